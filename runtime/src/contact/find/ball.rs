//! Balls on the triangles of a sheet, exactly: a triangle touches a ball at its point closest to the centre c, along
//! n = (x - c)/|x - c|, when |x - c| is the radius and the offset.
//!
//! Of a triangle that comes from afar the time at which it meets the ball is found by conservative advancement: with L no
//! less than the fastest of its masses the distance falls by no more than L dt, so that a step of (d - r)/L passes nothing
//! (Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996, 2.3).

use glam::DVec3;

use super::corners::at;
use super::keys::Kind;
use super::local::{Local, Meeting};
use super::tree::SkinTree;
use crate::contact::geometry::point_triangle;
use crate::contact::row::{Contact, SheetPoint};
use crate::contact::skin::SkinTriangle;

/// Steps of the advancement; each takes off most of the distance.
const ROUNDS: usize = 40;

/// Cosine of the angle within which the direction at the end is the one at the base, only later.
const SAME_SIDE: f64 = 0.8;

/// Rows of a ball with this centre and radius; returns how many triangles were looked at.
pub(super) fn ball(
    meeting: &Meeting,
    local: &Local,
    tree: &SkinTree,
    (centre, radius): (DVec3, f64),
    rows: &mut Vec<Contact>,
) -> u64 {
    let mut tests = 0;
    let reach = DVec3::splat(radius);
    for t in tree.triangles_in(&meeting.swept(centre - reach, centre + reach)) {
        let triangle = &meeting.skin.triangles()[t as usize];
        tests += 1;
        let places = local.of(triangle.masses).map(|x| x.map(|p| p - centre));
        let Some((normal, weights)) = touch(places, radius, meeting) else { continue };
        let (kind, index) = closest_feature(triangle, t, weights);
        let point = SheetPoint { masses: triangle.masses, weights };
        rows.push(meeting.row((point, kind, index), (centre + normal * radius, Kind::Ball, 0), normal));
    }
    tests
}

/// Normal and weights with which a triangle that moves past the origin touches a ball there.
fn touch([start, base, end]: [[DVec3; 3]; 3], radius: f64, meeting: &Meeting) -> Option<(DVec3, [f64; 3])> {
    let closest = |x: [DVec3; 3]| {
        let w = point_triangle(DVec3::ZERO, x);
        (at(x, w), w)
    };
    let touching = radius + meeting.offset;
    let (there, there_weights) = closest(base);
    let near = meeting.limits(2.0 * radius).near();
    let (direction, weights) = if there.length() <= radius + near {
        (there.try_normalize()?, there_weights)
    } else {
        let time = arrival(start, end, touching + meeting.margin)?;
        let (p, w) = closest([0, 1, 2].map(|i: usize| start[i].lerp(end[i], time)));
        (p.try_normalize()?, w)
    };
    let (last, last_weights) = closest(end);
    // A round of contact before this one knows better where the triangle will be than its motion without contact does.
    let first = base == start;
    let same = first && last.length() > 0.5 * radius && last.normalize_or_zero().dot(direction) > SAME_SIDE;
    let (normal, weights) = if same { (last.normalize_or_zero(), last_weights) } else { (direction, weights) };
    (normal.dot(at(end, weights)) - touching <= meeting.margin).then_some((normal, weights))
}

/// When a triangle comes as near to the origin as `reach` (m) on its way.
fn arrival(start: [DVec3; 3], end: [DVec3; 3], reach: f64) -> Option<f64> {
    let speed = (0..3).map(|i| start[i].distance(end[i])).fold(0.0, f64::max);
    let mut time = 0.0;
    for _ in 0..ROUNDS {
        let x = [0, 1, 2].map(|i: usize| start[i].lerp(end[i], time));
        let room = at(x, point_triangle(DVec3::ZERO, x)).length() - reach;
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
