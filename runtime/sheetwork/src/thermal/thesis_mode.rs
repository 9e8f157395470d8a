//! Heat as the thesis has it (4.11.1): stiffness follows from where things are and how hot, at once; nothing warms up or cools.
//!
//! With K the stiffness of a planar spring (E t, N/m), Ht and At (°C) the temperatures of the source and of the room, C the thermal
//! sensitivity (N/K) and d (m) a distance, a spring has K - (Ht - At)/d · C left (equation 4.4):
//!
//! - oven: all springs alike, d = 1 m, Ht its temperature, At 20 °C;
//! - heater: Ht - At is the hot face's, times what the sheet intercepts of it by equations 4.1 to 4.3 at its centre, ε cos Θ₁ ω with
//!   ω = A cos Θ₂/D² the solid angle as if all of the face were at its centre; d is a spring's own distance from there, and the
//!   loss is weighted by 1 + c (D - d)/D with c the thermal conductivity coefficient.
//!
//! The thesis leaves open in which units; these are ours. A hundredth of the stiffness always stays. Kept to be compared with: the
//! solid angle is wrong by a third at a distance of one side and by a factor of thirty at a tenth.

use glam::DVec3;

use crate::error::InputError;
use crate::scene::Scene;
use crate::sheet::Sheet;
use crate::thermal::REFERENCE;
use crate::thermal::source::Surroundings;

/// Part of the stiffness that always stays.
const LEAST: f64 = 0.01;

/// A hot face, as the thesis sees it.
struct Face {
    centre: DVec3,
    normal: DVec3,
    area: f64,
    celsius: f64,
    emissivity: f64,
}

/// The thesis's heat.
pub(crate) struct Thesis {
    faces: Vec<Face>,
    /// C, N/K.
    sensitivity: f64,
    /// c.
    conductivity: f64,
}

impl Thesis {
    /// That of `scene`.
    ///
    /// # Errors
    /// When a heater's file is not valid.
    pub fn new(scene: &Scene, sensitivity: f64, conductivity: f64) -> Result<Self, InputError> {
        let mut faces = Vec::new();
        for spec in scene.heaters.iter().filter(|h| h.on) {
            for heater in spec.resolve(&scene.base)? {
                for (i, face) in heater.faces.iter().enumerate() {
                    let Some(celsius) = face.temperature else { continue };
                    let corners = heater.polyhedron.corners(i);
                    let centre = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
                    faces.push(Face {
                        centre: spec.placement.apply(centre),
                        normal: spec.placement.quaternion() * heater.polyhedron.face_normal(i),
                        area: heater.polyhedron.face_area(i),
                        celsius,
                        emissivity: face.emissivity,
                    });
                }
            }
        }
        Ok(Self { faces, sensitivity, conductivity })
    }

    /// Makes `sheet` as soft as the room and the heaters have it.
    pub fn soften(&self, sheet: &mut Sheet, room: &Surroundings) {
        sheet.begin_heat(room.celsius);
        let Some(mut heat) = sheet.heat.take() else { return };
        let whole = sheet.material().young * sheet.material().thickness;
        let centre = sheet.centre_of_mass();
        let normal = mean_normal(sheet);
        let oven = self.sensitivity * (room.celsius - REFERENCE);
        heat.set_fractions(room.celsius, |mass| {
            let place = sheet.x.get(mass);
            let each = self.faces.iter().map(|face| {
                let (way, distance) = (centre - face.centre, centre.distance(face.centre));
                let own = place.distance(face.centre);
                if distance <= 0.0 || own <= 0.0 {
                    return 0.0;
                }
                // Both sides of the sheet take up heat: the cosine's sign does not matter.
                let (first, second) = (way.dot(normal).abs() / distance, way.dot(face.normal).max(0.0) / distance);
                let solid_angle = face.area * second / (distance * distance);
                let radiant = (face.celsius - room.celsius) * face.emissivity * first * solid_angle;
                let spread = (1.0 + self.conductivity * (distance - own) / distance).max(0.0);
                radiant / own * self.sensitivity * spread
            });
            (1.0 - (oven + each.sum::<f64>()) / whole).max(LEAST)
        });
        sheet.heat = Some(heat);
        sheet.follow_heat();
    }
}

/// Unit normal of the sheet's lowest layer, averaged.
fn mean_normal(sheet: &Sheet) -> DVec3 {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|m| sheet.x.get(m as usize));
        (b - a).cross(c - a)
    };
    let sum: DVec3 = match (&sheet.triangles, sheet.layers.first()) {
        (Some(triangles), _) => triangles.iter().map(area).sum(),
        (None, Some(layer)) => {
            // By the diagonals of the outline.
            let (i, j) = (layer.nx.saturating_sub(1), layer.nz.saturating_sub(1));
            let [a, b, c, d] = [(0, 0), (i, j), (i, 0), (0, j)].map(|(i, j)| sheet.x.get(layer.at(i, j) as usize));
            (d - c).cross(b - a)
        }
        (None, None) => DVec3::Y,
    };
    sum.normalize_or_zero()
}
