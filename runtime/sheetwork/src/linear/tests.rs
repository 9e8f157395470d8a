//! Tests of the factor with every instruction set, and of the indefinite one, against dense
//! factorisations.

use std::sync::LazyLock;

use proptest::prelude::*;

use crate::linear::cases::{self, FactorCase, dense_solve};
use crate::linear::dense::symmetric_eigen;
use crate::linear::ldl::IndefiniteFactor;
use crate::linear::*;

/// Two threads for factorisations.
static THREADS: LazyLock<crate::parallel::Pool> = LazyLock::new(|| crate::parallel::Pool::new(2).expect("two threads"));

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, v| v.abs().max(m))
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| (a - b).abs().max(m))
}

/// All available factors for a case.
fn factors(case: &FactorCase) -> Vec<Factor> {
    InstructionSet::ALL.into_iter().filter_map(|path| analyse_for(&case.pattern, &case.places, path)).collect()
}

/// A system with its solution from the dense factorisation.
struct Problem {
    values: Vec<f64>,
    load: Vec<f64>,
    solution: Vec<f64>,
}

impl Problem {
    fn new(case: &FactorCase, seed: u64) -> Self {
        let [values, load] = [case.values(seed, 1.0), case.load(seed)];
        let solution = dense_solve(case.dense(&values), &load).expect("positive definite");
        Self { values, load, solution }
    }

    /// Factorises, solves, and compares the solution with the dense one.
    fn check(&self, case: &FactorCase, factor: &mut Factor) {
        let who = format!("{} on {}", factor.name(), case.name);
        assert_eq!(factor.factorize(&self.values), Ok(()), "{who}");
        let mut x = self.load.clone();
        factor.solve(&mut x);
        // With condition numbers up to 1e5 a backward stable solution is accurate to about 1e-11.
        let size = largest(&self.solution);
        let error = difference(&x, &self.solution);
        assert!(error <= 1e-10 * size, "{who}: {error:e} of {size:e}");
        let residual = difference(&case.multiply(&self.values, &x), &self.load);
        assert!(residual <= 1e-11 * (1.0 + largest(&self.values) * size), "{who}: residual {residual:e}");
        let mut again = self.load.clone();
        assert_eq!(factor.factorize_and_solve(&self.values, &mut again), Ok(()), "{who}");
        assert_eq!(x, again, "{who}: with and after the factorisation");
        let mut on_two = self.load.clone();
        THREADS.install(|| {
            factor.set_parallel(true);
            assert_eq!(factor.factorize(&self.values), Ok(()), "{who}: on two threads");
            factor.set_parallel(false);
        });
        factor.solve(&mut on_two);
        assert_eq!(x, on_two, "{who}: on one thread and on two");
    }
}

#[test]
fn every_factor_agrees_with_the_dense_one() {
    for case in cases::all() {
        let problems = [0, 1].map(|seed| Problem::new(&case, seed));
        for mut factor in factors(&case) {
            for problem in &problems {
                problem.check(&case, &mut factor);
            }
        }
    }
}

proptest! {
    #![proptest_config(crate::math::drawn::drawn_cases(60))]

    /// Places on a coarse grid, so that many coincide.
    #[test]
    fn every_factor_agrees_with_the_dense_one_on_any_pattern(
        masses in prop::collection::vec((0i8..6, -3i8..3), 0..50),
        joined in prop::collection::vec((any::<u32>(), any::<u32>()), 0..160),
        seed in any::<u64>(),
    ) {
        let n = masses.len() as u32;
        let places = masses.iter().map(|&(u, v)| [f64::from(u), f64::from(v)]).collect();
        let case = FactorCase::new("any", places, joined.into_iter().filter(|_| n > 0).map(|(a, b)| (a % n, b % n)));
        let problem = Problem::new(&case, seed);
        for mut factor in factors(&case) {
            problem.check(&case, &mut factor);
        }
    }
}

#[test]
fn indefinite_matrices_are_refused_and_later_ones_factorise() {
    for case in [cases::chain(1), cases::chain(3), cases::shell(11, 11), cases::two_layers(5, 5), cases::scattered()] {
        let problem = Problem::new(&case, 2);
        for mut factor in factors(&case) {
            let who = format!("{} on {}", factor.name(), case.name);
            let good = case.values(1, 1.0);
            let last = case.pattern.blocks() - 1;
            for (slot, value) in [(0, -1e6), (0, f64::NAN), (last, -1e6), (last, 0.0), (last, f64::NAN)] {
                let mut bad = good.clone();
                bad[9 * slot + 4] = value;
                if value == 0.0 {
                    bad[9 * slot..9 * slot + 9].fill(0.0);
                }
                assert_eq!(factor.factorize(&bad), Err(NotPositiveDefinite), "{who}: {value} in block {slot}");
                THREADS.install(|| {
                    factor.set_parallel(true);
                    assert_eq!(
                        factor.factorize(&bad),
                        Err(NotPositiveDefinite),
                        "{who}: {value} in block {slot}, two threads"
                    );
                    factor.set_parallel(false);
                });
                let mut x = case.load(1);
                factor.solve(&mut x);
                assert!(x.iter().all(|v| v.is_nan()), "{who}: solves without a factor");
                problem.check(&case, &mut factor);
            }
        }
    }
}

#[test]
fn the_same_values_give_the_same_bits() {
    for case in [cases::shell(17, 17), cases::triangles(15, 4)] {
        for (mut one, mut other) in factors(&case).into_iter().zip(factors(&case)) {
            let [a, b] = [1, 2].map(|seed| case.values(seed, 1.0));
            // The second factor has factorised other values before.
            assert_eq!((one.factorize(&a), other.factorize(&b), other.factorize(&a)), (Ok(()), Ok(()), Ok(())));
            let mut x = [case.load(3), case.load(3)];
            one.solve(&mut x[0]);
            other.solve(&mut x[1]);
            assert_eq!(x[0], x[1], "{} on {}", one.name(), case.name);
        }
    }
}

