//! Attachment of sheets to bodies by entity: to bodies of the plugin, and to those of a caller's
//! Rapier world that carry their entity in the user data, as bevy_rapier3d's do.

use bevy::prelude::*;
use sheetwork::InputError;
use sheetwork::scene::Region;

use super::motion::Attached;
use super::{BodyMotion, SheetMotion, SheetWorld};

/// Parts of a sheet that are attached to bodies, where they are. Add it to the entity of a
/// [`Sheet`](super::Sheet), change it or remove it at any time: new entries are attached from the
/// next tick on, or as soon as the entity has a body, and entries that are gone let go.
///
/// A kinematic or static body leads the nodes. A dynamic one is moved by the sheet; one of the
/// caller's Rapier world only if the view is
/// [`pushing`](sheetwork::RigidView::pushing). A row of nodes is a hinge; two rows hold the slope.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct SheetAttachments(pub Vec<(Region, Entity)>);

impl SheetAttachments {
    /// Attachment of one region to the body of `entity`.
    pub fn new(region: Region, entity: Entity) -> Self {
        Self(vec![(region, entity)])
    }

    /// A further attachment.
    #[must_use]
    pub fn and(mut self, region: Region, entity: Entity) -> Self {
        self.0.push((region, entity));
        self
    }
}

/// Give changed attachments to the world.
pub(super) fn sync(
    mut world: ResMut<SheetWorld>,
    mut sheets: Query<(Entity, &mut SheetMotion, &SheetAttachments)>,
    bodies: Query<&BodyMotion>,
) {
    for (entity, mut motion, wanted) in &mut sheets {
        let present = &motion.attached.list;
        if *present == wanted.0 || motion.sheet(&world).is_none() {
            continue;
        }
        let (mut list, mut waits) = (present.clone(), Vec::new());
        for gone in present.iter().filter(|old| !wanted.0.contains(old)) {
            list.retain(|kept| kept != gone);
            report(entity, world.unpin(motion.id(), &gone.0));
        }
        for new in wanted.0.iter().filter(|new| !present.contains(new)) {
            let body = bodies.get(new.1).ok().filter(|body| body.generation == world.generation());
            match body.and_then(|body| body.ids.first().copied()) {
                Some(body) => report(entity, world.attach(motion.id(), &new.0, body)),
                None if world.borrows_bodies() => world.attach_later(motion.id(), new.clone()),
                None => {
                    let is_told = motion.attached.waits.contains(&new.1);
                    if !is_told {
                        warn!("sheet {entity} is attached to {} as soon as that has a body", new.1);
                    }
                    waits.push(new.1);
                    continue;
                }
            }
            list.push(new.clone());
        }
        // Not a change of the sheet for its observers.
        motion.bypass_change_detection().attached = Attached { list, waits };
    }
}

/// Let go of the attachments of a removed component.
pub(super) fn removed(
    removed: On<Remove, SheetAttachments>,
    mut world: ResMut<SheetWorld>,
    mut sheets: Query<&mut SheetMotion>,
) {
    let Ok(mut motion) = sheets.get_mut(removed.entity) else { return };
    let attached = std::mem::take(&mut motion.bypass_change_detection().attached);
    if motion.sheet(&world).is_some() {
        attached.list.iter().for_each(|(region, _)| report(removed.entity, world.unpin(motion.id(), region)));
    }
}

fn report(entity: Entity, result: Result<usize, InputError>) {
    if let Err(problem) = result {
        error!("attachments of {entity}: {problem}");
    }
}
