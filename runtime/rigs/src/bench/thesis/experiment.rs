//! Runs of shipped scenes with fields overridden, with prints at chosen times.

use std::path::Path;

use cpu_time::ProcessTime;
use sheetwork::islands::event::EventKind;
use sheetwork::scene::{Scene, library};
use sheetwork::sheet::Sheet;
use sheetwork::sheet::surface::{DrawingSurface, SurfaceSmoothing};
use sheetwork::{InputError, World};

use crate::bench::thesis::picture::{Print, Strip};

/// A scene in the course of its run.
pub(crate) struct Experiment {
    pub world: World,
    /// The world at its start.
    pub start: World,
    /// CPU time of the steps so far, s.
    pub cpu: f64,
    prints: Vec<Print>,
}

impl Experiment {
    /// A shipped scene with fields overridden: pairs of path and value.
    ///
    /// # Errors
    /// An unknown scene or field, or a value out of range.
    pub fn new(scene: &str, overrides: &[(&str, &str)]) -> Result<Self, InputError> {
        let scene = Scene::load(&library::find(Path::new(scene)))?.with_overrides(overrides)?;
        Self::of_scene(&scene)
    }

    /// A scene at its start.
    ///
    /// # Errors
    /// A scene that no world can be made of.
    pub fn of_scene(scene: &Scene) -> Result<Self, InputError> {
        Ok(Self { world: World::new(scene)?, start: World::new(scene)?, cpu: 0.0, prints: Vec::new() })
    }

    /// The first sheet.
    pub fn sheet(&self) -> &Sheet {
        &self.world.sheets()[0]
    }

    /// The first sheet at the start.
    pub fn first(&self) -> &Sheet {
        &self.start.sheets()[0]
    }

    /// Steps to a time (s), to rest or to an instability, and calls `watch` after each step.
    pub fn run_watching(&mut self, time: f64, mut watch: impl FnMut(&World)) {
        while self.world.time() < time - 0.5 * self.world.dt()
            && !self.world.is_resting()
            && self.world.unstable().is_none()
        {
            let start = ProcessTime::now();
            self.world.step();
            self.cpu += start.elapsed().as_secs_f64();
            watch(&self.world);
        }
    }

    /// Steps to a time (s), to rest or to an instability.
    pub fn run_to(&mut self, time: f64) {
        self.run_watching(time, |_| {});
    }

    /// Steps to the scene's duration, to rest or to an instability.
    pub fn run(&mut self) {
        self.run_to(self.world.scene().duration);
    }

    /// Keeps a print of the present state.
    pub fn print(&mut self) {
        let (time, lapse) = (self.world.time(), self.world.scene().time_lapse);
        let label = match lapse {
            1.0 => format!("{} s", (1e3 * time).round() / 1e3),
            _ if lapse < 10.0 => format!("{time:.1} s, {:.1} s of heat", time * lapse),
            _ => format!("{time:.1} s, {:.1} min of heat", time * lapse / 60.0),
        };
        self.prints.push(Print::new(&self.world, label));
    }

    /// Keeps a print of the present state under a name.
    pub fn print_as(&mut self, name: &str) {
        self.prints.push(Print::new(&self.world, name.to_owned()));
    }

    /// Keeps a print of the present state, a layer of its sheets drawn with a smoothing or flat.
    pub fn print_layer(&mut self, name: &str, layer: usize, smoothing: Option<SurfaceSmoothing>) {
        let (parts, smoothing) = smoothing.map_or((1, SurfaceSmoothing::Interpolating), |s| (4, s));
        let drawn = |sheet: &Sheet| DrawingSurface::of_sheet(sheet, layer, parts, smoothing);
        self.prints.push(Print::drawn(&self.world, name.to_owned(), drawn));
    }

    /// Steps to each of the times (s) and keeps a print of each.
    pub fn print_at(&mut self, times: &[f64]) {
        for &time in times {
            self.run_to(time);
            self.print();
        }
    }

    /// The prints as a picture.
    pub fn strip(&mut self, caption: &str) -> Strip {
        Strip { caption: caption.to_owned(), prints: std::mem::take(&mut self.prints) }
    }

    /// Time of the first event of a kind with a body, s; `body` is empty for none.
    pub fn time_of(&self, kind: EventKind, body: &str) -> Option<f64> {
        let event = self.world.events().iter().find(|e| e.kind == kind && e.body.as_deref().unwrap_or("") == body);
        event.map(|e| e.time_s)
    }

    /// Whether the run is stable, at rest, and no node is deeper than 0.1 mm in a body.
    pub fn is_sound(&self) -> bool {
        self.world.unstable().is_none() && self.world.is_resting() && self.world.penetration() < 1e-4
    }
}

/// A time in seconds, or "never".
pub(crate) fn seconds(time: Option<f64>) -> String {
    time.map_or_else(|| "never".to_owned(), |t| format!("{t:.3} s"))
}

/// "at rest after ...", or "not at rest after ...".
pub(crate) fn rest(experiment: &Experiment) -> String {
    match experiment.time_of(EventKind::AtRest, "") {
        Some(time) => format!("at rest after {time:.2} s"),
        None => format!("not at rest after {:.2} s", experiment.world.time()),
    }
}
