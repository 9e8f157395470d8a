//! Polyhedra: vertices and planar faces, closed or (for a heater) open.
//!
//! Lengths in metres. Faces are listed counter-clockwise seen from outside; a face may be concave
//! and may have holes only as separate faces. Checked conditions: at least three distinct corners a
//! face, planar faces, every edge of a closed polyhedron shared by exactly two faces with opposite
//! senses, positive volume.
//!
//! Equations, with p the corners of a face in order: area vector A = ½ Σ pᵢ × pᵢ₊₁ (Newell; its
//! length is the area, its direction the normal), volume V = ⅙ Σ a · (b × c) over the triangles (a,
//! b, c) of a fan of every face.

pub(crate) mod check;
pub mod pyramid;
pub(crate) mod shapes;
pub(crate) mod triangulate;

use std::collections::HashMap;

use glam::DVec3;
use serde::{Deserialize, Serialize};

pub(crate) use crate::scene::polyhedron::check::{MAX_COORDINATE, MAX_CORNERS};

/// Vertices in metres and faces as indices into them, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Polyhedron {
    /// Corner positions, m.
    pub vertices: Vec<DVec3>,
    /// Faces: three or more vertex indices each.
    pub faces: Vec<Vec<u32>>,
}

impl Polyhedron {
    /// Positions of the corners of face `face`, m; indices without a vertex are skipped, and a face
    /// that does not exist has none.
    pub fn corners(&self, face: usize) -> Vec<DVec3> {
        let indices = self.faces.get(face).map_or(&[][..], Vec::as_slice);
        indices.iter().filter_map(|index| self.vertices.get(*index as usize).copied()).collect()
    }

    /// Vector along the outward normal of face `face` with the face's area as length, m²; zero for
    /// a degenerate face.
    pub fn area_vector(&self, face: usize) -> DVec3 {
        area_vector(&self.corners(face))
    }

    /// Outward unit normal of face `face`; zero for a face that does not exist or has no area.
    pub fn face_normal(&self, face: usize) -> DVec3 {
        self.area_vector(face).normalize_or_zero()
    }

    /// Area of face `face`, m²; zero for a face that does not exist.
    pub fn face_area(&self, face: usize) -> f64 {
        self.area_vector(face).length()
    }

    /// Enclosed volume, m³; negative when the faces wind inwards, without meaning when the
    /// polyhedron is open.
    pub fn volume(&self) -> f64 {
        // Measured from a vertex of the polyhedron, to keep digits of a small body far from the
        // origin.
        let Some(origin) = self.vertices.first().copied() else { return 0.0 };
        let mut six_volumes = 0.0;
        for face in 0..self.faces.len() {
            let corners = self.corners(face);
            for pair in corners.windows(2).skip(1) {
                six_volumes += (corners[0] - origin).dot((pair[0] - origin).cross(pair[1] - origin));
            }
        }
        six_volumes / 6.0
    }

    /// Smallest and largest coordinates, m; both zero when there is no vertex.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let low = self.vertices.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = self.vertices.iter().copied().reduce(DVec3::max).unwrap_or_default();
        (low, high)
    }

    /// Reverse every face if the polyhedron is closed and its faces wind inwards.
    pub fn orient_outward(&mut self) {
        if self.volume() < 0.0 && check::closed(self).is_ok() {
            self.flip();
        }
    }

    /// The polyhedron with every coordinate multiplied by the factor of its axis; mirroring keeps
    /// the faces outward.
    pub fn scaled(mut self, factor: DVec3) -> Self {
        for vertex in &mut self.vertices {
            *vertex *= factor;
        }
        if factor.x * factor.y * factor.z < 0.0 {
            self.flip();
        }
        self
    }

    /// Reverse every face, keeping its first corner.
    fn flip(&mut self) {
        for face in &mut self.faces {
            if let Some(rest) = face.get_mut(1..) {
                rest.reverse();
            }
        }
    }
}

fn area_vector(corners: &[DVec3]) -> DVec3 {
    let Some(origin) = corners.first().copied() else { return DVec3::ZERO };
    let fan = corners.windows(2).map(|pair| (pair[0] - origin).cross(pair[1] - origin));
    fan.fold(DVec3::ZERO, |sum, cross| sum + cross) * 0.5
}

