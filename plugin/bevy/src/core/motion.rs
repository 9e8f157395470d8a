//! What comes back from the world: the last two states of a sheet or body, and how a sheet fares.

use bevy::prelude::*;
use sheetwork::math::Vectors;
use sheetwork::scene::{PathKey, Placement, path_at};

use super::placement::Pose;
use super::{Sheet, SheetBody};

/// A sheet's place in the [`SheetWorld`](super::SheetWorld), and where its masses were after the last three ticks.
///
/// Put on the entity when its sheet is built, and taken off with its [`Sheet`].
#[derive(Component, Clone, Debug)]
pub struct SheetMotion {
    name: String,
    generation: u32,
    built_from: Sheet,
    /// Oldest first.
    states: [Vectors; 3],
    /// Simulated times of the states, s.
    times: [f64; 3],
    /// Ticks in which nothing moved, up to 2: from then on the three states are the same.
    still: u8,
    revision: u64,
}

impl SheetMotion {
    pub(crate) fn new(name: String, generation: u32, built_from: Sheet, time: f64, x: &Vectors) -> Self {
        let states = [x.clone(), x.clone(), x.clone()];
        Self { name, generation, built_from, states, times: [time; 3], still: 2, revision: 0 }
    }

    /// The sheet's name in the world: `world.sheet(motion.name())`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Positions of the masses after the last tick, m.
    pub fn positions(&self) -> &Vectors {
        &self.states[2]
    }

    /// Whether it has moved in the last ticks.
    pub fn is_moving(&self) -> bool {
        self.still < 2
    }

    /// The states that the simulated time `time` (s) lies between and how far, 0 to 1, it is from the first to the second.
    pub fn around(&self, time: f64) -> (&Vectors, &Vectors, f32) {
        let first = if time < self.times[1] { 0 } else { 1 };
        let (from, to) = (self.times[first], self.times[first + 1]);
        let s = if to > from { ((time - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        (&self.states[first], &self.states[first + 1], s as f32)
    }

    /// Where mass `i` is at the simulated time `time` (s), m; for one that is shown,
    /// [`SheetWorld::shown_time`](super::SheetWorld::shown_time). `None` when there is no such mass.
    pub fn at(&self, i: usize, time: f64) -> Option<Vec3> {
        let (a, b, s) = self.around(time);
        (i < a.len().min(b.len())).then(|| a.get(i).lerp(b.get(i), f64::from(s)).as_vec3())
    }

    /// Changes whenever what is to be drawn has changed other than by the time that is shown.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    pub(super) fn generation(&self) -> u32 {
        self.generation
    }

    pub(super) fn built_from(&self) -> &Sheet {
        &self.built_from
    }

    pub(super) fn set_built_from(&mut self, sheet: &Sheet) {
        self.built_from = sheet.clone();
    }

    /// Takes in where the masses are at `time` and how they move; says whether that is news. Nothing is allocated, but for a sheet that has gone
    /// to another grid.
    pub(super) fn record(&mut self, time: f64, x: &Vectors, v: &Vectors) -> bool {
        if x.len() != self.states[2].len() && time >= self.times[2] {
            self.begin_anew(time, x, v);
            return true;
        }
        let same = *x == self.states[2];
        if time < self.times[2] {
            // The world has gone back, by a reset or to a snapshot: nothing lies between then and now.
            self.states.iter_mut().for_each(|state| copy(state, x));
            (self.times, self.still) = ([time; 3], 0);
            self.revision += 1;
            return true;
        }
        if time <= self.times[2] {
            // No time has passed; someone may have moved masses by hand.
            if !same {
                copy(&mut self.states[2], x);
                self.still = 0;
                self.revision += 1;
            }
            return !same;
        }
        self.times = [self.times[1], self.times[2], time];
        if same && self.still >= 2 {
            return false;
        }
        self.states.rotate_left(1);
        copy(&mut self.states[2], x);
        self.still = if same { self.still + 1 } else { 0 };
        self.revision += 1;
        true
    }
}

impl SheetMotion {
    /// Takes in a sheet on another grid. Where its masses were is told by how they move, so that what is shown goes on.
    fn begin_anew(&mut self, time: f64, x: &Vectors, v: &Vectors) {
        if time > self.times[2] {
            self.times = [self.times[1], self.times[2], time];
        }
        for (state, then) in self.states.iter_mut().zip(self.times) {
            *state = x.clone();
            state.add_scaled(then - time, v);
        }
        self.still = 0;
        self.revision += 1;
    }
}

/// Copies in place where the number of masses is the same, which it is but for a sheet that was built anew.
fn copy(to: &mut Vectors, from: &Vectors) {
    if to.len() == from.len() {
        to.copy_from(from);
    } else {
        *to = from.clone();
    }
}

/// A body's place in the [`SheetWorld`](super::SheetWorld).
///
/// Put on the entity when its body is built, and taken off with its [`SheetBody`].
#[derive(Component, Clone, Debug)]
pub struct BodyMotion {
    pub(super) names: Vec<String>,
    pub(super) generation: u32,
    pub(super) built_from: SheetBody,
    /// The entity's own transform that the body was put at or last sent to.
    pub(super) given: GlobalTransform,
    /// The path it follows from there, in the world's time; empty for one that is moved by its transform.
    pub(super) path: Vec<PathKey>,
    /// Where a body that moves freely was after the last three ticks.
    pub(super) flight: Option<Flight>,
}

/// The last three places of a body that moves freely, oldest first, and their simulated times, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Flight {
    times: [f64; 3],
    poses: [Pose; 3],
}

impl Flight {
    /// One that is at `pose` at `time`, s.
    pub fn at(time: f64, pose: Pose) -> Self {
        Self { times: [time; 3], poses: [pose; 3] }
    }

