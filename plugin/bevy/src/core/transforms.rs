//! Transforms of the entities of sheets, written from the frames of the sheets.

use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;

use super::{SheetMotion, SheetWorld, placement};

/// Difference in place (m) and angle (rad) below which a transform is not written.
const SAME: f32 = 1e-6;

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
