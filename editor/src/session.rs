//! A session: one world, played, paused, stepped, reset and changed. No window, no graphics.
//!
//! Time runs by a fixed step with an accumulator: a frame of real time is turned into whole steps of the engine, and what
//! is left over says where between the last two steps the picture is. A frame never spends more than [`FRAME_BUDGET`] on
//! stepping; time that could not be made up is dropped and counted, so that a slow scene runs slowly instead of choking.

mod recording;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::{DQuat, DVec3};
use sheetwork::link::LinkPlace;
use sheetwork::scene::{MaterialChoice, Scene};
use sheetwork::sheet::{Status, Vectors};
use sheetwork::{InputError, World};

use crate::link::LiveLink;
use crate::playback::{self, Playback};

/// Most wall-clock time a frame spends on stepping.
pub const FRAME_BUDGET: Duration = Duration::from_millis(30);

/// Longest real time that one frame makes up for, s: after a pause of the whole program the scene goes on, it does not leap.
const LONGEST_FRAME: f64 = 0.1;

/// Speeds that the slower and faster keys walk through: simulated seconds a real second.
pub const SPEEDS: [f64; 13] = [0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];

/// How many of the last energies are kept for the graph.
pub const HISTORY: usize = 240;

/// Something the user should know; shown until dismissed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// What.
    pub text: String,
    /// Whether something was refused or failed, rather than merely told.
    pub error: bool,
}

/// Energies at a moment, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergySample {
    /// Simulated time, s.
    pub time: f64,
    /// Of motion.
    pub kinetic: f64,
    /// In the springs.
    pub elastic: f64,
    /// Of height, zero at the origin.
    pub gravity: f64,
}

impl EnergySample {
    /// The sum of the three, J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravity
    }
}

/// How long steps take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Wall-clock time of a step, smoothed over some frames, s; 0 before the first.
    pub step_s: f64,
    /// Wall-clock time spent on stepping since the scene was opened or reset, s.
    pub spent_s: f64,
    /// Real time that could not be simulated because stepping was too slow, s.
    pub lost_s: f64,
    /// Steps taken in the last frame.
    pub steps: u32,
}

/// Whether a parameter's path is one of the material of the sheet called `sheet`.
fn is_of_material(path: &str, sheet: &str) -> bool {
    let rest = path.strip_prefix("sheets.").and_then(|p| p.strip_prefix(sheet)).and_then(|p| p.strip_prefix('.'));
    rest.is_some_and(|name| name.starts_with("material.") || name == "damping_ratio")
}

/// A world being worked with.
pub struct Session {
    world: World,
    file: Option<PathBuf>,
    playing: bool,
    speed: f64,
    owed: f64,
    before: Vec<Vectors>,
    bodies_before: Vec<(DVec3, DQuat)>,
    timing: Timing,
    penetration: Vec<f64>,
    history: Vec<EnergySample>,
    changes: Vec<(String, String)>,
    messages: Vec<Message>,
    told_unstable: bool,
    largest_step: Option<f64>,
    generation: u64,
    link: LiveLink,
    playback: Option<Playback>,
}

impl Session {
    /// A session with `scene`, not yet playing.
    ///
    /// # Errors
    /// When the scene, or a file it names, is not valid.
    pub fn new(scene: &Scene) -> Result<Self, InputError> {
        let world = World::new(scene)?;
        let mut session = Self {
            world,
            file: None,
            playing: false,
            speed: 1.0,
            owed: 0.0,
            before: Vec::new(),
            bodies_before: Vec::new(),
            timing: Timing::default(),
            penetration: Vec::new(),
            history: Vec::new(),
            changes: Vec::new(),
            messages: Vec::new(),
            told_unstable: false,
            largest_step: None,
            generation: 0,
            link: LiveLink::default(),
            playback: None,
        };
        session.begin();
        Ok(session)
    }

    /// A session with the scene in `file`, or with the recording there.
    ///
    /// # Errors
    /// When the file cannot be read, or the scene or recording is not valid.
    pub fn open(file: &Path) -> Result<Self, InputError> {
        if playback::is_recording(file) {
            let (scene, recording) = playback::open(file)?;
            return Ok(Self::new(&scene)?.play_back(recording).read_from(file));
        }
        Ok(Self::new(&Scene::load(file)?)?.read_from(file))
    }

    /// The session, remembering the file its scene came from: [`Session::reload`] reads it again.
    pub fn read_from(self, file: &Path) -> Self {
        Self { file: Some(file.to_path_buf()), ..self }
    }

