//! Calibration of lattices: spring stiffness from the stiffness of a sheet, for every structure.
//!
//! A request describes the sheet (plate stiffness, mass per area, size, clamped edges) and the
//! lattice. The result has a stiffness for every spring, a mass for every node, the springs cut by
//! clamps, and the delivered stiffness. In order:
//!
//! 1. `cell` extracts one period of the generated lattice;
//! 2. `fit` finds the stiffness of springs far from edges (least squares on `homogenise`d stiffness
//!    tensors, `nnls`);
//! 3. `free_edge` finds factors for springs beside free edges, `clamp` cuts springs at clamps,
//!    `mass` distributes the area, `brace` supports loose corners;
//! 4. `delivered` compares the result with the request.
//!
//! A lattice of central springs has D12 = D66 (Cauchy's relations; Love, *Mathematical Theory of
//! Elasticity*, note B): its Poisson's ratio is 1/3 for any request. Bending stiffness D11 cos⁴θ +
//! 2 (D12 + 2 D66) cos²θ sin²θ + D22 sin⁴θ can still be as requested in every direction θ; the fit
//! finds it where the structure has the springs for it.
//!
//! Pure functions of data: SI units, no state.

pub(crate) mod anticlastic;
pub(crate) mod brace;
pub(crate) mod cell;
pub(crate) mod clamp;
pub(crate) mod delivered;
pub(crate) mod dense;
pub(crate) mod fit;
pub(crate) mod free_edge;
pub(crate) mod homogenise;
pub(crate) mod mass;
pub(crate) mod nnls;
pub(crate) mod orthotropic;
pub(crate) mod target;
#[cfg(test)]
mod tests;

use crate::error::{InputError, check_range, reject_if};
use crate::mesh::structure::{Lattice, LatticeSpec, LatticeSpring, StructureKind, generate};

pub use crate::material::calibration::anticlastic::strip_bending;
pub use crate::material::calibration::clamp::WallSpring;
pub use crate::material::calibration::delivered::DeliveredRatios;
pub use crate::material::calibration::orthotropic::{FabricUnits, MeasuredFabric, Orthotropic};
pub use crate::material::calibration::target::{StiffnessTarget, Voigt};

/// Default distance between layers, in spacings of the grid.
///
/// Large enough that bending does not snap one layer through the next, small enough that shear
/// between layers is small.
const GAP_PER_SPACING: f64 = 0.25;

/// Clamped edges of a sheet: position and slope are fixed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClampedEdges {
    /// Edge at the smallest x (u = 0).
    pub left: bool,
    /// Edge at the largest x (u = 1).
    pub right: bool,
    /// Edge at the smallest z (v = 0).
    pub back: bool,
    /// Edge at the largest z (v = 1).
    pub front: bool,
}

/// Request for a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationRequest {
    /// Structure.
    pub structure: StructureKind,
    /// Nodes along the length, layers, nodes along the width.
    pub grid: (u32, u32, u32),
    /// Length and width, m.
    pub size: (f64, f64),
    /// Distance between layers, m, 1e-7 to 10; `None` for a quarter of the larger spacing of the
    /// grid.
    pub gap: Option<f64>,
    /// Whether cross-over springs join second neighbours along every spring line.
    pub cross_over: bool,
    /// Stiffness of second neighbours (flexion, cross-over) as a fraction of the first neighbours'
    /// on their line; 0 to 1000.
    pub second_neighbour: f64,
    /// Stiffness of the sheet.
    pub target: StiffnessTarget,
    /// Mass per area of the sheet, kg/m²; 1e-9 to 1e6.
    pub areal_mass: f64,
    /// Clamped edges.
    pub clamped: ClampedEdges,
    /// Wavelength of the reported loss to shear, m, 1e-6 to 1e6; `None` for the larger side.
    pub wavelength: Option<f64>,
}

impl CalibrationRequest {
    /// Sheet with free edges and the default gap.
    pub fn new(
        structure: StructureKind,
        grid: (u32, u32, u32),
        size: (f64, f64),
        target: StiffnessTarget,
        areal_mass: f64,
    ) -> Self {
        Self {
            structure,
            grid,
            size,
            gap: None,
            cross_over: false,
            second_neighbour: 1.0,
            target,
            areal_mass,
            clamped: ClampedEdges::default(),
            wavelength: None,
        }
    }
}

