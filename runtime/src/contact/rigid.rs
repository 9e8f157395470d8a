//! The rigid world: Rapier's bodies and colliders, the scene's own or a caller's.
//!
//! A world owns a [`RigidWorld`] made from the scene's bodies, floor and back wall. A game that already runs Rapier lends
//! its sets as a [`RigidView`] instead. Bodies stand still or follow a path; they are not pushed by sheets yet.

use glam::{DQuat, DVec3};
use rapier3d::prelude::*;

use crate::error::InputError;
use crate::scene::{BodySpec, PathKey, Placement, Polyhedron, Room, Scene, Shape, body_name, path_at, pol};

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
}

/// `user_data` of a collider whose mesh is known to be convex.
pub(super) const CONVEX: u128 = 0x636f_6e76_6578;

impl<'a> RigidView<'a> {
    /// A view of a caller's Rapier world, whose broad phase must be up to date with the colliders' places.
    pub fn new(
        broad_phase: &'a BroadPhaseBvh,
        narrow_phase: &'a NarrowPhase,
        bodies: &'a RigidBodySet,
        colliders: &'a ColliderSet,
    ) -> Self {
        Self { broad_phase, narrow_phase, bodies, colliders, owned: false }
    }

    /// Queries over everything but sensors.
    pub fn query(&self) -> QueryPipeline<'a> {
        let filter = QueryFilter::default().exclude_sensors();
        self.broad_phase.as_query_pipeline(self.narrow_phase.query_dispatcher(), self.bodies, self.colliders, filter)
    }
}

/// A body of the scene, for those who show or name it.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name, unique among the bodies.
    pub name: String,
    /// What it was made from.
    pub shape: Shape,
    /// Its faces, local coordinates, m; empty for balls and half spaces.
    pub polyhedra: Vec<Polyhedron>,
    /// Where it was put.
    pub placement: Placement,
    /// How it moves; empty for a body that stands still.
    pub path: Vec<PathKey>,
    handle: RigidBodyHandle,
    colliders: Vec<ColliderHandle>,
}

/// The scene's own Rapier world.
pub struct RigidWorld {
    inner: PhysicsWorld,
    bodies: Vec<Body>,
    moving: bool,
}

impl RigidWorld {
    /// The bodies of `scene`, its floor and its back wall.
    ///
    /// # Errors
    /// When a shape is not valid or its file cannot be read.
    pub fn build(scene: &Scene) -> Result<Self, InputError> {
        let mut world = Self { inner: PhysicsWorld::new(), bodies: Vec::new(), moving: false };
        world.inner.gravity = Vector::ZERO;
        for (index, spec) in scene.bodies.iter().enumerate() {
            let field = format!("bodies.{index}");
            world.add(scene, spec, index).map_err(|mut e| {
                if e.file.is_some() {
                    e.problem = format!("{} (the file of {field}.shape)", e.problem);
                } else {
                    e.field = if e.field.is_empty() { field } else { format!("{field}.{}", e.field) };
                }
                e
            })?;
        }
        if let Some(room) = &scene.room {
            world.add_room(scene, room)?;
        }
        world.settle();
        Ok(world)
    }

    fn add_room(&mut self, scene: &Scene, room: &Room) -> Result<(), InputError> {
        let plane = |name: &str, position: DVec3, rotation: DVec3| BodySpec {
            name: name.to_owned(),
            placement: Placement { position, rotation },
            ..BodySpec::new(Shape::HalfSpace)
        };
        self.add(scene, &plane("floor", DVec3::new(0.0, room.y.0, 0.0), DVec3::ZERO), 0)?;
        if room.back_wall {
            // Local +y, the side a half space is touched from, turned to +z.
            self.add(scene, &plane("back wall", DVec3::new(0.0, 0.0, room.z.0), DVec3::new(90.0, 0.0, 0.0)), 0)?;
        }
        Ok(())
    }

