//! Energy budget of an implicit step, and the freeze fallback.
//!
//! Contact adds no energy, nor do air at rest and fixed pins; with those alone
//!
//!   T + V ≤ T₀ + V₀,
//!
//! T kinetic energy, V elastic and potential energy, all in J. A linear solve over a large motion
//! can break the inequality: after a hard impact nodes move along the tangent instead of the arc.
//! Such a step is bisected; at the maximum bisection depth velocities are scaled to remove the
//! excess. Where the step still ends within a body, the sheet is frozen at reduced speed for the
//! step.

use crate::contact::Group;
use crate::contact::settings::ContactSettings;
use crate::contact::solver_body::Mover;
use crate::islands::settings::{EnergyBudgetSettings, StepSettings};
use crate::sheet::Field;

use crate::islands::implicit_step::Part;
use crate::islands::rigid_motion::whole_group;

const SETTINGS: EnergyBudgetSettings = StepSettings::DEFAULT.energy;
const STEP: StepSettings = StepSettings::DEFAULT;

/// Result of the energy check of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Stands,
    /// The step is to be bisected.
    Again,
    /// The fallback is to be applied.
    Fails,
    /// The sheet is unstable; later substeps are skipped.
    Runaway,
}

/// Energies of an island, J.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Energies {
    /// Kinetic energy of the sheets, of the dynamic bodies; elastic and potential energy.
    sheets: f64,
    bodies: f64,
    strain: f64,
    gravity: f64,
    /// Reference energy of nearly resting sheets.
    still: f64,
    /// Potential energy that depenetration may add.
    lifts: f64,
}

impl Energies {
    fn of(group: &Group, field: &Field) -> Self {
        let mut all = Self::default();
        for i in group.members {
            let energy = group.sheets[*i as usize].energy(field.gravity);
            all.sheets += energy.kinetic;
            all.strain += energy.elastic;
            all.gravity += energy.gravity;
            let mass: f64 = group.sheets[*i as usize].mass.iter().sum();
            let lift = if group.members.len() > 1 { SETTINGS.lift_several } else { SETTINGS.lift_single };
            all.still += mass * (0.5 * STEP.reference_speed * STEP.reference_speed + lift * field.gravity.length());
        }
        if group.lift > 0.0 {
            all.still += weight(group, field) * group.lift;
        }
        for mover in group.movers.iter().filter(|m| m.gives()) {
            all.bodies += mover.start.kinetic_energy();
            all.gravity += mover.start.gravity_energy(field.gravity);
        }
        all
    }

    fn total(&self) -> f64 {
        self.sheets + self.bodies + self.strain + self.gravity
    }

    /// Energies at the start of `part`; `None` when other loads than contact may do work in it.
    pub fn before(group: &Group, part: &Part) -> Option<Self> {
        let led = group.movers.iter().any(|m| !m.gives() && m.start.moves());
        let moved = |i: &u32| {
            let sheet = &group.sheets[*i as usize];
            sheet.is_pulled() || sheet.pins.moving(part.time, part.time + part.dt)
        };
        let blown = part.field.wind != glam::DVec3::ZERO;
        (!led && !blown && !group.members.iter().any(moved)).then(|| Self::of(group, &part.field))
    }

    /// Add the work of depenetration: of a lone sheet and its load from an initial penetration of
    /// `depth` (m), and of bodies by `parted` (m). Depenetration is complete within one step,
    /// however short. [`EnergyBudgetSettings::lift_several`] covers several sheets.
    pub fn lift_out(&mut self, group: &Group, field: &Field, (depth, parted): (f64, f64)) {
        let is_initial = depth > ContactSettings::DEFAULT.residual_penetration;
        let depth = if is_initial { depth.min(SETTINGS.maximum_initial_penetration) } else { 0.0 };
        if depth + parted > 0.0 && group.members.len() == 1 {
            self.lifts += weight(group, field) * (depth + parted);
        }
    }

