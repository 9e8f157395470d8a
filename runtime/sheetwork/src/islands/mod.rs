//! One step of a sheet: the order in which things happen.
//!
//! lead the pins → engine (forces) → flexion limit → guard → contact → thickness limit → (again, where the engine took less than the step)
//! → contact with what gives way and with sharp edges (`explicit`) → put the pins in place → still enough to sleep?
//!
//! What a scene does not use is not called: no pins, no limit, no bodies. Nothing here allocates once the first step has
//! sized the working arrays. Sheets that do not touch do not see one another, so they can be stepped on any number of threads
//! with the same result. The step of an implicit engine is in `group`.

pub(crate) mod energy_budget;
pub mod event;
pub(crate) mod explicit;
pub(crate) mod implicit_step;
pub(crate) mod instability;
pub(crate) mod island_detection;
pub(crate) mod island_manager;
pub(crate) mod rigid_motion;

pub(crate) use crate::islands::island_detection::{NearWork, skin};

use crate::contact::node::detection::contact;
use crate::islands::event::{Alarm, EventKind, Handled, Recorder, Touches};
use crate::math::Vectors;
use crate::profiler::{Phase, Watched};
use crate::rigid::RigidView;
use crate::sheet::{Sheet, Status};

pub use crate::sheet::Field;

/// Speed below which a sheet counts as still, m/s.
pub const SLEEP_SPEED: f64 = 1e-3;
/// How long it must be still before it sleeps, s.
pub const SLEEP_TIME: f64 = 0.5;
/// What stays so near to where it was, m, is still too, however fast: where contacts contradict one another, as at the rim of a sheet that lies on
/// another's, masses go to and fro between two places in which they are put in turns.
const TREMBLE: f64 = 1e-4;
/// The same of a sheet smaller than 5 cm, as a part of its diagonal.
const TREMBLE_OF_SMALL: f64 = 2e-3;
/// Speed above which a sheet has gone unstable, m/s: beyond any velocity a scene may set.
const SPEED_LIMIT: f64 = 2e4;
/// A sheet whose bounding box has grown to this many times its diagonal at the start has flown apart.
const SPREAD_LIMIT: f64 = 20.0;
/// Steps an adaptive engine may take within one step before the sheet counts as unstable.
const MOST_SUBSTEPS: u32 = 100_000;

/// What a sheet's step is given.
#[derive(Clone, Copy)]
pub(crate) struct Stage<'a> {
    pub field: Field,
    pub time: f64,
    pub dt: f64,
    pub view: Option<&'a RigidView<'a>>,
    pub sleep: bool,
    /// Whether sheets meet one another.
    pub sheets_meet: bool,
    pub watch: &'a Watched,
}

/// Takes one sheet of an explicit engine, or one that is near such a sheet, through `stage.dt`, alone with bodies that do not give way:
/// [`land`] ends the step.
/// Returns the length of the last part of the step, s.
pub(crate) fn fly(sheet: &mut Sheet, touches: &mut Touches, stage: &Stage) -> f64 {
    size_work(sheet);
    touches.begin(stage.time);
    sheet.work.touching.fill(false);
    sheet.keep_start();
    let mut done = 0.0;
    let mut substeps = 0;
    let mut last = stage.dt;
    let most = stage.dt / f64::from(sheet.parts_of_step(stage.dt)) * (1.0 + 1e-12);
    // The last part of a step may be a rounding error long; it is then the step's.
    while stage.dt - done > stage.dt * 1e-12 {
        let part = (stage.dt - done).min(most);
        let Some(taken) = substep(sheet, touches, stage, done, part) else { break };
        last = taken;
        done += last;
        substeps += 1;
        if substeps > MOST_SUBSTEPS {
            give_up(sheet, touches, stage, last);
            break;
        }
    }
    last
}

/// Ends the step of a sheet that touched nothing that gives way.
pub(crate) fn land(sheet: &mut Sheet, touches: &mut Touches, stage: &Stage, last: f64) {
    if !sheet.pins.is_empty() {
        sheet.pins.place(stage.time + stage.dt, &mut sheet.x);
    }
    touches.end(stage.time + stage.dt, sheet);
    if stage.sleep {
        fall_asleep(sheet, touches, stage, last);
    }
}

/// Makes the arrays a step works in.
pub(crate) fn size_work(sheet: &mut Sheet) {
    let n = sheet.masses();
    if sheet.work.x_before.len() != n {
        sheet.work.x_before = Vectors::zeros(n);
        sheet.work.v_before = Vectors::zeros(n);
        sheet.still_at = Vectors::zeros(n);
        sheet.work.struck = vec![Default::default(); n];
        sheet.work.touching = vec![false; n];
    }
}

