//! Delassus operator W = Σ J H⁻¹ Jᵀ, extended contact by contact.
//!
//! The Jacobian J of a contact holds, on a sheet, the weights of its nodes times the contact frame;
//! on a body, the frame and its moment. A sheet contributes with the factor of its tangent H = L
//! Lᵀ, by half solutions L⁻¹ Jᵀ (see [`crate::linear::HalfSolutions`]); a body with the
//! compliance of [`SolverBody`].

use glam::{DMat3, DVec3};

use crate::collision::constraint::{ContactConstraint, ContactSide};
use crate::contact::IslandView;
use crate::contact::solver::pgs::DualProblem;
use crate::contact::solver_body::SolverBody;
use crate::sheet::{Sheet, stage};

/// An active contact.
#[derive(Clone, Copy)]
struct ActiveContact {
    /// Index among the detected contacts.
    contact: u32,
    /// Contact frame; columns are the normal and two tangents.
    frame: DMat3,
    /// For each side: the sheet and the position in its list of active contacts. A side without a
    /// sheet, or on the same sheet as side a, holds [`NONE`].
    places: [(u32, u32); 2],
}

/// Delassus operator and the problem on it.
#[derive(Default)]
pub(crate) struct DelassusOperator {
    /// Active contacts in the order in which they were added.
    active: Vec<ActiveContact>,
    /// Active contacts of each body, ascending.
    on_body: Vec<Vec<u32>>,
    /// The problem u = W p + b.
    pub problem: DualProblem,
    /// Blocks of the contact that is being added.
    row: Vec<DMat3>,
    touched: Vec<u32>,
}

/// Entry of [`ActiveContact::places`] for a side without a sheet of its own.
const NONE: (u32, u32) = (u32::MAX, 0);

impl DelassusOperator {
    /// Remove all contacts, and clear the displacements of the sheets.
    pub fn clear(&mut self, island: &mut IslandView) {
        self.active.clear();
        self.problem.clear();
        self.on_body.iter_mut().for_each(Vec::clear);
        self.on_body.resize_with(island.solver_bodies.len(), Vec::new);
        island.each_response(|sheet, response| response.clear(sheet.node_count()));
    }

    /// Remove all contacts, but keep the displacements of the sheets.
    pub fn clear_for_velocities(&mut self, island: &mut IslandView) {
        island.each_response(|_, response| std::mem::swap(&mut response.saved_dx, &mut response.jump.dx));
        self.clear(island);
        island.each_response(|_, response| {
            std::mem::swap(&mut response.saved_dx, &mut response.jump.dx);
            response.touched = true;
        });
    }

    /// Index of active contact `i` among the detected contacts.
    pub fn contact(&self, i: usize) -> usize {
        self.active[i].contact as usize
    }

