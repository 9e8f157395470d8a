//! Snapshots as bytes: what is saved is gone on from bit for bit, in the world it is of and in a new one of the same scene; and what is
//! no snapshot is refused.
//!
//! The whole library for 600 steps: `sheetwork bench rollback`.

use glam::DVec3;
use sheetwork::World;
use sheetwork::engine::TABLE;
use sheetwork::lattice;
use sheetwork::scene::{Placement, Scene, Shape};
use sheetwork_tests::{body, shipped, small_sheet, state_hash};

/// Hashes after each of `steps` steps.
fn run(world: &mut World, steps: u32) -> Vec<u64> {
    let one = |_| {
        world.step();
        state_hash(world)
    };
    (0..steps).map(one).collect()
}

/// Goes `first` steps, saves, goes on, and says where two runs from what was saved come apart from that: after how many steps.
fn first_difference(scene: &Scene, first: u32, steps: u32) -> Option<(&'static str, usize)> {
    let mut world = World::new(scene).unwrap_or_else(|e| panic!("{e}"));
    run(&mut world, first);
    let saved = world.save();
    let wanted = run(&mut world, steps);
    let end = world.save();
    let mut fresh = World::new(scene).unwrap_or_else(|e| panic!("{e}"));
    for (name, world) in [("the same world", &mut world), ("a new world", &mut fresh)] {
        world.load(&saved).unwrap_or_else(|e| panic!("{}: {e}", scene.name));
        let again = world.save();
        if let Some(at) = (0..saved.len().max(again.len())).find(|i| saved.get(*i) != again.get(*i)).filter(|at| *at > 24) {
            println!("{}: {name}: what is saved again differs at byte {at} of {} ({})", scene.name, saved.len(), again.len());
        }
        let found = run(world, steps);
        if let Some(at) = (0..wanted.len()).find(|i| wanted[*i] != found[*i]) {
            return Some((name, at + 1));
        }
        if world.save() != end {
            println!("{}: {name}: ends alike, but for what is not seen", scene.name);
        }
    }
    None
}

fn continues(scene: &Scene, name: &str, first: u32, steps: u32) {
    let apart = first_difference(scene, first, steps);
    assert!(apart.is_none(), "{name}: {} differs after {} steps", apart.unwrap_or_default().0, apart.unwrap_or_default().1);
}

/// Scenes with contact, bodies that move, heat, flow, tears, glue and sticking.
const SAMPLE: &[(&str, u32, u32)] = &[
    ("wedge", 40, 60),
    ("slide_11", 60, 60),
    ("flat_floor_e01", 30, 60),
    ("box_on_sheet", 30, 40),
    ("ball_on_sheet", 20, 30),
    ("needle", 20, 20),
    ("folded_card", 30, 20),
    ("flag", 30, 40),
    ("hot_sag", 60, 60),
    ("heat_gun", 40, 40),
    ("oven_wedge", 40, 40),
    ("heater_wedge", 30, 30),
    ("torn_strip", 60, 40),
    ("sticky_film", 40, 30),
    ("creased_sheet", 30, 40),
];

#[test]
fn a_sample_of_the_library_goes_on_to_the_bit() {
    let chosen = std::env::var("SHEETWORK_SCENES").unwrap_or_default();
    if chosen.is_empty() {
        for (name, first, steps) in SAMPLE {
            continues(&shipped(name), name, *first, *steps);
        }
        return;
    }
    let mut parts = chosen.split(' ');
    let mut number = || parts.next().and_then(|n| n.parse::<u32>().ok());
    let (first, steps) = (number().unwrap_or(50), number().unwrap_or(50));
    let names: Vec<String> = parts.map(str::to_owned).collect();
    let names = if names.is_empty() { sheetwork_tests::all_shipped() } else { names };
    for name in names {
        let start = std::time::Instant::now();
        match first_difference(&shipped(&name), first, steps) {
            Some((what, at)) => println!("FAIL {name}: {what} after {at}  {:.1?}", start.elapsed()),
            None => println!("ok   {name}  {:.1?}", start.elapsed()),
        }
    }
}
