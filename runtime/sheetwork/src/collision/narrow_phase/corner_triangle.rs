//! Convex corners of a body on the triangles of a sheet.
//!
//! The contact normal is that of the triangle, provided that the body lies behind the plane of the
//! triangle. Lengths in m.

use glam::DVec3;

use crate::collision::bvh::SurfaceTree;
use crate::collision::constraint::{ContactConstraint, SheetPoint};
use crate::collision::features::{ColliderCorner, ColliderMesh};
use crate::collision::geometry::{barycentric_along, point_meets_triangle, point_triangle};
use crate::collision::narrow_phase::DetectionDistances;
use crate::collision::narrow_phase::body_frame::{BodyFramePositions, SheetBodyPair};
use crate::collision::narrow_phase::feature_keys::FeatureKind;
use crate::collision::settings::{DetectionSettings, EdgeEdgeSettings};

const SETTINGS: DetectionSettings = DetectionSettings::DEFAULT;
const EDGE_EDGE: EdgeEdgeSettings = DetectionSettings::DEFAULT.edge_edge;

/// Add the constraints of all convex corners of a collider surface. Return the number of triangles
/// tested.
pub(crate) fn corners(
    meeting: &SheetBodyPair,
    local: &BodyFramePositions,
    tree: &SurfaceTree,
    mesh: &ColliderMesh,
    constraints: &mut Vec<ContactConstraint>,
) -> u64 {
    let limits = meeting.limits(mesh.min_width());
    let around = local.around.grown(limits.offset + limits.margin);
    let mut tests = 0;
    for (index, corner) in mesh.corners().iter().enumerate() {
        if !(corner.position.cmpge(around.low).all() && corner.position.cmple(around.high).all()) {
            continue;
        }
        let mut nearest: Option<(f64, u32, bool)> = None;
        let mut put = |t: u32, (normal, weights): (DVec3, [f64; 3])| {
            let point = SheetPoint { nodes: meeting.skin.triangles()[t as usize].nodes, weights };
            constraints.push(meeting.constraint(
                (point, FeatureKind::Triangle, t),
                (corner.position, FeatureKind::Corner, index as u32),
                normal,
            ));
        };
        for t in tree.triangles_in(&meeting.swept(corner.position, corner.position)) {
            let places = local.positions(meeting.skin.triangles()[t as usize].nodes);
            tests += 1;
            let found = corner_contact(corner, places, &limits);
            let distance = interpolate(places[1], point_triangle(corner.position, places[1])).distance(corner.position);
            if nearest.is_none_or(|(least, other, _)| distance < least || (distance == least && t < other)) {
                nearest = Some((distance, t, found.is_some()));
            }
            if let Some(found) = found {
                put(t, found);
            }
        }
        if let Some((_, t, false)) = nearest {
            let places = local.positions(meeting.skin.triangles()[t as usize].nodes);
            if let Some(found) = retained_contact(corner, places, &limits) {
                put(t, found);
            }
        }
    }
    tests
}

/// Normal and barycentric weights of the contact of a moving triangle with a corner.
fn corner_contact(
    corner: &ColliderCorner,
    [start, base, end]: [[DVec3; 3]; 3],
    limits: &DetectionDistances,
) -> Option<(DVec3, [f64; 3])> {
    let gap = interpolate(base, point_triangle(corner.position, base)) - corner.position;
    // The triangle must be on the side on which the stage began.
    let placed = base != start;
    let near = || {
        facing_normal(corner, base).filter(|n| {
            gap.length() <= limits.base_distance() && (placed || n.dot(gap) >= -limits.max_start_penetration)
        })
    };
    let over = |n: DVec3| Some((n, clamp_weights(barycentric_along(corner.position, n, end)?)?));
    // A base accepted by the contact solver determines the touching point better than the free
    // motion.
    let known = |n: DVec3| Some((n, clamp_weights(barycentric_along(corner.position, n, base)?)?)).filter(|_| placed);
    // A triangle that met the corner and has slid off since is held where it met.
    let (normal, w) = near().and_then(|n| known(n).or_else(|| over(n))).or_else(|| {
        // A triangle that stays clear in free motion may have been pushed through by another
        // contact.
        let pushed = || contact_from_motion(corner, start, base, limits).filter(|_| placed);
        let (n, met) = contact_from_motion(corner, start, end, limits).or_else(pushed)?;
        over(n).or(met.map(|w| (n, w)))
    })?;
    accept_contact(corner, (normal, w), [start, base, end], limits)
}

