//! Vertices, edges and triangles of sheets and bodies for the barrier method, and the search for
//! stencils among them.
//!
//! Vertices are numbered through: the nodes of all sheets, then the vertices of the bodies. Boxes
//! around features that move by a displacement are swept along x, object against object.

use std::sync::Arc;

use glam::DVec3;

use crate::collision::features::{ColliderFeatures, ColliderPart};
use crate::collision::narrow_phase::ContactPair;
use crate::contact::IslandView;
use crate::contact::barrier::stencil::{Features, Stencil};
use crate::contact::settings::{BarrierSettings, ContactSettings};
use crate::math::RigidFrame;

const SETTINGS: BarrierSettings = ContactSettings::DEFAULT.barrier;

/// Owner of a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) enum Owner {
    /// Node of a sheet of the island.
    Node { sheet: u32, node: u32 },
    /// Point of a body of the island, in its frame, m.
    Body { body: u32, local: DVec3 },
}

/// Vertices of a feature, ascending or in the order of the feature; unused ones repeat the first.
type Feature = [u32; 3];

/// Features of one kind of an object, with their boxes by least x.
#[derive(Default)]
struct Boxes {
    sorted: Vec<(DVec3, DVec3, Feature)>,
    /// Greatest extent of a box along x, m.
    wide: f64,
}

impl Boxes {
    fn rebuild(&mut self, features: &[Feature], (x, d): (&[DVec3], &[DVec3]), room: f64) {
        self.sorted.clear();
        self.wide = 0.0;
        for feature in features {
            let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for i in feature.map(|i| i as usize) {
                low = low.min(x[i]).min(x[i] + d[i]);
                high = high.max(x[i]).max(x[i] + d[i]);
            }
            self.wide = self.wide.max(high.x - low.x + 2.0 * room);
            self.sorted.push((low - room, high + room, *feature));
        }
        self.sorted.sort_unstable_by(|a, b| a.0.x.total_cmp(&b.0.x).then(a.2.cmp(&b.2)));
    }

    /// Call `visit` for each pair of features whose boxes overlap.
    fn for_each_pair(&self, other: &Self, mut visit: impl FnMut(Feature, Feature)) {
        for (low, high, a) in &self.sorted {
            let first = other.sorted.partition_point(|b| b.0.x < low.x - other.wide);
            for (under, over, b) in other.sorted[first..].iter().take_while(|b| b.0.x <= high.x) {
                if under.cmple(*high).all() && over.cmpge(*low).all() {
                    visit(*a, *b);
                }
            }
        }
    }
}

/// A sheet, or a collider of a body.
#[derive(Default)]
struct Object {
    /// Sheet of the island; `None` for a body.
    sheet: Option<u32>,
    /// Part of the detection, for a body.
    part: u32,
    /// Half thickness, m; 0 for a body.
    half: f64,
    points: Vec<Feature>,
    edges: Vec<Feature>,
    triangles: Vec<Feature>,
    /// Radius of a ball around its only point, m.
    radius: f64,
    /// Point and point along the normal of a half space.
    plane: Option<[u32; 2]>,
    /// Corners of the box around its moving features, m.
    low: DVec3,
    high: DVec3,
    /// Whether another object is near.
    is_met: bool,
    boxes: [Boxes; 3],
}

/// A collider near the island.
#[derive(Clone)]
pub(crate) struct BarrierCollider<'a> {
    /// Part of the detection.
    pub part: u32,
    /// Body of the island.
    pub body: u32,
    pub features: &'a Arc<ColliderFeatures>,
    /// Frame of the collider in that of its body.
    pub frame: &'a RigidFrame,
}

impl Object {
    fn is_near(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && self.high.cmpge(other.low).all()
    }
}

/// Number of nodes, and revision and checksum of the surface, of a sheet.
fn key_of(island: &IslandView, local: usize) -> (usize, u64, u32) {
    let surface = island.contacts[local].surface.as_ref();
    let (revision, checksum) = surface.map_or((0, 0), |surface| (surface.revision(), surface.checksum()));
    (island.sheets[local].node_count(), revision, checksum)
}

/// A node attached to a point of a dynamic body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BarrierAttachment {
    pub sheet: u32,
    pub node: u32,
    /// Body of the island, and point in its frame, m.
    pub body: u32,
    pub local: DVec3,
}