    /// Compare with the present energies. With `last`, the step is scaled to fit the budget or
    /// fails. Without contact (`met`) a slight gain belongs to the integrator and is accepted. For
    /// `loose` sheets only the velocities relative to the rigid motion are scaled, which conserves
    /// momentum. Near rest the gain is removed from the kinetic energy, and the remainder is `owed`
    /// (J) by the following steps.
    pub fn judge(
        &self,
        group: &mut Group,
        field: &Field,
        (last, met, loose): (bool, bool, bool),
        owed: &mut f64,
    ) -> Verdict {
        let now = Self::of(group, field);
        let free = self.sheets + self.bodies + self.strain + self.still;
        let gain = now.total() - self.total() - self.lifts;
        if met && gain <= SETTINGS.bisection_gain * free && is_lingering(group, loose) {
            *owed = (*owed + gain + self.lifts).max(0.0);
            *owed -= take(group, *owed, now.sheets + now.bodies);
            return Verdict::Stands;
        }
        *owed = 0.0;
        if gain <= if met { SETTINGS.gain_tolerance } else { SETTINGS.bisection_gain } * free {
            return Verdict::Stands;
        }
        if gain > SETTINGS.bisection_gain * free && !last {
            return Verdict::Again;
        }
        if group.members.len() == 1 && (gain.is_nan() || gain > SETTINGS.divergence_gain * free) {
            return Verdict::Runaway;
        }
        if let Some(own) = loose.then(|| whole_group(group)).flatten() {
            let within = now.sheets - own.kinetic_energy();
            if gain > within {
                return if last { Verdict::Fails } else { Verdict::Again };
            }
            let part = (1.0 - gain / within).sqrt();
            group.each(|sheet| {
                for i in 0..sheet.masses() {
                    let along = own.velocity_at(sheet.x.get(i));
                    sheet.v.set(i, along + (sheet.v.get(i) - along) * part);
                }
            });
        } else if gain <= now.sheets {
            let part = (1.0 - gain / now.sheets).sqrt();
            group.each(|sheet| sheet.v.axes_mut().into_iter().flatten().for_each(|v| *v *= part));
        } else if last {
            return Verdict::Fails;
        }
        Verdict::Stands
    }
}

/// Whether all objects in `group` are slower than [`EnergyBudgetSettings::resting_speed`], one of
/// them is a dynamic body, and the sheets are held: in free sheets only relative motion may be
/// reduced.
fn is_lingering(group: &Group, loose: bool) -> bool {
    let gives = group.movers.iter().any(|m| m.gives());
    let slow = |m: &Mover| !m.gives() || m.start.velocity().length() < SETTINGS.resting_speed;
    gives
        && group.movers.iter().all(slow)
        && group.members.iter().all(|i| group.sheets[*i as usize].max_speed() < SETTINGS.resting_speed)
        && !(loose && whole_group(group).is_some())
}

/// Remove up to `owed` (J) from the kinetic energy `motion` (J) of all moving objects. Returns the
/// energy removed, J.
fn take(group: &mut Group, owed: f64, motion: f64) -> f64 {
    let taken = owed.min(motion);
    if taken > 0.0 {
        let part = (1.0 - taken / motion).sqrt();
        group.each(|sheet| sheet.v.axes_mut().into_iter().flatten().for_each(|v| *v *= part));
        for mover in group.movers.iter_mut().filter(|m| m.gives()) {
            mover.start = mover.start.with_velocity(mover.start.velocity() * part, mover.start.spin() * part);
        }
    }
    taken
}

/// Weight of the sheets and dynamic bodies of an island, N.
fn weight(group: &Group, field: &Field) -> f64 {
    let sheets: f64 = group.members.iter().flat_map(|i| &group.sheets[*i as usize].mass).sum();
    let bodies: f64 = group.movers.iter().filter(|m| m.gives()).map(|m| m.free.mass()).sum();
    (sheets + bodies) * field.gravity.length()
}

/// Freeze the sheets at the start of the substep; dynamic bodies keep their motion.
pub(crate) fn stay(group: &mut Group) {
    group.each(|sheet| {
        sheet.put_back();
        sheet.v.axes_mut().into_iter().flatten().for_each(|v| *v *= STEP.velocity_retention);
        sheet.restart_engine();
    });
}
