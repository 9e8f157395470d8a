//! Tests of ordered answers by their ranks: Friedman's test of several sheets, Wilcoxon's
//! signed-rank test of two, and Holm's correction for many tests.
//!
//! Ties take the mean of their ranks. p is that of the permutation distribution given the ties: of
//! the signs of the differences (Wilcoxon) and of the ranks of each subject (Friedman; M. Friedman,
//! J. Am. Stat. Assoc. 32, 1937; S. Holm, Scand. J. Stat. 6, 1979). It is exact for Wilcoxon, and
//! for Friedman where the number of rank sums is small; otherwise it is estimated from
//! permutations of a fixed seed.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::measure::SplitMix64;

/// Result of Wilcoxon's signed-rank test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Wilcoxon {
    /// Number of pairs that differ.
    pub n: usize,
    /// Sum of the ranks of positive differences.
    pub positive: f64,
    /// Sum of the ranks of negative differences.
    pub negative: f64,
    /// Probability of a sum of positive ranks at least as large, one-sided.
    pub p_greater: f64,
    /// Two-sided p.
    pub p: f64,
}

/// Result of Friedman's test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Friedman {
    /// Number of subjects.
    pub n: usize,
    /// Mean rank of each sheet; the best has the largest.
    pub mean_ranks: Vec<f64>,
    /// Statistic, corrected for ties; χ² of k - 1 degrees for many subjects.
    pub statistic: f64,
    /// p, two-sided by nature.
    pub p: f64,
}

/// Limits of the exact distribution of Friedman's statistic.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FriedmanSettings {
    /// Maximum number of distinct sums of ranks (a table of 10 subjects and 4 sheets has 20,000).
    pub states: usize,
    /// Permutations beyond it; 100,000 give p of 0.05 within 0.0014 (two standard errors).
    pub permutations: usize,
}

impl Default for FriedmanSettings {
    fn default() -> Self {
        Self { states: 30_000, permutations: 100_000 }
    }
}

/// Ranks from 1, doubled so that means of ties are whole numbers.
fn doubled_ranks(values: &[f64]) -> Vec<u32> {
    let count = |test: &dyn Fn(f64) -> bool| values.iter().filter(|v| test(**v)).count() as u32;
    values.iter().map(|v| 2 * count(&|w| w < *v) + count(&|w| w == *v) + 1).collect()
}

/// Wilcoxon's signed-rank test of the differences `first - second`; pairs without a difference
/// count for neither side and are left out. None without a difference.
pub fn wilcoxon(pairs: &[(f64, f64)]) -> Option<Wilcoxon> {
    let differences: Vec<f64> = pairs.iter().map(|(a, b)| a - b).filter(|d| *d != 0.0).collect();
    if differences.is_empty() {
        return None;
    }
    let ranks = doubled_ranks(&differences.iter().map(|d| d.abs()).collect::<Vec<_>>());
    let total: u32 = ranks.iter().sum();
    let positive: u32 = ranks.iter().zip(&differences).filter(|(_, d)| **d > 0.0).map(|(r, _)| r).sum();
    // Share of the sign patterns with each sum of positive ranks.
    let mut share = vec![0.0; total as usize + 1];
    share[0] = 1.0;
    let mut reached = 0;
    for rank in ranks.iter().map(|r| *r as usize) {
        for sum in (0..=reached).rev() {
            let half = 0.5 * share[sum];
            share[sum] = half;
            share[sum + rank] += half;
        }
        reached += rank;
    }
    let p_greater = share[positive as usize..].iter().sum::<f64>().min(1.0);
    let p_less = share[..=positive as usize].iter().sum::<f64>();
    Some(Wilcoxon {
        n: differences.len(),
        positive: 0.5 * f64::from(positive),
        negative: 0.5 * f64::from(total - positive),
        p_greater,
        p: (2.0 * p_greater.min(p_less)).min(1.0),
    })
}

/// Friedman's test of a row per subject and a column per sheet. None for fewer than two subjects or
/// sheets, or where every subject rates all alike.
pub fn friedman(rows: &[Vec<f64>]) -> Option<Friedman> {
    friedman_with(rows, FriedmanSettings::default())
}

