//! Primal contact solver of implicit integrators: assembly of the problem in displacements, and
//! transfer of its solution.
//!
//! A single sheet on kinematic and static bodies is solved with its own tangent matrix; several
//! sheets, or sheets with dynamic bodies, with one joint matrix.

use crate::parallel::*;
use glam::{DMat3, DVec3};

use crate::collision::constraint::Side;
use crate::collision::settings::{DetectionSettings, DuplicateSettings};
use crate::contact::settings::{ContactSettings, PrimalSettings};
use crate::contact::solver::augmented_lagrangian::{Accuracy, OnMasses, Primal, Row, Space, Tangent, covers};
use crate::contact::solver::delassus::{Group, frame_of};
use crate::contact::stage::{ContactCounters, Scratch};
use crate::contact::warm_start::Remembered;

const SETTINGS: PrimalSettings = ContactSettings::DEFAULT.primal;
const DUPLICATES: DuplicateSettings = DetectionSettings::DEFAULT.duplicates;
const CONTACT: ContactSettings = ContactSettings::DEFAULT;

impl Scratch {
    /// Solve the positions. Returns false if the solver did not converge.
    pub(crate) fn positions_on_masses(&mut self, group: &mut Group, h: f64, rough: bool) -> bool {
        let mut primal = std::mem::take(&mut self.primal);
        self.choose(group.members.len());
        let mut settled = false;
        for time in 1..=SETTINGS.maximum_solves {
            self.lay_rows(&mut primal, group, h);
            settled = self.solve_on_masses(&mut primal, group, true, rough);
            if !settled && !self.last_resort {
                break;
            }
            self.take_displacements(&primal, group);
            self.remember_positions(&primal);
            self.gaps.update(&self.found.contacts, group);
            if time == SETTINGS.maximum_solves || !self.choose_more() {
                break;
            }
        }
        self.primal = primal;
        settled
    }

    /// Choose the working set: contacts that may close, attachments, and contacts with a cached
    /// force.
    fn choose(&mut self, sheets: usize) {
        self.chosen.clear();
        self.is_chosen.clear();
        // A deep impact also closes the gaps behind it.
        let deepest = self.gaps.free.iter().fold(0.0_f64, |least, gap| least.min(*gap));
        let behind = -SETTINGS.relative_working_set_gap * deepest;
        let reach = if sheets > 1 {
            SETTINGS.working_set_gap.max((10.0 * behind).min(SETTINGS.maximum_enlarged_gap)).max(behind)
        } else {
            f64::INFINITY
        };
        self.eager = if behind > SETTINGS.working_set_gap && sheets > 1 { behind } else { 0.0 };
        for (i, contact) in self.found.contacts.iter().enumerate() {
            // A single sheet has no limit, because its sparsity pattern covers all its contacts.
            let near = self.gaps.free[i] < reach;
            let is_chosen = near || i >= self.found.glue_from || self.remembered(&contact.key).is_some();
            self.is_chosen.push(is_chosen);
            if is_chosen {
                self.chosen.push(i as u32);
            }
        }
    }

    /// Extend the working set by contacts that the solution has closed. Returns false if there are
    /// none.
    fn choose_more(&mut self) -> bool {
        let missed = |i: usize| !self.is_chosen[i] && self.gaps.now[i] < CONTACT.closed_gap;
        if !(0..self.is_chosen.len()).any(missed) {
            return false;
        }
        for (i, is_chosen) in self.is_chosen.iter_mut().enumerate() {
            if !*is_chosen && self.gaps.now[i] < SETTINGS.working_set_gap {
                *is_chosen = true;
                self.chosen.push(i as u32);
            }
        }
        self.chosen.sort_unstable();
        true
    }

