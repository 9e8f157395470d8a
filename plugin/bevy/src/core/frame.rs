//! Frame of a sheet: the pose of its entity, which follows the sheet.
//!
//! With the nodes' masses m, material coordinates (u, v) and positions x, their means ū, v̄ and x̄,
//!
//!   a = Σ m (u - ū) (x - x̄), b = Σ m (v - v̄) (x - x̄)
//!
//! are the mean directions of length and width. The axes of the frame are the orthonormal pair next
//! to a/|a| and b/|b|, which turn by equal angles, and its origin is x̄. The entity has the pose that
//! it had when the sheet was built, carried along rigidly.

use bevy::math::{DMat3, DQuat, DVec3};
use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;
use sheetwork::sheet::Sheet as SheetInWorld;

use super::placement::{self, Pose};
use super::{SheetMotion, SheetWorld};

/// Sine of the angle between length and width below which a sheet has no axes: rolled up or folded
/// onto a line.
const LEAST_SINE: f64 = 1e-3;
/// Difference in place (m) and angle (rad) below which a transform is not written.
const SAME: f32 = 1e-6;

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

/// Difference between two rotations, half an angle in rad if it is small. A rotation has two
/// quaternions.
fn turned(a: Quat, b: Quat) -> f32 {
    (a - b).length().min((a + b).length())
}

/// Write the transforms of the sheets at the displayed time.
pub(super) fn show_sheets(
    world: Res<SheetWorld>,
    mut sheets: Query<(Entity, &mut SheetMotion, Option<&ChildOf>)>,
    mut transforms: ParamSet<(TransformHelper, Query<&mut Transform>)>,
) {
    for (entity, mut motion, parent) in &mut sheets {
        let Some(pose) = motion.pose_at(world.shown_time()).filter(|_| motion.generation == world.generation()) else {
            continue;
        };
        let shown = GlobalTransform::from(placement::transform_of(pose));
        let parent = parent.and_then(|p| transforms.p0().compute_global_transform(p.parent()).ok());
        let local = parent.map_or_else(|| shown.compute_transform(), |p| shown.reparented_to(&p));
        // A transform that was written since the last tick is a teleport, which the next one does.
        let written = |transform: &Transform| motion.given.is_some_and(|given| given != *transform);
        if let Ok(mut transform) = transforms.p1().get_mut(entity)
            && !written(&transform)
        {
            let moved = transform.translation.distance(local.translation) > SAME
                || turned(transform.rotation, local.rotation) > SAME;
            if moved {
                (transform.translation, transform.rotation) = (local.translation, local.rotation);
                // Not a change of the sheet for its observers.
                motion.bypass_change_detection().given = Some(*transform);
            }
        }
    }
}
