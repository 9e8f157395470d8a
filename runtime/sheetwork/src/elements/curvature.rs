//! Curvatures of a plate as weighted sums over nodes: the input of [`crate::elements::bending`].
//!
//! κ_a = Σ w x (+ Σ c t for a prescribed edge slope), a = uu, vv, 2uv, is a vector because x is
//! one. A group holds the three components at one point and the area that the point represents.
//! Curvatures without a constraint (across a free edge) are `relaxed`: they minimise the energy,
//! which is the natural boundary condition. With B the matrix of the relaxed directions (columns)
//! and D the bending stiffness (N m), the relaxed curvature is Q κ,
//!
//! Q = I - B (Bᵀ D B)⁻¹ Bᵀ D, and κᵀ Qᵀ D Q κ is the energy of
//! [`crate::elements::bending::condensed`].

use std::f64::consts::FRAC_PI_4;

/// Curvatures at one point.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvatureGroup {
    /// Stencil of each component (uu, vv, 2uv): nodes and weights, 1/m²; empty for a component that
    /// is not evaluated at this point.
    pub rows: [Vec<(u32, f64)>; 3],
    /// Terms of prescribed edge slopes in each component: index of the direction and weight, 1/m.
    pub clamps: [Vec<(u32, f64)>; 3],
    /// Area that the group represents, m², including the area factor of a clamp.
    pub area: f64,
    /// Relaxed directions (uu, vv, 2uv) of curvature.
    pub relaxed: Vec<[f64; 3]>,
    /// Nodes a, b, c, d whose differences give the normal of the upper side,
    /// (x_b - x_a) × (x_d - x_c).
    pub frame: [u32; 4],
    /// Location: index of the node; for the twist of a cell, index of the cell's first node; for a
    /// triangle, index of the triangle.
    pub home: u32,
    /// Factor of each row in addition to the curvature.
    pub gain: [f64; 3],
    /// Length l over which each component bends, m: a kink of angle φ has curvature 2 sin(φ/2)/l in
    /// the stencil and φ/l as an angle per length. 0 for a component that needs no conversion.
    pub span: [f64; 3],
}

impl Default for CurvatureGroup {
    fn default() -> Self {
        Self {
            rows: Default::default(),
            clamps: Default::default(),
            area: 0.0,
            relaxed: Vec::new(),
            frame: [0; 4],
            home: 0,
            gain: [1.0; 3],
            span: [0.0; 3],
        }
    }
}

impl CurvatureGroup {
    /// Component `a` for a bend of `angle` per length (1/m) towards the upper side.
    pub fn curvature_from_angle(&self, a: usize, angle: f64) -> f64 {
        let l = self.span[a];
        let bent = if l > 0.0 {
            2.0 / l * (0.5 * l * angle).clamp(-MAXIMUM_HALF_ANGLE, MAXIMUM_HALF_ANGLE).sin()
        } else {
            angle
        };
        self.gain[a] * bent
    }

    /// Angle per length (1/m) towards the upper side for component `a` equal to `curvature` (1/m).
    pub fn angle_from_curvature(&self, a: usize, curvature: f64) -> f64 {
        let (l, bent) = (self.span[a], curvature / self.gain[a]);
        if l > 0.0 { 2.0 / l * (0.5 * l * bent).clamp(-1.0, 1.0).asin() } else { bent }
    }

    /// Rest strain o of component `a` at curvature `k` with rest curvature `rest`, 1/m, and its
    /// first and second derivatives with respect to `k`.
    ///
    /// With ψ the angle beyond that of rest, k - o is 2 sin(ψ/2)/l: the energy of a flat cell,
    /// turned to the angle of rest, with its stiffness D/l. Beyond ψ = π/2 the moment stays.
    pub fn rest_strain(&self, a: usize, k: f64, rest: f64) -> [f64; 3] {
        let r = 0.5 * self.span[a] / self.gain[a];
        if rest == 0.0 || r == 0.0 {
            return [rest, 0.0, 0.0];
        }
        let s = (r * k).clamp(-MAXIMUM_SINE, MAXIMUM_SINE);
        let c = (1.0 - s * s).sqrt();
        let half = s.asin() - (r * rest).clamp(-1.0, 1.0).asin();
        let [e, slope, bend] = if half.abs() <= FRAC_PI_4 {
            [half.sin(), half.cos(), -half.sin()]
        } else {
            let e = (0.5 + half.abs() - FRAC_PI_4).sqrt().copysign(half);
            [e, 0.5 / e.abs(), -0.25 / (e * e * e)]
        };
        let beyond = k - s / r;
        let second = if r * k == s { r * (bend / (c * c) + slope * s / (c * c * c)) } else { 0.0 };
        [k - e / r - slope / c * beyond, 1.0 - slope / c, -second]
    }
}

/// Sine of half of the angle between neighbouring parts (177°) beyond which their moment arm at
/// the nodes vanishes and the strain continues linearly.
const MAXIMUM_SINE: f64 = 0.9997;
/// Half of the largest angle between neighbouring parts of a sheet (folded flat), rad.
const MAXIMUM_HALF_ANGLE: f64 = std::f64::consts::FRAC_PI_2;

/// Q for bending stiffness `d` (N m) and the relaxed directions.
pub fn relaxation(d: &[[f64; 3]; 3], relaxed: &[[f64; 3]]) -> [[f64; 3]; 3] {
    let mut q = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Each direction is made D-orthogonal to the earlier ones: the projections then multiply.
    for direction in relaxed {
        let b = apply(&q, direction);
        let db = apply(d, &b);
        let stiffness = dot(&b, &db);
        if stiffness <= 1e-12 * dot(direction, &apply(d, direction)) || stiffness <= 0.0 {
            continue;
        }
        // (I - b (Db)ᵀ / bᵀDb) Q; D is symmetric.
        let row: [f64; 3] = std::array::from_fn(|j| (0..3).map(|i| db[i] * q[i][j]).sum::<f64>() / stiffness);
        for i in 0..3 {
            for j in 0..3 {
                q[i][j] -= b[i] * row[j];
            }
        }
    }
    q
}

/// a · b.
#[inline]
pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// m v.
#[inline]
pub(crate) fn apply(m: &[[f64; 3]; 3], v: &[f64; 3]) -> [f64; 3] {
    [dot(&m[0], v), dot(&m[1], v), dot(&m[2], v)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::bending::condensed;

    #[test]
    fn the_relaxed_curvature_has_the_condensed_energy() {
        let d = [[1.1, 0.3, 0.05], [0.3, 0.7, -0.02], [0.05, -0.02, 0.4]];
        let directions = [[0.0, 1.0, 0.0], [2.0, 1.0, 0.0], [0.3, 0.1, 1.0], [0.0, 3.0, 0.0]];
        for count in 0..=directions.len() {
            let q = relaxation(&d, &directions[..count]);
            let wanted = condensed(d, &directions[..count]);
            let column = |j: usize| [q[0][j], q[1][j], q[2][j]];
            for i in 0..3 {
                for j in 0..3 {
                    let got = dot(&column(i), &apply(&d, &column(j)));
                    assert!((got - wanted[i][j]).abs() < 1e-12, "{count}: {got}, not {}", wanted[i][j]);
                }
            }
            for b in &directions[..count] {
                assert!(apply(&q, b).iter().all(|v| v.abs() < 1e-12), "what is free to adjust is adjusted away");
            }
        }
    }
}
