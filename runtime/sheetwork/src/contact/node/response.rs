//! Response of one node to contact with a surface (thesis appendix B, with Coulomb friction).
//!
//! With n the outward normal and v the velocity relative to the body, an impact with v_n = v·n < 0
//! gives
//!
//!   v_n' = -e v_n,  |v_t'| = max(0, |v_t| - μ (1 + e) |v_n|),
//!
//! with e = 0 below `NodeContactSettings::restitution_speed`. A tangential velocity of 0 after
//! the impact is sticking.
//!
//! In a step that moves a node from x₀ to x₁ and its velocity from v₀ to v₁ through the surface,
//! the time of impact τ (fraction of the step) is where the straight path crosses it; the velocity
//! there is v₁ - a (1 - τ) dt with a = (v₁ - v₀)/dt. The acceleration a also acts for the remainder
//! of the step. Its normal part is removed if it presses into the surface, again with friction, and
//! the node moves as the integrator would move it: by its velocity and θ times the change of
//! velocity. A node at rest on a surface has τ = 0, so that one rule covers rebound, slip, stick
//! and rest. The error is of second order in the step.

use glam::DVec3;

use crate::contact::settings::{ContactSettings, NodeContactSettings};

const SETTINGS: NodeContactSettings = ContactSettings::DEFAULT.node;

/// Surface that a node meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeContactSurface {
    /// Point of the surface nearest to the end of the path, m.
    pub point: DVec3,
    /// Outward unit normal.
    pub normal: DVec3,
    /// Velocity of the surface at the point, m/s.
    pub velocity: DVec3,
    /// Friction coefficient of the pair.
    pub friction: f64,
    /// Coefficient of restitution of the pair.
    pub restitution: f64,
}

/// Path of a node over a step without contact, from (x0, v0) to (x1, v1) in `dt`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodePath {
    /// Position at the start, m.
    pub x0: DVec3,
    /// Velocity at the start, m/s.
    pub v0: DVec3,
    /// Position at the end, m.
    pub x1: DVec3,
    /// Velocity at the end, m/s.
    pub v1: DVec3,
    /// Length of the step, s.
    pub dt: f64,
    /// Weight θ of the acceleration in the integrator's displacement, Δx = v h + θ a h².
    pub drift: f64,
}

/// State of a node after contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeResponse {
    /// Position where the node met the surface, m.
    pub position_at_contact: DVec3,
    /// Velocity immediately after the contact, m/s.
    pub velocity_after_contact: DVec3,
    /// Position at the end of the step, m.
    pub x: DVec3,
    /// Velocity at the end of the step, m/s.
    pub v: DVec3,
    /// Approach speed of the impact, m/s; 0 for resting contact.
    pub impact: f64,
    /// Remaining time of the step after the contact, s.
    pub remaining_time: f64,
}

/// Return `v` with its length reduced by `amount` (m/s), at most to zero.
pub fn reduce_speed(v: DVec3, amount: f64) -> DVec3 {
    let speed = v.length();
    if speed <= amount { DVec3::ZERO } else { v * (1.0 - amount / speed) }
}

/// Time of impact of a path that ends behind `surface` at contact offset `skin` (m), as a fraction
/// of the step; 0 if the path starts behind it.
pub fn time_of_impact(flight: &NodePath, surface: &NodeContactSurface, skin: f64) -> f64 {
    // The surface moves with constant velocity; in its frame the path is a straight line.
    let start = (flight.x0 + surface.velocity * flight.dt - surface.point).dot(surface.normal) - skin;
    let end = (flight.x1 - surface.point).dot(surface.normal) - skin;
    if start > 0.0 { (start / (start - end)).clamp(0.0, 1.0) } else { 0.0 }
}

