//! World: sheets, rigid bodies, gravity, and the function that steps them.
//!
//! A world is built from a [`Scene`]. Between steps its setters change it, or [`World::set`] does
//! by path, with the checks of a scene file.

pub(crate) mod bodies;
pub(crate) mod body_loads;
pub(crate) mod checkpoint;
pub(crate) mod contacts;
pub(crate) mod failure_events;
pub(crate) mod forces;
pub(crate) mod ids;
pub(crate) mod joints;
pub mod journal;
pub(crate) mod loads;
pub(crate) mod lod;
pub mod lod_cost;
pub(crate) mod parameters;
pub(crate) mod part_file;
pub(crate) mod penetration;
mod pins;
mod placed_solids;
pub(crate) mod playback;
pub(crate) mod query;
pub mod recording;
pub(crate) mod remap;
pub(crate) mod report;
pub(crate) mod serialization;
pub(crate) mod sheets;
pub(crate) mod snapshot;
mod start_overlap;
pub(crate) mod state_hash;
pub(crate) mod step;
pub(crate) mod suggestions;
mod suspension;
pub(crate) mod teleport;
mod thermal;
pub(crate) mod wind;

use std::sync::Arc;

use glam::DVec3;

pub use crate::world::checkpoint::Checkpoint;
pub use crate::world::contacts::{ContactEvent, ContactEventKind, ContactPair, ContactPartner};
pub use crate::world::forces::{ForceEntry, ForceReport};
pub use crate::world::ids::{BodyId, HeaterId, SheetId};
pub use crate::world::joints::JointId;
pub use crate::world::loads::ForceTarget;
pub use crate::world::parameters::Parameter;
pub use crate::world::penetration::{PenetratedObject, Penetration};
pub use crate::world::query::{
    InterpolatedNodes, QueryFilter, QueryLayer, QueryShape, SheetQueries, SurfaceArea, SurfaceCurvature,
    SurfaceOverlaps, SurfacePoint,
};
pub use crate::world::report::{BodyReport, OpeningReport, Report, SheetReport, TemperatureReport, UnresolvedFolds};
pub use crate::world::snapshot::Snapshot;

use crate::contact::node::detection::deepest_penetration;
use crate::contact::{ContactCounters, SheetContact};
use crate::error::{BuildError, InputError, check_range};
use crate::islands::contact_log::ContactLog;
use crate::islands::event::Event;
use crate::islands::island_manager::IslandManager;
use crate::parallel::Pool;
use crate::profiler::{Profiler, StepObserver};
use crate::rigid::lent::LentBodies;
use crate::rigid::{BodyState, RigidWorld};
use crate::scene::{Air, IntegratorKind, PairSpec, Scene, WindZone, body_name, validate};
use crate::sheet::refine::RefineWorkspace;
use crate::sheet::temperature::spots;
use crate::sheet::wind::WindField;
use crate::sheet::{Energy, Equilibrium, Sheet, Status, attachment, equilibrium};
use crate::thermal::ThermalModel;
use crate::thermal::source::heater;
use crate::units::parameters::ParameterId as Id;
use crate::world::ids::IdTable;
use crate::world::serialization::StructureChecksum;

/// Maximum number of threads of a world.
const MAX_THREADS: f64 = 1024.0;

/// Simulation of sheets and bodies.
pub struct World {
    scene: Scene,
    sheets: Vec<Sheet>,
    suspended: Vec<suspension::SuspendedSheet>,
    sheet_ids: IdTable,
    body_ids: IdTable,
    heater_ids: IdTable,
    /// Name of each heater in parameter paths.
    heater_names: Vec<String>,
    sheet_contacts: Vec<SheetContact>,
    contact_logs: Vec<ContactLog>,
    rigid: Option<Box<RigidWorld>>,
    gravity: DVec3,
    air: Air,
    engine: IntegratorKind,
    tolerance: f64,
    dt: f64,
    time: f64,
    steps: u64,
    events: Vec<Event>,
    sleep: bool,
    buckling: bool,
    /// Check of penetration after each step; `None` while it is off.
    penetration_check: penetration::PenetrationCheck,
    pool: Option<Arc<Pool>>,
    islands: IslandManager,
    /// Bodies of the caller that sheets move.
    lent: LentBodies,
    wind_zones: Vec<WindZone>,
    /// Wind zones as a step evaluates them; `None` without zones.
    wind: Option<Box<WindField>>,
    /// Forces of the program on sheets.
    loads: loads::Loads,
    records_forces: bool,
    contacts: Option<Box<contacts::ContactRecords>>,
    /// Forces of the last step.
    forces: Vec<ForceEntry>,
    /// Thermal model; `None` without heat.
    heat: Option<Box<ThermalModel>>,
    /// Levels of detail; `None` when no sheet has levels.
    lod: Option<Box<lod::LodState>>,
    /// Workspace of local refinement; `None` while no sheet has had it.
    refine_work: Option<Box<RefineWorkspace>>,
    profiler: Profiler,
    /// Checksum of the scene's structure, for snapshots.
    structure: StructureChecksum,
    /// Layout of the last checkpoint.
    layout: Option<Arc<checkpoint::WorldLayout>>,
    /// Number of events before those in the list, from the world that a loaded snapshot belongs to.
    drained_events: u64,
}

