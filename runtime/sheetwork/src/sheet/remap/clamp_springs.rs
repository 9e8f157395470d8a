//! Remapping of inelastic strain in the springs cut by clamps to another grid, as strain per length
//! without load.
//!
//! Clamp springs from nodes of one layer with equal direction and length, counted in spacings of
//! the grid and of the layers, are of one kind on every grid. The strain of a new spring is the
//! mean over the old springs of its kind, weighted by a hat function along the clamp that is as
//! wide as the coarser cell. A kind that the old grid lacks uses the nearest kind of its layer.
//! `springs` describes the correction for the strain of the new grid.

use std::any::Any;

use glam::DVec3;

use crate::elements::wall_spring::{WallSpringState, WallSprings};
use crate::scene::SheetSpec;
use crate::sheet::Sheet;
use crate::sheet::remap::layer_offsets::LatticeLayout;
use crate::sheet::remap::row_interpolation::KindInterpolation;
use crate::sheet::remap::springs::fit_inelastic_strain;

/// Layer, and distance from the node to the fixed end along u, through the thickness and along v,
/// in twelfths of a spacing.
type ClampSpringKind = (u32, [i32; 3]);

fn kind(sheet: &Sheet, layout: &LatticeLayout, spec: &SheetSpec, (mass, point): (usize, DVec3)) -> ClampSpringKind {
    let (layer, (u, v), step) = (sheet.model.layer_of[mass], layout.uv[mass], layout.step());
    let own = DVec3::new((u - 0.5) * layout.extent.0, f64::from(layer) * layout.gap, (v - 0.5) * layout.extent.1);
    let away = spec.placement.quaternion().inverse() * (point - spec.placement.apply(own));
    let spacings = away / DVec3::new(step.0 * layout.extent.0, layout.gap, step.1 * layout.extent.1);
    (layer, (spacings * 12.0).round().to_array().map(|d| d as i32))
}

/// Clamp springs of a sheet.
fn clamp_springs(sheet: &Sheet) -> Option<&WallSprings> {
    sheet.elements.iter().find_map(|e| (&**e as &dyn Any).downcast_ref())
}

/// Remap the inelastic strain of the clamp springs of `old`.
pub(crate) fn remap_clamp_springs(sheet: &mut Sheet, old: &Sheet, spec: &SheetSpec) {
    let (Some(before), Some(own)) = (clamp_springs(old), clamp_springs(sheet)) else { return };
    if old.state.heat.is_none() {
        return;
    }
    let (was, now) = (LatticeLayout::from_sheet(old), LatticeLayout::from_sheet(sheet));
    let of_spring = |(mass, point, strain, [set, first, second]): (usize, DVec3, f64, WallSpringState)| {
        (kind(old, &was, spec, (mass, point)), was.uv[mass], [set, first, second, strain - set])
    };
    let kinds = KindInterpolation::new(before.stored_state(&old.state.x).map(of_spring));
    let width = now.wider_step(&was);
    let read = |(mass, point, strain, _): (usize, DVec3, f64, WallSpringState)| {
        let held = kinds.interpolate(kind(sheet, &now, spec, (mass, point)), now.uv[mass], width);
        held.map(|held| fit_inelastic_strain(held, strain))
    };
    let held: Vec<Option<WallSpringState>> = own.stored_state(&sheet.state.x).map(read).collect();
    let own = sheet.elements.iter_mut().find_map(|e| (&mut **e as &mut dyn Any).downcast_mut::<WallSprings>());
    own.into_iter().for_each(|walls| walls.set_stored_state(&held));
}