/// All features of an island.
#[derive(Default)]
pub(super) struct Surfaces {
    pub owners: Vec<Owner>,
    /// Position of each vertex at the start of the substep and at the present iterate, m.
    pub start: Vec<DVec3>,
    pub x: Vec<DVec3>,
    /// Vertices of node and point of the attachments.
    pub attached: Vec<[u32; 2]>,
    objects: Vec<Object>,
    /// First vertex of each sheet.
    first: Vec<u32>,
    /// Sheets and colliders whose features these are.
    sheets: Vec<(usize, u64, u32)>,
    colliders: Vec<(u32, u32, Arc<ColliderFeatures>, RigidFrame)>,
}

impl Surfaces {
    /// Collect the sheets of `island` and the `colliders`, each with its body of the island and its
    /// frame in it.
    pub fn build<'a>(&mut self, island: &IslandView, colliders: impl Iterator<Item = BarrierCollider<'a>> + Clone) {
        if self.is_built(island, colliders.clone()) {
            self.owners.truncate(self.owners.len() - self.attached.len());
            self.attached.clear();
            return;
        }
        self.sheets.clear();
        self.sheets.extend((0..island.sheets.len()).map(|local| key_of(island, local)));
        self.colliders.clear();
        self.owners.clear();
        self.attached.clear();
        self.objects.clear();
        self.first.clear();
        for (local, sheet) in (0..island.sheets.len() as u32).zip(island.sheets.iter()) {
            let first = self.owners.len() as u32;
            self.first.push(first);
            self.owners.extend((0..sheet.node_count() as u32).map(|node| Owner::Node { sheet: local, node }));
            let Some(surface) = &island.contacts[local as usize].surface else { continue };
            let mut object = Object { sheet: Some(local), half: surface.contact_offset(), ..Object::default() };
            for triangle in surface.triangles() {
                object.triangles.push(triangle.nodes.map(|i| first + i));
                for (node, owned) in triangle.nodes.iter().zip(triangle.owns_node) {
                    if owned {
                        object.points.push([first + node; 3]);
                    }
                }
                for (edge, owned) in triangle.edges.iter().zip(triangle.owns_edge) {
                    let [a, b] = surface.edges()[*edge as usize].nodes;
                    if owned {
                        object.edges.push([first + a, first + b, first + a]);
                    }
                }
            }
            self.objects.push(object);
        }
        for BarrierCollider { part, body, features, frame } in colliders {
            for (_, solid) in features.solids() {
                let object = self.body_object(body, solid, frame);
                self.objects.push(Object { part, ..object });
            }
            self.colliders.push((part, body, features.clone(), *frame));
        }
    }

    /// Whether the features are those of these sheets and colliders.
    fn is_built<'a>(&self, island: &IslandView, colliders: impl Iterator<Item = BarrierCollider<'a>>) -> bool {
        let mut known = self.colliders.iter();
        let mut is_known = |c: BarrierCollider| {
            known.next().is_some_and(|(part, body, features, frame)| {
                (c.part, c.body) == (*part, *body) && Arc::ptr_eq(c.features, features) && c.frame == frame
            })
        };
        let sheets = (0..island.sheets.len()).map(|local| key_of(island, local));
        let mut colliders = colliders;
        sheets.eq(self.sheets.iter().copied()) && colliders.all(&mut is_known) && known.next().is_none()
    }

    fn body_object(&mut self, body: u32, solid: &ColliderPart, frame: &RigidFrame) -> Object {
        let mut object = Object::default();
        let mut vertex = |p: DVec3| {
            self.owners.push(Owner::Body { body, local: frame.world(p) });
            self.owners.len() as u32 - 1
        };
        match solid {
            ColliderPart::HalfSpace { normal } => object.plane = Some([vertex(DVec3::ZERO), vertex(*normal)]),
            ColliderPart::Ball { centre, radius } => {
                object.points.push([vertex(*centre); 3]);
                object.radius = *radius;
            }
            ColliderPart::Mesh(mesh) => {
                let all: Vec<u32> = mesh.vertices.iter().map(|p| vertex(*p)).collect();
                object.triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| all[i as usize])));
                object.points.extend(mesh.corners().iter().map(|corner| [vertex(corner.position); 3]));
                for edge in mesh.edges() {
                    let [a, b] = edge.ends.map(&mut vertex);
                    object.edges.push([a, b, a]);
                }
            }
        }
        object
    }

    /// Add the points of attachments, after [`Surfaces::build`].
    pub fn attach(&mut self, attachments: &[BarrierAttachment]) {
        for of in attachments {
            let point = self.owners.len() as u32;
            self.owners.push(Owner::Body { body: of.body, local: of.local });
            self.attached.push([self.vertex(of.sheet, of.node) as u32, point]);
        }
    }

    /// Whether a vertex of a stencil is attached to the body of another.
    pub fn is_attached(&self, stencil: &Stencil) -> bool {
        let body = |i: u32| match self.owners[i as usize] {
            Owner::Body { body, .. } => Some(body),
            Owner::Node { .. } => None,
        };
        self.attached.iter().any(|[node, point]| {
            stencil.vertices.contains(node) && stencil.vertices.iter().any(|i| body(*i) == body(*point))
        })
    }

    /// Whether two edges are parallel at the start: their ends, which are points over triangles,
    /// are then as near as any of their points.
    fn are_parallel(&self, p: Feature, q: Feature) -> bool {
        let along = |edge: Feature| self.start[edge[1] as usize] - self.start[edge[0] as usize];
        let (a, b) = (along(p), along(q));
        a.cross(b).length_squared()
            < SETTINGS.parallel_sine * SETTINGS.parallel_sine * a.length_squared() * b.length_squared()
    }

    /// Vertex of a node.
    pub fn vertex(&self, sheet: u32, node: u32) -> usize {
        (self.first[sheet as usize] + node) as usize
    }

    /// Write to `found` the stencils that can come nearer than their offset while the vertices move
    /// from the present iterate by `d` (m). `friction` returns the friction coefficient of a pair.
    pub fn find(
        &mut self,
        island: &IslandView,
        d: &[DVec3],
        friction: &dyn Fn(ContactPair) -> Option<f64>,
        found: &mut Vec<Stencil>,
    ) {
        found.clear();
        let mut objects = std::mem::take(&mut self.objects);
        self.mark_met(island, &mut objects, d);
        for object in objects.iter_mut().filter(|object| object.is_met) {
            let room = object.half * (1.0 + SETTINGS.search_margin);
            let [points, edges, triangles] = &mut object.boxes;
            points.rebuild(&object.points, (&self.x, d), room + object.radius);
            edges.rebuild(&object.edges, (&self.x, d), room);
            triangles.rebuild(&object.triangles, (&self.x, d), room);
        }
        for (i, a) in objects.iter().enumerate() {
            let Some(sheet) = a.sheet else { continue };
            for (j, b) in objects.iter().enumerate().skip(i) {
                let misses = if i == j { self.stays_apart(island, sheet, d) } else { !a.is_near(b) };
                if misses {
                    continue;
                }
                let pair = b.sheet.map_or(ContactPair::SheetBody(sheet, b.part), |b| ContactPair::Sheets(sheet, b));
                if let Some(friction) = friction(pair) {
                    self.find_between(island, (a, b, friction), d, found);
                }
            }
        }
        self.objects = objects;
    }

    /// Compute the boxes of the objects, and which of them are near another or may meet themselves.
    fn mark_met(&self, island: &IslandView, objects: &mut [Object], d: &[DVec3]) {
        for object in objects.iter_mut() {
            let room = object.half * (1.0 + SETTINGS.search_margin) + object.radius;
            (object.low, object.high, object.is_met) = (DVec3::INFINITY, DVec3::NEG_INFINITY, false);
            let corners = object.points.iter().chain(&object.edges).flatten();
            for i in corners.map(|i| *i as usize) {
                object.low = object.low.min(self.x[i] - room).min(self.x[i] + d[i] - room);
                object.high = object.high.max(self.x[i] + room).max(self.x[i] + d[i] + room);
            }
            if object.plane.is_some() {
                (object.low, object.high) = (DVec3::NEG_INFINITY, DVec3::INFINITY);
            }
        }
        for i in 0..objects.len() {
            let Some(sheet) = objects[i].sheet else { continue };
            objects[i].is_met |= !self.stays_apart(island, sheet, d);
            for j in i + 1..objects.len() {
                if objects[i].is_near(&objects[j]) && objects[j].plane.is_none() {
                    (objects[i].is_met, objects[j].is_met) = (true, true);
                }
            }
        }
    }

    /// Whether a sheet has no contact with itself: it has layers, or it is a rectangle that stays a
    /// height graph over the plane of its mean normal.
    fn stays_apart(&self, island: &IslandView, sheet: u32, d: &[DVec3]) -> bool {
        let Some(surface) = &island.contacts[sheet as usize].surface else { return true };
        if !surface.is_rectangle() {
            return surface.is_multilayer();
        }
        [0.0, 1.0].into_iter().all(|part| {
            let at = |i: u32| {
                let i = self.vertex(sheet, i);
                self.x[i] + d[i] * part
            };
            let normal = |nodes: [u32; 3]| {
                let [a, b, c] = nodes.map(at);
                (b - a).cross(c - a)
            };
            let mean = surface.triangles().iter().map(|t| normal(t.nodes)).sum::<DVec3>().normalize_or_zero();
            let graph = |n: DVec3| n.dot(mean) > SETTINGS.graph_cosine * n.length();
            surface.triangles().iter().all(|t| graph(normal(t.nodes)))
        })
    }

    /// Stencil of `vertices`, with the sum of the half thicknesses, the range of the barrier and
    /// the friction.
    fn stencil(
        &self,
        (features, vertices, radius): (Features, [u32; 4], f64),
        (offset, range, friction): (f64, f64, f64),
    ) -> Stencil {
        let mut stencil = Stencil { features, vertices, radius, offset, limit: 0.0, friction, stiffness: 0.0 };
        let start = stencil.closest(vertices.map(|i| self.start[i as usize])).distance;
        // Features that start nearer, as on a compressed sheet, keep a part of their distance.
        let kept = if start > 0.0 { SETTINGS.kept_distance * start } else { start - range };
        stencil.limit = (stencil.offset - range).min(kept);
        stencil
    }

    /// Stencils between a sheet `a` and an object `b`.
    fn find_between(
        &self,
        island: &IslandView,
        (a, b, friction): (&Object, &Object, f64),
        d: &[DVec3],
        found: &mut Vec<Stencil>,
    ) {
        let offset = a.half + b.half;
        let itself = a.sheet.filter(|_| a.sheet == b.sheet);
        let surface = itself.and_then(|s| island.contacts[s as usize].surface.as_ref().map(|surface| (s, surface)));
        let apart_at_rest = |p: &[u32], q: &[u32]| {
            let Some((sheet, surface)) = &surface else { return true };
            let first = self.first[*sheet as usize];
            let size = |f: &[u32]| {
                f.iter()
                    .flat_map(|i| f.iter().map(move |j| surface.rest_distance(i - first, j - first)))
                    .fold(0.0, f64::max)
            };
            let reach = offset + size(p).max(size(q));
            p.iter().all(|i| q.iter().all(|j| surface.rest_distance(i - first, j - first) >= reach))
        };
        // Twice the thinner half thickness: the thinner sheet is not deeper in the thicker one.
        let thinner = if b.half > 0.0 { 2.0 * a.half.min(b.half) } else { offset };
        let law = (offset, SETTINGS.range * thinner, friction);
        let mut add = |features, vertices, radius| found.push(self.stencil((features, vertices, radius), law));
        if let Some([origin, along]) = b.plane {
            let n = (self.x[along as usize] - self.x[origin as usize]).normalize_or(DVec3::Y);
            for p in &a.points {
                let i = p[0] as usize;
                let height = n.dot(self.x[i] - self.x[origin as usize]);
                let falls = (d[origin as usize] - d[i]).dot(n).max(0.0);
                if height - falls < offset * (1.0 + SETTINGS.search_margin) {
                    add(Features::PointPlane, [p[0], origin, along, p[0]], 0.0);
                }
            }
            return;
        }
        let pair = |p: Feature, q: Feature| [p[0], q[0], q[1], q[2]];
        a.boxes[0].for_each_pair(&b.boxes[2], |p, q| {
            if apart_at_rest(&p[..1], &q) {
                add(Features::PointTriangle, pair(p, q), 0.0);
            }
        });
        a.boxes[1].for_each_pair(&b.boxes[1], |p, q| {
            if (itself.is_none() || p < q) && !self.are_parallel(p, q) && apart_at_rest(&p[..2], &q[..2]) {
                add(Features::Edges, [p[0], p[1], q[0], q[1]], 0.0);
            }
        });
        if itself.is_none() {
            b.boxes[0].for_each_pair(&a.boxes[2], |p, q| add(Features::PointTriangle, pair(p, q), b.radius));
        }
    }
}
