//! One step of an island with sheets of explicit integrators.
//!
//! Each sheet is first advanced alone: its integrator takes it through the step, and contact of
//! nodes with static and kinematic bodies is resolved node by node
//! ([`crate::contact::node::detection`]). All other contacts are resolved at the end of the step:
//! edges and corners of bodies, dynamic bodies, other sheets and self-contact, by the contact
//! constraints and the two solves of implicit integrators ([`crate::contact::stage`]), with the
//! node masses as system matrix. A sheet near none of these costs a few box tests. A sheet with an
//! implicit integrator in the same island is treated in the same way.

#[cfg(test)]
mod tests;

use crate::parallel::*;
use glam::DVec3;

use crate::collision::narrow_phase::Scope;
use crate::contact::outer_iteration::{Look, Margins, solve_masses};
use crate::contact::{Group, SheetContact};
use crate::islands::event::Touches;
use crate::islands::implicit_step::Find;
use crate::islands::island_detection::Near;
use crate::islands::island_manager::{Claim, IslandState, Shared, SteppedSheets};
use crate::islands::settings::{IslandSettings, StepSettings};
use crate::islands::{fly, instability, land};
use crate::sheet::{LED, Sheet, Status};

const SETTINGS: IslandSettings = StepSettings::DEFAULT.islands;

