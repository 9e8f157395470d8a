//! Specification of heat in a scene: oven, heaters, heat gun, and the thermal model.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::scene::heater_file::{Heater, HeaterFace, read_heaters_file};
use crate::scene::{PathKey, Placement, Polyhedron};

/// Thermal model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum HeatMode {
    /// Temperatures, conduction, exact radiation, E(T).
    #[default]
    Physical,
    /// Stiffness from the thesis's formulas, for comparison.
    Thesis {
        /// Thermal sensitivity C, N/K; 0 to 1e6.
        sensitivity: f64,
        /// Thermal conductivity coefficient; 0 to 1e3.
        #[serde(default)]
        conductivity: f64,
    },
}

/// Oven: the whole room, air and walls, at one temperature.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OvenSpec {
    /// Temperature while on, °C; -273.15 to 5000.
    pub temperature: f64,
    /// Whether the oven is on.
    pub on: bool,
    /// Convection coefficient in the oven, of both sides of a sheet together, W/(m² K), 0 to 1e6;
    /// `None` for that of the scene.
    pub convection: Option<f64>,
    /// Temperatures at times, in place of `temperature`: linear in between, constant after the
    /// last; off before the first.
    pub schedule: Vec<OvenKey>,
}

/// Temperature of an oven or of a hot body at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OvenKey {
    /// Simulated time, s; 0 to 1e6, increasing along the schedule.
    pub time: f64,
    /// Temperature, °C, -273.15 to 5000; `None` switches the oven, or the exchange of the body,
    /// off from this time.
    pub temperature: Option<f64>,
}

impl OvenKey {
    /// Temperature of `schedule` at `time` (s), °C; `None` while it is off.
    pub(crate) fn at(schedule: &[Self], time: f64) -> Option<f64> {
        let after = schedule.partition_point(|k| k.time <= time);
        let before = schedule.get(after.checked_sub(1)?)?;
        let from = before.temperature?;
        let next = schedule.get(after).and_then(|k| Some((k.time, k.temperature?)));
        Some(next.map_or(from, |(at, to)| from + (to - from) * (time - before.time) / (at - before.time)))
    }
}

impl Default for OvenSpec {
    fn default() -> Self {
        Self { temperature: 140.0, on: true, convection: None, schedule: Vec::new() }
    }
}

impl OvenSpec {
    /// Temperature at `time` (s), °C; `None` while it is off.
    pub(crate) fn celsius_at(&self, time: f64) -> Option<f64> {
        if !self.on {
            return None;
        }
        if self.schedule.is_empty() { Some(self.temperature) } else { OvenKey::at(&self.schedule, time) }
    }
}

/// Specification of a hot polyhedron.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HeaterSpec {
    /// Name in parameter paths; empty for its number from 0.
    pub name: String,
    /// Heater file; `None` for a heater given by `polyhedron` or `size`.
    pub file: Option<PathBuf>,
    /// In-line closed polyhedron.
    pub polyhedron: Option<Polyhedron>,
    /// Edges (x, y, z) of a box about its centre, m; 1e-6 to 1e4 each. Its faces are -x, +x, -y,
    /// +y, -z, +z.
    pub size: Option<DVec3>,
    /// Hot faces of `polyhedron` or `size`; a file has its own.
    pub hot: Vec<HotFaceSpec>,
    /// Whether the heater is on.
    pub on: bool,
    /// Placement of the heater.
    pub placement: Placement,
}

/// Hot face of a heater given in the scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HotFaceSpec {
    /// Index of the face, from 0.
    pub face: u32,
    /// Temperature, °C; -273.15 to 5000.
    pub temperature: f64,
    /// Emissivity, 0 to 1.
    #[serde(default = "black")]
    pub emissivity: f64,
}

fn black() -> f64 {
    1.0
}

impl Default for HeaterSpec {
    /// Heater that is on, without a shape.
    fn default() -> Self {
        Self {
            name: String::new(),
            file: None,
            polyhedron: None,
            size: None,
            hot: Vec::new(),
            on: true,
            placement: Placement::default(),
        }
    }
}

