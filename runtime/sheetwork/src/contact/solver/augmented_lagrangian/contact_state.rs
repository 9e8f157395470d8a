//! How a contact acts at given forces, and what of it stands in the matrix of a Newton step: D = ρ ∂P.
//!
//! With p the force there would be if it could be anything, p - ρ u (N): open where its normal part pulls, stuck where its part across is
//! within the limit of friction L, sliding beyond, where P turns with p_t and D is (L/|p_t|) ρ across it and nothing along.

use glam::{DMat3, DVec2, DVec3};

use crate::contact::coulomb::Law;
use crate::contact::solver::augmented_lagrangian::Row;

/// How a contact acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rubs {
    No,
    Sticks,
    Slides,
}

/// What the matrix has of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct State {
    pub pushes: bool,
    pub rubs: Rubs,
    /// Direction of friction where it slides, and D across it over ρ.
    pub along: DVec2,
    pub across: f64,
}

impl State {
    pub(crate) const OPEN: Self = Self { pushes: false, rubs: Rubs::No, along: DVec2::ZERO, across: 0.0 };

    pub(crate) fn acts(&self) -> bool {
        self.pushes || self.rubs != Rubs::No
    }

    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.pushes == other.pushes && self.rubs == other.rubs
    }

    /// Whether the factor with `other` in it does as well: what is a little off only costs another step.
    pub(crate) fn is_near(&self, other: &Self) -> bool {
        let alike = || {
            (self.along - other.along).abs().max_element() < 0.02
                && (self.across - other.across).abs() <= 0.1 * self.across.max(other.across)
        };
        self.is_like(other) && (self.rubs != Rubs::Slides || alike())
    }
}

/// The force nearest to `p` that a contact may have.
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

/// How a contact acts whose force would be `p` if it could be anything.
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

/// D of a contact of weights `rho`.
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
