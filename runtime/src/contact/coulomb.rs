//! Friction at one contact, exactly as Coulomb has it.
//!
//! In the frame (normal, two tangents) of a contact, the others held: u = A p + b with u the gap or the relative velocity
//! (m or m/s), p the force, A the 3x3 block of compliance of this contact. Wanted is p with
//!
//!   0 ≤ u_n ⊥ p_n ≥ 0,  |p_t| ≤ μ p_n,  and p_t = -μ p_n u_t/|u_t| where it slides.
//!
//! Three cases in turn: open (b_n ≥ 0), stuck (A p = -b lies in the cone), sliding. Sliding is found by a fixed-point iteration, and
//! where that goes round in circles (large μ, normal and tangential compliance strongly coupled) by bisection on p_n: for a
//! given p_n the tangential force is the minimum of a convex quadratic over a disc, and the gap that leaves changes sign once.
//! (De Saxcé and Feng, "The bipotential method", Math. Comput. Modelling 28, 1998, on why this is no minimum as a whole;
//! Cadoux, PhD thesis, Grenoble 2009, and Acary, Brémond, Huber, "On solving contact problems with Coulomb friction",
//! 2018, on Gauss-Seidel sweeps over such blocks.)

use glam::{DMat2, DMat3, DVec2, DVec3};

/// What a contact can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// Push, and rub with this coefficient.
    Coulomb(f64),
    /// Hold in every direction, as glue does.
    Glue,
}

/// Rounds of the fixed-point iteration.
const ROUNDS: u32 = 40;
/// Its accuracy, as a fraction of the force.
const CLOSE: f64 = 1e-12;

/// The force p for u = A p + b under `law`; `before` is what it was, a guess.
pub fn solve(a: &DMat3, b: DVec3, law: Law, before: DVec3) -> DVec3 {
    if a.x_axis.x <= 0.0 {
        // Nothing gives way: no force helps.
        return DVec3::ZERO;
    }
    let Law::Coulomb(friction) = law else { return stuck(a, b).unwrap_or(before) };
    if b.x >= 0.0 {
        return DVec3::ZERO;
    }
    let frictionless = DVec3::new(-b.x / a.x_axis.x, 0.0, 0.0);
    if friction == 0.0 {
        return frictionless;
    }
    if let Some(p) = stuck(a, b) {
        let tangential = p.y * p.y + p.z * p.z;
        if p.x > 0.0 && tangential <= friction * friction * p.x * p.x * (1.0 + 1e-12) {
            return p;
        }
    }
    sliding(a, b, friction, before, frictionless.x).unwrap_or_else(|| bisect(a, b, friction, frictionless.x))
}

fn stuck(a: &DMat3, b: DVec3) -> Option<DVec3> {
    // Near-singular blocks (a contact in line with what holds it) leave this to the other cases.
    let scale = a.x_axis.x.max(a.y_axis.y).max(a.z_axis.z);
    let determinant = a.determinant();
    (determinant > 1e-14 * scale * scale * scale).then(|| {
        let p = a.inverse() * -b;
        // One step of refinement: what sticks must not creep by rounding.
        p - a.inverse() * (*a * p + b)
    })
}

fn sliding(a: &DMat3, b: DVec3, friction: f64, before: DVec3, frictionless: f64) -> Option<DVec3> {
    let mut p = DVec3::new(before.x.max(1e-3 * frictionless), before.y, before.z);
    let stiff = a.y_axis.y.max(a.z_axis.z);
    for _ in 0..ROUNDS {
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
        if change <= CLOSE * (p.x.abs() + f64::MIN_POSITIVE) {
            return (p.x > 0.0).then_some(p);
        }
    }
    None
}

/// The normal force at which the gap closes, by bisection; `high` is where the search begins.
fn bisect(a: &DMat3, b: DVec3, friction: f64, mut high: f64) -> DVec3 {
    let mut low = 0.0;
    let gap = |p: DVec3| a.x_axis.x * p.x + a.y_axis.x * p.y + a.z_axis.x * p.z + b.x;
    for _ in 0..40 {
        if gap(rubbing(a, b, friction, high)) >= 0.0 {
            break;
        }
        high *= 2.0;
    }
    for _ in 0..48 {
        let middle = 0.5 * (low + high);
        if gap(rubbing(a, b, friction, middle)) >= 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    rubbing(a, b, friction, high)
}

/// For normal force `normal`, the p_t of |p_t| ≤ μ `normal` that does the most against sliding: the minimum of
/// ½ p_tᵀ A_tt p_t + (b_t + A_tn p_n)·p_t over the disc.
fn rubbing(a: &DMat3, b: DVec3, friction: f64, normal: f64) -> DVec3 {
    let c = DVec2::new(b.y + a.x_axis.y * normal, b.z + a.x_axis.z * normal);
    let radius = friction * normal;
    let tt = DMat2::from_cols(DVec2::new(a.y_axis.y, a.y_axis.z), DVec2::new(a.z_axis.y, a.z_axis.z));
    let with = |shift: f64| {
        let m = tt + DMat2::from_diagonal(DVec2::splat(shift));
        -(m.inverse() * c)
    };
    let mut p = with(0.0);
    if p.length() > radius || !p.is_finite() {
        // |p| falls as the shift grows, and is at most the radius at |c|/radius.
        let (mut low, mut high) = (0.0, c.length() / radius.max(f64::MIN_POSITIVE));
        for _ in 0..48 {
            let middle = 0.5 * (low + high);
            if with(middle).length() > radius {
                low = middle;
            } else {
                high = middle;
            }
        }
        p = with(high).clamp_length_max(radius);
    }
    DVec3::new(normal, p.x, p.y)
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
        #[test]
        fn what_it_finds_is_coulombs_law(m in prop::array::uniform9(-1.0..1.0f64), b in prop::array::uniform3(-1.0..1.0f64), mu in 0.0..1.5f64) {
            let (a, b) = (compliance(m), DVec3::from(b));
            let p = solve(&a, b, Law::Coulomb(mu), DVec3::ZERO);
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

    #[test]
    fn glue_holds_whatever_pulls() {
        let a = compliance([0.3, 0.1, -0.2, 0.5, 0.9, 0.1, 0.0, 0.2, 0.7]);
        let b = DVec3::new(0.4, -0.2, 0.1);
        assert!((a * solve(&a, b, Law::Glue, DVec3::ZERO) + b).length() < 1e-14);
    }
}
