//! Rigid bodies: Rapier's bodies and colliders, owned by the world or by the caller.
//!
//! A world owns a [`RigidWorld`], built from the bodies, floor and back wall of the scene. A game
//! that runs Rapier itself lends its sets as a [`RigidView`]. Bodies are static, kinematic or
//! dynamic; `step` advances them.

pub(crate) mod body_contacts;
pub(crate) mod body_loads;
pub(crate) mod impact;
pub(crate) mod joints;
pub(crate) mod lent;
pub(crate) mod mass_properties;
pub(crate) mod rolling_ball;
pub(crate) mod rolling_resistance;
pub(crate) mod serialization;
pub(crate) mod settings;
pub(crate) mod shape;
pub(crate) mod state;
pub(crate) mod step;
pub(crate) mod substeps;
#[cfg(test)]
mod tests;
pub(crate) mod view;

use glam::{DQuat, DVec3};
use rapier3d::prelude::*;

pub use crate::rigid::body_contacts::BodyContact;
pub use crate::rigid::lent::LentBody;
pub use crate::rigid::mass_properties::MassProperties;
pub(crate) use crate::rigid::rolling_resistance::Support;
pub use crate::rigid::state::BodyState;
pub use crate::rigid::view::RigidView;

use crate::error::{InputError, check_range};
use crate::rigid::body_loads::BodyLoad;
use crate::rigid::rolling_ball::RollingBallSolver;
use crate::rigid::shape::{is_convex, polyhedra_of, shapes_of};
use crate::rigid::step::RigidMotion;
use crate::rigid::view::ColliderOwners;
use crate::scene::{BodySpec, ContactDefaults, PathKey, Placement, Polyhedron, Room, Scene, Shape, body_name, path_at};

pub(crate) use crate::rigid::view::CONVEX;

/// Description of a body of the scene, for display.
#[derive(Clone, Debug)]
pub struct RigidBodyInfo {
    /// Name, unique among the bodies.
    pub name: String,
    /// Shape.
    pub shape: Shape,
    /// Faces in the frame of the body, m; empty for balls and half spaces.
    pub polyhedra: Vec<Polyhedron>,
    /// Initial placement.
    pub placement: Placement,
    /// Prescribed path of a kinematic body; empty for other bodies.
    pub path: Vec<PathKey>,
    material: Option<String>,
    handle: RigidBodyHandle,
    colliders: Vec<ColliderHandle>,
}

/// Kind of motion of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MotionKind {
    Static,
    /// Kinematic, along the path of the scene.
    Path,
    /// Kinematic, by program: pose at the end of the next step, if one is set.
    Target(Option<(DVec3, DQuat)>),
    /// Dynamic: gravity and contact.
    Dynamic,
}

/// Rigid bodies of a scene, in a Rapier world of their own.
pub struct RigidWorld {
    inner: PhysicsWorld,
    bodies: Vec<RigidBodyInfo>,
    motions: Vec<RigidMotion>,
    owners: ColliderOwners,
    /// Whether any body is kinematic.
    has_kinematic: bool,
    sleep: bool,
    contacts: Vec<BodyContact>,
    /// Union-find roots of the islands of touching bodies; buffer of the sleep test.
    island_roots: Vec<usize>,
    rolling: RollingBallSolver,
    /// Forces of a program during the present step or advance.
    loads: Vec<BodyLoad>,
    /// Joints removed in the last step.
    lost_joints: u32,
    /// Whether collision groups or sensors differ from the scene.
    has_changed_colliders: bool,
}

impl RigidWorld {
    /// Rigid world with the bodies of `scene`, its floor and its back wall.
    ///
    /// # Errors
    /// If a shape is invalid or its file cannot be read.
    pub fn build(scene: &Scene) -> Result<Self, InputError> {
        let mut world = Self {
            inner: PhysicsWorld::new(),
            bodies: Vec::new(),
            motions: Vec::new(),
            owners: ColliderOwners::new(scene.contact.clone()),
            has_kinematic: false,
            sleep: true,
            contacts: Vec::new(),
            island_roots: Vec::new(),
            rolling: RollingBallSolver::default(),
            loads: Vec::new(),
            lost_joints: 0,
            has_changed_colliders: false,
        };
        world.inner.gravity = Vector::ZERO;
        for (index, spec) in scene.bodies.iter().enumerate() {
            let field = format!("bodies.{index}");
            world.add(scene, spec, index).map_err(|e| e.of_object(&field, &format!("{field}.shape")))?;
        }
        scene.room.as_ref().map_or(Ok(()), |room| world.add_room(scene, room))?;
        world.update_broad_phase();
        Ok(world)
    }