/// Contact of the triangle nearest to a corner at the base, if no triangle is above the corner at
/// the end, as over a fold that bends away from it. Contact and friction may hold the triangle
/// although the free motion slides off.
fn retained_contact(
    corner: &ColliderCorner,
    [start, base, end]: [[DVec3; 3]; 3],
    limits: &DetectionDistances,
) -> Option<(DVec3, [f64; 3])> {
    let w = point_triangle(corner.position, base);
    let gap = interpolate(base, w) - corner.position;
    let normal = facing_normal(corner, base)?;
    let slid = (interpolate(end, w) - interpolate(base, w)).reject_from_normalized(normal).length();
    // Beyond the border of the sheet its edges are in contact.
    let beside = gap.reject_from_normalized(normal).length()
        > 0.5 * gap.length() + SETTINGS.impact_distance_tolerance * limits.half;
    let off = base == start && slid > SETTINGS.maximum_slide * base[0].distance(base[1]);
    if gap.length() > limits.base_distance()
        || beside
        || off
        || (base == start && normal.dot(gap) < -limits.max_start_penetration)
    {
        return None;
    }
    accept_contact(corner, (normal, w), [start, base, end], limits)
}

/// The contact, provided that the pair is near at the end and was not on opposite sides at the
/// start.
fn accept_contact(
    corner: &ColliderCorner,
    (normal, w): (DVec3, [f64; 3]),
    [start, base, end]: [[DVec3; 3]; 3],
    limits: &DetectionDistances,
) -> Option<(DVec3, [f64; 3])> {
    let height = |x: [DVec3; 3]| normal.dot(interpolate(x, w) - corner.position);
    // A triangle that stays clear in free motion may have been pushed in by another contact.
    let gap = if base == start { height(end) } else { height(end).min(height(base)) } - limits.offset;
    let was_apart = || {
        height(start) >= -limits.max_start_penetration
            || was_in_front(corner, start, limits)
            || was_on_that_side(corner, normal, [start, base], limits)
    };
    (gap <= limits.margin && was_apart()).then_some((normal, w))
}

/// Whether a triangle was in front of the corner at the start, with its normal there. When it
/// slides and turns, its final contact point may lie behind a plane that the earlier normal did not
/// define.
fn was_in_front(corner: &ColliderCorner, start: [DVec3; 3], limits: &DetectionDistances) -> bool {
    let gap = interpolate(start, point_triangle(corner.position, start)) - corner.position;
    facing_normal(corner, start).is_some_and(|normal| normal.dot(gap) >= -limits.max_start_penetration)
}

/// Whether at the start the corner was on the side of the triangle away from which `normal` points
/// at the base. Needed for a body that an impact turns by a large angle within the stage, for which
/// neither plane is conclusive.
fn was_on_that_side(
    corner: &ColliderCorner,
    normal: DVec3,
    [start, base]: [[DVec3; 3]; 2],
    limits: &DetectionDistances,
) -> bool {
    let upwards = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).normalize_or_zero();
    let away = if normal.dot(upwards(base)) < 0.0 { -upwards(start) } else { upwards(start) };
    away.dot(interpolate(start, point_triangle(corner.position, start)) - corner.position)
        >= -limits.max_start_penetration
}

/// Normal of a triangle that is far from the corner at the base, and the weights at the time of
/// impact; without an impact the normal at the end, if the triangle is close there.
fn contact_from_motion(
    corner: &ColliderCorner,
    start: [DVec3; 3],
    end: [DVec3; 3],
    limits: &DetectionDistances,
) -> Option<(DVec3, Option<[f64; 3]>)> {
    let four = |[a, b, c]: [DVec3; 3]| [corner.position, a, b, c];
    if let Some(hit) = point_meets_triangle(four(start), four(end), SETTINGS.impact_distance_tolerance * limits.half) {
        let there = [0, 1, 2].map(|i: usize| start[i].lerp(end[i], hit.time));
        return facing_normal(corner, there).map(|n| (n, Some(hit.weights)));
    }
    let gap = interpolate(end, point_triangle(corner.position, end)) - corner.position;
    if gap.length() > limits.offset + limits.margin {
        return None;
    }
    facing_normal(corner, end).filter(|n| n.dot(gap) >= 0.0).map(|n| (n, None))
}

/// Normal of a triangle, directed away from the body; `None` if the body is on both sides of its
/// plane.
fn facing_normal(corner: &ColliderCorner, [a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let normal = (b - a).cross(c - a).try_normalize()?;
    [normal, -normal].into_iter().find(|n| corner.lies_behind(*n, EDGE_EDGE.normal_cone_tolerance))
}

pub(crate) fn interpolate(x: [DVec3; 3], w: [f64; 3]) -> DVec3 {
    x[0] * w[0] + x[1] * w[1] + x[2] * w[2]
}

/// Barycentric weights clamped to the triangle if they exceed it by rounding; `None` otherwise.
pub(crate) fn clamp_weights(w: [f64; 3]) -> Option<[f64; 3]> {
    if w.iter().any(|x| x.is_nan() || *x < -EDGE_EDGE.parameter_tolerance) {
        return None;
    }
    let inside = w.map(|x| x.max(0.0));
    let sum: f64 = inside.iter().sum();
    Some(inside.map(|x| x / sum))
}
