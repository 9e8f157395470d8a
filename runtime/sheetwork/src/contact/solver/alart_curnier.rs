//! Alart-Curnier semismooth Newton method on normal and friction forces together. It is used for
//! small problems in which the fixed-point iteration on the friction bound stagnates.
//!
//! With u = W p + b in the contact frames, a weight ρ (N/m) and [x] the positive part of x,
//! Coulomb's law is
//!
//!   p_n = [p_n - ρ u_n],  p_t = projection of p_t - ρ u_t on a disc of radius L,
//!
//! with L = μ [p_n] (Jean and Moreau) or L = μ [p_n - ρ u_n] (Alart and Curnier). Both agree at the
//! solution but not on the way there, so that one may converge where the other does not. Newton's
//! method brings the residual of these equations (divided by ρ: m) to zero. The derivative of L
//! makes the matrix unsymmetric. It is small and dense and contains the closed contacts; Gaussian
//! elimination with row pivots solves it.
//!
//! Sources: Alart and Curnier, "A mixed formulation for frictional contact problems prone to Newton
//! like solution methods", CMAME 92, 1991; Acary, Brémond, Huber, "On solving contact problems with
//! Coulomb friction", 2018.

use glam::{DMat2, DMat3, DVec2, DVec3};
use multiversion::multiversion;

use crate::contact::coulomb::ContactLaw;
use crate::contact::settings::{AlartCurnierSettings, ContactSettings};
use crate::contact::solver::augmented_lagrangian::{AugmentedLagrangianTolerances, SolverConstraint};
use crate::contact::solver::pgs::DualProblem;

const SETTINGS: AlartCurnierSettings = ContactSettings::DEFAULT.alart_curnier;

/// Variants in the order in which they are tried, chosen on 200 problems of thrown sheets and
/// folds. Full steps converge fastest, although the residual may grow on the way; shortened steps
/// are slower and may stagnate.
const NEWTON_VARIANTS: [NewtonVariant; 5] = [
    NewtonVariant { step_lengths: 1, weight: 1.0, uses_trial_force: false, starts_at_zero: false },
    NewtonVariant { step_lengths: 2, weight: 1.0, uses_trial_force: false, starts_at_zero: false },
    NewtonVariant { step_lengths: 1, weight: 1.0, uses_trial_force: true, starts_at_zero: true },
    NewtonVariant { step_lengths: 2, weight: 10.0, uses_trial_force: true, starts_at_zero: false },
    NewtonVariant { step_lengths: 6, weight: 1.0, uses_trial_force: false, starts_at_zero: true },
];

/// Variant of the method.
#[derive(Clone, Copy, Debug)]
struct NewtonVariant {
    /// Number of step lengths that are tried, each half of the previous one.
    step_lengths: u32,
    /// ρ as a multiple of the inverse of the diagonal of W.
    weight: f64,
    /// Whether L = μ [p_n - ρ u_n] instead of μ [p_n].
    uses_trial_force: bool,
    /// Whether the iteration starts at zero forces instead of the given ones.
    starts_at_zero: bool,
}

/// Branch of the friction law at the present forces.
#[derive(Clone, Copy, Debug)]
enum FrictionBranch {
    /// Open: the force is zero.
    Open,
    /// Stick: u is zero.
    Stuck,
    /// Slip: direction of friction, and derivative of the projection with respect to p_t - ρ u_t.
    Slides(DVec2, DMat2),
}

/// Alart-Curnier solver and its arrays.
#[derive(Default)]
pub(crate) struct AlartCurnierSolver {
    /// Forces (N) and u (m), of the iterate, the trial point and the best trial point.
    force: Vec<DVec3>,
    u: Vec<DVec3>,
    trial: Vec<DVec3>,
    trial_u: Vec<DVec3>,
    best: (Vec<DVec3>, Vec<DVec3>),
    /// Residual (m) and branch of each contact.
    missed: Vec<DVec3>,
    branches: Vec<FrictionBranch>,
    step: Vec<DVec3>,
    step_u: Vec<DVec3>,
    /// First unknown of each closed contact.
    place: Vec<Option<usize>>,
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// Newton iterations since the solver was created.
    pub steps: u64,
}

