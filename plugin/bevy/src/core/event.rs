//! Events of sheets, as Bevy messages.

use bevy::ecs::entity::Entities;
use bevy::prelude::*;
use sheetwork::islands::event::{EventKind, InstabilityReport};
use sheetwork::sheet::FractureOpening;

use super::{BodyMotion, SheetMotion, SheetWorld, contacts};

/// Event of a sheet, such as first contact, slip off a body, or rest.
#[derive(Message, Clone, Debug, PartialEq)]
pub struct SheetEvent {
    /// Kind of the event.
    pub kind: EventKind,
    /// Simulated time of the event, s.
    pub time: f64,
    /// Name of the sheet in the [`SheetWorld`].
    pub sheet: String,
    /// Entity of the sheet, while it exists.
    pub entity: Option<Entity>,
    /// Name of the body involved, if any.
    pub body: Option<String>,
    /// Entity of that body, while it exists; for a body of the caller's Rapier world, the entity in
    /// the user data of its collider, where bevy_rapier3d keeps it.
    pub body_entity: Option<Entity>,
    /// Place and cause of a fracture, for a fracture event.
    pub opening: Option<FractureOpening>,
    /// Evidence of an instability and the recovery policy applied, for such events.
    pub alarm: Option<InstabilityReport>,
    /// Contact impulse of the step of a first contact, N s, if the world records forces.
    pub impulse: Option<f64>,
}

/// Send the events recorded since the last run.
pub(super) fn send(
    mut world: ResMut<SheetWorld>,
    sheets: Query<(Entity, &SheetMotion)>,
    bodies: Query<(Entity, &BodyMotion)>,
    entities: &Entities,
    mut out: MessageWriter<SheetEvent>,
) {
    // A reset shortens the list.
    let (seen, count) = (world.events_seen, world.event_count());
    if count == seen {
        return;
    }
    world.bypass_change_detection().events_seen = count;
    for event in world.events_since(seen) {
        let sheet = sheets.iter().find(|(_, m)| m.name() == event.sheet);
        let body = event.body.as_deref().and_then(|name| bodies.iter().find(|(_, m)| m.is_named(name)));
        out.write(SheetEvent {
            kind: event.kind,
            time: event.time_s,
            sheet: event.sheet.clone(),
            entity: sheet.map(|(entity, _)| entity),
            body: event.body.clone(),
            body_entity: body
                .map(|(entity, _)| entity)
                .or_else(|| event.user_data.and_then(|data| contacts::lent_entity(data, entities))),
            opening: event.opening,
            alarm: event.alarm,
            impulse: event.impulse_n_s,
        });
    }
}
