//! Real roots of a cubic c₀ + c₁ t + c₂ t² + c₃ t³ with 0 ≤ t ≤ 1.
//!
//! The roots of the derivative divide the interval into pieces on which the cubic is monotone. A
//! piece with different signs at its ends contains one root, found by Newton's method safeguarded
//! by bisection. Where the cubic only touches zero, the root of the derivative is used if the value
//! there is rounding noise.

/// Up to five roots in ascending order: three simple roots and two points of tangency.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Roots {
    values: [f64; 5],
    count: usize,
}

impl Roots {
    fn push(&mut self, t: f64) {
        let repeated = self.count > 0 && self.values[self.count - 1] == t;
        if self.count < self.values.len() && !repeated {
            self.values[self.count] = t;
            self.count += 1;
        }
    }

    /// Roots in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = f64> + '_ {
        self.values[..self.count].iter().copied()
    }
}

/// Roots in [0, 1] of the cubic with the coefficients `c`, lowest power first. Empty for a cubic
/// that is zero throughout, and for coefficients that are not finite.
pub fn roots_in_unit_interval(c: [f64; 4]) -> Roots {
    let mut roots = Roots::default();
    let scale = c.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if !scale.is_finite() || scale == 0.0 {
        return roots;
    }
    let noise = 1e-14 * scale;
    let value = |t: f64| ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
    let mut from = 0.0;
    let mut before = value(from);
    if before.abs() <= noise {
        roots.push(from);
    }
    for to in turning_points(c).into_iter().chain([1.0]).filter(|t| *t > 0.0 && *t <= 1.0) {
        let after = value(to);
        if after.abs() <= noise {
            roots.push(to);
        } else if before.abs() > noise && (before < 0.0) != (after < 0.0) {
            roots.push(bracketed(&c, from, to, before < 0.0));
        }
        (from, before) = (to, after);
    }
    roots
}

/// Zeros of the derivative, ascending; infinite if they do not exist.
fn turning_points(c: [f64; 4]) -> [f64; 2] {
    const NONE: f64 = f64::INFINITY;
    let (a, b, d) = (3.0 * c[3], 2.0 * c[2], c[1]);
    let inside = b * b - 4.0 * a * d;
    if inside < 0.0 {
        return [NONE; 2];
    }
    // The sum of two numbers of equal sign has no cancellation; the other root follows from the
    // product of both.
    let q = -0.5 * (b + b.signum() * inside.sqrt());
    let (first, second) = (if a != 0.0 { q / a } else { NONE }, if q != 0.0 { d / q } else { NONE });
    let (low, high) = (first.min(second), first.max(second));
    [if low.is_nan() { NONE } else { low }, if high.is_nan() { NONE } else { high }]
}

fn bracketed(c: &[f64; 4], mut low: f64, mut high: f64, rises: bool) -> f64 {
    let mut t = 0.5 * (low + high);
    for _ in 0..64 {
        let value = ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
        let slope = (3.0 * c[3] * t + 2.0 * c[2]) * t + c[1];
        if (value < 0.0) == rises {
            low = t;
        } else {
            high = t;
        }
        let newton = t - value / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if next == t || high - low <= f64::EPSILON {
            break;
        }
        t = next;
    }
    t
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(crate::math::drawn::drawn_cases(256))]

        #[test]
        fn the_roots_of_a_product_are_found(mut r in [-0.5..1.5, -0.5..1.5, -0.5..1.5], scale in 0.1..10.0) {
            r.sort_by(f64::total_cmp);
            let [a, b, d]: [f64; 3] = r;
            let c = [-a * b * d * scale, (a * b + b * d + d * a) * scale, -(a + b + d) * scale, scale];
            let found: Vec<f64> = roots_in_unit_interval(c).iter().collect();
            let apart = b - a > 1e-3 && d - b > 1e-3;
            for root in r.into_iter().filter(|x| apart && *x > 1e-6 && *x < 1.0 - 1e-6) {
                prop_assert!(found.iter().any(|t| (t - root).abs() < 1e-8), "{root} is not among {found:?}");
            }
            prop_assert!(found.windows(2).all(|w| w[0] < w[1]));
        }
    }

    #[test]
    fn lower_degrees_and_touching_points_are_roots_too() {
        let is = |c, roots: &[f64]| {
            let found: Vec<f64> = roots_in_unit_interval(c).iter().collect();
            let same = found.len() == roots.len() && found.iter().zip(roots).all(|(a, b)| (a - b).abs() < 1e-7);
            assert!(same, "{found:?} for {roots:?}");
        };
        is([-0.5, 1.0, 0.0, 0.0], &[0.5]);
        is([0.25, -1.0, 1.0, 0.0], &[0.5]);
        is([0.0, 1.0, 0.0, 0.0], &[0.0]);
        is([-1.0, 0.0, 0.0, 1.0], &[1.0]);
        is([0.0; 4], &[]);
        is([1.0, 0.0, 0.0, 0.0], &[]);
        is([f64::NAN, 1.0, 0.0, 0.0], &[]);
    }
}
