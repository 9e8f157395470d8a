//! Sheets: nodes with positions and velocities, springs or shell elements between them, a material,
//! prescribed degrees of freedom, and a time integrator.
//!
//! `build` makes a [`Sheet`] from a [`SheetSpec`](crate::scene::SheetSpec) or a .SHT file, the
//! setters here change a running sheet, and [`crate::islands`] steps it. SI units throughout.

pub(crate) mod accelerations;
pub(crate) mod air_drag;
pub(crate) mod air_parameters;
mod assembly;
pub(crate) mod attachment;
pub(crate) mod bonds;
pub(crate) mod buckling;
pub(crate) mod build;
pub(crate) mod creases;
pub(crate) mod creep;
pub(crate) mod damped_modes;
pub(crate) mod delivered_stiffness;
pub(crate) mod energy;
pub(crate) mod equilibrium;
pub(crate) mod fracture;
pub(crate) mod generation;
pub(crate) mod grab;
pub(crate) mod implicit_system;
pub(crate) mod instability;
pub mod layer_stack;
pub mod material_report;
pub(crate) mod modes;
pub(crate) mod node_contact;
pub(crate) mod pins;
pub(crate) mod probe;
pub(crate) mod reaction;
pub(crate) mod region;
pub(crate) mod remap;
pub(crate) mod serialization;
pub(crate) mod slits;
pub(crate) mod smooth_surface;
pub(crate) mod snapshot;
pub(crate) mod stage;
pub(crate) mod stage_trace;
pub mod surface;
pub mod temperature;
pub(crate) mod wireframe;

use std::sync::Arc;

use glam::DVec3;

pub use crate::math::Vectors;
pub use crate::sheet::accelerations::Field;
pub use crate::sheet::buckling::Buckling;
pub use crate::sheet::build::{from_file, to_file};
pub use crate::sheet::delivered_stiffness::DeliveredStiffness;
pub use crate::sheet::energy::Energy;
pub use crate::sheet::equilibrium::Equilibrium;
pub use crate::sheet::fracture::FractureOpening;
use crate::sheet::fracture::FractureState;
pub(crate) use crate::sheet::instability::{
    KineticElasticEnergy, PRESCRIBED_MOTION_ENERGY_FACTOR, RECOVERY_INTEGRATOR, RecoveryPolicy, RecoveryState,
};
pub use crate::sheet::modes::Mode;
pub use crate::sheet::pins::Pins;
pub use crate::sheet::probe::Probe;
pub use crate::sheet::region::select;
pub(crate) use crate::sheet::snapshot::SavedSheetState;
use crate::sheet::surface::DrawingSurface;

use crate::elements::Element;
use crate::elements::flexion_limit::FlexionLimit;
use crate::elements::grab_spring::GrabSpring;
use crate::elements::spring::{SpringWorkspace, Springs};
use crate::elements::thickness_limit::ThicknessLimit;
use crate::error::InputError;
use crate::integrators::Integrator;
use crate::material::law::ElementLaw;
use crate::mesh::outline::TriangleMesh;
use crate::mesh::structure::{LatticeLayer, StructureKind};
use crate::scene::IntegratorKind;
use crate::scene::{Adhesion, Material};
use crate::sheet::air_drag::AirDrag;
use crate::sheet::creep::InelasticState;
pub(crate) use crate::sheet::implicit_system::ImplicitSystem;
use crate::sheet::layer_stack::{LayerImpact, LayerStack};
use crate::sheet::temperature::SheetTemperature;
use crate::units::parameters::ParameterId as Id;

/// Motion status of a sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Status {
    /// Stepped.
    #[default]
    Awake,
    /// Asleep: not stepped until an event wakes the sheet.
    Asleep,
    /// Stopped after an instability; the rest of the scene continues.
    Unstable {
        /// Simulated time of the detection, s.
        time: f64,
        /// Node with the largest speed at that time.
        mass: u32,
        /// Position of that node before the rejected step, m.
        place: DVec3,
        /// Speed of that node, m/s; infinite for a non-finite value.
        speed: f64,
    },
    /// Frozen before an instability until a parameter of the sheet changes
    /// ([`crate::scene::WhenUnstable`]).
    Frozen {
        /// Simulated time of the detection, s.
        time: f64,
    },
}

