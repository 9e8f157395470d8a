//! Memory for rollback: for each of the last ticks, the world before it and the inputs of both
//! players.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::Air;

/// Maximum delay of an input, ticks.
pub const LATE: u64 = 8;
/// Wind speed of a player, m/s.
const WIND: f64 = 4.0;

/// World before a tick, and its inputs.
#[derive(Clone, Default)]
struct Tick {
    before: Vec<u8>,
    inputs: [f64; 2],
}

/// Ring buffer of the last ticks.
#[derive(Resource)]
pub struct History {
    ticks: Vec<Tick>,
    /// Number of the present tick, from 1.
    now: u64,
}

impl Default for History {
    fn default() -> Self {
        Self { ticks: vec![Tick::default(); LATE as usize + 1], now: 0 }
    }
}

impl History {
    fn at(&mut self, tick: u64) -> &mut Tick {
        let index = (tick % self.ticks.len() as u64) as usize;
        &mut self.ticks[index]
    }

    /// Begin a tick with the known inputs. An unknown input repeats the previous one.
    pub fn begin(&mut self, world: &SheetWorld, [own, _]: [f64; 2]) {
        let theirs = self.inputs(self.now)[1];
        self.now += 1;
        let now = self.now;
        let tick = self.at(now);
        world.serialise_into(&mut tick.before);
        tick.inputs = [own, theirs];
    }

    /// Number of the present tick.
    pub fn tick(&self) -> u64 {
        self.now
    }

    /// Inputs of `tick`, as far as they are known.
    pub fn inputs(&self, tick: u64) -> [f64; 2] {
        self.ticks[(tick % self.ticks.len() as u64) as usize].inputs
    }

    /// Size of the last snapshot, bytes.
    pub fn bytes(&self) -> usize {
        self.ticks[(self.now % self.ticks.len() as u64) as usize].before.len()
    }

    /// Store the other player's input of `tick`. Returns whether it differs from the assumed one.
    pub fn arrives(&mut self, tick: u64, input: f64) -> bool {
        let other = tick >= 1 && self.inputs(tick)[1] != input;
        if other {
            // The input holds for the later ticks until the next one arrives.
            (tick..=self.now).for_each(|t| self.at(t).inputs[1] = input);
        }
        other
    }

    /// Repeat the ticks from `tick` up to the start of the present one.
    pub fn replay(&mut self, world: &mut SheetWorld, tick: u64) {
        let before = std::mem::take(&mut self.at(tick).before);
        if let Err(error) = world.rewind(&before) {
            // Sheets were added or removed since: no rollback is possible.
            warn!("{error}");
        }
        self.at(tick).before = before;
        for t in tick..self.now {
            blow(world, self.inputs(t));
            world.step();
            world.serialise_into(&mut self.at(t + 1).before);
        }
    }
}

/// Apply the inputs of a tick to the world.
pub fn blow(world: &mut SheetWorld, inputs: [f64; 2]) {
    let air = Air { density: 1.2, wind: DVec3::new(WIND * inputs[0], 0.0, WIND * inputs[1]), ..world.air() };
    if air != world.air()
        && let Err(error) = world.set_air(air)
    {
        warn!("{error}");
    }
}
