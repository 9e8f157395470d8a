//! Heater files (.heater): hot polyhedra (thesis 4.3.2 and 4.11; the columns are defined here),
//! lengths in centimetres.
//!
//! A .POL file ([`crate::scene::pol`]) whose faces may be hot:
//!
//! ```text
//! F                               ends a cold face
//! F HOT temperature emissivity    ends a hot face: °C, and 0 (mirror) to 1 (black)
//! ```
//!
//! In the program lengths are in metres and temperatures in °C. A cold face is at the temperature
//! of the surroundings. A hot face of emissivity ε and temperature T emits ε σ T⁴ per area, T in
//! kelvin.

use std::path::Path;

use crate::error::{InputError, reject_if};
use crate::scene::pol::{read_marked, write_faces};
use crate::scene::polyhedron::Polyhedron;
use crate::scene::record_lines::{RecordColumn, RecordLine, decimal, quoted, read_file};

const TEMPERATURE: RecordColumn =
    RecordColumn { name: "F.temperature", unit: "°C", si_unit: "°C", shift: 0, min: -273.15, max: 5000.0 };
const EMISSIVITY: RecordColumn =
    RecordColumn { name: "F.emissivity", unit: "", si_unit: "", shift: 0, min: 0.0, max: 1.0 };

/// Closed polyhedron with hot and cold faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Heater {
    /// Shape, m.
    pub polyhedron: Polyhedron,
    /// Temperature and emissivity of each face of the polyhedron, in the same order.
    pub faces: Vec<HeaterFace>,
}

/// Temperature and emissivity of a face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeaterFace {
    /// Temperature, °C, -273.15 to 5000; `None` for a cold face, which has the temperature of the
    /// surroundings.
    pub temperature: Option<f64>,
    /// Emissivity, 0 to 1; 0 for a cold face.
    pub emissivity: f64,
}

impl HeaterFace {
    /// Cold face.
    pub const COLD: Self = Self { temperature: None, emissivity: 0.0 };

    /// Hot face: temperature in °C (-273.15 to 5000), emissivity 0 to 1.
    pub fn hot(temperature: f64, emissivity: f64) -> Self {
        Self { temperature: Some(temperature), emissivity }
    }
}

impl Heater {
    /// Check that the polyhedron is closed and every face has temperature and emissivity in range.
    ///
    /// # Errors
    /// The first defect; its field is that of [`Polyhedron::check_closed`], `faces` or
    /// `faces.N.temperature`.
    pub fn check(&self) -> Result<(), InputError> {
        self.polyhedron.check_closed()?;
        let (faces, marks) = (self.polyhedron.faces.len(), self.faces.len());
        reject_if!(faces != marks, "faces", "{marks} temperatures for {faces} faces");
        for (index, face) in self.faces.iter().enumerate() {
            let field = || format!("faces.{index}.emissivity");
            EMISSIVITY.check(field, face.emissivity)?;
            match face.temperature {
                Some(temperature) => TEMPERATURE.check(|| format!("faces.{index}.temperature"), temperature)?,
                None if face.emissivity != 0.0 => {
                    return Err(InputError::new(field(), format!("{} of a cold face must be 0", face.emissivity)));
                }
                None => {}
            }
        }
        Ok(())
    }
}

/// Read the heaters of a .heater text.
///
/// # Errors
/// The first fault, with its line: those of [`crate::scene::pol::read_pol`], and a temperature or
/// emissivity out of range.
pub fn read_heaters(text: &str) -> Result<Vec<Heater>, InputError> {
    let marked = read_marked(text, read_face)?;
    Ok(marked.into_iter().map(|(polyhedron, faces)| Heater { polyhedron, faces }).collect())
}

/// Read the heaters of a .heater file.
///
/// # Errors
/// Those of [`read_heaters`], and when the file cannot be read.
pub fn read_heaters_file(path: &Path) -> Result<Vec<Heater>, InputError> {
    read_file(path, read_heaters)
}

/// Text of heaters as .heater; faces beyond the list of temperatures are written cold.
///
/// Reading it gives the same heaters bit for bit under the condition of
/// [`crate::scene::pol::write_pol`].
pub fn write_heaters(heaters: &[Heater]) -> String {
    let mut text = String::new();
    for heater in heaters {
        write_faces(&mut text, &heater.polyhedron, |index| {
            let face = heater.faces.get(index).copied().unwrap_or(HeaterFace::COLD);
            match face.temperature {
                Some(temperature) => format!("F HOT {} {}", decimal(temperature, 0), decimal(face.emissivity, 0)),
                None => "F".to_owned(),
            }
        });
    }
    text.push_str("*\n");
    text
}