    /// Assemble the constraints of the working set and the joint matrix.
    fn lay_rows(&mut self, primal: &mut Primal, group: &mut Group, h: f64) {
        primal.clear();
        let known = (&*self, &*group);
        let row_of = |i: &u32| known.0.row_of(known.1, *i as usize, h);
        if group.parallel {
            let rows = self.chosen.par_iter().with_min_len(SETTINGS.constraints_per_task).map(row_of);
            rows.unzip_into_vecs(&mut primal.rows, &mut primal.force);
        } else {
            for (row, force) in self.chosen.iter().map(row_of) {
                primal.rows.push(row);
                primal.force.push(force);
            }
        }
        self.on_own = self.alone;
        if let Some(system) = group.sheet_mut(0).system_mut().filter(|_| self.alone) {
            self.on_own = primal.rows.iter().all(|row| covers(system.pattern(), row));
        }
        if !self.on_own {
            self.joint.fill(group, &primal.rows, h);
        }
    }

    /// Store the forces of the position solve in the contact cache.
    pub(crate) fn remember_positions(&mut self, primal: &Primal) {
        let (contacts, chosen) = (&self.found.contacts, &self.chosen);
        let open = chosen.iter().zip(&primal.force).filter(|(_, force)| **force == DVec3::ZERO);
        self.left_open.clear();
        self.left_open.extend(open.map(|(i, _)| contacts[*i as usize].key));
        self.left_open.sort_unstable();
        self.memory.replace(|old, new| {
            for (k, i) in chosen.iter().enumerate() {
                let (key, position) = (contacts[*i as usize].key, primal.rows[k].frame * primal.force[k]);
                let slides = primal.slides(k);
                // A new contact starts the velocity solve with the force of the position solve.
                let known = old.near(&key).unwrap_or(Remembered { velocity: position, slides: [slides; 2], position });
                new.push((key, Remembered { position, slides: [slides, known.slides[1]], ..known }));
            }
        });
    }

    /// Solve the velocities of the closed contacts. Returns false if the solver did not converge.
    pub(crate) fn velocities_on_masses(&mut self, group: &mut Group, h: f64) -> bool {
        let mut primal = std::mem::take(&mut self.primal);
        for (k, i) in self.chosen.iter().map(|i| *i as usize).enumerate() {
            let frame = primal.rows[k].frame;
            let u = self.velocity_of(group, i, &frame);
            let known = self.memory.near(&self.found.contacts[i].key).unwrap_or_default();
            primal.force[k] = if u.is_some() { frame.transpose() * known.velocity } else { DVec3::ZERO };
            primal.rows[k].slid = known.slides[1];
            primal.rows[k].b = u.map_or(DVec3::X, |u| u * h);
            primal.rows[k].new = false;
        }
        let settled = self.solve_on_masses(&mut primal, group, false, false);
        if settled || self.last_resort {
            self.take_jumps(&primal, group, h);
            self.remember_velocities(&primal);
        }
        self.primal = primal;
        settled
    }

    /// Store the forces of the velocity solve in the contact cache.
    pub(crate) fn remember_velocities(&mut self, primal: &Primal) {
        let (contacts, chosen) = (&self.found.contacts, &self.chosen);
        self.memory.replace(|old, new| {
            for (k, i) in chosen.iter().enumerate() {
                let (key, velocity) = (contacts[*i as usize].key, primal.rows[k].frame * primal.force[k]);
                let known = old.near(&key).unwrap_or_default();
                new.push((key, Remembered { velocity, slides: [known.slides[0], primal.slides(k)], ..known }));
            }
        });
    }

    /// Solve on the matrix of the sheet or on the joint one; `first` marks the solve after an
    /// assembly.
    fn solve_on_masses(&mut self, primal: &mut Primal, group: &mut Group, first: bool, rough: bool) -> bool {
        let accuracy = self.accuracy(rough, group.pieces());
        let tangent: &mut dyn Tangent = match group.sheet_mut(0).system_mut().filter(|_| self.on_own) {
            Some(system) => system,
            None => &mut self.joint,
        };
        if first {
            self.slots.clear();
            primal.rows.iter_mut().for_each(|row| row.bind(tangent.pattern(), &mut self.slots));
        }
        let mut space = OnMasses { tangent, slots: &self.slots };
        solve_counted(primal, &mut space, &mut self.counters, &accuracy)
    }

