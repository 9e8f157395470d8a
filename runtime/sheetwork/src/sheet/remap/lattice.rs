//! Remapping of positions and velocities of a lattice to another grid.
//!
//! Splines interpolate the bottom layer, which is also the drawn one, and the other layers keep
//! their offsets from it (`layer_offsets`). Then the bottom layer gets the least motion that
//! restores the mean membrane strain of all layers (`membrane`), and the other layers follow.
//! Differences of strain between layers are bending and follow from the surface. Prescribed nodes
//! of every layer have their prescribed positions.

use glam::DVec3;

use crate::math::Vectors;
use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{LatticeLayer, StructureKind};
use crate::scene::SheetSpec;
use crate::sheet::Sheet;
use crate::sheet::remap::attachments;
use crate::sheet::remap::layer_offsets::LatticeLayout;
use crate::sheet::remap::membrane::MembraneStrain;
use crate::sheet::remap::motion::{self, vectors};
use crate::sheet::remap::spline::SplineSurface;
use crate::sheet::remap::strain::{GridStrains, StrainGrid};

/// Maximum number of corrections of the membrane strain. The problem is nearly linear, and a
/// correction that does not reduce the residual is rejected.
const MAX_CORRECTIONS: usize = 3;

/// Bottom layer as a mesh of edges with strains.
fn mesh(layout: &LatticeLayout) -> StrainGrid {
    let (step, bottom) = (layout.step(), layout.layers[0]);
    let spacing = (step.0 * layout.extent.0, step.1 * layout.extent.1);
    StrainGrid { columns: bottom.nx as usize, rows: bottom.nz as usize, spacing, triangular: bottom.triangular }
}

/// Interpolate `values` of the bottom layer of `old` at the nodes of the bottom layer of `new`; the
/// result also has entries for the other layers, set to zero.
fn surface(old: &LatticeLayout, new: &LatticeLayout, values: &Vectors) -> Vec<DVec3> {
    let size = |l: &LatticeLayer| (l.nx as usize, l.nz as usize);
    let (from, to) = (size(&old.layers[0]), size(&new.layers[0]));
    let clamped = vec![false; from.0 * from.1];
    let staggered = old.is_triangular();
    let surface = SplineSurface { from, to, clamped: &clamped, staggered, folds: &Default::default() };
    let mut all = surface.interpolate(values, [DVec3::ZERO; 2]);
    all.resize(new.len(), DVec3::ZERO);
    all
}

/// Least tangential motion of the bottom layer that changes its strains by `change`. Normal motion
/// is excluded, because it would turn ripples into strain of the layers. `held` nodes do not move.
fn answer(mesh: &StrainGrid, layout: &LatticeLayout, x: &[DVec3], change: &GridStrains, held: &[bool]) -> Vec<DVec3> {
    let normals = layout.normals(x);
    let along = |i: usize, d: DVec3| if held[i] { DVec3::ZERO } else { d - normals[i] * normals[i].dot(d) };
    mesh.least_projected_motion(&x[..normals.len()], change, along)
}

/// Whether it is a lattice that can change its grid.
pub(crate) fn is_lattice(sheet: &Sheet) -> bool {
    sheet.model.structure != StructureKind::Shell && !sheet.springs.is_empty() && sheet.model.triangles.is_none()
}

/// Positions of the nodes of another grid, m; `None` for a grid that does not exist.
pub(crate) fn lattice_positions_at(sheet: &Sheet, grid: (u32, u32)) -> Option<Vectors> {
    let (old, new) = (LatticeLayout::from_sheet(sheet), LatticeLayout::on_grid(sheet, grid).ok()?);
    let places = with_loose_corners_extrapolated(sheet, &sheet.state.x);
    let x: Vec<DVec3> = places.iter().collect();
    let mut all = surface(&old, &new, &places);
    new.place_upper_layers(&new.interpolate(&old.offsets(&x, &vec![DVec3::ZERO; x.len()])), &mut all);
    Some(vectors(&all))
}

/// Nodal `values` interpolated at the nodes of another grid; `None` for a grid that does not
/// exist.
pub(crate) fn lattice_values_at(sheet: &Sheet, grid: (u32, u32), values: &[f64]) -> Option<Vec<f64>> {
    let (old, new) = (LatticeLayout::from_sheet(sheet), LatticeLayout::on_grid(sheet, grid).ok()?);
    Some(new.means(&old, values))
}

