//! Primal contact solver of implicit integrators: assembly of the problem in displacements, and
//! transfer of its solution.
//!
//! A single sheet on kinematic and static bodies is solved with its own tangent matrix; several
//! sheets, or sheets with dynamic bodies, with one joint matrix.

use crate::parallel::*;
use glam::{DMat3, DVec3};

use crate::collision::constraint::ContactSide;
use crate::collision::settings::{DetectionSettings, DuplicateSettings};
use crate::contact::IslandView;
use crate::contact::contact_cache::CachedForces;
use crate::contact::counters::ContactCounters;
use crate::contact::settings::{ContactSettings, PrimalSettings};
use crate::contact::solver::augmented_lagrangian::{
    AugmentedLagrangian, AugmentedLagrangianTolerances, PrimalSpace, SolverConstraint, TangentMatrix, UnknownSpace,
    covers_constraint,
};
use crate::contact::solver::delassus::frame_of;
use crate::contact::workspace::ContactWorkspace;
use crate::sheet::stage;

const SETTINGS: PrimalSettings = ContactSettings::DEFAULT.primal;
const DUPLICATES: DuplicateSettings = DetectionSettings::DEFAULT.duplicates;
const CONTACT: ContactSettings = ContactSettings::DEFAULT;

impl ContactWorkspace {
    /// Solve the positions. Returns false if the solver did not converge.
    pub(crate) fn solve_positions_primal(&mut self, island: &mut IslandView, h: f64, rough: bool) -> bool {
        let mut primal = std::mem::take(&mut self.augmented_lagrangian);
        self.choose_working_set(island.sheets.len());
        let mut settled = false;
        for time in 1..=SETTINGS.maximum_solves {
            self.assemble_constraints(&mut primal, island, h);
            settled = self.solve_primal(&mut primal, island, true, rough);
            if !settled && !self.policy.accepts_unconverged {
                break;
            }
            self.transfer_displacements(&primal, island);
            self.cache_position_forces(&primal);
            self.gaps.update(&self.detected.contacts, island);
            if time == SETTINGS.maximum_solves || !self.extend_working_set() {
                break;
            }
        }
        self.augmented_lagrangian = primal;
        settled
    }

    /// Choose the working set: contacts that may close, attachments, and contacts with a cached
    /// force.
    fn choose_working_set(&mut self, sheets: usize) {
        self.working_set.clear();
        self.in_working_set.clear();
        // A deep impact also closes the gaps behind it.
        let deepest = self.gaps.free.iter().fold(0.0_f64, |least, gap| least.min(*gap));
        let behind = -SETTINGS.relative_working_set_gap * deepest;
        let near = SETTINGS.working_set_gap * self.half_thickness;
        let reach = if sheets > 1 {
            near.max((10.0 * behind).min(SETTINGS.maximum_enlarged_gap * self.half_thickness)).max(behind)
        } else {
            f64::INFINITY
        };
        self.closing_gap = if behind > near && sheets > 1 { behind } else { 0.0 };
        for (i, contact) in self.detected.contacts.iter().enumerate() {
            // A single sheet has no limit, because its sparsity pattern covers all its contacts.
            let near = self.gaps.free[i] < reach;
            let is_chosen = near || self.is_bilateral(i) || self.cached_forces(&contact.key).is_some();
            self.in_working_set.push(is_chosen);
            if is_chosen {
                self.working_set.push(i as u32);
            }
        }
    }

    /// Extend the working set by contacts that the solution has closed. Returns false if there are
    /// none.
    fn extend_working_set(&mut self) -> bool {
        let missed = |i: usize| !self.in_working_set[i] && self.gaps.now[i] < CONTACT.closed_gap * self.half_thickness;
        if !(0..self.in_working_set.len()).any(missed) {
            return false;
        }
        for (i, is_chosen) in self.in_working_set.iter_mut().enumerate() {
            if !*is_chosen && self.gaps.now[i] < SETTINGS.working_set_gap * self.half_thickness {
                *is_chosen = true;
                self.working_set.push(i as u32);
            }
        }
        self.working_set.sort_unstable();
        true
    }

