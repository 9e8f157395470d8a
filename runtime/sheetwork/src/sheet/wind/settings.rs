//! Settings of wind zones.

use crate::units::settings::settings;

settings! {
    /// Settings of wind zones.
    pub struct WindSettings {
        /// Density of the air of a zone in a scene without air, kg/m³: at 20 °C and sea level.
        pub air_density: f64 = 1.2,
        /// Speed of sound, m/s: that of a blast.
        pub speed_of_sound: f64 = 340.0,
        /// End of a blast, in durations of its positive phase: its velocity is then below 1e-4 of
        /// the peak.
        pub blast_end: f64 = 12.0,
        /// Part of the weight of a sheet above which unsteady wind wakes it: below it, friction
        /// holds a sheet on any surface.
        pub waking_load: f64 = 0.1,
        /// Bands of wave number of turbulence, of three modes each: a mode costs a cosine per node.
        pub turbulence_bands: usize = 4,
        /// Wakes of moving bodies.
        pub wake: WakeSettings = WakeSettings::DEFAULT,
    }

    /// Wakes of moving bodies, each a sphere of equal volume.
    pub struct WakeSettings {
        /// Spreading rate of the wake of a sphere (Pope, *Turbulent Flows*, 2000, 5.4).
        pub spreading: f64 = 0.51,
        /// Drag coefficient of a sphere at Reynolds numbers of 1e3 to 1e5.
        pub drag: f64 = 0.5,
        /// Length of a wake, and distance up to which a body moves the air, in radii: its velocity
        /// is then below 1/50 of the body's.
        pub reach: f64 = 40.0,
        /// Speed below which a body moves no air, m/s: at it the pressure is 6e-5 Pa.
        pub minimum_speed: f64 = 0.01,
    }
}
