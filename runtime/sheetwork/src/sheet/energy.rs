//! Energies of a sheet, and its largest angular frequency.

use glam::DVec3;
use serde::Serialize;

use crate::math::Vectors;
use crate::sheet::{Sheet, fracture};

/// Energies, J. The potential energy of gravity is zero at the origin. Prescribed nodes are
/// included. A detached node has no kinetic energy and keeps the potential energy of the position
/// where it was detached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// Kinetic energy Σ ½ m v².
    pub kinetic: f64,
    /// Elastic energy: Σ ½ k (L - s)² of the springs, and that of membrane and bending of a shell.
    pub elastic: f64,
    /// Potential energy -Σ m g·x.
    pub gravity: f64,
    /// Sum of the three.
    pub total: f64,
}

impl Energy {
    /// Sum with other energies (J).
    pub(crate) fn plus(self, kinetic: f64, elastic: f64, gravity: f64) -> Self {
        Self {
            kinetic: self.kinetic + kinetic,
            elastic: self.elastic + elastic,
            gravity: self.gravity + gravity,
            total: self.total + kinetic + elastic + gravity,
        }
    }

    pub(crate) fn new(sheet: &Sheet, g: DVec3) -> Self {
        let moves = |i: usize| if sheet.is_detached(i) { 0.0 } else { sheet.model.mass[i] };
        let place = |i: usize, x: DVec3| fracture::detached_at(sheet, i).unwrap_or(x);
        let kinetic = sheet.state.v.iter().enumerate().map(|(i, v)| 0.5 * moves(i) * v.length_squared()).sum();
        let gravity = sheet.state.x.iter().enumerate().map(|(i, x)| -sheet.model.mass[i] * g.dot(place(i, x))).sum();
        let elastic = elastic(sheet);
        Self { kinetic, elastic, gravity, total: kinetic + elastic + gravity }
    }
}

/// Elastic energy of the present state, J.
pub(crate) fn elastic(sheet: &Sheet) -> f64 {
    let elements: f64 = sheet.elements.iter().map(|e| e.energy(&sheet.state.x)).sum();
    let springs = sheet.state.inelastic.as_ref().and_then(|f| f.spring_energy(&sheet.springs, &sheet.state.x));
    springs.unwrap_or_else(|| sheet.springs.energy(&sheet.state.x)) + elements
}

/// Largest angular frequency (rad/s) by power iteration on M⁻¹K, with the tangent stiffness K at
/// the present positions.
pub(crate) fn largest_frequency(sheet: &Sheet, iterations: usize) -> f64 {
    let n = sheet.node_count();
    let mut mode = Vectors::zeros(n);
    // A linear congruential sequence gives a reproducible start vector with a component in every
    // mode.
    let mut seed = 0x2545_f491_u32;
    for axis in mode.axes_mut() {
        for value in axis {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *value = f64::from(seed) / f64::from(u32::MAX) - 0.5;
        }
    }
    let mut next = Vectors::zeros(n);
    let mut eigenvalue = 0.0;
    for _ in 0..iterations {
        apply_stiffness(sheet, &mode, &mut next);
        apply_elements(sheet, &mode, &mut next);
        let norm: f64 = next.iter().map(|p| p.length_squared()).sum::<f64>().sqrt();
        let before: f64 = mode.iter().map(|p| p.length_squared()).sum::<f64>().sqrt();
        if norm <= 0.0 || before <= 0.0 {
            return 0.0;
        }
        eigenvalue = norm / before;
        mode.clear();
        mode.add_scaled(1.0 / norm, &next);
    }
    eigenvalue.sqrt()
}

/// Compute out = M⁻¹ K d of the springs; the tangent of a spring is k d̂d̂ᵀ + k (1 - s/L)(I -
/// d̂d̂ᵀ).
fn apply_stiffness(sheet: &Sheet, d: &Vectors, out: &mut Vectors) {
    out.clear();
    let springs = sheet.springs();
    for i in 0..springs.len() {
        let (a, b) = (springs.a[i] as usize, springs.b[i] as usize);
        let along = sheet.state.x.get(b) - sheet.state.x.get(a);
        let length = along.length();
        if length <= 0.0 {
            continue;
        }
        let unit = along / length;
        let difference = d.get(b) - d.get(a);
        let axial = unit * unit.dot(difference);
        let f = axial * springs.stiffness[i]
            + (difference - axial) * (springs.stiffness[i] * (1.0 - springs.rest[i] / length));
        out.set(a, out.get(a) - f * sheet.inverse_mass[a]);
        out.add(b, f * sheet.inverse_mass[b]);
    }
}

/// Add M⁻¹ K d of the elements, by central differences of their forces over a step that is small
/// against their nonlinearity.
fn apply_elements(sheet: &Sheet, d: &Vectors, out: &mut Vectors) {
    let largest = d.max_squared().sqrt();
    if sheet.elements.is_empty() || largest <= 0.0 {
        return;
    }
    let still = Vectors::zeros(d.len());
    let step = 1e-6 * sheet.model.initial_diagonal.max(1e-6) / largest;
    let (mut ahead, mut behind) = (Vectors::zeros(d.len()), Vectors::zeros(d.len()));
    for (force, sign) in [(&mut ahead, step), (&mut behind, -step)] {
        let mut x = sheet.state.x.clone();
        x.add_scaled(sign, d);
        sheet.elements.iter().for_each(|e| e.add_forces(&x, &still, force));
    }
    for i in 0..d.len() {
        out.add(i, (behind.get(i) - ahead.get(i)) * (sheet.inverse_mass[i] / (2.0 * step)));
    }
}
