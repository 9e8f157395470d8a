//! Pyramid for the rigs. Lengths in m.

use glam::DVec3;

use crate::scene::Polyhedron;

/// Square pyramid on the plane y = 0, its tip above the middle of its base.
pub fn pyramid(base: f64, height: f64) -> Polyhedron {
    let half = 0.5 * base;
    let corners = [(-half, -half), (-half, half), (half, half), (half, -half)];
    let mut vertices: Vec<DVec3> = corners.iter().map(|(x, z)| DVec3::new(*x, 0.0, *z)).collect();
    vertices.push(DVec3::new(0.0, height, 0.0));
    let sides = (0..4).map(|i| vec![i, (i + 1) % 4, 4]);
    let faces = std::iter::once(vec![3, 2, 1, 0]).chain(sides).collect();
    Polyhedron { vertices, faces }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_pyramid_is_closed_and_a_third_of_its_box() {
        let pyramid = super::pyramid(0.02, 0.3);
        pyramid.check_closed().expect("closed");
        assert!((pyramid.volume() / (0.02 * 0.02 * 0.3 / 3.0) - 1.0).abs() < 1e-12);
    }
}
