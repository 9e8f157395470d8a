//! What a step of an implicit engine may not end with: energy from nowhere, or a sheet within a body.
//!
//! Contact gives no energy, nor do air at rest and pins that hold; with those alone
//!
//!   T + V ≤ T₀ + V₀,
//!
//! T kinetic energy, V that of strain and of gravity. A linear solve over a large motion can break this: where a sheet is struck hard
//! its masses are taken along the tangent, not around the arc. Such a step is taken again as two, and where steps are as short as they
//! may be, velocities lose what there is too much. Where it ends within a body all the same, the sheet stays where it was, slower: time
//! is lost, and the next step has less to cope with. Energies in J.

use crate::contact::Group;
use crate::contact::solver_body::Mover;
use crate::sheet::Field;

use crate::islands::implicit_step::Part;
use crate::islands::rigid_motion::whole_group;

/// Energy gained, as a fraction of what could be turned into motion at the start, beyond which a step is taken again.
const GAIN: f64 = 0.1;
/// The same below which it is left: what engines do without contact, too.
const SLIGHT: f64 = 1e-3;
/// What moves slower than this (m/s), or is lifted by less than this (m), has no energy worth another step: a contact solve is
/// accurate to a fraction of a micrometre.
const STILL: f64 = 5e-3;
const LIFT: f64 = 1e-4;
/// The same for several sheets: each may be a few micrometres into the next, and a pile is lifted by all of them.
const LIFT_TOGETHER: f64 = 2e-3;
/// What overlapped at the start by more than contact leaves, and by no more than somebody may have put there, m, is lifted out of it.
const OVERLAPS: (f64, f64) = (2e-5, 5e-4);
/// The same beyond which a sheet is not to be helped: as one that begins deep within a body, and is thrown out of it. Of several
/// sheets one would take the others with it, so those stay where they were.
const RUNAWAY: f64 = 1e6;
/// Speed of what is about to come to rest, m/s. A body that rolls to and fro over the edges of the sheet's triangles is lifted onto each by up to a
/// twentieth of the energy it has: more than rolling takes from it.
const LINGERING: f64 = 0.03;
/// Part of its speed that a sheet keeps when it stays where it was, for want of a step that may stand.
pub(crate) const KEPT: f64 = 0.5;
/// Overlap with a body that a step may end with where its rounds did not come together, m.
pub(crate) const WITHIN: f64 = 3e-4;

/// Whether a step may stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Stands,
    /// It is to be taken again as two.
    Again,
    /// It cannot be made so that it may stand.
    Fails,
    /// What comes after need not be computed: the sheet is unstable.
    Runaway,
}

/// Energies of a group.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Energies {
    /// Of the motion of the sheets and of the bodies that give way, of strain and of gravity.
    sheets: f64,
    bodies: f64,
    strain: f64,
    gravity: f64,
    /// What the sheets have when they are all but still.
    still: f64,
    /// What lifts out of overlaps may add.
    lifts: f64,
}

impl Energies {
    fn of(group: &Group, field: &Field) -> Self {
        let mut all = Self::default();
        for i in group.members {
            let energy = group.sheets[*i as usize].energy(field.gravity);
            all.sheets += energy.kinetic;
            all.strain += energy.elastic;
            all.gravity += energy.gravity;
            let mass: f64 = group.sheets[*i as usize].mass.iter().sum();
            let lift = if group.members.len() > 1 { LIFT_TOGETHER } else { LIFT };
            all.still += mass * (0.5 * STILL * STILL + lift * field.gravity.length());
        }
        if group.lift > 0.0 {
            all.still += weight(group, field) * group.lift;
        }
        for mover in group.movers.iter().filter(|m| m.gives()) {
            all.bodies += mover.start.kinetic_energy();
            all.gravity += mover.start.gravity_energy(field.gravity);
        }
        all
    }

    fn total(&self) -> f64 {
        self.sheets + self.bodies + self.strain + self.gravity
    }

    /// Those at the start of `part`; `None` where something else than contact may do work in it.
    pub fn before(group: &Group, part: &Part) -> Option<Self> {
        let led = group.movers.iter().any(|m| !m.gives() && m.start.moves());
        let moved = |i: &u32| {
            let sheet = &group.sheets[*i as usize];
            sheet.is_pulled() || sheet.pins.moving(part.time, part.time + part.dt)
        };
        let blown = part.field.wind != glam::DVec3::ZERO;
        (!led && !blown && !group.members.iter().any(moved)).then(|| Self::of(group, &part.field))
    }

