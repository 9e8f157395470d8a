//! Surroundings: heat exchange of a sheet with the air by convection and with the walls by
//! radiation, on both sides,
//!
//!   q = -h (T - T_air) - 2 ε σ (T⁴ - T_wall⁴) per area of the sheet, half of it on each side.
//!
//! h is the coefficient of both sides together. Air and walls have one temperature: the scene's
//! `ambient_temperature`, or that of its oven.

use crate::error::InputError;
use crate::scene::Scene;
use crate::thermal::source::{HeatSource, HeatedSheet, STEFAN_BOLTZMANN, SourceInputs, SourceKind, fourth_power};

pub(crate) const KIND: SourceKind = SourceKind {
    name: "ambient_temperature",
    about: "the room: convection to the air and radiation to the walls, on both sides",
    build,
};

fn build(_scene: &Scene) -> Result<Vec<Box<dyn HeatSource>>, InputError> {
    Ok(vec![Box::new(SurroundingsSource)])
}

/// Source of the room.
struct SurroundingsSource;

impl HeatSource for SurroundingsSource {
    fn is_active(&self) -> bool {
        false
    }

    fn add_exchange(&mut self, _index: usize, moment: &SourceInputs, target: &mut HeatedSheet) {
        let (walls, half) = (fourth_power(moment.room.celsius), 0.5 * moment.room.convection);
        let radiation = target.emissivity() * STEFAN_BOLTZMANN;
        for i in 0..target.faces.patches.len() {
            let patch = target.faces.patches[i];
            target.couple(patch, moment.room.celsius, half * patch.area);
            let node = patch.node as usize;
            target.exchange.radiation[node] += radiation * patch.area;
            target.exchange.supply[node] += radiation * patch.area * walls;
        }
    }
}
