//! Boxes in the world and Parry's tree of boxes over the triangles of a sheet.
//!
//! A triangle's box holds it at the start and at the end of the stage, and with it all of the way between, since its masses
//! move along straight lines. Parry's boxes are in single precision; they are widened by what that loses.

use glam::{DMat3, DVec3, Vec3};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};

use crate::collision::collision_surface::{NONE, Skin, SkinEdge};
use crate::collision::features::Solid;
use crate::collision::narrow_phase::SheetMotion;
use crate::math::RigidFrame;
use crate::math::Vectors;
use crate::serialize::{Cut, Keeper, Taken, Taker};

/// A box with sides along the axes, m; the default holds nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cuboid {
    pub low: DVec3,
    pub high: DVec3,
}

impl Default for Cuboid {
    fn default() -> Self {
        Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY }
    }
}

impl From<(DVec3, DVec3)> for Cuboid {
    fn from((low, high): (DVec3, DVec3)) -> Self {
        Self { low, high }
    }
}

impl Cuboid {
    pub fn of(x: &Vectors) -> Self {
        x.bounds().map_or_else(Self::default, Self::from)
    }

    /// The box that a sheet sweeps in the stage, seen from what drifts along.
    pub fn swept(sheet: &SheetMotion, drift: &Drift) -> Self {
        let end = Self::of(sheet.end);
        Self::of(sheet.start).joined(&Self { low: end.low - drift.end, high: end.high - drift.end })
    }

    /// The box around a solid at a place.
    pub fn of_solid(solid: &Solid, frame: &RigidFrame) -> Self {
        Self::from(solid.bounds()).placed(frame)
    }

    /// The box in the world around a box of a frame.
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
    pub fn meets(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    fn single(&self) -> Aabb {
        let room = 2e-7 * (self.low.abs().max(self.high.abs())).max_element();
        let room = DVec3::splat(room);
        Aabb::new((self.low - room).as_vec3(), (self.high + room).as_vec3())
    }
}

/// How far what sheets are seen from goes between the start of a stage and its base, and its end, m.
///
/// Whether two sheets meet is the same seen from whatever moves steadily: sheets that fall together sweep next to nothing as
/// seen from one another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Drift {
    pub base: DVec3,
    pub end: DVec3,
}

impl Drift {
    /// The mean motion of some sheets.
    pub fn of<'a>(sheets: impl Iterator<Item = &'a SheetMotion<'a>>) -> Self {
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

/// The triangles of a sheet by where they are in a stage, and the normals they have at its base.
pub(crate) struct SkinTree {
    id: u32,
    revision: u64,
    tree: Bvh,
    /// What the boxes are seen from, and how much they are grown (m); `None` when they are of another stage.
    fresh: Option<(Drift, f64)>,
    has_ridges: bool,
    /// Box of each mass over the stage.
    boxes: Vec<Cuboid>,
    /// Box of each triangle over the stage.
    triangle_boxes: Vec<Cuboid>,
    /// Furthest that any mass goes between the start, the base and the end, as seen from what drifts along, m.
    pub travel: f64,
    /// Middles of the triangles, m.
    middles: Vec<DVec3>,
    /// Area vectors of the triangles (twice the area along the normal), world, m².
    areas: Vec<DVec3>,
    /// Sum of the area vectors of the triangles at each mass, world, m².
    mass_areas: Vec<DVec3>,
    /// How far each edge stands out of the line between the middles of its triangles, world, m; none at the border.
    ridges: Vec<DVec3>,
    /// Where the masses were, seen from the first, when the sheet was found flat; empty when it was not.
    flat_at: Vec<Vec3>,
    /// Least height of a triangle at rest, m.
    height: f64,
    /// Whether it is of several layers.
    pub stack: bool,
}

impl SkinTree {
    pub fn new(id: u32, skin: &Skin) -> Self {
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
            boxes: vec![Cuboid::default(); skin.masses()],
            triangle_boxes: vec![Cuboid::default(); skin.triangles().len()],
            travel: 0.0,
            middles: vec![DVec3::ZERO; skin.triangles().len()],
            areas: vec![DVec3::ZERO; skin.triangles().len()],
            mass_areas: vec![DVec3::ZERO; skin.masses()],
            ridges: vec![DVec3::ZERO; skin.edges().len()],
            flat_at: Vec::with_capacity(skin.masses()),
            height: skin.least_height(),
            stack: skin.is_stack(),
        }
    }

    /// Number of the sheet that it is of.
    pub fn of(&self) -> u32 {
        self.id
    }

    pub fn is_of(&self, id: u32, skin: &Skin) -> bool {
        let counts = self.areas.len() == skin.triangles().len() && self.mass_areas.len() == skin.masses();
        self.id == id && self.revision == skin.revision() && counts
    }

    pub fn forget(&mut self) {
        (self.fresh, self.has_ridges) = (None, false);
    }

