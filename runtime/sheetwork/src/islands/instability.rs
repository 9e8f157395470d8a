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

use crate::islands::StepContext;
use crate::islands::contact_log::ContactLog;
use crate::islands::event::{EventKind, InstabilityReport, RecoveryAction};
use crate::islands::settings::{InstabilitySettings, StepSettings};
use crate::islands::unstable::{freeze, is_unstable};
use crate::scene::WhenUnstable;
use crate::sheet::{
    KineticElasticEnergy, RECOVERY_INTEGRATOR, RecoveryPolicy, Sheet, Status, accelerations, creep, instability,
    node_contact, serialization, stage,
};

const SETTINGS: InstabilitySettings = StepSettings::DEFAULT.instability;
const STEP: StepSettings = StepSettings::DEFAULT;

/// Ease recovery policies and exchange integrators that are due, before the step of a world.
pub(crate) fn update_policies(sheets: &mut [Sheet], touches: &mut [ContactLog], context: &StepContext) {
    for (sheet, touches) in sheets.iter_mut().zip(touches) {
        if sheet.state.status != Status::Awake {
            continue;
        }
        let Some(mut guard) = sheet.recovery.take() else { continue };
        let state = &mut guard.state;
        if std::mem::take(&mut state.replaces_integrator) {
            state.replaced_integrator = Some(sheet.engine());
            sheet.change_engine(RECOVERY_INTEGRATOR, guard.tolerance);
        } else if state.advance_time(context.dt) {
            (state.bisections, state.limits_strain) = (state.bisections.saturating_sub(1), false);
            if let Some(own) = state.replaced_integrator.take() {
                sheet.change_engine(own, guard.tolerance);
            }
            if !guard.state.is_active() {
                touches.events.push((context.time, EventKind::Recovered, None));
            }
        }
        sheet.recovery = Some(guard);
    }
}

/// Record the energy of a monitored sheet of an explicit integrator before its step.
pub(crate) fn begin_energy_check(sheet: &mut Sheet) {
    if sheet.recovery.is_some() && node_contact::is_explicit(sheet) && sheet.state.status == Status::Awake {
        let level = instability::kinetic_elastic_energy(sheet).total();
        if let Some(guard) = &mut sheet.recovery {
            guard.energy_budget = if guard.state.limits_strain { level.max(guard.state.energy_budget) } else { level };
        }
    }
}

/// Check the whole step, contact included, of a monitored sheet of an explicit integrator that has
/// touched something. `brought` is the energy that contact partners could transfer, J. Returns
/// whether the sheet was rolled back.
pub(crate) fn finish_energy_check(
    sheet: &mut Sheet,
    touches: &mut ContactLog,
    context: &StepContext,
    brought: f64,
) -> bool {
    if !node_contact::is_explicit(sheet) || sheet.state.status != Status::Awake {
        return false;
    }
    let Some(mut guard) = sheet.recovery.take() else { return false };
    let sound = guard.state.replaces_integrator || guard.is_step_energy_acceptable(sheet, context, brought);
    if !sound {
        node_contact::set_integrator_start(sheet);
        let seen = InstabilityReport::new(sheet, context.field.gravity, context.dt);
        guard.state.record_detection();
        node_contact::restore_start(sheet);
        guard.state.energy_budget = instability::kinetic_elastic_energy(sheet).total();
        sheet.state.v.axes_mut().into_iter().flatten().for_each(|v| *v *= STEP.velocity_retention);
        stage::restart_engine(sheet);
        match guard.next_action().or_else(|| guard.shorten_limited_step()) {
            Some(handled) => {
                touches.report_instability(context.time, EventKind::Contained, InstabilityReport { handled, ..seen })
            }
            None => freeze(sheet, touches, context.time, seen),
        }
    }
    sheet.recovery = Some(guard);
    !sound
}

