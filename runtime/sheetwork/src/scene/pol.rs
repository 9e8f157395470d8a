//! Polyhedron files (.POL, thesis 4.5.1): text, one record a line, lengths in centimetres.
//!
//! ```text
//! # a comment
//! V x y z     a corner, cm; counter-clockwise seen from outside
//! F           ends a face: its corners are the V since the last F
//! P           ends a polyhedron: its faces are the F since the last P
//! *           ends the file
//! ```
//!
//! In the program lengths are in metres. Corners at the same position become one vertex of the
//! polyhedron; vertices are numbered in the order of their first use by a face. Every polyhedron is
//! checked when its P is read: see [`Polyhedron::check_closed`].

use std::path::Path;

use glam::DVec3;

use crate::error::InputError;
use crate::scene::polyhedron::{MAX_COORDINATE, MAX_CORNERS, Polyhedron, PolyhedronBuilder};
use crate::scene::record_lines::{RecordColumn, RecordLine, decimal, last_line, read_file, records};

/// Maximum number of corners in a file, over all faces.
const MAX_VERTICES: usize = 10_000_000;
/// Power of ten from the file's centimetres to metres.
const CENTIMETRES: i32 = -2;
const COORDINATES: [RecordColumn; 3] = [coordinate("V.x"), coordinate("V.y"), coordinate("V.z")];

const fn coordinate(name: &'static str) -> RecordColumn {
    RecordColumn { name, unit: "cm", si_unit: "m", shift: CENTIMETRES, min: -MAX_COORDINATE, max: MAX_COORDINATE }
}

/// Read the polyhedra of a .POL text.
///
/// # Errors
/// The first fault, with its line: an unknown record, a wrong number, records out of order, a
/// missing `*`, or a polyhedron that is open, not planar or inside out.
pub fn read_pol(text: &str) -> Result<Vec<Polyhedron>, InputError> {
    let marked = read_marked(text, |face| face.expect_fields(0, ""))?;
    Ok(marked.into_iter().map(|(polyhedron, _)| polyhedron).collect())
}

/// Read the polyhedra of a .POL file.
///
/// # Errors
/// Those of [`read_pol`], and when the file cannot be read.
pub fn read_pol_file(path: &Path) -> Result<Vec<Polyhedron>, InputError> {
    read_file(path, read_pol)
}

/// Text of polyhedra as .POL.
///
/// Reading it gives the same polyhedra bit for bit if they are numbered as by the reader (in the
/// order of first use, every vertex used and unique); otherwise the same shape with its vertices
/// renumbered.
pub fn write_pol(polyhedra: &[Polyhedron]) -> String {
    let mut text = String::new();
    for polyhedron in polyhedra {
        write_faces(&mut text, polyhedron, |_| "F".to_owned());
    }
    text.push_str("*\n");
    text
}

/// Append the records of one polyhedron; `face_line` gives the line that ends a face.
pub(crate) fn write_faces(text: &mut String, polyhedron: &Polyhedron, face_line: impl Fn(usize) -> String) {
    for face in 0..polyhedron.faces.len() {
        for corner in polyhedron.corners(face) {
            let [x, y, z] = corner.to_array().map(|c| decimal(c, CENTIMETRES));
            text.push_str(&format!("V {x} {y} {z}\n"));
        }
        text.push_str(&face_line(face));
        text.push('\n');
    }
    text.push_str("P\n");
}

