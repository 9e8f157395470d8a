//! Frame of a sheet: the pose of its entity, which follows the sheet.
//!
//! With the masses m of the nodes, their material coordinates (u, v) and positions x, and the means
//! ū, v̄ and x̄ of these,
//!
//!   a = Σ m (u - ū) (x - x̄), b = Σ m (v - v̄) (x - x̄)
//!
//! are the mean directions of length and width. The axes of the frame are the orthonormal pair next
//! to a/|a| and b/|b|, which turn by equal angles, and its origin is x̄. The entity has the pose
//! that it had when the sheet was built, carried along rigidly.

use bevy::math::{DMat3, DQuat, DVec3};
use sheetwork::sheet::Sheet as SheetInWorld;

use super::placement::Pose;

/// Sine of the angle between length and width below which a sheet has no axes: rolled up or folded
/// onto a line.
const LEAST_SINE: f64 = 1e-3;

/// Frame of a sheet; `None` for one without axes.
pub(super) fn frame_of(sheet: &SheetInWorld) -> Option<Pose> {
    let (mass, centre) = (sheet.total_mass(), sheet.centre_of_mass());
    let each = || sheet.model.uv.iter().enumerate().map(|(i, uv)| (sheet.node_mass(i), *uv, sheet.state.x.get(i)));
    let mean = each().fold((0.0, 0.0), |sum, (m, (u, v), _)| (sum.0 + m * u / mass, sum.1 + m * v / mass));
    let zero = (DVec3::ZERO, DVec3::ZERO);
    let (a, b) = each().fold(zero, |(a, b), (m, (u, v), x)| {
        let from_centre = (x - centre) * m;
        (a + from_centre * (u - mean.0), b + from_centre * (v - mean.1))
    });
    let (a, b) = (a.try_normalize()?, b.try_normalize()?);
    if a.cross(b).length() < LEAST_SINE {
        return None;
    }
    let (sum, difference) = ((a + b).normalize(), (a - b).normalize());
    let x = (sum + difference) * std::f64::consts::FRAC_1_SQRT_2;
    let z = (sum - difference) * std::f64::consts::FRAC_1_SQRT_2;
    Some((centre, DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z))))
}

/// Pose that, composed behind `frame`, is `pose`.
pub(super) fn relative(frame: Pose, pose: Pose) -> Pose {
    let back = frame.1.conjugate();
    (back * (pose.0 - frame.0), back * pose.1)
}
