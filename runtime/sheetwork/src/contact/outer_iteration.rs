//! Outer iteration of a stage: free motion, detection, position solve, update of the iterate.
//!
//! The iteration ends when the strain after the update is the strain that the linear solve
//! predicted and no surface penetrates another. Detection searches for contacts of the free motion.
//! Three further detections cover the motion by contact forces:
//!
//! - with wider margins, when contact displaces something by more than the margin;
//! - at the displaced position, when a single sheet is displaced so far that wide margins would
//!   include every pair;
//! - from the start of the stage to the iterate, for sheets that passed through each other. These
//!   contacts stay in the problem for the following iterations.
//!
//! Lengths in m.

use glam::DVec3;

use crate::contact::detected_contacts::DetectedContacts;
use crate::contact::explicit_bonds::find_bonded;
use crate::contact::settings::{ContactSettings, OuterIterationSettings};
use crate::contact::solver::choice::PositionSolve;
use crate::contact::solver::lattice_sweeps::{add_thickness_limits, is_of_lattices};
use crate::contact::workspace::ContactWorkspace;
use crate::contact::{IslandView, convergence};
use crate::sheet::Field;
use crate::sheet::stage::{self, StageWorkspace};

const SETTINGS: OuterIterationSettings = ContactSettings::DEFAULT.outer_iteration;

/// Positions and pairs that detection covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DetectionMode {
    /// Contacts of the free motion, seen from the start of the stage.
    FromStart,
    /// Contacts of the free motion, seen from the iterate.
    FromIterate,
    /// Contacts at the position displaced by contact in this iteration, seen from the start of the
    /// stage.
    ContactMotion,
    /// Contacts of sheets with bodies at the iterate.
    BodyPenetration,
    /// Sheet-sheet contacts on the way from the start of the stage to the iterate.
    SheetCrossing,
}

/// Search margins: pairs with a smaller gap after the free motion become contacts, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactMargins {
    /// Margin between a sheet and a body, m.
    pub bodies: f64,
    /// Margin between two sheets and within one sheet, m.
    pub sheets: f64,
}

impl ContactMargins {
    /// Margins for features that have reached their place.
    pub fn resting(island: &IslandView) -> Self {
        let margin = SETTINGS.margin * island.half_thickness();
        Self { bodies: margin, sheets: margin }
    }

    /// Initial margins of a stage in which contact displaces a resting sheet by `fall` (m). Sheets
    /// in a pile are displaced together, so that their relative displacement is smaller.
    fn of_stage(island: &IslandView, fall: f64) -> Self {
        let Self { bodies, sheets } = Self::resting(island);
        let between = if island.sheets.len() > 1 { SETTINGS.margin_between_several * sheets } else { sheets };
        Self { bodies: bodies.max(fall), sheets: between }
    }

    /// Widen the margins to cover the displacements `furthest`. Returns false if they already do.
    fn widen(&mut self, furthest: Self, half_thickness: f64) -> bool {
        let is_enough = furthest.bodies <= self.bodies && furthest.sheets <= self.sheets;
        let most = SETTINGS.maximum_margin * half_thickness;
        if !is_enough {
            self.bodies = self.bodies.max((1.5 * furthest.bodies).min(most));
            self.sheets = self.sheets.max((1.5 * furthest.sheets).min(most));
        }
        !is_enough
    }
}

/// Solve positions, and solve again with wider margins while contact displaces something into a
/// contact that was not detected.
fn solve_positions_and_widen(
    island: &mut IslandView,
    workspace: &mut ContactWorkspace,
    (h, initial): (f64, ContactMargins),
    (mode, rough): (DetectionMode, bool),
    mut detect: impl FnMut(&IslandView, DetectionMode, ContactMargins, &mut DetectedContacts),
) -> PositionSolve {
    let mut solved = workspace.profile(|workspace| workspace.solve_positions(island, h, rough));
    let (mut margins, half) = (initial, island.half_thickness());
    for _ in 0..SETTINGS.maximum_widenings {
        if solved != PositionSolve::Touched || !margins.widen(largest_displacements(island), half) {
            break;
        }
        let is_far = island.sheets.len() == 1 && margins.sheets > SETTINGS.displaced_search_distance * half;
        let overlaps = if is_far {
            detect(island, DetectionMode::ContactMotion, ContactMargins::resting(island), &mut workspace.rechecked);
            workspace.rechecked.remove_opposed(island, &workspace.cache);
            workspace.add_displaced_contacts(island)
        } else {
            detect(island, mode, margins, &mut workspace.rechecked);
            workspace.rechecked.remove_opposed(island, &workspace.cache);
            workspace.adopt_wider_detection(island)
        };
        if !overlaps {
            break;
        }
        workspace.add_crossed_contacts();
        solved = workspace.profile(|workspace| workspace.solve_positions(island, h, rough));
    }
    solved
}