    /// Settings of a solve for `sheets` sheets. The gap tolerance grows with the deepest
    /// penetration.
    pub(crate) fn accuracy(&self, rough: bool, sheets: usize) -> Accuracy {
        let sheets = if self.is_glue_alone() { 1 } else { sheets };
        let accuracy = accuracy(rough, sheets, self.deepest == 0);
        let deepest = self.gaps.free.iter().fold(0.0_f64, |deepest, gap| deepest.max(-gap));
        let room = if sheets > 1 {
            (SETTINGS.gap_tolerance_several * deepest).min(SETTINGS.maximum_gap_tolerance)
        } else {
            SETTINGS.gap_tolerance_single * deepest
        };
        Accuracy { gap: accuracy.gap.max(room), ..accuracy }
    }

    /// Constraint of contact `i` in a stage of weight `h` (s), and its initial force (N) in the
    /// contact frame.
    pub(crate) fn row_of(&self, group: &Group, i: usize, h: f64) -> (Row, DVec3) {
        let contact = &self.found.contacts[i];
        let mut row = Row::new(frame_of(contact.normal), self.law(i));
        for (side, sign) in [(&contact.a, 1.0), (&contact.b, -1.0)] {
            match side {
                Side::Sheet { sheet, point } => {
                    let first = self.joint.sheet(*sheet);
                    for (mass, weight) in point.terms() {
                        if let Some((block, free)) = group.sheet(*sheet).free_row(mass) {
                            row.add(first + block, DMat3::from_diagonal(free * (sign * weight)));
                        }
                    }
                }
                Side::Body { body, local } => {
                    if let Some(first) = self.joint.body(group.members.len(), *body) {
                        let mover = &group.movers[*body as usize];
                        let arm = mover.free.place(*local) - mover.free.centre();
                        row.add(first, DMat3::IDENTITY * sign);
                        row.add(first + 1, across(arm) * -sign);
                    }
                }
            }
        }
        row.b = self.position_of(group, i, &row.frame);
        // Such a contact gets no force from a neighbouring one of the same feature either.
        let left_open = self.left_open.binary_search(&contact.key).is_ok();
        let known = self.memory.near(&contact.key).filter(|_| !left_open);
        let is_unknown = self.memory.is_empty()
            || self.gaps.start[i] > SETTINGS.new_contact_gap
            || (self.eager > 0.0 && known.is_none());
        // A single sheet that penetrates where an earlier iteration left it open starts as closed
        // nevertheless; with several sheets the contact would alternate.
        row.new = is_unknown && (!left_open || group.members.len() == 1);
        row.eager = self.eager;
        row.idle = self.is_doubled(group, i);
        row.weigh(|block| self.joint.diagonal_of(group, block, h));
        let known = known.unwrap_or_default();
        row.slid = known.slides[0];
        (row, row.frame.transpose() * known.position)
    }

    /// Store the normal of the contact of each node with a body.
    pub(crate) fn note_masses(&mut self, group: &Group) {
        self.normals.clear();
        self.normals.resize(self.joint.size(), DVec3::ZERO);
        for contact in &self.found.contacts {
            if let (Side::Sheet { sheet, point }, Side::Body { .. }) = (contact.a, contact.b)
                && point.weights[0] == 1.0
                && let Some((row, _)) = group.sheet(sheet).free_row(point.masses[0])
            {
                self.normals[(self.joint.sheet(sheet) + row) as usize] = contact.normal;
            }
        }
    }

    /// Whether contact `i` with a body duplicates the contact of one of its nodes. The force would
    /// be distributed arbitrarily between the two.
    pub(crate) fn is_doubled(&self, group: &Group, i: usize) -> bool {
        let contact = &self.found.contacts[i];
        if i >= self.found.glue_from {
            return false;
        }
        let (Side::Sheet { sheet, point }, Side::Body { .. }) = (contact.a, contact.b) else { return false };
        let first = self.joint.sheet(sheet);
        let doubles = |(mass, weight): (u32, f64)| {
            let row = group.sheet(sheet).free_row(mass).filter(|_| weight > DUPLICATES.node_weight);
            row.is_some_and(|(row, _)| {
                self.normals[(first + row) as usize].dot(contact.normal) > DUPLICATES.normal_cosine
            })
        };
        point.weights[0] != 1.0 && point.terms().any(doubles)
    }

