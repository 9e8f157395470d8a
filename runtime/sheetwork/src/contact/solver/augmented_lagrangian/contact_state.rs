//! State of a contact at a given trial force, and its contribution to the matrix of a Newton step,
//! D = ρ ∂P.
//!
//! With the trial force p - ρ u (N): open if its normal part is tensile; stick if its tangential
//! part is within the friction bound L; slip beyond, where the projection P rotates with p_t, so
//! that D is ρ L/|p_t| across the direction of slip and zero along it.

use glam::{DMat3, DVec2, DVec3};

use crate::contact::coulomb::Law;
use crate::contact::solver::augmented_lagrangian::Row;

/// Friction of a contact: none, stick or slip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rubs {
    /// No friction.
    No,
    /// Stick: friction below the bound.
    Sticks,
    /// Slip: friction on the bound.
    Slides,
}

/// State of a contact in the matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct State {
    /// Whether the contact is closed.
    pub pushes: bool,
    /// Friction state.
    pub rubs: Rubs,
    /// Direction of friction in slip, and D across it divided by ρ.
    pub along: DVec2,
    pub across: f64,
}

impl State {
    /// State of an open contact.
    pub(crate) const OPEN: Self = Self { pushes: false, rubs: Rubs::No, along: DVec2::ZERO, across: 0.0 };

    /// Whether the contact has an entry in the matrix.
    pub(crate) fn acts(&self) -> bool {
        self.pushes || self.rubs != Rubs::No
    }

    /// Whether both states are open, stick or slip alike.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.pushes == other.pushes && self.rubs == other.rubs
    }

    /// Whether a factor with the state `other` can be used. A small difference only costs another
    /// iteration.
    pub(crate) fn is_near(&self, other: &Self) -> bool {
        let alike = || {
            (self.along - other.along).abs().max_element() < 0.02
                && (self.across - other.across).abs() <= 0.1 * self.across.max(other.across)
        };
        self.is_like(other) && (self.rubs != Rubs::Slides || alike())
    }
}

/// Projection P of the force `p` on the admissible forces with friction bound `limit` (N).
pub(crate) fn projected(row: &Row, p: DVec3, limit: f64) -> DVec3 {
    if row.law == Law::Glue {
        return p;
    }
    if row.idle {
        return DVec3::ZERO;
    }
    let tangential = DVec2::new(p.y, p.z).clamp_length_max(limit);
    DVec3::new(p.x.max(0.0), tangential.x, tangential.y)
}

/// State of a contact with trial force `p` and friction bound `limit` (N).
pub(crate) fn state_of(row: &Row, p: DVec3, limit: f64) -> State {
    if row.law == Law::Glue {
        return State { pushes: true, rubs: Rubs::Sticks, ..State::OPEN };
    }
    if row.idle {
        return State::OPEN;
    }
    let pushes = p.x > 0.0;
    let tangential = DVec2::new(p.y, p.z);
    let length = tangential.length();
    if limit <= 0.0 {
        State { pushes, ..State::OPEN }
    } else if length <= limit {
        State { pushes, rubs: Rubs::Sticks, ..State::OPEN }
    } else {
        State { pushes, rubs: Rubs::Slides, along: tangential / length, across: limit / length }
    }
}

/// D of a contact with weights `rho` (N/m); `braced` selects the regularised form, isotropic in
/// slip.
pub(crate) fn stiffness(rho: DVec3, state: &State, braced: bool) -> DMat3 {
    let [yy, yz, zz] = match state.rubs {
        Rubs::No => [0.0; 3],
        Rubs::Sticks => [rho.y, 0.0, rho.z],
        Rubs::Slides => {
            let (across, DVec2 { x: y, y: z }) = (rho.y * state.across, state.along);
            match braced {
                true => [across, 0.0, across],
                false => [across * z * z, -across * y * z, across * y * y],
            }
        }
    };
    DMat3::from_cols(
        DVec3::new(if state.pushes { rho.x } else { 0.0 }, 0.0, 0.0),
        DVec3::new(0.0, yy, yz),
        DVec3::new(0.0, yz, zz),
    )
}
