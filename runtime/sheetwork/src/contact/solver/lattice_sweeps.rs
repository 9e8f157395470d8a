//! Contact of explicit lattices with one another, and of explicit sheets with bonds: projected
//! Gauss-Seidel sweeps on their nodes, and on dynamic bodies.
//!
//! With an explicit integrator a force acts on its nodes alone, H = M/h². The displacement of a
//! contact by the forces p of all contacts is then the sum over its few nodes,
//!
//!   u = b + Σ w_i (h²/m_i) Σ w_j p_j  (positions),  h in place of h² for velocities,
//!
//! which needs no Delassus operator: a sweep changes the force of one contact after another and
//! moves the nodes at once. Its cost is linear in the number of contacts, where the Newton steps of
//! `pgs` factorise a matrix of all of them. The layers of each lattice stand in the same sweeps: a
//! node at the limit of the thickness rests on the cell below it as on a face, without friction.
//! Without that a stack of lattices is pressed flat, since contact moves the nodes after the limit
//! has acted on their velocities.
//!
//! A contact with a dynamic body moves the body at once, too. Its normal and tangents couple
//! through the rotation, and the contact is solved exactly (`coulomb`). A bond f lowers the bound
//! of the normal force from 0 to -f. Where that does not close the gap the bond is open, exerts no
//! force, and the sweeps go on without it.

use glam::{DMat3, DVec2, DVec3};

use crate::collision::constraint::{ContactConstraint, ContactSide, SheetPoint};
use crate::collision::narrow_phase::layer_key;
use crate::contact::IslandView;
use crate::contact::contact_cache::CachedForces;
use crate::contact::coulomb::{ContactLaw, solve};
use crate::contact::detected_contacts::DetectedContacts;
use crate::contact::explicit_bonds::position_bond;
use crate::contact::gap::{contact_displacement, contact_velocity_jump};
use crate::contact::settings::{ContactSettings, LatticeSweepSettings};
use crate::contact::solver::delassus::frame_of;
use crate::contact::solver_body::SolverBody;
use crate::contact::workspace::ContactWorkspace;
use crate::elements::thickness_limit::NearLimit;
use crate::math::Vectors;

const SETTINGS: LatticeSweepSettings = ContactSettings::DEFAULT.lattice_sweeps;

/// Quantity that the sweeps change.
#[derive(Clone, Copy, PartialEq, Eq)]
enum NodeQuantity {
    /// Displacements, m.
    Displacement,
    /// Velocity changes, m/s.
    Velocity,
}

/// A contact in the sweeps.
struct SweptContact {
    /// Index in the detected contacts.
    contact: u32,
    frame: DMat3,
    /// Compliance along the axes of the frame, m/N or m/(N s).
    compliance: DVec3,
    /// Relative position or velocity without contact, in the frame.
    free: DVec3,
    /// Force in the frame, N.
    force: DVec3,
    /// Bond force, N: the normal force is at least its negative.
    bond: f64,
    /// Law and 3×3 compliance of a contact with a dynamic body; `None` for nodes alone.
    with_body: Option<(ContactLaw, DMat3)>,
}

/// Sweeps on the nodes of lattices, with their working arrays.
#[derive(Default)]
pub(crate) struct LatticeSweeps {
    active: Vec<SweptContact>,
}

impl LatticeSweeps {
    /// Number of contacts in the last sweeps.
    pub fn len(&self) -> usize {
        self.active.len()
    }

