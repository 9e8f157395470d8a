//! Observation has no effect on a run, and commands equal the same changes by the game itself: bit
//! for bit, on any number of threads.

use std::thread;

use sheetwork_link::Link;
use sheetwork_tests::game::{TestGame, strip};
use sheetwork_tests::{shipped_scene, state_hash};

use super::place::TestLink;

const STEPS: u32 = 60;

/// Parameter changes by step.
const CHANGES: &[(u32, &str, &str)] = &[
    (7, "gravity", "(1, -4, 0)"),
    (20, "sheets.strip.material.young", "1e9"),
    (33, "sheets.strip.damping_ratio", "0.4"),
];

fn alone(threads: usize) -> u64 {
    let mut game = TestGame::new(&strip());
    game.world.set_threads(threads).expect("starts");
    for step in 0..STEPS {
        for (_, path, value) in CHANGES.iter().filter(|c| c.0 == step) {
            game.world.set(path, value).expect("in range");
        }
        game.world.step();
    }
    state_hash(&game.world)
}

#[test]
fn a_commanded_run_equals_the_run_with_the_same_changes() {
    let place = TestLink::new("same");
    let mut game = TestGame::new(&strip());
    let mut link = Link::new(&place.link, &game.world).expect("a link");
    let client = place.attach();
    let mut frames = client.frames(true).expect("a place");
    for step in 0..STEPS {
        for (_, path, value) in CHANGES.iter().filter(|c| c.0 == step) {
            thread::scope(|scope| {
                let asked = scope.spawn(|| client.set(path, value));
                while !asked.is_finished() {
                    link.answer(&mut game);
                }
                asked.join().expect("no panic").expect("accepted");
            });
        }
        game.world.step();
        link.exchange(&mut game, 1e-3);
        let _ = frames.latest().expect("sound");
    }
    let watched = state_hash(&game.world);
    for threads in [1, 2, 3, 8] {
        assert_eq!(alone(threads), watched, "on {threads} threads");
    }
}

#[test]
fn readers_have_no_effect_on_a_scene_with_fracture() {
    let place = TestLink::new("same-torn");
    let scene = shipped_scene("torn_strip");
    let mut plain = TestGame::new(&scene);
    let mut game = TestGame::new(&scene);
    let mut link = Link::new(&place.link, &game.world).expect("a link");
    let client = place.attach();
    let (mut frames, mut events) = (client.frames(true).expect("a place"), client.events().expect("a place"));
    for _ in 0..STEPS {
        plain.world.step();
        game.world.step();
        link.exchange(&mut game, 1e-3);
        let _ = (frames.latest().expect("sound"), events.next().expect("sound"));
    }
    assert_eq!(state_hash(&game.world), state_hash(&plain.world));
}