    /// Assemble the constraints of the working set and the joint matrix.
    fn assemble_constraints(&mut self, primal: &mut AugmentedLagrangian, island: &mut IslandView, h: f64) {
        primal.clear();
        let known = (&*self, &*island);
        let row_of = |i: &u32| known.0.constraint_of(known.1, *i as usize, h);
        if island.parallel {
            let rows = self.working_set.par_iter().with_min_len(SETTINGS.constraints_per_task).map(row_of);
            rows.unzip_into_vecs(&mut primal.constraints, &mut primal.force);
        } else {
            for (row, force) in self.working_set.iter().map(row_of) {
                primal.constraints.push(row);
                primal.force.push(force);
            }
        }
        self.uses_sheet_tangent = self.is_single_sheet_on_fixed_bodies;
        if let Some(system) = stage::system_mut(island.sheet_mut(0)).filter(|_| self.is_single_sheet_on_fixed_bodies) {
            self.uses_sheet_tangent = primal.constraints.iter().all(|row| covers_constraint(system.pattern(), row));
        }
        if !self.uses_sheet_tangent {
            let pairs = primal.constraints.iter().flat_map(SolverConstraint::pairs);
            self.island_tangent.fill(island, pairs, h);
        }
    }

    /// Store the forces of the position solve in the contact cache.
    pub(crate) fn cache_position_forces(&mut self, primal: &AugmentedLagrangian) {
        let (contacts, chosen) = (&self.detected.contacts, &self.working_set);
        let open = chosen.iter().zip(&primal.force).filter(|(_, force)| **force == DVec3::ZERO);
        self.open_keys.clear();
        self.open_keys.extend(open.map(|(i, _)| contacts[*i as usize].key));
        self.open_keys.sort_unstable();
        self.cache.replace(|old, new| {
            for (k, i) in chosen.iter().enumerate() {
                let (key, position) = (contacts[*i as usize].key, primal.constraints[k].frame * primal.force[k]);
                let slides = primal.slips(k);
                // A new contact starts the velocity solve with the force of the position solve.
                let known =
                    old.of_feature(&key).unwrap_or(CachedForces { velocity: position, slipped: [slides; 2], position });
                new.push((key, CachedForces { position, slipped: [slides, known.slipped[1]], ..known }));
            }
        });
    }

    /// Solve the velocities of the closed contacts. Returns false if the solver did not converge.
    pub(crate) fn solve_velocities_primal(&mut self, island: &mut IslandView, h: f64) -> bool {
        let mut primal = std::mem::take(&mut self.augmented_lagrangian);
        for (k, i) in self.working_set.iter().map(|i| *i as usize).enumerate() {
            let frame = primal.constraints[k].frame;
            let u = self.relative_velocity(island, i, &frame);
            let known = self.cache.of_feature(&self.detected.contacts[i].key).unwrap_or_default();
            primal.force[k] = if u.is_some() { frame.transpose() * known.velocity } else { DVec3::ZERO };
            primal.constraints[k].slipped = known.slipped[1];
            primal.constraints[k].b = u.map_or(DVec3::X, |u| u * h);
            primal.constraints[k].is_new = false;
        }
        let settled = self.solve_primal(&mut primal, island, false, false);
        if settled || self.policy.accepts_unconverged {
            self.transfer_velocity_jumps(&primal, island, h);
            self.cache_velocity_forces(&primal);
        }
        self.augmented_lagrangian = primal;
        settled
    }

    /// Store the forces of the velocity solve in the contact cache.
    pub(crate) fn cache_velocity_forces(&mut self, primal: &AugmentedLagrangian) {
        let (contacts, chosen) = (&self.detected.contacts, &self.working_set);
        let forces = primal.constraints.iter().zip(&primal.force).map(|(row, p)| row.frame * *p);
        self.impulses.set_stage_forces(chosen.iter().copied().zip(forces));
        self.cache.replace(|old, new| {
            for (k, i) in chosen.iter().enumerate() {
                let (key, velocity) = (contacts[*i as usize].key, primal.constraints[k].frame * primal.force[k]);
                let known = old.of_feature(&key).unwrap_or_default();
                new.push((key, CachedForces { velocity, slipped: [known.slipped[0], primal.slips(k)], ..known }));
            }
        });
    }

    /// Solve on the matrix of the sheet or on the joint one; `first` marks the solve after an
    /// assembly.
    fn solve_primal(
        &mut self,
        primal: &mut AugmentedLagrangian,
        island: &mut IslandView,
        first: bool,
        rough: bool,
    ) -> bool {
        let accuracy = self.settings(rough, island.independent_parts());
        let tangent: &mut dyn TangentMatrix =
            match stage::system_mut(island.sheet_mut(0)).filter(|_| self.uses_sheet_tangent) {
                Some(system) => system,
                None => &mut self.island_tangent,
            };
        if first {
            self.slots.clear();
            primal.constraints.iter_mut().for_each(|row| row.look_up_slots(tangent.pattern(), &mut self.slots));
        }
        let mut space = PrimalSpace { tangent, slots: &self.slots };
        solve_counted(primal, &mut space, &mut self.counters, &accuracy)
    }

