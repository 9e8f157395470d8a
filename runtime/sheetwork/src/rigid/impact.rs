//! Impact of a dynamic body with static and kinematic ones: velocities after restitution.
//!
//! Rapier applies restitution to the points of a contact one after the other and once, so that a
//! box that lands flat rotates and leaves too slowly. Here every point with the approach speed v
//! leaves with at least e v, with Coulomb friction at each, solved together by projected
//! Gauss-Seidel. A result that would gain energy is discarded in favour of Rapier's.

use glam::DVec3;

use crate::rigid::RigidWorld;
use crate::rigid::settings::{ImpactSettings, RigidSettings};
use crate::rigid::state::BodyState;

const SETTINGS: ImpactSettings = RigidSettings::DEFAULT.impact;
const RIGID: RigidSettings = RigidSettings::DEFAULT;

/// A contact point of an impact.
#[derive(Clone, Copy, Default)]
struct ImpactPoint {
    /// Position in the frame of the body, m.
    local: DVec3,
    /// Unit normal from the obstacle to the body.
    normal: DVec3,
    /// Velocity of the obstacle at the point, m/s.
    obstacle_velocity: DVec3,
    /// Gap, m, and approach speed, m/s.
    gap: f64,
    approach: f64,
    friction: f64,
    restitution: f64,
    /// Accumulated normal and friction impulses, N s.
    normal_impulse: f64,
    friction_impulse: DVec3,
}

impl RigidWorld {
    /// State of body `index` at the end of a substep of `part` s in which only static and kinematic
    /// bodies pushed it, after an impact; `None` if no point bounces.
    pub(crate) fn state_after_impact(&self, index: usize, part: f64, g: DVec3) -> Option<BodyState> {
        let from = self.motions[index].substep_start;
        let mut points = [ImpactPoint::default(); SETTINGS.maximum_points];
        let mut count = 0;
        self.for_each_impact_point(index, |point| {
            // Points in contact already are included with those that strike.
            let reached =
                (point.approach * part).max(SETTINGS.touch_fraction * f64::from(self.owners.contact_distance));
            if point.gap <= reached && count < SETTINGS.maximum_points {
                points[count] = point;
                count += 1;
            }
        });
        let points = &mut points[..count];
        if !points.iter().any(|p| p.restitution > 0.0 && p.approach > RIGID.restitution_speed) {
            return None;
        }
        let strike = points.iter().filter(|p| p.approach > RIGID.restitution_speed);
        let time = strike.map(|p| p.gap.max(0.0) / p.approach).fold(part, f64::min);
        let there = from.free_flight(time, g);
        let after = solve_impact(&there, points);
        (after.kinetic_energy() <= there.kinetic_energy() * (1.0 + 1e-9)).then(|| after.free_flight(part - time, g))
    }

    /// Call `with` for each contact of body `index` with a static or kinematic body that Rapier
    /// detected at the start of the substep.
    fn for_each_impact_point(&self, index: usize, mut with: impl FnMut(ImpactPoint)) {
        let from = &self.motions[index].substep_start;
        for pair in self.bodies[index].colliders.iter().flat_map(|c| self.inner.narrow_phase.contact_pairs_with(*c)) {
            let (Some(first), Some(second)) =
                (self.owners.body_of(pair.collider1), self.owners.body_of(pair.collider2))
            else {
                continue;
            };
            let over = &self.motions[if first == index { second } else { first }];
            let side = if first == index { -1.0 } else { 1.0 };
            for manifold in pair.solver_manifolds() {
                let normal = manifold.data.normal.as_dvec3().normalize_or_zero() * side;
                for point in manifold.points.iter().filter(|p| p.dist <= self.owners.contact_distance) {
                    let local = if first == index { point.local_p1 } else { point.local_p2 }.as_dvec3();
                    let place = from.world_point(local);
                    let wall = over.start.velocity_at(place);
                    let approach = -(from.velocity_at(place) - wall).dot(normal);
                    if normal != DVec3::ZERO {
                        let friction = f64::from(manifold.data.friction);
                        let restitution = f64::from(manifold.data.restitution);
                        let gap = f64::from(point.dist);
                        with(ImpactPoint {
                            local,
                            normal,
                            obstacle_velocity: wall,
                            gap,
                            approach,
                            friction,
                            restitution,
                            ..ImpactPoint::default()
                        });
                    }
                }
            }
        }
    }
}

/// State of the body `at` after the simultaneous impact at all `points`.
fn solve_impact(at: &BodyState, points: &mut [ImpactPoint]) -> BodyState {
    let mut state = *at;
    for point in points.iter_mut() {
        point.approach = (point.obstacle_velocity - at.velocity_at(at.world_point(point.local))).dot(point.normal);
    }
    for _ in 0..SETTINGS.maximum_sweeps {
        for point in points.iter_mut() {
            let place = at.world_point(point.local);
            let mobility = at.mobility(place, place);
            let e = if point.approach > RIGID.restitution_speed { point.restitution } else { 0.0 };
            let speed = (state.velocity_at(place) - point.obstacle_velocity).dot(point.normal);
            let push = (point.normal_impulse
                + (e * point.approach - speed) / point.normal.dot(mobility * point.normal))
            .max(0.0);
            state = state.with_impulse_at(point.normal * (push - point.normal_impulse), place);
            point.normal_impulse = push;
            let slip = (state.velocity_at(place) - point.obstacle_velocity).reject_from_normalized(point.normal);
            let along = slip.normalize_or_zero();
            if along == DVec3::ZERO {
                continue;
            }
            let wanted = point.friction_impulse - slip / along.dot(mobility * along);
            let rub = wanted.clamp_length_max(point.friction * push);
            state = state.with_impulse_at(rub - point.friction_impulse, place);
            point.friction_impulse = rub;
        }
    }
    state
}
