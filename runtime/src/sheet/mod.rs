//! What a sheet is: masses with positions and velocities, springs between them, a material, pins, and its engine.
//!
//! Built from a [`SheetSpec`](crate::scene::SheetSpec) or a .SHT file by `build`; changed while it runs by the setters here;
//! stepped by [`crate::step`]. SI units throughout.

mod buckle;
mod build;
mod creases;
mod damped;
mod drag;
mod edges;
mod energy;
mod equilibrium;
mod estimate;
mod flow;
mod forces;
mod generated;
mod glue;
mod guard;
mod implicit;
mod keep;
mod masses;
mod modes;
mod pins;
mod probe;
mod pull;
mod reaction;
mod region;
mod resample;
pub mod slits;
mod smooth;
mod snapshot;
pub(crate) mod stage;
pub mod surface;
mod tears;
pub(crate) mod trace;
mod tuning;
mod vectors;

use std::sync::Arc;

use glam::DVec3;

pub use buckle::Buckle;
pub use build::{from_file, to_file};
pub use energy::Energy;
pub use equilibrium::Equilibrium;
pub use estimate::DeliveredStiffness;
pub use forces::Field;
pub(crate) use guard::{GUARDED, Guard, GuardState, LED, Level};
pub use modes::Mode;
pub use pins::Pins;
pub use probe::Probe;
pub use region::select;
pub(crate) use snapshot::SheetState;
use surface::Surface;
pub use tears::Opening;
use tears::Tears;
pub use vectors::Vectors;

use self::drag::Drag;
use self::flow::Flow;
pub(crate) use self::implicit::System;
use crate::contact::through_thickness::{Stack, Strike};
use crate::element::flexion_limit::FlexionLimit;
use crate::element::pull::Pull;
use crate::element::spring::{SpringScratch, Springs};
use crate::element::thickness_limit::ThicknessLimit;
use crate::element::{Element, Law};
use crate::engine::{Engine, EngineKind};
use crate::error::{InputError, check_range};
use crate::heat::Heat;
use crate::lattice::outline::Mesh;
use crate::lattice::{Layer, StructureKind};
use crate::scene::{Material, Tack};

/// How a sheet fares.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Status {
    /// It moves, or could.
    #[default]
    Awake,
    /// It has been still for a while and is not stepped until something wakes it.
    Asleep,
    /// It went unstable and was stopped; the rest of the scene goes on.
    Unstable {
        /// Simulated time it was caught at, s.
        time: f64,
        /// Mass that was fastest then.
        mass: u32,
        /// Where that mass was before the step that was thrown away, m.
        place: DVec3,
        /// Its speed, m/s; infinite when it was not a number.
        speed: f64,
    },
    /// It was about to go unstable, and stands where it was until something about it is changed
    /// ([`crate::scene::WhenUnstable`]).
    Frozen {
        /// Simulated time it was caught at, s.
        time: f64,
    },
}

/// Whether a sheet goes through another, as one may that was put there: no motion parts the two, since what is on the one side of a triangle is
/// on the other side of its neighbour, and contact between them is left out until they are apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Crossing {
    /// Not known: to be looked for before the next step.
    #[default]
    Unknown,
    /// It does not.
    No,
    /// It does, which is still to be told.
    Seen,
    /// It does.
    Told,
}

/// Counts of what a sheet's stepping has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counters {
    /// Engine steps accepted.
    pub accepted: u64,
    /// Engine steps rejected by error control.
    pub rejected: u64,
    /// Evaluations of the forces of the whole sheet; linear solves of an implicit engine.
    pub evaluations: u64,
    /// Stages of an implicit engine that its guarded descent had to finish.
    pub guarded: u64,
    /// Times a mass was met with a body's surface.
    pub contacts: u64,
}

