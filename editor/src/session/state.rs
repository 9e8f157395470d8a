//! The session: fields, construction, and displayed state.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DQuat, DVec3};
use sheetwork::islands::event::Event;
use sheetwork::math::Vectors;
use sheetwork::profiler::StepObserver;
use sheetwork::scene::{Scene, SpotSpec};
use sheetwork::sheet::Status;
use sheetwork::{InputError, Snapshot, World};
use sheetwork_link::link_place::LinkPlace;

use super::item::{Item, MovedItem};
use super::message::Message;
use super::timing::Timing;
use super::variant::Variant;
use crate::document::Document;
use crate::link::LiveLink;
use crate::playback::Playback;
use crate::samples::{Sample, Samples};
use crate::stages::StageClock;
use crate::timeline::Timeline;

/// Grab of a sheet: name of the sheet and index of the grab.
#[derive(Clone, Debug)]
pub(super) struct GrabHandle {
    pub(super) sheet: String,
    pub(super) index: usize,
}

/// Stroke of painted heat.
pub(super) struct HeatStroke {
    pub(super) sheet: usize,
    pub(super) before: Snapshot,
    pub(super) spots: Vec<SpotSpec>,
}

/// Variant, and its session or the reason why it is invalid.
pub(super) struct VariantSession {
    pub(super) variant: Variant,
    pub(super) session: Result<Box<Session>, String>,
}

/// State of a session that a restart of the scene discards.
#[derive(Default)]
pub(super) struct RunState {
    pub(super) unstepped: f64,
    pub(super) timing: Timing,
    pub(super) penetration: Vec<f64>,
    pub(super) samples: Samples,
    pub(super) timeline: Timeline,
    /// State before playing, which stop restores.
    pub(super) before_play: Option<Snapshot>,
    pub(super) slots: [Option<Snapshot>; 9],
    pub(super) hand: Option<GrabHandle>,
    /// Nodes pinned at run time, and their displacements from the initial positions at that time:
    /// sheet, node, m.
    pub(super) pinned_here: Vec<(usize, u32, DVec3)>,
    /// Item that is being moved.
    pub(super) moved_item: Option<MovedItem>,
    /// Stroke of heat that is being painted.
    pub(super) stroke: Option<HeatStroke>,
    pub(super) instability_reported: bool,
}

/// World with its edited scene, clock and history.
pub struct Session {
    pub(super) world: World,
    pub(super) document: Document,
    pub(super) file: Option<PathBuf>,
    pub(super) playing: bool,
    pub(super) looped: bool,
    pub(super) speed: f64,
    pub(super) before: Vec<Vectors>,
    /// Time of the states `before` and `bodies_before`, s.
    pub(super) shown_from: f64,
    pub(super) bodies_before: Vec<(DVec3, DQuat)>,
    /// Profiler of the phases of a step, while requested.
    pub(super) stages: Option<Arc<StageClock>>,
    /// Centre of each heater of the scene in its own axes, m.
    pub(super) heater_centres: Vec<DVec3>,
    pub(super) messages: Vec<Message>,
    /// Stability limit of the time step, s, of the undamped sheets with the present integrator, in
    /// their shape at the last change; `None` without limit.
    pub(super) largest_step: Option<f64>,
    pub(super) generation: u64,
    pub(super) revision: u64,
    pub(super) link: LiveLink,
    pub(super) playback: Option<Playback>,
    /// Variants of the comparison.
    pub(super) variants: Vec<VariantSession>,
    pub(super) run_state: RunState,
}

impl Session {
    /// Session with `scene`, paused.
    ///
    /// # Errors
    /// When the scene, or a file it names, is not valid.
    pub fn new(scene: &Scene) -> Result<Self, InputError> {
        let world = World::with_start_overlaps(scene)?;
        let mut session = Self {
            world,
            document: Document::new(scene.clone()),
            file: None,
            playing: false,
            looped: false,
            speed: 1.0,
            before: Vec::new(),
            shown_from: 0.0,
            bodies_before: Vec::new(),
            stages: None,
            heater_centres: Vec::new(),
            messages: Vec::new(),
            largest_step: None,
            generation: 0,
            revision: 0,
            link: LiveLink::default(),
            playback: None,
            variants: Vec::new(),
            run_state: RunState::default(),
        };
        session.begin();
        Ok(session)
    }

    /// Reset everything that belongs to a run and not to the scene.
    pub(super) fn begin(&mut self) {
        self.run_state = RunState::default();
        self.messages.retain(|m| !m.of_run);
        self.show_present();
        self.run_state.samples.push(Sample::from_world(&self.world, 0.0));
        self.run_state.timeline.record(&self.world);
        self.find_largest_step();
        self.update_heater_centres();
        self.rebuild_variants();
    }

    /// Compute the stability limit: that of the integrator over the highest angular frequency of
    /// any sheet in its present shape.
    pub(super) fn find_largest_step(&mut self) {
        let limit = self.world.engine().info().stability_limit;
        if !limit.is_finite() {
            self.largest_step = None;
            return;
        }
        let frequency = self.world.sheets().iter().map(|sheet| {
            // A power iteration costs about one step: fewer for large sheets, where the limit is
            // only a hint.
            let iterations = (400_000 / sheet.springs().len().max(4 * sheet.node_count())).clamp(20, 100);
            sheet.largest_frequency(iterations)
        });
        let frequency = frequency.fold(0.0, f64::max);
        self.largest_step = (frequency > 0.0 && limit > 0.0).then(|| limit / frequency);
    }

    /// Display the present state without interpolation.
    pub(super) fn show_present(&mut self) {
        self.before.resize_with(self.world.sheets().len(), || Vectors::zeros(0));
        self.revision += 1;
        self.store_previous();
    }

