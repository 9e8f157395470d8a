//! Settings of rigid bodies: impacts, penetration, substeps, rolling and rotation.

/// Settings of rigid bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidSettings {
    /// Approach speed above which restitution acts between bodies, m/s.
    pub restitution_speed: f64,
    /// Penetration tolerance of two bodies, m. A rolling ball is moved out of less at once.
    pub penetration_tolerance: f64,
    /// Fraction of a larger penetration of two bodies that a step removes.
    pub penetration_recovery: f64,
    /// Speed (m/s) above which a body wakes a sleeping one that it touches.
    pub wake_speed: f64,
    /// Maximum number of steps of conservative advancement.
    pub maximum_advancement_steps: usize,
    /// Impacts of a body on several points at once.
    pub impact: ImpactSettings,
    /// Substeps of a body.
    pub substeps: RigidSubstepSettings,
    /// Motion of a ball from impact to impact.
    pub rolling_ball: RollingBallSettings,
    /// Rolling and drilling resistance.
    pub rolling_resistance: RollingResistanceSettings,
    /// Free rotation.
    pub rotation: RotationSettings,
}

impl RigidSettings {
    /// Settings in use.
    pub const DEFAULT: Self = Self {
        restitution_speed: 0.01,
        penetration_tolerance: 1e-4,
        penetration_recovery: 0.2,
        wake_speed: 0.01,
        maximum_advancement_steps: 48,
        impact: ImpactSettings::DEFAULT,
        substeps: RigidSubstepSettings::DEFAULT,
        rolling_ball: RollingBallSettings::DEFAULT,
        rolling_resistance: RollingResistanceSettings::DEFAULT,
        rotation: RotationSettings::DEFAULT,
    };
}

impl Default for RigidSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Impacts of a body on several points at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactSettings {
    /// Fraction of the contact distance below which a point counts as touching.
    pub touch_fraction: f64,
    /// Maximum number of sweeps over the points.
    pub maximum_sweeps: usize,
    /// Maximum number of points.
    pub maximum_points: usize,
}

impl ImpactSettings {
    /// Settings in use.
    pub const DEFAULT: Self = Self { touch_fraction: 0.1, maximum_sweeps: 100, maximum_points: 16 };
}

/// Substeps of a body, by its impacts and its rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidSubstepSettings {
    /// Length of an impact substep as a fraction of a step.
    pub impact_fraction: f64,
    /// Minimum length of any substep as a fraction of a step.
    pub minimum_fraction: f64,
    /// Maximum number of substeps of a step.
    pub maximum_substeps: u32,
    /// Maximum rotation of a touching body per substep, rad.
    pub maximum_rotation: f64,
    /// Motion of a touching body per substep, as a fraction of the prediction distance, above which
    /// other contact points are predicted.
    pub prediction_motion: f64,
}

impl RigidSubstepSettings {
    /// Settings in use.
    pub const DEFAULT: Self = Self {
        impact_fraction: 1.0 / 16.0,
        minimum_fraction: 1.0 / 64.0,
        maximum_substeps: 48,
        maximum_rotation: 0.3,
        prediction_motion: 0.05,
    };
}

/// Motion of a ball from impact to impact, with its exact surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollingBallSettings {
    /// Distance below which a surface is touched, m.
    pub touch_distance: f64,
    /// Distance to which the ball is advanced at an impact, m; well below the touch distance.
    pub impact_gap: f64,
    /// Separation speed up to which a surface supports the ball against gravity, m/s. Positions in
    /// single precision cause small errors of the normals.
    pub support_speed: f64,
    /// Speed that counts as zero, m/s.
    pub zero_speed: f64,
    /// Maximum number of segments of a step between impacts.
    pub maximum_segments: usize,
    /// Maximum number of sweeps over simultaneous contacts; one contact needs one.
    pub maximum_sweeps: usize,
}

impl RollingBallSettings {
    /// Settings in use.
    pub const DEFAULT: Self = Self {
        touch_distance: 1e-5,
        impact_gap: 2e-6,
        support_speed: 1e-3,
        zero_speed: 1e-6,
        maximum_segments: 24,
        maximum_sweeps: 12,
    };
}

/// Resistance of a ball to rolling and to rotation about the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollingResistanceSettings {
    /// Coefficient C of rolling resistance; hard balls on hard ground have 0.0003 to 0.002.
    pub coefficient: f64,
    /// Patch radius over ball radius, A; that of an indentation of 2e-4 radii.
    pub patch_ratio: f64,
}

impl RollingResistanceSettings {
    /// Settings in use.
    pub const DEFAULT: Self = Self { coefficient: 5e-4, patch_ratio: 0.02 };
}

/// Free rotation by the midpoint rule, and principal axes of inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationSettings {
    /// Maximum rotation per step of the midpoint rule, rad.
    pub maximum_rotation: f64,
    /// Maximum number of steps of the midpoint rule per free flight.
    pub maximum_steps: f64,
    /// Maximum number of Newton iterations per step of the midpoint rule; each gains at least one
    /// digit.
    pub maximum_newton_iterations: usize,
    /// Maximum number of Jacobi sweeps for the principal axes. Convergence is quadratic, so that
    /// few are needed.
    pub maximum_jacobi_sweeps: usize,
}

impl RotationSettings {
    /// Settings in use.
    pub const DEFAULT: Self = Self {
        maximum_rotation: 0.125,
        maximum_steps: 4000.0,
        maximum_newton_iterations: 24,
        maximum_jacobi_sweeps: 12,
    };
}
