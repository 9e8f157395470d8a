//! Step of one island by an implicit integrator, and the end of the step that all islands share:
//! contacts recorded, bodies updated, sheets put to sleep. An island with a sheet of an explicit
//! integrator is stepped by [`crate::islands::explicit`]: its time steps are as short as that
//! integrator requires.

use glam::DVec3;

use crate::collision::constraint::ContactSide;
use crate::contact::IslandView;
use crate::contact::adhesion::update_bonds;
use crate::contact::solver_body::SolverBody;
use crate::contact::workspace::ContactWorkspace;
use crate::islands::contact_log::{ContactLog, ContactRecorder};
use crate::islands::event::EventKind;
use crate::islands::explicit::sheet_step::apply_thickness_limit;
use crate::islands::implicit_step::{IslandSolve, Substep};
use crate::islands::island_builder::broad_phase_margin;
use crate::islands::island_detection::{DetectionCache, IslandDetection};
use crate::islands::island_manager::{BodyUpdate, IslandContext, IslandState, SteppedSheets, UpdatedBody};
use crate::islands::resting::update_rest_time;
use crate::islands::rigid_motion::FreeRotation;
use crate::islands::settings::{IslandSettings, StepSettings};
use crate::islands::step_report::StepReport;
use crate::islands::unstable::{is_unstable, stop_unstable};
use crate::scene::sleep::SLEEP;
use crate::sheet::{Interpenetration, Sheet, Status, accelerations, bonds, creep, node_contact, stage};

const SETTINGS: IslandSettings = StepSettings::DEFAULT.islands;

/// Apply the flexion and thickness limits after a step of `dt` (s).
fn apply_limits(sheet: &mut Sheet, dt: f64) {
    if let Some(limit) = &sheet.parameters.flexion.limit {
        limit.apply(&sheet.state.x, &mut sheet.state.v, &sheet.inverse_mass, dt);
    }
    apply_thickness_limit(sheet, dt);
}

/// Whether a sheet moves so fast within itself that it may meet itself in a step of `dt` (s).
fn may_fold(sheet: &Sheet, dt: f64) -> bool {
    let size = SETTINGS.folding_displacement * sheet.model.initial_diagonal;
    let mean = sheet.state.v.iter().sum::<DVec3>() / sheet.node_count().max(1) as f64;
    sheet.state.v.iter().any(|v| (v - mean).length() * dt > size)
}

