//! Convergence test of the outer iteration: penetration at the iterate.
//!
//! The strain test compares the strain of an iteration with the prediction of its linear solve.
//! Contact constraints are linear too: where a triangle turns under a needle's tip, or the nearest
//! point moves to another triangle, they may be satisfied while the surfaces overlap. The
//! penetration is therefore measured once more at the iterate, unless the stage hardly moved any
//! node. Lengths in m.

use glam::DVec3;

use crate::collision::constraint::{ContactConstraint, ContactSide};
use crate::contact::IslandView;
use crate::contact::settings::{ContactSettings, ConvergenceSettings};
use crate::contact::solver_body::SolverBody;
use crate::sheet::stage;

const SETTINGS: ConvergenceSettings = ContactSettings::DEFAULT.convergence;

/// Penetration tolerance, in half thicknesses, after iteration `round` with `sheets` sheets;
/// `stalled` says whether the iteration has stagnated.
pub(crate) fn penetration_tolerance(round: u32, sheets: usize, stalled: bool) -> f64 {
    let is_fine = sheets == 1 && round < SETTINGS.fine_iterations && !stalled;
    if is_fine { SETTINGS.fine_penetration } else { SETTINGS.penetration }
}

/// Whether any node, or a body at the distance of a node, moved far enough in the stage to require
/// another detection.
pub(crate) fn has_moved(island: &IslandView) -> bool {
    let still = if island.sheets.len() > 1 { SETTINGS.displacement_several } else { SETTINGS.displacement_single };
    let still = still * island.half_thickness();
    let size = island.sheets.iter().map(|sheet| sheet.model.initial_diagonal).fold(0.0, f64::max);
    let moves = |body: &SolverBody| {
        let (from, to) = (&body.start, &body.free);
        let turn = (to.rotation() - from.rotation()).length() * size;
        to.centre().distance(from.centre()) + turn > still
    };
    island.sheets.iter().any(|sheet| stage::has_moved(sheet, still)) || island.solver_bodies.iter().any(moves)
}

/// Position of a side of a contact at the iterate, m.
fn position(island: &IslandView, side: &ContactSide) -> DVec3 {
    match side {
        ContactSide::Sheet { sheet, point } => point.position(&island.sheet(*sheet).work.stage.iterate),
        ContactSide::Body { body, local } => {
            let solver_body = &island.solver_bodies[*body as usize];
            solver_body.free.world_point(*local)
                + solver_body.displacement_at(solver_body.free.world_point(*local) - solver_body.free.centre())
        }
    }
}

/// Penetration of a contact at the iterate, m; negative if it is open.
fn penetration(island: &IslandView, contact: &ContactConstraint) -> f64 {
    contact.offset - contact.normal.dot(position(island, &contact.a) - position(island, &contact.b))
}

/// Deepest penetration into a body among `contacts` at the iterate, m; 0 if there is none.
/// Sheet-sheet contacts are left out: not all of them are in the problem, and further iterations do
/// not reduce their penetration.
pub(crate) fn deepest_body_penetration(island: &IslandView, contacts: &[ContactConstraint]) -> f64 {
    let on_body = contacts.iter().filter(|c| matches!(c.b, ContactSide::Body { .. }));
    on_body.map(|c| penetration(island, c)).fold(0.0, f64::max)
}

