//! All bodies over one step, for detection and contact: states at its start and end, features of
//! their colliders, swept bounding boxes. The features of a collider are computed once and cached
//! while its shape is unchanged.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use rapier3d::prelude::{Collider, ColliderHandle, SharedShape};

use crate::collision::features::ColliderFeatures;
use crate::contact::solver_body::frame_of_body;
use crate::math::RigidFrame;
use crate::rigid::lent::{LentBodies, LentBody};
use crate::rigid::{BodyState, RigidView, RigidWorld};

/// A collider over one step.
pub(crate) struct StepCollider {
    pub handle: ColliderHandle,
    /// Index of its body in [`StepBodies::bodies`].
    pub body: u32,
    pub features: Arc<ColliderFeatures>,
    /// Frame of the collider in the frame of its body.
    pub frame: RigidFrame,
    /// Corners of the swept bounding box, m.
    pub low: DVec3,
    pub high: DVec3,
}

/// A body over one step.
#[derive(Clone, Copy)]
pub(crate) struct StepBody {
    pub start: BodyState,
    pub end: BodyState,
    /// Index in the world's list of bodies; `None` for a body owned by the caller.
    pub world_index: Option<u32>,
    /// Index in the list of lent bodies, of a body owned by the caller that sheets move.
    pub lent_index: Option<u32>,
    /// Whether the body sleeps.
    pub asleep: bool,
    /// Distance of the furthest point from the centre of mass, m; 0 for a body of the caller.
    pub extent: f64,
    /// Radius if the body is a ball of the world, m.
    pub ball: Option<f64>,
}

impl StepBody {
    /// Whether the body moves during the step.
    pub fn moves(&self) -> bool {
        !self.asleep && (self.start.is_moving() || self.end.is_moving())
    }
}

/// Cached features of a collider, valid while its shape is unchanged.
struct CachedFeatures {
    handle: ColliderHandle,
    shape: SharedShape,
    features: Arc<ColliderFeatures>,
}

/// All bodies and colliders over one step.
#[derive(Default)]
pub(crate) struct StepBodies {
    /// Colliders of all bodies.
    pub colliders: Vec<StepCollider>,
    /// Bodies of the world, then one per collider of the caller.
    pub bodies: Vec<StepBody>,
    /// Features by index of the collider handle.
    cache: Vec<Option<CachedFeatures>>,
}

impl StepBodies {
    /// Update all states for a step of `dt` (s) in the gravity `g` (m/s²): those of the world's
    /// bodies from `rigid`, of the caller's from `lent` if sheets move them, else from `view`.
    pub fn update(
        &mut self,
        view: &RigidView,
        (rigid, lent): (Option<&RigidWorld>, &LentBodies),
        (dt, g): (f64, DVec3),
    ) {
        self.colliders.clear();
        self.bodies.clear();
        if let Some(rigid) = rigid {
            self.bodies.extend((0..rigid.bodies().len()).filter_map(|index| own_body(rigid, index)));
        }
        let own = self.bodies.len();
        self.bodies.extend(lent.bodies.iter().enumerate().map(|(index, body)| lent_body(index, body, dt, g)));
        let query = view.query();
        for (handle, collider) in view.colliders.iter() {
            if collider.is_sensor() || !query.filter.test(query.bodies, handle, collider) {
                continue;
            }
            let parent = || collider.parent().and_then(|parent| lent.index_of(parent));
            let body = match view.body_of(handle).filter(|b| *b < own).or_else(|| parent().map(|index| own + index)) {
                Some(body) => body,
                None => {
                    self.bodies.push(caller_owned_body(view, collider, dt));
                    self.bodies.len() - 1
                }
            };
            let features = self.features_of(handle, collider);
            let over = &self.bodies[body];
            let there = RigidFrame::from_pose(collider.position());
            let frame = match (over.world_index, over.lent_index, collider.position_wrt_parent()) {
                (Some(_), ..) => relative_frame(&frame_of_body(&over.end), &there),
                (_, Some(_), Some(in_body)) => RigidFrame::from_pose(in_body),
                _ => RigidFrame::IDENTITY,
            };
            let bounds = collider.compute_aabb();
            let (low, high) = (bounds.mins.as_dvec3(), bounds.maxs.as_dvec3());
            // The swept box extends the box at the end by the displacement of the centre and the
            // rotation, which bound the motion of its corners.
            let radius = (high - low).length();
            let gone = over.start.centre().distance(over.end.centre());
            let turned = if over.moves() { over.start.spin().length() * dt * radius.min(1e4) } else { 0.0 };
            let slack = DVec3::splat(gone + turned.min(2.0 * radius));
            self.colliders.push(StepCollider {
                handle,
                body: body as u32,
                features,
                frame,
                low: low - slack,
                high: high + slack,
            });
        }
    }

