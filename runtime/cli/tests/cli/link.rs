//! The live link on the command line: one process serves, others observe and control it.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

use serde_json::Value;

use super::common::{ProgramOutput, TestFolder, keys};

/// A folder with a running game, which ends with the test.
struct ServedGame {
    place: TestFolder,
    root: PathBuf,
    game: Child,
}

impl ServedGame {
    fn new(name: &str, arguments: &[&str]) -> Self {
        let place = TestFolder::new(name);
        let root = place.path("link");
        let mut command = Command::new(env!("CARGO_BIN_EXE_sheetwork"));
        command.arg("serve").args(arguments).current_dir(place.path("")).env("SHEETWORK_LINK_ROOT", &root);
        let game = command.stdout(Stdio::null()).spawn().expect("the program starts");
        Self { place, root, game }
    }

    fn run(&self, arguments: &[&str]) -> ProgramOutput {
        let output = Command::new(env!("CARGO_BIN_EXE_sheetwork"))
            .args(arguments)
            .current_dir(self.place.path(""))
            .env("SHEETWORK_LINK_ROOT", &self.root)
            .output()
            .expect("the program starts");
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        ProgramOutput { status: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }

    fn json(&self, arguments: &[&str]) -> Value {
        let ran = self.run(arguments);
        assert_eq!(ran.status, Some(0), "{arguments:?}: {}", ran.err);
        ran.json()
    }
}

impl Drop for ServedGame {
    fn drop(&mut self) {
        let _ = self.game.kill();
        let _ = self.game.wait();
        // A short game removes the shared memory of the killed one.
        self.run(&["serve", "assets/scenes/wedge.ron", "--seconds", "0"]);
    }
}

#[test]
fn a_served_scene_can_be_watched_set_commanded_recorded_and_grabbed() {
    let served = ServedGame::new("link", &["assets/scenes/cantilever_sheet.ron", "--paused"]);
    let status = served.json(&["tell", "--wait", "60", "status"]);
    assert_eq!((status["scene"].as_str(), status["playing"].as_bool()), (Some("cantilever"), Some(false)));
    let young = "sheets.sheet.material.young";
    let all = served.json(&["params", "--json"]);
    let row = all.as_array().expect("a list").iter().find(|p| p["path"] == young).expect("listed");
    assert_eq!(keys(row), ["path", "value", "unit", "kind", "min", "max"]);
    assert_eq!(served.json(&["set", young, "3e9", "--json"])["old"], row["value"]);
    assert_eq!(served.json(&["get", young, "--json"])["value"], "3000000000");
    assert_eq!(served.run(&["get", young]).out, "3000000000 Pa\n");
    for (arguments, says) in [
        (&["set", young, "-3"][..], "outside"),
        (&["set", "sheets.sheet.colour", "3"], "cannot be set"),
        (&["get", "colour"], "no such parameter"),
        (&["set", "sheets.sheet.material.yuong", "3"], "did you mean sheets.sheet.material.young"),
        (&["params", "nosuch"], "no parameter has \"nosuch\""),
        (&["tell", "load", "no-such.ron"], "no-such.ron"),
        (&["grab", "nobody", "0", "0"], "nobody"),
        (&["watch", "--link", "other"], "there are: sheetwork"),
    ] {
        let ran = served.run(arguments);
        assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""), "{arguments:?}: {}", ran.err);
        assert!(ran.err.contains(says), "{arguments:?}: {}", ran.err);
    }
    assert_eq!(served.json(&["tell", "step", "5"])["steps"], 5);
    served.json(&["tell", "play"]);
    let csv = served.run(&["watch", "--csv", "--energy", "--frames", "3"]).out;
    let rows: Vec<Vec<&str>> = csv.lines().map(|l| l.split(',').collect()).collect();
    assert_eq!((rows.len(), rows[0][4], rows[1][4]), (4, "sheet", "sheet"));
    assert!(rows[1][13].parse::<f64>().expect("a total energy").is_finite() && rows[0].len() == rows[3].len());
    let line: Value = serde_json::from_str(served.run(&["watch", "--json", "--frames", "1"]).out.trim()).expect("JSON");
    assert_eq!(line["sheets"][0]["status"], "awake");
    assert!(served.run(&["watch", "--frames", "2"]).out.contains("cantilever · tr-bdf2"));
    let felt =
        served.json(&["grab", "sheet", "1", "0.5", "--by", "0,0.02,0", "--over", "0.2", "--seconds", "0.4", "--json"]);
    assert_eq!(felt["force_n"].as_array().map(Vec::len), Some(3));
    assert!(served.json(&["record", "a.swr", "--seconds", "0.5", "--json"])["frames"].as_u64() > Some(1));
    let (header, frames) = sheetwork::world::recording::read(&served.place.path("a.swr")).expect("a recording");
    assert_eq!((header.masses.as_slice(), header.bodies, frames[0].bodies.len()), (&[441][..], 1, 1));
    assert!(frames.windows(2).all(|f| f[0].time < f[1].time));
}

