//! What every rig with contact watches after each step: penetration, energy, contacts, and when things came to rest.
//!
//! Penetration is measured by `overlap`, not by the contact that is judged. Energy is that of all sheets and free bodies together;
//! its gain is the largest rise over the start, relative to what the situation brings (J), which the rig names.

use glam::DVec3;
use serde_json::{Map, Value, json};

use super::overlap::{self, Frame, Solid};
use crate::World;
use crate::sheet::{Status, Vectors};
use crate::step::SLEEP_SPEED;

/// Shortest time between two looks, s: explicit engines take thousands of steps in what the eye would see as one.
const LOOK: f64 = 1e-3;

/// What has been seen since it was made.
pub(crate) struct Watch {
    /// Bodies of the world by number, those whose shape is known here.
    solids: Vec<(usize, Solid)>,
    /// Triangles of each sheet.
    faces: Vec<Vec<[u32; 3]>>,
    places: Vec<Vectors>,
    /// When it last looked, s.
    looked: f64,
    start: f64,
    /// Largest energy seen over that at the start, J.
    rise: f64,
    /// Deepest a mass was in a body, thickness included, m.
    pub masses: f64,
    /// Deepest any place of the surface or any edge or corner of a body was, m.
    pub surface: f64,
    /// Largest overlap of two sheets, m.
    pub sheets: f64,
    /// Steps between looks at the overlap of sheets, which takes long.
    pub every: u64,
    steps: u64,
    still_since: Option<f64>,
    asleep_at: Option<f64>,
    touching: usize,
}

impl Watch {
    pub fn new(world: &World) -> Self {
        let bodies = world.rigid().map_or(&[][..], |r| r.bodies());
        let solids = bodies.iter().enumerate().filter_map(|(i, b)| Some((i, Solid::of(&b.shape)?))).collect();
        Self {
            solids,
            faces: world.sheets().iter().map(overlap::faces).collect(),
            places: world.sheets().iter().map(|s| s.x.clone()).collect(),
            looked: world.time(),
            start: energy(world),
            rise: 0.0,
            masses: 0.0,
            surface: 0.0,
            sheets: 0.0,
            every: 4,
            steps: 0,
            still_since: None,
            asleep_at: None,
            touching: 0,
        }
    }

    /// Looks at the world after a step; of steps shorter than [`LOOK`] not after each.
    pub fn see(&mut self, world: &World) {
        let since = world.time() - self.looked;
        if since < LOOK {
            return;
        }
        self.looked = world.time();
        self.steps += 1;
        self.look(world);
        self.see_rest(world, since);
    }

    /// Takes up how things are now.
    pub fn look(&mut self, world: &World) {
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

    fn see_rest(&mut self, world: &World, since: f64) {
        let furthest = SLEEP_SPEED * since;
        let still =
            world.sheets().iter().zip(&self.places).all(|(s, before)| {
                s.x.iter().zip(before.iter()).all(|(a, b)| a.distance_squared(b) < furthest * furthest)
            });
        self.still_since = if still { self.still_since.or(Some(world.time() - since)) } else { None };
        let asleep = world.sheets().iter().all(|s| s.status == Status::Asleep);
        self.asleep_at = if asleep { self.asleep_at.or(Some(world.time())) } else { None };
        for (place, sheet) in self.places.iter_mut().zip(world.sheets()) {
            place.copy_from(&sheet.x);
        }
    }

    /// Whether all sheets sleep.
    pub fn asleep(&self) -> bool {
        self.asleep_at.is_some()
    }

    /// Since when no mass has been faster than a millimetre a second, s; `None` where one still is.
    pub fn still_since(&self) -> Option<f64> {
        self.still_since
    }

    /// Largest rise of energy over the start, over `scale` (J).
    pub fn energy_gain(&self, scale: f64) -> f64 {
        self.rise / scale.max(f64::MIN_POSITIVE)
    }

    /// The keys that all rigs with contact have; `scale` is the energy (J) that the situation brings.
    pub fn keys(&self, world: &World, scale: f64) -> Map<String, Value> {
        let contacts: u64 = world.sheets().iter().map(|s| s.counters.contacts).sum();
        let keys = json!({
            "max_penetration_m": self.surface.max(self.masses).max(self.sheets),
            "max_mass_penetration_m": self.masses,
            "energy_gain": self.energy_gain(scale),
            "at_rest_s": self.still_since,
            "asleep_s": self.asleep_at,
            "contacts": contacts,
            "most_masses_touching": self.touching,
        });
        if let Value::Object(map) = keys { map } else { Map::new() }
    }
}

/// Energy of everything that moves, J.
pub(crate) fn energy(world: &World) -> f64 {
    world.energy().total
}

/// Where body number `index` is.
pub(crate) fn frame(world: &World, index: usize) -> Option<Frame> {
    let state = world.rigid()?.state(index)?;
    Some(Frame { position: state.origin(), rotation: state.rotation() })
}

/// Energy, J, that a fall of all sheets by `height` (m) brings.
pub(crate) fn fall(world: &World, height: f64) -> f64 {
    world.sheets().iter().map(|s| s.total_mass()).sum::<f64>() * world.gravity().length() * height
}

/// Whether every sheet's centre of mass is above that of the one before it: what has passed through another between two looks at
/// overlaps shows here.
pub(crate) fn in_order(world: &World) -> bool {
    world.sheets().windows(2).all(|pair| pair[0].centre_of_mass().y < pair[1].centre_of_mass().y)
}

/// Energy, J, of all sheets at this speed (m/s).
pub(crate) fn energy_of_speed(world: &World, speed: f64) -> f64 {
    0.5 * world.sheets().iter().map(|s| s.total_mass()).sum::<f64>() * speed * speed
}

/// Whether a sheet has touched anything by now.
pub(crate) fn touched(world: &World) -> bool {
    world.sheets().iter().any(|s| s.counters.contacts > 0 || s.touching().contains(&true))
}

/// Lowest mass of the first sheet above the plane through `on` with this normal, m.
pub(crate) fn lowest(world: &World, on: DVec3, normal: DVec3) -> f64 {
    let places = world.sheets().first().into_iter().flat_map(|s| s.x.iter());
    places.map(|p| (p - on).dot(normal)).fold(f64::INFINITY, f64::min)
}
