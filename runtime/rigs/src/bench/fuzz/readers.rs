//! Readers of input: one row each, with valid inputs and the test of a damaged one.

use std::path::Path;

use crc32fast::hash as crc;

use crate::bench::{files_of, read_files};
use sheetwork::scene::{Scene, heater_file, material, pol, sht};
use sheetwork::world::journal::{Journal, JournalInput, JournalWriter};
use sheetwork::world::recording::{self, RecordingWriter};
use sheetwork::{InputError, SceneError, World};
use sheetwork_link::Command;
use sheetwork_link::layout::FrameView;
use sheetwork_link::topology::Meshes;

/// Tests an input: true for accepted, false for rejected.
type Try = Box<dyn FnMut(&[u8]) -> bool>;
type Make = fn() -> Result<Try, InputError>;
type Seeds = fn(&Path) -> Result<Vec<Vec<u8>>, InputError>;

/// A reader under test.
pub struct FuzzedReader {
    pub name: &'static str,
    /// Fragments of a text format that break or change its meaning; none for a binary format.
    pub pieces: &'static [&'static str],
    /// Valid inputs, from the folder of the shipped files.
    pub seeds: Seeds,
    pub make: Make,
    /// Repairs checksums.
    pub repair: Option<fn(&mut [u8])>,
}

const RON: &[&str] = &[
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    ",",
    ":",
    "\"",
    "//",
    "/*",
    "None",
    "Some(",
    "true",
    "é",
    "\u{0}",
    "#![enable(implicit_some)]",
    "sheets: [(),]",
    "HalfSpace",
    "Ball(0)",
    "structure: \"provot3d\"",
    "grid: (2, 1, 2)",
    "pins: [(region: All)]",
    "outline: Disc(radius: 0)",
    "material: (young: 0)",
    "engine: \"rk45\"",
    "path: [(time: 0), (time: 0)]",
    "creases: [(from: (0, 0), to: (1, 1), angle: 175)]",
    "heat_mode: Thesis(sensitivity: 1, conductivity: 1)",
    "tearing: true",
];
const RECORDS: &[&str] =
    &["V", "F", "P", "*", "M", "S", "K", "B", "HOT", "#", "\n", "\n\n", " ", "\t", "x", "1 2 3", "-"];
