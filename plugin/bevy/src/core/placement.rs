//! Conversion between Bevy's transforms and the placements of the world.

use bevy::math::{DQuat, DVec3, EulerRot};
use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;
use sheetwork::scene::Placement;

/// Position (m) and rotation.
pub(crate) type Pose = (DVec3, DQuat);

/// Position and rotation of a transform, without its scale.
pub(crate) fn pose_of(transform: &GlobalTransform) -> Pose {
    let (_, rotation, translation) = transform.to_scale_rotation_translation();
    (translation.as_dvec3(), rotation.as_dquat().normalize())
}

/// Placement with this pose.
pub(crate) fn placement_of((position, rotation): Pose) -> Placement {
    let (z, y, x) = rotation.to_euler(EulerRot::ZYX);
    Placement { position, rotation: DVec3::new(x, y, z) * (180.0 / std::f64::consts::PI) }
}

/// Pose `inner`, given relative to `outer`, in the frame of `outer`.
pub(crate) fn compose(outer: Pose, inner: Pose) -> Pose {
    (outer.0 + outer.1 * inner.0, outer.1 * inner.1)
}

/// Transform with this pose.
pub(crate) fn transform_of((position, rotation): Pose) -> Transform {
    Transform { translation: position.as_vec3(), rotation: rotation.as_quat(), scale: Vec3::ONE }
}

/// Pose of a placement.
pub(crate) fn pose_of_placement(placement: &Placement) -> Pose {
    (placement.position, placement.quaternion())
}

/// Displacement and rotation, about the origin, that lead from one pose to another.
pub(crate) fn motion_between(from: Pose, to: Pose) -> Pose {
    let turn = if from.1 == to.1 { DQuat::IDENTITY } else { (to.1 * from.1.conjugate()).normalize() };
    (to.0 - turn * from.0, turn)
}

/// Global transform of the parent of an entity; the identity without one.
pub(super) fn parent_transform(parent: Option<&ChildOf>, transforms: &TransformHelper) -> GlobalTransform {
    let above = parent.and_then(|parent| transforms.compute_global_transform(parent.parent()).ok());
    above.unwrap_or_default()
}

/// Whether a pose is the identity.
pub(crate) fn is_identity((position, rotation): Pose) -> bool {
    position == DVec3::ZERO && rotation == DQuat::IDENTITY
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transform_becomes_the_same_placement() {
        let there = Transform::from_xyz(1.0, -2.0, 0.5).with_rotation(Quat::from_euler(EulerRot::XYZ, 0.3, -1.2, 2.0));
        let placement = placement_of(pose_of(&GlobalTransform::from(there)));
        let p = Vec3::new(0.3, 0.7, -0.2);
        let (ours, theirs) = (placement.apply(p.as_dvec3()).as_vec3(), there.transform_point(p));
        assert!(ours.distance(theirs) < 1e-6, "{ours} {theirs}");
    }
}
