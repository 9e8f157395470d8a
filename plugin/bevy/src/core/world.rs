//! Resource that owns the simulated world.

use std::ops::{Deref, DerefMut};
use std::time::{Duration, Instant};

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use rapier3d::prelude::RigidBodySet;
use sheetwork::rigid::RigidView;
use sheetwork::scene::{Air, Region, Scene};
use sheetwork::{BodyId, Checkpoint, InputError, SheetId, World as Sheets};

use super::placement;
use super::world_cell::WorldCell;

/// Prescribed motion of a kinematic body during this tick.
#[derive(Clone, Debug)]
pub(super) struct KinematicMotion {
    pub body: BodyId,
    pub from: (DVec3, DQuat),
    pub to: (DVec3, DQuat),
}

/// Motion of the pins of a sheet with the parent of its entity during this tick.
#[derive(Clone, Debug)]
struct PinLead {
    entity: Entity,
    sheet: SheetId,
    from: (DVec3, DQuat),
    to: (DVec3, DQuat),
}

/// The [`sheetwork::World`] of the entities with [`Sheet`](super::Sheet) and
/// [`SheetBody`](super::SheetBody).
///
/// It starts with `tr-bdf2`, which is stable for any material at the game's fixed step, and takes
/// that step until another one is set.
///
/// It dereferences to the world, for reading and for setters such as `set_gravity`, `set_engine`,
/// `set_dt`, `set_oven`, `set_surroundings` or `set("sheets.leaf.damping", "0.2")`. Sheets, bodies,
/// heaters and heat guns are added and removed with their entities: do not add or remove them here.
///
/// While the plugin steps it on another thread ([`SheetThreading`](super::SheetThreading)), each
/// access to the world waits for the end of the step.
#[derive(Resource)]
pub struct SheetWorld {
    world: WorldCell,
    borrowed: bool,
    generation: u32,
    pub(super) moves: Vec<KinematicMotion>,
    leads: Vec<PinLead>,
    /// Sheets whose pins do not follow a parent, which has been told.
    refused_leads: Vec<SheetId>,
    /// Attachments to bodies of the caller that are not made yet.
    later: Vec<(SheetId, (Region, Entity))>,
    /// Whether the objects may differ from the links of the entities since the last tick.
    pub(super) is_rewound: bool,
    pub(super) events_seen: u64,
    step_time: Duration,
    /// Wall-clock time of a step, exponential mean over ticks, s.
    mean_step: f64,
    /// Simulated time not yet stepped: less than a step, s.
    unstepped: f64,
    /// Displayed time, s.
    shown: f64,
    /// Time, time step and unstepped time before the step on another thread, s; `None` while there
    /// is none since a restart or rollback.
    launched: Option<(f64, f64, f64)>,
    /// Time step fitted to the game's ticks, s; `None` when another step was set.
    fitted: Option<f64>,
}

/// Bevy's default fixed step, s.
const FIXED_STEP: f64 = 1.0 / 64.0;

/// Settings of an empty world: the integrator of an empty scene, Bevy's default fixed step, air at
/// 1.2 kg/m³.
fn empty_world() -> Scene {
    let air = Air { density: 1.2, ..Air::default() };
    Scene { air, dt: FIXED_STEP, ..Scene::default() }
}

/// State of a [`SheetWorld`] with its sheets, bodies and heaters, of [`SheetWorld::checkpoint`].
#[derive(Clone)]
pub struct SheetCheckpoint {
    world: Checkpoint,
    generation: u32,
    unstepped: f64,
    moves: Vec<KinematicMotion>,
    leads: Vec<PinLead>,
}

impl SheetWorld {
    pub(super) fn new(borrowed: bool) -> Self {
        // The empty scene is valid.
        let scene = empty_world();
        let world = make(&scene, borrowed).unwrap_or_else(|e| unreachable!("the empty scene: {e}"));
        Self {
            world: WorldCell::new(world),
            borrowed,
            generation: 0,
            moves: Vec::new(),
            leads: Vec::new(),
            refused_leads: Vec::new(),
            later: Vec::new(),
            is_rewound: false,
            events_seen: 0,
            step_time: Duration::ZERO,
            mean_step: 0.0,
            unstepped: 0.0,
            shown: 0.0,
            launched: None,
            fitted: Some(FIXED_STEP),
        }
    }