const fn text(name: &'static str, pieces: &'static [&'static str], seeds: Seeds, make: Make) -> FuzzedReader {
    FuzzedReader { name, pieces, seeds, make, repair: None }
}

const fn binary(name: &'static str, seeds: Seeds, make: Make, repair: Option<fn(&mut [u8])>) -> FuzzedReader {
    FuzzedReader { name, pieces: &[], seeds, make, repair }
}

pub const READERS: &[FuzzedReader] = &[
    text("scene", RON, |a| files(a, "scenes", "ron"), || Ok(Box::new(scene))),
    text("sht", RECORDS, |a| files(a, "sheets", "sht"), || Ok(Box::new(sht_file))),
    text("pol", RECORDS, |a| files(a, "polyhedra", "pol"), || Ok(Box::new(pol_file))),
    text("heater", RECORDS, |a| files(a, "heaters", "heater"), || Ok(Box::new(heater_file))),
    text("material", RON, |a| files(a, "materials", "ron"), || Ok(Box::new(material_file))),
    binary("snapshot", |_| snapshots(), snapshot, Some(repair_snapshot)),
    binary("recording", |_| recordings(), || Ok(Box::new(recording_file)), Some(repair_parts)),
    binary("journal", |_| journals(), || Ok(Box::new(journal)), Some(repair_parts)),
    binary("link", |_| messages(), || Ok(Box::new(message)), None),
];

fn files(assets: &Path, folder: &str, ending: &str) -> Result<Vec<Vec<u8>>, InputError> {
    read_files(files_of(&assets.join(folder), ending)?)
}

/// An accepted scene is built and stepped if it is selected and small.
fn scene(bytes: &[u8]) -> bool {
    let Ok(scene) = Scene::parse(&String::from_utf8_lossy(bytes)) else { return false };
    if is_chosen(bytes)
        && is_small(&scene)
        && let Ok(mut world) = World::new(&scene)
    {
        (0..3).for_each(|_| _ = world.step());
    }
    true
}

/// Whether an input is tested beyond reading: a fixed choice of one in 64.
fn is_chosen(bytes: &[u8]) -> bool {
    crc(bytes).is_multiple_of(64)
}

fn is_small(scene: &Scene) -> bool {
    let masses = |s: &sheetwork::scene::SheetSpec| u64::from(s.grid.0) * u64::from(s.grid.1) * u64::from(s.grid.2);
    let files = scene.sheets.iter().any(|s| s.file.is_some());
    // Steps of an adaptive integrator may be a millionth of the scene's.
    !files && scene.sheets.iter().map(masses).sum::<u64>() < 600 && scene.engine.name() != "rk45"
}

fn sht_file(bytes: &[u8]) -> bool {
    let Ok(file) = sht::read_sht(&String::from_utf8_lossy(bytes)) else { return false };
    if file.masses.len() < 2000
        && let Ok(sheet) = sheetwork::sheet::from_file(&file)
    {
        let _ = sht::write_sht(&sheetwork::sheet::to_file(&sheet));
    }
    true
}

fn pol_file(bytes: &[u8]) -> bool {
    let Ok(all) = pol::read_pol(&String::from_utf8_lossy(bytes)) else { return false };
    pol::read_pol(&pol::write_pol(&all)).is_ok()
}

fn heater_file(bytes: &[u8]) -> bool {
    let Ok(all) = heater_file::read_heaters(&String::from_utf8_lossy(bytes)) else { return false };
    heater_file::read_heaters(&heater_file::write_heaters(&all)).is_ok()
}

fn material_file(bytes: &[u8]) -> bool {
    let Ok(read) = material::read_material(&String::from_utf8_lossy(bytes)) else { return false };
    read.plate_stiffness().is_finite()
}

/// A small world with each kind of state: heat, creep, fracture, contact. It has no dynamic body,
/// because Rapier's own state is verified by its checksum only.
fn small_scene() -> Result<Scene, SceneError> {
    Scene::parse(
        r#"(engine: "tr-bdf2", dt: 0.01, room: (x: (-1, 1), y: (0, 1), z: (-1, 1)),
            oven: (convection: 20, temperature: 150),
            sheets: [
                (name: "leaf", structure: "shell", grid: (6, 1, 5), size: (0.2, 0.15), material: "hips", creep: true,
                    plastic: true, placement: (position: (0, 0.02, 0)), pins: [(region: Point(0, 0), until: 0.3)]),
                (name: "film", structure: "shell", grid: (5, 1, 5), size: (0.1, 0.1), tearing: true,
                    material: (young: 1e7, thickness: 1e-4, tears_at: 0.001), placement: (position: (0.4, 0.1, 0)),
                    pins: [(region: Left), (region: Right, path: [(time: 0), (time: 1, offset: (0.05, 0, 0))])]),
                (name: "lattice", structure: "samm", grid: (4, 2, 4), size: (0.1, 0.1), material: "pet", springs: Uniform,
                    placement: (position: (-0.4, 0.05, 0)))])"#,
    )
}

fn snapshots() -> Result<Vec<Vec<u8>>, InputError> {
    let mut world = World::new(&small_scene()?)?;
    let mut all = vec![world.serialise()];
    for _ in 0..4 {
        (0..10).for_each(|_| _ = world.step());
        all.push(world.serialise());
    }
    Ok(all)
}

fn snapshot() -> Result<Try, InputError> {
    let mut world = World::new(&small_scene()?)?;
    let good = world.serialise();
    Ok(Box::new(move |bytes| {
        if world.deserialise(bytes).is_err() {
            return false;
        }
        // An accepted state is stepped: a sheet may become unstable, without further effect.
        world.step();
        world.deserialise(&good).is_ok()
    }))
}

fn repair_snapshot(bytes: &mut [u8]) {
    if bytes.len() >= 24 {
        let length = (bytes.len() - 24) as u64;
        bytes[12..20].copy_from_slice(&length.to_le_bytes());
        let sum = crc(&bytes[24..]);
        bytes[20..24].copy_from_slice(&sum.to_le_bytes());
    }
}

/// Repairs the checksums of parts that follow two lines, each after its length and its checksum.
fn repair_parts(bytes: &mut [u8]) {
    let lines: Vec<usize> = (0..bytes.len()).filter(|i| bytes[*i] == b'\n').take(2).collect();
    let Some(mut at) = lines.get(1).map(|end| end + 1) else { return };
    let journal = bytes.starts_with(b"sheetwork journal");
    while let Some(Some(length)) = bytes.get(at..at + 4).map(|b| b.first_chunk().map(|b| u32::from_le_bytes(*b))) {
        let Some(end) = at.checked_add(8 + length as usize).filter(|end| *end <= bytes.len()) else { return };
        let sum = if journal { crc(&bytes[at + 8..end]) } else { recording::checksum(&bytes[at + 8..end]) };
        bytes[at + 4..at + 8].copy_from_slice(&sum.to_le_bytes());
        at = end;
    }
}

