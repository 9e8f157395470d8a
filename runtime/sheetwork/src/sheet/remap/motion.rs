//! Remapping of positions and velocities to another grid, for shells; `lattice` does so for
//! lattices.

use std::borrow::Cow;

use glam::{DMat3, DVec3};

use crate::elements::remap::{GridRemap, MeshRemap, Remap};
use crate::math::Vectors;
use crate::mesh::structure::StructureKind;
use crate::scene::SheetSpec;
use crate::sheet::remap::spline::SplineSurface;
use crate::sheet::remap::strain::StrainGrid;
use crate::sheet::remap::{self, lattice, outline};
use crate::sheet::{Sheet, instability};

/// Tolerance on the distance of a node from its pin, relative to the length of the sheet, for
/// rounding.
pub(crate) const PIN_TOLERANCE: f64 = 1e-9;

fn edges_of_grid(sheet: &Sheet) -> StrainGrid {
    let [columns, rows] = remap::nodes_along(sheet);
    StrainGrid { columns, rows, spacing: outline::cell(sheet).into(), triangular: false }
}

/// Whether it is a shell on a grid.
fn is_grid(sheet: &Sheet) -> bool {
    sheet.model.structure == StructureKind::Shell
        && sheet.model.triangles.is_none()
        && sheet.elements.len() > sheet.grabs.len()
}

/// Positions of the nodes of another grid, m; the present positions where the grid is the same
/// or cannot change.
pub fn positions_at(sheet: &Sheet, grid: (u32, u32)) -> Cow<'_, Vectors> {
    let [columns, rows] = remap::nodes_along(sheet);
    let to = (grid.0 as usize, grid.1 as usize);
    if let Some(count) = outline::base_nodes(sheet, grid) {
        let x: Vec<DVec3> = sheet.state.x.iter().take(count).collect();
        return Cow::Owned(vectors(&x));
    }
    if let Some((mesh, first)) = outline::meshes_to(sheet, grid) {
        let x: Vec<DVec3> = sheet.state.x.iter().collect();
        let patches = outline::patches(sheet, mesh, false);
        return Cow::Owned(vectors(&patches.interpolate(first, &x, [DVec3::ZERO; 2])));
    }
    if to == (columns, rows) || !(is_grid(sheet) || lattice::is_lattice(sheet)) {
        return Cow::Borrowed(&sheet.state.x);
    }
    if lattice::is_lattice(sheet) {
        return lattice::lattice_positions_at(sheet, grid).map_or(Cow::Borrowed(&sheet.state.x), Cow::Owned);
    }
    let surface = SplineSurface {
        from: (columns, rows),
        to,
        clamped: &vec![false; sheet.node_count()],
        staggered: false,
        folds: &sheet.model.folds,
    };
    Cow::Owned(vectors(&surface.interpolate(&sheet.state.x, [DVec3::ZERO; 2])))
}

/// Nodal `values` interpolated at the nodes of another grid.
pub fn values_at<'a>(sheet: &Sheet, grid: (u32, u32), values: &'a [f64]) -> Cow<'a, [f64]> {
    let (from, to) = (remap::nodes_along(sheet), [grid.0 as usize, grid.1 as usize]);
    if let Some(count) = outline::base_nodes(sheet, grid) {
        return Cow::Borrowed(&values[..count]);
    }
    if let Some((mesh, first)) = outline::meshes_to(sheet, grid) {
        return Cow::Owned(Remap::Mesh(MeshRemap::new(mesh, first)).at_nodes(values));
    }
    if from == to || !(is_grid(sheet) || lattice::is_lattice(sheet)) {
        return Cow::Borrowed(values);
    }
    if lattice::is_lattice(sheet) {
        return lattice::lattice_values_at(sheet, grid, values).map_or(Cow::Borrowed(values), Cow::Owned);
    }
    Cow::Owned(Remap::Grid(GridRemap { from, to }).at_nodes(values))
}

