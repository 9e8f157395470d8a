//! Step observer of the rigs with contact: penetration, energy, contacts, and times of rest.
//!
//! Penetration is computed by `overlap`, independently of the contact solver. Energy is the total
//! of all sheets and dynamic bodies. The energy gain is the largest rise over the start, relative
//! to an energy (J) that the rig names.

use glam::DVec3;
use serde_json::{Map, Value, json};

use crate::measure::{Runner, object};
use sheetwork::World;
use sheetwork::collision::overlap::{self, BodyPose, OverlapSolid};
use sheetwork::math::Vectors;
use sheetwork::scene::sleep::SLEEP;
use sheetwork::sheet::{Sheet, Status};

/// Shortest time between two observations, s. Explicit integrators take thousands of steps in this
/// time.
const OBSERVATION_INTERVAL: f64 = 1e-3;

/// Largest values since construction.
#[derive(Default)]
pub(crate) struct ContactObserver {
    /// Index and solid of the bodies with a known shape.
    solids: Vec<(usize, OverlapSolid)>,
    /// Triangles of each sheet.
    faces: Vec<Vec<[u32; 3]>>,
    places: Vec<Vectors>,
    /// Time of the last observation, s.
    looked: f64,
    start: f64,
    /// Largest energy minus energy at the start, J.
    rise: f64,
    /// Largest penetration of a node into a body, thickness included, m.
    pub masses: f64,
    /// Largest penetration of the surface, or of an edge or corner of a body, m.
    pub surface: f64,
    /// Largest overlap of two sheets, m.
    pub sheets: f64,
    /// Observations between two evaluations of the costly overlap between sheets.
    pub every: u64,
    steps: u64,
    still_since: Option<f64>,
    asleep_at: Option<f64>,
    touching: usize,
}

impl ContactObserver {
    pub fn new(world: &World) -> Self {
        let bodies = world.rigid().map_or(&[][..], |r| r.bodies());
        let solids =
            bodies.iter().enumerate().filter_map(|(i, b)| Some((i, OverlapSolid::from_shape(&b.shape)?))).collect();
        Self {
            solids,
            faces: world.sheets().iter().map(overlap::faces).collect(),
            places: world.sheets().iter().map(|s| s.state.x.clone()).collect(),
            looked: world.time(),
            start: energy(world),
            every: 4,
            ..Self::default()
        }
    }

    /// Observes the world after a step. Steps shorter than [`OBSERVATION_INTERVAL`] are combined.
    pub fn observe_step(&mut self, world: &World) {
        let since = world.time() - self.looked;
        if since < OBSERVATION_INTERVAL {
            return;
        }
        self.looked = world.time();
        self.steps += 1;
        self.record_state(world);
        self.observe_rest(world, since);
    }

    /// Runs until all sheets sleep, for at most `duration` s.
    pub fn run_to_sleep(&mut self, runner: &mut Runner, duration: f64) {
        runner.run(duration, |world| {
            self.observe_step(world);
            !self.asleep()
        });
    }

    /// Records energy, penetration and contacts of the present state.
    pub fn record_state(&mut self, world: &World) {
        self.rise = self.rise.max(energy(world) - self.start);
        for (sheet, faces) in world.sheets().iter().zip(&self.faces) {
            for (body, solid) in &self.solids {
                let Some(frame) = frame(world, *body) else { continue };
                let (masses, surface) = overlap::with_body(sheet, faces, solid, &frame);
                self.masses = self.masses.max(masses);
                self.surface = self.surface.max(surface);
            }
        }
        if world.sheets().len() > 1 && self.steps.is_multiple_of(self.every) {
            self.sheets = self.sheets.max(overlap::between(world.sheets()));
        }
        let touching = world.sheets().iter().map(|s| s.touching().iter().filter(|t| **t).count()).sum();
        self.touching = self.touching.max(touching);
    }

