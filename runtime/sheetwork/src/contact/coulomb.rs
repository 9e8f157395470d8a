//! Exact solution of Coulomb friction at a single contact.
//!
//! In the contact frame (normal, two tangents), with the forces of all other contacts constant, u =
//! A p + b: u is the gap or relative velocity (m or m/s), p the force (N) and A the 3×3 compliance
//! block of the contact. The solution p satisfies
//!
//!   0 ≤ u_n ⊥ p_n ≥ 0,  |p_t| ≤ μ p_n,  and p_t = -μ p_n u_t/|u_t| in slip.
//!
//! Three cases are tried in turn: open (b_n ≥ 0), stick (A p = -b lies in the friction cone),
//! slip. Slip is found by a fixed-point iteration. Where that cycles (large μ, strong coupling of
//! normal and tangential compliance), a bracketing search on p_n replaces it: for a given p_n the
//! tangential force is the minimum of a convex quadratic over a disc, and the resulting gap changes
//! sign once.
//!
//! Sources: De Saxcé and Feng, "The bipotential method", Math. Comput. Modelling 28, 1998, on the
//! missing minimum principle; Cadoux, PhD thesis, Grenoble 2009, and Acary, Brémond, Huber, "On
//! solving contact problems with Coulomb friction", 2018, on Gauss-Seidel sweeps over such blocks.

use glam::{DMat2, DMat3, DVec2, DVec3};

use crate::contact::settings::{ContactSettings, CoulombSettings};

const SETTINGS: CoulombSettings = ContactSettings::DEFAULT.coulomb;

/// Law of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactLaw {
    /// Unilateral contact with this friction coefficient.
    Coulomb(f64),
    /// Bilateral constraint in all directions, as of an attachment.
    Attachment,
}

/// Return the force p (N) that satisfies u = A p + b and `law`; `before` is the initial guess.
pub fn solve(a: &DMat3, b: DVec3, law: ContactLaw, before: DVec3) -> DVec3 {
    if a.x_axis.x <= 0.0 {
        // Both sides are fixed along the normal: no force changes the gap.
        return DVec3::ZERO;
    }
    let ContactLaw::Coulomb(friction) = law else { return solve_stick(a, b).unwrap_or(before) };
    if b.x >= 0.0 {
        return DVec3::ZERO;
    }
    let frictionless = DVec3::new(-b.x / a.x_axis.x, 0.0, 0.0);
    if friction == 0.0 {
        return frictionless;
    }
    if let Some(p) = solve_stick(a, b) {
        let tangential = p.y * p.y + p.z * p.z;
        if p.x > 0.0 && tangential <= friction * friction * p.x * p.x * (1.0 + 1e-12) {
            return p;
        }
    }
    iterate_slip(a, b, friction, before, frictionless.x).unwrap_or_else(|| bracket_slip(a, b, friction, frictionless.x))
}

/// Force (N) for u = 0; `None` if the block is nearly singular.
fn solve_stick(a: &DMat3, b: DVec3) -> Option<DVec3> {
    // Near-singular blocks are left to the other cases.
    let scale = a.x_axis.x.max(a.y_axis.y).max(a.z_axis.z);
    let determinant = a.determinant();
    (determinant > 1e-14 * scale * scale * scale).then(|| {
        let p = a.inverse() * -b;
        // One step of iterative refinement: rounding must not make a sticking contact creep.
        p - a.inverse() * (*a * p + b)
    })
}

/// Force (N) in slip, by fixed-point iteration from `before`; `None` if it does not converge to a
/// closed contact.
fn iterate_slip(a: &DMat3, b: DVec3, friction: f64, before: DVec3, frictionless: f64) -> Option<DVec3> {
    let mut p = DVec3::new(before.x.max(1e-3 * frictionless), before.y, before.z);
    let stiff = a.y_axis.y.max(a.z_axis.z);
    for _ in 0..SETTINGS.maximum_iterations {
        let normal = (-(b.x + a.y_axis.x * p.y + a.z_axis.x * p.z) / a.x_axis.x).max(0.0);
        let at = DVec3::new(normal, p.y, p.z);
        let slip = *a * at + b;
        let mut tangential = DVec2::new(p.y - slip.y / stiff, p.z - slip.z / stiff);
        let (length, limit) = (tangential.length(), friction * normal);
        if length > limit {
            tangential *= limit / length;
        }
        let next = DVec3::new(normal, tangential.x, tangential.y);
        let change = (next - p).abs().element_sum();
        p = next;
        if change <= SETTINGS.tolerance * (p.x.abs() + f64::MIN_POSITIVE) {
            return (p.x > 0.0).then_some(p);
        }
    }
    None
}

