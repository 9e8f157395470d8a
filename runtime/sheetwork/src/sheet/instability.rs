//! What watches over a sheet that is not simply to be stopped when it goes unstable: its policy, and how far that has gone. What is done
//! is in [`crate::islands`]; a sheet whose policy is to stop holds nothing of this.
//!
//! An engine's own step can only turn what a sheet has, and what gravity, forces, pins and air do to it, into motion and strain:
//!
//!   ΔT + ΔV ≤ W,
//!
//! T and W of the masses that are free. Contact comes after the engine and is not in it: of a whole step the right side has what bodies and
//! other sheets bring, besides.

use glam::{DMat3, DQuat, DVec3};

use crate::elements::strain_limit::{Joint, StrainLimit, largest_strain};
use crate::integrators::EngineKind;
use crate::math::Vectors;
use crate::scene::WhenUnstable;
use crate::serialize::{Cut, Keeper, Taken, Taker};
use crate::sheet::{Field, Sheet, energy};

/// The engine of last resort.
pub(crate) const GUARDED: EngineKind = EngineKind::TrBdf2;

/// How long all must be well before a step is lengthened, or the sheet's own engine tried again, s of simulated time; doubled each time
/// that this was too early, up to the second.
const QUIET: f64 = 0.25;
const QUIET_MOST: f64 = 8.0;

/// Part of the kinetic energy of the whole sheet at the speed of a pin that the pin may bring in a step: against the tension of a sheet
/// as stiff as explicit engines bear it does work of about this size. A body that is led, likewise.
pub(crate) const LED: f64 = 32.0;

/// How far a policy has gone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GuardState {
    /// The step is taken in 2 to this power parts.
    pub level: u32,
    /// Whether springs are held to their limit.
    pub limiting: bool,
    /// The sheet's own engine, while the implicit one stands in for it.
    pub own: Option<EngineKind>,
    /// Whether it is to be replaced before the next step.
    pub replace: bool,
    /// Energy that a sheet whose springs are held may have, J: what contact strains them by is none of it.
    pub energy: f64,
    /// Energy from nowhere that has not gone again, J.
    pub surplus: f64,
    /// Time since the last alarm, s, how long it has to be, and whether something was eased since.
    pub calm: f64,
    pub wait: f64,
    pub eased: bool,
}

impl Default for GuardState {
    fn default() -> Self {
        Self {
            level: 0,
            limiting: false,
            own: None,
            replace: false,
            energy: 0.0,
            surplus: 0.0,
            calm: 0.0,
            wait: QUIET,
            eased: false,
        }
    }
}

impl GuardState {
    /// Whether anything is done.
    pub fn acts(&self) -> bool {
        self.level > 0 || self.limiting || self.own.is_some() || self.replace
    }

    /// Takes the step in twice as many parts as now, at most `parts`; how many those are, none where that is exhausted.
    pub fn shorten(&mut self, parts: u32) -> Option<u32> {
        (2_u32 << self.level <= parts).then(|| {
            self.level += 1;
            1 << self.level
        })
    }

    /// Takes note of an alarm.
    pub fn alarmed(&mut self) {
        if std::mem::take(&mut self.eased) {
            self.wait = (2.0 * self.wait).min(QUIET_MOST);
        }
        (self.calm, self.surplus) = (0.0, 0.0);
    }

    /// Lets `dt` s pass; whether it is time to ease what is done.
    pub fn pass(&mut self, dt: f64) -> bool {
        self.calm += dt;
        if self.calm < self.wait {
            return false;
        }
        self.calm = 0.0;
        if !self.acts() {
            (self.wait, self.eased) = (QUIET, false);
            return false;
        }
        self.eased = true;
        true
    }
}

impl GuardState {
    /// Keeps it for a snapshot.
    pub fn keep(&self, to: &mut Keeper) {
        to.count(self.level.into());
        [self.limiting, self.replace, self.eased, self.own.is_some()].into_iter().for_each(|f| to.flag(f));
        self.own.iter().for_each(|own| to.text(own.name()));
        to.numbers(&[self.energy, self.surplus, self.calm, self.wait]);
    }

