//! Rigid motion with the momentum of sheets and bodies.
//!
//!   V = P/m,  ω = I⁻¹ L,  P = Σ m v,  L = Σ (x-c) × m v
//!
//! over nodes and bodies; c (m) is their centre of mass, m (kg) their mass, I (kg m²) their
//! inertia. A fallback that ends before it converges lags behind the motion of free sheets: rigid
//! motions added to the velocities restore P (N s) and L (N m s).

use glam::{DMat3, DVec3};

use crate::collision::constraint::ContactSide;
use crate::contact::IslandView;
use crate::contact::solver_body::SolverBody;
use crate::contact::workspace::ContactWorkspace;
use crate::islands::energy_budget::EnergyBudget;
use crate::islands::settings::StepSettings;
use crate::rigid::{BodyState, MassProperties};
use crate::sheet::{Field, Sheet};

const SETTINGS: StepSettings = StepSettings::DEFAULT;

/// Sums over nodes and bodies that move as one rigid body, about `from` (m).
struct RigidSum {
    from: DVec3,
    mass: f64,
    first: DVec3,
    momentum: DVec3,
    moment: DVec3,
    second: DMat3,
    inertia: DMat3,
}

impl RigidSum {
    fn about(from: DVec3) -> Self {
        let (none, zero) = (DVec3::ZERO, DMat3::ZERO);
        Self { from, mass: 0.0, first: none, momentum: none, moment: none, second: zero, inertia: zero }
    }

    fn add(&mut self, mass: f64, place: DVec3, velocity: DVec3) {
        let (arm, momentum) = (place - self.from, velocity * mass);
        self.mass += mass;
        self.first += arm * mass;
        self.momentum += momentum;
        self.moment += arm.cross(momentum);
        self.second += DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z) * mass;
    }

    fn add_body(&mut self, body: &BodyState) {
        self.add(body.mass(), body.centre(), body.velocity());
        self.moment += body.angular_momentum(body.centre());
        self.inertia += body.inertia();
    }

    /// The equivalent rigid body, in world axes.
    fn body(&self) -> BodyState {
        let arm = self.first / self.mass;
        let second = self.second - DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z) * self.mass;
        let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
        let inertia = self.inertia + DMat3::from_diagonal(DVec3::splat(trace)) - second;
        let spread = MassProperties::from_inertia(self.mass, inertia);
        let still =
            BodyState::new(spread, self.from + arm, glam::DQuat::IDENTITY, self.momentum / self.mass, DVec3::ZERO);
        still.with_impulse(DVec3::ZERO, self.moment - arm.cross(self.momentum))
    }
}

/// Rigid body with the momentum and angular momentum of `sheet`; `None` when the sheet has fixed or
/// prescribed nodes.
pub(crate) fn rigid_equivalent(sheet: &Sheet) -> Option<BodyState> {
    rigid_equivalent_of_sheets([sheet].into_iter())
}

/// Rigid body with the momentum and angular momentum of all sheets of `island`; `None` when one of
/// them has fixed or prescribed nodes.
pub(crate) fn rigid_equivalent_of_island(island: &IslandView) -> Option<BodyState> {
    rigid_equivalent_of_sheets(island.sheets.iter())
}

fn rigid_equivalent_of_sheets<'a>(sheets: impl Iterator<Item = &'a Sheet> + Clone) -> Option<BodyState> {
    fn there(sheet: &Sheet) -> impl Iterator<Item = usize> {
        (0..sheet.node_count()).filter(|i| !sheet.is_detached(*i))
    }
    if sheets.clone().any(|sheet| sheet.pins.fixes_nodes() || there(sheet).any(|i| sheet.is_held(i))) {
        return None;
    }
    let first = sheets.clone().find_map(|sheet| there(sheet).next().map(|i| sheet.state.x.get(i)))?;
    let mut whole = RigidSum::about(first);
    for sheet in sheets {
        there(sheet).for_each(|i| whole.add(sheet.model.mass[i], sheet.state.x.get(i), sheet.state.v.get(i)));
    }
    Some(whole.body())
}

/// Whether all contacts near the sheets in this stage are with dynamic bodies or sheets.
pub(crate) fn is_free(island: &IslandView, workspace: &ContactWorkspace) -> bool {
    let gives = |side: &ContactSide| match side {
        ContactSide::Body { body, .. } => island.solver_bodies[*body as usize].is_dynamic(),
        ContactSide::Sheet { .. } => true,
    };
    workspace.detected.contacts.iter().all(|c| gives(&c.a) && gives(&c.b))
}

/// Momentum of the sheets and dynamic bodies of `island`, as their equivalent rigid body; `None`
/// where fixed or prescribed nodes, loads or air change it.
pub(crate) fn momentum_of_island(island: &IslandView, field: Field) -> Option<BodyState> {
    let is_changed = |sheet: &Sheet| sheet.is_loaded() || sheet.parameters.drag.is_active(&field);
    if field.air > 0.0 || island.sheets.iter().any(is_changed) {
        return None;
    }
    let own = rigid_equivalent_of_island(island)?;
    let mut all = RigidSum::about(own.centre());
    all.add_body(&own);
    island.solver_bodies.iter().filter(|body| body.is_dynamic()).for_each(|body| all.add_body(&body.start));
    Some(all.body())
}