/// Advance a monitored sheet of an explicit integrator from `time` by up to `part` (s). Returns the
/// time taken, s; `None` when the sheet rests until the end of the step.
pub(crate) fn advance(
    sheet: &mut Sheet,
    touches: &mut ContactLog,
    context: &StepContext,
    time: f64,
    part: f64,
) -> Option<f64> {
    let mut guard = sheet.recovery.take()?;
    let taken = guard.advance(sheet, touches, context, time, part);
    sheet.recovery = Some(guard);
    taken
}

impl RecoveryPolicy {
    fn advance(
        &mut self,
        sheet: &mut Sheet,
        touches: &mut ContactLog,
        context: &StepContext,
        time: f64,
        part: f64,
    ) -> Option<f64> {
        stage::save_state(sheet);
        let before = instability::kinetic_elastic_energy(sheet);
        let mut alarm: Option<InstabilityReport> = None;
        loop {
            let part = part.min(context.dt / f64::from(1_u32 << self.state.bisections));
            if self.state.bisections > 0 && !sheet.pins.is_empty() {
                sheet.pins.prescribe_velocities(time, part, &sheet.state.x, &mut sheet.state.v);
            }
            let taken = accelerations::advance_uncommitted(sheet, context.field, time, part).elapsed;
            if self.limit_strain(sheet, context, taken) || self.is_energy_acceptable(sheet, before, context, taken) {
                creep::end_inelastic_step(sheet);
                if let Some(alarm) = alarm {
                    touches.report_instability(time, EventKind::Contained, alarm);
                }
                return Some(taken);
            }
            let seen = InstabilityReport::new(sheet, context.field.gravity, taken);
            self.state.record_detection();
            self.state.energy_budget = before.total();
            let Some(handled) = self.next_action() else {
                stage::restore_state(sheet);
                stage::restart_engine(sheet);
                freeze(sheet, touches, time, seen);
                return None;
            };
            alarm = Some(InstabilityReport { handled, ..alarm.unwrap_or(seen) });
            stage::restore_state(sheet);
            stage::restart_engine(sheet);
            if self.state.replaces_integrator {
                alarm.into_iter().for_each(|alarm| touches.report_instability(time, EventKind::Contained, alarm));
                return None;
            }
        }
    }

    /// Next recovery action of the policy; `None` when none is left.
    fn next_action(&mut self) -> Option<RecoveryAction> {
        let state = &mut self.state;
        match self.policy {
            WhenUnstable::ReduceStep { parts } => {
                state.bisect(parts).map(|parts| RecoveryAction::StepReduced { parts })
            }
            WhenUnstable::Limit { strain } if !state.limits_strain => {
                state.limits_strain = true;
                Some(RecoveryAction::Limited { strain })
            }
            WhenUnstable::Implicit => {
                state.replaces_integrator = true;
                Some(RecoveryAction::Implicit)
            }
            _ => None,
        }
    }

    /// Recovery action for contact of a sheet whose strain is limited already: a shorter substep.
    fn shorten_limited_step(&mut self) -> Option<RecoveryAction> {
        let limits = matches!(self.policy, WhenUnstable::Limit { .. });
        limits
            .then(|| self.state.bisect(SETTINGS.maximum_limited_substeps))
            .flatten()
            .map(|parts| RecoveryAction::StepReduced { parts })
    }

    /// Whether the energy gain of the whole step is acceptable.
    fn is_step_energy_acceptable(&mut self, sheet: &Sheet, context: &StepContext, brought: f64) -> bool {
        if is_unstable(sheet) {
            return false;
        }
        let still = 0.5 * sheet.total_mass() * STEP.reference_speed * STEP.reference_speed;
        let work = instability::work_of_loads(sheet, node_contact::start_positions(sheet), &context.field)
            + instability::energy_gain_tolerance(sheet, &context.field, context.dt);
        let after = instability::kinetic_elastic_energy(sheet).total();
        let gain = after - self.energy_budget - work - brought;
        self.state.energy_error = (self.state.energy_error + gain).max(0.0);
        // The comparisons treat NaN as unacceptable.
        gain <= SETTINGS.maximum_gain * (self.energy_budget + still)
            && self.state.energy_error <= SETTINGS.maximum_accumulated_gain * (after + still)
    }