    /// Settings of a solve for `sheets` sheets. The gap tolerance grows with the deepest
    /// penetration.
    pub(crate) fn settings(&self, rough: bool, sheets: usize) -> AugmentedLagrangianTolerances {
        let sheets = if self.has_only_attachments() { 1 } else { sheets };
        let accuracy = accuracy(rough, sheets, self.policy.is_unbisected_step).scaled(self.half_thickness);
        let deepest = self.gaps.free.iter().fold(0.0_f64, |deepest, gap| deepest.max(-gap));
        let room = if sheets > 1 {
            (SETTINGS.gap_tolerance_several * deepest).min(SETTINGS.maximum_gap_tolerance * self.half_thickness)
        } else {
            SETTINGS.gap_tolerance_single * deepest
        };
        AugmentedLagrangianTolerances { gap: accuracy.gap.max(room), ..accuracy }
    }

    /// Constraint of contact `i` in a stage of weight `h` (s), and its initial force (N) in the
    /// contact frame.
    pub(crate) fn constraint_of(&self, island: &IslandView, i: usize, h: f64) -> (SolverConstraint, DVec3) {
        let contact = &self.detected.contacts[i];
        let mut row = SolverConstraint::new(frame_of(contact.normal), self.law(i));
        for (side, sign) in [(&contact.a, 1.0), (&contact.b, -1.0)] {
            match side {
                ContactSide::Sheet { sheet, point } => {
                    let first = self.island_tangent.sheet(*sheet);
                    for (mass, weight) in point.terms() {
                        if let Some((block, free)) = stage::free_row(island.sheet(*sheet), mass) {
                            row.add(first + block, DMat3::from_diagonal(free * (sign * weight)));
                        }
                    }
                }
                ContactSide::Body { body, local } => {
                    if let Some(first) = self.island_tangent.body(island.sheets.len(), *body) {
                        let solver_body = &island.solver_bodies[*body as usize];
                        let arm = solver_body.free.world_point(*local) - solver_body.free.centre();
                        row.add(first, DMat3::IDENTITY * sign);
                        row.add(first + 1, cross_matrix(arm) * -sign);
                    }
                }
            }
        }
        row.b = self.relative_position(island, i, &row.frame);
        // Such a contact gets no force from a neighbouring one of the same feature either.
        let left_open = self.open_keys.binary_search(&contact.key).is_ok();
        let known = self.cache.of_feature(&contact.key).filter(|_| !left_open);
        let is_unknown = self.cache.is_empty()
            || self.gaps.start[i] > SETTINGS.new_contact_gap * self.half_thickness
            || (self.closing_gap > 0.0 && known.is_none());
        // A single sheet that penetrates where an earlier iteration left it open starts as closed
        // nevertheless; with several sheets the contact would alternate.
        row.is_new = is_unknown && (!left_open || island.sheets.len() == 1);
        row.closing_gap = self.closing_gap;
        row.is_disabled = self.is_duplicate(island, i);
        row.compute_stiffness(|block| self.island_tangent.diagonal_of(island, block, h));
        let known = known.unwrap_or_default();
        row.slipped = known.slipped[0];
        (row, row.frame.transpose() * known.position)
    }

    /// Store the normal of the contact of each node with a body.
    pub(crate) fn store_node_normals(&mut self, island: &IslandView) {
        self.normals.clear();
        self.normals.resize(self.island_tangent.size(), DVec3::ZERO);
        for contact in &self.detected.contacts {
            if let (ContactSide::Sheet { sheet, point }, ContactSide::Body { .. }) = (contact.a, contact.b)
                && point.weights[0] == 1.0
                && let Some((row, _)) = stage::free_row(island.sheet(sheet), point.nodes[0])
            {
                self.normals[(self.island_tangent.sheet(sheet) + row) as usize] = contact.normal;
            }
        }
    }

    /// Whether contact `i` with a body duplicates the contact of one of its nodes. The force would
    /// be distributed arbitrarily between the two.
    pub(crate) fn is_duplicate(&self, island: &IslandView, i: usize) -> bool {
        let contact = &self.detected.contacts[i];
        if i >= self.detected.first_attachment {
            return false;
        }
        let (ContactSide::Sheet { sheet, point }, ContactSide::Body { .. }) = (contact.a, contact.b) else {
            return false;
        };
        let first = self.island_tangent.sheet(sheet);
        let doubles = |(mass, weight): (u32, f64)| {
            let row = stage::free_row(island.sheet(sheet), mass).filter(|_| weight > DUPLICATES.node_weight);
            row.is_some_and(|(row, _)| {
                self.normals[(first + row) as usize].dot(contact.normal) > DUPLICATES.normal_cosine
            })
        };
        point.weights[0] != 1.0 && point.terms().any(doubles)
    }

