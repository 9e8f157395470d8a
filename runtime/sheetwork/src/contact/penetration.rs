//! Penetration of an island in a stage: impacts and buried sheets at its start, and the deepest
//! penetration into a body at the iterate. Depths in m.

use crate::collision::constraint::{ContactConstraint, ContactSide};
use crate::collision::narrow_phase::is_node_surface_contact;
use crate::contact::detected_contacts::DetectedContacts;
use crate::contact::gap::{StagePose, gap};
use crate::contact::settings::ContactSettings;
use crate::contact::workspace::ContactWorkspace;
use crate::contact::{IslandView, convergence};

const SETTINGS: ContactSettings = ContactSettings::DEFAULT;

impl ContactWorkspace {
    /// Whether a contact was open by more than [`ContactSettings::impact_distance`] and would
    /// penetrate by more than that.
    /// The linearisation of this outer iteration is then far from the solution.
    pub(crate) fn is_impact(&self, island: &IslandView) -> bool {
        let least = SETTINGS.impact_distance * island.half_thickness();
        let strikes = |c| gap(island, c, StagePose::Free) < -least && gap(island, c, StagePose::Start) > least;
        self.detected.contacts.iter().any(strikes)
    }

    /// Deepest penetration of a node in a body surface at the start of the stage, m.
    pub(crate) fn initial_penetration(&self, island: &IslandView) -> f64 {
        let surfaces =
            self.detected.contacts[..self.detected.first_attachment].iter().filter(|c| is_node_surface_contact(&c.key));
        surfaces.map(|c| -gap(island, c, StagePose::Start)).fold(0.0, f64::max)
    }

    /// The sheet that started with at least half of its nodes deep inside bodies, if any. Only a
    /// scene edit can put a sheet there.
    pub(crate) fn initially_buried_sheet(&self, island: &IslandView) -> Option<u32> {
        let is_deep = |c: &&ContactConstraint| {
            let ContactSide::Sheet { sheet, point } = &c.a else { return false };
            let sheet = island.sheet(*sheet);
            // Only contacts of nodes with faces count: corners and edges may lie behind each
            // other's planes without overlap.
            let depth = -gap(island, c, StagePose::Start);
            // A node that a body passes by is behind its far side at the start and outside at the
            // end.
            depth > SETTINGS.buried_depth * sheet.model.initial_diagonal
                && -gap(island, c, StagePose::Free) > 0.5 * depth
                && is_node_surface_contact(&c.key)
                && point.terms().all(|(i, _)| !sheet.is_held(i as usize))
        };
        let deep = || self.detected.contacts[..self.detected.first_attachment].iter().filter(is_deep);
        let ContactSide::Sheet { sheet: first, .. } = deep().next()?.a else { return None };
        // A body that passes by in the step has some nodes behind its far side, but fewer than
        // half.
        let of_first = |c: &&ContactConstraint| matches!(c.a, ContactSide::Sheet { sheet, .. } if sheet == first);
        (2 * deep().filter(of_first).count() >= island.sheet(first).node_count()).then_some(first)
    }

    /// Deepest penetration into a body at the iterate, m, of the contacts that `detect` detects.
    pub fn deepest_penetration(
        &mut self,
        island: &IslandView,
        detect: impl FnOnce(&IslandView, &mut DetectedContacts),
    ) -> f64 {
        detect(island, &mut self.rechecked);
        self.rechecked.remove_opposed(island, &self.cache);
        convergence::deepest_body_penetration(island, &self.rechecked.contacts[..self.rechecked.first_attachment])
    }
}
