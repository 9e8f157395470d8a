//! Instability detector and recovery policy of a sheet. [`crate::islands`] applies the actions; a
//! sheet with the policy `Stop` has none of this state.
//!
//! The step of an integrator can only convert the energy of the sheet and the work of gravity,
//! applied forces, prescribed nodes and air into motion and strain:
//!
//!   ΔT + ΔV ≤ W,
//!
//! with kinetic energy T, elastic energy V and work W (J) of the dynamic nodes. Contact follows the
//! integrator and is not in this balance. For a whole step, W also holds the energy from bodies and
//! other sheets.

use glam::{DMat3, DQuat, DVec3};

use crate::elements::strain_limit::{self, LimitedSpring, StrainLimit};
use crate::math::Vectors;
use crate::scene::{IntegratorKind, WhenUnstable};
use crate::serialize::{CorruptState, ReadResult, State, StateReader, StateWriter};
use crate::sheet::{Field, Sheet, energy};

/// Implicit integrator that replaces one that failed.
pub(crate) const RECOVERY_INTEGRATOR: IntegratorKind = IntegratorKind::TrBdf2;

/// Delay (s of simulated time) without a detection after which a step is lengthened or the original
/// integrator is tried again: initial value, and maximum. The delay doubles after each attempt that
/// came too early.
const MIN_RECOVERY_DELAY: f64 = 0.25;
const MAX_RECOVERY_DELAY: f64 = 8.0;

/// Allowed work of prescribed motion per step, over m v² of the whole sheet at the speed v of a
/// prescribed node or kinematic body. Work against the tension of a sheet at the explicit stability
/// limit is about this large.
pub(crate) const PRESCRIBED_MOTION_ENERGY_FACTOR: f64 = 32.0;

/// Actions of a recovery policy so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RecoveryState {
    /// Base-2 logarithm of the number of substeps.
    pub bisections: u32,
    /// Whether the strain of springs is limited.
    pub limits_strain: bool,
    /// Replaced integrator, while the implicit one takes its place.
    pub replaced_integrator: Option<IntegratorKind>,
    /// Whether the integrator is replaced before the next step.
    pub replaces_integrator: bool,
    /// Energy budget (J) of a sheet with strain limiting, without strain from contact.
    pub energy_budget: f64,
    /// Energy error that has not decayed, J.
    pub energy_error: f64,
    /// Time since the last detection (s), the delay before an action is relaxed (s), and whether
    /// one has been relaxed since.
    pub time_since_detection: f64,
    pub delay: f64,
    pub is_relaxed: bool,
}

impl Default for RecoveryState {
    fn default() -> Self {
        Self {
            bisections: 0,
            limits_strain: false,
            replaced_integrator: None,
            replaces_integrator: false,
            energy_budget: 0.0,
            energy_error: 0.0,
            time_since_detection: 0.0,
            delay: MIN_RECOVERY_DELAY,
            is_relaxed: false,
        }
    }
}

impl RecoveryState {
    /// Whether any action is in effect.
    pub fn is_active(&self) -> bool {
        self.bisections > 0 || self.limits_strain || self.replaced_integrator.is_some() || self.replaces_integrator
    }

    /// Double the number of substeps, up to `parts`; return the new number, or `None` at the limit.
    pub fn bisect(&mut self, parts: u32) -> Option<u32> {
        (2_u32 << self.bisections <= parts).then(|| {
            self.bisections += 1;
            1 << self.bisections
        })
    }

    /// Record a detection.
    pub fn record_detection(&mut self) {
        if std::mem::take(&mut self.is_relaxed) {
            self.delay = (2.0 * self.delay).min(MAX_RECOVERY_DELAY);
        }
        (self.time_since_detection, self.energy_error) = (0.0, 0.0);
    }

