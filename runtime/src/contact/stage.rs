//! One stage of an implicit engine for sheets and bodies that touch.
//!
//! Rounds of: every sheet's free motion, linearised where it is; detection; a position solve, which puts everything that
//! would overlap just apart, with friction against the displacement; until the strain that comes of it is what the
//! linear solve predicted. Then a velocity solve on what is closed, with restitution as of the instant of impact.
//! Position and velocity need a solve each: by one alone a sheet that does not bounce leaves at two thirds of its speed.
//!
//! With α the part of the stage that a pair was apart, friction acts against 1-α of the tangential displacement, and the
//! speed of approach at the impact is (1-α) that at the start plus α the free one at the end.

use glam::{DMat3, DVec3};

use super::coulomb::Law;
use super::delassus::Group;
use super::dual::{ACCURACY, Dual};
use super::find::is_of_surface;
use super::found::Found;
use super::memory::{Memory, Remembered};
use super::mover::Mover;
use super::on_forces::Few;
use super::places::{At, Gaps, gap, place, velocity};
use super::primal::{Joint, Primal};
use super::rigid::Support;
use super::row::{Contact, Key, Side};
use super::settled;
use crate::kept::{Keeper, Taken, Taker};
use crate::watch::{Phase, Watched};

/// A contact this near is closed, m: its velocities are solved for.
pub(super) const CLOSED: f64 = 1e-5;
/// What comes from further apart than this to overlap by more is an impact, m: gravity alone does less in a stage.
const IMPACT: f64 = 2e-3;
/// A sheet deeper in a body than this part of its diagonal is not there by what a step left.
const BURIED: f64 = 0.1;
/// What a step may take before it is given up, in rounds times the masses there are, factors of contact's Newton steps on the masses times
/// these and the contacts, factors on forces (`on_forces`), and sweeps times the contacts: its rounds end, and the sheets stay where they are
/// for what is left of it. What has not settled by then does not, as sheets that are put through one another. The most of shipped scenes is
/// 2.5 million, when a ball flies into a house of fifteen cards.
const EFFORT: u64 = 4_000_000;
/// The same of one sheet on what does not give way. The most of shipped scenes is 120,000, when a film is drawn onto its mould.
const EFFORT_ALONE: u64 = 400_000;
/// Slower approaches do not bounce, m/s: what rests must not hop.
const BOUNCES_ABOVE: f64 = 0.2;

/// What contact has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ContactCounters {
    /// Rounds of stages that had contact.
    pub rounds: u64,
    /// Contacts there were, over all rounds.
    pub contacts: u64,
    /// The most at once.
    pub most: u64,
    /// Solves that did not settle.
    pub unsettled: u64,
    /// Sweeps over contacts.
    pub sweeps: u64,
    /// Newton steps on contacts, and factors they took.
    pub newton: u64,
    /// See `newton`.
    pub factors: u64,
    /// Steps that were halved.
    pub halved: u64,
    /// Parts of steps that contact was given up in: the sheets stayed where they were, or went on as one stiff body.
    pub given_up: u64,
}

/// How positions were solved for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Solved {
    /// On the forces of few contacts.
    #[default]
    OnForces,
    /// On the masses.
    OnMasses,
    /// By sweeps over contacts.
    BySweeps,
}

/// Arrays of a contact problem, kept from step to step.
#[derive(Default)]
pub(crate) struct Scratch {
    /// What may touch in this round, and what does where it has come to, or may where contact moves things further.
    pub found: Found,
    pub seen: Found,
    /// What of sheets has crossed in the rounds so far, and whether something has in the last.
    pub(super) crossing: Vec<Contact>,
    pub crossed: bool,
    pub memory: Memory,
    pub movers: Vec<Mover>,
    /// Memory of the other stage of a step: forces differ from stage to stage more than from step to step.
    other: Memory,
    stage: usize,
    kept_memory: [Memory; 2],
    pub kept_movers: Vec<Mover>,
    pub counters: ContactCounters,
    /// Who wants to know when contact is solved for.
    pub watch: Watched,
    pub(super) gaps: Gaps,
    dual: Dual,
    pub(super) primal: Primal,
    pub(super) joint: Joint,
    /// Contacts that may act, by number in `found`, and whether each is one of them.
    pub(super) chosen: Vec<u32>,
    pub(super) is_chosen: Vec<bool>,
    /// Contacts that the last solve for positions of this stage left open, in order.
    pub(super) left_open: Vec<Key>,
    /// Gap up to which what is new pushes for a beginning, m.
    pub(super) eager: f64,
    pub(super) solved: Solved,
    pub(super) few: Few,
    /// Where in the matrix the pairs of every row are.
    pub(super) slots: Vec<u32>,
    /// Whether the problem is of one sheet that is not folded on itself.
    pub single: bool,
    /// Whether its bodies do not give way either, and whether it is on the sheet's own matrix.
    pub(super) alone: bool,
    pub(super) on_own: bool,
    pub(super) normals: Vec<DVec3>,
    /// Whether a solve did not settle, whether what it came to is gone on from, and whether there is no shorter step to try.
    pub failed: bool,
    pub last_resort: bool,
    pub last: bool,
    /// What the step has taken so far, as [`EFFORT`] counts it.
    pub effort: u64,
    /// How often the steps of several sheets are halved before they are tried.
    pub expected: u32,
    pub deepest: u32,
    /// Whether the step has thrown a sheet about beyond help.
    pub runaway: bool,
    /// Whether contact was given up in a part of this step, and whether it was in the step before.
    pub gave_up: bool,
    pub told: bool,
    /// Steps on end in which it has been brought back from that, and whether it has in this one.
    pub strays: u32,
    /// Steps on end in which contact was given up.
    pub stuck: u32,
    pub strayed: bool,
    /// Which movers a sheet takes along that goes on as a stiff body.
    pub along: Vec<bool>,
    /// Energy that what is about to come to rest has from nowhere, and had no motion to take it from, J.
    pub owed: f64,
    /// Whether the group is of explicit engines.
    pub(super) short_steps: bool,
    /// What has been closed at the end of any stage of the step so far: sheet of the group, mass, part. What bounces is open again at its end.
    pub met: Vec<[u32; 3]>,
}

