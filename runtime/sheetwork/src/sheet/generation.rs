//! Generation of a sheet from its description: lattice or mesh, node masses, and spring stiffness
//! by the spring law of the sheet.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use crate::elements::Element;
use crate::elements::wall_spring::WallSprings;
use crate::error::InputError;
use crate::material::calibration::{CalibrationRequest, ClampedEdges, WallSpring, calibrate, default_gap};
use crate::mesh::outline::refine::Refinement;
use crate::mesh::outline::{self, Outline};
use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{Lattice, LatticeLayer, LatticeSpec, StructureKind, generate, nodes_of};
use crate::scene::{Material, PinSpec, Region, SheetSpec, SpringLaw};
use crate::sheet::assembly::SheetParts;
use crate::sheet::build::{extent, length_of, material_coordinates};

/// Minimum distance of the layers on a coarser grid, as a fraction of the distance that calibration
/// chooses there.
const MIN_GAP_RATIO: f64 = 0.4;

/// Clamp springs and delivered stiffness of a calibrated lattice.
#[derive(Clone, Debug, Default)]
pub(crate) struct CalibratedSprings {
    /// Nodes in the planes of clamped edges.
    pub held: Vec<u32>,
    /// Springs that end in these planes, in the axes of the sheet, with their rest lengths (m).
    pub walls: Vec<(WallSpring, f64)>,
    /// Delivered over requested bending stiffness, mean over directions.
    pub delivered: f64,
}

impl CalibratedSprings {
    /// Springs between lattice and clamp, placed in the world.
    pub fn wall_springs(
        &self,
        spec: &SheetSpec,
        material: &Material,
        creeps: Option<[f64; 2]>,
    ) -> Option<Box<dyn Element>> {
        let each = self.walls.iter().map(|(w, rest)| (w.mass, spec.placement.apply(w.point), *rest, w.stiffness));
        if self.walls.is_empty() {
            return None;
        }
        Some(Box::new(WallSprings::new(each, material.plate_stiffness()).with_creep(creeps)))
    }
}

/// Whether a pin is a fixed clamp along an edge, which cuts the springs of a calibrated lattice.
pub(crate) fn is_cutting_clamp(pin: &PinSpec) -> bool {
    let edge = matches!(pin.region, Region::Left | Region::Right | Region::Back | Region::Front);
    pin.clamp && pin.path.is_empty() && edge
}

/// Parts of a generated sheet; `described` is the grid in the scene, which differs from that of
/// `spec` after a change of grid; `levels` are those of a refined mesh.
pub(crate) fn generated(
    spec: &SheetSpec,
    material: &Material,
    base: &Path,
    described: (u32, u32, u32),
    levels: Option<&Arc<[u8]>>,
) -> Result<SheetParts, InputError> {
    if spec.outline.is_some() || !spec.holes.is_empty() || !spec.cuts.is_empty() {
        return outlined(spec, material, base, described, levels);
    }
    if spec.springs == SpringLaw::Calibrated && spec.structure != StructureKind::Shell {
        return calibrated(spec, material, described);
    }
    let layout = LatticeSpec {
        structure: spec.structure,
        grid: spec.grid,
        size: spec.size,
        gap: spec.gap,
        cross_over: spec.cross_over,
    };
    let lattice = generate(&layout)?;
    let n = lattice.positions.len();
    let sheet_mass = material.areal_mass() * spec.size.0 * spec.size.1;
    let mass = match spec.node_mass {
        Some(mass) => vec![mass; n],
        None if spec.structure == StructureKind::Shell => node_area_shares(spec.grid).map(|s| s * sheet_mass).collect(),
        None => vec![sheet_mass / n as f64; n],
    };
    let rest: Vec<f64> = lattice.links.iter().map(|l| length_of(l, &lattice.positions)).collect();
    let mut stiffness = stiffnesses(spec, material, &lattice, &rest);
    spec.inter_layer.apply(&layout, &lattice, &mut stiffness);
    Ok(parts_at_rest(spec, lattice, rest, stiffness, mass))
}

/// Parts of a shell with an outline: one layer with the nodes of a triangle mesh.
fn outlined(
    spec: &SheetSpec,
    material: &Material,
    base: &Path,
    described: (u32, u32, u32),
    levels: Option<&Arc<[u8]>>,
) -> Result<SheetParts, InputError> {
    let outline = Outline::new(spec.outline.as_ref(), &spec.holes, &spec.cuts, spec.size, base)?;
    let mut mesh = outline::mesh(&outline, (spec.grid.0, spec.grid.2))?;
    let mut refinement = None;
    if spec.refine.is_some() {
        let levels = levels.cloned().unwrap_or_else(|| vec![0; mesh.triangles.len()].into());
        let (finer, of_mesh) = Refinement::new(Arc::new(mesh), levels)?;
        (mesh, refinement) = (finer, Some(Box::new(of_mesh)));
    }
    let n = mesh.positions.len();
    let mut node_mass = spec.node_mass;
    if spec.grid == described {
        check_levels(spec, &outline)?;
    } else if let Some(mass) = &mut node_mass {
        // `node_mass` was scaled by the node counts of rectangular grids, which differ from those
        // of the outline.
        let first = outline::mesh(&outline, (described.0, described.2))?.positions.len();
        let rectangles = nodes_of(spec.grid) as f64 / nodes_of(described) as f64;
        *mass *= rectangles * first as f64 / n as f64;
    }
    let lattice = Lattice {
        positions: mesh.positions.iter().map(|[u, v]| DVec3::new(*u, 0.0, *v)).collect(),
        layer_of: vec![0; n],
        border: mesh.border.clone(),
        layers: vec![LatticeLayer { first: 0, nx: n as u32, nz: 1, triangular: false, tubular: false }],
        ..Lattice::default()
    };
    let each = |area: &f64| node_mass.unwrap_or(area * material.areal_mass());
    let mass = mesh.lumped.iter().map(each).collect();
    let mut parts = parts_at_rest(spec, lattice, Vec::new(), Vec::new(), mass);
    (parts.mesh, parts.refinement) = (Some(mesh), refinement);
    Ok(parts)
}