    /// Add `dt` (s) without a detection; true when an action can be relaxed.
    pub fn advance_time(&mut self, dt: f64) -> bool {
        self.time_since_detection += dt;
        if self.time_since_detection < self.delay {
            return false;
        }
        self.time_since_detection = 0.0;
        if !self.is_active() {
            (self.delay, self.is_relaxed) = (MIN_RECOVERY_DELAY, false);
            return false;
        }
        self.is_relaxed = true;
        true
    }

    /// Serialise the state.
    pub fn serialise(&self, to: &mut StateWriter) {
        to.count(self.bisections.into());
        [self.limits_strain, self.replaces_integrator, self.is_relaxed, self.replaced_integrator.is_some()]
            .serialise(to);
        self.replaced_integrator.iter().for_each(|own| to.text(own.name()));
        to.numbers(&[self.energy_budget, self.energy_error, self.time_since_detection, self.delay]);
    }

    /// Deserialise a state.
    pub fn deserialise(from: &mut StateReader) -> ReadResult<Self> {
        let mut state = Self { bisections: from.read()?, ..Self::default() };
        [state.limits_strain, state.replaces_integrator, state.is_relaxed] = from.read()?;
        if from.flag()? {
            state.replaced_integrator = Some(from.text()?.parse().map_err(|_| CorruptState)?);
        }
        (state.energy_budget, state.energy_error) = from.read()?;
        (state.time_since_detection, state.delay) = from.read()?;
        // The scene reader limits a step to 2^12 substeps.
        let numbers = [state.energy_budget, state.energy_error, state.time_since_detection];
        let is_sound = state.bisections <= 12 && numbers.iter().all(|n| *n >= 0.0) && state.delay > 0.0;
        if is_sound { Ok(state) } else { Err(CorruptState) }
    }
}

/// Recovery policy of a sheet and its workspace.
pub(crate) struct RecoveryPolicy {
    pub policy: WhenUnstable,
    pub state: RecoveryState,
    /// Energy at the start of the world's step, or the energy budget of a sheet with strain
    /// limiting, J.
    pub energy_budget: f64,
    /// Error tolerance of an adaptive integrator, m.
    pub tolerance: f64,
    /// Strain limit, with the fracture revision that it was built for; created on demand.
    pub limit: Option<(u64, StrainLimit)>,
    /// Positions at the start of an integrator step, and positions and velocities at its end.
    pub start: Vectors,
    pub end: (Vectors, Vectors),
}

/// Kinetic energy of the dynamic nodes and elastic energy of the sheet, J.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct KineticElasticEnergy {
    pub kinetic: f64,
    pub elastic: f64,
}

impl KineticElasticEnergy {
    /// Sum of both, J.
    pub fn total(self) -> f64 {
        self.kinetic + self.elastic
    }
}

impl Sheet {
    /// Recovery policy after an instability.
    pub fn when_unstable(&self) -> WhenUnstable {
        self.recovery.as_ref().map_or(WhenUnstable::Stop, |g| g.policy)
    }

    /// Change the recovery policy; actions of the previous policy are undone.
    ///
    /// # Errors
    /// When its number is out of range; nothing is changed then.
    pub fn set_when_unstable(&mut self, policy: WhenUnstable) -> Result<(), crate::InputError> {
        policy.check()?;
        set_recovery_policy(self, policy, self.recovery.as_ref().map_or(1e-7, |g| g.tolerance));
        self.wake();
        Ok(())
    }
}

/// Chosen integrator, also while another one replaces it.
pub(crate) fn chosen_engine(sheet: &Sheet) -> IntegratorKind {
    sheet.recovery.as_ref().and_then(|g| g.state.replaced_integrator).unwrap_or(sheet.engine_kind)
}

pub(crate) fn set_recovery_policy(sheet: &mut Sheet, policy: WhenUnstable, tolerance: f64) {
    if let Some(own) = sheet.recovery.as_mut().and_then(|g| g.state.replaced_integrator.take()) {
        sheet.change_engine(own, tolerance);
    }
    let watched = policy != WhenUnstable::Stop;
    let guard = || {
        let state = RecoveryState::default();
        Box::new(RecoveryPolicy {
            policy,
            state,
            energy_budget: 0.0,
            tolerance,
            limit: None,
            start: Vectors::default(),
            end: Default::default(),
        })
    };
    sheet.recovery = watched.then(guard);
}