impl HeaterSpec {
    /// Heaters of the specification, in their own axes, m.
    ///
    /// # Errors
    /// When the file cannot be read, when other than one of file, polyhedron and size is given, or
    /// when a hot face does not exist.
    pub fn resolve(&self, base: &Path) -> Result<Vec<Heater>, InputError> {
        let polyhedron = match (&self.file, &self.polyhedron, self.size) {
            (Some(file), None, None) if self.hot.is_empty() => return read_heaters_file(&base.join(file)),
            (Some(_), None, None) => {
                return Err(InputError::new("hot", "does not go with a file, which has hot faces"));
            }
            (None, Some(polyhedron), None) => polyhedron.clone(),
            (None, None, Some(size)) => sided(size),
            _ => return Err(InputError::new("file", "a heater has one of file, polyhedron and size")),
        };
        let mut faces = vec![HeaterFace::COLD; polyhedron.faces.len()];
        for (i, hot) in self.hot.iter().enumerate() {
            let count = faces.len();
            let face = faces.get_mut(hot.face as usize).ok_or_else(|| {
                InputError::new(format!("hot.{i}.face"), format!("{}: there are {count} faces, from 0", hot.face))
            })?;
            *face = HeaterFace::hot(hot.temperature, hot.emissivity);
        }
        let heater = Heater { polyhedron, faces };
        heater.check()?;
        Ok(vec![heater])
    }
}

/// Box with its faces in the order -x, +x, -y, +y, -z, +z.
fn sided(size: DVec3) -> Polyhedron {
    let mut solid = Polyhedron::cuboid(size);
    let order = |face: usize| {
        let n = solid.face_normal(face).to_array();
        let axis = (0..3).max_by(|a, b| n[*a].abs().total_cmp(&n[*b].abs())).unwrap_or(0);
        2 * axis + usize::from(n[axis] > 0.0)
    };
    let mut faces = solid.faces.clone();
    for face in 0..solid.faces.len() {
        faces[order(face)].clone_from(&solid.faces[face]);
    }
    solid.faces = faces;
    solid
}

/// Specification of a jet of hot air.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HeatGunSpec {
    /// Whether the heat gun is on.
    pub on: bool,
    /// Temperature of the air, °C; -273.15 to 5000.
    pub temperature: f64,
    /// Convection coefficient at the nozzle, W/(m² K); 0 to 1e6.
    pub convection: f64,
    /// Angle from the axis at which the convection coefficient falls to a third, degrees; 0.1 to
    /// 90.
    pub half_angle: f64,
    /// Distance at which the convection coefficient falls to a half, m; 1e-6 to 1e4.
    pub reach: f64,
    /// Position of the nozzle, m; each component within ±1e4.
    pub position: DVec3,
    /// Direction of the jet; any length but 0.
    pub direction: DVec3,
    /// Prescribed path; empty for a gun that is at rest or moved by the program.
    pub path: Vec<PathKey>,
}

impl Default for HeatGunSpec {
    fn default() -> Self {
        Self {
            on: true,
            temperature: 300.0,
            convection: 120.0,
            half_angle: 12.0,
            reach: 0.1,
            position: DVec3::new(0.0, 0.1, 0.0),
            direction: DVec3::NEG_Y,
            path: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_its_faces_in_the_order_that_is_promised() {
        let solid = sided(DVec3::new(1.0, 2.0, 3.0));
        solid.check_closed().expect("closed");
        let normals = [DVec3::NEG_X, DVec3::X, DVec3::NEG_Y, DVec3::Y, DVec3::NEG_Z, DVec3::Z];
        for (face, normal) in normals.into_iter().enumerate() {
            assert_eq!(solid.face_normal(face), normal);
        }
    }

    #[test]
    fn an_oven_follows_its_schedule() {
        let key = |time, temperature| OvenKey { time, temperature };
        let schedule = vec![key(1.0, Some(20.0)), key(2.0, Some(120.0)), key(5.0, None), key(6.0, Some(50.0))];
        let oven = OvenSpec { schedule, ..OvenSpec::default() };
        let at = |time| oven.celsius_at(time);
        assert_eq!((at(0.5), at(1.5), at(2.0), at(4.0)), (None, Some(70.0), Some(120.0), Some(120.0)));
        assert_eq!((at(5.5), at(6.0), at(100.0)), (None, Some(50.0), Some(50.0)));
        assert_eq!(OvenSpec { on: false, ..oven.clone() }.celsius_at(4.0), None);
        assert_eq!(OvenSpec::default().celsius_at(0.0), Some(140.0));
    }
}