    /// With an implicit integrator and an unchanged fitted step, set the time step to the game's
    /// tick of `period` s.
    pub(super) fn fit_step(&mut self, period: f64) {
        if self.wants_step(period) && self.world.set_dt(period).is_ok() {
            self.fitted = Some(period);
        }
    }

    /// Whether [`SheetWorld::fit_step`] would change the step.
    pub(super) fn wants_step(&self, period: f64) -> bool {
        self.fitted == Some(self.world.dt()) && period != self.world.dt() && self.world.engine().info().implicit
    }

    /// Restart the world at time 0 with the gravity, integrator, step, air, contact defaults,
    /// surroundings, oven and heat gun of `settings`. Its sheets, bodies, heaters and room are
    /// ignored. Entities are added again at their transforms.
    ///
    /// # Errors
    /// When a setting is out of range; the world is unchanged then.
    pub fn restart(&mut self, settings: &Scene) -> Result<(), InputError> {
        let empty = Scene { sheets: vec![], bodies: vec![], heaters: vec![], room: None, ..settings.clone() };
        self.world = WorldCell::new(make(&empty, self.borrowed)?);
        self.generation += 1;
        self.moves.clear();
        self.leads.clear();
        self.refused_leads.clear();
        self.later.clear();
        self.events_seen = 0;
        (self.unstepped, self.shown, self.fitted, self.launched) = (0.0, 0.0, None, None);
        Ok(())
    }

    /// Return every sheet and body to its initial state, at time 0. Integrator, step and other
    /// settings are those of the last restart; later changes of settings are lost.
    ///
    /// # Errors
    /// When a file of a sheet or body cannot be read; the world is unchanged then.
    pub fn reset(&mut self) -> Result<(), InputError> {
        self.world.reset()?;
        // The reset world has its first step again, which is fitted to the tick as at the start.
        self.fitted = self.fitted.map(|_| self.world.dt());
        self.moves.clear();
        self.leads.clear();
        self.events_seen = 0;
        (self.unstepped, self.shown, self.launched) = (0.0, 0.0, None);
        Ok(())
    }

    /// Restore the state saved as `bytes` by [`World::serialise`](sheetwork::World::serialise), for
    /// rollback. With equal inputs the following ticks repeat the original ones bit for bit, and
    /// their events are sent again. Sheets and bodies must be those of the saved state.
    ///
    /// # Errors
    /// When `bytes` is not a snapshot of this world; the world is unchanged then.
    pub fn rewind(&mut self, bytes: &[u8]) -> Result<(), InputError> {
        self.world.deserialise(bytes)?;
        self.launched = None;
        self.moves.clear();
        self.leads.clear();
        self.events_seen = self.events_seen.min(self.world.event_count());
        Ok(())
    }

    /// Store the world as a checkpoint, for a rollback across spawns and despawns.
    pub fn checkpoint(&mut self) -> SheetCheckpoint {
        let world = self.world.checkpoint();
        let (moves, leads) = (self.moves.clone(), self.leads.clone());
        SheetCheckpoint { world, generation: self.generation, unstepped: self.unstepped, moves, leads }
    }

    /// Return to a checkpoint. Sheets, bodies and heaters that were added since are gone, and those
    /// that were removed are back, with their ids of that time. The following ticks repeat the
    /// original ones bit for bit, given equal inputs, spawns and despawns in equal order.
    ///
    /// Entities are restored by the game, as `bevy_ggrs` does: roll back [`Sheet`](super::Sheet),
    /// [`SheetMotion`](super::SheetMotion), which links an entity to its sheet, `Transform` and the
    /// like as components, in any order with this call. An entity whose sheet is gone and that
    /// still has its `Sheet` gets a new one at its `Transform`.
    ///
    /// # Errors
    /// When the world was restarted since, or the checkpoint is of another world; the world is
    /// unchanged then.
    pub fn rewind_to(&mut self, checkpoint: &SheetCheckpoint) -> Result<(), InputError> {
        if checkpoint.generation != self.generation {
            return Err(InputError::new("checkpoint", "the world was restarted after it"));
        }
        self.world.restore_checkpoint(&checkpoint.world)?;
        self.moves.clone_from(&checkpoint.moves);
        self.leads.clone_from(&checkpoint.leads);
        (self.unstepped, self.launched) = (checkpoint.unstepped, None);
        self.events_seen = self.events_seen.min(self.world.event_count());
        self.is_rewound = true;
        Ok(())
    }

