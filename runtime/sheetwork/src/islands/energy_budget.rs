//! Energy budget of an implicit step.
//!
//! Contact adds no energy, nor do air at rest and fixed pins; with those alone
//!
//!   T + V ≤ T₀ + V₀,
//!
//! T kinetic energy, V elastic and potential energy, all in J. A linear solve over a large motion
//! can break the inequality: after a hard impact nodes move along the tangent instead of the arc.
//! Such a step is bisected; at the maximum bisection depth velocities are scaled to remove the
//! excess, or the fallback replaces it.

use crate::contact::IslandView;
use crate::contact::settings::ContactSettings;
use crate::contact::solver_body::SolverBody;
use crate::islands::settings::{EnergyBudgetSettings, StepSettings};
use crate::sheet::{Field, Sheet, node_contact};

use crate::islands::implicit_step::Substep;
use crate::islands::rigid_motion::rigid_equivalent_of_island;

const SETTINGS: EnergyBudgetSettings = StepSettings::DEFAULT.energy;
const STEP: StepSettings = StepSettings::DEFAULT;

/// Result of the energy check of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EnergyVerdict {
    Accept,
    /// The step is to be bisected.
    Bisect,
    /// The fallback is to be applied.
    Fallback,
}

/// Energies of an island, J.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EnergyBudget {
    /// Kinetic energy of the sheets, of the dynamic bodies; elastic and potential energy.
    sheets: f64,
    bodies: f64,
    strain: f64,
    gravity: f64,
    /// Reference energy of nearly resting sheets.
    still: f64,
    /// Potential energy that depenetration may add.
    depenetration_work: f64,
}

impl EnergyBudget {
    pub fn of(island: &IslandView, field: &Field) -> Self {
        let mut all = Self::default();
        for sheet in island.sheets.iter() {
            let energy = sheet.energy(field.gravity);
            all.sheets += energy.kinetic;
            all.strain += energy.elastic;
            all.gravity += energy.gravity;
            let mass: f64 = sheet.model.mass.iter().sum();
            let lift = if island.sheets.len() > 1 { SETTINGS.lift_several } else { SETTINGS.lift_single };
            let lift = lift * node_contact::half_thickness(sheet);
            all.still += mass * (0.5 * STEP.reference_speed * STEP.reference_speed + lift * field.gravity.length());
        }
        if island.body_penetration > 0.0 {
            all.still += island_weight(island, field) * island.body_penetration;
        }
        for solver_body in island.solver_bodies.iter().filter(|m| m.is_dynamic()) {
            all.bodies += solver_body.start.kinetic_energy();
            all.gravity += solver_body.start.gravity_energy(field.gravity);
        }
        all
    }

    pub fn total(&self) -> f64 {
        self.sheets + self.bodies + self.strain + self.gravity
    }

    /// Energies at the start of `part`; `None` when other loads than contact may do work in it.
    pub fn before(island: &IslandView, part: &Substep) -> Option<Self> {
        let led = island.solver_bodies.iter().any(|m| !m.is_dynamic() && m.start.is_moving());
        let moved = |sheet: &Sheet| sheet.is_loaded() || sheet.pins.moves_between(part.time, part.time + part.dt);
        let blown = part.field.wind != glam::DVec3::ZERO;
        (!led && !blown && !island.sheets.iter().any(moved)).then(|| Self::of(island, &part.field))
    }

    /// Add the work of depenetration: of a lone sheet and its load from an initial penetration of
    /// `depth` (m), and of bodies by `parted` (m). Depenetration is complete within one step,
    /// however short. [`EnergyBudgetSettings::lift_several`] covers several sheets.
    pub fn add_depenetration_work(&mut self, island: &IslandView, field: &Field, (depth, parted): (f64, f64)) {
        let half = island.half_thickness();
        let is_initial = depth > ContactSettings::DEFAULT.residual_penetration * half;
        let depth = if is_initial { depth.min(SETTINGS.maximum_initial_penetration * half) } else { 0.0 };
        if depth + parted > 0.0 && island.sheets.len() == 1 {
            self.depenetration_work += island_weight(island, field) * (depth + parted);
        }
    }

    /// Remove what the present energies exceed these from the motion of all objects, as far as
    /// there is any.
    pub fn remove_gain(&self, island: &mut IslandView, field: &Field) {
        let now = Self::of(island, field);
        let gain = now.total() - self.total() - self.depenetration_work;
        remove_kinetic_energy(island, gain, now.sheets + now.bodies);
    }

