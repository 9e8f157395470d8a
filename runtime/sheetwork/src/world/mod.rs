//! A world: sheets, rigid bodies, gravity, and the one function that steps them.
//!
//! Built from a [`Scene`]; read by those who show it; changed between steps by its setters, or by path with
//! [`World::set`], with the same checks as a scene file.

pub(crate) mod bodies;
pub(crate) mod failure_events;
pub mod journal;
pub(crate) mod lod;
pub mod lod_cost;
pub(crate) mod parameters;
pub(crate) mod playback;
pub mod recording;
pub(crate) mod remap;
pub(crate) mod report;
pub(crate) mod serialization;
pub(crate) mod snapshot;
pub(crate) mod state_hash;
pub(crate) mod suggestions;
pub(crate) mod thermal;

use std::sync::Arc;

use glam::DVec3;

pub use crate::world::parameters::Parameter;
pub use crate::world::report::{BodyReport, OpeningReport, Report, SheetReport, TemperatureReport};
pub use crate::world::snapshot::Snapshot;

use crate::contact::node::detection::deepest;
use crate::error::{InputError, check_range};
use crate::integrators::EngineKind;
use crate::islands::Stage;
use crate::islands::event::{Event, EventKind, Touches};
use crate::islands::island_manager::Groups;
use crate::profiler::{Phase, Watch, Watched};
use crate::rigid::{BodyState, RigidView, RigidWorld};
use crate::scene::{Air, PairSpec, Scene, SheetSpec, body_name, validate};
use crate::sheet::Field;
use crate::sheet::{Energy, Equilibrium, Sheet, Status};
use crate::thermal::Room;

/// Sheets and bodies in time.
pub struct World {
    scene: Scene,
    sheets: Vec<Sheet>,
    touches: Vec<Touches>,
    rigid: Option<RigidWorld>,
    gravity: DVec3,
    air: Air,
    engine: EngineKind,
    tolerance: f64,
    dt: f64,
    time: f64,
    steps: u64,
    events: Vec<Event>,
    sleep: bool,
    buckling: bool,
    pool: Option<Arc<rayon::ThreadPool>>,
    groups: Groups,
    /// What heats the sheets; none where nothing does.
    heat: Option<Box<Room>>,
    /// Which grids sheets are on; none where none has levels.
    detail: Option<Box<lod::Detail>>,
    watch: Watched,
    /// A sum of what it was made of, for snapshots.
    make: u32,
    /// Events before those in the list: told of in another world, which a snapshot is of.
    told_before: u64,
}

impl World {
    /// A world with its own rigid bodies.
    ///
    /// # Errors
    /// When the scene, or a file it names, is not valid.
    pub fn new(scene: &Scene) -> Result<Self, InputError> {
        let checked = validate::built(scene);
        let built = checked.and_then(|()| RigidWorld::build(scene)).and_then(|rigid| Self::build(scene, Some(rigid)));
        built.map_err(|e| scene.located(e))
    }

    /// A world without bodies of its own: the sheets meet what is lent to [`World::advance_with`]. The scene's bodies and room
    /// are not built.
    ///
    /// # Errors
    /// When the scene, or a file it names, is not valid.
    pub fn without_bodies(scene: &Scene) -> Result<Self, InputError> {
        validate::built(scene).and_then(|()| Self::build(scene, None)).map_err(|e| scene.located(e))
    }

