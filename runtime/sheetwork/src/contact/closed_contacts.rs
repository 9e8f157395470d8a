//! Closed contacts at the end of a stage: the nodes that touch, and the support of a body.
//!
//! A contact counts as closed if its gap with the forces of the last solve is below twice
//! [`ContactSettings::closed_gap`].

use glam::DVec3;

use crate::collision::constraint::{ContactConstraint, ContactSide};
use crate::contact::settings::ContactSettings;
use crate::contact::solver_body::SolverBody;
use crate::contact::workspace::ContactWorkspace;
use crate::rigid::Support;

const SETTINGS: ContactSettings = ContactSettings::DEFAULT;

impl ContactWorkspace {
    /// Contacts of sheets with their gap (m) with the forces of the last solve and the index of
    /// their collider in the island.
    pub fn measured_contacts(&self) -> impl Iterator<Item = ((&ContactConstraint, &f64), &u32)> {
        self.detected.contacts.iter().zip(&self.gaps.now).zip(&self.detected.colliders)
    }

    /// Call `touched` for every closed contact, with the index of its collider in the island.
    pub fn for_each_closed(&self, mut touched: impl FnMut(&ContactConstraint, u32)) {
        let least = SETTINGS.closed_gap_at_end * self.half_thickness;
        for ((contact, _), part) in self.measured_contacts().filter(|((_, gap), _)| **gap < least) {
            touched(contact, *part);
        }
    }

    /// Record the contacts that are closed at the end of a stage.
    pub fn record_closed_contacts(&mut self) {
        let mut met = std::mem::take(&mut self.closed_in_step);
        self.for_each_closed(|contact, part| {
            for side in [contact.a, contact.b] {
                if let ContactSide::Sheet { sheet, point } = side {
                    met.extend(point.terms().map(|(mass, _)| [sheet, mass, part]));
                }
            }
        });
        self.closed_in_step = met;
    }

    /// Support of body `body` of the island: sheets and kinematic or static bodies that carry it.
    /// Dynamic bodies are left out because rolling resistance would have to turn them too.
    pub fn support_of(&self, body: u32, solver_bodies: &[SolverBody]) -> Support {
        let mut support = Support::default();
        let is_it = |side: &ContactSide| matches!(side, ContactSide::Body { body: other, .. } if *other == body);
        let spin_of = |side: &ContactSide| match side {
            ContactSide::Body { body, .. } => solver_bodies
                .get(*body as usize)
                .filter(|solver_body| !solver_body.is_dynamic())
                .map(|solver_body| solver_body.start.spin()),
            ContactSide::Sheet { .. } => Some(DVec3::ZERO),
        };
        let all = self.detected.contacts[..self.detected.first_attachment].iter().zip(&self.gaps.now);
        let least = SETTINGS.closed_gap_at_end * self.half_thickness;
        for (contact, _) in all.filter(|(_, gap)| **gap < least) {
            let (normal, other) = match (is_it(&contact.a), is_it(&contact.b)) {
                (true, _) => (contact.normal, &contact.b),
                (_, true) => (-contact.normal, &contact.a),
                _ => continue,
            };
            if let Some(spin) = spin_of(other) {
                support.add(normal, contact.friction, spin);
            }
        }
        support
    }
}