    /// Replaces the world by the scene in `file`; keeps speed and whether it plays. When the file is refused the old
    /// world goes on and the refusal becomes a message. Returns whether it was opened.
    pub fn load(&mut self, file: &Path) -> bool {
        match Self::open(file) {
            Ok(fresh) => {
                let (playing, speed, generation) = (self.playing, self.speed, self.generation + 1);
                let messages = std::mem::take(&mut self.messages);
                let link = std::mem::take(&mut self.link);
                *self = Self { playing, speed, generation, messages, link, ..fresh };
                self.link.look_again();
                true
            }
            Err(error) => {
                self.fail(error.to_string());
                false
            }
        }
    }

    /// Makes sheet `index` of another material of the library, and starts the scene anew with it; what else was changed
    /// stays. A refusal becomes a message and changes nothing. Returns whether it was taken.
    pub fn choose_material(&mut self, index: usize, name: &str) -> bool {
        if self.playback.is_some() {
            self.fail("a recording has the material it was made with; open its scene to try another");
            return false;
        }
        let mut scene = self.world.scene().clone();
        let Some(sheet) = scene.sheets.get_mut(index) else { return false };
        sheet.material = MaterialChoice::Named(name.to_owned());
        // Its own damping is the material's now, and so are constants that were set by hand.
        sheet.damping_ratio = None;
        match World::new(&scene) {
            Ok(world) => self.world = world,
            Err(error) => {
                self.fail(error.to_string());
                return false;
            }
        }
        let called = self.world.sheets().get(index).map(|s| s.name.clone()).unwrap_or_default();
        let of_it = |path: &str| is_of_material(path, &called) || is_of_material(path, &index.to_string());
        self.changes.retain(|(path, _)| !of_it(path));
        for (path, value) in std::mem::take(&mut self.changes) {
            self.set(&path, &value);
        }
        self.generation += 1;
        self.begin();
        true
    }

    /// Reads the scene's file again and starts it with the file's own values.
    pub fn reload(&mut self) -> bool {
        self.changes.clear();
        match self.file.clone() {
            Some(file) => self.load(&file),
            None => self.reset(),
        }
    }

    /// Puts everything back to the start and keeps what was changed by [`Session::set`]. Returns whether it could.
    pub fn reset(&mut self) -> bool {
        if self.playback.is_some() {
            self.seek(0.0);
            return true;
        }
        if let Err(error) = self.world.reset() {
            self.fail(error.to_string());
            return false;
        }
        for (path, value) in std::mem::take(&mut self.changes) {
            self.set(&path, &value);
        }
        self.begin();
        true
    }

    fn begin(&mut self) {
        self.owed = 0.0;
        self.timing = Timing::default();
        self.penetration.clear();
        self.history.clear();
        self.told_unstable = false;
        self.settle_display();
        self.sample();
        self.find_largest_step();
    }

    /// The engine's limit over the highest frequency of any sheet as it lies.
    fn find_largest_step(&mut self) {
        let limit = self.world.engine().info().stability_limit;
        if !limit.is_finite() {
            self.largest_step = None;
            return;
        }
        let frequency = self.world.sheets().iter().map(|sheet| {
            // A power iteration costs about a step each: fewer for large sheets, for which it is only a hint.
            let iterations = (400_000 / sheet.springs().len().max(4 * sheet.masses())).clamp(20, 100);
            sheet.largest_frequency(iterations)
        });
        let frequency = frequency.fold(0.0, f64::max);
        self.largest_step = (frequency > 0.0 && limit > 0.0).then(|| limit / frequency);
    }

    /// Makes the picture show the present state, whatever part of a step is owed.
    fn settle_display(&mut self) {
        self.before.resize_with(self.world.sheets().len(), || Vectors::zeros(0));
        self.keep_before();
    }

    fn keep_before(&mut self) {
        for (before, sheet) in self.before.iter_mut().zip(self.world.sheets()) {
            if before.len() == sheet.masses() {
                before.copy_from(&sheet.x);
            } else {
                *before = sheet.x.clone();
            }
        }
        self.bodies_before.clear();
        if let Some(rigid) = self.world.rigid() {
            self.bodies_before.extend((0..rigid.bodies().len()).filter_map(|i| rigid.pose(i)));
        }
    }

