//! Construction of a sheet from its description: lattice from a generator or a file, elements,
//! prescribed degrees of freedom. `assembly` joins the parts.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use crate::elements::Element;
use crate::elements::bending::Bending;
use crate::elements::creep::InelasticLaw;
use crate::elements::curvature::CurvatureGroup;
use crate::elements::grid_membrane::CellMembrane;
use crate::elements::staggered::{StaggeredGrid, curvatures};
use crate::elements::triangle_bending::triangle_curvatures;
use crate::elements::triangle_membrane::EdgeMembrane;
use crate::error::InputError;
use crate::mesh::outline::{DrawnLines, MeshEdge, TriangleMesh};
use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{Lattice, LatticeLayer, LatticeSpec, LatticeSpring, StructureKind, generate, nodes_of};
use crate::scene::sht::{self, SheetFile, SheetFileNode, SheetFileSpring};
use crate::scene::validate::warp_direction;
use crate::scene::{
    CreaseSpec, Region, RegionVector, Scene, SheetSpec, adhesion, contact_surface, fracture, rest_shape, sheet_name,
};
use crate::sheet::assembly::{SheetParts, assemble};
use crate::sheet::creep::InelasticState;
use crate::sheet::fracture::{FractureState, open_slits};
use crate::sheet::generation::{CalibratedSprings, generated, is_cutting_clamp};
use crate::sheet::refine::Resolution;
use crate::sheet::{Sheet, creases, inter_layer, region, temperature};

impl Sheet {
    /// Build sheet number `index` of `scene`.
    ///
    /// # Errors
    /// When the description, or the file it names, is not valid; field names are relative to the
    /// sheet.
    pub fn build(scene: &Scene, index: usize) -> Result<Self, InputError> {
        let spec = &scene.sheets[index];
        Self::build_as(scene, index, spec, spec.grid, None)
    }

    /// Build sheet number `index` on another grid or with a refined mesh, with the thickness and
    /// the mass that it has on the grid of its description.
    ///
    /// # Errors
    /// As [`Sheet::build`], and when the sheet cannot have that grid or those levels.
    pub(crate) fn build_at(scene: &Scene, index: usize, at: &Resolution) -> Result<Self, InputError> {
        let mut spec = scene.sheets[index].clone();
        let (described, grid) = (spec.grid, at.grid);
        spec.grid = (grid.0, described.1, grid.1);
        if let Some(mass) = &mut spec.node_mass {
            *mass *= nodes_of(described) as f64 / nodes_of(spec.grid) as f64;
        }
        Self::build_as(scene, index, &spec, described, at.levels.as_ref())
    }

