//! Exact overlap of a triangle of a sheet with a simple convex body, as a measure independent of
//! contact.
//!
//! The overlap of a triangle and a convex body is the length of the shortest separating
//! translation. For polyhedra its direction is a face normal of the body, the normal of the
//! triangle, or the cross product of two edges (Gottschalk, Lin and Manocha, OBBTree, 1996, for
//! boxes; the same axes suffice for any two convex polyhedra). For separate solids it is the
//! negative distance. The tip of a needle that pierces a sheet counts by the length that stands
//! out, however slender the needle is. Lengths in m.

use glam::DVec3;

use crate::collision::overlap::distance::{point_triangle, segments};
use crate::scene::{Polyhedron, Shape};

/// A convex body in its own frame.
pub enum OverlapSolid {
    /// The half space y < 0.
    HalfSpace,
    /// A ball of this radius about the origin, m.
    Ball(f64),
    /// A convex polyhedron.
    Convex(ConvexSolid),
}

/// A convex polyhedron: face planes n·p = d, corners, edges, and faces as triangles.
pub struct ConvexSolid {
    planes: Vec<(DVec3, f64)>,
    corners: Vec<DVec3>,
    edges: Vec<[DVec3; 2]>,
    triangles: Vec<[DVec3; 3]>,
}

impl OverlapSolid {
    /// Solid of a scene's shape; `None` for shapes read from a file.
    pub fn from_shape(shape: &Shape) -> Option<Self> {
        match shape {
            Shape::HalfSpace => Some(Self::HalfSpace),
            Shape::Ball(radius) => Some(Self::Ball(*radius)),
            Shape::Box(size) => Some(Self::Convex(ConvexSolid::new(&Polyhedron::cuboid(*size)))),
            Shape::Polyhedron(polyhedron) => Some(Self::Convex(ConvexSolid::new(polyhedron))),
            Shape::File(_) | Shape::Part(..) => None,
        }
    }

    /// Depth of a point, m; the negative distance outside.
    pub fn depth(&self, p: DVec3) -> f64 {
        match self {
            Self::HalfSpace => -p.y,
            Self::Ball(radius) => radius - p.length(),
            Self::Convex(convex) => convex.depth(p),
        }
    }

    /// Whether the path from `a` to `b`, which may deviate by `bend` (m) from the straight line,
    /// leads through the core. The core of a polyhedron has its faces moved inward by a quarter of
    /// the least width plus `bend`, at most by a quarter of the width along their normal, so that a
    /// path around the rim of a plate does not count. The core of a ball has half the radius; that
    /// of a half space begins 0.01 m below its surface.
    pub fn crossed(&self, a: DVec3, b: DVec3, bend: f64) -> bool {
        match self {
            Self::HalfSpace => b.y < -0.01,
            Self::Ball(radius) => segments([a, b], [DVec3::ZERO; 2]) < 0.5 * radius,
            Self::Convex(convex) => convex.crossed(a, b, bend),
        }
    }

    /// Overlap with a triangle, m; negative for separate solids. Exact down to -`reach`, and any
    /// value below it beyond.
    pub fn overlap(&self, triangle: &[DVec3; 3], reach: f64) -> f64 {
        match self {
            Self::HalfSpace => triangle.iter().map(|p| -p.y).fold(f64::NEG_INFINITY, f64::max),
            Self::Ball(radius) => radius - point_triangle(DVec3::ZERO, *triangle),
            Self::Convex(convex) => convex.overlap(triangle, reach),
        }
    }
}

/// Least and greatest component of points along a direction.
fn span<'a>(points: impl IntoIterator<Item = &'a DVec3>, along: DVec3) -> (f64, f64) {
    points.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
        let at = p.dot(along);
        (low.min(at), high.max(at))
    })
}

impl ConvexSolid {
    /// Solid of a polyhedron, which must be convex.
    pub fn new(polyhedron: &Polyhedron) -> Self {
        let mut edges: Vec<(u32, u32)> = Vec::new();
        let (mut planes, mut triangles) = (Vec::new(), Vec::new());
        for (index, face) in polyhedron.faces.iter().enumerate() {
            let corners = polyhedron.corners(index);
            let normal = polyhedron.face_normal(index);
            if let Some(first) = corners.first() {
                planes.push((normal, normal.dot(*first)));
                triangles.extend(corners.windows(2).skip(1).map(|pair| [*first, pair[0], pair[1]]));
            }
            edges.extend(face.iter().zip(face.iter().cycle().skip(1)).filter(|(a, b)| a < b).map(|(a, b)| (*a, *b)));
        }
        let corner = |i: u32| polyhedron.vertices.get(i as usize).copied().unwrap_or_default();
        let edges = edges.into_iter().map(|(a, b)| [corner(a), corner(b)]).collect();
        Self { planes, corners: polyhedron.vertices.clone(), edges, triangles }
    }

    fn depth(&self, p: DVec3) -> f64 {
        let height = self.planes.iter().map(|(n, d)| n.dot(p) - d).fold(f64::NEG_INFINITY, f64::max);
        if height <= 0.0 {
            return -height;
        }
        -self.triangles.iter().map(|t| point_triangle(p, *t)).fold(f64::INFINITY, f64::min)
    }

    fn crossed(&self, a: DVec3, b: DVec3, bend: f64) -> bool {
        let width = |n: DVec3| {
            let (low, high) = span(&self.corners, n);
            high - low
        };
        let least = self.planes.iter().map(|(n, _)| width(*n)).fold(f64::INFINITY, f64::min);
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (n, d) in &self.planes {
            let inset = (0.25 * least + bend).min(0.25 * width(*n));
            let (from, to) = (n.dot(a) - d + inset, n.dot(b) - d + inset);
            if from > 0.0 && to > 0.0 {
                return false;
            }
            if from > 0.0 {
                enter = enter.max(from / (from - to));
            } else if to > 0.0 {
                leave = leave.min(from / (from - to));
            }
        }
        enter <= leave
    }

