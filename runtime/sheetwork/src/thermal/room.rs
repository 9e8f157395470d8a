//! The room that heats sheets: its sources, and the step of heat.
//!
//! A world has one when something in its scene is not at 20 °C. Heat is stepped after motion, with the motion's step or, where that is
//! shorter than `SHORTEST`, when as much time has gathered. Its time may run faster than the motion's by `time_lapse`.

use crate::error::{InputError, check_range};
use crate::rigid::{RigidView, RigidWorld};
use crate::scene::{HeatMode, Placement, Scene};
use crate::serialize::{Cut, Keeper, Taken, Taker};
use crate::sheet::{Sheet, Status};
use crate::thermal::source::{Dial, Moment, Source, Surroundings, TABLE, Target, hot_body};
use crate::thermal::thesis_mode::Thesis;
use crate::thermal::{COLDEST, HOTTEST, REFERENCE};

/// Shortest step of heat, s.
const SHORTEST: f64 = 1.0 / 240.0;

/// Sources, and how fast time runs for heat.
pub struct Room {
    surroundings: Surroundings,
    time_lapse: f64,
    sources: Vec<Box<dyn Source>>,
    thesis: Option<Thesis>,
    pending: f64,
}

impl Room {
    /// That of `scene`; none where everything is at 20 °C.
    ///
    /// # Errors
    /// When a heater's file is not valid.
    pub fn of(scene: &Scene) -> Result<Option<Self>, InputError> {
        let warm = scene.ambient_temperature != REFERENCE
            || scene.oven.is_some()
            || !scene.heaters.is_empty()
            || scene.heat_gun.is_some()
            || scene.bodies.iter().any(|b| b.temperature.is_some())
            || scene.sheets.iter().any(|s| s.temperature.is_some() || s.temperature_gradient || !s.spots.is_empty());
        if warm { Self::new(scene).map(Some) } else { Ok(None) }
    }

    /// The room of `scene`, whatever is in it.
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

    /// Puts a further source into it.
    pub fn add(&mut self, source: Box<dyn Source>) {
        self.sources.push(source);
    }

    /// Takes up a body that is as warm as `celsius` (°C) from now on.
    pub fn add_body(&mut self, name: &str, celsius: f64, conductance: f64) {
        let path = hot_body::path_of(name);
        // One that was removed has left its place.
        if !self.sources.iter_mut().any(|s| s.turn(&path, celsius)) {
            self.add(hot_body::of(name, celsius, conductance));
        }
    }

    /// Takes the source at `path` out; false where there is none.
    pub fn remove(&mut self, path: &str) -> bool {
        let before = self.sources.len();
        self.sources.retain(|s| s.path() != path);
        before != self.sources.len()
    }

    /// Sends the source at `path` to `placement`; false where there is none that can be sent.
    pub fn place(&mut self, path: &str, placement: &Placement) -> bool {
        self.sources.iter_mut().find(|s| s.path() == path).is_some_and(|s| s.place(placement))
    }

    /// Takes up how `scene` models heat: the thesis's formulas know its heaters.
    ///
    /// # Errors
    /// When a heater's file is not valid; nothing is changed then.
    pub fn model(&mut self, scene: &Scene) -> Result<(), InputError> {
        self.thesis = match scene.heat_mode {
            HeatMode::Physical => None,
            HeatMode::Thesis { sensitivity, conductivity } => Some(Thesis::new(scene, sensitivity, conductivity)?),
        };
        Ok(())
    }

    /// Takes up the surroundings of `scene`, and how fast time runs there.
    pub fn surround(&mut self, scene: &Scene) {
        self.surroundings = Surroundings { celsius: scene.ambient_temperature, convection: scene.convection };
        self.time_lapse = scene.time_lapse;
    }

    /// How warm the surroundings are at `time` (s).
    pub fn surroundings(&self, time: f64) -> Surroundings {
        let mut room = self.surroundings;
        self.sources.iter().for_each(|s| s.surround(time, &mut room));
        room
    }

    /// Steps the heat of all sheets after their motion went from `time` on by `dt` s.
    pub fn step(
        &mut self,
        sheets: &mut [Sheet],
        (time, dt): (f64, f64),
        view: Option<&RigidView>,
        rigid: Option<&RigidWorld>,
    ) {
        self.pending += dt;
        // A rounding error less is as good.
        if self.pending < SHORTEST * (1.0 - 1e-9) {
            return;
        }
        let span = std::mem::take(&mut self.pending) * self.time_lapse;
        self.pass(sheets, time + dt, span, view, rigid);
    }

    /// Steps the heat of all sheets by `dt` s from `time` on, however short that is, with no bodies about.
    pub fn step_whole(&mut self, sheets: &mut [Sheet], (time, dt): (f64, f64)) {
        self.pass(sheets, time + dt, dt * self.time_lapse, None, None);
    }

    /// Lets heat flow for `span` s, the sheets being where they are at `time`.
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
        // What is as warm as all around it stays so.
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

    /// Keeps for a snapshot what can be changed of it and of its sources.
    pub fn keep_settings(&self, to: &mut Keeper) {
        to.numbers(&[self.surroundings.celsius, self.surroundings.convection, self.time_lapse]);
        to.count(self.sources.len() as u64);
        self.sources.iter().for_each(|s| s.keep_settings(to));
    }

    /// Takes that back.
    pub fn take_settings(&mut self, from: &mut Taker) -> Taken {
        self.surroundings = Surroundings { celsius: from.number()?, convection: from.number()? };
        self.time_lapse = from.number()?;
        if from.count()? != self.sources.len() as u64 {
            return Err(Cut);
        }
        self.sources.iter_mut().try_for_each(|s| s.take_settings(from))
    }

    /// Keeps what it carries from step to step.
    pub fn keep(&self, to: &mut Keeper) {
        to.number(self.pending);
        self.sources.iter().for_each(|s| s.keep(to));
    }

    /// Takes that back, for these sheets.
    pub fn take(&mut self, from: &mut Taker, sheets: &[Sheet]) -> Taken {
        self.pending = from.number()?;
        self.sources.iter_mut().try_for_each(|s| s.take(from, sheets))
    }

    /// How many sources there are.
    pub fn sources(&self) -> usize {
        self.sources.len()
    }

    /// Sheets were added or removed.
    pub fn forget(&mut self) {
        self.sources.iter_mut().for_each(|s| s.forget());
    }

    /// What can be changed while the world runs.
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

    /// Changes what is at `path`; false where there is nothing of that name.
    ///
    /// # Errors
    /// When out of range; nothing is changed then.
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