    /// Takes in where the body is at `time`, s.
    pub fn record(&mut self, time: f64, pose: Pose) {
        if time > self.times[2] {
            self.times = [self.times[1], self.times[2], time];
            self.poses = [self.poses[1], self.poses[2], pose];
        } else if time < self.times[2] {
            *self = Self::at(time, pose);
        } else {
            self.poses[2] = pose;
        }
    }

    /// Where it is at `time` (s), between the places on both sides of it.
    pub fn shown(&self, time: f64) -> Pose {
        let first = if time < self.times[1] { 0 } else { 1 };
        let (from, to) = (self.times[first], self.times[first + 1]);
        let s = if to > from { ((time - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        let ((a, p), (b, q)) = (self.poses[first], self.poses[first + 1]);
        (a.lerp(b, s), p.slerp(q, s))
    }
}

impl BodyMotion {
    /// The body's name in the world; a body of several polyhedra is as many bodies there, and this is the first's.
    pub fn name(&self) -> &str {
        self.names.first().map_or("", String::as_str)
    }

    /// Whether it goes by this name in the world.
    pub fn is_named(&self, name: &str) -> bool {
        self.names.iter().any(|n| n == name)
    }

    /// Whether it follows a path.
    pub fn is_led(&self) -> bool {
        !self.path.is_empty()
    }

    /// Whether its entity's transform is written by the world, and not read.
    pub fn is_shown(&self) -> bool {
        self.is_led() || self.flight.is_some()
    }

    /// Where it is to be shown at the simulated time `time`, s.
    pub(super) fn at(&self, time: f64) -> Pose {
        self.flight.map_or_else(|| self.led_to(time), |flight| flight.shown(time))
    }

    /// Where its path has it at the simulated time `time`, s.
    fn led_to(&self, time: f64) -> Pose {
        let (offset, rotation) = path_at(&self.path, time);
        let turn = Placement { rotation, ..Placement::default() }.quaternion();
        let (position, start) = super::placement::pose_of(&self.given);
        (position + offset, turn * start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::{DQuat, DVec3};

    fn x_of(x: f64) -> Vectors {
        let mut v = Vectors::default();
        v.push(DVec3::new(x, 0.0, 0.0));
        v
    }

    #[test]
    fn motion_is_shown_between_the_states_on_both_sides_of_the_time() {
        let mut motion = SheetMotion::new("leaf".into(), 0, Sheet::default(), 0.0, &x_of(0.0));
        assert!(!motion.is_moving());
        motion.record(1.0, &x_of(1.0), &x_of(0.0));
        motion.record(2.0, &x_of(3.0), &x_of(0.0));
        assert!(motion.is_moving());
        let x = |motion: &SheetMotion, time| motion.at(0, time).map(|p| p.x);
        assert_eq!(x(&motion, 1.5), Some(2.0));
        assert_eq!(x(&motion, 0.5), Some(0.5));
        assert_eq!((x(&motion, -1.0), x(&motion, 9.0)), (Some(0.0), Some(3.0)), "held at the ends");
        assert_eq!(motion.at(1, 1.5), None);
    }

    #[test]
    fn a_flight_is_shown_between_its_places() {
        let at = |x: f64| (DVec3::X * x, DQuat::from_rotation_y(x));
        let mut flight = Flight::at(0.0, at(0.0));
        assert_eq!(flight.shown(0.5), at(0.0));
        flight.record(1.0, at(1.0));
        flight.record(2.0, at(2.0));
        let (place, turn) = flight.shown(1.5);
        assert!(place.distance(DVec3::X * 1.5) < 1e-12 && turn.angle_between(DQuat::from_rotation_y(1.5)) < 1e-6);
        assert_eq!(flight.shown(9.0), at(2.0));
        flight.record(2.0, at(5.0));
        // Of the two quaternions of one rotation either will do.
        let (place, turn) = flight.shown(2.0);
        assert!(place == DVec3::X * 5.0 && turn.dot(at(5.0).1).abs() > 1.0 - 1e-12);
    }

    #[test]
    fn what_stands_still_is_no_news_from_its_third_state_on() {
        let mut motion = SheetMotion::new("leaf".into(), 0, Sheet::default(), 0.0, &x_of(0.0));
        assert!(motion.record(1.0, &x_of(1.0), &x_of(0.0)));
        assert!(motion.record(2.0, &x_of(1.0), &x_of(0.0)) && motion.record(3.0, &x_of(1.0), &x_of(0.0)));
        assert!(!motion.is_moving() && !motion.record(4.0, &x_of(1.0), &x_of(0.0)));
        assert_eq!(motion.at(0, 2.5), Some(Vec3::X));
        let revision = motion.revision();
        assert!(motion.record(4.0, &x_of(2.0), &x_of(0.0)), "moved by hand while time stood still");
        assert_ne!(motion.revision(), revision);
        assert_eq!(motion.at(0, 4.0), Some(2.0 * Vec3::X));
    }
}
