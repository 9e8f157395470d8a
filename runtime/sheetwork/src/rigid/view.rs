//! Rapier's sets as a step of the sheets looks at them, the world's own or a caller's, and the coefficients of what meets
//! there.

use rapier3d::prelude::*;

use crate::scene::ContactDefaults;
use crate::sheet::Sheet;

/// `user_data` of a collider whose mesh is known to be convex.
pub(crate) const CONVEX: u128 = 0x636f_6e76_6578;

/// Stands for no body in [`Owners`].
const NOBODY: u32 = u32::MAX;

/// Which body each collider of the world's own belongs to, what bodies are made of, and what pairs of materials have.
pub(crate) struct Owners {
    /// By the index of a collider.
    body: Vec<u32>,
    /// By the index of a body; empty for one that does not say.
    material: Vec<String>,
    pub contact: ContactDefaults,
    /// How near two bodies must be somewhere to have anything to do with one another, m, however far Rapier looks.
    pub reach: Real,
}

impl Owners {
    /// No bodies, in a scene with these coefficients.
    pub fn new(contact: ContactDefaults) -> Self {
        Self { body: Vec::new(), material: Vec::new(), contact, reach: Real::MAX }
    }

    /// Forgets all bodies.
    pub fn clear(&mut self) {
        self.body.clear();
        self.material.clear();
    }

    /// The next body has these colliders and this material.
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

    /// Index of the body that a collider belongs to.
    pub fn of(&self, collider: ColliderHandle) -> Option<usize> {
        let body = self.body.get(collider.into_raw_parts().0 as usize).copied();
        body.filter(|b| *b != NOBODY).map(|b| b as usize)
    }

    pub(crate) fn material_of(&self, collider: ColliderHandle) -> &str {
        self.of(collider).and_then(|b| self.material.get(b)).map_or("", String::as_str)
    }
}

/// Rapier asks these what two bodies have together.
impl PhysicsHooks for Owners {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        if context.solver_contacts.iter().all(|c| c.dist > self.reach) {
            context.solver_contacts.clear();
        }
        let materials = (self.material_of(context.collider1), self.material_of(context.collider2));
        let combined = (f64::from(*context.friction), f64::from(*context.restitution));
        let (friction, restitution) = self.contact.between(materials, combined);
        *context.friction = friction as Real;
        *context.restitution = restitution as Real;
    }
}

/// Rapier's sets, as a step looks at them.
#[derive(Clone, Copy)]
pub struct RigidView<'a> {
    broad_phase: &'a BroadPhaseBvh,
    narrow_phase: &'a NarrowPhase,
    /// The bodies.
    pub bodies: &'a RigidBodySet,
    /// The colliders.
    pub colliders: &'a ColliderSet,
    /// Whether the bodies are the world's own, which move only as their velocities say.
    pub(crate) owned: bool,
    /// What is known of the world's own.
    owners: Option<&'a Owners>,
}

impl<'a> RigidView<'a> {
    /// A view of a caller's Rapier world, whose broad phase must be up to date with the colliders' places.
    pub fn new(
        broad_phase: &'a BroadPhaseBvh,
        narrow_phase: &'a NarrowPhase,
        bodies: &'a RigidBodySet,
        colliders: &'a ColliderSet,
    ) -> Self {
        Self { broad_phase, narrow_phase, bodies, colliders, owned: false, owners: None }
    }

    /// A view of the world's own.
    pub(crate) fn of_own(inner: &'a PhysicsWorld, owners: &'a Owners) -> Self {
        let view = Self::new(&inner.broad_phase, &inner.narrow_phase, &inner.bodies, &inner.colliders);
        Self { owned: true, owners: Some(owners), ..view }
    }

    /// Queries over everything but sensors.
    pub fn query(&self) -> QueryPipeline<'a> {
        let filter = QueryFilter::default().exclude_sensors();
        self.broad_phase.as_query_pipeline(self.narrow_phase.query_dispatcher(), self.bodies, self.colliders, filter)
    }

    /// Queries over what does not give way: everything but sensors and the world's own bodies that move freely.
    pub(crate) fn query_standing(&self) -> QueryPipeline<'a> {
        let query = self.query();
        let filter = if self.owned { QueryFilter::exclude_dynamic().exclude_sensors() } else { query.filter };
        QueryPipeline { filter, ..query }
    }

    /// Whether `body` gives way to sheets.
    pub(crate) fn gives_way(&self, body: &RigidBody) -> bool {
        self.owned && body.is_dynamic()
    }

    /// Index of the world's own body that a collider belongs to; `None` where the bodies are lent.
    pub fn body_of(&self, collider: ColliderHandle) -> Option<usize> {
        self.owners.and_then(|o| o.of(collider))
    }

    /// Friction and restitution of a sheet and a collider: of the pair of their materials if the scene has one, otherwise by
    /// the collider's rule, the sheet's own being the average.
    pub fn coefficients(&self, sheet: &Sheet, handle: ColliderHandle, collider: &Collider) -> (f64, f64) {
        let friction = combined(sheet.friction, collider.friction(), collider.friction_combine_rule());
        let restitution = combined(sheet.restitution, collider.restitution(), collider.restitution_combine_rule());
        match self.owners {
            Some(o) if !o.contact.pairs.is_empty() => {
                o.contact.between((&sheet.material().name, o.material_of(handle)), (friction, restitution))
            }
            _ => (friction, restitution),
        }
    }

    /// Coefficients of friction and restitution of two materials, by name; `combined` where the scene says nothing of them.
    pub(crate) fn between(&self, a: &str, b: &str, combined: (f64, f64)) -> (f64, f64) {
        self.owners.map_or(combined, |o| o.contact.between((a, b), combined))
    }
}

/// Rapier's rules for a pair's coefficient, with the sheet's own rule taken to be the average.
fn combined(ours: f64, theirs: Real, rule: CoefficientCombineRule) -> f64 {
    let theirs = f64::from(theirs);
    match rule {
        CoefficientCombineRule::Min => ours.min(theirs),
        CoefficientCombineRule::Multiply => ours * theirs,
        CoefficientCombineRule::Max => ours.max(theirs),
        _ => 0.5 * (ours + theirs),
    }
}