    /// Lets `real` s of wall-clock time pass. Does nothing while paused.
    pub fn frame(&mut self, real: f64) {
        self.timing.steps = 0;
        if !self.playing || !real.is_finite() || real <= 0.0 {
            return;
        }
        if let Some(recording) = &self.playback {
            self.playing = !recording.is_over();
            self.seek(recording.at() + real.min(LONGEST_FRAME) * self.speed);
            return;
        }
        let dt = self.world.dt();
        self.owed += real.min(LONGEST_FRAME) * self.speed;
        // The slack keeps a frame that is a whole number of steps, but for rounding, at that number.
        let due = (self.owed / dt + 1e-9).floor();
        let start = Instant::now();
        let mut taken = 0.0;
        while taken < due {
            let last = taken + 1.0 >= due || start.elapsed() > FRAME_BUDGET;
            if last {
                // Only the last step of a frame is shown on its way.
                self.keep_before();
            }
            self.world.step();
            taken += 1.0;
            if last {
                break;
            }
        }
        self.owed = (self.owed - taken * dt).max(0.0);
        if taken < due {
            let lost = (due - taken) * dt;
            self.owed = (self.owed - lost).max(0.0);
            self.timing.lost_s += lost / self.speed;
        }
        if taken > 0.0 {
            self.after_steps(taken, start.elapsed());
        }
    }

    /// Takes one step and pauses; shows its result.
    pub fn step(&mut self) {
        self.playing = false;
        self.owed = 0.0;
        if let Some(recording) = &mut self.playback {
            recording.step(&mut self.world);
            self.settle_display();
            return;
        }
        let start = Instant::now();
        self.world.step();
        self.settle_display();
        self.timing.steps = 1;
        self.after_steps(1.0, start.elapsed());
    }

    /// Runs `duration` s of simulated time at once, whatever the speed; shows the result. For pictures and runs without a
    /// window.
    pub fn run(&mut self, duration: f64) {
        if duration <= 0.0 || !duration.is_finite() {
            return;
        }
        if let Some(recording) = &self.playback {
            self.seek(recording.at() + duration);
            return;
        }
        let (begin, parts) = (self.world.time(), (duration / self.world.dt()).ceil().clamp(1.0, HISTORY as f64));
        for part in 1..=parts as u32 {
            let until = begin + duration * f64::from(part) / parts;
            let start = Instant::now();
            let steps = self.world.advance(until - self.world.time());
            self.after_steps(steps as f64, start.elapsed());
        }
        self.settle_display();
    }

    fn after_steps(&mut self, steps: f64, elapsed: Duration) {
        let elapsed = elapsed.as_secs_f64();
        let each = elapsed / steps;
        self.timing.steps = steps as u32;
        self.timing.spent_s += elapsed;
        self.timing.step_s = if self.timing.step_s > 0.0 { 0.9 * self.timing.step_s + 0.1 * each } else { each };
        self.world.watch_penetration(&mut self.penetration);
        self.sample();
        if let Some(sheet) = self.world.unstable().filter(|_| !self.told_unstable)
            && let Status::Unstable { time, speed, .. } = sheet.status
        {
            self.told_unstable = true;
            let text = format!(
                "{} went unstable at {time:.4} s (a mass at {speed:.2e} m/s) and was stopped. \
                 A shorter step, a softer sheet or another engine may hold; Reset starts again.",
                sheet.name
            );
            self.fail(text);
        }
    }

    fn sample(&mut self) {
        let mut sample = EnergySample { time: self.world.time(), ..EnergySample::default() };
        for sheet in self.world.sheets() {
            let energy = sheet.energy(self.world.gravity());
            sample.kinetic += energy.kinetic;
            sample.elastic += energy.elastic;
            sample.gravity += energy.gravity;
        }
        if self.history.len() >= HISTORY {
            self.history.remove(0);
        }
        self.history.push(sample);
    }

    /// Plays.
    pub fn play(&mut self) {
        if self.playback.as_ref().is_some_and(Playback::is_over) {
            self.seek(0.0);
        }
        self.playing = true;
    }

    /// Pauses.
    pub fn pause(&mut self) {
        self.playing = false;
    }

    /// Plays if it was paused, and the other way round.
    pub fn toggle(&mut self) {
        if self.playing { self.pause() } else { self.play() }
    }

    /// Whether it plays.
    pub fn playing(&self) -> bool {
        self.playing
    }

    /// Simulated seconds a real second.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Sets the speed, simulated seconds a real second; what is not finite is ignored, the rest taken to 0.001 to 1000.
    pub fn set_speed(&mut self, speed: f64) {
        if speed.is_finite() {
            self.speed = speed.clamp(1e-3, 1e3);
        }
    }

    /// The next faster of [`SPEEDS`].
    pub fn faster(&mut self) {
        if let Some(speed) = SPEEDS.iter().find(|s| **s > self.speed * 1.001) {
            self.speed = *speed;
        }
    }

    /// The next slower of [`SPEEDS`].
    pub fn slower(&mut self) {
        if let Some(speed) = SPEEDS.iter().rev().find(|s| **s < self.speed * 0.999) {
            self.speed = *speed;
        }
    }

    /// Changes a parameter of the world by path; kept through [`Session::reset`]. A refusal becomes a message and changes
    /// nothing. Returns whether it was taken.
    pub fn set(&mut self, path: &str, value: &str) -> bool {
        match self.try_set(path, value) {
            Ok(_) => true,
            Err(error) => {
                self.fail(error.to_string());
                false
            }
        }
    }

