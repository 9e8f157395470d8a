//! Angular momentum that attachments must return to the body that holds a sheet.
//!
//! The force F of an attachment acts on a sheet and on a body in a stage of weight h (s). It
//! changes their positions before it changes their velocities, and the displacement at constant
//! velocity takes angular momentum from both. The stress of the sheet returns its part in the next
//! stage. The body has no stress: the impulse acts at the arm r from the centre of mass as it is at
//! the end of the stage, while the mean arm during the stage was rotated back by half of the
//! rotation. With the angular velocity ω of the body,
//!
//!   h² F × (ω × r)   (kg m²/s)
//!
//! is lost per stage, a torque that slows rotation in proportion to the step. This module adds it
//! to the body. (RATTLE, which conserves angular momentum exactly, applies half of its impulse at
//! the start of a step: Andersen, J. Comput. Phys. 52, 1983.)
//!
//! Contacts need no correction, because impacts dissipate more than that; nor do explicit
//! integrators, whose steps are short.

use glam::DVec3;

use crate::collision::constraint::ContactSide;
use crate::contact::IslandView;
use crate::contact::workspace::ContactWorkspace;

impl ContactWorkspace {
    /// Add to the bodies of attachments the angular momentum that the last position solve took, in
    /// a stage of weight `h` (s).
    pub fn restore_spin(&self, island: &mut IslandView, h: f64) {
        let glue = &self.detected.contacts[self.detected.first_attachment..];
        if glue.is_empty() {
            return;
        }
        for (number, solver_body) in island.solver_bodies.iter_mut().enumerate() {
            let mut twist = DVec3::ZERO;
            for contact in glue {
                let ContactSide::Body { body, local } = contact.b else { continue };
                if body as usize == number
                    && let Some(force) = self.force_of(&contact.key)
                {
                    let arm = solver_body.free.world_point(local) - solver_body.free.centre();
                    twist += solver_body.free.spin().cross(arm).cross(force);
                }
            }
            solver_body.free = solver_body.free.with_impulse(DVec3::ZERO, twist * (h * h));
        }
    }
}
