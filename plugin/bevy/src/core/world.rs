//! The resource that owns the sheets' world.

use std::time::{Duration, Instant};

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use sheetwork::rigid::RigidView;
use sheetwork::scene::EngineKind;
use sheetwork::scene::{Air, Scene};
use sheetwork::{InputError, World as Sheets};

/// A body that is on its way from one place to another during this tick.
#[derive(Clone, Debug)]
pub(super) struct Move {
    pub name: String,
    pub from: (DVec3, DQuat),
    pub to: (DVec3, DQuat),
}

/// The [`sheetwork::World`] that entities with [`Sheet`](super::Sheet) and [`SheetBody`](super::SheetBody) are in.
///
/// It begins with an explicit engine, for the thesis's soft sheets. The first [`Sheet`](super::Sheet) that follows its material
/// changes that to `tr-bdf2`, which holds any material at the game's fixed step, unless engine or step were set before.
///
/// It dereferences to that world, for reading and for setters such as `set_gravity`, `set_engine`, `set_dt` or
/// `set("sheets.leaf.damping", "0.2")`; an oven is put about everything with `set_oven`, and the room made warmer with
/// `set_surroundings`. Sheets, bodies, heaters and heat guns come and go with their entities: do not add or remove them here.
#[derive(Resource, Deref, DerefMut)]
pub struct SheetWorld {
    #[deref]
    world: Sheets,
    borrowed: bool,
    generation: u32,
    pub(super) moves: Vec<Move>,
    pub(super) events_seen: usize,
    step_time: Duration,
    /// Wall-clock time of a step, smoothed over some ticks, s.
    mean_step: f64,
    /// Time that has come and is not yet a whole step, s.
    owed: f64,
    /// Time the display is at, s.
    shown: f64,
    /// The engine step that was fitted to the game's ticks, s; none where somebody else chose it.
    fitted: Option<f64>,
}

/// What an empty world begins with: a room's air.
fn for_games() -> Scene {
    let air = Air { density: 1.2, ..Air::default() };
    Scene { air, ..Scene::default() }
}

impl SheetWorld {
    pub(super) fn new(borrowed: bool) -> Self {
        // An empty scene is valid; there is nothing in it to refuse.
        let scene = for_games();
        let world = make(&scene, borrowed).unwrap_or_else(|e| unreachable!("the empty scene: {e}"));
        Self {
            world,
            borrowed,
            generation: 0,
            moves: Vec::new(),
            events_seen: 0,
            step_time: Duration::ZERO,
            mean_step: 0.0,
            owed: 0.0,
            shown: 0.0,
            fitted: None,
        }
    }

    /// Takes the engine for real materials, at Bevy's own fixed step, where engine and step are still those of an empty world.
    pub(super) fn hold_material(&mut self) {
        let empty = Scene::default();
        if self.world.engine() == empty.engine && self.world.dt() == empty.dt && self.world.set_dt(1.0 / 64.0).is_ok() {
            self.world.set_engine(EngineKind::TrBdf2);
            self.fitted = Some(1.0 / 64.0);
        }
    }

    /// With an implicit engine, makes the engine step the game's tick of `period` s, unless the step was set otherwise.
    pub(super) fn fit_step(&mut self, period: f64) {
        if self.wants_step(period) && self.world.set_dt(period).is_ok() {
            self.fitted = Some(period);
        }
    }

    /// Whether [`SheetWorld::fit_step`] would change something.
    pub(super) fn wants_step(&self, period: f64) -> bool {
        self.fitted == Some(self.world.dt()) && period != self.world.dt() && self.world.engine().info().implicit
    }

    /// Starts the world anew at time 0 with the gravity, engine, step, air, contact defaults, surroundings, oven and heat gun of
    /// `settings`, whose sheets, bodies, heaters and room are left out. Those of entities are put in again where their entities say.
    ///
    /// # Errors
    /// When a setting is out of range; the world is then as before.
    pub fn restart(&mut self, settings: &Scene) -> Result<(), InputError> {
        let empty = Scene { sheets: vec![], bodies: vec![], heaters: vec![], room: None, ..settings.clone() };
        self.world = make(&empty, self.borrowed)?;
        self.generation += 1;
        self.moves.clear();
        self.events_seen = 0;
        (self.owed, self.shown, self.fitted) = (0.0, 0.0, None);
        Ok(())
    }

    /// Puts every sheet and body back to where its entity put it in, at time 0. Engine, step and all else are those of the settings that it
    /// was started with: what was set since is to be set again.
    ///
    /// # Errors
    /// When a file that a sheet or body names cannot be read any more; the world is then as before.
    pub fn reset(&mut self) -> Result<(), InputError> {
        self.world.reset()?;
        self.moves.clear();
        self.events_seen = 0;
        (self.owed, self.shown) = (0.0, 0.0);
        Ok(())
    }