/// Read polyhedra whose F records `mark` reads: each polyhedron with the marks of its faces.
pub(crate) fn read_marked<M: Default>(
    text: &str,
    mark: impl Fn(&RecordLine<'_>) -> Result<M, InputError>,
) -> Result<Vec<(Polyhedron, Vec<M>)>, InputError> {
    let mut reader = PolReader::default();
    for record in records(text) {
        if let Some(end) = reader.end {
            return Err(record.error("", format!("something follows the end mark * of line {end}")));
        }
        match record.letter {
            "V" => reader.vertex(&record)?,
            "F" => reader.face(&record, &mark)?,
            "P" => reader.polyhedron(&record)?,
            "*" => reader.end(&record)?,
            _ => return Err(record.unknown("V, F, P, *")),
        }
    }
    match reader.end {
        Some(_) => Ok(reader.done),
        None => Err(InputError::new("", "the end mark * is missing").at_line(last_line(text))),
    }
}

/// State of the reader.
#[derive(Default)]
struct PolReader<M> {
    /// Corners since the last F.
    corners: Vec<DVec3>,
    /// Faces since the last P.
    assembler: PolyhedronBuilder,
    marks: Vec<M>,
    /// Lines of those faces' F records.
    face_lines: Vec<usize>,
    /// Corners in the whole file.
    vertices: usize,
    done: Vec<(Polyhedron, Vec<M>)>,
    /// Line of the end mark.
    end: Option<usize>,
}

impl<M> PolReader<M> {
    fn vertex(&mut self, record: &RecordLine<'_>) -> Result<(), InputError> {
        record.expect_fields(3, "x y z in cm")?;
        self.vertices += 1;
        if self.vertices > MAX_VERTICES {
            return Err(record.error("V", format!("the file has more than {MAX_VERTICES} corners")));
        }
        let [x, y, z] = &COORDINATES;
        self.corners.push(DVec3::new(record.number(0, x)?, record.number(1, y)?, record.number(2, z)?));
        Ok(())
    }

    fn face(
        &mut self,
        record: &RecordLine<'_>,
        mark: impl Fn(&RecordLine<'_>) -> Result<M, InputError>,
    ) -> Result<(), InputError> {
        let mark = mark(record)?;
        let count = self.corners.len();
        if !(3..=MAX_CORNERS).contains(&count) {
            let problem = format!("{count} corners (V) since the last face are outside 3 to {MAX_CORNERS} corners");
            return Err(record.error("F", problem));
        }
        self.assembler.face(&self.corners);
        self.corners.clear();
        self.marks.push(mark);
        self.face_lines.push(record.line);
        Ok(())
    }

    fn polyhedron(&mut self, record: &RecordLine<'_>) -> Result<(), InputError> {
        record.expect_fields(0, "")?;
        self.no_loose_corners(record)?;
        if self.assembler.face_count() == 0 {
            return Err(record.error("P", "no face (F) since the last polyhedron: at least 4 are needed"));
        }
        let polyhedron = self.assembler.take();
        if let Err(defect) = polyhedron.defect_of_closed() {
            // A fault of a face has the line of its F, another fault the line of the P.
            let line = defect.face.and_then(|face| self.face_lines.get(face).copied()).unwrap_or(record.line);
            let field = format!("polyhedra.{}.{}", self.done.len(), defect.error.field);
            return Err(InputError { field: field.trim_end_matches('.').to_owned(), ..defect.error }.at_line(line));
        }
        self.face_lines.clear();
        self.done.push((polyhedron, std::mem::take(&mut self.marks)));
        Ok(())
    }

    fn end(&mut self, record: &RecordLine<'_>) -> Result<(), InputError> {
        record.expect_fields(0, "")?;
        self.no_loose_corners(record)?;
        let faces = self.assembler.face_count();
        if faces > 0 {
            return Err(record.error("*", format!("{faces} faces (F) belong to no polyhedron: P is missing")));
        }
        if self.done.is_empty() {
            return Err(record.error("*", "the file holds no polyhedron (P): at least 1 is needed"));
        }
        self.end = Some(record.line);
        Ok(())
    }

    fn no_loose_corners(&self, record: &RecordLine<'_>) -> Result<(), InputError> {
        let count = self.corners.len();
        if count == 0 {
            return Ok(());
        }
        Err(record.error(record.letter, format!("{count} corners (V) belong to no face: F is missing")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::record_lines::damage;

    /// Corner cut off a cube: three right angles, legs of 1 cm; 19 lines.
    const TETRAHEDRON: &str = "# four faces\nV 0 0 0\nV 0 1 0\nV 1 0 0\nF\nV 0 0 0\nV 1 0 0\nV 0 0 1\nF\n\
        V 0 0 0\nV 0 0 1\nV 0 1 0\nF\nV 1 0 0\nV 0 1 0\nV 0 0 1\nF\nP\n*\n";

    fn error(text: &str) -> String {
        read_pol(text).expect_err("bad").to_string()
    }

    #[test]
    fn centimetres_become_metres_and_shared_corners_one_vertex() {
        let read = read_pol(TETRAHEDRON).expect("good");
        assert_eq!(read.len(), 1);
        assert_eq!(read[0].vertices, [DVec3::ZERO, 0.01 * DVec3::Y, 0.01 * DVec3::X, 0.01 * DVec3::Z]);
        assert_eq!(read[0].faces, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [2, 1, 3]]);
        assert!((read[0].volume() - 1e-6 / 6.0).abs() < 1e-18);
        let spelled = TETRAHEDRON.replace("V 1 0 0", "V 1.00 0.0e5 -0").replace('\n', "\r\n");
        assert_eq!(read_pol(&spelled).expect("other spelling"), read);
    }

    /// The polyhedron moved by `offset`, m.
    fn moved(mut polyhedron: Polyhedron, offset: DVec3) -> Polyhedron {
        polyhedron.vertices.iter_mut().for_each(|v| *v += offset);
        polyhedron
    }

    #[test]
    fn round_trips_are_exact() {
        let shapes = [
            moved(Polyhedron::cuboid(DVec3::new(0.016, 0.1, 1.0 / 3.0)), DVec3::new(-0.0015, -0.0281, 0.1)),
            Polyhedron::wedge(0.03, 0.0161, 0.032).scaled(DVec3::splat(std::f64::consts::PI)),
            Polyhedron::hemisphere(0.012, 8, 24),
        ];
        let text = write_pol(&shapes);
        let back = read_pol(&text).expect("ours");
        assert_eq!(back, shapes);
        for (a, b) in back.iter().zip(&shapes) {
            let bits =
                |p: &Polyhedron| p.vertices.iter().flat_map(|v| v.to_array().map(f64::to_bits)).collect::<Vec<_>>();
            assert_eq!(bits(a), bits(b));
        }
        assert_eq!(write_pol(&back), text);
    }

    #[test]
    fn faults_are_named_with_their_line() {
        assert_eq!(error(""), "line 1: the end mark * is missing");
        assert_eq!(error(&TETRAHEDRON.replace("*\n", "")), "line 18: the end mark * is missing");
        assert_eq!(error("*\n"), "line 1: *: the file holds no polyhedron (P): at least 1 is needed");
        assert_eq!(error(&format!("{TETRAHEDRON}\nV 1 1 1\n")), "line 21: something follows the end mark * of line 19");
        assert!(error("Q 1\n*\n").starts_with("line 1: unknown record \"Q\": a line starts with V, F, P, * or #"));
        assert_eq!(error("V 1 2\n"), "line 1: V: takes 3 fields (x y z in cm), found 2");
        assert_eq!(error("V 1 2 3\nV 1 2 3 4\n"), "line 2: V: takes 3 fields (x y z in cm), found 4");
        assert_eq!(error("V 1 2 inf\n"), "line 1: V.z: \"inf\" is not a number (-1000000 to 1000000 cm)");
        assert_eq!(error("V 1 1e7 0\n"), "line 1: V.y: \"1e7\" cm is outside -1000000 to 1000000 cm");
        assert!(error("V 1 NaN 0\n").contains("V.y: \"NaN\" is not a number"));
        assert!(error("V 0 0 0\nV 1 0 0\nF\n").starts_with("line 3: F: 2 corners"));
        assert!(error("F\n").starts_with("line 1: F: 0 corners"));
        assert!(error("P\n").starts_with("line 1: P: no face"));
        assert!(error(&TETRAHEDRON.replace("*", "P\n*")).starts_with("line 19: P: no face"));
        assert!(error(&TETRAHEDRON.replace("P\n", "")).starts_with("line 18: *: 4 faces (F) belong to no polyhedron"));
        assert!(error(&TETRAHEDRON.replace("F\nP", "P")).starts_with("line 17: P: 3 corners (V) belong to no face"));
        assert_eq!(error(&TETRAHEDRON.replacen("F\n", "F HOT 9 1\n", 1)), "line 5: F: takes no fields, found 3");
    }

    #[test]
    fn bad_polyhedra_are_named_with_the_line_of_their_face_or_of_their_end() {
        // The last face is missing: its edges are open, detected at the first face.
        let open = TETRAHEDRON.replace("V 1 0 0\nV 0 1 0\nV 0 0 1\nF\n", "");
        assert!(error(&open).starts_with("line 5: polyhedra.0.faces.0: is alone at the edge"), "{}", error(&open));
        let turned = TETRAHEDRON.replace("V 1 0 0\nV 0 1 0\nV 0 0 1\n", "V 0 0 1\nV 0 1 0\nV 1 0 0\n");
        assert!(error(&turned).starts_with("line 17: polyhedra.0.faces.3: runs from"));
        let bent = "V 0 0 0\nV 1 0 0\nV 1 1 0.1\nV 0 1 0\nF\nP\n*\n";
        assert!(error(bent).starts_with("line 5: polyhedra.0.faces.0: is not planar"));
        let inward = write_pol(&[Polyhedron::cuboid(DVec3::ONE).scaled(DVec3::ONE)]);
        let mut lines: Vec<&str> = inward.lines().collect();
        for face in 0..6 {
            lines.swap(face * 5, face * 5 + 2);
        }
        let message = error(&format!("{}{}", TETRAHEDRON.trim_end_matches("*\n"), lines.join("\n")));
        assert!(message.starts_with("line 49: polyhedra.1: faces wind inwards (volume -1"), "{message}");
    }

    #[test]
    fn files_name_themselves_in_errors() {
        let path = std::env::temp_dir().join(format!("sheetwork-pol-{}.pol", std::process::id()));
        let cube = Polyhedron::cuboid(DVec3::ONE);
        let error = read_pol_file(&path).expect_err("no file");
        assert_eq!(error.file.as_deref(), Some(path.as_path()));
        std::fs::write(&path, write_pol(std::slice::from_ref(&cube))).expect("written");
        let read = read_pol_file(&path);
        std::fs::write(&path, "V 1\n").expect("written");
        let bad = read_pol_file(&path).expect_err("short");
        std::fs::remove_file(&path).expect("removed");
        assert_eq!(read, Ok(vec![cube]));
        assert_eq!((bad.file, bad.line), (Some(path), Some(1)));
    }

    #[test]
    fn damaged_files_are_read_or_refused_but_never_panic() {
        let text = write_pol(&[Polyhedron::wedge(0.03, 0.016, 0.032), Polyhedron::cuboid(DVec3::splat(0.016))]);
        let (mut good, mut bad) = (0, 0);
        damage::try_all(&text, 4000, |damaged| match read_pol(damaged) {
            Ok(read) => {
                assert_eq!(read_pol(&write_pol(&read)), Ok(read));
                good += 1;
            }
            Err(error) => {
                assert!(error.line.is_some() && !error.problem.is_empty());
                bad += 1;
            }
        });
        assert!(good > 20 && bad > 2000, "{good} read, {bad} refused");
    }
}
