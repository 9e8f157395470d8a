//! Calibrated lattices: from the stiffness of a sheet to the stiffness of springs, for every structure.
//!
//! A request says what the sheet is (plate stiffness, mass per area, size, clamped edges) and which lattice carries it. The
//! answer has a stiffness for every spring, a mass for every node, the springs that clamps cut, and what of all that was asked
//! is delivered. In order:
//!
//! 1. `cell` cuts one period out of the generated lattice;
//! 2. `fit` finds the stiffness of springs far from edges (least squares on `homogenise`d stiffness tensors, `nnls`);
//! 3. `boundary` finds factors for springs beside free edges, `wall` cuts springs at clamps, `mass` shares the area,
//!    `brace` ties loose corners;
//! 4. `delivered` compares and says what is missing.
//!
//! A lattice of central springs has D12 = D66 (Cauchy's relations; Love, *Mathematical Theory of Elasticity*, note B): its
//! Poisson's ratio is 1/3 whatever was asked. Bending stiffness D11 cos⁴θ + 2 (D12 + 2 D66) cos²θ sin²θ + D22 sin⁴θ can
//! still be as asked in every direction θ, which is what the fit finds where the structure has the springs for it.
//!
//! Pure functions of data: SI units, no state.

pub(crate) mod anticlastic;
pub(crate) mod boundary;
pub(crate) mod brace;
pub(crate) mod cell;
pub(crate) mod delivered;
pub(crate) mod dense;
pub(crate) mod fit;
pub(crate) mod homogenise;
pub(crate) mod mass;
pub(crate) mod nnls;
pub(crate) mod target;
#[cfg(test)]
mod tests;
pub(crate) mod wall;

use crate::error::{InputError, check_range};
use crate::mesh::structure::{Lattice, LatticeSpec, Link, StructureKind, generate};

pub use crate::material::calibration::anticlastic::strip_bending;
pub use crate::material::calibration::delivered::Delivered;
pub use crate::material::calibration::target::{Orthotropic, Target, Voigt};
pub use crate::material::calibration::wall::WallSpring;

/// Distance between layers that is chosen where none is given, in spacings of the grid.
///
/// Far enough apart that bending does not snap one layer through the next, near enough that shear between them is small.
const GAP_PER_SPACING: f64 = 0.25;

/// Edges of a sheet that are clamped: held as if the sheet went on, straight, inside a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clamped {
    /// The edge at the smallest x (u = 0).
    pub left: bool,
    /// The edge at the largest x (u = 1).
    pub right: bool,
    /// The edge at the smallest z (v = 0).
    pub back: bool,
    /// The edge at the largest z (v = 1).
    pub front: bool,
}

/// What is to be calibrated.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Structure.
    pub structure: StructureKind,
    /// Masses along the length, layers, masses along the width.
    pub grid: (u32, u32, u32),
    /// Length and width, m.
    pub size: (f64, f64),
    /// Distance between layers, m, 1e-7 to 10; none for a quarter of the larger spacing of the grid.
    pub gap: Option<f64>,
    /// Whether second neighbours along every spring line are joined (cross-over springs).
    pub cross_over: bool,
    /// Stiffness of second neighbours (flexion, cross-over) as a fraction of the first neighbours' on their line; 0 to 1000.
    pub second_neighbour: f64,
    /// Stiffness of the sheet.
    pub target: Target,
    /// Mass per area of the sheet, kg/m²; 1e-9 to 1e6.
    pub areal_mass: f64,
    /// Which edges are clamped.
    pub clamped: Clamped,
    /// Wavelength for which loss to shear is reported, m, 1e-6 to 1e6; none for the larger side.
    pub wavelength: Option<f64>,
}

impl Request {
    /// A sheet with free edges and a gap of the calibration's choosing.
    pub fn new(
        structure: StructureKind,
        grid: (u32, u32, u32),
        size: (f64, f64),
        target: Target,
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
            clamped: Clamped::default(),
            wavelength: None,
        }
    }
}

