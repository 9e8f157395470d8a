//! Stencils of the barrier method: pairs of features and their distance d, and the barrier b(d).
//!
//! With the sum of the half thicknesses a, the barrier acts below the distance a and is infinite at
//! ξ = (1 - δ) a, so that surfaces overlap by less than the fraction δ of it (Li et al.,
//! Incremental Potential Contact, 2020, with an offset as in Codimensional IPC, 2021):
//!
//!   s = (d - ξ)/(a - ξ),   b = -k (a - ξ)² (s - 1)² ln s   for 0 < s < 1, otherwise 0.
//!
//! d = |Σ w_i p_i| with the weights w of the closest points, which are constant in the
//! derivatives: ∇d = w_i n and ∇²b = b″ n nᵀ w_i w_j. Lengths in m, energies in J.

use glam::DVec3;

use crate::collision::geometry::{point_triangle, segment_segment};
use crate::contact::settings::{BarrierSettings, ContactSettings};

const SETTINGS: BarrierSettings = ContactSettings::DEFAULT.barrier;

/// Features of a stencil; the vertices are in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Features {
    /// A point and a triangle.
    PointTriangle,
    /// Two edges.
    Edges,
    /// A point and the plane through the second vertex; the third is a point along its normal.
    PointPlane,
}

/// A pair of features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stencil {
    pub features: Features,
    pub vertices: [u32; 4],
    /// Radius of the ball around the point, m; 0 otherwise.
    pub radius: f64,
    /// Sum of the half thicknesses, m.
    pub offset: f64,
    /// Distance at which the barrier is infinite, m; negative where the features start too near.
    pub limit: f64,
    pub friction: f64,
    /// Stiffness of the barrier, N/m; 0 for that of its vertices.
    pub stiffness: f64,
}

/// Closest points of a stencil.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closest {
    /// Distance, m.
    pub distance: f64,
    /// Unit vector from the second feature to the first.
    pub normal: DVec3,
    /// Weight of each vertex in the difference of the closest points.
    pub weights: [f64; 4],
}

impl Stencil {
    /// Closest points with vertices at `x`.
    pub fn closest(&self, x: [DVec3; 4]) -> Closest {
        let weights = match self.features {
            Features::PointTriangle => {
                let [a, b, c] = point_triangle(x[0], [x[1], x[2], x[3]]);
                [1.0, -a, -b, -c]
            }
            Features::Edges => {
                let (s, t) = segment_segment([x[0], x[1]], [x[2], x[3]]);
                [1.0 - s, s, t - 1.0, -t]
            }
            Features::PointPlane => {
                let normal = (x[2] - x[1]).normalize_or(DVec3::Y);
                let distance = normal.dot(x[0] - x[1]);
                return Closest { distance: distance - self.radius, normal, weights: [1.0, -1.0, 0.0, 0.0] };
            }
        };
        let between: DVec3 = x.iter().zip(weights).map(|(x, w)| *x * w).sum();
        let distance = between.length();
        let normal = between / distance.max(f64::MIN_POSITIVE);
        Closest { distance: distance - self.radius, normal, weights }
    }

    /// Value (J), first (N) and second derivative (N/m) of the barrier of stiffness `k` (N/m) at
    /// the distance `d` (m).
    pub fn barrier(&self, d: f64, k: f64) -> [f64; 3] {
        let range = self.offset - self.limit;
        let s = (d - self.limit) / range;
        if s >= 1.0 {
            return [0.0; 3];
        }
        if s <= 0.0 {
            return [f64::INFINITY; 3];
        }
        let (log, less) = (s.ln(), s - 1.0);
        let value = -k * range * range * less * less * log;
        let first = -k * range * (2.0 * less * log + less * less / s);
        [value, first, -k * (2.0 * log + 4.0 * less / s - (less / s) * (less / s))]
    }

