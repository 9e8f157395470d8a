//! Where a body strikes what does not give way: its velocities after a bounce.
//!
//! Rapier gives restitution to the points of a contact one after the other and once, so that a box that lands flat turns and leaves too
//! slowly. Here every point that is approached with v leaves with at least e v, with Coulomb's friction at each, all solved for together by
//! projected Gauss-Seidel; what would gain energy by that is left to Rapier.

use glam::DVec3;

use crate::rigid::RigidWorld;
use crate::rigid::state::BodyState;

/// Approach speed above which a body bounces, m/s.
const BOUNCES: f64 = 0.01;
/// Part of what Rapier sees by itself that is no distance.
const LIES: f64 = 0.1;
/// Passes over the points, and most points.
const PASSES: usize = 100;
const POINTS: usize = 16;

/// A point that strikes.
#[derive(Clone, Copy, Default)]
struct Point {
    /// Place on the body, in its frame, m.
    local: DVec3,
    /// From the wall to the body, unit.
    normal: DVec3,
    /// Velocity of the wall there, m/s.
    wall: DVec3,
    /// How far it is from the wall, m, and how fast it comes, m/s.
    gap: f64,
    approach: f64,
    friction: f64,
    restitution: f64,
    /// Impulses so far, N s.
    push: f64,
    rub: DVec3,
}

impl RigidWorld {
    /// Body `index` at the end of a part of `part` s in which nothing but what does not give way has pushed it, after a bounce; `None` where it
    /// does not bounce.
    pub(crate) fn bounced(&self, index: usize, part: f64, g: DVec3) -> Option<BodyState> {
        let from = self.motions[index].from;
        let mut points = [Point::default(); POINTS];
        let mut count = 0;
        self.each_strike(index, |point| {
            // With those that strike, those that it lies on already.
            let reached = (point.approach * part).max(LIES * f64::from(self.owners.reach));
            if point.gap <= reached && count < POINTS {
                points[count] = point;
                count += 1;
            }
        });
        let points = &mut points[..count];
        if !points.iter().any(|p| p.restitution > 0.0 && p.approach > BOUNCES) {
            return None;
        }
        let strike = points.iter().filter(|p| p.approach > BOUNCES);
        let time = strike.map(|p| p.gap.max(0.0) / p.approach).fold(part, f64::min);
        let there = from.fly(time, g);
        let after = left(&there, points);
        (after.kinetic_energy() <= there.kinetic_energy() * (1.0 + 1e-9)).then(|| after.fly(part - time, g))
    }

    /// Calls `with` for each point at which body `index` is near what does not give way, as Rapier has found them at the start of the part.
    fn each_strike(&self, index: usize, mut with: impl FnMut(Point)) {
        let from = &self.motions[index].from;
        for pair in self.bodies[index].colliders.iter().flat_map(|c| self.inner.narrow_phase.contact_pairs_with(*c)) {
            let (Some(first), Some(second)) = (self.owners.of(pair.collider1), self.owners.of(pair.collider2)) else {
                continue;
            };
            let over = &self.motions[if first == index { second } else { first }];
            let side = if first == index { -1.0 } else { 1.0 };
            for manifold in pair.solver_manifolds() {
                let normal = manifold.data.normal.as_dvec3().normalize_or_zero() * side;
                for point in manifold.points.iter().filter(|p| p.dist <= self.owners.reach) {
                    let local = if first == index { point.local_p1 } else { point.local_p2 }.as_dvec3();
                    let place = from.place(local);
                    let wall = over.start.velocity_at(place);
                    let approach = -(from.velocity_at(place) - wall).dot(normal);
                    if normal != DVec3::ZERO {
                        let friction = f64::from(manifold.data.friction);
                        let restitution = f64::from(manifold.data.restitution);
                        let gap = f64::from(point.dist);
                        with(Point { local, normal, wall, gap, approach, friction, restitution, ..Point::default() });
                    }
                }
            }
        }
    }
}

/// The body `at` after all `points` have struck.
fn left(at: &BodyState, points: &mut [Point]) -> BodyState {
    let mut state = *at;
    for point in points.iter_mut() {
        point.approach = (point.wall - at.velocity_at(at.place(point.local))).dot(point.normal);
    }
    for _ in 0..PASSES {
        for point in points.iter_mut() {
            let place = at.place(point.local);
            let mobility = at.mobility(place, place);
            let e = if point.approach > BOUNCES { point.restitution } else { 0.0 };
            let speed = (state.velocity_at(place) - point.wall).dot(point.normal);
            let push = (point.push + (e * point.approach - speed) / point.normal.dot(mobility * point.normal)).max(0.0);
            state = state.kicked(point.normal * (push - point.push), place);
            point.push = push;
            let slip = (state.velocity_at(place) - point.wall).reject_from_normalized(point.normal);
            let along = slip.normalize_or_zero();
            if along == DVec3::ZERO {
                continue;
            }
            let wanted = point.rub - slip / along.dot(mobility * along);
            let rub = wanted.clamp_length_max(point.friction * push);
            state = state.kicked(rub - point.rub, place);
            point.rub = rub;
        }
    }
    state
}