    /// Indices of all active contacts among the detected contacts.
    pub fn contacts(&self) -> impl Iterator<Item = usize> + '_ {
        self.active.iter().map(|a| a.contact as usize)
    }

    /// Frame of active contact `i`: normal and two tangents.
    pub fn frame(&self, i: usize) -> DMat3 {
        self.active[i].frame
    }

    /// Add the contacts `new`, which the caller has pushed to the problem, in a stage of weight `h`
    /// (s).
    pub fn add(&mut self, island: &mut IslandView, contacts: &[ContactConstraint], new: &[u32], h: f64) {
        let first = self.active.len();
        island.each_response(|_, response| response.loads.clear());
        for number in new {
            self.load(island, contacts, *number);
        }
        island.each_response(|sheet, response| {
            if !response.loads.is_empty() {
                stage::half_solve(sheet, &response.loads, &mut response.halves);
            }
        });
        for i in first..self.active.len() {
            self.couple(island, contacts, i, h);
        }
    }

    /// Add the Jacobian of a contact to the lists of its sheets and bodies.
    fn load(&mut self, island: &mut IslandView, contacts: &[ContactConstraint], number: u32) {
        let contact = &contacts[number as usize];
        let index = self.active.len() as u32;
        let frame = frame_of(contact.normal);
        let mut places = [NONE; 2];
        let same = matches!((contact.a, contact.b), (ContactSide::Sheet { sheet: a, .. }, ContactSide::Sheet { sheet: b, .. }) if a == b);
        for (k, side) in [contact.a, contact.b].into_iter().enumerate() {
            match side {
                ContactSide::Body { body, .. } => {
                    if island.solver_bodies[body as usize].is_dynamic() {
                        self.on_body[body as usize].push(index);
                    }
                }
                ContactSide::Sheet { sheet, .. } if k == 0 || !same => {
                    let (member, response) = island.with_response(sheet);
                    for column in [frame.x_axis, frame.y_axis, frame.z_axis] {
                        response.loads.push(loads(member, contact, sheet, column));
                    }
                    places[k] = (sheet, response.list.len() as u32);
                    response.list.push(index);
                }
                ContactSide::Sheet { .. } => {}
            }
        }
        self.active.push(ActiveContact { contact: number, frame, places });
    }

    /// Compute the blocks of W between active contact `i` and those before it, and itself.
    fn couple(&mut self, island: &IslandView, contacts: &[ContactConstraint], i: usize, h: f64) {
        self.row.resize(self.active.len(), DMat3::ZERO);
        self.touched.clear();
        let active = self.active[i];
        for (sheet, place) in active.places.into_iter().filter(|u| *u != NONE) {
            let response = island.response(sheet);
            for (other, j) in response.list[..=place as usize].iter().enumerate() {
                let block = response.halves.block(place as usize, other);
                self.accumulate_block(*j, DMat3::from_cols_array_2d(&block).transpose());
            }
        }
        let contact = &contacts[active.contact as usize];
        for (body, arm, sign) in body_arms(contact, &island.solver_bodies).into_iter().flatten() {
            let solver_body = &island.solver_bodies[body as usize];
            for k in 0..self.on_body[body as usize].len() {
                let j = self.on_body[body as usize][k];
                if j as usize > i {
                    break;
                }
                let other = self.active[j as usize];
                let others = body_arms(&contacts[other.contact as usize], &island.solver_bodies);
                for (_, at, its) in others.into_iter().flatten().filter(|a| a.0 == body) {
                    let compliance = solver_body.compliance(arm, at) * (h * h * sign * its);
                    self.accumulate_block(j, active.frame.transpose() * compliance * other.frame);
                }
            }
        }
        for j in &self.touched {
            self.problem.couple(i, *j as usize, self.row[*j as usize]);
            self.row[*j as usize] = DMat3::ZERO;
        }
    }

    /// Add `block` to the block of the present contact and contact `j`.
    fn accumulate_block(&mut self, j: u32, block: DMat3) {
        let there = &mut self.row[j as usize];
        if *there == DMat3::ZERO {
            self.touched.push(j);
        }
        *there += block;
    }

    /// Compute the contact forces on the nodes of each sheet, N.
    fn forces(&self, island: &mut IslandView, contacts: &[ContactConstraint]) {
        island.each_response(|_, response| {
            if response.is_touched() {
                response.force.clear();
            }
        });
        for (active, p) in self.active.iter().zip(&self.problem.force) {
            if *p == DVec3::ZERO {
                continue;
            }
            let force = active.frame * *p;
            let contact = &contacts[active.contact as usize];
            for (side, sign) in [(contact.a, 1.0), (contact.b, -1.0)] {
                if let ContactSide::Sheet { sheet, point } = side {
                    island.with_response(sheet).1.add_force(&point, force * sign);
                }
            }
        }
    }

    /// Compute the displacements by the forces of the problem, and the accelerations that
    /// correspond to the forces, in sheets and solver bodies. `h` is the weight of the stage (s).
    pub fn displace(&self, island: &mut IslandView, contacts: &[ContactConstraint], h: f64) {
        self.forces(island, contacts);
        island.each_response(|sheet, response| {
            if response.is_touched() {
                stage::solve_displacement(sheet, &response.force, &mut response.jump.dx);
                response.accelerate(&sheet.inverse_mass);
            }
        });
        island.solver_bodies.iter_mut().for_each(SolverBody::clear_displacement);
        self.push_bodies(island, contacts, |solver_body, force, moment| {
            solver_body.add_displacement(force, moment, h);
        });
    }

    /// Compute the velocity jumps by the forces of the problem acting for `h` (s), in sheets and
    /// solver bodies.
    pub fn apply_velocity_jumps(&self, island: &mut IslandView, contacts: &[ContactConstraint], h: f64) {
        self.forces(island, contacts);
        island.each_response(|sheet, response| {
            if response.is_touched() {
                stage::solve_displacement(sheet, &response.force, &mut response.jump.dv);
                response.jump.dv.axes_mut().into_iter().flatten().for_each(|v| *v /= h);
            }
        });
        island.solver_bodies.iter_mut().for_each(|m| (m.kick, m.spin_jump) = (DVec3::ZERO, DVec3::ZERO));
        self.push_bodies(island, contacts, |solver_body, force, moment| {
            solver_body.add_velocity_jump(force, moment, h);
        });
    }

    /// Call `push` for every contact on a dynamic body with its force (N) and the moment about the
    /// centre of mass (N m).
    fn push_bodies(
        &self,
        island: &mut IslandView,
        contacts: &[ContactConstraint],
        push: impl Fn(&mut SolverBody, DVec3, DVec3),
    ) {
        for (active, p) in self.active.iter().zip(&self.problem.force) {
            if *p == DVec3::ZERO {
                continue;
            }
            for (body, arm, sign) in
                body_arms(&contacts[active.contact as usize], &island.solver_bodies).into_iter().flatten()
            {
                let force = active.frame * *p * sign;
                let solver_body = &mut island.solver_bodies[body as usize];
                if solver_body.is_dynamic() {
                    push(solver_body, force, arm.cross(force));
                }
            }
        }
    }
}