    /// Number of restarts. Links from entities with another generation are stale.
    pub(crate) fn generation(&self) -> u32 {
        self.generation
    }

    /// Whether the rigid bodies belong to the caller.
    pub fn borrows_bodies(&self) -> bool {
        self.borrowed
    }

    /// Whether the world holds neither sheets nor bodies.
    pub fn is_empty(&self) -> bool {
        self.world.sheets().is_empty() && self.world.rigid().is_none_or(|r| r.bodies().is_empty())
    }

    /// Advance against the world's own bodies by the whole steps of
    /// [`World::dt`](sheetwork::World::dt) that fit into `duration` s plus the remainder of the
    /// last call. The result does not depend on the frame rate. Returns the number of steps.
    pub fn advance(&mut self, duration: f64) -> u64 {
        let start = Instant::now();
        let Some(steps) = self.due_steps(duration) else { return 0 };
        let moves = self.begin_moves(steps);
        advance(&mut self.world, steps, &moves);
        self.took(start.elapsed(), steps);
        steps
    }

    /// Begin the steps of [`SheetWorld::advance`] on another thread. The next access to the world
    /// waits for their end.
    pub(super) fn begin_advance(&mut self, duration: f64) {
        self.launched = Some((self.world.time(), self.world.dt(), self.unstepped));
        let Some(steps) = self.due_steps(duration).filter(|steps| *steps > 0) else { return };
        let moves = self.begin_moves(steps);
        self.world.begin(move |world| {
            advance(world, steps, &moves);
            steps
        });
    }

    /// Take over the measured time of the last steps on another thread.
    pub(super) fn finish_advance(&mut self) {
        if let Some((time, steps)) = self.world.take_time() {
            self.took(time, steps);
        }
    }

    /// Whether the world is being stepped on another thread: an access waits for the end.
    pub fn is_stepping(&self) -> bool {
        self.world.is_stepping()
    }

    /// Number of whole steps in `duration` s and the remainder of the last call; `None` without a
    /// duration.
    fn due_steps(&mut self, duration: f64) -> Option<u64> {
        if duration.is_nan() || duration <= 0.0 {
            return None;
        }
        let (time, dt) = (self.unstepped + duration, self.world.dt());
        // The slack of 1e-9 steps absorbs the rounding of a duration of whole steps.
        let steps = (time / dt + 1e-9).floor().max(0.0) as u64;
        self.unstepped = (time - steps as f64 * dt).max(0.0);
        Some(steps)
    }

    /// Begin the motions that wait for the next step.
    fn begin_moves(&mut self, steps: u64) -> Vec<KinematicMotion> {
        if steps == 0 {
            return Vec::new();
        }
        self.lead_pins(steps as f64 * self.world.dt());
        std::mem::take(&mut self.moves)
    }

    /// Advance by `duration` s, in equal steps of at most [`World::dt`](sheetwork::World::dt),
    /// against the caller's Rapier world, which is already at the end of that time; 0 does nothing.
    /// For a system in [`SheetworkSet::Step`](super::SheetworkSet::Step), with
    /// [`SheetClock::due`](super::SheetClock::due) as the duration. Returns the number of steps.
    pub fn advance_with(&mut self, view: &RigidView, duration: f64) -> u64 {
        if duration <= 0.0 {
            return 0;
        }
        let start = Instant::now();
        self.lead_pins(duration);
        let steps = self.world.advance_with(view, duration);
        self.attach_waiting(view);
        self.took(start.elapsed(), steps);
        steps
    }

    /// Lead the pins of a sheet with the parent of `entity`, from one pose to another, during the
    /// next tick with a step.
    pub(super) fn lead_later(&mut self, entity: Entity, sheet: SheetId, from: (DVec3, DQuat), to: (DVec3, DQuat)) {
        match self.leads.iter_mut().find(|lead| lead.sheet == sheet) {
            Some(waiting) => waiting.to = to,
            None => self.leads.push(PinLead { entity, sheet, from, to }),
        }
    }

