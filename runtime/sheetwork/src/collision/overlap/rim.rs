//! The solid of a sheet within itself: its rim is flat, so that the two sides of a cut lie side by
//! side. It contains the surface whose border is moved inward by half the thickness, with a round
//! rim, and two rims that touch are then a thickness apart.
//!
//! A node between two border edges with inward normals m_1 and m_2 moves by
//!
//!   d = 2 h (m_1 + m_2) / |m_1 + m_2|²,   d·m_1 = d·m_2 = h,
//!
//! with h half the thickness; at the tip of a cut, where the normals are opposed, by at most 2 h.

use glam::DVec3;

use crate::collision::collision_surface::CollisionSurface;
use crate::math::Vectors;

/// Move the border of a surface with the nodes at `x` (m) inward by `by` (m). `sums` is a buffer.
pub fn inset_border(surface: &CollisionSurface, x: &mut Vectors, sums: &mut Vec<DVec3>, by: f64) {
    sums.clear();
    sums.resize(x.len(), DVec3::ZERO);
    for edge in surface.edges().iter().filter(|edge| edge.is_border()) {
        let Some(triangle) = surface.triangles().get(edge.triangles[0] as usize) else { continue };
        let [a, b] = edge.nodes.map(|i| x.get(i as usize));
        let inner = triangle.nodes.map(|i| x.get(i as usize)).into_iter().sum::<DVec3>() - a - b;
        let along = (b - a).normalize_or_zero();
        let inward = (inner - a).reject_from_normalized(along).normalize_or_zero();
        edge.nodes.iter().for_each(|i| sums[*i as usize] += inward);
    }
    for (i, sum) in sums.iter().enumerate().filter(|(_, sum)| **sum != DVec3::ZERO) {
        let length = 2.0 * by / sum.length();
        x.set(i, x.get(i) + sum.normalize() * length.min(2.0 * by));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_border_of_a_square_moves_inward() {
        let mut x = Vectors::default();
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.5, 0.5)] {
            x.push(DVec3::new(u, 0.0, v));
        }
        let triangles = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        let surface = CollisionSurface::new(&triangles, &x, 0.0, false);
        inset_border(&surface, &mut x, &mut Vec::new(), 0.1);
        assert!(x.get(0).distance(DVec3::new(0.1, 0.0, 0.1)) < 1e-15);
        assert!(x.get(2).distance(DVec3::new(0.9, 0.0, 0.9)) < 1e-15);
        assert_eq!(x.get(4), DVec3::new(0.5, 0.0, 0.5));
    }
}
