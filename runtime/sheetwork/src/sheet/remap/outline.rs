//! Remapping of a sheet with an outline, holes or cuts: positions, velocities, forces and contact
//! flags.
//!
//! The new grid has another mesh. Its nodes are placed on the smooth surface through the old ones
//! ([`crate::sheet::remap::patch`]) and then get the least motion that gives the edges the stretch
//! of the old sheet, along their arcs; velocities likewise. Between two refinements of a mesh,
//! nodes and edges that both have keep position and stretch.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use crate::elements::remap::{MeshRemap, hat_weights};
use crate::elements::triangle_membrane::EdgeMembrane;
use crate::math::Vectors;
use crate::mesh::outline::TriangleMesh;
use crate::mesh::outline::locate::{PointLocator, inward};
use crate::mesh::outline::refine::Refinement;
use crate::scene::SheetSpec;
use crate::sheet::model::OutlineMeshes;
use crate::sheet::remap::motion::{self, PIN_TOLERANCE, vectors};
use crate::sheet::remap::patch::MovingLeastSquares;
use crate::sheet::remap::strain::{MAX_NEWTON_ITERATIONS, MOTION_WEIGHT, STRAIN_THRESHOLD, solve_conjugate_gradients};
use crate::sheet::{Sheet, remap};

impl Sheet {
    /// Mesh of a sheet with an outline, holes or cuts; positions (m) relative to the origin of its
    /// description.
    pub fn mesh(&self) -> Option<&TriangleMesh> {
        self.model.meshes.present.as_deref()
    }
}

fn edge_membrane(sheet: &Sheet) -> Option<&EdgeMembrane> {
    sheet.elements.iter().find_map(|e| (&**e as &dyn std::any::Any).downcast_ref())
}

/// Present mesh and that of the scene's `grid` where that is another grid; `None` where it is not.
pub(crate) fn meshes_to(sheet: &Sheet, grid: (u32, u32)) -> Option<(&TriangleMesh, &TriangleMesh)> {
    let (_, first) = sheet
        .model
        .meshes
        .described
        .as_ref()
        .filter(|(first, _)| *first == grid && *first != (sheet.model.grid.0, sheet.model.grid.2))?;
    Some((sheet.model.meshes.present.as_deref()?, first))
}

/// Number of nodes of the base mesh of a refined sheet on `grid`: they are its first nodes. `None`
/// for another grid or a sheet that is not refined.
pub(crate) fn base_nodes(sheet: &Sheet, grid: (u32, u32)) -> Option<usize> {
    let refinement = sheet.model.meshes.refinement.as_ref()?;
    ((sheet.model.grid.0, sheet.model.grid.2) == grid).then(|| refinement.base.positions.len())
}

/// Take over the mesh of the scene's grid from `old`, the same sheet on another grid.
pub(crate) fn copy_described_mesh(sheet: &mut Sheet, old: &Sheet) {
    let OutlineMeshes { present, described, refinement } = &old.model.meshes;
    let own = || Some(((old.model.grid.0, old.model.grid.2), present.clone()?));
    // Nodes of a base mesh are the first nodes of its refinements.
    let base = |r: &Refinement| ((old.model.grid.0, old.model.grid.2), r.base.clone());
    sheet.model.meshes.described = described.clone().or_else(|| refinement.as_ref().map(|r| base(r))).or_else(own);
}

/// Size of a cell of its grid, m.
pub(crate) fn cell(sheet: &Sheet) -> [f64; 2] {
    let [columns, rows] = remap::nodes_along(sheet);
    [sheet.model.extent.0 / (columns - 1) as f64, sheet.model.extent.1 / (rows - 1) as f64]
}

/// Remap positions and velocities of `old`, with its edge stretch and its rates.
pub(crate) fn remap_outline(sheet: &mut Sheet, old: &Sheet, spec: &SheetSpec, meshes: &MeshRemap, time: f64) {
    let surface = patches(old, meshes.from, true);
    let rotation = spec.placement.quaternion();
    let (was, were): (Vec<DVec3>, Vec<DVec3>) = (old.state.x.iter().collect(), old.state.v.iter().collect());
    remap_outline_pins(sheet, old, spec, meshes);
    let slope = [rotation * DVec3::X, rotation * DVec3::Z];
    sheet.state.x = vectors(&surface.interpolate_new(meshes.to, &meshes.shared, &was, slope));
    sheet.pins.prescribe_positions(time, &mut sheet.state.x);
    restore_stretch_of(sheet, old, meshes);
    sheet.pins.prescribe_positions(time, &mut sheet.state.x);
    if old.state.v.max_squared() == 0.0 {
        sheet.state.v = Vectors::zeros(sheet.node_count());
        return;
    }
    let mut v = vectors(&surface.interpolate_new(meshes.to, &meshes.shared, &were, [DVec3::ZERO; 2]));
    if let Some((before, now)) = edge_membrane(old).zip(edge_membrane(sheet)) {
        let wanted = read_stretch((before, now), meshes, &before.stretch_rates(&old.state.x, &old.state.v));
        let change: Vec<f64> =
            wanted.iter().zip(now.stretch_rates(&sheet.state.x, &v)).map(|(wanted, own)| wanted - own).collect();
        let d = least_motion_for_stretch(sheet, now, &change);
        v.add_scaled(1.0, &d);
    }
    sheet.state.v = v;
    sheet.pins.zero_fixed_axes(&mut sheet.state.v);
    motion::restore_momentum(sheet, old);
}

