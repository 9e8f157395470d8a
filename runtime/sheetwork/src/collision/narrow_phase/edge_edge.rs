//! Sharp convex edges of a body on the edges of a sheet.
//!
//! The normal of two lines is n = u × e / |u × e|, directed out of the body. If the edges are
//! nearly parallel, the normal of the sheet replaces it. An edge contact exists only if n lies
//! between the normals of the two faces; beyond them the faces are in contact. With n given, the
//! two points above each other along n follow from the positions of both edges at the end. Lengths
//! in m.

use glam::DVec3;

use crate::collision::bvh::{BoundingBox, SurfaceTree};
use crate::collision::constraint::{ContactConstraint, SheetPoint};
use crate::collision::features::{ColliderEdge, ColliderMesh};
use crate::collision::geometry::{EdgeImpact, edges_meet, segment_segment};
use crate::collision::narrow_phase::body_frame::{BodyFramePositions, SheetBodyPair};
use crate::collision::narrow_phase::feature_keys::FeatureKind;
use crate::collision::narrow_phase::{DetectionDistances, box_of};
use crate::collision::settings::{DetectionSettings, EdgeEdgeSettings, VertexFaceSettings};

const SETTINGS: EdgeEdgeSettings = DetectionSettings::DEFAULT.edge_edge;
const DETECTION: DetectionSettings = DetectionSettings::DEFAULT;
const VERTEX_FACE: VertexFaceSettings = DetectionSettings::DEFAULT.vertex_face;

/// Parameters on both edges at the contact, if known.
type Met = Option<(f64, f64)>;

/// Contact of two edges: normal, and parameters on the sheet's and on the other edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeContact {
    pub normal: DVec3,
    pub s: f64,
    pub t: f64,
}

/// Add the constraints of all sharp convex edges of a collider surface. Return the number of edge
/// pairs tested.
pub(crate) fn edges(
    meeting: &SheetBodyPair,
    local: &BodyFramePositions,
    tree: &SurfaceTree,
    mesh: &ColliderMesh,
    constraints: &mut Vec<ContactConstraint>,
) -> u64 {
    let limits = meeting.limits(mesh.min_width());
    let mut tests = 0;
    let around = local.around.grown(limits.offset + limits.margin);
    mesh.edges_in(around.low, around.high, |index| {
        let edge = &mesh.edges()[index as usize];
        let (low, high) = box_of(edge.ends);
        let close = BoundingBox { low, high }.grown(limits.offset + limits.margin);
        for t in tree.triangles_in(&meeting.swept(low, high)) {
            let triangle = &meeting.skin.triangles()[t as usize];
            for side in (0..3).filter(|side| triangle.owns_edge[*side]) {
                let number = triangle.edges[side];
                let own = &meeting.skin.edges()[number as usize];
                let places @ [start, base, end] = local.positions(own.nodes);
                if !close.overlaps(&BoundingBox::from(box_of(start.into_iter().chain(base).chain(end)))) {
                    continue;
                }
                tests += 1;
                if remains_parallel(edge, places) {
                    continue;
                }
                let side = meeting.orientation_at_base(own, tree, local);
                let before = || meeting.orientation_at_start(own, local);
                let Some(found) = crossing(edge, places, (&side, &before), &limits) else { continue };
                let foot = edge.ends[0].lerp(edge.ends[1], found.t);
                let point = on_edge(own.nodes, found.s, number);
                constraints.push(meeting.constraint(point, (foot, FeatureKind::BodyEdge, index), found.normal));
            }
        }
    });
    tests
}

/// Point at the parameter `s` of an edge with its feature. An end is a node, which other edges
/// share.
pub(crate) fn on_edge([i, j]: [u32; 2], s: f64, number: u32) -> (SheetPoint, FeatureKind, u32) {
    if s <= SETTINGS.parameter_tolerance {
        (SheetPoint::node(i), FeatureKind::Node, i)
    } else if s >= 1.0 - SETTINGS.parameter_tolerance {
        (SheetPoint::node(j), FeatureKind::Node, j)
    } else {
        (SheetPoint { nodes: [i, j, i], weights: [1.0 - s, s, 0.0] }, FeatureKind::SheetEdge, number)
    }
}

/// Directions from which an edge of a sheet can be touched.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeOrientation {
    /// Unit normals of the adjacent triangles; at the border the only one, twice.
    pub sides: [DVec3; 2],
    /// Unit vectors from the edge into these triangles, perpendicular to it; at the border the only
    /// one, twice.
    pub flanks: [DVec3; 2],
    pub is_border: bool,
}