    /// Build sheet number `index` of `scene` from `spec`; `described` is the grid in the scene, and
    /// `levels` are those of a refined mesh.
    fn build_as(
        scene: &Scene,
        index: usize,
        spec: &SheetSpec,
        described: (u32, u32, u32),
        levels: Option<&Arc<[u8]>>,
    ) -> Result<Self, InputError> {
        let drawn = with_drawn_lines(spec, &scene.base)?;
        let spec = drawn.as_ref().unwrap_or(spec);
        let material = spec.material.resolve(&scene.base)?;
        warp_direction(spec, &material)?;
        let mut parts = match &spec.file {
            Some(file) => read_parts(&sht::read_sht_file(&scene.base.join(file))?)?,
            None => generated(spec, &material, &scene.base, described, levels)?,
        };
        let (calibrated, mesh, refinement) = (parts.calibrated.take(), parts.mesh.take(), parts.refinement.take());
        let triangles = mesh.as_ref().map(upper_side);
        let mut sheet = assemble(scene, spec, material, parts, calibrated.is_some(), triangles);
        sheet.model.refinement = refinement.as_ref().map(|r| r.levels.clone());
        sheet.model.meshes.refinement = refinement;
        sheet.name = sheet_name(&sheet.name, index);
        apply_regions(spec, &mut sheet, calibrated.as_ref())?;
        sheet.set_flexion_limit(spec.flexion_limit)?;
        inter_layer::initialise(&mut sheet, spec)?;
        rest_shape::check_material(spec, &sheet.parameters.material)?;
        let law = InelasticLaw::new(&sheet.parameters.material, spec.creep, spec.plastic);
        sheet.elements = shell_elements(spec, &sheet, mesh.as_ref(), &law);
        sheet.model.meshes.present = mesh.map(Arc::new);
        sheet.parameters.springs.delivered_fraction = calibrated.as_ref().map(|c| c.delivered);
        if !sheet.elements.is_empty() {
            sheet.parameters.springs.delivered_fraction = Some(1.0);
        }
        let walls = calibrated.and_then(|c| c.wall_springs(spec, &sheet.parameters.material, creep_shares(&law)));
        sheet.elements.extend(walls);
        if spec.creep || spec.plastic {
            let celsius = spec.temperature.unwrap_or(scene.ambient_temperature);
            sheet.state.inelastic = Some(Box::new(InelasticState::new(law, celsius, scene.time_lapse, &sheet.springs)));
        }
        sheet.refresh();
        if spec.creep {
            // The stiffness of a creeping sheet depends on temperature with and without a heat
            // source.
            temperature::start_temperatures(&mut sheet, scene.ambient_temperature);
        }
        sheet.state.touching = vec![false; sheet.node_count()];
        let is_tube = sheet.model.layers.iter().any(|layer| layer.tubular);
        contact_surface::check_built(spec.contact_surface, scene.engine, is_tube)?;
        if spec.sticky {
            adhesion::check_material(&sheet.parameters.material)?;
            sheet.model.adhesion_areas = node_areas(&sheet);
        }
        if spec.tearing {
            fracture::check_material(&sheet.parameters.material)?;
        }
        if spec.tearing || !spec.slits.is_empty() {
            sheet.state.fracture = Some(Box::new(FractureState::new(&sheet, spec.tearing)));
            open_slits(&mut sheet, &spec.slits)?;
        }
        Ok(sheet)
    }
}

/// `spec` with the cuts and creases of its SVG file, if it has some.
fn with_drawn_lines(spec: &SheetSpec, base: &Path) -> Result<Option<SheetSpec>, InputError> {
    let lines = DrawnLines::read(spec.outline.as_ref(), base)?;
    if lines.cuts.is_empty() && lines.creases.is_empty() {
        return Ok(None);
    }
    let mut spec = spec.clone();
    spec.cuts.extend(lines.cuts);
    let each =
        lines.creases.into_iter().map(|([from, to], angle)| CreaseSpec { from: from.into(), to: to.into(), angle });
    spec.creases.extend(each);
    rest_shape::check(&spec)?;
    Ok(Some(spec))
}

/// Area per node, m²: the area of the layer in proportion to the node masses.
fn node_areas(sheet: &Sheet) -> Vec<f64> {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|m| sheet.model.place(m));
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
    };
    let covered: f64 = match &sheet.model.triangles {
        Some(triangles) => triangles.iter().map(area).sum(),
        None => sheet.model.extent.0 * sheet.model.extent.1,
    };
    let mut all = vec![0.0; sheet.node_count()];
    for layer in &sheet.model.layers {
        let whole: f64 = layer.range().map(|i| sheet.model.mass[i]).sum();
        layer.range().for_each(|i| all[i] = covered * sheet.model.mass[i] / whole);
    }
    all
}

/// Triangles of a mesh for drawing, counter-clockwise seen from the upper side.
fn upper_side(mesh: &TriangleMesh) -> Vec<[u32; 3]> {
    mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect()
}

/// Membrane and bending of a shell on a triangle mesh. A boundary edge is clamped when both its
/// nodes are.
fn mesh_elements(spec: &SheetSpec, sheet: &Sheet, mesh: &TriangleMesh, law: &InelasticLaw) -> Vec<Box<dyn Element>> {
    let clamped = |e: &MeshEdge| e.nodes.iter().all(|n| sheet.model.clamped[*n as usize]);
    let (groups, normals) = triangle_curvatures(mesh, &clamped);
    let rotation = spec.placement.quaternion();
    let directions: Vec<DVec3> = normals.iter().map(|[u, v]| rotation * DVec3::new(*u, 0.0, *v)).collect();
    let mut membrane = EdgeMembrane::new(mesh, &groups).with_creep(creep_shares(law));
    membrane.set_clamps(&directions);
    let base = sheet.model.meshes.refinement.as_ref().map_or(mesh, |r| &r.base);
    let bending = bending(spec, law, groups, &directions, |groups| creases::on_mesh(spec, groups, mesh, base));
    vec![Box::new(membrane), Box::new(bending)]
}

