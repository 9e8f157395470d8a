//! Turbulence as a sum of Fourier modes, after Kraichnan, "Diffusion by a random velocity field",
//! Physics of Fluids 13, 1970.
//!
//! A mode is u = a cos 2π(k·x - f t + φ) with the amplitude a across the wave vector k (1/m),
//! so that each mode, and their sum, is free of divergence. Four shells of wavelengths L, L/2, L/4
//! and L/8 have three modes each, along three random axes at right angles, with equal variance in
//! every direction. The variance of a shell is as k^(-2/3), the energy of Kolmogorov's inertial
//! range in a band of constant ratio. A mode changes at the rate f = σ |k| of its own eddies,
//! with σ (m/s) the root mean square of a component.

use glam::{DQuat, DVec3};

use crate::scene::TurbulenceSpec;
use crate::sheet::wind::settings::WindSettings;

/// Bands of wave number.
const BANDS: usize = WindSettings::DEFAULT.turbulence_bands;

#[derive(Clone, Copy, Debug, Default)]
struct Mode {
    /// Amplitude, m/s.
    amplitude: DVec3,
    /// Wave vector over 2π, 1/m.
    wave: DVec3,
    /// Frequency, 1/s.
    frequency: f64,
    /// Phase, turns.
    phase: f64,
}

/// Turbulent velocity field.
#[derive(Clone, Debug)]
pub(super) struct Turbulence {
    modes: [Mode; 3 * BANDS],
}

impl Turbulence {
    pub fn new(spec: &TurbulenceSpec) -> Self {
        let mut random = SplitMix(u64::from(spec.seed));
        let weight = |shell: usize| 4.0_f64.powf(-(shell as f64) / 3.0);
        let total: f64 = (0..BANDS).map(weight).sum();
        let mut modes = [Mode::default(); 3 * BANDS];
        for (shell, part) in modes.chunks_exact_mut(3).enumerate() {
            let [x, y, z, w] = [(); 4].map(|()| random.next() - 0.5);
            let rotation = DQuat::from_xyzw(x, y, z, w + 1e-9).normalize();
            let amplitude = spec.intensity * (2.0 * weight(shell) / total).sqrt();
            let wave = f64::from(1_u32 << shell) / spec.length;
            let axes = [DVec3::X, DVec3::Y, DVec3::Z];
            for (axis, mode) in part.iter_mut().enumerate() {
                *mode = Mode {
                    amplitude: rotation * axes[(axis + 1) % 3] * amplitude,
                    wave: rotation * axes[axis] * wave,
                    frequency: spec.intensity * wave,
                    phase: random.next(),
                };
            }
        }
        Self { modes }
    }

    /// Velocity at `x` (m) in the frame of the mean flow at `time` (s), m/s.
    pub fn velocity(&self, x: DVec3, time: f64) -> DVec3 {
        let each = self.modes.iter();
        each.map(|m| m.amplitude * cosine_of_turns(m.wave.dot(x) - m.frequency * time + m.phase)).sum()
    }
}

/// cos 2πt to 1e-9, with basic operations only: equal on every platform.
pub(super) fn cosine_of_turns(t: f64) -> f64 {
    let x = std::f64::consts::TAU * (0.25 - (t - t.round()).abs());
    let s = x * x;
    let high = s * (-1.0 / 5040.0 + s * (1.0 / 362_880.0 + s * (-1.0 / 39_916_800.0 + s / 6_227_020_800.0)));
    x * (1.0 + s * (-1.0 / 6.0 + s * (1.0 / 120.0 + high)))
}

/// SplitMix64 (Steele, Lea, Flood, 2014).
struct SplitMix(u64);

impl SplitMix {
    /// Next number, 0 to below 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / 18_446_744_073_709_551_616.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cosine_agrees_with_the_library() {
        for i in -2000..2000 {
            let t = f64::from(i) * 0.00137;
            assert!((cosine_of_turns(t) - (std::f64::consts::TAU * t).cos()).abs() < 1e-9, "{t}");
        }
    }

    #[test]
    fn turbulence_has_its_intensity_in_every_direction_and_no_divergence() {
        for seed in [0, 1, 77] {
            let field = Turbulence::new(&TurbulenceSpec { intensity: 2.0, length: 0.5, seed });
            let mut square = DVec3::ZERO;
            let mut random = SplitMix(9);
            let count = 20_000;
            for _ in 0..count {
                let x = DVec3::new(random.next(), random.next(), random.next()) * 40.0;
                let u = field.velocity(x, 0.3);
                square += u * u / f64::from(count);
            }
            let rms = square.to_array().map(f64::sqrt);
            assert!(rms.iter().all(|r| (r - 2.0).abs() < 0.06), "{rms:?}");
            let (x, h) = (DVec3::new(0.1, 0.7, -0.3), 1e-4);
            let slope =
                |axis: DVec3| (field.velocity(x + axis * h, 0.3) - field.velocity(x - axis * h, 0.3)) / (2.0 * h);
            let each = [slope(DVec3::X).x, slope(DVec3::Y).y, slope(DVec3::Z).z];
            let divergence: f64 = each.iter().sum();
            assert!(divergence.abs() < 1e-3 * each.iter().map(|d| d.abs()).fold(0.0, f64::max), "{divergence}");
        }
    }
}
