//! Components with the last states of a sheet and of a body, for interpolated display.

use std::sync::Arc;

use bevy::prelude::*;
use sheetwork::math::Vectors;
use sheetwork::scene::{PathKey, Placement, Region, path_at};
use sheetwork::sheet::Sheet as SheetInWorld;
use sheetwork::{BodyId, SheetId};

use super::frame::{frame_of, relative};
use super::placement::{Pose, compose};
use super::{Sheet, SheetBody, SheetWorld};

/// Link from the entity to its sheet in the [`SheetWorld`](super::SheetWorld), with the node
/// positions after the last three ticks.
///
/// Inserted when the sheet is built, removed with its [`Sheet`].
#[derive(Component, Clone, Debug)]
pub struct SheetMotion {
    id: SheetId,
    name: String,
    pub(super) generation: u32,
    pub(super) built_from: Sheet,
    /// Node positions, m, oldest first.
    states: [Vectors; 3],
    /// Simulated times of the states, s.
    times: [f64; 3],
    /// Consecutive ticks without motion, at most 2; then all three states are equal.
    still: u8,
    revision: u64,
    /// Levels of a locally refined mesh in the last state.
    refinement: Option<Arc<[u8]>>,
    /// Topology of the last state, and its revision.
    topology: (Topology, u64),
    /// Transform of the entity that the sheet has followed or that follows it; `None` before the
    /// first tick.
    pub(super) given: Option<Transform>,
    /// Parent of the entity at the last tick; `None` before the first.
    pub(super) parent: Option<LastParent>,
    /// Attachments by entity that the world has.
    pub(super) attached: Attached,
    frame: Option<FrameMotion>,
}

/// Grid, open cells and thickness (m) of a sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Topology {
    nodes: usize,
    grid: (u32, u32, u32),
    opening: u64,
    thickness: f64,
}

impl Topology {
    fn of_sheet(sheet: &SheetInWorld) -> Self {
        Self {
            nodes: sheet.node_count(),
            grid: sheet.model.grid,
            opening: sheet.opening_revision(),
            thickness: sheet.material().thickness,
        }
    }
}

/// Attachments of a sheet by entity.
#[derive(Clone, Debug, Default)]
pub(super) struct Attached {
    pub list: Vec<(Region, Entity)>,
    /// Entities without a body that attachments wait for.
    pub waits: Vec<Entity>,
}

/// Pose of a sheet's entity, which follows the sheet.
#[derive(Clone, Copy, Debug)]
struct FrameMotion {
    /// Pose of the entity in the frame of the sheet.
    anchor: Pose,
    history: PoseHistory,
    /// Transform at which the sheet was first built.
    start: Transform,
}

/// Parent of a sheet's entity at the last tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct LastParent {
    pub entity: Option<Entity>,
    pub transform: GlobalTransform,
    /// Whether a change of its scale has been told.
    pub is_told: bool,
}

impl LastParent {
    /// Parent with this transform.
    pub fn new(parent: Option<&ChildOf>, transform: GlobalTransform) -> Self {
        Self { entity: parent.map(ChildOf::parent), transform, is_told: false }
    }
}

impl SheetMotion {
    /// Let the pose of the entity, at present `pose`, follow `sheet` at `time`, s. `start` is its
    /// transform at the first time.
    pub(super) fn follow(&mut self, sheet: &SheetInWorld, (time, pose): (f64, Pose), start: Transform) {
        self.topology.0 = Topology::of_sheet(sheet);
        self.frame = frame_of(sheet).map(|frame| FrameMotion {
            anchor: relative(frame, pose),
            history: PoseHistory::new(time, pose),
            start,
        });
    }

    /// Transform at which the sheet was first built, once its entity follows it.
    pub(super) fn start(&self) -> Option<Transform> {
        self.frame.map(|frame| frame.start)
    }

    /// Pose of the entity at the simulated time `time`, s.
    pub(super) fn pose_at(&self, time: f64) -> Option<Pose> {
        self.frame.map(|frame| frame.history.shown(time))
    }

    /// Pose of the entity after the last tick.
    pub(super) fn pose(&self) -> Option<Pose> {
        self.frame.map(|frame| frame.history.latest())
    }

    /// Store the pose at `time`, s; one without axes keeps its last rotation.
    fn record_frame(&mut self, time: f64, sheet: &SheetInWorld) {
        let Some(motion) = &mut self.frame else { return };
        let kept = || (sheet.centre_of_mass(), (motion.history.latest().1 * motion.anchor.1.conjugate()).normalize());
        let frame = frame_of(sheet).unwrap_or_else(kept);
        motion.history.record(time, compose(frame, motion.anchor));
    }

    pub(crate) fn new(
        (id, name): (SheetId, String),
        generation: u32,
        built_from: Sheet,
        time: f64,
        x: &Vectors,
    ) -> Self {
        let states = [x.clone(), x.clone(), x.clone()];
        let times = [time; 3];
        Self {
            id,
            name,
            generation,
            built_from,
            states,
            times,
            still: 2,
            revision: 0,
            refinement: None,
            topology: (Topology::default(), 0),
            given: None,
            parent: None,
            attached: Attached::default(),
            frame: None,
        }
    }