/// Shares of the Maxwell arms of a law with creep.
fn creep_shares(law: &InelasticLaw) -> Option<[f64; 2]> {
    law.creep.map(|c| c.arms.share)
}

/// Bending of a shell; `angles` are its initial rest curvatures.
fn bending(
    spec: &SheetSpec,
    law: &InelasticLaw,
    groups: Vec<CurvatureGroup>,
    directions: &[DVec3],
    angles: impl Fn(&[CurvatureGroup]) -> Vec<[f64; 3]>,
) -> Bending {
    if !creases::has_initial_curvature(spec) && law.creep.is_none() && law.plastic.is_none() {
        return Bending::new(groups, directions);
    }
    let angles = angles(&groups);
    Bending::with_rest(groups, directions, &angles, creep_shares(law), law.plastic.is_some())
}

/// Membrane and bending of a shell; empty for a lattice.
fn shell_elements(
    spec: &SheetSpec,
    sheet: &Sheet,
    mesh: Option<&TriangleMesh>,
    law: &InelasticLaw,
) -> Vec<Box<dyn Element>> {
    if spec.file.is_some() || sheet.model.structure != StructureKind::Shell {
        return Vec::new();
    }
    if let Some(mesh) = mesh {
        return mesh_elements(spec, sheet, mesh, law);
    }
    let (columns, rows) = (sheet.model.grid.0 as usize, sheet.model.grid.2 as usize);
    let spacing = (spec.size.0 / (columns - 1) as f64, spec.size.1 / (rows - 1) as f64);
    let grid = StaggeredGrid { columns, rows, spacing, clamped: &sheet.model.clamped };
    let rotation = spec.placement.quaternion();
    let (groups, directions) = (curvatures(&grid), [rotation * DVec3::X, rotation * DVec3::Z]);
    let membrane = CellMembrane::new(columns, rows, spacing).with_creep(creep_shares(law));
    let angles = |groups: &[CurvatureGroup]| creases::on_grid(spec, groups, (columns, rows), spacing);
    vec![Box::new(membrane), Box::new(bending(spec, law, groups, &directions, angles))]
}

pub(crate) fn length_of(link: &LatticeSpring, positions: &[DVec3]) -> f64 {
    positions[link.a as usize].distance(positions[link.b as usize])
}

/// Parts of a sheet file. Its positions are in world coordinates, and its springs have their own
/// rest lengths.
fn read_parts(file: &SheetFile) -> Result<SheetParts, InputError> {
    let structure: StructureKind = file.structure.parse()?;
    let [nx, layers, nz] = file.dimensions;
    let mut lattice = Lattice {
        positions: file.masses.iter().map(|m| m.position).collect(),
        layer_of: file.masses.iter().map(|m| m.layer).collect(),
        border: file.masses.iter().map(|m| m.border).collect(),
        ..Lattice::default()
    };
    let mut first = 0;
    for index in 0..layers {
        let (lx, lz) = if index % 2 == 1 { (nx - 1, nz - 1) } else { (nx, nz) };
        let triangular = structure.info().triangular;
        let mut layer = LatticeLayer { first, nx: lx, nz: lz, triangular, tubular: false };
        layer.tubular = is_tube(&layer, &file.springs);
        lattice.layers.push(layer);
        first += lx * lz;
    }
    for spring in &file.springs {
        let layer = lattice.layer_of[spring.a as usize].min(lattice.layer_of[spring.b as usize]);
        lattice.links.push(LatticeSpring { a: spring.a, b: spring.b, class: spring.kind, layer });
    }
    // The file may hold a bent sheet, so the material coordinates come from the lattice at rest.
    let grid = (nx, layers, nz);
    let plain = generate(&LatticeSpec { structure, grid, size: (1.0, 1.0), gap: 1.0, cross_over: false })?;
    lattice.flexion.clone_from(&plain.flexion);
    Ok(SheetParts {
        rest: file.springs.iter().map(|s| s.rest).collect(),
        stiffness: file.springs.iter().map(|s| s.stiffness).collect(),
        mass: file.masses.iter().map(|m| m.mass).collect(),
        velocity: file.masses.iter().map(|m| m.velocity).collect(),
        force: file.masses.iter().map(|m| m.force).collect(),
        structure,
        grid: (nx, layers, nz),
        damping: file.damping,
        uv: material_coordinates(&plain),
        extent: extent_of_springs(file, structure.info().triangular),
        lattice,
        calibrated: None,
        mesh: None,
        refinement: None,
    })
}