impl EdgeOrientation {
    /// Whether a contact along the normal `n`, towards the edge, comes from outside: at a border or
    /// a fold from where the surface leads away from it, otherwise from above or below.
    pub fn admits(&self, n: DVec3) -> bool {
        let stands_out = self.flanks.iter().all(|flank| n.dot(*flank) > -SETTINGS.inward_sine);
        stands_out || !self.is_border && self.sides.iter().any(|side| n.dot(*side).abs() > SETTINGS.inner_edge_cosine)
    }

    /// Surface normal on the side of `n`, not normalised.
    fn normal_towards(&self, n: DVec3) -> DVec3 {
        self.sides.into_iter().map(|side| if side.dot(n) < 0.0 { -side } else { side }).sum()
    }
}

/// Whether a sheet edge stays parallel to the body edge at all of `places` and between them, so
/// that no contact is possible; this is frequent for sheets square on a box. Between two places the
/// component across the body edge is at most, the component along it at least, that at one of them.
fn remains_parallel(edge: &ColliderEdge, places: [[DVec3; 2]; 3]) -> bool {
    let direction = (edge.ends[1] - edge.ends[0]).normalize_or_zero();
    let ways = places.map(|x| x[1] - x[0]);
    let along = ways.map(|way| way.dot(direction));
    let across = ways.iter().map(|way| way.cross(direction).length_squared()).fold(0.0, f64::max);
    let turns = along.iter().any(|a| a * along[0] <= 0.0);
    let least = along.iter().fold(f64::INFINITY, |least, a| least.min(a.abs()));
    !turns && across < (0.99 * SETTINGS.parallel_sine * least).powi(2)
}

/// Contact of a sheet edge that moves through `start`, `base` and `end` with an edge of a body.
/// `side` is its orientation at the base, `before` that at the start.
fn crossing(
    edge: &ColliderEdge,
    [start, base, end]: [[DVec3; 2]; 3],
    (side, before): (&EdgeOrientation, &dyn Fn() -> EdgeOrientation),
    limits: &DetectionDistances,
) -> Option<EdgeContact> {
    let found = contact_from_base(edge, [start, base, end], side, limits);
    let placed = base != start;
    // A pair that stays clear in free motion may have been pushed through by another contact.
    let pushed = || contact_from_motion(edge, start, base, side, limits).filter(|_| placed);
    let (normal, met) = found.or_else(|| contact_from_motion(edge, start, end, side, limits)).or_else(pushed)?;
    // The base, if accepted by the contact solver, determines the touching points better than the
    // end of the free motion. Edges that met and have slid off since are held where they met.
    let known = met.filter(|_| found.is_some() && placed);
    let (s, t) = known.or_else(|| facing_parameters(end, edge.ends, normal)).or(met)?;
    let height = |x: [DVec3; 2]| normal.dot(separation(x, edge, s, t));
    // A pair that stays clear in free motion may have been pushed in by another contact.
    let gap = if placed { height(end).min(height(base)) } else { height(end) } - limits.offset;
    // The edge passed down a face and over its rim: outside the body, but behind the body edge.
    let came_round = || {
        let outside = |n: &DVec3| start.iter().all(|p| n.dot(*p - edge.ends[0]) >= -limits.max_start_penetration);
        let met = |end| edge_impact(edge, start, end, limits.half).is_some();
        edge.normals.iter().any(outside)
            && (met(end) || placed && (height(base) >= -limits.max_start_penetration || met(base)))
    };
    let was_apart = || {
        height(start) >= -limits.max_start_penetration || was_in_front(edge, start, &before(), limits) || came_round()
    };
    (gap <= limits.margin && was_apart()).then_some(EdgeContact { normal, s, t })
}

/// Whether a sheet edge was in front of the body edge at the start, with its orientation there.
/// When it slides and turns, its final contact points may lie behind each other along the earlier
/// normal.
fn was_in_front(edge: &ColliderEdge, start: [DVec3; 2], side: &EdgeOrientation, limits: &DetectionDistances) -> bool {
    let (s, t) = segment_segment(start, edge.ends);
    outward_normal(edge, start[1] - start[0], side)
        .is_some_and(|normal| normal.dot(separation(start, edge, s, t)) >= -limits.max_start_penetration)
}

/// Vector from the body edge at `t` to the sheet edge `x` at `s`, m.
fn separation(x: [DVec3; 2], edge: &ColliderEdge, s: f64, t: f64) -> DVec3 {
    x[0].lerp(x[1], s) - edge.ends[0].lerp(edge.ends[1], t)
}

