//! One step of an island with sheets of explicit integrators.
//!
//! Each sheet is first advanced alone: its integrator takes it through the step, and contact of
//! nodes with static and kinematic bodies is resolved node by node
//! ([`crate::contact::node::detection`]). All other contacts are resolved at the end of the step:
//! edges and corners of bodies, dynamic bodies, other sheets and self-contact, by the contact
//! constraints and the two solves of implicit integrators
//! ([`crate::contact::outer_iteration::solve_explicit`]), with the node masses as system matrix. A
//! sheet near none of these costs a few box tests. A sheet with an implicit integrator in the same
//! island is treated in the same way.

pub(crate) mod sheet_step;
#[cfg(test)]
mod tests;

use crate::parallel::*;
use glam::DVec3;

use crate::collision::narrow_phase::DetectionScope;
use crate::contact::adhesion::update_bonds;
use crate::contact::node::flexion::hold_limits_with_contacts;
use crate::contact::outer_iteration::{ContactMargins, DetectionMode, solve_explicit};
use crate::contact::{IslandView, SheetContact};
use crate::islands::contact_log::ContactLog;
use crate::islands::explicit::sheet_step::{advance_free, finish_step};
use crate::islands::instability;
use crate::islands::island_builder::broad_phase_margin;
use crate::islands::island_detection::IslandDetection;
use crate::islands::island_manager::{IslandContext, IslandState, SteppedSheets};
use crate::islands::step_report::StepReport;
use crate::sheet::forces::{SheetForces, with_record};
use crate::sheet::instability::energy_at_start;
use crate::sheet::{ForcePartner, PRESCRIBED_MOTION_ENERGY_FACTOR, Sheet, Status, attachment, node_contact};

/// Result of the contacts at the end of a step.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ContactSolve {
    /// A single sheet has none: its motion is unchanged and its step is not ended.
    NotNeeded,
    /// The step is ended without contacts of the solver.
    Ended,
    /// The step is ended with contacts of the solver.
    Solved,
}

