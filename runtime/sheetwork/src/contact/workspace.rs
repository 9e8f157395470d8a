//! Contact solve of one stage of an implicit integrator: position solve, velocity solve, choice of
//! the solver.
//!
//! The outer iteration (`outer_iteration`) calls [`ContactWorkspace::solve_positions`] once per
//! iteration. The position solve finds forces that remove all penetration of the linearised free
//! motion, with friction against the tangential displacement. After the outer iteration,
//! [`ContactWorkspace::solve_velocities`] finds the velocity jumps of the contacts that are closed,
//! with restitution. Positions and velocities need separate solves: with a single one, a sheet that
//! should not rebound separates with two thirds of its approach speed.
//!
//! With α the fraction of the stage before a pair closes, friction acts against (1-α) times the
//! tangential displacement, and the approach speed at impact is
//!
//!   (1-α) times the speed at the start plus α times the free speed at the end.
//!
//! Lengths in m, speeds in m/s, forces in N.

use glam::{DMat3, DVec3};

use crate::collision::constraint::{ContactConstraint, ContactKey, ContactSide};
use crate::collision::narrow_phase::is_node_surface_contact;
use crate::contact::IslandView;
use crate::contact::contact_cache::{CachedForces, ContactCache};
use crate::contact::convergence;
use crate::contact::coulomb::ContactLaw;
use crate::contact::detected_contacts::DetectedContacts;
use crate::contact::gap::{ContactGaps, StagePose, gap, position, velocity};
use crate::contact::settings::{ContactSettings, PgsSettings};
use crate::contact::solver::augmented_lagrangian::{AugmentedLagrangian, IslandTangent};
use crate::contact::solver::dual::DualSolver;
use crate::contact::solver::pgs_working_set::PgsContactSolver;
use crate::contact::solver_body::SolverBody;
use crate::profiler::{Phase, Profiler};
use crate::rigid::Support;
use crate::serialize::{ReadResult, StateReader, StateWriter};

const SETTINGS: ContactSettings = ContactSettings::DEFAULT;
const PGS: PgsSettings = ContactSettings::DEFAULT.pgs;

/// Counters of the contact solver since the start of the simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ContactCounters {
    /// Outer iterations with contact.
    pub rounds: u64,
    /// Contacts in the problem, summed over all outer iterations.
    pub contacts: u64,
    /// Largest number of contacts in one solve.
    pub most: u64,
    /// Solves that did not converge.
    pub unsettled: u64,
    /// PGS sweeps over all contacts.
    pub sweeps: u64,
    /// Newton iterations of the contact solvers.
    pub newton: u64,
    /// Matrix factorisations of the contact solvers.
    pub factors: u64,
    /// Step bisections.
    pub halved: u64,
    /// Substeps that ended in a fallback: the sheets moved rigidly or were frozen.
    pub given_up: u64,
}

/// The contact solver that found the positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum PositionSolver {
    /// Dual solver: unknowns are the contact forces.
    #[default]
    Dual,
    /// Primal solver: unknowns are the displacements of nodes and bodies.
    Primal,
    /// Projected Gauss-Seidel.
    Pgs,
}

