//! Sheets compressed across their thickness between two bodies whose motion is prescribed.
//!
//! Between two opposite faces at a distance d below the sum of the contact offsets no position
//! satisfies both contacts. The material is compressed there, by the strain 1 - d/t:
//!
//! - the contact with one face becomes bilateral, at d/2, without slip relative to the mean motion
//!   of the faces: the pressure E (1 - d/t) bears far more friction than a sheet can pull;
//! - the others of the same feature have an offset slightly below d/2 and stay open.
//!
//! The pressure acts on both faces alike and does not move the sheet. Lengths in m.

use crate::collision::constraint::{ContactConstraint, ContactSide};
use crate::contact::IslandView;
use crate::contact::gap::{StagePose, position, velocity};
use crate::contact::settings::ContactSettings;

const SETTINGS: ContactSettings = ContactSettings::DEFAULT;

/// Make the contacts that compress a sheet compatible. `contacts` are in ascending order of their
/// keys, so that those of one feature of a sheet follow one another.
pub(crate) fn resolve_compression(island: &IslandView, contacts: &mut [ContactConstraint]) {
    let most = SETTINGS.opposed_normal_cosine;
    let fixed = |side: &ContactSide| matches!(side, ContactSide::Body { body, .. } if !island.solver_bodies[*body as usize].is_dynamic());
    for feature in contacts.chunk_by_mut(|one, next| one.key[0] == next.key[0]) {
        if feature.len() < 2 {
            continue;
        }
        let pairs = (1..feature.len()).flat_map(|k| (0..k).map(move |i| (i, k)));
        let compressed = pairs.filter_map(|(i, k)| {
            let (one, other) = (&feature[i], &feature[k]);
            if !(fixed(&one.b) && fixed(&other.b) && one.normal.dot(other.normal) < most) {
                return None;
            }
            let [a, b] = [one, other].map(|contact| position(island, &contact.b, StagePose::Free));
            let distance = (one.normal - other.normal).normalize_or_zero().dot(b - a);
            (distance > 0.0 && distance < one.offset + other.offset).then_some((i, k, distance))
        });
        let nearest = compressed.min_by(|one, other| one.2.total_cmp(&other.2));
        let Some((held, facing, distance)) = nearest else { continue };
        let [a, b] = [held, facing].map(|i| velocity(island, &feature[i].b, StagePose::Free));
        let normal = feature[held].normal;
        for contact in feature.iter_mut().filter(|c| fixed(&c.b) && c.normal.dot(normal).abs() > -most) {
            contact.offset = contact.offset.min(SETTINGS.compressed_offset * 0.5 * distance);
        }
        (feature[held].offset, feature[held].compressed) = (0.5 * distance, Some(0.5 * (b - a)));
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::contact::gap::node_side;
    use crate::contact::test_island::{TestIsland, body_side, contact, fixed_body, loose_nodes};
    use crate::scene::IntegratorKind;

    /// Contacts of node 0 of a sheet of 0.5 mm between two planes at the distance `distance` (m),
    /// 0.1 mm from the lower one, after [`resolve_compression`].
    fn between_planes(distance: f64) -> [ContactConstraint; 2] {
        let mut sheet = loose_nodes(2, 0.2, &[], IntegratorKind::BackwardEuler);
        sheet.state.x.set(0, DVec3::Y * 1e-4);
        let mut island = TestIsland::new(vec![sheet], vec![fixed_body(), fixed_body()], DVec3::ZERO);
        island.begin_stage(0.01);
        island.sheets[0].work.stage.free_positions.set(0, DVec3::Y * 1e-4);
        let below = contact(0, node_side(0, 0), body_side(0, DVec3::ZERO), DVec3::Y);
        let above = contact(0, node_side(0, 0), body_side(1, DVec3::Y * distance), DVec3::NEG_Y);
        let mut both = [below, above].map(|c| ContactConstraint { offset: 2.5e-4, ..c });
        island.with(|view, _| resolve_compression(view, &mut both));
        both
    }

    #[test]
    fn a_node_in_a_gap_below_the_thickness_is_held_in_its_middle() {
        let [below, above] = between_planes(4e-4);
        assert!(below.compressed == Some(DVec3::ZERO) && (below.offset - 2e-4).abs() < 1e-16, "{below:?}");
        assert!(above.compressed.is_none() && above.offset < 2e-4 && above.offset > 1.5e-4, "{above:?}");
    }

    #[test]
    fn a_gap_of_the_thickness_and_planes_past_each_other_leave_the_contacts_as_they_are() {
        for distance in [5.1e-4, -1e-4] {
            let both = between_planes(distance);
            assert!(both.iter().all(|c| c.compressed.is_none() && c.offset == 2.5e-4), "{distance} {both:?}");
        }
    }
}
