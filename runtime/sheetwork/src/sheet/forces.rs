//! Record of the forces on a sheet in a step, if [`crate::World::record_forces`] is on.
//!
//! Every entry is an impulse J (N s) with its moment about the origin of the world (N m s); the
//! mean force of the step is J/dt. Contact, attachment and bond impulses are those by which the
//! solvers change the velocities. Gravity and applied forces are constant in a step. The rest of
//! the change of momentum
//!
//!   ΔP - Σ J
//!
//! is the impulse of the pins, without pins that of the air, without air that of the grabs. So the
//! entries of a sheet add up to ΔP, and with [`ForceKind::Numerical`] to the change of its angular
//! momentum. With pins, air and grabs are taken from their laws at the end of the step.
//!
//! The force on a pinned node follows from its own balance, m Δv/dt minus the mean of the internal
//! forces at the ends of the step, and a share, equal for all pinned nodes, of the difference to
//! the total.

use glam::DVec3;
use rapier3d::prelude::ColliderHandle;
use serde::Serialize;

use crate::elements::spring::SpringWorkspace;
use crate::math::Vectors;
use crate::sheet::attached_body::AttachedTo;
use crate::sheet::{Field, Sheet, SheetState, Status};

/// Kind of a force on a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ForceKind {
    /// Contact: normal force and friction. With an explicit integrator it includes the bonds.
    Contact,
    /// Pull of adhesive bonds.
    Bond,
    /// Attachment to a body (`pins` with `body`).
    Attachment,
    /// Fixed and prescribed nodes.
    Pins,
    /// Gravity.
    Gravity,
    /// Applied forces.
    Load,
    /// Air: damping, drag, wind and pressure.
    Air,
    /// Grabs.
    Grab,
    /// Change of momentum without a force: fallbacks, energy budget, a sheet that is put to sleep
    /// or stopped, and the error of the angular momentum.
    Numerical,
}

/// Partner that exerts a force on a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ForcePartner {
    /// No object, or an unknown one.
    None,
    /// The sheet itself.
    Itself,
    /// Sheet, by its index in the world.
    Sheet(usize),
    /// Body, by its index in the world.
    Body(usize),
    /// Collider of the caller's rigid world.
    Collider(ColliderHandle),
    /// Pin, by its index among those that are neither attached to a body nor fixed along some axes
    /// only; these have the next index together.
    Pin(usize),
}

/// Impulse of one kind and partner on a sheet in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairImpulse {
    pub kind: ForceKind,
    pub partner: ForcePartner,
    /// Impulse, N s.
    pub impulse: DVec3,
    /// Moment of the impulse about the origin, N m s.
    pub moment: DVec3,
    /// Sum of the magnitudes of its parts, N s.
    pub magnitude: f64,
    /// Sum of the places of its parts times their magnitudes, N s m.
    pub centre: DVec3,
    /// Sum of the normals of its parts, each to the sheet, times their magnitudes, N s.
    pub normal: DVec3,
    /// Largest speed of approach and of slip of its parts at the start of the step, m/s.
    pub speeds: (f64, f64),
}

/// Place of a part of an impulse, m; the unit normal of its contact to the sheet, or zero; and the
/// velocity of the sheet relative to the partner there at the start of the step, m/s.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ImpulseSample {
    pub place: DVec3,
    pub normal: DVec3,
    pub velocity: DVec3,
}

impl ImpulseSample {
    /// A part at `place` (m) without contact.
    pub fn at(place: DVec3) -> Self {
        Self { place, ..Self::default() }
    }

    /// Speed of approach along the normal and of slip across it, m/s.
    fn speeds(&self) -> (f64, f64) {
        if self.normal == DVec3::ZERO {
            return (0.0, 0.0);
        }
        let along = self.velocity.dot(self.normal);
        ((-along).max(0.0), (self.velocity - self.normal * along).length())
    }
}