    fn overlap(&self, triangle: &[DVec3; 3], reach: f64) -> f64 {
        let apart = |(n, d): &(DVec3, f64)| span(triangle, *n).0 - d;
        let gap = self.planes.iter().map(apart).fold(f64::NEG_INFINITY, f64::max);
        if gap > reach {
            return -gap;
        }
        let gap = self.other_axes(triangle).fold(gap, f64::max);
        if gap <= 0.0 || gap > reach {
            return -gap;
        }
        -self.distance(triangle)
    }

    /// Gaps along the normal of the triangle and the cross products of edges, m; negative for
    /// overlap.
    fn other_axes(&self, triangle: &[DVec3; 3]) -> impl Iterator<Item = f64> + '_ {
        let triangle = *triangle;
        let sides = [triangle[1] - triangle[0], triangle[2] - triangle[1], triangle[0] - triangle[2]];
        let crosses = self.edges.iter().flat_map(move |[a, b]| {
            let edge = *b - *a;
            sides.map(|side| {
                let cross = edge.cross(side);
                // Nearly parallel edges define no axis.
                if cross.length() > 1e-6 * edge.length() * side.length() { cross.normalize() } else { DVec3::ZERO }
            })
        });
        let normal = sides[0].cross(sides[1]).normalize_or_zero();
        std::iter::once(normal).chain(crosses).filter(|axis| *axis != DVec3::ZERO).map(move |axis| {
            let (low, high) = span(&self.corners, axis);
            let (from, to) = span(&triangle, axis);
            (from - high).max(low - to)
        })
    }

    /// Distance from a triangle outside, m.
    fn distance(&self, triangle: &[DVec3; 3]) -> f64 {
        let sides = [[triangle[0], triangle[1]], [triangle[1], triangle[2]], [triangle[2], triangle[0]]];
        let faces = self.triangles.iter().flat_map(|face| triangle.map(|p| point_triangle(p, *face)));
        let corners = self.corners.iter().map(|p| point_triangle(*p, *triangle));
        let edges = self.edges.iter().flat_map(|edge| sides.map(|side| segments(*edge, side)));
        faces.chain(corners).chain(edges).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> OverlapSolid {
        OverlapSolid::Convex(ConvexSolid::new(&Polyhedron::cuboid(DVec3::splat(2.0))))
    }

    #[test]
    fn a_triangle_in_a_cube_is_as_deep_as_the_shortest_way_out() {
        let lying = [DVec3::new(-0.5, 0.99, -0.5), DVec3::new(0.5, 0.99, -0.5), DVec3::new(0.0, 0.99, 0.5)];
        let check = |triangle: [DVec3; 3], wanted: f64| {
            let found = cube().overlap(&triangle, 10.0);
            assert!((found - wanted).abs() < 1e-12, "{triangle:?}: {found}, {wanted}");
        };
        check(lying, 0.01);
        check(lying.map(|p| p + DVec3::Y * 0.03), -0.02);
        // Diagonally beside an edge.
        check(lying.map(|p| p + DVec3::new(1.53, 0.05, 0.0)), -(0.03_f64.powi(2) + 0.04_f64.powi(2)).sqrt());
        // A wide triangle through which the corner (1, 1, 1) protrudes by 0.02.
        let diagonal = DVec3::ONE.normalize();
        let (u, v) = diagonal.any_orthonormal_pair();
        let centre = DVec3::ONE - diagonal * 0.02;
        let wide = [centre + u * 3.0, centre - u * 2.0 + v * 3.0, centre - u * 2.0 - v * 3.0];
        check(wide, 0.02);
    }

    #[test]
    fn a_path_through_a_plate_is_detected() {
        let plate = OverlapSolid::Convex(ConvexSolid::new(&Polyhedron::cuboid(DVec3::new(1.0, 0.002, 1.0))));
        let crossed = |a: [f64; 3], b: [f64; 3], bend| plate.crossed(DVec3::from(a), DVec3::from(b), bend);
        assert!(crossed([0.0, 0.2, 0.0], [0.3, -0.2, 0.1], 0.0));
        assert!(crossed([0.0, 0.2, 0.0], [0.3, -0.2, 0.1], 0.1));
        assert!(!crossed([0.0, 0.2, 0.0], [0.3, 0.001, 0.1], 0.0));
        assert!(!crossed([0.9, 0.2, 0.0], [0.6, -0.2, 0.0], 0.0));
        // A path around the rim, or through the plate beside it.
        let around = ([0.49, 0.01, 0.0], [0.505, -0.01, 0.0]);
        assert!(crossed(around.0, around.1, 0.0) && !crossed(around.0, around.1, 0.004));
        assert!(OverlapSolid::Ball(0.1).crossed(DVec3::X, DVec3::new(-1.0, 0.02, 0.0), 0.0));
        assert!(!OverlapSolid::Ball(0.1).crossed(DVec3::X, DVec3::new(-1.0, 0.17, 0.0), 0.0));
    }

    #[test]
    fn a_slender_needle_counts_by_how_far_it_stands_out() {
        let needle = crate::scene::polyhedron::pyramid::pyramid(0.004, 0.08);
        let tip = OverlapSolid::Convex(ConvexSolid::new(&needle));
        let sheet = [DVec3::new(-0.05, 0.07, -0.05), DVec3::new(0.06, 0.07, -0.05), DVec3::new(0.0, 0.07, 0.07)];
        assert!((tip.overlap(&sheet, 1.0) - 0.01).abs() < 1e-12);
    }
}
