//! Links of entities to objects that a return to a checkpoint has removed.

use bevy::prelude::*;

use super::{BodyMotion, HeaterHandle, SheetMotion, SheetWorld};

/// Discard the links of entities whose sheet or body is gone after a return to a checkpoint.
pub(super) fn discard_stale(
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    sheets: Query<(Entity, &SheetMotion)>,
    bodies: Query<(Entity, &BodyMotion)>,
    heaters: Query<(Entity, &HeaterHandle)>,
) {
    if !world.is_rewound {
        return;
    }
    world.bypass_change_detection().is_rewound = false;
    for (entity, motion) in &sheets {
        if world.get_sheet(motion.id()).is_none() {
            commands.entity(entity).try_remove::<SheetMotion>();
        }
    }
    for (entity, motion) in &bodies {
        if motion.ids.iter().any(|id| world.body_name(*id).is_none()) {
            commands.entity(entity).try_remove::<BodyMotion>();
        }
    }
    for (entity, _) in heaters.iter().filter(|(_, heater)| !heater.is_in(&world)) {
        commands.entity(entity).try_remove::<HeaterHandle>();
    }
}
