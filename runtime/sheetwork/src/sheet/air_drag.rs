//! Aerodynamic force on a sheet: pressure drag across its surface, friction drag along it.
//!
//! On a node with the area A and the normal n, and the velocity u relative to the wind, the force
//! is
//!
//!   f = -½ ρ A (C_n |u·n| (u·n) n + C_t |u_t| u_t), u_t = u - (u·n) n,
//!
//! with the air density ρ (kg/m³). A flat plate across the stream has C_n of about 1.17, along it
//! C_t of about 0.02 for both sides (Hoerner, *Fluid-Dynamic Drag*, 1965). Areas and normals are
//! those of the triangles around a node. Sheets do not shelter one another, and the air does not
//! react to them. Wind zones give velocity and density of the air at each node ([`NodeAir`]), and
//! `plate_aerodynamics` another normal force.
//!
//! A pressure difference p between the two sides (vacuum below, air blown under) adds the force -p
//! A n.
//!
//! Implicit stages take f = -K u and the pressure force with K, A and n at the start of the stage.

use glam::{DMat3, DVec3};

use crate::integrators::implicit::StageProblem;
use crate::linear::Pattern;
use crate::math::Vectors;
use crate::scene::{Aerodynamics, PressureKey};
use crate::serialize::{ReadResult, State, StateReader, StateWriter, state};
use crate::sheet::Field;
use crate::sheet::plate_aerodynamics::PlateFlow;
use crate::sheet::wind::NodeAir;

/// Air drag and pressure of one sheet.
#[derive(Clone, Debug, Default)]
pub(crate) struct AirDrag {
    triangles: Vec<[u32; 3]>,
    /// Fraction of the area per layer.
    share: f64,
    /// C_n and C_t.
    pub coefficients: (f64, f64),
    /// Pressure on the upper side above that on the lower, Pa.
    pub pressure: f64,
    /// Area of the lowest layer over the mean area of all layers. The upper layers of some lattices
    /// are smaller, and pressure acts on the whole sheet.
    area_ratio: f64,
    /// Pressure over time; empty for a constant pressure.
    schedule: Vec<PressureKey>,
    /// Area vector n A of each node, m².
    areas: Vec<DVec3>,
    /// K of each node, N s/m; empty without air.
    tensors: Vec<DMat3>,
    /// Pressure force on each node, N; empty without pressure.
    pressure_forces: Vec<DVec3>,
    wind: DVec3,
    law: Aerodynamics,
    /// Air at each node in wind zones; `None` without zones.
    nodes: Option<Box<NodeAir>>,
}

state!(PressureKey { time, pressure });

impl AirDrag {
    /// Drag on the triangles of all layers of a sheet.
    pub fn new(triangles: Vec<[u32; 3]>, layers: usize, coefficients: (f64, f64)) -> Self {
        Self { triangles, share: 1.0 / layers.max(1) as f64, area_ratio: 1.0, coefficients, ..Self::default() }
    }

    /// Drag with the `law` of the normal force.
    pub fn with_law(self, law: Aerodynamics) -> Self {
        Self { law, ..self }
    }

    /// Take the air at the nodes, for its next update.
    pub fn take_nodes(&mut self) -> Option<Box<NodeAir>> {
        self.nodes.take()
    }

    /// Set the air at the nodes.
    pub fn set_nodes(&mut self, air: Box<NodeAir>) {
        self.nodes = Some(air);
    }

    /// Square of the largest speed of the air, m²/s²; 0 without air.
    pub fn wind_squared(&self, field: &Field) -> f64 {
        let wind = if field.air_density > 0.0 { field.wind.length_squared() } else { 0.0 };
        self.nodes.as_ref().map_or(wind, |air| air.largest_squared)
    }

    /// Add the accelerations by buoyancy, m/s², with the inverse masses (1/kg) of the nodes.
    pub fn add_buoyancy(&self, inverse_mass: &[f64], a: &mut Vectors) {
        let buoyancy = self.nodes.as_ref().map_or(&[][..], |air| &air.buoyancy);
        for (i, (force, w)) in buoyancy.iter().zip(inverse_mass).enumerate() {
            a.add(i, *force * *w);
        }
    }

    /// Whether wind zones act on it.
    pub fn is_in_zones(&self) -> bool {
        self.nodes.is_some()
    }

    /// Replace the triangles.
    pub fn set_triangles(&mut self, triangles: Vec<[u32; 3]>) {
        self.triangles = triangles;
    }

