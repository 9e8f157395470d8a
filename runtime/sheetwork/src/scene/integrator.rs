//! Kinds of integrators and their names in files (scene keyword `engine`). The schemes themselves,
//! with order and stability limit, are in [`crate::integrators::TABLE`].

use serde::{Deserialize, Serialize};

use crate::error::InputError;

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

/// Every kind with its name in files and on the command line, in the order of menus.
const NAMES: [(IntegratorKind, &str); 10] = [
    (IntegratorKind::Analytical, "analytical"),
    (IntegratorKind::Euler, "euler"),
    (IntegratorKind::EulerCromer, "euler-cromer"),
    (IntegratorKind::EulerRichardson, "euler-richardson"),
    (IntegratorKind::Verlet, "verlet"),
    (IntegratorKind::Rk4, "rk4"),
    (IntegratorKind::Rk45, "rk45"),
    (IntegratorKind::TrBdf2, "tr-bdf2"),
    (IntegratorKind::BackwardEuler, "backward-euler"),
    (IntegratorKind::Bdf2, "bdf2"),
];

impl IntegratorKind {
    /// Name in files and on the command line.
    pub fn name(self) -> &'static str {
        NAMES.iter().find(|(kind, _)| *kind == self).map_or("", |(_, name)| *name)
    }
}

impl std::fmt::Display for IntegratorKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for IntegratorKind {
    type Err = InputError;

    fn from_str(name: &str) -> Result<Self, InputError> {
        NAMES.iter().find(|(_, known)| *known == name).map(|(kind, _)| *kind).ok_or_else(|| {
            let names: Vec<&str> = NAMES.iter().map(|(_, name)| *name).collect();
            InputError::unknown_name("engine", "engine", name, &names)
        })
    }
}

impl TryFrom<String> for IntegratorKind {
    type Error = InputError;

    fn try_from(name: String) -> Result<Self, InputError> {
        name.parse()
    }
}

impl From<IntegratorKind> for String {
    fn from(kind: IntegratorKind) -> Self {
        kind.name().to_owned()
    }
}