/// A contact problem with the variant that solves it.
struct VariantProblem<'a> {
    problem: &'a DualProblem,
    rows: &'a [SolverConstraint],
    by: NewtonVariant,
}

impl VariantProblem<'_> {
    /// 1/ρ along the normal and the tangents, m/N.
    fn own(&self, i: usize) -> (f64, f64) {
        let a = &self.problem.diagonal[i];
        (a.x_axis.x / self.by.weight, a.y_axis.y.max(a.z_axis.z) / self.by.weight)
    }

    /// Residual (m) and branch of contact `i` at force `p` and relative displacement `u`.
    fn residual(&self, i: usize, p: DVec3, u: DVec3) -> (DVec3, FrictionBranch) {
        let ((a, at), row) = (self.own(i), &self.rows[i]);
        let ContactLaw::Coulomb(friction) = row.law else { return (u, FrictionBranch::Stuck) };
        let scale = DVec3::new(a, at, at);
        if row.is_disabled || p.x * a - u.x <= 0.0 {
            return (p * scale, FrictionBranch::Open);
        }
        let limit = friction * if self.by.uses_trial_force { p.x - u.x / a } else { p.x.max(0.0) };
        let wanted = DVec2::new(p.y - u.y / at, p.z - u.z / at);
        let length = wanted.length();
        if length <= limit {
            return (u, FrictionBranch::Stuck);
        }
        let along = wanted / length;
        let off = (DVec2::new(p.y, p.z) - along * limit) * at;
        let across = DMat2::from_cols(along.perp() * along.perp().x, along.perp() * along.perp().y);
        (DVec3::new(u.x, off.x, off.y), FrictionBranch::Slides(along, across * (limit / length)))
    }
}

impl AlartCurnierSolver {
    /// Solve for the forces of `rows` from the initial forces in `force`; leaves forces and u of
    /// the solution. Returns false, with nothing changed, if no variant reaches the tolerances of
    /// `accuracy`.
    pub fn solve(
        &mut self,
        problem: &DualProblem,
        rows: &[SolverConstraint],
        accuracy: &AugmentedLagrangianTolerances,
        (force, u): (&mut Vec<DVec3>, &mut Vec<DVec3>),
    ) -> bool {
        if rows.len() > SETTINGS.maximum_contacts {
            return false;
        }
        for by in NEWTON_VARIANTS {
            self.force.clone_from(force);
            if by.starts_at_zero {
                self.force.fill(DVec3::ZERO);
            }
            if self.iterate(&VariantProblem { problem, rows, by }, accuracy) {
                force.clone_from(&self.force);
                u.clone_from(&self.u);
                return true;
            }
        }
        false
    }

    /// Iterate with one variant from the present forces. Returns whether it converged.
    fn iterate(&mut self, posed: &VariantProblem, accuracy: &AugmentedLagrangianTolerances) -> bool {
        let mut u = std::mem::take(&mut self.u);
        compute_u(posed, &self.force, &mut u);
        self.u = u;
        let mut sum = self.compute_residual(posed);
        for _ in 0..SETTINGS.maximum_iterations * posed.by.step_lengths.min(2) {
            if !sum.is_finite() {
                return false;
            }
            // The residual is scaled by 1/ρ.
            let gap = accuracy.gap / posed.by.weight;
            let close = |m: &DVec3| m.x.abs() <= gap && m.y.abs().max(m.z.abs()) * accuracy.slip_weight <= gap;
            if self.missed.iter().all(close) {
                return self.has_plausible_forces(posed);
            }
            self.steps += 1;
            if !self.solve_newton_step(posed) {
                return false;
            }
            sum = self.move_along_step(posed, sum);
        }
        false
    }

    /// Whether the forces are plausible for contacts that can be opened together.
    fn has_plausible_forces(&self, posed: &VariantProblem) -> bool {
        let pushes = |i: usize| posed.rows[i].law != ContactLaw::Attachment;
        let alone = |i: usize| -posed.rows[i].b.x / posed.problem.diagonal[i].x_axis.x;
        let all = || (0..self.force.len()).filter(|i| pushes(*i));
        let most = all().map(alone).fold(0.0, f64::max);
        all().all(|i| self.force[i].x <= SETTINGS.contradiction_ratio * most)
    }

