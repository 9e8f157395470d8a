//! The heavy elastica: a clamped strip bent by its own weight, inextensible, of any rotation.
//!
//! B θ'' = -q (L - s) cos θ, θ(0) = 0, θ'(L) = 0 (Rohde 1953; Wang 1986): B the bending stiffness
//! per width, N·m, q the weight per area, Pa, s the arc length from the clamp, m, θ the slope below
//! the horizontal.

const PIECES: usize = 2000;

/// Drop of the tip over the length, for Γ = q L³ / B.
pub fn tip_drop(gamma: f64) -> f64 {
    // Shooting from the tip, where the curvature vanishes: the slope there is sought that gives
    // slope 0 at the clamp.
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if from_tip(gamma, middle).0 > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    from_tip(gamma, low).1
}

/// Slope at the clamp, and height of the clamp over the tip, of the curve with slope `tip` at its
/// tip.
fn from_tip(gamma: f64, tip: f64) -> (f64, f64) {
    let h = 1.0 / PIECES as f64;
    let rate = |u: f64, [slope, bend, _]: [f64; 3]| [-bend, gamma * u * slope.cos(), slope.sin()];
    let along = |state: [f64; 3], by: f64, k: [f64; 3]| std::array::from_fn(|i| state[i] + by * k[i]);
    let mut state = [tip, 0.0, 0.0];
    for piece in 0..PIECES {
        let u = piece as f64 * h;
        let k1 = rate(u, state);
        let k2 = rate(u + 0.5 * h, along(state, 0.5 * h, k1));
        let k3 = rate(u + 0.5 * h, along(state, 0.5 * h, k2));
        let k4 = rate(u + h, along(state, h, k3));
        state = std::array::from_fn(|i| state[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    (state[0], state[2])
}