    /// Add contact `contact` with the relative motion `free`, the cached `force` (N, world axes)
    /// and the bond force `bond` (N); `scale` is h² (s²) or h (s).
    fn push(
        &mut self,
        (contact, constraint, law): (usize, &ContactConstraint, ContactLaw),
        free: DVec3,
        (force, bond): (DVec3, f64),
        island: &IslandView,
        scale: f64,
    ) {
        let frame = frame_of(constraint.normal);
        let mut compliance = DVec3::ZERO;
        let mut of_bodies = DMat3::ZERO;
        for side in [&constraint.a, &constraint.b] {
            match side {
                ContactSide::Sheet { sheet, point } => {
                    for (node, weight) in point.terms() {
                        let mobility = mobility(island, *sheet, node) * (scale * weight * weight);
                        let along = |axis: DVec3| (axis * axis).dot(mobility);
                        compliance += DVec3::new(along(frame.x_axis), along(frame.y_axis), along(frame.z_axis));
                    }
                }
                ContactSide::Body { body, local } => {
                    let body = &island.solver_bodies[*body as usize];
                    if body.is_dynamic() {
                        let arm = arm_of(body, *local);
                        of_bodies += frame.transpose() * body.compliance(arm, arm) * frame * scale;
                    }
                }
            }
        }
        let with_body = (of_bodies != DMat3::ZERO).then(|| (law, of_bodies + DMat3::from_diagonal(compliance)));
        let force = frame.transpose() * force;
        self.active.push(SweptContact { contact: contact as u32, frame, compliance, free, force, bond, with_body });
    }

    /// Sweep until no contact moves by more than the tolerance (m). Returns the number of sweeps.
    fn sweep(
        &mut self,
        island: &mut IslandView,
        contacts: &[ContactConstraint],
        quantity: NodeQuantity,
        h: f64,
    ) -> u32 {
        let tolerance = SETTINGS.tolerance * island.half_thickness();
        let (scale, tolerance) = match quantity {
            NodeQuantity::Displacement => (h * h, tolerance),
            NodeQuantity::Velocity => (h, tolerance / h),
        };
        for swept in &self.active {
            push_sides(island, &contacts[swept.contact as usize], swept.frame * swept.force, quantity, scale);
        }
        for sweeps in 1..=SETTINGS.maximum_sweeps {
            let mut largest = 0.0_f64;
            for swept in &mut self.active {
                let constraint = &contacts[swept.contact as usize];
                let apart = value(island, &constraint.a, quantity) - value(island, &constraint.b, quantity);
                let change = swept.change(swept.free + swept.frame.transpose() * apart, constraint.friction);
                if change != DVec3::ZERO {
                    push_sides(island, constraint, swept.frame * change, quantity, scale);
                    let moved = swept.with_body.map_or(change * swept.compliance, |(_, block)| block * change);
                    largest = largest.max(moved.abs().max_element());
                }
            }
            if largest <= tolerance {
                return sweeps;
            }
        }
        SETTINGS.maximum_sweeps
    }
}

impl SweptContact {
    /// Change the force so that the contact, at the relative motion `u`, obeys Coulomb's law.
    /// Returns the change, N.
    fn change(&mut self, u: DVec3, friction: f64) -> DVec3 {
        let bond = DVec3::new(self.bond, 0.0, 0.0);
        if let Some((law, block)) = &self.with_body {
            let force = solve(block, u - *block * (self.force + bond), *law, self.force + bond) - bond;
            let change = force - self.force;
            self.force = force;
            return change;
        }
        let step = |u: f64, compliance: f64| if compliance > 0.0 { u / compliance } else { 0.0 };
        let normal = (self.force.x - step(u.x, self.compliance.x)).max(0.0 - self.bond);
        let sticking =
            DVec2::new(self.force.y - step(u.y, self.compliance.y), self.force.z - step(u.z, self.compliance.z));
        let tangential =
            if friction > 0.0 { sticking.clamp_length_max(friction * (normal + self.bond)) } else { DVec2::ZERO };
        let force = DVec3::new(normal, tangential.x, tangential.y);
        let change = force - self.force;
        self.force = force;
        change
    }
}

/// Inverse mass of a node along the world axes, 1/kg.
fn mobility(island: &IslandView, sheet: u32, node: u32) -> DVec3 {
    let sheet = island.sheet(sheet);
    let inverse = DVec3::splat(sheet.inverse_mass[node as usize]);
    if sheet.pins.is_empty() { inverse } else { inverse * sheet.pins.free_axes(node) }
}

