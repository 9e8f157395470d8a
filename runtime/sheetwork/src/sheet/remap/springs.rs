//! Remapping of inelastic strain in the springs of a lattice to another grid, as strain per length
//! without load.
//!
//! Springs of one class between the same layers with the same direction, counted in spacings of the
//! grid, are of one kind. The strain of a new spring is the mean over the old springs of its kind,
//! weighted by a hat function about its middle that is as wide as the coarser cell. A kind that the
//! old grid lacks (a brace at another corner) uses the kind with the nearest direction. Thermal
//! expansion follows from the remapped temperatures.
//!
//! The strain is ε = h + e, with the inelastic strain h and the elastic strain e. Where h
//! dominates, as beside a clamp of a sagged sheet, the shape is the reliable information, and a
//! mean h that differs from the strain ε' of the new grid would cause stress. The new spring
//! therefore has the inelastic strain h + w (ε' - e - h), w = h²/(h² + e²), which preserves e where
//! e dominates.

use crate::elements::wall_spring::WallSpringState;
use crate::mesh::spring_class::SpringClass;
use crate::sheet::Sheet;
use crate::sheet::remap::lattice;
use crate::sheet::remap::layer_offsets::LatticeLayout;
use crate::sheet::remap::row_interpolation::KindInterpolation;

/// Class, layers of the two ends, and direction from the first to the second end along u and v, in
/// twelfths of a spacing.
type SpringKind = ((SpringClass, [u32; 2]), [i32; 2]);

/// Strains of a new spring at the total strain `strain`, from the inelastic strain, its two arms
/// and the elastic strain of the old grid.
pub(crate) fn fit_inelastic_strain([set, first, second, elastic]: [f64; 4], strain: f64) -> WallSpringState {
    let (h, e) = (set * set, elastic * elastic);
    let part = if h > 0.0 { h / (h + e) } else { 0.0 };
    [set + part * (strain - elastic - set), first, second]
}

fn kind(sheet: &Sheet, layout: &LatticeLayout, i: usize) -> SpringKind {
    let (a, b) = (sheet.springs.a[i] as usize, sheet.springs.b[i] as usize);
    let (step, p, q) = (layout.step(), layout.uv[a], layout.uv[b]);
    let along = [(q.0 - p.0) / step.0, (q.1 - p.1) / step.1].map(|d| (12.0 * d).round() as i32);
    ((sheet.springs.class[i], [sheet.model.layer_of[a], sheet.model.layer_of[b]]), along)
}

fn middle(sheet: &Sheet, layout: &LatticeLayout, i: usize) -> (f64, f64) {
    let (p, q) = (layout.uv[sheet.springs.a[i] as usize], layout.uv[sheet.springs.b[i] as usize]);
    (0.5 * (p.0 + q.0), 0.5 * (p.1 + q.1))
}

/// Remap the inelastic strain of the springs of `old`.
pub(crate) fn remap_springs(sheet: &mut Sheet, old: &Sheet) {
    if !lattice::is_lattice(sheet) || old.state.heat.is_none() {
        return;
    }
    let (before, now) = (LatticeLayout::from_sheet(old), LatticeLayout::from_sheet(sheet));
    let of_spring = |i: usize| {
        let [set, first, second] = spring_held(old, i);
        (kind(old, &before, i), middle(old, &before, i), [set, first, second, spring_strain(old, i) - set])
    };
    let kinds = KindInterpolation::new((0..old.springs.len()).map(of_spring));
    let width = now.wider_step(&before);
    for i in 0..sheet.springs.len() {
        if let Some(held) = kinds.interpolate(kind(sheet, &now, i), middle(sheet, &now, i), width) {
            put_spring(sheet, i, fit_inelastic_strain(held, spring_strain(sheet, i)));
        }
    }
}

/// Strain of spring `i` without thermal expansion.
fn spring_strain(sheet: &Sheet, i: usize) -> f64 {
    let [a, b] = [sheet.springs.a[i], sheet.springs.b[i]].map(|m| sheet.state.x.get(m as usize));
    sheet.state.heat.as_ref().map_or(0.0, |h| a.distance(b) / h.grown_length(i) - 1.0)
}

/// Inelastic strain of spring `i`, and that of its two arms.
fn spring_held(sheet: &Sheet, i: usize) -> WallSpringState {
    let creeping = sheet.state.inelastic.as_ref().and_then(|f| f.spring_held(i));
    let grown = sheet.state.heat.as_ref().map(|h| h.grown_length(i));
    creeping.or(grown.map(|length| [sheet.springs.rest[i] / length - 1.0, 0.0, 0.0])).unwrap_or_default()
}

fn put_spring(sheet: &mut Sheet, i: usize, held: WallSpringState) {
    if let Some(flow) = sheet.state.inelastic.as_mut().filter(|f| f.spring_held(i).is_some()) {
        flow.put_spring(i, held, &mut sheet.springs);
    } else if let Some(heat) = &sheet.state.heat {
        sheet.springs.set_rest(i, heat.grown_length(i) * (1.0 + held[0]));
    }
}
