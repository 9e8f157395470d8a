//! Recordings are read as written: positions, temperatures, open cells; old files too, and damaged
//! ones are refused.

use std::path::PathBuf;

use crate::scene::Scene;
use crate::world::recording::*;

/// File of one test, removed at its end.
struct RecordingFile(PathBuf);

impl RecordingFile {
    fn new(test: &str) -> Self {
        Self(std::env::temp_dir().join(format!("sheetwork-recording-{test}-{}.swr", std::process::id())))
    }

    fn refusal(&self, bytes: &[u8]) -> String {
        std::fs::write(&self.0, bytes).expect("writable");
        read(&self.0).expect_err("refused").problem
    }
}

impl Drop for RecordingFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn falling() -> World {
    let scene = r#"(engine: "euler-richardson", dt: 0.001, room: (x: (-1, 1), y: (0, 1), z: (-1, 1)),
        sheets: [(structure: "trimm", grid: (11, 2, 11), size: (0.025, 0.025), material: "thesis", springs: Uniform,
            placement: (position: (0, 0.1, 0)))])"#;
    World::new(&Scene::parse(scene).expect("valid")).expect("valid")
}

#[test]
fn a_recording_is_read_as_written_and_a_truncated_or_damaged_one_is_rejected() {
    let (mut world, file) = (falling(), RecordingFile::new("read"));
    let mut recorder = RecordingWriter::create(&file.0, &world, 60.0).expect("writable");
    for _ in 0..3 {
        recorder.frame(&world).expect("writable");
        world.advance(1.0 / 60.0);
    }
    assert_eq!(recorder.finish().expect("writable"), 3);
    let (header, frames) = read(&file.0).expect("a recording");
    assert_eq!((frames.len(), header.masses.as_slice(), header.bodies), (3, &[221][..], 2));
    assert!((frames[2].time - 2.0 / 60.0).abs() < 1e-12);
    assert!(frames[2].sheets[0][0].y < frames[0].sheets[0][0].y);
    assert_eq!((frames[0].temperatures_of(0), frames[0].open_of(0)), (&RecordedTemperature::Unknown, &[][..]));
    let bytes = std::fs::read(&file.0).expect("readable");
    assert!(file.refusal(&bytes[..bytes.len() - 5]).contains("ends within frame 2"));
    let start = bytes.len() - 3 * (8 + 8 + 1 + 12 * 221 + 28 * 2);
    assert!(file.refusal(&bytes[..start + 3]).contains("ends within frame 0"));
    // One bit anywhere in the frames.
    for at in (start..bytes.len()).step_by(101) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 16;
        let problem = file.refusal(&damaged);
        assert!(problem.contains("damaged") || problem.contains("ends within"), "byte {at}: {problem}");
    }
    assert!(file.refusal(b"something else\n").contains("not a recording"));
    assert!(file.refusal(&[0xff, 0xfe, 0x00]).contains("not a recording"));
    assert!(file.refusal(b"sheetwork recording 3\n{}\n").contains("version 3"));
}

#[test]
fn a_file_of_the_first_version_is_read() {
    let (world, file) = (falling(), RecordingFile::new("first"));
    let frame = RecordedFrame::of(&world);
    let header = RecordingHeader {
        scene: "old".into(),
        source: "()".into(),
        frames_per_second: 60.0,
        masses: vec![221],
        bodies: 2,
    };
    let mut bytes = format!("sheetwork recording 1\n{}\n", serde_json::to_string(&header).expect("JSON")).into_bytes();
    for _ in 0..2 {
        bytes.extend(frame.time.to_le_bytes());
        frame.sheets[0].iter().flat_map(|p| p.to_array()).for_each(|c| bytes.extend(c.to_le_bytes()));
        for (p, r) in &frame.bodies {
            p.to_array().into_iter().chain(r.to_array()).for_each(|c| bytes.extend(c.to_le_bytes()));
        }
    }
    std::fs::write(&file.0, &bytes).expect("writable");
    let (read_header, frames) = read(&file.0).expect("a recording");
    assert_eq!((read_header, frames.len()), (header, 2));
    assert_eq!((&frames[1].sheets, &frames[1].bodies), (&frame.sheets, &frame.bodies));
    assert!(file.refusal(&bytes[..bytes.len() - 1]).contains("ends within frame 1"));
}

