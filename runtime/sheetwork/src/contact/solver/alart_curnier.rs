//! Newton steps on normal forces and limits of friction at once, for the few contacts of which those limits, following the normal
//! forces (`primal`), do not settle.
//!
//! With u = W p + b in the frames of the contacts, ρ a weight (N/m) and [x] the part of x that is positive, Coulomb's law is
//!
//!   p_n = [p_n - ρ u_n],  p_t = the nearest to p_t - ρ u_t within a disc of radius L,
//!
//! L = μ [p_n] or μ [p_n - ρ u_n]: the same where the law holds, not on the way there, and where one does not come there the other may.
//! What is missed, in m, is brought to nothing by Newton's method. The derivative of L makes the matrix unsymmetric; it is
//! small and dense, of the contacts that push, and eliminated with row pivots.
//! (Alart and Curnier, "A mixed formulation for frictional contact problems prone to Newton like solution methods", CMAME 92, 1991;
//! Jean and Moreau's L against theirs: Acary, Brémond, Huber, "On solving contact problems with Coulomb friction", 2018.)

use glam::{DMat2, DMat3, DVec2, DVec3};
use multiversion::multiversion;

use crate::contact::coulomb::Law;
use crate::contact::solver::augmented_lagrangian::{Accuracy, Row};
use crate::contact::solver::pgs::Problem;

/// Contacts up to which it is tried: the cost grows with the cube.
pub(crate) const MOST: usize = 128;
/// Steps of a try, times the lengths it looks at or two.
const STEPS: u32 = 20;
/// Force on a contact over the largest that would put one apart by itself, beyond which contacts contradict one another: in folds it comes to
/// 1000, where a needle is touched from within to 10⁴ at least.
const CONTRADICTED: f64 = 2000.0;
/// What is tried in turn, found on 200 problems of thrown sheets and folds: whole steps come there soonest, though more may be missed on the way;
/// those shortened until less is are slow, and stall.
const TRIES: [Try; 5] = [
    Try { lengths: 1, weight: 1.0, ahead: false, from_rest: false },
    Try { lengths: 2, weight: 1.0, ahead: false, from_rest: false },
    Try { lengths: 1, weight: 1.0, ahead: true, from_rest: true },
    Try { lengths: 2, weight: 10.0, ahead: true, from_rest: false },
    Try { lengths: 6, weight: 1.0, ahead: false, from_rest: true },
];
/// Part of what is missed that a step must take away, times the part of it that is taken.
const GAIN: f64 = 0.1;
/// What is added to W's diagonal in the matrix, as a fraction: contacts that hold the same leave it singular.
const SLIGHT: f64 = 1e-9;
/// Pivots below this fraction of the largest entry are none.
const SINGULAR: f64 = 1e-14;

/// How it is tried.
#[derive(Clone, Copy, Debug)]
struct Try {
    /// Lengths of a step that are looked at, each half of the one before.
    lengths: u32,
    /// ρ over the inverse of W's diagonal.
    weight: f64,
    /// Whether L is μ [p_n - ρ u_n].
    ahead: bool,
    /// Whether it begins without forces, and not with those there were.
    from_rest: bool,
}

/// What the law of a contact says at the forces there are.
#[derive(Clone, Copy, Debug)]
enum Says {
    Open,
    Stuck,
    /// Friction along this direction; what of a change of p_t - ρ u_t is felt.
    Slides(DVec2, DMat2),
}

/// The solver with its arrays.
#[derive(Default)]
pub(crate) struct AtOnce {
    /// Forces, N; u, m; and both of the step that is tried.
    force: Vec<DVec3>,
    u: Vec<DVec3>,
    trial: Vec<DVec3>,
    trial_u: Vec<DVec3>,
    best: (Vec<DVec3>, Vec<DVec3>),
    /// What is missed, m, and what each contact does.
    missed: Vec<DVec3>,
    says: Vec<Says>,
    step: Vec<DVec3>,
    step_u: Vec<DVec3>,
    /// First unknown of each contact that pushes.
    place: Vec<Option<usize>>,
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// Newton steps so far.
    pub steps: u64,
}

/// A contact problem as it is put here.
struct Posed<'a> {
    problem: &'a Problem,
    rows: &'a [Row],
    by: Try,
}

