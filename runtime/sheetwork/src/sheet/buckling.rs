//! Detection of buckling: a snap-through or bifurcation that releases elastic energy.
//!
//! Within a step the sheet moves by Δx and its elastic forces change by Δf. A stable sheet resists
//! its own motion, Δf·Δx < 0, in vibration and at rest, because its elastic energy U is convex
//! along the motion. Past a limit point or a bifurcation the energy is concave,
//!
//!   Δf·Δx > 0 and ΔU < 0,
//!
//! up to the inflection (Thompson and Hunt, *A General Theory of Elastic Stability*, 1973, ch. 2).
//! The energy of the buckle is the energy released up to the inflection, and its position is where
//! the elastic forces did the most work in a step. A later release within 0.1 s counts as ringing
//! unless it is more than twice as large. Detection costs one evaluation of forces and energy per
//! step.

use glam::DVec3;

use crate::elements::Element;
use crate::elements::spring::SpringWorkspace;
use crate::math::Vectors;
use crate::serialize::{ReadResult, State, StateReader, StateWriter, state};
use crate::sheet::{Sheet, Status};

/// Minimum released fraction of the elastic energy of a buckle.
const MIN_RELEASED_FRACTION: f64 = 0.02;
/// Speed (m/s) of the whole sheet whose kinetic energy is the minimum energy of a buckle.
const MIN_BUCKLE_SPEED: f64 = 5e-3;

/// Duration of the ringing after a buckle, s.
const RINGING_TIME: f64 = 0.1;
/// Energy ratio above which a release during the ringing is another buckle.
const MIN_REPEAT_RATIO: f64 = 2.0;

/// Buckling of a sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Buckling {
    /// Simulated time at the start of the release, s.
    pub time: f64,
    /// Position of the largest work of the elastic forces in a step, m.
    pub place: DVec3,
    /// Elastic energy released up to the inflection, J.
    pub energy: f64,
}

/// Release of elastic energy in progress.
#[derive(Clone, Copy, Default)]
struct Snap {
    since: f64,
    stored: f64,
    released: f64,
    peak_work: f64,
    place: DVec3,
}

state!(Buckling { time, energy, place });
state!(Snap { since, stored, released, peak_work, place });

/// State of the detector after the last step.
#[derive(Default)]
pub(crate) struct BuckleDetector {
    x: Vectors,
    force: Vectors,
    elastic: f64,
    next_force: Vectors,
    still: Vectors,
    scratch: SpringWorkspace,
    /// Fracture revision of the last step.
    revision: u64,
    fall: Option<Snap>,
    last: Option<Buckling>,
}

impl BuckleDetector {
    /// Serialise the state.
    pub fn serialise(&self, to: &mut StateWriter) {
        to.vector_list(&self.x);
        to.vector_list(&self.force);
        to.number(self.elastic);
        self.fall.serialise(to);
        self.last.serialise(to);
    }

    /// Deserialise the state of a sheet with `masses` nodes and the fracture revision `revision`.
    pub fn deserialise(&mut self, from: &mut StateReader, masses: usize, revision: u64) -> ReadResult {
        from.vector_list(&mut self.x, masses)?;
        from.vector_list(&mut self.force, masses)?;
        for buffer in [&mut self.next_force, &mut self.still] {
            *buffer = Vectors::zeros(masses);
        }
        self.revision = revision;
        self.elastic.deserialise(from)?;
        self.fall.deserialise(from)?;
        self.last.deserialise(from)
    }
}

/// Turn detection on or off.
pub(crate) fn set_buckling_detection(sheet: &mut Sheet, watch: bool) {
    if watch != sheet.state.buckle_detector.is_some() {
        sheet.state.buckle_detector = watch.then(Box::default);
    }
}

/// Test the last step, which began at `time` (s), for buckling.
pub(crate) fn detect_buckling(sheet: &mut Sheet, time: f64) -> Option<Buckling> {
    if sheet.state.status != Status::Awake {
        return None;
    }
    let mut watch = sheet.state.buckle_detector.take()?;
    let found = watch.detect(sheet, time);
    sheet.state.buckle_detector = Some(watch);
    found
}

/// Compute the elastic forces at the present positions (N) into the detector; return the
/// elastic energy (J).
fn elastic(sheet: &Sheet, watch: &mut BuckleDetector) -> f64 {
    let BuckleDetector { next_force: force, still, scratch, .. } = watch;
    force.clear();
    sheet.springs.add_forces(&sheet.state.x, still, false, scratch, force);
    // Grab springs are external to the sheet.
    let own = &sheet.elements[..sheet.elements.len() - sheet.grabs.len()];
    own.iter().for_each(|e| e.add_forces(&sheet.state.x, still, force));
    let pulled: f64 = sheet.grabs.iter().map(|p| p.energy(&sheet.state.x)).sum();
    sheet.energy(DVec3::ZERO).elastic - pulled
}

impl BuckleDetector {
    fn detect(&mut self, sheet: &Sheet, time: f64) -> Option<Buckling> {
        let n = sheet.node_count();
        // Fracture also releases energy, but is not buckling.
        let is_first = self.x.len() != n || self.revision != sheet.opening_revision();
        self.revision = sheet.opening_revision();
        if is_first {
            self.fall = None;
            for buffer in [&mut self.next_force, &mut self.still] {
                *buffer = Vectors::zeros(n);
            }
        }
        let elastic = elastic(sheet, self);
        let found = if is_first { None } else { self.detect_snap(sheet, time, elastic) };
        self.elastic = elastic;
        self.x.clone_from(&sheet.state.x);
        self.force.clone_from(&self.next_force);
        found
    }

    fn detect_snap(&mut self, sheet: &Sheet, time: f64, elastic: f64) -> Option<Buckling> {
        let (mut resists, mut most, mut place) = (0.0, 0.0, DVec3::ZERO);
        // Prescribed motion is not a loss of stability.
        for i in (0..sheet.node_count()).filter(|i| !sheet.is_held(*i)) {
            let (force, next, x) = (self.force.get(i), self.next_force.get(i), sheet.state.x.get(i));
            let moved = x - self.x.get(i);
            resists -= (next - force).dot(moved);
            let work = (0.5 * (force + next)).dot(moved);
            if work > most {
                (most, place) = (work, x);
            }
        }
        let given = self.elastic - elastic;
        if resists < 0.0 && given > 0.0 {
            let new = Snap { since: time, stored: self.elastic, released: 0.0, peak_work: 0.0, place };
            let fall = self.fall.get_or_insert(new);
            fall.released += given;
            if most > fall.peak_work {
                (fall.peak_work, fall.place) = (most, place);
            }
            return None;
        }
        let fall = self.fall.take()?;
        let faint = 0.5 * sheet.total_mass() * MIN_BUCKLE_SPEED * MIN_BUCKLE_SPEED;
        let rings = self
            .last
            .is_some_and(|b| fall.since < b.time + RINGING_TIME && fall.released < MIN_REPEAT_RATIO * b.energy);
        let is_one = fall.released > faint && fall.released > MIN_RELEASED_FRACTION * fall.stored && !rings;
        let found = is_one.then_some(Buckling { time: fall.since, place: fall.place, energy: fall.released });
        self.last = found.or(self.last);
        found
    }
}