/// Restore the recovery state of another time.
pub(crate) fn restore_recovery_state(sheet: &mut Sheet, state: Option<RecoveryState>) {
    let Some(guard) = &mut sheet.recovery else { return };
    let (now, then) = (guard.state, state.unwrap_or_default());
    (guard.state, guard.limit) = (then, None);
    let tolerance = guard.tolerance;
    match (now.replaced_integrator, then.replaced_integrator) {
        (Some(own), None) => sheet.change_engine(own, tolerance),
        (None, Some(_)) => {
            // The chosen integrator may differ from the one of that time.
            if let Some(guard) = &mut sheet.recovery {
                guard.state.replaced_integrator = Some(sheet.engine_kind);
            }
            sheet.change_engine(RECOVERY_INTEGRATOR, tolerance);
        }
        _ => {}
    }
}

pub(crate) fn kinetic_elastic_energy(sheet: &Sheet) -> KineticElasticEnergy {
    let each = sheet.state.v.iter().zip(&sheet.model.mass).zip(&sheet.inverse_mass);
    let motion = each.filter(|(_, w)| **w > 0.0).map(|((v, m), _)| 0.5 * m * v.length_squared()).sum();
    KineticElasticEnergy { kinetic: motion, elastic: energy::elastic(sheet) }
}

/// Kinetic energy at the start of the step, J.
pub(crate) fn energy_at_start(sheet: &Sheet) -> f64 {
    sheet.work.start.1.iter().zip(&sheet.model.mass).map(|(v, m)| 0.5 * m * v.length_squared()).sum()
}

/// Work of gravity, applied forces and pressure on the dynamic nodes since the positions
/// `from`, J.
pub(crate) fn work_of_loads(sheet: &Sheet, from: &Vectors, field: &Field) -> f64 {
    let mut work = sheet.parameters.drag.pushed(from, &sheet.state.x);
    for (i, w) in sheet.inverse_mass.iter().enumerate() {
        if *w > 0.0 {
            let force = field.gravity * sheet.model.mass[i] + sheet.parameters.applied.get(i);
            work += force.dot(sheet.state.x.get(i) - from.get(i));
        }
    }
    work
}

/// Tolerance of the energy balance of a step of `dt` (s), J: work of prescribed nodes and wind,
/// and the error of the coarsest integrator in free fall.
pub(crate) fn energy_gain_tolerance(sheet: &Sheet, field: &Field, dt: f64) -> f64 {
    let held = (0..sheet.node_count()).filter(|i| sheet.inverse_mass[*i] == 0.0);
    let led = held.map(|i| sheet.state.v.get(i).length_squared()).fold(0.0, f64::max);
    let glued = sheet.pins.attached_body_states().map(|(_, b)| b.velocity().length_squared()).fold(0.0, f64::max);
    let wind = sheet.parameters.drag.wind_squared(field);
    let fall = field.gravity.length_squared() * dt * dt;
    sheet.total_mass() * (PRESCRIBED_MOTION_ENERGY_FACTOR * led.max(glued) + wind + fall)
}

/// Pairs of nodes joined by a spring, or neighbours in a shell, with their distances in the
/// flat sheet.
fn strain_pairs(sheet: &Sheet) -> impl Iterator<Item = LimitedSpring> + '_ {
    let springs = &sheet.springs;
    let closed = (0..springs.len()).filter(|i| springs.stiffness[*i] > 0.0);
    let joined = closed.map(|i| LimitedSpring { ends: [springs.a[i], springs.b[i]], rest: springs.rest[i] });
    let edges = if springs.is_empty() { sheet.edges() } else { Vec::new() };
    let place = |i: u32| {
        let [u, v] = sheet.model.place(i);
        DVec3::new(u, v, 0.0)
    };
    joined
        .chain(edges.into_iter().map(move |ends| LimitedSpring { ends, rest: place(ends[0]).distance(place(ends[1])) }))
}