/// Arm of a point fixed in a body from its centre of mass, m.
fn arm_of(body: &SolverBody, local: DVec3) -> DVec3 {
    body.free.world_point(local) - body.free.centre()
}

/// Displacement or velocity change of one side by contact.
fn value(island: &IslandView, side: &ContactSide, quantity: NodeQuantity) -> DVec3 {
    match quantity {
        NodeQuantity::Displacement => contact_displacement(island, side),
        NodeQuantity::Velocity => contact_velocity_jump(island, side),
    }
}

/// Move the nodes and dynamic bodies of a contact by `force` (N, world axes, on side a).
fn push_sides(island: &mut IslandView, contact: &ContactConstraint, force: DVec3, quantity: NodeQuantity, scale: f64) {
    for (side, sign) in [(&contact.a, scale), (&contact.b, -scale)] {
        match side {
            ContactSide::Sheet { sheet, point } => {
                for (node, weight) in point.terms() {
                    let by = mobility(island, *sheet, node) * force * (sign * weight);
                    let jump = &mut island.with_response(*sheet).1.jump;
                    let values: &mut Vectors =
                        if quantity == NodeQuantity::Displacement { &mut jump.dx } else { &mut jump.dv };
                    values.add(node as usize, by);
                }
            }
            ContactSide::Body { body, local } => {
                let body = &mut island.solver_bodies[*body as usize];
                if body.is_dynamic() {
                    let by = force * sign;
                    let moment = arm_of(body, *local).cross(by);
                    // The weight of the stage is in `by`.
                    match quantity {
                        NodeQuantity::Displacement => body.add_displacement(by, moment, 1.0),
                        NodeQuantity::Velocity => body.add_velocity_jump(by, moment, 1.0),
                    }
                }
            }
        }
    }
}

/// Whether contact of the island is solved on the nodes of lattices: several of them, all of two
/// layers or more, without dynamic bodies and attachments.
pub(crate) fn is_of_lattices(island: &IslandView, detected: &DetectedContacts) -> bool {
    island.sheets.len() > 1
        && detected.first_attachment >= detected.contacts.len()
        && detected.colliders.len() == detected.contacts.len()
        && !island.solver_bodies.iter().any(SolverBody::is_dynamic)
        && island.contacts.iter().all(|c| c.surface.as_ref().is_some_and(|s| s.is_multilayer()))
}

/// Add the limits of the thickness of all lattices as contacts between a node and its cell.
pub(crate) fn add_thickness_limits(island: &IslandView, detected: &mut DetectedContacts) {
    for (index, sheet) in (0_u32..).zip(island.sheets.iter()) {
        let Some(limit) = &sheet.parameters.thickness_limit else { continue };
        for near in limit.near_limit(&sheet.work.stage.free_positions, SETTINGS.thickness_margin) {
            let NearLimit { apex, corners: [a, b, c, d], is_square, .. } = near;
            let half = |p: u32, q: u32| SheetPoint { nodes: [p, q, q], weights: [0.5, 0.5, 0.0] };
            let third = SheetPoint { nodes: [a, b, c], weights: [1.0 / 3.0; 3] };
            // The middles of both diagonals of a square.
            let points = if is_square { [Some(half(a, c)), Some(half(b, d))] } else { [Some(third), None] };
            for (number, point) in (0_u32..).zip(points.into_iter().flatten()) {
                detected.contacts.push(ContactConstraint {
                    a: ContactSide::Sheet { sheet: index, point: SheetPoint::node(apex) },
                    b: ContactSide::Sheet { sheet: index, point },
                    normal: near.normal,
                    offset: near.least_height,
                    key: layer_key(index, apex, 2 * near.index + number),
                    friction: 0.0,
                    restitution: 0.0,
                    bond: 0.0,
                    compressed: None,
                });
                detected.colliders.push(u32::MAX);
            }
        }
    }
    detected.first_attachment = detected.contacts.len();
}

