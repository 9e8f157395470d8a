//! The rigid world: Rapier's bodies and colliders, the scene's own or a caller's.
//!
//! A world owns a [`RigidWorld`] made from the scene's bodies, floor and back wall. A game that already runs Rapier lends
//! its sets as a [`RigidView`] instead. Bodies stand still, follow a path, or move freely: `step` says how.

pub(crate) mod body_contacts;
pub(crate) mod impact;
pub(crate) mod mass_properties;
pub(crate) mod rolling_ball;
pub(crate) mod rolling_resistance;
pub(crate) mod serialization;
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
pub use crate::rigid::mass_properties::MassProperties;
pub(crate) use crate::rigid::rolling_resistance::Support;
pub use crate::rigid::state::BodyState;
pub use crate::rigid::view::RigidView;

use crate::error::{InputError, check_range};
use crate::rigid::rolling_ball::Rolling;
use crate::rigid::shape::{is_convex, polyhedra_of, shapes_of};
use crate::rigid::step::Motion;
use crate::rigid::view::Owners;
use crate::scene::{BodySpec, ContactDefaults, PathKey, Placement, Polyhedron, Room, Scene, Shape, body_name, path_at};

pub(crate) use crate::rigid::view::CONVEX;

/// A body of the scene, for those who show or name it.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name, unique among the bodies.
    pub name: String,
    /// What it was made from.
    pub shape: Shape,
    /// Its faces, local coordinates, m; empty for balls and half spaces.
    pub polyhedra: Vec<Polyhedron>,
    /// Where it was put.
    pub placement: Placement,
    /// How it is led; empty for a body that stands still or moves freely.
    pub path: Vec<PathKey>,
    material: Option<String>,
    handle: RigidBodyHandle,
    colliders: Vec<ColliderHandle>,
}

/// What moves a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Standing,
    /// Its path.
    Path,
    /// A program, which sends it to this place by the end of the next step.
    Sent(Option<(DVec3, DQuat)>),
    /// Gravity and what touches it.
    Free,
}

/// The scene's own Rapier world.
pub struct RigidWorld {
    inner: PhysicsWorld,
    bodies: Vec<Body>,
    motions: Vec<Motion>,
    owners: Owners,
    /// Whether any body is led.
    moving: bool,
    sleep: bool,
    contacts: Vec<BodyContact>,
    /// Scratch of falling asleep.
    groups: Vec<usize>,
    rolling: Rolling,
}

