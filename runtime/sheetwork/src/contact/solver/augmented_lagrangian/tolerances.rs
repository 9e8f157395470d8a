//! Tolerances, weights and iteration limits of an augmented Lagrangian solve, by kind of problem.
//!
//! A solve ends when three errors are within tolerance: gaps and slips u (m), the force balance
//! |Jᵀ p - H δ| as a fraction of the sum of forces, and the friction bounds. A single sheet
//! needs fine tolerances, because slip of sticking contacts adds up from step to step; several
//! sheets in an impact change contact states in every iteration and get by with coarse ones.

use glam::DVec3;

use crate::contact::settings::{AugmentedLagrangianSettings, ContactSettings};
use crate::contact::solver::augmented_lagrangian::InteriorPointTolerances;

const SETTINGS: AugmentedLagrangianSettings = ContactSettings::DEFAULT.augmented_lagrangian;

/// Settings of a solve: tolerances, weights and iteration limits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AugmentedLagrangianTolerances {
    /// Half the thickness of the thinnest sheet, m; 1 before [`Self::scaled`].
    pub half_thickness: f64,
    /// Gap tolerance, m; in half thicknesses before [`Self::scaled`].
    pub gap: f64,
    /// ρ as a multiple of the stiffness of the sheet at the contact. With 100, a Newton step
    /// reduces the penetration to a hundredth. Friction has a smaller factor because it changes
    /// between stick and slip.
    pub weight_factor: DVec3,
    /// Maximum of the normal factor when weights grow in slow convergence. Piles converge more
    /// slowly with larger weights.
    pub maximum_weight_factor: f64,
    /// Weight of slip in the residual; slip of sticking contacts would add up from step to step.
    pub slip_weight: f64,
    /// Tolerance of the force balance H δ = Jᵀ p, as a fraction of the sum of forces. A stiff
    /// contact has a force error at a small gap.
    pub balance: f64,
    /// Tolerance of the force balance in late iterations, see
    /// [`AugmentedLagrangianSettings::iterations_before_late_balance`]. When sheets slide over each
    /// other, a few contacts alternate between stick and slip for many iterations.
    pub balance_late: f64,
    /// Tolerance of the force balance after the interior point method, whose friction converges
    /// slowly.
    pub balance_interior: f64,
    /// Settings of the interior point method.
    pub interior: InteriorPointTolerances,
    /// Maximum number of updates of the friction bounds.
    pub maximum_bound_updates: u32,
    /// Iterations after which the interior point method is used in any case.
    pub interior_point_iteration: u32,
    /// Whether to regularise steps when many contacts change state: more robust, but slower near
    /// the solution.
    pub regularised: bool,
}

impl AugmentedLagrangianTolerances {
    /// Settings for a single sheet: sticking contacts must not creep, and momentum is conserved.
    pub const SINGLE_SHEET: Self = Self {
        half_thickness: 1.0,
        gap: 8e-4,
        slip_weight: 10.0,
        weight_factor: DVec3::new(100.0, 10.0, 10.0),
        maximum_weight_factor: 1e4,
        balance: 1e-7,
        balance_late: 1e-7,
        balance_interior: 1e-3,
        interior: InteriorPointTolerances::SINGLE_SHEET,
        maximum_bound_updates: 5,
        // A sheet that lies loosely around a needle, with half of its contacts near the friction
        // bound, needs between 20 and 30. A failed solve costs more than the spare iterations
        // because the step is then bisected.
        interior_point_iteration: 40,
        regularised: false,
    };
    /// Settings for several sheets during an impact, in which some contact changes between stick
    /// and slip in every iteration. The friction bounds follow the normal forces from solve to
    /// solve.
    pub const IMPACT: Self = Self {
        half_thickness: 1.0,
        gap: 0.02,
        slip_weight: 1.0,
        weight_factor: DVec3::new(30.0, 3.0, 3.0),
        maximum_weight_factor: 0.0,
        balance: 1e-3,
        balance_late: 5e-2,
        balance_interior: 1e-2,
        interior: InteriorPointTolerances::SEVERAL_SHEETS,
        maximum_bound_updates: 0,
        interior_point_iteration: 14,
        regularised: true,
    };
    /// Settings for several sheets without bisection. The acceleration of a sliding sheet is within
    /// 2 % of the exact one (0.5 to 7 % with `maximum_bound_updates: 0`). [`Self::FEW_SHEETS`]
    /// takes 1.2 to 1.6 times as long for a falling house of cards.
    pub const SEVERAL_SHEETS: Self = Self { balance_late: 1e-2, maximum_bound_updates: 1, ..Self::IMPACT };
    /// Settings for a few sheets without bisection. The acceleration of a sliding sheet is within
    /// 1e-4 of the exact one. With ten times the tolerance of the balance, steps of a sheet that
    /// slides at 35° may fail to converge for seconds.
    pub const FEW_SHEETS: Self = Self { balance_late: 1e-4, maximum_bound_updates: 2, ..Self::IMPACT };
    /// Settings for an outer iteration of a single sheet that is far from the solution.
    pub const ROUGH: Self = Self {
        gap: 0.04,
        slip_weight: 10.0,
        balance: 1e-3,
        balance_late: 1e-3,
        balance_interior: 1e-2,
        maximum_bound_updates: 0,
        ..Self::SINGLE_SHEET
    };
    /// Settings for an outer iteration of several sheets that is far from the solution.
    pub const ROUGH_SEVERAL_SHEETS: Self =
        Self { gap: 0.04, slip_weight: 10.0, weight_factor: Self::SINGLE_SHEET.weight_factor, ..Self::IMPACT };

    /// These tolerances for sheets of this half thickness, m.
    pub fn scaled(self, half_thickness: f64) -> Self {
        Self { half_thickness, gap: self.gap * half_thickness, ..self }
    }

    /// Maximum number of iterations without updates of the friction bounds; `in_forces` says
    /// whether the unknowns are contact forces.
    pub(super) fn maximum_iterations(&self, in_forces: bool) -> u32 {
        if in_forces {
            self.interior_point_iteration.min(SETTINGS.maximum_iterations_in_forces)
        } else {
            self.interior_point_iteration
        }
    }

    /// Tolerance of the force balance in iteration `round`.
    pub(super) fn balance_at(&self, round: u32) -> f64 {
        if round < SETTINGS.iterations_before_late_balance { self.balance } else { self.balance_late }
    }
}
