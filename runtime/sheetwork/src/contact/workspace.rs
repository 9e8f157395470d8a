//! Contact problem of an island: detected contacts, contact caches of its stages, solvers with
//! their arrays, counters and the course of the step.
//!
//! The workspace lives from step to step. Contact caches start the next solve; they and the solver
//! bodies are saved before a substep and restored when it is rolled back. The phases of contact add
//! their methods to it, each in a file of its own: `detected_contacts`, `relative_motion`,
//! `penetration`, `solver/choice` and the solvers, `closed_contacts`, `attachment_spin`.

use glam::DVec3;

use crate::collision::constraint::{ContactConstraint, ContactKey};
use crate::contact::barrier::BarrierSolver;
use crate::contact::contact_cache::{CachedForces, ContactCache};
use crate::contact::counters::ContactCounters;
use crate::contact::detected_contacts::DetectedContacts;
use crate::contact::gap::ContactGaps;
use crate::contact::impulse_log::ImpulseLog;
use crate::contact::settings::ContactSettings;
use crate::contact::solve_policy::SolvePolicy;
use crate::contact::solver::augmented_lagrangian::{AugmentedLagrangian, IslandTangent};
use crate::contact::solver::choice::PositionSolver;
use crate::contact::solver::dual::DualSolver;
use crate::contact::solver::lattice_sweeps::LatticeSweeps;
use crate::contact::solver::pgs_working_set::PgsContactSolver;
use crate::contact::solver_body::SolverBody;
use crate::profiler::{Phase, Profiler};
use crate::serialize::{ReadResult, State, StateReader, StateWriter};

const SETTINGS: ContactSettings = ContactSettings::DEFAULT;

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
    /// Whether a detected contact has a bond of an explicit integrator.
    pub(crate) has_bonds: bool,
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
    /// Barrier method; `None` until a substep needs it.
    pub(crate) barrier: Option<Box<BarrierSolver>>,
    /// PGS solver.
    pub(crate) pgs: PgsContactSolver,
    /// Gauss-Seidel on the nodes of explicit lattices.
    pub(crate) lattice_sweeps: LatticeSweeps,
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
    /// Half the thickness of the thinnest sheet, to which tolerances refer, m: of the last position
    /// solve.
    pub(crate) half_thickness: f64,
    /// Gap (m) below which a contact without a known force starts as closed.
    pub(crate) closing_gap: f64,
    /// Solver of the last position solve; the velocity solve uses it too.
    pub(crate) position_solver: PositionSolver,
    /// Dual solver.
    pub(crate) dual: DualSolver,
    /// Slots in the matrix of the block pairs of every constraint.
    pub(crate) slots: Vec<u32>,
    /// Whether the problem is a single sheet without self-contact.
    pub is_single_unfolded_sheet: bool,
    /// Whether the problem is a single sheet on kinematic and static bodies only.
    pub(crate) is_single_sheet_on_fixed_bodies: bool,
    /// Whether the sheet's own tangent matrix covers all constraints, so that no joint matrix is
    /// needed.
    pub(crate) uses_sheet_tangent: bool,
    /// Contact normal of every node in contact with a body, by block row; zero without contact.
    pub(crate) normals: Vec<DVec3>,
    /// Demands on the solution of this substep.
    pub policy: SolvePolicy,
    /// Work of the step so far, in node-iterations, compared to [`ContactSettings::maximum_work`].
    pub work: u64,
    /// Work budget of the step; `None` for the default.
    pub budget: Option<u64>,
    /// Contacts that were closed at the end of any stage of the step: sheet of the island, node,
    /// collider. A contact that rebounds within the step is open again at its end.
    pub closed_in_step: Vec<[u32; 3]>,
    /// Impulses of the step, if forces are recorded.
    pub impulses: ImpulseLog,
}

impl ContactWorkspace {
    /// Measure `work` as part of the contact solve.
    pub fn profile<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let watch = self.profiler.clone();
        watch.measure(Phase::Contact, || work(self))
    }

    /// Begin a step.
    pub fn begin_step(&mut self) {
        self.work = 0;
        self.detected.clear();
    }

    /// Save the contact caches and solver bodies for a rollback of the step.
    pub fn save_for_rollback(&mut self, solver_bodies: &[SolverBody]) {
        self.begin_stage(0);
        self.saved_caches[0].copy_from(&self.cache);
        self.saved_caches[1].copy_from(&self.other_stage_cache);
        self.saved_solver_bodies.clear();
        self.saved_solver_bodies.extend_from_slice(solver_bodies);
        self.impulses.begin_substep();
    }

    /// Forget the contacts of the sheet `id`, whose removal lowers higher identifiers by one.
    pub fn remove_sheet(&mut self, id: u32) {
        self.cache.remove_sheet(id);
        self.other_stage_cache.remove_sheet(id);
    }

    /// Reset after a step without any possible contact.
    pub fn reset(&mut self) {
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
        [self.is_single_unfolded_sheet, self.is_single_sheet_on_fixed_bodies, self.uses_sheet_tangent].serialise(to);
        to.count(self.stage as u64);
        to.number(self.closing_gap);
        self.counters.serialise(to);
        self.cache.serialise(to);
        self.other_stage_cache.serialise(to);
        self.island_tangent.serialise(to);
    }

    /// Deserialise the state that persists between steps.
    pub fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        [self.is_single_unfolded_sheet, self.is_single_sheet_on_fixed_bodies, self.uses_sheet_tangent] = from.read()?;
        self.stage = from.index(2)? as usize;
        self.closing_gap = from.number()?;
        self.counters.deserialise(from)?;
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
    pub fn restore_saved(&mut self, solver_bodies: &mut Vec<SolverBody>) {
        self.stage = 0;
        self.impulses.roll_back();
        self.cache.copy_from(&self.saved_caches[0]);
        self.other_stage_cache.copy_from(&self.saved_caches[1]);
        solver_bodies.clear();
        solver_bodies.extend_from_slice(&self.saved_solver_bodies);
    }

    /// Whether the problem has attachments and no contacts.
    pub(crate) fn has_only_attachments(&self) -> bool {
        self.detected.first_attachment == 0 && !self.detected.contacts.is_empty()
    }

    /// Whether the work budget of the step is spent.
    pub fn is_work_budget_spent(&self) -> bool {
        self.work > self.work_budget()
    }

    /// Whether the work budget of the barrier method is spent: as much again as that of the scene.
    pub fn is_barrier_budget_spent(&self) -> bool {
        self.work > self.work_budget() + self.budget.unwrap_or(SETTINGS.maximum_work)
    }

    fn work_budget(&self) -> u64 {
        let default = match self.is_single_sheet_on_fixed_bodies {
            true => SETTINGS.maximum_work_of_single_sheet,
            false => SETTINGS.maximum_work,
        };
        self.budget.unwrap_or(default)
    }

    /// Begin the outer iteration of a stage.
    pub(crate) fn begin_outer_iteration(&mut self) {
        self.policy.is_explicit = false;
        self.has_crossed = false;
        self.crossed_contacts.clear();
        self.open_keys.clear();
    }

    /// Force of a contact in the last position solve, N; `None` if it was open.
    pub(crate) fn force_of(&self, key: &ContactKey) -> Option<DVec3> {
        self.cache.of(key).map(|r| r.position)
    }
}