/// A sheet in a world.
pub struct Sheet {
    /// Name, unique in its world.
    pub name: String,
    /// Structure it was generated with.
    pub structure: StructureKind,
    /// Masses along the length, layers, masses along the width.
    pub grid: (u32, u32, u32),
    /// Positions of the masses, m.
    pub x: Vectors,
    /// Velocities of the masses, m/s.
    pub v: Vectors,
    /// Constant force on each mass, N.
    pub applied: Vectors,
    /// Friction coefficient, 0 to 10.
    pub friction: f64,
    /// Restitution coefficient, 0 to 1.
    pub restitution: f64,
    /// Layers, bottom first.
    pub layers: Vec<Layer>,
    /// Triangles of a sheet that is no rectangle, counter-clockwise seen from its upper side; it then has one layer that is
    /// no grid.
    pub triangles: Option<Vec<[u32; 3]>>,
    /// Its mesh, and that of the grid that its scene has, if it has gone to another.
    mesh: Option<Arc<Mesh>>,
    first_mesh: Option<((u32, u32), Arc<Mesh>)>,
    /// Place of each mass in the sheet, (u, v), 0 to 1 over the bottom layer.
    pub uv: Vec<(f64, f64)>,
    /// Masses on the outline of their layer.
    pub border: Vec<bool>,
    /// Layer of each mass.
    pub layer_of: Vec<u32>,
    /// Named material points.
    pub probes: Vec<Probe>,
    /// Whether it moves, sleeps or was stopped.
    pub status: Status,
    /// Whether it goes through another sheet.
    pub(crate) crossing: Crossing,
    /// What stepping has done.
    pub counters: Counters,
    pub(crate) mass: Vec<f64>,
    pub(crate) inverse_mass: Vec<f64>,
    pub(crate) springs: Springs,
    /// Membrane and bending of a shell.
    pub(crate) elements: Vec<Box<dyn Element>>,
    /// Who pulls at it; each is also the last of the elements, in this order.
    pulls: Vec<Pull>,
    pub(crate) drag: Drag,
    /// Its temperatures; none for a sheet that nothing heats.
    pub(crate) heat: Option<Box<Heat>>,
    /// Temperature it is described with, °C, and whether its sides may differ.
    pub(crate) first_temperature: Option<f64>,
    pub(crate) has_gradient: bool,
    /// Of a sheet that is not simply stopped when it goes unstable.
    pub(crate) guard: Option<Box<Guard>>,
    /// Of a sheet that is watched for buckling.
    watch: Option<Box<buckle::Watch>>,
    /// Of a sheet that creeps or yields.
    flow: Option<Box<Flow>>,
    /// Of a sheet whose cells can open.
    tears: Option<Box<Tears>>,
    /// Of a sheet that sticks, the area of it that falls to each mass, m².
    areas: Vec<f64>,
    /// The linear system of implicit engines, made when the first step needs it.
    system: Option<Box<System>>,
    field_before: Option<Field>,
    pub(crate) flexion: Vec<[u32; 3]>,
    pub(crate) flexion_limit: Option<FlexionLimit>,
    pub(crate) thickness_limit: Option<ThicknessLimit>,
    pub(crate) pins: Pins,
    /// Masses held together with the slope of the sheet.
    pub(crate) clamped: Vec<bool>,
    pub(crate) engine_kind: EngineKind,
    pub(crate) engine: Box<dyn Engine>,
    pub(crate) stack: Stack,
    /// How long it has been still, s, and where it was when it was found so.
    pub(crate) quiet: f64,
    pub(crate) still_at: Vectors,
    pub(crate) work: Work,
    material: Material,
    damping: f64,
    damping_ratio: f64,
    /// Longer side, m.
    length: f64,
    /// Length and width that [`Sheet::uv`] is a fraction of, m, at rest.
    pub(crate) extent: (f64, f64),
    /// Distance between its layers when it was built, m; 1 of a single layer.
    pub(crate) gap: f64,
    /// Stiffness of each spring per N/m of E t, or per N m of bending stiffness where springs are calibrated.
    stiffness_per_unit: Vec<f64>,
    /// Whether springs are calibrated to how the sheet bends.
    bends: bool,
    /// Fraction of the bending stiffness asked for that the structure delivers; none where it does not aim at it.
    delivered: Option<f64>,
    /// Diagonal of its bounding box when it was built, m.
    pub(crate) spread: f64,
    /// Where it is creased along masses.
    folds: surface::Folds,
    /// Longest step that its explicit engine bears, s; infinite unless it has gone to another grid.
    pub(crate) longest: f64,
    damped: bool,
}

