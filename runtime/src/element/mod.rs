//! Elements: what pulls on masses, each alone. Springs, the shell's membrane and bending; limits on angles and thickness.
//!
//! An [`Element`] is all elements of one kind in a sheet. It stores an energy of the positions and, with a retardation time
//! τ (s), resists its own rate of strain as a Kelvin-Voigt solid does, σ = C (ε + τ ε̇).
//!
//! Explicit engines ask for forces. Implicit ones solve stages: with v = (x - w)/h in a stage (w what the scheme already
//! knows), the strain rate is taken the same way, ε̇ = (ε(x) - ε_w)/h, so that a rigid rotation has none and the viscous part
//! has a potential, ½ (τ/h) (ε - ε_w)ᵀ C (ε - ε_w). Tangents are mixed: the stress in the geometric part is an unknown of its
//! own, σ*, which [`Element::predict`] takes from the last linear solve (Magisano, Leonetti, Garcea, "How to improve
//! efficiency and robustness of the Newton method in geometrically non-linear structural problem discretized via
//! displacement-based finite elements", CMAME 313, 2017).

mod axial;
pub mod bending;
pub mod carry;
pub mod cell_membrane;
#[cfg(test)]
pub(crate) mod check;
pub mod curvature;
pub mod edge_membrane;
pub mod flexion_limit;
pub mod flow;
pub mod mixed_spring;
pub mod opening;
pub mod pack;
pub mod pull;
pub mod spring;
pub mod staggered;
pub mod strain_limit;
pub mod thickness_limit;
pub mod triangle;
pub mod wall_spring;

use crate::kept::{Keeper, Taken, Taker};
use crate::sheet::Vectors;

/// Index of a 3x3 block in the tangent's values that nothing reads: where blocks of held masses go.
pub const NO_BLOCK: u32 = u32::MAX;

/// One term of what a stage measures rates of strain from: `weight` ε(x).
pub struct Anchor<'a> {
    /// Weight of the strain.
    pub weight: f64,
    /// Positions, m.
    pub x: &'a Vectors,
}

/// Stiffness of a sheet per width, and its retardation time. Components are (uu, vv, uv) with engineering shear and twist
/// (γ = 2 ε_uv, 2 κ_uv); u is along the sheet's length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Membrane stiffness, N/m.
    pub membrane: [[f64; 3]; 3],
    /// Bending stiffness, N m.
    pub bending: [[f64; 3]; 3],
    /// Retardation time τ, s; 0 for a sheet without damping.
    pub retardation: f64,
}

/// What warming and cooling have made of a sheet's material, mass by mass: see [`crate::heat`].
#[derive(Clone, Copy, Debug)]
pub struct Warmth<'a> {
    /// E of the law over E at the mass's temperature: 1 or more where the sheet has softened.
    pub compliance: &'a [f64],
    /// Strain of a sheet free to expand, α (T - 20 °C).
    pub expansion: &'a [f64],
    /// Curvature along the upper side's normal of a sheet free to curl, 1/m; empty where the sheet is as warm on both sides.
    pub curl: &'a [f64],
}

impl Warmth<'_> {
    /// Stiffness of what lies in a row between `masses`, as a fraction of the law's: one after another they give way together.
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

/// The strain at which an element is at rest, when its stiffness goes from `before` to `after` of the law's at strain `strain`
/// and it was at rest at `rest`. What softens keeps its rest and so gives up stress; what stiffens keeps its stress and so
/// sets. Either way it stores no more energy than before.
#[inline(always)]
pub(crate) fn set_rest(strain: f64, rest: f64, before: f64, after: f64) -> f64 {
    if after > before { strain - (before / after) * (strain - rest) } else { rest }
}

/// Which stress the geometric part of a tangent takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometric {
    /// σ*, as the last solve predicted it.
    Mixed,
    /// σ* where it is tension, nothing where it is compression: positive semi-definite.
    Clipped,
}

/// All elements of one kind in a sheet.
pub trait Element: std::any::Any + Send + Sync {
    /// A copy of it, with all that it holds.
    fn boxed(&self) -> Box<dyn Element>;

    /// Calls `visit(a, b)` for the masses whose forces depend on each other's place, a > b; repeats are allowed.
    fn couples(&self, visit: &mut dyn FnMut(u32, u32));

    /// Learns where its blocks are: `block(a, b)` with a ≥ b is the index of the block ∂²E/∂x_a∂x_b, or [`NO_BLOCK`].
    fn bind(&mut self, block: &dyn Fn(u32, u32) -> u32);

