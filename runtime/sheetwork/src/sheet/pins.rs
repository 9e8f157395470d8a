//! Prescribed and fixed degrees of freedom of the nodes of a sheet, and attachments to bodies.
//!
//! A node is fixed, follows a path, is fixed along some axes only, or is attached to a body. A node
//! attached to a static or kinematic body is at x + q l at the end of a step, with the position x
//! and the rotation q of the body at that time and the position l of the node in the frame of the
//! body. A node attached to a dynamic body stays dynamic, and the contact solver computes the
//! attachment force.

use glam::{DQuat, DVec3};
use rapier3d::prelude::RigidBodyHandle;

use crate::math::Vectors;
use crate::rigid::BodyState;
use crate::scene::{PathKey, path_at};
use crate::serialize::{ReadResult, StateReader, StateWriter, state};
use crate::sheet::attached_body::{AttachedBody, AttachedTo, Attachment, BodyMotion};
use crate::sheet::prescribed_nodes::PrescribedNodes;

/// Prescribed degrees of freedom and attachments of a sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pins {
    groups: Vec<PrescribedNodes>,
    glue: Vec<Attachment>,
    fixed_axes: Vec<FixedAxes>,
    /// Detached nodes, whose attachments are void; empty without any.
    detached: Vec<bool>,
    /// Whether nodes were pinned or unpinned while the world ran.
    is_changed: bool,
}

/// Node fixed along some axes of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FixedAxes {
    mass: u32,
    held: [bool; 3],
    start: DVec3,
}

state!(PathKey { time, offset, rotation });

impl Pins {
    /// Prescribe `masses`, at present at `start` (m): along `path` (empty: fixed), until the time
    /// `until` (s) if given.
    pub fn add(&mut self, masses: Vec<u32>, start: Vec<DVec3>, path: Vec<PathKey>, until: Option<f64>) {
        self.groups.push(PrescribedNodes { masses, start, path, until, lead: None });
    }

    /// Unpin `nodes`, a sorted list, while the world runs; return those that a pin held.
    pub(crate) fn unpin(&mut self, nodes: &[u32]) -> Vec<u32> {
        let mut freed = Vec::new();
        for group in &mut self.groups {
            freed.extend(group.release(nodes));
        }
        self.groups.retain(|group| !group.masses.is_empty());
        for glue in &mut self.glue {
            let (kept, gone): (Vec<_>, Vec<_>) =
                std::mem::take(&mut glue.masses).into_iter().partition(|node| nodes.binary_search(&node.0).is_err());
            glue.masses = kept;
            freed.extend(gone.into_iter().map(|node| node.0));
        }
        self.glue.retain(|glue| !glue.masses.is_empty());
        self.is_changed = true;
        freed
    }

    /// Attach nodes of a running sheet, each with its present position (m), to a body in the state
    /// `state`. No pin holds them.
    pub(crate) fn attach(&mut self, masses: impl Iterator<Item = (u32, DVec3)>, owner: AttachedTo, state: BodyState) {
        self.glue.push(Attachment::new(masses, owner, state));
        self.is_changed = true;
    }

    /// Remove the attachments to those lent bodies that are `gone`; return the nodes that they
    /// prescribed.
    pub(crate) fn detach_lent(&mut self, gone: impl Fn(RigidBodyHandle) -> bool) -> Vec<u32> {
        self.detach_if(|body| if let AttachedTo::Lent(handle) = body.owner { gone(handle) } else { false })
    }

    /// Whether nodes are attached to a lent body that is `gone`.
    pub(crate) fn is_attached_to_lent(&self, gone: impl Fn(RigidBodyHandle) -> bool) -> bool {
        let mut owners = self.glue.iter().filter_map(|g| Some(g.body?.owner));
        owners.any(|owner| if let AttachedTo::Lent(handle) = owner { gone(handle) } else { false })
    }

    fn detach_if(&mut self, on_it: impl Fn(&AttachedBody) -> bool) -> Vec<u32> {
        let led = |g: &&Attachment| g.body.is_some_and(|body| body.is_kinematic && on_it(&body));
        let freed = self.glue.iter().filter(led).flat_map(|g| g.masses.iter().map(|m| m.0)).collect();
        self.glue.retain(|g| !g.body.is_some_and(|body| on_it(&body)));
        freed
    }

    /// Whether nodes were pinned or unpinned while the world ran.
    pub(crate) fn is_changed(&self) -> bool {
        self.is_changed
    }

    /// Serialise the pins that can be released.
    pub(crate) fn serialise(&self, to: &mut StateWriter) {
        to.flag(self.is_changed);
        to.count(self.groups.len() as u64);
        self.groups.iter().for_each(|group| group.serialise(to));
        to.count(self.glue.len() as u64);
        self.glue.iter().for_each(|glue| glue.serialise(to));
    }

