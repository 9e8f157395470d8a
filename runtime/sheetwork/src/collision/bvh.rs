//! Bounding boxes, and Parry's bounding volume hierarchy over the triangles of a sheet.
//!
//! The box of a triangle contains its positions at the start and at the end of the stage. It
//! therefore contains all positions between, since nodes move along straight lines. Parry's boxes
//! have single precision and are widened by the rounding error. Lengths in m.

use glam::{DMat3, DVec3, Vec3};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};

use crate::collision::collision_surface::{CollisionSurface, NONE, SurfaceEdge};
use crate::collision::features::ColliderPart;
use crate::collision::narrow_phase::SheetStageMotion;
use crate::math::{RigidFrame, Vectors};
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter};

/// An axis-aligned box, m; the default is empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BoundingBox {
    pub low: DVec3,
    pub high: DVec3,
}

impl Default for BoundingBox {
    fn default() -> Self {
        Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY }
    }
}

impl From<(DVec3, DVec3)> for BoundingBox {
    fn from((low, high): (DVec3, DVec3)) -> Self {
        Self { low, high }
    }
}

impl BoundingBox {
    pub fn from_positions(x: &Vectors) -> Self {
        x.bounds().map_or_else(Self::default, Self::from)
    }

    /// Box that a sheet sweeps in the stage, relative to the moving reference frame.
    pub fn swept(sheet: &SheetStageMotion, drift: &FrameMotion) -> Self {
        let end = Self::from_positions(sheet.end);
        Self::from_positions(sheet.start).joined(&Self { low: end.low - drift.end, high: end.high - drift.end })
    }

    /// Bounding box of a part of a collider with this frame.
    pub fn from_part(solid: &ColliderPart, frame: &RigidFrame) -> Self {
        Self::from(solid.bounds()).placed(frame)
    }

    /// World bounding box of a box given in `frame`.
    pub fn placed(&self, frame: &RigidFrame) -> Self {
        if !(self.low.is_finite() && self.high.is_finite()) {
            return *self;
        }
        let (centre, half) = (0.5 * (self.low + self.high), 0.5 * (self.high - self.low));
        let r = frame.rotation;
        let reach = DMat3::from_cols(r.x_axis.abs(), r.y_axis.abs(), r.z_axis.abs()) * half;
        let centre = frame.world(centre);
        Self { low: centre - reach, high: centre + reach }
    }

    pub fn grown(&self, by: f64) -> Self {
        Self { low: self.low - DVec3::splat(by), high: self.high + DVec3::splat(by) }
    }

    pub fn joined(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    #[inline]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    fn single(&self) -> Aabb {
        let room = 2e-7 * (self.low.abs().max(self.high.abs())).max_element();
        let room = DVec3::splat(room);
        Aabb::new((self.low - room).as_vec3(), (self.high + room).as_vec3())
    }
}

/// Displacement of the reference frame from the start of a stage to its base and to its end, m.
///
/// Overlap of swept boxes is tested in a frame that follows the mean motion: sheets that fall
/// together sweep almost no volume relative to each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FrameMotion {
    pub base: DVec3,
    pub end: DVec3,
}

impl FrameMotion {
    /// Mean motion of some sheets.
    pub fn mean_of<'a>(sheets: impl Iterator<Item = &'a SheetStageMotion<'a>>) -> Self {
        let (mut sum, mut count) = (Self::default(), 0);
        for sheet in sheets {
            let start = sheet.start.iter().sum::<DVec3>();
            sum.base += sheet.base.iter().sum::<DVec3>() - start;
            sum.end += sheet.end.iter().sum::<DVec3>() - start;
            count += sheet.start.len();
        }
        let per = 1.0 / count.max(1) as f64;
        Self { base: sum.base * per, end: sum.end * per }
    }
}

