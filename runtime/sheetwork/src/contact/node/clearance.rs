//! Which masses need not be looked at: those that cannot have reached anything since they were last found far from it.
//!
//! When a mass at place c was found to be at least d away from every body, it can meet nothing while it stays within d of
//! c, less what bodies have moved since. Only the distance from c is looked at, so that whatever moved the mass (an engine,
//! a pin, a program) is covered. The result of a step is the same with and without; only the time differs.

use glam::DVec3;
use rapier3d::prelude::ColliderHandle;

use crate::contact::node::response::{Flight, Surface};
use crate::contact::node::target::NO_FACE;
use crate::math::Vectors;
use crate::serialize::{Keeper, Taken, Taker};

/// What is known of the masses of a sheet.
#[derive(Default)]
pub(crate) struct Clearance {
    /// Where each mass was when it was last checked, m.
    checked: Vectors,
    /// Value of `moved` up to which that check holds for a mass that stays where it was; -∞ if it was never checked.
    until: Vec<f64>,
    /// How far the fastest body has moved in all, m.
    moved: f64,
    /// Of this step: distance to the nearest body so far, m; negative for masses that are not looked at.
    pub nearest: Vec<f64>,
    /// Collider and face that each mass was nearest to when it was last looked at.
    pub face: Vec<(ColliderHandle, u32)>,
    /// Masses that met two bodies in this step: each was put where the other may be.
    pub cornered: Vec<u32>,
    /// Masses that met something in this step, and what each met first.
    pub met: Vec<u32>,
    pub first: Vec<Option<First>>,
    /// What is left of the ways of masses that were turned aside in this step, and room for the same of one round before.
    pub legs: Vec<Leg>,
    pub last_legs: Vec<Leg>,
}

/// What a mass met first in a step.
#[derive(Clone, Copy)]
pub(crate) struct First {
    pub collider: ColliderHandle,
    pub face: u32,
    pub surface: Surface,
    /// When, as a fraction of the step.
    pub tau: f64,
    /// Whether it would have met another collider too.
    pub another: bool,
}

/// The way of a mass from where it met a surface to where it ends the step.
#[derive(Clone, Copy)]
pub(crate) struct Leg {
    pub mass: u32,
    /// What it met, and the normal there.
    pub from: ColliderHandle,
    pub normal: DVec3,
    pub flight: Flight,
}

impl Clearance {
    /// Forgets what was known: every mass is looked at in the next step.
    pub fn forget(&mut self) {
        self.until.fill(f64::NEG_INFINITY);
    }

    /// Keeps it for a snapshot.
    pub fn keep(&self, to: &mut Keeper) {
        to.vector_list(&self.checked);
        to.numbers(&self.until);
        to.number(self.moved);
        for (collider, face) in &self.face {
            let (index, generation) = collider.into_raw_parts();
            [index, generation, *face].into_iter().for_each(|v| to.count(u64::from(v)));
        }
    }

    /// Takes it back, of a sheet of `masses` masses.
    pub fn take(&mut self, from: &mut Taker, masses: usize) -> Taken {
        *self = Self::default();
        let mut checked = Vectors::default();
        from.vector_list(&mut checked, masses)?;
        if !checked.is_empty() {
            self.size(masses);
        }
        self.checked = checked;
        from.numbers(&mut self.until)?;
        self.moved = from.number()?;
        for face in &mut self.face {
            *face = (ColliderHandle::from_raw_parts(from.small()?, from.small()?), from.small()?);
        }
        Ok(())
    }

    fn size(&mut self, masses: usize) {
        self.checked = Vectors::zeros(masses);
        self.until = vec![f64::NEG_INFINITY; masses];
        self.nearest = vec![0.0; masses];
        self.face = vec![(ColliderHandle::invalid(), NO_FACE); masses];
        self.cornered = Vec::with_capacity(masses);
        self.met = Vec::with_capacity(masses);
        self.first = vec![None; masses];
        self.legs = Vec::with_capacity(masses);
        self.last_legs = Vec::with_capacity(masses);
    }

    /// Whether mass `i` was never checked, so that nothing bounds how deep in a body it may be.
    pub fn is_new(&self, i: usize) -> bool {
        self.until[i] == f64::NEG_INFINITY
    }

    /// Begins a step in which bodies move by at most `reach` (m). Sets `nearest` to `margin` for masses that must be looked
    /// at, which `x` and `free` decide, and to -1 for the others; masses are met at `offset` (m). False when there is nothing to look at.
    pub fn begin(&mut self, x: &Vectors, free: impl Fn(usize) -> bool, reach: f64, margin: f64, offset: f64) -> bool {
        if self.until.len() != x.len() {
            self.size(x.len());
        }
        self.cornered.clear();
        self.legs.clear();
        self.met.clear();
        self.moved += reach;
        let mut any = false;
        for i in 0..x.len() {
            let slack = self.until[i] - self.moved - 2.0 * offset;
            let clear = slack > 0.0 && x.get(i).distance_squared(self.checked.get(i)) < slack * slack;
            let look = !clear && free(i);
            self.nearest[i] = if look { margin } else { -1.0 };
            any |= look;
        }
        any
    }

    /// Ends the step: masses that were looked at are clear for as far as the nearest body was.
    pub fn end(&mut self, x: &Vectors) {
        for i in (0..x.len()).filter(|i| self.nearest[*i] >= 0.0) {
            self.checked.set(i, x.get(i));
            self.until[i] = self.nearest[i] + self.moved;
        }
    }
}
