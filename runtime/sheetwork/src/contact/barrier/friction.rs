//! Friction of the barrier method: a dissipative potential of the normal forces λ that the
//! solution without friction has.
//!
//! With the tangential displacement u_t since the start of the substep and the width ε (Li et al.,
//! Incremental Potential Contact, 2020, section 5):
//!
//!   D = μ λ f(|u_t|),   f′(y) = 2y/ε - y²/ε² for y < ε, otherwise 1.

use glam::{DMat3, DVec3};

use crate::contact::IslandView;
use crate::contact::barrier::terms::outer;
use crate::contact::barrier::{BarrierSolver, PairFriction};
use crate::contact::settings::{BarrierSettings, ContactSettings};

const SETTINGS: BarrierSettings = ContactSettings::DEFAULT.barrier;

/// Friction of one stencil.
pub(super) struct Friction {
    pub vertices: [u32; 4],
    pub weights: [f64; 4],
    normal: DVec3,
    /// Bound μ λ, N.
    bound: f64,
    /// ε, m.
    width: f64,
}

impl Friction {
    fn along(&self, slip: DVec3) -> DVec3 {
        slip - self.normal * slip.dot(self.normal)
    }

    /// D (J) at the displacement `slip` (m).
    pub fn value(&self, slip: DVec3) -> f64 {
        let (y, e) = (self.along(slip).length(), self.width);
        self.bound * if y < e { y * y / e - y * y * y / (3.0 * e * e) } else { y - e / 3.0 }
    }

    /// Gradient (N) and positive semidefinite second derivative (N/m) of D.
    pub fn derivatives(&self, slip: DVec3) -> (DVec3, DMat3) {
        let along = self.along(slip);
        let (y, e) = (along.length(), self.width);
        // f′/y and f″.
        let (over, second) = if y < e { (2.0 / e - y / (e * e), 2.0 / e - 2.0 * y / (e * e)) } else { (1.0 / y, 0.0) };
        let u = along.normalize_or_zero();
        let plane = DMat3::IDENTITY - outer(self.normal, self.normal);
        (along * (self.bound * over), (plane * over + outer(u, u) * (second - over)) * self.bound)
    }
}

impl BarrierSolver {
    /// Tangential and normal displacement of a stencil's points since the start, m.
    pub(super) fn slip(&self, friction: &Friction) -> DVec3 {
        let moved = |i: u32| self.surfaces.x[i as usize] - self.surfaces.start[i as usize];
        friction.vertices.iter().zip(friction.weights).map(|(i, w)| moved(*i) * w).sum()
    }

    /// Add friction with the present normal forces, in a substep of `h` (s). Returns whether there
    /// is any.
    pub(super) fn begin_friction(&mut self, island: &IslandView, friction: PairFriction, h: f64) -> bool {
        self.find_active(island, friction);
        let mut found = std::mem::take(&mut self.friction);
        found.clear();
        for stencil in self.active.iter().filter(|stencil| stencil.friction > 0.0) {
            let closest = stencil.closest(self.corners(stencil));
            let [_, first, _] = stencil.barrier(closest.distance, self.stiffness(stencil).unwrap_or(0.0));
            if first < 0.0 && first.is_finite() {
                found.push(Friction {
                    vertices: stencil.vertices,
                    weights: closest.weights,
                    normal: closest.normal,
                    bound: stencil.friction * -first,
                    width: SETTINGS.slip_speed * h,
                });
            }
        }
        self.friction = found;
        !self.friction.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_is_the_gradient_of_its_potential_and_at_most_its_bound() {
        let friction = Friction { vertices: [0; 4], weights: [0.0; 4], normal: DVec3::Y, bound: 3.0, width: 1e-3 };
        for slip in [DVec3::new(2e-4, 5.0, 1e-4), DVec3::new(5e-3, 0.0, -1e-3)] {
            let (gradient, _) = friction.derivatives(slip);
            for axis in [DVec3::X, DVec3::Z] {
                let h = 1e-8;
                let slope = (friction.value(slip + axis * h) - friction.value(slip - axis * h)) / (2.0 * h);
                assert!((slope - gradient.dot(axis)).abs() < 1e-4, "{slope} {gradient}");
            }
            assert!(gradient.length() <= 3.0 + 1e-12 && gradient.y.abs() < 1e-12);
        }
    }
}