    /// Whether the energy gain of a substep of `taken` (s) from `before` is acceptable.
    fn is_energy_acceptable(
        &mut self,
        sheet: &Sheet,
        before: KineticElasticEnergy,
        context: &StepContext,
        taken: f64,
    ) -> bool {
        if is_unstable(sheet) {
            return false;
        }
        let after = instability::kinetic_elastic_energy(sheet);
        let still = 0.5 * sheet.total_mass() * STEP.reference_speed * STEP.reference_speed;
        let work = instability::work_of_loads(sheet, stage::saved_positions(sheet), &context.field);
        let gain =
            after.total() - before.total() - work - instability::energy_gain_tolerance(sheet, &context.field, taken);
        self.state.energy_error = (self.state.energy_error + gain).max(0.0);
        // The comparisons treat NaN as unacceptable.
        gain <= SETTINGS.maximum_gain * (before.total() + still)
            && self.state.energy_error <= SETTINGS.maximum_accumulated_gain * (after.total() + still)
    }

    /// Limit strain and energy of the sheet where the policy does so. Returns whether it does and
    /// the sheet is stable. The step of the integrator is scaled down until no strain changes by
    /// more than half the limit, and further while the elastic energy exceeds the available energy;
    /// the last trial moves the sheet as a rigid body.
    fn limit_strain(&mut self, sheet: &mut Sheet, context: &StepContext, taken: f64) -> bool {
        let WhenUnstable::Limit { strain } = self.policy else { return false };
        let finite = sheet.state.v.max_squared().is_finite() && sheet.state.x.max_squared().is_finite();
        if !self.state.limits_strain || !finite {
            return false;
        }
        let revision = sheet.opening_revision();
        // Temperature and creep change rest lengths.
        if serialization::is_changed(sheet) || self.limit.as_ref().is_some_and(|l| l.0 != revision) {
            self.limit = None;
        }
        let (_, limit) = self.limit.get_or_insert_with(|| (revision, instability::strain_limit(sheet)));
        let (start, end) = (&mut self.start, &mut self.end);
        start.clone_from(stage::saved_positions(sheet));
        end.0.clone_from(&sheet.state.x);
        end.1.clone_from(&sheet.state.v);
        let own = instability::largest_strain_change(sheet, limit, start, &end.0, taken);
        let mut part = if own > 0.5 * strain { 0.5 * strain / own } else { 1.0 };
        let mut eased = part < 1.0;
        for trial in 0..=SETTINGS.maximum_trials {
            if part < 1.0 {
                instability::scale_back_step(sheet, start, (&end.0, &end.1), taken, part);
            }
            // The strain limit bends the sheet; the last trial leaves its shape unchanged.
            if part > 0.0 {
                eased |= limit.apply(strain, &mut sheet.state.x, &mut sheet.state.v, &sheet.inverse_mass, taken);
            }
            let (earned, slack) = (
                self.state.energy_budget + instability::work_of_loads(sheet, start, &context.field),
                instability::energy_gain_tolerance(sheet, &context.field, taken),
            );
            let allowed = earned + slack;
            let most = allowed - instability::kinetic_elastic_energy(sheet).elastic;
            if most >= 0.0 || trial == SETTINGS.maximum_trials {
                if instability::limit_kinetic_energy(sheet, most.max(0.0)) {
                    instability::limit_spin(sheet, most.max(0.0));
                    instability::limit_drift(sheet, most.max(0.0), context.field.gravity * taken);
                    eased = true;
                }
                // Pins may add the energy `slack` in each step, without accumulation.
                self.state.energy_budget =
                    instability::kinetic_elastic_energy(sheet).total().min(earned.max(slack)).max(0.0);
                break;
            }
            (part, eased) = (if trial + 1 == SETTINGS.maximum_trials { 0.0 } else { 0.25 * part }, true);
        }
        if eased {
            self.state.time_since_detection = 0.0;
        }
        !is_unstable(sheet)
    }
}
