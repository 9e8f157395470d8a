//! Checks of a polyhedron, and their messages.
//!
//! Lengths in metres. Order of the checks: coordinates, then each face alone (corners, area,
//! planarity, outline), then edges, then volume; the first defect is reported.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use crate::error::InputError;
use crate::scene::polyhedron::{Polyhedron, area_vector};
use crate::units::parameters::ParameterId as Id;

/// Planarity tolerance: distance of a corner from the plane of its face, relative to the face's
/// size.
const PLANARITY: f64 = 1e-4;
/// Area threshold, relative to the face's size squared, below which a face counts as a line.
const FLATNESS: f64 = 1e-10;
/// Volume threshold, relative to the size cubed, below which a polyhedron counts as flat: rounding
/// error of a flat one.
const THINNESS: f64 = 1e-15;
/// Largest coordinate, m.
pub(crate) const MAX_COORDINATE: f64 = 1e4;
/// Maximum number of corners of a face: checking and triangulating a face take time quadratic in
/// it.
pub(crate) const MAX_CORNERS: usize = 1024;

/// Defect of a polyhedron.
#[derive(Debug, PartialEq)]
pub(crate) struct PolyhedronDefect {
    /// Face with the defect, if it is a single one.
    pub(crate) face: Option<usize>,
    /// Field ("vertices.3.x", "faces.3" or empty) and problem.
    pub(crate) error: InputError,
}

impl Polyhedron {
    /// Check that the polyhedron is closed with outward faces.
    ///
    /// Coordinates must be finite and within ±1e4 m. Faces must have 3 to 1024 distinct corners, be
    /// planar to 1e-4 of their size and not cross themselves. Every edge must belong to two faces
    /// with opposite senses, and the volume must be positive.
    ///
    /// # Errors
    /// The first defect found; its field is `vertices.N.x`, `faces.N` or empty.
    pub fn check_closed(&self) -> Result<(), InputError> {
        self.defect_of_closed().map_err(|defect| defect.error)
    }

    /// [`Polyhedron::check_closed`] with the face of the defect.
    pub(crate) fn defect_of_closed(&self) -> Result<(), PolyhedronDefect> {
        faces(self)?;
        closed(self)?;
        let (low, high) = self.bounds();
        let size = (high - low).length();
        let (volume, least) = (self.volume(), THINNESS * size * size * size);
        if volume > least {
            return Ok(());
        }
        let problem = if volume < -least {
            format!("faces wind inwards (volume {volume} m³): list corners counter-clockwise seen from outside")
        } else {
            format!("encloses no volume ({volume} m³, size {size} m)")
        };
        Err(PolyhedronDefect { face: None, error: InputError::new("", problem) })
    }
}

/// Check that every edge occurs once in each sense.
pub(crate) fn closed(polyhedron: &Polyhedron) -> Result<(), PolyhedronDefect> {
    // Directed edges: if each is unique and has its reverse, each edge has exactly two faces.
    let mut face_of = HashMap::new();
    for (face, corners) in polyhedron.faces.iter().enumerate() {
        for (from, to) in edges(corners) {
            if let Some(other) = face_of.insert((from, to), face) {
                let problem = format!(
                    "runs from vertex {from} to vertex {to} as faces.{other} does: one of the two winds the wrong way, or \
                     more than two faces meet there"
                );
                return Err(face_defect(face, problem));
            }
        }
    }
    for (face, corners) in polyhedron.faces.iter().enumerate() {
        for (from, to) in edges(corners) {
            if !face_of.contains_key(&(to, from)) {
                let problem = format!(
                    "is alone at the edge from vertex {from} to vertex {to}: the polyhedron is open there, every edge \
                     needs exactly 2 faces"
                );
                return Err(face_defect(face, problem));
            }
        }
    }
    Ok(())
}

