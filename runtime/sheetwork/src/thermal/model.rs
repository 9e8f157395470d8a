//! Thermal model of a world: its sources, and the thermal step.
//!
//! A world has one when its scene has a temperature other than 20 °C. Heat is stepped after motion,
//! with the time step of the motion or, where that is shorter than `MIN_STEP`, when that much time
//! has accumulated. Thermal time is faster than mechanical time by `time_lapse`.

use crate::error::InputError;
use crate::rigid::{RigidView, RigidWorld};
use crate::scene::{BodySpec, HeatMode, Placement, Scene};
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter};
use crate::sheet::{Sheet, Status, temperature};
use crate::thermal::source::{HeatSource, HeatedSheet, SourceInputs, Surroundings, TABLE, hot_body};
use crate::thermal::thesis_mode::ThesisHeat;
use crate::units::parameters::ParameterId as Id;
use crate::units::temperature::REFERENCE;

/// Minimum thermal step, s.
const MIN_STEP: f64 = 1.0 / 240.0;

/// Heat sources, surroundings and time-lapse.
pub struct ThermalModel {
    surroundings: Surroundings,
    time_lapse: f64,
    sources: Vec<Box<dyn HeatSource>>,
    thesis: Option<ThesisHeat>,
    pending: f64,
}

impl ThermalModel {
    /// Thermal model of `scene`; `None` where everything is at 20 °C.
    ///
    /// # Errors
    /// When the file of a heater is invalid.
    pub fn of(scene: &Scene) -> Result<Option<Self>, InputError> {
        let warm = scene.ambient_temperature != REFERENCE
            || scene.oven.is_some()
            || !scene.heaters.is_empty()
            || scene.heat_gun.is_some()
            || scene.bodies.iter().any(BodySpec::is_hot)
            || scene.sheets.iter().any(|s| s.temperature.is_some() || s.temperature_gradient || !s.spots.is_empty());
        if warm { Self::new(scene).map(Some) } else { Ok(None) }
    }

    /// Thermal model of `scene`, also where everything is at 20 °C.
    ///
    /// # Errors
    /// As [`ThermalModel::of`].
    pub fn new(scene: &Scene) -> Result<Self, InputError> {
        let mut sources = Vec::new();
        for kind in TABLE {
            sources.extend((kind.build)(scene)?);
        }
        let surroundings = Surroundings { celsius: scene.ambient_temperature, convection: scene.convection };
        let mut room = Self { surroundings, time_lapse: scene.time_lapse, sources, thesis: None, pending: 0.0 };
        room.set_heat_mode(scene.heat_mode);
        Ok(room)
    }

    /// Add a source.
    pub fn add(&mut self, source: Box<dyn HeatSource>) {
        self.sources.push(source);
    }

    /// Add the hot body `name` of `spec` with contact conductance `conductance` (W/(m² K)).
    pub fn add_body(&mut self, name: &str, spec: &BodySpec, conductance: f64) {
        let source = hot_body::of(name, spec, conductance);
        // The source of a removed body is reused.
        match self.sources.iter_mut().find(|s| s.path() == source.path()) {
            Some(old) => *old = source,
            None => self.add(source),
        }
    }

    /// Remove the source at `path`. Returns `false` when there is none.
    pub fn remove(&mut self, path: &str) -> bool {
        let before = self.sources.len();
        self.sources.retain(|s| s.path() != path);
        before != self.sources.len()
    }

    /// Move the source at `path` to `placement`. Returns `false` when there is none that can be
    /// moved.
    pub fn place(&mut self, path: &str, placement: &Placement) -> bool {
        self.sources.iter_mut().find(|s| s.path() == path).is_some_and(|s| s.place(placement))
    }

    /// Set the heat mode.
    pub fn set_heat_mode(&mut self, mode: HeatMode) {
        self.thesis = match mode {
            HeatMode::Physical => None,
            HeatMode::Thesis { sensitivity, conductivity } => {
                Some(ThesisHeat { sensitivity, conductivity, faces: Vec::new() })
            }
        };
    }

    /// Prepare `sheet`, which is at `celsius` (°C) until it is heated.
    pub fn prepare(&self, sheet: &mut Sheet, celsius: f64) {
        temperature::start_temperatures(sheet, celsius);
        if let Some(thesis) = &self.thesis {
            thesis.prepare(sheet);
        }
    }

    /// Set surroundings and time-lapse of `scene`.
    pub fn set_surroundings(&mut self, scene: &Scene) {
        self.surroundings = Surroundings { celsius: scene.ambient_temperature, convection: scene.convection };
        self.time_lapse = scene.time_lapse;
    }

    /// Surroundings at `time` (s).
    pub fn surroundings(&self, time: f64) -> Surroundings {
        let mut room = self.surroundings;
        self.sources.iter().for_each(|s| s.modify_surroundings(time, &mut room));
        room
    }

    /// Step the heat of all sheets after their motion from `time` by `dt` (s).
    pub fn step(
        &mut self,
        sheets: &mut [Sheet],
        (time, dt): (f64, f64),
        view: Option<&RigidView>,
        rigid: Option<&RigidWorld>,
    ) {
        self.pending += dt;
        // The tolerance absorbs rounding.
        if self.pending < MIN_STEP * (1.0 - 1e-9) {
            return;
        }
        let span = std::mem::take(&mut self.pending) * self.time_lapse;
        self.advance(sheets, time + dt, span, view, rigid);
    }

