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

#[cfg(test)]
mod tests {
    use super::*;

    fn row(friction: f64) -> SolverConstraint {
        SolverConstraint::new(DMat3::IDENTITY, ContactLaw::Coulomb(friction))
    }

    #[test]
    fn projection_cuts_tension_and_friction_beyond_the_bound() {
        let row = row(0.5);
        // (trial force, bound, projection).
        let cases = [
            (DVec3::new(2.0, 0.3, -0.4), 1.0, DVec3::new(2.0, 0.3, -0.4)),
            (DVec3::new(2.0, 3.0, -4.0), 1.0, DVec3::new(2.0, 0.6, -0.8)),
            (DVec3::new(-2.0, 0.3, -0.4), 0.0, DVec3::ZERO),
        ];
        for (trial, bound, expected) in cases {
            assert!(project_force(&row, trial, bound).distance(expected) < 1e-15, "{trial}");
        }
        let attachment = SolverConstraint::new(DMat3::IDENTITY, ContactLaw::Attachment);
        assert_eq!(project_force(&attachment, DVec3::NEG_ONE, 0.0), DVec3::NEG_ONE);
        let mut disabled = row;
        disabled.is_disabled = true;
        assert_eq!(project_force(&disabled, DVec3::ONE, 1.0), DVec3::ZERO);
    }

    #[test]
    fn state_names_the_branch_of_the_projection() {
        let state = |p: DVec3, bound: f64| state_of(&row(0.5), p, bound);
        let stick = state(DVec3::new(2.0, 0.3, -0.4), 1.0);
        assert_eq!((stick.is_closed, stick.friction), (true, FrictionState::Stick));
        let slip = state(DVec3::new(2.0, 3.0, -4.0), 1.0);
        assert_eq!((slip.is_closed, slip.friction), (true, FrictionState::Slip));
        // Direction p_t/|p_t|, and L/|p_t| = 1/5 across it.
        assert!((slip.along - DVec2::new(0.6, -0.8)).length() < 1e-15 && (slip.across - 0.2).abs() < 1e-15);
        let open = state(DVec3::new(-2.0, 0.3, -0.4), 0.0);
        assert!(!open.is_closed && !open.is_active());
        assert_eq!(state(DVec3::new(2.0, 0.3, 0.0), 0.0).friction, FrictionState::None, "no bound, no friction");
    }

    #[test]
    fn derivative_is_that_of_the_projection_by_central_differences() {
        let (row, rho, step) = (row(0.5), DVec3::splat(7.0), 1e-6);
        for trial in [DVec3::new(2.0, 0.3, -0.4), DVec3::new(2.0, 3.0, -4.0), DVec3::new(-2.0, 0.3, 0.1)] {
            let d = derivative(rho, &state_of(&row, trial, 1.0), false);
            for (k, axis) in DVec3::AXES.into_iter().enumerate() {
                let [above, below] = [step, -step].map(|by| project_force(&row, trial + axis * by, 1.0));
                let slope = (above - below) * (rho.x / (2.0 * step));
                assert!(slope.distance(d.col(k)) < 1e-8, "{trial}, axis {k}: {slope} {}", d.col(k));
            }
        }
    }

    #[test]
    fn regularised_derivative_bounds_the_exact_one_from_above() {
        let (rho, slip) = (DVec3::splat(7.0), state_of(&row(0.5), DVec3::new(2.0, 3.0, -4.0), 1.0));
        let excess = derivative(rho, &slip, true) - derivative(rho, &slip, false);
        // ρ L/|p_t| along the direction of slip, and zero across it.
        let along = DVec3::new(0.0, 0.6, -0.8);
        assert!((excess * along - along * (7.0 * 0.2)).length() < 1e-14);
        assert!((excess * DVec3::new(0.0, 0.8, 0.6)).length() < 1e-14);
    }
}
