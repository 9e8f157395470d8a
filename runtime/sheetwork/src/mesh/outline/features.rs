//! Detection of parts of a sheet that are narrower than a cell, for which the grid is too coarse.
//!
//! Such parts are two boundaries closer to each other than a cell, and places of one boundary where
//! the sheet between two side-by-side sides is narrower. A corner is accepted at any angle of at
//! least 15° between its sides.

use glam::DVec2;

use crate::error::InputError;
use crate::mesh::outline::line::{CellScale, OutlineLine};
use crate::mesh::outline::ring::{distance, meeting};

/// Minimum width, cells: one cell, with a margin for a grid that does not quite fit.
const MIN_WIDTH: f64 = 0.95;
/// Cosine threshold for side-by-side sides: directions within 15° of antiparallel.
const SIDE_BY_SIDE: f64 = -0.966;

/// Check the boundaries of a sheet, the outer one first, the sheet on the left of each.
///
/// # Errors
/// The first part that is smaller than a cell, with place and size.
pub fn check(rings: &[OutlineLine], cells: &CellScale) -> Result<(), InputError> {
    let boxes: Vec<_> = rings.iter().map(|r| crate::mesh::outline::bounds(&r.points)).collect();
    for (ring, (low, high)) in rings.iter().zip(&boxes) {
        let extent = *high - *low;
        if extent.min_element() < MIN_WIDTH {
            let size = (extent * cells.size).min_element();
            return Err(cells.too_small(&ring.field, "is only", size, low.midpoint(*high)));
        }
    }
    for (i, a) in rings.iter().enumerate() {
        for (b, far) in rings[..i].iter().zip(&boxes) {
            let gap = (boxes[i].0 - far.1).max(far.0 - boxes[i].1).max_element();
            if gap < MIN_WIDTH {
                apart(a, b, cells)?;
            }
        }
    }
    rings.iter().try_for_each(|r| narrow(r, cells))
}

fn apart(a: &OutlineLine, b: &OutlineLine, cells: &CellScale) -> Result<(), InputError> {
    for (a, b) in [(a, b), (b, a)] {
        let (low, high) = crate::mesh::outline::bounds(&b.points);
        let near = |p: &&DVec2| (low - **p).max(**p - high).max_element() < MIN_WIDTH;
        for p in a.points.iter().filter(near) {
            if let Some((u, v)) = b.sides().find(|s| distance(*p, s.0, s.1) < MIN_WIDTH) {
                let q = u + (v - u) * crate::mesh::outline::ring::foot(*p, u, v);
                let size = cells.distance(*p, q);
                return Err(cells.too_small(&a.field, &format!("leaves, to {},", b.field), size, *p));
            }
        }
    }
    Ok(())
}

fn narrow(ring: &OutlineLine, cells: &CellScale) -> Result<(), InputError> {
    let steps = (4.0 * ring.length()).ceil();
    for k in 0..steps as usize {
        let s = (k as f64 + 0.5) * ring.length() / steps;
        let side = ring.side_at(s);
        let along = (ring.points[side + 1] - ring.points[side]).normalize_or_zero();
        let p = ring.at(s);
        let inward = p + along.perp() * MIN_WIDTH;
        let (low, high) = (p.min(inward), p.max(inward));
        for (j, (a, b)) in ring.sides().enumerate() {
            if j == side || !(a.min(b).cmple(high).all() && a.max(b).cmpge(low).all()) {
                continue;
            }
            let facing = (b - a).normalize_or_zero().dot(along) < SIDE_BY_SIDE;
            if let Some((t, _)) = meeting((p, inward), (a, b)).filter(|_| facing) {
                let q = p.lerp(inward, t);
                let size = cells.distance(p, q);
                return Err(cells.too_small(&ring.field, "narrows to", size, p.midpoint(q)));
            }
        }
    }
    Ok(())
}