impl Posed<'_> {
    /// 1/ρ: along the normal, and across it, m/N.
    fn own(&self, i: usize) -> (f64, f64) {
        let a = &self.problem.diagonal[i];
        (a.x_axis.x / self.by.weight, a.y_axis.y.max(a.z_axis.z) / self.by.weight)
    }

    /// What contact `i` misses at force `p` and `u`, m, and what its law says there.
    fn missed(&self, i: usize, p: DVec3, u: DVec3) -> (DVec3, Says) {
        let ((a, at), row) = (self.own(i), &self.rows[i]);
        let Law::Coulomb(friction) = row.law else { return (u, Says::Stuck) };
        let scale = DVec3::new(a, at, at);
        if row.idle || p.x * a - u.x <= 0.0 {
            return (p * scale, Says::Open);
        }
        let limit = friction * if self.by.ahead { p.x - u.x / a } else { p.x.max(0.0) };
        let wanted = DVec2::new(p.y - u.y / at, p.z - u.z / at);
        let length = wanted.length();
        if length <= limit {
            return (u, Says::Stuck);
        }
        let along = wanted / length;
        let off = (DVec2::new(p.y, p.z) - along * limit) * at;
        let across = DMat2::from_cols(along.perp() * along.perp().x, along.perp() * along.perp().y);
        (DVec3::new(u.x, off.x, off.y), Says::Slides(along, across * (limit / length)))
    }
}

impl AtOnce {
    /// Solves for the forces on `rows` from those in `force`, and leaves them and u there; false, with nothing changed, where it does not come
    /// to what `accuracy` asks.
    pub fn solve(
        &mut self,
        problem: &Problem,
        rows: &[Row],
        accuracy: &Accuracy,
        (force, u): (&mut Vec<DVec3>, &mut Vec<DVec3>),
    ) -> bool {
        if rows.len() > MOST {
            return false;
        }
        for by in TRIES {
            self.force.clone_from(force);
            if by.from_rest {
                self.force.fill(DVec3::ZERO);
            }
            if self.descend(&Posed { problem, rows, by }, accuracy) {
                force.clone_from(&self.force);
                u.clone_from(&self.u);
                return true;
            }
        }
        false
    }

    /// Takes steps from the forces there are; whether that ends where it should.
    fn descend(&mut self, posed: &Posed, accuracy: &Accuracy) -> bool {
        let mut u = std::mem::take(&mut self.u);
        answer(posed, &self.force, &mut u);
        self.u = u;
        let mut sum = self.look(posed);
        for _ in 0..STEPS * posed.by.lengths.min(2) {
            if !sum.is_finite() {
                return false;
            }
            // Forces are missed in m by 1/ρ.
            let gap = accuracy.gap / posed.by.weight;
            let close = |m: &DVec3| m.x.abs() <= gap && m.y.abs().max(m.z.abs()) * accuracy.slip <= gap;
            if self.missed.iter().all(close) {
                return self.is_sound(posed);
            }
            self.steps += 1;
            if !self.make_step(posed) {
                return false;
            }
            sum = self.go(posed, sum);
        }
        false
    }

    /// Whether the forces are such as contacts that can be put apart have.
    fn is_sound(&self, posed: &Posed) -> bool {
        let pushes = |i: usize| posed.rows[i].law != Law::Glue;
        let alone = |i: usize| -posed.rows[i].b.x / posed.problem.diagonal[i].x_axis.x;
        let all = || (0..self.force.len()).filter(|i| pushes(*i));
        let most = all().map(alone).fold(0.0, f64::max);
        all().all(|i| self.force[i].x <= CONTRADICTED * most)
    }

    /// Works out what is missed; returns the sum of its squares, m².
    fn look(&mut self, posed: &Posed) -> f64 {
        self.missed.clear();
        self.says.clear();
        for (i, (p, u)) in self.force.iter().zip(&self.u).enumerate() {
            let (missed, says) = posed.missed(i, *p, *u);
            self.missed.push(missed);
            self.says.push(says);
        }
        self.missed.iter().map(|m| m.length_squared()).sum()
    }

