//! Entities with Bevy's `Disabled`: their sheets are suspended with their state, and what else they
//! have in the world is removed until they are enabled.

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::prelude::*;

use super::joints::JointLink;
use super::motion::Attached;
use super::{BodyMotion, HeaterHandle, Sheet, SheetHeatGun, SheetMotion, SheetWorld};

/// Links of an entity to the world. A body or heater loses its link and is added again when its
/// entity is enabled.
type Links<'a> = (Option<&'a BodyMotion>, Option<&'a HeaterHandle>, Option<&'a JointLink>, Option<&'a SheetHeatGun>);

/// Take the objects of a disabled entity out of the simulation.
pub(super) fn disabled(
    added: On<Add, Disabled>,
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    sheets: Query<&SheetMotion, Allow<Disabled>>,
    others: Query<Links, Allow<Disabled>>,
) {
    let entity = added.entity;
    if let Ok(motion) = sheets.get(entity)
        && motion.generation == world.generation()
    {
        world.suspend_sheet(motion.id());
    }
    let Ok((body, heater, joint, gun)) = others.get(entity) else { return };
    if let Some(body) = body {
        super::sync::remove_body(&mut world, Some(body));
        commands.entity(entity).try_remove::<BodyMotion>();
    }
    if let Some(heater) = heater {
        heater.remove_from(&mut world);
        commands.entity(entity).try_remove::<HeaterHandle>();
    }
    if let Some(joint) = joint {
        joint.remove_from(&mut world);
        commands.entity(entity).try_remove::<JointLink>();
    }
    if gun.is_some() {
        // The removal of a heat gun cannot fail.
        let _ = world.set_heat_gun(None);
    }
}

/// Put the sheet of an enabled entity back. Changes of its components in between count from now on.
pub(super) fn enabled(
    removed: On<Remove, Disabled>,
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    mut sheets: Query<(&mut Sheet, &mut SheetMotion, &mut Transform), Allow<Disabled>>,
) {
    let Ok((mut sheet, mut motion, mut transform)) = sheets.get_mut(removed.entity) else { return };
    if motion.generation != world.generation() {
        return;
    }
    if !world.resume_sheet(motion.id()) {
        // A return to a checkpoint has removed it: it is built again.
        commands.entity(removed.entity).try_remove::<SheetMotion>();
        return;
    }
    if let Some(resumed) = world.get_sheet(motion.id()) {
        motion.rejoin(world.time(), resumed);
    }
    if motion.built_from != *sheet {
        sheet.set_changed();
    }
    if motion.given.is_some_and(|given| given != *transform) {
        transform.set_changed();
    }
    if world.borrows_bodies() {
        // The attachments to the caller's bodies have ended and are made again.
        motion.attached = Attached::default();
    }
}
