//! Velocity Verlet: half a velocity update, a position update, and half a velocity update with the
//! acceleration at the new position.
//!
//! v_h = v + ½ a₀ h; x ← x + v_h h; a₁ at (x, v + a₀ h); v ← v_h + ½ a₁ h. The predicted velocity
//! v + a₀ h in a₁ preserves order 2 with dashpots. Symplectic without dashpots: on x'' = -ω²x
//! stable for a = hω up to 2, energy error about a²/4. Each step recomputes the first acceleration,
//! because contact and changed parameters between steps invalidate the previous one.

use crate::integrators::{AdvanceReport, Forces, Integrator, IntegratorInfo, resize_like};
use crate::math::Vectors;
use crate::scene::IntegratorKind;

pub(crate) const INFO: IntegratorInfo = IntegratorInfo {
    kind: IntegratorKind::Verlet,
    name: "verlet",
    about: "velocity Verlet, order 2, symplectic",
    order: 2,
    stability_limit: 2.0,
    evaluations: 2,
    make: || Box::new(Verlet::default()),
    ..IntegratorInfo::EXPLICIT
};

#[derive(Default)]
struct Verlet {
    a: Vectors,
    predicted: Vectors,
}

impl Integrator for Verlet {
    fn advance(&mut self, forces: &mut dyn Forces, t: f64, dt: f64, x: &mut Vectors, v: &mut Vectors) -> AdvanceReport {
        resize_like(&mut self.a, x);
        resize_like(&mut self.predicted, x);
        forces.accelerations(t, x, v, &mut self.a);
        self.predicted.set_sum(v, dt, &self.a);
        v.add_scaled(0.5 * dt, &self.a);
        x.add_scaled(dt, v);
        forces.accelerations(t + dt, x, &self.predicted, &mut self.a);
        v.add_scaled(0.5 * dt, &self.a);
        AdvanceReport { elapsed: dt, accepted: 1, rejected: 0, evaluations: 2, globalised: 0 }
    }
}
