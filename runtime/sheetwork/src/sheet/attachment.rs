//! Attachments of a sheet to bodies: binding, motion, and release.

use glam::DVec3;

use crate::error::InputError;
use crate::rigid::BodyState;
use crate::sheet::Sheet;

impl Sheet {
    /// Bind attachments to their bodies; `find` gives index and state by name. Nodes attached to a
    /// static or kinematic body become kinematic; those attached to a dynamic body start with its
    /// motion.
    ///
    /// # Errors
    /// When a body does not exist.
    pub(crate) fn attach_to_bodies(
        &mut self,
        find: impl Fn(&str) -> Option<(usize, BodyState)>,
    ) -> Result<(), InputError> {
        let named = |name: String| InputError::new("pins", format!("no body named \"{name}\" is there to be glued to"));
        let held = self.pins.bind_bodies(&find).map_err(named)?;
        for mass in &held {
            self.inverse_mass[*mass as usize] = 0.0;
            self.state.v.set(*mass as usize, DVec3::ZERO);
        }
        for (mass, state) in self.pins.attached_body_states() {
            let i = mass as usize;
            self.state.v.set(i, state.velocity_at(self.state.x.get(i)));
        }
        if !held.is_empty() {
            self.invalidate_system();
        }
        Ok(())
    }

    /// Whether any node is attached to a dynamic body.
    pub(crate) fn has_dynamic_attachments(&self) -> bool {
        self.pins.has_dynamic_attachments()
    }

    /// Nodes attached to dynamic bodies: node, index of the body, position in the frame of the body
    /// (m).
    pub fn dynamic_attachments(&self) -> impl Iterator<Item = (u32, usize, DVec3)> + '_ {
        self.pins.dynamic_attachments()
    }

    /// Set the motion of the bodies in the step from `time` on, `dt` long (s); `find` gives the
    /// states of a body at its start and end.
    pub(crate) fn set_body_motion(
        &mut self,
        time: f64,
        dt: f64,
        find: impl Fn(usize) -> Option<(BodyState, BodyState)>,
    ) {
        self.pins.set_body_motion(time, dt, find);
    }

    /// Release the attachments to the removed body `index`; later indices decrease by one.
    pub(crate) fn detach_body(&mut self, index: usize) {
        let freed = self.pins.detach_body(index);
        self.set_free(&freed);
    }

    /// Release the pins that end by time `t` (s); their nodes keep the prescribed velocity.
    #[doc(hidden)]
    pub fn release_pins(&mut self, t: f64) {
        if self.pins.has_release_by(t) {
            let freed = self.pins.release(t);
            self.set_free(&freed);
            self.restart_engine();
        }
    }

    fn set_free(&mut self, freed: &[u32]) {
        for mass in freed {
            let i = *mass as usize;
            if !self.is_detached(i) && !self.pins.masses().any(|held| held == *mass) {
                self.inverse_mass[i] = 1.0 / self.model.mass[i];
            }
        }
        if !freed.is_empty() {
            self.invalidate_system();
        }
    }

    /// Discard the linear system after a change of the dynamic nodes.
    pub(crate) fn invalidate_system(&mut self) {
        self.system = None;
        self.last_field = None;
        self.wake();
    }
}
