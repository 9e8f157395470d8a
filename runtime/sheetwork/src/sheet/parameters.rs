//! Parameters of a sheet: material, coefficients and loads, which a user may change between steps.
//! Setters of [`Sheet`](crate::sheet::Sheet) check their ranges and update what depends on them.

use crate::elements::flexion_limit::FlexionLimit;
use crate::elements::thickness_limit::ThicknessLimit;
use crate::math::Vectors;
use crate::scene::Material;
use crate::sheet::air_drag::AirDrag;
use crate::sheet::inter_layer::InterLayerSprings;

/// Parameters of a running sheet.
pub struct SheetParameters {
    /// Constant force on each node, N.
    pub applied: Vectors,
    /// Friction coefficient, 0 to 10.
    pub friction: f64,
    /// Restitution coefficient, 0 to 1.
    pub restitution: f64,
    pub(crate) material: Material,
    /// Damping ratio of the lowest bending mode.
    pub(crate) damping_ratio: f64,
    pub(crate) springs: SpringParameters,
    pub(crate) drag: AirDrag,
    pub(crate) flexion: Flexion,
    pub(crate) thickness_limit: Option<ThicknessLimit>,
    /// Longest stable step of the explicit integrator, s; infinite unless the grid has changed.
    pub(crate) max_step: f64,
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
pub(crate) struct SpringParameters {
    /// Stiffness of each spring per N/m of E t, or per N m of bending stiffness for calibrated
    /// springs.
    pub per_unit: Vec<f64>,
    /// Stiffness between layers.
    pub inter_layer: InterLayerSprings,
    /// Whether the springs are calibrated to the bending stiffness.
    pub is_calibrated: bool,
    /// Delivered over requested bending stiffness; `None` for springs that are not calibrated.
    pub delivered_fraction: Option<f64>,
    /// Damping of each spring as a fraction of critical.
    pub damping: f64,
    /// Whether any spring has a dashpot.
    pub has_dashpots: bool,
}
