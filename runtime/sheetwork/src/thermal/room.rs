//! Thermal model of a world: its sources, and the thermal step.
//!
//! A world has one when its scene has a temperature other than 20 °C. Heat is stepped after motion,
//! with the time step of the motion or, where that is shorter than `SHORTEST`, when that much time
//! has accumulated. Thermal time is faster than mechanical time by `time_lapse`.

use crate::error::{InputError, check_range};
use crate::rigid::{RigidView, RigidWorld};
use crate::scene::{HeatMode, Placement, Scene};
use crate::serialize::{Cut, Keeper, Taken, Taker};
use crate::sheet::{Sheet, Status};
use crate::thermal::source::{Dial, Moment, Source, Surroundings, TABLE, Target, hot_body};
use crate::thermal::thesis_mode::Thesis;
use crate::units::temperature::{COLDEST, HOTTEST, REFERENCE};

/// Minimum thermal step, s.
const SHORTEST: f64 = 1.0 / 240.0;

/// Heat sources, surroundings and time-lapse.
pub struct Room {
    surroundings: Surroundings,
    time_lapse: f64,
    sources: Vec<Box<dyn Source>>,
    thesis: Option<Thesis>,
    pending: f64,
}

impl Room {
    /// Thermal model of `scene`; `None` where everything is at 20 °C.
    ///
    /// # Errors
    /// When the file of a heater is invalid.
    pub fn of(scene: &Scene) -> Result<Option<Self>, InputError> {
        let warm = scene.ambient_temperature != REFERENCE
            || scene.oven.is_some()
            || !scene.heaters.is_empty()
            || scene.heat_gun.is_some()
            || scene.bodies.iter().any(|b| b.temperature.is_some())
            || scene.sheets.iter().any(|s| s.temperature.is_some() || s.temperature_gradient || !s.spots.is_empty());
        if warm { Self::new(scene).map(Some) } else { Ok(None) }
    }

    /// Thermal model of `scene`, also where everything is at 20 °C.
    ///
    /// # Errors
    /// As [`Room::of`].
    pub fn new(scene: &Scene) -> Result<Self, InputError> {
        let mut sources = Vec::new();
        for kind in TABLE {
            sources.extend((kind.build)(scene)?);
        }
        let surroundings = Surroundings { celsius: scene.ambient_temperature, convection: scene.convection };
        let mut room = Self { surroundings, time_lapse: scene.time_lapse, sources, thesis: None, pending: 0.0 };
        room.model(scene)?;
        Ok(room)
    }

    /// Add a source.
    pub fn add(&mut self, source: Box<dyn Source>) {
        self.sources.push(source);
    }