/// Whether the two sides of a sheet-sheet contact have penetrated in the stage by more than later
/// steps can recover, or have passed through. Pairs whose mid-surfaces had already passed each
/// other at the start do not count.
pub(crate) fn has_crossed(island: &IslandView, contact: &ContactConstraint) -> bool {
    let start = |side: &ContactSide| match side {
        ContactSide::Sheet { sheet, point } => point.position(&island.sheet(*sheet).state.x),
        ContactSide::Body { body, local } => island.solver_bodies[*body as usize].start.world_point(*local),
    };
    let was = contact.offset - contact.normal.dot(start(&contact.a) - start(&contact.b));
    let now = penetration(island, contact);
    now > SETTINGS.crossed_penetration * contact.offset
        && now > was.max(0.0) + SETTINGS.crossed_growth * contact.offset
        && was < contact.offset
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gap::node_side;
    use crate::contact::test_island::{TestIsland, body_side, contact, fixed_body, loose_nodes, on_plane};
    use crate::scene::IntegratorKind;

    const DT: f64 = 0.01;

    /// Two sheets whose first nodes lie 1 mm apart along y, sheet 1 above; sheet 1 moves down by
    /// `fall` (m) in the stage.
    fn two_sheets(fall: f64) -> TestIsland {
        let mut sheets: Vec<_> = (0..2).map(|_| loose_nodes(2, 0.2, &[], IntegratorKind::BackwardEuler)).collect();
        sheets[1].state.x.set(0, DVec3::Y * 1e-3);
        sheets[1].state.v.set(0, DVec3::NEG_Y * (fall / DT));
        let mut island = TestIsland::new(sheets, vec![fixed_body()], DVec3::ZERO);
        island.begin_stage(DT);
        let moved = island.sheets[1].state.x.get(0) - DVec3::Y * fall;
        island.sheets[1].work.stage.iterate.set(0, moved);
        island
    }

    #[test]
    fn tolerance_is_finer_in_the_first_iterations_of_a_single_sheet() {
        let (fine, coarse) = (SETTINGS.fine_penetration, SETTINGS.penetration);
        assert_eq!(penetration_tolerance(0, 1, false), fine);
        assert_eq!(penetration_tolerance(SETTINGS.fine_iterations - 1, 1, false), fine);
        assert_eq!(penetration_tolerance(SETTINGS.fine_iterations, 1, false), coarse);
        assert_eq!(penetration_tolerance(0, 1, true), coarse, "stagnation");
        assert_eq!(penetration_tolerance(0, 2, false), coarse);
    }

    #[test]
    fn deepest_penetration_is_that_of_the_iterate_into_bodies() {
        // Node 0 of sheet 0 lies on the plane of the contact offset 0.3 mm: it is 0.3 mm deep. The
        // deeper sheet-sheet contact does not count.
        let mut island = two_sheets(0.0);
        let on_body = ContactConstraint { offset: 3e-4, ..on_plane(0, DVec3::Y) };
        let on_sheet = contact(1, node_side(1, 0), node_side(0, 0), DVec3::Y);
        let on_sheet = ContactConstraint { offset: 5e-3, ..on_sheet };
        let open =
            ContactConstraint { offset: -1e-3, ..contact(2, node_side(0, 0), body_side(0, DVec3::ZERO), DVec3::Y) };
        let all = [on_body, on_sheet, open];
        let depth = island.with(|view, _| deepest_body_penetration(view, &all));
        assert!((depth - 3e-4).abs() < 1e-16, "{depth}");
        assert_eq!(island.with(|view, _| deepest_body_penetration(view, &all[1..])), 0.0);
    }

    #[test]
    fn nodes_count_as_moved_beyond_the_displacement_threshold() {
        let threshold = SETTINGS.displacement_several * two_sheets(0.0).with(|view, _| view.half_thickness());
        assert!(!two_sheets(0.9 * threshold).with(|view, _| has_moved(view)));
        assert!(two_sheets(1.1 * threshold).with(|view, _| has_moved(view)));
    }

    #[test]
    fn sheets_have_crossed_when_a_touching_pair_penetrates_by_three_tenths_of_its_offset() {
        let offset = 1e-3;
        let pair = ContactConstraint { offset, ..contact(0, node_side(1, 0), node_side(0, 0), DVec3::Y) };
        let crossed = |fall: f64| two_sheets(fall).with(|view, _| has_crossed(view, &pair));
        assert!(!crossed(0.9 * SETTINGS.crossed_penetration * offset));
        assert!(crossed(1.1 * SETTINGS.crossed_penetration * offset));
        assert!(crossed(2.0 * offset), "passed through");
        // A pair whose penetration grows from 2 to 3 offsets had passed before this stage.
        let passed = ContactConstraint { offset: 1e-3, normal: DVec3::NEG_Y, ..pair };
        assert!(!two_sheets(-1e-3).with(|view, _| has_crossed(view, &passed)));
    }
}
