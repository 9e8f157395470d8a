//! Contact solve of one stage of an implicit integrator: position solve, velocity solve, choice of
//! the solver.
//!
//! The outer iteration (`outer_iteration`) calls [`Scratch::solve_positions`] once per iteration.
//! The position solve finds forces that remove all penetration of the linearised free motion, with
//! friction against the tangential displacement. After the outer iteration,
//! [`Scratch::solve_velocities`] finds the velocity jumps of the contacts that are closed, with
//! restitution. Positions and velocities need separate solves: with a single one, a sheet that
//! should not rebound separates with two thirds of its approach speed.
//!
//! With α the fraction of the stage before a pair closes, friction acts against (1-α) times the
//! tangential displacement, and the approach speed at impact is
//!
//!   (1-α) times the speed at the start plus α times the free speed at the end.
//!
//! Lengths in m, speeds in m/s, forces in N.

use glam::{DMat3, DVec3};

use crate::collision::constraint::{Contact, Key, Side};
use crate::collision::narrow_phase::is_of_surface;
use crate::contact::convergence;
use crate::contact::coulomb::Law;
use crate::contact::detected::Found;
use crate::contact::gap::{At, Gaps, gap, place, velocity};
use crate::contact::settings::{ContactSettings, PgsSettings};
use crate::contact::solver::augmented_lagrangian::{Joint, Primal};
use crate::contact::solver::delassus::Group;
use crate::contact::solver::dual::Few;
use crate::contact::solver::node_sweeps::Dual;
use crate::contact::solver_body::Mover;
use crate::contact::warm_start::{Memory, Remembered};
use crate::profiler::{Phase, Watched};
use crate::rigid::Support;
use crate::serialize::{Keeper, Taken, Taker};

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
pub(crate) enum Solved {
    /// Dual solver: unknowns are the contact forces.
    #[default]
    OnForces,
    /// Primal solver: unknowns are the displacements of nodes and bodies.
    OnMasses,
    /// Projected Gauss-Seidel.
    BySweeps,
}