    /// Set the pressure schedule `keys`, from time 0. `x` are the positions (m), and `lowest` is
    /// the number of triangles of the lowest layer.
    pub fn set_schedule(&mut self, keys: &[PressureKey], x: &Vectors, lowest: usize) {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|m| x.get(m as usize));
            (b - a).cross(c - a).length()
        };
        let one: f64 = self.triangles.iter().take(lowest).map(area).sum();
        let mean = self.triangles.iter().map(area).sum::<f64>() * self.share;
        self.area_ratio = if mean > 0.0 { one / mean } else { 1.0 };
        self.schedule = keys.to_vec();
        self.pressure = PressureKey::at(keys, 0.0);
    }

    /// Serialise the settings.
    pub fn serialise_settings(&self, to: &mut StateWriter) {
        self.coefficients.serialise(to);
        // A pressure schedule determines the pressure.
        Some(self.pressure).filter(|_| self.schedule.is_empty()).serialise(to);
        to.states(&self.schedule);
    }

    /// Deserialise the settings.
    pub fn deserialise_settings(&mut self, from: &mut StateReader) -> ReadResult {
        self.coefficients.deserialise(from)?;
        if let Some(pressure) = from.read()? {
            self.pressure = pressure;
        }
        self.schedule = from.states(16)?;
        Ok(())
    }

    /// Copy the settings of `other`.
    pub fn copy_settings(&mut self, other: &Self) {
        (self.coefficients, self.pressure) = (other.coefficients, other.pressure);
        self.schedule.clone_from(&other.schedule);
    }

    /// Set a constant pressure, Pa.
    pub fn set_pressure(&mut self, pressure: f64) {
        self.schedule.clear();
        self.pressure = pressure;
    }

    /// Update the pressure to `time` (s); return whether it has changed.
    pub fn follow_schedule(&mut self, time: f64) -> bool {
        let before = self.pressure;
        if !self.schedule.is_empty() {
            self.pressure = PressureKey::at(&self.schedule, time);
        }
        self.pressure != before
    }

    /// Whether air or pressure exerts a force under `field`.
    pub fn is_active(&self, field: &Field) -> bool {
        field.air_density > 0.0 || self.pressure != 0.0 || self.nodes.is_some()
    }

    /// Compute K and the pressure forces at the positions `x` (m) and velocities `v` (m/s).
    pub fn begin(&mut self, field: &Field, x: &Vectors, v: &Vectors) {
        self.pressure_forces.clear();
        if field.air_density == 0.0 {
            self.tensors.clear();
        }
        if !self.is_active(field) {
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
        if self.nodes.is_some() || self.law != Aerodynamics::Drag {
            return self.begin_each(field, x, v);
        }
        if self.pressure != 0.0 {
            self.pressure_forces.extend(self.areas.iter().map(|area| *area * (-self.pressure * self.area_ratio)));
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

    /// Compute K and the constant forces as [`AirDrag::begin`] does, with the air of each node or
    /// another law of the normal force.
    fn begin_each(&mut self, field: &Field, x: &Vectors, v: &Vectors) {
        let mut nodes = self.nodes.take();
        if let Some(air) = nodes.as_mut().filter(|air| air.wind.len() != x.len()) {
            // It was asleep at the start of the step.
            air.set_uniform(field, x.len());
        }
        let pressure = self.pressure * self.area_ratio;
        let buoyancy = nodes.as_ref().map_or(&[][..], |air| &air.buoyancy);
        if pressure != 0.0 || !buoyancy.is_empty() {
            let lift = |i: usize| buoyancy.get(i).copied().unwrap_or_default();
            let each = self.areas.iter().enumerate().map(|(i, area)| lift(i) - *area * pressure);
            self.pressure_forces.extend(each);
        }
        self.tensors.resize(x.len(), DMat3::ZERO);
        let relative = |i: usize| v.get(i) - nodes.as_ref().map_or(field.wind, |air| air.wind[i]);
        let density = |i: usize| nodes.as_ref().map_or(field.air_density, |air| air.density[i]);
        let (c_n, c_t) = self.coefficients;
        let flow = match self.law {
            Aerodynamics::Drag => None,
            Aerodynamics::Plate => Some(PlateFlow::new(&self.areas, x, relative, c_n)),
        };
        for (i, (tensor, area)) in self.tensors.iter_mut().zip(&self.areas).enumerate() {
            let (size, n, u) = (area.length(), area.normalize_or_zero(), relative(i));
            let normal = u.dot(n);
            let along = c_t * (u - n * normal).length();
            let across = match &flow {
                None => c_n * normal.abs(),
                Some(flow) => flow.factor(x.get(i), u.length(), normal),
            };
            let outer = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
            *tensor =
                (outer * (across - along) + DMat3::from_diagonal(DVec3::splat(along))) * (0.5 * density(i) * size);
        }
        self.nodes = nodes;
    }

    /// Add the force on each node (N) at `x` and `v`, for explicit integrators.
    pub fn add_forces(&mut self, field: &Field, x: &Vectors, v: &Vectors, force: &mut Vectors) {
        self.begin(field, x, v);
        match &self.nodes {
            None => self.add_drag(v, |_| self.wind, force),
            Some(air) => self.add_drag(v, |i| air.wind[i], force),
        }
        for (i, push) in self.pressure_forces.iter().enumerate() {
            force.add(i, *push);
        }
    }

    /// Add the drag at the velocities `v` (m/s) in the `wind` (m/s) of each node.
    fn add_drag(&self, v: &Vectors, wind: impl Fn(usize) -> DVec3, force: &mut Vectors) {
        for (i, k) in self.tensors.iter().enumerate() {
            force.set(i, force.get(i) - *k * (v.get(i) - wind(i)));
        }
    }

    /// Part of Φ whose gradient is minus the drag and the pressure force, J.
    pub fn potential(&self, stage: &StageProblem, x: &Vectors) -> f64 {
        let drag = match &self.nodes {
            None => self.drag_potential(stage, x, |_| self.wind),
            Some(air) => self.drag_potential(stage, x, |i| air.wind[i]),
        };
        let pushed = self.pressure_forces.iter().enumerate().map(|(i, push)| push.dot(x.get(i)));
        drag - pushed.sum::<f64>()
    }

    /// Part of Φ whose gradient is minus the drag in the `wind` (m/s) of each node, J.
    fn drag_potential(&self, stage: &StageProblem, x: &Vectors, wind: impl Fn(usize) -> DVec3) -> f64 {
        let each = self.tensors.iter().enumerate().map(|(i, k)| {
            if stage.per_time > 0.0 {
                let u = (x.get(i) - stage.w.get(i)) * stage.per_time - wind(i);
                0.5 * u.dot(*k * u) / stage.per_time
            } else {
                -x.get(i).dot(*k * wind(i))
            }
        });
        each.sum()
    }

    /// Work of the pressure force between the positions `from` and `to`, J.
    pub fn pushed(&self, from: &Vectors, to: &Vectors) -> f64 {
        self.pressure_forces.iter().enumerate().map(|(i, push)| push.dot(to.get(i) - from.get(i))).sum()
    }

    /// Add the gradient of [`AirDrag::potential`], N.
    pub fn add_gradient(&self, stage: &StageProblem, x: &Vectors, gradient: &mut Vectors) {
        match &self.nodes {
            None => self.add_drag_gradient(stage, x, |_| self.wind, gradient),
            Some(air) => self.add_drag_gradient(stage, x, |i| air.wind[i], gradient),
        }
        for (i, push) in self.pressure_forces.iter().enumerate() {
            gradient.set(i, gradient.get(i) - *push);
        }
    }

    /// Add the gradient of the drag in the `wind` (m/s) of each node, N.
    fn add_drag_gradient(
        &self,
        stage: &StageProblem,
        x: &Vectors,
        wind: impl Fn(usize) -> DVec3,
        gradient: &mut Vectors,
    ) {
        for (i, k) in self.tensors.iter().enumerate() {
            gradient.add(i, *k * ((x.get(i) - stage.w.get(i)) * stage.per_time - wind(i)));
        }
    }

    /// Add the tangent K/h to the diagonal blocks; `masses` are the nodes of the block rows.
    pub fn add_tangent(&self, stage: &StageProblem, masses: &[u32], pattern: &Pattern, values: &mut [f64]) {
        if self.tensors.is_empty() {
            return;
        }
        for (row, mass) in masses.iter().enumerate() {
            let at = 9 * pattern.starts[row] as usize;
            // K is symmetric, so columns equal rows.
            let k = (self.tensors[*mass as usize] * stage.per_time).to_cols_array();
            values[at..at + 9].iter_mut().zip(k).for_each(|(to, k)| *to += k);
        }
    }
}
