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
//! A difference of pressure between its two sides (a vacuum below it, air blown under it) pushes each mass by -p A n.
//!
//! Implicit stages take f = -K u and the push with K, A and n from the place and speed a stage begins at.

use glam::{DMat3, DVec3};

use crate::integrators::implicit::Stage;
use crate::linear::Pattern;
use crate::math::Vectors;
use crate::scene::PressureKey;
use crate::serialize::{Keeper, Taken, Taker};
use crate::sheet::Field;

/// Drag of one sheet.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drag {
    triangles: Vec<[u32; 3]>,
    /// Part of the area that a layer answers for.
    share: f64,
    /// C_n and C_t.
    pub coefficients: (f64, f64),
    /// Pressure on the upper side above that on the lower, Pa.
    pub pressure: f64,
    /// Area of the lowest layer over the mean of all, which some lattices' upper ones fall short of: pressure finds a whole sheet.
    cover: f64,
    /// What it follows; empty for what stays.
    schedule: Vec<PressureKey>,
    /// n A of each mass, m².
    areas: Vec<DVec3>,
    /// K of each mass, N s/m; empty where there is no air.
    tensors: Vec<DMat3>,
    /// What pressure pushes each mass by, N; empty where there is none.
    pushes: Vec<DVec3>,
    wind: DVec3,
}

impl Drag {
    /// Drag on the triangles of all layers of a sheet.
    pub fn new(triangles: Vec<[u32; 3]>, layers: usize, coefficients: (f64, f64)) -> Self {
        Self { triangles, share: 1.0 / layers.max(1) as f64, cover: 1.0, coefficients, ..Self::default() }
    }

    /// Takes up other triangles.
    pub fn set_triangles(&mut self, triangles: Vec<[u32; 3]>) {
        self.triangles = triangles;
    }

    /// Lets pressure follow `keys`, from time 0. The sheet lies at `x` (m); `lowest` triangles are those of its lowest layer.
    pub fn follow(&mut self, keys: &[PressureKey], x: &Vectors, lowest: usize) {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|m| x.get(m as usize));
            (b - a).cross(c - a).length()
        };
        let one: f64 = self.triangles.iter().take(lowest).map(area).sum();
        let mean = self.triangles.iter().map(area).sum::<f64>() * self.share;
        self.cover = if mean > 0.0 { one / mean } else { 1.0 };
        self.schedule = keys.to_vec();
        self.pressure = PressureKey::at(keys, 0.0);
    }

    /// Keeps for a snapshot what can be set.
    pub fn keep_settings(&self, to: &mut Keeper) {
        to.numbers(&[self.coefficients.0, self.coefficients.1]);
        // One that follows a schedule is not set.
        to.optional(Some(self.pressure).filter(|_| self.schedule.is_empty()));
        to.count(self.schedule.len() as u64);
        self.schedule.iter().for_each(|key| to.numbers(&[key.time, key.pressure]));
    }

    /// Takes it back.
    pub fn take_settings(&mut self, from: &mut Taker) -> Taken {
        self.coefficients = (from.number()?, from.number()?);
        if let Some(pressure) = from.optional()? {
            self.pressure = pressure;
        }
        self.schedule.clear();
        for _ in 0..from.length(16)? {
            self.schedule.push(PressureKey { time: from.number()?, pressure: from.number()? });
        }
        Ok(())
    }

    /// Takes up what has been set of `other`.
    pub fn take_setting_of(&mut self, other: &Self) {
        (self.coefficients, self.pressure) = (other.coefficients, other.pressure);
        self.schedule.clone_from(&other.schedule);
    }

    /// Leaves pressure at what it is set to.
    pub fn hold(&mut self, pressure: f64) {
        self.schedule.clear();
        self.pressure = pressure;
    }

    /// Takes up the pressure of `time` (s); whether that is another than before.
    pub fn pass(&mut self, time: f64) -> bool {
        let before = self.pressure;
        if !self.schedule.is_empty() {
            self.pressure = PressureKey::at(&self.schedule, time);
        }
        self.pressure != before
    }

    /// Whether it does anything in such air.
    pub fn acts(&self, field: &Field) -> bool {
        field.air_density > 0.0 || self.pressure != 0.0
    }

    /// Takes K and the push from positions `x` (m) and velocities `v` (m/s).
    pub fn begin(&mut self, field: &Field, x: &Vectors, v: &Vectors) {
        self.pushes.clear();
        if field.air_density == 0.0 {
            self.tensors.clear();
        }
        if !self.acts(field) {
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
        if self.pressure != 0.0 {
            self.pushes.extend(self.areas.iter().map(|area| *area * (-self.pressure * self.cover)));
        }
        if field.air_density == 0.0 {
            return;
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
        for (i, push) in self.pushes.iter().enumerate() {
            force.set(i, force.get(i) + *push);
        }
    }

    /// u of mass `i` in a stage.
    fn relative(&self, stage: &Stage, x: &Vectors, i: usize) -> DVec3 {
        (x.get(i) - stage.w.get(i)) * stage.per_time - self.wind
    }

    /// The part of Φ whose gradient is minus the drag and the push, J.
    pub fn potential(&self, stage: &Stage, x: &Vectors) -> f64 {
        let each = self.tensors.iter().enumerate().map(|(i, k)| {
            if stage.per_time > 0.0 {
                let u = self.relative(stage, x, i);
                0.5 * u.dot(*k * u) / stage.per_time
            } else {
                -x.get(i).dot(*k * self.wind)
            }
        });
        let pushed = self.pushes.iter().enumerate().map(|(i, push)| push.dot(x.get(i)));
        each.sum::<f64>() - pushed.sum::<f64>()
    }

    /// What the push does in moving masses from `from` to `to`, J.
    pub fn pushed(&self, from: &Vectors, to: &Vectors) -> f64 {
        self.pushes.iter().enumerate().map(|(i, push)| push.dot(to.get(i) - from.get(i))).sum()
    }

    /// Adds the gradient of that, N.
    pub fn add_gradient(&self, stage: &Stage, x: &Vectors, gradient: &mut Vectors) {
        for (i, k) in self.tensors.iter().enumerate() {
            gradient.set(i, gradient.get(i) + *k * self.relative(stage, x, i));
        }
        for (i, push) in self.pushes.iter().enumerate() {
            gradient.set(i, gradient.get(i) - *push);
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