    /// Brings boxes (seen from `drift`, grown by `room`, m) and normals to where the sheet is.
    pub fn refresh(&mut self, sheet: &SheetMotion, drift: &Drift, room: f64) {
        let before = self.fresh.replace((*drift, room));
        if before == self.fresh {
            return;
        }
        let by = DVec3::splat(room);
        let mut furthest = 0.0_f64;
        for (i, around) in self.boxes.iter_mut().enumerate() {
            let (p, base, q) = (sheet.start.get(i), sheet.base.get(i) - drift.base, sheet.end.get(i) - drift.end);
            furthest = furthest.max(p.distance_squared(q)).max(p.distance_squared(base));
            *around = Cuboid { low: p.min(q).min(base) - by, high: p.max(q).max(base) + by };
        }
        // To the end by way of the start, from wherever the base is: twice the longer of both ways is enough.
        self.travel = 2.0 * furthest.sqrt();
        for (i, t) in sheet.skin.triangles().iter().enumerate() {
            let [a, b, c] = t.masses.map(|m| &self.boxes[m as usize]);
            let around = a.joined(b).joined(c);
            self.triangle_boxes[i] = around;
            self.tree.insert_or_update_partially(around.single(), i as u32, 0.0);
        }
        self.tree.refit_without_opt();
        if before.is_none() {
            self.turn(sheet);
        }
    }

    /// Brings the normals to where the sheet is.
    fn turn(&mut self, sheet: &SheetMotion) {
        self.mass_areas.fill(DVec3::ZERO);
        for (area, t) in self.areas.iter_mut().zip(sheet.skin.triangles()) {
            *area = area_of(sheet.base, t.masses);
            t.masses.iter().for_each(|m| self.mass_areas[*m as usize] += *area);
        }
    }

    /// Brings the ridges to where the sheet is, once a call; where it `bends`, of each the one at the end where that stands out further.
    pub fn refresh_ridges(&mut self, sheet: &SheetMotion, bends: bool) {
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

    /// Calls `take` with each ridge and what it is where the masses are at `x`.
    fn each_ridge(&mut self, skin: &Skin, x: &Vectors, take: impl Fn(&mut DVec3, DVec3)) {
        for (middle, t) in self.middles.iter_mut().zip(skin.triangles()) {
            *middle = t.masses.iter().map(|i| x.get(*i as usize)).sum::<DVec3>() / 3.0;
        }
        for (ridge, edge) in self.ridges.iter_mut().zip(skin.edges()).filter(|(_, edge)| !edge.is_border()) {
            let [a, b] = edge.masses.map(|i| x.get(i as usize));
            let [s, t] = edge.triangles.map(|t| self.middles[t as usize]);
            let (along, aside) = (b - a, s + t - 2.0 * a);
            // The middle of a triangle is a third of its height from the edge; over two triangles that fall away by h₁ and h₂
            // the edge stands out by (h₁ + h₂)/4 over the line between the middles of their other sides.
            take(ridge, 0.75 * (aside - along * (aside.dot(along) / along.length_squared())));
        }
    }

    /// How far an edge inside the sheet stands out, and which way it is hollow, m.
    pub fn ridge(&self, edge: u32) -> DVec3 {
        self.ridges[edge as usize]
    }

    /// Unit normal of the sheet at a mass at the base, world; zero where no triangle is.
    pub fn mass_normal(&self, i: usize) -> DVec3 {
        self.mass_areas[i].normalize_or_zero()
    }

    /// Box of a mass over the stage, grown as the triangles' are.
    #[inline]
    pub fn box_of_mass(&self, i: u32) -> &Cuboid {
        &self.boxes[i as usize]
    }

    /// Box of a triangle over the stage.
    #[inline]
    pub fn box_of_triangle(&self, t: u32) -> &Cuboid {
        &self.triangle_boxes[t as usize]
    }

    /// Remembers whether the sheet is flat as it lies: all normals within 30° of one direction.
    pub fn look_whether_flat(&mut self, skin: &Skin, x: &Vectors) {
        if self.is_as_it_was_flat(x) {
            return;
        }
        self.flat_at.clear();
        if skin.is_rectangle() && is_flat(skin, x, 0.75) {
            let first = x.get(0);
            self.flat_at.extend(x.iter().map(|p| (p - first).as_vec3()));
        }
    }

    /// Keeps for a snapshot what a step takes over from those before it.
    pub fn keep(&self, to: &mut Keeper) {
        to.count(u64::from(self.id));
        to.count(self.flat_at.len() as u64);
        self.flat_at.iter().for_each(|p| to.singles(&p.to_array()));
    }

    /// The tree of sheet number `id`, with what was kept; `skin` finds the surface of a sheet by its number.
    pub fn taken<'s>(from: &mut Taker, skin: impl Fn(u32) -> Option<&'s Skin>) -> Taken<Self> {
        let id = from.small()?;
        let mut tree = Self::new(id, skin(id).ok_or(Cut)?);
        let count = from.length(12)?;
        if count != 0 && count != tree.boxes.len() {
            return Err(Cut);
        }
        for _ in 0..count {
            let mut place = [0.0; 3];
            from.singles(&mut place)?;
            tree.flat_at.push(Vec3::from_array(place));
        }
        Ok(tree)
    }