/// Builder of a polyhedron from the positions of corners; corners at the same position share a
/// vertex.
///
/// Vertices are numbered in the order of their first use by a face, so that a polyhedron and its
/// copy from a file agree in every index.
#[derive(Default)]
pub(crate) struct PolyhedronBuilder {
    polyhedron: Polyhedron,
    known: HashMap<[u64; 3], u32>,
}

impl PolyhedronBuilder {
    /// Add a face with these corners, m, counter-clockwise seen from outside.
    pub(crate) fn face(&mut self, corners: &[DVec3]) {
        let face = corners.iter().map(|corner| self.vertex(*corner)).collect();
        self.polyhedron.faces.push(face);
    }

    /// The polyhedron of the faces so far; the builder is empty afterwards.
    pub(crate) fn take(&mut self) -> Polyhedron {
        self.known.clear();
        std::mem::take(&mut self.polyhedron)
    }

    /// Number of faces so far.
    pub(crate) fn face_count(&self) -> usize {
        self.polyhedron.faces.len()
    }

    fn vertex(&mut self, position: DVec3) -> u32 {
        // Adding zero turns -0 into 0: equal positions with different bits.
        let key = position.to_array().map(|c| (c + 0.0).to_bits());
        let vertices = &mut self.polyhedron.vertices;
        *self.known.entry(key).or_insert_with(|| {
            vertices.push(position);
            (vertices.len() - 1) as u32
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_the_volume_areas_and_normals_of_a_box() {
        let mut body = Polyhedron::cuboid(DVec3::new(2.0, 3.0, 4.0));
        body.vertices.iter_mut().for_each(|v| *v += DVec3::new(10.0, 0.0, 0.0));
        assert!((body.volume() - 24.0).abs() < 1e-12);
        let mut sum = DVec3::ZERO;
        for face in 0..6 {
            let (area, normal) = (body.face_area(face), body.face_normal(face));
            let across = normal.abs().dot(DVec3::new(2.0, 3.0, 4.0));
            assert!((area - 24.0 / across).abs() < 1e-12);
            sum += normal * area;
        }
        assert!(sum.length() < 1e-12, "the area vectors of a closed surface cancel");
        assert_eq!(body.bounds(), (DVec3::new(9.0, -1.5, -2.0), DVec3::new(11.0, 1.5, 2.0)));
    }

    #[test]
    fn faces_that_wind_inwards_are_turned_only_when_closed() {
        let outward = Polyhedron::wedge(1.0, 1.0, 1.0);
        let mut inward = outward.clone();
        inward.flip();
        assert!(inward.volume() < 0.0);
        let mut open = inward.clone();
        open.faces.pop();
        let before = open.clone();
        open.orient_outward();
        assert_eq!(open, before);
        inward.orient_outward();
        assert_eq!(inward, outward);
    }

    #[test]
    fn mirroring_keeps_the_volume_positive() {
        let body = Polyhedron::wedge(1.0, 2.0, 3.0);
        let mirrored = body.clone().scaled(DVec3::new(-2.0, 1.0, 1.0));
        assert!((mirrored.volume() - 2.0 * body.volume()).abs() < 1e-12);
        assert_eq!(mirrored.check_closed(), Ok(()));
    }

    #[test]
    fn queries_of_missing_faces_return_neutral_values() {
        let bad = Polyhedron { vertices: vec![DVec3::ONE], faces: vec![vec![0, 7, 9], vec![]] };
        assert_eq!(bad.face_area(0), 0.0);
        assert_eq!(bad.face_normal(5), DVec3::ZERO);
        assert_eq!(bad.volume(), 0.0);
        assert_eq!(Polyhedron::default().bounds(), (DVec3::ZERO, DVec3::ZERO));
        assert!(bad.triangulate().is_empty());
    }

    #[test]
    fn negative_zero_is_the_same_place_as_zero() {
        let mut assembler = PolyhedronBuilder::default();
        assembler.face(&[DVec3::ZERO, DVec3::X, DVec3::Y]);
        assembler.face(&[DVec3::new(-0.0, 0.0, -0.0), DVec3::Y, DVec3::Z]);
        let polyhedron = assembler.take();
        assert_eq!(polyhedron.vertices.len(), 4);
        assert_eq!(polyhedron.faces, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(assembler.take(), Polyhedron::default());
    }
}