impl World {
    /// Build a world with its own rigid bodies.
    ///
    /// # Errors
    /// When the scene, or a file it names, is invalid, and when a sheet starts inside a body or
    /// another sheet, unless the scene's `repair` moves it out.
    pub fn new(scene: &Scene) -> Result<Self, BuildError> {
        Self::built(scene, Self::build_apart)
    }

    /// Build a world as [`World::new`] does, also where sheets start inside bodies or one another:
    /// for an editor, in which objects are moved through each other.
    ///
    /// # Errors
    /// When the scene, or a file it names, is invalid.
    pub fn with_start_overlaps(scene: &Scene) -> Result<Self, BuildError> {
        Self::built(scene, |scene, rigid| Self::build(scene, Some(Box::new(rigid))))
    }

    /// Build a world with its own rigid bodies by `build`.
    fn built(scene: &Scene, build: fn(&Scene, RigidWorld) -> Result<Self, InputError>) -> Result<Self, BuildError> {
        let checked = validate::built(scene);
        let built = checked.and_then(|()| RigidWorld::build(scene)).and_then(|rigid| build(scene, rigid));
        built.map_err(|e| BuildError::from(e).map(|e| scene.located(e)))
    }

    /// Build a world without bodies of its own: sheets meet the bodies passed to
    /// [`World::advance_with`]. Bodies and room of the scene are not built.
    ///
    /// # Errors
    /// When the scene, or a file it names, is invalid.
    pub fn without_bodies(scene: &Scene) -> Result<Self, BuildError> {
        let built = validate::built(scene).and_then(|()| Self::build(scene, None));
        built.map_err(|e| BuildError::from(e).map(|e| scene.located(e)))
    }

    /// Build a world whose sheets start apart from bodies and from one another.
    fn build_apart(scene: &Scene, rigid: RigidWorld) -> Result<Self, InputError> {
        let mut world = Self::build(scene, Some(Box::new(rigid)))?;
        let mut first = 0;
        while let Some((index, by)) = start_overlap::check(&world.sheets, first, world.rigid.as_deref(), scene.repair)?
        {
            let mut moved = world.scene.clone();
            moved.sheets[index].placement.position += by;
            first = index + 1;
            world = Self::build(&moved, world.rigid.take())?;
        }
        Ok(world)
    }