/// Forces on a sheet: those of the last step, and the impulses of the present one.
#[derive(Default)]
pub(crate) struct SheetForces {
    /// Impulses of the last step, N s, and its length, s.
    pub pairs: Vec<PairImpulse>,
    pub dt: f64,
    /// Mean contact force and pin force on each node in the last step, N.
    pub contact: Vectors,
    pub pins: Vectors,
    /// Partner of each node's bond; empty without adhesion.
    pub bond_partner: Vec<ForcePartner>,
    next: Vec<PairImpulse>,
    node_impulse: Vectors,
    /// Momentum (kg m/s) and angular momentum about the origin (kg m²/s) at the start of the step.
    start: (DVec3, DVec3),
    v_start: Vectors,
    /// Velocities before node contact, m/s.
    v_free: Vectors,
    /// Internal forces at the end of the last step and of this one, N.
    internal: [Vectors; 2],
    has_internal: bool,
    springs: SpringWorkspace,
    was_awake: bool,
    is_cancelled: bool,
}

/// Momentum (kg m/s) and angular momentum about the origin (kg m²/s).
fn momenta(sheet: &Sheet) -> (DVec3, DVec3) {
    let each = sheet.state.x.iter().zip(sheet.state.v.iter()).zip(&sheet.model.mass);
    each.fold((DVec3::ZERO, DVec3::ZERO), |(p, l), ((x, v), m)| (p + v * *m, l + x.cross(v) * *m))
}

/// Call `work` with the record of a sheet that has one.
pub(crate) fn with_record(sheet: &mut Sheet, work: impl FnOnce(&mut SheetForces, &mut Sheet)) {
    if let Some(mut forces) = sheet.work.forces.take() {
        work(&mut forces, sheet);
        sheet.work.forces = Some(forces);
    }
}

impl SheetForces {
    /// Begin a step.
    pub fn begin(&mut self, sheet: &Sheet) {
        let n = sheet.node_count();
        if self.node_impulse.len() != n {
            for buffer in [&mut self.contact, &mut self.pins, &mut self.node_impulse, &mut self.v_free] {
                *buffer = Vectors::zeros(n);
            }
            self.internal = [Vectors::zeros(n), Vectors::zeros(n)];
            self.has_internal = false;
            self.bond_partner.clear();
        }
        self.next.clear();
        self.node_impulse.clear();
        self.start = momenta(sheet);
        self.v_start.clone_from(&sheet.state.v);
        (self.was_awake, self.is_cancelled) = (sheet.state.status == Status::Awake, false);
        if sheet.pins.fixes_nodes() && !self.has_internal {
            self.update_internal(sheet);
            self.has_internal = true;
        }
    }

    /// Count the whole change of momentum of this step as numerical: the sheet was rolled back.
    pub fn cancel(&mut self) {
        self.is_cancelled = true;
    }

    /// Velocity at the start of the step of the weighted mean of nodes, m/s.
    pub fn velocity_at_start(&self, terms: impl Iterator<Item = (u32, f64)>) -> DVec3 {
        terms.map(|(i, weight)| self.v_start.get(i as usize) * weight).sum()
    }

    /// Add an impulse (N s).
    pub fn add(&mut self, key: (ForceKind, ForcePartner), impulse: DVec3, sample: &ImpulseSample) {
        let (magnitude, speeds) = (impulse.length(), sample.speeds());
        let pair = self.pair(key);
        pair.impulse += impulse;
        pair.moment += sample.place.cross(impulse);
        pair.magnitude += magnitude;
        pair.centre += sample.place * magnitude;
        pair.normal += sample.normal * magnitude;
        pair.speeds = (pair.speeds.0.max(speeds.0), pair.speeds.1.max(speeds.1));
    }

    /// Add an impulse (N s) that has no single place, with its moment about the origin (N m s).
    fn add_moment(&mut self, key: (ForceKind, ForcePartner), impulse: DVec3, moment: DVec3) {
        let pair = self.pair(key);
        pair.impulse += impulse;
        pair.moment += moment;
        pair.magnitude += impulse.length();
    }