/// Arrays a step works in; kept so that a warm step allocates nothing.
#[derive(Default)]
pub(crate) struct Work {
    pub springs: SpringScratch,
    pub force: Vectors,
    pub x_before: Vectors,
    pub v_before: Vectors,
    /// Positions and velocities at the start of the step.
    pub start: (Vectors, Vectors),
    /// Normal (unit) and fraction of the impact each mass met in this step; the fraction is 0 for none.
    pub struck: Vec<Strike>,
    pub touching: Vec<bool>,
    pub clearance: crate::contact::Clearance,
    pub stage: stage::StageWork,
    pub unit: crate::contact::Unit,
    pub contact: Option<Box<crate::contact::stage::Scratch>>,
    pub near: Option<Box<crate::step::NearWork>>,
    /// Its contact surface, made when it is first near something.
    pub skin: Option<Box<crate::contact::skin::Skin>>,
    /// What it sticks to.
    pub stuck: Option<Box<crate::contact::stick::Stuck>>,
    /// Of one that does not move, its first and last mass and the box around it, m.
    pub resting: Option<((Option<DVec3>, Option<DVec3>), (DVec3, DVec3))>,
    /// Where it was in the step, of one that is judged.
    pub trace: Option<Box<trace::Trace>>,
    /// Colliders that masses touched in this step.
    pub met: Vec<(rapier3d::prelude::ColliderHandle, u32)>,
    /// How many of them are of what touched at the end of the step.
    pub met_at_end: usize,
}

impl Sheet {
    /// How many masses it has.
    pub fn masses(&self) -> usize {
        self.x.len()
    }

    /// Mass of node `i`, kg; panics when there is none, as indexing does.
    pub fn mass(&self, i: usize) -> f64 {
        self.mass[i]
    }

    /// Whether mass `i` is held or led in every direction.
    pub fn is_held(&self, i: usize) -> bool {
        self.inverse_mass[i] == 0.0
    }

    /// Mass of the whole sheet, kg.
    pub fn total_mass(&self) -> f64 {
        self.mass.iter().sum()
    }

    /// Layer `index` as a surface to draw, with `parts` spline pieces from mass to mass of a grid; `None` where there is no such
    /// layer. What has opened is left out, and no spline drawn over it: a sheet that is not whole is drawn flat between its masses.
    pub fn surface(&self, index: usize, parts: u32) -> Option<Surface> {
        if self.opened().is_some() {
            let layer = self.layers.get(index)?;
            let mut surface = Surface::new(layer, &self.uv, 1);
            let closed = self.closed_triangles(layer.triangles());
            surface.keep(closed.into_iter().map(|t| t.map(|i| i - layer.first)).collect());
            return Some(surface);
        }
        match &self.mesh {
            Some(mesh) => (index == 0).then(|| Surface::of_triangles(mesh, &self.uv, parts)),
            None => self.layers.get(index).map(|layer| Surface::folded(layer, &self.uv, parts, &self.folds)),
        }
    }

    /// Its springs.
    pub fn springs(&self) -> &Springs {
        &self.springs
    }

    /// Its material as it is now.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// Damping ratio of its slowest bending motion (shell and calibrated lattices).
    pub fn damping_ratio(&self) -> f64 {
        self.damping_ratio
    }

    /// Changes the damping ratio of the slowest bending motion, 0 to 10.
    ///
    /// # Errors
    /// When out of range; nothing is changed then.
    pub fn set_damping_ratio(&mut self, ratio: f64) -> Result<(), InputError> {
        check_range("damping_ratio", ratio, 0.0, 10.0, "of critical")?;
        self.damping_ratio = ratio;
        self.refresh();
        Ok(())
    }

