//! Oven: the whole room, its air and its walls, at one temperature, which can change or be switched
//! at any time.

use crate::error::InputError;
use crate::scene::{OvenKey, OvenSpec, Scene};
use crate::serialize::{ReadResult, State, StateReader, StateWriter, state};
use crate::thermal::source::{HeatSource, SourceKind, Surroundings};
use crate::units::parameters::ParameterId as Id;

pub(crate) const KIND: SourceKind = SourceKind { name: "oven", about: "the whole room at a temperature", build };

fn build(scene: &Scene) -> Result<Vec<Box<dyn HeatSource>>, InputError> {
    Ok(scene.oven.iter().map(of).collect())
}

/// Oven of `spec`.
pub(crate) fn of(spec: &OvenSpec) -> Box<dyn HeatSource> {
    Box::new(Oven { spec: spec.clone() })
}

/// Parameter path of the oven.
pub(crate) const PATH: &str = "oven";

/// Read the schedule that `StateWriter::states` wrote.
pub(crate) fn read_schedule(from: &mut StateReader) -> ReadResult<Vec<OvenKey>> {
    let keys: Vec<(f64, Option<f64>)> = from.states(9)?;
    Ok(keys.into_iter().map(|(time, temperature)| OvenKey { time, temperature }).collect())
}

struct Oven {
    spec: OvenSpec,
}

state!(OvenKey { time, temperature });

impl HeatSource for Oven {
    fn modify_surroundings(&self, time: f64, room: &mut Surroundings) {
        if let Some(celsius) = self.spec.celsius_at(time) {
            room.celsius = celsius;
            room.convection = self.spec.convection.unwrap_or(room.convection);
        }
    }

    fn is_active(&self) -> bool {
        false
    }

    fn path(&self) -> String {
        PATH.into()
    }

    fn parameters(&self) -> &'static [Id] {
        &[Id::OvenTemperature, Id::OvenOn]
    }

    fn parameter(&self, id: Id) -> f64 {
        match id {
            Id::OvenOn => f64::from(u8::from(self.spec.on)),
            _ => self.spec.temperature,
        }
    }

    fn set_parameter(&mut self, id: Id, value: f64) {
        if id == Id::OvenOn {
            self.spec.on = value >= 0.5;
        } else {
            // A set temperature replaces the schedule.
            self.spec.schedule.clear();
            self.spec.temperature = value;
        }
    }

    fn serialise_settings(&self, to: &mut StateWriter) {
        self.spec.on.serialise(to);
        self.spec.temperature.serialise(to);
        // Setting the temperature clears the schedule.
        to.states(&self.spec.schedule);
    }

    fn deserialise_settings(&mut self, from: &mut StateReader) -> ReadResult {
        (self.spec.on, self.spec.temperature) = from.read()?;
        self.spec.schedule = read_schedule(from)?;
        Ok(())
    }
}