    /// Compare with the present energies. With `last`, the step is scaled to fit the budget or
    /// fails. Without contact (`met`) a slight gain belongs to the integrator and is accepted. For
    /// `has_no_fixed_body` sheets only the velocities relative to the rigid motion are scaled,
    /// which conserves momentum. Near rest the gain is removed from the kinetic energy, and the
    /// remainder is `owed` (J) by the following steps.
    pub fn check_and_scale(
        &self,
        island: &mut IslandView,
        field: &Field,
        (last, met, has_no_fixed_body): (bool, bool, bool),
        owed: &mut f64,
    ) -> EnergyVerdict {
        let now = Self::of(island, field);
        let free = self.sheets + self.bodies + self.strain + self.still;
        let gain = now.total() - self.total() - self.depenetration_work;
        if met && gain <= SETTINGS.bisection_gain * free && is_nearly_resting(island, has_no_fixed_body) {
            *owed = (*owed + gain + self.depenetration_work).max(0.0);
            *owed -= remove_kinetic_energy(island, *owed, now.sheets + now.bodies);
            return EnergyVerdict::Accept;
        }
        *owed = 0.0;
        if gain <= if met { SETTINGS.gain_tolerance } else { SETTINGS.bisection_gain } * free {
            return EnergyVerdict::Accept;
        }
        if gain > SETTINGS.bisection_gain * free && !last {
            return EnergyVerdict::Bisect;
        }
        if gain.is_nan() {
            return EnergyVerdict::Fallback;
        }
        if let Some(own) = has_no_fixed_body.then(|| rigid_equivalent_of_island(island)).flatten() {
            let within = now.sheets - own.kinetic_energy();
            if gain > within {
                return if last { EnergyVerdict::Fallback } else { EnergyVerdict::Bisect };
            }
            let part = (1.0 - gain / within).sqrt();
            island.for_each_sheet(|sheet| {
                for i in 0..sheet.node_count() {
                    let along = own.velocity_at(sheet.state.x.get(i));
                    sheet.state.v.set(i, along + (sheet.state.v.get(i) - along) * part);
                }
            });
        } else if gain <= now.sheets {
            let part = (1.0 - gain / now.sheets).sqrt();
            island.for_each_sheet(|sheet| sheet.state.v.axes_mut().into_iter().flatten().for_each(|v| *v *= part));
        } else if last {
            return EnergyVerdict::Fallback;
        }
        EnergyVerdict::Accept
    }
}

/// Whether all objects in `island` are slower than [`EnergyBudgetSettings::resting_speed`], one of
/// them is a dynamic body, and the sheets are held: in free sheets only relative motion may be
/// reduced.
fn is_nearly_resting(island: &IslandView, has_no_fixed_body: bool) -> bool {
    let gives = island.solver_bodies.iter().any(|m| m.is_dynamic());
    let slow = |m: &SolverBody| !m.is_dynamic() || m.start.velocity().length() < SETTINGS.resting_speed;
    gives
        && island.solver_bodies.iter().all(slow)
        && island.sheets.iter().all(|sheet| sheet.max_speed() < SETTINGS.resting_speed)
        && !(has_no_fixed_body && rigid_equivalent_of_island(island).is_some())
}

/// Remove up to `owed` (J) from the kinetic energy `motion` (J) of all moving objects. Returns the
/// energy removed, J.
fn remove_kinetic_energy(island: &mut IslandView, owed: f64, motion: f64) -> f64 {
    let taken = owed.min(motion);
    if taken > 0.0 {
        let part = (1.0 - taken / motion).sqrt();
        island.for_each_sheet(|sheet| sheet.state.v.axes_mut().into_iter().flatten().for_each(|v| *v *= part));
        for solver_body in island.solver_bodies.iter_mut().filter(|m| m.is_dynamic()) {
            solver_body.start =
                solver_body.start.with_velocity(solver_body.start.velocity() * part, solver_body.start.spin() * part);
        }
    }
    taken
}

/// Weight of the sheets and dynamic bodies of an island, N.
fn island_weight(island: &IslandView, field: &Field) -> f64 {
    let sheets: f64 = island.sheets.iter().flat_map(|sheet| &sheet.model.mass).sum();
    let bodies: f64 = island.solver_bodies.iter().filter(|m| m.is_dynamic()).map(|m| m.free.mass()).sum();
    (sheets + bodies) * field.gravity.length()
}
