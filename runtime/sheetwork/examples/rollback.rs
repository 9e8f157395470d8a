//! Rollback for networked games: the state of every tick is stored as bytes; an input that arrives
//! eight ticks late goes back, and the repeated ticks end in the bits of a game without delay.
//!
//! `cargo run -p sheetwork --example rollback`

use std::collections::VecDeque;
use std::time::Instant;

use sheetwork::glam::DVec3;
use sheetwork::prelude::*;

/// Tick in which the other player pushes the sheet.
const PUSHED_AT: u64 = 30;
/// Ticks until this machine hears of it.
const DELAY: u64 = 8;

pub fn main() -> Result<(), InputError> {
    let floor = BodySpec::new(Shape::HalfSpace);
    let card = SheetSpec::new("card").named("card").size(0.2, 0.2).grid(11, 11).at(0.0, 0.1, 0.0);
    let scene = Scene::new().with_body(floor).with_sheet(card);

    // The game of the other player: the push happens in its tick.
    let mut there = World::new(&scene)?;
    for tick in 0..90 {
        push(&mut there, tick)?;
        there.step();
    }

    // This game keeps the states before the last `DELAY` ticks.
    let mut here = World::new(&scene)?;
    let mut states: VecDeque<Vec<u8>> = VecDeque::new();
    for tick in 0..90 {
        if tick == PUSHED_AT + DELAY {
            let bytes = states.front().expect("there is a state").clone();
            println!("tick {tick}: the push of tick {PUSHED_AT} arrives; a state has {} bytes", bytes.len());
            println!("state hash before: {:016x}", here.state_hash());
            let begin = Instant::now();
            here.deserialise(&bytes)?;
            for repeated in PUSHED_AT..tick {
                push(&mut here, repeated)?;
                here.step();
            }
            println!("going back and {DELAY} ticks again: {:.1} ms", 1e3 * begin.elapsed().as_secs_f64());
            println!("state hash after:  {:016x}", here.state_hash());
        }
        states.push_back(here.serialise());
        if states.len() > DELAY as usize {
            states.pop_front();
        }
        here.step();
    }
    println!("at {:.2} s here: {:016x}, there: {:016x}", here.time(), here.state_hash(), there.state_hash());
    assert_eq!(here.state_hash(), there.state_hash(), "the two games are equal to the bit");
    Ok(())
}

/// The input of a tick: an impulse of 1 mN s on one corner in tick `PUSHED_AT`.
fn push(world: &mut World, tick: u64) -> Result<(), InputError> {
    if tick != PUSHED_AT {
        return Ok(());
    }
    world.sheets_mut()[0].apply_impulse(0, DVec3::new(0.0, 1e-3, 0.0))
}