impl Scratch {
    /// Does `work`, a part of solving for contact.
    pub fn watched<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let watch = self.watch.clone();
        watch.within(Phase::Contact, || work(self))
    }

    /// Keeps what a step that is taken back must find again.
    pub fn keep(&mut self, movers: &[Mover]) {
        self.begin_stage(0);
        self.kept_memory[0].copy_from(&self.memory);
        self.kept_memory[1].copy_from(&self.other);
        self.kept_movers.clear();
        self.kept_movers.extend_from_slice(movers);
        self.along.resize(movers.len(), false);
    }

    /// Notes that contact is given up in a part of the step.
    pub fn note_given_up(&mut self) {
        self.counters.given_up += 1;
        self.gave_up = true;
    }

    /// Changes `movers` for those that were kept.
    pub fn swap_kept(&mut self, movers: &mut Vec<Mover>) {
        std::mem::swap(movers, &mut self.kept_movers);
    }

    /// After a step in which nothing could touch.
    pub fn rest(&mut self) {
        (self.gave_up, self.owed) = (false, 0.0);
        self.found.forget();
        self.memory.clear();
        self.other.clear();
    }

    /// Begins stage number `k` of a step.
    pub fn begin_stage(&mut self, k: usize) {
        if k.min(1) != self.stage {
            std::mem::swap(&mut self.memory, &mut self.other);
            self.stage = k.min(1);
        }
    }

    /// What is remembered of a contact: of this stage, or of the other one where it is new.
    pub(super) fn remembered(&self, key: &Key) -> Option<Remembered> {
        self.memory.of(key).or_else(|| self.other.of(key))
    }

    /// Keeps for a snapshot what a step takes over from those before it.
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

    /// Takes it back.
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

    /// Comes back to what was kept.
    pub fn put_back(&mut self, movers: &mut Vec<Mover>) {
        self.stage = 0;
        self.memory.copy_from(&self.kept_memory[0]);
        self.other.copy_from(&self.kept_memory[1]);
        movers.clear();
        movers.extend_from_slice(&self.kept_movers);
    }

    /// Puts apart what would overlap after the free motion, with weight `h` (s) of the stage: leaves displacements in the
    /// units of the sheets and in the movers. False when nothing overlaps.
    pub(super) fn solve_positions(&mut self, group: &mut Group, h: f64, rough: bool) -> bool {
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
            // What several sheets came to without settling is near enough to go on from, and another way would take too long.
            if self.alone {
                // Contact stands in the factor.
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

    /// Solves for positions on forces, or where those are many, on masses; false where that did not settle.
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

    /// Whether nothing that was found comes and goes: sheets and bodies that are glued together, and touch nothing.
    pub(super) fn is_glue_alone(&self) -> bool {
        self.found.glue_from == 0 && !self.found.contacts.is_empty()
    }

    /// Whether the step has taken as much as it may.
    pub fn is_spent(&self) -> bool {
        self.effort > if self.alone { EFFORT_ALONE } else { EFFORT }
    }

    /// Begins the rounds of a stage.
    pub(super) fn begin_rounds(&mut self) {
        self.short_steps = false;
        self.crossed = false;
        self.crossing.clear();
        self.left_open.clear();
    }

    /// Whether something that was apart would come to overlap by much, so that the sheet will not be where this round leaves it.
    pub(super) fn is_impact(&self, group: &Group) -> bool {
        self.found.contacts.iter().any(|c| gap(group, c, At::Free) < -IMPACT && gap(group, c, At::Start) > IMPACT)
    }

    /// How deep masses of the sheets were in surfaces where the stage began, m.
    pub(crate) fn overlapped(&self, group: &Group) -> f64 {
        let surfaces = self.found.contacts[..self.found.glue_from].iter().filter(|c| is_of_surface(&c.key));
        surfaces.map(|c| -gap(group, c, At::Start)).fold(0.0, f64::max)
    }

    /// A sheet that began deep within bodies with half of its masses or more, as it can only have been put there.
    pub(super) fn buried(&self, group: &Group) -> Option<u32> {
        let is_deep = |c: &&Contact| {
            let Side::Sheet { sheet, point } = &c.a else { return false };
            let sheet = group.sheet(*sheet);
            // Of a mass in a surface: corners and edges can be far behind one another's planes and yet apart.
            let depth = -gap(group, c, At::Start);
            // What a body passes is behind its far side at the start, and not any more once it has gone by.
            depth > BURIED * sheet.spread
                && -gap(group, c, At::Free) > 0.5 * depth
                && is_of_surface(&c.key)
                && point.terms().all(|(i, _)| !sheet.is_held(i as usize))
        };
        let deep = || self.found.contacts[..self.found.glue_from].iter().filter(is_deep);
        let Side::Sheet { sheet: first, .. } = deep().next()?.a else { return None };
        // A body that passes in a step is seen from behind by some.
        let of_first = |c: &&Contact| matches!(c.a, Side::Sheet { sheet, .. } if sheet == first);
        (2 * deep().filter(of_first).count() >= group.sheet(first).masses()).then_some(first)
    }

    pub(super) fn law(&self, i: usize) -> Law {
        if i >= self.found.glue_from { Law::Glue } else { Law::Coulomb(self.found.contacts[i].friction) }
    }

    /// u of contact `i` in `frame` after the free motion: its gap, and the displacement that friction acts against, m.
    pub(super) fn position_of(&self, group: &Group, i: usize, frame: &DMat3) -> DVec3 {
        let contact = &self.found.contacts[i];
        let end = place(group, &contact.a, At::Free) - place(group, &contact.b, At::Free);
        if i >= self.found.glue_from {
            return frame.transpose() * end;
        }
        let start = place(group, &contact.a, At::Start) - place(group, &contact.b, At::Start);
        let along = frame.transpose() * (end - start) * (1.0 - self.gaps.airborne(i));
        DVec3::new(self.gaps.free[i], along.y, along.z)
    }

    /// u of contact `i` in `frame` after the free motion: its velocity, with what it must bounce, m/s; `None` where it is not closed.
    pub(super) fn velocity_of(&self, group: &Group, i: usize, frame: &DMat3) -> Option<DVec3> {
        let contact = &self.found.contacts[i];
        let free = velocity(group, &contact.a, At::Free) - velocity(group, &contact.b, At::Free);
        let mut u = frame.transpose() * free;
        if i < self.found.glue_from {
            if self.gaps.now[i] > CLOSED {
                return None;
            }
            let start = velocity(group, &contact.a, At::Start) - velocity(group, &contact.b, At::Start);
            let airborne = self.gaps.airborne(i);
            let approach = (1.0 - airborne) * start.dot(contact.normal) + airborne * u.x;
            if approach < -BOUNCES_ABOVE {
                u.x += contact.restitution * approach;
            }
        }
        Some(u)
    }

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
            // Which contacts there are can be told from forces that are nearly right.
            let swept = if rough { dual.sweep_roughly() } else { dual.sweep() };
            self.counters.sweeps += u64::from(swept.sweeps);
            self.effort += u64::from(swept.sweeps) * dual.delassus.problem.len() as u64;
            dual.delassus.displace(group, &self.found.contacts, h);
            self.gaps.update(&self.found.contacts, group);
            if !dual.grow(self, group, h) {
                if !rough || swept.change <= ACCURACY {
                    break swept.change <= ACCURACY;
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

    /// Active contacts of [`Scratch::positions_between`] as they were, solved for velocities.
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
        self.counters.unsettled += u64::from(swept.change > ACCURACY);
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

    /// Solves for the velocities of what is closed after the last position solve; leaves jumps in the units and movers.
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

    /// Deepest overlap with a body where the rounds have come to, m, of what `find` writes.
    pub fn overlap(&mut self, group: &Group, find: impl FnOnce(&Group, &mut Found)) -> f64 {
        find(group, &mut self.seen);
        self.seen.leave_out_opposed(group, &self.memory);
        settled::deepest(group, &self.seen.contacts[..self.seen.glue_from])
    }

    /// The force between the two sides of a contact in the last position solve, N; none where there was none.
    pub(super) fn force_of(&self, key: &Key) -> Option<DVec3> {
        self.memory.of(key).map(|r| r.position)
    }

    /// Notes what is closed at the end of a stage.
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

    /// What body number `body` of a group of `movers` lies on: sheets, and bodies that do not give way. (One that does would be turned by
    /// what it brakes, which is left out.)
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
        for (contact, _) in all.filter(|(_, gap)| **gap < 2.0 * CLOSED) {
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

    /// Calls `touched` for every contact that is closed, with the part of the group it is with.
    pub fn closed(&self, mut touched: impl FnMut(&Contact, u32)) {
        let all = self.found.contacts.iter().zip(&self.gaps.now).zip(&self.found.parts);
        for ((contact, _), part) in all.filter(|((_, gap), _)| **gap < 2.0 * CLOSED) {
            touched(contact, *part);
        }
    }
}
