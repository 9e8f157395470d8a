//! Balls on the triangles of a sheet, without tessellation.
//!
//! A triangle touches a ball of centre c at its point x closest to c, along n = (x - c)/|x - c|,
//! when
//! |x - c| equals radius plus contact offset. The time of impact of a triangle that approaches from
//! afar is found by conservative advancement: with L at least the speed of its fastest node, the
//! distance d falls by at most L dt, so that a step of (d - r)/L cannot miss an impact (Mirtich,
//! Impulse-based dynamic simulation of rigid body systems, 1996, 2.3).
//!
//! The impact counts only if c lies in the Voronoi region of the touched feature. A triangle of a
//! flat sheet ahead of a ball that moves along the sheet would otherwise be touched at an edge or
//! corner, along a normal that opposes the ball, while the ball is over another triangle.
//!
//! Positions are relative to c in axes that do not rotate with the ball: a rolling ball turns under
//! the touched place and does not carry it along. Lengths in m.

use glam::DVec3;

use crate::collision::bvh::SurfaceTree;
use crate::collision::collision_surface::{NONE, SurfaceTriangle};
use crate::collision::constraint::{ContactConstraint, SheetPoint};
use crate::collision::geometry::point_triangle;
use crate::collision::narrow_phase::body_frame::{BodyFramePositions, SheetBodyPair};
use crate::collision::narrow_phase::corner_triangle::interpolate;
use crate::collision::narrow_phase::feature_keys::FeatureKind;
use crate::collision::settings::{DetectionSettings, TriangleBallSettings};

const SETTINGS: TriangleBallSettings = DetectionSettings::DEFAULT.triangle_ball;
const DETECTION: DetectionSettings = DetectionSettings::DEFAULT;

/// Distances of the features of triangles near a ball, with buffers reused between calls.
#[derive(Default)]
pub(crate) struct BallWorkspace {
    /// Distance of each constraint's feature from the centre, m; `None` if the triangle was far at
    /// the base.
    rows: Vec<Option<f64>>,
    /// Keys of features whose triangle has a nearer one, and the distance of that.
    dominated: Vec<(u64, f64)>,
}

/// Add the constraints of a ball with this centre and radius. Return the number of triangles
/// tested.
pub(crate) fn ball(
    meeting: &SheetBodyPair,
    local: &BodyFramePositions,
    tree: &SurfaceTree,
    (centre, radius): (DVec3, f64),
    nearest: &mut BallWorkspace,
    constraints: &mut Vec<ContactConstraint>,
) -> u64 {
    let mut tests = 0;
    let reach = DVec3::splat(radius);
    let first = constraints.len();
    nearest.rows.clear();
    nearest.dominated.clear();
    for t in tree.triangles_in(&meeting.swept(centre - reach, centre + reach)) {
        let triangle = &meeting.skin.triangles()[t as usize];
        tests += 1;
        let seen = local.positions(triangle.nodes).map(|x| x.map(|p| p - centre));
        let places = meeting.in_world_axes(seen);
        let mut is_nearest = |touch: &BallContact| {
            let nearer = |other: u32| {
                let seen =
                    local.positions(meeting.skin.triangles()[other as usize].nodes).map(|x| x.map(|p| p - centre));
                let [start, base, end] = meeting.in_world_axes(seen);
                tests += 1;
                let there = touch.seen.map_or(base, |time| between(start, end, time));
                closest(there).0.length() < touch.distance * (1.0 - SETTINGS.relative_tolerance)
            };
            !any_adjacent(meeting, t, closest_feature(triangle, t, touch.weights), nearer)
        };
        let touches = ball_contacts(places, radius, meeting);
        let Some(BallContact { normal, weights, distance, near, .. }) =
            touches.into_iter().flatten().find(&mut is_nearest)
        else {
            continue;
        };
        let (kind, index) = closest_feature(triangle, t, weights);
        let normal = meeting.at_end(normal);
        let point = SheetPoint { nodes: triangle.nodes, weights };
        let row = meeting.constraint((point, kind, index), (centre + normal * radius, FeatureKind::Ball, 0), normal);
        nearest.note(meeting, triangle, row.key[0], near.then_some(distance));
        constraints.push(row);
    }
    nearest.remove_dominated(first, constraints);
    tests
}