/// Contact problem of an island: detected contacts, contact cache, solvers and their arrays. It
/// lives from step to step.
#[derive(Default)]
pub(crate) struct ContactWorkspace {
    /// Contacts of this outer iteration.
    pub detected: DetectedContacts,
    /// Contacts of an additional detection: at the iterate, or with wider margins.
    pub rechecked: DetectedContacts,
    /// Sheet-sheet contacts whose sides have passed through each other in the outer iterations so
    /// far.
    pub(crate) crossed_contacts: Vec<ContactConstraint>,
    /// Whether any sides passed through each other in the last outer iteration.
    pub has_crossed: bool,
    /// Contact cache of this stage of the step.
    pub cache: ContactCache,
    /// Storage of the solver bodies between steps; the island view takes them for a step.
    pub solver_bodies: Vec<SolverBody>,
    /// Contact cache of the other stages of the step. Forces differ more from stage to stage than
    /// from step to step.
    other_stage_cache: ContactCache,
    /// Stage that `cache` belongs to: 0, or 1 for all later stages.
    stage: usize,
    /// Contact caches at the start of the substep, for a rollback.
    saved_caches: [ContactCache; 2],
    /// Solver bodies at the start of the substep, for a rollback.
    pub saved_solver_bodies: Vec<SolverBody>,
    /// Counters of the contact solver.
    pub counters: ContactCounters,
    /// Profiler that measures the contact solve.
    pub profiler: Profiler,
    /// Gaps of `detected`.
    pub(crate) gaps: ContactGaps,
    /// PGS solver.
    pgs: PgsContactSolver,
    /// Augmented Lagrangian solver, shared by the primal and the dual solver.
    pub(crate) augmented_lagrangian: AugmentedLagrangian,
    /// Joint tangent matrix of the island.
    pub(crate) island_tangent: IslandTangent,
    /// Working set of the solver, as indices into `detected`.
    pub(crate) working_set: Vec<u32>,
    /// Whether each contact of `detected` is in the working set of the primal solver.
    pub(crate) in_working_set: Vec<bool>,
    /// Keys of the contacts that the last position solve of this stage left open, in ascending
    /// order.
    pub(crate) open_keys: Vec<ContactKey>,
    /// Gap (m) below which a contact without a known force starts as closed.
    pub(crate) closing_gap: f64,
    /// Solver of the last position solve; the velocity solve uses it too.
    pub(crate) position_solver: PositionSolver,
    /// Dual solver.
    pub(crate) dual: DualSolver,
    /// Slots in the matrix of the block pairs of every constraint.
    pub(crate) slots: Vec<u32>,
    /// Whether the problem is a single sheet without self-contact.
    pub is_single_sheet: bool,
    /// Whether the problem is a single sheet on kinematic and static bodies only.
    pub(crate) has_only_fixed_bodies: bool,
    /// Whether the sheet's own tangent matrix covers all constraints, so that no joint matrix is
    /// needed.
    pub(crate) uses_sheet_tangent: bool,
    /// Contact normal of every node in contact with a body, by block row; zero without contact.
    pub(crate) normals: Vec<DVec3>,
    /// Whether a solve of the substep failed to converge.
    pub solve_failed: bool,
    /// Whether an unconverged solution is accepted.
    pub accepts_unconverged: bool,
    /// Whether the substep is the shortest allowed one.
    pub is_shortest_substep: bool,
    /// Work of the step so far, in node-iterations, compared to [`ContactSettings::maximum_work`].
    pub work: u64,
    /// Bisection level at which the step of several sheets starts: one less than the deepest level
    /// of the previous step.
    pub initial_bisection_level: u32,
    /// Deepest bisection level attempted in this step.
    pub deepest_bisection_level: u32,
    /// Whether the step diverged beyond recovery; its remaining substeps are skipped.
    pub is_diverged: bool,
    /// Whether a substep of this step ended in a fallback.
    pub used_fallback: bool,
    /// Whether a substep of the previous step ended in a fallback; the event is sent once per
    /// episode.
    pub used_fallback_before: bool,
    /// Consecutive steps that were rolled back after divergence.
    pub consecutive_rollbacks: u32,
    /// Consecutive steps with a fallback.
    pub consecutive_fallbacks: u32,
    /// Whether this step was rolled back after divergence.
    pub was_rolled_back: bool,
    /// Solver bodies that move together with a sheet in the rigid-motion fallback.
    pub moves_rigidly: Vec<bool>,
    /// Energy error (J) that exceeded the available kinetic energy and is carried to the next
    /// steps.
    pub energy_error: f64,
    /// Whether the island uses explicit integrators.
    pub(crate) is_explicit: bool,
    /// Contacts that were closed at the end of any stage of the step: sheet of the island, node,
    /// collider. A contact that rebounds within the step is open again at its end.
    pub closed_in_step: Vec<[u32; 3]>,
}