/// Remap positions and velocities of `old`, with its strains and rates of strain.
pub(crate) fn remap_motion(sheet: &mut Sheet, old: &Sheet, spec: &SheetSpec, time: f64) {
    if sheet.model.structure != StructureKind::Shell {
        return lattice::remap_layers(sheet, old, spec, time);
    }
    let (before, now) = (edges_of_grid(old), edges_of_grid(sheet));
    let surface = SplineSurface {
        from: (before.columns, before.rows),
        to: (now.columns, now.rows),
        clamped: &old.model.clamped,
        staggered: false,
        folds: &old.model.folds,
    };
    let rotation = spec.placement.quaternion();
    let clamp = [rotation * DVec3::X * before.spacing.0, rotation * DVec3::Z * before.spacing.1];
    sheet.state.x = vectors(&surface.interpolate(&old.state.x, clamp));
    sheet.pins.adopt_positions(time, &mut sheet.state.x, PIN_TOLERANCE * sheet.model.length);
    let held: Vec<bool> = sheet.inverse_mass.iter().map(|w| *w == 0.0).collect();
    let (was, were): (Vec<DVec3>, Vec<DVec3>) = (old.state.x.iter().collect(), old.state.v.iter().collect());
    let mut x: Vec<DVec3> = sheet.state.x.iter().collect();
    now.restore_strains(&mut x, &before.interpolate(&before.strains(&was), &now), &held);
    sheet.state.x = vectors(&x);
    sheet.pins.adopt_positions(time, &mut sheet.state.x, PIN_TOLERANCE * sheet.model.length);
    if old.state.v.max_squared() == 0.0 {
        sheet.state.v = Vectors::zeros(sheet.node_count());
        return;
    }
    let mut v = surface.interpolate(&old.state.v, [DVec3::ZERO; 2]);
    now.restore_strain_rates(&x, &mut v, &before.interpolate(&before.rates(&was, &were), &now), &held);
    sheet.state.v = vectors(&v);
    sheet.pins.zero_fixed_axes(&mut sheet.state.v);
    restore_momentum(sheet, old);
}

/// Set the momentum and angular momentum of `old`, for a sheet without pins.
pub(crate) fn restore_momentum(sheet: &mut Sheet, old: &Sheet) {
    if !sheet.pins.is_empty() {
        return;
    }
    let centre = sheet.centre_of_mass();
    let (mut inertia, mut size) = (DMat3::ZERO, 0.0);
    for (x, m) in sheet.state.x.iter().zip(&sheet.model.mass) {
        let r = x - centre;
        inertia +=
            (DMat3::from_diagonal(DVec3::splat(r.length_squared())) - DMat3::from_cols(r * r.x, r * r.y, r * r.z)) * *m;
        size += m * r.length_squared();
    }
    let lost = old.angular_momentum() - sheet.angular_momentum();
    let turns = inertia.determinant() > 1e-9 * size * size * size;
    let spin = if turns { inertia.inverse() * lost } else { DVec3::ZERO };
    for i in 0..sheet.node_count() {
        sheet.state.v.add(i, spin.cross(sheet.state.x.get(i) - centre));
    }
    let drift = (old.momentum() - sheet.momentum()) / sheet.total_mass();
    for i in 0..sheet.node_count() {
        sheet.state.v.add(i, drift);
    }
}

/// Limit the kinetic energy to that of `old` minus the gain of elastic energy.
pub(crate) fn limit_kinetic_energy_to(sheet: &mut Sheet, old: &Sheet) {
    let (before, now) = (instability::kinetic_elastic_energy(old), instability::kinetic_elastic_energy(sheet));
    let gained = (now.elastic - before.elastic).max(0.0);
    instability::limit_kinetic_energy(sheet, (before.kinetic - gained).max(0.0));
}

pub(crate) fn vectors(list: &[DVec3]) -> Vectors {
    let mut all = Vectors::default();
    list.iter().for_each(|v| all.push(*v));
    all
}
