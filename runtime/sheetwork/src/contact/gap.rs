//! Kinematics of a contact in a stage: positions and velocities of its two sides, and their change
//! by contact.
//!
//! A side is a point of a sheet (a weighted mean of nodes) or a point fixed in the frame of a body.
//! The gap along the normal n is
//!
//!   g = n · (x_a - x_b) - contact offset.
//!
//! Lengths in m, speeds in m/s.

use glam::DVec3;

use crate::collision::constraint::{ContactConstraint, ContactSide, SheetPoint};
use crate::contact::IslandView;
use crate::contact::solver_body::SolverBody;
use crate::integrators::implicit::staged::ContactJump;
use crate::math::Vectors;

/// Gaps of all contacts of an outer iteration, m.
#[derive(Default)]
pub(crate) struct ContactGaps {
    /// Gap after the free motion.
    pub free: Vec<f64>,
    /// Gap with the forces of the last solve.
    pub now: Vec<f64>,
    /// Gap at the start of the stage, along the present normal.
    pub start: Vec<f64>,
    /// Position of side a after the free motion.
    pub positions_a: Vec<DVec3>,
}

impl ContactGaps {
    /// Measure the gaps without contact forces.
    pub fn measure(&mut self, contacts: &[ContactConstraint], island: &IslandView) {
        self.free.clear();
        self.start.clear();
        self.positions_a.clear();
        for contact in contacts {
            let (a, b) = (position(island, &contact.a, StagePose::Free), position(island, &contact.b, StagePose::Free));
            self.free.push(contact.normal.dot(a - b) - contact.offset);
            self.start.push(gap(island, contact, StagePose::Start));
            self.positions_a.push(a);
        }
        self.now.clone_from(&self.free);
    }

    /// Update `now` with the displacement by contact.
    pub fn update(&mut self, contacts: &[ContactConstraint], island: &IslandView) {
        for (i, contact) in contacts.iter().enumerate() {
            let by = contact_displacement(island, &contact.a) - contact_displacement(island, &contact.b);
            self.now[i] = self.free[i] + contact.normal.dot(by);
        }
    }

    /// Fraction of the stage before contact `i` closes, 0 to 1.
    pub fn open_fraction(&self, i: usize) -> f64 {
        let (start, end) = (self.start[i], self.free[i]);
        if start > 0.0 && start > end { (start / (start - end)).clamp(0.0, 1.0) } else { 0.0 }
    }
}

/// Instant of the stage: its start, or its end after the free motion.
#[derive(Clone, Copy)]
pub(crate) enum StagePose {
    /// At the start of the stage.
    Start,
    /// At the end of the stage, after the free motion.
    Free,
}

/// Position of a side, m.
pub(crate) fn position(island: &IslandView, side: &ContactSide, at: StagePose) -> DVec3 {
    match side {
        ContactSide::Sheet { sheet, point } => {
            let sheet = island.sheet(*sheet);
            point.position(if matches!(at, StagePose::Start) {
                &sheet.state.x
            } else {
                &sheet.work.stage.free_positions
            })
        }
        ContactSide::Body { body, local } => {
            let solver_body = &island.solver_bodies[*body as usize];
            if matches!(at, StagePose::Start) {
                solver_body.start.world_point(*local)
            } else {
                solver_body.free.world_point(*local)
            }
        }
    }
}

/// Gap of a contact, m.
pub(crate) fn gap(island: &IslandView, contact: &ContactConstraint, at: StagePose) -> f64 {
    contact.normal.dot(position(island, &contact.a, at) - position(island, &contact.b, at)) - contact.offset
}

/// Displacement of a side by contact, m.
pub(crate) fn contact_displacement(island: &IslandView, side: &ContactSide) -> DVec3 {
    by_contact(island, side, |jump| &jump.dx, SolverBody::displacement_at)
}

/// Velocity change of a side by contact, m/s.
pub(crate) fn contact_velocity_jump(island: &IslandView, side: &ContactSide) -> DVec3 {
    by_contact(island, side, |jump| &jump.dv, |solver_body, arm| solver_body.kick + solver_body.spin_jump.cross(arm))
}

