//! Thin plate in a stream: normal force and centre of pressure at every incidence.
//!
//! Rayleigh's plate in separated flow ("On the resistance of fluids", Phil. Mag. 1876; Lamb,
//! *Hydrodynamics*, §77) has the normal force coefficient C_N = 2π sin α/(4 + π sin α) and
//! its centre of pressure ahead of the middle by x_p/c = 3/4 cos α/(4 + π sin α), with the
//! chord c. Its slope π/2 at α = 0 belongs to an aspect ratio Λ of about 1, and its 0.88 at
//! 90° to a plate of infinite span without the suction behind it. The law here has the same form
//! with measured ends,
//!
//!   C_N = a sin α/(1 + κ sin α),  κ = a/C_n - 1,  x_p/c = 3/16 cos α/(1 + π/4 sin α),
//!
//! with Helmbold's lift slope a = 2πΛ/(2 + √(4 + Λ²)) (Schlichting and Truckenbrodt,
//! *Aerodynamik des Flugzeuges*) and the drag coefficient C_n across the stream. It equals
//! Rayleigh's for a = π/2 and C_n = 2π/(4 + π). There is no suction at a sharp leading edge, so
//! the drag at the incidence α is C_N sin α besides friction. The abrupt stall of a wide wing is
//! not modelled.
//!
//! Incidence is that of each node, so that rotation damps itself and a bent sheet has its camber.
//! Chord, span and centre of pressure are those of the whole sheet, from the second moments of its
//! area: c = √(12 <s²>) along the stream. The pressure on a node at s ahead of the centroid is
//! weighted by 1 + s x_p/<s²>, at least 0, which puts its resultant at x_p.

use glam::{DMat3, DVec3};

use crate::math::Vectors;

/// Centre of pressure at small incidence, in chords ahead of the middle.
const CENTRE: f64 = 3.0 / 16.0;

/// Flow past a whole sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlateFlow {
    /// Lift slope a, per radian.
    slope: f64,
    /// κ.
    fullness: f64,
    /// Centroid, m.
    centroid: DVec3,
    /// Gradient of the pressure weight, 1/m.
    gradient: DVec3,
}

impl PlateFlow {
    /// Flow past a sheet with the area vectors `areas` (m²) of its nodes at `x` (m), which move at
    /// `relative` (m/s) through the air, with the coefficient `across` at 90°.
    pub fn new(areas: &[DVec3], x: &Vectors, relative: impl Fn(usize) -> DVec3, across: f64) -> Self {
        let (mut area, mut normal, mut centroid, mut velocity) = (0.0, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for (i, vector) in areas.iter().enumerate() {
            let size = vector.length();
            area += size;
            normal += *vector;
            centroid += x.get(i) * size;
            velocity += relative(i) * size;
        }
        let still = Self { slope: 0.0, fullness: 0.0, centroid: DVec3::ZERO, gradient: DVec3::ZERO };
        if area <= 0.0 || across <= 0.0 {
            return still;
        }
        (centroid, velocity) = (centroid / area, velocity / area);
        let mut moment = DMat3::ZERO;
        for (i, vector) in areas.iter().enumerate() {
            let from = x.get(i) - centroid;
            let weighted = from * (vector.length() / area);
            moment += DMat3::from_cols(weighted * from.x, weighted * from.y, weighted * from.z);
        }
        let normal = normal.normalize_or_zero();
        let along = velocity - normal * velocity.dot(normal);
        let stream = if along == DVec3::ZERO { normal.any_orthonormal_vector() } else { along.normalize() };
        let aside = normal.cross(stream);
        let squared = stream.dot(moment * stream);
        let (chord, span) = ((12.0 * squared).sqrt(), (12.0 * aside.dot(moment * aside)).sqrt());
        if !(chord > 0.0 && span > 0.0 && velocity.is_finite()) {
            return still;
        }
        let ratio = span * span / area;
        let slope = std::f64::consts::TAU * ratio / (2.0 + (4.0 + ratio * ratio).sqrt());
        let speed = velocity.length().max(f64::MIN_POSITIVE);
        let (cosine, sine) = (along.length() / speed, velocity.dot(normal).abs() / speed);
        let centre = CENTRE * chord * cosine / (1.0 + std::f64::consts::FRAC_PI_4 * sine);
        Self { slope, fullness: slope / across - 1.0, centroid, gradient: stream * (centre / squared) }
    }

    /// Factor of the normal velocity in the normal force of a node at `x` (m), without ½ ρ A, at
    /// the relative speed `speed` and normal velocity `normal` (m/s).
    pub fn factor(&self, x: DVec3, speed: f64, normal: f64) -> f64 {
        let weight = (1.0 + (x - self.centroid).dot(self.gradient)).max(0.0);
        let whole = speed + self.fullness * normal.abs();
        if whole > 0.0 { weight * self.slope * speed * speed / whole } else { 0.0 }
    }
}
