//! Velocity Verlet: half a kick, a drift, half a kick with the acceleration at the new place.
//!
//! v_h = v + ½ a₀ h; x ← x + v_h h; a₁ at (x, v + a₀ h); v ← v_h + ½ a₁ h. The velocity given to a₁ is a prediction, which
//! keeps order 2 with dashpots. Symplectic without them: on x'' = -ω²x stable for a = hω up to 2, energy within about a²/4.
//! The first acceleration is computed afresh each step, not carried over, because contact and parameter changes between
//! steps make the old one wrong.

use crate::integrators::{Advance, Engine, EngineInfo, EngineKind, Forces, fit};
use crate::math::Vectors;

pub(crate) const INFO: EngineInfo = EngineInfo {
    kind: EngineKind::Verlet,
    name: "verlet",
    about: "velocity Verlet, order 2, symplectic",
    order: 2,
    stability_limit: 2.0,
    evaluations: 2,
    drift: 0.5,
    adaptive: false,
    implicit: false,
    amplification: None,
    make: || Box::new(Verlet::default()),
};

#[derive(Default)]
struct Verlet {
    a: Vectors,
    predicted: Vectors,
}

impl Engine for Verlet {
    fn advance(&mut self, forces: &mut dyn Forces, t: f64, dt: f64, x: &mut Vectors, v: &mut Vectors) -> Advance {
        fit(&mut self.a, x);
        fit(&mut self.predicted, x);
        forces.accelerations(t, x, v, &mut self.a);
        self.predicted.set_sum(v, dt, &self.a);
        v.add_scaled(0.5 * dt, &self.a);
        x.add_scaled(dt, v);
        forces.accelerations(t + dt, x, &self.predicted, &mut self.a);
        v.add_scaled(0.5 * dt, &self.a);
        Advance { taken: dt, accepted: 1, rejected: 0, evaluations: 2, guarded: 0 }
    }
}
