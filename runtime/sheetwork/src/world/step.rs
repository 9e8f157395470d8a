//! One step of a world: the order of its phases. See `docs/architecture.md`.

use glam::DVec3;
use rapier3d::prelude::{ColliderHandle, RigidBodySet};

use crate::islands::StepContext;
use crate::islands::contact_log::ContactLog;
use crate::islands::event::{Event, EventKind};
use crate::islands::island_manager::UpdatedBody;
use crate::islands::settings::{FallbackSettings, StepSettings};
use crate::islands::step_report::StepReport;
use crate::profiler::Phase;
use crate::rigid::lent::lent_pose;
use crate::rigid::{LentBody, RigidView, RigidWorld};
use crate::sheet::attached_body::{AttachedTo, BodyMotion};
use crate::sheet::{Field, Sheet, Status, air_parameters, attachment};
use crate::world::World;

const SETTINGS: FallbackSettings = StepSettings::DEFAULT.fallback;

impl World {
    /// Take one step of [`World::dt`] with the world's own bodies. The report says whether every
    /// island converged, and otherwise what was done.
    pub fn step(&mut self) -> StepReport {
        self.step_by(self.dt);
        self.clear_loads();
        self.step_report()
    }

    /// Report of the last step.
    pub fn step_report(&self) -> StepReport {
        self.islands.report
    }

    /// Advance by `duration` (s) in equal steps of at most [`World::dt`]. Returns the number of
    /// steps.
    pub fn advance(&mut self, duration: f64) -> u64 {
        let steps = steps_in(duration, self.dt);
        for _ in 0..steps {
            self.step_by(duration / steps as f64);
        }
        if steps > 0 {
            self.clear_loads();
        }
        steps
    }

    pub(super) fn field(&self) -> Field {
        Field { gravity: self.gravity, air: self.air.rate(), air_density: self.air.density, wind: self.air.wind }
    }

    /// Take one step of `dt` (s) with the world's own bodies. It is split where the velocity of a
    /// body on its path changes by so much that a sheet that it strikes would notice.
    fn step_by(&mut self, dt: f64) {
        let end = self.time + dt;
        let Some(at) = self.first_jolt(dt) else { return self.step_part(dt) };
        self.step_part(at - self.time);
        self.step_part(end - self.time);
    }

    /// First time in a step of `dt` (s) at which a body on its path changes its displacement in the
    /// step by more than a fraction of the smallest sheet.
    fn first_jolt(&self, dt: f64) -> Option<f64> {
        let rigid = self.rigid.as_deref()?;
        let size = self.sheets.iter().map(|sheet| sheet.model.initial_diagonal).fold(f64::INFINITY, f64::min);
        let margin = SETTINGS.impact_fraction * dt;
        rigid.first_jolt((self.time + margin, self.time + dt - margin), SETTINGS.impact_displacement * size / dt)
    }

    /// Take one step of `dt` (s): the phases in their order.
    fn step_part(&mut self, dt: f64) {
        self.release_due_pins(dt);
        // The bodies are taken out for the step: the view borrows them while the sheets change.
        let mut rigid = self.rigid.take();
        self.step_bodies(rigid.as_deref_mut(), dt);
        let view = rigid.as_deref().map(RigidWorld::view);
        self.step_sheets(view.as_ref(), rigid.as_deref(), dt);
        self.step_thermal(view.as_ref(), rigid.as_deref(), dt);
        self.update_bodies(rigid.as_deref_mut(), dt);
        self.rigid = rigid;
        self.finish_step(dt, None);
    }

    /// Release the pins whose time has come; a sheet without them may wake.
    fn release_due_pins(&mut self, dt: f64) {
        let now = self.time + 1e-9 * dt;
        self.sheets.iter_mut().for_each(|sheet| attachment::release_pins(sheet, now));
    }

    /// Step the rigid bodies without the sheets, and lead the nodes that are attached to them.
    fn step_bodies(&mut self, rigid: Option<&mut RigidWorld>, dt: f64) {
        let Some(rigid) = rigid else { return };
        self.profiler.measure(Phase::Rigid, || rigid.step(self.time, dt, self.gravity));
        let motion = |owner| {
            let AttachedTo::Own(index) = owner else { return None };
            Some(BodyMotion { index: Some(index), from: *rigid.start(index)?, to: *rigid.state(index)? })
        };
        self.sheets.iter_mut().for_each(|s| _ = s.pins.set_body_motion(self.time, dt, motion));
    }

