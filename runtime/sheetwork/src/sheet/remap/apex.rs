//! A mass that three springs hold over a triangle: where it is by their lengths, and how it moves by their rates.
//!
//! With corners cᵢ and squared lengths ℓᵢ² the mass is in the plane of the triangle where 2 p·(cⱼ - cᵢ) = ℓᵢ² - ℓⱼ² + |cⱼ|² - |cᵢ|², and over it by
//! δ² = ℓ₁² - |p - c₁|². It moves as wᵢ·x' = ½ (ℓᵢ²)' + wᵢ·cᵢ' says, wᵢ = x - cᵢ. Lengths m, rates per second.

use glam::{DMat3, DVec3};

/// Part of a cube of the triangle's side below which three springs lie in a plane and tell nothing of a motion.
const FLAT: f64 = 1e-9;

/// Where a mass is over the upper side of `corners` (m), `n` its unit normal, with springs of these squared lengths (m²).
pub(crate) fn place(corners: [DVec3; 3], n: DVec3, squares: [f64; 3]) -> DVec3 {
    let [c, along, across] = [corners[0], corners[1] - corners[0], corners[2] - corners[0]];
    let right = |e: DVec3, square: f64| 0.5 * (squares[0] - square + e.length_squared());
    let (p, q) = (right(along, squares[1]), right(across, squares[2]));
    let (aa, ab, bb) = (along.length_squared(), along.dot(across), across.length_squared());
    let size = aa * bb - ab * ab;
    let flat =
        if size > 0.0 { along * ((p * bb - q * ab) / size) + across * ((q * aa - p * ab) / size) } else { DVec3::ZERO };
    c + flat + n * (squares[0] - flat.length_squared()).max(0.0).sqrt()
}

/// How fast a mass at `x` over `corners` (m) moves, which move at `moving` (m/s), where half its springs' squares change at `rates` (m²/s); as the
/// corners do in the mean where springs lie flat.
pub(crate) fn velocity(x: DVec3, corners: [DVec3; 3], moving: [DVec3; 3], rates: [f64; 3]) -> DVec3 {
    let w = corners.map(|c| x - c);
    let right: [f64; 3] = std::array::from_fn(|i| rates[i] + w[i].dot(moving[i]));
    let matrix = DMat3::from_cols(w[0], w[1], w[2]).transpose();
    let side = (corners[1] - corners[0]).length();
    if matrix.determinant().abs() > FLAT * side * side * side {
        matrix.inverse() * DVec3::from_array(right)
    } else {
        (moving[0] + moving[1] + moving[2]) / 3.0
    }
}
