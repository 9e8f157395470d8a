//! All vibrations of a small sheet about where it is, with how fast each dies away.
//!
//! With K = -∂f/∂x and C = -∂f/∂v every complex pair of eigenvalues λ of x'' + M⁻¹ C x' + M⁻¹ K x = 0 is a vibration with ω = |λ| and
//! c = -2 Re λ, as x'' + c x' + ω² x = 0 has it. Real eigenvalues say not which two are of one motion: what is overdamped is taken from
//! K φ = ω² M φ and c = φᵀ C φ, without what C does between two of them. Both matrices come of differences of forces and are full: for
//! some dozens of masses.

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
pub const MOST_MASSES: usize = 64;

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
        modes(&weighted(&stiffness), &weighted(&damping)).unwrap_or_default()
    }

    /// Forces of springs and elements at `x` (m) and `v` (m/s), N.
    fn forces_at(&self, x: &Vectors, v: &Vectors) -> Vectors {
        let mut force = Vectors::zeros(x.len());
        self.springs.add_forces(x, v, true, &mut SpringScratch::default(), &mut force);
        self.elements.iter().for_each(|e| e.add_forces(x, v, &mut force));
        force
    }
}

/// The vibrations of x'' + C x' + K x = 0, slowest first; none where they cannot be found.
fn modes(stiffness: &Mat<f64>, damping: &Mat<f64>) -> Option<Vec<DampedMode>> {
    let n = stiffness.nrows();
    let eigen = stiffness.self_adjoint_eigen(Side::Lower).ok()?;
    let rates = eigen.U().transpose() * damping * eigen.U();
    let squared = eigen.S().column_vector();
    let overdamped = |k: &usize| rates[(*k, *k)] * rates[(*k, *k)] >= 4.0 * squared[*k];
    let mut all: Vec<DampedMode> =
        (0..n).filter(overdamped).map(|k| DampedMode { squared: squared[k], rate: rates[(k, k)] }).collect();
    // In the fastest motion's time, so that both halves of the state are of one size.
    let fastest = squared[n.checked_sub(1)?].max(f64::MIN_POSITIVE).sqrt();
    let state = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => 0.0,
        (true, false) => f64::from(u8::from(i + n == j)),
        (false, true) => -stiffness[(i - n, j)] / (fastest * fastest),
        (false, false) => -damping[(i - n, j - n)] / fastest,
    });
    let roots = state.eigenvalues().ok()?;
    let vibrates = roots.iter().filter(|root| root.im > 1e-6);
    all.extend(
        vibrates
            .map(|root| DampedMode { squared: root.norm_sqr() * fastest * fastest, rate: -2.0 * root.re * fastest }),
    );
    all.sort_by(|a, b| a.squared.total_cmp(&b.squared));
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vibrations_that_damping_couples_have_the_roots_of_their_polynomial() {
        // Two oscillators of 1 and 2 rad/s; a dashpot between them and one on the second.
        let k = Mat::from_fn(2, 2, |i, j| if i == j { [1.0, 4.0][i] } else { 0.0 });
        let c = Mat::from_fn(2, 2, |i, j| [[0.2, -0.2], [-0.2, 0.5]][i][j]);
        let found = modes(&k, &c).expect("found");
        assert_eq!(found.len(), 2);
        for mode in found {
            // det(λ² + λ C + K) = 0 at λ = -c/2 + i √(ω² - c²/4).
            let (re, im) = (-0.5 * mode.rate, (mode.squared - 0.25 * mode.rate * mode.rate).sqrt());
            let times = |a: (f64, f64), b: (f64, f64)| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
            let root = (re, im);
            let square = times(root, root);
            let entry = |c: f64, k: f64| (square.0 + c * re + k, square.1 + c * im);
            let (first, second, beside) = (entry(0.2, 1.0), entry(0.5, 4.0), (-0.2 * re, -0.2 * im));
            let (product, crossed) = (times(first, second), times(beside, beside));
            assert!((product.0 - crossed.0).hypot(product.1 - crossed.1) < 1e-12, "{mode:?}");
        }
        // One that is overdamped keeps its own numbers.
        let strong = Mat::from_fn(2, 2, |i, j| if i == j { [3.0, 0.1][i] } else { 0.0 });
        let found = modes(&k, &strong).expect("found");
        let near = |m: DampedMode, squared: f64, rate: f64| (m.squared - squared).abs() + (m.rate - rate).abs() < 1e-12;
        assert!(near(found[0], 1.0, 3.0) && near(found[1], 4.0, 0.1), "{found:?}");
    }
}