    /// Deserialise the pins of a sheet with `masses` nodes; true if they differ from the present
    /// ones.
    pub(crate) fn deserialise(&mut self, from: &mut StateReader, masses: usize) -> ReadResult<bool> {
        let is_changed = from.flag()?;
        let mut groups = Vec::new();
        for _ in 0..from.length(3)? {
            groups.push(PrescribedNodes::deserialise(from, masses)?);
        }
        let mut glue = Vec::new();
        for _ in 0..from.length(10)? {
            glue.push(Attachment::deserialise(from, masses)?);
        }
        self.is_changed = is_changed;
        let alike = glue.len() == self.glue.len() && glue.iter().zip(&self.glue).all(|(a, b)| a.is_alike(b));
        let changed = groups != self.groups || !alike;
        (self.groups, self.glue) = (groups, glue);
        Ok(changed)
    }

    /// Whether a pin is released by time `t` (s).
    pub fn has_release_by(&self, t: f64) -> bool {
        self.groups.iter().any(|g| g.until.is_some_and(|until| until <= t))
    }

    /// Remove the pins whose release time is not after `t` (s); return their nodes.
    pub(crate) fn release(&mut self, t: f64) -> Vec<u32> {
        let over = |g: &PrescribedNodes| g.until.is_some_and(|until| until <= t);
        let freed = self.groups.iter().filter(|g| over(g)).flat_map(|g| g.masses.iter().copied()).collect();
        self.groups.retain(|g| !over(g));
        freed
    }

    /// Let paths and releases be later by `delay` (s).
    pub(crate) fn delay(&mut self, delay: f64) {
        self.groups.iter_mut().for_each(|group| group.delay(delay));
    }

    /// Lead the pinned nodes, attached ones and those fixed along some axes aside, by a rotation
    /// about the origin and then a displacement (m), from time `time` (s) on within `duration` (s).
    /// Returns their number.
    pub(crate) fn lead(&mut self, motion: (DVec3, DQuat), time: f64, duration: f64) -> usize {
        self.groups.iter_mut().for_each(|group| group.lead(motion, time, duration));
        self.groups.iter().map(|group| group.masses.len()).sum()
    }

    /// Bind the attachments again, with their nodes at `x` (m), to bodies in the state that `find`
    /// gives.
    pub(crate) fn renew_attachments(&mut self, x: &Vectors, find: impl Fn(AttachedTo) -> Option<BodyState>) {
        for glue in &mut self.glue {
            let Some(owner) = glue.body.map(|body| body.owner) else { continue };
            let Some(state) = find(owner) else { continue };
            glue.masses.iter_mut().for_each(|(node, place, _)| *place = x.get(*node as usize));
            glue.bind(owner, state);
        }
    }

    /// Fix the node `mass`, at present at `start` (m), along the axes (x, y, z) selected by `held`.
    pub fn add_fixed_axes(&mut self, mass: u32, start: DVec3, held: [bool; 3]) {
        self.fixed_axes.push(FixedAxes { mass, held, start });
    }

    /// Attach `masses`, each with its present position (m), to the body called `name`.
    pub fn add_attachment(&mut self, masses: impl Iterator<Item = (u32, DVec3)>, name: &str) {
        let masses = masses.map(|(mass, place)| (mass, place, DVec3::ZERO)).collect();
        self.glue.push(Attachment { name: name.to_owned(), masses, body: None });
    }

    /// Look up the bodies of new attachments by name: index and state. Return the nodes attached to
    /// static or kinematic bodies, which must be fixed. The error is the name of the first body
    /// that does not exist.
    pub(crate) fn bind_bodies(
        &mut self,
        find: impl Fn(&str) -> Option<(usize, BodyState)>,
    ) -> Result<Vec<u32>, String> {
        let mut led = Vec::new();
        for glue in self.glue.iter_mut().filter(|g| g.body.is_none()) {
            let Some((index, state)) = find(&glue.name) else { return Err(glue.name.clone()) };
            if glue.bind(AttachedTo::Own(index), state) {
                led.extend(glue.masses.iter().map(|m| m.0));
            }
        }
        Ok(led)
    }

    /// Set the step of the bodies, from `time` on and `dt` long (s); `find` gives the motion of a
    /// body that is there. Returns whether one has become kinematic or dynamic.
    pub(crate) fn set_body_motion(
        &mut self,
        time: f64,
        dt: f64,
        find: impl Fn(AttachedTo) -> Option<BodyMotion>,
    ) -> bool {
        let mut is_changed = false;
        for hold in self.glue.iter_mut().filter_map(|g| g.body.as_mut()) {
            is_changed |= hold.set_motion(find(hold.owner), (time, dt));
        }
        is_changed
    }

