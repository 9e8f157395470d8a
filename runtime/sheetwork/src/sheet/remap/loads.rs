//! Remapping of applied forces and of contact flags to another grid.
//!
//! A force is distributed to the nodes of its cell by the lever rule, which preserves the force and
//! moment of the flat sheet. In a layer of a lattice the cell is the pair of rows around the force,
//! with two nodes each; beyond the outermost node the lever rule extrapolates.

use glam::DVec3;

use crate::mesh::structure::LatticeLayer;
use crate::sheet::Sheet;
use crate::sheet::remap::layer_offsets::LatticeLayout;
use crate::sheet::remap::{self, lattice};

/// The two of `count` points, `step` apart from `first` on, around `at`, with their weights.
fn between(at: f64, (first, step, count): (f64, f64, usize)) -> [(usize, f64); 2] {
    if count < 2 {
        return [(0, 1.0), (0, 0.0)];
    }
    let place = (at - first) / step;
    let low = (place.floor().max(0.0) as usize).min(count - 2);
    let part = place - low as f64;
    [(low, 1.0 - part), (low + 1, part)]
}

/// Distribute each applied force of `old` to the nodes of its cell by the lever rule.
pub(crate) fn remap_forces(sheet: &mut Sheet, old: &Sheet) {
    if lattice::is_lattice(sheet) {
        return remap_layer_forces(sheet, old);
    }
    sheet.parameters.applied.clear();
    let [columns, rows] = remap::nodes_along(sheet);
    let cell = |at: f64, count: usize| {
        let place = at.clamp(0.0, 1.0) * (count - 1) as f64;
        let low = (place.floor() as usize).min(count - 2);
        (low, place - low as f64)
    };
    for (i, force) in old.parameters.applied.iter().enumerate().filter(|(_, f)| *f != DVec3::ZERO) {
        let ((a, s), (b, t)) = (cell(old.model.uv[i].0, columns), cell(old.model.uv[i].1, rows));
        for (column, row, weight) in
            [(a, b, (1.0 - s) * (1.0 - t)), (a + 1, b, s * (1.0 - t)), (a, b + 1, (1.0 - s) * t), (a + 1, b + 1, s * t)]
        {
            let mass = row * columns + column;
            sheet.parameters.applied.add(mass, force * weight);
        }
    }
}

fn remap_layer_forces(sheet: &mut Sheet, old: &Sheet) {
    sheet.parameters.applied.clear();
    let layout = LatticeLayout::from_sheet(sheet);
    let step = layout.step();
    for (i, force) in old.parameters.applied.iter().enumerate().filter(|(_, f)| *f != DVec3::ZERO) {
        let layer = &layout.layers[old.model.layer_of[i] as usize];
        let (u, v) = old.model.uv[i];
        let place = |j: usize| layout.uv[layer.at(0, j as u32) as usize];
        for (j, b) in between(v, (place(0).1, step.1, layer.nz as usize)) {
            for (k, a) in between(u, (place(j).0, step.0, layer.nx as usize)) {
                let mass = layer.at(k as u32, j as u32) as usize;
                sheet.parameters.applied.add(mass, force * (a * b));
            }
        }
    }
}

/// Copy the contact flag of the nearest node of `old` to each node.
pub(crate) fn remap_contact_flags(sheet: &mut Sheet, old: &Sheet) {
    if !old.state.touching.contains(&true) {
        return;
    }
    if lattice::is_lattice(sheet) {
        return remap_layer_contact_flags(sheet, old);
    }
    let [columns, rows] = remap::nodes_along(old);
    let near = |at: f64, count: usize| (at * (count - 1) as f64).round() as usize;
    for (i, (u, v)) in sheet.model.uv.iter().enumerate() {
        sheet.state.touching[i] = old.state.touching[near(*v, rows) * columns + near(*u, columns)];
    }
}

fn remap_layer_contact_flags(sheet: &mut Sheet, old: &Sheet) {
    let layout = LatticeLayout::from_sheet(old);
    let step = layout.step();
    let near =
        |at: f64, (first, step, count): (f64, f64, u32)| (((at - first) / step).round().max(0.0) as u32).min(count - 1);
    for (layer, own) in layout.layers.iter().zip(&sheet.model.layers) {
        let place = |layer: &LatticeLayer, j: u32| layout.uv[layer.at(0, j) as usize];
        for i in own.range() {
            let (u, v) = sheet.model.uv[i];
            let j = near(v, (place(layer, 0).1, step.1, layer.nz));
            let k = near(u, (place(layer, j).0, step.0, layer.nx));
            sheet.state.touching[i] = old.state.touching[layer.at(k, j) as usize];
        }
    }
}