    /// Takes it back.
    pub fn taken(from: &mut Taker) -> Taken<Self> {
        let level = from.small()?;
        let (limiting, replace, eased) = (from.flag()?, from.flag()?, from.flag()?);
        let own = if from.flag()? { Some(from.text()?.parse().map_err(|_| Cut)?) } else { None };
        let (energy, surplus) = (from.number()?, from.number()?);
        let (calm, wait) = (from.number()?, from.number()?);
        // Parts of a step are limited where policies are read.
        let sound = level <= 12 && energy >= 0.0 && surplus >= 0.0 && calm >= 0.0 && wait > 0.0;
        if sound { Ok(Self { level, limiting, own, replace, energy, surplus, calm, wait, eased }) } else { Err(Cut) }
    }
}

/// The policy of a sheet, and what it needs.
pub(crate) struct Guard {
    pub policy: WhenUnstable,
    pub state: GuardState,
    /// What the sheet had at the start of the world's step, or may have if its springs are held, J.
    pub before: f64,
    /// Error that an adaptive engine of the sheet's may make, m.
    pub tolerance: f64,
    /// Made when it is first needed, and anew when the sheet has opened: the revision it is of.
    pub limit: Option<(u64, StrainLimit)>,
    /// Where a step of the engine began, and what came of it.
    pub start: Vectors,
    pub end: (Vectors, Vectors),
}

/// Energy of the free masses' motion and of strain, J.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Level {
    pub motion: f64,
    pub elastic: f64,
}

impl Level {
    /// Both together.
    pub fn total(self) -> f64 {
        self.motion + self.elastic
    }
}

impl Sheet {
    /// What is done when it is about to go unstable.
    pub fn when_unstable(&self) -> WhenUnstable {
        self.guard.as_ref().map_or(WhenUnstable::Stop, |g| g.policy)
    }

    /// Changes what is done when it is about to go unstable; what the former policy has done is undone.
    ///
    /// # Errors
    /// When its number is out of range; nothing is changed then.
    pub fn set_when_unstable(&mut self, policy: WhenUnstable) -> Result<(), crate::InputError> {
        policy.check()?;
        self.watch_over(policy, self.guard.as_ref().map_or(1e-7, |g| g.tolerance));
        self.wake();
        Ok(())
    }

    /// The engine that it was given, which another may stand in for.
    pub(crate) fn own_engine(&self) -> EngineKind {
        self.guard.as_ref().and_then(|g| g.state.own).unwrap_or(self.engine_kind)
    }

    pub(crate) fn watch_over(&mut self, policy: WhenUnstable, tolerance: f64) {
        if let Some(own) = self.guard.as_mut().and_then(|g| g.state.own.take()) {
            self.change_engine(own, tolerance);
        }
        let watched = policy != WhenUnstable::Stop;
        let guard = || {
            let state = GuardState::default();
            Box::new(Guard {
                policy,
                state,
                before: 0.0,
                tolerance,
                limit: None,
                start: Vectors::default(),
                end: Default::default(),
            })
        };
        self.guard = watched.then(guard);
    }

    /// Goes back to what a policy had done, at another time.
    pub(crate) fn restore_guard(&mut self, state: Option<GuardState>) {
        let Some(guard) = &mut self.guard else { return };
        let (now, then) = (guard.state, state.unwrap_or_default());
        (guard.state, guard.limit) = (then, None);
        let tolerance = guard.tolerance;
        match (now.own, then.own) {
            (Some(own), None) => self.change_engine(own, tolerance),
            (None, Some(_)) => {
                // Its own may have been changed since.
                if let Some(guard) = &mut self.guard {
                    guard.state.own = Some(self.engine_kind);
                }
                self.change_engine(GUARDED, tolerance);
            }
            _ => {}
        }
    }

    pub(crate) fn level(&self) -> Level {
        let each = self.v.iter().zip(&self.mass).zip(&self.inverse_mass);
        let motion = each.filter(|(_, w)| **w > 0.0).map(|((v, m), _)| 0.5 * m * v.length_squared()).sum();
        Level { motion, elastic: energy::elastic(self) }
    }

    /// Energy of motion that it had at the start of the step, J.
    pub(crate) fn energy_at_start(&self) -> f64 {
        self.work.start.1.iter().zip(&self.mass).map(|(v, m)| 0.5 * m * v.length_squared()).sum()
    }

    /// What gravity, applied forces and pressure have done to free masses on their way from `from`, J.
    pub(crate) fn work_since(&self, from: &Vectors, field: &Field) -> f64 {
        let mut work = self.drag.pushed(from, &self.x);
        for (i, w) in self.inverse_mass.iter().enumerate() {
            if *w > 0.0 {
                let force = field.gravity * self.mass[i] + self.applied.get(i);
                work += force.dot(self.x.get(i) - from.get(i));
            }
        }
        work
    }