    /// Membrane and bending stiffness and retardation time as they are now.
    pub fn law(&self) -> Law {
        self.material.law(self.length, self.damping_ratio)
    }

    /// The linear solver of an implicit engine: its name, block rows and blocks of the matrix, numbers in the factor;
    /// `None` before the first implicit step.
    pub fn solver(&self) -> Option<(&'static str, usize, usize, usize)> {
        self.system.as_ref().map(|s| s.about())
    }

    /// Dashpot of its springs as a fraction of critical.
    pub fn damping(&self) -> f64 {
        self.damping
    }

    /// Its angle limit, degrees, if one is set.
    pub fn flexion_angle_limit(&self) -> Option<f64> {
        self.flexion_limit.as_ref().map(|l| l.limit)
    }

    /// Largest angle of its flexion triples as it lies, degrees; `None` for a structure without flexion.
    pub fn largest_flexion_angle(&self) -> Option<f64> {
        (!self.flexion.is_empty())
            .then(|| FlexionLimit { triples: self.flexion.clone(), limit: 180.0 }.largest_angle(&self.x))
    }

    /// Smallest distance of a mass from the layer it stands on, as a fraction of that at rest; `None` for a single layer or
    /// where no limit is set.
    pub fn squeezed_to(&self) -> Option<f64> {
        self.thickness_limit.as_ref().map(|l| l.lowest(&self.x))
    }

    /// Masses that touched a body in the last step.
    pub fn touching(&self) -> &[bool] {
        &self.work.touching
    }

    /// Centre of mass, m.
    pub fn centre_of_mass(&self) -> DVec3 {
        let sum: DVec3 = self.x.iter().zip(&self.mass).map(|(x, m)| x * *m).sum();
        sum / self.total_mass()
    }

    /// Linear momentum, kg m/s.
    pub fn momentum(&self) -> DVec3 {
        self.v.iter().zip(&self.mass).map(|(v, m)| v * *m).sum()
    }

    /// Angular momentum about the centre of mass, kg m²/s.
    pub fn angular_momentum(&self) -> DVec3 {
        let centre = self.centre_of_mass();
        (0..self.masses()).map(|i| (self.x.get(i) - centre).cross(self.v.get(i)) * self.mass[i]).sum()
    }

    /// Whether forces of the scene, or someone, pull at it.
    pub(crate) fn is_pulled(&self) -> bool {
        !self.pulls.is_empty() || self.applied.max_squared() > 0.0 || self.drag.pressure != 0.0
    }

    /// Energies under `gravity` (m/s²), J. The potential energy of gravity is zero at the origin.
    pub fn energy(&self, gravity: DVec3) -> Energy {
        Energy::of(self, gravity)
    }

    /// How its material sticks; none of a sheet that does not.
    pub(crate) fn tack(&self) -> Option<Tack> {
        if self.areas.is_empty() { None } else { self.material.tack }
    }

    /// Area of the sheet that falls to mass `i`, m².
    pub(crate) fn area_of(&self, i: u32) -> f64 {
        self.areas.get(i as usize).copied().unwrap_or(0.0)
    }

    /// Largest speed of a mass, m/s.
    pub fn max_speed(&self) -> f64 {
        self.v.max_squared().sqrt()
    }

    /// Largest frequency of the sheet as it lies, rad/s, by power iteration on its stiffness; explicit engines are stable
    /// for steps up to their limit over this. `iterations` of 200 give it to about a percent.
    pub fn largest_frequency(&self, iterations: usize) -> f64 {
        energy::largest_frequency(self, iterations)
    }

    /// The engine that steps it.
    pub fn engine(&self) -> EngineKind {
        self.engine_kind
    }

    /// Changes the engine; the next step is taken by the new one from where the sheet is.
    pub fn set_engine(&mut self, kind: EngineKind, tolerance: f64) {
        if let Some(guard) = &mut self.guard {
            (guard.state, guard.tolerance) = (GuardState::default(), tolerance);
        }
        self.change_engine(kind, tolerance);
        if self.longest.is_finite() {
            self.fit_step();
        }
        self.wake();
    }