/// Add rigid motions to the velocities of the sheets and dynamic bodies of `island`, after which
/// together they have the momentum that `before` has after a time `dt` (s) of free flight, or the
/// part of them that adds a kinetic energy of `most` (J).
pub(crate) fn restore_momentum(island: &mut IslandView, before: &BodyState, (field, dt): (Field, f64), most: f64) {
    let Some(now) = momentum_of_island(island, field) else { return };
    let lost = before.momentum() + field.gravity * (before.mass() * dt) - now.momentum();
    let turned = before.angular_momentum(before.centre()) - now.angular_momentum(now.centre());
    // Each object turns about its own centre, which keeps its momentum.
    let bodies = island.solver_bodies.iter().filter(|body| body.is_dynamic()).map(|body| body.start);
    let all = island.sheets.iter().filter_map(rigid_equivalent).chain(bodies);
    let (mut inertia, mut own) = (DMat3::ZERO, DVec3::ZERO);
    for object in all {
        inertia += object.inertia();
        own += object.angular_momentum(object.centre());
    }
    let spread = MassProperties::from_inertia(now.mass(), inertia);
    let still = BodyState::new(spread, now.centre(), glam::DQuat::IDENTITY, DVec3::ZERO, DVec3::ZERO);
    let full = still.with_impulse(lost, turned);
    // Kinetic energy that a part α of the motion adds: a α + b α².
    let (a, b) = (now.momentum().dot(full.velocity()) + own.dot(full.spin()), full.kinetic_energy());
    let part = if a + b <= most { 1.0 } else { (((a * a + 4.0 * b * most).sqrt() - a) / (2.0 * b)).clamp(0.0, 1.0) };
    let (velocity, spin) = (full.velocity() * part, full.spin() * part);
    island.for_each_sheet(|sheet| {
        let Some(own) = rigid_equivalent(sheet) else { return };
        for i in 0..sheet.node_count() {
            sheet.state.v.add(i, velocity + spin.cross(sheet.state.x.get(i) - own.centre()));
        }
    });
    for body in island.solver_bodies.iter_mut().filter(|body| body.is_dynamic()) {
        body.start = body.start.with_velocity(body.start.velocity() + velocity, body.start.spin() + spin);
    }
}

/// Momentum and energy of an island that rotates freely, at the start of a step: an implicit
/// integrator loses angular momentum where it rotates far in a step.
pub(crate) struct FreeRotation {
    momentum: BodyState,
    /// Kinetic, elastic and potential energy, J.
    energy: f64,
}

impl FreeRotation {
    /// That of `island` before a step of `dt` (s); `None` for a slow rotation, or where other than
    /// dynamic bodies are near.
    pub fn of(island: &IslandView, field: Field, dt: f64) -> Option<Self> {
        if !island.solver_bodies.iter().all(SolverBody::is_dynamic) {
            return None;
        }
        let momentum = momentum_of_island(island, field)?;
        let rotates = momentum.spin().length() * dt > SETTINGS.free_rotation;
        rotates.then(|| Self { momentum, energy: EnergyBudget::of(island, &field).total() })
    }

    /// Number of bisections of a step of `dt` (s) after which the island rotates little in a part.
    pub fn bisections(&self, dt: f64) -> u32 {
        let rotation = self.momentum.spin().length() * dt / SETTINGS.rotation_of_part;
        rotation.log2().ceil().clamp(0.0, SETTINGS.maximum_rotation_bisections) as u32
    }

    /// Restore the momentum after a step of `dt` (s), as far as the energy does not rise.
    pub fn restore(&self, island: &mut IslandView, field: Field, dt: f64) {
        let lost = self.energy - EnergyBudget::of(island, &field).total();
        restore_momentum(island, &self.momentum, (field, dt), lost.max(0.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rigid_equivalent_conserves_momentum_and_loses_energy() {
        let spread = MassProperties::from_inertia(0.3, DMat3::from_diagonal(DVec3::new(1.0, 2.0, 2.5)) * 1e-4);
        let turned = glam::DQuat::from_rotation_x(0.8);
        let body = BodyState::new(spread, DVec3::new(0.1, 0.2, 0.0), turned, DVec3::NEG_Y, DVec3::new(3.0, 0.0, 9.0));
        let mut all = RigidSum::about(DVec3::new(5.0, 0.0, 1.0));
        all.add_body(&body);
        let (mut momentum, mut moment, mut energy) =
            (body.momentum(), body.angular_momentum(DVec3::ZERO), body.kinetic_energy());
        for i in 0..20 {
            let (t, mass) = (f64::from(i), 0.01 + 1e-3 * f64::from(i));
            let (x, v) = (DVec3::new(t.sin(), t.cos(), 0.1 * t), DVec3::new((2.0 * t).cos(), 3.0, t.sin()));
            all.add(mass, x, v);
            momentum += v * mass;
            moment += x.cross(v) * mass;
            energy += 0.5 * mass * v.length_squared();
        }
        for whole in [all.body(), all.body().free_flight(0.3, DVec3::ZERO)] {
            assert!(whole.momentum().distance(momentum) < 1e-12 * momentum.length());
            assert!(whole.angular_momentum(DVec3::ZERO).distance(moment) < 1e-9 * moment.length());
            assert!(whole.kinetic_energy() < energy);
        }
    }

    #[test]
    fn collinear_nodes_have_a_rigid_equivalent() {
        let mut line = RigidSum::about(DVec3::ZERO);
        (0..5).for_each(|i| line.add(0.1, DVec3::X * f64::from(i), DVec3::Y * f64::from(i)));
        let body = line.body();
        assert!(body.velocity().distance(DVec3::Y * 2.0) < 1e-12 && body.spin().distance(DVec3::Z) < 1e-9, "{body:?}");
    }
}