/// Interpenetration with another sheet, as in an initial placement. Motion cannot resolve it,
/// because neighbouring triangles see opposite sides; contact between the two sheets is left out
/// until they are apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Interpenetration {
    /// Unknown; tested before the next step.
    #[default]
    Unknown,
    /// No interpenetration.
    None,
    /// Interpenetration that has not been reported.
    Detected,
    /// Interpenetration that has been reported.
    Reported,
}

/// Counters of the steps of a sheet since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counters {
    /// Accepted integrator steps.
    pub accepted: u64,
    /// Integrator steps rejected by error control.
    pub rejected: u64,
    /// Force evaluations of the whole sheet; linear solves of an implicit integrator.
    pub evaluations: u64,
    /// Implicit stages finished by the globalised Newton method.
    pub guarded: u64,
    /// Contacts between a node and the surface of a body.
    pub contacts: u64,
}

/// Sheet of a world: nodes, elements, material, integrator and state.
pub struct Sheet {
    /// Name, unique in its world.
    pub name: String,
    /// Structure it was generated with.
    pub structure: StructureKind,
    /// Numbers of nodes along the length, of layers, and of nodes along the width.
    pub grid: (u32, u32, u32),
    /// Node positions, m.
    pub x: Vectors,
    /// Node velocities, m/s.
    pub v: Vectors,
    /// Constant force on each node, N.
    pub applied: Vectors,
    /// Friction coefficient, 0 to 10.
    pub friction: f64,
    /// Restitution coefficient, 0 to 1.
    pub restitution: f64,
    /// Layers, bottom first.
    pub layers: Vec<LatticeLayer>,
    /// Triangles of a sheet with an outline, counter-clockwise seen from the upper side; such a
    /// sheet has one layer without a grid.
    pub triangles: Option<Vec<[u32; 3]>>,
    meshes: OutlineMeshes,
    /// Material coordinates (u, v) of each node, 0 to 1 over the bottom layer.
    pub uv: Vec<(f64, f64)>,
    /// Nodes on the outline of their layer.
    pub border: Vec<bool>,
    /// Layer of each node.
    pub layer_of: Vec<u32>,
    /// Named material points.
    pub probes: Vec<Probe>,
    /// Motion status.
    pub status: Status,
    /// Interpenetration with another sheet.
    pub(crate) interpenetration: Interpenetration,
    /// Counters of its steps.
    pub counters: Counters,
    pub(crate) mass: Vec<f64>,
    pub(crate) inverse_mass: Vec<f64>,
    pub(crate) springs: Springs,
    /// Membrane and bending of a shell, wall springs of clamps, and grab springs last.
    pub(crate) elements: Vec<Box<dyn Element>>,
    /// Grab springs. Each is also one of the last elements, in this order.
    grabs: Vec<GrabSpring>,
    pub(crate) drag: AirDrag,
    /// Temperatures; `None` for a sheet without a thermal network.
    pub(crate) heat: Option<Box<SheetTemperature>>,
    described_temperature: DescribedTemperature,
    /// Instability detector and recovery policy; `None` for [`crate::scene::WhenUnstable::Stop`].
    pub(crate) recovery: Option<Box<RecoveryPolicy>>,
    /// Buckling detector; `None` where buckling is not reported.
    buckle_detector: Option<Box<buckling::BuckleDetector>>,
    /// State of creep and plasticity; `None` for an elastic sheet.
    inelastic: Option<Box<InelasticState>>,
    /// Fracture state; `None` for a sheet whose cells cannot open.
    fracture: Option<Box<FractureState>>,
    /// Area per node of an adhesive sheet, m²; empty otherwise.
    adhesion_areas: Vec<f64>,
    /// Linear system of an implicit integrator, built by the first implicit step.
    system: Option<Box<ImplicitSystem>>,
    last_field: Option<Field>,
    pub(crate) flexion: Flexion,
    pub(crate) thickness_limit: Option<ThicknessLimit>,
    pub(crate) pins: Pins,
    /// Nodes clamped in position and slope.
    pub(crate) clamped: Vec<bool>,
    pub(crate) engine_kind: IntegratorKind,
    pub(crate) engine: Box<dyn Integrator>,
    pub(crate) stack: LayerStack,
    /// Time below the sleep threshold, s; `rest_positions` are the positions (m) at its start.
    pub(crate) rest_time: f64,
    /// Whether the nodes or their mobility may have changed other than by a step.
    pub(crate) displaced: bool,
    pub(crate) rest_positions: Vectors,
    pub(crate) work: StepWorkspace,
    material: Material,
    damping_ratio: f64,
    /// Longer side, m.
    length: f64,
    /// Length and width (m, at rest) to which [`Sheet::uv`] refers.
    pub(crate) extent: (f64, f64),
    /// Initial distance of the layers, m; 1 for a single layer.
    pub(crate) gap: f64,
    spring_parameters: SpringParameters,
    /// Initial diagonal of the bounding box, m.
    pub(crate) initial_diagonal: f64,
    /// Columns and rows of nodes along creases.
    folds: surface::CreaseLines,
    /// Longest stable step of the explicit integrator, s; infinite unless the grid has changed.
    pub(crate) max_step: f64,
}