    /// Features of a collider, from the cache if its shape is unchanged.
    fn features_of(&mut self, handle: ColliderHandle, collider: &Collider) -> Arc<ColliderFeatures> {
        let at = handle.into_raw_parts().0 as usize;
        if self.cache.len() <= at {
            self.cache.resize_with(at + 1, || None);
        }
        let shape = collider.shared_shape();
        let same = |c: &CachedFeatures| c.handle == handle && Arc::ptr_eq(&c.shape.0, &shape.0);
        match &self.cache[at] {
            Some(cached) if same(cached) => cached.features.clone(),
            _ => {
                let features = Arc::new(ColliderFeatures::from_shape(collider.shape()));
                self.cache[at] = Some(CachedFeatures { handle, shape: shape.clone(), features: features.clone() });
                features
            }
        }
    }
}

/// A body of the world.
fn own_body(rigid: &RigidWorld, index: usize) -> Option<StepBody> {
    Some(StepBody {
        start: *rigid.start(index)?,
        end: *rigid.state(index)?,
        world_index: Some(index as u32),
        lent_index: None,
        asleep: rigid.is_asleep(index),
        extent: rigid.extent(index),
        ball: rigid.radius(index),
    })
}

/// A dynamic body that the caller lends.
fn lent_body(index: usize, body: &LentBody, dt: f64, g: DVec3) -> StepBody {
    StepBody {
        start: body.state,
        end: body.state.free_flight(dt, g),
        world_index: None,
        lent_index: Some(index as u32),
        asleep: body.is_asleep,
        extent: 0.0,
        ball: None,
    }
}

/// A body that the caller moves: its present pose is the pose at the end of the step.
fn caller_owned_body(view: &RigidView, collider: &Collider, dt: f64) -> StepBody {
    let pose = collider.position();
    let (origin, rotation) = (pose.translation.as_dvec3(), pose.rotation.as_dquat());
    let body = collider.parent().and_then(|h| view.bodies.get(h)).filter(|b| !b.is_fixed());
    let (velocity, spin) = body.map_or((DVec3::ZERO, DVec3::ZERO), |b| {
        let spin = b.angvel().as_dvec3();
        (b.linvel().as_dvec3() + spin.cross(origin - b.center_of_mass().as_dvec3()), spin)
    });
    let end = BodyState::fixed_at(origin, rotation).with_velocity(velocity, spin);
    StepBody {
        start: end.free_flight(-dt, DVec3::ZERO),
        end,
        world_index: None,
        lent_index: None,
        asleep: false,
        extent: 0.0,
        ball: None,
    }
}

/// Frame `inner` expressed in `outer`; exactly the identity if both agree to single precision.
fn relative_frame(outer: &RigidFrame, inner: &RigidFrame) -> RigidFrame {
    let frame =
        RigidFrame { origin: outer.local_point(inner.origin), rotation: outer.rotation.transpose() * inner.rotation };
    let size = 1.0 + outer.origin.abs().max_element();
    let turned = (frame.rotation - DMat3::IDENTITY).to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    if frame.origin.length() < 1e-6 * size && turned < 1e-5 { RigidFrame::IDENTITY } else { frame }
}