    fn build(scene: &Scene, rigid: Option<RigidWorld>) -> Result<Self, InputError> {
        validate::values(scene)?;
        let mut sheets = Vec::with_capacity(scene.sheets.len());
        for index in 0..scene.sheets.len() {
            sheets.push(Sheet::build(scene, index).map_err(|mut e| {
                if e.file.is_some() {
                    e.problem = format!("{} (the file of sheets.{index})", e.problem);
                } else {
                    let dot = if e.field.is_empty() { "" } else { "." };
                    e.field = format!("sheets.{index}{dot}{}", e.field);
                }
                e
            })?);
        }
        for (index, sheet) in sheets.iter_mut().enumerate() {
            glue(sheet, rigid.as_ref())
                .map_err(|e| InputError::new(format!("sheets.{index}.{}", e.field), e.problem))?;
        }
        let heat = Room::of(scene)?.map(Box::new);
        if heat.is_some() {
            // An oven that is on finds them as they come in.
            sheets.iter_mut().for_each(|s| s.begin_heat(scene.ambient_temperature));
        }
        for (index, (sheet, spec)) in sheets.iter_mut().zip(&scene.sheets).enumerate() {
            let warmed = sheet.warm(&spec.spots, scene.ambient_temperature);
            warmed.map_err(|e| InputError::new(format!("sheets.{index}.spots.{}", e.field), e.problem))?;
        }
        let touches = sheets.iter().map(|_| Touches::default()).collect();
        let own = named(scene);
        let detail = lod::Detail::of(scene, &sheets);
        Ok(Self {
            sheets,
            touches,
            rigid,
            gravity: scene.gravity,
            air: scene.air,
            engine: scene.engine,
            tolerance: scene.tolerance,
            dt: scene.dt,
            time: 0.0,
            steps: 0,
            events: Vec::new(),
            sleep: true,
            buckling: false,
            pool: None,
            groups: Groups::default(),
            heat,
            detail,
            watch: Watched::default(),
            make: serialization::make_of(&own),
            told_before: 0,
            scene: own,
        })
    }

    /// Puts everything back to the scene it was built from; the number of threads, sleeping and the watch stay as set.
    ///
    /// # Errors
    /// When a file the scene names can no longer be read; the world is then as before.
    pub fn reset(&mut self) -> Result<(), InputError> {
        let rigid = if self.rigid.is_some() { Some(RigidWorld::build(&self.scene)?) } else { None };
        let fresh = Self::build(&self.scene, rigid)?;
        let (sleep, buckling, pool) = (self.sleep, self.buckling, self.pool.take());
        let watch = std::mem::take(&mut self.watch);
        *self = Self { sleep, buckling, pool, watch, ..fresh };
        if let Some(rigid) = &mut self.rigid {
            rigid.set_sleep(sleep);
        }
        Ok(())
    }

    /// Steps sheets on this many threads; 1 uses the caller's. The result does not depend on it.
    ///
    /// # Errors
    /// When the system refuses to start the threads.
    pub fn set_threads(&mut self, threads: usize) -> Result<(), InputError> {
        self.pool = if threads <= 1 {
            None
        } else {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            Some(Arc::new(pool.map_err(|e| InputError::new("threads", e.to_string()))?))
        };
        Ok(())
    }

    /// Whether sheets and bodies that come to rest are put to sleep (they are, unless told otherwise).
    pub fn set_sleep(&mut self, sleep: bool) {
        self.sleep = sleep;
        if let Some(rigid) = &mut self.rigid {
            rigid.set_sleep(sleep);
        }
        if !sleep {
            self.sheets.iter_mut().for_each(Sheet::wake);
        }
    }

    /// Has `watch` told which part of a step is under way, from the next step on; nobody for none. Results do not depend on it.
    pub fn set_watch(&mut self, watch: Option<Arc<dyn Watch>>) {
        self.watch = Watched(watch);
    }

    /// Takes one step of [`World::dt`] with the world's own bodies.
    pub fn step(&mut self) {
        self.step_by(self.dt);
    }

    /// Advances by `duration` s in equal steps of at most [`World::dt`]; returns how many.
    pub fn advance(&mut self, duration: f64) -> u64 {
        let steps = steps_in(duration, self.dt);
        for _ in 0..steps {
            self.step_by(duration / steps as f64);
        }
        steps
    }

    /// Sets gravity (m/s²) beyond what a scene may have: for rigs that look for a limit.
    pub fn set_gravity_unbounded(&mut self, gravity: DVec3) {
        self.gravity = gravity;
    }

    /// Moves every sheet to its equilibrium under gravity, its forces and the wind, without contact and without time
    /// passing; `tolerance` is how far (m) the last step of the search may go. How each was found, in order.
    pub fn settle(&mut self, tolerance: f64) -> Vec<Equilibrium> {
        let field = self.field();
        self.sheets.iter_mut().map(|s| s.settle(field, tolerance)).collect()
    }

    /// Lets every sheet flow for `dt` s, in equilibrium throughout; see [`Sheet::flow_settled`]. The world's time stands.
    pub fn flow_settled(&mut self, dt: f64, tolerance: f64) -> Vec<Equilibrium> {
        let field = self.field();
        self.sheets.iter_mut().map(|s| s.flow_settled(field, dt, tolerance)).collect()
    }

    fn field(&self) -> Field {
        Field { gravity: self.gravity, air: self.air.rate(), air_density: self.air.density, wind: self.air.wind }
    }

