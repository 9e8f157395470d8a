//! What a game that rolls back remembers: of the last ticks the world before each and the inputs of both players.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::Air;

/// By how many ticks an input may be late.
pub const LATE: u64 = 8;
/// How hard a hand blows, m/s.
const WIND: f64 = 4.0;

/// One tick.
#[derive(Clone, Default)]
struct Tick {
    before: Vec<u8>,
    inputs: [f64; 2],
}

/// The last ticks, in the memory of those before them.
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

    /// Begins a tick with what is known of its inputs. What is not known yet is taken to be as it was.
    pub fn begin(&mut self, world: &SheetWorld, [own, _]: [f64; 2]) {
        let theirs = self.inputs(self.now)[1];
        self.now += 1;
        let now = self.now;
        let tick = self.at(now);
        world.save_into(&mut tick.before);
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

    /// Bytes of the last snapshot.
    pub fn bytes(&self) -> usize {
        self.ticks[(self.now % self.ticks.len() as u64) as usize].before.len()
    }

    /// The other player's input of `tick` has come; whether it is another than was supposed.
    pub fn arrives(&mut self, tick: u64, input: f64) -> bool {
        let other = tick >= 1 && self.inputs(tick)[1] != input;
        if other {
            // And from then on, until more is known.
            (tick..=self.now).for_each(|t| self.at(t).inputs[1] = input);
        }
        other
    }

    /// Runs the ticks from `tick` on again, up to where the present one begins.
    pub fn replay(&mut self, world: &mut SheetWorld, tick: u64) {
        let before = std::mem::take(&mut self.at(tick).before);
        if let Err(error) = world.rewind(&before) {
            // Sheets have come or gone: there is nothing to go back to.
            warn!("{error}");
        }
        self.at(tick).before = before;
        for t in tick..self.now {
            blow(world, self.inputs(t));
            world.step();
            world.save_into(&mut self.at(t + 1).before);
        }
    }
}

/// Gives the world the inputs of a tick.
pub fn blow(world: &mut SheetWorld, inputs: [f64; 2]) {
    let air = Air { density: 1.2, wind: DVec3::new(WIND * inputs[0], 0.0, WIND * inputs[1]), ..world.air() };
    if air != world.air()
        && let Err(error) = world.set_air(air)
    {
        warn!("{error}");
    }
}