    /// Compute the residual. Returns the sum of its squares, m².
    fn compute_residual(&mut self, posed: &VariantProblem) -> f64 {
        self.missed.clear();
        self.branches.clear();
        for (i, (p, u)) in self.force.iter().zip(&self.u).enumerate() {
            let (missed, says) = posed.residual(i, *p, *u);
            self.missed.push(missed);
            self.branches.push(says);
        }
        self.missed.iter().map(|m| m.length_squared()).sum()
    }

    /// Move along the step, or along the fraction of it with the smallest residual. Returns the
    /// squared residual there.
    fn move_along_step(&mut self, posed: &VariantProblem, before: f64) -> f64 {
        let mut step_u = std::mem::take(&mut self.step_u);
        step_u.clear();
        step_u.resize(self.step.len(), DVec3::ZERO);
        posed.problem.apply_delassus(&self.step, &mut step_u);
        self.step_u = step_u;
        let (mut part, mut least) = (1.0, f64::INFINITY);
        for _ in 0..posed.by.step_lengths {
            let along = |from: &[DVec3], by: &[DVec3], to: &mut Vec<DVec3>| {
                to.clear();
                to.extend(from.iter().zip(by).map(|(x, d)| *x + *d * part));
            };
            along(&self.force, &self.step, &mut self.trial);
            along(&self.u, &self.step_u, &mut self.trial_u);
            let pairs = self.trial.iter().zip(&self.trial_u).enumerate();
            let sum: f64 = pairs.map(|(i, (p, u))| posed.residual(i, *p, *u).0.length_squared()).sum();
            if sum < least {
                least = sum;
                std::mem::swap(&mut self.best.0, &mut self.trial);
                std::mem::swap(&mut self.best.1, &mut self.trial_u);
            }
            if sum <= (1.0 - SETTINGS.required_decrease * part) * before {
                break;
            }
            part *= 0.5;
        }
        if least == f64::INFINITY {
            return f64::NAN;
        }
        std::mem::swap(&mut self.force, &mut self.best.0);
        std::mem::swap(&mut self.u, &mut self.best.1);
        self.compute_residual(posed)
    }

    /// Solve for the Newton step. Returns false if the matrix is singular.
    fn solve_newton_step(&mut self, posed: &VariantProblem) -> bool {
        let Self { branches: says, force, missed, place, matrix, right, step, .. } = self;
        let mut size = 0;
        place.clear();
        place.extend(says.iter().map(|s| {
            let pushes = !matches!(s, FrictionBranch::Open);
            size += if pushes { 3 } else { 0 };
            pushes.then(|| size - 3)
        }));
        matrix.clear();
        matrix.resize(size * size, 0.0);
        right.clear();
        right.resize(size, 0.0);
        // A contact that opens loses its force, which changes u of the others.
        step.clear();
        step.extend(force.iter().zip(place.iter()).map(|(p, place)| if place.is_some() { DVec3::ZERO } else { -*p }));
        let mut felt = std::mem::take(&mut self.trial_u);
        felt.clear();
        felt.resize(step.len(), DVec3::ZERO);
        posed.problem.apply_delassus(step, &mut felt);
        for (i, row) in place.iter().enumerate().filter_map(|(i, place)| place.map(|row| (i, row))) {
            let (_, at) = posed.own(i);
            // Derivatives of the residual with respect to u and p.
            let (by_u, by_p) = derivatives(&says[i], posed, i, at);
            let left = -missed[i] - by_u * felt[i];
            right[row..row + 3].copy_from_slice(&left.to_array());
            let diagonal = posed.problem.diagonal[i];
            let slight = DVec3::new(diagonal.x_axis.x, diagonal.y_axis.y, diagonal.z_axis.z) * SETTINGS.diagonal_shift;
            write_block(matrix, size, (row, row), &(by_u * (diagonal + DMat3::from_diagonal(slight)) + by_p));
            for (j, block) in &posed.problem.columns[i] {
                if let Some(column) = place[*j as usize] {
                    // The list holds ∂u_j/∂p_i, the transpose of the block that belongs here.
                    write_block(matrix, size, (row, column), &(by_u * block.transpose()));
                }
            }
        }
        self.trial_u = felt;
        if !eliminate(matrix, right) {
            return false;
        }
        for (i, row) in place.iter().enumerate().filter_map(|(i, place)| place.map(|row| (i, row))) {
            step[i] = DVec3::from_slice(&right[row..]);
        }
        true
    }
}

