//! Balls on the triangles of a sheet, exactly: a triangle touches a ball at its point closest to the centre c, along
//! n = (x - c)/|x - c|, when |x - c| is the radius and the offset.
//!
//! Of a triangle that comes from afar the time at which it meets the ball is found by conservative advancement: with L no
//! less than the fastest of its masses the distance falls by no more than L dt, so that a step of (d - r)/L passes nothing
//! (Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996, 2.3).
//!
//! It then counts only if c is in the region of the feature that it meets: a triangle of a flat sheet ahead of a ball that goes
//! along it comes near with its side or its corner first, along a normal that leans against the ball, while the ball is over another.
//!
//! All of it is seen from c in axes that do not turn: what rolls turns under a place that touches, and does not take it along.

use glam::DVec3;

use crate::collision::bvh::SkinTree;
use crate::collision::collision_surface::{NONE, SkinTriangle};
use crate::collision::constraint::{Contact, SheetPoint};
use crate::collision::geometry::point_triangle;
use crate::collision::narrow_phase::body_frame::{Local, Meeting};
use crate::collision::narrow_phase::corner_triangle::at;
use crate::collision::narrow_phase::edge_edge::SLIPS;
use crate::collision::narrow_phase::feature_keys::Kind;

/// Steps of the advancement; each takes off most of the distance.
const ROUNDS: usize = 40;

/// Cosine of the angle within which the direction at the end is the one at the base, only later.
const SAME_SIDE: f64 = 0.8;

/// What is no further from touching rests on the ball, m.
const RESTS: f64 = 2e-5;

/// Part of a distance by which another is less that is: rounding.
const LESS: f64 = 1e-9;

/// Most triangles looked at around a mass.
const FAN: usize = 64;

/// What each triangle near a ball says of its own features, kept from call to call.
#[derive(Default)]
pub(crate) struct Nearest {
    /// Distance from the centre of what each row is of, m, where things were near before they moved.
    rows: Vec<Option<f64>>,
    /// Names of features of a triangle that has something nearer, and the distance of that.
    surpassed: Vec<(u64, f64)>,
}

/// Rows of a ball with this centre and radius; returns how many triangles were looked at.
pub(crate) fn ball(
    meeting: &Meeting,
    local: &Local,
    tree: &SkinTree,
    (centre, radius): (DVec3, f64),
    nearest: &mut Nearest,
    rows: &mut Vec<Contact>,
) -> u64 {
    let mut tests = 0;
    let reach = DVec3::splat(radius);
    let first = rows.len();
    nearest.rows.clear();
    nearest.surpassed.clear();
    for t in tree.triangles_in(&meeting.swept(centre - reach, centre + reach)) {
        let triangle = &meeting.skin.triangles()[t as usize];
        tests += 1;
        let seen = local.of(triangle.masses).map(|x| x.map(|p| p - centre));
        let places = meeting.in_axes_of_the_world(seen);
        let mut is_nearest = |touch: &Touch| {
            let nearer = |other: u32| {
                let seen = local.of(meeting.skin.triangles()[other as usize].masses).map(|x| x.map(|p| p - centre));
                let [start, base, end] = meeting.in_axes_of_the_world(seen);
                tests += 1;
                let there = touch.seen.map_or(base, |time| between(start, end, time));
                closest(there).0.length() < touch.distance * (1.0 - LESS)
            };
            !around(meeting, t, closest_feature(triangle, t, touch.weights), nearer)
        };
        let touches = touches(places, radius, meeting);
        let Some(Touch { normal, weights, distance, near, .. }) = touches.into_iter().flatten().find(&mut is_nearest)
        else {
            continue;
        };
        let (kind, index) = closest_feature(triangle, t, weights);
        let normal = meeting.at_end(normal);
        let point = SheetPoint { masses: triangle.masses, weights };
        let row = meeting.row((point, kind, index), (centre + normal * radius, Kind::Ball, 0), normal);
        nearest.note(meeting, triangle, row.key[0], near.then_some(distance));
        rows.push(row);
    }
    nearest.leave_out_surpassed(first, rows);
    tests
}

impl Nearest {
    /// Notes that `of` is what a triangle has nearest, at `distance` (m).
    fn note(&mut self, meeting: &Meeting, triangle: &SkinTriangle, of: u64, distance: Option<f64>) {
        self.rows.push(distance);
        let masses = triangle.masses.map(|i| meeting.sheet_feature(Kind::Mass, i));
        let edges = triangle.edges.map(|i| meeting.sheet_feature(Kind::SheetEdge, i));
        if let Some(distance) = distance {
            let others = masses.into_iter().chain(edges).filter(|feature| *feature != of);
            self.surpassed.extend(others.map(|feature| (feature, distance)));
        }
    }

    /// Leaves out of the rows from number `first` on those of an edge or a mass to which a triangle that it belongs to has something
    /// nearer. A surface touches a ball where it is nearest to it on all sides; beside that place such a row says the same with a normal
    /// that leans away from it, and where a ball rolls off, would push it on for as long as accuracy lets it.
    fn leave_out_surpassed(&mut self, first: usize, rows: &mut Vec<Contact>) {
        self.surpassed.sort_unstable_by(|p, q| p.0.cmp(&q.0).then(p.1.total_cmp(&q.1)));
        let least = |feature: u64| {
            let at = self.surpassed.partition_point(|(name, _)| *name < feature);
            self.surpassed.get(at).filter(|(name, _)| *name == feature).map(|(_, distance)| *distance)
        };
        let mut kept = first;
        for (i, distance) in self.rows.iter().enumerate() {
            let row = rows[first + i];
            let is_surpassed = distance.is_some_and(|d| least(row.key[0]).is_some_and(|least| least < d));
            if !is_surpassed {
                rows[kept] = row;
                kept += 1;
            }
        }
        rows.truncate(kept);
    }
}

