//! Triangulation of faces, by ear clipping in a fixed order.
//!
//! An ear is a convex corner whose triangle with its two neighbours contains no other corner; a
//! simple polygon always has one. Corners are neither moved nor added, so a closed polyhedron
//! becomes a closed triangle mesh. Lengths in metres.

use glam::DVec2;

use crate::scene::polyhedron::{Polyhedron, area_vector};

impl Polyhedron {
    /// All faces as triangles of vertex indices, counter-clockwise seen from outside, face by face.
    ///
    /// Faces may be concave. Faces of fewer than three corners, or with corners without a vertex,
    /// are skipped.
    pub fn triangulate(&self) -> Vec<[u32; 3]> {
        (0..self.faces.len()).flat_map(|face| self.triangulate_face(face)).collect()
    }

    /// Triangles of face `face`; empty if it does not exist, has fewer than three corners or
    /// corners without vertex.
    pub fn triangulate_face(&self, face: usize) -> Vec<[u32; 3]> {
        let Some(corners) = self.faces.get(face) else { return Vec::new() };
        let outline = self.flatten(corners);
        if outline.len() < 3 || outline.len() != corners.len() {
            return Vec::new();
        }
        clip_ears(&outline).into_iter().map(|triangle| triangle.map(|corner| corners[corner])).collect()
    }

    /// Projection of the face along its normal: two of the three coordinates, in the order that
    /// keeps it counter-clockwise.
    pub(crate) fn flatten(&self, face: &[u32]) -> Vec<DVec2> {
        let corners: Vec<_> = face.iter().filter_map(|index| self.vertices.get(*index as usize).copied()).collect();
        let normal = area_vector(&corners);
        let size = normal.abs();
        let project = |c: &glam::DVec3| {
            // Dropping the axis nearest to the normal distorts the outline least.
            let (flat, along) = if size.x >= size.y && size.x >= size.z {
                (DVec2::new(c.y, c.z), normal.x)
            } else if size.y >= size.z {
                (DVec2::new(c.z, c.x), normal.y)
            } else {
                (DVec2::new(c.x, c.y), normal.z)
            };
            if along < 0.0 { DVec2::new(flat.y, flat.x) } else { flat }
        };
        corners.iter().map(project).collect()
    }
}

/// Triangles of a counter-clockwise outline, as indices into it.
fn clip_ears(outline: &[DVec2]) -> Vec<[usize; 3]> {
    let mut ring: Vec<usize> = (0..outline.len()).collect();
    let mut triangles = Vec::with_capacity(outline.len().saturating_sub(2));
    let mut start = 0;
    while ring.len() > 3 {
        let ear = next_ear(outline, &ring, start);
        triangles.push(around(&ring, ear));
        ring.remove(ear);
        // Continuing past the neighbour clips every other corner and gives fewer slivers than a
        // fan.
        start = ear + 1;
    }
    if let [a, b, c] = ring[..] {
        triangles.push([a, b, c]);
    }
    triangles
}

/// Position in the ring of the first ear at or after `start`, cyclically.
fn next_ear(outline: &[DVec2], ring: &[usize], start: usize) -> usize {
    let mut widest = (0, f64::NEG_INFINITY);
    for step in 0..ring.len() {
        let place = (start + step) % ring.len();
        let corners = around(ring, place);
        let turn = turn(corners.map(|i| outline[i]));
        if turn > 0.0 && !ring.iter().any(|other| !corners.contains(other) && covers(outline, corners, *other)) {
            return place;
        }
        if turn > widest.1 {
            widest = (place, turn);
        }
    }
    // Only an outline that touches itself, or is so thin that rounding decides, has no ear: clip
    // the most convex corner.
    widest.0
}

/// The corner at `place` between its neighbours.
fn around(ring: &[usize], place: usize) -> [usize; 3] {
    let count = ring.len();
    [ring[(place + count - 1) % count], ring[place], ring[(place + 1) % count]]
}

/// Twice the signed area of a triangle.
fn turn([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Whether the triangle contains the point, its sides included.
fn covers(outline: &[DVec2], triangle: [usize; 3], point: usize) -> bool {
    let [a, b, c] = triangle.map(|i| outline[i]);
    let p = outline[point];
    turn([a, b, p]) >= 0.0 && turn([b, c, p]) >= 0.0 && turn([c, a, p]) >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Face with this outline in a slanted plane.
    fn slanted(outline: &[(f64, f64)]) -> Polyhedron {
        let (u, v) = (DVec3::new(0.6, -0.8, 0.0), DVec3::new(0.0, 0.0, -1.0));
        Polyhedron {
            vertices: outline.iter().map(|(x, y)| DVec3::ONE + *x * u + *y * v).collect(),
            faces: vec![(0..outline.len() as u32).collect()],
        }
    }

    /// Check that the triangles cover the face once: positive areas, on the face's side, with the
    /// face's total.
    fn assert_covered(polyhedron: &Polyhedron, area: f64) {
        assert!((polyhedron.face_area(0) - area).abs() < 1e-12);
        let triangles = polyhedron.triangulate();
        assert_eq!(triangles.len(), polyhedron.faces[0].len() - 2);
        let mut sum = 0.0;
        for triangle in triangles {
            let part = Polyhedron { vertices: polyhedron.vertices.clone(), faces: vec![triangle.to_vec()] };
            assert!(part.face_area(0) > 1e-9, "{triangle:?} has no area");
            assert!(part.face_normal(0).dot(polyhedron.face_normal(0)) > 0.999_999, "{triangle:?} is turned over");
            sum += part.face_area(0);
        }
        assert!((sum - area).abs() < 1e-12, "{sum} is not {area}");
    }

    #[test]
    fn concave_faces_are_covered_once() {
        // An L, a comb with three teeth and an arrow head.
        assert_covered(&slanted(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]), 3.0);
        let comb = [
            (0.0, 0.0),
            (5.0, 0.0),
            (5.0, 3.0),
            (4.0, 3.0),
            (4.0, 1.0),
            (3.0, 1.0),
            (3.0, 3.0),
            (2.0, 3.0),
            (2.0, 1.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ];
        assert_covered(&slanted(&comb), 11.0);
        assert_covered(&slanted(&[(0.0, 0.0), (2.0, 1.0), (0.0, 2.0), (1.0, 1.0)]), 1.0);
    }

    #[test]
    fn straight_angles_give_no_empty_triangle() {
        let square = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0), (0.0, 2.0), (0.0, 1.0)];
        assert_covered(&slanted(&square), 4.0);
    }

    #[test]
    fn a_triangulated_closed_polyhedron_is_closed_and_as_large() {
        let dome = Polyhedron::hemisphere(0.012, 8, 24);
        let triangles = dome.triangulate();
        let mesh =
            Polyhedron { vertices: dome.vertices.clone(), faces: triangles.iter().map(|t| t.to_vec()).collect() };
        assert_eq!(mesh.check_closed(), Ok(()));
        assert!((mesh.volume() - dome.volume()).abs() < 1e-12 * dome.volume());
        assert_eq!(dome.triangulate(), triangles, "the same every time");
    }

    #[test]
    fn outlines_without_ears_still_end() {
        // Coincident and crossing corners: the result has no meaning, but exists.
        assert_eq!(slanted(&[(0.0, 0.0); 6]).triangulate().len(), 4);
        assert_eq!(slanted(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0), (0.5, 2.0)]).triangulate().len(), 3);
        let nan = slanted(&[(f64::NAN, 0.0), (1.0, f64::INFINITY), (1.0, 0.0), (0.0, 1.0)]);
        assert_eq!(nan.triangulate().len(), 2);
    }
}
