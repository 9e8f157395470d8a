//! Explicit integrators of order 1: one evaluation of the accelerations a at the start of the step.
//! They differ in the update of x and v. Growth of the energy on x'' = -ω²x is given with a =
//! hω.

use crate::integrators::{AdvanceReport, Forces, Integrator, IntegratorInfo, resize_like};
use crate::math::Vectors;
use crate::scene::IntegratorKind;

/// Explicit Euler (thesis equation 3.17): x ← x + v h, v ← v + a h, both evaluated at the start
/// of the step.
///
/// The energy grows by exactly (1 + a²) per step.
pub(crate) const EULER: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::Euler,
    name: "euler",
    about: "explicit Euler, order 1",
    order: 1,
    evaluations: 1,
    drift: 0.0,
    make: || {
        make(|dt, a, x, v| {
            x.add_scaled(dt, v);
            v.add_scaled(dt, a);
        })
    },
    ..IntegratorInfo::EXPLICIT
};

/// Euler-Cromer, the thesis's first-order integrator (equations 3.18 and 3.19): v ← v + a h, then
/// x ← x + v h with the new v.
///
/// Symplectic: stable for a up to 2, and the energy oscillates by about ±a/2.
pub(crate) const EULER_CROMER: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::EulerCromer,
    name: "euler-cromer",
    about: "semi-implicit Euler, order 1, symplectic (thesis, first order)",
    order: 1,
    stability_limit: 2.0,
    evaluations: 1,
    drift: 1.0,
    make: || {
        make(|dt, a, x, v| {
            v.add_scaled(dt, a);
            x.add_scaled(dt, v);
        })
    },
    ..IntegratorInfo::EXPLICIT
};

/// The thesis's "analytical" integrator, constant acceleration over the step: x ← x + v h + ½
/// a h², v ← v + a h. The velocity is Euler's, hence order 1.
///
/// The energy grows by (1 + a²/2) per step: exact for free fall, always unstable for an undamped
/// spring.
pub(crate) const ANALYTICAL: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::Analytical,
    name: "analytical",
    about: "constant acceleration over the step (thesis)",
    order: 1,
    evaluations: 1,
    make: || {
        make(|dt, a, x, v| {
            x.add_scaled(dt, v);
            x.add_scaled(0.5 * dt * dt, a);
            v.add_scaled(dt, a);
        })
    },
    ..IntegratorInfo::EXPLICIT
};

/// Update of x and v by a step of `dt` (s) with the accelerations a.
type Update = fn(dt: f64, a: &Vectors, x: &mut Vectors, v: &mut Vectors);

struct FirstOrder {
    a: Vectors,
    update: Update,
}

fn make(update: Update) -> Box<dyn Integrator> {
    Box::new(FirstOrder { a: Vectors::default(), update })
}

impl Integrator for FirstOrder {
    fn advance(&mut self, forces: &mut dyn Forces, t: f64, dt: f64, x: &mut Vectors, v: &mut Vectors) -> AdvanceReport {
        resize_like(&mut self.a, x);
        forces.accelerations(t, x, v, &mut self.a);
        (self.update)(dt, &self.a, x, v);
        AdvanceReport { elapsed: dt, accepted: 1, rejected: 0, evaluations: 1, globalised: 0 }
    }
}