/// Derivatives of the residual of contact `i` with respect to u and to p; `at` is 1/ρ of the
/// tangents.
fn derivatives(says: &FrictionBranch, posed: &VariantProblem, i: usize, at: f64) -> (DMat3, DMat3) {
    let FrictionBranch::Slides(along, across) = says else { return (DMat3::IDENTITY, DMat3::ZERO) };
    let ContactLaw::Coulomb(friction) = posed.rows[i].law else { return (DMat3::IDENTITY, DMat3::ZERO) };
    let (a, _) = posed.own(i);
    let held = (DMat2::IDENTITY - *across) * at;
    let pushed = *along * (-friction * at);
    let tangents = |m: DMat2, first: DVec3| {
        DMat3::from_cols(first, DVec3::new(0.0, m.x_axis.x, m.x_axis.y), DVec3::new(0.0, m.y_axis.x, m.y_axis.y))
    };
    let ahead = if posed.by.uses_trial_force { pushed / -a } else { DVec2::ZERO };
    let by_u = tangents(*across, DVec3::new(1.0, ahead.x, ahead.y));
    (by_u, tangents(held, DVec3::new(0.0, pushed.x, pushed.y)))
}

/// Compute u = W p + b.
fn compute_u(posed: &VariantProblem, p: &[DVec3], u: &mut Vec<DVec3>) {
    u.clear();
    u.resize(p.len(), DVec3::ZERO);
    posed.problem.apply_delassus(p, u);
    u.iter_mut().zip(posed.rows).for_each(|(u, row)| *u += row.b);
}

/// Write a block into a row-major matrix of `size` columns.
fn write_block(matrix: &mut [f64], size: usize, (row, column): (usize, usize), block: &DMat3) {
    for r in 0..3 {
        let at = (row + r) * size + column;
        matrix[at..at + 3].copy_from_slice(&block.row(r).to_array());
    }
}

