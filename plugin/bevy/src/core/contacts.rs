//! Contacts of sheets, for sounds, hits and damage: messages when a contact begins, ends or is
//! hard, and the present pairs on entities with [`SheetContacts`].

use bevy::ecs::entity::Entities;
use bevy::prelude::*;
use sheetwork::{ContactEventKind, ContactPair, ContactPartner, SheetId};

use super::{BodyMotion, SheetMotion, SheetWorld};

/// Records the contacts of a sheet. Add it to the entity of a [`Sheet`](super::Sheet): from the
/// next tick on [`SheetContact`] messages are sent for it, and `pairs` lists what it touches.
///
/// Two sheets that touch make one pair; it is sent and listed if one of them has the component.
#[derive(Component, Clone, Debug)]
pub struct SheetContacts {
    /// Force above which [`ContactEventKind::ForceExceeded`] is sent, N; infinite for none. At
    /// least 0.
    pub threshold: f32,
    /// Pairs in contact after the last tick.
    pub pairs: Vec<SheetContactPair>,
    /// Sheet, generation of the world, and bits of the threshold that were last passed on.
    recorded: Option<(SheetId, u32, u32)>,
}

impl Default for SheetContacts {
    fn default() -> Self {
        Self::above(f32::INFINITY)
    }
}

impl SheetContacts {
    /// Records with a threshold of `force` (N).
    pub fn above(force: f32) -> Self {
        Self { threshold: force, pairs: Vec::new(), recorded: None }
    }
}

/// A sheet and an object that it touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetContactPair {
    /// The pair in the world, with place, normal, impulse, force and speeds in SI units.
    pub pair: ContactPair,
    /// Entity of the sheet, while it exists.
    pub sheet: Option<Entity>,
    /// Entity of the partner, while it exists: a body or another sheet, or the sheet itself. For a
    /// body of the caller's Rapier world it is the entity in the user data of its collider, where
    /// bevy_rapier3d keeps it.
    pub partner: Option<Entity>,
}

/// Message of a contact that begins, exceeds the threshold of force, or ends.
#[derive(Message, Clone, Copy, Debug, PartialEq)]
pub struct SheetContact {
    /// Kind of the event.
    pub kind: ContactEventKind,
    /// Simulated time, s.
    pub time: f64,
    /// The two objects, and their contact then.
    pub contact: SheetContactPair,
}

/// Entities of the objects of pairs.
#[derive(bevy::ecs::system::SystemParam)]
pub(super) struct Partners<'w, 's> {
    sheets: Query<'w, 's, (Entity, &'static SheetMotion)>,
    bodies: Query<'w, 's, (Entity, &'static BodyMotion)>,
    entities: &'w Entities,
}

impl Partners<'_, '_> {
    fn sheet(&self, id: SheetId) -> Option<Entity> {
        self.sheets.iter().find(|(_, motion)| motion.id() == id).map(|(entity, _)| entity)
    }

    fn pair(&self, pair: &ContactPair) -> SheetContactPair {
        let sheet = self.sheet(pair.sheet);
        let partner = match pair.partner {
            ContactPartner::Itself => sheet,
            ContactPartner::Sheet(id) => self.sheet(id),
            ContactPartner::Body(id) => {
                self.bodies.iter().find(|(_, motion)| motion.ids.contains(&id)).map(|(entity, _)| entity)
            }
            ContactPartner::Collider { user_data, .. } => lent_entity(user_data, self.entities),
            _ => None,
        };
        SheetContactPair { pair: *pair, sheet, partner }
    }
}

/// Entity in the user data of a collider, if it exists.
pub(super) fn lent_entity(user_data: u128, entities: &Entities) -> Option<Entity> {
    let entity = u64::try_from(user_data).ok().and_then(Entity::try_from_bits)?;
    entities.contains(entity).then_some(entity)
}

/// Let the world record the contacts of entities with [`SheetContacts`].
pub(super) fn request(mut world: ResMut<SheetWorld>, mut asking: Query<(Entity, &SheetMotion, &mut SheetContacts)>) {
    for (entity, motion, mut contacts) in &mut asking {
        let wanted = Some((motion.id(), world.generation(), contacts.threshold.to_bits()));
        if contacts.recorded == wanted || motion.sheet(&world).is_none() {
            continue;
        }
        let threshold = f64::from(contacts.threshold);
        // Not a change of the world, nor of the component for its observers.
        if let Err(problem) = world.bypass_change_detection().record_contacts(motion.id(), Some(threshold)) {
            error!("contacts of {entity}: {problem}");
        }
        contacts.bypass_change_detection().recorded = wanted;
    }
}

/// Stop the records of a removed component.
pub(super) fn removed(removed: On<Remove, SheetContacts>, mut world: ResMut<SheetWorld>, motions: Query<&SheetMotion>) {
    if let Ok(motion) = motions.get(removed.entity) {
        // A sheet that is gone records nothing.
        let _ = world.bypass_change_detection().record_contacts(motion.id(), None);
    }
}

/// Send the events of the last tick, and list the present pairs.
pub(super) fn send(
    mut world: ResMut<SheetWorld>,
    mut asking: Query<(Entity, &mut SheetContacts)>,
    partners: Partners,
    mut out: MessageWriter<SheetContact>,
) {
    if asking.is_empty() {
        return;
    }
    for event in world.bypass_change_detection().drain_contact_events() {
        out.write(SheetContact { kind: event.kind, time: event.time, contact: partners.pair(&event.pair) });
    }
    for (_, mut contacts) in &mut asking {
        if !contacts.pairs.is_empty() {
            contacts.pairs.clear();
        }
    }
    for pair in world.contacts() {
        let pair = partners.pair(pair);
        let other = pair.partner.filter(|_| matches!(pair.pair.partner, ContactPartner::Sheet(_)));
        for entity in [pair.sheet, other].into_iter().flatten() {
            if let Ok((_, mut contacts)) = asking.get_mut(entity) {
                contacts.pairs.push(pair);
            }
        }
    }
}
