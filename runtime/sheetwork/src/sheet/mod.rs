//! Sheets: nodes with positions and velocities, springs or shell elements between them, a material,
//! prescribed degrees of freedom, and a time integrator.
//!
//! `build` makes a [`Sheet`] from a [`SheetSpec`](crate::scene::SheetSpec) or a .SHT file, the
//! setters here change a running sheet, and [`crate::islands`] steps it. SI units throughout.

#[doc(hidden)]
pub mod accelerations;
pub(crate) mod air_drag;
pub(crate) mod air_parameters;
mod assembly;
#[doc(hidden)]
pub(crate) mod attached_body;
pub mod attachment;
pub(crate) mod b_spline;
pub(crate) mod bonds;
pub(crate) mod buckling;
pub(crate) mod build;
pub(crate) mod cell_state;
pub(crate) mod cells;
pub(crate) mod creases;
pub(crate) mod creep;
pub(crate) mod damped_modes;
pub(crate) mod delivered_stiffness;
pub(crate) mod energy;
pub(crate) mod equilibrium;
pub(crate) mod forces;
pub(crate) mod fracture;
pub(crate) mod generation;
pub(crate) mod grab;
pub(crate) mod implicit_system;
pub(crate) mod instability;
pub mod inter_layer;
pub mod layer_stack;
pub mod material_report;
pub mod model;
pub(crate) mod modes;
pub(crate) mod node_contact;
pub mod parameters;
pub(crate) mod pins;
pub(crate) mod plate_aerodynamics;
mod prescribed_nodes;
pub(crate) mod probe;
pub(crate) mod reaction;
pub(crate) mod refine;
pub(crate) mod region;
pub(crate) mod remap;
pub(crate) mod serialization;
pub(crate) mod slits;
pub(crate) mod smooth_surface;
pub(crate) mod snapshot;
pub(crate) mod stage;
#[doc(hidden)]
pub mod stage_trace;
pub mod state;
pub mod surface;
pub mod temperature;
pub(crate) mod wind;
pub(crate) mod wireframe;

use glam::DVec3;

pub use crate::math::Vectors;
pub use crate::sheet::accelerations::Field;
pub use crate::sheet::buckling::Buckling;
pub use crate::sheet::build::{from_file, to_file};
pub use crate::sheet::cells::SheetCells;
pub use crate::sheet::delivered_stiffness::DeliveredStiffness;
pub use crate::sheet::energy::Energy;
pub use crate::sheet::equilibrium::Equilibrium;
pub use crate::sheet::forces::{ForceKind, ForcePartner};
pub use crate::sheet::fracture::FractureOpening;
pub(crate) use crate::sheet::instability::{
    KineticElasticEnergy, PRESCRIBED_MOTION_ENERGY_FACTOR, RECOVERY_INTEGRATOR, RecoveryPolicy, RecoveryState,
};
pub use crate::sheet::model::SheetModel;
pub use crate::sheet::modes::Mode;
pub use crate::sheet::parameters::SheetParameters;
pub use crate::sheet::pins::Pins;
pub use crate::sheet::probe::Probe;
pub use crate::sheet::region::select;
pub(crate) use crate::sheet::snapshot::SavedSheetState;
pub(crate) use crate::sheet::state::Interpenetration;
pub use crate::sheet::state::{Counters, SheetState, Status};
use crate::sheet::surface::{DrawingSurface, SurfaceSmoothing};

use crate::elements::Element;
use crate::elements::flexion_limit::FlexionLimit;
use crate::elements::flexion_limit::solver::FlexionWorkspace;
use crate::elements::grab_spring::GrabSpring;
use crate::elements::spring::{SpringWorkspace, Springs};
use crate::error::{InputError, reject_if};
use crate::integrators::Integrator;
use crate::material::law::ElementLaw;
use crate::material::loss_factor::MAX_LOSS_FACTOR;
use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::StructureKind;
use crate::scene::{Adhesion, IntegratorKind, Material};
pub(crate) use crate::sheet::implicit_system::ImplicitSystem;
use crate::sheet::layer_stack::{LayerImpact, LayerStack};
use crate::units::parameters::ParameterId as Id;

