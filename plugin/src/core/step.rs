//! Time passes, and what became of the sheets and bodies is written to their entities.

use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;

use super::motion::Pose;
use super::{BodyMotion, SheetClock, SheetMotion, SheetState, SheetWorld, placement};

/// Whether the plugin steps by itself.
pub(super) fn owns_bodies(world: Res<SheetWorld>) -> bool {
    !world.borrows_bodies()
}

/// Advances the sheets by what is due in this tick.
pub(super) fn advance(mut world: ResMut<SheetWorld>, clock: Res<SheetClock>) {
    world.advance(clock.due());
}

/// Brings positions and state of every sheet to its entity.
pub(super) fn write_sheets(world: Res<SheetWorld>, mut sheets: Query<(&mut SheetMotion, &mut SheetState)>) {
    for (mut motion, mut state) in &mut sheets {
        if let Some(sheet) = world.sheet(motion.name()) {
            // What stands still is not marked as changed.
            if motion.is_moving() || *motion.after() != sheet.x {
                motion.push(&sheet.x);
            }
            state.set_if_neq(SheetState::of(sheet));
        }
    }
}

/// Notes where the bodies are that follow a path.
pub(super) fn write_bodies(world: Res<SheetWorld>, mut bodies: Query<&mut BodyMotion>) {
    let Some(rigid) = world.rigid() else { return };
    for mut motion in bodies.iter_mut().filter(|m| m.led) {
        let index = rigid.bodies().iter().position(|b| b.name == motion.name());
        if let Some(pose) = index.and_then(|i| rigid.pose(i)) {
            motion.before = motion.after;
            motion.after = pose;
        }
    }
}

/// Shows the bodies that follow a path between their last two places.
pub(super) fn show_led_bodies(
    fixed: Res<Time<Fixed>>,
    bodies: Query<(Entity, &BodyMotion, Option<&ChildOf>)>,
    mut transforms: ParamSet<(TransformHelper, Query<&mut Transform>)>,
) {
    let s = fixed.overstep_fraction_f64().clamp(0.0, 1.0);
    for (entity, motion, parent) in bodies.iter().filter(|(_, m, _)| m.led) {
        let pose: Pose = placement::between(motion.before, motion.after, s);
        let shown = GlobalTransform::from(placement::transform_of(pose));
        let parent = parent.and_then(|p| transforms.p0().compute_global_transform(p.parent()).ok());
        let local = parent.map_or_else(|| shown.compute_transform(), |p| shown.reparented_to(&p));
        if let Ok(mut transform) = transforms.p1().get_mut(entity) {
            let (translation, rotation) = (local.translation, local.rotation);
            if transform.translation != translation || transform.rotation != rotation {
                transform.translation = translation;
                transform.rotation = rotation;
            }
        }
    }
}