/// Compute the response of a node whose path ends behind `surface`; the node stays `skin` (m) in
/// front of it.
pub fn respond_to_surface(flight: &NodePath, surface: &NodeContactSurface, skin: f64) -> NodeResponse {
    let NodePath { x0, v0, x1, v1, dt, drift } = *flight;
    let n = surface.normal;
    let tau = time_of_impact(flight, surface, skin);
    let rest = (1.0 - tau) * dt;
    let acceleration = (v1 - v0) / dt;
    let arriving = v1 - surface.velocity - acceleration * rest;

    // Symplectic Euler schemes store velocities half a step off the path. An impact acts on the
    // velocity of the path.
    let shift = acceleration * ((drift - 0.5) * dt);
    let (mut leaving, impact) = impact_velocity(arriving + shift, surface);
    leaving = if impact > 0.0 { leaving - shift } else { impact_velocity(arriving, surface).0 };
    // The remainder of the step.
    let mut last = leaving + acceleration * rest;
    let pressing = last.dot(n);
    if pressing < 0.0 {
        last = reduce_speed(last - n * pressing, -surface.friction * pressing);
    }
    let touch = x0 + (x1 - x0) * tau;
    let on_path = if impact > 0.0 { shift } else { DVec3::ZERO };
    let weight = if impact > 0.0 { 0.5 } else { drift };
    let mut x = touch + (surface.velocity + leaving.lerp(last, weight) + on_path) * rest;
    let depth = skin - (x - surface.point).dot(n);
    if depth > 0.0 {
        x += n * depth;
    }
    NodeResponse {
        position_at_contact: touch,
        velocity_after_contact: leaving + surface.velocity,
        x,
        v: last + surface.velocity,
        impact,
        remaining_time: rest,
    }
}

/// Relative velocity after an impact, and its approach speed (m/s), 0 if it is below the
/// restitution threshold.
fn impact_velocity(v: DVec3, surface: &NodeContactSurface) -> (DVec3, f64) {
    let n = surface.normal;
    let approach = v.dot(n);
    if approach >= 0.0 {
        return (v, 0.0);
    }
    let is_impact = -approach > SETTINGS.restitution_speed;
    let e = if is_impact { surface.restitution } else { 0.0 };
    let impulse = -(1.0 + e) * approach;
    let along = reduce_speed(v - n * approach, surface.friction * impulse);
    (along - n * (e * approach), if is_impact { -approach } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: NodeContactSurface = NodeContactSurface {
        point: DVec3::ZERO,
        normal: DVec3::Y,
        velocity: DVec3::ZERO,
        friction: 0.3,
        restitution: 0.5,
    };

    #[test]
    fn an_impact_reverses_the_normal_and_slows_the_tangential_velocity() {
        let v = DVec3::new(4.0, -2.0, 0.0);
        let flight = NodePath { x0: DVec3::Y, v0: v, x1: DVec3::Y + v, v1: v, dt: 1.0, drift: 0.5 };
        let out = respond_to_surface(&flight, &FLOOR, 0.0);
        // Friction takes 0.3 · 1.5 · 2 from 4; half of the step remains after the impact.
        assert!(out.v.distance(DVec3::new(3.1, 1.0, 0.0)) < 1e-12, "{out:?}");
        assert!(out.x.distance(DVec3::new(2.0 + 1.55, 0.5, 0.0)) < 1e-12, "{out:?}");
        assert_eq!(out.impact, 2.0);
    }

    #[test]
    fn sticking_node_stays_exactly_in_place() {
        let g = DVec3::new(0.2, -1.0, 0.0);
        let flight = NodePath { x0: DVec3::ZERO, v0: DVec3::ZERO, x1: g * 0.005, v1: g * 0.1, dt: 0.1, drift: 0.5 };
        let out = respond_to_surface(&flight, &FLOOR, 0.0);
        assert_eq!((out.x, out.v), (DVec3::ZERO, DVec3::ZERO));
    }

    #[test]
    fn slipping_node_decelerates_by_friction_times_normal_acceleration() {
        let (g, dt) = (DVec3::new(0.0, -10.0, 0.0), 0.01);
        let v0 = DVec3::new(1.0, 0.0, 0.0);
        let flight =
            NodePath { x0: DVec3::ZERO, v0, x1: v0 * dt + g * (0.5 * dt * dt), v1: v0 + g * dt, dt, drift: 0.5 };
        let out = respond_to_surface(&flight, &FLOOR, 0.0);
        assert!((out.v.x - (1.0 - 0.3 * 10.0 * dt)).abs() < 1e-12);
        assert!((out.x.x - (dt - 0.5 * 3.0 * dt * dt)).abs() < 1e-12);
    }

    #[test]
    fn moving_surface_carries_a_sticking_node() {
        let belt = NodeContactSurface { velocity: DVec3::new(0.5, 0.0, 0.0), friction: 10.0, ..FLOOR };
        let (dt, g) = (0.01, DVec3::new(0.0, -10.0, 0.0));
        let v0 = belt.velocity;
        let flight =
            NodePath { x0: DVec3::ZERO, v0, x1: v0 * dt + g * (0.5 * dt * dt), v1: v0 + g * dt, dt, drift: 0.5 };
        let out = respond_to_surface(&flight, &belt, 0.0);
        assert!(out.v.distance(v0) < 1e-15 && out.x.distance(v0 * dt) < 1e-15, "{out:?}");
    }
}
