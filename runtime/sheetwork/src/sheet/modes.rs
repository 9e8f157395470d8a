//! Lowest vibration modes of a sheet about its present state: K φ = ω² M φ with the tangent
//! stiffness K.
//!
//! Subspace iteration on (K + σM)⁻¹ M with a small shift σ, which makes the matrix of a free sheet
//! positive definite (Bathe, *Finite Element Procedures*, 2014, chapter 11).

use faer::{Mat, Side};

use crate::elements::Geometric;
use crate::integrators::implicit::StageProblem;
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
        system.forget_constant();
        let law = self.law();
        // The shift is a tenth of the lowest cantilever frequency: far below the requested modes,
        // far above rounding.
        let stiffness = law.bending[0][0].max(law.bending[1][1]);
        let area: f64 = self.model.length * self.model.length;
        let slowest = 3.516 * (stiffness * area / self.total_mass().max(f64::MIN_POSITIVE)).sqrt() / area;
        let mut shift = 0.1 * slowest.max(1e-3);
        let x = self.state.x.clone();
        // An unstable state needs a shift above its largest growth rate.
        let mut found = false;
        for _ in 0..20 {
            system.forget_constant();
            found = implicit_system::with_implicit_sheet(self, Field::default(), &mut system, |problem| {
                let still = Vectors::zeros(x.len());
                problem.start(&x, &still);
                let stage = StageProblem { per_time: shift, y: &x, w: &x };
                problem.factorize(&stage, &x, Geometric::Mixed).is_ok()
            });
            if found {
                break;
            }
            shift *= 2.0;
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
        system.forget_constant();
        let x = self.state.x.clone();
        let stands = implicit_system::with_implicit_sheet(self, Field::default(), &mut system, |problem| {
            let still = Vectors::zeros(x.len());
            problem.start(&x, &still);
            let stage = StageProblem { per_time: 0.0, y: &x, w: &x };
            problem.factorize(&stage, &x, Geometric::Mixed).is_ok()
        });
        system.forget_constant();
        self.system = Some(system);
        stands
    }
}

/// Subspace iteration with the present factor, that of K + σM with σ = `shift`².
fn iterate(sheet: &Sheet, system: &mut ImplicitSystem, count: usize, shift: f64) -> Vec<Mode> {
    let n = 3 * system.masses().len();
    let size = (count + EXTRA_VECTORS).min(n);
    let weight: Vec<f64> = system
        .masses()
        .iter()
        .flat_map(|m| [sheet.model.mass[*m as usize]; 3])
        .zip(system.free_entries())
        .map(|(m, f)| m * f)
        .collect();
    let mut seed = 0x9e37_79b9_u32;
    let mut draw = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed) / f64::from(u32::MAX) - 0.5
    };
    let mut basis: Vec<Vec<f64>> = (0..size).map(|_| (0..n).map(|_| draw()).collect()).collect();
    let mut before = vec![0.0; size];
    let mut values = vec![0.0; size];
    for _ in 0..MAX_ITERATIONS {
        let loads: Vec<Vec<f64>> = basis.iter().map(|v| v.iter().zip(&weight).map(|(v, m)| v * m).collect()).collect();
        let mut moved = loads.clone();
        moved.iter_mut().for_each(|b| system.solve(b));
        // Reduced problem: A = Zᵀ (K + σM) Z = Zᵀ M V, B = Zᵀ M Z.
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mass_of = |v: &[f64]| v.iter().zip(&weight).map(|(v, m)| v * m).collect::<Vec<f64>>();
        let heavy: Vec<Vec<f64>> = moved.iter().map(|v| mass_of(v)).collect();
        let a = Mat::from_fn(size, size, |i, j| 0.5 * (dot(&moved[i], &loads[j]) + dot(&moved[j], &loads[i])));
        let b = Mat::from_fn(size, size, |i, j| dot(&moved[i], &heavy[j]));
        let Some((eigenvalues, vectors)) = reduced(&a, &b) else { return Vec::new() };
        basis = (0..size)
            .map(|k| {
                let mut v = vec![0.0; n];
                for (j, z) in moved.iter().enumerate() {
                    let c = vectors[(j, k)];
                    v.iter_mut().zip(z).for_each(|(v, z)| *v += c * z);
                }
                v
            })
            .collect();
        values.copy_from_slice(&eigenvalues);
        let settled = |k: usize| (values[k] - before[k]).abs() <= 1e-10 * values[k].abs();
        if (0..count.min(size)).all(settled) {
            break;
        }
        before.copy_from_slice(&values);
    }
    let sigma = shift * shift;
    (0..count.min(size))
        .map(|k| {
            let squared = values[k] - sigma;
            let mut shape = Vectors::zeros(sheet.node_count());
            for (p, mass) in basis[k].chunks_exact(3).zip(system.masses()) {
                shape.set(*mass as usize, glam::DVec3::from_slice(p));
            }
            // The eigenvalue of a rigid mode is the shift plus rounding.
            let omega = if squared > 1e-3 * sigma { squared.sqrt() } else { 0.0 };
            Mode { omega, squared, shape }
        })
        .collect()
}

/// Eigenvalues, ascending, and B-normalised eigenvectors of A c = λ B c; `None` if the eigenvalue
/// problem of B or of the reduced matrix fails.
fn reduced(a: &Mat<f64>, b: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    let n = a.nrows();
    // Scaling to a unit diagonal limits the rounding errors of the factor.
    let scale: Vec<f64> = (0..n).map(|i| 1.0 / b[(i, i)].sqrt()).collect();
    let a = Mat::from_fn(n, n, |i, j| a[(i, j)] * scale[i] * scale[j]);
    let b = Mat::from_fn(n, n, |i, j| b[(i, j)] * scale[i] * scale[j]);
    let eigen = b.self_adjoint_eigen(Side::Lower).ok()?;
    // Near-null directions of B are linearly dependent: they get weight zero and sort to the end.
    let (u, s) = (eigen.U(), eigen.S().column_vector());
    let root = |k: usize| if s[k] > 1e-13 { 1.0 / s[k].sqrt() } else { 0.0 };
    let whiten = Mat::from_fn(n, n, |i, k| u[(i, k)] * root(k));
    let mut c = whiten.transpose() * &a * &whiten;
    for k in (0..n).filter(|k| s[*k] <= 1e-13) {
        c[(k, k)] = f64::MAX.sqrt();
    }
    let eigen = c.self_adjoint_eigen(Side::Lower).ok()?;
    let vectors = &whiten * eigen.U();
    let values = (0..n).map(|k| eigen.S().column_vector()[k]).collect();
    Some((values, Mat::from_fn(n, n, |i, k| vectors[(i, k)] * scale[i])))
}
