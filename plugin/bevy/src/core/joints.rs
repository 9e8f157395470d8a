//! Joints between bodies by entity, which are those of Rapier.

use bevy::prelude::*;
use sheetwork::JointId;
use sheetwork::rapier3d::prelude::GenericJoint;

use super::{BodyMotion, SheetWorld};

/// Joint between the bodies of two [`SheetBody`](super::SheetBody) entities, at least one of them
/// dynamic. Add it to any entity; change it at any time, as its motor or its limits; it ends when
/// it is removed, or with one of the bodies. Its frames are those of the bodies, m.
///
/// Bodies of a caller's Rapier world have the joints of that world.
#[derive(Component, Clone, Debug)]
pub struct SheetJoint {
    /// Entities of the two bodies.
    pub bodies: [Entity; 2],
    /// Joint of Rapier, with its limits and motors.
    pub joint: GenericJoint,
}

impl SheetJoint {
    /// Joint between the bodies of `a` and `b`; `joint` is one of Rapier's builders or joints, as
    /// `RevoluteJointBuilder::new(Vec3::Z)`.
    pub fn new(a: Entity, b: Entity, joint: impl Into<GenericJoint>) -> Self {
        Self { bodies: [a, b], joint: joint.into() }
    }
}

/// Link from the entity to its joint in the [`SheetWorld`]. Inserted when the joint is made,
/// removed with its [`SheetJoint`].
#[derive(Component, Clone, Debug)]
pub struct JointLink {
    /// `None` for a joint that the world has refused.
    id: Option<JointId>,
    bodies: [Entity; 2],
    generation: u32,
}

impl JointLink {
    /// End the joint in the world.
    pub(super) fn remove_from(&self, world: &mut SheetWorld) {
        if let Some(id) = self.id.filter(|_| self.generation == world.generation()) {
            world.remove_joint(id);
        }
    }
}

/// Give new and changed joints to the world.
pub(super) fn sync(
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    joints: Query<(Entity, Ref<SheetJoint>, Option<&JointLink>)>,
    bodies: Query<&BodyMotion>,
) {
    for (entity, wanted, link) in &joints {
        let link = link.filter(|link| link.generation == world.generation());
        let present = link.and_then(|link| link.id).filter(|id| world.joint(*id).is_some());
        let is_refused = link.is_some_and(|link| link.id.is_none());
        if !wanted.is_changed() && (present.is_some() || is_refused) {
            continue;
        }
        if let Some(id) = present {
            if link.is_some_and(|link| link.bodies == wanted.bodies) {
                let set = world.set_joint(id, wanted.joint);
                set.map_or_else(|problem| error!("joint of {entity}: {problem}"), |_| {});
                continue;
            }
            world.remove_joint(id);
        }
        let generation = world.generation();
        let body = |of: Entity| bodies.get(of).ok().filter(|body| body.generation == generation)?.id();
        let [Some(a), Some(b)] = wanted.bodies.map(body) else { continue };
        let made = world.insert_joint(a, b, wanted.joint);
        let id = made.map_err(|problem| error!("joint of {entity}: {problem}")).ok();
        commands.entity(entity).try_insert(JointLink { id, bodies: wanted.bodies, generation });
    }
}

/// End the joint of a removed component.
pub(super) fn removed(
    removed: On<Remove, SheetJoint>,
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    links: Query<&JointLink>,
) {
    let Ok(link) = links.get(removed.entity) else { return };
    link.remove_from(&mut world);
    commands.entity(removed.entity).try_remove::<JointLink>();
}