/// Normal and parameters of a pair that is close at the base, where contact and friction may hold
/// it although the free motion slides off.
fn contact_from_base(
    edge: &ColliderEdge,
    [start, base, end]: [[DVec3; 2]; 3],
    side: &EdgeOrientation,
    limits: &DetectionDistances,
) -> Option<(DVec3, Met)> {
    let (s, t) = segment_segment(base, edge.ends);
    let gap = separation(base, edge, s, t);
    if gap.length() > limits.base_distance() {
        return None;
    }
    let normal = outward_normal(edge, base[1] - base[0], side)?;
    // A closest point at the end of an edge belongs to other features.
    let beside =
        gap.reject_from_normalized(normal).length() > 0.5 * gap.length() + DETECTION.rounding_distance * limits.half;
    // The pair must be on the side on which the stage began.
    if beside || (base == start && normal.dot(gap) < -limits.max_start_penetration) {
        return None;
    }
    let slid = (separation(end, edge, s, t) - gap).reject_from_normalized(normal).length();
    Some((normal, (base != start || slid < DETECTION.maximum_slide * base[0].distance(base[1])).then_some((s, t))))
}

/// Normal of a pair that is far apart at the base, and its parameters at the time of impact;
/// without an impact the normal at the end, if the pair is close there.
fn contact_from_motion(
    edge: &ColliderEdge,
    start: [DVec3; 2],
    end: [DVec3; 2],
    side: &EdgeOrientation,
    limits: &DetectionDistances,
) -> Option<(DVec3, Met)> {
    let [q, r] = edge.ends;
    if let Some(hit) = edge_impact(edge, start, end, limits.half) {
        let at = [0, 1].map(|i: usize| start[i].lerp(end[i], hit.time));
        return outward_normal(edge, at[1] - at[0], side).map(|n| (n, Some((hit.s, hit.t))));
    }
    let (s, t) = segment_segment(end, edge.ends);
    let gap = end[0].lerp(end[1], s) - q.lerp(r, t);
    if gap.length() > limits.offset + limits.margin {
        return None;
    }
    outward_normal(edge, end[1] - end[0], side).filter(|n| n.dot(gap) >= 0.0).map(|n| (n, None))
}

/// Impact of a sheet edge with a body edge.
fn edge_impact(edge: &ColliderEdge, start: [DVec3; 2], end: [DVec3; 2], half: f64) -> Option<EdgeImpact> {
    let [q, r] = edge.ends;
    edges_meet([start[0], start[1], q, r], [end[0], end[1], q, r], DETECTION.impact_distance_tolerance * half)
        .or_else(|| rim_impact(edge, start, end, half))
}

/// Impact of a sheet edge of which one end cuts across the body edge from one face to the other,
/// not deep enough to enter through a face. It carries the sheet edge behind the body edge without
/// an edge-edge impact.
fn rim_impact(edge: &ColliderEdge, start: [DVec3; 2], end: [DVec3; 2], half: f64) -> Option<EdgeImpact> {
    [0, 1].into_iter().find_map(|k: usize| {
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        for n in edge.normals {
            let (from, to) = (n.dot(start[k] - edge.ends[0]), n.dot(end[k] - edge.ends[0]));
            if from > 0.0 && to > 0.0 {
                return None;
            }
            if from > 0.0 {
                enters = enters.max(from / (from - to));
            } else if to > 0.0 {
                leaves = leaves.min(from / (from - to));
            }
        }
        let time = 0.5 * (enters + leaves);
        let (along, at) = (edge.ends[1] - edge.ends[0], start[k].lerp(end[k], time) - edge.ends[0]);
        let t = along.dot(at) / along.length_squared();
        let deepest = edge.normals.map(|n| -n.dot(at)).into_iter().fold(f64::INFINITY, f64::min);
        let cuts = enters > 0.0
            && leaves < 1.0
            && enters < leaves
            && deepest < VERTEX_FACE.corner_cut_depth * half
            && (0.0..=1.0).contains(&t);
        cuts.then_some(EdgeImpact { time, s: k as f64, t })
    })
}

