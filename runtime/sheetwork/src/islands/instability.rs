//! Instability detector and recovery policy ([`crate::scene::WhenUnstable`]) for sheets of explicit
//! integrators.
//!
//! A step of an explicit integrator may not increase the energy, apart from the work of gravity,
//! wind and pins. A step that does is rolled back and, by policy, repeated in shorter substeps,
//! repeated with a strain limit, taken by the implicit integrator from the next step on, or
//! replaced by freezing the sheet. Each interval without detection eases the policy by one level.
//! Contact may add only the energy of bodies and other sheets. A sheet that ends a step above that
//! bound returns to the start of the step at reduced speed, its contact partners move as if it were
//! absent, and the policy applies.
//!
//! The detector depends on the state of one sheet alone: any number of threads gives the same
//! result. Implicit integrators check their own energy ([`crate::islands::energy_budget`]); when
//! their fallbacks fail, the sheet is frozen. Energies in J.

use crate::islands::event::{Alarm, EventKind, Handled, Touches};
use crate::islands::settings::{InstabilitySettings, StepSettings};
use crate::islands::{Stage, is_unstable};
use crate::scene::WhenUnstable;
use crate::sheet::{GUARDED, Guard, Level, Sheet, Status};

const SETTINGS: InstabilitySettings = StepSettings::DEFAULT.instability;
const STEP: StepSettings = StepSettings::DEFAULT;

/// Ease recovery policies and exchange integrators that are due, before the step of a world.
pub(crate) fn begin(sheets: &mut [Sheet], touches: &mut [Touches], stage: &Stage) {
    for (sheet, touches) in sheets.iter_mut().zip(touches) {
        if sheet.status != Status::Awake {
            continue;
        }
        let Some(mut guard) = sheet.guard.take() else { continue };
        let state = &mut guard.state;
        if std::mem::take(&mut state.replace) {
            state.own = Some(sheet.engine());
            sheet.change_engine(GUARDED, guard.tolerance);
        } else if state.pass(stage.dt) {
            (state.level, state.limiting) = (state.level.saturating_sub(1), false);
            if let Some(own) = state.own.take() {
                sheet.change_engine(own, guard.tolerance);
            }
            if !guard.state.acts() {
                touches.events.push((stage.time, EventKind::Recovered, None));
            }
        }
        sheet.guard = Some(guard);
    }
}

/// Record the energy of a monitored sheet of an explicit integrator before its step.
pub(crate) fn open(sheet: &mut Sheet) {
    if sheet.guard.is_some() && sheet.is_explicit() && sheet.status == Status::Awake {
        let level = sheet.level().total();
        if let Some(guard) = &mut sheet.guard {
            guard.before = if guard.state.limiting { level.max(guard.state.energy) } else { level };
        }
    }
}

/// Check the whole step, contact included, of a monitored sheet of an explicit integrator that has
/// touched something. `brought` is the energy that contact partners could transfer, J. Returns
/// whether the sheet was rolled back.
pub(crate) fn close(sheet: &mut Sheet, touches: &mut Touches, stage: &Stage, brought: f64) -> bool {
    if !sheet.is_explicit() || sheet.status != Status::Awake {
        return false;
    }
    let Some(mut guard) = sheet.guard.take() else { return false };
    let sound = guard.state.replace || guard.is_sound_at_end(sheet, stage, brought);
    if !sound {
        sheet.take_start_for_before();
        let seen = Alarm::of(sheet, stage.field.gravity, stage.dt);
        guard.state.alarmed();
        sheet.go_to_start();
        guard.state.energy = sheet.level().total();
        sheet.v.axes_mut().into_iter().flatten().for_each(|v| *v *= STEP.velocity_retention);
        sheet.restart_engine();
        match guard.next().or_else(|| guard.shorten_limited()) {
            Some(handled) => touches.tell(stage.time, EventKind::Contained, Alarm { handled, ..seen }),
            None => crate::islands::freeze(sheet, touches, stage.time, seen),
        }
    }
    sheet.guard = Some(guard);
    !sound
}

/// Advance a monitored sheet of an explicit integrator from `time` by up to `part` (s). Returns the
/// time taken, s; `None` when the sheet rests until the end of the step.
pub(crate) fn advance(sheet: &mut Sheet, touches: &mut Touches, stage: &Stage, time: f64, part: f64) -> Option<f64> {
    let mut guard = sheet.guard.take()?;
    let taken = guard.advance(sheet, touches, stage, time, part);
    sheet.guard = Some(guard);
    taken
}

impl Guard {
    fn advance(
        &mut self,
        sheet: &mut Sheet,
        touches: &mut Touches,
        stage: &Stage,
        time: f64,
        part: f64,
    ) -> Option<f64> {
        sheet.keep();
        let before = sheet.level();
        let mut alarm: Option<Alarm> = None;
        loop {
            let part = part.min(stage.dt / f64::from(1_u32 << self.state.level));
            if self.state.level > 0 && !sheet.pins.is_empty() {
                sheet.pins.lead(time, part, &sheet.x, &mut sheet.v);
            }
            let taken = sheet.advance_open(stage.field, time, part).taken;
            if self.hold(sheet, stage, taken) || self.is_sound(sheet, before, stage, taken) {
                sheet.end_flow();
                if let Some(alarm) = alarm {
                    touches.tell(time, EventKind::Contained, alarm);
                }
                return Some(taken);
            }
            let seen = Alarm::of(sheet, stage.field.gravity, taken);
            self.state.alarmed();
            self.state.energy = before.total();
            let Some(handled) = self.next() else {
                sheet.put_back();
                sheet.restart_engine();
                crate::islands::freeze(sheet, touches, time, seen);
                return None;
            };
            alarm = Some(Alarm { handled, ..alarm.unwrap_or(seen) });
            sheet.put_back();
            sheet.restart_engine();
            if self.state.replace {
                alarm.into_iter().for_each(|alarm| touches.tell(time, EventKind::Contained, alarm));
                return None;
            }
        }
    }