impl ContactWorkspace {
    /// Remove the penetration of the free motion by sweeps on the nodes, in a step of `h` (s).
    pub(super) fn solve_positions_on_nodes(&mut self, island: &mut IslandView, h: f64) {
        let mut sweeps = std::mem::take(&mut self.lattice_sweeps);
        loop {
            self.sweep_positions(&mut sweeps, island, h);
            if !self.has_bonds || !self.release_open_bonds(island) {
                break;
            }
        }
        let contacts = &self.detected.contacts;
        self.cache.replace(|old, new| {
            new.extend(sweeps.active.iter().map(|swept| {
                let key = contacts[swept.contact as usize].key;
                let position = swept.frame * swept.force;
                (key, CachedForces { position, ..old.of(&key).unwrap_or_default() })
            }));
        });
        self.lattice_sweeps = sweeps;
    }

    /// Sweep the positions from the cached forces, in a step of `h` (s).
    fn sweep_positions(&mut self, sweeps: &mut LatticeSweeps, island: &mut IslandView, h: f64) {
        sweeps.active.clear();
        island.each_response(|sheet, response| response.prepare_without_list(sheet.node_count()));
        island.solver_bodies.iter_mut().for_each(SolverBody::clear_displacement);
        for (i, constraint) in self.detected.contacts.iter().enumerate() {
            let free = self.relative_position(island, i, &frame_of(constraint.normal));
            let force = self.cached_forces(&constraint.key).map_or(DVec3::ZERO, |f| f.position);
            let bond = position_bond(island, constraint);
            sweeps.push((i, constraint, self.law(i)), free, (force, bond), island, h * h);
        }
        let done = sweeps.sweep(island, &self.detected.contacts, NodeQuantity::Displacement, h);
        self.counters.sweeps += u64::from(done);
        self.work += u64::from(done) * sweeps.len() as u64;
    }

    /// Remove the bonds of contacts that are open after the sweeps. Returns whether there are any.
    fn release_open_bonds(&mut self, island: &IslandView) -> bool {
        self.gaps.update(&self.detected.contacts, island);
        let mut is_any = false;
        for (contact, gap) in self.detected.contacts.iter_mut().zip(&self.gaps.now) {
            if contact.bond > 0.0 && *gap > SETTINGS.open_gap * self.half_thickness {
                contact.bond = 0.0;
                is_any = true;
            }
        }
        is_any
    }

    /// Solve the velocities of the contacts that the position solve left closed.
    pub(super) fn solve_velocities_on_nodes(&mut self, island: &mut IslandView, h: f64) {
        let mut sweeps = std::mem::take(&mut self.lattice_sweeps);
        sweeps.active.clear();
        island.each_response(|_, response| response.jump.dv.clear());
        island.solver_bodies.iter_mut().for_each(|m| (m.kick, m.spin_jump) = (DVec3::ZERO, DVec3::ZERO));
        for (i, constraint) in self.detected.contacts.iter().enumerate() {
            let Some(free) = self.relative_velocity(island, i, &frame_of(constraint.normal)) else { continue };
            let force = self.cached_forces(&constraint.key).map_or(DVec3::ZERO, |f| f.velocity);
            sweeps.push((i, constraint, self.law(i)), free, (force, constraint.bond), island, h);
        }
        let done = sweeps.sweep(island, &self.detected.contacts, NodeQuantity::Velocity, h);
        self.counters.sweeps += u64::from(done);
        let contacts = &self.detected.contacts;
        self.impulses.set_stage_forces(sweeps.active.iter().map(|swept| (swept.contact, swept.frame * swept.force)));
        self.cache.replace(|old, new| {
            // In the order of the contacts; an open one has no velocity force.
            let mut closed = sweeps.active.iter().peekable();
            for (i, contact) in (0_u32..).zip(contacts) {
                let swept = closed.next_if(|swept| swept.contact == i);
                let velocity = swept.map_or(DVec3::ZERO, |swept| swept.frame * swept.force);
                new.push((contact.key, CachedForces { velocity, ..old.of(&contact.key).unwrap_or_default() }));
            }
        });
        self.lattice_sweeps = sweeps;
    }
}