/// Sheet of a world.
pub struct Sheet {
    /// Name, unique in its world.
    pub name: String,
    /// Mesh, masses and rest shape: what only an edit of the structure changes.
    pub model: SheetModel,
    /// Material, loads and coefficients: what a user may change between steps.
    pub parameters: SheetParameters,
    /// All that evolves in a step, apart from the histories in `elements` and `engine`.
    pub state: SheetState,
    /// Named material points.
    pub probes: Vec<Probe>,
    pub(crate) inverse_mass: Vec<f64>,
    pub(crate) springs: Springs,
    /// Membrane and bending of a shell, wall springs of clamps, and grab springs last.
    pub(crate) elements: Vec<Box<dyn Element>>,
    /// Grab springs. Each is also one of the last elements, in this order.
    grabs: Vec<GrabSpring>,
    pub(crate) pins: Pins,
    pub(crate) stack: LayerStack,
    /// Instability detector and recovery policy; `None` for [`crate::scene::WhenUnstable::Stop`].
    pub(crate) recovery: Option<Box<RecoveryPolicy>>,
    pub(crate) engine_kind: IntegratorKind,
    pub(crate) engine: Box<dyn Integrator>,
    /// Linear system of an implicit integrator, built by the first implicit step.
    system: Option<Box<ImplicitSystem>>,
    /// Field of the last implicit step; `None` after a restart.
    last_field: Option<Field>,
    pub(crate) work: StepWorkspace,
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
    pub flexion: FlexionWorkspace,
    pub stage: stage::StageWorkspace,
    /// Positions (m) of the first and last node and the bounding box (m) of a sheet at rest.
    pub resting: Option<((Option<DVec3>, Option<DVec3>), (DVec3, DVec3))>,
    /// Positions during the step, recorded when buckling is detected.
    pub trace: Option<Box<stage_trace::StageTrace>>,
    /// Colliders touched by nodes in this step.
    pub touched_colliders: Vec<(rapier3d::prelude::ColliderHandle, u32)>,
    /// Number of entries of `touched_colliders` that touch at the end of the step.
    pub touched_at_end: usize,
    /// Whether the contact solution of the last step was not accepted and its penetration is not
    /// checked yet.
    pub is_contact_uncertain: bool,
    /// Record of the forces; `None` unless they are recorded.
    pub forces: Option<Box<forces::SheetForces>>,
}