impl Shared<'_> {
    /// Step the island of `members` of `sheets`; the first of `sheets` has index `first` in the
    /// world.
    pub fn step_explicit(
        &self,
        mut all: SteppedSheets,
        state: &mut Option<Box<IslandState>>,
        (members, first): (&[u32], u32),
        parallel: bool,
        claims: &mut Vec<Claim>,
    ) {
        let [only] = members else {
            self.fly_all(&mut all, members, parallel);
            self.meet(&mut all, state, (members, first), parallel, claims);
            return;
        };
        let index = *only as usize;
        instability::open(&mut all.sheets[index]);
        let last = fly(&mut all.sheets[index], &mut all.contacts[index], &mut all.touches[index], self.stage);
        if all.sheets[index].status != Status::Awake {
            return;
        }
        let near = self.is_near(&all.sheets[index], &mut all.contacts[index]);
        if !(near && self.meet(&mut all, state, (members, first), parallel, claims)) {
            let SteppedSheets { sheets, touches, .. } = all;
            if sheets[index].work.touching.contains(&true) {
                instability::close(&mut sheets[index], &mut touches[index], self.stage, 0.0);
            }
            land(&mut sheets[index], &mut touches[index], self.stage, last);
        }
    }

    fn fly_all(&self, all: &mut SteppedSheets, members: &[u32], parallel: bool) {
        type One<'a> = ((&'a mut Sheet, &'a mut SheetContact), &'a mut Touches);
        let one = |(i, ((sheet, contact), touches)): (usize, One)| {
            if members.binary_search(&(i as u32)).is_ok() {
                instability::open(sheet);
                fly(sheet, contact, touches, self.stage);
            }
        };
        if parallel {
            let all = all.sheets.par_iter_mut().zip(all.contacts.par_iter_mut()).zip(all.touches.par_iter_mut());
            all.enumerate().for_each(one);
        } else {
            let all = all.sheets.iter_mut().zip(all.contacts.iter_mut()).zip(all.touches.iter_mut());
            all.enumerate().for_each(one);
        }
    }

    /// Whether a single sheet may have contacts beyond those of its nodes with static bodies: a
    /// dynamic body near its path, attachments, and for one layer edges or self-contact. Lattices
    /// of several layers meet static bodies with their nodes alone: the many constraints along a
    /// ridge keep their coarse steps from resting.
    fn is_near(&self, sheet: &Sheet, contact: &mut SheetContact) -> bool {
        contact.prepare_surface(sheet);
        let stack = contact.surface.as_ref().is_some_and(|s| s.is_stack());
        if !stack || sheet.is_glued() {
            return true;
        }
        let room = sheet.contact_offset() + SETTINGS.broad_phase_margin;
        let Some((low, high)) = swept(sheet, room) else { return false };
        self.surroundings.parts.iter().any(|part| {
            let gives = self.surroundings.bodies.get(part.body as usize).is_some_and(|b| b.start.gives());
            gives && part.low.cmple(high).all() && part.high.cmpge(low).all()
        })
    }

    /// Resolve contacts at the end of the step with dynamic bodies, sharp features and sheets, and
    /// end the step. Returns `false`, without changes, when a single sheet has no contact.
    fn meet(
        &self,
        all: &mut SteppedSheets,
        state: &mut Option<Box<IslandState>>,
        (members, first): (&[u32], u32),
        parallel: bool,
        claims: &mut Vec<Claim>,
    ) -> bool {
        if members.is_empty() {
            return false;
        }
        let SteppedSheets { sheets, contacts, touches } = all;
        let dt = self.stage.dt;
        for sheet in members.iter().map(|i| *i as usize) {
            // Adhesion is not supported with explicit integrators.
            sheets[sheet].unstick();
            contacts[sheet].prepare_surface(&sheets[sheet]);
            sheets[sheet].work.met.clear();
            sheets[sheet].begin_contact(dt);
        }
        let IslandState { contact: scratch, detection: work } = &mut **state.get_or_insert_default();
        let movers = std::mem::take(&mut scratch.movers);
        scratch.watch.clone_from(self.stage.watch);
        let mut group = Group { sheets, contacts, members, movers, parallel, lift: 0.0, leaning: 0 };
        let mut near = Near {
            view: self.stage.view,
            surroundings: self.surroundings,
            body_contacts: self.body_contacts,
            gravity: self.stage.field.gravity,
            sheets_meet: self.stage.sheets_meet,
            first,
            work: &mut *work,
            watch: self.stage.watch,
        };
        let idle = !self.begin(&mut near, &mut group);
        let touched = !idle && {
            near.begin_stage(&mut group, 0.0, dt);
            let touched = solve_masses(&mut group, scratch, dt, |group, found| {
                near.find(group, Look::First, Margins::NARROW, found)
            });
            near.end_stage(&mut group);
            touched
        };
        group.each_unit(|sheet, unit| {
            sheet.end_contact((touched && unit.is_touched()).then_some(&unit.jump));
        });
        let brought = brought(&group);
        let Group { sheets, movers, .. } = group;
        let lone = idle && members.len() == 1;
        let mut put_back = false;
        if !lone {
            for index in members.iter().map(|i| *i as usize) {
                if !touched && !sheets[index].work.touching.contains(&true) {
                    continue;
                }
                put_back |= instability::close(&mut sheets[index], &mut touches[index], self.stage, brought);
            }
        }
        let first_claim = claims.len();
        if idle || put_back {
            scratch.rest();
        } else {
            self.note(sheets, members, scratch, work);
            self.claim(&movers, work, scratch, claims);
        }
        if !lone {
            for sheet in members.iter().map(|i| *i as usize) {
                let work = &mut sheets[sheet].work;
                work.x_before.clone_from(&work.start.0);
            }
            self.finish(sheets, touches, members);
            if self.stage.sleep {
                self.fall_asleep(sheets, touches, members, &mut claims[first_claim..]);
            }
        }
        scratch.movers = movers;
        !lone
    }

    /// Begin detection for an island whose free motions are known. Returns `false` when contact is
    /// impossible.
    fn begin(&self, near: &mut Near, group: &mut Group) -> bool {
        let mut around = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut travel = 0.0_f64;
        for sheet in group.members.iter().map(|i| &group.sheets[*i as usize]) {
            let (low, high) = sheet.box_around();
            around = (around.0.min(low), around.1.max(high));
            travel = travel.max(sheet.travel());
        }
        let bodies = self.surroundings.bodies.iter().filter(|b| b.moves());
        let fastest = bodies.map(|b| b.start.velocity().length().max(b.end.velocity().length())).fold(0.0, f64::max);
        let reach = travel + fastest * self.stage.dt + SETTINGS.broad_phase_margin;
        // A lone sheet has resolved faces of static bodies in its free advance.
        near.work.limit(Scope { faces: false, stacks: false });
        near.begin(group, around, reach);
        let gives = group.movers.iter().any(|m| m.gives());
        if group.members.len() > 1 || gives || near.work.folds() {
            near.work.limit(Scope { faces: true, stacks: false });
            near.begin(group, around, reach);
        }
        !near.is_idle(group)
    }
}

/// Energy that contact partners could transfer to a sheet of the island, J: the kinetic energy of
/// dynamic bodies and other sheets, and the work of kinematic bodies. Zero when no sheet is
/// monitored.
fn brought(group: &Group) -> f64 {
    let sheets = || group.members.iter().map(|i| &group.sheets[*i as usize]);
    if !sheets().any(|s| s.guard.is_some()) {
        return 0.0;
    }
    let weight: f64 = sheets().map(Sheet::total_mass).sum();
    let bodies = group
        .movers
        .iter()
        .map(|m| if m.gives() { m.start.kinetic_energy() } else { weight * LED * m.start.velocity().length_squared() });
    let others = if group.members.len() > 1 { sheets().map(Sheet::energy_at_start).sum() } else { 0.0 };
    bodies.sum::<f64>() + others
}

/// Corners of the box that a sheet swept in the step, m, enlarged by `room` (m).
fn swept(sheet: &Sheet, room: f64) -> Option<(DVec3, DVec3)> {
    let (a, b) = sheet.work.start.0.bounds()?;
    let (c, d) = sheet.x.bounds()?;
    Some((a.min(c) - room, b.max(d) + room))
}
