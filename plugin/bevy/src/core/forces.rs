//! Forces on the sheets, for entities with [`SheetForces`].

use bevy::math::DVec3;
use bevy::prelude::*;
use sheetwork::{ForceEntry, ForceKind, ForcePartner};

use super::{BodyMotion, SheetMotion, SheetWorld};

/// Forces on a sheet in the last step. Add it to the entity of a [`Sheet`](super::Sheet): from the
/// next step on the world records forces.
#[derive(Component, Clone, Debug, Default)]
pub struct SheetForces {
    /// Entries of the sheet, each with the entity of the body or sheet that exerts the force.
    pub entries: Vec<(ForceEntry, Option<Entity>)>,
}

impl SheetForces {
    /// Force of one kind, N: the sum over all partners.
    pub fn total(&self, kind: ForceKind) -> DVec3 {
        self.entries.iter().filter(|(entry, _)| entry.kind == kind).map(|(entry, _)| entry.force).sum()
    }

    /// Contact and attachment force that the body or sheet `partner` exerts, N.
    pub fn by(&self, partner: Entity) -> DVec3 {
        let of_it = |(_, entity): &&(ForceEntry, Option<Entity>)| *entity == Some(partner);
        self.entries.iter().filter(of_it).map(|(entry, _)| entry.force).sum()
    }
}

/// Let the world record forces while any entity asks for them.
pub(super) fn request(mut world: ResMut<SheetWorld>, asking: Query<(), With<SheetForces>>) {
    if !asking.is_empty() {
        // Not a change of the world.
        world.bypass_change_detection().record_forces(true);
    }
}

/// Copy the forces of the last step to the entities.
pub(super) fn write(
    world: Res<SheetWorld>,
    mut asking: Query<(&SheetMotion, &mut SheetForces)>,
    sheets: Query<(Entity, &SheetMotion)>,
    bodies: Query<(Entity, &BodyMotion)>,
) {
    for (motion, mut forces) in &mut asking {
        forces.entries.clear();
        let Some(own) = world.sheets().iter().position(|sheet| sheet.name == motion.name()) else { continue };
        for entry in world.forces().iter().filter(|entry| entry.sheet == own) {
            let name = world.partner_name(entry).unwrap_or_default();
            let partner = match entry.partner {
                ForcePartner::Body(_) => bodies.iter().find(|(_, body)| body.is_named(name)).map(|(entity, _)| entity),
                _ => sheets.iter().find(|(_, sheet)| sheet.name() == name).map(|(entity, _)| entity),
            };
            forces.entries.push((*entry, partner));
        }
    }
}