pub(crate) fn strain_limit(sheet: &Sheet) -> StrainLimit {
    StrainLimit::new(strain_pairs(sheet))
}

/// Largest present strain between joined nodes; infinite for non-finite positions.
pub(crate) fn largest_strain(sheet: &Sheet) -> f64 {
    strain_limit::largest_strain(strain_pairs(sheet), &sheet.state.x)
}

/// Reduce the kinetic energy to `most` (J). The motion relative to the rigid motion slows down;
/// a sheet without fixed nodes keeps its rigid motion. Return whether the energy was above
/// `most`.
pub(crate) fn limit_kinetic_energy(sheet: &mut Sheet, most: f64) -> bool {
    let motion = kinetic_elastic_energy(sheet).kinetic;
    if motion <= most {
        return false;
    }
    let whole = rigid_velocity(sheet, &sheet.state.x, &sheet.state.v);
    let at = |i: usize| whole.at(sheet.state.x.get(i));
    let own: f64 = (0..sheet.node_count()).map(|i| 0.5 * sheet.model.mass[i] * at(i).length_squared()).sum();
    // The rigid and the relative motion are orthogonal, so their energies add.
    let keep = ((most - own).max(0.0) / (motion - own).max(f64::MIN_POSITIVE)).min(1.0).sqrt();
    for i in 0..sheet.node_count() {
        if sheet.inverse_mass[i] > 0.0 {
            let base = whole.at(sheet.state.x.get(i));
            sheet.state.v.set(i, base + (sheet.state.v.get(i) - base) * keep);
        }
    }
    true
}

/// Reduce the spin of the whole sheet until its kinetic energy is `most` (J) or the spin is
/// zero. After a failed integrator step the spin is unreliable.
pub(crate) fn limit_spin(sheet: &mut Sheet, most: f64) {
    let whole = rigid_velocity(sheet, &sheet.state.x, &sheet.state.v);
    let turning = |i: usize| whole.spin.cross(sheet.state.x.get(i) - whole.centre);
    let turns: f64 = (0..sheet.node_count()).map(|i| 0.5 * sheet.model.mass[i] * turning(i).length_squared()).sum();
    let excess = kinetic_elastic_energy(sheet).kinetic - most;
    if excess > 0.0 && turns > 0.0 {
        let less = 1.0 - (1.0 - excess / turns).max(0.0).sqrt();
        for i in 0..sheet.node_count() {
            let slowed = sheet.state.v.get(i) - turning(i) * less;
            sheet.state.v.set(i, slowed);
        }
    }
}

/// Restore the mean velocity at the start of the substep plus `fallen` (m/s), for a free sheet
/// whose kinetic energy is above `most` (J) and whose mean speed has grown. The air force on a
/// failed state is unreliable.
pub(crate) fn limit_drift(sheet: &mut Sheet, most: f64, fallen: DVec3) {
    if !sheet.pins.is_empty() || kinetic_elastic_energy(sheet).kinetic <= most {
        return;
    }
    let total = sheet.total_mass();
    let mean = |v: &Vectors| v.iter().zip(&sheet.model.mass).map(|(v, m)| v * *m).sum::<DVec3>() / total;
    let (was, is) = (mean(&sheet.work.v_before) + fallen, mean(&sheet.state.v));
    if is.length_squared() > was.length_squared() {
        for i in 0..sheet.node_count() {
            sheet.state.v.add(i, was - is);
        }
    }
}