    /// Next recovery action of the policy; `None` when none is left.
    fn next(&mut self) -> Option<Handled> {
        let state = &mut self.state;
        match self.policy {
            WhenUnstable::ReduceStep { parts } => state.shorten(parts).map(|parts| Handled::StepReduced { parts }),
            WhenUnstable::Limit { strain } if !state.limiting => {
                state.limiting = true;
                Some(Handled::Limited { strain })
            }
            WhenUnstable::Implicit => {
                state.replace = true;
                Some(Handled::Implicit)
            }
            _ => None,
        }
    }

    /// Recovery action for contact of a sheet whose strain is limited already: a shorter substep.
    fn shorten_limited(&mut self) -> Option<Handled> {
        let limits = matches!(self.policy, WhenUnstable::Limit { .. });
        limits
            .then(|| self.state.shorten(SETTINGS.maximum_limited_substeps))
            .flatten()
            .map(|parts| Handled::StepReduced { parts })
    }

    /// Whether the energy gain of the whole step is acceptable.
    fn is_sound_at_end(&mut self, sheet: &Sheet, stage: &Stage, brought: f64) -> bool {
        if is_unstable(sheet) {
            return false;
        }
        let still = 0.5 * sheet.total_mass() * STEP.reference_speed * STEP.reference_speed;
        let work = sheet.work_since(sheet.start_positions(), &stage.field) + sheet.may_gain(&stage.field, stage.dt);
        let after = sheet.level().total();
        let gain = after - self.before - work - brought;
        self.state.surplus = (self.state.surplus + gain).max(0.0);
        // The comparisons treat NaN as unacceptable.
        gain <= SETTINGS.maximum_gain * (self.before + still)
            && self.state.surplus <= SETTINGS.maximum_accumulated_gain * (after + still)
    }

    /// Whether the energy gain of a substep of `taken` (s) from `before` is acceptable.
    fn is_sound(&mut self, sheet: &Sheet, before: Level, stage: &Stage, taken: f64) -> bool {
        if is_unstable(sheet) {
            return false;
        }
        let after = sheet.level();
        let still = 0.5 * sheet.total_mass() * STEP.reference_speed * STEP.reference_speed;
        let work = sheet.work_since(sheet.kept_positions(), &stage.field);
        let gain = after.total() - before.total() - work - sheet.may_gain(&stage.field, taken);
        self.state.surplus = (self.state.surplus + gain).max(0.0);
        // The comparisons treat NaN as unacceptable.
        gain <= SETTINGS.maximum_gain * (before.total() + still)
            && self.state.surplus <= SETTINGS.maximum_accumulated_gain * (after.total() + still)
    }

    /// Limit strain and energy of the sheet where the policy does so. Returns whether it does and
    /// the sheet is stable. The step of the integrator is scaled down until no strain changes by
    /// more than half the limit, and further while the elastic energy exceeds the available energy;
    /// the last trial moves the sheet as a rigid body.
    fn hold(&mut self, sheet: &mut Sheet, stage: &Stage, taken: f64) -> bool {
        let WhenUnstable::Limit { strain } = self.policy else { return false };
        let finite = sheet.v.max_squared().is_finite() && sheet.x.max_squared().is_finite();
        if !self.state.limiting || !finite {
            return false;
        }
        let revision = sheet.opening_revision();
        // Temperature and creep change rest lengths.
        if sheet.is_changed() || self.limit.as_ref().is_some_and(|l| l.0 != revision) {
            self.limit = None;
        }
        let (_, limit) = self.limit.get_or_insert_with(|| (revision, sheet.strain_limit()));
        let (start, end) = (&mut self.start, &mut self.end);
        start.clone_from(sheet.kept_positions());
        end.0.clone_from(&sheet.x);
        end.1.clone_from(&sheet.v);
        let own = sheet.stretch_to(limit, start, &end.0, taken);
        let mut part = if own > 0.5 * strain { 0.5 * strain / own } else { 1.0 };
        let mut eased = part < 1.0;
        for trial in 0..=SETTINGS.maximum_trials {
            if part < 1.0 {
                sheet.carry_part(start, (&end.0, &end.1), taken, part);
            }
            // The strain limit bends the sheet; the last trial leaves its shape unchanged.
            if part > 0.0 {
                eased |= limit.apply(strain, &mut sheet.x, &mut sheet.v, &sheet.inverse_mass, taken);
            }
            let (earned, slack) =
                (self.state.energy + sheet.work_since(start, &stage.field), sheet.may_gain(&stage.field, taken));
            let allowed = earned + slack;
            let most = allowed - sheet.level().elastic;
            if most >= 0.0 || trial == SETTINGS.maximum_trials {
                if sheet.slow_down(most.max(0.0)) {
                    sheet.slow_spin(most.max(0.0));
                    sheet.slow_drift(most.max(0.0), stage.field.gravity * taken);
                    eased = true;
                }
                // Pins may add the energy `slack` in each step, without accumulation.
                self.state.energy = sheet.level().total().min(earned.max(slack)).max(0.0);
                break;
            }
            (part, eased) = (if trial + 1 == SETTINGS.maximum_trials { 0.0 } else { 0.25 * part }, true);
        }
        if eased {
            self.state.calm = 0.0;
        }
        !is_unstable(sheet)
    }
}