impl IslandContext<'_> {
    /// Step the island of the sheets `all`, whose indices in the world are `ids`.
    pub fn step_explicit(&self, mut all: SteppedSheets, ids: &[u32], parallel: bool) {
        if !self.advance_and_resolve(&mut all, ids, parallel) {
            update_bonds(all.sheets, None, self.surroundings);
        }
    }

    /// Advance the sheets and resolve their contacts. Returns whether the contact solver ran, and
    /// with it the update of the bonds.
    fn advance_and_resolve(&self, all: &mut SteppedSheets, ids: &[u32], parallel: bool) -> bool {
        if let Some(Some(state)) = all.states.first_mut() {
            state.progress.report = StepReport { islands: 1, ..StepReport::default() };
        }
        if all.sheets.len() != 1 {
            self.advance_all_free(all, parallel);
            return self.resolve_contacts(all, ids, parallel) == ContactSolve::Solved;
        }
        let (sheet, contact, touches) = (&mut all.sheets[0], &mut all.contacts[0], &mut all.touches[0]);
        instability::begin_energy_check(sheet);
        let last = advance_free(sheet, contact, touches, self.context);
        if sheet.state.status != Status::Awake {
            return false;
        }
        let is_near = self.is_near(sheet, contact);
        let solve = if is_near { self.resolve_contacts(all, ids, parallel) } else { ContactSolve::NotNeeded };
        if solve == ContactSolve::NotNeeded {
            let (sheet, touches) = (&mut all.sheets[0], &mut all.touches[0]);
            if sheet.state.touching.contains(&true)
                && instability::finish_energy_check(sheet, touches, self.context, 0.0)
            {
                with_record(sheet, |forces, _| forces.cancel());
            }
            finish_step(sheet, touches, self.context, last);
        }
        solve == ContactSolve::Solved
    }

    fn advance_all_free(&self, all: &mut SteppedSheets, parallel: bool) {
        type SteppedSheet<'a> = ((&'a mut Sheet, &'a mut SheetContact), &'a mut ContactLog);
        let one = |((sheet, contact), touches): SteppedSheet| {
            instability::begin_energy_check(sheet);
            advance_free(sheet, contact, touches, self.context);
        };
        if parallel {
            all.sheets.par_iter_mut().zip(all.contacts.par_iter_mut()).zip(all.touches.par_iter_mut()).for_each(one);
        } else {
            all.sheets.iter_mut().zip(all.contacts.iter_mut()).zip(all.touches.iter_mut()).for_each(one);
        }
    }

    /// Whether a single sheet may have contacts beyond those of its nodes with static bodies: a
    /// dynamic body near its path, attachments, and for one layer edges or self-contact. Lattices
    /// of several layers meet static bodies with their nodes alone: the many constraints along a
    /// ridge keep their coarse steps from resting.
    fn is_near(&self, sheet: &Sheet, contact: &mut SheetContact) -> bool {
        contact.prepare_surface(sheet);
        let stack = contact.surface.as_ref().is_some_and(|s| s.is_multilayer());
        if !stack || attachment::has_dynamic_attachments(sheet) {
            return true;
        }
        let room = node_contact::contact_offset(sheet) + broad_phase_margin(sheet);
        let Some((low, high)) = swept_box(sheet, room) else { return false };
        self.surroundings.colliders.iter().any(|part| {
            let gives = self.surroundings.bodies.get(part.body as usize).is_some_and(|b| b.start.is_dynamic());
            gives && part.low.cmple(high).all() && part.high.cmpge(low).all()
        })
    }

    /// Resolve contacts at the end of the step with dynamic bodies, sharp features and sheets, and
    /// end the step, unless a single sheet has no contact.
    fn resolve_contacts(&self, all: &mut SteppedSheets, ids: &[u32], parallel: bool) -> ContactSolve {
        let SteppedSheets { sheets, contacts, touches, states } = all;
        let Some(state) = states.first_mut() else { return ContactSolve::NotNeeded };
        let dt = self.context.dt;
        for (sheet, contact) in sheets.iter_mut().zip(contacts.iter_mut()) {
            contact.prepare_surface(sheet);
            sheet.work.touched_colliders.clear();
            node_contact::begin_contact_stage(sheet, dt);
        }
        let IslandState { contact: workspace, progress, detection: work, body_updates } =
            &mut **state.get_or_insert_default();
        let solver_bodies = std::mem::take(&mut workspace.solver_bodies);
        workspace.profiler.clone_from(self.context.profiler);
        workspace.impulses.begin_step(sheets.iter().any(|sheet| sheet.work.forces.is_some()));
        let mut island =
            IslandView { sheets, contacts, solver_bodies, parallel, body_penetration: 0.0, stacked_bodies: 0 };
        let mut detection = IslandDetection {
            view: self.context.view,
            surroundings: self.surroundings,
            body_contacts: self.body_contacts,
            gravity: self.context.field.gravity,
            sheets_meet: self.context.sheets_meet,
            ids,
            work: &mut *work,
            profiler: self.context.profiler,
        };
        let idle = !self.begin(&mut detection, &mut island);
        let touched = !idle && {
            detection.begin_stage(&mut island, 0.0, dt);
            let touched = solve_explicit(&mut island, workspace, dt, |island, found| {
                detection.detect_contacts(island, DetectionMode::FromStart, ContactMargins::resting(island), found)
            });
            detection.end_stage(&mut island);
            touched
        };
        island.each_response(|sheet, response| {
            node_contact::apply_contact(sheet, (touched && response.is_touched()).then_some(&response.jump));
        });
        if touched {
            workspace.log_stage_impulses(&island, dt);
            self.record_impulses(island.sheets, ids, workspace, detection.work);
            island
                .for_each_sheet(|sheet| with_record(sheet, |forces, sheet| forces.begin_node_contact(&sheet.state.v)));
            hold_limits_with_contacts(&mut island, workspace, dt);
            let add = |forces: &mut SheetForces, sheet: &mut Sheet| {
                forces.add_node_contact(sheet, |_| ForcePartner::None);
            };
            island.for_each_sheet(|sheet| with_record(sheet, add));
        }
        let brought = energy_of_surroundings(&island);
        let IslandView { sheets, solver_bodies, .. } = island;
        let lone = idle && sheets.len() == 1;
        let mut put_back = false;
        if !lone {
            for (sheet, touches) in sheets.iter_mut().zip(touches.iter_mut()) {
                if touched || sheet.state.touching.contains(&true) {
                    let is_put_back = instability::finish_energy_check(sheet, touches, self.context, brought);
                    put_back |= is_put_back;
                    if is_put_back {
                        with_record(sheet, |forces, _| forces.cancel());
                    }
                }
            }
        }
        if idle || put_back {
            workspace.reset();
            progress.reset_contact();
        } else {
            self.record_contacts(sheets, workspace, work);
            update_bonds(sheets, Some((workspace, work.bodies())), self.surroundings);
            self.update_bodies(&solver_bodies, work, workspace, body_updates);
        }
        if !lone {
            for work in sheets.iter_mut().map(|sheet| &mut sheet.work) {
                work.x_before.clone_from(&work.start.0);
            }
            self.finish_sheets(sheets, touches);
            if self.context.sleep {
                self.sleep_if_resting(sheets, body_updates);
            }
        }
        workspace.solver_bodies = solver_bodies;
        match idle || put_back {
            _ if lone => ContactSolve::NotNeeded,
            true => ContactSolve::Ended,
            false => ContactSolve::Solved,
        }
    }

    /// Begin detection for an island whose free motions are known. Returns `false` when contact is
    /// impossible.
    fn begin(&self, detection: &mut IslandDetection, island: &mut IslandView) -> bool {
        let mut around = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut travel, mut margin) = (0.0_f64, 0.0_f64);
        for sheet in island.sheets.iter() {
            let (low, high) = node_contact::bounding_box(sheet);
            around = (around.0.min(low), around.1.max(high));
            travel = travel.max(node_contact::largest_travel(sheet));
            margin = margin.max(broad_phase_margin(sheet));
        }
        let bodies = self.surroundings.bodies.iter().filter(|b| b.moves());
        let fastest = bodies.map(|b| b.start.velocity().length().max(b.end.velocity().length())).fold(0.0, f64::max);
        let reach = travel + fastest * self.context.dt + margin;
        // A lone sheet has resolved faces of static bodies in its free advance.
        detection.work.limit(DetectionScope { faces: false, stacks: false });
        detection.begin(island, around, reach);
        let gives = island.solver_bodies.iter().any(|m| m.is_dynamic());
        if island.sheets.len() > 1 || gives || detection.work.has_self_contact() {
            detection.work.limit(DetectionScope { faces: true, stacks: false });
            detection.begin(island, around, reach);
        }
        !detection.is_idle(island)
    }
}

/// Energy that contact partners could transfer to a sheet of the island, J: the kinetic energy of
/// dynamic bodies and other sheets, and the work of kinematic bodies. Zero when no sheet is
/// monitored.
fn energy_of_surroundings(island: &IslandView) -> f64 {
    let sheets = || island.sheets.iter();
    if !sheets().any(|s| s.recovery.is_some()) {
        return 0.0;
    }
    let weight: f64 = sheets().map(Sheet::total_mass).sum();
    let bodies = island.solver_bodies.iter().map(|m| {
        if m.is_dynamic() {
            m.start.kinetic_energy()
        } else {
            weight * PRESCRIBED_MOTION_ENERGY_FACTOR * m.start.velocity().length_squared()
        }
    });
    let others = if island.sheets.len() > 1 { sheets().map(energy_at_start).sum() } else { 0.0 };
    bodies.sum::<f64>() + others
}

/// Corners of the box that a sheet swept in the step, m, enlarged by `room` (m).
fn swept_box(sheet: &Sheet, room: f64) -> Option<(DVec3, DVec3)> {
    let (a, b) = sheet.work.start.0.bounds()?;
    let (c, d) = sheet.state.x.bounds()?;
    Some((a.min(c) - room, b.max(d) + room))
}