    /// Lead the nodes attached to bodies of the caller's rigid world in a step of `dt` (s), which
    /// ends `remaining` (s) before the state in `view`. Bodies that are gone let them go.
    fn step_lent_attachments(&mut self, view: &RigidView, dt: f64, remaining: f64) {
        let lent = &self.lent;
        let gravity = self.gravity;
        let motion = |owner| {
            let AttachedTo::Lent(handle) = owner else { return None };
            if let Some(index) = lent.index_of(handle) {
                let from = lent.bodies[index].state;
                return Some(BodyMotion { index: Some(index), from, to: from.free_flight(dt, gravity) });
            }
            let end = lent_pose(view.bodies.get(handle)?);
            let at = |before: f64| end.free_flight(-before, DVec3::ZERO);
            Some(BodyMotion { index: None, from: at(remaining + dt), to: at(remaining) })
        };
        for sheet in self.sheets.iter_mut().filter(|sheet| sheet.pins.is_attached()) {
            attachment::detach_lent(sheet, |handle| !view.bodies.contains(handle));
            if sheet.pins.set_body_motion(self.time, dt, motion) {
                attachment::fix_pinned_nodes(sheet);
            }
        }
    }

    /// Set the dynamic bodies to their state after contact with sheets in a step of `dt` (s).
    fn update_bodies(&mut self, rigid: Option<&mut RigidWorld>, dt: f64) {
        let Some(rigid) = rigid else { return };
        for update in &self.islands.body_updates {
            let UpdatedBody::Own(index) = update.body else { continue };
            rigid.set_state(index as usize, update.end);
            if update.sleeps {
                rigid.put_to_sleep(index as usize);
            }
        }
        if rigid.lost_joints() > 0 {
            self.islands.report.lost_joints = rigid.lost_joints();
        }
        if rigid.has_loads() {
            rigid.finish_loads(dt);
        }
    }

    /// Set the lent bodies to their state after a step of `dt` (s).
    fn update_lent_bodies(&mut self, dt: f64) {
        self.lent.fly(dt, self.gravity);
        for update in &self.islands.body_updates {
            if let UpdatedBody::Lent(index) = update.body {
                self.lent.set(index as usize, update.end, update.sleeps);
            }
        }
    }

    /// Dynamic bodies of the caller after [`World::advance_with`] with a view that is
    /// [`RigidView::pushing`].
    pub fn lent_bodies(&self) -> &[LentBody] {
        &self.lent.bodies
    }

    /// Write the states of the lent bodies that sheets have moved to the caller's `bodies`, which
    /// were those of the view. Call it after [`World::advance_with`]; a second call writes nothing.
    pub fn write_lent_bodies(&mut self, bodies: &mut RigidBodySet) {
        self.lent.write_to(bodies);
    }

    /// Phases after the motion: fracture, events, contacts, buckling, levels of detail, local
    /// refinement. `lent` is the caller's rigid world, if there is one.
    fn finish_step(&mut self, dt: f64, lent: Option<&RigidView>) {
        self.fracture_sheets();
        self.collect_events(dt, lent);
        self.update_contacts(lent);
        self.detect_buckling(self.time - dt);
        self.check_penetration();
        self.update_lod(dt, lent);
        if self.refine_work.is_some() {
            self.refine_sheets();
        }
    }

    /// Advance by `duration` (s) in equal steps of at most [`World::dt`] with the caller's rigid
    /// world, which must already be at the end of that time. Returns the number of steps.
    pub fn advance_with(&mut self, view: &RigidView, duration: f64) -> u64 {
        let steps = steps_in(duration, self.dt);
        let dt = duration / steps as f64;
        self.lent.begin(view, duration, self.gravity);
        for step in 1..=steps {
            self.release_due_pins(dt);
            self.step_lent_attachments(view, dt, (steps - step) as f64 * dt);
            self.step_sheets(Some(view), None, dt);
            self.update_lent_bodies(dt);
            self.step_thermal(Some(view), None, dt);
            self.finish_step(dt, Some(view));
        }
        if steps > 0 {
            self.clear_loads();
        }
        steps
    }

