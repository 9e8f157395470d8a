//! Settings of rigid bodies: impacts, penetration, substeps, rolling and rotation.

use crate::units::settings::settings;

settings! {
    /// Settings of rigid bodies.
    pub struct RigidSettings {
        /// Velocity change of a lent body, as a part of its velocities, below which sheets have not
        /// moved it.
        pub lent_rounding: f64 = 1e-6,
        /// Approach speed above which restitution acts between bodies, m/s.
        pub restitution_speed: f64 = 0.01,
        /// Penetration tolerance of two bodies, m. A rolling ball is moved out of less at once.
        pub penetration_tolerance: f64 = 1e-4,
        /// Fraction of a larger penetration of two bodies that a step removes.
        pub penetration_recovery: f64 = 0.2,
        /// Speed (m/s) above which a body wakes a sleeping one that it touches.
        pub wake_speed: f64 = 0.01,
        /// Maximum distance of a joint from the origins of its bodies, m: that of the origin of a
        /// body from the origin of the world.
        pub maximum_joint_distance: f32 = 1e4,
        /// Maximum number of steps of conservative advancement.
        pub maximum_advancement_steps: usize = 48,
        /// Impacts of a body on several points at once.
        pub impact: ImpactSettings = ImpactSettings::DEFAULT,
        /// Substeps of a body.
        pub substeps: RigidSubstepSettings = RigidSubstepSettings::DEFAULT,
        /// Motion of a ball from impact to impact.
        pub rolling_ball: RollingBallSettings = RollingBallSettings::DEFAULT,
        /// Rolling and drilling resistance.
        pub rolling_resistance: RollingResistanceSettings = RollingResistanceSettings::DEFAULT,
        /// Free rotation.
        pub rotation: RotationSettings = RotationSettings::DEFAULT,
    }

    /// Impacts of a body on several points at once.
    pub struct ImpactSettings {
        /// Fraction of the contact distance below which a point counts as touching.
        pub touch_fraction: f64 = 0.1,
        /// Maximum number of sweeps over the points.
        pub maximum_sweeps: usize = 100,
        /// Maximum number of points.
        pub maximum_points: usize = 16,
    }

    /// Substeps of a body, by its impacts and its rotation.
    pub struct RigidSubstepSettings {
        /// Length of an impact substep as a fraction of a step.
        pub impact_fraction: f64 = 1.0 / 16.0,
        /// Minimum length of any substep as a fraction of a step.
        pub minimum_fraction: f64 = 1.0 / 64.0,
        /// Maximum number of substeps of a step.
        pub maximum_substeps: u32 = 48,
        /// Maximum rotation of a touching body per substep, rad.
        pub maximum_rotation: f64 = 0.3,
        /// Motion of a touching body per substep, as a fraction of the prediction distance, above
        /// which other contact points are predicted.
        pub prediction_motion: f64 = 0.05,
    }

    /// Motion of a ball from impact to impact, with its exact surface.
    pub struct RollingBallSettings {
        /// Distance below which a surface is touched, m.
        pub touch_distance: f64 = 1e-5,
        /// Distance to which the ball is advanced at an impact, m; well below the touch distance.
        pub impact_gap: f64 = 2e-6,
        /// Separation speed up to which a surface supports the ball against gravity, m/s. Positions
        /// in single precision cause small errors of the normals.
        pub support_speed: f64 = 1e-3,
        /// Speed that counts as zero, m/s.
        pub zero_speed: f64 = 1e-6,
        /// Maximum number of segments of a step between impacts.
        pub maximum_segments: usize = 24,
        /// Maximum number of sweeps over simultaneous contacts; one contact needs one.
        pub maximum_sweeps: usize = 12,
    }

    /// Resistance of a ball to rolling and to rotation about the normal.
    pub struct RollingResistanceSettings {
        /// Coefficient C of rolling resistance; hard balls on hard ground have 0.0003 to 0.002.
        pub coefficient: f64 = 5e-4,
        /// Patch radius over ball radius, A; that of an indentation of 2e-4 radii.
        pub patch_ratio: f64 = 0.02,
    }

    /// Free rotation by the midpoint rule, and principal axes of inertia.
    pub struct RotationSettings {
        /// Maximum rotation per step of the midpoint rule, rad.
        pub maximum_rotation: f64 = 0.125,
        /// Inertia per mass of a caller's body that may not rotate about some axis, m²: so large
        /// that contact with a sheet does not turn it.
        pub locked_inertia: f64 = 1e9,
        /// Maximum number of steps of the midpoint rule per free flight.
        pub maximum_steps: f64 = 4000.0,
        /// Maximum number of Newton iterations per step of the midpoint rule; each gains at least
        /// one digit.
        pub maximum_newton_iterations: usize = 24,
        /// Maximum number of Jacobi sweeps for the principal axes. Convergence is quadratic, so
        /// that few are needed.
        pub maximum_jacobi_sweeps: usize = 12,
    }
}
