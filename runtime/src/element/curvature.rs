//! Curvatures of a plate as sums over masses: what a lattice of masses has to say to [`super::bending`].
//!
//! κ_a = Σ w x (+ Σ c t where an edge's slope is prescribed), a = uu, vv, 2uv; vectors, because x is. A group is where the
//! three are known together and stand for an area. Curvatures that nothing holds (across a free edge) are `relaxed`: they
//! take the value that costs least, which is the natural boundary condition. With B the matrix of these directions (columns)
//! and D the bending stiffness, the relaxed curvature is Q κ,
//!
//! Q = I - B (Bᵀ D B)⁻¹ Bᵀ D, and κᵀ Qᵀ D Q κ the energy that [`super::bending::condensed`] gives.

/// Curvatures at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvatureGroup {
    /// Stencil of each component (uu, vv, 2uv): masses and weights, 1/m²; empty for one that is not known here.
    pub rows: [Vec<(u32, f64)>; 3],
    /// What a prescribed edge slope adds to each component: number of the direction and weight, 1/m.
    pub clamps: [Vec<(u32, f64)>; 3],
    /// Area the group stands for, the clamp's factor included, m².
    pub area: f64,
    /// Directions (uu, vv, 2uv) of curvature that are free to adjust.
    pub relaxed: Vec<[f64; 3]>,
    /// Masses a, b, c, d whose differences give the normal of the upper side, (x_b - x_a) × (x_d - x_c).
    pub frame: [u32; 4],
    /// Number of the mass it is at; of a cell's twist of the cell's first mass; of a triangle its own.
    pub home: u32,
    /// Factor that each row has beyond the curvature that it is of.
    pub gain: [f64; 3],
    /// Length l over which each bends, m: a kink of the angle φ has the curvature 2 sin(φ/2)/l here, and is one of φ/l. 0 where a
    /// curvature is taken as it is.
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
    /// What component `a` is where the sheet bends by `angle` a length, 1/m, towards its upper side.
    pub fn of_angle(&self, a: usize, angle: f64) -> f64 {
        let l = self.span[a];
        let bent =
            if l > 0.0 { 2.0 / l * (0.5 * l * angle).clamp(-FLAT_ON_ITSELF, FLAT_ON_ITSELF).sin() } else { angle };
        self.gain[a] * bent
    }

    /// The angle a length, 1/m, by which the sheet bends towards its upper side where component `a` is `curvature`, 1/m.
    pub fn angle_of(&self, a: usize, curvature: f64) -> f64 {
        let (l, bent) = (self.span[a], curvature / self.gain[a]);
        if l > 0.0 { 2.0 / l * (0.5 * l * bent).clamp(-1.0, 1.0).asin() } else { bent }
    }
}

/// Half the largest angle between neighbouring parts of a sheet.
const FLAT_ON_ITSELF: f64 = std::f64::consts::FRAC_PI_2;

/// Q for bending stiffness `d` (N m) and the directions of curvature that are free to adjust.
pub fn relaxation(d: &[[f64; 3]; 3], relaxed: &[[f64; 3]]) -> [[f64; 3]; 3] {
    let mut q = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // One direction after the other, each made D-orthogonal to those before: the projections then multiply.
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
pub(super) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// m v.
#[inline]
pub(super) fn apply(m: &[[f64; 3]; 3], v: &[f64; 3]) -> [f64; 3] {
    [dot(&m[0], v), dot(&m[1], v), dot(&m[2], v)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::bending::condensed;

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
