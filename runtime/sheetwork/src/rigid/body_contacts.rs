//! Where bodies touch one another: Rapier's contacts of a step, in f64 and in an order that is always the same.
//!
//! Rapier finds them at the start of the step. Points are kept in the frames of their bodies, so that the gap
//! n·(x_a - x_b) (m) can be taken at any other place of the two.

use glam::DVec3;
use rapier3d::prelude::{ColliderHandle, PhysicsWorld};

use crate::collision::constraint::Key;
use crate::rigid::Motion;
use crate::rigid::view::Owners;

/// A point where two bodies touch or nearly do, at least one of which moves freely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyContact {
    /// Index of the body that the normal points to.
    pub a: usize,
    /// Index of the body that the normal comes from.
    pub b: usize,
    /// Where on a, in its frame, m.
    pub on_a: DVec3,
    /// Where on b, in its frame, m.
    pub on_b: DVec3,
    /// Whether a and b are balls there: they touch below their centres however they turn.
    pub round: [bool; 2],
    /// From b to a, unit, in the world, at the start of the step.
    pub normal: DVec3,
    /// How far apart they were along it at the start of the step, m; negative inside one another.
    pub distance: f64,
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Its name from step to step: colliders and features.
    pub key: Key,
}

/// Adds to `list` the contacts that Rapier has found in its last part of a step, of pairs that are not in it; motions still hold the start of
/// that part.
pub(crate) fn collect(inner: &PhysicsWorld, owners: &Owners, motions: &[Motion], list: &mut Vec<BodyContact>) {
    let known = list.len();
    for pair in inner.narrow_phase.contact_pairs() {
        let (Some(b), Some(a)) = (owners.of(pair.collider1), owners.of(pair.collider2)) else { continue };
        let (Some(of_a), Some(of_b)) = (motions.get(a), motions.get(b)) else { continue };
        if !of_a.start.gives() && !of_b.start.gives() {
            continue;
        }
        if list[..known].iter().any(|c| (c.a, c.b) == (a, b) || (c.b, c.a) == (a, b)) {
            continue;
        }
        let is_ball = |handle| inner.colliders.get(handle).is_some_and(|c| c.shape().as_ball().is_some());
        let round = [pair.collider2, pair.collider1].map(is_ball);
        for manifold in pair.solver_manifolds() {
            let normal = manifold.data.normal.as_dvec3().normalize_or_zero();
            let is_near = manifold.points.iter().any(|point| point.dist <= owners.reach);
            if normal == DVec3::ZERO || !is_near {
                continue;
            }
            for point in &manifold.points {
                let on_b = at_start(of_b, point.local_p1.as_dvec3(), round[1]);
                let on_a = at_start(of_a, point.local_p2.as_dvec3(), round[0]);
                let distance = (of_a.start.place(on_a) - of_b.start.place(on_b)).dot(normal);
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
                    key: [name(pair.collider2, point.fid2.0), name(pair.collider1, point.fid1.0)],
                });
            }
        }
    }
    sort(list);
}

/// The point of a body that has the part of a ball at the start of the step that the point `at` had at the start of its last part; of others
/// that point.
fn at_start(motion: &Motion, at: DVec3, is_round: bool) -> DVec3 {
    if !is_round || motion.from.rotation() == motion.start.rotation() {
        return at;
    }
    motion.start.rotation().conjugate() * (motion.from.rotation() * at)
}

/// The name of a feature of a collider.
pub(crate) fn name(collider: ColliderHandle, feature: u32) -> u64 {
    u64::from(collider.into_raw_parts().0) << 32 | u64::from(feature)
}

/// Puts contacts in an order that depends on nothing else.
pub(crate) fn sort(list: &mut [BodyContact]) {
    // Points that agree in all of this are the same point: their order does not matter.
    list.sort_unstable_by(|p, q| {
        let by_place = p.on_a.x.total_cmp(&q.on_a.x).then(p.on_a.y.total_cmp(&q.on_a.y));
        (p.a, p.b, p.key).cmp(&(q.a, q.b, q.key)).then(by_place).then(p.on_a.z.total_cmp(&q.on_a.z))
    });
}