#[test]
fn a_heated_scene_is_switched_watched_and_recorded_with_temperatures() {
    let served = ServedGame::new("warm-link", &["assets/scenes/melting_hole.ron", "--paused"]);
    served.json(&["tell", "--wait", "60", "status"]);
    let switch = "heaters.panel.on";
    assert_eq!(served.json(&["get", switch, "--json"])["value"], true);
    assert_eq!(served.json(&["params", switch, "--json"])[0]["kind"], "boolean");
    assert!(served.run(&["params", switch]).out.ends_with("true or false\n"));
    assert_eq!(served.json(&["set", switch, "false", "--json"])["old"], "true");
    assert_eq!(served.run(&["set", switch, "true"]).out, "heaters.panel.on: false -> true\n");
    assert!(served.run(&["set", switch, "0.3"]).err.contains("neither true nor false"));
    served.json(&["tell", "step", "3"]);
    let line: Value = serde_json::from_str(served.run(&["watch", "--json", "--frames", "1"]).out.trim()).expect("JSON");
    let warm = &line["sheets"][0]["temperature_c"];
    assert_eq!(keys(warm), ["min", "mean", "max"]);
    assert!(warm["max"].as_f64() > warm["min"].as_f64() && warm["min"].as_f64() > Some(19.0), "{warm}");
    let csv = served.run(&["watch", "--csv", "--frames", "1"]).out;
    let rows: Vec<Vec<&str>> = csv.lines().map(|l| l.split(',').collect()).collect();
    assert_eq!((rows[0].last(), rows[0].len()), (Some(&"hottest_c"), rows[1].len()));
    assert!(served.run(&["watch", "--frames", "1"]).out.contains("temp "));
    served.json(&["tell", "play"]);
    assert!(served.json(&["record", "w.swr", "--seconds", "0.5", "--json"])["frames"].as_u64() > Some(1));
    let (header, frames) = sheetwork::world::recording::read(&served.place.path("w.swr")).expect("a recording");
    let last = frames.last().expect("frames");
    assert!(
        matches!(last.temperatures_of(0), sheetwork::world::recording::RecordedTemperature::Mean(t) if t.len() == header.masses[0])
    );
}

#[test]
fn a_short_soak_reports_its_resources() {
    let ran = TestFolder::new("soak").run(&["bench", "soak", "--frames", "300", "--json"]);
    let result = ran.json();
    let wanted =
        ["frames", "seconds", "written", "bytes", "dropped", "commands", "kills", "before", "warm", "after", "grown"];
    assert_eq!(keys(&result), wanted);
    assert_eq!(
        (result["frames"].as_u64(), result["kills"].as_u64(), result["dropped"].as_u64()),
        (Some(300), Some(20), Some(0))
    );
    assert!(result["written"].as_u64() >= Some(300) && result["after"]["memory_bytes"].as_u64() > Some(100_000));
    assert_eq!(ran.status, Some(i32::from(result["grown"] == true)));
}