/// A calibrated lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// What it was generated from, with the gap.
    pub spec: LatticeSpec,
    /// The lattice.
    pub lattice: Lattice,
    /// Stiffness of every spring, N/m, in the order of the lattice's links.
    pub stiffness: Vec<f64>,
    /// Springs to be added to the lattice, with their stiffness, N/m: for masses that its layers leave loose.
    pub braces: Vec<(Link, f64)>,
    /// Mass of every node, kg, in the order of the lattice's positions.
    pub mass: Vec<f64>,
    /// Masses in the planes of the clamps: to be held.
    pub held: Vec<u32>,
    /// Springs from free masses to the planes of the clamps.
    pub walls: Vec<WallSpring>,
    /// What is delivered of what was asked.
    pub delivered: Delivered,
}

/// Calibrates a lattice.
///
/// # Errors
/// When the grid, the size, the gap or a value of the request is out of range; the error names the field.
pub fn calibrate(request: &Request) -> Result<Calibration, InputError> {
    let spec = specification(request)?;
    let lattice = generate(&spec)?;
    if spec.structure == StructureKind::Shell {
        return Ok(without_springs(request, spec, lattice));
    }
    let pattern = cell::Pattern {
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
    let edges = boundary::Boundary::new(&pattern, &bulk, &bending);
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
        mass: mass::shares(&lattice, spec.size, request.areal_mass),
        held: wall::held(&lattice, spec.size, request.clamped),
        walls: wall::cut(&spec, &lattice, &bulk, &edges, request.clamped),
        delivered: Delivered::of(request, &pattern, &cell, &k, &edges),
        spec,
        lattice,
    })
}

/// A structure that is the sheet itself: masses and what is held, and nothing to calibrate.
fn without_springs(request: &Request, spec: LatticeSpec, lattice: Lattice) -> Calibration {
    Calibration {
        stiffness: Vec::new(),
        braces: Vec::new(),
        mass: mass::shares(&lattice, spec.size, request.areal_mass),
        held: wall::held(&lattice, spec.size, request.clamped),
        walls: Vec::new(),
        delivered: Delivered::exact(&request.target),
        spec,
        lattice,
    }
}

/// The rows with which the triangles of a triangular lattice of `columns` masses come nearest to equilateral, where all its
/// directions bend alike; none for other structures.
pub fn isotropic_rows(structure: StructureKind, columns: u32, size: (f64, f64)) -> Option<u32> {
    let row = size.0 / (f64::from(columns) - 0.5) * 0.75_f64.sqrt();
    structure.info().triangular.then(|| ((size.1 / row).round() as u32).saturating_add(1).max(2))
}

/// The distance between layers that is chosen where none is given, m.
pub fn default_gap(structure: StructureKind, grid: (u32, u32, u32), size: (f64, f64)) -> f64 {
    let (dx, dz) = LatticeSpec { structure, grid, size, gap: 1.0, cross_over: false }.spacing();
    (GAP_PER_SPACING * dx.max(dz)).clamp(1e-7, 10.0)
}

fn specification(request: &Request) -> Result<LatticeSpec, InputError> {
    check_range("areal_mass", request.areal_mass, 1e-9, 1e6, "kg/m²")?;
    check_range("second_neighbour", request.second_neighbour, 0.0, 1e3, "")?;
    check_range("wavelength", request.wavelength.unwrap_or(1.0), 1e-6, 1e6, "m")?;
    let entries = request.target.membrane.iter().chain(&request.target.bending).flatten();
    if entries.clone().any(|v| !v.is_finite()) || request.target.largest_bending() <= 0.0 {
        return Err(InputError::new("target", "is not the stiffness of a sheet"));
    }
    Ok(LatticeSpec {
        structure: request.structure,
        grid: request.grid,
        size: request.size,
        gap: request.gap.unwrap_or_else(|| default_gap(request.structure, request.grid, request.size)),
        cross_over: request.cross_over,
    })
}