impl ContactWorkspace {
    /// Measure `work` as part of the contact solve.
    pub fn profile<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let watch = self.profiler.clone();
        watch.measure(Phase::Contact, || work(self))
    }

    /// Save the contact caches and solver bodies for a rollback of the step.
    pub fn save_for_rollback(&mut self, movers: &[SolverBody]) {
        self.begin_stage(0);
        self.saved_caches[0].copy_from(&self.cache);
        self.saved_caches[1].copy_from(&self.other_stage_cache);
        self.saved_solver_bodies.clear();
        self.saved_solver_bodies.extend_from_slice(movers);
        self.moves_rigidly.resize(movers.len(), false);
    }

    /// Record a fallback in this substep.
    pub fn record_fallback(&mut self) {
        self.counters.given_up += 1;
        self.used_fallback = true;
    }

    /// Exchange `movers` with the saved solver bodies.
    pub fn swap_saved_bodies(&mut self, movers: &mut Vec<SolverBody>) {
        std::mem::swap(movers, &mut self.saved_solver_bodies);
    }

    /// Reset after a step without any possible contact.
    pub fn reset(&mut self) {
        (self.used_fallback, self.energy_error) = (false, 0.0);
        self.detected.clear();
        self.cache.clear();
        self.other_stage_cache.clear();
    }

    /// Begin stage `k` of a step: select its contact cache (one for stage 0, one for all others).
    pub fn begin_stage(&mut self, k: usize) {
        if k.min(1) != self.stage {
            std::mem::swap(&mut self.cache, &mut self.other_stage_cache);
            self.stage = k.min(1);
        }
    }

    /// Cached forces of a contact, from this stage or, if absent, from the other one.
    pub(crate) fn cached_forces(&self, key: &ContactKey) -> Option<CachedForces> {
        self.cache.of(key).or_else(|| self.other_stage_cache.of(key))
    }

    /// Serialise the state that persists between steps.
    pub fn serialise(&self, to: &mut StateWriter) {
        let flags = [
            self.is_single_sheet,
            self.has_only_fixed_bodies,
            self.uses_sheet_tangent,
            self.solve_failed,
            self.accepts_unconverged,
            self.is_shortest_substep,
        ];
        flags
            .into_iter()
            .chain([self.is_diverged, self.was_rolled_back, self.is_explicit, self.used_fallback])
            .for_each(|f| to.flag(f));
        for count in [
            self.stage as u32,
            self.initial_bisection_level,
            self.deepest_bisection_level,
            self.consecutive_rollbacks,
            self.consecutive_fallbacks,
        ] {
            to.count(u64::from(count));
        }
        to.numbers(&[self.closing_gap, self.energy_error]);
        let c = &self.counters;
        for count in [c.rounds, c.contacts, c.most, c.unsettled, c.sweeps, c.newton, c.factors, c.halved, c.given_up] {
            to.count(count);
        }
        self.cache.serialise(to);
        self.other_stage_cache.serialise(to);
        self.island_tangent.serialise(to);
    }

    /// Deserialise the state that persists between steps.
    pub fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        (self.is_single_sheet, self.has_only_fixed_bodies, self.uses_sheet_tangent) =
            (from.flag()?, from.flag()?, from.flag()?);
        (self.solve_failed, self.accepts_unconverged, self.is_shortest_substep) =
            (from.flag()?, from.flag()?, from.flag()?);
        (self.is_diverged, self.was_rolled_back, self.is_explicit) = (from.flag()?, from.flag()?, from.flag()?);
        self.used_fallback = from.flag()?;
        self.stage = from.index(2)? as usize;
        (self.initial_bisection_level, self.deepest_bisection_level, self.consecutive_rollbacks) =
            (from.count_u32()?, from.count_u32()?, from.count_u32()?);
        self.consecutive_fallbacks = from.count_u32()?;
        (self.closing_gap, self.energy_error) = (from.number()?, from.number()?);
        let c = &mut self.counters;
        let counts = [&mut c.rounds, &mut c.contacts, &mut c.most, &mut c.unsettled, &mut c.sweeps, &mut c.newton];
        for count in counts.into_iter().chain([&mut c.factors, &mut c.halved, &mut c.given_up]) {
            *count = from.count()?;
        }
        self.cache.deserialise(from)?;
        self.other_stage_cache.deserialise(from)?;
        self.island_tangent.deserialise(from)?;
        self.detected = DetectedContacts::default();
        self.augmented_lagrangian.clear();
        self.working_set.clear();
        self.position_solver = PositionSolver::Dual;
        Ok(())
    }

    /// Restore the contact caches and solver bodies that were saved.
    pub fn restore_saved(&mut self, movers: &mut Vec<SolverBody>) {
        self.stage = 0;
        self.cache.copy_from(&self.saved_caches[0]);
        self.other_stage_cache.copy_from(&self.saved_caches[1]);
        movers.clear();
        movers.extend_from_slice(&self.saved_solver_bodies);
    }

    /// Remove the penetration of the free motion, in a stage of weight `h` (s). The displacements
    /// are left in the contact arrays of the sheets and in the solver bodies. `rough` lowers the
    /// accuracy. Returns false if nothing overlaps.
    pub(crate) fn solve_positions(&mut self, group: &mut IslandView, h: f64, rough: bool) -> bool {
        self.gaps.measure(&self.detected.contacts, group);
        if self.detected.first_attachment >= self.detected.contacts.len() && self.gaps.free.iter().all(|g| *g >= 0.0) {
            if !self.is_explicit {
                self.forget_solution(group);
            }
            return false;
        }
        if self.is_explicit {
            self.solve_positions_by_pgs(group, h);
            self.position_solver = PositionSolver::Pgs;
        } else if !self.choose_position_solver(group, h, rough) {
            if !self.accepts_unconverged {
                self.solve_failed = true;
                return true;
            }
            // An unconverged solution of several sheets is good enough for the next outer
            // iteration, and another solver takes too long.
            if self.has_only_fixed_bodies {
                // The primal solver has left contact in the factor.
                group.for_each_sheet(|sheet| sheet.restore_factor());
                self.solve_positions_by_pgs(group, h);
                self.position_solver = PositionSolver::Pgs;
            }
        }
        let count = match self.position_solver {
            PositionSolver::Pgs => self.pgs.delassus.problem.len(),
            _ => self.working_set.len(),
        };
        self.gaps.update(&self.detected.contacts, group);
        self.counters.rounds += 1;
        self.counters.contacts += count as u64;
        self.counters.most = self.counters.most.max(count as u64);
        true
    }

    /// Position solve: dual solver for a small working set, otherwise primal solver, and for a
    /// single sheet the dual solver again if the primal one fails. Returns false if none converges.
    fn choose_position_solver(&mut self, group: &mut IslandView, h: f64, rough: bool) -> bool {
        let within =
            |c: &ContactConstraint| matches!((c.a, c.b), (ContactSide::Sheet { .. }, ContactSide::Sheet { .. }));
        let is_folded = group.sheets.len() == 1 && self.detected.contacts.iter().any(within);
        self.is_single_sheet = group.sheets.len() == 1 && !is_folded;
        self.has_only_fixed_bodies = group.sheets.len() == 1 && group.solver_bodies.iter().all(|m| !m.is_dynamic());
        self.island_tangent.lay_out(group);
        self.store_node_normals(group);
        self.position_solver = PositionSolver::Dual;
        let on_forces = if self.is_dual_affordable(group) { self.solve_positions_dual(group, h, rough) } else { None };
        on_forces.unwrap_or_else(|| {
            self.position_solver = PositionSolver::Primal;
            let factors = self.counters.factors;
            let settled = self.solve_positions_primal(group, h, rough);
            let size = self.detected.contacts.len() + group.nodes();
            self.work += (self.counters.factors - factors) * size as u64;
            settled
                || group.sheets.len() == 1 && {
                    self.position_solver = PositionSolver::Dual;
                    self.retry_positions_dual(group, h, rough)
                }
        })
    }

    /// Whether the problem has attachments and no contacts.
    pub(crate) fn has_only_attachments(&self) -> bool {
        self.detected.first_attachment == 0 && !self.detected.contacts.is_empty()
    }

    /// Whether the work budget of the step is spent.
    pub fn is_work_budget_spent(&self) -> bool {
        self.work
            > if self.has_only_fixed_bodies { SETTINGS.maximum_work_of_single_sheet } else { SETTINGS.maximum_work }
    }

    /// Begin the outer iteration of a stage.
    pub(crate) fn begin_outer_iteration(&mut self) {
        self.is_explicit = false;
        self.has_crossed = false;
        self.crossed_contacts.clear();
        self.open_keys.clear();
    }

    /// Whether a contact was open by more than [`ContactSettings::impact_distance`] and would
    /// penetrate by more than that.
    /// The linearisation of this outer iteration is then far from the solution.
    pub(crate) fn is_impact(&self, group: &IslandView) -> bool {
        self.detected.contacts.iter().any(|c| {
            gap(group, c, StagePose::Free) < -SETTINGS.impact_distance
                && gap(group, c, StagePose::Start) > SETTINGS.impact_distance
        })
    }

    /// Deepest penetration of a node in a body surface at the start of the stage, m.
    pub(crate) fn initial_penetration(&self, group: &IslandView) -> f64 {
        let surfaces =
            self.detected.contacts[..self.detected.first_attachment].iter().filter(|c| is_node_surface_contact(&c.key));
        surfaces.map(|c| -gap(group, c, StagePose::Start)).fold(0.0, f64::max)
    }

    /// The sheet that started with at least half of its nodes deep inside bodies, if any. Only a
    /// scene edit can put a sheet there.
    pub(crate) fn initially_buried_sheet(&self, group: &IslandView) -> Option<u32> {
        let is_deep = |c: &&ContactConstraint| {
            let ContactSide::Sheet { sheet, point } = &c.a else { return false };
            let sheet = group.sheet(*sheet);
            // Only contacts of nodes with faces count: corners and edges may lie behind each
            // other's planes without overlap.
            let depth = -gap(group, c, StagePose::Start);
            // A node that a body passes by is behind its far side at the start and outside at the
            // end.
            depth > SETTINGS.buried_depth * sheet.initial_diagonal
                && -gap(group, c, StagePose::Free) > 0.5 * depth
                && is_node_surface_contact(&c.key)
                && point.terms().all(|(i, _)| !sheet.is_held(i as usize))
        };
        let deep = || self.detected.contacts[..self.detected.first_attachment].iter().filter(is_deep);
        let ContactSide::Sheet { sheet: first, .. } = deep().next()?.a else { return None };
        // A body that passes by in the step has some nodes behind its far side, but fewer than
        // half.
        let of_first = |c: &&ContactConstraint| matches!(c.a, ContactSide::Sheet { sheet, .. } if sheet == first);
        (2 * deep().filter(of_first).count() >= group.sheet(first).node_count()).then_some(first)
    }

    /// Law of contact `i`: Coulomb friction, or bilateral for an attachment.
    pub(crate) fn law(&self, i: usize) -> ContactLaw {
        if i >= self.detected.first_attachment {
            ContactLaw::Attachment
        } else {
            ContactLaw::Coulomb(self.detected.contacts[i].friction)
        }
    }

    /// Relative position u of contact `i` in `frame` after the free motion, m: normal gap, and the
    /// tangential displacement that friction opposes.
    pub(crate) fn relative_position(&self, group: &IslandView, i: usize, frame: &DMat3) -> DVec3 {
        let contact = &self.detected.contacts[i];
        let end = position(group, &contact.a, StagePose::Free) - position(group, &contact.b, StagePose::Free);
        if i >= self.detected.first_attachment {
            return frame.transpose() * end;
        }
        let start = position(group, &contact.a, StagePose::Start) - position(group, &contact.b, StagePose::Start);
        let along = frame.transpose() * (end - start) * (1.0 - self.gaps.open_fraction(i));
        DVec3::new(self.gaps.free[i], along.y, along.z)
    }

    /// Relative velocity u of contact `i` in `frame` after the free motion, with the restitution
    /// target added, m/s. `None` if the contact is open.
    pub(crate) fn relative_velocity(&self, group: &IslandView, i: usize, frame: &DMat3) -> Option<DVec3> {
        let contact = &self.detected.contacts[i];
        let free = velocity(group, &contact.a, StagePose::Free) - velocity(group, &contact.b, StagePose::Free);
        let mut u = frame.transpose() * free;
        if i < self.detected.first_attachment {
            if self.gaps.now[i] > SETTINGS.closed_gap {
                return None;
            }
            let start = velocity(group, &contact.a, StagePose::Start) - velocity(group, &contact.b, StagePose::Start);
            let airborne = self.gaps.open_fraction(i);
            let approach = (1.0 - airborne) * start.dot(contact.normal) + airborne * u.x;
            if approach < -SETTINGS.restitution_speed {
                u.x += contact.restitution * approach;
            }
        }
        Some(u)
    }

    /// Solve the positions by PGS: coarsely while the working set grows, then to the tolerance.
    fn solve_positions_by_pgs(&mut self, group: &mut IslandView, h: f64) {
        let mut dual = std::mem::take(&mut self.pgs);
        dual.begin(self, group, h);
        let mut rough = true;
        let settled = loop {
            dual.b.clear();
            for k in 0..dual.delassus.problem.len() {
                let u = self.relative_position(group, dual.delassus.contact(k), &dual.delassus.frame(k));
                dual.b.push(u);
            }
            // Approximate forces are accurate enough to extend the working set.
            let swept = if rough { dual.sweep_roughly() } else { dual.sweep() };
            self.counters.sweeps += u64::from(swept.sweeps);
            self.work += u64::from(swept.sweeps) * dual.delassus.problem.len() as u64;
            dual.delassus.displace(group, &self.detected.contacts, h);
            self.gaps.update(&self.detected.contacts, group);
            if !dual.extend(self, group, h) {
                if !rough || swept.change <= PGS.tolerance {
                    break swept.change <= PGS.tolerance;
                }
                rough = false;
            }
        };
        self.counters.unsettled += u64::from(!settled);
        let contacts = &self.detected.contacts;
        self.cache.replace(|old, new| {
            new.extend(dual.forces().map(|(c, position)| {
                let key = contacts[c].key;
                (key, CachedForces { position, ..old.of(&key).unwrap_or_default() })
            }));
        });
        self.pgs = dual;
    }

    /// Solve the velocities of the contacts that the PGS position solve left active.
    fn solve_velocities_by_pgs(&mut self, group: &mut IslandView, h: f64) {
        let mut dual = std::mem::take(&mut self.pgs);
        dual.b.clear();
        for k in 0..dual.delassus.problem.len() {
            let i = dual.delassus.contact(k);
            let frame = dual.delassus.frame(k);
            let u = self.relative_velocity(group, i, &frame);
            let force = self.cached_forces(&self.detected.contacts[i].key).map_or(DVec3::ZERO, |f| f.velocity);
            dual.delassus.problem.force[k] = if u.is_some() { frame.transpose() * force } else { DVec3::ZERO };
            dual.b.push(u.map_or(DVec3::new(f64::INFINITY, 0.0, 0.0), |u| u * h));
        }
        let swept = dual.sweep();
        self.counters.sweeps += u64::from(swept.sweeps);
        self.counters.unsettled += u64::from(swept.change > PGS.tolerance);
        dual.delassus.apply_velocity_jumps(group, &self.detected.contacts, h);
        let contacts = &self.detected.contacts;
        self.cache.replace(|old, new| {
            new.extend(dual.forces().map(|(c, velocity)| {
                let key = contacts[c].key;
                (key, CachedForces { velocity, ..old.of(&key).unwrap_or_default() })
            }));
        });
        self.pgs = dual;
    }

    /// Solve the velocities of the contacts that the last position solve closed, in a stage of
    /// weight `h` (s). The velocity jumps are left in the contact arrays of the sheets and in the
    /// solver bodies.
    pub fn solve_velocities(&mut self, group: &mut IslandView, h: f64) {
        if self.position_solver != PositionSolver::Pgs {
            let settled = match self.position_solver {
                PositionSolver::Dual => self.solve_velocities_dual(group, h),
                _ => {
                    self.solve_velocities_primal(group, h)
                        || self.transfer_to_dual(group, h) && self.solve_velocities_dual(group, h)
                }
            };
            if settled || !self.accepts_unconverged || !self.has_only_fixed_bodies {
                self.solve_failed = !settled && !self.accepts_unconverged;
                return;
            }
            group.for_each_sheet(|sheet| sheet.restore_factor());
            let mut dual = std::mem::take(&mut self.pgs);
            dual.begin_closed(self, group, h);
            self.pgs = dual;
        }
        self.solve_velocities_by_pgs(group, h);
    }

    /// Deepest penetration into a body at the iterate, m, of the contacts that `detect` detects.
    pub fn deepest_penetration(
        &mut self,
        group: &IslandView,
        detect: impl FnOnce(&IslandView, &mut DetectedContacts),
    ) -> f64 {
        detect(group, &mut self.rechecked);
        self.rechecked.remove_opposed(group, &self.cache);
        convergence::deepest_body_penetration(group, &self.rechecked.contacts[..self.rechecked.first_attachment])
    }

    /// Force of a contact in the last position solve, N; `None` if it was open.
    pub(crate) fn force_of(&self, key: &ContactKey) -> Option<DVec3> {
        self.cache.of(key).map(|r| r.position)
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
    pub fn support_of(&self, body: u32, movers: &[SolverBody]) -> Support {
        let mut support = Support::default();
        let is_it = |side: &ContactSide| matches!(side, ContactSide::Body { body: other, .. } if *other == body);
        let spin_of = |side: &ContactSide| match side {
            ContactSide::Body { body, .. } => {
                movers.get(*body as usize).filter(|mover| !mover.is_dynamic()).map(|mover| mover.start.spin())
            }
            ContactSide::Sheet { .. } => Some(DVec3::ZERO),
        };
        let all = self.detected.contacts[..self.detected.first_attachment].iter().zip(&self.gaps.now);
        for (contact, _) in all.filter(|(_, gap)| **gap < 2.0 * SETTINGS.closed_gap) {
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

    /// Call `touched` for every closed contact, with the index of its collider in the island.
    pub fn for_each_closed(&self, mut touched: impl FnMut(&ContactConstraint, u32)) {
        let all = self.detected.contacts.iter().zip(&self.gaps.now).zip(&self.detected.colliders);
        for ((contact, _), part) in all.filter(|((_, gap), _)| **gap < 2.0 * SETTINGS.closed_gap) {
            touched(contact, *part);
        }
    }
}
