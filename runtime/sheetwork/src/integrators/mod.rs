//! Engines: how time passes for a sheet. Each is one file with one row in [`TABLE`].
//!
//! An engine advances positions and velocities of x'' = a(t, x, v) and knows nothing of springs: it asks a [`Forces`] for
//! accelerations. Held and led masses have acceleration zero and the velocity they are led with, which every engine
//! carries through exactly. An engine keeps no state from one step to the next except rk45's step size, so that a sheet
//! continues from positions and velocities alone.
//!
//! On x'' = -ω²x with a = hω the schemes behave as the table in `assets/README.md` says; the conformance tests measure it.

pub(crate) mod analytical;
pub(crate) mod backward_euler;
pub(crate) mod bdf2;
pub(crate) mod euler;
pub(crate) mod euler_cromer;
pub(crate) mod euler_richardson;
pub mod implicit;
pub(crate) mod rk4;
pub(crate) mod rk45;
pub(crate) mod tr_bdf2;
pub(crate) mod verlet;

use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::math::Vectors;
use crate::serialize::{Keeper, Taken, Taker};

/// Accelerations of a set of masses.
pub trait Forces {
    /// Writes the accelerations (m/s²) at time `t` (s), positions `x` (m) and velocities `v` (m/s) to `a`.
    fn accelerations(&mut self, t: f64, x: &Vectors, v: &Vectors, a: &mut Vectors);

    /// The same masses as implicit schemes see them; `None` where nobody prepared for that.
    fn implicit(&mut self) -> Option<&mut dyn implicit::Implicit> {
        None
    }
}

/// What a call to [`Engine::advance`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Advance {
    /// Time that passed, s; less than asked only for an adaptive engine.
    pub taken: f64,
    /// Steps accepted.
    pub accepted: u64,
    /// Steps tried and thrown away because their error was too large.
    pub rejected: u64,
    /// Calls of [`Forces::accelerations`]; linear solves of an implicit scheme.
    pub evaluations: u64,
    /// Stages of an implicit scheme that the guarded descent had to finish.
    pub guarded: u64,
}

/// A time-stepping scheme with its working arrays.
pub trait Engine: Send + Sync {
    /// Advances `x` (m) and `v` (m/s) from time `t` (s) by `dt` (s), or by less where the scheme chooses its own steps.
    fn advance(&mut self, forces: &mut dyn Forces, t: f64, dt: f64, x: &mut Vectors, v: &mut Vectors) -> Advance;

    /// The scheme stage by stage, where it is implicit.
    fn staged(&mut self) -> Option<&mut dyn implicit::staged::Staged> {
        None
    }

    /// What [`EngineInfo::drift`] is in the next step, of `dt` s, where that depends on the steps before.
    fn drift(&self, _dt: f64) -> Option<f64> {
        None
    }

    /// Sets the position error (m) an adaptive scheme may make in a step; others ignore it.
    fn set_tolerance(&mut self, _tolerance: f64) {}

    /// Visits what is carried from step to step, always the same numbers in the same order once a step was taken.
    fn history(&mut self, _visit: &mut dyn FnMut(&mut [f64])) {}

    /// Keeps the same, and what an adaptive scheme has learnt, for a snapshot.
    fn keep(&self, _to: &mut Keeper) {}

    /// Takes that back, for `masses` masses.
    fn take(&mut self, _from: &mut Taker, _masses: usize) -> Taken {
        Ok(())
    }

    /// Forgets what was learnt from earlier steps: called after anything but the engine has moved the sheet far.
    fn restart(&mut self) {}
}

/// An engine that does nothing: what a sheet holds while its own is at work on it.
pub(crate) struct Resting;

impl Engine for Resting {
    fn advance(&mut self, _forces: &mut dyn Forces, _t: f64, dt: f64, _x: &mut Vectors, _v: &mut Vectors) -> Advance {
        Advance { taken: dt, ..Advance::default() }
    }
}