    /// Entry of a kind and partner.
    fn pair(&mut self, (kind, partner): (ForceKind, ForcePartner)) -> &mut PairImpulse {
        let found = self.next.iter().position(|pair| (pair.kind, pair.partner) == (kind, partner));
        let index = found.unwrap_or_else(|| {
            let zero = DVec3::ZERO;
            let (impulse, moment, centre, normal) = (zero, zero, zero, zero);
            self.next.push(PairImpulse {
                kind,
                partner,
                impulse,
                moment,
                magnitude: 0.0,
                centre,
                normal,
                speeds: (0.0, 0.0),
            });
            self.next.len() - 1
        });
        &mut self.next[index]
    }

    /// Add a contact impulse (N s) on node `i`.
    pub fn add_on_node(&mut self, i: u32, impulse: DVec3) {
        self.node_impulse.add(i as usize, impulse);
    }

    /// Store the velocities `v` before contact of single nodes, m/s.
    pub fn begin_node_contact(&mut self, v: &Vectors) {
        self.v_free.clone_from(v);
    }

    /// Add the impulses of contact of single nodes: the change of their velocities. `partner_of`
    /// gives the partner of a node; a node without one gets that of the largest impulse.
    pub fn add_node_contact(&mut self, sheet: &Sheet, partner_of: impl Fn(usize) -> ForcePartner) {
        let impulse_of = |v_free: &Vectors, i: usize| (sheet.state.v.get(i) - v_free.get(i)) * sheet.model.mass[i];
        for unknown in [false, true] {
            for i in (0..sheet.node_count()).filter(|i| sheet.inverse_mass[*i] > 0.0) {
                let (impulse, mut partner) = (impulse_of(&self.v_free, i), partner_of(i));
                if impulse == DVec3::ZERO || (partner == ForcePartner::None) != unknown {
                    continue;
                }
                if unknown {
                    partner = self.main_partner();
                }
                let change = sheet.state.v.get(i) - self.v_free.get(i);
                let normal = impulse.normalize_or_zero();
                let sample = ImpulseSample { place: sheet.state.x.get(i), normal, velocity: -change };
                self.add((ForceKind::Contact, partner), impulse, &sample);
                self.add_on_node(i as u32, impulse);
            }
        }
    }

    /// Add the impulse by which the thickness limit, which does not move nodes in contact, loads
    /// the partner of the largest contact impulse: the change of momentum since
    /// [`SheetForces::begin_node_contact`], in equal parts on the nodes in contact.
    pub fn add_limit(&mut self, sheet: &Sheet) {
        let change = |i: usize| (sheet.state.v.get(i) - self.v_free.get(i)) * sheet.model.mass[i];
        let total: DVec3 = (0..sheet.node_count()).map(change).sum();
        let touching = || (0..sheet.node_count()).filter(|i| sheet.state.touching[*i]);
        if total == DVec3::ZERO || touching().next().is_none() {
            return;
        }
        let (partner, part) = (self.main_partner(), total / touching().count() as f64);
        for i in touching() {
            self.add((ForceKind::Contact, partner), part, &ImpulseSample::at(sheet.state.x.get(i)));
            self.add_on_node(i as u32, part);
        }
    }

    /// Partner of the largest contact impulse.
    fn main_partner(&self) -> ForcePartner {
        let contacts = self.next.iter().filter(|pair| pair.kind == ForceKind::Contact);
        let largest = contacts.max_by(|a, b| a.magnitude.total_cmp(&b.magnitude));
        largest.map_or(ForcePartner::None, |pair| pair.partner)
    }

    /// End a step of `dt` (s). The forces of a sleeping sheet are those of its last step; a sheet
    /// that is stopped has none.
    pub fn finish(&mut self, sheet: &mut Sheet, field: &Field, dt: f64) {
        if !self.was_awake && sheet.state.status != Status::Awake {
            if sheet.state.status != Status::Asleep {
                self.pairs.clear();
                self.contact.clear();
                self.pins.clear();
            }
            return;
        }
        if self.is_cancelled {
            self.next.clear();
            self.node_impulse.clear();
        }
        self.add_bonds(sheet, dt);
        self.pins.clear();
        self.add_weight_and_loads(sheet, field, dt);
        self.add_rest(sheet, field, dt);
        std::mem::swap(&mut self.pairs, &mut self.next);
        self.contact.clear();
        self.contact.add_scaled(1.0 / dt, &self.node_impulse);
        self.dt = dt;
    }

