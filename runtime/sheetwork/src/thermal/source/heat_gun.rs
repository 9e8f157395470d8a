//! Heat gun: a jet of hot air in a cone, moved along a path or by the program.
//!
//! A patch that faces the nozzle, at a distance d from it and at an angle θ from the axis of the
//! jet, is in air of the gun's temperature with
//!
//!   h = h₀ cos φ e^(-(θ/θ₀)²) r/(r + d),
//!
//! θ₀ the half angle, r the reach (at which h falls to a half) and φ the angle between the normal
//! of the patch and the direction to the nozzle. The model is generic: h₀ (W/(m² K)) and r (m) are
//! to be set from a measurement.

use glam::DVec3;

use crate::error::InputError;
use crate::scene::{HeatGunSpec, Placement, Scene, path_at};
use crate::serialize::{ReadResult, State, StateReader, StateWriter};
use crate::thermal::source::{HeatSource, HeatedSheet, SourceInputs, SourceKind};
use crate::units::parameters::ParameterId as Id;

/// Angle from the axis, in half angles, beyond which the jet ends.
const MAX_HALF_ANGLES: f64 = 3.0;

pub(crate) const KIND: SourceKind =
    SourceKind { name: "heat_gun", about: "a jet of hot air in a cone that moves", build };

fn build(scene: &Scene) -> Result<Vec<Box<dyn HeatSource>>, InputError> {
    Ok(scene.heat_gun.iter().map(of).collect())
}

/// Heat gun of `spec`.
pub(crate) fn of(spec: &HeatGunSpec) -> Box<dyn HeatSource> {
    Box::new(HeatGun { spec: spec.clone() })
}

/// Parameter path of the heat gun.
pub(crate) const PATH: &str = "heat_gun";

struct HeatGun {
    spec: HeatGunSpec,
}

impl HeatGun {
    /// Position of the nozzle (m) and direction of the jet at `time` (s).
    fn aim(&self, time: f64) -> (DVec3, DVec3) {
        let (offset, turn) = path_at(&self.spec.path, time);
        let turn = Placement { position: DVec3::ZERO, rotation: turn }.quaternion();
        (self.spec.position + offset, (turn * self.spec.direction).normalize_or_zero())
    }

    /// Convection coefficient h at a patch, W/(m² K).
    fn convection(&self, nozzle: DVec3, axis: DVec3, place: DVec3, normal: DVec3) -> f64 {
        let way = place - nozzle;
        let distance = way.length();
        let facing = if distance > 0.0 { -normal.dot(way) / distance } else { 0.0 };
        if facing <= 0.0 {
            return 0.0;
        }
        let angle = axis.cross(way).length().atan2(axis.dot(way)) / self.spec.half_angle.to_radians();
        if angle > MAX_HALF_ANGLES {
            return 0.0;
        }
        let reach = self.spec.reach / (self.spec.reach + distance);
        self.spec.convection * facing * (-angle * angle).exp() * reach
    }
}

impl HeatSource for HeatGun {
    fn is_active(&self) -> bool {
        self.spec.on
    }

    fn add_exchange(&mut self, _index: usize, moment: &SourceInputs, target: &mut HeatedSheet) {
        if !self.spec.on {
            return;
        }
        let (nozzle, axis) = self.aim(moment.time);
        for i in 0..target.faces.patches.len() {
            let (patch, normal) = (target.faces.patches[i], target.faces.normals[i]);
            let place = target.sheet.state.x.get(patch.mass as usize);
            let h = self.convection(nozzle, axis, place, normal);
            if h > 0.0 {
                target.couple(patch, self.spec.temperature, h * patch.area);
            }
        }
    }

    fn path(&self) -> String {
        PATH.into()
    }

    fn place(&mut self, placement: &Placement) -> bool {
        self.spec.position = placement.position;
        self.spec.direction = placement.quaternion() * DVec3::NEG_Z;
        true
    }

    fn parameters(&self) -> &'static [Id] {
        const ALL: &[Id] = &[
            Id::HeatGunOn,
            Id::HeatGunTemperature,
            Id::HeatGunPositionX,
            Id::HeatGunPositionY,
            Id::HeatGunPositionZ,
            Id::HeatGunDirectionX,
            Id::HeatGunDirectionY,
            Id::HeatGunDirectionZ,
        ];
        ALL
    }

    fn parameter(&self, id: Id) -> f64 {
        match id {
            Id::HeatGunOn => f64::from(u8::from(self.spec.on)),
            Id::HeatGunPositionX => self.spec.position.x,
            Id::HeatGunPositionY => self.spec.position.y,
            Id::HeatGunPositionZ => self.spec.position.z,
            Id::HeatGunDirectionX => self.spec.direction.x,
            Id::HeatGunDirectionY => self.spec.direction.y,
            Id::HeatGunDirectionZ => self.spec.direction.z,
            _ => self.spec.temperature,
        }
    }

    fn set_parameter(&mut self, id: Id, value: f64) {
        match id {
            Id::HeatGunOn => self.spec.on = value >= 0.5,
            Id::HeatGunPositionX => self.spec.position.x = value,
            Id::HeatGunPositionY => self.spec.position.y = value,
            Id::HeatGunPositionZ => self.spec.position.z = value,
            Id::HeatGunDirectionX => self.spec.direction.x = value,
            Id::HeatGunDirectionY => self.spec.direction.y = value,
            Id::HeatGunDirectionZ => self.spec.direction.z = value,
            _ => self.spec.temperature = value,
        }
    }

    fn serialise_settings(&self, to: &mut StateWriter) {
        (self.spec.on, self.spec.temperature).serialise(to);
        (self.spec.position, self.spec.direction).serialise(to);
    }

    fn deserialise_settings(&mut self, from: &mut StateReader) -> ReadResult {
        (self.spec.on, self.spec.temperature) = from.read()?;
        (self.spec.position, self.spec.direction) = from.read()?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_jet_is_strongest_on_its_axis_and_reaches_only_what_faces_it() {
        let spec =
            HeatGunSpec { position: DVec3::new(0.0, 0.3, 0.0), reach: 0.1, half_angle: 10.0, ..Default::default() };
        let gun = HeatGun { spec };
        let (nozzle, axis) = gun.aim(0.0);
        let at = |x: f64, n: DVec3| gun.convection(nozzle, axis, DVec3::new(x, 0.0, 0.0), n);
        assert!((at(0.0, DVec3::Y) / (gun.spec.convection * 0.25) - 1.0).abs() < 1e-12);
        assert_eq!(at(0.0, DVec3::NEG_Y), 0.0);
        let aside = 0.3 * 10_f64.to_radians().tan();
        let distance = 0.3_f64.hypot(aside);
        let wanted = gun.spec.convection * (0.3 / distance) * (-1.0_f64).exp() * 0.1 / (0.1 + distance);
        assert!((at(aside, DVec3::Y) / wanted - 1.0).abs() < 1e-12);
        assert_eq!(at(1.0, DVec3::Y), 0.0);
    }
}