/// Meshes of an outlined sheet.
#[derive(Default)]
struct OutlineMeshes {
    /// Present mesh.
    present: Option<Arc<TriangleMesh>>,
    /// Grid of the scene and its mesh, after a change of grid.
    described: Option<((u32, u32), Arc<TriangleMesh>)>,
}

/// Temperature of a sheet in its description.
struct DescribedTemperature {
    /// Initial temperature, °C; that of the surroundings without a value.
    initial: Option<f64>,
    /// Whether the two sides may have different temperatures.
    has_gradient: bool,
}

/// Triples of nodes in a line of a lattice that has a flexion limit.
#[derive(Default)]
pub(crate) struct Flexion {
    /// Nodes of each triple, the middle one second.
    pub triples: Vec<[u32; 3]>,
    pub limit: Option<FlexionLimit>,
}

/// Parameters of the springs relative to the material.
#[derive(Default)]
struct SpringParameters {
    /// Stiffness of each spring per N/m of E t, or per N m of bending stiffness for calibrated
    /// springs.
    per_unit: Vec<f64>,
    /// Whether the springs are calibrated to the bending stiffness.
    is_calibrated: bool,
    /// Delivered over requested bending stiffness; `None` for springs that are not calibrated.
    delivered_fraction: Option<f64>,
    /// Damping of each spring as a fraction of critical.
    damping: f64,
    /// Whether any spring has a dashpot.
    has_dashpots: bool,
}

/// Workspace of a step. It persists between steps, so that a warm step does not allocate.
#[derive(Default)]
pub(crate) struct StepWorkspace {
    pub springs: SpringWorkspace,
    pub force: Vectors,
    pub x_before: Vectors,
    pub v_before: Vectors,
    /// Positions (m) and velocities (m/s) at the start of the step.
    pub start: (Vectors, Vectors),
    /// Unit normal and fraction of the impact of each node in this step; the fraction is 0 without
    /// an impact.
    pub layer_impacts: Vec<LayerImpact>,
    pub touching: Vec<bool>,
    pub stage: stage::StageWorkspace,
    /// Adhesive bonds.
    pub adhesion: Option<Box<bonds::AdhesionState>>,
    /// Positions (m) of the first and last node and the bounding box (m) of a sheet at rest.
    pub resting: Option<((Option<DVec3>, Option<DVec3>), (DVec3, DVec3))>,
    /// Positions during the step, recorded when buckling is detected.
    pub trace: Option<Box<stage_trace::StageTrace>>,
    /// Colliders touched by nodes in this step.
    pub touched_colliders: Vec<(rapier3d::prelude::ColliderHandle, u32)>,
    /// Number of entries of `touched_colliders` that touch at the end of the step.
    pub touched_at_end: usize,
}