/// Solve the dense system in place by Gaussian elimination with row pivots. Returns false if it is
/// singular.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn eliminate(matrix: &mut [f64], right: &mut [f64]) -> bool {
    let size = right.len();
    let largest = matrix.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for k in 0..size {
        let pivot = (k..size)
            .fold(k, |best, r| if matrix[r * size + k].abs() > matrix[best * size + k].abs() { r } else { best });
        // The comparison is false for NaN.
        let is_sound = matrix[pivot * size + k].abs() > SETTINGS.minimum_pivot * largest;
        if !is_sound {
            return false;
        }
        if pivot != k {
            (0..size).for_each(|c| matrix.swap(pivot * size + c, k * size + c));
            right.swap(pivot, k);
        }
        let (above, below) = matrix.split_at_mut((k + 1) * size);
        let upper = &above[k * size + k..];
        for (r, row) in below.chunks_exact_mut(size).enumerate() {
            let factor = row[k] / upper[0];
            if factor != 0.0 {
                row[k..].iter_mut().zip(upper).for_each(|(x, u)| *x -= factor * u);
                right[k + 1 + r] -= factor * right[k];
            }
        }
    }
    for k in (0..size).rev() {
        let row = &matrix[k * size..(k + 1) * size];
        let known: f64 = row[k + 1..].iter().zip(&right[k + 1..]).map(|(m, x)| m * x).sum();
        right[k] = (right[k] - known) / row[k];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::coulomb;

    /// Pseudorandom numbers from -1 to 1 with a fixed seed.
    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// A problem of `count` coupled contacts with W = M Mᵀ plus a small diagonal.
    fn drawn(count: usize, friction: f64, next: &mut impl FnMut() -> f64) -> (DualProblem, Vec<SolverConstraint>) {
        let m: Vec<Vec<DMat3>> = (0..count)
            .map(|_| (0..count).map(|_| DMat3::from_cols_array(&std::array::from_fn(|_| next()))).collect())
            .collect();
        let (mut problem, mut rows) = (DualProblem::default(), Vec::new());
        for i in 0..count {
            problem.push(ContactLaw::Coulomb(friction), DVec3::ZERO);
            for j in 0..=i {
                let block: DMat3 = (0..count).map(|k| m[i][k] * m[j][k].transpose()).fold(DMat3::ZERO, |a, b| a + b);
                problem.couple(i, j, if i == j { block + DMat3::IDENTITY * 0.01 } else { block });
            }
            let mut row = SolverConstraint::new(DMat3::IDENTITY, ContactLaw::Coulomb(friction));
            row.b = DVec3::new(next(), next(), next()) * 1e-3;
            rows.push(row);
        }
        (problem, rows)
    }

    #[test]
    fn single_contact_matches_the_exact_solution() {
        let mut next = numbers(1);
        for _ in 0..50 {
            let friction = 0.8 * next().abs();
            let (problem, rows) = drawn(1, friction, &mut next);
            let known = coulomb::solve(&problem.diagonal[0], rows[0].b, ContactLaw::Coulomb(friction), DVec3::ZERO);
            let (mut force, mut u) = (vec![DVec3::ZERO], Vec::new());
            assert!(AlartCurnierSolver::default().solve(
                &problem,
                &rows,
                &AugmentedLagrangianTolerances::SINGLE_SHEET.scaled(2.5e-4),
                (&mut force, &mut u)
            ));
            // The tolerance is that of the gaps.
            assert!((problem.diagonal[0] * (force[0] - known)).length() < 1e-6, "{} {known}", force[0]);
        }
    }

    #[test]
    fn converged_forces_obey_coulombs_law() {
        let mut next = numbers(2);
        let mut settled = 0;
        for _ in 0..50 {
            let (problem, rows) = drawn(6, 0.5, &mut next);
            let (mut force, mut u) = (vec![DVec3::ZERO; 6], Vec::new());
            if !AlartCurnierSolver::default().solve(
                &problem,
                &rows,
                &AugmentedLagrangianTolerances::SINGLE_SHEET.scaled(2.5e-4),
                (&mut force, &mut u),
            ) {
                continue;
            }
            settled += 1;
            for (p, u) in force.iter().zip(&u) {
                let (rub, slip) = (DVec2::new(p.y, p.z), DVec2::new(u.y, u.z));
                assert!(p.x >= -1e-6 && u.x > -1e-6 && p.x.min(u.x) < 1e-6, "{p} {u}");
                assert!(rub.length() <= 0.5 * p.x + 1e-6, "{p}");
                if slip.length() > 1e-5 && p.x > 1e-5 {
                    assert!((rub + slip.normalize() * 0.5 * p.x).length() < 1e-3 * p.x, "{p} {u}");
                }
            }
        }
        assert!(settled >= 45, "{settled} of 50");
    }

    #[test]
    fn contradicting_contacts_do_not_converge() {
        // One point, pushed up and down by more than its range.
        let mut problem = DualProblem::default();
        let mut rows = Vec::new();
        for sign in [1.0, -1.0] {
            problem.push(ContactLaw::Coulomb(0.3), DVec3::ZERO);
            problem.couple(rows.len(), rows.len(), DMat3::IDENTITY);
            let mut row = SolverConstraint::new(DMat3::from_diagonal(DVec3::splat(sign)), ContactLaw::Coulomb(0.3));
            row.b = DVec3::new(-1e-3, 0.0, 0.0);
            rows.push(row);
        }
        problem.couple(1, 0, -DMat3::IDENTITY);
        let (mut force, mut u) = (vec![DVec3::ZERO; 2], Vec::new());
        assert!(!AlartCurnierSolver::default().solve(
            &problem,
            &rows,
            &AugmentedLagrangianTolerances::SINGLE_SHEET.scaled(2.5e-4),
            (&mut force, &mut u)
        ));
        assert_eq!(force, [DVec3::ZERO; 2], "nothing is changed");
    }
}