    /// Transfer displacements and forces of the solution to the sheets and solver bodies.
    fn transfer_displacements(&self, primal: &AugmentedLagrangian, island: &mut IslandView) {
        let (joint, delta, count) = (&self.island_tangent, primal.displacement(), island.sheets.len());
        for local in 0..count as u32 {
            let (sheet, response) = island.with_response(local);
            response.prepare_without_list(sheet.node_count());
            stage::spread_rows(sheet, &delta[3 * joint.sheet(local) as usize..], &mut response.jump.dx);
        }
        for (i, (row, p)) in self.working_set.iter().zip(primal.constraints.iter().zip(&primal.force)) {
            if *p == DVec3::ZERO {
                continue;
            }
            let contact = &self.detected.contacts[*i as usize];
            for (side, sign) in [(&contact.a, 1.0), (&contact.b, -1.0)] {
                if let ContactSide::Sheet { sheet, point } = side {
                    island.with_response(*sheet).1.add_force(point, row.frame * *p * sign);
                }
            }
        }
        for local in 0..count as u32 {
            let (sheet, response) = island.with_response(local);
            response.accelerate(&sheet.inverse_mass);
        }
        for (body, solver_body) in island.solver_bodies.iter_mut().enumerate() {
            if let Some(first) = joint.body(count, body as u32) {
                let at = 3 * first as usize;
                (solver_body.displacement, solver_body.rotation) =
                    (DVec3::from_slice(&delta[at..]), DVec3::from_slice(&delta[at + 3..]));
            }
        }
    }

    /// Transfer the velocity jumps of the solution to the sheets and solver bodies.
    fn transfer_velocity_jumps(&self, primal: &AugmentedLagrangian, island: &mut IslandView, h: f64) {
        let (joint, delta, count) = (&self.island_tangent, primal.displacement(), island.sheets.len());
        for local in 0..count as u32 {
            let (sheet, response) = island.with_response(local);
            stage::spread_rows(sheet, &delta[3 * joint.sheet(local) as usize..], &mut response.jump.dv);
            response.jump.dv.axes_mut().into_iter().flatten().for_each(|v| *v /= h);
        }
        for (body, solver_body) in island.solver_bodies.iter_mut().enumerate() {
            if let Some(first) = joint.body(count, body as u32) {
                let at = 3 * first as usize;
                (solver_body.kick, solver_body.spin_jump) =
                    (DVec3::from_slice(&delta[at..]) / h, DVec3::from_slice(&delta[at + 3..]) / h);
            }
        }
    }
}

/// Settings for `sheets` sheets; `calm` means that the step has not been bisected.
fn accuracy(rough: bool, sheets: usize, calm: bool) -> AugmentedLagrangianTolerances {
    match rough {
        true if sheets > 1 => AugmentedLagrangianTolerances::ROUGH_SEVERAL_SHEETS,
        true => AugmentedLagrangianTolerances::ROUGH,
        false if sheets > 1 && calm && sheets <= SETTINGS.maximum_sheets_of_finest => {
            AugmentedLagrangianTolerances::FEW_SHEETS
        }
        false if sheets > 1 && calm => AugmentedLagrangianTolerances::SEVERAL_SHEETS,
        false if sheets > 1 => AugmentedLagrangianTolerances::IMPACT,
        false => AugmentedLagrangianTolerances::SINGLE_SHEET,
    }
}

/// Solve, and add iterations and factorisations to the counters.
pub(crate) fn solve_counted(
    primal: &mut AugmentedLagrangian,
    space: &mut dyn UnknownSpace,
    counters: &mut ContactCounters,
    accuracy: &AugmentedLagrangianTolerances,
) -> bool {
    let before = (primal.steps, primal.factors);
    let settled = primal.solve(space, accuracy);
    counters.unsettled += u64::from(!settled);
    counters.newton += primal.steps - before.0;
    counters.factors += primal.factors - before.1;
    settled
}

/// Cross-product matrix [r]× of r × .
fn cross_matrix(r: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, r.z, -r.y), DVec3::new(-r.z, 0.0, r.x), DVec3::new(r.y, -r.x, 0.0))
}