/// Where a triangle touches a ball.
struct Touch {
    /// In the axes of the places.
    normal: DVec3,
    weights: [f64; 3],
    /// Distance of the point from the centre, m.
    distance: f64,
    /// Whether it was near before it moved.
    near: bool,
    /// The part of its way at which it is like that; none for where it was at the base.
    seen: Option<f64>,
}

/// The point of a triangle that is closest to the origin, and its weights.
fn closest(x: [DVec3; 3]) -> (DVec3, [f64; 3]) {
    let w = point_triangle(DVec3::ZERO, x);
    (at(x, w), w)
}

fn between(start: [DVec3; 3], end: [DVec3; 3], time: f64) -> [DVec3; 3] {
    [0, 1, 2].map(|i: usize| start[i].lerp(end[i], time))
}

/// Whether `is` is true of a triangle that shares the feature of triangle number `t` that is touched.
fn around(meeting: &Meeting, t: u32, (kind, index): (Kind, u32), mut is: impl FnMut(u32) -> bool) -> bool {
    let (triangles, edges) = (meeting.skin.triangles(), meeting.skin.edges());
    let across = |edge: u32, from: u32| {
        let [a, b] = edges[edge as usize].triangles;
        Some(if a == from { b } else { a }).filter(|other| *other != NONE)
    };
    match kind {
        Kind::SheetEdge => across(index, t).is_some_and(is),
        Kind::Mass => {
            let sides = triangles[t as usize].edges.into_iter().filter(|e| edges[*e as usize].masses.contains(&index));
            // From one side around the mass, and from the other where the border ended that.
            for first in sides {
                let (mut from, mut through) = (t, first);
                for _ in 0..FAN {
                    let Some(next) = across(through, from) else { break };
                    if next == t {
                        return false;
                    }
                    if is(next) {
                        return true;
                    }
                    let mut on = triangles[next as usize].edges.into_iter();
                    let Some(out) = on.find(|e| *e != through && edges[*e as usize].masses.contains(&index)) else {
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

/// How a triangle that moves past the origin touches a ball there: as it is at the end, and, where something else is nearer then, as it came.
fn touches([start, base, end]: [[DVec3; 3]; 3], radius: f64, meeting: &Meeting) -> [Option<Touch>; 2] {
    let touching = radius + meeting.offset;
    let (there, there_weights) = closest(base);
    let is_near = there.length() <= radius + meeting.limits(2.0 * radius).near();
    let arrived = if is_near {
        there.try_normalize().map(|n| (n, there_weights, there.length(), None))
    } else {
        arrival(start, end, touching + meeting.margin).and_then(|time| {
            let (p, weights) = closest(between(start, end, time));
            p.try_normalize().map(|n| (n, weights, p.length(), Some(time)))
        })
    };
    let arrived =
        arrived.map(|(normal, weights, distance, seen)| Touch { normal, weights, distance, near: is_near, seen });
    let Some(arrived) = arrived else { return [None, None] };
    let (last, weights) = closest(end);
    let distance = last.length();
    // A round of contact before this one knows better where the triangle will be than its motion without contact does.
    let first = base == start;
    // A sheet under strain goes far into the ball without contact, and is nearest to its centre elsewhere there: what rests is held where it
    // rests, and finds again the force that it had there.
    let slid = || (at(end, there_weights) - there).reject_from(there).length();
    let rests = there.length() - touching < RESTS && slid() < SLIPS;
    let normal = last.normalize_or_zero();
    let same = first && !rests && distance > 0.5 * radius && normal.dot(arrived.normal) > SAME_SIDE;
    let at_end = same.then_some(Touch { normal, weights, distance, near: is_near, seen: Some(1.0) });
    let closes = |touch: &Touch| touch.normal.dot(at(end, touch.weights)) - touching <= meeting.margin;
    if at_end.as_ref().is_some_and(|touch| !closes(touch)) {
        return [None, None];
    }
    [at_end, Some(arrived).filter(closes)]
}

/// When a triangle comes as near to the origin as `reach` (m) on its way.
fn arrival(start: [DVec3; 3], end: [DVec3; 3], reach: f64) -> Option<f64> {
    let speed = (0..3).map(|i| start[i].distance(end[i])).fold(0.0, f64::max);
    let mut time = 0.0;
    for _ in 0..ROUNDS {
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

/// What the weights say is touched: triangles that share a mass or an edge then make one row of it.
fn closest_feature(triangle: &SkinTriangle, number: u32, w: [f64; 3]) -> (Kind, u32) {
    match w.map(|x| x == 0.0) {
        [true, true, _] => (Kind::Mass, triangle.masses[2]),
        [true, _, true] => (Kind::Mass, triangle.masses[1]),
        [_, true, true] => (Kind::Mass, triangle.masses[0]),
        [true, _, _] => (Kind::SheetEdge, triangle.edges[1]),
        [_, true, _] => (Kind::SheetEdge, triangle.edges[2]),
        [_, _, true] => (Kind::SheetEdge, triangle.edges[0]),
        _ => (Kind::Triangle, number),
    }
}