/// Find the normal force (N) at which the gap closes, with upper starting value `high`, by the
/// Illinois variant of regula falsi (Dowell and Jarratt, "A modified regula falsi method", BIT 11,
/// 1971).
fn bracket_slip(a: &DMat3, b: DVec3, friction: f64, mut high: f64) -> DVec3 {
    let disc = FrictionDisc::new(a);
    let mut found = DVec3::ZERO;
    let mut gap = |normal: f64| {
        found = disc.opposing_force(a, b, friction, normal);
        (a.x_axis.x * found.x + a.y_axis.x * found.y + a.z_axis.x * found.z + b.x, found)
    };
    let (mut low, mut below) = (0.0, b.x);
    let (mut above, mut p) = gap(high);
    for _ in 0..40 {
        if above >= 0.0 {
            break;
        }
        (low, below) = (high, above);
        high *= 2.0;
        (above, p) = gap(high);
    }
    let mut last = 0.0_f64;
    for _ in 0..60 {
        if above <= 1e-15 * b.x.abs() || high - low <= 1e-15 * high {
            break;
        }
        // `clamp` panics on NaN, which a corrupted snapshot may contain.
        let middle = (high - above * (high - low) / (above - below)).max(low).min(high);
        let (value, there) = gap(middle);
        if value >= 0.0 {
            (high, above, p) = (middle, value, there);
            below *= if last > 0.0 { 0.5 } else { 1.0 };
        } else {
            (low, below) = (middle, value);
            above *= if last < 0.0 { 0.5 } else { 1.0 };
        }
        last = value;
    }
    p
}

/// Principal directions and values of the tangential compliance.
struct FrictionDisc {
    rotation: DMat2,
    compliance: DVec2,
}

impl FrictionDisc {
    fn new(a: &DMat3) -> Self {
        let (turned, compliance) = principal(a.y_axis.y, a.y_axis.z, a.z_axis.z);
        Self { rotation: turned, compliance: compliance.max(DVec2::ZERO) }
    }

    /// Return the force with normal part `normal` (N) whose tangential part, |p_t| ≤ μ `normal`,
    /// opposes slip best. It minimises ½ p_tᵀ A_tt p_t + (b_t + A_tn p_n)·p_t over the disc. On
    /// the boundary p_t = -(A_tt + s)⁻¹ c, with s from Newton's method on 1/|p_t|, which
    /// converges from below (J. J. Moré, "The Levenberg-Marquardt algorithm", Lecture Notes in
    /// Mathematics 630, 1978).
    fn opposing_force(&self, a: &DMat3, b: DVec3, friction: f64, normal: f64) -> DVec3 {
        let c = self.rotation.transpose() * DVec2::new(b.y + a.x_axis.y * normal, b.z + a.x_axis.z * normal);
        let radius = friction * normal;
        let with = |shift: f64| -c / (self.compliance + DVec2::splat(shift));
        let (mut shift, mut p) = (0.0, with(0.0));
        if !p.is_finite() {
            shift = 1e-12 * c.length() / radius.max(f64::MIN_POSITIVE);
            p = with(shift);
        }
        if p.length() > radius {
            for _ in 0..40 {
                let length = p.length();
                if length <= radius * (1.0 + 1e-15) {
                    break;
                }
                let fall = (p * p / (self.compliance + DVec2::splat(shift))).element_sum() / length;
                shift += (length / radius - 1.0) * length / fall;
                p = with(shift);
            }
            p = p.clamp_length_max(radius);
        }
        let p = self.rotation * if p.is_finite() { p } else { DVec2::ZERO };
        DVec3::new(normal, p.x, p.y)
    }
}