    fn add_room(&mut self, scene: &Scene, room: &Room) -> Result<(), InputError> {
        let plane = |name: &str, position: DVec3, rotation: DVec3| BodySpec {
            name: name.to_owned(),
            placement: Placement { position, rotation },
            ..BodySpec::new(Shape::HalfSpace)
        };
        self.add(scene, &plane("floor", DVec3::new(0.0, room.y.0, 0.0), DVec3::ZERO), 0)?;
        if room.back_wall {
            // Local +y, the outer side of a half space, rotated to +z.
            self.add(scene, &plane("back wall", DVec3::new(0.0, 0.0, room.z.0), DVec3::new(90.0, 0.0, 0.0)), 0)?;
        }
        Ok(())
    }

    /// Add a body; friction, restitution and files default to those of `scene`. A body without a
    /// name is called "body `index`".
    ///
    /// # Errors
    /// If its shape is invalid or its file cannot be read; the world is then unchanged.
    pub fn add(&mut self, scene: &Scene, spec: &BodySpec, index: usize) -> Result<(), InputError> {
        let polyhedra = polyhedra_of(scene, &spec.shape)?;
        let shapes = shapes_of(&spec.shape, &polyhedra, spec.is_dynamic())?;
        let motion = initial_motion(spec, &polyhedra)?;
        let handle = self.inner.insert_body(rapier_builder(&motion));
        let friction = spec.friction.unwrap_or(scene.contact.friction) as f32;
        let restitution = spec.restitution.unwrap_or(scene.contact.restitution) as f32;
        let mut colliders = Vec::new();
        for (index, shape) in shapes.into_iter().enumerate() {
            let mark = if polyhedra.get(index).is_some_and(is_convex) { CONVEX } else { 0 };
            let is_asked = spec.material.is_some() || motion.is_free();
            let hooks = if is_asked { ActiveHooks::MODIFY_SOLVER_CONTACTS } else { ActiveHooks::empty() };
            let collider = ColliderBuilder::new(shape).friction(friction).restitution(restitution).user_data(mark);
            // The collider has no mass of its own: the body has its mass in f64.
            colliders.push(self.inner.insert_collider(collider.density(0.0).active_hooks(hooks), Some(handle)));
        }
        if motion.is_free() {
            self.tune_rapier(2.0 * motion.extent);
        }
        self.has_kinematic |= motion.kind == MotionKind::Path;
        self.owners.push(&colliders, spec.material.as_deref());
        self.motions.push(motion);
        self.bodies.push(RigidBodyInfo {
            name: body_name(&spec.name, index),
            shape: spec.shape.clone(),
            polyhedra,
            placement: spec.placement,
            path: spec.path.clone(),
            material: spec.material.clone(),
            handle,
            colliders,
        });
        self.update_broad_phase();
        Ok(())
    }

    /// Adjust Rapier's length unit and speed limit to the smallest dynamic body. `size` is the
    /// diameter of a body to be added, m.
    fn tune_rapier(&mut self, size: f64) {
        let first = !self.motions.iter().any(RigidMotion::is_free);
        let p = &mut self.inner.integration_parameters;
        let before = if first { 1.0 } else { p.length_unit };
        p.length_unit = before.min(size.clamp(1e-3, 1.0) as Real);
        p.normalized_max_linear_velocity = Real::MAX;
        // Contacts are recomputed in each step. Friction uses Rapier's default model: the model
        // with friction at each contact point decelerates a sliding box by 10 % too little.
        p.contact_recycling = false;
        self.owners.contact_distance = p.prediction_distance();
    }

    /// Set the contact coefficients and material pairs from the next step on, and wake all bodies.
    pub(crate) fn set_contact(&mut self, contact: &ContactDefaults) {
        self.owners.contact = contact.clone();
        self.wake_all();
    }

    /// Bodies in the order of the scene, then floor and back wall.
    pub fn bodies(&self) -> &[RigidBodyInfo] {
        &self.bodies
    }

    /// Colliders of body `index`; empty for an index out of range.
    pub(crate) fn colliders(&self, index: usize) -> &[ColliderHandle] {
        self.bodies.get(index).map_or(&[], |b| &b.colliders)
    }

    /// Radius (m) of body `index`; `None` unless it is a ball.
    pub fn radius(&self, index: usize) -> Option<f64> {
        match self.bodies.get(index)?.shape {
            Shape::Ball(radius) => Some(radius),
            _ => None,
        }
    }

