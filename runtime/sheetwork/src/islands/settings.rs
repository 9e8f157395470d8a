//! Settings of the step of an island: island building, bisection, energy budget, fallbacks and
//! detection of instability. Sleep thresholds are in [`crate::scene::sleep`].

use crate::units::settings::settings;

settings! {
    /// Settings of the step of an island.
    pub struct StepSettings {
        /// Fraction of its velocity that a sheet keeps after an energy gain by contact.
        pub velocity_retention: f64 = 0.5,
        /// Rotation (rad) of a free island in a step above which its angular momentum is restored.
        pub free_rotation: f64 = 0.01,
        /// Maximum rotation (rad) of a free island in a part of a step without contact.
        pub rotation_of_part: f64 = 0.35,
        /// Maximum number of bisections for [`Self::rotation_of_part`].
        pub maximum_rotation_bisections: f64 = 4.0,
        /// Speed (m/s) of the reference kinetic energy below which energy gains are ignored.
        pub reference_speed: f64 = 5e-3,
        /// Broad phase and islands.
        pub islands: IslandSettings = IslandSettings::DEFAULT,
        /// Bisection of a step.
        pub bisection: BisectionSettings = BisectionSettings::DEFAULT,
        /// Energy budget of a step.
        pub energy: EnergyBudgetSettings = EnergyBudgetSettings::DEFAULT,
        /// Barrier method in place of a step.
        pub fallback: FallbackSettings = FallbackSettings::DEFAULT,
        /// Detection of instability.
        pub instability: InstabilitySettings = InstabilitySettings::DEFAULT,
        /// Events of sheets on bodies.
        pub touch: TouchSettings = TouchSettings::DEFAULT,
    }

    /// Broad phase and islands.
    pub struct IslandSettings {
        /// Margin of the broad phase beyond the distance from speeds, as a multiple of the half
        /// thickness of the sheet. It exceeds the margin of detection.
        pub broad_phase_margin: f64 = 4.0,
        /// Displacement of a node within its sheet in a step, as a fraction of the sheet's
        /// diagonal, above which a flat sheet without contact may meet itself.
        pub folding_displacement: f64 = 0.25,
        /// Maximum number of iterations in which islands grow by their largest speed.
        pub maximum_growth_iterations: u32 = 4,
        /// Consecutive steps with a fallback after which sheets are tested for interpenetration.
        pub fallbacks_before_overlap_test: u32 = 20,
    }

    /// Bisection of a step: maximum depths and reasons.
    pub struct BisectionSettings {
        /// Maximum number of bisections of a step of a single sheet. With three, sheets thrown at
        /// edges at 20 m/s often end a step unconverged, with millimetres of penetration.
        pub maximum_depth_single: u32 = 6,
        /// Maximum number of bisections of a step of a single sheet with self-contact, lower to
        /// bound the cost.
        pub maximum_depth_self_contact: u32 = 4,
        /// Maximum number of bisections of a step of several sheets. They converge over the
        /// following steps too, and are bisected only for an energy error, a strain error or
        /// interpenetration.
        pub maximum_depth_several: u32 = 4,
        /// Maximum rotation of a body with corners in a substep near a sheet, rad. Contact is
        /// linearised in the rotation; with a larger one a struck needle swings through the sheet.
        pub maximum_rotation: f64 = 0.2,
    }

    /// Energy budget of a step. Gains are fractions of the energy available for motion at its
    /// start.
    pub struct EnergyBudgetSettings {
        /// Energy gain above which a step is bisected.
        pub bisection_gain: f64 = 0.1,
        /// Energy gain tolerance: integrators gain as much without contact.
        pub gain_tolerance: f64 = 1e-3,
        /// Lift of the reference energy, in half thicknesses, below which gains of a single sheet
        /// are ignored. It exceeds the accuracy of a contact solve.
        pub lift_single: f64 = 0.4,
        /// Lift of the reference energy for several sheets, as a multiple of the half thickness:
        /// each may penetrate the next, and their depenetration lifts the whole pile.
        pub lift_several: f64 = 8.0,
        /// Maximum penetration of initial positions, in half thicknesses, whose removal may add
        /// potential energy.
        pub maximum_initial_penetration: f64 = 2.0,
        /// Speed below which a motion is about to rest, m/s. A body that rolls over the edges of
        /// triangles is lifted at each, which may exceed the rolling resistance.
        pub resting_speed: f64 = 0.03,
    }

    /// Barrier method in place of a step that did not converge.
    pub struct FallbackSettings {
        /// Displacement of a body with prescribed motion in a substep, as a fraction of the sheet's
        /// diagonal, above which the substep is split at the first impact.
        pub impact_displacement: f64 = 0.25,
        /// Least fraction of a substep before and after the first impact at which it is split.
        pub impact_fraction: f64 = 0.02,
        /// Maximum number of bisections of a substep of the barrier method in which a body does not
        /// arrive.
        pub barrier_bisections: u32 = 6,
    }

    /// Detection of instability, and the step limit of sheets with limited strain.
    pub struct InstabilitySettings {
        /// Speed above which a sheet is unstable, m/s: above any velocity that a scene may set.
        pub maximum_speed: f64 = 2e4,
        /// Ratio of the diagonal of a sheet's bounding box to its diagonal at the start above which
        /// the sheet is unstable.
        pub maximum_diagonal_ratio: f64 = 20.0,
        /// Maximum number of substeps of an adaptive integrator in one step; above it the sheet is
        /// unstable.
        pub maximum_adaptive_substeps: u32 = 100_000,
        /// Maximum energy gain of one step as a fraction of the energy at its start.
        pub maximum_gain: f64 = 0.1,
        /// Maximum accumulated energy gain as a fraction of the present energy.
        pub maximum_accumulated_gain: f64 = 0.5,
        /// Maximum number of shorter trials of a strain-limited step.
        pub maximum_trials: u32 = 4,
        /// Maximum number of substeps per step of a strain-limited sheet; with more needed, the
        /// sheet is frozen.
        pub maximum_limited_substeps: u32 = 16,
    }

    /// Events of sheets that touch, cover and leave bodies.
    pub struct TouchSettings {
        /// Time without contact after which a sheet has left a body, s.
        pub separation_delay: f64 = 0.1,
        /// Fraction of a layer's nodes that must touch for the sheet to lie flat.
        pub flat_node_fraction: f64 = 0.95,
        /// Flatness threshold: deviation from a plane as a fraction of the sheet's diagonal.
        pub flatness: f64 = 0.02,
    }
}