#[test]
fn half_solutions_give_products_of_the_inverse() {
    for case in [cases::chain(1), cases::shell(11, 11), cases::triangles(13, 2), cases::scattered()] {
        let n = case.pattern.size() as u32;
        let mut loads = SparseLoads::default();
        for i in 0..6 {
            let row = |k: u32| (i * 7919 + k * 31) % n;
            loads.push((0..1 + i % 4).map(|k| (row(k), [0.3, f64::from(k) - 1.0, f64::from(i)])));
        }
        for mut factor in factors(&case) {
            let who = format!("{} on {}", factor.name(), case.name);
            let mut halves = HalfSolutions::default();
            halves.clear();
            factor.half_solve(&loads, &mut halves);
            assert!(halves.product(0, 0).is_nan(), "{who}: without a factor");
            assert_eq!(factor.factorize(&case.values(1, 1.0)), Ok(()));
            halves.clear();
            factor.half_solve(&loads, &mut halves);
            assert_eq!(halves.len(), loads.len());
            for (i, load) in loads.iter().enumerate() {
                let mut x = vec![0.0; 3 * n as usize];
                for &(row, value) in load {
                    (0..3).for_each(|k| x[3 * row as usize + k] += value[k]);
                }
                factor.solve(&mut x);
                for (j, other) in loads.iter().enumerate() {
                    let terms = other.iter().flat_map(|&(row, v)| (0..3).map(move |k| (3 * row as usize + k, v[k])));
                    let expected: f64 = terms.map(|(at, v)| x[at] * v).sum();
                    let scale = (halves.product(i, i) * halves.product(j, j)).sqrt();
                    let error = (halves.product(i, j) - expected).abs();
                    assert!(error <= 1e-10 * scale, "{who}: {i}, {j}: {error:e} of {scale:e}");
                }
            }
        }
    }
}

#[test]
fn blocks_of_half_solutions_have_the_bits_of_their_products() {
    for case in [cases::chain(1), cases::shell(11, 11), cases::triangles(13, 2), cases::scattered()] {
        let n = case.pattern.size() as u32;
        // As from contacts: three loads at equal nodes.
        let load = |i: u32, axis: u32| {
            let rows = (0..1 + i % 3).map(move |k| (i * 7919 + k * 31) % n);
            rows.map(move |row| {
                (row, [0, 1, 2].map(|k| f64::from(u32::from(k == axis)) * 0.7 + f64::from(k * i) * 0.1))
            })
        };
        let mut loads = SparseLoads::default();
        (0..5).for_each(|i| (0..3).for_each(|axis| loads.push(load(i, axis))));
        for mut factor in factors(&case) {
            let who = format!("{} on {}", factor.name(), case.name);
            assert_eq!(factor.factorize(&case.values(1, 1.0)), Ok(()));
            let mut halves = HalfSolutions::default();
            factor.half_solve(&loads, &mut halves);
            for (b, c) in (0..5).flat_map(|b| (0..5).map(move |c| (b, c))) {
                let products = [0, 1, 2].map(|i| [0, 1, 2].map(|j| halves.product(3 * b + i, 3 * c + j)));
                assert_eq!(halves.block(b, c), products, "{who}: block {b}, {c}");
            }
        }
    }
}

#[test]
fn the_indefinite_factor_agrees_with_a_dense_one() {
    for case in cases::all().into_iter().filter(|case| case.pattern.size() > 0) {
        let n = 3 * case.pattern.size();
        let load = case.load(3);
        let mut factor = IndefiniteFactor::new(&case.pattern, &case.places);
        for seed in [1, 2] {
            let mut values = case.values(seed, 1.0);
            // The mean of the eigenvalues as shift.
            let shift = nalgebra::DMatrix::from_vec(n, n, case.dense(&values)).trace() / n as f64 + 0.1;
            for column in 0..case.pattern.size() {
                let at = 9 * case.pattern.starts[column] as usize;
                (0..3).for_each(|k| values[at + 4 * k] -= shift);
            }
            let dense = nalgebra::DMatrix::from_vec(n, n, case.dense(&values));
            assert!(dense.clone().cholesky().is_none(), "{}: positive definite", case.name);
            let expected = dense.lu().solve(&nalgebra::DVector::from_column_slice(&load)).expect("regular");
            let mut x = load.clone();
            assert_eq!(factor.factorize_and_solve(&values, &mut x), Ok(()), "{}", case.name);
            let (error, size) = (difference(&x, expected.as_slice()), largest(expected.as_slice()));
            assert!(error <= 1e-8 * size, "{}: {error:e} of {size:e}", case.name);
        }
        let nothing = vec![0.0; 9 * case.pattern.blocks()];
        assert_eq!(factor.factorize_and_solve(&nothing, &mut load.clone()), Err(NotPositiveDefinite));
    }
}

#[test]
fn eigenvalues_ascend_and_their_vectors_belong_to_them() {
    let case = cases::shell(4, 4);
    let matrix = nalgebra::DMatrix::from_vec(48, 48, case.dense(&case.values(1, 1.0)));
    let (values, vectors) = symmetric_eigen(matrix.clone()).expect("converges");
    assert!(values.as_slice().is_sorted(), "{values}");
    let residual = &matrix * &vectors - &vectors * nalgebra::DMatrix::from_diagonal(&values);
    assert!(residual.amax() < 1e-12 * matrix.amax(), "{:e}", residual.amax());
    assert!(symmetric_eigen(nalgebra::DMatrix::from_element(2, 2, f64::NAN)).is_none());
}