/// Change of a side by contact, from the sheet's response `of_sheet` or the body's response
/// `of_body` at an arm (m).
fn by_contact(
    island: &IslandView,
    side: &ContactSide,
    of_sheet: impl Fn(&ContactJump) -> &Vectors,
    of_body: impl Fn(&SolverBody, DVec3) -> DVec3,
) -> DVec3 {
    match side {
        ContactSide::Sheet { sheet, point } => {
            let response = island.response(*sheet);
            if response.is_touched() { point.position(of_sheet(&response.jump)) } else { DVec3::ZERO }
        }
        ContactSide::Body { body, local } => {
            let solver_body = &island.solver_bodies[*body as usize];
            of_body(solver_body, solver_body.free.world_point(*local) - solver_body.free.centre())
        }
    }
}

/// Velocity of a side at the start of the stage or at its end without contact, m/s.
pub(crate) fn velocity(island: &IslandView, side: &ContactSide, at: StagePose) -> DVec3 {
    match side {
        ContactSide::Sheet { sheet, point } => {
            let sheet = island.sheet(*sheet);
            point.position(if matches!(at, StagePose::Start) { &sheet.state.v } else { &sheet.work.stage.velocity })
        }
        ContactSide::Body { body, local } => {
            let solver_body = &island.solver_bodies[*body as usize];
            let state = if matches!(at, StagePose::Start) { &solver_body.start } else { &solver_body.free };
            state.velocity_at(state.world_point(*local))
        }
    }
}

/// Side of a contact at node `i` of a sheet.
pub(crate) fn node_side(sheet: u32, i: u32) -> ContactSide {
    ContactSide::Sheet { sheet, point: SheetPoint::node(i) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::test_island::{TestIsland, ball, body_side, contact, fixed_body, loose_nodes};
    use crate::scene::IntegratorKind;

    const DT: f64 = 0.01;

    #[test]
    fn gap_and_open_fraction_follow_a_node_that_falls_on_a_plane() {
        // Node 0 is 3 mm above the contact offset and moves down by 4 mm.
        let mut sheet = loose_nodes(2, 0.2, &[], IntegratorKind::BackwardEuler);
        sheet.state.x.set(0, DVec3::new(0.0, 5e-3, 0.0));
        sheet.state.v.set(0, DVec3::new(0.0, -4e-3 / DT, 0.0));
        let mut island = TestIsland::new(vec![sheet], vec![fixed_body()], DVec3::ZERO);
        island.begin_stage(DT);
        let field = island.field;
        assert!(crate::sheet::stage::solve_free_motion(&mut island.sheets[0], field));
        let floor = contact(0, node_side(0, 0), body_side(0, DVec3::ZERO), DVec3::Y);
        let floor = ContactConstraint { offset: 2e-3, ..floor };
        let mut gaps = ContactGaps::default();
        island.with(|view, _| gaps.measure(&[floor], view));
        assert!((gaps.start[0] - 3e-3).abs() < 1e-15 && (gaps.free[0] + 1e-3).abs() < 1e-15, "{:?}", gaps.free);
        assert_eq!(gaps.now, gaps.free);
        // α = start/(start - end) = 3/4.
        assert!((gaps.open_fraction(0) - 0.75).abs() < 1e-12);
    }

    #[test]
    fn contact_that_starts_closed_or_stays_open_has_the_limits_of_the_fraction() {
        let gaps =
            |start: f64, free: f64| ContactGaps { start: vec![start], free: vec![free], ..ContactGaps::default() };
        assert_eq!(gaps(0.0, -1e-3).open_fraction(0), 0.0);
        assert_eq!(gaps(-1e-3, -2e-3).open_fraction(0), 0.0);
        assert_eq!(gaps(2e-3, 1e-3).open_fraction(0), 1.0);
        assert_eq!(gaps(1e-3, 2e-3).open_fraction(0), 0.0, "it opens");
    }

    #[test]
    fn sides_of_a_moved_body_move_with_its_centre_and_rotation() {
        let mut island = TestIsland::new(vec![], vec![ball(2.0, DVec3::ZERO)], DVec3::ZERO);
        let (shift, turn, arm) = (DVec3::new(1e-3, 2e-3, 0.0), DVec3::Z * 1e-2, DVec3::X * 0.1);
        (island.bodies[0].displacement, island.bodies[0].rotation) = (shift, turn);
        (island.bodies[0].kick, island.bodies[0].spin_jump) = (shift * 10.0, turn * 10.0);
        let side = body_side(0, arm);
        let (by, jump) = island.with(|view, _| (contact_displacement(view, &side), contact_velocity_jump(view, &side)));
        // δ + θ × r, with z × x = y.
        let expected = shift + DVec3::Y * (1e-2 * 0.1);
        assert!(by.distance(expected) < 1e-17 && jump.distance(expected * 10.0) < 1e-16, "{by} {jump}");
    }
}