#[test]
fn an_unstable_sheet_is_reported_beside_the_answer() {
    let served = ServedGame::new("unstable-link", &["assets/scenes/cantilever_sheet.ron", "--paused"]);
    served.json(&["tell", "--wait", "60", "status"]);
    assert_eq!(served.run(&["set", "engine", "euler"]).err, "");
    assert_eq!(served.json(&["tell", "step", "100"])["stopped"], serde_json::json!(["sheet"]));
    let set = served.run(&["set", "engine", "tr-bdf2"]);
    assert_eq!((set.status, set.out.as_str()), (Some(0), "engine: euler -> tr-bdf2\n"));
    assert!(set.err.contains("sheet is unstable and stopped") && set.err.contains("tell reset"), "{}", set.err);
    let reset = served.run(&["tell", "reset"]);
    assert!(reset.err.is_empty() && reset.json().get("stopped").is_none());
    assert!(served.json(&["tell", "step", "10"]).get("stopped").is_none());
}

#[test]
fn a_haptic_loop_feels_the_sheet_and_reports_its_rate_and_latency() {
    let served = ServedGame::new("haptic-link", &["assets/scenes/cantilever_sheet.ron"]);
    served.json(&["tell", "--wait", "60", "status"]);
    let felt = served.json(&["haptic", "sheet", "1", "0.5", "--seconds", "1.5", "--stiffness", "20", "--json"]);
    let number = |key: &str| felt[key].as_f64().unwrap_or_else(|| panic!("{key} in {felt}"));
    // The hand goes up by 5 cm and back: the sheet, 9 N/m stiff at its tip, gives way to a part.
    assert!((0.05..2.0).contains(&number("largest_force_n")), "{felt}");
    for key in ["force_loop_hz", "period_p99_ms", "link_loop_hz", "round_trip_median_ms", "round_trip_p99_ms"] {
        assert!(number(key) > 0.0, "{key} in {felt}");
    }
    let bad = served.run(&["haptic", "sheet", "1", "0.5", "--device", "/dev/input/none"]);
    assert!(bad.status == Some(2) && bad.err.contains("/dev/input/none"), "{}", bad.err);
}

#[test]
fn a_missing_game_is_an_error_and_invalid_names_are_rejected() {
    let place = TestFolder::new("no-link");
    let root = place.path("none");
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sheetwork"));
        let output = command.args(arguments).env("SHEETWORK_LINK_ROOT", &root).output().expect("the program starts");
        (output.status.code(), String::from_utf8(output.stderr).expect("UTF-8"))
    };
    for command in [&["watch"][..], &["params"], &["get", "gravity"], &["set", "gravity", "1"], &["tell", "play"]] {
        let (status, err) = run(command);
        assert!(status == Some(2) && err.contains("no game serves"), "{command:?}: {err}");
    }
    let (status, err) = run(&["watch", "--link", "a/b"]);
    assert!(status == Some(2) && err.contains("1 to 32 letters"), "{err}");
}

#[test]
fn a_second_game_is_told_how_to_choose_another_name() {
    let served = ServedGame::new("taken-link", &["assets/scenes/wedge.ron", "--paused"]);
    served.json(&["tell", "--wait", "60", "status"]);
    let second = served.run(&["serve", "assets/scenes/wedge.ron", "--seconds", "0"]);
    assert_eq!(second.status, Some(2), "{}", second.err);
    for part in ["another process already serves the link \"sheetwork\"", "SHEETWORK_LINK", "--link NAME"] {
        assert!(second.err.contains(part), "no {part} in {}", second.err);
    }
    let other = served.run(&["serve", "assets/scenes/wedge.ron", "--seconds", "0", "--link", "other"]);
    assert_eq!(other.status, Some(0), "{}", other.err);
}