impl BallWorkspace {
    /// Record that `of` is the nearest feature of a triangle, at `distance` (m).
    fn note(&mut self, meeting: &SheetBodyPair, triangle: &SurfaceTriangle, of: u64, distance: Option<f64>) {
        self.rows.push(distance);
        let masses = triangle.nodes.map(|i| meeting.sheet_feature(FeatureKind::Node, i));
        let edges = triangle.edges.map(|i| meeting.sheet_feature(FeatureKind::SheetEdge, i));
        if let Some(distance) = distance {
            let others = masses.into_iter().chain(edges).filter(|feature| *feature != of);
            self.dominated.extend(others.map(|feature| (feature, distance)));
        }
    }

    /// Remove, from index `first` on, the constraints of an edge or a node that belongs to a
    /// triangle with a nearer feature. A surface touches a ball where its distance is a local
    /// minimum; another constraint beside that place would have a normal that leans away, and would
    /// push a ball that rolls off.
    fn remove_dominated(&mut self, first: usize, constraints: &mut Vec<ContactConstraint>) {
        self.dominated.sort_unstable_by(|p, q| p.0.cmp(&q.0).then(p.1.total_cmp(&q.1)));
        let least = |feature: u64| {
            let at = self.dominated.partition_point(|(name, _)| *name < feature);
            self.dominated.get(at).filter(|(name, _)| *name == feature).map(|(_, distance)| *distance)
        };
        let mut kept = first;
        for (i, distance) in self.rows.iter().enumerate() {
            let row = constraints[first + i];
            let is_surpassed = distance.is_some_and(|d| least(row.key[0]).is_some_and(|least| least < d));
            if !is_surpassed {
                constraints[kept] = row;
                kept += 1;
            }
        }
        constraints.truncate(kept);
    }
}

/// Contact of a triangle with a ball.
struct BallContact {
    /// Unit normal in the axes of the positions.
    normal: DVec3,
    weights: [f64; 3],
    /// Distance of the point from the centre, m.
    distance: f64,
    /// Whether the triangle was near the ball at the base.
    near: bool,
    /// Fraction of the motion at which the contact is evaluated; `None` for the base.
    seen: Option<f64>,
}

/// Point of a triangle closest to the origin, and its barycentric weights.
fn closest(x: [DVec3; 3]) -> (DVec3, [f64; 3]) {
    let w = point_triangle(DVec3::ZERO, x);
    (interpolate(x, w), w)
}

fn between(start: [DVec3; 3], end: [DVec3; 3], time: f64) -> [DVec3; 3] {
    [0, 1, 2].map(|i: usize| start[i].lerp(end[i], time))
}

/// Whether `is` holds for any triangle that shares the touched feature of triangle `t`.
fn any_adjacent(
    meeting: &SheetBodyPair,
    t: u32,
    (kind, index): (FeatureKind, u32),
    mut is: impl FnMut(u32) -> bool,
) -> bool {
    let (triangles, edges) = (meeting.skin.triangles(), meeting.skin.edges());
    let across = |edge: u32, from: u32| {
        let [a, b] = edges[edge as usize].triangles;
        Some(if a == from { b } else { a }).filter(|other| *other != NONE)
    };
    match kind {
        FeatureKind::SheetEdge => across(index, t).is_some_and(is),
        FeatureKind::Node => {
            let sides = triangles[t as usize].edges.into_iter().filter(|e| edges[*e as usize].nodes.contains(&index));
            // Go around the node from one side, and from the other side if the border stopped the
            // first pass.
            for first in sides {
                let (mut from, mut through) = (t, first);
                for _ in 0..SETTINGS.maximum_fan {
                    let Some(next) = across(through, from) else { break };
                    if next == t {
                        return false;
                    }
                    if is(next) {
                        return true;
                    }
                    let mut on = triangles[next as usize].edges.into_iter();
                    let Some(out) = on.find(|e| *e != through && edges[*e as usize].nodes.contains(&index)) else {
                        break;
                    };
                    (from, through) = (next, out);
                }
            }
            false
        }
        _ => false,
    }
}