    /// Counts what lifts a lone sheet and what lies on it out of an overlap of `depth` (m) that the step began with, and bodies with what
    /// lies on them out of one that is to be less by `parted` (m): that is taken back at once, however short the step. Several sheets are
    /// lifted by [`LIFT_TOGETHER`] in any case.
    pub fn lift_out(&mut self, group: &Group, field: &Field, (depth, parted): (f64, f64)) {
        let depth = if depth > OVERLAPS.0 { depth.min(OVERLAPS.1) } else { 0.0 };
        if depth + parted > 0.0 && group.members.len() == 1 {
            self.lifts += weight(group, field) * (depth + parted);
        }
    }

    /// Compares with those now. With `last`, the step is made so that it may stand, or fails. Where nothing was `met` a slight gain is the
    /// engine's own, and stands. Of sheets that are `loose` only what moves against their motion as a whole is slowed: that has momentum.
    /// Of what is about to come to rest any gain is taken from its motion, and what it had not enough for is `owed` (J) by the next steps.
    pub fn judge(
        &self,
        group: &mut Group,
        field: &Field,
        (last, met, loose): (bool, bool, bool),
        owed: &mut f64,
    ) -> Verdict {
        let now = Self::of(group, field);
        let free = self.sheets + self.bodies + self.strain + self.still;
        let gain = now.total() - self.total() - self.lifts;
        if met && gain <= GAIN * free && is_lingering(group, loose) {
            *owed = (*owed + gain + self.lifts).max(0.0);
            *owed -= take(group, *owed, now.sheets + now.bodies);
            return Verdict::Stands;
        }
        *owed = 0.0;
        if gain <= if met { SLIGHT } else { GAIN } * free {
            return Verdict::Stands;
        }
        if gain > GAIN * free && !last {
            return Verdict::Again;
        }
        if group.members.len() == 1 && (gain.is_nan() || gain > RUNAWAY * free) {
            return Verdict::Runaway;
        }
        if let Some(own) = loose.then(|| whole_group(group)).flatten() {
            let within = now.sheets - own.kinetic_energy();
            if gain > within {
                return if last { Verdict::Fails } else { Verdict::Again };
            }
            let part = (1.0 - gain / within).sqrt();
            group.each(|sheet| {
                for i in 0..sheet.masses() {
                    let along = own.velocity_at(sheet.x.get(i));
                    sheet.v.set(i, along + (sheet.v.get(i) - along) * part);
                }
            });
        } else if gain <= now.sheets {
            let part = (1.0 - gain / now.sheets).sqrt();
            group.each(|sheet| sheet.v.axes_mut().into_iter().flatten().for_each(|v| *v *= part));
        } else if last {
            return Verdict::Fails;
        }
        Verdict::Stands
    }
}

/// Whether nothing in `group` goes faster than [`LINGERING`], bodies are in it that give way, and something holds it: of what is free only
/// the motion against the whole may be lessened.
fn is_lingering(group: &Group, loose: bool) -> bool {
    let gives = group.movers.iter().any(|m| m.gives());
    let slow = |m: &Mover| !m.gives() || m.start.velocity().length() < LINGERING;
    gives
        && group.movers.iter().all(slow)
        && group.members.iter().all(|i| group.sheets[*i as usize].max_speed() < LINGERING)
        && !(loose && whole_group(group).is_some())
}

/// Takes `owed` (J) from all that moves, with `motion` (J), or all of that; returns how much.
fn take(group: &mut Group, owed: f64, motion: f64) -> f64 {
    let taken = owed.min(motion);
    if taken > 0.0 {
        let part = (1.0 - taken / motion).sqrt();
        group.each(|sheet| sheet.v.axes_mut().into_iter().flatten().for_each(|v| *v *= part));
        for mover in group.movers.iter_mut().filter(|m| m.gives()) {
            mover.start = mover.start.with_velocity(mover.start.velocity() * part, mover.start.spin() * part);
        }
    }
    taken
}

/// Weight of a group's sheets, and of the bodies in it that give way, N.
fn weight(group: &Group, field: &Field) -> f64 {
    let sheets: f64 = group.members.iter().flat_map(|i| &group.sheets[*i as usize].mass).sum();
    let bodies: f64 = group.movers.iter().filter(|m| m.gives()).map(|m| m.free.mass()).sum();
    (sheets + bodies) * field.gravity.length()
}

/// Leaves the sheets where they were at the start; bodies that give way go on.
pub(crate) fn stay(group: &mut Group) {
    group.each(|sheet| {
        sheet.put_back();
        sheet.v.axes_mut().into_iter().flatten().for_each(|v| *v *= KEPT);
        sheet.restart_engine();
    });
}
