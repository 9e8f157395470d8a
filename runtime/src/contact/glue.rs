//! What glue does to the spin of the body that holds it.
//!
//! A force F on a sheet in a stage of weight h (s) displaces the sheet and the body that holds it before it changes their velocities. That takes
//! angular momentum from both, as a place changes under a velocity. Of the sheet the stress that goes along with it gives it back in the next
//! stage. Of the body, whose turn carries none, it would be the impulse at the arm r from its centre of mass as that is at the end, where it has acted over
//! the stage, on an arm that was on average turned back by half of that: with the body's angular velocity ω,
//!
//!   h² F × (ω × r)   (kg m²/s)
//!
//! is lost, a torque that brakes whatever spins, in proportion to the step. The body is given that. (RATTLE, which keeps angular momentum exactly,
//! applies half of its impulse at the start of a step: Andersen, J. Comput. Phys. 52, 1983.)
//!
//! A contact that comes and goes is left as it is: what a blow dissipates is more than that. So are explicit engines, whose steps are short.

use glam::DVec3;

use super::delassus::Group;
use super::row::Side;
use super::stage::Scratch;

impl Scratch {
    /// Gives the bodies that glue is on the angular momentum that the last solve for places, in a stage of weight `h` (s), would take.
    pub fn turn_back(&self, group: &mut Group, h: f64) {
        let glue = &self.found.contacts[self.found.glue_from..];
        if glue.is_empty() {
            return;
        }
        for (number, mover) in group.movers.iter_mut().enumerate() {
            let mut twist = DVec3::ZERO;
            for contact in glue {
                let Side::Body { body, local } = contact.b else { continue };
                if body as usize == number
                    && let Some(force) = self.force_of(&contact.key)
                {
                    let arm = mover.free.place(local) - mover.free.centre();
                    twist += mover.free.spin().cross(arm).cross(force);
                }
            }
            mover.free = mover.free.pushed(DVec3::ZERO, twist * (h * h));
        }
    }
}