pub(crate) fn friedman_with(rows: &[Vec<f64>], settings: FriedmanSettings) -> Option<Friedman> {
    let (n, k) = (rows.len(), rows.first()?.len());
    if n < 2 || k < 2 || rows.iter().any(|r| r.len() != k) {
        return None;
    }
    let ranks: Vec<Vec<u32>> = rows.iter().map(|r| doubled_ranks(r)).collect();
    let mut sums = vec![0; k];
    for row in &ranks {
        sums.iter_mut().zip(row).for_each(|(sum, rank)| *sum += rank);
    }
    // With ranks doubled, the mean of a row is k + 1.
    let middle = (n * (k + 1)) as f64;
    let squares = |sums: &[u32]| sums.iter().map(|s| (f64::from(*s) - middle).powi(2)).sum::<f64>();
    let spread: f64 = ranks.iter().flatten().map(|r| (f64::from(*r) - (k + 1) as f64).powi(2)).sum();
    if spread <= 0.0 {
        return None;
    }
    let found = squares(&sums);
    let p = exact(&ranks, found, settings.states, &squares)
        .unwrap_or_else(|| sampled(&ranks, found, settings.permutations, &squares));
    Some(Friedman {
        n,
        mean_ranks: sums.iter().map(|s| 0.5 * f64::from(*s) / n as f64).collect(),
        statistic: (k - 1) as f64 * found / spread,
        p,
    })
}

/// Probability of squares of at least `found`, over all orders of the ranks of each subject. None
/// where there are more than `most` sums of ranks. Sums are sorted: the statistic does not tell the
/// sheets apart.
fn exact(ranks: &[Vec<u32>], found: f64, most: usize, squares: &dyn Fn(&[u32]) -> f64) -> Option<f64> {
    let mut states: BTreeMap<Vec<u32>, f64> = BTreeMap::new();
    states.insert(vec![0; ranks.first()?.len()], 1.0);
    for (index, row) in ranks.iter().enumerate() {
        // By symmetry the first subject keeps its order.
        let orders = if index == 0 { vec![row.clone()] } else { orders_of(row) };
        let mut next: BTreeMap<Vec<u32>, f64> = BTreeMap::new();
        let share = 1.0 / orders.len() as f64;
        for (sums, weight) in &states {
            for order in &orders {
                let mut sum: Vec<u32> = sums.iter().zip(order).map(|(s, r)| s + r).collect();
                sum.sort_unstable();
                *next.entry(sum).or_insert(0.0) += weight * share;
            }
            if next.len() > most {
                return None;
            }
        }
        states = next;
    }
    let reaches = |sums: &[u32]| squares(sums) >= found - 1e-9;
    Some(states.iter().filter(|(sums, _)| reaches(sums)).map(|(_, weight)| weight).sum::<f64>().min(1.0))
}

/// Different orders of a row, each as often as any other.
fn orders_of(row: &[u32]) -> Vec<Vec<u32>> {
    fn extend(start: &mut Vec<u32>, left: &[u32], all: &mut Vec<Vec<u32>>) {
        if left.is_empty() {
            all.push(start.clone());
        }
        for (i, rank) in left.iter().enumerate() {
            if left[..i].contains(rank) {
                continue;
            }
            start.push(*rank);
            extend(start, &[&left[..i], &left[i + 1..]].concat(), all);
            start.pop();
        }
    }
    let mut all = Vec::new();
    extend(&mut Vec::new(), row, &mut all);
    all
}

/// As [`exact`], from random orders.
fn sampled(ranks: &[Vec<u32>], found: f64, permutations: usize, squares: &dyn Fn(&[u32]) -> f64) -> f64 {
    let mut draw = SplitMix64::from_state(1);
    let mut rows = ranks.to_vec();
    let mut reaching = 0;
    for _ in 0..permutations {
        let mut sums = vec![0; rows.first().map_or(0, Vec::len)];
        for row in &mut rows {
            (1..row.len()).rev().for_each(|i| row.swap(i, draw.below(i + 1)));
            sums.iter_mut().zip(row.iter()).for_each(|(sum, rank)| *sum += rank);
        }
        reaching += usize::from(squares(&sums) >= found - 1e-9);
    }
    (reaching + 1) as f64 / (permutations + 1) as f64
}

