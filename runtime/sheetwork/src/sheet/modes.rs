//! Lowest vibration modes of a sheet about its present state: K φ = ω² M φ with the tangent
//! stiffness K.
//!
//! Subspace iteration on (K + σM)⁻¹ M with a small shift σ, which makes the matrix of a free sheet
//! positive definite (Bathe, *Finite Element Procedures*, 2014, chapter 11).

use nalgebra::{DMatrix, DVector};

use crate::elements::Geometric;
use crate::integrators::implicit::StageProblem;
use crate::linear::dense::symmetric_eigen;
use crate::math::Vectors;
use crate::sheet::implicit_system::{self, ImplicitSystem};
use crate::sheet::{Field, Sheet, creep};

/// Vibration mode.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// Angular frequency, rad/s; 0 for a rigid or an unstable mode.
    pub omega: f64,
    /// Square of the angular frequency, rad²/s²; negative for an unstable mode.
    pub squared: f64,
    /// Displacement of every node, with φᵀ M φ = 1 kg m².
    pub shape: Vectors,
}

/// Iterated vectors beyond the requested modes.
const EXTRA_VECTORS: usize = 8;
const MAX_ITERATIONS: usize = 300;

impl Sheet {
    /// Lowest `count` modes about the present state, lowest first; fewer for a sheet with fewer
    /// unknowns, none if the tangent is far from positive definite.
    pub fn modes(&mut self, count: usize) -> Vec<Mode> {
        creep::use_instantaneous_law(self);
        let mut system = self.system.take().unwrap_or_else(|| Box::new(ImplicitSystem::new(self)));
        let law = self.law();
        // The shift is a tenth of the lowest cantilever frequency: far below the requested modes,
        // far above rounding.
        let stiffness = law.bending[0][0].max(law.bending[1][1]);
        let area: f64 = self.model.length * self.model.length;
        let slowest = 3.516 * (stiffness * area / self.total_mass().max(f64::MIN_POSITIVE)).sqrt() / area;
        let mut shift = 0.1 * slowest.max(1e-3);
        // An unstable state needs a shift above its largest growth rate.
        let mut found = factorises(self, &mut system, shift);
        for _ in 1..20 {
            if !found {
                shift *= 2.0;
                found = factorises(self, &mut system, shift);
            }
        }
        let modes = if found { iterate(self, &mut system, count, shift) } else { Vec::new() };
        system.forget_constant();
        self.system = Some(system);
        modes
    }

    /// Whether the present state is stable: the tangent stiffness with the present stress is
    /// positive definite.
    pub fn is_stable(&mut self) -> bool {
        creep::use_instantaneous_law(self);
        let mut system = self.system.take().unwrap_or_else(|| Box::new(ImplicitSystem::new(self)));
        let stands = factorises(self, &mut system, 0.0);
        system.forget_constant();
        self.system = Some(system);
        stands
    }
}

/// Whether K + σM at the present state, with σ = `shift`² and K of the present stress, has a
/// Cholesky factor, which then is that of `system`.
fn factorises(sheet: &mut Sheet, system: &mut ImplicitSystem, shift: f64) -> bool {
    system.forget_constant();
    let x = sheet.state.x.clone();
    implicit_system::with_implicit_sheet(sheet, Field::default(), system, |problem| {
        problem.start(&x, &Vectors::zeros(x.len()));
        let stage = StageProblem { per_time: shift, y: &x, w: &x };
        problem.factorize(&stage, &x, Geometric::Mixed).is_ok()
    })
}

/// Subspace iteration with the present factor, that of K + σM with σ = `shift`².
fn iterate(sheet: &Sheet, system: &mut ImplicitSystem, count: usize, shift: f64) -> Vec<Mode> {
    let n = 3 * system.masses().len();
    let masses = system.masses().iter().flat_map(|m| [sheet.model.mass[*m as usize]; 3]);
    let weight = DVector::from_iterator(n, masses.zip(system.free_entries()).map(|(m, f)| m * f));
    let times_mass = |mut vectors: DMatrix<f64>| {
        vectors.column_iter_mut().for_each(|mut v| v.component_mul_assign(&weight));
        vectors
    };
    let mut seed = 0x9e37_79b9_u32;
    let mut draw = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed) / f64::from(u32::MAX) - 0.5
    };
    let mut basis = DMatrix::from_fn(n, (count + EXTRA_VECTORS).min(n), |_, _| draw());
    let mut values = DVector::zeros(0);
    for _ in 0..MAX_ITERATIONS {
        let loads = times_mass(basis);
        let mut moved = loads.clone();
        moved.as_mut_slice().chunks_exact_mut(n.max(1)).for_each(|v| system.solve(v));
        // Reduced problem: A = Zᵀ (K + σM) Z = Zᵀ M V, B = Zᵀ M Z.
        let a = moved.transpose() * &loads;
        let b = moved.transpose() * times_mass(moved.clone());
        let Some((next, vectors)) = reduced(&(0.5 * (&a + a.transpose())), &b) else { return Vec::new() };
        basis = moved * vectors;
        let settled = |(next, last): (&f64, &f64)| (next - last).abs() <= 1e-10 * next.abs();
        let has_settled = next.len() == values.len() && next.iter().zip(&values).take(count).all(settled);
        values = next;
        if has_settled {
            break;
        }
    }
    let sigma = shift * shift;
    (0..count.min(values.len()))
        .map(|k| {
            let squared = values[k] - sigma;
            let mut shape = Vectors::zeros(sheet.node_count());
            for (p, mass) in basis.column(k).as_slice().chunks_exact(3).zip(system.masses()) {
                shape.set(*mass as usize, glam::DVec3::from_slice(p));
            }
            // The eigenvalue of a rigid mode is the shift plus rounding.
            let omega = if squared > 1e-3 * sigma { squared.sqrt() } else { 0.0 };
            Mode { omega, squared, shape }
        })
        .collect()
}

/// Eigenvalues, ascending, and B-normalised eigenvectors of A c = λ B c, in the span of the
/// linearly independent columns of B; `None` if an eigenvalue problem fails.
fn reduced(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    // Scaling to a unit diagonal limits the rounding errors of the factor.
    let scale = DMatrix::from_diagonal(&b.map_diagonal(|b| 1.0 / b.sqrt()));
    let (s, u) = symmetric_eigen(&scale * b * &scale)?;
    // Near-null directions of B are linearly dependent.
    let dependent = s.iter().take_while(|s| **s <= 1e-13).count();
    let mut whiten = scale * u.columns_range(dependent..);
    for (mut column, s) in whiten.column_iter_mut().zip(s.iter().skip(dependent)) {
        column /= s.sqrt();
    }
    let (values, vectors) = symmetric_eigen(whiten.transpose() * a * &whiten)?;
    Some((values, whiten * vectors))
}