/// One call of the engine and what follows it; returns the time taken, none where the sheet does not go on in this step.
fn substep(sheet: &mut Sheet, touches: &mut Touches, stage: &Stage, done: f64, part: f64) -> Option<f64> {
    let time = stage.time + done;
    if !sheet.pins.is_empty() {
        sheet.pins.lead(time, part, &sheet.x, &mut sheet.v);
    }
    sheet.work.x_before.copy_from(&sheet.x);
    sheet.work.v_before.copy_from(&sheet.v);
    let taken = match sheet.guard {
        // Implicit engines watch their own steps.
        Some(_) if sheet.is_explicit() => instability::advance(sheet, touches, stage, time, part)?,
        _ => sheet.advance(stage.field, time, part).taken,
    };
    if let Some(limit) = &sheet.flexion_limit {
        limit.apply(&sheet.x, &mut sheet.v, &sheet.inverse_mass, taken);
    }
    if is_unstable(sheet) {
        give_up(sheet, touches, stage, taken);
        return None;
    }
    if let Some(view) = stage.view {
        let remaining = (stage.dt - done - taken).max(0.0);
        stage.watch.within(Phase::Detection, || {
            contact(sheet, view, taken, remaining, &mut Recorder { touches, view });
        });
    }
    if let Some(limit) = &sheet.thickness_limit {
        limit.apply(&sheet.x, &mut sheet.v, &sheet.inverse_mass, &sheet.work.touching, taken);
    }
    Some(taken)
}

fn is_unstable(sheet: &Sheet) -> bool {
    // Written so that a NaN is unstable too.
    let slow = sheet.v.max_squared() < SPEED_LIMIT * SPEED_LIMIT;
    let most = SPREAD_LIMIT * sheet.spread;
    let together = match sheet.opened() {
        None => sheet.x.bounds().is_some_and(|(low, high)| low.distance(high) < most),
        // Its pieces may part.
        Some(_) => sheet.holds_together(most),
    };
    sheet.work.stage.astray || !(slow && together)
}

/// Stops a sheet that a step of `dt` s has made unstable where it was before, and says so.
fn give_up(sheet: &mut Sheet, touches: &mut Touches, stage: &Stage, dt: f64) {
    let alarm = Alarm::of(sheet, stage.field.gravity, dt);
    sheet.x.copy_from(&sheet.work.x_before);
    if sheet.guard.is_some() && sheet.x.max_squared().is_finite() {
        freeze(sheet, touches, stage.time, alarm);
        return;
    }
    sheet.v.clear();
    let (mass, place) = (alarm.mass, sheet.x.get(alarm.mass as usize));
    sheet.status = Status::Unstable { time: stage.time, mass, place, speed: alarm.speed_m_s };
    touches.tell(stage.time, EventKind::Unstable, alarm);
}

/// Lets a sheet stand where it is until something about it is changed, and says so.
fn freeze(sheet: &mut Sheet, touches: &mut Touches, time: f64, alarm: Alarm) {
    sheet.v.clear();
    sheet.restart_engine();
    sheet.status = Status::Frozen { time };
    touches.tell(time, EventKind::Contained, Alarm { handled: Handled::Frozen, ..alarm });
}

/// Puts a sheet to sleep that has been still for a while; `last` is the length of the last part of the step, s.
fn fall_asleep(sheet: &mut Sheet, touches: &mut Touches, stage: &Stage, last: f64) {
    // A sheet adrift is not at rest, however slow: something must hold it.
    let held = (!sheet.pins.is_empty() || touches.count() > 0) && !sheet.is_creeping();
    if note_rest(sheet, held, (last, stage.dt)) {
        sheet.status = Status::Asleep;
        sheet.v.clear();
        touches.events.push((stage.time + stage.dt, EventKind::AtRest, None));
    }
}

/// Counts for how long a sheet that may be `held` has been still, after a step of `dt` s with a last part of `last` s; true where that is long enough
/// to sleep.
fn note_rest(sheet: &mut Sheet, held: bool, (last, dt): (f64, f64)) -> bool {
    if !held || !(is_still(sheet, last) || is_near(sheet)) {
        sheet.quiet = 0.0;
        return false;
    }
    if sheet.quiet == 0.0 {
        sheet.still_at.clone_from(&sheet.work.x_before);
    }
    sheet.quiet += dt;
    sheet.quiet >= SLEEP_TIME
}

/// Whether all masses are no further than what may tremble from where they were when the sheet was found still, or at the start of the step.
fn is_near(sheet: &Sheet) -> bool {
    let before = if sheet.quiet > 0.0 { &sheet.still_at } else { &sheet.work.x_before };
    before.len() == sheet.masses() && furthest_within(&sheet.x, before, TREMBLE.min(TREMBLE_OF_SMALL * sheet.spread))
}

/// Whether no mass went faster than [`SLEEP_SPEED`], by where it went and not by its velocity: next to masses that contact
/// holds, a multi-stage engine can rest with a velocity left that every step takes back again.
fn is_still(sheet: &Sheet, dt: f64) -> bool {
    furthest_within(&sheet.x, &sheet.work.x_before, SLEEP_SPEED * dt)
}

fn furthest_within(now: &Vectors, before: &Vectors, most: f64) -> bool {
    (0..now.len()).all(|i| now.get(i).distance_squared(before.get(i)) < most * most)
}