    /// The step budget of the scene, shared among the nodes of the awake sheets.
    fn work_per_node(&self) -> Option<f64> {
        let budget = self.scene.contact.step_budget? as f64;
        let awake = self.sheets.iter().filter(|sheet| sheet.state.status == Status::Awake);
        Some(budget / awake.map(Sheet::node_count).sum::<usize>().max(1) as f64)
    }

    fn step_sheets(&mut self, view: Option<&RigidView>, rigid: Option<&RigidWorld>, dt: f64) {
        self.begin_loads();
        self.update_wind(view, dt);
        self.begin_forces();
        let context = StepContext {
            field: self.field(),
            time: self.time,
            dt,
            view,
            lent: &self.lent,
            sleep: self.sleep,
            sheets_meet: self.scene.contact.sheets,
            work_per_node: self.work_per_node(),
            profiler: &self.profiler,
        };
        self.sheets.iter_mut().for_each(|s| air_parameters::update_pressure(s, context.time + context.dt));
        let many = self.sheets.len() > 1;
        let Self { sheets, sheet_contacts, contact_logs, islands, pool, .. } = self;
        let mut work = |parallel: bool| {
            context.profiler.measure(Phase::Motion, || {
                islands.step((sheets, sheet_contacts, contact_logs), &context, rigid, parallel)
            })
        };
        match pool {
            Some(pool) if many => pool.install(|| work(true)),
            _ => work(false),
        }
        self.finish_forces(dt);
        self.finish_loads();
        // Sheets may become unstable outside the solution of their island.
        let is_unstable = |log: &&ContactLog| log.events.iter().any(|event| event.1 == EventKind::Unstable);
        let unstable = self.contact_logs.iter().filter(is_unstable).count() as u32;
        self.islands.report.stopped = self.islands.report.stopped.max(unstable);
        self.steps += 1;
        self.time += dt;
    }

    /// Move the events of the sheets to the world's list, sheet by sheet: their order is
    /// independent of threads. `dt` is the length of the step, s.
    fn collect_events(&mut self, dt: f64, lent: Option<&RigidView>) {
        for index in 0..self.contact_logs.len() {
            let log = &mut self.contact_logs[index];
            log.report_sleep(self.sheets[index].state.status, self.time - dt, self.time);
            if log.events.is_empty() {
                continue;
            }
            let mut alarms = std::mem::take(&mut log.alarms).into_iter();
            for (time_s, kind, collider) in std::mem::take(&mut log.events) {
                let body = collider.and_then(|collider| self.name_of_collider(collider, lent));
                let alarm = if kind.has_alarm() { alarms.next() } else { None };
                let place_m = alarm.map(|a| a.place_m);
                let event = Event::new(time_s, kind, &self.sheets[index].name, body);
                let first = collider.filter(|_| kind == EventKind::FirstContact);
                let impulse_n_s = first.and_then(|c| self.contact_impulse(index, c, event.body.as_deref()));
                let user_data = lent.zip(collider).and_then(|(view, c)| Some(view.colliders.get(c)?.user_data));
                self.events.push(Event { alarm, place_m, impulse_n_s, user_data, ..event });
            }
        }
    }

    /// Name of the body of a collider; "collider N" for one of the caller's rigid world.
    fn name_of_collider(&self, collider: ColliderHandle, lent: Option<&RigidView>) -> Option<String> {
        match lent {
            Some(_) => Some(format!("collider {}", collider.into_raw_parts().0)),
            None => self.rigid.as_deref()?.name_of(collider).map(str::to_owned),
        }
    }
}

/// Number of equal steps of at most `dt` in `duration`; at least one, none if the duration is not
/// positive or not finite.
fn steps_in(duration: f64, dt: f64) -> u64 {
    if duration <= 0.0 || !duration.is_finite() {
        return 0;
    }
    // The slack absorbs rounding of a duration that is a whole number of steps.
    ((duration / dt) - 1e-9).ceil().max(1.0) as u64
}
