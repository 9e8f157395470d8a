//! Kinds of integrators (scene keyword `engine`). The schemes themselves, with name, order and
//! stability limit, are in [`crate::integrators::TABLE`].

use serde::{Deserialize, Serialize};

/// Kinds of integrators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
#[non_exhaustive]
pub enum IntegratorKind {
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