/// Copy nodal `values`, extrapolated linearly at nodes without a spring to another layer. Such
/// a node, as at the corner of a triangular lattice without braces, is loose and does not
/// represent the sheet.
fn with_loose_corners_extrapolated(sheet: &Sheet, values: &Vectors) -> Vectors {
    let mut all = values.clone();
    if sheet.model.layers.len() < 2 {
        return all;
    }
    let mut joined = vec![false; sheet.node_count()];
    for i in (0..sheet.springs.len()).filter(|i| sheet.springs.class[*i] == SpringClass::Inter) {
        [sheet.springs.a[i], sheet.springs.b[i]].into_iter().for_each(|m| joined[m as usize] = true);
    }
    let bottom = &sheet.model.layers[0];
    let columns = bottom.nx as usize;
    for loose in bottom.range().filter(|i| !joined[*i]) {
        let column = loose % columns;
        let (one, two) = if column >= 2 {
            (loose - 1, loose - 2)
        } else if column + 2 < columns {
            (loose + 1, loose + 2)
        } else {
            continue;
        };
        all.set(loose, values.get(one) * 2.0 - values.get(two));
    }
    all
}

/// Remap positions and velocities of `old`, with its layer offsets, strains and rates of
/// strain.
pub(crate) fn remap_layers(sheet: &mut Sheet, old: &Sheet, spec: &SheetSpec, time: f64) {
    let (before, now) = (LatticeLayout::from_sheet(old), LatticeLayout::from_sheet(sheet));
    attachments::remap_pins(sheet, old, spec, (&before, &now));
    let (places, motion) =
        (with_loose_corners_extrapolated(old, &old.state.x), with_loose_corners_extrapolated(old, &old.state.v));
    let (was, were): (Vec<DVec3>, Vec<DVec3>) = (places.iter().collect(), motion.iter().collect());
    let offsets = now.interpolate(&before.offsets(&was, &were));
    let mesh = mesh(&now);
    let held: Vec<bool> = sheet.inverse_mass[..mesh.columns * mesh.rows].iter().map(|w| *w == 0.0).collect();

    let mut x = surface(&before, &now, &places);
    let wanted = MembraneStrain::strains(&before, &was);
    let mut best: Option<(f64, Vec<DVec3>)> = None;
    for _ in 0..=MAX_CORRECTIONS {
        place_layers_with_pins(sheet, &now, &offsets, &mut x, time);
        let change = wanted.change(&mesh, &now, &MembraneStrain::strains(&now, &x));
        let left = change.square();
        if best.as_ref().is_some_and(|(least, _)| left >= *least) {
            break;
        }
        let d = answer(&mesh, &now, &x, &change, &held);
        best = Some((left, x.clone()));
        x.iter_mut().zip(&d).for_each(|(x, d)| *x += *d);
    }
    let x = best.map_or(x, |(_, x)| x);
    sheet.state.x = vectors(&x);
    if old.state.v.max_squared() == 0.0 {
        sheet.state.v = Vectors::zeros(sheet.node_count());
        return;
    }
    let mut v = surface(&before, &now, &motion);
    now.move_upper_layers(&offsets, &x, &mut v);
    let wanted = MembraneStrain::rates(&before, &was, &were);
    let d = answer(&mesh, &now, &x, &wanted.change(&mesh, &now, &MembraneStrain::rates(&now, &x, &v)), &held);
    v.iter_mut().zip(&d).for_each(|(v, d)| *v += *d);
    now.move_upper_layers(&offsets, &x, &mut v);
    sheet.state.v = vectors(&v);
    attachments::remap_pinned_velocities(sheet, old, (&before, &now));
    motion::restore_momentum(sheet, old);
}

/// Set the upper layers from the bottom one at `x` (m), and the positions of prescribed nodes
/// at `time` (s).
fn place_layers_with_pins(sheet: &mut Sheet, layout: &LatticeLayout, offsets: &[[f64; 6]], x: &mut [DVec3], time: f64) {
    let mut place = |x: &mut [DVec3]| {
        sheet.state.x = vectors(x);
        sheet.pins.prescribe_positions(time, &mut sheet.state.x);
        x.iter_mut().zip(sheet.state.x.iter()).for_each(|(to, from)| *to = from);
    };
    place(x);
    layout.place_upper_layers(offsets, x);
    place(x);
}