/// Contacts of a triangle that moves past a ball at the origin: that at the end, and, as an
/// alternative if another feature is nearer then, that at arrival.
fn ball_contacts(
    [start, base, end]: [[DVec3; 3]; 3],
    radius: f64,
    meeting: &SheetBodyPair,
) -> [Option<BallContact>; 2] {
    let touching = radius + meeting.offset;
    let (there, there_weights) = closest(base);
    let is_near = there.length() <= radius + meeting.limits(2.0 * radius).base_distance();
    let arrived = if is_near {
        there.try_normalize().map(|n| (n, there_weights, there.length(), None))
    } else {
        time_of_impact(start, end, touching + meeting.margin).and_then(|time| {
            let (p, weights) = closest(between(start, end, time));
            p.try_normalize().map(|n| (n, weights, p.length(), Some(time)))
        })
    };
    let arrived =
        arrived.map(|(normal, weights, distance, seen)| BallContact { normal, weights, distance, near: is_near, seen });
    let Some(arrived) = arrived else { return [None, None] };
    let (last, weights) = closest(end);
    let distance = last.length();
    // A base accepted by the contact solver predicts the position better than the free motion.
    let first = base == start;
    // A stretched sheet moves deep into the ball in free motion, where another point is closest. A
    // resting contact keeps its point, so that its force is found in the contact cache.
    let slid = || (interpolate(end, there_weights) - there).reject_from(there).length();
    let rests = there.length() - touching < SETTINGS.resting_distance * meeting.half
        && slid() < DETECTION.maximum_slide * start[0].distance(start[1]);
    let normal = last.normalize_or_zero();
    let same = first && !rests && distance > 0.5 * radius && normal.dot(arrived.normal) > SETTINGS.same_side_cosine;
    let at_end = same.then_some(BallContact { normal, weights, distance, near: is_near, seen: Some(1.0) });
    let closes = |touch: &BallContact| touch.normal.dot(interpolate(end, touch.weights)) - touching <= meeting.margin;
    if at_end.as_ref().is_some_and(|touch| !closes(touch)) {
        return [None, None];
    }
    [at_end, Some(arrived).filter(closes)]
}

/// Fraction of the motion at which the distance of a triangle from the origin falls to `reach` (m).
fn time_of_impact(start: [DVec3; 3], end: [DVec3; 3], reach: f64) -> Option<f64> {
    let speed = (0..3).map(|i| start[i].distance(end[i])).fold(0.0, f64::max);
    let mut time = 0.0;
    for _ in 0..SETTINGS.maximum_advancement_steps {
        let room = closest(between(start, end, time)).0.length() - reach;
        if room <= 1e-6 * reach {
            return Some(time);
        }
        time += room / speed;
        if time.is_nan() || time > 1.0 {
            return None;
        }
    }
    Some(time)
}

/// Feature that the weights identify. Triangles that share a node or an edge then produce equal
/// keys.
fn closest_feature(triangle: &SurfaceTriangle, number: u32, w: [f64; 3]) -> (FeatureKind, u32) {
    match w.map(|x| x == 0.0) {
        [true, true, _] => (FeatureKind::Node, triangle.nodes[2]),
        [true, _, true] => (FeatureKind::Node, triangle.nodes[1]),
        [_, true, true] => (FeatureKind::Node, triangle.nodes[0]),
        [true, _, _] => (FeatureKind::SheetEdge, triangle.edges[1]),
        [_, true, _] => (FeatureKind::SheetEdge, triangle.edges[2]),
        [_, _, true] => (FeatureKind::SheetEdge, triangle.edges[0]),
        _ => (FeatureKind::Triangle, number),
    }
}
