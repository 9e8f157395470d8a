//! Anticlastic bending: effect of the membrane on the bending stiffness of a strip.
//!
//! A strip bent to curvature κ tends to curl by ν κ across its width. In a wide or thin strip the
//! membrane prevents this, and the strip bends with D; in a narrow or thick one it does not, and
//! the strip bends with D (1-ν²). Across the width the deflection w from the cylinder is a beam on
//! an elastic foundation, D w'''' + S κ² w = 0 with w'' = -ν κ and w''' = 0 at the free edges, S
//! the uniaxial membrane stiffness (Lamb 1891; Ashwell, *J. Roy. Aero. Soc.* 54, 1950). Its energy
//! gives the bending stiffness
//!
//!   D (1 - ν² F),  F = (2/β) (cosh β - cos β)/(sinh β + sin β),  β = W (S κ²/(4 D))^(1/4).

/// Bending stiffness of a strip of the given width (m) bent to `curvature` (1/m), as a fraction of
/// D (`bending`, N m) of its plate; `stretch` is its uniaxial membrane stiffness per width, N/m.
pub fn strip_bending(bending: f64, stretch: f64, poisson: f64, curvature: f64, width: f64) -> f64 {
    let beta = width * (stretch * curvature * curvature / (4.0 * bending)).max(0.0).powf(0.25);
    let share = if !beta.is_finite() || beta < 1e-2 {
        1.0
    } else if beta > 30.0 {
        2.0 / beta
    } else {
        (2.0 / beta) * (beta.cosh() - beta.cos()) / (beta.sinh() + beta.sin())
    };
    1.0 - poisson * poisson * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrow_strips_are_beams_and_wide_ones_plates() {
        let (d, s, nu) = (0.04, 1.5e6, 0.35);
        assert!((strip_bending(d, s, nu, 1.0, 1e-5) - (1.0 - nu * nu)).abs() < 1e-9);
        assert!((strip_bending(d, s, nu, 10.0, 100.0) - 1.0).abs() < 1e-4);
        assert!((strip_bending(d, s, nu, 0.0, 1.0) - (1.0 - nu * nu)).abs() < 1e-12);
    }

    #[test]
    fn the_energy_is_that_of_the_beam_on_its_foundation() {
        // Check by the differential equation's invariant: F is the mean of -w''/(ν κ) over the
        // width, integrated here by Simpson's rule.
        let beta: f64 = 3.7;
        // w'' ∝ p cosh(m) cos(m) + q sinh(m) sin(m), m = β (x/W), even in x, w''' = 0 and w'' = 1
        // at the edge m = β/2.
        let h = 0.5 * beta;
        let (c, s) = (h.cosh() * h.cos(), h.sinh() * h.sin());
        let (dc, ds) = (h.sinh() * h.cos() - h.cosh() * h.sin(), h.cosh() * h.sin() + h.sinh() * h.cos());
        let determinant = c * ds - s * dc;
        let (p, q) = (ds / determinant, -dc / determinant);
        let curl = |m: f64| p * m.cosh() * m.cos() + q * m.sinh() * m.sin();
        let n = 200;
        let weight = |i: usize| if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
        let mean = (0..=n).map(|i| weight(i) * curl(h * i as f64 / n as f64)).sum::<f64>() / (3.0 * n as f64);
        let (nu, d, w, s) = (0.3, 2.0, 0.5, 7.0);
        let curvature = (beta / w).powi(2) * (4.0_f64 * d / s).sqrt();
        let found = (1.0 - strip_bending(d, s, nu, curvature, w)) / (nu * nu);
        assert!((found - mean).abs() < 1e-8, "{found} {mean}");
    }
}