impl RigidWorld {
    /// The bodies of `scene`, its floor and its back wall.
    ///
    /// # Errors
    /// When a shape is not valid or its file cannot be read.
    pub fn build(scene: &Scene) -> Result<Self, InputError> {
        let mut world = Self {
            inner: PhysicsWorld::new(),
            bodies: Vec::new(),
            motions: Vec::new(),
            owners: Owners::new(scene.contact.clone()),
            moving: false,
            sleep: true,
            contacts: Vec::new(),
            groups: Vec::new(),
            rolling: Rolling::default(),
        };
        world.inner.gravity = Vector::ZERO;
        for (index, spec) in scene.bodies.iter().enumerate() {
            let field = format!("bodies.{index}");
            world.add(scene, spec, index).map_err(|mut e| {
                if e.file.is_some() {
                    e.problem = format!("{} (the file of {field}.shape)", e.problem);
                } else {
                    e.field = if e.field.is_empty() { field } else { format!("{field}.{}", e.field) };
                }
                e
            })?;
        }
        if let Some(room) = &scene.room {
            world.add_room(scene, room)?;
        }
        world.settle();
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
            // Local +y, the side a half space is touched from, turned to +z.
            self.add(scene, &plane("back wall", DVec3::new(0.0, 0.0, room.z.0), DVec3::new(90.0, 0.0, 0.0)), 0)?;
        }
        Ok(())
    }

    /// Adds a body; friction, restitution and files are taken as in `scene`. Named "body `index`" if it has no name.
    ///
    /// # Errors
    /// When its shape is not valid or its file cannot be read; nothing is added then.
    pub fn add(&mut self, scene: &Scene, spec: &BodySpec, index: usize) -> Result<(), InputError> {
        let polyhedra = polyhedra_of(scene, &spec.shape)?;
        let shapes = shapes_of(&spec.shape, &polyhedra, spec.is_dynamic())?;
        let motion = motion_of(spec, &polyhedra)?;
        let handle = self.inner.insert_body(builder(&motion));
        let friction = spec.friction.unwrap_or(scene.contact.friction) as f32;
        let restitution = spec.restitution.unwrap_or(scene.contact.restitution) as f32;
        let mut colliders = Vec::new();
        for (index, shape) in shapes.into_iter().enumerate() {
            let mark = if polyhedra.get(index).is_some_and(is_convex) { CONVEX } else { 0 };
            let is_asked = spec.material.is_some() || motion.is_free();
            let hooks = if is_asked { ActiveHooks::MODIFY_SOLVER_CONTACTS } else { ActiveHooks::empty() };
            let collider = ColliderBuilder::new(shape).friction(friction).restitution(restitution).user_data(mark);
            // Its mass is the body's, in f64, and not of its own.
            colliders.push(self.inner.insert_collider(collider.density(0.0).active_hooks(hooks), Some(handle)));
        }
        if motion.is_free() {
            self.tune(2.0 * motion.extent);
        }
        self.moving |= motion.kind == Kind::Path;
        self.owners.push(&colliders, spec.material.as_deref());
        self.motions.push(motion);
        self.bodies.push(Body {
            name: body_name(&spec.name, index),
            shape: spec.shape.clone(),
            polyhedra,
            placement: spec.placement,
            path: spec.path.clone(),
            material: spec.material.clone(),
            handle,
            colliders,
        });
        self.settle();
        Ok(())
    }

    /// Sets what Rapier takes for small and fast to the smallest of the bodies that move freely; `size` is the diameter of one
    /// of them, m.
    fn tune(&mut self, size: f64) {
        let first = !self.motions.iter().any(Motion::is_free);
        let p = &mut self.inner.integration_parameters;
        let before = if first { 1.0 } else { p.length_unit };
        p.length_unit = before.min(size.clamp(1e-3, 1.0) as Real);
        p.normalized_max_linear_velocity = Real::MAX;
        // Contacts that are looked at anew in every step. Friction stays as Rapier has it: its other model, with friction at
        // each point of a contact, brakes a sliding box by a tenth too little.
        p.contact_recycling = false;
        self.owners.reach = p.prediction_distance();
    }

    /// Takes these pairs of materials from the next step on, and wakes all bodies.
    pub(crate) fn set_contact(&mut self, contact: &ContactDefaults) {
        self.owners.contact = contact.clone();
        self.wake_all();
    }

    /// The bodies, scene order, then floor and back wall.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Colliders of body `index`.
    pub(crate) fn colliders(&self, index: usize) -> &[ColliderHandle] {
        self.bodies.get(index).map_or(&[], |b| &b.colliders)
    }

    /// Radius (m) of body `index` if it is a ball.
    pub fn radius(&self, index: usize) -> Option<f64> {
        match self.bodies.get(index)?.shape {
            Shape::Ball(radius) => Some(radius),
            _ => None,
        }
    }

    /// Distance (m) of the furthest point of body `index` from its centre of mass; 0 for one that is not moved by what it meets.
    pub fn extent(&self, index: usize) -> f64 {
        self.motions.get(index).map_or(0.0, |motion| motion.extent)
    }

    /// Index of the body of that name.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|b| b.name == name)
    }

    /// Removes the body of that name and wakes the others; false when there is none.
    pub fn remove(&mut self, name: &str) -> bool {
        let Some(index) = self.index_of(name) else { return false };
        self.inner.remove_body(self.bodies.remove(index).handle);
        self.motions.remove(index);
        self.owners.clear();
        for body in &self.bodies {
            self.owners.push(&body.colliders, body.material.as_deref());
        }
        self.contacts.clear();
        self.wake_all();
        self.settle();
        true
    }

    /// Sends the body of that name to a place (m) where it will be at the end of the next step; false when there is none.
    /// From then on it is moved this way, and neither by a path nor freely.
    pub fn send(&mut self, name: &str, position: DVec3, rotation: DQuat) -> bool {
        let Some(index) = self.index_of(name) else { return false };
        let (body, motion) = (&mut self.bodies[index], &mut self.motions[index]);
        let Some(rigid) = self.inner.bodies.get_mut(body.handle) else { return false };
        let here = rigid.position();
        let there = here.translation == position.as_vec3() && here.rotation == rotation.as_quat();
        if there && motion.kind == Kind::Standing {
            return true;
        }
        body.path.clear();
        if motion.is_free() {
            motion.end = BodyState::standing(motion.end.origin(), motion.end.rotation());
            motion.asleep = false;
        }
        motion.kind = Kind::Sent(Some((position, rotation)));
        rigid.set_body_type(RigidBodyType::KinematicPositionBased, true);
        self.moving = true;
        true
    }

    /// Rapier fills its broad phase in a step; nothing is let move in it.
    fn settle(&mut self) {
        self.inner.gravity = Vector::ZERO;
        self.inner.integration_parameters.dt = 1e-6;
        self.inner.step();
        for index in 0..self.motions.len() {
            if self.motions[index].is_free() {
                self.write(index);
            }
        }
    }

    /// Where body `index` is: position (m) and rotation; `None` when there is no such body.
    pub fn pose(&self, index: usize) -> Option<(DVec3, DQuat)> {
        self.state(index).map(|s| (s.origin(), s.rotation()))
    }

    /// State of body `index` at the end of the last step.
    pub fn state(&self, index: usize) -> Option<&BodyState> {
        self.motions.get(index).map(|m| &m.end)
    }

    /// State of body `index` at the start of the last step; one that is led has the velocity of the step.
    pub fn start(&self, index: usize) -> Option<&BodyState> {
        self.motions.get(index).map(|m| &m.start)
    }

    /// Whether body `index` sleeps.
    pub fn is_asleep(&self, index: usize) -> bool {
        self.motions.get(index).is_some_and(|m| m.asleep)
    }

    /// Whether no body that moves freely is awake.
    pub fn is_quiet(&self) -> bool {
        self.motions.iter().all(|m| m.asleep || !m.is_free())
    }

    /// Name of the body that a collider belongs to.
    pub fn name_of(&self, collider: ColliderHandle) -> Option<&str> {
        self.owners.of(collider).and_then(|b| self.bodies.get(b)).map(|b| b.name.as_str())
    }

    /// Whether any body is led, by a path or a program.
    pub fn moving(&self) -> bool {
        self.moving
    }

    /// What a step looks at.
    pub fn view(&self) -> RigidView<'_> {
        RigidView::of_own(&self.inner, &self.owners)
    }
}

