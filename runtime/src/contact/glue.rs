//! What glue does to the spin of the body that holds it.
//!
//! The solve for places puts the two sides of glue together by displacements h² F/m that change no velocity. A mass of the sheet at velocity
//! v then has another angular momentum about any point, by h² F × v, and the body by -h² F × V, V the velocity of its centre of mass. With the
//! body's angular velocity ω and the arm r of the place on it, v = V + ω × r, and the two leave
//!
//!   h² F × (ω × r)   (kg m²/s)
//!
//! of what neither had: a torque that brakes whatever spins, in proportion to the step. The impulse has really acted over the stage, on an arm that
//! was turned back by half of it; the body is given the angular momentum that this makes. (RATTLE, which keeps angular momentum exactly, applies
//! half of its impulse at the start of a step for that: Andersen, J. Comput. Phys. 52, 1983.)
//!
//! A contact that comes and goes is left as it is: what a blow dissipates is more than that.

use glam::DVec3;

use super::delassus::Group;
use super::row::Side;
use super::stage::Scratch;

impl Scratch {
    /// Gives the bodies that glue is on the angular momentum that the last solve for places, in a stage of weight `h` (s), has taken from them and
    /// the sheets.
    pub fn turn_back(&self, group: &mut Group, h: f64) {
        for contact in &self.found.contacts[self.found.glue_from..] {
            let (Side::Body { body, local }, Some(force)) = (contact.b, self.force_of(&contact.key)) else { continue };
            let mover = &mut group.movers[body as usize];
            let arm = mover.free.place(local) - mover.free.centre();
            let twist = mover.free.spin().cross(arm).cross(force) * (h * h);
            mover.free = mover.free.pushed(DVec3::ZERO, twist);
        }
    }
}