    /// Changes the engine alone.
    pub(crate) fn change_engine(&mut self, kind: EngineKind, tolerance: f64) {
        if kind != self.engine_kind {
            self.engine = kind.make();
            self.engine_kind = kind;
            // An implicit one then begins without what another has left in the elements.
            self.field_before = None;
        }
        self.engine.set_tolerance(tolerance);
    }

    /// Changes the material: stiffness and dashpots follow at once, masses stay as they were built.
    ///
    /// # Errors
    /// When a constant is out of range; nothing is changed then.
    pub fn set_material(&mut self, material: Material) -> Result<(), InputError> {
        crate::scene::validate::material("material", &material)?;
        if self.flow.is_some() && material.burgers != self.material.burgers {
            return Err(InputError::new("material.burgers", "cannot change while the sheet creeps"));
        }
        if let Some(heat) = &mut self.heat {
            heat.set_material(&material);
        }
        self.material = material;
        self.refresh();
        self.follow_heat();
        if self.longest.is_finite() {
            self.fit_step();
        }
        Ok(())
    }

    /// Changes the dashpots of the springs: a fraction of critical, 0 to 10.
    ///
    /// # Errors
    /// When out of range; nothing is changed then.
    pub fn set_damping(&mut self, damping: f64) -> Result<(), InputError> {
        check_range("damping", damping, 0.0, 10.0, "of critical")?;
        self.damping = damping;
        self.refresh();
        Ok(())
    }

    /// Sets or lifts the angle limit of the flexion triples, degrees.
    ///
    /// # Errors
    /// When out of range or the structure has no flexion; nothing is changed then.
    pub fn set_flexion_limit(&mut self, limit: Option<f64>) -> Result<(), InputError> {
        if let Some(limit) = limit {
            check_range("flexion_limit", limit, 1.0, 180.0, "degrees")?;
            if self.flexion.is_empty() {
                let problem = format!("{} has no flexion triples to limit", self.structure);
                return Err(InputError::new("flexion_limit", problem));
            }
        }
        self.flexion_limit = limit.map(|limit| FlexionLimit { triples: self.closed_triples(), limit });
        self.wake();
        Ok(())
    }

    /// Wakes it if it sleeps or is frozen.
    pub fn wake(&mut self) {
        self.quiet = 0.0;
        self.work.clearance.forget();
        self.doubt_apart();
        if matches!(self.status, Status::Asleep | Status::Frozen { .. }) {
            self.status = Status::Awake;
        }
    }

    /// Has it looked before the next step whether it goes through another sheet.
    pub(crate) fn doubt_apart(&mut self) {
        if self.crossing == Crossing::No {
            self.crossing = Crossing::Unknown;
        }
    }

    /// Stiffness and dashpots from material and damping: k = (k per E t) E t, c = ζ · 2 √(k μ) with μ the reduced mass; of
    /// calibrated springs k = (k per D) D, c = τ k.
    fn refresh(&mut self) {
        let law = self.law();
        self.elements.iter_mut().for_each(|e| e.set_law(&law));
        self.refresh_springs();
    }

    /// As [`Sheet::refresh`], of the springs alone: elements have followed already.
    pub(crate) fn refresh_springs(&mut self) {
        let law = self.law();
        let unit =
            if self.bends { self.material.plate_stiffness() } else { self.material.young * self.material.thickness };
        for i in 0..self.springs.len() {
            let (ma, mb) = (self.mass[self.springs.a[i] as usize], self.mass[self.springs.b[i] as usize]);
            let mut k = self.stiffness_per_unit[i] * unit;
            if let Some(heat) = &self.heat {
                k *= heat.spring_softness(i);
            }
            let critical = 2.0 * (k * ma * mb / (ma + mb)).sqrt();
            let dashpot = if self.bends { law.retardation * k } else { self.damping * critical };
            self.springs.set_law(i, k, dashpot);
        }
        self.damped = self.springs.damped();
        self.refresh_flow();
        if let Some(system) = &mut self.system {
            system.refresh(&self.springs);
        }
        self.wake();
    }
}
