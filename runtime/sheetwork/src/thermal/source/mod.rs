//! Sources of heat: the surroundings, an oven, heaters, hot bodies, a heat gun.
//!
//! One file a source and one row in [`TABLE`]. A source adds to the [`Exchange`] of a sheet what its patches take up; the sheet's
//! own losses are `surroundings`'. Sources are looked at once a step of heat, at its start.

pub mod gun;
pub mod heater;
pub mod hot_body;
pub mod oven;
pub mod surroundings;

use glam::DVec3;

use crate::error::InputError;
use crate::rigid::{RigidView, RigidWorld};
use crate::scene::{Placement, Scene};
use crate::serialize::{Keeper, Taken, Taker};
use crate::sheet::Sheet;
use crate::thermal::patches::{Faces, Patch};
use crate::thermal::stepper::Exchange;
use crate::thermal::{STEFAN_BOLTZMANN, ZERO_CELSIUS};

/// A kind of source.
pub struct Kind {
    /// Its name, as in a scene.
    pub name: &'static str,
    /// One line on what it does.
    pub about: &'static str,
    /// Those of a scene.
    pub(crate) build: fn(&Scene) -> Result<Vec<Box<dyn Source>>, InputError>,
}

/// Every kind, in the order in which they give: the surroundings first.
pub const TABLE: &[Kind] = &[surroundings::KIND, oven::KIND, heater::KIND, hot_body::KIND, gun::KIND];

/// What a source is asked with.
pub struct Moment<'a> {
    /// Simulated time of the sheet's motion, s.
    pub time: f64,
    /// How warm the room is.
    pub room: Surroundings,
    /// Bodies, where there are any to be touched or to throw a shadow.
    pub view: Option<&'a RigidView<'a>>,
    /// The world's own bodies.
    pub rigid: Option<&'a RigidWorld>,
}

/// The surroundings: air and walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// Temperature, °C.
    pub celsius: f64,
    /// Convection of both sides of a sheet together, W/(m² K).
    pub convection: f64,
}

impl Surroundings {
    /// T⁴ of the walls, K⁴.
    pub fn fourth_power(&self) -> f64 {
        fourth_power(self.celsius)
    }
}

/// (T + 273.15)⁴, K⁴.
pub fn fourth_power(celsius: f64) -> f64 {
    let kelvin = celsius + ZERO_CELSIUS;
    kelvin * kelvin * kelvin * kelvin
}

/// A sheet as a source sees it.
pub struct Target<'a> {
    /// The sheet.
    pub sheet: &'a Sheet,
    /// Its sides.
    pub faces: &'a Faces,
    /// What its nodes exchange: to be added to.
    pub exchange: &'a mut Exchange,
}

impl Target<'_> {
    /// Patches with their places (m) and normals.
    pub fn patches(&self) -> impl Iterator<Item = (Patch, DVec3, DVec3)> + use<'_> {
        let Self { sheet, faces, .. } = self;
        faces.patches.iter().zip(&faces.normals).map(|(p, n)| (*p, sheet.x.get(p.mass as usize), *n))
    }

    /// Emissivity of the sheet.
    pub fn emissivity(&self) -> f64 {
        self.sheet.material().emissivity
    }

    /// `patch` exchanges with what is `celsius` warm by `conductance` (W/K).
    pub fn couple(&mut self, patch: Patch, celsius: f64, conductance: f64) {
        let node = patch.node as usize;
        self.exchange.supply[node] += conductance * celsius;
        self.exchange.convection[node] += conductance;
    }

    /// `patch` takes up what `view_factor` of it receives from a face that sends out like a black one for which T⁴ is
    /// `above` K⁴ more than the walls'.
    pub fn irradiate(&mut self, patch: Patch, view_factor: f64, above: f64) {
        let taken = self.emissivity() * STEFAN_BOLTZMANN * patch.area * view_factor * above;
        self.exchange.supply[patch.node as usize] += taken;
    }
}

/// A number of a source that can be changed while the world runs.
pub struct Dial {
    /// Its path in the world: `oven.temperature`.
    pub path: String,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// Its range.
    pub range: (f64, f64),
}

/// Gives heat to sheets, or takes it.
pub trait Source: Send + Sync {
    /// What of its surroundings is another for it: an oven's are warm.
    fn surround(&self, _time: f64, _room: &mut Surroundings) {}

    /// Whether it gives anything to a sheet that is as warm as its surroundings, or takes it.
    fn is_at_work(&self) -> bool {
        true
    }

    /// Adds what sheet number `index` takes up.
    fn give(&mut self, index: usize, moment: &Moment, target: &mut Target);

    /// Where its numbers are among the world's parameters: `oven`, `heaters.lamp`. The room's have no common place.
    fn path(&self) -> String {
        String::new()
    }

    /// Goes to `placement`; false where it has no place that can be changed so.
    fn place(&mut self, _placement: &Placement) -> bool {
        false
    }

    /// What can be changed of it.
    fn dials(&self) -> Vec<Dial> {
        Vec::new()
    }

    /// Takes up `value` for the dial at `path`, which has been checked; false where it has no such dial.
    fn turn(&mut self, _path: &str, _value: f64) -> bool {
        false
    }

    /// Keeps for a snapshot what can be changed of it.
    fn keep_settings(&self, _to: &mut Keeper) {}

    /// Takes that back.
    fn take_settings(&mut self, _from: &mut Taker) -> Taken {
        Ok(())
    }

    /// Keeps what it carries from step to step.
    fn keep(&self, _to: &mut Keeper) {}

    /// Takes that back, for these sheets.
    fn take(&mut self, _from: &mut Taker, _sheets: &[Sheet]) -> Taken {
        Ok(())
    }

    /// Sheets were added or removed: what is kept for each is no longer theirs.
    fn forget(&mut self) {}
}