/// Refuse a level of detail that is too coarse for the outline.
fn check_levels(spec: &SheetSpec, outline: &Outline) -> Result<(), InputError> {
    for (i, level) in spec.detail.iter().flat_map(|d| &d.levels).enumerate() {
        let fault = |e: InputError| {
            let (columns, rows) = level.grid;
            let problem = format!("{columns}x{rows} is too coarse: {}: {}", e.field, e.problem);
            InputError::new(format!("detail.levels.{i}.grid"), problem)
        };
        outline::mesh(outline, level.grid).map_err(fault)?;
    }
    Ok(())
}

fn calibrated(spec: &SheetSpec, material: &Material, described: (u32, u32, u32)) -> Result<SheetParts, InputError> {
    let clamped = |region: Region| spec.pins.iter().any(|p| is_cutting_clamp(p) && p.region == region);
    // After a change of grid the layers keep the distance that they have on the described grid. The
    // minimum prevents a bend from snapping one layer through the other.
    let gap = |grid| default_gap(spec.structure, grid, spec.size);
    let gap = (described != spec.grid).then(|| gap(described).max(MIN_GAP_RATIO * gap(spec.grid)));
    let request = CalibrationRequest {
        gap,
        cross_over: spec.cross_over,
        second_neighbour: spec.flexion_stiffness,
        clamped: ClampedEdges {
            left: clamped(Region::Left),
            right: clamped(Region::Right),
            back: clamped(Region::Back),
            front: clamped(Region::Front),
        },
        ..CalibrationRequest::new(spec.structure, spec.grid, spec.size, material.target(), material.areal_mass())
    };
    let found = calibrate(&request)?;
    let mut lattice = found.lattice;
    let mut stiffness = found.stiffness;
    for (link, k) in found.braces {
        lattice.links.push(link);
        stiffness.push(k);
    }
    let rest = lattice.links.iter().map(|l| length_of(l, &lattice.positions)).collect();
    let mass = spec.node_mass.map_or(found.mass, |m| vec![m; lattice.positions.len()]);
    let rest_of = |w: &WallSpring| lattice.positions[w.mass as usize].distance(w.point);
    let delivered = found.delivered.bending.iter().sum::<f64>() / found.delivered.bending.len() as f64;
    let walls = found.walls.iter().map(|w| (*w, rest_of(w))).collect();
    let mut parts = parts_at_rest(spec, lattice, rest, stiffness, mass);
    parts.calibrated = Some(CalibratedSprings { held: found.held, walls, delivered });
    Ok(parts)
}

fn parts_at_rest(
    spec: &SheetSpec,
    lattice: Lattice,
    rest: Vec<f64>,
    stiffness: Vec<f64>,
    mass: Vec<f64>,
) -> SheetParts {
    let n = lattice.positions.len();
    SheetParts {
        rest,
        stiffness,
        mass,
        velocity: vec![DVec3::ZERO; n],
        force: vec![DVec3::ZERO; n],
        structure: spec.structure,
        grid: spec.grid,
        damping: spec.damping,
        uv: material_coordinates(&lattice),
        extent: extent(&lattice),
        lattice,
        calibrated: None,
        mesh: None,
        refinement: None,
    }
}

/// Fraction of a single layer's area per node, in order.
fn node_area_shares((nx, _, nz): (u32, u32, u32)) -> impl Iterator<Item = f64> {
    let along = |k: u32, n: u32| if k == 0 || k + 1 == n { 0.5 } else { 1.0 } / f64::from(n - 1);
    (0..nz).flat_map(move |j| (0..nx).map(move |i| along(i, nx) * along(j, nz)))
}

/// Stiffness of every spring (N/m) by the spring law of the sheet.
fn stiffnesses(spec: &SheetSpec, material: &Material, lattice: &Lattice, rest: &[f64]) -> Vec<f64> {
    let et = material.young * material.thickness;
    let area = spec.size.0 * spec.size.1;
    let mut family: BTreeMap<(SpringClass, u32), f64> = BTreeMap::new();
    for link in &lattice.links {
        *family.entry((link.class, link.layer)).or_default() += 1.0;
    }
    let layers = f64::from(spec.grid.1);
    let each = lattice.links.iter().zip(rest).map(|(link, length)| {
        let k = match spec.springs {
            SpringLaw::Uniform | SpringLaw::Calibrated => et,
            SpringLaw::Length => {
                let share = area / family.get(&(link.class, link.layer)).copied().unwrap_or(1.0);
                // Each layer has its share of the thickness, and a spring represents a strip of
                // width share/length. Springs between layers have the full stiffness E t per layer:
                // E A/h would be many times stiffer and shorten the stable step without a visible
                // effect.
                let strip = if link.class == SpringClass::Inter { 1.0 } else { (share / length) / length };
                (et / layers) * strip
            }
        };
        match link.class {
            SpringClass::Flexion | SpringClass::CrossOver => k * spec.flexion_stiffness,
            _ => k,
        }
    });
    each.collect()
}