/// Whether springs of class z join the first and the last row of a square layer in every column.
fn is_tube(layer: &LatticeLayer, springs: &[SheetFileSpring]) -> bool {
    // Two rows are neighbours, and the seam of a triangular layer has no rule for its shift.
    if layer.triangular || layer.nz < 3 {
        return false;
    }
    let (first, last) = (layer.at(0, 0), layer.at(0, layer.nz - 1));
    let column = |s: &SheetFileSpring| {
        let (low, high) = (s.a.min(s.b), s.a.max(s.b));
        let column = low.checked_sub(first).filter(|i| *i < layer.nx)?;
        (s.kind == SpringClass::Z && high == last + column).then_some(column as usize)
    };
    let mut joined = vec![false; layer.nx as usize];
    springs.iter().filter_map(column).for_each(|i| joined[i] = true);
    joined.iter().all(|j| *j)
}

/// Length and width (m) of the sheet of a file, from the rest lengths of its springs.
fn extent_of_springs(file: &SheetFile, triangular: bool) -> (f64, f64) {
    let mean = |kind: SpringClass| {
        let each = file.springs.iter().filter(|s| s.kind == kind);
        let (count, sum) = each.fold((0.0, 0.0), |(n, sum), s| (n + 1.0, sum + s.rest));
        (count > 0.0).then(|| sum / count)
    };
    let [nx, _, nz] = file.dimensions.map(f64::from);
    let along = mean(SpringClass::X).unwrap_or(1.0);
    // The slanting springs of a triangular layer give the distance of its rows.
    let slant =
        || Some((mean(SpringClass::Diagonal)?.powi(2) - 0.25 * along * along).max(1e-12 * along * along).sqrt());
    let across = mean(SpringClass::Z).or_else(slant).unwrap_or(along);
    let columns = if triangular { nx - 0.5 } else { nx - 1.0 };
    (along * columns, across * (nz - 1.0))
}

/// Corners of the bounding box of the bottom layer of a lattice at rest, m.
fn bottom_bounds(lattice: &Lattice) -> (DVec3, DVec3) {
    let bottom = &lattice.positions[lattice.layers.first().map_or(0..0, LatticeLayer::range)];
    bottom.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)))
}

/// Length and width (m) of the bottom layer of a lattice at rest.
pub(crate) fn extent(lattice: &Lattice) -> (f64, f64) {
    let (low, high) = bottom_bounds(lattice);
    (high.x - low.x, high.z - low.z)
}

/// Material coordinates (u, v) of every node: x and z as fractions of the bounding rectangle of the
/// bottom layer at rest.
pub(crate) fn material_coordinates(lattice: &Lattice) -> Vec<(f64, f64)> {
    let (low, high) = bottom_bounds(lattice);
    let fraction = |p: f64, low: f64, high: f64| if high > low { (p - low) / (high - low) } else { 0.0 };
    lattice.positions.iter().map(|p| (fraction(p.x, low.x, high.x), fraction(p.z, low.z, high.z))).collect()
}

