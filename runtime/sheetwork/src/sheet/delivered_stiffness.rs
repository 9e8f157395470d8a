//! Delivered stiffness of a running sheet: the part of the requested modulus that structure, grid
//! and step produce.
//!
//! - Structure: fraction of the bending stiffness that the springs deliver (1 for a shell).
//! - Grid: second differences see a wave of wave number q with the relative stiffness (1 - (q
//!   h)²/12)². q is that of the present shape, q⁴ = Σ (Δκ)²/(h⁴ Σ κ²) with the curvature κ along
//!   the grid, or that of the slowest wave, 1.875/L, for a flat sheet. (Droop at rest is more
//!   accurate, because the weights at a clamp remove most of the error.)
//! - Step: a wave of wave number q oscillates at ω = q² √(D/ρt); the integrator advances its phase
//!   by an angle that differs from ω dt, and damps it. A sheet at rest has no error from the step.
//!
//! The estimates hold to leading order for waves that the grid resolves, and not for a crumpled
//! sheet.

use serde::Serialize;

use crate::scene::sleep::SLEEP;
use crate::sheet::Sheet;

/// Delivered part of a modulus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DeliveredStiffness {
    /// Requested Young's modulus, Pa.
    pub asked_pa: f64,
    /// Young's modulus of an exact sheet with the same bending stiffness, Pa.
    pub bends_as_pa: f64,
    /// Fraction that the structure delivers.
    pub structure: f64,
    /// Fraction of the structure's stiffness that the grid delivers for the present shape.
    pub grid: f64,
    /// Fraction of the grid's stiffness that the step delivers for the present motion; 1 at rest.
    pub step: f64,
    /// Wave number of the present shape, rad/m.
    pub wave_number_rad_m: f64,
    /// Damping ratio of this wave by the material.
    pub material_damping_ratio: f64,
    /// Damping ratio of this wave by the integrator, which is a numerical error.
    pub numerical_damping_ratio: f64,
}

impl Sheet {
    /// Stiffness that structure, grid, integrator and step `dt` (s) deliver; `None` for springs
    /// that are not calibrated to the bending stiffness.
    pub fn delivered_stiffness(&self, dt: f64) -> Option<DeliveredStiffness> {
        let structure = self.parameters.springs.delivered_fraction?;
        let (q, grid) = resolved(self);
        let law = self.law();
        let d = law.bending;
        let areal = self.material().areal_mass();
        let omega = q * q * (structure * grid * d[0][0] / areal).sqrt();
        let moves = self.max_speed() > SLEEP.speed;
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
        // The modulus of an orthotropic sheet is that of bending along the length.
        let plate = d[0][0] - d[0][1] * d[0][1] / d[1][1];
        let asked = 12.0 * plate / self.material().thickness.powi(3);
        Some(DeliveredStiffness {
            asked_pa: asked,
            bends_as_pa: asked * structure * grid * step,
            structure,
            grid,
            step,
            wave_number_rad_m: q,
            material_damping_ratio: 0.5 * (law.retardation * omega + self.loss_factor()),
            numerical_damping_ratio: numerical,
        })
    }
}

/// Wave number of the present shape (rad/m), and the fraction of the bending stiffness that the
/// grid delivers for it.
fn resolved(sheet: &Sheet) -> (f64, f64) {
    let slowest = 1.875_104 / sheet.model.length;
    let Some(layer) = sheet.model.layers.first().filter(|_| sheet.model.triangles.is_none()) else {
        // On triangles the slowest wave represents the shape, and the area per node gives the
        // spacing.
        let h2 = sheet.total_mass() / sheet.material().areal_mass() / sheet.node_count().max(1) as f64;
        return (slowest, (1.0 - slowest * slowest * h2 / 12.0).powi(2));
    };
    let (nx, nz) = (layer.nx, layer.nz);
    let mut sums = CurvatureSums { curvature: 0.0, bend: 0.0, spacing: f64::INFINITY };
    let mut line = Vec::new();
    for j in 0..nz {
        line.clear();
        line.extend((0..nx).map(|i| layer.at(i, j) as usize));
        sums.add(sheet, &line);
    }
    // The rows of a triangular layer are staggered.
    if !layer.triangular {
        for i in 0..nx {
            line.clear();
            line.extend((0..nz).map(|j| layer.at(i, j) as usize));
            sums.add(sheet, &line);
        }
    }
    let h = sums.spacing;
    // A sheet flat to 1e-6 is evaluated at the slowest wave.
    let q = if sums.curvature <= 1e-12 { slowest } else { (sums.bend / sums.curvature).sqrt().sqrt() / h };
    let q = q.max(slowest).min(std::f64::consts::PI / h);
    (q, (1.0 - (q * h).powi(2) / 12.0).powi(2))
}

/// Dimensionless curvature along grid lines: Σ κ² and Σ (Δκ)², and the smallest spacing (m).
struct CurvatureSums {
    curvature: f64,
    bend: f64,
    spacing: f64,
}

impl CurvatureSums {
    /// Add a line of nodes without two at each end, because differences beside a clamp are not
    /// smooth.
    fn add(&mut self, sheet: &Sheet, line: &[usize]) {
        let x = |k: usize| sheet.state.x.get(line[k]);
        let curvature = |k: usize| x(k - 1) - x(k) * 2.0 + x(k + 1);
        self.spacing = line
            .windows(2)
            .map(|w| sheet.state.x.get(w[0]).distance(sheet.state.x.get(w[1])))
            .fold(self.spacing, f64::min);
        for k in 3..line.len().saturating_sub(3) {
            self.curvature += curvature(k).length_squared();
            self.bend += (curvature(k - 1) - curvature(k) * 2.0 + curvature(k + 1)).length_squared();
        }
    }
}
