//! A run is recorded, repeated, entered at any step, and differences are named.

use crate::world::journal::*;

fn world() -> World {
    let scene = Scene::parse(
        r#"(engine: "tr-bdf2", dt: 0.01, room: (x: (-1, 1), y: (0, 1), z: (-1, 1)),
            sheets: [(name: "leaf", structure: "shell", grid: (6, 1, 5), size: (0.2, 0.15), material: "pet",
                placement: (position: (0, 0.02, 0)))],
            bodies: [(name: "ball", shape: Ball(0.02), mass: 0.01, placement: (position: (0.05, 0.1, 0)))])"#,
    );
    World::new(&scene.expect("valid")).expect("valid")
}

fn inputs(step: u32) -> Vec<JournalInput> {
    let sheet = || "leaf".to_owned();
    match step {
        3 => vec![JournalInput::Grab { sheet: sheet(), uv: (1.0, 0.5), stiffness: 20.0 }],
        5 => vec![JournalInput::Pull { sheet: sheet(), index: 0, target: DVec3::new(0.1, 0.1, 0.0) }],
        9 => vec![JournalInput::Set { path: "gravity".into(), value: "(0, -4, 1)".into() }],
        11 => vec![JournalInput::PlaceBody {
            name: "ball".into(),
            position: DVec3::new(0.02, 0.09, 0.0),
            rotation: DQuat::from_rotation_x(0.5),
        }],
        14 => vec![
            JournalInput::LetGo { sheet: sheet(), index: 0 },
            JournalInput::Set { path: "sheets.leaf.material.young".into(), value: "1e9".into() },
        ],
        _ => Vec::new(),
    }
}

fn journal(name: &str, steps: u32) -> (PathBuf, World) {
    let file = std::env::temp_dir().join(format!("sheetwork-journal-{name}-{}", std::process::id()));
    let mut world = world();
    let mut writer = JournalWriter::create(&file, &world, 6).expect("a file");
    for step in 0..steps {
        inputs(step).into_iter().for_each(|i| writer.input(&mut world, i).expect("taken"));
        writer.step(&mut world).expect("written");
    }
    writer.finish().expect("written");
    (file, world)
}

#[test]
fn a_run_repeats_bit_for_bit_and_can_be_entered_at_any_step() {
    let (file, end) = journal("again", 20);
    let journal = Journal::read(&file).expect("its own");
    assert_eq!(journal.len(), 20);
    let mut again = journal.world(None).expect("its scene");
    assert_eq!(journal.check(&mut again), Ok(None));
    assert_eq!(again.serialise(), end.serialise());
    let mut way = world();
    for step in 0..=20 {
        journal.seek(&mut again, u64::from(step)).expect("there");
        assert_eq!(state_checksums(&again), state_checksums(&way), "{step}");
        if step < 20 {
            inputs(step).iter().for_each(|i| i.apply(&mut way).expect("taken"));
            way.step();
        }
    }
    assert!(journal.seek(&mut again, 21).expect_err("beyond").problem.contains("0 to 20"));
    std::fs::remove_file(file).expect("there");
}

#[test]
fn the_first_step_that_differs_is_named() {
    let (file, _) = journal("differs", 20);
    let mut journal = Journal::read(&file).expect("its own");
    let mut world = journal.world(None).expect("its scene");
    // The ball meets the sheet after this step.
    journal.parts[1].steps[3].sums[0] ^= 1;
    let found = journal.check(&mut world).expect("can be run").expect("differs");
    assert_eq!((found.step, &*found.what), (10, "leaf"));
    assert!((found.time_s - 0.1).abs() < 1e-9);
    let last = journal.parts[0].steps[1].sums.len() - 1;
    journal.parts[0].steps[1].sums[last] ^= 1;
    assert_eq!(
        journal.check(&mut world).expect("can be run").map(|d| (d.step, d.what)),
        Some((2, "bodies".to_owned()))
    );
    std::fs::remove_file(file).expect("there");
}

#[test]
fn a_file_without_the_journal_format_is_rejected() {
    let (file, _) = journal("bad", 8);
    let bytes = std::fs::read(&file).expect("there");
    std::fs::remove_file(file).expect("there");
    let says = |bytes: &[u8], what: &str| {
        let error = Journal::from_bytes(bytes).expect_err(what);
        assert!(error.problem.contains(what), "{error}");
    };
    says(b"", "not a journal");
    says(b"sheetwork recording 2\n", "not a journal");
    says(b"sheetwork journal 7\n{}\n", "version 7");
    says(b"sheetwork journal 2", "version 2");
    says(b"sheetwork journal 12, and no end of the line for a long way on", "version 12;");
    says(b"sheetwork journal one\n{}\n", "not a journal");
    says(b"sheetwork journal 1", "header");
    says(b"sheetwork journal 1\n{}\n", "header");
    says(&bytes[..bytes.len() - 1], "ends within part 1");
    let mut damaged = bytes.clone();
    let last = damaged.len() - 1;
    damaged[last] ^= 4;
    says(&damaged, "damaged");
    for cut in (0..bytes.len()).step_by(97) {
        let _ = Journal::from_bytes(&bytes[..cut]);
    }
}
