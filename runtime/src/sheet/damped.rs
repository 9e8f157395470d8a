//! All vibrations of a small sheet about where it is, with how fast each dies away.
//!
//! K φ = ω² M φ with K = -∂f/∂x and, of C = -∂f/∂v, the share of each: c = φᵀ C φ with φᵀ M φ = 1, so that x'' + c x' + ω² x = 0. What C
//! does between two of them is left out. Both matrices come of differences of forces, as they are, and are full: for some hundred
//! masses.

use faer::{Mat, Side};
use glam::DVec3;

use super::{Sheet, Vectors};
use crate::element::spring::SpringScratch;

/// A way the sheet vibrates, and how that dies away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampedMode {
    /// Square of its angular frequency, rad²/s²; negative where the sheet does not stand by itself.
    pub squared: f64,
    /// Rate c of its damping, 1/s: twice the damping ratio times the frequency.
    pub rate: f64,
}

/// Most masses of a sheet whose matrices are made.
pub const MOST_MASSES: usize = 200;

impl Sheet {
    /// All its vibrations about its present place, slowest first; none of a sheet of more than [`MOST_MASSES`] masses, or where they
    /// cannot be found.
    pub fn damped_modes(&self) -> Vec<DampedMode> {
        let n = self.masses();
        if n > MOST_MASSES {
            return Vec::new();
        }
        let free: Vec<usize> = (0..3 * n).filter(|i| self.inverse_mass[i / 3] > 0.0).collect();
        let still = Vectors::zeros(n);
        // Far below what forces tell apart, far above rounding.
        let (step, speed) = (1e-6 * self.spread.max(1e-6), 1e-3 * self.spread.max(1e-6));
        let along = |i: usize, size: f64| {
            let mut d = Vectors::zeros(n);
            let mut at = DVec3::ZERO;
            at[i % 3] = size;
            d.set(i / 3, at);
            d
        };
        let moved = |i: usize, size: f64| {
            let mut x = self.x.clone();
            x.add_scaled(1.0, &along(i, size));
            self.forces_at(&x, &still)
        };
        let columns = |size: f64, force: &dyn Fn(usize, f64) -> Vectors| -> Vec<Vec<f64>> {
            let column = |i: &usize| {
                let (ahead, behind) = (force(*i, size), force(*i, -size));
                let per = |k: &usize| (behind.get(k / 3)[k % 3] - ahead.get(k / 3)[k % 3]) / (2.0 * size);
                free.iter().map(per).collect()
            };
            free.iter().map(column).collect()
        };
        let stiffness = columns(step, &moved);
        let damping = columns(speed, &|i, size| self.forces_at(&self.x, &along(i, size)));
        let root: Vec<f64> = free.iter().map(|i| self.inverse_mass[i / 3].sqrt()).collect();
        let weighted = |of: &[Vec<f64>]| {
            Mat::from_fn(free.len(), free.len(), |i, j| 0.5 * (of[i][j] + of[j][i]) * root[i] * root[j])
        };
        let Ok(eigen) = weighted(&stiffness).self_adjoint_eigen(Side::Lower) else { return Vec::new() };
        let rates = eigen.U().transpose() * weighted(&damping) * eigen.U();
        let squared = eigen.S().column_vector();
        (0..free.len()).map(|k| DampedMode { squared: squared[k], rate: rates[(k, k)] }).collect()
    }

    /// Forces of springs and elements at `x` (m) and `v` (m/s), N.
    fn forces_at(&self, x: &Vectors, v: &Vectors) -> Vectors {
        let mut force = Vectors::zeros(x.len());
        self.springs.add_forces(x, v, true, &mut SpringScratch::default(), &mut force);
        self.elements.iter().for_each(|e| e.add_forces(x, v, &mut force));
        force
    }
}