    /// Takes up a stiffness.
    fn set_law(&mut self, law: &Law);

    /// Takes up what warming and cooling have made of the material, at positions `x`. The law stays that of the cold sheet, and
    /// what a change of stiffness alone does never adds energy.
    fn warm(&mut self, x: &Vectors, warmth: &Warmth);

    /// Energy stored at positions `x`, J.
    fn energy(&self, x: &Vectors) -> f64;

    /// Adds the forces (N) at positions `x` (m) and velocities `v` (m/s), viscous ones included.
    fn add_forces(&self, x: &Vectors, v: &Vectors, force: &mut Vectors);

    /// Begins a stage: `per_time` is 1/h (1/s), 0 for equilibrium; ε_w is the anchors' sum, and `follow` (s) times the rate of
    /// strain that the last stage ended with. That rate is the scheme's own, like its accelerations: one computed from
    /// velocities would disagree with them after a kick, and a stiff dashpot would then put energy in.
    fn begin(&mut self, per_time: f64, anchors: &[Anchor], follow: f64);

    /// Ends a stage at `x`: keeps its rate of strain, (ε(x) - ε_w)/h.
    fn finish(&mut self, x: &Vectors);

    /// Forgets the rate of strain: there is none.
    fn forget(&mut self);

    /// Visits what is carried from stage to stage (rates of strain, the stress σ*), always the same numbers in the same order:
    /// to be kept, and to be put back.
    fn history(&mut self, visit: &mut dyn FnMut(&mut [f64]));

    /// Keeps the same, for a snapshot.
    fn keep_history(&self, to: &mut Keeper);

    /// Takes back what [`Element::keep_history`] has kept.
    fn take_history(&mut self, from: &mut Taker) -> Taken;

    /// Keeps what steps have made of its law and its rest: by warmth, flow and opening.
    fn keep_changes(&self, _to: &mut Keeper) {}

    /// Takes that back, of an element of which the same cells are open.
    fn take_changes(&mut self, _from: &mut Taker) -> Taken {
        Ok(())
    }

    /// Stored energy and viscous potential of the stage at `x`, J.
    fn potential(&self, x: &Vectors) -> f64;

    /// Adds the gradient of [`Element::potential`], N.
    fn add_gradient(&mut self, x: &Vectors, gradient: &mut Vectors);

    /// Adds the part of the tangent that does not depend on positions to `values`, nine numbers a block by rows, N/m.
    fn add_constant_tangent(&self, _per_time: f64, _values: &mut [f64]) {}

    /// Adds the rest of the tangent at `x`.
    fn add_tangent(&mut self, x: &Vectors, geometric: Geometric, values: &mut [f64]);

    /// Takes up the stress that moving from `x` by `d` predicts to first order; returns the energy ½ Δεᵀ C Δε (J) of the
    /// strain that first order misses.
    fn predict(&mut self, x: &Vectors, d: &Vectors) -> f64;

    /// Takes up the stress at `x` as it is.
    fn settle(&mut self, x: &Vectors);

    /// Takes it that these cells are open, and no others, and that these masses are gone with them: there it holds nothing any more.
    /// Never adds energy where more have opened. A stiffness has to be taken up after it ([`Element::set_law`]).
    fn open(&mut self, _open: &opening::Open, _gone: &[bool]) {}

    /// Rest curvatures as angles a length, 1/m; `None` where there are none.
    fn rest_angles(&self) -> Option<Vec<[f64; 3]>> {
        None
    }

    /// Takes up what `old`, of the same sheet on another grid, has come to hold: by yield, creep and warmth. Its own stiffness and
    /// expansion are those of its temperatures already.
    fn carry(&mut self, _old: &(dyn Element + 'static), _carry: &carry::Carry) {}

    /// Itself as one that flows; `None` where it does not.
    fn flows(&mut self) -> Option<&mut dyn flow::Flows> {
        None
    }
}

/// Keeps 3x3 matrices.
pub(crate) fn keep_matrices<'a>(matrices: impl Iterator<Item = &'a [[f64; 3]; 3]>, to: &mut Keeper) {
    matrices.flatten().for_each(|row| to.numbers(row));
}

/// Takes as many back.
pub(crate) fn take_matrices<'a>(mut matrices: impl Iterator<Item = &'a mut [[f64; 3]; 3]>, from: &mut Taker) -> Taken {
    matrices.try_for_each(|m| m.iter_mut().try_for_each(|row| from.numbers(row)))
}

/// Adds `block` (by rows) times `scale` to block `slot` of `values`.
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