/// Largest displacement by contact in the island, m: absolute, and relative to the mean
/// displacement of the sheets.
fn largest_displacements(island: &IslandView) -> ContactMargins {
    let units = || island.contacts.iter().map(|contact| &contact.response);
    let touched = || units().filter(|response| response.is_touched()).map(|response| &response.jump.dx);
    let (sum, count) = touched().fold((DVec3::ZERO, 0), |(sum, n), dx| (sum + dx.iter().sum::<DVec3>(), n + dx.len()));
    // Sheets without contact have no displacement, and the mean is zero.
    let mean = if units().all(|response| response.is_touched()) { sum / count.max(1) as f64 } else { DVec3::ZERO };
    let most = |from: DVec3| {
        touched().flat_map(|dx| dx.iter()).map(|dx| (dx - from).length_squared()).fold(0.0, f64::max).sqrt()
    };
    let bodies = island.solver_bodies.iter().map(|m| m.displacement.length()).fold(most(DVec3::ZERO), f64::max);
    ContactMargins { bodies, sheets: most(mean) }
}

/// Run the outer iteration of one stage for all sheets of `island`. `h` is the weight of the stage
/// (s). `detect` writes the contacts for a detection mode and margins, given the free motions
/// stored in the group.
pub(crate) fn solve_stage(
    island: &mut IslandView,
    workspace: &mut ContactWorkspace,
    field: Field,
    h: f64,
    mut detect: impl FnMut(&IslandView, DetectionMode, ContactMargins, &mut DetectedContacts),
) -> StageSolve {
    let sheets = island.sheets.len();
    let margins = ContactMargins::of_stage(island, field.gravity.length() * h * h);
    // A pair that touched in any iteration may touch again; ending without it would let it pass
    // through.
    let (mut met, mut before) = (false, f64::INFINITY);
    let mut mode = DetectionMode::FromStart;
    workspace.begin_outer_iteration();
    for round in 0..SETTINGS.maximum_iterations_single + SETTINGS.additional_iterations {
        workspace.work += island.nodes() as u64;
        if !compute_free_motion(island, field) {
            return StageSolve::Unconverged;
        }
        detect(island, mode, margins, &mut workspace.detected);
        workspace.detected.remove_opposed(island, &workspace.cache);
        if let Some(sheet) = workspace.initially_buried_sheet(island).filter(|_| round == 0) {
            return StageSolve::InitialPenetration(sheet);
        }
        workspace.add_crossed_contacts();
        let rough = round == 0 && workspace.is_impact(island);
        let touched = match solve_positions_and_widen(island, workspace, (h, margins), (mode, rough), &mut detect) {
            PositionSolve::Failed => return StageSolve::Unconverged,
            solved => solved == PositionSolve::Touched,
        };
        met |= touched;
        let firm =
            workspace.has_only_attachments() || workspace.is_single_unfolded_sheet && island.independent_parts() == 1;
        let worst = update_iterates(island, field, touched, firm);
        if met && !workspace.policy.is_shortest_substep && has_diverged(round, sheets, worst) {
            return StageSolve::Diverged;
        }
        let moved = met && convergence::has_moved(island);
        if moved && !workspace.is_single_unfolded_sheet {
            detect(island, DetectionMode::SheetCrossing, margins, &mut workspace.rechecked);
            workspace.record_crossed_contacts(island);
        }
        mode = if workspace.has_crossed { DetectionMode::FromStart } else { DetectionMode::FromIterate };
        let done = !rough && stages(island).all(|stage| stage.is_finished);
        let mut apart = !workspace.has_crossed;
        if apart && done && moved {
            apart = is_free_of_penetration(island, workspace, round, &mut before, &mut detect);
        }
        if done && apart {
            return if touched { StageSolve::Converged } else { StageSolve::ConvergedWithoutContact };
        }
        if !apart {
            island.for_each_sheet(|sheet| sheet.work.stage.is_finished = false);
        }
        if let Some(end) = iteration_limit(round, maximum_iterations(workspace, met), (met, touched)) {
            return end;
        }
    }
    StageSolve::Separated
}

/// Whether no sheet penetrates a body at the iterate of iteration `round` by more than the
/// tolerance; `before` is the penetration at the last test, m.
fn is_free_of_penetration(
    island: &IslandView,
    workspace: &mut ContactWorkspace,
    round: u32,
    before: &mut f64,
    mut detect: impl FnMut(&IslandView, DetectionMode, ContactMargins, &mut DetectedContacts),
) -> bool {
    let overlap = workspace.deepest_penetration(island, |island, found| {
        detect(island, DetectionMode::BodyPenetration, ContactMargins::resting(island), found)
    });
    let is_stalled = overlap > SETTINGS.stagnation_ratio * *before;
    *before = overlap;
    overlap <= convergence::penetration_tolerance(round, island.sheets.len(), is_stalled) * island.half_thickness()
}

