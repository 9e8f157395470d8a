//! Finite elements of a sheet: springs, membrane and bending, and the limits on angle, strain and
//! thickness.
//!
//! An [`Element`] holds all elements of one kind in a sheet. It stores an energy E(x) of the
//! positions and, with a retardation time τ (s), Kelvin-Voigt damping: σ = C (ε + τ ε̇). A
//! flat loss factor adds Maxwell arms to implicit integrators: see [`loss_factor`].
//!
//! Explicit integrators need forces. Implicit integrators solve stages: within a stage the velocity
//! is v = (x - w)/h, where the integrator gives w, and the strain rate is taken in the same way,
//! ε̇ = (ε(x) - ε_w)/h. A rigid rotation then has no strain rate, and the viscous part has the
//! potential ½ (τ/h) (ε - ε_w)ᵀ C (ε - ε_w). Tangents are of the mixed-stress Newton
//! method: the stress σ* in the geometric stiffness is an unknown that [`Element::predict_stress`]
//! takes from the last linear solution.
//!
//! Source: Magisano, Leonetti, Garcea, "How to improve efficiency and robustness of the Newton
//! method in geometrically non-linear structural problem discretized via displacement-based finite
//! elements", CMAME 313, 2017.

pub(crate) mod axial;
pub mod bending;
pub mod creep;
pub mod curvature;
#[cfg(test)]
mod derivative_check;
pub mod flexion_limit;
pub mod fracture;
pub mod grab_spring;
pub mod grid_membrane;
pub mod loss_factor;
pub mod mixed_spring;
pub mod remap;
pub mod spring;
pub mod staggered;
pub mod strain_limit;
pub mod thickness_limit;
pub mod triangle_bending;
pub mod triangle_cells;
pub mod triangle_membrane;
pub mod wall_spring;

use crate::material::law::ElementLaw;
use crate::math::Vectors;
use crate::serialize::{ReadResult, StateReader, StateWriter};

pub(crate) use crate::math::lanes::NO_BLOCK;

/// Term `weight` ε(x) of the reference strain ε_w of a stage.
pub struct Anchor<'a> {
    /// Weight of the strain.
    pub weight: f64,
    /// Positions, m.
    pub x: &'a Vectors,
}

/// Effects of temperature on a sheet's material, one value per node: see [`crate::thermal`].
#[derive(Clone, Copy, Debug)]
pub struct ThermalFields<'a> {
    /// E of the law over E at the node's temperature: above 1 where the sheet is softened.
    pub compliance: &'a [f64],
    /// Strain of free thermal expansion, α (T - 20 °C).
    pub expansion: &'a [f64],
    /// Curvature of free thermal bending towards the upper side, 1/m; empty without a temperature
    /// gradient.
    pub curl: &'a [f64],
}

impl ThermalFields<'_> {
    /// Remaining stiffness of an element between `masses`, as a fraction of the law's: the inverse
    /// of the mean compliance (springs in series).
    #[inline]
    pub fn stiffness(&self, masses: &[u32]) -> f64 {
        let sum: f64 = masses.iter().map(|m| self.compliance[*m as usize]).sum();
        masses.len() as f64 / sum
    }

    /// Mean expansion of `masses`.
    #[inline]
    pub fn mean_expansion(&self, masses: &[u32]) -> f64 {
        let sum: f64 = masses.iter().map(|m| self.expansion[*m as usize]).sum();
        sum / masses.len() as f64
    }
}

/// Rest strain of an element at strain `strain` whose stiffness changes from `before` to `after`
/// (fractions of the law's), where `rest` is the rest strain before. Softening keeps the rest
/// strain and relaxes stress; stiffening keeps the stress and moves the rest strain. Neither raises
/// the energy.
#[inline(always)]
pub(crate) fn rest_strain_after_softening(strain: f64, rest: f64, before: f64, after: f64) -> f64 {
    if after > before { strain - (before / after) * (strain - rest) } else { rest }
}

/// Choice of the stress in the geometric part of a tangent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometric {
    /// σ* as predicted by the last linear solution.
    Mixed,
    /// Tensile part of σ*, without compression: the tangent is positive semi-definite.
    Clipped,
}

/// All elements of one kind in a sheet. The defaults are those of an element without law, history
/// and stress, whose tangent is constant.
pub trait Element: std::any::Any + Send + Sync {
    /// Calls `visit(a, b)` for each pair of nodes, a > b, whose positions enter a common energy
    /// term; pairs may repeat.
    fn visit_coupled_nodes(&self, visit: &mut dyn FnMut(u32, u32));

    /// Stores the indices of its matrix blocks: `block(a, b)` with a ≥ b is the index of
    /// ∂²E/∂x_a∂x_b, or [`NO_BLOCK`].
    fn bind_blocks(&mut self, block: &dyn Fn(u32, u32) -> u32);

    /// Sets the stiffness.
    fn set_law(&mut self, _law: &ElementLaw) {}

