//! The Python client against a game in Rust. Needs Python with iceoryx2 and numpy:
//! SHEETWORK_PYTHON, the system's, or a virtual environment created in the target folder. Skipped
//! with a message without one.

use std::path::{Path, PathBuf};
use std::process::Command;

use sheetwork_tests::python::python;

use super::place::TestLink;

fn a_python() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("link-python");
    python("import iceoryx2, numpy", &folder, &["iceoryx2==0.10.0", "numpy"])
}

const SCRIPT: &str = r#"
import numpy, sheetwork
with sheetwork.attach(wait=30) as game:
    game.patience = 30
    status = game.status()
    assert status["sheets"] == ["strip"] and not status["playing"], status
    assert {p["path"] for p in game.parameters()} >= {"gravity", "engine", "sheets.strip.material.young"}
    assert game.get("gravity") == (0.0, -9.81, 0.0)
    assert game.set("gravity", (0, 50, 0)) == "(0, -9.81, 0)"
    for path, value in [("gravity", (0, float("nan"), 0)), ("sheets.strip.material.young", -1), ("x", 1)]:
        try:
            game.set(path, value)
            raise SystemExit(f"{path} = {value} was taken")
        except sheetwork.Refused as reason:
            assert path in str(reason), reason
    before = game.frame().sheet("strip").positions.copy()
    time = game.step(1)
    frame = game.frame(complete=True)
    sheet = frame.sheet("strip")
    assert frame.time == time and frame.steps == 1 and frame.complete and sheet.triangles is None
    drawn = game.frame(triangles=True, patience=30)
    mesh = drawn.sheet("strip")
    assert mesh.triangles.shape == (64, 3) and mesh.triangles.max() == 44 and mesh.open is None and drawn.topology >= 1
    assert sheet.positions.shape == (45, 3) and sheet.grid == (9, 1, 5) and sheet.structure == "shell"
    # In effect by the next step: the free edge goes up.
    assert sheet.positions[8, 1] > before[8, 1]
    assert numpy.allclose(numpy.linalg.norm(sheet.normals, axis=1), 1, atol=1e-5)
    assert sheet.strain.shape == (45,) and abs(sheet.strain).max() < 1e-3
    assert sheet.temperature is None and sheet.energy["total"] != 0
    # What it does not bear stops it, and every answer says so.
    game.set("engine", "euler"); game.step(300)
    assert game.stopped == ["strip"] and game.status()["stopped"] == ["strip"], game.stopped
    game.reset()
    assert game.stopped == [] and game.get("engine") == "tr-bdf2"
    game.play()
    seen = [f.frame for f in game.frames(count=20, newest=False)]
    assert seen == sorted(set(seen)) and len(seen) == 20
    with game.grab("strip", 1.0, 0.5, stiffness=20.0) as hand:
        target = numpy.array(hand.position) + (0, 0.01, 0)
        for _ in range(50):
            force, position = hand.pull(target)
        assert numpy.allclose(force, -20.0 * (target - position))
    game.snapshot("a"); game.restore("a"); game.pause(); game.reset()
    assert "strip" in game.scene()
    # A film that is heated and can tear.
    game.load(FILM)
    lamp = next(p["path"] for p in game.parameters() if p["kind"] == "boolean")
    assert game.get(lamp) is True and game.set(lamp, False) == "true" and game.get(lamp) is False
    assert game.set(lamp, numpy.bool_(True)) == "false" and game.get(lamp) is True
    for value in (0.5, "warm"):
        try:
            game.set(lamp, value)
            raise SystemExit(f"{lamp} = {value} was taken")
        except sheetwork.Refused as reason:
            assert "neither true nor false" in str(reason), reason
    game.step(2)
    film = game.frame(triangles=True, patience=30).sheets[0]
    assert film.temperature.shape == (961,) and film.temperature.dtype == numpy.float32 and film.temperature.min() >= 19
    assert film.open.shape == (30, 30) and not film.open.any() and len(film.triangles) == 1800
    try:
        game.set("gravty", 1)
    except sheetwork.Refused as reason:
        assert "did you mean gravity?" in str(reason), reason
try:
    sheetwork.attach("nobody")
    raise SystemExit("attached to nobody")
except sheetwork.NoGame:
    pass
data = numpy.zeros(4096, numpy.uint8)
for size in (0, 10, 143, 144, 4096):
    try:
        sheetwork.Frame(data[:size])
        raise SystemExit("nonsense was taken for a frame")
    except ValueError:
        pass
    try:
        sheetwork.Topology(data[:size])
        raise SystemExit("nonsense was taken for a topology")
    except ValueError:
        pass
print("python is content")
"#;

#[test]
fn the_python_client_reads_sets_grabs_and_reports_rejections() {
    let Some(python) = a_python() else {
        eprintln!("skipped: no Python with iceoryx2 and numpy, and none can be installed");
        return;
    };
    let place = TestLink::new("python");
    let _game = place.start("game", &[("SHEETWORK_PAUSED", "1")]);
    drop(place.attach());
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("../runtime/link/python");
    let film = sheetwork_tests::scenes_folder().join("melting_hole.ron");
    let script = format!("FILM = {:?}\n{SCRIPT}", film.display().to_string());
    let ran = Command::new(python)
        .args(["-c", &script])
        .env("PYTHONPATH", package)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("SHEETWORK_LINK_ROOT", place.link.root())
        .env("SHEETWORK_LINK", place.link.name())
        .output()
        .expect("starts");
    let (out, err) = (String::from_utf8_lossy(&ran.stdout), String::from_utf8_lossy(&ran.stderr));
    assert!(ran.status.success() && out.contains("python is content"), "{out}{err}");
}
