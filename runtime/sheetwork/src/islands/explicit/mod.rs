//! One step of sheets of explicit engines and of what they may touch.
//!
//! Each sheet flies by itself: its engine takes it through the step, and masses that meet a body that does not give way are
//! turned back one by one ([`crate::contact::node::detection`]). All else then happens at the end of the step: edges and corners of
//! bodies, bodies that give way, other sheets and the sheet itself, by the rows and the two solves that implicit engines have
//! ([`crate::contact::stage`]), where the masses answer each for itself. A sheet near none of these pays a few boxes. A sheet that goes
//! on with an implicit engine among these flies and meets as they do.

#[cfg(test)]
mod tests;

use glam::DVec3;
use rayon::prelude::*;

use crate::collision::narrow_phase::Scope;
use crate::contact::Group;
use crate::contact::outer_iteration::{Look, Margins, solve_masses};
use crate::islands::event::Touches;
use crate::islands::implicit_step::Find;
use crate::islands::island_detection::{Near, skin};
use crate::islands::island_manager::{Claim, Shared};
use crate::islands::{fly, instability, land};
use crate::sheet::{LED, Sheet, Status};

/// Room around what a sheet sweeps, m: more than the margin of detection.
const ROOM: f64 = 1e-3;

impl Shared<'_> {
    /// Steps the group of `members` of `sheets`; the first of `sheets` is number `first` of the world's.
    pub fn step_explicit(
        &self,
        sheets: &mut [Sheet],
        touches: &mut [Touches],
        members: &[u32],
        first: u32,
        parallel: bool,
        claims: &mut Vec<Claim>,
    ) {
        let [only] = members else {
            self.fly_all(sheets, touches, members, parallel);
            self.meet(sheets, touches, members, first, parallel, claims);
            return;
        };
        let index = *only as usize;
        instability::open(&mut sheets[index]);
        let last = fly(&mut sheets[index], &mut touches[index], self.stage);
        if sheets[index].status != Status::Awake {
            return;
        }
        let near = self.is_near(&mut sheets[index]);
        if !(near && self.meet(sheets, touches, members, first, parallel, claims)) {
            if sheets[index].work.touching.contains(&true) {
                instability::close(&mut sheets[index], &mut touches[index], self.stage, 0.0);
            }
            land(&mut sheets[index], &mut touches[index], self.stage, last);
        }
    }

    fn fly_all(&self, sheets: &mut [Sheet], touches: &mut [Touches], members: &[u32], parallel: bool) {
        let one = |(i, (sheet, touches)): (usize, (&mut Sheet, &mut Touches))| {
            if members.binary_search(&(i as u32)).is_ok() {
                instability::open(sheet);
                fly(sheet, touches, self.stage);
            }
        };
        if parallel {
            sheets.par_iter_mut().zip(touches.par_iter_mut()).enumerate().for_each(one);
        } else {
            sheets.iter_mut().zip(touches.iter_mut()).enumerate().for_each(one);
        }
    }

    /// Whether there may be anything for a single sheet that has flown but what its masses met: something that gives way where it
    /// went, glue, and for one layer edges or a fold. Lattices of several layers meet what stands with their masses alone: on
    /// the many rows of a ridge their coarse steps do not come to rest.
    fn is_near(&self, sheet: &mut Sheet) -> bool {
        skin(sheet);
        let stack = sheet.work.skin.as_ref().is_some_and(|s| s.is_stack());
        if !stack || sheet.is_glued() {
            return true;
        }
        let room = sheet.contact_offset() + ROOM;
        let Some((low, high)) = swept(sheet, room) else { return false };
        self.surroundings.parts.iter().any(|part| {
            let gives = self.surroundings.bodies.get(part.body as usize).is_some_and(|b| b.start.gives());
            gives && part.low.cmple(high).all() && part.high.cmpge(low).all()
        })
    }

    /// Lets sheets that have flown meet what gives way and what is sharp, and ends the step. False, with nothing done, when
    /// a single sheet has nothing to meet.
    fn meet(
        &self,
        sheets: &mut [Sheet],
        touches: &mut [Touches],
        members: &[u32],
        first: u32,
        parallel: bool,
        claims: &mut Vec<Claim>,
    ) -> bool {
        let Some(lead) = members.first().map(|i| *i as usize) else { return false };
        let dt = self.stage.dt;
        for sheet in members.iter().map(|i| *i as usize) {
            // Sheets of explicit engines do not stick.
            sheets[sheet].unstick();
            skin(&mut sheets[sheet]);
            sheets[sheet].work.met.clear();
            sheets[sheet].begin_contact(dt);
        }
        let mut scratch = sheets[lead].work.contact.take().unwrap_or_default();
        let mut work = sheets[lead].work.near.take().unwrap_or_default();
        let movers = std::mem::take(&mut scratch.movers);
        scratch.watch.clone_from(self.stage.watch);
        let mut group = Group { sheets, members, movers, parallel, lift: 0.0, leaning: 0 };
        let mut near = Near {
            view: self.stage.view,
            surroundings: self.surroundings,
            body_contacts: self.body_contacts,
            gravity: self.stage.field.gravity,
            sheets_meet: self.stage.sheets_meet,
            first,
            work: &mut work,
            watch: self.stage.watch,
        };
        let idle = !self.begin(&mut near, &mut group);
        let touched = !idle && {
            near.begin_stage(&mut group, 0.0, dt);
            let touched = solve_masses(&mut group, &mut scratch, dt, |group, found| {
                near.find(group, Look::First, Margins::NARROW, found)
            });
            near.end_stage(&mut group);
            touched
        };
        group.each(|sheet| {
            let unit = std::mem::take(&mut sheet.work.unit);
            sheet.end_contact((touched && unit.is_touched()).then_some(&unit.jump));
            sheet.work.unit = unit;
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
            self.note(sheets, members, &scratch, &work);
            self.claim(&movers, &work, &scratch, claims);
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
        sheets[lead].work.contact = Some(scratch);
        sheets[lead].work.near = Some(work);
        !lone
    }

    /// Begins detection for a group whose free motions are known; false when nothing can touch.
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
        let reach = travel + fastest * self.stage.dt + ROOM;
        // A sheet alone with what stands has met all faces by itself already.
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

/// Energy that what the sheets of a group meet could bring one of them, J: all of the motion of bodies that give way and of the other sheets, and
/// what bodies that are led push with; none where no sheet is watched.
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

/// Corners of the box that a sheet went through in the step, with `room` around it, m.
fn swept(sheet: &Sheet, room: f64) -> Option<(DVec3, DVec3)> {
    let (a, b) = sheet.work.start.0.bounds()?;
    let (c, d) = sheet.x.bounds()?;
    Some((a.min(c) - room, b.max(d) + room))
}
