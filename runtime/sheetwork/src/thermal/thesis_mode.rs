//! Thermal model of the thesis (4.11.1), for comparison: the stiffness follows at once from the
//! positions and temperatures of sources.
//!
//! With K the stiffness of a planar spring (E t, N/m), Ht and At (°C) the temperatures of the
//! source and of the room, C the thermal sensitivity of the material (N/K) and d (m) a distance,
//! the remaining stiffness of a spring is K - (Ht - At)/d · C (equation 4.4):
//!
//! - oven: all springs alike, d = 1 m, Ht its temperature, At 20 °C;
//! - heater: Ht - At is that of the hot face times the fraction of its radiation that the sheet
//!   intercepts, by equations 4.1 to 4.3 at its centre, ε cos Θ₁ ω with ω = A cos Θ₂/D² the solid
//!   angle as if all of the face were at its centre; d is the distance of the spring from there,
//!   and the loss is weighted by 1 + c (D - d)/D with c the thermal conductivity coefficient.
//!
//! The thesis does not state units; these are defined here. At least a hundredth of the stiffness
//! remains. The solid angle is wrong by a third at a distance of one side and by a factor of thirty
//! at a tenth.

use glam::DVec3;

use crate::sheet::{Sheet, temperature};
use crate::thermal::source::{HotPlane, Surroundings};
use crate::units::temperature::REFERENCE;

/// Minimum remaining stiffness, as a fraction.
const MIN_STIFFNESS: f64 = 0.01;

/// Thermal model of the thesis.
pub(crate) struct ThesisHeat {
    /// C, N/K.
    pub sensitivity: f64,
    /// Thermal conductivity coefficient c.
    pub conductivity: f64,
    /// Hot faces in this step.
    pub faces: Vec<HotPlane>,
}

impl ThesisHeat {
    /// Give the material of `sheet` the coefficients that it does not state.
    pub fn prepare(&self, sheet: &mut Sheet) -> (f64, f64) {
        let material = &mut sheet.parameters.material;
        let sensitivity = material.thesis_sensitivity.get_or_insert(self.sensitivity);
        (*sensitivity, *material.thesis_conductivity.get_or_insert(self.conductivity))
    }

    /// Set the stiffness of `sheet` from the room and the heaters.
    pub fn apply(&self, sheet: &mut Sheet, room: &Surroundings) {
        temperature::start_temperatures(sheet, room.celsius);
        let (sensitivity, conductivity) = self.prepare(sheet);
        let Some(mut heat) = sheet.state.heat.take() else { return };
        let whole = sheet.material().young * sheet.material().thickness;
        let centre = sheet.centre_of_mass();
        let normal = mean_normal(sheet);
        let oven = sensitivity * (room.celsius - REFERENCE);
        heat.set_fractions(room.celsius, |mass| {
            let place = sheet.state.x.get(mass);
            let each = self.faces.iter().map(|face| {
                let (way, distance) = (centre - face.centre, centre.distance(face.centre));
                let own = place.distance(face.centre);
                if distance <= 0.0 || own <= 0.0 {
                    return 0.0;
                }
                // Both sides of the sheet absorb heat: the sign of the cosine is irrelevant.
                let (first, second) = (way.dot(normal).abs() / distance, way.dot(face.normal).max(0.0) / distance);
                let solid_angle = face.area * second / (distance * distance);
                let radiant = (face.celsius - room.celsius) * face.emissivity * first * solid_angle;
                let spread = (1.0 + conductivity * (distance - own) / distance).max(0.0);
                radiant / own * sensitivity * spread
            });
            (1.0 - (oven + each.sum::<f64>()) / whole).max(MIN_STIFFNESS)
        });
        sheet.state.heat = Some(heat);
        temperature::update_thermal_stiffness(sheet);
    }
}

/// Mean unit normal of the sheet's lowest layer.
fn mean_normal(sheet: &Sheet) -> DVec3 {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|m| sheet.state.x.get(m as usize));
        (b - a).cross(c - a)
    };
    let sum: DVec3 = match (&sheet.model.triangles, sheet.model.layers.first()) {
        (Some(triangles), _) => triangles.iter().map(area).sum(),
        (None, Some(layer)) => {
            // Normal from the diagonals of the outline.
            let (i, j) = (layer.nx.saturating_sub(1), layer.nz.saturating_sub(1));
            let [a, b, c, d] =
                [(0, 0), (i, j), (i, 0), (0, j)].map(|(i, j)| sheet.state.x.get(layer.at(i, j) as usize));
            (d - c).cross(b - a)
        }
        (None, None) => DVec3::Y,
    };
    sum.normalize_or_zero()
}
