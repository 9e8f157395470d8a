//! Mean, standard deviation, median, and paired Student's t test.
//!
//! The deviation is the population deviation (divided by n). p is one-sided: the probability of a
//! mean difference at least this large in this direction under the null hypothesis. Both follow the
//! thesis.

use serde::Serialize;

/// Summary of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Sample size.
    pub n: usize,
    /// Mean.
    pub mean: f64,
    /// Population standard deviation.
    pub deviation: f64,
    /// Median; the mean of the middle two for an even size.
    pub median: f64,
}

/// Result of a paired test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Paired {
    /// Number of pairs.
    pub n: usize,
    /// Mean difference, first minus second of each pair.
    pub difference: f64,
    /// Mean difference over its standard error.
    pub t: f64,
    /// One-sided p.
    pub p: f64,
}

/// Mean, deviation and median of `values`; none for an empty slice.
pub fn summary(values: &[f64]) -> Option<Summary> {
    let n = values.len();
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = 0.5 * (sorted.get(n.checked_sub(1)? / 2)? + sorted.get(n / 2)?);
    let mean = values.iter().sum::<f64>() / n as f64;
    let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n as f64).sqrt();
    Some(Summary { n, mean, deviation, median })
}

/// Paired Student's t test; none for fewer than two pairs or equal differences.
pub fn paired(pairs: &[(f64, f64)]) -> Option<Paired> {
    let n = pairs.len();
    let differences = || pairs.iter().map(|(a, b)| a - b);
    let difference = differences().sum::<f64>() / n as f64;
    let spread: f64 = differences().map(|d| (d - difference).powi(2)).sum();
    if n < 2 || spread <= 0.0 {
        return None;
    }
    let error = (spread / ((n - 1) as f64 * n as f64)).sqrt();
    let t = difference / error;
    Some(Paired { n, difference, t, p: tail_probability(t, n as u32 - 1) })
}

/// Probability that Student's t of `freedom` degrees exceeds |t|. A finite sum of powers of cos θ,
/// with tan θ = t/√ν (Abramowitz and Stegun 26.7.3 and 26.7.4).
fn tail_probability(t: f64, freedom: u32) -> f64 {
    let angle = (t.abs() / f64::from(freedom).sqrt()).atan();
    let (sin, cos) = angle.sin_cos();
    let odd = freedom % 2;
    // Terms cos^(2k + odd) with recursive coefficients.
    let mut term = if odd == 1 { cos } else { 1.0 };
    let mut sum = 0.0;
    let mut power = odd;
    while power + 2 <= freedom {
        sum += term;
        power += 2;
        term *= cos * cos * f64::from(power - 1) / f64::from(power);
    }
    let within = if odd == 1 { (angle + sin * sum) * std::f64::consts::FRAC_2_PI } else { sin * sum };
    (0.5 * (1.0 - within)).clamp(0.0, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tail_probabilities_equal_the_table_of_students_t() {
        // Degrees of freedom, t, and one-sided probability beyond t.
        let table = [
            (1, 6.313_751_515, 0.05),
            (2, 4.302_652_73, 0.025),
            (3, 3.182_446_305, 0.025),
            (4, 2.776_445_105, 0.025),
            (9, 2.262_157_163, 0.025),
            (9, 1.383_028_739, 0.10),
            (10, 2.763_769_458, 0.01),
            (30, 1.697_260_887, 0.05),
        ];
        for (freedom, t, p) in table {
            assert!((tail_probability(t, freedom) - p).abs() < 1e-9, "{freedom}: {}", tail_probability(t, freedom));
            assert_eq!(tail_probability(t, freedom), tail_probability(-t, freedom));
        }
        assert_eq!(tail_probability(0.0, 7), 0.5);
    }

    #[test]
    fn statistics_of_too_few_values_are_undefined() {
        assert_eq!(summary(&[]), None);
        let found = summary(&[3.0, 1.0, 2.0, 8.0]).expect("some");
        assert_eq!((found.n, found.mean, found.median), (4, 3.5, 2.5));
        assert!((found.deviation - 7.25_f64.sqrt()).abs() < 1e-12);
        assert_eq!(paired(&[(1.0, 2.0)]), None);
        assert_eq!(paired(&[(1.0, 2.0), (2.0, 3.0)]), None, "all differ alike");
    }
}
