//! Time integrators: each is one row in [`TABLE`].
//!
//! An integrator advances positions and velocities of x'' = a(t, x, v). It has no knowledge of
//! elements and evaluates accelerations through [`Forces`]. Fixed and kinematic nodes have zero
//! acceleration and their prescribed velocity, which every integrator reproduces exactly. Explicit
//! fixed-step integrators have no state between steps; `rk45` stores its step size, `tr-bdf2`
//! accelerations, and `bdf2` the previous step.
//!
//! `docs/integrators.md` tabulates accuracy and stability on x'' = -ω²x; the conformance tests
//! measure them.

pub(crate) mod backward_euler;
pub(crate) mod bdf2;
pub(crate) mod euler_richardson;
pub(crate) mod first_order;
pub mod implicit;
pub(crate) mod rk4;
pub(crate) mod rk45;
pub mod settings;
pub(crate) mod tr_bdf2;
pub(crate) mod verlet;

use glam::DVec3;

use crate::error::named_in_table;
use crate::math::Vectors;
use crate::scene::IntegratorKind;
use crate::serialize::{ReadResult, StateReader, StateWriter};

/// Accelerations of a set of nodes.
pub trait Forces {
    /// Writes the accelerations (m/s²) at time `t` (s), positions `x` (m) and velocities `v` (m/s)
    /// to `a`.
    fn accelerations(&mut self, t: f64, x: &Vectors, v: &Vectors, a: &mut Vectors);

    /// The nodes as a problem for implicit integrators; `None` if it was not prepared.
    fn implicit(&mut self) -> Option<&mut dyn implicit::ImplicitProblem> {
        None
    }
}

/// Result of [`Integrator::advance`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AdvanceReport {
    /// Elapsed time, s; less than requested only for an adaptive integrator.
    pub elapsed: f64,
    /// Accepted steps.
    pub accepted: u64,
    /// Steps rejected because of their error.
    pub rejected: u64,
    /// Calls of [`Forces::accelerations`]; linear solves of an implicit integrator.
    pub evaluations: u64,
    /// Stages of an implicit integrator that the globalised Newton method completed.
    pub globalised: u64,
}

/// A time integrator with its working arrays.
pub trait Integrator: Send + Sync {
    /// Advances `x` (m) and `v` (m/s) from time `t` (s) by `dt` (s), or by less if the integrator
    /// is adaptive. Implicit integrators have this default: their stages in turn.
    fn advance(
        &mut self,
        forces: &mut dyn Forces,
        _t: f64,
        dt: f64,
        x: &mut Vectors,
        v: &mut Vectors,
    ) -> AdvanceReport {
        self.staged().map_or_else(AdvanceReport::default, |scheme| implicit::staged::advance(scheme, forces, dt, x, v))
    }

    /// The integrator stage by stage; `None` if it is explicit.
    fn staged(&mut self) -> Option<&mut dyn implicit::staged::StagedIntegrator> {
        None
    }

    /// The value of [`IntegratorInfo::drift`] for the next step of `dt` s; `None` if it is
    /// constant.
    fn drift(&self, _dt: f64) -> Option<f64> {
        None
    }

    /// Sets the position error (m) that an adaptive integrator accepts per step; others ignore it.
    fn set_tolerance(&mut self, _tolerance: f64) {}

    /// Visits the values that persist from step to step, in one order, once a step has been taken.
    fn visit_history(&mut self, _visit: &mut dyn FnMut(&mut [f64])) {}

    /// Serialises the values of [`Integrator::visit_history`] and the step size of an adaptive
    /// integrator.
    fn serialise(&self, _to: &mut StateWriter) {}

    /// Deserialises the values of [`Integrator::serialise`], for the given number of nodes.
    fn deserialise(&mut self, _from: &mut StateReader, _masses: usize) -> ReadResult {
        Ok(())
    }

    /// Discards the history. Called after anything but the integrator has moved the sheet far.
    fn restart(&mut self) {}