impl Sheet {
    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.state.x.len()
    }

    /// Mass of node `i`, kg. Panics for an index out of range.
    pub fn node_mass(&self, i: usize) -> f64 {
        self.model.mass[i]
    }

    /// Whether node `i` is fixed or kinematic in every direction.
    pub fn is_held(&self, i: usize) -> bool {
        self.inverse_mass[i] == 0.0
    }

    /// Mass of the whole sheet, kg.
    pub fn total_mass(&self) -> f64 {
        self.model.mass.iter().sum()
    }

    /// Drawing surface of layer `index` with `parts` spline segments between neighbouring nodes;
    /// `None` for a layer that does not exist. A sheet with open cells is drawn flat between its
    /// nodes, without the open cells.
    pub fn surface(&self, index: usize, parts: u32) -> Option<DrawingSurface> {
        DrawingSurface::of_sheet(self, index, parts, SurfaceSmoothing::Interpolating)
    }

    /// Springs of a lattice.
    pub fn springs(&self) -> &Springs {
        &self.springs
    }

    /// Present material.
    pub fn material(&self) -> &Material {
        &self.parameters.material
    }

    /// Damping ratio of the lowest bending mode (shell and calibrated lattices).
    pub fn damping_ratio(&self) -> f64 {
        self.parameters.damping_ratio
    }

    /// Change the damping ratio of the lowest bending mode, 0 to 10.
    ///
    /// # Errors
    /// When out of range; nothing is changed then.
    pub fn set_damping_ratio(&mut self, ratio: f64) -> Result<(), InputError> {
        Id::DampingRatio.check("damping_ratio", ratio)?;
        self.parameters.damping_ratio = ratio;
        self.refresh();
        Ok(())
    }

    /// Flat loss factor η; 0 for lattices, explicit integrators and materials with a damping
    /// ratio, whose damping is that of a Kelvin-Voigt solid.
    pub fn loss_factor(&self) -> f64 {
        let eta = 2.0 * self.parameters.damping_ratio;
        let is_flat = self.parameters.material.loss_factor.is_some() && eta <= MAX_LOSS_FACTOR;
        let is_shell = self.model.structure == StructureKind::Shell;
        if is_flat && is_shell && instability::chosen_engine(self).info().implicit { eta } else { 0.0 }
    }

    /// Present membrane stiffness, bending stiffness and damping.
    pub fn law(&self) -> ElementLaw {
        let (material, eta) = (&self.parameters.material, self.loss_factor());
        if eta > 0.0 {
            return material.law(self.model.length, 0.0).with_loss_factor(eta);
        }
        material.law(self.model.length, self.parameters.damping_ratio)
    }

    /// Linear solver of an implicit integrator: name, block rows of the matrix, blocks of the
    /// matrix, nonzeros of the factor. `None` before the first implicit step.
    pub fn solver(&self) -> Option<(&'static str, usize, usize, usize)> {
        self.system.as_ref().map(|s| s.statistics())
    }

    /// Spring dashpots as a fraction of critical damping.
    pub fn damping(&self) -> f64 {
        self.parameters.springs.damping
    }

    /// Limit of the flexion angle, degrees; `None` without a limit.
    pub fn flexion_angle_limit(&self) -> Option<f64> {
        self.parameters.flexion.limit.as_ref().map(|l| l.limit)
    }

    /// Largest present angle of the flexion triples, degrees; `None` for a structure without
    /// flexion.
    pub fn largest_flexion_angle(&self) -> Option<f64> {
        (!self.parameters.flexion.triples.is_empty()).then(|| {
            FlexionLimit { triples: self.parameters.flexion.triples.clone(), limit: 180.0 }.largest_angle(&self.state.x)
        })
    }

    /// Smallest distance of a node from the layer below, over that distance at rest; `None` for a
    /// single layer or without a limit.
    pub fn squeezed_to(&self) -> Option<f64> {
        self.parameters.thickness_limit.as_ref().map(|l| l.lowest(&self.state.x))
    }

    /// Nodes that touched a body in the last step.
    pub fn touching(&self) -> &[bool] {
        &self.state.touching
    }

    /// Centre of mass, m.
    pub fn centre_of_mass(&self) -> DVec3 {
        let sum: DVec3 = self.state.x.iter().zip(&self.model.mass).map(|(x, m)| x * *m).sum();
        sum / self.total_mass()
    }

    /// Linear momentum, kg m/s.
    pub fn momentum(&self) -> DVec3 {
        self.state.v.iter().zip(&self.model.mass).map(|(v, m)| v * *m).sum()
    }

    /// Angular momentum about the centre of mass, kg m²/s.
    pub fn angular_momentum(&self) -> DVec3 {
        let centre = self.centre_of_mass();
        (0..self.node_count())
            .map(|i| (self.state.x.get(i) - centre).cross(self.state.v.get(i)) * self.model.mass[i])
            .sum()
    }

    /// Whether an applied force, a grab, a pressure or the air of a wind zone acts on it.
    pub(crate) fn is_loaded(&self) -> bool {
        let drag = &self.parameters.drag;
        let pushed = drag.pressure != 0.0 || drag.is_in_zones();
        pushed || !self.grabs.is_empty() || self.parameters.applied.max_squared() > 0.0
    }

    /// Energies under `gravity` (m/s²), J. The potential energy of gravity is zero at the origin.
    pub fn energy(&self, gravity: DVec3) -> Energy {
        Energy::new(self, gravity)
    }

    /// Adhesion parameters; `None` for a sheet without adhesion.
    pub(crate) fn tack(&self) -> Option<Adhesion> {
        if self.model.adhesion_areas.is_empty() { None } else { self.parameters.material.tack }
    }

    /// Area of node `i` of an adhesive sheet, m².
    pub(crate) fn area_of(&self, i: u32) -> f64 {
        self.model.adhesion_areas.get(i as usize).copied().unwrap_or(0.0)
    }

    /// Largest speed of a node, m/s.
    pub fn max_speed(&self) -> f64 {
        self.state.v.max_squared().sqrt()
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
        let eta = self.loss_factor();
        self.change_engine(kind, tolerance);
        if self.loss_factor() != eta {
            self.refresh();
        }
        if self.parameters.max_step.is_finite() {
            remap::update_max_step(self);
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
        let changes = material.burgers != self.parameters.material.burgers;
        reject_if!(
            self.state.inelastic.is_some() && changes,
            "material.burgers",
            "cannot change while the sheet creeps"
        );
        if let Some(heat) = &mut self.state.heat {
            heat.set_material(&material);
        }
        self.parameters.material = material;
        self.refresh();
        temperature::update_thermal_stiffness(self);
        if self.parameters.max_step.is_finite() {
            remap::update_max_step(self);
        }
        Ok(())
    }

    /// Change the dashpots of the springs: a fraction of critical damping, 0 to 10.
    ///
    /// # Errors
    /// When out of range; nothing is changed then.
    pub fn set_damping(&mut self, damping: f64) -> Result<(), InputError> {
        Id::Damping.check("damping", damping)?;
        self.parameters.springs.damping = damping;
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
            let (none, structure) = (self.parameters.flexion.triples.is_empty(), self.model.structure);
            reject_if!(none, "flexion_limit", "{structure} has no flexion triples to limit");
        }
        self.parameters.flexion.limit =
            limit.map(|limit| FlexionLimit { triples: fracture::closed_triples(self), limit });
        fracture::reset_flexion_impulses(self);
        self.wake();
        Ok(())
    }

    /// Wake a sleeping or frozen sheet.
    pub fn wake(&mut self) {
        self.state.rest_time = 0.0;
        self.state.displaced = true;
        self.invalidate_interpenetration();
        if matches!(self.state.status, Status::Asleep | Status::Frozen { .. }) {
            self.state.status = Status::Awake;
        }
    }

    /// Request a test of interpenetration with other sheets before the next step.
    pub(crate) fn invalidate_interpenetration(&mut self) {
        if self.state.interpenetration == Interpenetration::None {
            self.state.interpenetration = Interpenetration::Unknown;
        }
    }

    /// Update stiffness and dashpots from material and damping: k = (k per E t) E t and c = ζ · 2
    /// √(k μ) with the reduced mass μ; for calibrated springs k = (k per D) D and c = τ k.
    /// Springs between layers may have a stiffness of their own ([`inter_layer`]).
    fn refresh(&mut self) {
        let law = self.law();
        self.elements.iter_mut().for_each(|e| e.set_law(&law));
        self.refresh_springs();
    }

    /// Update the springs as [`Sheet::refresh`] does, without the elements.
    pub(crate) fn refresh_springs(&mut self) {
        let law = self.law();
        let unit = if self.parameters.springs.is_calibrated {
            self.parameters.material.plate_stiffness()
        } else {
            self.parameters.material.young * self.parameters.material.thickness
        };
        let between_layers = self.parameters.springs.inter_layer.unit(unit);
        for i in 0..self.springs.len() {
            let unit = if self.springs.class[i] == SpringClass::Inter { between_layers } else { unit };
            let (ma, mb) = (self.model.mass[self.springs.a[i] as usize], self.model.mass[self.springs.b[i] as usize]);
            let mut k = self.parameters.springs.per_unit[i] * unit;
            if let Some(heat) = &self.state.heat {
                k *= heat.spring_softness(i);
            }
            let critical = 2.0 * (k * ma * mb / (ma + mb)).sqrt();
            let dashpot = if self.parameters.springs.is_calibrated {
                law.retardation * k
            } else {
                self.parameters.springs.damping * critical
            };
            self.springs.set_law(i, k, dashpot);
        }
        self.parameters.springs.has_dashpots = self.springs.is_damped();
        creep::update_inelastic_law(self);
        if let Some(system) = &mut self.system {
            system.refresh(&self.springs);
        }
        self.wake();
    }
}