    /// Energy (J) that a sound step of `dt` s may gain besides: by what leads pins and by the wind, and by the error of the coarsest
    /// engine in free fall.
    pub(crate) fn may_gain(&self, field: &Field, dt: f64) -> f64 {
        let held = (0..self.masses()).filter(|i| self.inverse_mass[*i] == 0.0);
        let led = held.map(|i| self.v.get(i).length_squared()).fold(0.0, f64::max);
        let glued = self.pins.glued_states().map(|(_, b)| b.velocity().length_squared()).fold(0.0, f64::max);
        let wind = if field.air_density > 0.0 { field.wind.length_squared() } else { 0.0 };
        let fall = field.gravity.length_squared() * dt * dt;
        self.total_mass() * (LED * led.max(glued) + wind + fall)
    }

    /// Masses that belong together: those that springs join, or the neighbours of a shell, and their distances in the flat sheet.
    fn joints(&self) -> impl Iterator<Item = Joint> + '_ {
        let springs = &self.springs;
        let closed = (0..springs.len()).filter(|i| springs.stiffness[*i] > 0.0);
        let joined = closed.map(|i| Joint { ends: [springs.a[i], springs.b[i]], rest: springs.rest[i] });
        let edges = if springs.is_empty() { self.edges() } else { Vec::new() };
        let place = |i: u32| {
            let (u, v) = self.uv[i as usize];
            DVec3::new(u * self.extent.0, v * self.extent.1, 0.0)
        };
        joined.chain(edges.into_iter().map(move |ends| Joint { ends, rest: place(ends[0]).distance(place(ends[1])) }))
    }

    pub(crate) fn strain_limit(&self) -> StrainLimit {
        StrainLimit::new(self.joints())
    }

    /// Largest strain between masses that belong together, as it lies; infinite where it is no number.
    pub(crate) fn largest_strain(&self) -> f64 {
        largest_strain(self.joints(), &self.x)
    }

    /// Brings the energy of motion down to `most` (J), the motion of the whole left as it is as long as nothing holds it; whether there
    /// was anything to do.
    pub(crate) fn slow_down(&mut self, most: f64) -> bool {
        let motion = self.level().motion;
        if motion <= most {
            return false;
        }
        let whole = self.whole_motion(&self.x, &self.v);
        let at = |i: usize| whole.at(self.x.get(i));
        let own: f64 = (0..self.masses()).map(|i| 0.5 * self.mass[i] * at(i).length_squared()).sum();
        // The two parts of the motion are orthogonal, so that their energies add.
        let keep = ((most - own).max(0.0) / (motion - own).max(f64::MIN_POSITIVE)).min(1.0).sqrt();
        for i in 0..self.masses() {
            if self.inverse_mass[i] > 0.0 {
                let base = whole.at(self.x.get(i));
                self.v.set(i, base + (self.v.get(i) - base) * keep);
            }
        }
        true
    }

    /// Slows its turning as a whole until its energy of motion is `most` (J), or it turns no more: what an engine that has failed took it to
    /// says little of how it turned.
    pub(crate) fn slow_spin(&mut self, most: f64) {
        let whole = self.whole_motion(&self.x, &self.v);
        let turning = |i: usize| whole.spin.cross(self.x.get(i) - whole.centre);
        let turns: f64 = (0..self.masses()).map(|i| 0.5 * self.mass[i] * turning(i).length_squared()).sum();
        let excess = self.level().motion - most;
        if excess > 0.0 && turns > 0.0 {
            let less = 1.0 - (1.0 - excess / turns).max(0.0).sqrt();
            for i in 0..self.masses() {
                let slowed = self.v.get(i) - turning(i) * less;
                self.v.set(i, slowed);
            }
        }
    }

    /// Has it move as it did when the part of the step began, but for `fallen` (m/s), where its motion as a whole has more than `most` (J): air pushes what has
    /// failed with any force.
    pub(crate) fn slow_drift(&mut self, most: f64, fallen: DVec3) {
        if !self.pins.is_empty() || self.level().motion <= most {
            return;
        }
        let total = self.total_mass();
        let mean = |v: &Vectors| v.iter().zip(&self.mass).map(|(v, m)| v * *m).sum::<DVec3>() / total;
        let (was, is) = (mean(&self.work.v_before) + fallen, mean(&self.v));
        if is.length_squared() > was.length_squared() {
            for i in 0..self.masses() {
                let moved = self.v.get(i) + (was - is);
                self.v.set(i, moved);
            }
        }
    }

    /// Takes the sheet from where it was at `start` as an engine has taken it to `end` (positions, velocities) in `dt` s, but with a `part`
    /// (0 to 1) of what it did beyond moving the whole.
    pub(crate) fn carry_part(&mut self, start: &Vectors, end: (&Vectors, &Vectors), dt: f64, part: f64) {
        let shift = self.shift(start, end.0, dt);
        let turn = DQuat::from_scaled_axis(shift.spin * dt);
        let total = self.total_mass();
        let ahead = shift.centre + shift.velocity * dt;
        let drift = (0..self.masses()).map(|i| end.1.get(i) * self.mass[i]).sum::<DVec3>() / total;
        // What something holds does not move as a whole.
        let drift = if self.pins.is_empty() { drift } else { DVec3::ZERO };
        for i in 0..self.masses() {
            if self.inverse_mass[i] == 0.0 {
                self.x.set(i, end.0.get(i));
                self.v.set(i, end.1.get(i));
                continue;
            }
            let carried = ahead + turn * (start.get(i) - shift.centre);
            self.x.set(i, carried + (end.0.get(i) - carried) * part);
            let base = drift + shift.spin.cross(carried - ahead);
            self.v.set(i, base + (end.1.get(i) - base) * part);
        }
    }

    /// Largest change of strain that [`Sheet::carry_part`] of all would bring.
    pub(crate) fn stretch_to(&self, limit: &StrainLimit, start: &Vectors, end: &Vectors, dt: f64) -> f64 {
        let shift = self.shift(start, end, dt);
        let turn = DQuat::from_scaled_axis(shift.spin * dt);
        let own = |i: u32| {
            let (from, to) = (start.get(i as usize), end.get(i as usize));
            to - (shift.centre + shift.velocity * dt + turn * (from - shift.centre))
        };
        limit.joints().iter().map(|j| own(j.ends[0]).distance(own(j.ends[1])) / j.rest).fold(0.0, f64::max)
    }

    /// The motion of the whole that takes it from `start` to `end` in `dt` s.
    fn shift(&self, start: &Vectors, end: &Vectors, dt: f64) -> Whole {
        let rate = |i: usize| (end.get(i) - start.get(i)) / dt;
        self.whole_of(start, rate)
    }

    fn whole_motion(&self, x: &Vectors, v: &Vectors) -> Whole {
        self.whole_of(x, |i| v.get(i))
    }

    /// The rigid motion with the momenta of masses at `x` that move with `v`; none of a sheet that something holds.
    fn whole_of(&self, x: &Vectors, v: impl Fn(usize) -> DVec3) -> Whole {
        if !self.pins.is_empty() {
            return Whole::default();
        }
        let total = self.total_mass();
        let mean =
            |of: &dyn Fn(usize) -> DVec3| (0..self.masses()).map(|i| of(i) * self.mass[i]).sum::<DVec3>() / total;
        let (centre, velocity) = (mean(&|i| x.get(i)), mean(&v));
        let (mut inertia, mut turning) = (DMat3::ZERO, DVec3::ZERO);
        for (i, m) in self.mass.iter().enumerate() {
            let r = x.get(i) - centre;
            let outer = DMat3::from_cols(r * r.x, r * r.y, r * r.z);
            inertia += (DMat3::from_diagonal(DVec3::splat(r.length_squared())) - outer) * *m;
            turning += r.cross(v(i) - velocity) * *m;
        }
        let size = inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z;
        let turns = inertia.determinant() > 1e-9 * size * size * size;
        let spin = if turns { inertia.inverse() * turning } else { DVec3::ZERO };
        Whole { centre, velocity, spin }
    }
}

/// A rigid motion: of the place `centre` (m) with `velocity` (m/s), and about it with `spin` (rad/s).
#[derive(Clone, Copy, Default)]
struct Whole {
    centre: DVec3,
    velocity: DVec3,
    spin: DVec3,
}

impl Whole {
    fn at(&self, x: DVec3) -> DVec3 {
        self.velocity + self.spin.cross(x - self.centre)
    }
}