    /// Whether it was found flat at the start of the step.
    pub fn looks_flat(&self) -> bool {
        !self.flat_at.is_empty()
    }

    /// Least height of a triangle at rest, m.
    pub fn height(&self) -> f64 {
        self.height
    }

    /// Whether no triangle turns by more than 45° from one direction in the stage. A rectangle of which that is true is a
    /// graph over a plane and cannot meet itself.
    pub fn stays_flat(&self, sheet: &SheetMotion) -> bool {
        if self.flat_at.is_empty() {
            return false;
        }
        [sheet.start, sheet.end].into_iter().all(|x| self.is_as_it_was_flat(x) || is_flat(sheet.skin, x, 0.5))
    }

    /// Whether it was found flat and its masses have hardly shifted against each other since: masses that shift by δ turn a
    /// triangle of height h by 2 δ/h at most, by 11° here.
    fn is_as_it_was_flat(&self, x: &Vectors) -> bool {
        if self.flat_at.is_empty() || self.flat_at.len() != x.len() {
            return false;
        }
        let (first, allowed) = (x.get(0), 0.05 * self.height);
        let moved = |(i, p): (usize, &Vec3)| (x.get(i) - first - p.as_dvec3()).length_squared();
        self.flat_at.iter().enumerate().all(|m| moved(m) <= allowed * allowed)
    }

    /// Numbers of the triangles whose boxes meet `around`.
    pub fn triangles_in(&self, around: &Cuboid) -> impl Iterator<Item = u32> + '_ {
        let around = around.single();
        self.tree.leaves(move |node| around.intersects(&node.aabb()))
    }

    /// Pairs of triangles of this sheet and another, which sweeps `around`, whose boxes meet. One tree is asked for each
    /// triangle: Parry's walk of two trees at once would allocate where they are deep.
    pub fn pairs_with<'a>(&'a self, other: &'a Self, around: Cuboid) -> impl Iterator<Item = (u32, u32)> + 'a {
        let own = self.triangle_boxes.iter().zip(0_u32..).filter(move |(cuboid, _)| cuboid.meets(&around));
        own.flat_map(|(cuboid, p)| other.triangles_in(cuboid).map(move |q| (p, q)))
    }

    /// Calls `visit` with pairs of triangles of this sheet whose boxes meet, each once.
    pub fn own_pairs(&self, workspace: &mut BvhWorkspace, mut visit: impl FnMut(u32, u32)) {
        self.tree.traverse_bvtt_single_tree::<false>(workspace, &mut visit);
    }

    /// Mean normal of the triangles of an edge, world.
    pub fn edge_normal(&self, triangles: [u32; 2]) -> DVec3 {
        let sum: DVec3 = triangles.into_iter().filter(|t| *t != NONE).map(|t| self.areas[t as usize]).sum();
        sum.normalize_or_zero()
    }

    /// Unit normals of the triangles at an edge; at the border that of the one there is, twice.
    pub fn edge_normals(&self, [first, second]: [u32; 2]) -> [DVec3; 2] {
        [first, if second == NONE { first } else { second }].map(|t| self.areas[t as usize].normalize_or_zero())
    }
}

#[inline]
fn area_of(x: &Vectors, masses: [u32; 3]) -> DVec3 {
    let [a, b, c] = masses.map(|m| x.get(m as usize));
    (b - a).cross(c - a)
}

/// Middles of the triangles at an edge, seen from a point of it, square to it, at the base, m.
pub(crate) fn flanks<'a>(sheet: &SheetMotion<'a>, edge: &SkinEdge) -> impl Iterator<Item = DVec3> + use<'a> {
    let (base, skin) = (sheet.base, sheet.skin);
    let [a, b] = edge.masses.map(|i| base.get(i as usize));
    let along = (b - a).normalize_or(DVec3::X);
    edge.triangles.into_iter().filter(|t| *t != NONE).map(move |t| {
        let masses = skin.triangles()[t as usize].masses;
        let middle = masses.iter().map(|i| base.get(*i as usize)).sum::<DVec3>() / 3.0;
        (middle - a).reject_from_normalized(along)
    })
}

/// Whether the normals of all triangles make an angle with their mean whose squared cosine is more than `cosine_squared`.
fn is_flat(skin: &Skin, x: &Vectors, cosine_squared: f64) -> bool {
    let areas = || skin.triangles().iter().map(|t| area_of(x, t.masses));
    let mean = areas().sum::<DVec3>().normalize_or_zero();
    areas().all(|n| {
        let along = n.dot(mean);
        along > 0.0 && along * along > cosine_squared * n.length_squared()
    })
}
