//! State of a contact at a given trial force, and its contribution to the matrix of a Newton step,
//! D = ρ ∂P.
//!
//! With the trial force p - ρ u (N): open if its normal part is tensile; stick if its tangential
//! part is within the friction bound L; slip beyond, where the projection P rotates with p_t, so
//! that D is ρ L/|p_t| across the direction of slip and zero along it.

use glam::{DMat3, DVec2, DVec3};

use crate::contact::coulomb::ContactLaw;
use crate::contact::solver::augmented_lagrangian::SolverConstraint;

/// Friction of a contact: none, stick or slip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrictionState {
    /// No friction.
    None,
    /// Stick: friction below the bound.
    Stick,
    /// Slip: friction on the bound.
    Slip,
}

/// State of a contact in the matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactState {
    /// Whether the contact is closed.
    pub is_closed: bool,
    /// Friction state.
    pub friction: FrictionState,
    /// Direction of friction in slip, and D across it divided by ρ.
    pub along: DVec2,
    pub across: f64,
}

impl ContactState {
    /// State of an open contact.
    pub(crate) const OPEN: Self =
        Self { is_closed: false, friction: FrictionState::None, along: DVec2::ZERO, across: 0.0 };

    /// Whether the contact has an entry in the matrix.
    pub(crate) fn is_active(&self) -> bool {
        self.is_closed || self.friction != FrictionState::None
    }

    /// Whether both states are open, stick or slip alike.
    pub(crate) fn has_same_kind(&self, other: &Self) -> bool {
        self.is_closed == other.is_closed && self.friction == other.friction
    }

    /// Whether a factor with the state `other` can be used. A small difference only costs another
    /// iteration.
    pub(crate) fn is_near(&self, other: &Self) -> bool {
        let alike = || {
            (self.along - other.along).abs().max_element() < 0.02
                && (self.across - other.across).abs() <= 0.1 * self.across.max(other.across)
        };
        self.has_same_kind(other) && (self.friction != FrictionState::Slip || alike())
    }
}

/// Projection P of the force `p` on the admissible forces with friction bound `limit` (N).
pub(crate) fn project_force(row: &SolverConstraint, p: DVec3, limit: f64) -> DVec3 {
    if row.law == ContactLaw::Attachment {
        return p;
    }
    if row.is_disabled {
        return DVec3::ZERO;
    }
    let tangential = DVec2::new(p.y, p.z).clamp_length_max(limit);
    DVec3::new(p.x.max(0.0), tangential.x, tangential.y)
}

/// State of a contact with trial force `p` and friction bound `limit` (N).
pub(crate) fn state_of(row: &SolverConstraint, p: DVec3, limit: f64) -> ContactState {
    if row.law == ContactLaw::Attachment {
        return ContactState { is_closed: true, friction: FrictionState::Stick, ..ContactState::OPEN };
    }
    if row.is_disabled {
        return ContactState::OPEN;
    }
    let pushes = p.x > 0.0;
    let tangential = DVec2::new(p.y, p.z);
    let length = tangential.length();
    if limit <= 0.0 {
        ContactState { is_closed: pushes, ..ContactState::OPEN }
    } else if length <= limit {
        ContactState { is_closed: pushes, friction: FrictionState::Stick, ..ContactState::OPEN }
    } else {
        ContactState {
            is_closed: pushes,
            friction: FrictionState::Slip,
            along: tangential / length,
            across: limit / length,
        }
    }
}

/// D of a contact with weights `rho` (N/m); `braced` selects the regularised form, isotropic in
/// slip.
pub(crate) fn derivative(rho: DVec3, state: &ContactState, braced: bool) -> DMat3 {
    let [yy, yz, zz] = match state.friction {
        FrictionState::None => [0.0; 3],
        FrictionState::Stick => [rho.y, 0.0, rho.z],
        FrictionState::Slip => {
            let (across, DVec2 { x: y, y: z }) = (rho.y * state.across, state.along);
            match braced {
                true => [across, 0.0, across],
                false => [across * z * z, -across * y * z, across * y * y],
            }
        }
    };
    DMat3::from_cols(
        DVec3::new(if state.is_closed { rho.x } else { 0.0 }, 0.0, 0.0),
        DVec3::new(0.0, yy, yz),
        DVec3::new(0.0, yz, zz),
    )
}
