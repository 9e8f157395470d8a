//! How contacts answer one another: W = Σ J H⁻¹ Jᵀ, grown contact by contact.
//!
//! A contact's row J has on a sheet the weights of its masses times the contact's frame, on a body the frame and its moment.
//! A sheet answers with the factor of its tangent, H = L Lᵀ, by half solutions L⁻¹ Jᵀ (see
//! [`crate::engine::linear::HalfSolutions`]), a body as [`Mover`] says.

use glam::{DMat3, DVec3};

use super::mover::Mover;
use super::row::{Contact, Side};
use super::sweeps::Problem;
use crate::engine::implicit::staged::Jump;
use crate::engine::linear::{HalfSolutions, Loads};
use crate::sheet::{Sheet, Vectors};

/// What a sheet has to do with a contact problem.
#[derive(Default)]
pub(crate) struct Unit {
    /// Contacts of the problem on this sheet, ascending, by number among the active ones.
    list: Vec<u32>,
    loads: Loads,
    halves: HalfSolutions,
    touched: bool,
    kept_dx: Vectors,
    /// Force of the contacts on each mass, N.
    force: Vectors,
    /// What contact does to it in this stage.
    pub jump: Jump,
}

impl Unit {
    fn clear(&mut self, n: usize) {
        self.touched = false;
        self.list.clear();
        self.halves.clear();
        for buffer in [&mut self.force, &mut self.jump.dx, &mut self.jump.dv, &mut self.jump.acceleration] {
            if buffer.len() != n {
                *buffer = Vectors::zeros(n);
            }
        }
        self.jump.dx.clear();
    }

    /// Takes all contacts off this sheet.
    pub fn release(&mut self) {
        self.touched = false;
        self.list.clear();
    }

    /// Whether any contact is on this sheet.
    pub fn is_touched(&self) -> bool {
        self.touched || !self.list.is_empty()
    }

    /// Makes ready for contacts that are not in the list, on a sheet of `n` masses.
    pub fn touch(&mut self, n: usize) {
        self.clear(n);
        self.force.clear();
        self.touched = true;
    }

    /// Adds `force` (N) at `point`.
    pub fn push(&mut self, point: &super::row::SheetPoint, force: DVec3) {
        for (mass, weight) in point.terms() {
            let there = self.force.get(mass as usize);
            self.force.set(mass as usize, there + force * weight);
        }
    }

    /// Works out the accelerations that the forces are, with the masses' `inverse` (1/kg).
    pub fn accelerate(&mut self, inverse: &[f64]) {
        for (i, w) in inverse.iter().enumerate() {
            self.jump.acceleration.set(i, self.force.get(i) * *w);
        }
    }
}

/// Sheets and bodies of a contact problem.
pub(crate) struct Group<'a> {
    pub sheets: &'a mut [Sheet],
    /// Which of them belong to it, ascending; a contact's `sheet` is a number in this list.
    pub members: &'a [u32],
    pub movers: Vec<Mover>,
    /// Whether to work on several sheets at once.
    pub parallel: bool,
    /// How far bodies are brought out of one another in this step, and what lies on them with them, m.
    pub lift: f64,
    /// How many bodies that give way touch another that does.
    pub leaning: usize,
}

impl Group<'_> {
    /// The sheet that a contact calls number `local`.
    pub fn sheet(&self, local: u32) -> &Sheet {
        &self.sheets[self.members[local as usize] as usize]
    }

    /// The same, to be changed.
    pub fn sheet_mut(&mut self, local: u32) -> &mut Sheet {
        &mut self.sheets[self.members[local as usize] as usize]
    }

    /// How many things move in it by themselves and on one another, where one sheet and the bodies that touch it alone count as one: of
    /// more, some contact always changes how it acts.
    pub fn pieces(&self) -> usize {
        self.members.len() + self.leaning.saturating_sub(1)
    }

    /// How many masses it has.
    pub fn masses(&self) -> usize {
        self.members.iter().map(|i| self.sheets[*i as usize].masses()).sum()
    }

    /// Calls `work` for every sheet of the group; what it does to one must not depend on others.
    pub fn each(&mut self, work: impl Fn(&mut Sheet) + Sync) {
        use rayon::prelude::*;
        let members = self.members;
        if self.parallel {
            let all = self.sheets.par_iter_mut().enumerate();
            all.filter(|(i, _)| members.binary_search(&(*i as u32)).is_ok()).for_each(|(_, sheet)| work(sheet));
        } else {
            members.iter().for_each(|i| work(&mut self.sheets[*i as usize]));
        }
    }
}

/// A contact in the problem.
#[derive(Clone, Copy)]
struct Active {
    contact: u32,
    /// Columns: normal and two tangents.
    frame: DMat3,
    /// Numbers of the sheets of its sides and its place in their lists; `u32::MAX` for a side that is no sheet, or the same.
    units: [(u32, u32); 2],
}