    fn build(scene: &Scene, rigid: Option<Box<RigidWorld>>) -> Result<Self, InputError> {
        validate::values(scene)?;
        let mut sheets = attached_sheets(scene, rigid.as_deref())?;
        let heat = ThermalModel::of(scene)?.map(Box::new);
        if let Some(heat) = &heat {
            // An oven that is on begins with sheets at ambient temperature.
            sheets.iter_mut().for_each(|s| heat.prepare(s, scene.ambient_temperature));
        }
        for (index, (sheet, spec)) in sheets.iter_mut().zip(&scene.sheets).enumerate() {
            let warmed = spots::heat_spots(sheet, &spec.spots, scene.ambient_temperature);
            warmed.map_err(|e| e.within(&format!("sheets.{index}.spots")))?;
        }
        let sheet_contacts = sheets.iter().map(|_| SheetContact::default()).collect();
        let contact_logs = sheets.iter().map(|_| ContactLog::default()).collect();
        let own = named(scene);
        let lod = lod::LodState::of(scene, &sheets);
        Ok(Self {
            sheet_ids: IdTable::new(sheets.len()),
            body_ids: IdTable::new(rigid.as_ref().map_or(0, |r| r.bodies().len())),
            heater_ids: IdTable::new(scene.heaters.len()),
            heater_names: scene.heaters.iter().enumerate().map(|(index, h)| heater::name_of(h, index)).collect(),
            sheets,
            suspended: Vec::new(),
            sheet_contacts,
            contact_logs,
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
            penetration_check: penetration::PenetrationCheck::default(),
            pool: None,
            islands: IslandManager::default(),
            lent: LentBodies::default(),
            wind_zones: scene.wind_zones.clone(),
            wind: wind::field_of(&scene.wind_zones),
            loads: loads::Loads::default(),
            records_forces: false,
            contacts: None,
            forces: Vec::new(),
            heat,
            lod,
            refine_work: scene.sheets.iter().any(|s| s.refine.is_some()).then(Box::default),
            profiler: Profiler::default(),
            structure: StructureChecksum::new(&own),
            layout: None,
            drained_events: 0,
            scene: own,
        })
    }

    /// Reset the world to its scene. The number of threads, sleeping and the profiler stay as set;
    /// ids stay valid.
    ///
    /// # Errors
    /// When a file that the scene names cannot be read; the world is then unchanged.
    pub fn reset(&mut self) -> Result<(), BuildError> {
        let suspended = self.suspended_ids();
        suspended.iter().for_each(|id| _ = self.resume_sheet(*id));
        let done = self.rebuild();
        suspended.iter().for_each(|id| _ = self.suspend_sheet(*id));
        done
    }

    /// Build the world again from its scene.
    fn rebuild(&mut self) -> Result<(), BuildError> {
        let rigid = if self.rigid.is_some() { Some(Box::new(RigidWorld::build(&self.scene)?)) } else { None };
        let mut fresh = Self::build(&self.scene, rigid)?;
        fresh.take_ids(self);
        let (sleep, buckling, pool) = (self.sleep, self.buckling, self.pool.take());
        let records_forces = self.records_forces;
        let profiler = std::mem::take(&mut self.profiler);
        let always = self.penetration_check.is_always();
        let penetration_check = penetration::PenetrationCheck::new(always);
        let contacts = self.contacts.take().map(|records| Box::new(records.restarted()));
        *self = Self { sleep, buckling, penetration_check, pool, profiler, records_forces, contacts, ..fresh };
        if let Some(rigid) = &mut self.rigid {
            rigid.set_sleep(sleep);
        }
        Ok(())
    }

    /// Take the ids of `old`: its sheets and heaters are those of this world, in the same order;
    /// its bodies are known by their names. A floor that was removed is there again, with a new id.
    fn take_ids(&mut self, old: &mut Self) {
        self.sheet_ids = std::mem::take(&mut old.sheet_ids);
        self.heater_ids = std::mem::take(&mut old.heater_ids);
        self.body_ids = std::mem::take(&mut old.body_ids);
        if let (Some(new), Some(old)) = (&self.rigid, &old.rigid) {
            let former: Vec<_> = new.bodies().iter().map(|body| old.index_of(&body.name)).collect();
            self.body_ids.replace(&former);
        }
    }

    /// Set the number of threads that step islands, 1 to 1024; 1 by default: the caller's. Results
    /// do not depend on it. Without the feature `parallel` all threads are the caller's.
    ///
    /// # Errors
    /// When out of range, or when the system refuses to start the threads.
    pub fn set_threads(&mut self, threads: usize) -> Result<(), InputError> {
        check_range("threads", threads as f64, 1.0, MAX_THREADS, "")?;
        self.pool = if threads <= 1 { None } else { Some(Arc::new(Pool::new(threads)?)) };
        Ok(())
    }

    /// Enable or disable sleeping of resting sheets and bodies. Default: enabled.
    pub fn set_sleep(&mut self, sleep: bool) {
        self.sleep = sleep;
        if let Some(rigid) = &mut self.rigid {
            rigid.set_sleep(sleep);
        }
        if !sleep {
            self.sheets.iter_mut().for_each(Sheet::wake);
        }
    }