    /// Remove the attachments to the removed body `index` of the world and decrement the indices of
    /// later bodies; return the nodes that the body prescribed.
    pub(crate) fn detach_body(&mut self, index: usize) -> Vec<u32> {
        let freed = self.detach_if(|body| body.owner == AttachedTo::Own(index));
        for hold in self.glue.iter_mut().filter_map(|g| g.body.as_mut()) {
            if let AttachedTo::Own(other) = hold.owner
                && other > index
            {
                hold.owner = AttachedTo::Own(other - 1);
                hold.index = hold.index.map(|other| other - 1);
            }
        }
        freed
    }

    /// Dynamic attached nodes: node, index of the body, position in the frame of the body (m).
    pub fn dynamic_attachments(&self) -> impl Iterator<Item = (u32, usize, DVec3)> + '_ {
        let free = self.glue.iter().filter_map(|g| Some((g, g.body.filter(|h| !h.is_kinematic)?.index?)));
        let all = free.flat_map(|(g, index)| g.masses.iter().map(move |(mass, _, local)| (*mass, index, *local)));
        all.filter(|(mass, ..)| !self.detached.get(*mass as usize).is_some_and(|gone| *gone))
    }

    /// Void the attachments of exactly the nodes in `gone`.
    pub(crate) fn set_gone(&mut self, gone: &[bool]) {
        self.detached.clear();
        self.detached.extend_from_slice(gone);
    }

    /// Dynamic attached nodes, each with the state of its body at the end of the step.
    pub(crate) fn attached_body_states(&self) -> impl Iterator<Item = (u32, &BodyState)> + '_ {
        let free = self.glue.iter().filter_map(|g| g.body.as_ref().filter(|h| !h.is_kinematic).map(|h| (g, &h.to)));
        free.flat_map(|(g, state)| g.masses.iter().map(move |m| (m.0, state)))
    }

    /// Kinematic attached nodes: motion of the body, node, position in the frame of the body (m).
    fn kinematic_attachments(&self) -> impl Iterator<Item = (&AttachedBody, u32, DVec3)> + '_ {
        let led = self.glue.iter().filter_map(|g| g.body.as_ref().filter(|h| h.is_kinematic).map(|h| (g, h)));
        led.flat_map(|(g, h)| g.masses.iter().map(move |(mass, _, local)| (h, *mass, *local)))
    }

    /// Whether no node is prescribed, fixed or attached.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty() && self.fixed_axes.is_empty() && self.glue.is_empty()
    }

    /// Whether it fixes or prescribes any node, attachments to dynamic bodies aside.
    pub(crate) fn fixes_nodes(&self) -> bool {
        !self.fixed_axes.is_empty() || self.masses().next().is_some()
    }

    /// Whether any node is attached to a body.
    pub(crate) fn is_attached(&self) -> bool {
        !self.glue.is_empty()
    }

    /// Whether any node is attached to a dynamic body.
    pub(crate) fn has_dynamic_attachments(&self) -> bool {
        self.dynamic_attachments().next().is_some()
    }

    /// Nodes that are prescribed in every direction, kinematic attached nodes included.
    pub fn masses(&self) -> impl Iterator<Item = u32> + '_ {
        self.groups
            .iter()
            .flat_map(|g| g.masses.iter().copied())
            .chain(self.kinematic_attachments().map(|(_, mass, _)| mass))
    }

    /// Fixed and prescribed nodes with their pin (nodes fixed along some axes come last) or, as an
    /// error, the body that they are attached to, and their fixed axes (1).
    pub(crate) fn prescribed(&self) -> impl Iterator<Item = (Result<usize, AttachedTo>, u32, DVec3)> + '_ {
        let groups = self.groups.iter().enumerate();
        let pinned = groups.flat_map(|(k, g)| g.masses.iter().map(move |i| (Ok(k), *i, DVec3::ONE)));
        let attached = self.kinematic_attachments().map(|(hold, i, _)| (Err(hold.owner), i, DVec3::ONE));
        let last = Ok(self.groups.len());
        let fixed = self.fixed_axes.iter().map(move |r| (last, r.mass, r.replaced(DVec3::ZERO, DVec3::ONE)));
        pinned.chain(attached).chain(fixed)
    }

    /// Nodes fixed along some axes, and those axes.
    pub fn fixed_axes(&self) -> impl Iterator<Item = (u32, [bool; 3])> + '_ {
        self.fixed_axes.iter().map(|r| (r.mass, r.held))
    }

    /// Free (1) and fixed (0) axes of node `i`.
    pub(crate) fn free_axes(&self, i: u32) -> DVec3 {
        let free = |r: &FixedAxes| DVec3::from_array(r.held.map(|held| if held { 0.0 } else { 1.0 }));
        self.fixed_axes.iter().filter(|r| r.mass == i).map(free).fold(DVec3::ONE, |a, b| a * b)
    }

    /// Whether any pin moves between the times `from` and `to`, s.
    pub fn moves_between(&self, from: f64, to: f64) -> bool {
        let led = self.glue.iter().filter_map(|g| g.body);
        self.groups.iter().any(|g| g.moves_between(from, to))
            || led
                .into_iter()
                .any(|h| h.from.is_moving() || (h.from.origin(), h.from.rotation()) != (h.to.origin(), h.to.rotation()))
    }

    /// Set the constant velocity of every prescribed node that takes it to its position at `t +
    /// dt`.
    pub(crate) fn prescribe_velocities(&self, t: f64, dt: f64, x: &Vectors, v: &mut Vectors) {
        for (i, place) in self.groups.iter().flat_map(|group| group.positions(t + dt)) {
            v.set(i, (place - x.get(i)) / dt);
        }
        for (hold, mass, local) in self.kinematic_attachments() {
            let i = mass as usize;
            v.set(i, (hold.at(t + dt).world_point(local) - x.get(i)) / dt);
        }
        self.zero_fixed_axes(v);
    }

    /// Set the exact position of every prescribed node at `t` (s), which prevents the accumulation
    /// of rounding errors.
    pub(crate) fn prescribe_positions(&self, t: f64, x: &mut Vectors) {
        for (i, place) in self.groups.iter().flat_map(|group| group.positions(t)) {
            x.set(i, place);
        }
        for (hold, mass, local) in self.kinematic_attachments() {
            x.set(mass as usize, hold.at(t).world_point(local));
        }
        self.set_fixed_axes(x, |rail| rail.start);
    }

    /// Adopt the positions `x` at time `t` (s): a node further than `slack` (m) from its prescribed
    /// position gets a new start position. All others are set to their exact positions.
    pub(crate) fn adopt_positions(&mut self, t: f64, x: &mut Vectors, slack: f64) {
        for group in &mut self.groups {
            group.lead = None;
            let offset = path_at(&group.path, t).0;
            for (i, start) in group.masses.iter().zip(&mut group.start) {
                let there = x.get(*i as usize) - offset;
                if there.distance(*start) > slack {
                    *start = there;
                }
            }
        }
        for rail in &mut self.fixed_axes {
            let there = x.get(rail.mass as usize);
            if rail.replaced(there, rail.start).distance(there) > slack {
                rail.start = there;
            }
        }
        self.prescribe_positions(t, x);
    }

    /// Nodes with their start positions (m), pin by pin, and at the end the nodes fixed along some
    /// axes.
    pub(crate) fn starts(&self) -> impl Iterator<Item = Vec<(u32, DVec3)>> + '_ {
        let groups = self.groups.iter().map(|g| g.masses.iter().copied().zip(g.start.iter().copied()).collect());
        groups.chain(std::iter::once(self.fixed_axes.iter().map(|r| (r.mass, r.start)).collect()))
    }

    /// Shift the start position of node `i` of pin `k`, counted as in [`Pins::starts`], by `by(k,
    /// i)` (m), where that is longer than `slack` (m), the rounding errors.
    pub(crate) fn shift_starts(&mut self, slack: f64, by: impl Fn(usize, u32) -> DVec3) {
        let by = |k: usize, i: u32| Some(by(k, i)).filter(|by| by.length() > slack).unwrap_or_default();
        for (k, group) in self.groups.iter_mut().enumerate() {
            group.masses.iter().zip(&mut group.start).for_each(|(i, start)| *start += by(k, *i));
        }
        let last = self.groups.len();
        self.fixed_axes.iter_mut().for_each(|r| r.start += by(last, r.mass));
    }

    /// Set the fixed components of velocities, accelerations or forces to zero.
    pub(crate) fn zero_fixed_axes(&self, a: &mut Vectors) {
        self.set_fixed_axes(a, |_| DVec3::ZERO);
    }

    /// Copy the fixed components of `x` to `to`.
    pub(crate) fn copy_fixed_axes(&self, x: &Vectors, to: &mut Vectors) {
        self.set_fixed_axes(to, |rail| x.get(rail.mass as usize));
    }

    fn set_fixed_axes(&self, to: &mut Vectors, value: impl Fn(&FixedAxes) -> DVec3) {
        for rail in &self.fixed_axes {
            let i = rail.mass as usize;
            to.set(i, rail.replaced(to.get(i), value(rail)));
        }
    }
}

impl FixedAxes {
    /// `p` with the fixed components of `q`.
    fn replaced(&self, p: DVec3, q: DVec3) -> DVec3 {
        let pick = |axis: usize| if self.held[axis] { q[axis] } else { p[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    }
}