/// Contact problem of an island: detected contacts, contact cache, solvers and their arrays. It
/// lives from step to step.
#[derive(Default)]
pub(crate) struct Scratch {
    /// Contacts of this outer iteration.
    pub found: Found,
    /// Contacts of an additional detection: at the iterate, or with wider margins.
    pub seen: Found,
    /// Sheet-sheet contacts whose sides have passed through each other in the outer iterations so
    /// far.
    pub(crate) crossing: Vec<Contact>,
    /// Whether any sides passed through each other in the last outer iteration.
    pub crossed: bool,
    /// Contact cache of this stage of the step.
    pub memory: Memory,
    /// Storage of the solver bodies between steps; the island view takes them for a step.
    pub movers: Vec<Mover>,
    /// Contact cache of the other stages of the step. Forces differ more from stage to stage than
    /// from step to step.
    other: Memory,
    /// Stage that `memory` belongs to: 0, or 1 for all later stages.
    stage: usize,
    /// Contact caches at the start of the substep, for a rollback.
    kept_memory: [Memory; 2],
    /// Solver bodies at the start of the substep, for a rollback.
    pub kept_movers: Vec<Mover>,
    /// Counters of the contact solver.
    pub counters: ContactCounters,
    /// Profiler that measures the contact solve.
    pub watch: Watched,
    /// Gaps of `found`.
    pub(crate) gaps: Gaps,
    /// PGS solver.
    dual: Dual,
    /// Augmented Lagrangian solver, shared by the primal and the dual solver.
    pub(crate) primal: Primal,
    /// Joint tangent matrix of the island.
    pub(crate) joint: Joint,
    /// Working set of the solver, as indices into `found`.
    pub(crate) chosen: Vec<u32>,
    /// Whether each contact of `found` is in the working set of the primal solver.
    pub(crate) is_chosen: Vec<bool>,
    /// Keys of the contacts that the last position solve of this stage left open, in ascending
    /// order.
    pub(crate) left_open: Vec<Key>,
    /// Gap (m) below which a contact without a known force starts as closed.
    pub(crate) eager: f64,
    /// Solver of the last position solve; the velocity solve uses it too.
    pub(crate) solved: Solved,
    /// Dual solver.
    pub(crate) few: Few,
    /// Slots in the matrix of the block pairs of every constraint.
    pub(crate) slots: Vec<u32>,
    /// Whether the problem is a single sheet without self-contact.
    pub single: bool,
    /// Whether the problem is a single sheet on kinematic and static bodies only.
    pub(crate) alone: bool,
    /// Whether the sheet's own tangent matrix covers all constraints, so that no joint matrix is
    /// needed.
    pub(crate) on_own: bool,
    /// Contact normal of every node in contact with a body, by block row; zero without contact.
    pub(crate) normals: Vec<DVec3>,
    /// Whether a solve of the substep failed to converge.
    pub failed: bool,
    /// Whether an unconverged solution is accepted.
    pub last_resort: bool,
    /// Whether the substep is the shortest allowed one.
    pub last: bool,
    /// Work of the step so far, in node-iterations, compared to [`ContactSettings::maximum_work`].
    pub effort: u64,
    /// Bisection level at which the step of several sheets starts: one less than the deepest level
    /// of the previous step.
    pub expected: u32,
    /// Deepest bisection level attempted in this step.
    pub deepest: u32,
    /// Whether the step diverged beyond recovery; its remaining substeps are skipped.
    pub runaway: bool,
    /// Whether a substep of this step ended in a fallback.
    pub gave_up: bool,
    /// Whether a substep of the previous step ended in a fallback; the event is sent once per
    /// episode.
    pub told: bool,
    /// Consecutive steps that were rolled back after divergence.
    pub strays: u32,
    /// Consecutive steps with a fallback.
    pub stuck: u32,
    /// Whether this step was rolled back after divergence.
    pub strayed: bool,
    /// Solver bodies that move together with a sheet in the rigid-motion fallback.
    pub along: Vec<bool>,
    /// Energy error (J) that exceeded the available kinetic energy and is carried to the next
    /// steps.
    pub owed: f64,
    /// Whether the island uses explicit integrators.
    pub(crate) short_steps: bool,
    /// Contacts that were closed at the end of any stage of the step: sheet of the island, node,
    /// collider. A contact that rebounds within the step is open again at its end.
    pub met: Vec<[u32; 3]>,
}

