//! Heat sources: surroundings, oven, heaters, hot bodies, heat gun.
//!
//! Each source has one file and one row in [`TABLE`]. A source adds the heat exchange of its
//! patches to the [`Exchange`] of a sheet; `surroundings` adds the losses of the sheet. Sources are
//! evaluated once per thermal step, at its start.

pub mod heat_gun;
pub mod heater;
pub mod hot_body;
pub mod oven;
pub mod surroundings;

use glam::DVec3;

use crate::error::InputError;
use crate::rigid::{RigidView, RigidWorld};
use crate::scene::{Placement, Scene};
use crate::serialize::{ReadResult, StateReader, StateWriter};
use crate::sheet::Sheet;
use crate::sheet::temperature::conduction::Exchange;
use crate::sheet::temperature::patches::{Patch, SheetPatches};
use crate::units::parameters::ParameterId;
use crate::units::temperature::{STEFAN_BOLTZMANN, ZERO_CELSIUS};

/// Kind of source.
pub struct SourceKind {
    /// Name, as in a scene.
    pub name: &'static str,
    /// Description in one line.
    pub about: &'static str,
    /// Sources of this kind in a scene.
    pub(crate) build: fn(&Scene) -> Result<Vec<Box<dyn HeatSource>>, InputError>,
}

/// All kinds, in the order of evaluation: the surroundings first.
pub const TABLE: &[SourceKind] = &[surroundings::KIND, oven::KIND, heater::KIND, hot_body::KIND, heat_gun::KIND];

/// Inputs of a source in a step.
pub struct SourceInputs<'a> {
    /// Simulated time of the motion, s.
    pub time: f64,
    /// Temperature of the room.
    pub room: Surroundings,
    /// Bodies for contact and shadows, if any.
    pub view: Option<&'a RigidView<'a>>,
    /// The world's own bodies.
    pub rigid: Option<&'a RigidWorld>,
}

/// Surroundings: air and walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// Temperature, °C.
    pub celsius: f64,
    /// Convection coefficient of both sides of a sheet together, W/(m² K).
    pub convection: f64,
}

/// (T + 273.15)⁴, K⁴.
pub fn fourth_power(celsius: f64) -> f64 {
    let kelvin = celsius + ZERO_CELSIUS;
    kelvin * kelvin * kelvin * kelvin
}

/// Sheet as a source sees it.
pub struct HeatedSheet<'a> {
    /// The sheet.
    pub sheet: &'a Sheet,
    /// Patches of the sheet.
    pub faces: &'a SheetPatches,
    /// Exchange of the thermal nodes, to which sources add.
    pub exchange: &'a mut Exchange,
}

impl HeatedSheet<'_> {
    /// Emissivity of the sheet.
    pub fn emissivity(&self) -> f64 {
        self.sheet.material().emissivity
    }

    /// Add an exchange of `patch` with a temperature `celsius` (°C) through `conductance` (W/K).
    pub fn couple(&mut self, patch: Patch, celsius: f64, conductance: f64) {
        let node = patch.node as usize;
        self.exchange.supply[node] += conductance * celsius;
        self.exchange.convection[node] += conductance;
    }

    /// Add the radiation that `patch` absorbs with `view_factor` from a black face whose T⁴ exceeds
    /// that of the walls by `above` (K⁴).
    pub fn irradiate(&mut self, patch: Patch, view_factor: f64, above: f64) {
        let taken = self.emissivity() * STEFAN_BOLTZMANN * patch.area * view_factor * above;
        self.exchange.supply[patch.node as usize] += taken;
    }
}

/// Plane hot face, for the formulas of the thesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HotPlane {
    /// Centre, m.
    pub centre: DVec3,
    /// Outward unit normal.
    pub normal: DVec3,
    /// Area, m².
    pub area: f64,
    /// Temperature, °C.
    pub celsius: f64,
    /// Emissivity.
    pub emissivity: f64,
}

/// Heat source.
pub trait HeatSource: Send + Sync {
    /// Change the surroundings, as an oven does.
    fn modify_surroundings(&self, _time: f64, _room: &mut Surroundings) {}

    /// Whether the source exchanges heat with a sheet at the temperature of its surroundings.
    fn is_active(&self) -> bool {
        true
    }

    /// Add the heat exchange of the sheet `_index`.
    fn add_exchange(&mut self, _index: usize, _moment: &SourceInputs, _target: &mut HeatedSheet) {}

    /// Append the source's hot faces at present to `_faces`: none while it is off.
    fn add_hot_faces(&self, _faces: &mut Vec<HotPlane>) {}

    /// Path of the source's parameters: `oven`, `heaters.lamp`. Empty for the room.
    fn path(&self) -> String {
        String::new()
    }

    /// Move the source to `placement`. Returns `false` when its placement is fixed.
    fn place(&mut self, _placement: &Placement) -> bool {
        false
    }

    /// Name that stands for `*` in the paths of the source's parameters; empty where there is only
    /// one source of the kind.
    fn name(&self) -> &str {
        ""
    }

    /// Parameters that can change while the world runs.
    fn parameters(&self) -> &'static [ParameterId] {
        &[]
    }

    /// Value of one of these parameters; a switch is 0 or 1.
    fn parameter(&self, _id: ParameterId) -> f64 {
        0.0
    }

    /// Set one of these parameters to `value`, which has been checked.
    fn set_parameter(&mut self, _id: ParameterId, _value: f64) {}

    /// Serialise the settings for a snapshot.
    fn serialise_settings(&self, _to: &mut StateWriter) {}

    /// Deserialise the settings.
    fn deserialise_settings(&mut self, _from: &mut StateReader) -> ReadResult {
        Ok(())
    }

    /// Serialise the state that steps depend on.
    fn serialise(&self, _to: &mut StateWriter) {}

    /// Deserialise the state, for these sheets.
    fn deserialise(&mut self, _from: &mut StateReader, _sheets: &[Sheet]) -> ReadResult {
        Ok(())
    }

    /// Discard the state of each sheet, after sheets were added or removed.
    fn discard_views(&mut self) {}
}