fn edges(corners: &[u32]) -> impl Iterator<Item = (u32, u32)> + '_ {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// Check coordinates, and every face by itself.
fn faces(polyhedron: &Polyhedron) -> Result<(), PolyhedronDefect> {
    for (index, vertex) in polyhedron.vertices.iter().enumerate() {
        // NaN fails the comparison.
        if vertex.abs().cmple(DVec3::splat(MAX_COORDINATE)).all() {
            continue;
        }
        for (axis, value) in ["x", "y", "z"].into_iter().zip(vertex.to_array()) {
            let found = Id::VertexCoordinate.check(&format!("vertices.{index}.{axis}"), value);
            found.map_err(|error| PolyhedronDefect { face: None, error })?;
        }
    }
    if polyhedron.faces.is_empty() {
        let error = InputError::new("faces", "none: at least 1 face is needed");
        return Err(PolyhedronDefect { face: None, error });
    }
    for (index, face) in polyhedron.faces.iter().enumerate() {
        face_problem(polyhedron, face).map_err(|problem| face_defect(index, problem))?;
    }
    Ok(())
}

fn face_defect(face: usize, problem: String) -> PolyhedronDefect {
    PolyhedronDefect { face: Some(face), error: InputError::new(format!("faces.{face}"), problem) }
}

fn face_problem(polyhedron: &Polyhedron, face: &[u32]) -> Result<(), String> {
    if face.len() < 3 || face.len() > MAX_CORNERS {
        return Err(format!("{} corners are outside 3 to {MAX_CORNERS} corners", face.len()));
    }
    let count = polyhedron.vertices.len();
    let mut corners = Vec::with_capacity(face.len());
    for index in face {
        match polyhedron.vertices.get(*index as usize) {
            Some(vertex) => corners.push(*vertex),
            None => return Err(format!("vertex {index} does not exist: there are {count}, counted from 0")),
        }
    }
    let mut sorted = face.to_vec();
    sorted.sort_unstable();
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(format!("vertex {} is listed twice: corners must be distinct", pair[0]));
    }
    flat(&corners)?;
    simple(&polyhedron.flatten(face))
}

/// Check that the corners span a plane and lie in it.
fn flat(corners: &[DVec3]) -> Result<(), String> {
    let low = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let size = (high - low).length();
    let area = area_vector(corners);
    if area.length() <= FLATNESS * size * size {
        return Err(format!("has no area ({} m², size {size} m): its corners lie on a line", area.length()));
    }
    let normal = area.normalize_or_zero();
    let origin = corners[0];
    // The plane goes through the mean of the corners, to treat all corners alike.
    let mean = corners.iter().map(|c| (*c - origin).dot(normal)).sum::<f64>() / corners.len() as f64;
    for (index, corner) in corners.iter().enumerate() {
        let off = ((*corner - origin).dot(normal) - mean).abs();
        if off > PLANARITY * size {
            let most = PLANARITY * size;
            return Err(format!("is not planar: corner {index} lies {off} m off its plane, more than {most} m"));
        }
    }
    Ok(())
}

/// Check that the outline does not touch itself.
fn simple(outline: &[DVec2]) -> Result<(), String> {
    let count = outline.len();
    let edge = |i: usize| (outline[i], outline[(i + 1) % count]);
    for i in 0..count {
        let (a, b) = edge(i);
        let (_, next) = edge((i + 1) % count);
        if (b - a).perp_dot(next - b) == 0.0 && (b - a).dot(next - b) <= 0.0 {
            return Err(format!("folds back on itself at corner {}", (i + 1) % count));
        }
        // Edges i+1 and, for i = 0, the last one share a corner with edge i.
        let end = if i == 0 { count - 1 } else { count };
        for j in i + 2..end {
            let (c, d) = edge(j);
            if touch(a, b, c, d) {
                return Err(format!("crosses or touches itself: its edges {i} and {j}, counted from 0, meet"));
            }
        }
    }
    Ok(())
}

