//! Where a sheet comes to rest under constant forces, found without stepping through time.
//!
//! Mixed-stress Newton from where the sheet is: for sheets that bend and hardly stretch it takes about six linear solves on any
//! grid (see [`crate::elements`]). Where that does not settle (a buckled sheet, or one that nothing holds upright) it goes on by backward
//! Euler steps without velocity whose length grows, which go down in energy and end in a stable equilibrium.

use crate::elements::{Anchor, Geometric};
use crate::integrators::implicit::newton::{Work, solve};
use crate::integrators::implicit::{Implicit, Stage};
use crate::math::Vectors;
use crate::sheet::implicit_system::System;
use crate::sheet::{Field, Sheet};

/// How an equilibrium was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Equilibrium {
    /// Linear solves.
    pub solves: u32,
    /// Length of the last step of the iteration, m.
    pub last_step: f64,
    /// Whether it settled.
    pub settled: bool,
    /// Whether Newton's method from where the sheet was did it alone.
    pub direct: bool,
    /// Whether the sheet stands there by itself: at an unstable equilibrium the least push sends it elsewhere.
    pub stable: bool,
}

/// Steps of Newton's method alone.
const DIRECT_STEPS: u32 = 25;
/// Relaxation steps after that.
const RELAXING_STEPS: u32 = 400;

impl Sheet {
    /// Moves the sheet to equilibrium under `field`, to a last step of at most `tolerance` m, and stops it there.
    pub fn settle(&mut self, field: Field, tolerance: f64) -> Equilibrium {
        self.stand_still();
        let found = self.find_equilibrium(field, tolerance);
        Equilibrium { stable: self.is_stable(), ..found }
    }

    /// Lets the sheet flow for `dt` s so slowly that it is in equilibrium under `field` throughout, to a last step of at most
    /// `tolerance` m, and stops it where it has come to. Whether it is stable there is not looked at.
    pub fn flow_settled(&mut self, field: Field, dt: f64, tolerance: f64) -> Equilibrium {
        self.begin_flow(dt);
        let found = self.find_equilibrium(field, tolerance);
        self.end_flow();
        found
    }

    fn find_equilibrium(&mut self, field: Field, tolerance: f64) -> Equilibrium {
        let mut system = self.system.take().unwrap_or_else(|| Box::new(System::new(self)));
        system.forget_constant();
        let mut x = self.x.clone();
        let (start, size) = (self.x.clone(), self.spread);
        let found = self.with_problem(field, &mut system, |problem| {
            let mut found = newton(problem, &mut x, tolerance, size);
            if !found.settled {
                x.copy_from(&start);
                relax(problem, &mut x, tolerance, &mut found);
            }
            found
        });
        system.forget_constant();
        self.system = Some(system);
        self.x.copy_from(&x);
        self.v.clear();
        self.engine.restart();
        found
    }
}

fn newton(problem: &mut dyn Implicit, x: &mut Vectors, tolerance: f64, size: f64) -> Equilibrium {
    let still = Vectors::zeros(x.len());
    let mut d = still.clone();
    let mut found = Equilibrium { direct: true, ..Equilibrium::default() };
    problem.begin(0.0, &[], 0.0, x, &still);
    problem.settle(x);
    let stage = Stage { per_time: 0.0, y: &still, w: &still };
    for _ in 0..DIRECT_STEPS {
        let mut done = problem.direction(&stage, x, Geometric::Mixed, &mut d);
        if done.is_err() {
            done = problem.direction(&stage, x, Geometric::Clipped, &mut d);
        }
        if done.is_err() {
            break;
        }
        found.solves += 1;
        problem.predict(x, &d);
        x.add_scaled(1.0, &d);
        found.last_step = d.max_squared().sqrt();
        if found.last_step <= tolerance {
            found.settled = true;
            break;
        }
        if found.last_step.is_nan() || found.last_step > 100.0 * size {
            break;
        }
    }
    found
}

/// Backward Euler without velocity, in steps that double while they go well.
fn relax(problem: &mut dyn Implicit, x: &mut Vectors, tolerance: f64, found: &mut Equilibrium) {
    let still = Vectors::zeros(x.len());
    let mut work = Work::default();
    let mut before = x.clone();
    let mut h = 1e-2;
    found.direct = false;
    for _ in 0..RELAXING_STEPS {
        before.copy_from(x);
        problem.begin(1.0 / h, &[Anchor { weight: 1.0, x: &before }], 0.0, &before, &still);
        let stage = Stage { per_time: 1.0 / h, y: &before, w: &before };
        let solved = solve(problem, &stage, &before, x, &mut work);
        found.solves += solved.solves;
        let moved = (0..x.len()).map(|i| x.get(i).distance_squared(before.get(i))).fold(0.0, f64::max).sqrt();
        found.last_step = moved;
        if moved <= tolerance && h > 1.0 {
            found.settled = true;
            return;
        }
        h = if solved.guarded { (0.5 * h).max(1e-4) } else { (2.0 * h).min(1e3) };
    }
}
