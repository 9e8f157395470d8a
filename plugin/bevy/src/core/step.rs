//! Advance of the world, and transfer of positions and states to the entities.

use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;

use super::{BodyMotion, SheetClock, SheetMotion, SheetState, SheetWorld, placement};

/// Whether the plugin itself steps the world.
pub(super) fn owns_bodies(world: Res<SheetWorld>) -> bool {
    !world.borrows_bodies()
}

/// Advance the world by the duration of this tick.
pub(super) fn advance(mut world: ResMut<SheetWorld>, clock: Res<SheetClock>) {
    world.advance(clock.due());
}

/// Begin the steps of this tick on another thread.
pub(super) fn begin(mut world: ResMut<SheetWorld>, clock: Res<SheetClock>) {
    world.begin_advance(clock.due());
}

/// Wait for the steps of the last tick.
pub(super) fn finish(mut world: ResMut<SheetWorld>) {
    world.finish_advance();
}

/// Write positions and state of every sheet to its entity.
pub(super) fn write_sheets(world: Res<SheetWorld>, mut sheets: Query<(&mut SheetMotion, &mut SheetState)>) {
    for (mut motion, mut state) in &mut sheets {
        let Some(sheet) = motion.sheet(&world) else { continue };
        // A resting sheet is not marked as changed.
        if motion.bypass_change_detection().record_sheet(world.time(), sheet) {
            motion.set_changed();
        }
        state.set_if_neq(SheetState::from_sheet(sheet));
    }
}

/// Store the poses of dynamic bodies on their entities.
pub(super) fn write_bodies(world: Res<SheetWorld>, mut bodies: Query<&mut BodyMotion>) {
    let Some(rigid) = world.rigid() else { return };
    for mut motion in &mut bodies {
        // The stored poses are not a change of the component for its observers.
        let motion = motion.bypass_change_detection();
        if motion.history.is_none() || motion.generation != world.generation() {
            continue;
        }
        let pose = rigid.index_of(motion.name()).and_then(|index| rigid.pose(index));
        if let (Some(pose), Some(history)) = (pose, &mut motion.history) {
            history.record(world.time(), pose);
        }
    }
}

/// Advance the displayed time to this frame.
pub(super) fn show(mut world: ResMut<SheetWorld>, clock: Res<SheetClock>, fixed: Res<Time<Fixed>>) {
    let tick = fixed.timestep().as_secs_f64() * clock.rate();
    let fraction = (tick > 0.0).then(|| fixed.overstep_fraction_f64().clamp(0.0, 1.0));
    // The displayed time is not a change of the world.
    world.bypass_change_detection().show(tick, fraction);
}

/// Write the transforms of bodies on paths and of dynamic bodies at the displayed time.
pub(super) fn show_bodies(
    world: Res<SheetWorld>,
    bodies: Query<(Entity, &BodyMotion, Option<&ChildOf>)>,
    mut transforms: ParamSet<(TransformHelper, Query<&mut Transform>)>,
) {
    for (entity, motion, parent) in bodies.iter().filter(|(_, m, _)| m.writes_transform()) {
        let shown = GlobalTransform::from(placement::transform_of(motion.at(world.shown_time())));
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
