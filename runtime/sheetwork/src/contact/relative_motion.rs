//! Relative motion u of the two sides of a contact without contact forces: the right-hand side b of
//! the contact problem.
//!
//! With α the fraction of the stage before a pair closes, friction acts against (1-α) times the
//! tangential displacement, and the approach speed at impact is
//!
//!   (1-α) times the speed at the start plus α times the free speed at the end.
//!
//! Lengths in m, speeds in m/s.

use glam::{DMat3, DVec3};

use crate::contact::IslandView;
use crate::contact::coulomb::ContactLaw;
use crate::contact::gap::{StagePose, position, velocity};
use crate::contact::settings::ContactSettings;
use crate::contact::workspace::ContactWorkspace;

const SETTINGS: ContactSettings = ContactSettings::DEFAULT;

impl ContactWorkspace {
    /// Whether contact `i` is an attachment, or holds a compressed sheet.
    pub(crate) fn is_bilateral(&self, i: usize) -> bool {
        i >= self.detected.first_attachment || self.detected.contacts[i].compressed.is_some()
    }

    /// Law of contact `i`: Coulomb friction, or bilateral.
    pub(crate) fn law(&self, i: usize) -> ContactLaw {
        if self.is_bilateral(i) {
            ContactLaw::Attachment
        } else {
            ContactLaw::Coulomb(self.detected.contacts[i].friction)
        }
    }

    /// Relative position u of contact `i` in `frame` after the free motion, m: normal gap, and the
    /// tangential displacement that friction opposes.
    pub(crate) fn relative_position(&self, island: &IslandView, i: usize, frame: &DMat3) -> DVec3 {
        let contact = &self.detected.contacts[i];
        let end = position(island, &contact.a, StagePose::Free) - position(island, &contact.b, StagePose::Free);
        if i >= self.detected.first_attachment {
            return frame.transpose() * end;
        }
        let start = position(island, &contact.a, StagePose::Start) - position(island, &contact.b, StagePose::Start);
        let turn = frame.transpose();
        if let Some(velocity) = contact.compressed {
            let along = turn * (end - start - velocity * island.sheets[0].work.stage.length);
            return DVec3::new(self.gaps.free[i], along.y, along.z);
        }
        let along = turn * (end - start) * (1.0 - self.gaps.open_fraction(i));
        DVec3::new(self.gaps.free[i], along.y, along.z)
    }

    /// Relative velocity u of contact `i` in `frame` after the free motion, with the restitution
    /// target added, m/s. `None` if the contact is open.
    pub(crate) fn relative_velocity(&self, island: &IslandView, i: usize, frame: &DMat3) -> Option<DVec3> {
        let contact = &self.detected.contacts[i];
        let free = velocity(island, &contact.a, StagePose::Free) - velocity(island, &contact.b, StagePose::Free);
        if let Some(velocity) = contact.compressed {
            return Some(frame.transpose() * (free - velocity));
        }
        let mut u = frame.transpose() * free;
        if i < self.detected.first_attachment {
            if self.gaps.now[i] > SETTINGS.closed_gap * self.half_thickness {
                return None;
            }
            let start = velocity(island, &contact.a, StagePose::Start) - velocity(island, &contact.b, StagePose::Start);
            let airborne = self.gaps.open_fraction(i);
            let approach = (1.0 - airborne) * start.dot(contact.normal) + airborne * u.x;
            if approach < -SETTINGS.restitution_speed {
                u.x += contact.restitution * approach;
            }
        }
        Some(u)
    }
}