/// The operator, and the problem on it.
#[derive(Default)]
pub(crate) struct Delassus {
    active: Vec<Active>,
    /// Active contacts on each body, ascending.
    on_body: Vec<Vec<u32>>,
    pub problem: Problem,
    row: Vec<DMat3>,
    touched: Vec<u32>,
}

const NONE: (u32, u32) = (u32::MAX, 0);

impl Delassus {
    /// Forgets all contacts.
    pub fn clear(&mut self, group: &mut Group) {
        self.active.clear();
        self.problem.clear();
        self.on_body.iter_mut().for_each(Vec::clear);
        self.on_body.resize_with(group.movers.len(), Vec::new);
        group.each(|sheet| {
            let n = sheet.masses();
            sheet.work.unit.clear(n);
        });
    }

    /// Forgets all contacts, but not what they did to the places of the sheets.
    pub fn clear_for_velocities(&mut self, group: &mut Group) {
        group.each(|sheet| std::mem::swap(&mut sheet.work.unit.kept_dx, &mut sheet.work.unit.jump.dx));
        self.clear(group);
        group.each(|sheet| {
            let unit = &mut sheet.work.unit;
            std::mem::swap(&mut unit.kept_dx, &mut unit.jump.dx);
            unit.touched = true;
        });
    }

    /// Number of active contact `i` in the list they were taken from.
    pub fn contact(&self, i: usize) -> usize {
        self.active[i].contact as usize
    }

    /// Numbers of all active contacts in that list.
    pub fn contacts(&self) -> impl Iterator<Item = usize> + '_ {
        self.active.iter().map(|a| a.contact as usize)
    }

    /// Frame of active contact `i`: normal and two tangents.
    pub fn frame(&self, i: usize) -> DMat3 {
        self.active[i].frame
    }

    /// Makes the contacts numbered in `new` active; they were pushed to the problem by the caller. `h` is the weight of the stage, s.
    pub fn add(&mut self, group: &mut Group, contacts: &[Contact], new: &[u32], h: f64) {
        let first = self.active.len();
        group.each(|sheet| sheet.work.unit.loads.clear());
        for number in new {
            self.load(group, contacts, *number);
        }
        group.each(|sheet| {
            let mut unit = std::mem::take(&mut sheet.work.unit);
            if !unit.loads.is_empty() {
                sheet.half_solve(&unit.loads, &mut unit.halves);
            }
            sheet.work.unit = unit;
        });
        for i in first..self.active.len() {
            self.couple(group, contacts, i, h);
        }
    }

    /// Puts the rows of a contact into the lists of its sheets and bodies.
    fn load(&mut self, group: &mut Group, contacts: &[Contact], number: u32) {
        let contact = &contacts[number as usize];
        let index = self.active.len() as u32;
        let frame = frame_of(contact.normal);
        let mut units = [NONE; 2];
        let same =
            matches!((contact.a, contact.b), (Side::Sheet { sheet: a, .. }, Side::Sheet { sheet: b, .. }) if a == b);
        for (k, side) in [contact.a, contact.b].into_iter().enumerate() {
            match side {
                Side::Body { body, .. } => {
                    if group.movers[body as usize].gives() {
                        self.on_body[body as usize].push(index);
                    }
                }
                Side::Sheet { sheet, .. } if k == 0 || !same => {
                    let member = group.sheet_mut(sheet);
                    let mut unit = std::mem::take(&mut member.work.unit);
                    for column in [frame.x_axis, frame.y_axis, frame.z_axis] {
                        unit.loads.push(loads(member, contact, sheet, column));
                    }
                    units[k] = (sheet, unit.list.len() as u32);
                    unit.list.push(index);
                    member.work.unit = unit;
                }
                Side::Sheet { .. } => {}
            }
        }
        self.active.push(Active { contact: number, frame, units });
    }

    /// Couples active contact `i` with those before it and with itself.
    fn couple(&mut self, group: &Group, contacts: &[Contact], i: usize, h: f64) {
        self.row.resize(self.active.len(), DMat3::ZERO);
        self.touched.clear();
        let active = self.active[i];
        for (sheet, place) in active.units.into_iter().filter(|u| *u != NONE) {
            let unit = &group.sheet(sheet).work.unit;
            for (other, j) in unit.list[..=place as usize].iter().enumerate() {
                let block = unit.halves.block(place as usize, other);
                self.gather(*j, DMat3::from_cols_array_2d(&block).transpose());
            }
        }
        let contact = &contacts[active.contact as usize];
        for (body, arm, sign) in arms(contact, &group.movers).into_iter().flatten() {
            let mover = &group.movers[body as usize];
            for k in 0..self.on_body[body as usize].len() {
                let j = self.on_body[body as usize][k];
                if j as usize > i {
                    break;
                }
                let other = self.active[j as usize];
                let others = arms(&contacts[other.contact as usize], &group.movers);
                for (_, at, its) in others.into_iter().flatten().filter(|a| a.0 == body) {
                    let compliance = mover.compliance(arm, at) * (h * h * sign * its);
                    self.gather(j, active.frame.transpose() * compliance * other.frame);
                }
            }
        }
        for j in &self.touched {
            self.problem.couple(i, *j as usize, self.row[*j as usize]);
            self.row[*j as usize] = DMat3::ZERO;
        }
    }

    fn gather(&mut self, j: u32, block: DMat3) {
        let there = &mut self.row[j as usize];
        if *there == DMat3::ZERO {
            self.touched.push(j);
        }
        *there += block;
    }

    /// Forces of the problem on the masses of each sheet, left in the units, N.
    fn forces(&self, group: &mut Group, contacts: &[Contact]) {
        group.each(|sheet| {
            if sheet.work.unit.is_touched() {
                sheet.work.unit.force.clear();
            }
        });
        for (active, p) in self.active.iter().zip(&self.problem.force) {
            if *p == DVec3::ZERO {
                continue;
            }
            let force = active.frame * *p;
            let contact = &contacts[active.contact as usize];
            for (side, sign) in [(contact.a, 1.0), (contact.b, -1.0)] {
                if let Side::Sheet { sheet, point } = side {
                    group.sheet_mut(sheet).work.unit.push(&point, force * sign);
                }
            }
        }
    }

    /// Displacements that the forces of the problem make, left in the units and movers, with the accelerations they are.
    pub fn displace(&self, group: &mut Group, contacts: &[Contact], h: f64) {
        self.forces(group, contacts);
        group.each(|sheet| {
            let mut unit = std::mem::take(&mut sheet.work.unit);
            if unit.is_touched() {
                sheet.answer(&unit.force, &mut unit.jump.dx);
                unit.accelerate(&sheet.inverse_mass);
            }
            sheet.work.unit = unit;
        });
        group.movers.iter_mut().for_each(Mover::release);
        self.push_bodies(group, contacts, |mover, force, moment| {
            mover.displace(force, moment, h);
        });
    }

    /// Jumps of velocity that the forces of the problem make in h, left in the units and movers.
    pub fn kick(&self, group: &mut Group, contacts: &[Contact], h: f64) {
        self.forces(group, contacts);
        group.each(|sheet| {
            let mut unit = std::mem::take(&mut sheet.work.unit);
            if unit.is_touched() {
                sheet.answer(&unit.force, &mut unit.jump.dv);
                unit.jump.dv.axes_mut().into_iter().flatten().for_each(|v| *v /= h);
            }
            sheet.work.unit = unit;
        });
        group.movers.iter_mut().for_each(|m| (m.kick, m.twist) = (DVec3::ZERO, DVec3::ZERO));
        self.push_bodies(group, contacts, |mover, force, moment| {
            mover.strike(force, moment, h);
        });
    }

    /// Calls `push` for every body that gives way and every contact on it, with the force (N) on it and its moment about the
    /// centre of mass (N m).
    fn push_bodies(&self, group: &mut Group, contacts: &[Contact], push: impl Fn(&mut Mover, DVec3, DVec3)) {
        for (active, p) in self.active.iter().zip(&self.problem.force) {
            if *p == DVec3::ZERO {
                continue;
            }
            for (body, arm, sign) in arms(&contacts[active.contact as usize], &group.movers).into_iter().flatten() {
                let force = active.frame * *p * sign;
                let mover = &mut group.movers[body as usize];
                if mover.gives() {
                    push(mover, force, arm.cross(force));
                }
            }
        }
    }
}