/// Result of a stage that ends after iteration `round` because of the limit `rounds`; `None` if it
/// goes on. `met` and `touched` say whether there was contact in any and in the last iteration.
fn iteration_limit(round: u32, rounds: u32, (met, touched): (bool, bool)) -> Option<StageSolve> {
    if round + 1 >= rounds && touched == met {
        return Some(if met { StageSolve::Unconverged } else { StageSolve::UnconvergedWithoutContact });
    }
    (round + 1 >= rounds + SETTINGS.additional_iterations).then_some(StageSolve::Separated)
}

/// Whether the strain error `worst` after iteration `round` counts as divergence, as a multiple of
/// the tolerance.
fn has_diverged(round: u32, sheets: usize, worst: f64) -> bool {
    let early = sheets > 1 && round + 1 == SETTINGS.iterations_before_divergence;
    early && worst > SETTINGS.early_divergence_threshold
        || round >= SETTINGS.iterations_before_divergence && worst > SETTINGS.divergence_threshold
}

/// Maximum number of outer iterations; `met` says whether any contact has closed.
fn maximum_iterations(workspace: &ContactWorkspace, met: bool) -> u32 {
    match workspace.is_single_unfolded_sheet || workspace.has_only_attachments() || !met {
        _ if workspace.is_work_budget_spent() => 1,
        true => SETTINGS.maximum_iterations_single,
        false if workspace.policy.is_shortest_substep => SETTINGS.maximum_iterations_shortest_substep,
        false => SETTINGS.maximum_iterations_several,
    }
}

/// Compute the free motion of every sheet that has not converged. Returns false if a solve failed.
fn compute_free_motion(island: &mut IslandView, field: Field) -> bool {
    island.for_each_sheet(|sheet| {
        if !sheet.work.stage.is_finished && !stage::solve_free_motion(sheet, field) {
            sheet.work.stage.has_failed = true;
        }
    });
    stages(island).all(|stage| !stage.has_failed)
}

/// Move every sheet to its new iterate, with the contact displacement if `touched`; `firm` demands
/// fine convergence at attachments. Returns the largest strain error as a multiple of the
/// tolerance.
fn update_iterates(island: &mut IslandView, field: Field, touched: bool, firm: bool) -> f64 {
    island.each_response(|sheet, response| {
        let contact = (touched && response.is_touched()).then_some(&response.jump.dx);
        stage::update_iterate(sheet, field, contact, firm);
    });
    stages(island).filter(|stage| !stage.is_finished).map(|stage| stage.misprediction_ratio).fold(0.0, f64::max)
}

/// Stage data of all sheets of the island.
fn stages<'a>(island: &'a IslandView) -> impl Iterator<Item = &'a StageWorkspace> {
    island.sheets.iter().map(|sheet| &sheet.work.stage)
}

/// Solve the contact of an island with explicit integrators, whose free motions are known, in a
/// step of `h` s; `detect` writes the contacts. Returns false if nothing touches. Otherwise
/// displacements and velocity jumps are left in the contact arrays of the sheets and in the solver
/// bodies.
pub(crate) fn solve_explicit(
    island: &mut IslandView,
    workspace: &mut ContactWorkspace,
    h: f64,
    detect: impl FnOnce(&IslandView, &mut DetectedContacts),
) -> bool {
    workspace.policy.is_explicit = true;
    detect(island, &mut workspace.detected);
    workspace.detected.remove_opposed(island, &workspace.cache);
    workspace.has_bonds = find_bonded(island, &mut workspace.detected);
    if is_of_lattices(island, &workspace.detected) {
        add_thickness_limits(island, &mut workspace.detected);
    }
    let solved = workspace.profile(|workspace| workspace.solve_positions(island, h, false));
    let touched = solved == PositionSolve::Touched;
    if touched {
        workspace.profile(|workspace| workspace.solve_velocities(island, h));
    }
    touched
}

/// Result of the outer iteration of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StageSolve {
    /// Converged without contact.
    ConvergedWithoutContact,
    /// Converged with contact.
    Converged,
    /// Iteration limit without contact.
    UnconvergedWithoutContact,
    /// Iteration limit with contact, or a failed solve.
    Unconverged,
    /// Diverged; a shorter step may converge.
    Diverged,
    /// Cancelled: this sheet of the island started deep inside a body, which no step length
    /// resolves.
    InitialPenetration(u32),
    /// Iteration limit; an earlier iteration had contact, the last one had none.
    Separated,
}

#[cfg(test)]
mod tests;