    /// Change of momentum and of angular momentum that no entry explains.
    fn rest(&self, sheet: &Sheet) -> (DVec3, DVec3) {
        let (p, l) = momenta(sheet);
        let start = (p - self.start.0, l - self.start.1);
        self.next.iter().fold(start, |(p, l), pair| (p - pair.impulse, l - pair.moment))
    }

    /// Add the pull of the bonds of an implicit integrator, which it takes as applied forces.
    fn add_bonds(&mut self, sheet: &Sheet, dt: f64) {
        let Some(stuck) = sheet.state.adhesion.as_ref().filter(|stuck| stuck.substep == 0.0) else { return };
        for (i, force) in stuck.previous_bond_force.iter().enumerate().filter(|(_, force)| *force != DVec3::ZERO) {
            let partner = self.bond_partner.get(i).copied().unwrap_or(ForcePartner::None);
            self.add((ForceKind::Bond, partner), force * dt, &ImpulseSample::at(sheet.state.x.get(i)));
        }
    }

    /// Add gravity and the applied forces.
    fn add_weight_and_loads(&mut self, sheet: &Sheet, field: &Field, dt: f64) {
        // The mean of the positions at both ends is that of x - v dt/2.
        let middle = |i: usize| sheet.state.x.get(i) - sheet.state.v.get(i) * (0.5 * dt);
        let mut moments = [DVec3::ZERO; 2];
        let mut load = DVec3::ZERO;
        for i in 0..sheet.node_count() {
            let (weight, applied) = (field.gravity * sheet.model.mass[i], sheet.parameters.applied.get(i));
            moments[0] += middle(i).cross(weight);
            moments[1] += middle(i).cross(applied);
            load += applied;
        }
        let none = ForcePartner::None;
        self.add_moment((ForceKind::Gravity, none), field.gravity * sheet.total_mass() * dt, moments[0] * dt);
        if load != DVec3::ZERO || moments[1] != DVec3::ZERO {
            self.add_moment((ForceKind::Load, none), load * dt, moments[1] * dt);
        }
    }

    /// Assign the rest of the change of momentum to pins, air or grabs.
    fn add_rest(&mut self, sheet: &mut Sheet, field: &Field, dt: f64) {
        let none = ForcePartner::None;
        let is_pinned = sheet.pins.fixes_nodes();
        let in_air = field.air > 0.0 || sheet.parameters.drag.is_active(field);
        if !sheet.grabs.is_empty() && (is_pinned || in_air) {
            let (force, moment) = grab_force(sheet);
            self.add_moment((ForceKind::Grab, none), force * dt, moment * dt);
        }
        if in_air && is_pinned {
            let (force, moment) = air_force(sheet, field, &mut self.v_free);
            self.add_moment((ForceKind::Air, none), force * dt, moment * dt);
        }
        let (rest, moment) = self.rest(sheet);
        let kind = match sheet.grabs.is_empty() {
            _ if std::mem::take(&mut self.is_cancelled) => ForceKind::Numerical,
            _ if is_pinned => ForceKind::Pins,
            _ if in_air => ForceKind::Air,
            false => ForceKind::Grab,
            true => ForceKind::Numerical,
        };
        if kind == ForceKind::Pins {
            self.add_pins(sheet, field, rest / dt, dt);
        } else if kind != ForceKind::Numerical {
            self.add_moment((kind, none), rest, moment);
        }
        let (rest, moment) = self.rest(sheet);
        self.add_moment((ForceKind::Numerical, none), rest, moment);
        // Its parts are differences of momenta.
        let numerical = self.next.iter_mut().filter(|pair| pair.kind == ForceKind::Numerical);
        numerical.for_each(|pair| pair.magnitude = pair.impulse.length());
    }