fn apply_regions(
    spec: &SheetSpec,
    sheet: &mut Sheet,
    calibrated: Option<&CalibratedSprings>,
) -> Result<(), InputError> {
    let find =
        |region: &Region, field: String| region::select(region, sheet).map_err(|e| InputError::new(field, e.problem));
    let each = |list: &[RegionVector], what: &str| -> Result<Vec<(Vec<u32>, DVec3)>, InputError> {
        let masses =
            list.iter().enumerate().map(|(i, r)| Ok((find(&r.region, format!("{what}.{i}.region"))?, r.value)));
        masses.collect()
    };
    let velocities = each(&spec.velocities, "velocities")?;
    let forces = each(&spec.forces, "forces")?;
    let pinned: Result<Vec<_>, _> =
        spec.pins.iter().enumerate().map(|(i, p)| find(&p.region, format!("pins.{i}.region"))).collect();
    for (masses, value) in velocities {
        masses.iter().for_each(|i| sheet.state.v.add(*i as usize, value));
    }
    for (masses, value) in forces {
        masses.iter().for_each(|i| sheet.parameters.applied.add(*i as usize, value));
    }
    for (pin, mut masses) in spec.pins.iter().zip(pinned?) {
        if let Some(c) = calibrated.filter(|_| is_cutting_clamp(pin)) {
            masses.retain(|m| c.held.contains(m));
        }
        let (x, y, z) = pin.axes;
        if !(x && y && z) {
            for i in masses {
                sheet.pins.add_fixed_axes(i, sheet.state.x.get(i as usize), [x, y, z]);
            }
            sheet.pins.zero_fixed_axes(&mut sheet.state.v);
            continue;
        }
        if let Some(body) = &pin.body {
            let places: Vec<(u32, DVec3)> = masses.iter().map(|i| (*i, sheet.state.x.get(*i as usize))).collect();
            sheet.pins.add_attachment(places.into_iter(), body);
            continue;
        }
        let start = masses.iter().map(|i| sheet.state.x.get(*i as usize)).collect();
        for i in &masses {
            sheet.inverse_mass[*i as usize] = 0.0;
            sheet.model.clamped[*i as usize] |= pin.clamp;
            sheet.state.v.set(*i as usize, DVec3::ZERO);
        }
        sheet.pins.add(masses, start, pin.path.clone(), pin.until);
    }
    Ok(())
}

/// Convert a sheet to a .SHT file with its present positions and velocities.
pub fn to_file(sheet: &Sheet) -> SheetFile {
    let (nx, layers, nz) = sheet.model.grid;
    let masses = (0..sheet.node_count()).map(|i| SheetFileNode {
        acceleration: DVec3::ZERO,
        position: sheet.state.x.get(i),
        force: sheet.parameters.applied.get(i),
        velocity: sheet.state.v.get(i),
        mass: sheet.model.mass[i],
        layer: sheet.model.layer_of[i],
        border: sheet.model.border[i],
    });
    let springs = (0..sheet.springs.len()).map(|i| SheetFileSpring {
        kind: sheet.springs.class[i],
        a: sheet.springs.a[i],
        b: sheet.springs.b[i],
        stiffness: sheet.springs.stiffness[i],
        rest: sheet.springs.rest[i],
    });
    let bottom = sheet.model.layers.first().copied().unwrap_or_default();
    let last = |n: u32| n.saturating_sub(1);
    SheetFile {
        masses: masses.collect(),
        springs: springs.collect(),
        corners: [
            bottom.at(0, 0),
            bottom.at(last(bottom.nx), 0),
            bottom.at(0, last(bottom.nz)),
            bottom.at(last(bottom.nx), last(bottom.nz)),
        ],
        centre: bottom.at(bottom.nx / 2, bottom.nz / 2),
        dimensions: [nx, layers, nz],
        damping: sheet.damping(),
        structure: sheet.model.structure.name().to_owned(),
    }
}

/// Build a single sheet from a file, in an empty scene, for conversions and tests.
///
/// # Errors
/// When the file's contents do not make a sheet.
pub fn from_file(file: &SheetFile) -> Result<Sheet, InputError> {
    let scene = Scene::thesis();
    let spec = SheetSpec::thesis();
    let mut sheet = assemble(&scene, &spec, spec.material.resolve(&scene.base)?, read_parts(file)?, false, None);
    sheet.state.touching = vec![false; sheet.node_count()];
    Ok(sheet)
}