/// Normal of a body edge and a line along `along`, limited to the range between the normals of the
/// adjacent faces. `None` beyond that range, for parallel lines, and where the sheet cannot be
/// touched from that side.
fn outward_normal(edge: &ColliderEdge, along: DVec3, side: &EdgeOrientation) -> Option<DVec3> {
    let direction = (edge.ends[1] - edge.ends[0]).normalize_or_zero();
    let across = along.normalize_or_zero().cross(direction);
    let sine = across.length();
    let normal = if sine >= SETTINGS.nearly_parallel_sine {
        across / sine
    } else if sine >= SETTINGS.parallel_sine {
        side.normal_towards(edge.normals[0] + edge.normals[1]).reject_from_normalized(direction).try_normalize()?
    } else {
        return None;
    };
    let [m, n] = edge.normals;
    let normal = if normal.dot(m + n) < 0.0 { -normal } else { normal };
    if !side.admits(normal) {
        return None;
    }
    // normal = α m + β n; both coefficients below are scaled by the sine of the angle of m and n.
    let cosine = m.dot(n);
    let (a, b) = (normal.dot(m), normal.dot(n));
    let sine = (1.0 - cosine * cosine).max(1e-12).sqrt();
    let (alpha, beta) = ((a - cosine * b) / sine, (b - cosine * a) / sine);
    if alpha < -SETTINGS.normal_cone_tolerance || beta < -SETTINGS.normal_cone_tolerance {
        None
    } else if alpha < 0.0 {
        Some(n)
    } else if beta < 0.0 {
        Some(m)
    } else {
        Some(normal)
    }
}

/// Parameters of the points of two edges that are above each other along `n`; `None` if either edge
/// is too short.
pub(crate) fn facing_parameters(p: [DVec3; 2], q: [DVec3; 2], n: DVec3) -> Option<(f64, f64)> {
    let (u, v, w) = (p[1] - p[0], q[1] - q[0], p[0] - q[0]);
    let (vn, un) = (v.cross(n), u.cross(n));
    let turn = u.dot(vn);
    if turn.is_nan() || turn.abs() <= 0.5 * SETTINGS.parallel_sine * u.length() * v.length() {
        return None;
    }
    let (s, t) = (-w.dot(vn) / turn, -w.dot(un) / turn);
    let within = |x: f64| (-SETTINGS.parameter_tolerance..=1.0 + SETTINGS.parameter_tolerance).contains(&x);
    (within(s) && within(t)).then(|| (s.clamp(0.0, 1.0), t.clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use proptest::prelude::*;

    use super::*;

    fn vector(reach: f64) -> impl Strategy<Value = DVec3> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(move |(x, y, z)| reach * DVec3::new(x, y, z))
    }

    proptest! {
        #![proptest_config(crate::math::drawn::drawn_cases(20_000))]

        /// A parallel pair has no contact, for edges close to the direction of a box edge that pass
        /// through it.
        #[test]
        fn edges_that_remain_parallel_have_no_contact(turns in [vector(0.012), vector(0.012), vector(0.012)],
                                               places in [vector(2e-3), vector(2e-3), vector(2e-3)], back in any::<bool>()) {
            let edge = ColliderEdge { ends: [DVec3::ZERO, 0.1 * DVec3::X], normals: [DVec3::Y, DVec3::Z] };
            let half = DVec3::X * if back { -0.01 } else { 0.01 };
            let ways = [0, 1, 2].map(|k| {
                let (middle, way) = (places[k] + 0.05 * DVec3::X, DQuat::from_scaled_axis(turns[k]) * half);
                [middle - way, middle + way]
            });
            let side = EdgeOrientation { sides: [DVec3::Y; 2], flanks: [DVec3::Z, -DVec3::Z], is_border: false };
            let limits = DetectionDistances { margin: 5e-4, offset: 2.5e-4, max_start_penetration: 1e-4, half: 2.5e-4, fall: 0.0 };
            let found = crossing(&edge, ways, (&side, &|| side), &limits);
            prop_assert!(found.is_none() || !remains_parallel(&edge, ways), "{found:?}");
        }

        /// Edges turned by a small angle are detected as parallel.
        #[test]
        fn parallel_edges_are_detected(turns in [vector(0.005), vector(0.005), vector(0.005)], middle in vector(2e-3)) {
            let edge = ColliderEdge { ends: [DVec3::ZERO, 0.1 * DVec3::X], normals: [DVec3::Y, DVec3::Z] };
            let way = |turn: DVec3| DQuat::from_scaled_axis(turn) * DVec3::X * 0.01;
            prop_assert!(remains_parallel(&edge, turns.map(|turn| [middle, middle + way(turn)])));
            // An edge turned by half a revolution crosses the direction of the body edge.
            prop_assert!(!remains_parallel(&edge, [[middle, middle + way(turns[0])], [middle, middle - way(turns[1])], [middle, middle - way(turns[2])]]));
        }
    }
}