/// Bodies of a contact: number, arm from the centre of mass (m), sign of the force on it.
fn arms(contact: &Contact, movers: &[Mover]) -> [Option<(u32, DVec3, f64)>; 2] {
    [(contact.a, 1.0), (contact.b, -1.0)].map(|(side, sign)| match side {
        Side::Body { body, local } => {
            let mover = &movers[body as usize];
            Some((body, mover.free.place(local) - mover.free.centre(), sign))
        }
        Side::Sheet { .. } => None,
    })
}

/// A contact's force along `direction` on the free masses of sheet `number`, by block row.
fn loads<'a>(
    sheet: &'a Sheet,
    contact: &Contact,
    number: u32,
    direction: DVec3,
) -> impl Iterator<Item = (u32, [f64; 3])> + use<'a> {
    let sides = [(contact.a, 1.0), (contact.b, -1.0)];
    sides.into_iter().flat_map(move |(side, sign)| {
        let terms = match side {
            Side::Sheet { sheet, point } if sheet == number => Some(point),
            _ => None,
        };
        terms.into_iter().flat_map(move |point| {
            (0..3).filter_map(move |k| {
                let weight = point.weights[k];
                let (row, free) = sheet.free_row(point.masses[k]).filter(|_| weight != 0.0)?;
                Some((row, (direction * free * (sign * weight)).to_array()))
            })
        })
    })
}

/// A frame whose first column is `normal`.
pub(crate) fn frame_of(normal: DVec3) -> DMat3 {
    let axis = if normal.x.abs() < 0.7 { DVec3::X } else { DVec3::Y };
    let tangent = (axis - normal * axis.dot(normal)).normalize();
    DMat3::from_cols(normal, tangent, normal.cross(tangent))
}