    /// Add the pins, whose forces sum to `total` (N).
    fn add_pins(&mut self, sheet: &Sheet, field: &Field, total: DVec3, dt: f64) {
        self.internal.swap(0, 1);
        self.update_internal(sheet);
        let (mut sum, mut count) = (DVec3::ZERO, DVec3::ZERO);
        for_each_pinned(sheet, &mut self.v_free, |_, i, axes| {
            let inertia = (sheet.state.v.get(i) - self.v_start.get(i)) / dt - field.gravity;
            let own = inertia * sheet.model.mass[i]
                - sheet.parameters.applied.get(i)
                - (self.internal[0].get(i) + self.internal[1].get(i)) * 0.5
                - self.node_impulse.get(i) / dt;
            self.pins.add(i, own * axes);
            sum += own * axes;
            count += axes;
        });
        let share = (total - sum) / count.max(DVec3::ONE);
        let mut claimed = std::mem::take(&mut self.v_free);
        for_each_pinned(sheet, &mut claimed, |owner, i, axes| {
            self.pins.add(i, share * axes);
            let force = self.pins.get(i) * axes;
            self.add(owner, force * dt, &ImpulseSample::at(sheet.state.x.get(i)));
        });
        self.v_free = claimed;
    }

    /// Compute the internal forces at the present state.
    fn update_internal(&mut self, sheet: &Sheet) {
        let Self { internal: [force, _], springs, .. } = self;
        force.clear();
        let Sheet { state: SheetState { x, v, .. }, parameters, .. } = sheet;
        sheet.springs.add_forces(x, v, parameters.springs.has_dashpots, springs, force);
        sheet.elements.iter().for_each(|e| e.add_forces(x, v, force));
    }
}

/// Call `work` for the pinned nodes with kind and partner of their pin and their fixed axes (1). An
/// axis that two pins fix belongs to the first; `claimed` is scratch.
fn for_each_pinned(
    sheet: &Sheet,
    claimed: &mut Vectors,
    mut work: impl FnMut((ForceKind, ForcePartner), usize, DVec3),
) {
    claimed.clear();
    for (owner, i, axes) in sheet.pins.prescribed() {
        let (i, owner) = match owner {
            Ok(pin) => (i as usize, (ForceKind::Pins, ForcePartner::Pin(pin))),
            Err(AttachedTo::Own(body)) => (i as usize, (ForceKind::Attachment, ForcePartner::Body(body))),
            Err(AttachedTo::Lent(_)) => (i as usize, (ForceKind::Attachment, ForcePartner::None)),
        };
        let axes = axes * (DVec3::ONE - claimed.get(i));
        claimed.add(i, axes);
        work(owner, i, axes);
    }
}

impl Sheet {
    /// Mean contact force and mean force of the pins on each node in the last step, N; `None`
    /// unless [`crate::World::record_forces`] is on.
    pub fn mean_forces(&self) -> Option<(&Vectors, &Vectors)> {
        self.work.forces.as_ref().map(|forces| (&forces.contact, &forces.pins))
    }
}

/// Force of the grabs (N) and its moment about the origin (N m).
fn grab_force(sheet: &Sheet) -> (DVec3, DVec3) {
    let each = sheet.grabs.iter().map(|grab| {
        let at = grab.point(&sheet.state.x);
        (at, (grab.target - at) * grab.stiffness)
    });
    each.fold((DVec3::ZERO, DVec3::ZERO), |(f, m), (at, force)| (f + force, m + at.cross(force)))
}

/// Force of the air by its law at the present state (N) and its moment about the origin (N m).
fn air_force(sheet: &mut Sheet, field: &Field, force: &mut Vectors) -> (DVec3, DVec3) {
    force.clear();
    let Sheet { state: SheetState { x, v, .. }, parameters, inverse_mass, model, .. } = sheet;
    if parameters.drag.is_active(field) {
        parameters.drag.add_forces(field, x, v, force);
    }
    let mut sum = (DVec3::ZERO, DVec3::ZERO);
    for i in (0..x.len()).filter(|i| inverse_mass[*i] > 0.0) {
        let f = force.get(i) - v.get(i) * (field.air * model.mass[i]);
        sum = (sum.0 + f, sum.1 + x.get(i).cross(f));
    }
    sum
}