/// Bounding volume hierarchy over the triangles of a sheet in a stage, and its normals at the base.
pub(crate) struct SurfaceTree {
    pub(crate) id: u32,
    revision: u64,
    tree: Bvh,
    /// Reference frame and growth (m) of the boxes; `None` if they belong to another stage.
    fresh: Option<(FrameMotion, f64)>,
    has_ridges: bool,
    /// Box of each node over the stage.
    boxes: Vec<BoundingBox>,
    /// Box of each triangle over the stage.
    triangle_boxes: Vec<BoundingBox>,
    /// Upper bound (m) of the motion of any node within the stage, in the reference frame.
    pub travel: f64,
    /// Centroids of the triangles, m.
    middles: Vec<DVec3>,
    /// Area vectors of the triangles (normal times twice the area), world axes, m².
    areas: Vec<DVec3>,
    /// Sum of the area vectors of the triangles at each node, world axes, m².
    node_areas: Vec<DVec3>,
    /// Height of each edge above the line between the centroids of its triangles, world axes, m;
    /// zero at the border.
    ridges: Vec<DVec3>,
    /// Positions of the nodes relative to the first when the sheet was found flat, m; empty if it
    /// was not.
    flat_at: Vec<Vec3>,
    /// Least height of a triangle at rest, m.
    height: f64,
    /// Whether the sheet has several layers.
    pub is_multilayer: bool,
}

impl SurfaceTree {
    pub fn new(id: u32, skin: &CollisionSurface) -> Self {
        let boxes = skin.triangles().iter().enumerate().map(|(i, t)| {
            let place = skin.middle(t);
            (i, Aabb::new(place.as_vec3(), place.as_vec3()).loosened(t.size as f32))
        });
        Self {
            id,
            revision: skin.revision(),
            tree: Bvh::from_iter(BvhBuildStrategy::Binned, boxes),
            fresh: None,
            has_ridges: false,
            boxes: vec![BoundingBox::default(); skin.node_count()],
            triangle_boxes: vec![BoundingBox::default(); skin.triangles().len()],
            travel: 0.0,
            middles: vec![DVec3::ZERO; skin.triangles().len()],
            areas: vec![DVec3::ZERO; skin.triangles().len()],
            node_areas: vec![DVec3::ZERO; skin.node_count()],
            ridges: vec![DVec3::ZERO; skin.edges().len()],
            flat_at: Vec::with_capacity(skin.node_count()),
            height: skin.least_height(),
            is_multilayer: skin.is_multilayer(),
        }
    }

    pub fn is_of(&self, id: u32, skin: &CollisionSurface) -> bool {
        let counts = self.areas.len() == skin.triangles().len() && self.node_areas.len() == skin.node_count();
        self.id == id && self.revision == skin.revision() && counts
    }

    pub fn forget(&mut self) {
        (self.fresh, self.has_ridges) = (None, false);
    }

    /// Update the boxes (relative to `drift`, grown by `room`, m) and the normals.
    pub fn refresh(&mut self, sheet: &SheetStageMotion, drift: &FrameMotion, room: f64) {
        let before = self.fresh.replace((*drift, room));
        if before == self.fresh {
            return;
        }
        let by = DVec3::splat(room);
        let mut furthest = 0.0_f64;
        for (i, around) in self.boxes.iter_mut().enumerate() {
            let (p, base, q) = (sheet.start.get(i), sheet.base.get(i) - drift.base, sheet.end.get(i) - drift.end);
            furthest = furthest.max(p.distance_squared(q)).max(p.distance_squared(base));
            *around = BoundingBox { low: p.min(q).min(base) - by, high: p.max(q).max(base) + by };
        }
        // The path from the base to the end by way of the start is at most twice the longer of its
        // parts.
        self.travel = 2.0 * furthest.sqrt();
        for (i, t) in sheet.skin.triangles().iter().enumerate() {
            let [a, b, c] = t.nodes.map(|m| &self.boxes[m as usize]);
            let around = a.joined(b).joined(c);
            self.triangle_boxes[i] = around;
            self.tree.insert_or_update_partially(around.single(), i as u32, 0.0);
        }
        self.tree.refit_without_opt();
        if before.is_none() {
            self.turn(sheet);
        }
    }

    /// Update the normals to the base.
    fn turn(&mut self, sheet: &SheetStageMotion) {
        self.node_areas.fill(DVec3::ZERO);
        for (area, t) in self.areas.iter_mut().zip(sheet.skin.triangles()) {
            *area = area_of(sheet.base, t.nodes);
            t.nodes.iter().for_each(|m| self.node_areas[*m as usize] += *area);
        }
    }

