//! Every backend against the dense Cholesky factor, and the backends against each other.

use super::cases::{self, Case, dense_solve};
use super::*;

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, v| v.abs().max(m))
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| (a - b).abs().max(m))
}

/// All factors there are for a case.
fn factors(case: &Case) -> Vec<Box<dyn Factor>> {
    let ours = Path::ALL.into_iter().filter_map(|path| analyse_for(&case.pattern, &case.places, path));
    std::iter::once(analyse(&case.pattern, &case.places, Backend::Faer)).chain(ours).collect()
}

/// Factorises, solves, and holds the solution against the dense one.
fn check(case: &Case, factor: &mut dyn Factor, seed: u64) {
    let values = case.values(seed, 1.0);
    let load = case.load(seed);
    let expected = dense_solve(case.dense(&values), &load).expect("positive definite");
    let who = format!("{} on {}", factor.name(), case.name);
    assert_eq!(factor.factorize(&values), Ok(()), "{who}");
    let mut x = load.clone();
    factor.solve(&mut x);
    // Condition numbers reach 1e5; a backward stable solution is then right to about 1e-11.
    let error = difference(&x, &expected);
    assert!(error <= 1e-10 * largest(&expected), "{who}: {error:e} of {:e}", largest(&expected));
    let residual = difference(&case.multiply(&values, &x), &load);
    assert!(residual <= 1e-11 * (1.0 + largest(&values) * largest(&x)), "{who}: residual {residual:e}");
}

#[test]
fn every_factor_agrees_with_the_dense_one() {
    for case in cases::all() {
        for mut factor in factors(&case) {
            for seed in 0..3 {
                check(&case, &mut *factor, seed);
            }
        }
    }
}

#[test]
fn what_is_not_positive_is_refused_and_the_next_one_is_not() {
    for case in [cases::chain(1), cases::chain(3), cases::shell(11, 11), cases::two_layers(5, 5), cases::scattered()] {
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
                assert_eq!(factor.factorize(&bad), Err(NotPositive), "{who}: {value} in block {slot}");
                let mut x = case.load(1);
                factor.solve(&mut x);
                assert!(x.iter().all(|v| v.is_nan()), "{who}: solves without a factor");
                check(&case, &mut *factor, 2);
            }
        }
    }
}

#[test]
fn the_same_values_give_the_same_bits() {
    for case in [cases::shell(17, 17), cases::triangles(15, 4)] {
        for (mut one, mut other) in factors(&case).into_iter().zip(factors(&case)) {
            let [a, b] = [1, 2].map(|seed| case.values(seed, 1.0));
            // The other has factorised something else before.
            assert_eq!((one.factorize(&a), other.factorize(&b), other.factorize(&a)), (Ok(()), Ok(()), Ok(())));
            let mut x = [case.load(3), case.load(3)];
            one.solve(&mut x[0]);
            other.solve(&mut x[1]);
            assert_eq!(x[0], x[1], "{} on {}", one.name(), case.name);
        }
    }
}