    /// Applies the effects of temperature at positions `_x` (m). The law stays that of the cold
    /// sheet. A change of stiffness alone never raises the energy.
    fn apply_temperature(&mut self, _x: &Vectors, _warmth: &ThermalFields) {}

    /// Energy stored at positions `x` (m), J.
    fn energy(&self, x: &Vectors) -> f64;

    /// Adds the forces (N) at positions `x` (m) and velocities `v` (m/s), viscous forces included.
    fn add_forces(&self, x: &Vectors, v: &Vectors, force: &mut Vectors);

    /// Begins a stage. `_per_time` is 1/h (1/s), 0 for equilibrium. The reference strain ε_w is
    /// the sum of the anchors plus `_follow` (s) times the strain rate at the end of the last
    /// stage. This rate belongs to the integrator, as its accelerations do: a rate computed from
    /// velocities would disagree with them after an impact, and a stiff damper would then add
    /// energy.
    fn begin_stage(&mut self, _per_time: f64, _anchors: &[Anchor], _follow: f64) {}

    /// Ends a stage at `_x` (m) and stores the strain rate (ε(x) - ε_w)/h.
    fn finish_stage(&mut self, _x: &Vectors) {}

    /// Sets the stored strain rates to zero.
    fn reset_rates(&mut self) {}

    /// Visits the values that persist from stage to stage (strain rates, the stress σ*), always in
    /// one order, for storing and restoring.
    fn visit_history(&mut self, _visit: &mut dyn FnMut(&mut [f64])) {}

    /// Serialises the values that [`Element::visit_history`] visits.
    fn serialise_history(&self, _to: &mut StateWriter) {}

    /// Deserialises the values that [`Element::serialise_history`] writes.
    fn deserialise_history(&mut self, _from: &mut StateReader) -> ReadResult {
        Ok(())
    }

    /// Serialises the parts of law and rest state that change with time: temperature, creep,
    /// fracture.
    fn serialise_changes(&self, _to: &mut StateWriter) {}

    /// Deserialises the values that [`Element::serialise_changes`] writes. The open cells must be
    /// set before.
    fn deserialise_changes(&mut self, _from: &mut StateReader) -> ReadResult {
        Ok(())
    }

    /// Stored energy and viscous potential of the stage at `x` (m), J.
    fn potential(&self, x: &Vectors) -> f64;

    /// Adds the gradient of [`Element::potential`], N.
    fn add_gradient(&mut self, x: &Vectors, gradient: &mut Vectors);

    /// Adds the part of the tangent that does not depend on positions to `values`: nine numbers per
    /// block, row by row, N/m.
    fn add_constant_tangent(&self, _per_time: f64, _values: &mut [f64]) {}

    /// Adds the position-dependent part of the tangent at `_x` (m), N/m.
    fn add_tangent(&mut self, _x: &Vectors, _geometric: Geometric, _values: &mut [f64]) {}

    /// Sets σ* to the stress that a displacement `_d` (m) from `_x` (m) predicts to first order.
    /// Returns the energy ½ Δεᵀ C Δε (J) of the second-order strain Δε.
    fn predict_stress(&mut self, _x: &Vectors, _d: &Vectors) -> f64 {
        0.0
    }

    /// Sets σ* to the stress at `_x` (m).
    fn update_stress(&mut self, _x: &Vectors) {}

    /// Sets the open cells, and the nodes `_gone` that no closed cell touches: elements there have
    /// no stiffness. Opening cells never raises the energy at the positions `_x` (m).
    /// [`Element::set_law`] must follow.
    fn open(&mut self, _x: &Vectors, _open: &fracture::OpenCells, _gone: &[bool]) {}

    /// Rest curvatures as angles per length, 1/m; `None` for an element without rest curvature.
    fn rest_angles(&self) -> Option<Vec<[f64; 3]>> {
        None
    }

    /// Maxwell arms of a flat loss factor; `None` for an element without.
    fn arms(&self) -> Option<&loss_factor::ArmStrains> {
        None
    }

    /// As [`Element::arms`], for changes.
    fn arms_mut(&mut self) -> Option<&mut loss_factor::ArmStrains> {
        None
    }

    /// Takes the state of `old`, the element on another grid of the sheet: plastic strain, creep
    /// and thermal rest strain. Stiffness and expansion must already be those of this element's
    /// temperatures.
    fn transfer_state(&mut self, _old: &(dyn Element + 'static), _carry: &remap::Remap) {}

    /// The element as one with creep or plasticity; `None` for a purely elastic element.
    fn as_inelastic(&mut self) -> Option<&mut dyn creep::InelasticElement> {
        None
    }
}

/// Adds `block` (row by row) to block `slot` of `values`.
#[inline(always)]
pub(crate) fn add_block(values: &mut [f64], slot: u32, block: &[f64; 9]) {
    if slot == NO_BLOCK {
        return;
    }
    let at = slot as usize * 9;
    for (to, from) in values[at..at + 9].iter_mut().zip(block) {
        *to += from;
    }
}