    fn step_by(&mut self, dt: f64) {
        let now = self.time + 1e-9 * dt;
        for (sheet, touches) in self.sheets.iter_mut().zip(&mut self.touches) {
            let slept = sheet.status == Status::Asleep;
            sheet.release_pins(now);
            if slept && sheet.status != Status::Asleep {
                touches.events.push((self.time, EventKind::Woke, None));
            }
        }
        // Taken out for the step: the view borrows it while the sheets are changed.
        let mut rigid = self.rigid.take();
        if let Some(rigid) = &mut rigid {
            self.watch.within(Phase::Rigid, || rigid.step(self.time, dt, self.gravity));
            let states = |index| Some((*rigid.start(index)?, *rigid.state(index)?));
            self.sheets.iter_mut().for_each(|s| s.follow(self.time, dt, states));
        }
        let view = rigid.as_ref().map(RigidWorld::view);
        self.step_sheets(view.as_ref(), rigid.as_ref(), dt);
        self.step_heat(view.as_ref(), rigid.as_ref(), dt);
        if let Some(rigid) = &mut rigid {
            for claim in &self.groups.claims {
                rigid.claim(claim.body, claim.end);
                if claim.sleeps {
                    rigid.freeze(claim.body);
                }
            }
        }
        self.rigid = rigid;
        self.tear_sheets();
        self.collect_events(|world, collider| world.rigid.as_ref()?.name_of(collider).map(str::to_owned));
        self.look_for_buckling(self.time - dt);
        self.follow_detail(dt);
    }

    /// Advances by `duration` s in equal steps of at most [`World::dt`] against a caller's rigid world, which must already be
    /// at the end of that time; returns how many.
    pub fn advance_with(&mut self, view: &RigidView, duration: f64) -> u64 {
        let steps = steps_in(duration, self.dt);
        let dt = duration / steps as f64;
        for _ in 0..steps {
            self.step_sheets(Some(view), None, dt);
            self.step_heat(Some(view), None, dt);
            self.tear_sheets();
            self.collect_events(|_, collider| Some(format!("collider {}", collider.into_raw_parts().0)));
            self.look_for_buckling(self.time - dt);
            self.follow_detail(dt);
        }
        steps
    }

    fn step_sheets(&mut self, view: Option<&RigidView>, rigid: Option<&RigidWorld>, dt: f64) {
        let stage = Stage {
            field: self.field(),
            time: self.time,
            dt,
            view,
            sleep: self.sleep,
            sheets_meet: self.scene.contact.sheets,
            watch: &self.watch,
        };
        self.sheets.iter_mut().for_each(|s| s.press(stage.time + stage.dt));
        let many = self.sheets.len() > 1;
        let Self { sheets, touches, groups, pool, .. } = self;
        let mut work = |parallel: bool| {
            stage.watch.within(Phase::Motion, || groups.step(sheets, touches, &stage, rigid, parallel))
        };
        match pool {
            Some(pool) if many => pool.install(|| work(true)),
            _ => work(false),
        }
        self.steps += 1;
        self.time += dt;
    }

    /// Moves the sheets' events to the world's list, sheet by sheet, so that their order does not depend on threads.
    fn collect_events(&mut self, name: impl Fn(&Self, rapier3d::prelude::ColliderHandle) -> Option<String>) {
        for index in 0..self.touches.len() {
            if self.touches[index].events.is_empty() {
                continue;
            }
            let mut alarms = std::mem::take(&mut self.touches[index].alarms).into_iter();
            for (time_s, kind, collider) in std::mem::take(&mut self.touches[index].events) {
                let body = collider.and_then(|c| name(self, c));
                let alarm = if kind.has_alarm() { alarms.next() } else { None };
                let place_m = alarm.map(|a| a.place_m);
                let event = Event::new(time_s, kind, &self.sheets[index].name, body);
                self.events.push(Event { alarm, place_m, ..event });
            }
        }
    }

    /// The scene it was built from.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The sheets.
    pub fn sheets(&self) -> &[Sheet] {
        &self.sheets
    }

    /// The sheets, to be changed between steps.
    pub fn sheets_mut(&mut self) -> &mut [Sheet] {
        &mut self.sheets
    }

    /// The world's own rigid bodies; `None` where the caller lends them.
    pub fn rigid(&self) -> Option<&RigidWorld> {
        self.rigid.as_ref()
    }