/// Calibrated lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Specification of the lattice, with the gap.
    pub spec: LatticeSpec,
    /// The lattice.
    pub lattice: Lattice,
    /// Stiffness of every spring, N/m, in the order of the lattice's links.
    pub stiffness: Vec<f64>,
    /// Braces for nodes without inter-layer springs, with their stiffness, N/m.
    pub braces: Vec<(LatticeSpring, f64)>,
    /// Mass of every node, kg, in the order of the lattice's positions.
    pub mass: Vec<f64>,
    /// Nodes in the planes of the clamps, to be fixed.
    pub held: Vec<u32>,
    /// Springs from free nodes to the planes of the clamps.
    pub walls: Vec<WallSpring>,
    /// Delivered stiffness.
    pub delivered: DeliveredRatios,
}

/// Calibrate a lattice.
///
/// # Errors
/// When the grid, the size, the gap or a value of the request is out of range; the error names the
/// field.
pub fn calibrate(request: &CalibrationRequest) -> Result<Calibration, InputError> {
    let spec = specification(request)?;
    let lattice = generate(&spec)?;
    if spec.structure == StructureKind::Shell {
        return Ok(without_springs(request, spec, lattice));
    }
    let pattern = cell::LatticePattern {
        structure: spec.structure,
        layers: spec.grid.1,
        spacing: spec.spacing(),
        gap: spec.gap,
        cross_over: spec.cross_over,
    };
    let cell = pattern.periodic();
    let bulk = fit::fit(&pattern, &cell, &request.target, request.second_neighbour);
    let k = bulk.of_cell(&cell);
    let bending = homogenise::homogenise(&cell, &k).free_bending();
    let edges = free_edge::EdgeStiffness::new(&pattern, &bulk, &bending);
    let sites = cell::sites(&lattice);
    let stiffness = lattice.links.iter().map(|link| {
        let (a, b) = (link.a as usize, link.b as usize);
        let layer = &lattice.layers[link.layer as usize];
        let grid = (i64::from(layer.nx), i64::from(layer.nz));
        bulk.stiffness(link.class, link.layer, lattice.positions[b] - lattice.positions[a])
            * edges.factor(link.class, sites[a], sites[b], grid, request.clamped)
    });
    Ok(Calibration {
        stiffness: stiffness.collect(),
        braces: brace::braces(&lattice, &bulk),
        mass: mass::node_masses(&lattice, spec.size, request.areal_mass),
        held: clamp::fixed_nodes(&lattice, spec.size, request.clamped),
        walls: clamp::cut(&spec, &lattice, &bulk, &edges, request.clamped),
        delivered: DeliveredRatios::of(request, &pattern, &cell, &k, &edges),
        spec,
        lattice,
    })
}

/// Result for the shell, which has no springs: node masses and fixed nodes.
fn without_springs(request: &CalibrationRequest, spec: LatticeSpec, lattice: Lattice) -> Calibration {
    Calibration {
        stiffness: Vec::new(),
        braces: Vec::new(),
        mass: mass::node_masses(&lattice, spec.size, request.areal_mass),
        held: clamp::fixed_nodes(&lattice, spec.size, request.clamped),
        walls: Vec::new(),
        delivered: DeliveredRatios::exact(&request.target),
        spec,
        lattice,
    }
}

/// Number of rows with which the triangles of a triangular lattice of `columns` nodes are closest
/// to equilateral, and its bending isotropic; `None` for other structures.
pub fn isotropic_rows(structure: StructureKind, columns: u32, size: (f64, f64)) -> Option<u32> {
    let row = size.0 / (f64::from(columns) - 0.5) * 0.75_f64.sqrt();
    structure.info().triangular.then(|| ((size.1 / row).round() as u32).saturating_add(1).max(2))
}

/// Default distance between layers, m.
pub fn default_gap(structure: StructureKind, grid: (u32, u32, u32), size: (f64, f64)) -> f64 {
    let (dx, dz) = LatticeSpec { structure, grid, size, gap: 1.0, cross_over: false }.spacing();
    (GAP_PER_SPACING * dx.max(dz)).clamp(1e-7, 10.0)
}

fn specification(request: &CalibrationRequest) -> Result<LatticeSpec, InputError> {
    check_range("areal_mass", request.areal_mass, 1e-9, 1e6, "kg/m²")?;
    check_range("second_neighbour", request.second_neighbour, 0.0, 1e3, "")?;
    check_range("wavelength", request.wavelength.unwrap_or(1.0), 1e-6, 1e6, "m")?;
    let entries = request.target.membrane.iter().chain(&request.target.bending).flatten();
    let is_wrong = entries.clone().any(|v| !v.is_finite()) || request.target.largest_bending() <= 0.0;
    reject_if!(is_wrong, "target", "is not the stiffness of a sheet");
    Ok(LatticeSpec {
        structure: request.structure,
        grid: request.grid,
        size: request.size,
        gap: request.gap.unwrap_or_else(|| default_gap(request.structure, request.grid, request.size)),
        cross_over: request.cross_over,
    })
}
