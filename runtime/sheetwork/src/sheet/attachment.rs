//! Sheets glued to bodies: which masses a body takes with it, and what happens when it is taken away.

use glam::DVec3;

use crate::error::InputError;
use crate::rigid::BodyState;
use crate::sheet::Sheet;

impl Sheet {
    /// Finds the bodies that masses are glued to; `find` gives index and state by name. Masses glued to a body that stands or
    /// is led are held by it; those glued to one that moves freely start with its motion.
    ///
    /// # Errors
    /// When a body is not there.
    pub(crate) fn glue_to(&mut self, find: impl Fn(&str) -> Option<(usize, BodyState)>) -> Result<(), InputError> {
        let named = |name: String| InputError::new("pins", format!("no body named \"{name}\" is there to be glued to"));
        let held = self.pins.bind(&find).map_err(named)?;
        for mass in &held {
            self.inverse_mass[*mass as usize] = 0.0;
            self.v.set(*mass as usize, DVec3::ZERO);
        }
        for (mass, state) in self.pins.glued_states() {
            let i = mass as usize;
            self.v.set(i, state.velocity_at(self.x.get(i)));
        }
        if !held.is_empty() {
            self.forget_system();
        }
        Ok(())
    }

    /// Whether any of its masses are glued to a body that moves freely.
    pub(crate) fn is_glued(&self) -> bool {
        self.pins.glues()
    }

    /// Masses that are glued to bodies that move freely: mass, index of the body, place in the body's frame (m).
    pub fn glued(&self) -> impl Iterator<Item = (u32, usize, DVec3)> + '_ {
        self.pins.glued()
    }

    /// Tells of the bodies' step from `time` on, `dt` long (s); `find` gives the states of a body at its start and end.
    pub(crate) fn follow(&mut self, time: f64, dt: f64, find: impl Fn(usize) -> Option<(BodyState, BodyState)>) {
        self.pins.follow(time, dt, find);
    }

    /// Lets go of body `index`, which is taken away; the bodies after it are counted anew.
    pub(crate) fn unglue(&mut self, index: usize) {
        let freed = self.pins.unglue(index);
        self.set_free(&freed);
    }

    /// Lets go of masses whose pins end by time `t`, s; they keep the velocity that they were led with.
    pub fn release_pins(&mut self, t: f64) {
        if self.pins.ends(t) {
            let freed = self.pins.release(t);
            self.set_free(&freed);
            self.restart_engine();
        }
    }

    fn set_free(&mut self, freed: &[u32]) {
        for mass in freed {
            let i = *mass as usize;
            if !self.is_gone(i) && !self.pins.masses().any(|held| held == *mass) {
                self.inverse_mass[i] = 1.0 / self.mass[i];
            }
        }
        if !freed.is_empty() {
            self.forget_system();
        }
    }

    /// Which masses are free has changed: what an implicit engine has worked out is of the others.
    pub(crate) fn forget_system(&mut self) {
        self.system = None;
        self.field_before = None;
        self.wake();
    }
}