/// Bodies of a contact: index, arm from the centre of mass (m), sign of the force.
fn body_arms(contact: &ContactConstraint, solver_bodies: &[SolverBody]) -> [Option<(u32, DVec3, f64)>; 2] {
    [(contact.a, 1.0), (contact.b, -1.0)].map(|(side, sign)| match side {
        ContactSide::Body { body, local } => {
            let solver_body = &solver_bodies[body as usize];
            Some((body, solver_body.free.world_point(local) - solver_body.free.centre(), sign))
        }
        ContactSide::Sheet { .. } => None,
    })
}

/// Load of a contact force of 1 N along `direction` on the block rows of sheet `number`.
fn loads<'a>(
    sheet: &'a Sheet,
    contact: &ContactConstraint,
    number: u32,
    direction: DVec3,
) -> impl Iterator<Item = (u32, [f64; 3])> + use<'a> {
    let sides = [(contact.a, 1.0), (contact.b, -1.0)];
    sides.into_iter().flat_map(move |(side, sign)| {
        let terms = match side {
            ContactSide::Sheet { sheet, point } if sheet == number => Some(point),
            _ => None,
        };
        terms.into_iter().flat_map(move |point| {
            (0..3).filter_map(move |k| {
                let weight = point.weights[k];
                let (row, free) = stage::free_row(sheet, point.nodes[k]).filter(|_| weight != 0.0)?;
                Some((row, (direction * free * (sign * weight)).to_array()))
            })
        })
    })
}

