//! What happens to sheets, as Bevy messages.

use bevy::prelude::*;
use sheetwork::islands::event::{Alarm, EventKind};
use sheetwork::sheet::Opening;

use super::{BodyMotion, SheetMotion, SheetWorld};

/// Something that happened to a sheet: it touched a body, slid off, came to rest...
#[derive(Message, Clone, Debug, PartialEq)]
pub struct SheetEvent {
    /// What.
    pub kind: EventKind,
    /// Simulated time it happened at, s.
    pub time: f64,
    /// Name of the sheet in the [`SheetWorld`].
    pub sheet: String,
    /// The sheet's entity, if it still has one.
    pub entity: Option<Entity>,
    /// Name of the body it happened with, where there is one.
    pub body: Option<String>,
    /// That body's entity, where it has one.
    pub body_entity: Option<Entity>,
    /// Where and of what the sheet opened, when it did.
    pub opening: Option<Opening>,
    /// What showed that the sheet was unstable, and what was done about it.
    pub alarm: Option<Alarm>,
}

/// Sends what the world has recorded since the last time.
pub(super) fn send(
    mut world: ResMut<SheetWorld>,
    sheets: Query<(Entity, &SheetMotion)>,
    bodies: Query<(Entity, &BodyMotion)>,
    mut out: MessageWriter<SheetEvent>,
) {
    // There are fewer after a reset.
    let seen = world.events_seen.min(world.events().len());
    world.bypass_change_detection().events_seen = seen;
    if world.events().len() <= seen {
        return;
    }
    for event in &world.events()[seen..] {
        let sheet = sheets.iter().find(|(_, m)| m.name() == event.sheet);
        let body = event.body.as_deref().and_then(|name| bodies.iter().find(|(_, m)| m.is_named(name)));
        out.write(SheetEvent {
            kind: event.kind,
            time: event.time_s,
            sheet: event.sheet.clone(),
            entity: sheet.map(|(entity, _)| entity),
            body: event.body.clone(),
            body_entity: body.map(|(entity, _)| entity),
            opening: event.opening,
            alarm: event.alarm,
        });
    }
    world.events_seen = world.events().len();
}