    /// Goes along the step, or the part of it that does best; returns what is then missed.
    fn go(&mut self, posed: &Posed, before: f64) -> f64 {
        let mut step_u = std::mem::take(&mut self.step_u);
        step_u.clear();
        step_u.resize(self.step.len(), DVec3::ZERO);
        posed.problem.answer(&self.step, &mut step_u);
        self.step_u = step_u;
        let (mut part, mut least) = (1.0, f64::INFINITY);
        for _ in 0..posed.by.lengths {
            let along = |from: &[DVec3], by: &[DVec3], to: &mut Vec<DVec3>| {
                to.clear();
                to.extend(from.iter().zip(by).map(|(x, d)| *x + *d * part));
            };
            along(&self.force, &self.step, &mut self.trial);
            along(&self.u, &self.step_u, &mut self.trial_u);
            let pairs = self.trial.iter().zip(&self.trial_u).enumerate();
            let sum: f64 = pairs.map(|(i, (p, u))| posed.missed(i, *p, *u).0.length_squared()).sum();
            if sum < least {
                least = sum;
                std::mem::swap(&mut self.best.0, &mut self.trial);
                std::mem::swap(&mut self.best.1, &mut self.trial_u);
            }
            if sum <= (1.0 - GAIN * part) * before {
                break;
            }
            part *= 0.5;
        }
        if least == f64::INFINITY {
            return f64::NAN;
        }
        std::mem::swap(&mut self.force, &mut self.best.0);
        std::mem::swap(&mut self.u, &mut self.best.1);
        self.look(posed)
    }