    /// Transfer displacements and forces of the solution to the sheets and solver bodies.
    fn take_displacements(&self, primal: &Primal, group: &mut Group) {
        let (joint, delta, count) = (&self.joint, primal.displacement(), group.members.len());
        for local in 0..count as u32 {
            let (sheet, unit) = group.with_unit(local);
            unit.touch(sheet.masses());
            sheet.spread_rows(&delta[3 * joint.sheet(local) as usize..], &mut unit.jump.dx);
        }
        for (i, (row, p)) in self.chosen.iter().zip(primal.rows.iter().zip(&primal.force)) {
            if *p == DVec3::ZERO {
                continue;
            }
            let contact = &self.found.contacts[*i as usize];
            for (side, sign) in [(&contact.a, 1.0), (&contact.b, -1.0)] {
                if let Side::Sheet { sheet, point } = side {
                    group.with_unit(*sheet).1.push(point, row.frame * *p * sign);
                }
            }
        }
        for local in 0..count as u32 {
            let (sheet, unit) = group.with_unit(local);
            unit.accelerate(&sheet.inverse_mass);
        }
        for (body, mover) in group.movers.iter_mut().enumerate() {
            if let Some(first) = joint.body(count, body as u32) {
                let at = 3 * first as usize;
                (mover.shift, mover.turn) = (DVec3::from_slice(&delta[at..]), DVec3::from_slice(&delta[at + 3..]));
            }
        }
    }

    /// Transfer the velocity jumps of the solution to the sheets and solver bodies.
    fn take_jumps(&self, primal: &Primal, group: &mut Group, h: f64) {
        let (joint, delta, count) = (&self.joint, primal.displacement(), group.members.len());
        for local in 0..count as u32 {
            let (sheet, unit) = group.with_unit(local);
            sheet.spread_rows(&delta[3 * joint.sheet(local) as usize..], &mut unit.jump.dv);
            unit.jump.dv.axes_mut().into_iter().flatten().for_each(|v| *v /= h);
        }
        for (body, mover) in group.movers.iter_mut().enumerate() {
            if let Some(first) = joint.body(count, body as u32) {
                let at = 3 * first as usize;
                (mover.kick, mover.twist) =
                    (DVec3::from_slice(&delta[at..]) / h, DVec3::from_slice(&delta[at + 3..]) / h);
            }
        }
    }
}

/// Settings for `sheets` sheets; `calm` means that the step has not been bisected.
fn accuracy(rough: bool, sheets: usize, calm: bool) -> Accuracy {
    match rough {
        true if sheets > 1 => Accuracy::ROUGH_TOGETHER,
        true => Accuracy::ROUGH,
        false if sheets > 1 && calm && sheets <= SETTINGS.maximum_sheets_of_finest => Accuracy::TOGETHER_FEW,
        false if sheets > 1 && calm => Accuracy::TOGETHER_CALM,
        false if sheets > 1 => Accuracy::TOGETHER,
        false => Accuracy::FINE,
    }
}

/// Solve, and add iterations and factorisations to the counters.
pub(crate) fn solve_counted(
    primal: &mut Primal,
    space: &mut dyn Space,
    counters: &mut ContactCounters,
    accuracy: &Accuracy,
) -> bool {
    let before = (primal.steps, primal.factors);
    let settled = primal.solve(space, accuracy);
    counters.unsettled += u64::from(!settled);
    counters.newton += primal.steps - before.0;
    counters.factors += primal.factors - before.1;
    settled
}

/// Cross-product matrix [r]× of r × .
fn across(r: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, r.z, -r.y), DVec3::new(-r.z, 0.0, r.x), DVec3::new(r.y, -r.x, 0.0))
}
