//! Curvature of a part of a sheet as a linear operator on its masses: what the bending element is built from.
//!
//! Components are (uu, vv, 2uv), the last with the engineering factor: κ = (x_uu, x_vv, 2 x_uv), vectors in the world, 1/m.
//! A group's energy is ½ A κᵀ D' κ with its area A (m²) and D' = Qᵀ D Q, the bending stiffness D (N m) condensed over the
//! directions of curvature that nothing prescribes. With B the matrix of these directions (columns),
//!
//! Q = I - B (Bᵀ D B)⁻¹ Bᵀ D,
//!
//! so that the free directions take the values of least energy (static condensation).

/// A part of the sheet whose curvature is known, and how.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurvatureGroup {
    /// Stencil of each of the three components (uu, vv, 2uv): masses and weights, 1/m².
    pub rows: [Vec<(u32, f64)>; 3],
    /// What prescribed tangents add to each component: (index of the clamp direction, weight in 1/m).
    pub clamps: [Vec<(u32, f64)>; 3],
    /// Area that the group stands for, the factor of a clamp included, m².
    pub area: f64,
    /// Directions of curvature (uu, vv, 2uv) that are free to adjust.
    pub relaxed: Vec<[f64; 3]>,
    /// Four masses a, b, c, d whose differences (b - a) x (d - c) point along the normal, u to v by the right hand.
    pub frame: [u32; 4],
}

/// Q for stiffness `d` (N m) and the directions of curvature that are free to adjust.
pub fn relaxation(d: &[[f64; 3]; 3], relaxed: &[[f64; 3]]) -> [[f64; 3]; 3] {
    let mut q = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // One direction after the other, each made D-orthogonal to those before: the projections then multiply.
    for direction in relaxed {
        let b = apply(&q, direction);
        let db = apply(d, &b);
        let stiffness = dot(&b, &db);
        let scale = dot(direction, &apply(d, direction));
        if stiffness <= 1e-12 * scale || stiffness <= 0.0 {
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

/// D' = Qᵀ D Q.
pub fn condensed(d: &[[f64; 3]; 3], relaxed: &[[f64; 3]]) -> [[f64; 3]; 3] {
    if relaxed.is_empty() {
        return *d;
    }
    let q = relaxation(d, relaxed);
    let column = |m: &[[f64; 3]; 3], j: usize| [m[0][j], m[1][j], m[2][j]];
    let dq: [[f64; 3]; 3] = std::array::from_fn(|j| apply(d, &column(&q, j)));
    let value = |i: usize, j: usize| dot(&column(&q, i), &dq[j]);
    // The mean of both halves: symmetric to the bit.
    std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (value(i, j) + value(j, i))))
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn apply(m: &[[f64; 3]; 3], v: &[f64; 3]) -> [f64; 3] {
    [dot(&m[0], v), dot(&m[1], v), dot(&m[2], v)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) {
        for (a, b) in a.as_flattened().iter().zip(b.as_flattened()) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn a_free_direction_leaves_the_beam() {
        let nu = 0.3;
        let plate = [[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]];
        close(condensed(&plate, &[]), plate);
        // κ_vv free: what bends along u is a beam, D (1 - ν²), and twist is untouched.
        let beam = [[1.0 - nu * nu, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.35]];
        close(condensed(&plate, &[[0.0, 1.0, 0.0]]), beam);
        let twist = [[0.0; 3], [0.0; 3], [0.0, 0.0, 0.35]];
        close(condensed(&plate, &[[0.0, 1.0, 0.0], [2.0, 1.0, 0.0]]), twist);
        close(condensed(&plate, &[[0.0, 1.0, 0.0], [2.0, 1.0, 0.0], [0.3, 0.1, 1.0]]), [[0.0; 3]; 3]);
        // The same direction twice is one.
        close(condensed(&plate, &[[0.0, 1.0, 0.0], [0.0, 3.0, 0.0]]), beam);
    }
}