    /// Add a body at `celsius` (°C) with contact conductance `conductance` (W/(m² K)).
    pub fn add_body(&mut self, name: &str, celsius: f64, conductance: f64) {
        let path = hot_body::path_of(name);
        // The source of a removed body is reused.
        if !self.sources.iter_mut().any(|s| s.turn(&path, celsius)) {
            self.add(hot_body::of(name, celsius, conductance));
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

    /// Set the heat mode of `scene`; the thesis's formulas read its heaters.
    ///
    /// # Errors
    /// When the file of a heater is invalid; nothing changes then.
    pub fn model(&mut self, scene: &Scene) -> Result<(), InputError> {
        self.thesis = match scene.heat_mode {
            HeatMode::Physical => None,
            HeatMode::Thesis { sensitivity, conductivity } => Some(Thesis::new(scene, sensitivity, conductivity)?),
        };
        Ok(())
    }

    /// Set surroundings and time-lapse of `scene`.
    pub fn surround(&mut self, scene: &Scene) {
        self.surroundings = Surroundings { celsius: scene.ambient_temperature, convection: scene.convection };
        self.time_lapse = scene.time_lapse;
    }

    /// Surroundings at `time` (s).
    pub fn surroundings(&self, time: f64) -> Surroundings {
        let mut room = self.surroundings;
        self.sources.iter().for_each(|s| s.surround(time, &mut room));
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
        if self.pending < SHORTEST * (1.0 - 1e-9) {
            return;
        }
        let span = std::mem::take(&mut self.pending) * self.time_lapse;
        self.pass(sheets, time + dt, span, view, rigid);
    }

    /// Step the heat of all sheets by `dt` (s) from `time` on, without the minimum step and without
    /// bodies.
    pub fn step_whole(&mut self, sheets: &mut [Sheet], (time, dt): (f64, f64)) {
        self.pass(sheets, time + dt, dt * self.time_lapse, None, None);
    }

    /// Advance heat by `span` (s) with the sheets at their positions of `time`.
    fn pass(
        &mut self,
        sheets: &mut [Sheet],
        time: f64,
        span: f64,
        view: Option<&RigidView>,
        rigid: Option<&RigidWorld>,
    ) {
        let room = self.surroundings(time);
        if let Some(thesis) = &self.thesis {
            sheets.iter_mut().for_each(|sheet| thesis.soften(sheet, &room));
            return;
        }
        let moment = Moment { time, room, view, rigid };
        for (index, sheet) in sheets.iter_mut().enumerate() {
            if !matches!(sheet.status, Status::Unstable { .. }) {
                self.heat(index, sheet, &moment, span);
            }
        }
    }

    fn heat(&mut self, index: usize, sheet: &mut Sheet, moment: &Moment, span: f64) {
        sheet.begin_heat(moment.room.celsius);
        // A sheet at the temperature of its surroundings keeps it.
        let is_even = sheet.heat.as_ref().is_some_and(|heat| heat.is_all_at(moment.room.celsius));
        if is_even && !self.sources.iter().any(|s| s.is_at_work()) {
            return sheet.follow_heat();
        }
        let Some(mut heat) = sheet.heat.take() else { return };
        let body = heat.body(sheet);
        body.faces.turn(sheet);
        body.exchange.clear(body.stepper.network().capacity.len());
        let mut target = Target { sheet, faces: &body.faces, exchange: &mut body.exchange };
        self.sources.iter_mut().for_each(|source| source.give(index, moment, &mut target));
        heat.advance(span);
        sheet.heat = Some(heat);
        sheet.follow_heat();
    }

    /// Serialise the settings of the model and its sources.
    pub fn keep_settings(&self, to: &mut Keeper) {
        to.numbers(&[self.surroundings.celsius, self.surroundings.convection, self.time_lapse]);
        to.count(self.sources.len() as u64);
        self.sources.iter().for_each(|s| s.keep_settings(to));
    }

    /// Deserialise the settings.
    pub fn take_settings(&mut self, from: &mut Taker) -> Taken {
        self.surroundings = Surroundings { celsius: from.number()?, convection: from.number()? };
        self.time_lapse = from.number()?;
        if from.count()? != self.sources.len() as u64 {
            return Err(Cut);
        }
        self.sources.iter_mut().try_for_each(|s| s.take_settings(from))
    }

    /// Serialise the state that steps depend on.
    pub fn keep(&self, to: &mut Keeper) {
        to.number(self.pending);
        self.sources.iter().for_each(|s| s.keep(to));
    }

    /// Deserialise the state, for these sheets.
    pub fn take(&mut self, from: &mut Taker, sheets: &[Sheet]) -> Taken {
        self.pending = from.number()?;
        self.sources.iter_mut().try_for_each(|s| s.take(from, sheets))
    }

    /// Number of sources.
    pub fn sources(&self) -> usize {
        self.sources.len()
    }

    /// Discard the state of each sheet, after sheets were added or removed.
    pub fn forget(&mut self) {
        self.sources.iter_mut().for_each(|s| s.forget());
    }

    /// Parameters that can change while the world runs.
    pub fn dials(&self) -> Vec<Dial> {
        let dial = |path: &str, value, unit, range| Dial { path: path.into(), value, unit, range };
        let mut all = vec![
            dial("ambient_temperature", self.surroundings.celsius, "°C", (COLDEST, HOTTEST)),
            dial("convection", self.surroundings.convection, "W/(m² K)", (0.0, 1e6)),
            dial("time_lapse", self.time_lapse, "", (1e-3, 1e4)),
        ];
        all.extend(self.sources.iter().flat_map(|s| s.dials()));
        all
    }

    /// Set the parameter at `path`. Returns `false` when there is none.
    ///
    /// # Errors
    /// When it is out of range; nothing changes then.
    pub fn turn(&mut self, path: &str, value: f64) -> Result<bool, InputError> {
        let Some(dial) = self.dials().into_iter().find(|d| d.path == path) else { return Ok(false) };
        check_range(path, value, dial.range.0, dial.range.1, dial.unit)?;
        match path {
            "ambient_temperature" => self.surroundings.celsius = value,
            "convection" => self.surroundings.convection = value,
            "time_lapse" => self.time_lapse = value,
            _ => return Ok(self.sources.iter_mut().any(|s| s.turn(path, value))),
        }
        Ok(true)
    }
}
