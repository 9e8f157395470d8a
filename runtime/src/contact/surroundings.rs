//! All bodies over a step, as detection and the contact problem want them: their states at its start and end, the features
//! of their colliders, and the boxes they sweep. Features are made when a collider is first seen and kept while its shape
//! stays.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use rapier3d::prelude::{Collider, ColliderHandle, SharedShape};

use super::features::Features;
use super::frame::RigidFrame;
use super::rigid::{BodyState, RigidView, RigidWorld};

/// A collider over a step.
pub(crate) struct Part {
    pub handle: ColliderHandle,
    /// Which of the bodies it belongs to.
    pub body: u32,
    pub features: Arc<Features>,
    /// Its frame in that of the body.
    pub frame: RigidFrame,
    /// Corners of the box it sweeps, m.
    pub low: DVec3,
    pub high: DVec3,
}

/// A body over a step.
#[derive(Clone, Copy)]
pub(crate) struct BodyOver {
    pub start: BodyState,
    pub end: BodyState,
    /// Its number in the world's own list, where it is one of those.
    pub own: Option<u32>,
    pub asleep: bool,
    /// Distance of its furthest point from its centre of mass, and its radius if it is a ball, m; of the world's own.
    pub extent: f64,
    pub ball: Option<f64>,
}

impl BodyOver {
    /// Whether it is anywhere else at the end of the step than at its start.
    pub fn moves(&self) -> bool {
        !self.asleep && (self.start.moves() || self.end.moves())
    }
}

struct Cached {
    handle: ColliderHandle,
    shape: SharedShape,
    features: Arc<Features>,
}

/// All bodies over a step.
#[derive(Default)]
pub(crate) struct Surroundings {
    pub parts: Vec<Part>,
    pub bodies: Vec<BodyOver>,
    cache: Vec<Option<Cached>>,
}

impl Surroundings {
    /// Takes up where everything is in a step of `dt` s: of the world's own bodies by `rigid`, of others by `view`.
    pub fn update(&mut self, view: &RigidView, rigid: Option<&RigidWorld>, dt: f64) {
        self.parts.clear();
        self.bodies.clear();
        if let Some(rigid) = rigid {
            for index in 0..rigid.bodies().len() {
                let (Some(start), Some(end)) = (rigid.start(index), rigid.state(index)) else { continue };
                let asleep = rigid.is_asleep(index);
                let (extent, ball) = (rigid.extent(index), rigid.radius(index));
                self.bodies.push(BodyOver { start: *start, end: *end, own: Some(index as u32), asleep, extent, ball });
            }
        }
        let own = self.bodies.len();
        let query = view.query();
        for (handle, collider) in view.colliders.iter() {
            if collider.is_sensor() || !query.filter.test(query.bodies, handle, collider) {
                continue;
            }
            let body = match view.body_of(handle).filter(|b| *b < own) {
                Some(body) => body,
                None => {
                    self.bodies.push(lent(view, collider, dt));
                    self.bodies.len() - 1
                }
            };
            let features = self.features_of(handle, collider);
            let over = &self.bodies[body];
            let of_body = super::mover::frame(&over.end);
            let there = RigidFrame::of(collider.position());
            let frame = if body < own { within(&of_body, &there) } else { RigidFrame::IDENTITY };
            let bounds = collider.compute_aabb();
            let (low, high) = (bounds.mins.as_dvec3(), bounds.maxs.as_dvec3());
            // Where it was at the start of the step: no further than its furthest corner has moved.
            let radius = (high - low).length();
            let gone = over.start.centre().distance(over.end.centre());
            let turned = if over.moves() { over.start.spin().length() * dt * radius.min(1e4) } else { 0.0 };
            let slack = DVec3::splat(gone + turned.min(2.0 * radius));
            self.parts.push(Part { handle, body: body as u32, features, frame, low: low - slack, high: high + slack });
        }
    }

    fn features_of(&mut self, handle: ColliderHandle, collider: &Collider) -> Arc<Features> {
        let at = handle.into_raw_parts().0 as usize;
        if self.cache.len() <= at {
            self.cache.resize_with(at + 1, || None);
        }
        let shape = collider.shared_shape();
        let same = |c: &Cached| c.handle == handle && Arc::ptr_eq(&c.shape.0, &shape.0);
        match &self.cache[at] {
            Some(cached) if same(cached) => cached.features.clone(),
            _ => {
                let features = Arc::new(Features::of(collider.shape()));
                self.cache[at] = Some(Cached { handle, shape: shape.clone(), features: features.clone() });
                features
            }
        }
    }
}

/// A body that somebody else moves: at the end of the step it is where it is now.
fn lent(view: &RigidView, collider: &Collider, dt: f64) -> BodyOver {
    let pose = collider.position();
    let (origin, rotation) = (pose.translation.as_dvec3(), pose.rotation.as_dquat());
    let body = collider.parent().and_then(|h| view.bodies.get(h)).filter(|b| !b.is_fixed());
    let (velocity, spin) = body.map_or((DVec3::ZERO, DVec3::ZERO), |b| {
        let spin = b.angvel().as_dvec3();
        (b.linvel().as_dvec3() + spin.cross(origin - b.center_of_mass().as_dvec3()), spin)
    });
    let end = BodyState::standing(origin, rotation).with_velocity(velocity, spin);
    BodyOver { start: end.fly(-dt, DVec3::ZERO), end, own: None, asleep: false, extent: 0.0, ball: None }
}

/// Frame `inner` in the axes of `outer`; exactly none for two that are one but for rounding to single precision.
fn within(outer: &RigidFrame, inner: &RigidFrame) -> RigidFrame {
    let frame = RigidFrame { origin: outer.local(inner.origin), rotation: outer.rotation.transpose() * inner.rotation };
    let size = 1.0 + outer.origin.abs().max_element();
    let turned = (frame.rotation - DMat3::IDENTITY).to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    if frame.origin.length() < 1e-6 * size && turned < 1e-5 { RigidFrame::IDENTITY } else { frame }
}