    /// Update the ridges to the base, once per call of detection. With `bends`, the ridge at the
    /// end replaces that at the base where it is higher.
    pub fn refresh_ridges(&mut self, sheet: &SheetStageMotion, bends: bool) {
        if std::mem::replace(&mut self.has_ridges, true) {
            return;
        }
        self.each_ridge(sheet.skin, sheet.base, |ridge, now| *ridge = now);
        if bends {
            self.each_ridge(sheet.skin, sheet.end, |ridge, now| {
                if now.length_squared() > ridge.length_squared() {
                    *ridge = now;
                }
            });
        }
    }

    /// Call `take` with each stored ridge and its value for the positions `x`.
    fn each_ridge(&mut self, skin: &CollisionSurface, x: &Vectors, take: impl Fn(&mut DVec3, DVec3)) {
        for (middle, t) in self.middles.iter_mut().zip(skin.triangles()) {
            *middle = t.nodes.iter().map(|i| x.get(*i as usize)).sum::<DVec3>() / 3.0;
        }
        for (ridge, edge) in self.ridges.iter_mut().zip(skin.edges()).filter(|(_, edge)| !edge.is_border()) {
            let [a, b] = edge.nodes.map(|i| x.get(i as usize));
            let [s, t] = edge.triangles.map(|t| self.middles[t as usize]);
            let (along, aside) = (b - a, s + t - 2.0 * a);
            // The centroid of a triangle is a third of its height from the edge. Over two triangles
            // that fall away by h₁ and h₂ the edge stands out by (h₁ + h₂)/4 above the line between
            // the midpoints of the other sides.
            take(ridge, 0.75 * (aside - along * (aside.dot(along) / along.length_squared())));
        }
    }

    /// Height of an inner edge above its triangles, directed to the concave side, m.
    pub fn ridge(&self, edge: u32) -> DVec3 {
        self.ridges[edge as usize]
    }

    /// Unit normal of the sheet at a node at the base, world axes; zero without triangles.
    pub fn node_normal(&self, i: usize) -> DVec3 {
        self.node_areas[i].normalize_or_zero()
    }

    /// Box of a node over the stage, with the same growth as those of the triangles.
    #[inline]
    pub fn node_box(&self, i: u32) -> &BoundingBox {
        &self.boxes[i as usize]
    }

    /// Box of a triangle over the stage.
    #[inline]
    pub fn triangle_box(&self, t: u32) -> &BoundingBox {
        &self.triangle_boxes[t as usize]
    }

    /// Determine whether the sheet is flat: all normals within 30° of their mean.
    pub fn look_whether_flat(&mut self, skin: &CollisionSurface, x: &Vectors) {
        if self.is_as_it_was_flat(x) {
            return;
        }
        self.flat_at.clear();
        if skin.is_rectangle() && is_flat(skin, x, 0.75) {
            let first = x.get(0);
            self.flat_at.extend(x.iter().map(|p| (p - first).as_vec3()));
        }
    }

    /// Serialise the state that carries over between steps.
    pub fn serialise(&self, to: &mut StateWriter) {
        to.count(u64::from(self.id));
        to.count(self.flat_at.len() as u64);
        self.flat_at.iter().for_each(|p| to.singles(&p.to_array()));
    }