/// Principal directions and values, the larger first, of the symmetric matrix [[a, b], [b, c]].
pub(crate) fn principal(a: f64, b: f64, c: f64) -> (DMat2, DVec2) {
    let (mean, half) = (0.5 * (a + c), 0.5 * (a - c));
    let radius = half.hypot(b);
    // The two formulas are equivalent; the one without cancellation is used.
    let first = if radius == 0.0 {
        DVec2::X
    } else if half >= 0.0 {
        DVec2::new(half + radius, b).normalize()
    } else {
        DVec2::new(b, radius - half).normalize()
    };
    (DMat2::from_cols(first, first.perp()), DVec2::new(mean + radius, mean - radius))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn compliance(m: [f64; 9]) -> DMat3 {
        let m = DMat3::from_cols_array(&m);
        m * m.transpose() + DMat3::IDENTITY * 1e-3
    }

    proptest! {
        #![proptest_config(crate::math::drawn::drawn_cases(256))]

        #[test]
        fn solution_obeys_coulombs_law(m in prop::array::uniform9(-1.0..1.0f64), b in prop::array::uniform3(-1.0..1.0f64), mu in 0.0..1.5f64) {
            let (a, b) = (compliance(m), DVec3::from(b));
            let p = solve(&a, b, ContactLaw::Coulomb(mu), DVec3::ZERO);
            let u = a * p + b;
            prop_assert!(p.x >= 0.0);
            if p.x == 0.0 {
                prop_assert!(b.x >= 0.0);
                return Ok(());
            }
            prop_assert!(u.x.abs() < 1e-9, "gap {}", u.x);
            let (force, slip) = (DVec2::new(p.y, p.z), DVec2::new(u.y, u.z));
            prop_assert!(force.length() <= mu * p.x * (1.0 + 1e-9));
            if slip.length() > 1e-8 {
                prop_assert!((force + slip.normalize() * mu * p.x).length() < 1e-6 * (1.0 + p.x), "{force} {slip}");
            }
        }
    }

    /// Force of a contact with the compliance `a` (m/N) in every direction.
    fn solve_isotropic(a: f64, b: DVec3, friction: f64) -> DVec3 {
        solve(&(DMat3::IDENTITY * a), b, ContactLaw::Coulomb(friction), DVec3::ZERO)
    }

    #[test]
    fn isotropic_contact_is_the_projection_on_the_friction_cone() {
        let (a, mu) = (2.5e-3, 0.4);
        // Uncoupled directions: p_n = [-b_n/a], p_t = -b_t/a shortened to μ p_n.
        for tangential in [DVec2::new(1.0, -2.0), DVec2::new(30.0, 40.0), DVec2::ZERO] {
            let b = DVec3::new(-10.0, tangential.x, tangential.y) * 1e-3;
            let normal = 10e-3 / a;
            let friction = (-tangential * (1e-3 / a)).clamp_length_max(mu * normal);
            let p = solve_isotropic(a, b, mu);
            assert!(p.distance(DVec3::new(normal, friction.x, friction.y)) < 1e-11 * normal, "{p}");
        }
        assert_eq!(solve_isotropic(a, DVec3::new(1e-3, 5.0, 5.0), mu), DVec3::ZERO, "open");
    }

    #[test]
    fn contact_without_mobility_along_the_normal_has_no_force() {
        let a = DMat3::from_diagonal(DVec3::new(0.0, 1.0, 1.0));
        assert_eq!(solve(&a, DVec3::NEG_X, ContactLaw::Coulomb(0.3), DVec3::ZERO), DVec3::ZERO);
    }

    #[test]
    fn coupled_slip_has_the_normal_force_of_two_linear_equations() {
        // Normal and first tangent couple with c. In slip towards ±y, p_y = ∓μ p_n, and the
        // closed gap a p_n + c p_y + b_n = 0 gives p_n = -b_n/(a ∓ μ c).
        let (a, c, mu) = (2.0, 0.8, 0.5);
        let block = DMat3::from_cols(DVec3::new(a, c, 0.0), DVec3::new(c, a, 0.0), DVec3::new(0.0, 0.0, a));
        for sign in [1.0, -1.0] {
            let p = solve(&block, DVec3::new(-1.0, 5.0 * sign, 0.0), ContactLaw::Coulomb(mu), DVec3::ZERO);
            let normal = 1.0 / (a - sign * mu * c);
            assert!(p.distance(DVec3::new(normal, -sign * mu * normal, 0.0)) < 1e-10, "{p} {normal}");
        }
    }

    #[test]
    fn bracketing_search_finds_the_solution_of_the_fixed_point_iteration() {
        let (a, c, mu) = (2.0, 0.8, 0.5);
        let block = DMat3::from_cols(DVec3::new(a, c, 0.0), DVec3::new(c, a, 0.0), DVec3::new(0.0, 0.0, a));
        let normal = 1.0 / (a - mu * c);
        let p = bracket_slip(&block, DVec3::new(-1.0, 5.0, 0.0), mu, 1.0 / a);
        assert!(p.distance(DVec3::new(normal, -mu * normal, 0.0)) < 1e-10, "{p} {normal}");
    }

    #[test]
    fn principal_values_are_the_roots_of_the_characteristic_polynomial() {
        for [a, b, c] in [[2.0, 0.0, 5.0], [2.0, 1.5, -1.0], [3.0, -2.0, 3.0], [1.0, 0.0, 1.0]] {
            let (basis, values) = principal(a, b, c);
            let (mean, radius) = (0.5 * (a + c), (0.25 * (a - c) * (a - c) + b * b).sqrt());
            assert!((values - DVec2::new(mean + radius, mean - radius)).length() < 1e-15);
            let matrix = DMat2::from_cols(DVec2::new(a, b), DVec2::new(b, c));
            for (direction, value) in [(basis.x_axis, values.x), (basis.y_axis, values.y)] {
                assert!((matrix * direction - direction * value).length() < 1e-14, "{direction} {value}");
            }
        }
    }

    #[test]
    fn attachment_holds_in_every_direction() {
        let a = compliance([0.3, 0.1, -0.2, 0.5, 0.9, 0.1, 0.0, 0.2, 0.7]);
        let b = DVec3::new(0.4, -0.2, 0.1);
        assert!((a * solve(&a, b, ContactLaw::Attachment, DVec3::ZERO) + b).length() < 1e-14);
    }
}
