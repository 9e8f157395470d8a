//! Serialisation of the rigid world: the f64 states, and Rapier's sets if any body can move.
//!
//! Rapier carries more than poses between steps: warm-start impulses, pairs, the order of its
//! islands. All its sets are serialised by their own implementation. A world of static bodies omits
//! them, since it equals the world as built from its scene.

use glam::{DQuat, DVec3};
use rapier3d::prelude::{ImpulseJoint, PhysicsWorld, Real};

use crate::error::InputError;
use crate::rigid::step::RigidMotion;
use crate::rigid::{BodyState, MotionKind, RigidBodyInfo, RigidWorld};
use crate::scene::Scene;
use crate::serialize::{CorruptState, ReadResult, State, StateReader, StateWriter};

/// Bodies of a rigid world, and Rapier's sets in a state with these bodies.
pub(crate) struct RigidLayout {
    bodies: Vec<RigidBodyInfo>,
    motions: Vec<RigidMotion>,
    sets: Vec<u8>,
    has_changed_colliders: bool,
    sleep: bool,
    contact_distance: Real,
}

impl RigidWorld {
    /// Present bodies.
    pub(crate) fn layout(&self) -> RigidLayout {
        RigidLayout {
            bodies: self.bodies.clone(),
            motions: self.motions.clone(),
            // An error leaves an empty byte sequence, which is rejected later.
            sets: postcard::to_extend(&self.inner, Vec::new()).unwrap_or_default(),
            has_changed_colliders: self.has_changed_colliders,
            sleep: self.sleep,
            contact_distance: self.owners.contact_distance,
        }
    }

    /// Rigid world with the bodies of `layout`, and the contact parameters of `scene`.
    ///
    /// # Errors
    /// If Rapier's sets cannot be read.
    pub(crate) fn from_layout(layout: &RigidLayout, scene: &Scene) -> Result<Self, InputError> {
        let unreadable = |_| InputError::new("bodies", "Rapier's sets cannot be read");
        let inner: PhysicsWorld = postcard::from_bytes(&layout.sets).map_err(unreadable)?;
        let mut world = Self::build(&Scene { bodies: Vec::new(), room: None, ..scene.clone() })?;
        world.owners.clear();
        for body in &layout.bodies {
            world.owners.push(&body.colliders, body.material.as_deref());
        }
        world.owners.contact_distance = layout.contact_distance;
        (world.inner, world.bodies, world.motions) = (inner, layout.bodies.clone(), layout.motions.clone());
        world.has_kinematic = world.motions.iter().any(|motion| motion.kind == MotionKind::Path);
        (world.has_changed_colliders, world.sleep) = (layout.has_changed_colliders, layout.sleep);
        Ok(world)
    }

    /// Serialise the rigid world.
    pub(crate) fn serialise(&self, to: &mut StateWriter) {
        to.count(self.motions.len() as u64);
        self.motions.iter().for_each(|motion| serialise_motion(motion, to));
        self.serialise_loads(to);
        let flags = [self.has_kinematic, self.has_changed_colliders, self.differs_from_scene()];
        flags.into_iter().for_each(|f| to.flag(f));
        if self.differs_from_scene() {
            // An error of serialisation leaves an empty byte sequence, which deserialisation
            // rejects.
            let sets = postcard::to_extend(&self.inner, Vec::new()).unwrap_or_default();
            to.blob(&sets);
        }
    }

    /// Deserialise the rigid world in place; `scene` is the one from which it was built.
    pub(crate) fn deserialise(&mut self, from: &mut StateReader, scene: &Scene) -> ReadResult {
        if from.count()? != self.motions.len() as u64 {
            return Err(CorruptState);
        }
        let motions =
            (0..self.motions.len()).map(|_| deserialise_motion(from)).collect::<ReadResult<Vec<RigidMotion>>>()?;
        self.deserialise_loads(from)?;
        let (moving, changed, has_sets) = (from.flag()?, from.flag()?, from.flag()?);
        if has_sets {
            let inner: PhysicsWorld = postcard::from_bytes(from.blob()?).map_err(|_| CorruptState)?;
            let known = |b: &RigidBodyInfo| {
                inner.bodies.get(b.handle).is_some() && b.colliders.iter().all(|c| inner.colliders.get(*c).is_some())
            };
            let counts = (inner.bodies.len(), inner.colliders.len());
            let joined = |handle| inner.bodies.get(handle).is_some();
            let holds = |(_, joint): (_, &ImpulseJoint)| joined(joint.body1()) && joined(joint.body2());
            if counts != (self.inner.bodies.len(), self.inner.colliders.len())
                || !self.bodies.iter().all(known)
                || !inner.impulse_joints.iter().all(holds)
            {
                return Err(CorruptState);
            }
            self.inner = inner;
        } else if self.differs_from_scene() {
            let (sleep, loads) = (self.sleep, std::mem::take(&mut self.loads));
            *self = Self::build(scene).map_err(|_| CorruptState)?;
            (self.sleep, self.loads) = (sleep, loads);
            if motions.len() != self.motions.len() {
                return Err(CorruptState);
            }
        }
        for (index, (motion, body)) in motions.iter().zip(&mut self.bodies).enumerate() {
            // A body moved by a program has no path.
            if motion.kind == MotionKind::Path && body.path.is_empty() {
                body.path = scene.bodies.get(index).map(|b| b.path.clone()).unwrap_or_default();
            } else if matches!(motion.kind, MotionKind::Target(_)) {
                body.path.clear();
            }
        }
        (self.motions, self.has_kinematic, self.has_changed_colliders) = (motions, moving, changed);
        self.contacts.clear();
        Ok(())
    }

    /// Whether Rapier's sets differ from those as built: a body is kinematic or dynamic, or a
    /// collider was changed.
    fn differs_from_scene(&self) -> bool {
        self.has_changed_colliders || self.has_kinematic || self.motions.iter().any(|m| m.kind != MotionKind::Static)
    }
}

fn serialise_motion(motion: &RigidMotion, to: &mut StateWriter) {
    let kind = match &motion.kind {
        MotionKind::Static => 0,
        MotionKind::Path => 1,
        MotionKind::Target(None) => 2,
        MotionKind::Target(Some(_)) => 3,
        MotionKind::Dynamic => 4,
    };
    to.byte(kind);
    if let MotionKind::Target(Some((place, rotation))) = motion.kind {
        to.vector(place);
        to.rotation(rotation);
    }
    motion.start.serialise(to);
    motion.end.serialise(to);
    [motion.asleep, motion.set_by_contact, motion.had_impulse].serialise(to);
    [motion.rest_time, motion.extent].serialise(to);
}

fn deserialise_motion(from: &mut StateReader) -> ReadResult<RigidMotion> {
    let kind = match from.byte()? {
        0 => MotionKind::Static,
        1 => MotionKind::Path,
        2 => MotionKind::Target(None),
        3 => MotionKind::Target(Some((from.vector()?, from.rotation()?))),
        4 => MotionKind::Dynamic,
        _ => return Err(CorruptState),
    };
    let mut states = [BodyState::fixed_at(DVec3::ZERO, DQuat::IDENTITY); 2];
    states.deserialise(from)?;
    let [start, end] = states;
    let [asleep, set_by_contact, had_impulse] = from.read()?;
    let [rest_time, extent] = from.read()?;
    Ok(RigidMotion { kind, start, substep_start: start, end, asleep, rest_time, set_by_contact, had_impulse, extent })
}