impl Sheet {
    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.x.len()
    }

    /// Mass of node `i`, kg. Panics for an index out of range.
    pub fn node_mass(&self, i: usize) -> f64 {
        self.mass[i]
    }

    /// Whether node `i` is fixed or kinematic in every direction.
    pub fn is_held(&self, i: usize) -> bool {
        self.inverse_mass[i] == 0.0
    }

    /// Mass of the whole sheet, kg.
    pub fn total_mass(&self) -> f64 {
        self.mass.iter().sum()
    }

    /// Drawing surface of layer `index` with `parts` spline segments between neighbouring nodes;
    /// `None` for a layer that does not exist. A sheet with open cells is drawn flat between its
    /// nodes, without the open cells.
    pub fn surface(&self, index: usize, parts: u32) -> Option<DrawingSurface> {
        if self.open_cell_set().is_some() {
            let layer = self.layers.get(index)?;
            let mut surface = DrawingSurface::new(layer, &self.uv, 1);
            let closed = self.closed_triangles(layer.triangles());
            surface.set_triangles(closed.into_iter().map(|t| t.map(|i| i - layer.first)).collect());
            return Some(surface);
        }
        match &self.meshes.present {
            Some(mesh) => (index == 0).then(|| DrawingSurface::from_mesh(mesh, &self.uv, parts)),
            None => {
                self.layers.get(index).map(|layer| DrawingSurface::with_creases(layer, &self.uv, parts, &self.folds))
            }
        }
    }

    /// Springs of a lattice.
    pub fn springs(&self) -> &Springs {
        &self.springs
    }

    /// Present material.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// Damping ratio of the lowest bending mode (shell and calibrated lattices).
    pub fn damping_ratio(&self) -> f64 {
        self.damping_ratio
    }

    /// Change the damping ratio of the lowest bending mode, 0 to 10.
    ///
    /// # Errors
    /// When out of range; nothing is changed then.
    pub fn set_damping_ratio(&mut self, ratio: f64) -> Result<(), InputError> {
        Id::DampingRatio.check("damping_ratio", ratio)?;
        self.damping_ratio = ratio;
        self.refresh();
        Ok(())
    }

    /// Present membrane stiffness, bending stiffness and retardation time.
    pub fn law(&self) -> ElementLaw {
        self.material.law(self.length, self.damping_ratio)
    }

    /// Linear solver of an implicit integrator: name, block rows of the matrix, blocks of the
    /// matrix, nonzeros of the factor. `None` before the first implicit step.
    pub fn solver(&self) -> Option<(&'static str, usize, usize, usize)> {
        self.system.as_ref().map(|s| s.statistics())
    }

    /// Spring dashpots as a fraction of critical damping.
    pub fn damping(&self) -> f64 {
        self.spring_parameters.damping
    }

    /// Limit of the flexion angle, degrees; `None` without a limit.
    pub fn flexion_angle_limit(&self) -> Option<f64> {
        self.flexion.limit.as_ref().map(|l| l.limit)
    }

    /// Largest present angle of the flexion triples, degrees; `None` for a structure without
    /// flexion.
    pub fn largest_flexion_angle(&self) -> Option<f64> {
        (!self.flexion.triples.is_empty())
            .then(|| FlexionLimit { triples: self.flexion.triples.clone(), limit: 180.0 }.largest_angle(&self.x))
    }

    /// Smallest distance of a node from the layer below, over that distance at rest; `None` for a
    /// single layer or without a limit.
    pub fn squeezed_to(&self) -> Option<f64> {
        self.thickness_limit.as_ref().map(|l| l.lowest(&self.x))
    }

    /// Nodes that touched a body in the last step.
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
        (0..self.node_count()).map(|i| (self.x.get(i) - centre).cross(self.v.get(i)) * self.mass[i]).sum()
    }

    /// Whether an applied force, a grab or a pressure acts on it.
    pub(crate) fn is_loaded(&self) -> bool {
        !self.grabs.is_empty() || self.applied.max_squared() > 0.0 || self.drag.pressure != 0.0
    }

    /// Energies under `gravity` (m/s²), J. The potential energy of gravity is zero at the origin.
    pub fn energy(&self, gravity: DVec3) -> Energy {
        Energy::new(self, gravity)
    }

    /// Adhesion parameters; `None` for a sheet without adhesion.
    pub(crate) fn tack(&self) -> Option<Adhesion> {
        if self.adhesion_areas.is_empty() { None } else { self.material.tack }
    }

    /// Area of node `i` of an adhesive sheet, m².
    pub(crate) fn area_of(&self, i: u32) -> f64 {
        self.adhesion_areas.get(i as usize).copied().unwrap_or(0.0)
    }

    /// Largest speed of a node, m/s.
    pub fn max_speed(&self) -> f64 {
        self.v.max_squared().sqrt()
    }

    /// Largest angular frequency of the present state, rad/s, by power iteration on its stiffness.
    /// The longest stable explicit step is the integrator's stability limit over this frequency.
    /// 200 `iterations` give about 1 % accuracy.
    pub fn largest_frequency(&self, iterations: usize) -> f64 {
        energy::largest_frequency(self, iterations)
    }

    /// Time integrator (scene keyword `engine`).
    pub fn engine(&self) -> IntegratorKind {
        self.engine_kind
    }

    /// Change the time integrator from the next step on; `tolerance` is the error tolerance (m) of
    /// an adaptive integrator.
    pub fn set_engine(&mut self, kind: IntegratorKind, tolerance: f64) {
        if let Some(guard) = &mut self.recovery {
            (guard.state, guard.tolerance) = (RecoveryState::default(), tolerance);
        }
        self.change_engine(kind, tolerance);
        if self.max_step.is_finite() {
            self.update_max_step();
        }
        self.wake();
    }

    /// Change the integrator and its tolerance (m), and nothing else.
    pub(crate) fn change_engine(&mut self, kind: IntegratorKind, tolerance: f64) {
        if kind != self.engine_kind {
            self.engine = kind.construct();
            self.engine_kind = kind;
            // A new implicit integrator restarts without the rates that another left in the
            // elements.
            self.last_field = None;
        }
        self.engine.set_tolerance(tolerance);
    }

    /// Change the material. Stiffness and dashpots follow at once; node masses stay.
    ///
    /// # Errors
    /// When a constant is out of range; nothing is changed then.
    pub fn set_material(&mut self, material: Material) -> Result<(), InputError> {
        crate::scene::validate::material("material", &material)?;
        if self.inelastic.is_some() && material.burgers != self.material.burgers {
            return Err(InputError::new("material.burgers", "cannot change while the sheet creeps"));
        }
        if let Some(heat) = &mut self.heat {
            heat.set_material(&material);
        }
        self.material = material;
        self.refresh();
        self.update_thermal_stiffness();
        if self.max_step.is_finite() {
            self.update_max_step();
        }
        Ok(())
    }

    /// Change the dashpots of the springs: a fraction of critical damping, 0 to 10.
    ///
    /// # Errors
    /// When out of range; nothing is changed then.
    pub fn set_damping(&mut self, damping: f64) -> Result<(), InputError> {
        Id::Damping.check("damping", damping)?;
        self.spring_parameters.damping = damping;
        self.refresh();
        Ok(())
    }

    /// Set or remove the angle limit of the flexion triples, degrees.
    ///
    /// # Errors
    /// When out of range or the structure has no flexion; nothing is changed then.
    pub fn set_flexion_limit(&mut self, limit: Option<f64>) -> Result<(), InputError> {
        if let Some(limit) = limit {
            Id::FlexionLimit.check("flexion_limit", limit)?;
            if self.flexion.triples.is_empty() {
                let problem = format!("{} has no flexion triples to limit", self.structure);
                return Err(InputError::new("flexion_limit", problem));
            }
        }
        self.flexion.limit = limit.map(|limit| FlexionLimit { triples: self.closed_triples(), limit });
        self.wake();
        Ok(())
    }

    /// Wake a sleeping or frozen sheet.
    pub fn wake(&mut self) {
        self.rest_time = 0.0;
        self.displaced = true;
        self.invalidate_interpenetration();
        if matches!(self.status, Status::Asleep | Status::Frozen { .. }) {
            self.status = Status::Awake;
        }
    }

    /// Request a test of interpenetration with other sheets before the next step.
    pub(crate) fn invalidate_interpenetration(&mut self) {
        if self.interpenetration == Interpenetration::None {
            self.interpenetration = Interpenetration::Unknown;
        }
    }

    /// Update stiffness and dashpots from material and damping: k = (k per E t) E t and c = ζ · 2
    /// √(k μ) with the reduced mass μ; for calibrated springs k = (k per D) D and c = τ k.
    fn refresh(&mut self) {
        let law = self.law();
        self.elements.iter_mut().for_each(|e| e.set_law(&law));
        self.refresh_springs();
    }

    /// Update the springs as [`Sheet::refresh`] does, without the elements.
    pub(crate) fn refresh_springs(&mut self) {
        let law = self.law();
        let unit = if self.spring_parameters.is_calibrated {
            self.material.plate_stiffness()
        } else {
            self.material.young * self.material.thickness
        };
        for i in 0..self.springs.len() {
            let (ma, mb) = (self.mass[self.springs.a[i] as usize], self.mass[self.springs.b[i] as usize]);
            let mut k = self.spring_parameters.per_unit[i] * unit;
            if let Some(heat) = &self.heat {
                k *= heat.spring_softness(i);
            }
            let critical = 2.0 * (k * ma * mb / (ma + mb)).sqrt();
            let dashpot = if self.spring_parameters.is_calibrated {
                law.retardation * k
            } else {
                self.spring_parameters.damping * critical
            };
            self.springs.set_law(i, k, dashpot);
        }
        self.spring_parameters.has_dashpots = self.springs.is_damped();
        self.update_inelastic_law();
        if let Some(system) = &mut self.system {
            system.refresh(&self.springs);
        }
        self.wake();
    }
}