    /// Lead pins within the next `duration` s.
    fn lead_pins(&mut self, duration: f64) {
        for PinLead { entity, sheet, from, to } in std::mem::take(&mut self.leads) {
            let (by, turn) = placement::motion_between(from, to);
            if self.world.get_sheet(sheet).is_some()
                && let Err(problem) = self.world.lead_pins(sheet, by, turn, duration)
                && !self.refused_leads.contains(&sheet)
            {
                self.refused_leads.push(sheet);
                error!("pins of {entity} do not follow its parent: {problem}");
            }
        }
    }

    /// Attach a region of a sheet to a body of the caller after its next step.
    pub(super) fn attach_later(&mut self, sheet: SheetId, attachment: (Region, Entity)) {
        self.later.push((sheet, attachment));
    }

    /// Make the attachments to bodies of the caller that wait, now that both worlds are at one
    /// time.
    fn attach_waiting(&mut self, view: &RigidView) {
        for (sheet, (region, entity)) in std::mem::take(&mut self.later) {
            let is_it = |user_data: u128| user_data == u128::from(entity.to_bits());
            let Some((handle, _)) = view.bodies.iter().find(|(_, body)| is_it(body.user_data)) else {
                error!("no body of the Rapier world has {entity} in its user data");
                continue;
            };
            if let Err(problem) = self.world.attach_lent(sheet, &region, (view.bodies, handle)) {
                error!("attachment to {entity}: {problem}");
            }
        }
    }

    /// Write the states of the bodies that sheets have moved to the caller's `bodies`, after
    /// [`SheetWorld::advance_with`] with a view that is [`RigidView::pushing`].
    pub fn write_lent_bodies(&mut self, bodies: &mut RigidBodySet) {
        self.world.write_lent_bodies(bodies);
    }

    /// Simulated time displayed in this frame, s. It lags [`World::time`](sheetwork::World::time)
    /// by about a tick, so that every frame lies between two computed states.
    pub fn shown_time(&self) -> f64 {
        self.shown
    }

    /// Advance the displayed time: `fraction` of the next tick, of `tick` s, has passed; `None`
    /// while paused.
    pub(super) fn show(&mut self, tick: f64, fraction: Option<f64>) {
        let idle = || (self.world.time(), self.world.dt(), self.unstepped);
        let (now, dt, unstepped) = self.launched.unwrap_or_else(idle);
        let Some(fraction) = fraction else {
            self.shown = now;
            return;
        };
        // One tick behind, so that a later state exists; one step more unless ticks are whole
        // steps.
        let steps = tick / dt;
        let whole = (steps - steps.round()).abs() < 1e-6 && unstepped < 1e-6 * dt;
        let behind = if whole || self.borrowed { tick } else { tick + dt };
        let target = now + unstepped + fraction * tick - behind;
        // The displayed time is monotonic after a pause or a change of speed; only a rollback moves
        // it back.
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

    /// Wall-clock time of one time step, exponential mean over ticks, s; 0 before the first.
    pub fn mean_step_time(&self) -> f64 {
        self.mean_step
    }

    /// Wall-clock time of the last [`SheetWorld::advance`] or [`SheetWorld::advance_with`].
    pub fn step_time(&self) -> Duration {
        self.step_time
    }
}

impl Deref for SheetWorld {
    type Target = Sheets;

    fn deref(&self) -> &Sheets {
        &self.world
    }
}

impl DerefMut for SheetWorld {
    fn deref_mut(&mut self) -> &mut Sheets {
        &mut self.world
    }
}

/// Take `steps` steps; the bodies move at constant velocity over all of them.
fn advance(world: &mut Sheets, steps: u64, moves: &[KinematicMotion]) {
    for step in 1..=steps {
        let s = step as f64 / steps as f64;
        for KinematicMotion { body, from, to } in moves {
            world.move_body(*body, from.0.lerp(to.0, s), from.1.slerp(to.1, s));
        }
        world.step();
    }
}

fn make(scene: &Scene, borrowed: bool) -> Result<Sheets, InputError> {
    Ok(if borrowed { Sheets::without_bodies(scene) } else { Sheets::new(scene) }?)
}