    pub(super) fn store_previous(&mut self) {
        self.shown_from = self.world.time();
        for (before, sheet) in self.before.iter_mut().zip(self.world.sheets()) {
            if before.len() == sheet.node_count() {
                before.copy_from(&sheet.state.x);
            } else {
                *before = sheet.state.x.clone();
            }
        }
        self.bodies_before.clear();
        if let Some(rigid) = self.world.rigid() {
            self.bodies_before.extend((0..rigid.bodies().len()).filter_map(|i| rigid.pose(i)));
        }
    }

    /// World of the session.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Edited scene.
    pub fn scene(&self) -> &Scene {
        self.document.scene()
    }

    /// Edited scene with undo and redo.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// Live link.
    pub fn link(&self) -> &LiveLink {
        &self.link
    }

    /// Open or close the live link; an error becomes its status.
    pub fn set_link(&mut self, on: bool) {
        self.link.switch(on, &self.world);
    }

    /// Open the live link at a place.
    pub fn open_link(&mut self, place: &LinkPlace) {
        self.link.open(place, &self.world);
    }

    /// Answer the requests of other processes, and publish the world.
    pub fn exchange(&mut self) {
        let mut link = std::mem::take(&mut self.link);
        let step_s = self.run_state.timing.step_s;
        link.exchange(self, step_s);
        self.link = link;
    }

    /// World for commands over the live link.
    pub(crate) fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// File of the scene.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Interpolation parameter of the display between the last two states, 0 to 1.
    pub fn alpha(&self) -> f64 {
        (self.run_state.unstepped / self.world.dt()).clamp(0.0, 1.0)
    }

    /// Node positions of each sheet one step ago, m; the display interpolates between these and the
    /// present ones.
    pub fn before(&self) -> &[Vectors] {
        &self.before
    }

    /// Displayed pose of body `index`; `None` when there is no such body.
    pub fn body_pose(&self, index: usize) -> Option<(DVec3, DQuat)> {
        let (position, rotation) = self.world.rigid()?.pose(index)?;
        if let Some(there) = self.moved_position(Item::Body(index)) {
            return Some((there, rotation));
        }
        let alpha = self.alpha();
        Some(match self.bodies_before.get(index) {
            Some((p, r)) => (p.lerp(position, alpha), r.slerp(rotation, alpha)),
            None => (position, rotation),
        })
    }

    /// Switch the profiler of a step's phases on or off.
    pub fn time_stages(&mut self, on: bool) {
        if on != self.stages.is_some() {
            self.stages = on.then(Arc::default);
            self.run_state.timing.stages = None;
            self.watch_world();
        }
    }

    /// Pass the profiler to the present world.
    pub(super) fn watch_world(&mut self) {
        let clock = self.stages.clone();
        self.world.set_profiler(clock.map(|clock| clock as Arc<dyn StepObserver>));
    }

    /// Wall-clock times of steps.
    pub fn timing(&self) -> Timing {
        self.run_state.timing
    }

    /// Largest penetration of a node of each sheet at the end of a frame, m.
    pub fn penetration(&self) -> &[f64] {
        &self.run_state.penetration
    }

    /// Samples of the run, oldest first.
    pub fn history(&self) -> &[Sample] {
        self.run_state.samples.all()
    }

    /// Samples as CSV.
    pub fn csv(&self) -> String {
        self.run_state.samples.csv(&crate::samples::height_names(&self.world))
    }

    /// Events of the run up to the present time.
    pub fn events(&self) -> impl DoubleEndedIterator<Item = &Event> {
        let now = self.world.time() + 0.5 * self.world.dt();
        self.run_state.timeline.events().iter().filter(move |e| e.time_s <= now)
    }

    /// Number of nodes of all sheets that touched a body in the last step.
    pub fn contacts(&self) -> usize {
        self.world.sheets().iter().map(|s| s.touching().iter().filter(|t| **t).count()).sum()
    }

    /// Simulated time at which a sheet became unstable, s; `None` while all are stable.
    pub fn unstable_since(&self) -> Option<f64> {
        match self.world.unstable()?.state.status {
            Status::Unstable { time, .. } => Some(time),
            _ => None,
        }
    }

    /// Changes with every new world: objects for display must be rebuilt.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Changes with every jump of the displayed state, as after a rollback.
    pub fn revision(&self) -> u64 {
        self.revision
    }
}

impl Session {
    /// Show an error message.
    pub fn fail(&mut self, text: impl Into<String>) {
        self.tell(Message { text: text.into(), error: true, of_run: false });
    }

    /// Value of a result; an error becomes a message.
    pub fn accept<T>(&mut self, result: Result<T, impl Display>) -> Option<T> {
        result.map_err(|error| self.fail(error.to_string())).ok()
    }

    /// Show a note in place of the previous one.
    pub fn note(&mut self, text: impl Into<String>) {
        self.messages.retain(|m| m.error);
        self.tell(Message { text: text.into(), error: false, of_run: false });
    }

    /// Show an error message of this run.
    pub(super) fn fail_of_run(&mut self, text: String) {
        self.tell(Message { text, error: true, of_run: true });
    }

    fn tell(&mut self, message: Message) {
        // A slider held against a limit is rejected in every frame; one message suffices.
        if !self.messages.contains(&message) {
            self.messages.push(message);
        }
    }

    /// Messages not yet dismissed, oldest first.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }

    /// Dismiss message `index`.
    pub fn dismiss(&mut self, index: usize) {
        if index < self.messages.len() {
            self.messages.remove(index);
        }
    }
}