    /// Deserialise the tree of a sheet; `skin` returns its collision surface by identifier.
    pub fn deserialise<'s>(
        from: &mut StateReader,
        skin: impl Fn(u32) -> Option<&'s CollisionSurface>,
    ) -> ReadResult<Self> {
        let id = from.count_u32()?;
        let mut tree = Self::new(id, skin(id).ok_or(CorruptState)?);
        let count = from.length(12)?;
        if count != 0 && count != tree.boxes.len() {
            return Err(CorruptState);
        }
        for _ in 0..count {
            let mut place = [0.0; 3];
            from.singles(&mut place)?;
            tree.flat_at.push(Vec3::from_array(place));
        }
        Ok(tree)
    }

    /// Whether the sheet was flat at the start of the step.
    pub fn looks_flat(&self) -> bool {
        !self.flat_at.is_empty()
    }

    /// Least height of a triangle at rest, m.
    pub fn height(&self) -> f64 {
        self.height
    }

    /// Whether all normals stay within 45° of their mean at the start and at the end of the stage.
    /// A rectangle for which this holds is a height graph over a plane and has no self-contact.
    pub fn stays_flat(&self, sheet: &SheetStageMotion) -> bool {
        if self.flat_at.is_empty() {
            return false;
        }
        [sheet.start, sheet.end].into_iter().all(|x| self.is_as_it_was_flat(x) || is_flat(sheet.skin, x, 0.5))
    }

    /// Whether the sheet was found flat and its nodes have moved little relative to each other: a
    /// shift δ of the nodes turns a triangle of height h by at most 2 δ/h, here 0.1 rad.
    fn is_as_it_was_flat(&self, x: &Vectors) -> bool {
        if self.flat_at.is_empty() || self.flat_at.len() != x.len() {
            return false;
        }
        let (first, allowed) = (x.get(0), 0.05 * self.height);
        let moved = |(i, p): (usize, &Vec3)| (x.get(i) - first - p.as_dvec3()).length_squared();
        self.flat_at.iter().enumerate().all(|m| moved(m) <= allowed * allowed)
    }

    /// Indices of the triangles whose boxes overlap `around`.
    pub fn triangles_in(&self, around: &BoundingBox) -> impl Iterator<Item = u32> + '_ {
        let around = around.single();
        self.tree.leaves(move |node| around.intersects(&node.aabb()))
    }

    /// Pairs of triangles with overlapping boxes, of this sheet and another that sweeps `around`.
    /// The tree is queried for each triangle: Parry's traversal of two trees allocates memory for
    /// deep trees.
    pub fn pairs_with<'a>(&'a self, other: &'a Self, around: BoundingBox) -> impl Iterator<Item = (u32, u32)> + 'a {
        let own = self.triangle_boxes.iter().zip(0_u32..).filter(move |(cuboid, _)| cuboid.overlaps(&around));
        own.flat_map(|(cuboid, p)| other.triangles_in(cuboid).map(move |q| (p, q)))
    }

    /// Call `visit` once for each pair of triangles of this sheet with overlapping boxes.
    pub fn own_pairs(&self, workspace: &mut BvhWorkspace, mut visit: impl FnMut(u32, u32)) {
        self.tree.traverse_bvtt_single_tree::<false>(workspace, &mut visit);
    }

    /// Mean normal of the triangles at an edge, world axes.
    pub fn edge_normal(&self, triangles: [u32; 2]) -> DVec3 {
        let sum: DVec3 = triangles.into_iter().filter(|t| *t != NONE).map(|t| self.areas[t as usize]).sum();
        sum.normalize_or_zero()
    }

    /// Unit normals of the triangles at an edge; at the border that of the only one, twice.
    pub fn edge_normals(&self, [first, second]: [u32; 2]) -> [DVec3; 2] {
        [first, if second == NONE { first } else { second }].map(|t| self.areas[t as usize].normalize_or_zero())
    }
}

#[inline]
fn area_of(x: &Vectors, masses: [u32; 3]) -> DVec3 {
    let [a, b, c] = masses.map(|m| x.get(m as usize));
    (b - a).cross(c - a)
}

/// Vectors from an edge to the centroids of its triangles, perpendicular to the edge, at the base,
/// m.
pub(crate) fn flanks<'a>(sheet: &SheetStageMotion<'a>, edge: &SurfaceEdge) -> impl Iterator<Item = DVec3> + use<'a> {
    let (base, skin) = (sheet.base, sheet.skin);
    let [a, b] = edge.nodes.map(|i| base.get(i as usize));
    let along = (b - a).normalize_or(DVec3::X);
    edge.triangles.into_iter().filter(|t| *t != NONE).map(move |t| {
        let masses = skin.triangles()[t as usize].nodes;
        let middle = masses.iter().map(|i| base.get(*i as usize)).sum::<DVec3>() / 3.0;
        (middle - a).reject_from_normalized(along)
    })
}

/// Whether the squared cosine between each triangle normal and their mean exceeds `cosine_squared`.
pub(crate) fn is_flat(skin: &CollisionSurface, x: &Vectors, cosine_squared: f64) -> bool {
    let areas = || skin.triangles().iter().map(|t| area_of(x, t.nodes));
    let mean = areas().sum::<DVec3>().normalize_or_zero();
    areas().all(|n| {
        let along = n.dot(mean);
        along > 0.0 && along * along > cosine_squared * n.length_squared()
    })
}