impl IslandContext<'_> {
    /// Step the island of the sheets `all`, whose indices in the world are `ids`.
    pub fn step(&self, all: SteppedSheets, ids: &[u32], parallel: bool) {
        let context = self.context;
        // The collision surface is built from the state before the first motion.
        all.contacts.iter_mut().zip(&*all.sheets).for_each(|(contact, sheet)| contact.prepare_surface(sheet));
        if all.sheets.iter().any(node_contact::is_explicit) {
            self.step_explicit(all, ids, parallel);
            return;
        }
        let SteppedSheets { sheets, contacts, touches, states } = all;
        let Some(state) = states.first_mut() else { return };
        for (sheet, touches) in sheets.iter_mut().zip(touches.iter_mut()) {
            node_contact::resize_workspace(sheet);
            touches.begin(context.time);
            sheet.state.touching.fill(false);
            sheet.work.touched_colliders.clear();
            sheet.work.x_before.copy_from(&sheet.state.x);
            if sheet.recovery.is_some() {
                sheet.work.v_before.copy_from(&sheet.state.v);
            }
        }
        sheets.iter_mut().for_each(bonds::apply_bond_forces);
        let IslandState { contact: workspace, progress, detection: work, body_updates } =
            &mut **state.get_or_insert_default();
        let solver_bodies = std::mem::take(&mut workspace.solver_bodies);
        workspace.profiler.clone_from(context.profiler);
        let budget_of = |work: f64| (work * sheets.iter().map(Sheet::node_count).sum::<usize>() as f64) as u64;
        workspace.budget = context.work_per_node.map(budget_of);
        workspace.impulses.begin_step(sheets.iter().any(|sheet| sheet.work.forces.is_some()));
        let (around, reach) = self.extent(sheets);
        let mut island =
            IslandView { sheets, contacts, solver_bodies, parallel, body_penetration: 0.0, stacked_bodies: 0 };
        let mut detection = IslandDetection {
            view: context.view,
            surroundings: self.surroundings,
            body_contacts: self.body_contacts,
            gravity: context.field.gravity,
            sheets_meet: context.sheets_meet,
            ids,
            work: &mut *work,
            profiler: context.profiler,
        };
        detection.begin(&mut island, around, reach);
        let part = Substep { field: context.field, time: context.time, done: 0.0, dt: context.dt, bisections: 0 };
        let folds = |sheet: &Sheet| may_fold(sheet, context.dt);
        let is_idle = detection.is_idle(&island) && !island.sheets.iter().any(folds);
        let is_alone = !is_idle || island.solver_bodies.is_empty();
        let rotation = is_alone.then(|| FreeRotation::of(&island, context.field, context.dt)).flatten();
        progress.least_bisection = rotation.as_ref().map_or(0, |rotation| rotation.bisections(context.dt));
        if is_idle {
            island.for_each_sheet(|sheet| {
                if !sheet.pins.is_empty() {
                    sheet.pins.prescribe_velocities(context.time, context.dt, &sheet.state.x, &mut sheet.state.v);
                }
                let parts = 1 << progress.least_bisection;
                let dt = context.dt / f64::from(parts);
                for part in 0..parts {
                    accelerations::advance(sheet, context.field, context.time + dt * f64::from(part), dt);
                }
            });
            workspace.reset();
            progress.report = StepReport { islands: 1, ..StepReport::default() };
            progress.reset_contact();
        } else {
            let progress = &mut *progress;
            IslandSolve { view: &mut island, workspace, progress, detection: &mut detection }.advance(part);
            if progress.begins_fallbacks() {
                touches.iter_mut().for_each(|t| t.events.push((context.time + context.dt, EventKind::GivenUp, None)));
            }
            progress.previous = progress.report;
        }
        if let Some(rotation) = rotation {
            rotation.restore(&mut island, context.field, context.dt);
        }
        if progress.count_fallback_step(SETTINGS.fallbacks_before_overlap_test) {
            island.for_each_sheet(Sheet::invalidate_interpenetration);
        }
        island.for_each_sheet(|sheet| apply_limits(sheet, context.dt));
        let IslandView { sheets, solver_bodies, .. } = island;
        self.record_contacts(sheets, workspace, work);
        workspace.closed_in_step.clear();
        self.record_impulses(sheets, ids, workspace, work);
        sheets.iter_mut().for_each(bonds::clear_node_contacts);
        update_bonds(sheets, Some((workspace, work.bodies())), self.surroundings);
        sheets.iter_mut().for_each(bonds::remove_bond_forces);
        self.finish_sheets(sheets, touches);
        // Bodies that cannot have met a sheet move as Rapier computes.
        if !is_idle {
            self.update_bodies(&solver_bodies, work, workspace, body_updates);
        }
        if context.sleep {
            self.sleep_if_resting(sheets, body_updates);
        }
        workspace.solver_bodies = solver_bodies;
    }

    /// Record the contacts at the end of the step and the contacts with restitution during the
    /// step: touching nodes and touched bodies.
    pub fn record_contacts(&self, sheets: &mut [Sheet], workspace: &ContactWorkspace, work: &DetectionCache) {
        let handle_of =
            |part: u32| work.part(part).and_then(|p| self.surroundings.colliders.get(p as usize)).map(|p| p.handle);
        workspace.for_each_closed(|contact, part| {
            let handle = handle_of(part);
            for side in [contact.a, contact.b] {
                if let ContactSide::Sheet { sheet, point } = side {
                    let sheet = &mut sheets[sheet as usize];
                    for (mass, _) in point.terms() {
                        let noted = std::mem::replace(&mut sheet.state.touching[mass as usize], true);
                        // Contacts of nodes with static bodies were recorded during free flight.
                        if let Some(handle) = handle.filter(|_| !noted || !node_contact::solves_node_by_node(sheet)) {
                            sheet.work.touched_colliders.push((handle, mass));
                        }
                    }
                }
            }
        });
        for work in sheets.iter_mut().map(|sheet| &mut sheet.work) {
            work.touched_at_end = work.touched_colliders.len();
        }
        for [sheet, mass, part] in workspace.closed_in_step.iter().copied() {
            let Sheet { work, state, .. } = &mut sheets[sheet as usize];
            let noted = std::mem::replace(&mut state.touching[mass as usize], true);
            let Some(handle) = handle_of(part) else { continue };
            // The list at the end of the step can lack a body from which the node rebounded.
            let (at_end, added) = work.touched_colliders.split_at(work.touched_at_end);
            let is_new = || !at_end.iter().any(|(known, _)| *known == handle) && !added.contains(&(handle, mass));
            if !noted || is_new() {
                work.touched_colliders.push((handle, mass));
            }
        }
    }

    /// Append the new states of the dynamic bodies to `claims`.
    pub fn update_bodies(
        &self,
        solver_bodies: &[SolverBody],
        work: &DetectionCache,
        workspace: &ContactWorkspace,
        updates: &mut Vec<BodyUpdate>,
    ) {
        for (number, (solver_body, index)) in solver_bodies.iter().zip(work.bodies()).enumerate() {
            let over = &self.surroundings.bodies[*index as usize];
            let body = over.world_index.map(UpdatedBody::Own).or(over.lent_index.map(UpdatedBody::Lent));
            if let Some(body) = body.filter(|_| solver_body.is_dynamic()) {
                let pull = self.context.field.gravity * self.context.dt;
                let resist = |radius| {
                    workspace.support_of(number as u32, solver_bodies).resist(&solver_body.start, radius, pull)
                };
                let end = over.ball.map_or(solver_body.start, resist);
                updates.push(BodyUpdate { body, end, extent: over.extent, sleeps: false });
            }
        }
    }

    /// Bounding box of the island, thickness included, and the maximum displacement of its objects,
    /// m.
    fn extent(&self, sheets: &[Sheet]) -> ((DVec3, DVec3), f64) {
        let mut around = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut speed, mut margin) = (0.0_f64, 0.0_f64);
        for sheet in sheets {
            let (low, high) = node_contact::bounding_box(sheet);
            around = (around.0.min(low), around.1.max(high));
            speed = speed.max(sheet.max_speed());
            margin = margin.max(broad_phase_margin(sheet));
        }
        // A moving body in reach may hit a sheet and set its speed.
        for over in self.surroundings.bodies.iter().filter(|b| b.moves()) {
            speed = speed.max(over.start.velocity().length()).max(over.end.velocity().length());
        }
        let (dt, gravity) = (self.context.dt, self.context.field.gravity.length());
        (around, speed * dt + gravity * dt * dt + margin)
    }

    /// Stop unstable sheets, place pins, and record touches and events.
    pub fn finish_sheets(&self, sheets: &mut [Sheet], touches: &mut [ContactLog]) {
        let context = self.context;
        for (sheet, touches) in sheets.iter_mut().zip(touches) {
            if is_unstable(sheet) || std::mem::take(&mut sheet.work.stage.has_failed) {
                stop_unstable(sheet, touches, context, context.dt);
                continue;
            }
            if sheet.state.interpenetration == Interpenetration::Detected {
                sheet.state.interpenetration = Interpenetration::Reported;
                touches.events.push((context.time, EventKind::Crossing, None));
            }
            if !sheet.pins.is_empty() {
                sheet.pins.prescribe_positions(context.time + context.dt, &mut sheet.state.x);
            }
            sheet.state.counters.contacts += sheet.work.touched_colliders.len() as u64;
            if let Some(view) = context.view {
                let mut recorder = ContactRecorder { touches: &mut *touches, view };
                sheet.work.touched_colliders.iter().for_each(|(handle, _)| recorder.touched(*handle));
            }
            touches.end(context.time + context.dt, sheet);
        }
    }

    /// Put the island to sleep when all its objects have been resting for the sleep delay.
    pub fn sleep_if_resting(&self, sheets: &mut [Sheet], updates: &mut [BodyUpdate]) {
        let dt = self.context.dt;
        let mut all = true;
        for sheet in sheets.iter_mut() {
            if sheet.state.status != Status::Awake {
                continue;
            }
            // Sleeping requires a pin or a contact: a free sheet can drift slowly.
            let touched = !sheet.pins.is_empty() || sheet.state.touching.contains(&true);
            let held = touched && !creep::is_creeping(sheet);
            all &= update_rest_time(sheet, held, (dt, dt));
        }
        let slow = |c: &BodyUpdate| c.end.velocity().length() + c.end.spin().length() * c.extent < SLEEP.speed;
        if !all || !updates.iter().all(slow) {
            return;
        }
        for sheet in sheets.iter_mut() {
            if sheet.state.status != Status::Awake {
                continue;
            }
            sheet.state.status = Status::Asleep;
            sheet.state.v.clear();
            stage::restart_engine(sheet);
        }
        updates.iter_mut().for_each(|c| c.sleeps = true);
    }
}
