//! Elastica: closed forms and reference solutions for tests and rigs.

use std::f64::consts::FRAC_PI_2;

/// Integration steps when only the ends of the strip are needed.
const STEPS: usize = 4000;

/// Droop of a heavy inextensible strip clamped horizontally: tip drop and reach as fractions of its
/// length. See [`elastica_curve`].
pub fn elastica(gamma: f64) -> (f64, f64) {
    let (reach, drop) = elastica_curve(gamma, STEPS).last().copied().unwrap_or((1.0, 0.0));
    (drop, reach)
}

/// Curve of a heavy inextensible strip clamped horizontally, from its tip to the clamp: horizontal
/// and vertical distance of each of `steps` + 1 points from the tip, as fractions of its length.
///
///   θ'' = -Γ (1-s) cos θ, θ(0) = 0, θ'(1) = 0,
///
/// with the load parameter Γ = ρ g t L³/B (B the bending stiffness per width, N m). Integrated from
/// the tip in φ = π/2 - θ, the angle from the vertical, which is as small as e^(-⅔√Γ) at the tip
/// and grows to π/2 at the root; the smallest such φ is the solution without coils.
pub fn elastica_curve(gamma: f64, steps: usize) -> Vec<(f64, f64)> {
    let (mut low, mut high) = (f64::MIN_POSITIVE, FRAC_PI_2);
    for _ in 0..200 {
        // Bisection of the tip angle, in its logarithm while it is small.
        let middle = if high > 4.0 * low { low.sqrt() * high.sqrt() } else { 0.5 * (low + high) };
        if hang(gamma, middle, steps, &mut |_, _| ()) < FRAC_PI_2 {
            low = middle;
        } else {
            high = middle;
        }
        if high / low < 1.0 + 1e-15 {
            break;
        }
    }
    let mut points = Vec::with_capacity(steps + 1);
    hang(gamma, 0.5 * (low + high), steps, &mut |reach, drop| points.push((reach, drop)));
    points
}

/// Angle from the vertical at the root of a strip with the angle `tip` (rad) at its tip, by the
/// classical Runge-Kutta method; `visit` receives reach and drop of each point. Ends early far
/// beyond horizontal.
fn hang(gamma: f64, tip: f64, steps: usize, visit: &mut dyn FnMut(f64, f64)) -> f64 {
    // Angle, its derivative towards the root, reach, drop.
    let mut u = [tip, 0.0, 0.0, 0.0];
    let rate = |s: f64, u: [f64; 4]| [u[1], gamma * s * u[0].sin(), u[0].sin(), u[0].cos()];
    let moved = |u: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| u[i] + h * k[i]);
    visit(0.0, 0.0);
    let mut s = 0.0;
    for step in 0..steps {
        // Short steps near the clamp, where a long strip bends.
        let next = 1.0 - (1.0 - (step + 1) as f64 / steps as f64).powi(2);
        let h = next - s;
        let k1 = rate(s, u);
        let k2 = rate(s + 0.5 * h, moved(u, k1, 0.5 * h));
        let k3 = rate(s + 0.5 * h, moved(u, k2, 0.5 * h));
        let k4 = rate(s + h, moved(u, k3, h));
        for i in 0..4 {
            u[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
        if u[0] > 1.5 * FRAC_PI_2 {
            return u[0];
        }
        visit(u[2], u[3]);
        s = next;
    }
    u[0]
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_elastica_is_that_of_the_tables() {
        for (gamma, drop, reach) in [
            (0.1, 0.0124984, 0.9999107),
            (1.0, 0.1234714, 0.9912464),
            (10.0, 0.7001997, 0.6563538),
            (100.0, 0.9375239, 0.1592234),
        ] {
            let (h, w) = super::elastica(gamma);
            assert!((h - drop).abs() < 1e-7 && (w - reach).abs() < 1e-7, "{gamma}: {h} {w}");
        }
        // Far beyond the tables the reach approaches √(2/Γ) and the strip hangs nearly its length.
        for gamma in [200.0_f64, 1e3, 1e4, 1e6] {
            let (h, w) = super::elastica(gamma);
            assert!((w * (0.5 * gamma).sqrt() - 1.0).abs() < 0.15 && h > 0.95 && h < 1.0, "{gamma}: {h} {w}");
        }
    }
}
