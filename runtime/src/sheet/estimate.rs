//! How stiff a sheet really is as it runs: what structure, grid and step leave of the modulus that was asked for.
//!
//! - Structure: the fraction of the bending stiffness that its springs deliver (1 for a shell).
//! - Grid: second differences see a wave of wave number q as softer by (1 - (q h)²/12)². How short the waves of the present
//!   shape are follows from comparing its curvature by differences over h and over 2h: Σ κ₂ₕ²/Σ κ_h² = 1 - (q h)²/2 to this order.
//!   A flat sheet is judged by its slowest wave, q = 1.875/L.
//! - Step: a wave of q vibrates at ω = q² √(D/ρt), and the engine turns it by another angle a step than ω dt, and damps it.
//!   A sheet at rest owes nothing to the step.
//!
//! Estimates for waves that the grid resolves, to leading order; a crumpled sheet is beyond them.

use serde::Serialize;

use super::Sheet;
use crate::step::SLEEP_SPEED;

/// What is left of a modulus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DeliveredStiffness {
    /// Young's modulus asked for, Pa.
    pub asked_pa: f64,
    /// Young's modulus of a sheet without errors that would bend as this one does, Pa.
    pub bends_as_pa: f64,
    /// Fraction that the structure delivers.
    pub structure: f64,
    /// Fraction of that which the grid leaves for the present shape.
    pub grid: f64,
    /// Fraction of that which the step leaves for the present motion; 1 at rest.
    pub step: f64,
    /// Wave number of the present shape, rad/m.
    pub wave_number_rad_m: f64,
    /// Damping ratio of that wave by the material.
    pub material_damping_ratio: f64,
    /// Damping ratio of that wave by the engine alone: an error, not physics.
    pub numerical_damping_ratio: f64,
}

impl Sheet {
    /// What grid, engine and step `dt` (s) deliver now of the stiffness asked for; `None` where springs have their stiffness
    /// by a rule that does not aim at it, or masses lie on no regular grid.
    pub fn delivered_stiffness(&self, dt: f64) -> Option<DeliveredStiffness> {
        let structure = self.delivered?;
        let (q, grid) = self.resolved();
        let law = self.law();
        let areal = self.material().areal_mass();
        let omega = q * q * (structure * grid * law.bending[0][0] / areal).sqrt();
        let moves = self.max_speed() > SLEEP_SPEED;
        let (mut step, mut numerical) = (1.0, 0.0);
        if let Some(amplification) = self.engine().info().amplification {
            let angle = omega * dt;
            let (modulus, turned) = amplification(angle);
            if angle > 0.0 && turned > 0.0 {
                numerical = -modulus.ln() / turned;
                if moves {
                    step = (turned / angle).powi(2);
                }
            }
        }
        let asked = self.material().young;
        Some(DeliveredStiffness {
            asked_pa: asked,
            bends_as_pa: asked * structure * grid * step,
            structure,
            grid,
            step,
            wave_number_rad_m: q,
            material_damping_ratio: 0.5 * law.retardation * omega,
            numerical_damping_ratio: numerical,
        })
    }

    /// Wave number of the present shape (rad/m) and the fraction of bending stiffness that the grid has for it.
    fn resolved(&self) -> (f64, f64) {
        let slowest = 1.875_104 / self.length;
        let Some(layer) = self.layers.first().filter(|_| self.triangles.is_none()) else { return (slowest, 1.0) };
        let (nx, nz) = (layer.nx, layer.nz);
        let mut near = 0.0;
        let mut far = 0.0;
        let mut spacing = f64::INFINITY;
        let mut add = |masses: [u32; 5]| {
            let [a, b, c, d, e] = masses.map(|m| self.x.get(m as usize));
            spacing = spacing.min(b.distance(c));
            near += (b - c * 2.0 + d).length_squared();
            far += (a - c * 2.0 + e).length_squared() / 16.0;
        };
        for j in 0..nz {
            for i in 2..nx.saturating_sub(2) {
                add([i - 2, i - 1, i, i + 1, i + 2].map(|i| layer.at(i, j)));
            }
        }
        // The rows of a triangular layer do not lie behind one another.
        if !layer.triangular {
            for i in 0..nx {
                for j in 2..nz.saturating_sub(2) {
                    add([j - 2, j - 1, j, j + 1, j + 2].map(|j| layer.at(i, j)));
                }
            }
        }
        // Flat to a millionth of a radian a cell: nothing to compare.
        let count = f64::from(nx) * f64::from(nz);
        if !spacing.is_finite() || near <= 1e-12 * spacing * spacing * count {
            let h = self.length / f64::from(nx.max(nz).max(2) - 1);
            return (slowest, 1.0 - (slowest * h).powi(2) / 6.0);
        }
        let lost = (1.0 - far / near).clamp(0.0, 1.0);
        ((2.0 * lost).sqrt().max(slowest * spacing) / spacing, 1.0 - lost / 3.0)
    }
}