    /// Fraction of the displacements `d` (m) from `x` for which the distance stays above its limit,
    /// by additive continuous collision detection (Li, Kaufman and Jiang, Codimensional IPC, 2021).
    pub fn free_fraction(&self, x: [DVec3; 4], d: [DVec3; 4]) -> f64 {
        let used = if self.features == Features::PointPlane { 2 } else { 4 };
        let mean = d[..used].iter().sum::<DVec3>() / used as f64;
        let d = d.map(|d| d - mean);
        let length = |i: usize| d[i].length();
        let speed = match self.features {
            Features::PointTriangle => length(0) + length(1).max(length(2)).max(length(3)),
            Features::Edges => length(0).max(length(1)) + length(2).max(length(3)),
            Features::PointPlane => length(0) + length(1),
        };
        let gap_at = |t: f64| self.closest([0, 1, 2, 3].map(|i| x[i] + d[i] * t)).distance - self.limit;
        let first = gap_at(0.0);
        let kept = SETTINGS.kept_gap * first;
        let (mut t, mut gap) = (0.0, first);
        for _ in 0..SETTINGS.maximum_advancements {
            let step = (if t > 0.0 { (1.0 - SETTINGS.kept_gap) * gap } else { gap - kept }) / speed;
            if step <= 0.0 || step.is_nan() {
                break;
            }
            if t + step >= 1.0 {
                return 1.0;
            }
            t += step;
            gap = gap_at(t);
            if gap <= kept {
                break;
            }
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point_over_triangle() -> (Stencil, [DVec3; 4]) {
        let stencil = Stencil {
            features: Features::PointTriangle,
            vertices: [0, 1, 2, 3],
            radius: 0.0,
            offset: 0.1,
            limit: 0.09,
            friction: 0.0,
            stiffness: 0.0,
        };
        (stencil, [DVec3::new(0.2, 0.5, 0.2), DVec3::ZERO, DVec3::X, DVec3::Z])
    }

    #[test]
    fn the_barrier_is_smooth_and_infinite_at_its_limit() {
        let (stencil, _) = point_over_triangle();
        for d in [0.091, 0.095, 0.0999] {
            let h = 1e-7;
            let [up, down] = [d + h, d - h].map(|d| stencil.barrier(d, 3.0));
            let [_, first, second] = stencil.barrier(d, 3.0);
            assert!(((up[0] - down[0]) / (2.0 * h) - first).abs() < 1e-5 * first.abs().max(1e-3), "{d}");
            assert!(((up[1] - down[1]) / (2.0 * h) - second).abs() < 1e-5 * second.abs(), "{d}");
            assert!(first < 0.0 && second > 0.0);
        }
        assert_eq!(stencil.barrier(0.1, 3.0), [0.0; 3]);
        assert_eq!(stencil.barrier(0.09, 3.0)[0], f64::INFINITY);
    }

    #[test]
    fn a_point_that_falls_on_a_triangle_stops_before_the_limit() {
        let (stencil, x) = point_over_triangle();
        let fall = [DVec3::NEG_Y, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO];
        let part = stencil.free_fraction(x, fall);
        assert!(part < 0.41 && part > 0.36, "{part}");
        assert_eq!(stencil.free_fraction(x, [DVec3::NEG_Y; 4]), 1.0);
        assert_eq!(stencil.free_fraction(x, fall.map(|d| -d)), 1.0);
    }

    #[test]
    fn crossed_edges_stop_before_the_limit() {
        let stencil = Stencil { features: Features::Edges, ..point_over_triangle().0 };
        let x = [DVec3::new(0.0, 0.3, -1.0), DVec3::new(0.0, 0.3, 1.0), DVec3::NEG_X, DVec3::X];
        let closest = stencil.closest(x);
        assert!((closest.distance - 0.3).abs() < 1e-15 && closest.normal.distance(DVec3::Y) < 1e-15);
        let part = stencil.free_fraction(x, [DVec3::NEG_Y, DVec3::NEG_Y, DVec3::ZERO, DVec3::ZERO]);
        assert!(part < 0.21 && part > 0.17, "{part}");
    }
}
