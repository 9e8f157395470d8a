//! Remapping of the pins of a lattice to another grid.
//!
//! Each pin prescribes the nodes of its region on the new grid. Their start positions are those of
//! the description, shifted like those of the old grid, which a moved sheet requires. Prescribed
//! nodes have the velocity of those of the old grid in their layer.

use glam::DVec3;

use crate::scene::SheetSpec;
use crate::sheet::Sheet;
use crate::sheet::remap::layer_offsets::LatticeLayout;
use crate::sheet::remap::motion::PIN_TOLERANCE;
use crate::sheet::remap::row_interpolation::RowInterpolation;

/// Shift the start positions of pins like those of `old`; this sheet must be as built.
pub(crate) fn remap_pins(
    sheet: &mut Sheet,
    old: &Sheet,
    spec: &SheetSpec,
    (before, now): (&LatticeLayout, &LatticeLayout),
) {
    if sheet.pins.is_empty() {
        return;
    }
    let up = spec.placement.quaternion() * DVec3::Y;
    // Initial position of a node of the old grid.
    let rest = |i: usize| {
        let (u, v) = before.uv[i];
        let along = DVec3::new((u - 0.5) * before.extent.0, 0.0, (v - 0.5) * before.extent.1);
        spec.placement.apply(along) + up * (f64::from(old.model.layer_of[i]) * before.gap)
    };
    let moved = |starts: Vec<(u32, DVec3)>| {
        let by = |(i, start): (u32, DVec3)| (before.uv[i as usize], (start - rest(i as usize)).to_array());
        RowInterpolation::new(starts.into_iter().map(by))
    };
    let moved: Vec<RowInterpolation<3>> = old.pins.starts().map(moved).collect();
    sheet.pins.shift_starts(PIN_TOLERANCE * sheet.model.length, |k, i| {
        let by = moved.get(k).and_then(|rows| rows.interpolate(now.uv[i as usize], before.step()));
        by.map_or(DVec3::ZERO, DVec3::from_array)
    });
}

/// Set the velocities of prescribed nodes to those of `old`, and fixed components to zero.
pub(crate) fn remap_pinned_velocities(sheet: &mut Sheet, old: &Sheet, (before, now): (&LatticeLayout, &LatticeLayout)) {
    for (layer, own) in before.layers.iter().zip(&now.layers) {
        let held = layer.range().filter(|i| old.inverse_mass[*i] == 0.0);
        let rows = RowInterpolation::new(held.map(|i| (before.uv[i], old.state.v.get(i).to_array())));
        for i in own.range().filter(|i| sheet.inverse_mass[*i] == 0.0) {
            let v = rows.interpolate(now.uv[i], before.step()).map_or(DVec3::ZERO, DVec3::from_array);
            sheet.state.v.set(i, v);
        }
    }
    sheet.pins.zero_fixed_axes(&mut sheet.state.v);
}
