//! Overlap of two sheets: sum of their half thicknesses minus the distance of their surfaces, m.

use glam::DVec3;

use crate::collision::overlap::{corners, distance, faces, half_thickness};
use crate::sheet::Sheet;

/// A triangle with its bounding box.
struct BoundedTriangle {
    corners: [DVec3; 3],
    low: DVec3,
    high: DVec3,
}

fn boxed(sheet: &Sheet) -> Vec<BoundedTriangle> {
    let of = |t: &[u32; 3]| {
        let corners = corners(&sheet.state.x, t);
        let (low, high) = bounds(corners);
        BoundedTriangle { corners, low, high }
    };
    faces(sheet).iter().map(of).collect()
}

/// Largest overlap (m) of any two sheets; 0 if none touch. Surfaces that intersect overlap by the
/// sum of their half thicknesses.
pub fn between(sheets: &[Sheet]) -> f64 {
    pairs(sheets, 0.0).into_iter().map(|(_, _, overlap)| overlap).fold(0.0, f64::max)
}

/// Indices and overlap (m) of all pairs of sheets nearer than `slack` (m) to contact.
pub fn pairs(sheets: &[Sheet], slack: f64) -> Vec<(usize, usize, f64)> {
    let surfaces: Vec<Vec<BoundedTriangle>> = sheets.iter().map(boxed).collect();
    let mut found = Vec::new();
    for (i, a) in sheets.iter().enumerate() {
        for (j, b) in sheets.iter().enumerate().skip(i + 1) {
            let touching = half_thickness(a) + half_thickness(b);
            let reach = touching + slack;
            let (Some(around), Some(other)) = (a.state.x.bounds(), b.state.x.bounds()) else { continue };
            if apart(around, other, reach) {
                continue;
            }
            let distance = closest(&surfaces[i], &surfaces[j], reach);
            if distance < reach {
                found.push((i, j, touching - distance));
            }
        }
    }
    found
}

/// Corners of the box around a triangle, m.
pub(crate) fn bounds([a, b, c]: [DVec3; 3]) -> (DVec3, DVec3) {
    (a.min(b).min(c), a.max(b).max(c))
}

/// Whether two boxes are farther than `by` (m) from each other along an axis.
pub(crate) fn apart(a: (DVec3, DVec3), b: (DVec3, DVec3), by: f64) -> bool {
    (a.0 - b.1).max(b.0 - a.1).max_element() > by
}

/// Distance of two surfaces (m) if it is below `reach`, otherwise `reach`.
fn closest(a: &[BoundedTriangle], b: &[BoundedTriangle], reach: f64) -> f64 {
    let mut least = reach;
    for s in a {
        for t in b {
            if !apart((s.low, s.high), (t.low, t.high), least) {
                least = least.min(distance::triangles(&s.corners, &t.corners));
            }
        }
    }
    least
}