    /// Add `by` (m/s²) to the stored acceleration of `node`, if there is one: a force on it begins
    /// or ends between two steps.
    fn add_acceleration(&mut self, _node: usize, _by: DVec3) {}
}

/// An integrator without effect: placeholder in a sheet while its own integrator works on it.
pub(crate) struct IdleIntegrator;

impl Integrator for IdleIntegrator {
    fn advance(
        &mut self,
        _forces: &mut dyn Forces,
        _t: f64,
        dt: f64,
        _x: &mut Vectors,
        _v: &mut Vectors,
    ) -> AdvanceReport {
        AdvanceReport { elapsed: dt, ..AdvanceReport::default() }
    }
}

/// Row of the table of integrators.
pub struct IntegratorInfo {
    /// Kind.
    pub kind: IntegratorKind,
    /// Name in files and on the command line.
    pub name: &'static str,
    /// One-line description.
    pub about: &'static str,
    /// Order of convergence of positions at a fixed time.
    pub order: u32,
    /// Largest hω without growth of an undamped oscillation; 0 for unconditional weak growth,
    /// infinite for implicit integrators.
    pub stability_limit: f64,
    /// Evaluations of the forces per step; for an implicit integrator its stages, each with one or
    /// more linear solves.
    pub evaluations: u32,
    /// Weight θ of a constant acceleration in the displacement of a step, Δx = v h + θ a h²: ½
    /// except for the Euler integrators. Contact changes displacements with the weight θ too, so
    /// that nodes in contact stay in step with their neighbours.
    pub drift: f64,
    /// Whether it chooses its own steps within `dt`.
    pub adaptive: bool,
    /// Whether it solves for the end of the step.
    pub implicit: bool,
    /// Amplification of x'' = -ω²x per step as a function of ω dt (rad): remaining amplitude and
    /// phase advance (rad). Given for integrators with long steps, where it matters.
    pub amplification: Option<fn(f64) -> (f64, f64)>,
    /// Constructor.
    pub(crate) make: fn() -> Box<dyn Integrator>,
}

impl IntegratorInfo {
    /// Properties that most explicit integrators share, without name and order.
    const EXPLICIT: Self = Self {
        kind: IntegratorKind::Analytical,
        name: "",
        about: "",
        order: 0,
        stability_limit: 0.0,
        evaluations: 0,
        drift: 0.5,
        adaptive: false,
        implicit: false,
        amplification: None,
        make: || Box::new(IdleIntegrator),
    };
    /// Properties that most implicit integrators share, without name and order.
    const IMPLICIT: Self = Self { stability_limit: f64::INFINITY, implicit: true, ..Self::EXPLICIT };
}

/// Every integrator, in the order of menus.
pub const TABLE: &[IntegratorInfo] = &[
    first_order::ANALYTICAL,
    first_order::EULER,
    first_order::EULER_CROMER,
    euler_richardson::INFO,
    verlet::INFO,
    rk4::INFO,
    rk45::INFO,
    tr_bdf2::INFO,
    backward_euler::INFO,
    bdf2::INFO,
];

impl IntegratorKind {
    /// The row of this kind in [`TABLE`].
    pub fn info(self) -> &'static IntegratorInfo {
        // The test `every_kind_is_in_the_table` checks that every kind has a row.
        TABLE.iter().find(|e| e.kind == self).unwrap_or(&TABLE[0])
    }

    /// A new integrator of this kind.
    pub fn construct(self) -> Box<dyn Integrator> {
        (self.info().make)()
    }
}

named_in_table!(IntegratorKind, TABLE, "engine");

/// Resizes `buffer` to the length of `like`; does not allocate if the lengths agree.
fn resize_like(buffer: &mut Vectors, like: &Vectors) {
    if buffer.len() != like.len() {
        *buffer = Vectors::zeros(like.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_in_the_table() {
        for row in TABLE {
            assert_eq!(row.kind.name(), row.name);
            assert_eq!(row.name.parse::<IntegratorKind>(), Ok(row.kind));
        }
        assert!("euler-kramer".parse::<IntegratorKind>().expect_err("no such engine").problem.contains("euler-cromer"));
    }
}