/// p corrected for their number by Holm's method, in the order given.
pub fn holm(all: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|a, b| all[*a].total_cmp(&all[*b]));
    let mut corrected = vec![0.0; all.len()];
    let mut least: f64 = 0.0;
    for (place, index) in order.into_iter().enumerate() {
        least = least.max(all[index] * (all.len() - place) as f64).min(1.0);
        corrected[index] = least;
    }
    corrected
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs without ties whose negative differences have the ranks `negative`.
    fn ranked(n: usize, negative: &[usize]) -> Vec<(f64, f64)> {
        (1..=n).map(|r| (r as f64 * if negative.contains(&r) { -1.0 } else { 1.0 }, 0.0)).collect()
    }

    #[test]
    fn wilcoxon_equals_its_published_table() {
        // Two-sided p of the smaller sum of ranks (Siegel, Nonparametric Statistics, table G, and
        // the counts it is made of: 2 × 25/1024 for n = 10, T = 8).
        let table: [(usize, &[usize], f64); 5] =
            [(5, &[], 0.0625), (6, &[], 0.03125), (8, &[3], 0.0390625), (10, &[8], 0.048828125), (7, &[2], 0.046875)];
        for (n, negative, p) in table {
            let found = wilcoxon(&ranked(n, negative)).expect("differences");
            assert!((found.p - p).abs() < 1e-12, "{n}: {}", found.p);
            assert_eq!(found.positive + found.negative, (n * (n + 1) / 2) as f64);
            assert!(found.p_greater <= 0.5);
        }
        assert_eq!(wilcoxon(&[(1.0, 1.0)]), None);
        // Ties: |d| = 1, 1, 2 have the ranks 1.5, 1.5, 3; both signs of all 8 patterns.
        let tied = wilcoxon(&[(1.0, 0.0), (1.0, 0.0), (2.0, 0.0), (5.0, 5.0)]).expect("differences");
        assert_eq!((tied.n, tied.positive, tied.p_greater, tied.p), (3, 6.0, 0.125, 0.25));
    }

    #[test]
    fn friedman_equals_its_published_table() {
        // Friedman 1937, table V and VI: subjects, rows of ranks, χ², p.
        let three = |rows: &[[f64; 3]]| rows.iter().map(|r| r.to_vec()).collect::<Vec<_>>();
        let four = |rows: &[[f64; 4]]| rows.iter().map(|r| r.to_vec()).collect::<Vec<_>>();
        let (a, b) = ([1.0, 2.0, 3.0], [2.0, 1.0, 3.0]);
        let cases = [
            (three(&[a, a, a]), 6.0, 0.028),
            (three(&[a, a, a, b]), 6.5, 0.042),
            (three(&[a, a, a, a]), 8.0, 0.0046),
            (four(&[[1.0, 2.0, 3.0, 4.0]; 3]), 9.0, 0.0017),
            (four(&[[1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 4.0], [2.0, 1.0, 3.0, 4.0]]), 8.2, 0.017),
        ];
        for (rows, statistic, p) in cases {
            let found = friedman(&rows).expect("different");
            assert!((found.statistic - statistic).abs() < 1e-9, "{found:?}");
            assert!((found.p - p).abs() < 6e-4, "{found:?}");
            let drawn = friedman_with(&rows, FriedmanSettings { states: 1, ..FriedmanSettings::default() });
            assert!((drawn.expect("different").p - found.p).abs() < 3e-3);
        }
        assert_eq!(friedman(&[vec![1.0, 1.0], vec![2.0, 2.0]]), None);
    }

    #[test]
    fn holm_equals_its_definition() {
        let found = holm(&[0.01, 0.04, 0.03, 0.005]);
        // 4 × 0.005, 3 × 0.01, 2 × 0.03, and 0.04 not below the one before.
        let wanted = [0.03, 0.06, 0.06, 0.02];
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        assert_eq!(holm(&[0.6, 0.9]), [1.0, 1.0]);
    }
}