/// The engines there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum EngineKind {
    /// Constant acceleration over the step.
    Analytical,
    /// Explicit Euler.
    Euler,
    /// Semi-implicit Euler.
    EulerCromer,
    /// Explicit midpoint.
    EulerRichardson,
    /// Velocity Verlet.
    Verlet,
    /// Classical Runge-Kutta of order 4.
    Rk4,
    /// Dormand-Prince pair of orders 5 and 4, adaptive.
    Rk45,
    /// Implicit, trapezoidal and BDF2 stages.
    TrBdf2,
    /// Implicit Euler.
    BackwardEuler,
    /// Implicit BDF2.
    Bdf2,
}

/// One row of the table of engines.
pub struct EngineInfo {
    /// Which it is.
    pub kind: EngineKind,
    /// Name in files and on the command line.
    pub name: &'static str,
    /// One line on what it is.
    pub about: &'static str,
    /// Order of convergence of positions at a fixed time.
    pub order: u32,
    /// Largest hω at which undamped oscillation does not grow; 0 where it always grows a little, infinite for implicit ones.
    pub stability_limit: f64,
    /// Evaluations of the forces a step; of an implicit scheme its stages, each one or more linear solves.
    pub evaluations: u32,
    /// Weight θ of a constant acceleration in a step's displacement, Δx = v h + θ a h²: ½ but for the Euler schemes. Contact
    /// moves what it slows by the same rule, or masses in contact would drift from their neighbours.
    pub drift: f64,
    /// Whether it chooses its own steps within `dt`.
    pub adaptive: bool,
    /// Whether it solves for the end of the step.
    pub implicit: bool,
    /// Of x'' = -ω²x in a step, by ω dt (rad): what is left of the amplitude, and the angle turned, rad. Given for engines
    /// whose steps are long enough for it to matter.
    pub amplification: Option<fn(f64) -> (f64, f64)>,
    /// Makes one.
    pub(crate) make: fn() -> Box<dyn Engine>,
}

/// Every engine, in the order menus show them.
pub const TABLE: &[EngineInfo] = &[
    analytical::INFO,
    euler::INFO,
    euler_cromer::INFO,
    euler_richardson::INFO,
    verlet::INFO,
    rk4::INFO,
    rk45::INFO,
    tr_bdf2::INFO,
    backward_euler::INFO,
    bdf2::INFO,
];

impl EngineKind {
    /// Its row in the table.
    pub fn info(self) -> &'static EngineInfo {
        // Every kind has a row: `every_kind_is_in_the_table` below.
        TABLE.iter().find(|e| e.kind == self).unwrap_or(&TABLE[0])
    }

    /// Name in files and on the command line.
    pub fn name(self) -> &'static str {
        self.info().name
    }

    /// A new engine of this kind.
    pub fn make(self) -> Box<dyn Engine> {
        (self.info().make)()
    }
}

impl std::fmt::Display for EngineKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for EngineKind {
    type Err = InputError;

    fn from_str(name: &str) -> Result<Self, InputError> {
        TABLE.iter().find(|e| e.name == name).map(|e| e.kind).ok_or_else(|| {
            let names: Vec<&str> = TABLE.iter().map(|e| e.name).collect();
            InputError::new("engine", format!("no engine is named \"{name}\"; there are {}", names.join(", ")))
        })
    }
}

impl TryFrom<String> for EngineKind {
    type Error = InputError;

    fn try_from(name: String) -> Result<Self, InputError> {
        name.parse()
    }
}

impl From<EngineKind> for String {
    fn from(kind: EngineKind) -> Self {
        kind.name().to_owned()
    }
}

/// Makes `buffer` as long as `like` without allocating when it already is.
fn fit(buffer: &mut Vectors, like: &Vectors) {
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
            assert_eq!(row.name.parse::<EngineKind>(), Ok(row.kind));
        }
        assert!("euler-kramer".parse::<EngineKind>().expect_err("no such engine").problem.contains("euler-cromer"));
    }
}
