//! Settings of integrators: Newton iteration of implicit stages, and limits of single integrators.

use crate::units::settings::settings;

settings! {
    /// Settings of integrators.
    pub struct IntegratorSettings {
        /// Newton iteration of implicit stages.
        pub newton: NewtonSettings = NewtonSettings::DEFAULT,
        /// Speed (m/s) below which `bdf2` counts a sheet in contact as resting.
        pub resting_speed: f64 = 5e-3,
        /// Speed (m/s) above which a resting sheet of `bdf2` counts as moving.
        pub leaving_speed: f64 = 0.1,
        /// Minimum step of `rk45` as a fraction of `dt`; it is accepted with any error. An unstable
        /// sheet is then detected by its speed instead of by an endless loop.
        pub minimum_adaptive_step: f64 = 1e-6,
    }

    /// Newton iteration of implicit stages. Energies are fractions of the inertial term of the
    /// stage.
    pub struct NewtonSettings {
        /// Tolerance of a rise of Φ.
        pub potential_rise: f64 = 0.02,
        /// Tolerance of the energy of the prediction error.
        pub prediction_error: f64 = 1e-4,
        /// Tolerance of the energy of the prediction error with contact.
        pub prediction_error_contact: f64 = 1e-2,
        /// Tolerance of the energy of the prediction error of a sheet that is attached to a dynamic
        /// body. A rotation by φ in an outer iteration mispredicts an energy proportional to
        /// φ⁴, but the attachment forces on two rows of a stiff sheet, hundreds of newtons, are
        /// wrong by φ. At 0.01 rad, which the tolerance of other sheets allows, a strip on a drum
        /// loses a fifth of its angular momentum in one step.
        pub prediction_error_attached: f64 = 1e-12,
        /// Speed (m/s) whose kinetic energy is the minimum of the inertial term: below it, the
        /// kinetic energy of a sheet does not justify another solve.
        pub reference_speed: f64 = 1e-3,
        /// Speed (m/s) whose kinetic energy is the minimum of the reference energy of a stage of an
        /// island.
        pub reference_speed_stage: f64 = 5e-3,
        /// Maximum number of mixed-stress steps before the globalised method.
        pub maximum_mixed_steps: u32 = 9,
        /// Maximum number of steps of the globalised method.
        pub maximum_descent_steps: u32 = 15,
    }
}