    /// Set the profiler that receives the phases from the next step on; `None` removes it. Results
    /// do not depend on it.
    pub fn set_profiler(&mut self, observer: Option<Arc<dyn StepObserver>>) {
        self.profiler = Profiler(observer);
    }

    /// Set gravity (m/s²) without the range of a scene, for rigs that search for a limit.
    #[doc(hidden)]
    pub fn set_gravity_unbounded(&mut self, gravity: DVec3) {
        self.gravity = gravity;
    }

    /// Move every sheet to its equilibrium under gravity, its forces and wind, without contact and
    /// without advancing time. `tolerance` is the largest displacement of the last iteration, m.
    /// Returns the result of each sheet, in order.
    pub fn find_equilibrium(&mut self, tolerance: f64) -> Vec<Equilibrium> {
        let rigid = self.rigid.take();
        self.update_wind(rigid.as_deref().map(RigidWorld::view).as_ref(), 0.0);
        self.rigid = rigid;
        let field = self.field();
        self.sheets.iter_mut().map(|s| equilibrium::find_equilibrium(s, field, tolerance)).collect()
    }

    /// Creep of every sheet over `dt` (s), in equilibrium throughout; see
    /// [`creep_in_equilibrium`](crate::sheet::equilibrium::creep_in_equilibrium). The world's time
    /// does not advance.
    #[doc(hidden)]
    pub fn creep_in_equilibrium(&mut self, dt: f64, tolerance: f64) -> Vec<Equilibrium> {
        let field = self.field();
        self.sheets.iter_mut().map(|s| equilibrium::creep_in_equilibrium(s, field, dt, tolerance)).collect()
    }

    /// The scene of the world.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The world's own rigid bodies; `None` when the caller provides them.
    pub fn rigid(&self) -> Option<&RigidWorld> {
        self.rigid.as_deref()
    }

    /// Counters of the contact solver of the island whose first sheet is `index`.
    #[doc(hidden)]
    pub fn contact_counters(&self, index: usize) -> ContactCounters {
        self.islands.contact_counters(index)
    }

    /// Take the events so far out of the world, in the order of the steps.
    pub fn drain_events(&mut self) -> Vec<Event> {
        self.drained_events += self.events.len() as u64;
        std::mem::take(&mut self.events)
    }

    /// Events since the start or since [`World::drain_events`], in the order of the steps.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Number of events since the start, drained ones included.
    pub fn event_count(&self) -> u64 {
        self.drained_events + self.events.len() as u64
    }