    /// Step the heat of all sheets by `dt` (s) from `time` on, without the minimum step and without
    /// bodies.
    pub fn step_whole(&mut self, sheets: &mut [Sheet], (time, dt): (f64, f64)) {
        self.advance(sheets, time + dt, dt * self.time_lapse, None, None);
    }

    /// Advance heat by `span` (s) with the sheets at their positions of `time`.
    fn advance(
        &mut self,
        sheets: &mut [Sheet],
        time: f64,
        span: f64,
        view: Option<&RigidView>,
        rigid: Option<&RigidWorld>,
    ) {
        let room = self.surroundings(time);
        if let Some(thesis) = &mut self.thesis {
            thesis.faces.clear();
            self.sources.iter().for_each(|source| source.add_hot_faces(&mut thesis.faces));
            sheets.iter_mut().for_each(|sheet| thesis.apply(sheet, &room));
            return;
        }
        let moment = SourceInputs { time, room, view, rigid };
        for (index, sheet) in sheets.iter_mut().enumerate() {
            if !matches!(sheet.state.status, Status::Unstable { .. }) {
                self.heat(index, sheet, &moment, span);
            }
        }
    }

    fn heat(&mut self, index: usize, sheet: &mut Sheet, moment: &SourceInputs, span: f64) {
        temperature::start_temperatures(sheet, moment.room.celsius);
        // A sheet at the temperature of its surroundings keeps it.
        let is_even = sheet.state.heat.as_ref().is_some_and(|heat| heat.is_all_at(moment.room.celsius));
        if is_even && !self.sources.iter().any(|s| s.is_active()) {
            return temperature::update_thermal_stiffness(sheet);
        }
        let Some(mut heat) = sheet.state.heat.take() else { return };
        let body = heat.body(sheet);
        body.faces.update_normals(sheet);
        body.exchange.clear(body.stepper.network().capacity.len());
        let mut target = HeatedSheet { sheet, faces: &body.faces, exchange: &mut body.exchange };
        self.sources.iter_mut().for_each(|source| source.add_exchange(index, moment, &mut target));
        heat.advance(span);
        sheet.state.heat = Some(heat);
        temperature::update_thermal_stiffness(sheet);
    }

    /// Serialise the settings of the model and its sources.
    pub fn serialise_settings(&self, to: &mut StateWriter) {
        to.numbers(&[self.surroundings.celsius, self.surroundings.convection, self.time_lapse]);
        to.count(self.sources.len() as u64);
        self.sources.iter().for_each(|s| s.serialise_settings(to));
    }

    /// Deserialise the settings.
    pub fn deserialise_settings(&mut self, from: &mut StateReader) -> ReadResult {
        self.surroundings = Surroundings { celsius: from.number()?, convection: from.number()? };
        self.time_lapse = from.number()?;
        if from.count()? != self.sources.len() as u64 {
            return Err(CorruptState);
        }
        self.sources.iter_mut().try_for_each(|s| s.deserialise_settings(from))
    }

    /// Serialise the state that steps depend on.
    pub fn serialise(&self, to: &mut StateWriter) {
        to.number(self.pending);
        self.sources.iter().for_each(|s| s.serialise(to));
    }

    /// Deserialise the state, for these sheets.
    pub fn deserialise(&mut self, from: &mut StateReader, sheets: &[Sheet]) -> ReadResult {
        self.pending = from.number()?;
        self.sources.iter_mut().try_for_each(|s| s.deserialise(from, sheets))
    }

    /// Number of sources.
    pub fn sources(&self) -> usize {
        self.sources.len()
    }

    /// Discard the state of each sheet, after sheets were added or removed.
    pub fn discard_views(&mut self) {
        self.sources.iter_mut().for_each(|s| s.discard_views());
    }

    /// Parameters that can change while the world runs: identifier, name of the source, and value.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = (Id, &str, f64)> {
        let own = [
            (Id::AmbientTemperature, self.surroundings.celsius),
            (Id::Convection, self.surroundings.convection),
            (Id::TimeLapse, self.time_lapse),
        ];
        let sources =
            self.sources.iter().flat_map(move |s| s.parameters().iter().map(|id| (*id, s.name(), s.parameter(*id))));
        own.into_iter().map(|(id, value)| (id, "", value)).chain(sources)
    }

    /// Set the parameter `id` of the source `name`. Returns `false` when there is no such source.
    pub(crate) fn set_parameter(&mut self, id: Id, name: &str, value: f64) -> bool {
        match id {
            Id::AmbientTemperature => self.surroundings.celsius = value,
            Id::Convection => self.surroundings.convection = value,
            Id::TimeLapse => self.time_lapse = value,
            _ => {
                let mut sources = self.sources.iter_mut();
                let Some(source) = sources.find(|s| s.name() == name && s.parameters().contains(&id)) else {
                    return false;
                };
                source.set_parameter(id, value);
            }
        }
        true
    }
}