    /// The sheet of that name.
    pub fn sheet(&self, name: &str) -> Option<&Sheet> {
        self.sheets.iter().find(|s| s.name == name)
    }

    /// The sheet of that name, to be changed between steps.
    pub fn sheet_mut(&mut self, name: &str) -> Option<&mut Sheet> {
        let sheet = self.sheets.iter_mut().find(|s| s.name == name)?;
        // It may be put through another.
        sheet.doubt_apart();
        Some(sheet)
    }

    /// Adds a sheet and returns its name: the description's, made unique with a number where it is taken.
    ///
    /// # Errors
    /// When the description, or a file it names, is not valid; nothing is added then.
    pub fn add_sheet(&mut self, spec: &SheetSpec) -> Result<String, InputError> {
        let base = if spec.name.is_empty() { "sheet" } else { spec.name.as_str() };
        let taken = |name: &str| self.sheets.iter().any(|s| s.name == name);
        let name = free_name(base, taken);
        let mut scene = self.scene.clone();
        scene.engine = self.engine;
        scene.tolerance = self.tolerance;
        scene.sheets.push(SheetSpec { name: name.clone(), ..spec.clone() });
        validate::values(&scene)?;
        let mut sheet = Sheet::build(&scene, scene.sheets.len() - 1)?;
        glue(&mut sheet, self.rigid.as_ref())?;
        if let Some(heat) = &mut self.heat {
            heat.forget();
            sheet.begin_heat(self.scene.ambient_temperature);
        } else if let Some(heat) = Room::of(&scene)? {
            self.heat = Some(Box::new(heat));
            sheet.begin_heat(self.scene.ambient_temperature);
        }
        sheet.warm(&spec.spots, self.scene.ambient_temperature)?;
        self.scene.sheets = scene.sheets;
        self.sheets.push(sheet);
        match &mut self.detail {
            Some(detail) => detail.add(),
            None => self.detail = lod::Detail::of(&self.scene, &self.sheets),
        }
        self.touches.push(Touches::default());
        self.make = serialization::make_of(&self.scene);
        Ok(name)
    }

    /// Removes the sheet of that name; false when there is none.
    pub fn remove_sheet(&mut self, name: &str) -> bool {
        let Some(index) = self.sheets.iter().position(|s| s.name == name) else { return false };
        self.sheets.remove(index);
        self.detail.iter_mut().for_each(|detail| detail.remove(index));
        self.touches.remove(index);
        self.scene.sheets.remove(index);
        self.make = serialization::make_of(&self.scene);
        if let Some(heat) = &mut self.heat {
            heat.forget();
        }
        true
    }

    /// What has happened so far, in order of the steps.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Steps taken.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Step of the engine, s.
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Gravity, m/s².
    pub fn gravity(&self) -> DVec3 {
        self.gravity
    }

    /// The engine.
    pub fn engine(&self) -> EngineKind {
        self.engine
    }

    /// The air.
    pub fn air(&self) -> Air {
        self.air
    }

    /// State of the rigid body of that name: where it is and how it moves.
    pub fn body_state(&self, name: &str) -> Option<&BodyState> {
        let rigid = self.rigid.as_ref()?;
        rigid.state(rigid.index_of(name)?)
    }

    /// Energies of all sheets, and of all bodies that move freely, J; gravity's is zero at the origin.
    pub fn energy(&self) -> Energy {
        let sheets = self.sheets.iter().map(|s| s.energy(self.gravity));
        let all = sheets.fold(Energy::default(), |sum, e| sum.plus(e.kinetic, e.elastic, e.gravity));
        let bodies = self.rigid.iter().flat_map(|r| (0..r.bodies().len()).filter_map(|i| r.state(i)));
        bodies.fold(all, |sum, b| sum.plus(b.kinetic_energy(), 0.0, b.gravity_energy(self.gravity)))
    }

    /// Whether nothing moves by itself: all sheets asleep or stopped, and all bodies that move freely asleep.
    pub fn is_quiet(&self) -> bool {
        let rests = self.sheets.iter().all(|s| s.status != Status::Awake);
        rests && self.rigid.as_ref().is_none_or(RigidWorld::is_quiet)
    }

    /// The first sheet that went unstable, if one did.
    pub fn unstable(&self) -> Option<&Sheet> {
        self.sheets.iter().find(|s| matches!(s.status, Status::Unstable { .. }))
    }