impl Scratch {
    /// Measure `work` as part of the contact solve.
    pub fn watched<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let watch = self.watch.clone();
        watch.within(Phase::Contact, || work(self))
    }

    /// Save the contact caches and solver bodies for a rollback of the step.
    pub fn keep(&mut self, movers: &[Mover]) {
        self.begin_stage(0);
        self.kept_memory[0].copy_from(&self.memory);
        self.kept_memory[1].copy_from(&self.other);
        self.kept_movers.clear();
        self.kept_movers.extend_from_slice(movers);
        self.along.resize(movers.len(), false);
    }

    /// Record a fallback in this substep.
    pub fn note_given_up(&mut self) {
        self.counters.given_up += 1;
        self.gave_up = true;
    }

    /// Exchange `movers` with the saved solver bodies.
    pub fn swap_kept(&mut self, movers: &mut Vec<Mover>) {
        std::mem::swap(movers, &mut self.kept_movers);
    }

    /// Reset after a step without any possible contact.
    pub fn rest(&mut self) {
        (self.gave_up, self.owed) = (false, 0.0);
        self.found.forget();
        self.memory.clear();
        self.other.clear();
    }

    /// Begin stage `k` of a step: select its contact cache (one for stage 0, one for all others).
    pub fn begin_stage(&mut self, k: usize) {
        if k.min(1) != self.stage {
            std::mem::swap(&mut self.memory, &mut self.other);
            self.stage = k.min(1);
        }
    }

    /// Cached forces of a contact, from this stage or, if absent, from the other one.
    pub(crate) fn remembered(&self, key: &Key) -> Option<Remembered> {
        self.memory.of(key).or_else(|| self.other.of(key))
    }

    /// Serialise the state that persists between steps.
    pub fn save(&self, to: &mut Keeper) {
        let flags = [self.single, self.alone, self.on_own, self.failed, self.last_resort, self.last];
        flags.into_iter().chain([self.runaway, self.strayed, self.short_steps, self.gave_up]).for_each(|f| to.flag(f));
        for count in [self.stage as u32, self.expected, self.deepest, self.strays, self.stuck] {
            to.count(u64::from(count));
        }
        to.numbers(&[self.eager, self.owed]);
        let c = &self.counters;
        for count in [c.rounds, c.contacts, c.most, c.unsettled, c.sweeps, c.newton, c.factors, c.halved, c.given_up] {
            to.count(count);
        }
        self.memory.keep(to);
        self.other.keep(to);
        self.joint.keep(to);
    }

    /// Deserialise the state that persists between steps.
    pub fn take(&mut self, from: &mut Taker) -> Taken {
        (self.single, self.alone, self.on_own) = (from.flag()?, from.flag()?, from.flag()?);
        (self.failed, self.last_resort, self.last) = (from.flag()?, from.flag()?, from.flag()?);
        (self.runaway, self.strayed, self.short_steps) = (from.flag()?, from.flag()?, from.flag()?);
        self.gave_up = from.flag()?;
        self.stage = from.index(2)? as usize;
        (self.expected, self.deepest, self.strays) = (from.small()?, from.small()?, from.small()?);
        self.stuck = from.small()?;
        (self.eager, self.owed) = (from.number()?, from.number()?);
        let c = &mut self.counters;
        let counts = [&mut c.rounds, &mut c.contacts, &mut c.most, &mut c.unsettled, &mut c.sweeps, &mut c.newton];
        for count in counts.into_iter().chain([&mut c.factors, &mut c.halved, &mut c.given_up]) {
            *count = from.count()?;
        }
        self.memory.take(from)?;
        self.other.take(from)?;
        self.joint.take(from)?;
        self.found = Found::default();
        self.primal.clear();
        self.chosen.clear();
        self.solved = Solved::OnForces;
        Ok(())
    }

    /// Restore the contact caches and solver bodies that were saved.
    pub fn put_back(&mut self, movers: &mut Vec<Mover>) {
        self.stage = 0;
        self.memory.copy_from(&self.kept_memory[0]);
        self.other.copy_from(&self.kept_memory[1]);
        movers.clear();
        movers.extend_from_slice(&self.kept_movers);
    }

    /// Remove the penetration of the free motion, in a stage of weight `h` (s). The displacements
    /// are left in the contact arrays of the sheets and in the solver bodies. `rough` lowers the
    /// accuracy. Returns false if nothing overlaps.
    pub(crate) fn solve_positions(&mut self, group: &mut Group, h: f64, rough: bool) -> bool {
        self.gaps.measure(&self.found.contacts, group);
        if self.found.glue_from >= self.found.contacts.len() && self.gaps.free.iter().all(|g| *g >= 0.0) {
            if !self.short_steps {
                self.forget_solution(group);
            }
            return false;
        }
        if self.short_steps {
            self.positions_between(group, h);
            self.solved = Solved::BySweeps;
        } else if !self.positions_by_newton(group, h, rough) {
            if !self.last_resort {
                self.failed = true;
                return true;
            }
            // An unconverged solution of several sheets is good enough for the next outer
            // iteration, and another solver takes too long.
            if self.alone {
                // The primal solver has left contact in the factor.
                group.each(|sheet| sheet.restore_factor());
                self.positions_between(group, h);
                self.solved = Solved::BySweeps;
            }
        }
        let count = match self.solved {
            Solved::BySweeps => self.dual.delassus.problem.len(),
            _ => self.chosen.len(),
        };
        self.gaps.update(&self.found.contacts, group);
        self.counters.rounds += 1;
        self.counters.contacts += count as u64;
        self.counters.most = self.counters.most.max(count as u64);
        true
    }

    /// Position solve: dual solver for a small working set, otherwise primal solver, and for a
    /// single sheet the dual solver again if the primal one fails. Returns false if none converges.
    fn positions_by_newton(&mut self, group: &mut Group, h: f64, rough: bool) -> bool {
        let within = |c: &Contact| matches!((c.a, c.b), (Side::Sheet { .. }, Side::Sheet { .. }));
        let is_folded = group.members.len() == 1 && self.found.contacts.iter().any(within);
        self.single = group.members.len() == 1 && !is_folded;
        self.alone = group.members.len() == 1 && group.movers.iter().all(|m| !m.gives());
        self.joint.lay_out(group);
        self.note_masses(group);
        self.solved = Solved::OnForces;
        let on_forces = if self.are_few(group) { self.positions_on_few(group, h, rough) } else { None };
        on_forces.unwrap_or_else(|| {
            self.solved = Solved::OnMasses;
            let factors = self.counters.factors;
            let settled = self.positions_on_masses(group, h, rough);
            let size = self.found.contacts.len() + group.masses();
            self.effort += (self.counters.factors - factors) * size as u64;
            settled
                || group.members.len() == 1 && {
                    self.solved = Solved::OnForces;
                    self.positions_on_forces_after_all(group, h, rough)
                }
        })
    }

    /// Whether the problem has attachments and no contacts.
    pub(crate) fn is_glue_alone(&self) -> bool {
        self.found.glue_from == 0 && !self.found.contacts.is_empty()
    }

    /// Whether the work budget of the step is spent.
    pub fn is_spent(&self) -> bool {
        self.effort > if self.alone { SETTINGS.maximum_work_of_single_sheet } else { SETTINGS.maximum_work }
    }

    /// Begin the outer iteration of a stage.
    pub(crate) fn begin_rounds(&mut self) {
        self.short_steps = false;
        self.crossed = false;
        self.crossing.clear();
        self.left_open.clear();
    }

    /// Whether a contact was open by more than [`ContactSettings::impact_distance`] and would
    /// penetrate by more than that.
    /// The linearisation of this outer iteration is then far from the solution.
    pub(crate) fn is_impact(&self, group: &Group) -> bool {
        self.found.contacts.iter().any(|c| {
            gap(group, c, At::Free) < -SETTINGS.impact_distance && gap(group, c, At::Start) > SETTINGS.impact_distance
        })
    }

    /// Deepest penetration of a node in a body surface at the start of the stage, m.
    pub(crate) fn overlapped(&self, group: &Group) -> f64 {
        let surfaces = self.found.contacts[..self.found.glue_from].iter().filter(|c| is_of_surface(&c.key));
        surfaces.map(|c| -gap(group, c, At::Start)).fold(0.0, f64::max)
    }

    /// The sheet that started with at least half of its nodes deep inside bodies, if any. Only a
    /// scene edit can put a sheet there.
    pub(crate) fn buried(&self, group: &Group) -> Option<u32> {
        let is_deep = |c: &&Contact| {
            let Side::Sheet { sheet, point } = &c.a else { return false };
            let sheet = group.sheet(*sheet);
            // Only contacts of nodes with faces count: corners and edges may lie behind each
            // other's planes without overlap.
            let depth = -gap(group, c, At::Start);
            // A node that a body passes by is behind its far side at the start and outside at the
            // end.
            depth > SETTINGS.buried_depth * sheet.spread
                && -gap(group, c, At::Free) > 0.5 * depth
                && is_of_surface(&c.key)
                && point.terms().all(|(i, _)| !sheet.is_held(i as usize))
        };
        let deep = || self.found.contacts[..self.found.glue_from].iter().filter(is_deep);
        let Side::Sheet { sheet: first, .. } = deep().next()?.a else { return None };
        // A body that passes by in the step has some nodes behind its far side, but fewer than
        // half.
        let of_first = |c: &&Contact| matches!(c.a, Side::Sheet { sheet, .. } if sheet == first);
        (2 * deep().filter(of_first).count() >= group.sheet(first).masses()).then_some(first)
    }

    /// Law of contact `i`: Coulomb friction, or bilateral for an attachment.
    pub(crate) fn law(&self, i: usize) -> Law {
        if i >= self.found.glue_from { Law::Glue } else { Law::Coulomb(self.found.contacts[i].friction) }
    }

    /// Relative position u of contact `i` in `frame` after the free motion, m: normal gap, and the
    /// tangential displacement that friction opposes.
    pub(crate) fn position_of(&self, group: &Group, i: usize, frame: &DMat3) -> DVec3 {
        let contact = &self.found.contacts[i];
        let end = place(group, &contact.a, At::Free) - place(group, &contact.b, At::Free);
        if i >= self.found.glue_from {
            return frame.transpose() * end;
        }
        let start = place(group, &contact.a, At::Start) - place(group, &contact.b, At::Start);
        let along = frame.transpose() * (end - start) * (1.0 - self.gaps.airborne(i));
        DVec3::new(self.gaps.free[i], along.y, along.z)
    }

    /// Relative velocity u of contact `i` in `frame` after the free motion, with the restitution
    /// target added, m/s. `None` if the contact is open.
    pub(crate) fn velocity_of(&self, group: &Group, i: usize, frame: &DMat3) -> Option<DVec3> {
        let contact = &self.found.contacts[i];
        let free = velocity(group, &contact.a, At::Free) - velocity(group, &contact.b, At::Free);
        let mut u = frame.transpose() * free;
        if i < self.found.glue_from {
            if self.gaps.now[i] > SETTINGS.closed_gap {
                return None;
            }
            let start = velocity(group, &contact.a, At::Start) - velocity(group, &contact.b, At::Start);
            let airborne = self.gaps.airborne(i);
            let approach = (1.0 - airborne) * start.dot(contact.normal) + airborne * u.x;
            if approach < -SETTINGS.restitution_speed {
                u.x += contact.restitution * approach;
            }
        }
        Some(u)
    }

    /// Solve the positions by PGS: coarsely while the working set grows, then to the tolerance.
    fn positions_between(&mut self, group: &mut Group, h: f64) {
        let mut dual = std::mem::take(&mut self.dual);
        dual.begin(self, group, h);
        let mut rough = true;
        let settled = loop {
            dual.b.clear();
            for k in 0..dual.delassus.problem.len() {
                let u = self.position_of(group, dual.delassus.contact(k), &dual.delassus.frame(k));
                dual.b.push(u);
            }
            // Approximate forces are accurate enough to extend the working set.
            let swept = if rough { dual.sweep_roughly() } else { dual.sweep() };
            self.counters.sweeps += u64::from(swept.sweeps);
            self.effort += u64::from(swept.sweeps) * dual.delassus.problem.len() as u64;
            dual.delassus.displace(group, &self.found.contacts, h);
            self.gaps.update(&self.found.contacts, group);
            if !dual.grow(self, group, h) {
                if !rough || swept.change <= PGS.tolerance {
                    break swept.change <= PGS.tolerance;
                }
                rough = false;
            }
        };
        self.counters.unsettled += u64::from(!settled);
        let contacts = &self.found.contacts;
        self.memory.replace(|old, new| {
            new.extend(dual.forces().map(|(c, position)| {
                let key = contacts[c].key;
                (key, Remembered { position, ..old.of(&key).unwrap_or_default() })
            }));
        });
        self.dual = dual;
    }

    /// Solve the velocities of the contacts that the PGS position solve left active.
    fn velocities_between(&mut self, group: &mut Group, h: f64) {
        let mut dual = std::mem::take(&mut self.dual);
        dual.b.clear();
        for k in 0..dual.delassus.problem.len() {
            let i = dual.delassus.contact(k);
            let frame = dual.delassus.frame(k);
            let u = self.velocity_of(group, i, &frame);
            let force = self.remembered(&self.found.contacts[i].key).map_or(DVec3::ZERO, |f| f.velocity);
            dual.delassus.problem.force[k] = if u.is_some() { frame.transpose() * force } else { DVec3::ZERO };
            dual.b.push(u.map_or(DVec3::new(f64::INFINITY, 0.0, 0.0), |u| u * h));
        }
        let swept = dual.sweep();
        self.counters.sweeps += u64::from(swept.sweeps);
        self.counters.unsettled += u64::from(swept.change > PGS.tolerance);
        dual.delassus.kick(group, &self.found.contacts, h);
        let contacts = &self.found.contacts;
        self.memory.replace(|old, new| {
            new.extend(dual.forces().map(|(c, velocity)| {
                let key = contacts[c].key;
                (key, Remembered { velocity, ..old.of(&key).unwrap_or_default() })
            }));
        });
        self.dual = dual;
    }

    /// Solve the velocities of the contacts that the last position solve closed, in a stage of
    /// weight `h` (s). The velocity jumps are left in the contact arrays of the sheets and in the
    /// solver bodies.
    pub fn solve_velocities(&mut self, group: &mut Group, h: f64) {
        if self.solved != Solved::BySweeps {
            let settled = match self.solved {
                Solved::OnForces => self.velocities_on_forces(group, h),
                _ => {
                    self.velocities_on_masses(group, h)
                        || self.take_to_forces(group, h) && self.velocities_on_forces(group, h)
                }
            };
            if settled || !self.last_resort || !self.alone {
                self.failed = !settled && !self.last_resort;
                return;
            }
            group.each(|sheet| sheet.restore_factor());
            let mut dual = std::mem::take(&mut self.dual);
            dual.begin_closed(self, group, h);
            self.dual = dual;
        }
        self.velocities_between(group, h);
    }

    /// Deepest penetration into a body at the iterate, m, of the contacts that `find` detects.
    pub fn overlap(&mut self, group: &Group, find: impl FnOnce(&Group, &mut Found)) -> f64 {
        find(group, &mut self.seen);
        self.seen.leave_out_opposed(group, &self.memory);
        convergence::deepest(group, &self.seen.contacts[..self.seen.glue_from])
    }

    /// Force of a contact in the last position solve, N; `None` if it was open.
    pub(crate) fn force_of(&self, key: &Key) -> Option<DVec3> {
        self.memory.of(key).map(|r| r.position)
    }

    /// Record the contacts that are closed at the end of a stage.
    pub fn note_met(&mut self) {
        let mut met = std::mem::take(&mut self.met);
        self.closed(|contact, part| {
            for side in [contact.a, contact.b] {
                if let Side::Sheet { sheet, point } = side {
                    met.extend(point.terms().map(|(mass, _)| [sheet, mass, part]));
                }
            }
        });
        self.met = met;
    }

    /// Support of body `body` of the island: sheets and kinematic or static bodies that carry it.
    /// Dynamic bodies are left out because rolling resistance would have to turn them too.
    pub fn support_of(&self, body: u32, movers: &[Mover]) -> Support {
        let mut support = Support::default();
        let is_it = |side: &Side| matches!(side, Side::Body { body: other, .. } if *other == body);
        let spin_of = |side: &Side| match side {
            Side::Body { body, .. } => {
                movers.get(*body as usize).filter(|mover| !mover.gives()).map(|mover| mover.start.spin())
            }
            Side::Sheet { .. } => Some(DVec3::ZERO),
        };
        let all = self.found.contacts[..self.found.glue_from].iter().zip(&self.gaps.now);
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
    pub fn closed(&self, mut touched: impl FnMut(&Contact, u32)) {
        let all = self.found.contacts.iter().zip(&self.gaps.now).zip(&self.found.parts);
        for ((contact, _), part) in all.filter(|((_, gap), _)| **gap < 2.0 * SETTINGS.closed_gap) {
            touched(contact, *part);
        }
    }
}