    /// Distance (m) of the farthest point of body `index` from its centre of mass; 0 for a body
    /// that is not dynamic.
    pub fn extent(&self, index: usize) -> f64 {
        self.motions.get(index).map_or(0.0, |motion| motion.extent)
    }

    /// Set the collision groups of body `index`, which exists, and wake all.
    pub(crate) fn set_groups(&mut self, index: usize, groups: InteractionGroups) {
        self.change_colliders(index, |collider| collider.set_collision_groups(groups));
    }

    /// Let body `index`, which exists, be a sensor or solid, and wake all. Return whether that is a
    /// change.
    pub(crate) fn set_sensor(&mut self, index: usize, is_sensor: bool) -> bool {
        let is_change = self.is_sensor(index) != is_sensor;
        if is_change {
            self.change_colliders(index, |collider| collider.set_sensor(is_sensor));
        }
        is_change
    }

    /// Whether body `index` is a sensor.
    pub(crate) fn is_sensor(&self, index: usize) -> bool {
        let collider = self.colliders(index).first().and_then(|handle| self.inner.colliders.get(*handle));
        collider.is_some_and(Collider::is_sensor)
    }

    fn change_colliders(&mut self, index: usize, change: impl Fn(&mut Collider)) {
        for handle in &self.bodies[index].colliders {
            if let Some(collider) = self.inner.colliders.get_mut(*handle) {
                change(collider);
            }
        }
        self.has_changed_colliders = true;
        self.contacts.clear();
        self.wake_all();
    }

    /// Index of the body called `name`.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|b| b.name == name)
    }

    /// Remove body `index`, which exists, and wake the others. Return its name.
    pub(crate) fn remove(&mut self, index: usize) -> String {
        let removed = self.bodies.remove(index);
        self.inner.remove_body(removed.handle);
        self.motions.remove(index);
        self.loads.retain(|load| load.body != index);
        self.loads.iter_mut().filter(|load| load.body > index).for_each(|load| load.body -= 1);
        self.owners.clear();
        for body in &self.bodies {
            self.owners.push(&body.colliders, body.material.as_deref());
        }
        self.contacts.clear();
        self.wake_all();
        self.update_broad_phase();
        removed.name
    }

    /// Set the pose (position in m) that body `index`, which exists, reaches at the end of the next
    /// step. The body is kinematic from then on and leaves its path. Return false if Rapier has no
    /// such body.
    pub(crate) fn set_target(&mut self, index: usize, position: DVec3, rotation: DQuat) -> bool {
        let (body, motion) = (&mut self.bodies[index], &mut self.motions[index]);
        let Some(rigid) = self.inner.bodies.get_mut(body.handle) else { return false };
        let here = rigid.position();
        let there = here.translation == position.as_vec3() && here.rotation == rotation.as_quat();
        if there && motion.kind == MotionKind::Static {
            return true;
        }
        body.path.clear();
        if motion.is_free() {
            motion.end = BodyState::fixed_at(motion.end.origin(), motion.end.rotation());
            motion.asleep = false;
        }
        motion.kind = MotionKind::Target(Some((position, rotation)));
        rigid.set_body_type(RigidBodyType::KinematicPositionBased, true);
        self.has_kinematic = true;
        true
    }

    /// Update Rapier's broad phase by a step without gravity, short enough that no body moves
    /// visibly.
    fn update_broad_phase(&mut self) {
        self.inner.gravity = Vector::ZERO;
        self.inner.integration_parameters.dt = 1e-6;
        self.inner.step();
        for index in 0..self.motions.len() {
            if self.motions[index].is_free() {
                self.write_to_rapier(index);
            }
        }
    }

    /// Pose of body `index`: position (m) and rotation; `None` for an index out of range.
    pub fn pose(&self, index: usize) -> Option<(DVec3, DQuat)> {
        self.state(index).map(|s| (s.origin(), s.rotation()))
    }

    /// State of body `index` at the end of the last step.
    pub fn state(&self, index: usize) -> Option<&BodyState> {
        self.motions.get(index).map(|m| &m.end)
    }

    /// State of body `index` at the start of the last step. A kinematic body has its velocity in
    /// that step.
    pub fn start(&self, index: usize) -> Option<&BodyState> {
        self.motions.get(index).map(|m| &m.start)
    }

    /// Whether body `index` sleeps.
    pub fn is_asleep(&self, index: usize) -> bool {
        self.motions.get(index).is_some_and(|m| m.asleep)
    }

    /// Whether all dynamic bodies sleep.
    pub fn all_asleep(&self) -> bool {
        self.motions.iter().all(|m| m.asleep || !m.is_free())
    }

    /// Name of the body that owns a collider.
    pub fn name_of(&self, collider: ColliderHandle) -> Option<&str> {
        self.owners.body_of(collider).and_then(|b| self.bodies.get(b)).map(|b| b.name.as_str())
    }

    /// First time (s) between `from` and `to` at which the velocity of a body on its path changes
    /// by more than `speed` (m/s).
    pub(crate) fn first_jolt(&self, (from, to): (f64, f64), speed: f64) -> Option<f64> {
        let jolts = self.bodies.iter().flat_map(|body| {
            let path = &body.path;
            let velocity = |k: usize| match (path.get(k), path.get(k + 1)) {
                (Some(a), Some(b)) => (b.offset - a.offset) / (b.time - a.time),
                _ => DVec3::ZERO,
            };
            let before = move |k: usize| k.checked_sub(1).map_or(DVec3::ZERO, velocity);
            let inside = path.iter().enumerate().filter(move |(_, key)| key.time > from && key.time < to);
            inside.filter(move |(k, _)| velocity(*k).distance(before(*k)) > speed).map(|(_, key)| key.time)
        });
        jolts.min_by(f64::total_cmp)
    }

    /// Whether any body is kinematic, by a path or a program.
    pub fn has_kinematic(&self) -> bool {
        self.has_kinematic
    }

    /// View of bodies and colliders for a step of the sheets.
    pub fn view(&self) -> RigidView<'_> {
        RigidView::from_world(&self.inner, &self.owners)
    }
}