/// Where a body is put, and how it moves at the start.
fn motion_of(spec: &BodySpec, polyhedra: &[Polyhedron]) -> Result<Motion, InputError> {
    let (origin, rotation) = pose_of(&spec.placement, &spec.path, 0.0);
    let mut motion = Motion {
        kind: if spec.path.is_empty() { Kind::Standing } else { Kind::Path },
        start: BodyState::standing(origin, rotation),
        from: BodyState::standing(origin, rotation),
        end: BodyState::standing(origin, rotation),
        asleep: false,
        quiet: 0.0,
        claimed: false,
        pushed: false,
        extent: 0.0,
    };
    if spec.is_dynamic() {
        let spread = MassProperties::of_unit_density(&spec.shape, polyhedra)
            .ok_or_else(|| InputError::new("shape", "has no volume: a body that moves freely needs one"))?;
        let mass = spec.mass.or(spec.density.map(|d| d * spread.mass)).unwrap_or_default();
        check_range("density", mass, 1e-9, 1e9, "kg")
            .map_err(|e| InputError::new(e.field, format!("makes a mass that is not allowed: {}", e.problem)))?;
        let spread = spread.with_mass(mass);
        motion.kind = Kind::Free;
        motion.end = BodyState::new(spread, origin, rotation, spec.velocity, spec.spin);
        (motion.start, motion.from) = (motion.end, motion.end);
        motion.extent = match spec.shape {
            Shape::Ball(radius) => radius,
            _ => polyhedra.iter().flat_map(|p| &p.vertices).map(|p| p.distance(spread.centre)).fold(0.0, f64::max),
        };
    }
    Ok(motion)
}

/// Rapier's body for it.
fn builder(motion: &Motion) -> RigidBodyBuilder {
    let (origin, rotation) = (motion.end.origin().as_vec3(), motion.end.rotation().as_quat());
    let builder = match motion.kind {
        Kind::Standing => RigidBodyBuilder::fixed(),
        Kind::Path | Kind::Sent(_) => RigidBodyBuilder::kinematic_position_based(),
        Kind::Free => {
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
                // When it sleeps is for its world to say.
                .can_sleep(false)
                .ccd_enabled(true)
        }
    };
    builder.pose(Pose::from_parts(origin, rotation))
}

/// Where a path has a body at `time` (s): position (m) and rotation.
fn pose_of(placement: &Placement, path: &[PathKey], time: f64) -> (DVec3, DQuat) {
    let (offset, turn) = path_at(path, time);
    let turn = Placement { position: DVec3::ZERO, rotation: turn };
    (placement.position + offset, turn.quaternion() * placement.quaternion())
}