    /// Id of the sheet in the world: `world.get_sheet(motion.id())`.
    pub fn id(&self) -> SheetId {
        self.id
    }

    /// The sheet in the world; `None` after a restart, until the sheet is built again.
    pub fn sheet<'w>(&self, world: &'w SheetWorld) -> Option<&'w SheetInWorld> {
        world.get_sheet(self.id).filter(|_| self.generation == world.generation())
    }

    /// Name of the sheet in the world, as in parameter paths.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Node positions after the last tick, m.
    pub fn positions(&self) -> &Vectors {
        &self.states[2]
    }

    /// Whether any node moved in the last ticks.
    pub fn is_moving(&self) -> bool {
        self.still < 2
    }

    /// States before and after the simulated time `time` (s), and the interpolation parameter, 0 to
    /// 1, between them.
    pub fn around(&self, time: f64) -> (&Vectors, &Vectors, f32) {
        let first = if time < self.times[1] { 0 } else { 1 };
        let (from, to) = (self.times[first], self.times[first + 1]);
        let s = if to > from { ((time - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        (&self.states[first], &self.states[first + 1], s as f32)
    }

    /// Position of node `i` at the simulated time `time` (s), m. The displayed time is
    /// [`SheetWorld::shown_time`](super::SheetWorld::shown_time). `None` when there is no such
    /// node.
    pub fn at(&self, i: usize, time: f64) -> Option<Vec3> {
        let (a, b, s) = self.around(time);
        (i < a.len().min(b.len())).then(|| a.get(i).lerp(b.get(i), f64::from(s)).as_vec3())
    }

    /// Revision of the displayed shape. It changes with every change of the states.
    #[cfg_attr(not(feature = "render"), allow(dead_code))]
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    /// Levels of a locally refined mesh in the last state.
    #[cfg_attr(not(feature = "render"), allow(dead_code))]
    pub(crate) fn refinement(&self) -> &Option<Arc<[u8]>> {
        &self.refinement
    }

    /// Revision of what a mesh of the sheet is made for, in the last state: grid, open cells,
    /// thickness.
    #[cfg_attr(not(feature = "render"), allow(dead_code))]
    pub(crate) fn topology(&self) -> u64 {
        self.topology.1
    }

    /// Store the state of a sheet that was moved at once: there is no motion to show.
    pub(super) fn jump(&mut self, sheet: &SheetInWorld) {
        self.states.iter_mut().for_each(|state| copy(state, &sheet.state.x));
        self.still = 0;
        self.revision += 1;
        let time = self.times[2];
        self.record_frame(time, sheet);
        if let Some(frame) = &mut self.frame {
            frame.history = PoseHistory::new(time, frame.history.latest());
        }
    }

    /// Store the state of a sheet that is in the world again from `time`, s, on.
    pub(super) fn rejoin(&mut self, time: f64, sheet: &SheetInWorld) {
        self.times = [time; 3];
        self.parent = None;
        self.jump(sheet);
    }

    /// Store the state of `sheet` at `time`, s, as [`SheetMotion::record`].
    pub(super) fn record_sheet(&mut self, time: f64, sheet: &SheetInWorld) -> bool {
        self.record_frame(time, sheet);
        let topology = Topology::of_sheet(sheet);
        if topology != self.topology.0 || self.refinement != sheet.model.refinement {
            self.topology = (topology, self.topology.1 + 1);
        }
        let (x, v) = (&sheet.state.x, &sheet.state.v);
        if self.refinement != sheet.model.refinement {
            self.refinement = sheet.model.refinement.clone();
            // Meshes may differ with the same number of nodes.
            if time >= self.times[2] && x.len() == self.states[2].len() {
                self.replace_grid(time, x, v);
                return true;
            }
        }
        self.record(time, x, v)
    }

    /// Store node positions `x` and velocities `v` at `time`, s. Returns whether the displayed
    /// shape changes. Allocates only after a change of grid.
    pub(super) fn record(&mut self, time: f64, x: &Vectors, v: &Vectors) -> bool {
        if x.len() != self.states[2].len() && time >= self.times[2] {
            self.replace_grid(time, x, v);
            return true;
        }
        let same = *x == self.states[2];
        if time < self.times[2] {
            // After a reset or a rollback there is no motion to interpolate.
            self.states.iter_mut().for_each(|state| copy(state, x));
            (self.times, self.still) = ([time; 3], 0);
            self.revision += 1;
            return true;
        }
        if time <= self.times[2] {
            // No time has passed, but a system may have moved nodes.
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
    /// Replace all states after a change of grid. The earlier positions are extrapolated from the
    /// velocities, so that the displayed motion continues.
    fn replace_grid(&mut self, time: f64, x: &Vectors, v: &Vectors) {
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

/// Copy in place when the number of nodes is unchanged.
fn copy(to: &mut Vectors, from: &Vectors) {
    if to.len() == from.len() {
        to.copy_from(from);
    } else {
        *to = from.clone();
    }
}

/// Link from the entity to its bodies in the [`SheetWorld`](super::SheetWorld).
///
/// Inserted when the body is built, removed with its [`SheetBody`].
#[derive(Component, Clone, Debug)]
pub struct BodyMotion {
    pub(super) ids: Vec<BodyId>,
    pub(super) names: Vec<String>,
    pub(super) generation: u32,
    pub(super) built_from: SheetBody,
    /// Transform of the entity at which the body was placed or to which it was last moved.
    pub(super) given: GlobalTransform,
    /// Path from there, in the world's time; empty for a body that its transform moves.
    pub(super) path: Vec<PathKey>,
    /// Poses of a dynamic body after the last three ticks.
    pub(super) history: Option<PoseHistory>,
}

/// Last three poses of a dynamic body, oldest first, and their simulated times, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PoseHistory {
    times: [f64; 3],
    poses: [Pose; 3],
}

impl PoseHistory {
    /// Poses of a body that rests at `pose` until `time`, s.
    pub fn new(time: f64, pose: Pose) -> Self {
        Self { times: [time; 3], poses: [pose; 3] }
    }

    /// Store the pose at `time`, s.
    pub fn record(&mut self, time: f64, pose: Pose) {
        if time > self.times[2] {
            self.times = [self.times[1], self.times[2], time];
            self.poses = [self.poses[1], self.poses[2], pose];
        } else if time < self.times[2] {
            *self = Self::new(time, pose);
        } else {
            self.poses[2] = pose;
        }
    }

    /// Last pose.
    pub fn latest(&self) -> Pose {
        self.poses[2]
    }

    /// Pose at `time` (s), interpolated between the neighbouring states.
    pub fn shown(&self, time: f64) -> Pose {
        let first = if time < self.times[1] { 0 } else { 1 };
        let (from, to) = (self.times[first], self.times[first + 1]);
        let s = if to > from { ((time - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        let ((a, p), (b, q)) = (self.poses[first], self.poses[first + 1]);
        (a.lerp(b, s), p.slerp(q, s))
    }
}

impl BodyMotion {
    /// Name of the body in the world. A shape of several polyhedra makes several bodies there; this
    /// is the name of the first.
    pub fn name(&self) -> &str {
        self.names.first().map_or("", String::as_str)
    }

    /// Id of the first of its bodies in the world, as for
    /// [`World::apply_body_force`](sheetwork::World::apply_body_force).
    pub fn id(&self) -> Option<BodyId> {
        self.ids.first().copied()
    }

    /// Whether one of its bodies in the world has this name.
    pub fn is_named(&self, name: &str) -> bool {
        self.names.iter().any(|n| n == name)
    }

    /// Whether the body follows a path.
    pub fn follows_path(&self) -> bool {
        !self.path.is_empty()
    }

    /// Whether the plugin writes the entity's transform instead of reading it.
    pub fn writes_transform(&self) -> bool {
        self.follows_path() || self.history.is_some()
    }

    /// Displayed pose at the simulated time `time`, s.
    pub(super) fn at(&self, time: f64) -> Pose {
        self.history.map_or_else(|| self.path_pose(time), |history| history.shown(time))
    }

    /// Pose on the path at the simulated time `time`, s.
    fn path_pose(&self, time: f64) -> Pose {
        let (offset, rotation) = path_at(&self.path, time);
        let turn = Placement { rotation, ..Placement::default() }.quaternion();
        let (position, start) = super::placement::pose_of(&self.given);
        (position + offset, turn * start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Id of a sheet.
    fn id() -> SheetId {
        let mut world = sheetwork::World::new(&Default::default()).expect("valid");
        world.add_sheet(&Default::default()).expect("valid")
    }
    use bevy::math::{DQuat, DVec3};

    fn x_of(x: f64) -> Vectors {
        let mut v = Vectors::default();
        v.push(DVec3::new(x, 0.0, 0.0));
        v
    }

    #[test]
    fn displayed_motion_is_interpolated_between_the_neighbouring_states() {
        let mut motion = SheetMotion::new((id(), "leaf".into()), 0, Sheet::default(), 0.0, &x_of(0.0));
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
    fn a_displayed_pose_is_interpolated() {
        let at = |x: f64| (DVec3::X * x, DQuat::from_rotation_y(x));
        let mut history = PoseHistory::new(0.0, at(0.0));
        assert_eq!(history.shown(0.5), at(0.0));
        history.record(1.0, at(1.0));
        history.record(2.0, at(2.0));
        let (place, turn) = history.shown(1.5);
        assert!(place.distance(DVec3::X * 1.5) < 1e-12 && turn.angle_between(DQuat::from_rotation_y(1.5)) < 1e-6);
        assert_eq!(history.shown(9.0), at(2.0));
        history.record(2.0, at(5.0));
        // Either of the two quaternions of a rotation is valid.
        let (place, turn) = history.shown(2.0);
        assert!(place == DVec3::X * 5.0 && turn.dot(at(5.0).1).abs() > 1.0 - 1e-12);
    }

    #[test]
    fn a_resting_sheet_reports_no_change_from_its_third_state_on() {
        let mut motion = SheetMotion::new((id(), "leaf".into()), 0, Sheet::default(), 0.0, &x_of(0.0));
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
