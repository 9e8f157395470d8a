//! Motion of the parents of sheets, which leads their pins.

use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;

use super::motion::LastParent;
use super::placement::parent_transform;
use super::{SheetClock, SheetMotion, SheetWorld, placement};

/// Relative change of a parent's scale that counts as one: above the rounding of `f32` in the
/// products of transforms, from which the scale is read.
const SCALE_TOLERANCE: f32 = 1e-5;

/// Lead the pins of sheets whose parent has moved since the last tick; while time is paused, the
/// whole sheet moves. A written transform of the sheet itself takes precedence.
pub(super) fn lead(
    mut world: ResMut<SheetWorld>,
    clock: Res<SheetClock>,
    mut sheets: Query<(Entity, &Transform, Option<&ChildOf>, &mut SheetMotion)>,
    transforms: TransformHelper,
) {
    for (entity, transform, parent, mut motion) in &mut sheets {
        let now = LastParent::new(parent, parent_transform(parent, &transforms));
        let is_written = motion.given.is_some_and(|given| given != *transform);
        let is_current = motion.generation == world.generation();
        // Not a change of the sheet for its observers.
        let motion = motion.bypass_change_detection();
        let Some(last) = motion.parent.replace(now) else { continue };
        motion.parent.iter_mut().for_each(|parent| parent.is_told = last.is_told);
        if last.transform == now.transform || last.entity != now.entity || is_written || !is_current {
            continue;
        }
        let scale = (now.transform.scale() - last.transform.scale()).abs().max_element();
        if scale > SCALE_TOLERANCE * last.transform.scale().abs().max_element() && !last.is_told {
            motion.parent.iter_mut().for_each(|parent| parent.is_told = true);
            error!("the scale of the parent of {entity} has changed: sheet {} keeps its size", motion.name());
        }
        let (from, to) = (placement::pose_of(&last.transform), placement::pose_of(&now.transform));
        if from == to {
            continue;
        }
        if clock.due() > 0.0 {
            world.lead_later(entity, motion.id(), from, to);
        } else if !motion.built_from.spec.pins.is_empty() {
            move_with_parent(&mut world, motion, (from, to));
        }
    }
}

/// Move a pinned sheet at once with its parent.
fn move_with_parent(world: &mut SheetWorld, motion: &mut SheetMotion, (from, to): (placement::Pose, placement::Pose)) {
    let (by, turn) = placement::motion_between(from, to);
    match world.move_sheet(motion.id(), by, turn) {
        Ok(()) => world.get_sheet(motion.id()).into_iter().for_each(|sheet| motion.jump(sheet)),
        Err(problem) => error!("sheet {} does not follow its parent: {problem}", motion.name()),
    }
}
