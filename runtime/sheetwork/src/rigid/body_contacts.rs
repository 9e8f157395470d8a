//! Contacts between bodies: Rapier's contacts of a step, in f64 and in a deterministic order.
//!
//! Rapier detects the contacts at the start of the step. Points are stored in the frames of their
//! bodies, so that the gap n·(x_a - x_b) (m) can be evaluated at any later pose.

use glam::DVec3;
use rapier3d::prelude::{ColliderHandle, PhysicsWorld};

use crate::rigid::RigidMotion;
use crate::rigid::view::ColliderOwners;

/// A contact point of two bodies, at least one of them dynamic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyContact {
    /// Index of the body to which the normal points.
    pub a: usize,
    /// Index of the body from which the normal points.
    pub b: usize,
    /// Point on a in the frame of a, m.
    pub on_a: DVec3,
    /// Point on b in the frame of b, m.
    pub on_b: DVec3,
    /// Whether a and b are balls at this contact: the contact point does not rotate with a ball.
    pub round: [bool; 2],
    /// Unit normal from b to a, world axes, at the start of the step.
    pub normal: DVec3,
    /// Distance along the normal at the start of the step, m; negative for penetration.
    pub distance: f64,
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Coefficient of restitution.
    pub restitution: f64,
    /// [u64; 2] that is constant between steps, from colliders and features.
    pub key: [u64; 2],
}

/// Append the contacts that Rapier detected in its last substep, for pairs not yet in `list`. The
/// motions still hold the start of that substep.
pub(crate) fn collect(
    inner: &PhysicsWorld,
    owners: &ColliderOwners,
    motions: &[RigidMotion],
    list: &mut Vec<BodyContact>,
) {
    let known = list.len();
    for pair in inner.narrow_phase.contact_pairs() {
        let (Some(b), Some(a)) = (owners.body_of(pair.collider1), owners.body_of(pair.collider2)) else { continue };
        let (Some(of_a), Some(of_b)) = (motions.get(a), motions.get(b)) else { continue };
        if !of_a.start.is_dynamic() && !of_b.start.is_dynamic() {
            continue;
        }
        if list[..known].iter().any(|c| (c.a, c.b) == (a, b) || (c.b, c.a) == (a, b)) {
            continue;
        }
        let is_ball = |handle| inner.colliders.get(handle).is_some_and(|c| c.shape().as_ball().is_some());
        let round = [pair.collider2, pair.collider1].map(is_ball);
        for manifold in pair.solver_manifolds() {
            let normal = manifold.data.normal.as_dvec3().normalize_or_zero();
            let is_near = manifold.points.iter().any(|point| point.dist <= owners.contact_distance);
            if normal == DVec3::ZERO || !is_near {
                continue;
            }
            for point in &manifold.points {
                let on_b = at_start(of_b, point.local_p1.as_dvec3(), round[1]);
                let on_a = at_start(of_a, point.local_p2.as_dvec3(), round[0]);
                let distance = (of_a.start.world_point(on_a) - of_b.start.world_point(on_b)).dot(normal);
                list.push(BodyContact {
                    a,
                    b,
                    on_a,
                    on_b,
                    round,
                    normal,
                    distance,
                    friction: f64::from(manifold.data.friction),
                    restitution: f64::from(manifold.data.restitution),
                    key: [feature_key(pair.collider2, point.fid2.0), feature_key(pair.collider1, point.fid1.0)],
                });
            }
        }
    }
    sort(list);
}

/// Point of a ball that has, at the start of the step, the world direction that `at` had at the
/// start of the last substep; for other bodies `at` itself.
fn at_start(motion: &RigidMotion, at: DVec3, is_round: bool) -> DVec3 {
    if !is_round || motion.substep_start.rotation() == motion.start.rotation() {
        return at;
    }
    motion.start.rotation().conjugate() * (motion.substep_start.rotation() * at)
}

/// [u64; 2] of a feature of a collider.
pub(crate) fn feature_key(collider: ColliderHandle, feature: u32) -> u64 {
    u64::from(collider.into_raw_parts().0) << 32 | u64::from(feature)
}

/// Sort contacts into an order that depends on their contents alone.
pub(crate) fn sort(list: &mut [BodyContact]) {
    // Contacts equal in all these values are interchangeable.
    list.sort_unstable_by(|p, q| {
        let by_place = p.on_a.x.total_cmp(&q.on_a.x).then(p.on_a.y.total_cmp(&q.on_a.y));
        (p.a, p.b, p.key).cmp(&(q.a, q.b, q.key)).then(by_place).then(p.on_a.z.total_cmp(&q.on_a.z))
    });
}