/// Initial pose and motion of a body.
fn initial_motion(spec: &BodySpec, polyhedra: &[Polyhedron]) -> Result<RigidMotion, InputError> {
    let (origin, rotation) = path_pose(&spec.placement, &spec.path, 0.0);
    let mut motion = RigidMotion {
        kind: if spec.path.is_empty() { MotionKind::Static } else { MotionKind::Path },
        start: BodyState::fixed_at(origin, rotation),
        substep_start: BodyState::fixed_at(origin, rotation),
        end: BodyState::fixed_at(origin, rotation),
        asleep: false,
        rest_time: 0.0,
        set_by_contact: false,
        had_impulse: false,
        extent: 0.0,
    };
    if spec.is_dynamic() {
        let spread = MassProperties::from_shape(&spec.shape, polyhedra)
            .ok_or_else(|| InputError::new("shape", "has no volume: a body that moves freely needs one"))?;
        let mass = spec.mass.or(spec.density.map(|d| d * spread.mass)).unwrap_or_default();
        check_range("density", mass, 1e-9, 1e9, "kg")
            .map_err(|e| InputError::new(e.field, format!("makes a mass that is not allowed: {}", e.problem)))?;
        let spread = spread.with_mass(mass);
        motion.kind = MotionKind::Dynamic;
        motion.end = BodyState::new(spread, origin, rotation, spec.velocity, spec.spin);
        (motion.start, motion.substep_start) = (motion.end, motion.end);
        motion.extent = match spec.shape {
            Shape::Ball(radius) => radius,
            _ => polyhedra.iter().flat_map(|p| &p.vertices).map(|p| p.distance(spread.centre)).fold(0.0, f64::max),
        };
    }
    Ok(motion)
}

/// Rapier's body for this motion.
fn rapier_builder(motion: &RigidMotion) -> RigidBodyBuilder {
    let (origin, rotation) = (motion.end.origin().as_vec3(), motion.end.rotation().as_quat());
    let builder = match motion.kind {
        MotionKind::Static => RigidBodyBuilder::fixed(),
        MotionKind::Path | MotionKind::Target(_) => RigidBodyBuilder::kinematic_position_based(),
        MotionKind::Dynamic => {
            let m = motion.end.mass_properties();
            RigidBodyBuilder::dynamic()
                .additional_mass_properties(rapier3d::prelude::MassProperties::with_principal_inertia_frame(
                    m.centre.as_vec3(),
                    m.mass as f32,
                    m.principal.as_vec3(),
                    m.axes.as_quat(),
                ))
                .linvel(motion.end.velocity().as_vec3())
                .angvel(motion.end.spin().as_vec3())
                // The rigid world decides about sleep.
                .can_sleep(false)
                .ccd_enabled(true)
        }
    };
    builder.pose(Pose::from_parts(origin, rotation))
}

/// Pose on a path at `time` (s): position (m) and rotation.
fn path_pose(placement: &Placement, path: &[PathKey], time: f64) -> (DVec3, DQuat) {
    let (offset, turn) = path_at(path, time);
    let turn = Placement { position: DVec3::ZERO, rotation: turn };
    (placement.position + offset, turn.quaternion() * placement.quaternion())
}
