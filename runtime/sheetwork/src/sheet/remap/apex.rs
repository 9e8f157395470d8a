//! Apex of three springs over a triangle: position from their lengths, velocity from their rates.
//!
//! With corners cᵢ and squared lengths ℓᵢ², the projection p of the apex onto the plane of the
//! triangle satisfies 2 p·(cⱼ - cᵢ) = ℓᵢ² - ℓⱼ² + |cⱼ|² - |cᵢ|², and its height is δ² = ℓ₁² - |p -
//! c₁|². Its velocity x' satisfies wᵢ·x' = ½ (ℓᵢ²)' + wᵢ·cᵢ' with wᵢ = x - cᵢ. Lengths in m, rates
//! per second.

use glam::{DMat3, DVec3};

/// Minimum determinant, relative to the cube of the triangle's side, at which the three springs
/// determine a velocity.
const MIN_RELATIVE_DETERMINANT: f64 = 1e-9;

/// Position of the apex over the upper side of `corners` (m), with their unit normal `n` and
/// squared spring lengths `squares` (m²).
pub(crate) fn apex_position(corners: [DVec3; 3], n: DVec3, squares: [f64; 3]) -> DVec3 {
    let [c, along, across] = [corners[0], corners[1] - corners[0], corners[2] - corners[0]];
    let right = |e: DVec3, square: f64| 0.5 * (squares[0] - square + e.length_squared());
    let (p, q) = (right(along, squares[1]), right(across, squares[2]));
    let (aa, ab, bb) = (along.length_squared(), along.dot(across), across.length_squared());
    let size = aa * bb - ab * ab;
    let flat =
        if size > 0.0 { along * ((p * bb - q * ab) / size) + across * ((q * aa - p * ab) / size) } else { DVec3::ZERO };
    c + flat + n * (squares[0] - flat.length_squared()).max(0.0).sqrt()
}

/// Velocity (m/s) of the apex at `x` over `corners` (m) with the velocities `moving` (m/s), where
/// `rates` are half the rates of the squared spring lengths (m²/s). For springs in a plane it is
/// the mean velocity of the corners.
pub(crate) fn apex_velocity(x: DVec3, corners: [DVec3; 3], moving: [DVec3; 3], rates: [f64; 3]) -> DVec3 {
    let w = corners.map(|c| x - c);
    let right: [f64; 3] = std::array::from_fn(|i| rates[i] + w[i].dot(moving[i]));
    let matrix = DMat3::from_cols(w[0], w[1], w[2]).transpose();
    let side = (corners[1] - corners[0]).length();
    if matrix.determinant().abs() > MIN_RELATIVE_DETERMINANT * side * side * side {
        matrix.inverse() * DVec3::from_array(right)
    } else {
        (moving[0] + moving[1] + moving[2]) / 3.0
    }
}