/// A shell with two temperatures through its thickness, and a lattice that can fracture.
fn hot() -> World {
    let scene = r#"(engine: "tr-bdf2", dt: 0.01, heaters: [(name: "lamp", size: (0.1, 0.1, 0.1), hot: [(face: 0, temperature: 200)])],
        sheets: [
            (name: "shell", structure: "shell", grid: (5, 1, 4), size: (0.1, 0.1), material: "pvc", temperature_gradient: true),
            (name: "film", structure: "samm", grid: (6, 2, 5), size: (0.1, 0.1), material: "pvc",
                springs: Uniform, tearing: true, placement: (position: (0.5, 0, 0)))])"#;
    World::new(&Scene::parse(scene).expect("valid")).expect("valid")
}

/// A sheet that softens by the thesis's formulas.
fn softened() -> World {
    let scene = r#"(engine: "tr-bdf2", dt: 0.01, heat_mode: Thesis(sensitivity: 2000), oven: (temperature: 120),
        sheets: [(structure: "shell", grid: (5, 1, 4), size: (0.1, 0.1), material: "pvc")])"#;
    World::new(&Scene::parse(scene).expect("valid")).expect("valid")
}

#[test]
fn temperatures_and_open_cells_are_restored() {
    let (mut world, file) = (hot(), RecordingFile::new("warmth"));
    let mut recorder = RecordingWriter::create(&file.0, &world, 60.0).expect("writable");
    let mut kept = Vec::new();
    for step in 0..4 {
        world.sheets_mut()[1].set_temperatures(|i| 20.0 + f64::from(step) * 7.3 + i as f64).expect("in range");
        let mut frame = RecordedFrame::of(&world);
        // Cells opened by hand: one from the second frame on, another in the fourth.
        let open = |cells: &[usize]| (0..20).map(|c| cells.contains(&c)).collect::<Vec<_>>();
        frame.open[1] = [open(&[]), open(&[3]), open(&[3]), open(&[3, 19])][step as usize].as_slice().into();
        if step == 0 {
            frame.open[1] = [].into();
        }
        recorder.append(&frame).expect("writable");
        kept.push(frame);
    }
    recorder.finish().expect("writable");
    let (_, frames) = read(&file.0).expect("a recording");
    for (read, kept) in frames.iter().zip(&kept) {
        assert_eq!((&read.open, &read.sheets), (&kept.open, &kept.sheets));
        for (read, kept) in read.temperatures.iter().zip(&kept.temperatures) {
            assert_eq!(std::mem::discriminant(read), std::mem::discriminant(kept));
            let apart = read.values().iter().zip(kept.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(read.values().len() == kept.values().len() && apart < 0.0501, "{apart} °C");
        }
    }
    // The displayed sheet has the recorded temperatures.
    let mut shown = hot();
    shown.show(&frames[3]).expect("of this scene");
    let celsius = shown.sheets()[1].temperatures().expect("heated");
    assert!(celsius.iter().enumerate().all(|(i, t)| (t - (41.9 + i as f64)).abs() < 0.06), "{celsius:?}");
    let mut foreign = frames[3].clone();
    foreign.temperatures[0] = RecordedTemperature::Mean(vec![9e9; 20]);
    assert!(shown.show(&foreign).expect_err("refused").problem.contains("°C"));
    foreign.temperatures[0] = RecordedTemperature::Mean(vec![20.0; 3]);
    assert!(shown.show(&foreign).expect_err("refused").problem.contains("other sheets"));
}

#[test]
fn remaining_stiffness_of_the_thesis_model_is_restored() {
    let (mut world, file) = (softened(), RecordingFile::new("thesis"));
    world.advance(0.05);
    let left = |world: &World| {
        let heat = world.sheets()[0].heat().expect("heated");
        (0..20).map(|i| 1.0 / heat.compliance(i)).collect::<Vec<_>>()
    };
    let mut recorder = RecordingWriter::create(&file.0, &world, 60.0).expect("writable");
    recorder.frame(&world).expect("writable");
    recorder.finish().expect("writable");
    let (_, frames) = read(&file.0).expect("a recording");
    assert!(matches!(frames[0].temperatures_of(0), RecordedTemperature::Stiffness(_)) && left(&world)[7] < 0.9);
    let mut shown = softened();
    shown.show(&frames[0]).expect("of this scene");
    for (seen, was) in left(&shown).iter().zip(left(&world)) {
        assert!((seen - was).abs() < 3e-3, "{seen} and {was}");
    }
}