    /// Goes to where the world was when `bytes` were saved ([`World::save`](sheetwork::World::save)), for a game that rolls back: the ticks
    /// that follow are those that came then, to the bit, if they are given the same inputs. What was told of as events since
    /// then is told of again. Sheets and bodies must be those of then.
    ///
    /// # Errors
    /// When `bytes` are no snapshot of this world; nothing is changed then.
    pub fn rewind(&mut self, bytes: &[u8]) -> Result<(), InputError> {
        self.world.load(bytes)?;
        self.moves.clear();
        self.events_seen = self.events_seen.min(self.world.events().len());
        Ok(())
    }

    /// Counts the restarts; what was put into an earlier world is no longer in this one.
    pub(crate) fn generation(&self) -> u32 {
        self.generation
    }

    /// Whether the rigid bodies are lent by the caller.
    pub fn borrows_bodies(&self) -> bool {
        self.borrowed
    }

    /// Whether there is neither sheet nor body in it.
    pub fn is_empty(&self) -> bool {
        self.world.sheets().is_empty() && self.world.rigid().is_none_or(|r| r.bodies().is_empty())
    }

    /// Advances against the world's own bodies by as many whole steps of [`World::dt`](sheetwork::World::dt) as `duration` s,
    /// and what was left the last time, have room for: what a sheet does depends neither on frames nor on playback speed.
    /// Returns how many steps that were.
    pub fn advance(&mut self, duration: f64) -> u64 {
        if duration.is_nan() || duration <= 0.0 {
            return 0;
        }
        let start = Instant::now();
        self.owed += duration;
        // The slack keeps a duration that is a whole number of steps, but for rounding, at that number.
        let steps = (self.owed / self.world.dt() + 1e-9).floor().max(0.0) as u64;
        let moves = if steps > 0 { std::mem::take(&mut self.moves) } else { Vec::new() };
        for step in 1..=steps {
            // Evenly over the tick, and not all the way in its first step.
            let s = step as f64 / steps as f64;
            for Move { name, from, to } in &moves {
                self.world.move_body(name, from.0.lerp(to.0, s), from.1.slerp(to.1, s));
            }
            self.world.step();
        }
        self.owed = (self.owed - steps as f64 * self.world.dt()).max(0.0);
        self.took(start.elapsed(), steps);
        steps
    }

    /// Advances by `duration` s, in equal steps of at most [`World::dt`](sheetwork::World::dt), against a Rapier world of the
    /// caller's, which is already at the end of that time; 0 does nothing. For a system in [`SheetworkSet::Step`](super::SheetworkSet::Step), with
    /// [`SheetClock::due`](super::SheetClock::due) as the duration.
    pub fn advance_with(&mut self, view: &RigidView, duration: f64) -> u64 {
        if duration <= 0.0 {
            return 0;
        }
        let start = Instant::now();
        let steps = self.world.advance_with(view, duration);
        self.took(start.elapsed(), steps);
        steps
    }

    /// Simulated time that is shown in this frame, s: a little behind [`World::time`](sheetwork::World::time), so that it can
    /// run smoothly between steps that were taken.
    pub fn shown_time(&self) -> f64 {
        self.shown
    }

    /// Moves the shown time on: `fraction` of the next tick, of `tick` s, has passed; `None` while the sheets stand still.
    pub(super) fn show(&mut self, tick: f64, fraction: Option<f64>) {
        let now = self.world.time();
        let Some(fraction) = fraction else {
            self.shown = now;
            return;
        };
        // A tick behind, so that there is always a state ahead; and a step more unless ticks are whole steps.
        let steps = tick / self.world.dt();
        let whole = (steps - steps.round()).abs() < 1e-6 && self.owed < 1e-6 * self.world.dt();
        let behind = if whole || self.borrowed { tick } else { tick + self.world.dt() };
        let target = now + self.owed + fraction * tick - behind;
        // Never backwards: not after a pause, and not when the speed changes; but back with the world itself.
        let least = if self.shown > now { 0.0 } else { self.shown };
        self.shown = target.min(now).max(least);
    }

    fn took(&mut self, time: Duration, steps: u64) {
        self.step_time = time;
        if steps > 0 {
            let each = time.as_secs_f64() / steps as f64;
            self.mean_step = if self.mean_step > 0.0 { 0.95 * self.mean_step + 0.05 * each } else { each };
        }
    }

    /// Wall-clock time of one step of the engine, smoothed over some ticks, s; 0 before the first.
    pub fn mean_step_time(&self) -> f64 {
        self.mean_step
    }

    /// Wall-clock time the last [`SheetWorld::advance`] or [`SheetWorld::advance_with`] took.
    pub fn step_time(&self) -> Duration {
        self.step_time
    }
}

fn make(scene: &Scene, borrowed: bool) -> Result<Sheets, InputError> {
    if borrowed { Sheets::without_bodies(scene) } else { Sheets::new(scene) }
}