/// Smooth surface through its nodes; `slopes` uses the known slopes at clamps.
pub(crate) fn patches<'a>(sheet: &Sheet, mesh: &'a TriangleMesh, slopes: bool) -> MovingLeastSquares<'a> {
    let held = |i: usize| sheet.inverse_mass[i] == 0.0;
    let surface = MovingLeastSquares::new(mesh, cell(sheet), held, |i| slopes && sheet.model.clamped[i]);
    match &sheet.model.meshes.refinement {
        Some(refinement) => surface.with_scale(sizes_at_nodes(mesh, refinement)),
        None => surface,
    }
}

/// Size of the largest triangle around each node, in sizes of its base triangle.
fn sizes_at_nodes(mesh: &TriangleMesh, refinement: &Refinement) -> Vec<f64> {
    let mut sizes = vec![0.0_f64; mesh.positions.len()];
    for ((t, area), parent) in mesh.triangles.iter().zip(&mesh.areas).zip(&refinement.parents) {
        let size = (area / refinement.base.areas[*parent as usize]).sqrt();
        t.iter().for_each(|v| sizes[*v as usize] = sizes[*v as usize].max(size));
    }
    sizes
}

/// Shift the start positions of pins from those of the description like those of `old`, which a
/// moved sheet requires.
fn remap_outline_pins(sheet: &mut Sheet, old: &Sheet, spec: &SheetSpec, meshes: &MeshRemap) {
    let rest = |[u, v]: [f64; 2]| spec.placement.apply(DVec3::new(u, 0.0, v));
    let shifts = |starts: Vec<(u32, DVec3)>| {
        let place = |i: u32| meshes.from.positions[i as usize];
        PinShifts::new(starts.into_iter().map(|(i, start)| (place(i), start - rest(place(i)))).collect())
    };
    let shifts: Vec<PinShifts> = old.pins.starts().map(shifts).collect();
    let slack = PIN_TOLERANCE * sheet.model.length;
    sheet.pins.shift_starts(slack, |k, i| shifts[k].at(meshes.to.positions[i as usize]));
}

/// Move nodes towards the edge stretch of `old`.
fn restore_stretch_of(sheet: &mut Sheet, old: &Sheet, meshes: &MeshRemap) {
    let Some(both) = edge_membrane(old).zip(edge_membrane(sheet)) else { return };
    let wanted = read_stretch(both, meshes, &both.0.stretch(&old.state.x));
    for _ in 0..MAX_NEWTON_ITERATIONS {
        let Some(now) = edge_membrane(sheet) else { return };
        let change: Vec<f64> =
            wanted.iter().zip(now.stretch(&sheet.state.x)).map(|(wanted, own)| wanted - own).collect();
        if change.iter().all(|e| e.abs() < STRAIN_THRESHOLD) {
            return;
        }
        let d = least_motion_for_stretch(sheet, now, &change);
        sheet.state.x.add_scaled(1.0, &d);
    }
}

/// Least motion that changes the edge stretch by `change`; fixed nodes do not move.
fn least_motion_for_stretch(sheet: &Sheet, membrane: &EdgeMembrane, change: &[f64]) -> Vectors {
    let n = sheet.node_count();
    let [a, b] = cell(sheet);
    let scale = MOTION_WEIGHT / (a * b);
    let back = |stress: &[f64], to: &mut [DVec3]| {
        let mut sum = Vectors::zeros(n);
        membrane.add_edge_forces(&sheet.state.x, stress, &mut sum);
        to.iter_mut().zip(sum.iter()).for_each(|(to, p)| *to = p);
    };
    let mut first = vec![DVec3::ZERO; n];
    back(change, &mut first);
    let normal = |way: &[DVec3], image: &mut [DVec3]| {
        back(&membrane.stretch_rates(&sheet.state.x, &vectors(way)), image);
        image.iter_mut().zip(way).for_each(|(i, w)| *i += *w * scale);
    };
    let free = |d: &mut [DVec3]| {
        d.iter_mut().zip(&sheet.inverse_mass).filter(|(_, w)| **w == 0.0).for_each(|(d, _)| *d = DVec3::ZERO);
    };
    vectors(&solve_conjugate_gradients(first, normal, free))
}

