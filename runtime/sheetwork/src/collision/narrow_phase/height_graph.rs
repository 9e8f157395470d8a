//! Test whether a sheet is a height graph over a plane throughout a stage, which excludes
//! self-contact.
//!
//! Project a disc-shaped surface along a direction m. If every triangle faces up (n·m > 0), and the
//! border, seen along m, turns once around a point that stays on its left, the projection is one to
//! one: no two points of the surface are above each other (argument of degree; P. Volino, N.
//! Magnenat-Thalmann, "Efficient self-collision detection on smoothly discretized surface
//! animations using geometrical shape regularity", Computer Graphics Forum 13, 1994). Nodes move
//! along straight lines, so that the area vector of a triangle is A₀ (1-t)² + 2 A₁ t (1-t) + A₂ t²,
//! and the triangle faces up throughout if these three vectors do.
//!
//! The angle between each triangle and m is bounded by a cosine that leaves space for the thickness
//! of the sheet: two walls of that slope are farther apart than the thickness at a distance of one
//! triangle from their common line.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::collision::collision_surface::CollisionSurface;
use crate::collision::narrow_phase::SheetStageMotion;
use crate::collision::settings::{DetectionSettings, SheetPairSettings};
use crate::math::Vectors;

const SETTINGS: SheetPairSettings = DetectionSettings::DEFAULT.sheet_pairs;

/// Whether the sheet is a single rectangle and such a graph. `height` is the least height of its
/// triangles, m.
pub(crate) fn remains_height_graph(sheet: &SheetStageMotion, height: f64) -> bool {
    let (skin, start, end) = (sheet.skin, sheet.start, sheet.end);
    if !skin.is_rectangle() || start.len() != end.len() {
        return false;
    }
    let area = |x: &Vectors, masses: [u32; 3]| {
        let [p, q] = sides(x, masses);
        p.cross(q)
    };
    let whole = |x| skin.triangles().iter().map(|t| area(x, t.nodes)).sum::<DVec3>();
    let up = (whole(start) + whole(end)).normalize_or_zero();
    let least = SETTINGS.minimum_graph_cosine.max(SETTINGS.minimum_graph_height * skin.contact_offset() / height);
    let faces_up = |a: DVec3| {
        let along = a.dot(up);
        along > 0.0 && along * along > least * least * a.length_squared()
    };
    let keeps_up = skin.triangles().iter().all(|t| {
        let ([p, q], [r, s]) = (sides(start, t.nodes), sides(end, t.nodes));
        let between = 0.5 * (p.cross(s) + r.cross(q));
        faces_up(p.cross(q)) && faces_up(r.cross(s)) && between.dot(up) > 0.0
    });
    keeps_up && [start, end].into_iter().all(|x| border_is_simple(skin, x, up))
}

/// Two sides of a triangle.
#[inline(always)]
fn sides(x: &Vectors, masses: [u32; 3]) -> [DVec3; 2] {
    let [a, b, c] = masses.map(|m| x.get(m as usize));
    [b - a, c - a]
}

/// Whether the border, seen along `up`, turns once around its centroid.
fn border_is_simple(skin: &CollisionSurface, x: &Vectors, up: DVec3) -> bool {
    let border = || skin.edges().iter().filter(|e| e.is_border());
    let (sum, count) = border().fold((DVec3::ZERO, 0), |(sum, n), e| (sum + x.get(e.nodes[0] as usize), n + 1));
    let middle = sum / f64::from(count.max(1));
    let (mut turned, mut left) = (0.0, true);
    for edge in border() {
        let masses = skin.triangles()[edge.triangles[0] as usize].nodes;
        let [a, b] = edge.nodes;
        // Orientation of the edge in its triangle, with the surface on the left.
        let forward = (0..3).any(|k| masses[k] == a && masses[(k + 1) % 3] == b);
        let [p, q] = if forward { [a, b] } else { [b, a] }.map(|m| {
            let arm = x.get(m as usize) - middle;
            arm - up * arm.dot(up)
        });
        let across = p.cross(q).dot(up);
        left &= across > 0.0;
        turned += across.atan2(p.dot(q));
    }
    left && (turned / TAU).round() == 1.0
}
