//! All vibration modes of a small sheet about its present state, with their damping rates.
//!
//! K φ = ω² M φ with K = -∂f/∂x, and the modal part c = φᵀ C φ of C = -∂f/∂v with φᵀ M φ = 1, so
//! that x'' + c x' + ω² x = 0. The coupling of modes by C is neglected. Both matrices are dense and
//! come from central differences of the forces, which suits some dozens of nodes.

use glam::DVec3;
use nalgebra::DMatrix;

use crate::elements::spring::SpringWorkspace;
use crate::linear::dense::symmetric_eigen;
use crate::math::Vectors;
use crate::sheet::Sheet;

/// Vibration mode with its damping rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampedMode {
    /// Square of the angular frequency, rad²/s²; negative for an unstable mode.
    pub squared: f64,
    /// Damping rate c, 1/s: twice the damping ratio times the angular frequency.
    pub rate: f64,
}

/// Maximum number of nodes for dense matrices.
pub const MAX_NODES: usize = 64;

impl Sheet {
    /// All modes about the present state, lowest first; empty for a sheet of more than 64 nodes, or
    /// if the eigenvalue problem fails.
    pub fn damped_modes(&self) -> Vec<DampedMode> {
        let n = self.node_count();
        if n > MAX_NODES {
            return Vec::new();
        }
        let free: Vec<usize> = (0..3 * n).filter(|i| self.inverse_mass[i / 3] > 0.0).collect();
        let still = Vectors::zeros(n);
        // The increments are small against the nonlinearity of the forces and large against
        // rounding.
        let (step, speed) =
            (1e-6 * self.model.initial_diagonal.max(1e-6), 1e-3 * self.model.initial_diagonal.max(1e-6));
        let along = |i: usize, size: f64| {
            let mut d = Vectors::zeros(n);
            let mut at = DVec3::ZERO;
            at[i % 3] = size;
            d.set(i / 3, at);
            d
        };
        let moved = |i: usize, size: f64| {
            let mut x = self.state.x.clone();
            x.add_scaled(1.0, &along(i, size));
            forces_at(self, &x, &still)
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
        let damping = columns(speed, &|i, size| forces_at(self, &self.state.x, &along(i, size)));
        let root: Vec<f64> = free.iter().map(|i| self.inverse_mass[i / 3].sqrt()).collect();
        let weighted = |of: &[Vec<f64>]| {
            DMatrix::from_fn(free.len(), free.len(), |i, j| 0.5 * (of[i][j] + of[j][i]) * root[i] * root[j])
        };
        modes(weighted(&stiffness), &weighted(&damping)).unwrap_or_default()
    }
}

/// Forces of springs and elements at `x` (m) and `v` (m/s), N.
fn forces_at(sheet: &Sheet, x: &Vectors, v: &Vectors) -> Vectors {
    let mut force = Vectors::zeros(x.len());
    sheet.springs.add_forces(x, v, true, &mut SpringWorkspace::default(), &mut force);
    sheet.elements.iter().for_each(|e| e.add_forces(x, v, &mut force));
    force
}

/// Modes of x'' + C x' + K x = 0, lowest first; `None` if the eigenvalue problem fails.
fn modes(stiffness: DMatrix<f64>, damping: &DMatrix<f64>) -> Option<Vec<DampedMode>> {
    let (squared, vectors) = symmetric_eigen(stiffness)?;
    let rates = vectors.transpose() * damping * &vectors;
    Some(squared.iter().zip(&rates.diagonal()).map(|(&squared, &rate)| DampedMode { squared, rate }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::World;
    use crate::mesh::structure::StructureKind;
    use crate::scene::{PinSpec, Region, Scene, SheetSpec};

    #[test]
    fn two_oscillators_turned_by_45_degrees_have_their_own_frequencies_and_rates() {
        // 1 and 2 rad/s, 0.2 and 0.6 1/s, along the diagonals.
        let turned = |a: f64, b: f64| DMatrix::from_fn(2, 2, |i, j| 0.5 * if i == j { a + b } else { a - b });
        let found = modes(turned(1.0, 4.0), &turned(0.2, 0.6)).expect("found");
        let near = |m: DampedMode, squared: f64, rate: f64| (m.squared - squared).abs() + (m.rate - rate).abs() < 1e-12;
        assert!(found.len() == 2 && near(found[0], 1.0, 0.2) && near(found[1], 4.0, 0.6), "{found:?}");
    }

    #[test]
    fn stiffness_proportional_damping_gives_proportional_rates_and_fixed_nodes_have_no_modes() {
        let sheet = SheetSpec {
            structure: StructureKind::Slamm,
            grid: (4, 2, 3),
            damping: 0.1,
            pins: vec![PinSpec::clamped(Region::Left)],
            ..SheetSpec::thesis()
        };
        let world = World::new(&Scene { sheets: vec![sheet], ..Scene::thesis() }).expect("valid");
        let sheet = &world.sheets()[0];
        let modes = sheet.damped_modes();
        let held = (0..sheet.node_count()).filter(|i| sheet.is_held(*i)).count();
        assert!(held > 0 && modes.len() == 3 * (sheet.node_count() - held));
        let tau = sheet.springs().damping[0] / sheet.springs().stiffness[0];
        let (fastest, omega) = (modes[modes.len() - 1], sheet.largest_frequency(3000));
        assert!((fastest.squared.sqrt() / omega - 1.0).abs() < 1e-3, "{fastest:?} {omega}");
        for mode in modes.iter().filter(|m| m.squared > 1e-3 * fastest.squared) {
            assert!((mode.rate / (tau * mode.squared) - 1.0).abs() < 1e-3, "{mode:?} {tau}");
        }
    }
}
