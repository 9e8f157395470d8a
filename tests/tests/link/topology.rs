//! Topology over the link: triangles are sent once, also to later readers, and again after
//! fracture.

use std::time::Duration;

use sheetwork::scene::Scene;
use sheetwork_link::Client;
use sheetwork_link::Link;

use super::place::{TestLink, WAIT_TIMEOUT};
use sheetwork_tests::game::{TestGame, strip};

/// A strip of paper that is pulled at one end until it fractures.
fn drawn() -> Scene {
    Scene::parse(
        r#"(name: "drawn", dt: 0.004, engine: "tr-bdf2", gravity: (0, 0, 0), sheets: [(name: "strip", structure: "shell", grid: (9, 1, 5),
            size: (0.2, 0.1), material: "paper", tearing: true, damping_ratio: 0.5, pins: [(region: Left),
            (region: Right, path: [(time: 0), (time: 0.4, offset: (0.04, 0, 0))])])])"#,
    )
    .expect("valid")
}

#[test]
fn triangles_are_sent_once_and_to_new_readers() {
    let place = TestLink::new("triangles");
    let mut game = TestGame::new(&strip());
    let mut link = Link::new(&place.link, &game.world).expect("serves");
    let client = Client::attach(&place.link).expect("attaches");
    let (mut frames, mut topology) = (client.frames(false).expect("reads"), client.topology().expect("reads"));
    let mut step = |link: &mut Link| {
        game.world.step();
        link.exchange(&mut game, 1e-3);
    };
    step(&mut link);
    let frame = frames.next().expect("sound").expect("there");
    assert!(topology.follow(frame.header()).expect("sound"));
    let mesh = topology.sheet("strip").expect("there");
    assert_eq!((mesh.masses, mesh.triangles.len(), mesh.open.len(), topology.sheets().len()), (45, 64, 0, 1));
    drop(frame);
    drop(frames);
    // No further sample for readers that have the topology.
    let written = link.statistics().bytes;
    (0..50).for_each(|_| step(&mut link));
    assert_eq!(link.statistics().bytes, written);
    // A different reader, with the number of readers unchanged.
    drop(topology);
    let (mut frames, mut topology) = (client.frames(false).expect("reads"), client.topology().expect("reads"));
    step(&mut link);
    let frame = frames.next().expect("sound").expect("there");
    assert!(topology.follow(frame.header()).expect("sound"));
    assert_eq!((topology.version(), topology.sheets()[0].triangles.len()), (frame.header().topology, 64));
}

#[test]
fn fracture_updates_the_topology_and_a_reset_restores_it() {
    let place = TestLink::new("tears");
    let mut game = TestGame::new(&drawn());
    let mut link = Link::new(&place.link, &game.world).expect("serves");
    let client = Client::attach(&place.link).expect("attaches");
    let (mut frames, mut topology) = (client.frames(true).expect("reads"), client.topology().expect("reads"));
    let mut versions = Vec::new();
    for step in 0..90 {
        if step == 80 {
            game.world.reset().expect("the same scene");
        } else {
            game.world.step();
        }
        link.exchange(&mut game, 1e-3);
        let frame = frames.latest().expect("sound").expect("there");
        assert!(topology.follow(frame.header()).expect("sound"), "step {step}");
        let (sheet, mesh) = (&game.world.sheets()[0], topology.sheet("strip").expect("there"));
        assert_eq!(mesh.open, sheet.open_cells().expect("it can open"), "step {step}");
        assert_eq!(mesh.cells, (8, 4));
        let drawn = sheet.surface(0, 1).expect("drawn").mesh(&sheet.state.x);
        assert_eq!(mesh.triangles, drawn.indices, "step {step}");
        // Cut edges do not contribute to strain.
        let view = frame.view().expect("sound");
        assert!(view.sheet("strip").expect("there").strain().iter().all(|e| e.abs() < 0.2), "step {step}");
        versions.push((topology.version(), sheet.open_count()));
    }
    let most = versions.iter().map(|v| v.1).max().expect("steps");
    assert!(most >= 4 && versions[0].1 == 0 && versions[89].1 == 0, "{versions:?}");
    assert!(
        versions.windows(2).all(|v| (v[0].0 == v[1].0) == (v[0].1 == v[1].1)),
        "a version for each change: {versions:?}"
    );
}

#[test]
fn a_game_in_another_process_sends_its_triangles() {
    let place = TestLink::new("mesh");
    let _game = place.start("game", &[("SHEETWORK_PAUSED", "1")]);
    let client = place.attach();
    let mut topology = client.topology().expect("reads");
    let frame = client.frames(false).expect("reads").wait(WAIT_TIMEOUT).expect("a frame");
    assert_eq!(topology.wait(frame.header(), WAIT_TIMEOUT).expect("topology")[0].triangles.len(), 64);
    assert!(
        topology.wait(&sheetwork_link::layout::FrameHeader { topology: 9, ..*frame.header() }, Duration::ZERO).is_err()
    );
}