    /// Adds a body; friction, restitution and files are taken as in `scene`. Named "body `index`" if it has no name.
    ///
    /// # Errors
    /// When its shape is not valid or its file cannot be read; nothing is added then.
    pub fn add(&mut self, scene: &Scene, spec: &BodySpec, index: usize) -> Result<(), InputError> {
        let polyhedra = polyhedra_of(scene, &spec.shape)?;
        let shapes = shapes_of(&spec.shape, &polyhedra)?;
        let builder =
            if spec.path.is_empty() { RigidBodyBuilder::fixed() } else { RigidBodyBuilder::kinematic_position_based() };
        let handle = self.inner.insert_body(builder.pose(pose(&spec.placement, &spec.path, 0.0)));
        let friction = spec.friction.unwrap_or(scene.contact.friction) as f32;
        let restitution = spec.restitution.unwrap_or(scene.contact.restitution) as f32;
        let mut colliders = Vec::new();
        for (index, shape) in shapes.into_iter().enumerate() {
            let mark = if polyhedra.get(index).is_some_and(is_convex) { CONVEX } else { 0 };
            let collider = ColliderBuilder::new(shape).friction(friction).restitution(restitution).user_data(mark);
            colliders.push(self.inner.insert_collider(collider, Some(handle)));
        }
        self.moving |= !spec.path.is_empty();
        let name = body_name(&spec.name, index);
        self.bodies.push(Body {
            name,
            shape: spec.shape.clone(),
            polyhedra,
            placement: spec.placement,
            path: spec.path.clone(),
            handle,
            colliders,
        });
        self.settle();
        Ok(())
    }

    /// The bodies, scene order, then floor and back wall.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Removes the body of that name; false when there is none.
    pub fn remove(&mut self, name: &str) -> bool {
        let Some(index) = self.bodies.iter().position(|b| b.name == name) else { return false };
        self.inner.remove_body(self.bodies.remove(index).handle);
        self.settle();
        true
    }

    /// Sends the body of that name to a place (m) where it will be at the end of the next step; false when there is none.
    /// From then on it is moved this way and not by a path.
    pub fn send(&mut self, name: &str, position: DVec3, rotation: DQuat) -> bool {
        let Some(body) = self.bodies.iter_mut().find(|b| b.name == name) else { return false };
        let Some(rigid) = self.inner.bodies.get_mut(body.handle) else { return false };
        let (position, rotation) = (position.as_vec3(), rotation.as_quat());
        let here = rigid.position();
        if here.translation == position && here.rotation == rotation && body.path.is_empty() {
            return true;
        }
        body.path.clear();
        rigid.set_body_type(RigidBodyType::KinematicPositionBased, true);
        rigid.set_next_kinematic_position(Pose::from_parts(position, rotation));
        self.moving = true;
        true
    }

    /// Rapier fills its broad phase in a step; nothing moves by itself in so short a time.
    fn settle(&mut self) {
        self.inner.integration_parameters.dt = 1e-6;
        self.inner.step();
    }

    /// Where body `index` is: position (m) and rotation; `None` when there is no such body.
    pub fn pose(&self, index: usize) -> Option<(DVec3, DQuat)> {
        let body = self.inner.bodies.get(self.bodies.get(index)?.handle)?;
        let p = body.position();
        Some((p.translation.as_dvec3(), p.rotation.as_dquat()))
    }

    /// Name of the body that a collider belongs to.
    pub fn name_of(&self, collider: ColliderHandle) -> Option<&str> {
        self.bodies.iter().find(|b| b.colliders.contains(&collider)).map(|b| b.name.as_str())
    }

    /// Whether any body follows a path.
    pub fn moving(&self) -> bool {
        self.moving
    }