/// Distribute each applied force of `old` to the corners of its triangle.
pub(crate) fn remap_outline_forces(sheet: &mut Sheet, old: &Sheet, meshes: &MeshRemap) {
    sheet.parameters.applied.clear();
    if old.parameters.applied.max_squared() == 0.0 {
        return;
    }
    let locator = PointLocator::new(meshes.to);
    let sides = inward(meshes.from);
    for (i, force) in old.parameters.applied.iter().enumerate().filter(|(_, f)| *f != DVec3::ZERO) {
        for (mass, part) in hat_weights(meshes.to, &locator, meshes.from.positions[i], sides[i]) {
            sheet.parameters.applied.add(mass as usize, force * part);
        }
    }
}

/// Interpolate the contact flags of `old` in its triangles; a node touches from a value of 0.5
/// on.
pub(crate) fn remap_outline_contact_flags(sheet: &mut Sheet, old: &Sheet, meshes: &MeshRemap) {
    let before: Vec<[f64; 1]> = old.state.touching.iter().map(|t| [f64::from(u8::from(*t))]).collect();
    for i in 0..sheet.node_count() {
        sheet.state.touching[i] = meshes.at_node(&before, i)[0] >= 0.5;
    }
}

/// Shift of the nodes of a pin from their described positions: a least-squares plane plus the
/// deviation of the nearest node.
struct PinShifts {
    each: Vec<([f64; 2], DVec3)>,
    plane: DMat3,
}

impl PinShifts {
    fn new(each: Vec<([f64; 2], DVec3)>) -> Self {
        let (mut moments, mut right) = (DMat3::ZERO, DMat3::ZERO);
        let mut size = 0.0;
        for ([u, v], by) in &each {
            let s = DVec3::new(1.0, *u, *v);
            moments += DMat3::from_cols(s * s.x, s * s.y, s * s.z);
            right += DMat3::from_cols(*by * s.x, *by * s.y, *by * s.z);
            size += u * u + v * v;
        }
        // For pins in a line the slope across the line is undetermined; the regularisation makes it
        // zero.
        moments += DMat3::from_diagonal(DVec3::new(0.0, 1.0, 1.0) * (1e-9 * size + f64::MIN_POSITIVE));
        let plane = if each.is_empty() { DMat3::ZERO } else { right * moments.inverse() };
        Self { each, plane: if plane.is_finite() { plane } else { DMat3::ZERO } }
    }

    fn at(&self, p: [f64; 2]) -> DVec3 {
        let on_plane = |p: [f64; 2]| self.plane * DVec3::new(1.0, p[0], p[1]);
        let far = |q: &[f64; 2]| (q[0] - p[0]).hypot(q[1] - p[1]);
        let nearest = self.each.iter().min_by(|a, b| far(&a.0).total_cmp(&far(&b.0)));
        nearest.map_or(DVec3::ZERO, |(q, by)| on_plane(p) + (*by - on_plane(*q)))
    }
}

/// Stretch of the new edges from the `stretch` of the old ones, by way of the strain tensors of
/// triangles averaged at nodes.
fn read_stretch((before, now): (&EdgeMembrane, &EdgeMembrane), meshes: &MeshRemap, stretch: &[f64]) -> Vec<f64> {
    let at_masses = mean_at_masses(meshes.from, &before.tensors(stretch));
    let read: Vec<[f64; 3]> = (0..meshes.to.positions.len()).map(|i| meshes.at_node(&at_masses, i)).collect();
    let mut edges = now.edge_strains(&read);
    if meshes.shared.is_empty() {
        return edges;
    }
    // Edges that both meshes have keep their stretch.
    let key = |[a, b]: [u32; 2]| (a.min(b), a.max(b));
    let there: BTreeMap<(u32, u32), f64> =
        meshes.from.edges.iter().map(|e| key(e.nodes)).zip(stretch.iter().copied()).collect();
    for (edge, strain) in meshes.to.edges.iter().zip(&mut edges) {
        if let [Some(a), Some(b)] = edge.nodes.map(|v| meshes.shared[v as usize]) {
            *strain = there.get(&key([a, b])).copied().unwrap_or(*strain);
        }
    }
    edges
}

/// Mean of triangle values at each node, weighted by area.
fn mean_at_masses(mesh: &TriangleMesh, values: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; mesh.positions.len()];
    for ((t, value), area) in mesh.triangles.iter().zip(values).zip(&mesh.areas) {
        for v in t {
            sums[*v as usize].iter_mut().zip(value).for_each(|(s, x)| *s += x * area / 3.0);
        }
    }
    sums.iter().zip(&mesh.lumped).map(|(sum, area)| sum.map(|s| s / area)).collect()
}