    /// Solves for the step; false where the matrix is singular.
    fn make_step(&mut self, posed: &Posed) -> bool {
        let Self { says, force, missed, place, matrix, right, step, .. } = self;
        let mut size = 0;
        place.clear();
        place.extend(says.iter().map(|s| {
            let pushes = !matches!(s, Says::Open);
            size += if pushes { 3 } else { 0 };
            pushes.then(|| size - 3)
        }));
        matrix.clear();
        matrix.resize(size * size, 0.0);
        right.clear();
        right.resize(size, 0.0);
        // What opens loses its force, and the others feel that.
        step.clear();
        step.extend(force.iter().zip(place.iter()).map(|(p, place)| if place.is_some() { DVec3::ZERO } else { -*p }));
        let mut felt = std::mem::take(&mut self.trial_u);
        felt.clear();
        felt.resize(step.len(), DVec3::ZERO);
        posed.problem.answer(step, &mut felt);
        for (i, row) in place.iter().enumerate().filter_map(|(i, place)| place.map(|row| (i, row))) {
            let (_, at) = posed.own(i);
            // How what is missed follows u, and p by itself.
            let (by_u, by_p) = of_law(&says[i], posed, i, at);
            let left = -missed[i] - by_u * felt[i];
            right[row..row + 3].copy_from_slice(&left.to_array());
            let diagonal = posed.problem.diagonal[i];
            let slight = DVec3::new(diagonal.x_axis.x, diagonal.y_axis.y, diagonal.z_axis.z) * SLIGHT;
            put(matrix, size, (row, row), &(by_u * (diagonal + DMat3::from_diagonal(slight)) + by_p));
            for (j, block) in &posed.problem.columns[i] {
                if let Some(column) = place[*j as usize] {
                    // The list holds ∂u_j/∂p_i, the transpose of what belongs here.
                    put(matrix, size, (row, column), &(by_u * block.transpose()));
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

/// ∂(what is missed)/∂u and, beside that, /∂p of contact `i`, whose W across the normal is `at`.
fn of_law(says: &Says, posed: &Posed, i: usize, at: f64) -> (DMat3, DMat3) {
    let Says::Slides(along, across) = says else { return (DMat3::IDENTITY, DMat3::ZERO) };
    let Law::Coulomb(friction) = posed.rows[i].law else { return (DMat3::IDENTITY, DMat3::ZERO) };
    let (a, _) = posed.own(i);
    let held = (DMat2::IDENTITY - *across) * at;
    let pushed = *along * (-friction * at);
    let tangents = |m: DMat2, first: DVec3| {
        DMat3::from_cols(first, DVec3::new(0.0, m.x_axis.x, m.x_axis.y), DVec3::new(0.0, m.y_axis.x, m.y_axis.y))
    };
    let ahead = if posed.by.ahead { pushed / -a } else { DVec2::ZERO };
    let by_u = tangents(*across, DVec3::new(1.0, ahead.x, ahead.y));
    (by_u, tangents(held, DVec3::new(0.0, pushed.x, pushed.y)))
}

/// u = W p + b.
fn answer(posed: &Posed, p: &[DVec3], u: &mut Vec<DVec3>) {
    u.clear();
    u.resize(p.len(), DVec3::ZERO);
    posed.problem.answer(p, u);
    u.iter_mut().zip(posed.rows).for_each(|(u, row)| *u += row.b);
}

/// Writes a block into a matrix of `size` rows, row by row.
fn put(matrix: &mut [f64], size: usize, (row, column): (usize, usize), block: &DMat3) {
    for r in 0..3 {
        let at = (row + r) * size + column;
        matrix[at..at + 3].copy_from_slice(&block.row(r).to_array());
    }
}

/// Solves the dense system in place by elimination with row pivots; false where it is singular.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn eliminate(matrix: &mut [f64], right: &mut [f64]) -> bool {
    let size = right.len();
    let largest = matrix.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for k in 0..size {
        let pivot = (k..size)
            .fold(k, |best, r| if matrix[r * size + k].abs() > matrix[best * size + k].abs() { r } else { best });
        // Written so that what is no number is singular.
        let is_sound = matrix[pivot * size + k].abs() > SINGULAR * largest;
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

    /// Numbers from -1 to 1 that are the same each time.
    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// `count` contacts of which each answers the forces at the others too, with W = M Mᵀ and a little on its diagonal.
    fn drawn(count: usize, friction: f64, next: &mut impl FnMut() -> f64) -> (Problem, Vec<Row>) {
        let m: Vec<Vec<DMat3>> = (0..count)
            .map(|_| (0..count).map(|_| DMat3::from_cols_array(&std::array::from_fn(|_| next()))).collect())
            .collect();
        let (mut problem, mut rows) = (Problem::default(), Vec::new());
        for i in 0..count {
            problem.push(Law::Coulomb(friction), DVec3::ZERO);
            for j in 0..=i {
                let block: DMat3 = (0..count).map(|k| m[i][k] * m[j][k].transpose()).fold(DMat3::ZERO, |a, b| a + b);
                problem.couple(i, j, if i == j { block + DMat3::IDENTITY * 0.01 } else { block });
            }
            let mut row = Row::new(DMat3::IDENTITY, Law::Coulomb(friction));
            row.b = DVec3::new(next(), next(), next()) * 1e-3;
            rows.push(row);
        }
        (problem, rows)
    }

    #[test]
    fn one_contact_has_the_force_that_is_known() {
        let mut next = numbers(1);
        for _ in 0..50 {
            let friction = 0.8 * next().abs();
            let (problem, rows) = drawn(1, friction, &mut next);
            let known = coulomb::solve(&problem.diagonal[0], rows[0].b, Law::Coulomb(friction), DVec3::ZERO);
            let (mut force, mut u) = (vec![DVec3::ZERO], Vec::new());
            assert!(AtOnce::default().solve(&problem, &rows, &Accuracy::FINE, (&mut force, &mut u)));
            // As exact as gaps are asked for.
            assert!((problem.diagonal[0] * (force[0] - known)).length() < 1e-6, "{} {known}", force[0]);
        }
    }

    #[test]
    fn what_settles_is_coulombs_law_at_every_contact() {
        let mut next = numbers(2);
        let mut settled = 0;
        for _ in 0..50 {
            let (problem, rows) = drawn(6, 0.5, &mut next);
            let (mut force, mut u) = (vec![DVec3::ZERO; 6], Vec::new());
            if !AtOnce::default().solve(&problem, &rows, &Accuracy::FINE, (&mut force, &mut u)) {
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
    fn contacts_that_contradict_each_other_have_no_forces() {
        // One place, pushed up and down by more than it may give.
        let mut problem = Problem::default();
        let mut rows = Vec::new();
        for sign in [1.0, -1.0] {
            problem.push(Law::Coulomb(0.3), DVec3::ZERO);
            problem.couple(rows.len(), rows.len(), DMat3::IDENTITY);
            let mut row = Row::new(DMat3::from_diagonal(DVec3::splat(sign)), Law::Coulomb(0.3));
            row.b = DVec3::new(-1e-3, 0.0, 0.0);
            rows.push(row);
        }
        problem.couple(1, 0, -DMat3::IDENTITY);
        let (mut force, mut u) = (vec![DVec3::ZERO; 2], Vec::new());
        assert!(!AtOnce::default().solve(&problem, &rows, &Accuracy::FINE, (&mut force, &mut u)));
        assert_eq!(force, [DVec3::ZERO; 2], "nothing is changed");
    }
}