    /// A parameter that is a number, as it is now; `None` when there is none at this path.
    pub fn parameter(&self, path: &str) -> Option<f64> {
        self.world.parameters().into_iter().find(|p| p.path == path)?.value.parse().ok()
    }

    /// Largest step, s, at which the undamped sheets hold with the present engine, as they lay at the last change; `None`
    /// where there is no such limit.
    pub fn largest_step(&self) -> Option<f64> {
        self.largest_step
    }

    /// Parameters changed since the scene was opened: path and value.
    pub fn changes(&self) -> &[(String, String)] {
        &self.changes
    }

    /// Tells the user that something was refused or failed.
    pub fn fail(&mut self, text: impl Into<String>) {
        self.tell(Message { text: text.into(), error: true });
    }

    /// Tells the user something.
    pub fn note(&mut self, text: impl Into<String>) {
        self.tell(Message { text: text.into(), error: false });
    }

    fn tell(&mut self, message: Message) {
        // A slider held against a limit is refused every frame; it is said once.
        if !self.messages.contains(&message) {
            self.messages.push(message);
        }
    }

    /// Messages not yet dismissed, oldest first.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }

    /// Dismisses message `index`.
    pub fn dismiss(&mut self, index: usize) {
        if index < self.messages.len() {
            self.messages.remove(index);
        }
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The live link.
    pub fn link(&self) -> &LiveLink {
        &self.link
    }

    /// Opens the live link, or closes it; why it cannot be opened becomes its status.
    pub fn set_link(&mut self, on: bool) {
        let mut link = std::mem::take(&mut self.link);
        link.switch(on, &self.world);
        self.link = link;
    }

    /// Opens the live link at a place of the caller's choice.
    pub fn open_link(&mut self, place: &LinkPlace) {
        let mut link = std::mem::take(&mut self.link);
        link.open(place, &self.world);
        self.link = link;
    }

    /// Does what other processes ask, and shows them the world.
    pub fn exchange(&mut self) {
        let mut link = std::mem::take(&mut self.link);
        link.exchange(self);
        self.link = link;
    }

    /// The world, for those who command it over the link.
    pub(crate) fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// Sets a parameter as [`Session::set`] does, but returns the old value, or why not.
    pub(crate) fn try_set(&mut self, path: &str, value: &str) -> Result<String, InputError> {
        if self.playback.is_some() {
            return Err(InputError::new(path, "cannot be changed in a recording; open its scene for that"));
        }
        let old = self.world.set(path, value)?;
        self.keep_change(path, value);
        Ok(old)
    }

    fn keep_change(&mut self, path: &str, value: &str) {
        self.changes.retain(|(p, _)| p != path);
        self.changes.push((path.to_owned(), value.to_owned()));
        if path == "engine" || path.contains("material") {
            self.find_largest_step();
        }
    }

    /// The file the scene came from.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Where between the last two steps the picture is: 0 at the one before, 1 at the last.
    pub fn alpha(&self) -> f64 {
        (self.owed / self.world.dt()).clamp(0.0, 1.0)
    }

    /// Positions of the masses of each sheet one step ago, m: the picture lies between these and the present ones.
    pub fn before(&self) -> &[Vectors] {
        &self.before
    }

    /// Where body `index` is in the picture; `None` when there is no such body.
    pub fn body_pose(&self, index: usize) -> Option<(DVec3, DQuat)> {
        let (position, rotation) = self.world.rigid()?.pose(index)?;
        let alpha = self.alpha();
        Some(match self.bodies_before.get(index) {
            Some((p, r)) => (p.lerp(position, alpha), r.slerp(rotation, alpha)),
            None => (position, rotation),
        })
    }

    /// How long steps take.
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// How many times faster than real time steps are: simulated over wall-clock time of a step; `None` before the first.
    pub fn real_time_factor(&self) -> Option<f64> {
        (self.timing.step_s > 0.0).then(|| self.world.dt() / self.timing.step_s)
    }

    /// Deepest a mass of each sheet has been inside a body at the end of a frame, m.
    pub fn penetration(&self) -> &[f64] {
        &self.penetration
    }

    /// The last energies, oldest first.
    pub fn history(&self) -> &[EnergySample] {
        &self.history
    }

    /// Masses of all sheets that touched a body in the last step.
    pub fn contacts(&self) -> usize {
        self.world.sheets().iter().map(|s| s.touching().iter().filter(|t| **t).count()).sum()
    }

    /// Changes whenever another scene is opened: what was made for drawing must be made anew.
    pub fn generation(&self) -> u64 {
        self.generation
    }
}