    /// How deep the deepest mass of any sheet is inside a body now, m.
    pub fn penetration(&self) -> f64 {
        let Some(rigid) = &self.rigid else { return 0.0 };
        let view = rigid.view();
        self.sheets.iter().map(|s| deepest(s, &view)).fold(0.0, f64::max)
    }

    /// Changes the step, s; 1e-7 to 1.
    ///
    /// # Errors
    /// When out of range; nothing is changed then.
    pub fn set_dt(&mut self, dt: f64) -> Result<(), InputError> {
        check_range("dt", dt, 1e-7, 1.0, "s")?;
        self.dt = dt;
        Ok(())
    }

    /// Changes gravity, m/s²; each component within ±1000.
    ///
    /// # Errors
    /// When out of range; nothing is changed then.
    pub fn set_gravity(&mut self, gravity: DVec3) -> Result<(), InputError> {
        for (axis, value) in gravity.to_array().into_iter().enumerate() {
            check_range(&format!("gravity.{axis}"), value, -1e3, 1e3, "m/s²")?;
        }
        self.gravity = gravity;
        self.sheets.iter_mut().for_each(Sheet::wake);
        if let Some(rigid) = &mut self.rigid {
            rigid.wake_all();
        }
        Ok(())
    }

    /// Adds pairs of materials, each in place of one of the same two materials; they hold from the next step on, for what is in
    /// the world and for what comes.
    ///
    /// # Errors
    /// When a coefficient is out of range; nothing is changed then.
    pub fn add_pairs(&mut self, pairs: &[PairSpec]) -> Result<(), InputError> {
        let mut contact = self.scene.contact.clone();
        for pair in pairs {
            contact.pairs.retain(|p| !p.joins(&pair.between.0, &pair.between.1));
            contact.pairs.push(pair.clone());
        }
        validate::contact(&contact)?;
        if let Some(rigid) = &mut self.rigid {
            rigid.set_contact(&contact);
        }
        self.scene.contact = contact;
        self.sheets.iter_mut().for_each(Sheet::wake);
        Ok(())
    }

    /// Changes the air.
    ///
    /// # Errors
    /// When out of range; nothing is changed then.
    pub fn set_air(&mut self, air: Air) -> Result<(), InputError> {
        validate::air(&air)?;
        self.air = air;
        self.sheets.iter_mut().for_each(Sheet::wake);
        Ok(())
    }

    /// Changes the engine of every sheet; the next step is the new one's.
    pub fn set_engine(&mut self, engine: EngineKind) {
        self.engine = engine;
        let tolerance = self.tolerance;
        self.sheets.iter_mut().for_each(|s| s.set_engine(engine, tolerance));
    }

    /// Changes the error an adaptive engine may make in a step, m; 1e-15 to 1.
    ///
    /// # Errors
    /// When out of range; nothing is changed then.
    pub fn set_tolerance(&mut self, tolerance: f64) -> Result<(), InputError> {
        check_range("tolerance", tolerance, 1e-15, 1.0, "m")?;
        self.tolerance = tolerance;
        self.set_engine(self.engine);
        Ok(())
    }
}

/// `base`, or `base 2`, `base 3`... whichever is first not taken.
fn free_name(base: &str, taken: impl Fn(&str) -> bool) -> String {
    let numbered = (2_u64..).map(|n| format!("{base} {n}"));
    std::iter::once(base.to_owned()).chain(numbered).find(|name| !taken(name)).unwrap_or_default()
}

/// Equal steps of at most `dt` that make up `duration`; at least one.
fn steps_in(duration: f64, dt: f64) -> u64 {
    // The slack keeps a duration that is a whole number of steps, but for rounding, at that number.
    ((duration / dt) - 1e-9).ceil().max(1.0) as u64
}

/// The scene with the names of its bodies filled in, so that one can be found in it when it is removed.
fn named(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for (index, body) in scene.bodies.iter_mut().enumerate() {
        body.name = body_name(&body.name, index);
    }
    scene
}

/// Glues a sheet to the bodies that its pins name.
fn glue(sheet: &mut Sheet, rigid: Option<&RigidWorld>) -> Result<(), InputError> {
    sheet.glue_to(|name| {
        let rigid = rigid?;
        let index = rigid.index_of(name)?;
        Some((index, *rigid.state(index)?))
    })
}