    /// Events after the first `count` since the start, without those that were drained. After a
    /// reset there may be fewer than `count`: then none.
    pub fn events_since(&self, count: u64) -> &[Event] {
        let from = usize::try_from(count.saturating_sub(self.drained_events)).unwrap_or(usize::MAX);
        self.events.get(from..).unwrap_or_default()
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of steps taken.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Time step, s.
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Gravity, m/s².
    pub fn gravity(&self) -> DVec3 {
        self.gravity
    }

    /// Time integrator of the world.
    pub fn engine(&self) -> IntegratorKind {
        self.engine
    }

    /// Air of the world.
    pub fn air(&self) -> Air {
        self.air
    }

    /// State of the rigid body `name`.
    pub fn body_state(&self, name: &str) -> Option<&BodyState> {
        let rigid = self.rigid.as_deref()?;
        rigid.state(rigid.index_of(name)?)
    }

    /// Energies of all sheets and dynamic bodies, J; potential energy is zero at the origin.
    pub fn energy(&self) -> Energy {
        let sheets = self.sheets.iter().map(|s| s.energy(self.gravity));
        let all = sheets.fold(Energy::default(), |sum, e| sum.plus(e.kinetic, e.elastic, e.gravity));
        let bodies = self.rigid.iter().flat_map(|r| (0..r.bodies().len()).filter_map(|i| r.state(i)));
        bodies.fold(all, |sum, b| sum.plus(b.kinetic_energy(), 0.0, b.gravity_energy(self.gravity)))
    }

    /// Whether all sheets are asleep or stopped and all dynamic bodies are asleep.
    pub fn is_resting(&self) -> bool {
        let rests = self.sheets.iter().all(|s| s.state.status != Status::Awake);
        rests && self.rigid.as_deref().is_none_or(RigidWorld::all_asleep)
    }

    /// The first unstable sheet, if any.
    pub fn unstable(&self) -> Option<&Sheet> {
        self.sheets.iter().find(|s| matches!(s.state.status, Status::Unstable { .. }))
    }

    /// Largest penetration of a body by a node, m.
    pub fn penetration(&self) -> f64 {
        let Some(rigid) = &self.rigid else { return 0.0 };
        let view = rigid.view();
        self.sheets.iter().map(|s| deepest_penetration(s, &view)).fold(0.0, f64::max)
    }

    /// Set the time step, s; 1e-7 to 1.
    ///
    /// # Errors
    /// When it is out of range; nothing changes then.
    pub fn set_dt(&mut self, dt: f64) -> Result<(), InputError> {
        Id::TimeStep.check("dt", dt)?;
        self.dt = dt;
        Ok(())
    }

    /// Set gravity, m/s²; each component within ±1000.
    ///
    /// # Errors
    /// When it is out of range; nothing changes then.
    pub fn set_gravity(&mut self, gravity: DVec3) -> Result<(), InputError> {
        Id::Gravity.check_each("gravity", gravity.to_array())?;
        self.gravity = gravity;
        self.sheets.iter_mut().for_each(Sheet::wake);
        if let Some(rigid) = &mut self.rigid {
            rigid.wake_all();
        }
        Ok(())
    }

    /// Add contact parameters of material pairs, replacing those of the same two materials, from
    /// the next step on, for present and future objects.
    ///
    /// # Errors
    /// When a coefficient is out of range; nothing changes then.
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

    /// Set the air.
    ///
    /// # Errors
    /// When it is out of range; nothing changes then.
    pub fn set_air(&mut self, air: Air) -> Result<(), InputError> {
        validate::air(&air)?;
        self.air = air;
        self.sheets.iter_mut().for_each(Sheet::wake);
        Ok(())
    }

    /// Set the integrator of every sheet, from the next step on.
    pub fn set_engine(&mut self, engine: IntegratorKind) {
        self.engine = engine;
        let tolerance = self.tolerance;
        self.sheets.iter_mut().for_each(|s| s.set_engine(engine, tolerance));
    }

    /// Set the error tolerance of an adaptive integrator, m per step; 1e-15 to 1.
    ///
    /// # Errors
    /// When it is out of range; nothing changes then.
    pub fn set_tolerance(&mut self, tolerance: f64) -> Result<(), InputError> {
        Id::Tolerance.check("tolerance", tolerance)?;
        self.tolerance = tolerance;
        self.set_engine(self.engine);
        Ok(())
    }
}

/// The first of `wanted` (or `default` if that is empty), `wanted 2`, `wanted 3`... that is not in
/// use.
fn unique_name(wanted: &str, default: &str, taken: impl Fn(&str) -> bool) -> String {
    let base = if wanted.is_empty() { default } else { wanted };
    let numbered = (2_u64..).map(|n| format!("{base} {n}"));
    std::iter::once(base.to_owned()).chain(numbered).find(|name| !taken(name)).unwrap_or_default()
}

/// The sheets of a scene, attached to the bodies that they name.
fn attached_sheets(scene: &Scene, rigid: Option<&RigidWorld>) -> Result<Vec<Sheet>, InputError> {
    let mut sheets = Vec::with_capacity(scene.sheets.len());
    for index in 0..scene.sheets.len() {
        let field = format!("sheets.{index}");
        sheets.push(Sheet::build(scene, index).map_err(|e| e.of_object(&field, &field))?);
    }
    for (index, sheet) in sheets.iter_mut().enumerate() {
        attach_to_bodies(sheet, rigid).map_err(|e| e.within(&format!("sheets.{index}")))?;
    }
    Ok(sheets)
}

/// The scene with default names of bodies filled in, so that a removed body is found in it.
fn named(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for (index, body) in scene.bodies.iter_mut().enumerate() {
        body.name = body_name(&body.name, index);
    }
    scene
}

/// Attach a sheet to the bodies that its pins name.
fn attach_to_bodies(sheet: &mut Sheet, rigid: Option<&RigidWorld>) -> Result<(), InputError> {
    attachment::attach_to_bodies(sheet, |name| {
        let rigid = rigid?;
        let index = rigid.index_of(name)?;
        Some((index, *rigid.state(index)?))
    })
}