/// Whether the segments ab and cd have a point in common.
fn touch(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let side = |p: DVec2, q: DVec2, r: DVec2| {
        let cross = (q - p).perp_dot(r - p);
        if cross == 0.0 { 0 } else { cross.signum() as i32 }
    };
    let (c_side, d_side, a_side, b_side) = (side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b));
    if c_side * d_side < 0 && a_side * b_side < 0 {
        return true;
    }
    let within = |p: DVec2, q: DVec2, r: DVec2| p.min(q).cmple(r).all() && r.cmple(p.max(q)).all();
    (c_side == 0 && within(a, b, c))
        || (d_side == 0 && within(a, b, d))
        || (a_side == 0 && within(c, d, a))
        || (b_side == 0 && within(c, d, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error of a cube changed by `spoil`.
    fn spoilt(spoil: impl Fn(&mut Polyhedron)) -> String {
        let mut cube = Polyhedron::cuboid(DVec3::ONE);
        assert_eq!(cube.check_closed(), Ok(()));
        spoil(&mut cube);
        cube.check_closed().expect_err("spoilt").to_string()
    }

    #[test]
    fn coordinates_are_checked_with_their_field_and_range() {
        let error = spoilt(|p| p.vertices[2].y = f64::NAN);
        assert_eq!(error, "vertices.2.y: NaN m is outside -10000 to 10000 m");
        assert!(spoilt(|p| p.vertices[0].z = 2e4).starts_with("vertices.0.z: 20000 m"));
    }

    #[test]
    fn corners_are_checked() {
        assert!(spoilt(|p| p.faces[3].truncate(2)).starts_with("faces.3: 2 corners are outside 3 to"));
        assert!(spoilt(|p| p.faces[1][0] = 99).starts_with("faces.1: vertex 99 does not exist: there are 8"));
        assert!(spoilt(|p| p.faces[1][0] = p.faces[1][2]).contains("listed twice"));
        assert!(spoilt(|p| p.faces.clear()).starts_with("faces: none"));
        assert!(spoilt(|p| p.faces[0] = (0..2000).collect()).contains("2000 corners"));
    }

    #[test]
    fn faces_must_be_planar_have_area_and_a_simple_outline() {
        assert!(spoilt(|p| p.vertices[0] *= 1.01).contains("is not planar: corner"));
        // A rounded vertex within the tolerance is accepted.
        let mut rounded = Polyhedron::cuboid(DVec3::ONE);
        rounded.vertices[0] *= 1.0 + 1e-5;
        assert_eq!(rounded.check_closed(), Ok(()));

        let plane = |points: &[(f64, f64)]| Polyhedron {
            vertices: points.iter().map(|p| DVec3::new(p.0, 2.0, p.1)).collect(),
            faces: vec![(0..points.len() as u32).collect()],
        };
        let line = plane(&[(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)]);
        assert!(faces(&line).expect_err("line").error.problem.contains("no area"));
        let bow = plane(&[(0.0, 0.0), (3.0, 3.0), (3.0, 0.0), (0.0, 2.0)]);
        assert!(faces(&bow).expect_err("bow tie").error.problem.contains("edges 0 and 2"));
        let spike = plane(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (1.0, 0.5), (0.0, 0.5)]);
        assert!(faces(&spike).expect_err("spike").error.problem.contains("folds back on itself at corner 2"));
        let arrow = plane(&[(0.0, 0.0), (2.0, 0.0), (0.5, 0.5), (0.0, 2.0)]);
        assert_eq!(faces(&arrow), Ok(()));
        assert!(arrow.check_closed().expect_err("open").problem.contains("open"));
    }

    #[test]
    fn open_and_turned_faces_are_told_apart() {
        let error = spoilt(|p| {
            p.faces.pop();
        });
        assert!(error.contains("is open there"), "{error}");
        assert!(spoilt(|p| p.faces[4].reverse()).contains("winds the wrong way"));
        assert!(spoilt(|p| p.faces.iter_mut().for_each(|f| f.reverse())).contains("faces wind inwards (volume -1"));
        // A third face on an edge.
        let error = spoilt(|p| {
            let (a, b) = (p.faces[0][0], p.faces[0][1]);
            p.vertices.push(DVec3::splat(3.0));
            p.faces.push(vec![a, b, 8]);
        });
        assert!(error.contains("more than two faces"), "{error}");
    }

    #[test]
    fn two_sides_of_one_face_enclose_nothing() {
        let leaf =
            Polyhedron { vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y], faces: vec![vec![0, 1, 2], vec![0, 2, 1]] };
        assert_eq!(faces(&leaf), Ok(()));
        assert!(leaf.check_closed().expect_err("flat").problem.contains("encloses no volume"));
    }
}