/// Fallback: scale back a step from `start` to `end` (positions, velocities) of `dt` (s). The
/// rigid motion stays, and `part` (0 to 1) of the remaining motion is kept.
pub(crate) fn scale_back_step(sheet: &mut Sheet, start: &Vectors, end: (&Vectors, &Vectors), dt: f64, part: f64) {
    let shift = mean_rigid_velocity(sheet, start, end.0, dt);
    let turn = DQuat::from_scaled_axis(shift.spin * dt);
    let total = sheet.total_mass();
    let ahead = shift.centre + shift.velocity * dt;
    let drift = (0..sheet.node_count()).map(|i| end.1.get(i) * sheet.model.mass[i]).sum::<DVec3>() / total;
    // A sheet with fixed nodes has no free rigid motion.
    let drift = if sheet.pins.is_empty() { drift } else { DVec3::ZERO };
    for i in 0..sheet.node_count() {
        if sheet.inverse_mass[i] == 0.0 {
            sheet.state.x.set(i, end.0.get(i));
            sheet.state.v.set(i, end.1.get(i));
            continue;
        }
        let carried = ahead + turn * (start.get(i) - shift.centre);
        sheet.state.x.set(i, carried + (end.0.get(i) - carried) * part);
        let base = drift + shift.spin.cross(carried - ahead);
        sheet.state.v.set(i, base + (end.1.get(i) - base) * part);
    }
}

/// Largest change of strain of the whole step, the rigid motion excluded.
pub(crate) fn largest_strain_change(
    sheet: &Sheet,
    limit: &StrainLimit,
    start: &Vectors,
    end: &Vectors,
    dt: f64,
) -> f64 {
    let shift = mean_rigid_velocity(sheet, start, end, dt);
    let turn = DQuat::from_scaled_axis(shift.spin * dt);
    let own = |i: u32| {
        let (from, to) = (start.get(i as usize), end.get(i as usize));
        to - (shift.centre + shift.velocity * dt + turn * (from - shift.centre))
    };
    limit.joints().iter().map(|j| own(j.ends[0]).distance(own(j.ends[1])) / j.rest).fold(0.0, f64::max)
}

/// Rigid velocity from `start` to `end` within `dt` (s).
fn mean_rigid_velocity(sheet: &Sheet, start: &Vectors, end: &Vectors, dt: f64) -> RigidVelocity {
    let rate = |i: usize| (end.get(i) - start.get(i)) / dt;
    rigid_velocity_of(sheet, start, rate)
}

fn rigid_velocity(sheet: &Sheet, x: &Vectors, v: &Vectors) -> RigidVelocity {
    rigid_velocity_of(sheet, x, |i| v.get(i))
}

/// Rigid velocity with the momenta of the nodes at `x` with velocities `v`; zero for a sheet
/// with pins.
fn rigid_velocity_of(sheet: &Sheet, x: &Vectors, v: impl Fn(usize) -> DVec3) -> RigidVelocity {
    if !sheet.pins.is_empty() {
        return RigidVelocity::default();
    }
    let total = sheet.total_mass();
    let mean = |of: &dyn Fn(usize) -> DVec3| {
        (0..sheet.node_count()).map(|i| of(i) * sheet.model.mass[i]).sum::<DVec3>() / total
    };
    let (centre, velocity) = (mean(&|i| x.get(i)), mean(&v));
    let (mut inertia, mut turning) = (DMat3::ZERO, DVec3::ZERO);
    for (i, m) in sheet.model.mass.iter().enumerate() {
        let r = x.get(i) - centre;
        let outer = DMat3::from_cols(r * r.x, r * r.y, r * r.z);
        inertia += (DMat3::from_diagonal(DVec3::splat(r.length_squared())) - outer) * *m;
        turning += r.cross(v(i) - velocity) * *m;
    }
    let size = inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z;
    let turns = inertia.determinant() > 1e-9 * size * size * size;
    let spin = if turns { inertia.inverse() * turning } else { DVec3::ZERO };
    RigidVelocity { centre, velocity, spin }
}

/// Velocity of a rigid motion: `velocity` (m/s) at the point `centre` (m), and `spin` (rad/s).
#[derive(Clone, Copy, Default)]
struct RigidVelocity {
    centre: DVec3,
    velocity: DVec3,
    spin: DVec3,
}

impl RigidVelocity {
    fn at(&self, x: DVec3) -> DVec3 {
        self.velocity + self.spin.cross(x - self.centre)
    }
}