    fn observe_rest(&mut self, world: &World, since: f64) {
        let furthest = SLEEP.speed * since;
        let still = world.sheets().iter().zip(&self.places).all(|(s, before)| {
            s.state.x.iter().zip(before.iter()).all(|(a, b)| a.distance_squared(b) < furthest * furthest)
        });
        self.still_since = if still { self.still_since.or(Some(world.time() - since)) } else { None };
        let asleep = world.sheets().iter().all(|s| s.state.status == Status::Asleep);
        self.asleep_at = if asleep { self.asleep_at.or(Some(world.time())) } else { None };
        for (place, sheet) in self.places.iter_mut().zip(world.sheets()) {
            place.copy_from(&sheet.state.x);
        }
    }

    /// Whether all sheets sleep.
    pub fn asleep(&self) -> bool {
        self.asleep_at.is_some()
    }

    /// Time since which all nodes are slower than 1 mm/s, s; `None` while a node is faster.
    pub fn still_since(&self) -> Option<f64> {
        self.still_since
    }

    /// Largest rise of the energy over the start, divided by `scale` (J).
    pub fn energy_gain(&self, scale: f64) -> f64 {
        self.rise / scale.max(f64::MIN_POSITIVE)
    }

    /// JSON keys common to all rigs with contact; `scale` is the energy (J) of the situation.
    pub fn keys(&self, world: &World, scale: f64) -> Map<String, Value> {
        let contacts: u64 = world.sheets().iter().map(|s| s.state.counters.contacts).sum();
        object(json!({
            "max_penetration_m": self.surface.max(self.masses).max(self.sheets),
            "max_mass_penetration_m": self.masses,
            "energy_gain": self.energy_gain(scale),
            "at_rest_s": self.still_since,
            "asleep_s": self.asleep_at,
            "contacts": contacts,
            "most_masses_touching": self.touching,
        }))
    }
}

/// Total energy of the world, J.
pub(crate) fn energy(world: &World) -> f64 {
    world.energy().total
}

/// Frame of body number `index`.
pub(crate) fn frame(world: &World, index: usize) -> Option<BodyPose> {
    let state = world.rigid()?.state(index)?;
    Some(BodyPose { position: state.origin(), rotation: state.rotation() })
}

/// Energy (J) of a fall of all sheets by `height` (m).
pub(crate) fn fall_energy(world: &World, height: f64) -> f64 {
    world.sheets().iter().map(|s| s.total_mass()).sum::<f64>() * world.gravity().length() * height
}

/// Centre of mass of each sheet, m.
pub(crate) fn centres(world: &World) -> Vec<DVec3> {
    world.sheets().iter().map(Sheet::centre_of_mass).collect()
}

/// Largest horizontal distance of a sheet's centre of mass from its place in `start`, m.
pub(crate) fn drift(world: &World, start: &[DVec3]) -> f64 {
    let aside = |(a, b): (&DVec3, &DVec3)| (*a - *b).with_y(0.0).length();
    start.iter().zip(&centres(world)).map(aside).fold(0.0, f64::max)
}

/// Whether every sheet's centre of mass is above that of the previous sheet. Detects a passage
/// between two overlap evaluations.
pub(crate) fn is_in_order(world: &World) -> bool {
    world.sheets().windows(2).all(|pair| pair[0].centre_of_mass().y < pair[1].centre_of_mass().y)
}

/// Kinetic energy (J) of all sheets at this speed (m/s).
pub(crate) fn energy_of_speed(world: &World, speed: f64) -> f64 {
    0.5 * world.sheets().iter().map(|s| s.total_mass()).sum::<f64>() * speed * speed
}

/// Whether a sheet has been in contact so far.
pub(crate) fn has_touched(world: &World) -> bool {
    world.sheets().iter().any(|s| s.state.counters.contacts > 0 || s.touching().contains(&true))
}

/// Lowest node of the first sheet above the plane through `on` with this normal, m.
pub(crate) fn lowest(world: &World, on: DVec3, normal: DVec3) -> f64 {
    let places = world.sheets().first().into_iter().flat_map(|s| s.state.x.iter());
    places.map(|p| (p - on).dot(normal)).fold(f64::INFINITY, f64::min)
}
