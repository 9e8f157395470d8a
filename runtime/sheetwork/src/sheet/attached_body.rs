//! Nodes of a sheet that are attached to a rigid body of the world or of the caller's rigid world.
//!
//! A node keeps its position l in the frame of the body. With the position x and the rotation q of
//! a static or kinematic body it is at x + q l; a dynamic body gets the attachment force from the
//! contact solver.

use glam::DVec3;
use rapier3d::prelude::RigidBodyHandle;

use crate::rigid::BodyState;
use crate::serialize::{CorruptState, ReadResult, State, StateReader, StateWriter};

/// Body that nodes are attached to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AttachedTo {
    /// Body of the world, by its index.
    Own(usize),
    /// Body of the caller's rigid world.
    Lent(RigidBodyHandle),
}

/// A body over one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyMotion {
    /// Index in the list of the bodies of the step, if it is dynamic.
    pub index: Option<usize>,
    /// States at the start and at the end.
    pub from: BodyState,
    pub to: BodyState,
}

/// Nodes attached to a body.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Attachment {
    /// Name of the body in the description; empty for an attachment of a running sheet.
    pub name: String,
    /// Each node, its initial position (m), and its position in the frame of the body (m) once the
    /// body is known.
    pub masses: Vec<(u32, DVec3, DVec3)>,
    pub body: Option<AttachedBody>,
}

/// Body of an attachment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AttachedBody {
    pub owner: AttachedTo,
    /// Index in the list of the bodies of the step, while it is there and dynamic.
    pub index: Option<usize>,
    /// Whether the body is kinematic or static and prescribes the nodes; otherwise the contact
    /// solver acts on them.
    pub is_kinematic: bool,
    /// States of the body at the start and the end of the world's step, start time of the step (s)
    /// and its length (s).
    pub from: BodyState,
    pub to: BodyState,
    time: f64,
    dt: f64,
}

impl Attachment {
    /// Attach `masses`, each with its present position (m), to a body in the state `state`.
    pub fn new(masses: impl Iterator<Item = (u32, DVec3)>, owner: AttachedTo, state: BodyState) -> Self {
        let masses = masses.map(|(mass, place)| (mass, place, DVec3::ZERO)).collect();
        let mut new = Self { name: String::new(), masses, body: None };
        new.bind(owner, state);
        new
    }

    /// Set the body, in the state `state`; return whether it prescribes the nodes.
    pub fn bind(&mut self, owner: AttachedTo, state: BodyState) -> bool {
        self.masses.iter_mut().for_each(|(_, place, local)| *local = state.local_point(*place));
        let is_kinematic = !state.is_dynamic();
        let index = if let AttachedTo::Own(index) = owner { Some(index) } else { None };
        self.body = Some(AttachedBody { owner, index, is_kinematic, from: state, to: state, time: 0.0, dt: 0.0 });
        is_kinematic
    }

    /// Whether the nodes and the body are those of `other`.
    pub fn is_alike(&self, other: &Self) -> bool {
        let body = |of: &Self| of.body.map(|body| (body.owner, body.is_kinematic));
        self.masses == other.masses && body(self) == body(other)
    }

    pub fn serialise(&self, to: &mut StateWriter) {
        to.text(&self.name);
        to.states(&self.masses);
        to.flag(self.body.is_some());
        self.body.iter().for_each(|body| body.serialise(to));
    }

    /// Deserialise an attachment of a sheet with `masses` nodes.
    pub fn deserialise(from: &mut StateReader, masses: usize) -> ReadResult<Self> {
        let name = from.text()?.to_owned();
        let nodes: Vec<(u32, DVec3, DVec3)> = from.states(49)?;
        if nodes.iter().any(|node| node.0 as usize >= masses) {
            return Err(CorruptState);
        }
        let body = if from.flag()? { Some(AttachedBody::deserialise(from)?) } else { None };
        Ok(Self { name, masses: nodes, body })
    }
}

impl AttachedBody {
    /// State of the body at time `t` (s); exactly the final state at the end of the step.
    pub fn at(&self, t: f64) -> BodyState {
        let done = t - self.time;
        if done >= self.dt * (1.0 - 1e-12) { self.to } else { self.from.free_flight(done, DVec3::ZERO) }
    }

    /// Set the motion in a step from `time` on and `dt` long (s); a body that is not there stays.
    /// Returns whether it has become kinematic or dynamic.
    pub fn set_motion(&mut self, motion: Option<BodyMotion>, (time, dt): (f64, f64)) -> bool {
        let Some(BodyMotion { index, from, to }) = motion else {
            let there = self.to.at_rest();
            *self = Self { index: None, from: there, to: there, time, dt, ..*self };
            return false;
        };
        // A body of the world keeps the kind of its attachment: it may be led for a time.
        let is_kinematic = if let AttachedTo::Lent(_) = self.owner { index.is_none() } else { self.is_kinematic };
        let is_changed = is_kinematic != self.is_kinematic;
        *self = Self { index, is_kinematic, from, to, time, dt, ..*self };
        is_changed
    }

    fn serialise(&self, to: &mut StateWriter) {
        let (kind, [a, b]) = match self.owner {
            AttachedTo::Own(index) => (0, [index as u64, 0]),
            AttachedTo::Lent(handle) => {
                let (index, generation) = handle.into_raw_parts();
                (1, [index.into(), generation.into()])
            }
        };
        to.byte(kind);
        to.count(a);
        to.count(b);
        to.flag(self.is_kinematic);
        self.from.serialise(to);
        self.to.serialise(to);
        to.numbers(&[self.time, self.dt]);
    }

    fn deserialise(from: &mut StateReader) -> ReadResult<Self> {
        let (kind, a, b) = (from.byte()?, from.count()?, from.count()?);
        let part = |value| u32::try_from(value).map_err(|_| CorruptState);
        let owner = match kind {
            0 => AttachedTo::Own(part(a)? as usize),
            1 => AttachedTo::Lent(RigidBodyHandle::from_raw_parts(part(a)?, part(b)?)),
            _ => return Err(CorruptState),
        };
        let is_kinematic = from.flag()?;
        let mut states = [BodyState::fixed_at(DVec3::ZERO, glam::DQuat::IDENTITY); 2];
        states.deserialise(from)?;
        let mut times = [0.0; 2];
        from.numbers(&mut times)?;
        let index = if let AttachedTo::Own(index) = owner { Some(index) } else { None };
        let ([start, end], [time, dt]) = (states, times);
        Ok(Self { owner, index, is_kinematic, from: start, to: end, time, dt })
    }
}
