//! Closed forms and reference solutions that cases are held against.

/// Droop of a heavy inextensible strip clamped horizontally: tip drop and reach as fractions of its length.
///
/// θ'' = -Γ (1-s) cos θ, θ(0) = 0, θ'(1) = 0, with Γ = ρ g t L³/B the one number of the problem (B the bending stiffness per
/// width). Integrated from the tip in φ = π/2 - θ, the angle from the plumb line, which there is as small as e^(-⅔√Γ) and grows all
/// the way to π/2 at the root; the smallest such φ is the strip that does not coil.
pub fn elastica(gamma: f64) -> (f64, f64) {
    let root = std::f64::consts::FRAC_PI_2;
    let mut high = 1e-300;
    while hang(gamma, high).0 < root && high < root {
        high *= 2.0;
    }
    let (mut low, mut high) = (0.5 * high, high.min(root));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if hang(gamma, middle).0 < root {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (_, drop, reach) = hang(gamma, 0.5 * (low + high));
    (drop, reach)
}

/// Angle from the plumb line at the root, drop and reach of a strip whose tip hangs at `tip` from it, by the classical
/// Runge-Kutta method.
fn hang(gamma: f64, tip: f64) -> (f64, f64, f64) {
    const STEPS: u32 = 4000;
    let h = 1.0 / f64::from(STEPS);
    // Angle, its slope towards the root, drop, reach.
    let mut u = [tip, 0.0, 0.0, 0.0];
    let rate = |s: f64, u: [f64; 4]| [u[1], gamma * s * u[0].sin(), u[0].cos(), u[0].sin()];
    let moved = |u: [f64; 4], k: [f64; 4], h: f64| [u[0] + h * k[0], u[1] + h * k[1], u[2] + h * k[2], u[3] + h * k[3]];
    for step in 0..STEPS {
        let s = f64::from(step) * h;
        let k1 = rate(s, u);
        let k2 = rate(s + 0.5 * h, moved(u, k1, 0.5 * h));
        let k3 = rate(s + 0.5 * h, moved(u, k2, 0.5 * h));
        let k4 = rate(s + h, moved(u, k3, h));
        for i in 0..4 {
            u[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
    (u[0], u[2], u[3])
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
        // Far beyond the tables the reach goes to √(2/Γ) and the strip hangs nearly its length.
        for gamma in [200.0_f64, 1e3, 1e4, 1e6] {
            let (h, w) = super::elastica(gamma);
            assert!((w * (0.5 * gamma).sqrt() - 1.0).abs() < 0.15 && h > 0.95 && h < 1.0, "{gamma}: {h} {w}");
        }
    }
}