/// Orthonormal frame whose first column is `normal`.
pub(crate) fn frame_of(normal: DVec3) -> DMat3 {
    let axis = if normal.x.abs() < 0.7 { DVec3::X } else { DVec3::Y };
    let tangent = (axis - normal * axis.dot(normal)).normalize();
    DMat3::from_cols(normal, tangent, normal.cross(tangent))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::coulomb::ContactLaw;
    use crate::contact::gap::node_side;
    use crate::contact::test_island::{TestIsland, ball, body_side, contact, fixed_body, loose_nodes};
    use crate::scene::IntegratorKind;

    const H: f64 = 0.01;

    /// The operator of `contacts`.
    fn operator(island: &mut TestIsland, contacts: &[ContactConstraint]) -> DelassusOperator {
        let mut operator = DelassusOperator::default();
        island.with(|view, _| {
            operator.clear(view);
            contacts.iter().for_each(|_| operator.problem.push(ContactLaw::Coulomb(0.5), DVec3::ZERO));
            let all: Vec<u32> = (0..contacts.len() as u32).collect();
            operator.add(view, contacts, &all, H);
        });
        operator
    }

    /// Balls of masses 2 and 5 kg and radius 0.1 m that touch at the origin, one above the other.
    fn two_balls() -> (TestIsland, ContactConstraint) {
        let bodies = vec![ball(2.0, DVec3::Y * 0.1), ball(5.0, DVec3::NEG_Y * 0.1)];
        let island = TestIsland::new(vec![], bodies, DVec3::ZERO);
        let (a, b) = (body_side(0, DVec3::NEG_Y * 0.1), body_side(1, DVec3::Y * 0.1));
        (island, contact(0, a, b, DVec3::Y))
    }

    #[test]
    fn two_bodies_add_their_inverse_masses_and_inertias() {
        let (mut island, touch) = two_balls();
        let w = operator(&mut island, &[touch]).problem.diagonal[0];
        // A tangential force at arm r also turns a ball with I = 2/5 m r²: 1/m + r²/I = 7/(2 m).
        let masses = 1.0 / 2.0 + 1.0 / 5.0;
        let expected = DMat3::from_diagonal(DVec3::new(masses, 3.5 * masses, 3.5 * masses) * (H * H));
        assert!((w - expected).to_cols_array().iter().all(|x| x.abs() < 1e-15 * H), "{w} {expected}");
    }

    #[test]
    fn two_contacts_of_a_body_couple_through_its_rotation() {
        // A ball of 2 kg, I = 0.4 · 2 · 0.01, under normal forces at the arms x = 0.06 and -0.08
        // m.
        let mut island = TestIsland::new(vec![], vec![ball(2.0, DVec3::ZERO), fixed_body()], DVec3::ZERO);
        let arms = [0.06, -0.08];
        let contacts = [0, 1].map(|i| {
            let at = DVec3::X * arms[i as usize];
            contact(i, body_side(0, at), body_side(1, at), DVec3::Y)
        });
        let problem = operator(&mut island, &contacts).problem;
        // W_ij = h² (1/m + x_i x_j/I).
        let expected = |i: usize, j: usize| H * H * (1.0 / 2.0 + arms[i] * arms[j] / (0.4 * 2.0 * 0.01));
        assert!((problem.diagonal[0].x_axis.x - expected(0, 0)).abs() < 1e-17);
        assert!((problem.diagonal[1].x_axis.x - expected(1, 1)).abs() < 1e-17);
        assert_eq!(problem.columns[0].len(), 1);
        assert!((problem.columns[0][0].1.x_axis.x - expected(0, 1)).abs() < 1e-17);
    }

    #[test]
    fn node_and_body_add_their_inverse_masses() {
        let sheet = loose_nodes(2, 0.2, &[], IntegratorKind::BackwardEuler);
        let mut island = TestIsland::new(vec![sheet], vec![ball(5.0, DVec3::NEG_Y * 0.1)], DVec3::ZERO);
        island.begin_stage(H);
        let field = island.field;
        assert!(stage::solve_free_motion(&mut island.sheets[0], field));
        let touch = contact(0, node_side(0, 0), body_side(0, DVec3::Y * 0.1), DVec3::Y);
        let w = operator(&mut island, &[touch]).problem.diagonal[0];
        let expected = DVec3::new(1.0 / 0.2 + 1.0 / 5.0, 1.0 / 0.2 + 3.5 / 5.0, 1.0 / 0.2 + 3.5 / 5.0) * (H * H);
        assert!((w - DMat3::from_diagonal(expected)).to_cols_array().iter().all(|x| x.abs() < 1e-14 * H), "{w}");
    }

    #[test]
    fn forces_move_both_bodies_in_proportion_to_their_mobility() {
        let (mut island, touch) = two_balls();
        let mut operator = operator(&mut island, &[touch]);
        // In the frame (normal, two tangents) of the normal y, the first tangent is x.
        operator.problem.force[0] = DVec3::new(30.0, 4.0, 0.0);
        let force = DVec3::new(4.0, 30.0, 0.0);
        island.with(|view, _| {
            operator.displace(view, &[touch], H);
            operator.apply_velocity_jumps(view, &[touch], H);
        });
        for (body, sign, m) in [(0, 1.0, 2.0), (1, -1.0, 5.0)] {
            let body = &island.bodies[body];
            assert!(body.displacement.distance(force * (sign * H * H / m)) < 1e-16, "{}", body.displacement);
            assert!(body.kick.distance(force * (sign * H / m)) < 1e-14, "{}", body.kick);
            // Both forces have the moment r × p = (∓r y) × (±p) = 0.1 · 4 about z.
            let turn = DVec3::Z * (0.1 * 4.0 / (0.4 * m * 0.01));
            assert!(body.rotation.distance(turn * (H * H)) < 1e-15, "{}", body.rotation);
            assert!(body.spin_jump.distance(turn * H) < 1e-13, "{}", body.spin_jump);
        }
    }

    #[test]
    fn frame_is_orthonormal_and_starts_with_the_normal() {
        for normal in [DVec3::X, DVec3::Y, DVec3::NEG_Z, DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.8, -0.6, 0.0)] {
            let frame = frame_of(normal);
            assert_eq!(frame.x_axis, normal);
            let error = frame.transpose() * frame - DMat3::IDENTITY;
            assert!(error.to_cols_array().iter().all(|x| x.abs() < 1e-15) && frame.determinant() > 0.0, "{normal}");
        }
    }
}
