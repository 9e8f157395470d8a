//! Rigid-motion fallback: without a converged contact solution, free sheets of an island move as
//! one rigid body with the bodies that they would penetrate, as in a perfectly plastic impact.
//!
//!   V = P/m,  ω = I⁻¹ L,  P = Σ m v,  L = Σ (x-c) × m v
//!
//! over nodes and bodies; c (m) is their centre of mass, m (kg) their mass, I (kg m²) their
//! inertia. The motion conserves P (N s) and L (N m s) and removes relative motion. It causes
//! neither strain nor new penetration among the objects that move together. Sheets that move
//! without bodies keep half of their internal velocities, which carry no momentum. Where the motion
//! would lead into a static or kinematic body, the fallback does not apply and the sheets are
//! frozen.

use glam::{DMat3, DVec3};

use crate::collision::constraint::ContactSide;
use crate::contact::IslandView;
use crate::contact::detected_contacts::DetectedContacts;
use crate::contact::gap::{StagePose, gap};
use crate::contact::outer_iteration::{ContactMargins, DetectionMode};
use crate::contact::workspace::ContactWorkspace;
use crate::islands::implicit_step::{IslandSolve, Substep};
use crate::islands::settings::{FallbackSettings, StepSettings};
use crate::rigid::{BodyState, MassProperties};
use crate::sheet::{Sheet, stage, stage_trace};

const SETTINGS: FallbackSettings = StepSettings::DEFAULT.fallback;
const STEP: StepSettings = StepSettings::DEFAULT;

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

impl IslandSolve<'_, '_, '_> {
    /// Move the sheets rigidly from the start to the end of `substep`, together with the bodies
    /// that they would penetrate. Returns `false`, without motion, when a node is fixed or a static
    /// or kinematic body is near: a sheet that lies on such a body must come to rest.
    pub fn move_rigidly(&mut self, substep: &Substep) -> bool {
        if !is_free(self.view, self.workspace) {
            return false;
        }
        self.view.for_each_sheet(stage::restore_state);
        let Some(own) = rigid_equivalent_of_island(self.view) else { return false };
        self.workspace.swap_saved_bodies(&mut self.view.solver_bodies);
        self.detection.begin_stage(self.view, substep.done, substep.done + substep.dt);
        let Some((start, end)) = self.predict_rigid_motion(substep, &own) else {
            self.workspace.swap_saved_bodies(&mut self.view.solver_bodies);
            return false;
        };
        let kept = if self.progress.moves_rigidly.contains(&true) { 0.0 } else { STEP.velocity_retention };
        self.view.for_each_sheet(|sheet| {
            for i in 0..sheet.node_count() {
                let (x, v) = (sheet.state.x.get(i), sheet.state.v.get(i));
                let there = end.world_point(start.local_point(x));
                let within = end.rotation() * (v - own.velocity_at(x));
                sheet.state.x.set(i, there);
                sheet.state.v.set(i, end.velocity_at(there) + within * kept);
            }
            stage::restart_engine(sheet);
            stage_trace::update_trace(sheet, |trace, x| trace.ends.push((substep.done + substep.dt, x.clone())));
        });
        self.detection.end_stage(self.view);
        true
    }

    /// Rigid body of the sheets, `own`, and the bodies that they would penetrate, at the start and
    /// at the end of `substep`. Writes the node positions to the stages of the sheets and the
    /// motions to the solver bodies. `None` when a static or kinematic body would be penetrated.
    fn predict_rigid_motion(&mut self, substep: &Substep, own: &BodyState) -> Option<(BodyState, BodyState)> {
        let (island, along) = (&mut *self.view, &mut self.progress.moves_rigidly);
        along.clear();
        along.resize(island.solver_bodies.len(), false);
        for _ in 0..=island.solver_bodies.len() {
            let mut all = RigidSum::about(own.centre());
            all.add_body(own);
            let moved = island.solver_bodies.iter().zip(along.iter()).filter(|(_, along)| **along);
            moved.for_each(|(body, _)| all.add_body(&body.start));
            let start = all.body();
            let end = start.free_flight(substep.dt, substep.field.gravity);
            let turn = end.rotation().to_scaled_axis();
            for (body, _) in island.solver_bodies.iter_mut().zip(along.iter()).filter(|(_, along)| **along) {
                let centre = end.world_point(start.local_point(body.start.centre()));
                let moved = body.start.displaced(centre - body.start.centre(), turn);
                body.begin(moved.with_velocity(end.velocity_at(centre), end.spin()));
            }
            island.for_each_sheet(|sheet| {
                for i in 0..sheet.node_count() {
                    sheet.work.stage.free_positions.set(i, end.world_point(start.local_point(sheet.state.x.get(i))));
                }
            });
            let found = &mut self.workspace.rechecked;
            self.detection.detect_contacts(island, DetectionMode::FromStart, ContactMargins::resting(island), found);
            if !add_met_bodies(island, found, along)? {
                return Some((start, end));
            }
        }
        None
    }
}

/// Mark in `along` the bodies that the rigid body would penetrate by the contacts `seen`. Returns
/// whether new ones were marked; `None` when one of them is static or kinematic.
fn add_met_bodies(island: &IslandView, seen: &DetectedContacts, along: &mut [bool]) -> Option<bool> {
    let mut more = false;
    let rounding = SETTINGS.penetration_rounding * island.half_thickness();
    for (i, contact) in seen.contacts.iter().enumerate() {
        let meets =
            || gap(island, contact, StagePose::Free) < gap(island, contact, StagePose::Start).min(0.0) - rounding;
        let goes = |side: &ContactSide| match side {
            ContactSide::Body { body, .. } => along[*body as usize],
            ContactSide::Sheet { .. } => true,
        };
        if goes(&contact.a) == goes(&contact.b) || i < seen.first_attachment && !meets() {
            continue;
        }
        for side in [contact.a, contact.b] {
            if let ContactSide::Body { body, .. } = side {
                if !island.solver_bodies[body as usize].is_dynamic() {
                    return None;
                }
                more |= !std::mem::replace(&mut along[body as usize], true);
            }
        }
    }
    Some(more)
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
