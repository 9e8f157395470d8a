//! Nodes of one pin: fixed, or prescribed along a path, and led to a new place in a given time.

use glam::{DQuat, DVec3};

use crate::scene::{PathKey, path_at};
use crate::serialize::{CorruptState, ReadResult, State, StateReader, StateWriter, state};

/// Nodes of a pin.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PrescribedNodes {
    pub masses: Vec<u32>,
    /// Position of each node without the offset of the path, m.
    pub start: Vec<DVec3>,
    /// Path of offsets; empty for a fixed pin.
    pub path: Vec<PathKey>,
    /// Release time, s.
    pub until: Option<f64>,
    pub lead: Option<Lead>,
}

/// Motion of a pin to a new place.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Lead {
    /// Position of each node at the start, m.
    from: Vec<DVec3>,
    /// Times of the start and the end, s.
    time: f64,
    end: f64,
}

state!(Lead { from, time, end });

impl Lead {
    fn is_over(&self, t: f64) -> bool {
        t >= self.end
    }
}

impl PrescribedNodes {
    /// Nodes with their prescribed positions at time `t` (s), m.
    pub fn positions(&self, t: f64) -> impl Iterator<Item = (usize, DVec3)> + '_ {
        let offset = path_at(&self.path, t).0;
        let lead = self.lead.as_ref().filter(|lead| !lead.is_over(t));
        self.masses.iter().zip(&self.start).enumerate().map(move |(k, (node, start))| {
            let target = *start + offset;
            let led = |lead: &Lead| {
                let s = ((t - lead.time) / (lead.end - lead.time)).clamp(0.0, 1.0);
                lead.from[k].lerp(target, s)
            };
            (*node as usize, lead.map_or(target, led))
        })
    }

    /// Whether the nodes move between the times `from` and `to`, s.
    pub fn moves_between(&self, from: f64, to: f64) -> bool {
        let is_led = self.lead.as_ref().is_some_and(|lead| !lead.is_over(from));
        is_led || path_at(&self.path, from).0 != path_at(&self.path, to).0
    }

    /// Lead the nodes from time `time` (s) on, within `duration` (s), to the places at which they
    /// would be after a rotation about the origin and a displacement by `by` (m); the path turns
    /// with them.
    pub fn lead(&mut self, (by, rotation): (DVec3, DQuat), time: f64, duration: f64) {
        let from = self.positions(time).map(|(_, place)| place).collect();
        self.start.iter_mut().for_each(|start| *start = rotation * *start + by);
        self.path.iter_mut().for_each(|key| key.offset = rotation * key.offset);
        self.lead = Some(Lead { from, time, end: time + duration });
    }

    /// Let path and release be later by `delay` (s).
    pub fn delay(&mut self, delay: f64) {
        self.path.iter_mut().for_each(|key| key.time += delay);
        self.until = self.until.map(|until| until + delay);
        self.lead.iter_mut().for_each(|lead| (lead.time, lead.end) = (lead.time + delay, lead.end + delay));
    }

    /// Take the nodes in `nodes`, a sorted list, out of the pin; return them.
    pub fn release(&mut self, nodes: &[u32]) -> Vec<u32> {
        let is_kept: Vec<bool> = self.masses.iter().map(|node| nodes.binary_search(node).is_err()).collect();
        let gone = self.masses.iter().zip(&is_kept).filter(|(_, kept)| !**kept).map(|(node, _)| *node).collect();
        retain(&mut self.masses, &is_kept);
        retain(&mut self.start, &is_kept);
        self.lead.iter_mut().for_each(|lead| retain(&mut lead.from, &is_kept));
        gone
    }

    pub fn serialise(&self, to: &mut StateWriter) {
        to.count(self.masses.len() as u64);
        for (node, start) in self.masses.iter().zip(&self.start) {
            to.count(u64::from(*node));
            to.vector(*start);
        }
        self.until.serialise(to);
        to.states(&self.path);
        to.flag(self.lead.is_some());
        self.lead.iter().for_each(|lead| lead.serialise(to));
    }

    /// Deserialise a pin of a sheet with `count` nodes.
    pub fn deserialise(from: &mut StateReader, count: usize) -> ReadResult<Self> {
        let nodes: Vec<(u32, DVec3)> = from.states(25)?;
        let (masses, start): (Vec<u32>, Vec<DVec3>) = nodes.into_iter().unzip();
        let mut read = Self { masses, start, until: from.read()?, path: from.states(56)?, lead: None };
        if from.flag()? {
            let mut lead = Lead { from: vec![DVec3::ZERO; read.masses.len()], ..Lead::default() };
            lead.deserialise(from)?;
            read.lead = Some(lead);
        }
        let is_sound = read.lead.as_ref().is_none_or(|lead| lead.from.len() == read.masses.len());
        if !is_sound || read.masses.iter().any(|node| *node as usize >= count) {
            return Err(CorruptState);
        }
        Ok(read)
    }
}

/// Retain the entries of a list that are marked.
fn retain<T>(list: &mut Vec<T>, is_kept: &[bool]) {
    let mut marks = is_kept.iter();
    list.retain(|_| marks.next().is_none_or(|kept| *kept));
}