/// Calls `write` with a temporary file and returns the file's content.
fn written(name: &str, write: impl FnOnce(&Path) -> Result<(), InputError>) -> Result<Vec<u8>, InputError> {
    let file = std::env::temp_dir().join(format!("sheetwork-fuzz-{name}-{}", std::process::id()));
    write(&file)?;
    let bytes = std::fs::read(&file).map_err(|e| InputError::io(&file, &e))?;
    std::fs::remove_file(&file).map_err(|e| InputError::io(&file, &e))?;
    Ok(bytes)
}

fn recording_file(bytes: &[u8]) -> bool {
    recording::from_bytes(bytes).is_ok()
}

fn recordings() -> Result<Vec<Vec<u8>>, InputError> {
    let mut world = World::new(&small_scene()?)?;
    let one = written("recording", |file| {
        let mut recorder = RecordingWriter::create(file, &world, 60.0)?;
        for _ in 0..6 {
            recorder.frame(&world)?;
            (0..5).for_each(|_| _ = world.step());
        }
        recorder.finish().map(|_| ())
    })?;
    Ok(vec![one])
}

fn journals() -> Result<Vec<Vec<u8>>, InputError> {
    let mut world = World::new(&small_scene()?)?;
    let one = written("journal", |file| {
        let mut writer = JournalWriter::create(file, &world, 3)?;
        for step in 0..7 {
            if step % 2 == 0 {
                writer.input(
                    &mut world,
                    JournalInput::Set { path: "gravity".into(), value: format!("(0, -{step}, 0)") },
                )?;
            }
            writer.step(&mut world)?;
        }
        writer.finish()
    })?;
    Ok(vec![one])
}

fn journal(bytes: &[u8]) -> bool {
    let Ok(journal) = Journal::from_bytes(bytes) else { return false };
    // The scene may differ from the original, so only small ones are run.
    let small = || Scene::parse(&journal.header.source).is_ok_and(|s| is_small(&s)) && journal.len() < 50;
    if is_chosen(bytes)
        && small()
        && let Ok(mut world) = journal.world(None)
    {
        let _ = journal.check(&mut world);
    }
    true
}

fn messages() -> Result<Vec<Vec<u8>>, InputError> {
    let world = World::new(&small_scene()?)?;
    let (frame, meshes) = sheetwork_link::samples(&world);
    let commands = [
        r#"{"layout":1,"op":"status"}"#,
        r#"{"layout":1,"op":"params","from":3}"#,
        r#"{"layout":1,"op":"set","path":"gravity","value":"(0,-1.6,0)"}"#,
        r#"{"layout":1,"op":"step","steps":10}"#,
        r#"{"layout":1,"op":"snapshot","name":"a"}"#,
        r#"{"layout":1,"op":"grab","sheet":"leaf","uv":[0.5,0.5],"stiffness":100}"#,
        r#"{"layout":1,"op":"pull","grab":1,"target":[0,0.1,0]}"#,
    ];
    let commands = commands.into_iter().map(|c| c.as_bytes().to_vec());
    Ok([frame, meshes].into_iter().chain(commands).collect())
}

/// Memory with the alignment of a sample.
#[repr(align(64))]
struct AlignedBytes([u8; 1 << 18]);

fn message(bytes: &[u8]) -> bool {
    let mut memory = Box::new(AlignedBytes([0; 1 << 18]));
    let length = bytes.len().min(memory.0.len());
    memory.0[..length].copy_from_slice(&bytes[..length]);
    let bytes = &memory.0[..length];
    if let Ok(view) = FrameView::new(bytes) {
        let mut sum = view.bodies().iter().flatten().sum::<f32>();
        for sheet in view.sheets() {
            let arrays = [sheet.positions(), sheet.normals()];
            sum += arrays.into_iter().flatten().flatten().sum::<f32>();
            sum += sheet.strain().iter().chain(sheet.temperature()).sum::<f32>();
            sum += sheet.contact().iter().map(|c| f32::from(*c)).sum::<f32>();
            let _ = (sheet.header().name(), sheet.header().structure());
        }
        // Frames may hold any number; none is an error.
        return std::hint::black_box(sum).to_bits() != 1;
    }
    Meshes::read(bytes).is_ok() || Command::from_bytes(bytes).is_ok()
}