/// Read the fields of an F record.
fn read_face(record: &RecordLine<'_>) -> Result<HeaterFace, InputError> {
    if record.fields.is_empty() {
        return Ok(HeaterFace::COLD);
    }
    if record.field(0) != "HOT" {
        let problem =
            format!("{} is not HOT: a face is F (cold) or F HOT temperature emissivity", quoted(record.field(0)));
        return Err(record.error("F", problem));
    }
    record.expect_fields(3, "HOT, temperature in °C, emissivity")?;
    Ok(HeaterFace::hot(record.number(1, &TEMPERATURE)?, record.number(2, &EMISSIVITY)?))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::scene::record_lines::damage;

    /// Slab with one hot face and wedge with two.
    fn pair() -> Vec<Heater> {
        let mut slab = vec![HeaterFace::COLD; 6];
        slab[2] = HeaterFace::hot(250.0, 0.9);
        let mut wedge = vec![HeaterFace::hot(-273.15, 1.0); 5];
        wedge[4] = HeaterFace::hot(1.0 / 3.0, 0.1);
        vec![
            Heater { polyhedron: Polyhedron::cuboid(DVec3::new(0.03, 0.003, 0.03)), faces: slab },
            Heater { polyhedron: Polyhedron::wedge(0.03, 0.016, 0.032), faces: wedge },
        ]
    }

    #[test]
    fn round_trips_are_exact() {
        let text = write_heaters(&pair());
        assert_eq!(text.matches("F HOT 250 0.9\n").count(), 1);
        let back = read_heaters(&text).expect("ours");
        assert_eq!(back, pair());
        assert_eq!(write_heaters(&back), text);
        assert!(back.iter().all(|heater| heater.check().is_ok()));
    }

    #[test]
    fn faults_are_named_with_their_line() {
        let text = write_heaters(&pair());
        let line = text.lines().position(|l| l.starts_with("F HOT 250")).expect("hot") + 1;
        let error = |face: &str| {
            let error = read_heaters(&text.replace("F HOT 250 0.9", face)).expect_err("bad");
            assert_eq!(error.line, Some(line));
            format!("{}: {}", error.field, error.problem)
        };
        assert_eq!(error("F HOT 5001 0.9"), "F.temperature: \"5001\" °C is outside -273.15 to 5000 °C");
        assert_eq!(error("F HOT -274 0.9"), "F.temperature: \"-274\" °C is outside -273.15 to 5000 °C");
        assert_eq!(error("F HOT 250 1.1"), "F.emissivity: \"1.1\" is outside 0 to 1");
        assert_eq!(error("F HOT 250 nan"), "F.emissivity: \"nan\" is not a number (0 to 1)");
        assert_eq!(error("F HOT 250"), "F: takes 3 fields (HOT, temperature in °C, emissivity), found 2");
        assert!(error("F WARM 250 1").starts_with("F: \"WARM\" is not HOT"));
        assert_eq!(read_heaters(&text.replace("*\n", "")).expect_err("no end").line, Some(text.lines().count() - 1));
    }

    #[test]
    fn heaters_made_by_program_are_checked() {
        let path = std::env::temp_dir().join(format!("sheetwork-heater-{}.heater", std::process::id()));
        let refused = |spoil: fn(&mut Heater)| {
            let mut heaters = pair();
            spoil(&mut heaters[1]);
            heaters[1].check().expect_err("spoilt").field
        };
        assert_eq!(refused(|h| h.faces[1].temperature = Some(f64::NAN)), "faces.1.temperature");
        assert_eq!(refused(|h| h.faces[0].emissivity = -0.1), "faces.0.emissivity");
        assert_eq!(refused(|h| h.faces[0].temperature = None), "faces.0.emissivity");
        assert_eq!(refused(|h| h.faces.truncate(2)), "faces");
        assert!(refused(|h| drop(h.polyhedron.faces.pop())).starts_with("faces."));
        std::fs::write(&path, write_heaters(&pair())).expect("written");
        let read = read_heaters_file(&path);
        std::fs::remove_file(&path).expect("removed");
        assert_eq!(read, Ok(pair()));
    }

    #[test]
    fn damaged_files_are_read_or_refused_but_never_panic() {
        let text = write_heaters(&pair());
        damage::try_all(&text, 4000, |damaged| match read_heaters(damaged) {
            Ok(read) => assert_eq!(read_heaters(&write_heaters(&read)), Ok(read)),
            Err(error) => assert!(error.line.is_some()),
        });
    }
}
