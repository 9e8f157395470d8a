//! Forces of a program on the world's own dynamic bodies.
//!
//! A force F acts on a step of dt by the impulses F dt/2 at its start and its end, so that a free
//! body has the exact displacement v dt + F dt²/(2 m).

use glam::DVec3;

use crate::rigid::RigidWorld;
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter};

/// Force on a body until the end of the step or advance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyLoad {
    pub body: usize,
    /// N.
    pub force: DVec3,
    /// Point of the body frame, m.
    pub local: DVec3,
}

impl RigidWorld {
    /// Whether forces act.
    pub(crate) fn has_loads(&self) -> bool {
        !self.loads.is_empty()
    }

    /// Let a force act from the next step on; the body wakes.
    pub(crate) fn add_load(&mut self, load: BodyLoad) {
        self.loads.push(load);
        self.wake(load.body);
    }

    /// Apply an impulse (N s) at a point of the frame of body `index` (m) at once; the body wakes.
    pub(crate) fn apply_impulse(&mut self, index: usize, impulse: DVec3, local: DVec3) {
        let Some(motion) = self.motions.get_mut(index).filter(|motion| motion.is_free()) else { return };
        motion.end = motion.end.with_impulse_at(impulse, motion.end.world_point(local));
        self.wake(index);
    }

    /// Apply the impulse of the loads over `time` (s).
    pub(super) fn apply_loads(&mut self, time: f64) {
        for index in 0..self.loads.len() {
            let BodyLoad { body, force, local } = self.loads[index];
            self.apply_impulse(body, force * time, local);
        }
    }

    /// Second half of the impulse of the loads in a step of `dt` s, after contact with the sheets.
    pub(crate) fn finish_loads(&mut self, dt: f64) {
        self.apply_loads(0.5 * dt);
    }

    /// Remove the loads at the end of a step or an advance.
    pub(crate) fn clear_loads(&mut self) {
        self.loads.clear();
    }

    pub(super) fn serialise_loads(&self, to: &mut StateWriter) {
        to.count(self.loads.len() as u64);
        for load in &self.loads {
            to.count(load.body as u64);
            to.vector(load.force);
            to.vector(load.local);
        }
    }

    pub(super) fn deserialise_loads(&mut self, from: &mut StateReader) -> ReadResult {
        self.loads.clear();
        for _ in 0..from.count()? {
            let (body, force, local) = (from.count()? as usize, from.vector()?, from.vector()?);
            if body >= self.motions.len() || !force.is_finite() || !local.is_finite() {
                return Err(CorruptState);
            }
            self.loads.push(BodyLoad { body, force, local });
        }
        Ok(())
    }
}
