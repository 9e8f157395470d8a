//! View of Rapier's sets for a step of the sheets, and contact coefficients of pairs.
//!
//! The sets belong to the world or to the caller.

use rapier3d::prelude::*;

use crate::scene::ContactDefaults;

/// `user_data` of a collider whose mesh is convex.
pub(crate) const CONVEX: u128 = 0x636f_6e76_6578;

/// Index in [`ColliderOwners`] that stands for no body.
const NOBODY: u32 = u32::MAX;

/// Body of each collider of the world, materials of the bodies, and coefficients of material pairs.
pub(crate) struct ColliderOwners {
    /// Index of the body, by the index of a collider.
    body: Vec<u32>,
    /// Material, by the index of a body; empty for a body without a material.
    material: Vec<String>,
    pub contact: ContactDefaults,
    /// Distance (m) of the nearest contact point above which a pair of bodies has no contact,
    /// regardless of Rapier's prediction distance.
    pub contact_distance: Real,
}

impl ColliderOwners {
    /// Empty table with the contact coefficients of a scene.
    pub fn new(contact: ContactDefaults) -> Self {
        Self { body: Vec::new(), material: Vec::new(), contact, contact_distance: Real::MAX }
    }

    /// Remove all bodies.
    pub fn clear(&mut self) {
        self.body.clear();
        self.material.clear();
    }

    /// Append a body with these colliders and this material.
    pub fn push(&mut self, colliders: &[ColliderHandle], material: Option<&str>) {
        let index = self.material.len() as u32;
        for handle in colliders {
            let at = handle.into_raw_parts().0 as usize;
            if self.body.len() <= at {
                self.body.resize(at + 1, NOBODY);
            }
            self.body[at] = index;
        }
        self.material.push(material.unwrap_or_default().to_owned());
    }

    /// Index of the body that owns a collider.
    pub(crate) fn body_of(&self, collider: ColliderHandle) -> Option<usize> {
        let body = self.body.get(collider.into_raw_parts().0 as usize).copied();
        body.filter(|b| *b != NOBODY).map(|b| b as usize)
    }

    pub(crate) fn material_of(&self, collider: ColliderHandle) -> &str {
        self.body_of(collider).and_then(|b| self.material.get(b)).map_or("", String::as_str)
    }
}

/// Hooks by which Rapier obtains the contact coefficients of two bodies.
impl PhysicsHooks for ColliderOwners {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        if context.solver_contacts.iter().all(|c| c.dist > self.contact_distance) {
            context.solver_contacts.clear();
        }
        let materials = (self.material_of(context.collider1), self.material_of(context.collider2));
        let combined = (f64::from(*context.friction), f64::from(*context.restitution));
        let (friction, restitution) = self.contact.between(materials, combined);
        *context.friction = friction as Real;
        *context.restitution = restitution as Real;
    }
}

/// View of Rapier's sets for a step.
#[derive(Clone, Copy)]
pub struct RigidView<'a> {
    broad_phase: &'a BroadPhaseBvh,
    narrow_phase: &'a NarrowPhase,
    /// Rigid bodies.
    pub bodies: &'a RigidBodySet,
    /// Colliders.
    pub colliders: &'a ColliderSet,
    /// Whether the bodies belong to the world, which moves them by their velocities alone.
    pub(crate) is_world_owned: bool,
    /// Whether contact with sheets moves the dynamic bodies.
    pushes: bool,
    /// Owners and materials of the world's colliders; `None` for a caller's sets.
    owners: Option<&'a ColliderOwners>,
}

impl<'a> RigidView<'a> {
    /// View of a caller's Rapier world. Its broad phase must be up to date with the poses of the
    /// colliders. All its bodies count as led: sheets do not move them, unless
    /// [`RigidView::pushing`] says so.
    pub fn new(
        broad_phase: &'a BroadPhaseBvh,
        narrow_phase: &'a NarrowPhase,
        bodies: &'a RigidBodySet,
        colliders: &'a ColliderSet,
    ) -> Self {
        Self { broad_phase, narrow_phase, bodies, colliders, is_world_owned: false, pushes: false, owners: None }
    }

    /// The view with dynamic bodies that contact with sheets moves. After the step,
    /// [`World::write_lent_bodies`](crate::World::write_lent_bodies) gives them their new states.
    #[must_use]
    pub fn pushing(self) -> Self {
        Self { pushes: true, ..self }
    }

    /// View of the world's own sets.
    pub(crate) fn from_world(inner: &'a PhysicsWorld, owners: &'a ColliderOwners) -> Self {
        let view = Self::new(&inner.broad_phase, &inner.narrow_phase, &inner.bodies, &inner.colliders);
        Self { is_world_owned: true, pushes: true, owners: Some(owners), ..view }
    }

    /// Query pipeline over all colliders except sensors.
    pub fn query(&self) -> QueryPipeline<'a> {
        let filter = QueryFilter::default().exclude_sensors();
        self.broad_phase.as_query_pipeline(self.narrow_phase.query_dispatcher(), self.bodies, self.colliders, filter)
    }

    /// Query pipeline over static and kinematic colliders: all except sensors and the dynamic
    /// bodies that sheets move.
    pub(crate) fn query_fixed(&self) -> QueryPipeline<'a> {
        let query = self.query();
        let filter = if self.pushes { QueryFilter::exclude_dynamic().exclude_sensors() } else { query.filter };
        QueryPipeline { filter, ..query }
    }

    /// Whether contact with sheets moves `body`. A lent one that may not move along an axis is led.
    pub(crate) fn is_dynamic(&self, body: &RigidBody) -> bool {
        self.pushes
            && body.is_dynamic()
            && body.mass() > 0.0
            && (self.is_world_owned || !body.locked_axes().intersects(LockedAxes::TRANSLATION_LOCKED))
    }

    /// Index of the world's body that owns a collider; `None` for a caller's sets.
    pub(crate) fn body_of(&self, collider: ColliderHandle) -> Option<usize> {
        self.owners.and_then(|o| o.body_of(collider))
    }

    /// Friction and restitution of a sheet and a collider: those of their pair of materials if the
    /// scene has one, otherwise by the collider's combine rule, with the average as the rule of the
    /// sheet.
    pub(crate) fn coefficients(
        &self,
        (material, friction, restitution): (&str, f64, f64),
        handle: ColliderHandle,
        collider: &Collider,
    ) -> (f64, f64) {
        let friction = combined(friction, collider.friction(), collider.friction_combine_rule());
        let restitution = combined(restitution, collider.restitution(), collider.restitution_combine_rule());
        match self.owners {
            Some(o) if !o.contact.pairs.is_empty() => {
                o.contact.between((material, o.material_of(handle)), (friction, restitution))
            }
            _ => (friction, restitution),
        }
    }

    /// Coefficients of friction and restitution of two materials by name; `combined` if the scene
    /// does not define the pair.
    pub(crate) fn between(&self, a: &str, b: &str, combined: (f64, f64)) -> (f64, f64) {
        self.owners.map_or(combined, |o| o.contact.between((a, b), combined))
    }
}

/// Coefficient of a pair by Rapier's combine rules, with the average as the rule of the sheet.
fn combined(ours: f64, theirs: Real, rule: CoefficientCombineRule) -> f64 {
    let theirs = f64::from(theirs);
    match rule {
        CoefficientCombineRule::Min => ours.min(theirs),
        CoefficientCombineRule::Multiply => ours * theirs,
        CoefficientCombineRule::Max => ours.max(theirs),
        _ => 0.5 * (ours + theirs),
    }
}
