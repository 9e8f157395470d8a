//! What the air does to a sheet: pressure on what moves across itself, friction on what moves along itself.
//!
//! On a mass that stands for the area A with normal n, moving at u relative to the wind,
//!
//! f = -½ ρ A (C_n |u·n| (u·n) n + C_t |u_t| u_t), u_t = u - (u·n) n,
//!
//! with ρ the density of the air: a flat plate across the stream has C_n of about 1.17, along it C_t of about 0.02 for both
//! sides (Hoerner, *Fluid-Dynamic Drag*, 1965). Areas and normals are those of the triangles around a mass. Sheets do not
//! shelter one another, and air is not set in motion.
//!
//! Implicit stages take f = -K u with K from the place and speed a stage begins at.

use glam::{DMat3, DVec3};

use super::{Field, Vectors};
use crate::engine::implicit::Stage;
use crate::engine::linear::Pattern;

/// Drag of one sheet.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drag {
    triangles: Vec<[u32; 3]>,
    /// Part of the area that a layer answers for.
    share: f64,
    /// C_n and C_t.
    pub coefficients: (f64, f64),
    /// n A of each mass, m².
    areas: Vec<DVec3>,
    /// K of each mass, N s/m; empty where there is no air.
    tensors: Vec<DMat3>,
    wind: DVec3,
}

impl Drag {
    /// Drag on the triangles of all layers of a sheet.
    pub fn new(triangles: Vec<[u32; 3]>, layers: usize, coefficients: (f64, f64)) -> Self {
        Self { triangles, share: 1.0 / layers.max(1) as f64, coefficients, ..Self::default() }
    }

    /// Takes K from positions `x` (m) and velocities `v` (m/s).
    pub fn begin(&mut self, field: &Field, x: &Vectors, v: &Vectors) {
        if field.air_density == 0.0 {
            self.tensors.clear();
            return;
        }
        self.wind = field.wind;
        self.areas.resize(x.len(), DVec3::ZERO);
        self.areas.fill(DVec3::ZERO);
        for t in &self.triangles {
            let [a, b, c] = t.map(|m| x.get(m as usize));
            let third = (b - a).cross(c - a) * (self.share / 6.0);
            t.iter().for_each(|m| self.areas[*m as usize] += third);
        }
        let half = 0.5 * field.air_density;
        self.tensors.resize(x.len(), DMat3::ZERO);
        for (i, (tensor, area)) in self.tensors.iter_mut().zip(&self.areas).enumerate() {
            let size = area.length();
            let n = area.normalize_or_zero();
            let u = v.get(i) - field.wind;
            let across = u.dot(n);
            let along = (u - n * across).length();
            let (across, along) = (self.coefficients.0 * across.abs(), self.coefficients.1 * along);
            let normal = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
            *tensor = (normal * (across - along) + DMat3::from_diagonal(DVec3::splat(along))) * (half * size);
        }
    }

    /// Adds the force on each mass (N) at `x` and `v`: for explicit engines.
    pub fn add_forces(&mut self, field: &Field, x: &Vectors, v: &Vectors, force: &mut Vectors) {
        self.begin(field, x, v);
        for (i, k) in self.tensors.iter().enumerate() {
            force.set(i, force.get(i) - *k * (v.get(i) - self.wind));
        }
    }

    /// u of mass `i` in a stage.
    fn relative(&self, stage: &Stage, x: &Vectors, i: usize) -> DVec3 {
        (x.get(i) - stage.w.get(i)) * stage.per_time - self.wind
    }

    /// The part of Φ whose gradient is minus the drag, J.
    pub fn potential(&self, stage: &Stage, x: &Vectors) -> f64 {
        let each = self.tensors.iter().enumerate().map(|(i, k)| {
            if stage.per_time > 0.0 {
                let u = self.relative(stage, x, i);
                0.5 * u.dot(*k * u) / stage.per_time
            } else {
                -x.get(i).dot(*k * self.wind)
            }
        });
        each.sum()
    }

    /// Adds the gradient of that, N.
    pub fn add_gradient(&self, stage: &Stage, x: &Vectors, gradient: &mut Vectors) {
        for (i, k) in self.tensors.iter().enumerate() {
            gradient.set(i, gradient.get(i) + *k * self.relative(stage, x, i));
        }
    }

    /// Adds its tangent, K/h on the diagonal; `masses` are those of the block rows.
    pub fn add_tangent(&self, stage: &Stage, masses: &[u32], pattern: &Pattern, values: &mut [f64]) {
        if self.tensors.is_empty() {
            return;
        }
        for (row, mass) in masses.iter().enumerate() {
            let at = 9 * pattern.starts[row] as usize;
            // Symmetric, so that columns are rows.
            let k = (self.tensors[*mass as usize] * stage.per_time).to_cols_array();
            values[at..at + 9].iter_mut().zip(k).for_each(|(to, k)| *to += k);
        }
    }
}