    /// Moves the bodies that follow paths from time `t` to `t + dt` (s).
    pub fn step(&mut self, t: f64, dt: f64) {
        if !self.moving {
            return;
        }
        for body in self.bodies.iter().filter(|b| !b.path.is_empty()) {
            if let Some(rigid) = self.inner.bodies.get_mut(body.handle) {
                rigid.set_next_kinematic_position(pose(&body.placement, &body.path, t + dt));
            }
        }
        self.inner.integration_parameters.dt = dt as f32;
        self.inner.step();
    }

    /// Puts the bodies where their paths have them at time `t` (s), at rest.
    pub fn place(&mut self, t: f64) {
        for body in self.bodies.iter().filter(|b| !b.path.is_empty()) {
            if let Some(rigid) = self.inner.bodies.get_mut(body.handle) {
                rigid.set_position(pose(&body.placement, &body.path, t), true);
            }
        }
        if self.moving {
            self.settle();
        }
    }

    /// What a step looks at.
    pub fn view(&self) -> RigidView<'_> {
        let inner = &self.inner;
        let view = RigidView::new(&inner.broad_phase, &inner.narrow_phase, &inner.bodies, &inner.colliders);
        RigidView { owned: true, ..view }
    }
}

fn pose(placement: &Placement, path: &[PathKey], time: f64) -> Pose {
    let (offset, turn) = path_at(path, time);
    let moved = Placement { position: placement.position + offset, rotation: turn };
    Pose::from_parts(moved.position.as_vec3(), (moved.quaternion() * placement.quaternion()).as_quat())
}

fn polyhedra_of(scene: &Scene, shape: &Shape) -> Result<Vec<Polyhedron>, InputError> {
    match shape {
        Shape::File(file) => pol::read_pol_file(&scene.base.join(file)),
        Shape::Part(file, index) => {
            let mut all = pol::read_pol_file(&scene.base.join(file))?;
            if *index >= all.len() {
                let problem = format!("polyhedron {index} of {}, which holds {}", file.display(), all.len());
                return Err(InputError::new("shape", problem));
            }
            Ok(vec![all.swap_remove(*index)])
        }
        Shape::Polyhedron(polyhedron) => {
            polyhedron.check_closed().map_err(|e| InputError::new(format!("shape.{}", e.field), e.problem))?;
            Ok(vec![polyhedron.clone()])
        }
        Shape::Box(size) => Ok(vec![Polyhedron::cuboid(*size)]),
        Shape::Ball(_) | Shape::HalfSpace => Ok(Vec::new()),
    }
}

/// Polyhedra become oriented triangle meshes: convex or not, Parry then knows their inside.
fn shapes_of(shape: &Shape, polyhedra: &[Polyhedron]) -> Result<Vec<SharedShape>, InputError> {
    match shape {
        Shape::Ball(radius) => Ok(vec![SharedShape::ball(*radius as f32)]),
        Shape::HalfSpace => Ok(vec![SharedShape::halfspace(Vector::Y)]),
        Shape::File(_) | Shape::Part(..) | Shape::Polyhedron(_) | Shape::Box(_) => {
            polyhedra.iter().map(mesh_of).collect()
        }
    }
}

fn mesh_of(polyhedron: &Polyhedron) -> Result<SharedShape, InputError> {
    let vertices = polyhedron.vertices.iter().map(|p| p.as_vec3()).collect();
    SharedShape::trimesh_with_flags(vertices, polyhedron.triangulate(), TriMeshFlags::ORIENTED)
        .map_err(|e| InputError::new("shape", format!("cannot be made into a surface: {e}")))
}

/// Whether every vertex lies behind every face, but for rounding.
fn is_convex(polyhedron: &Polyhedron) -> bool {
    let (low, high) = polyhedron.bounds();
    let slack = 1e-6 * low.distance(high);
    (0..polyhedron.faces.len()).all(|face| {
        let normal = polyhedron.face_normal(face);
        let Some(on) = polyhedron.faces[face].first().and_then(|v| polyhedron.vertices.get(*v as usize)) else {
            return false;
        };
        polyhedron.vertices.iter().all(|p| (*p - *on).dot(normal) <= slack)
    })
}
