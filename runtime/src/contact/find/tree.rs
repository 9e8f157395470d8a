//! Boxes in the world and Parry's tree of boxes over the triangles of a sheet.
//!
//! A triangle's box holds it at the start and at the end of the stage, and with it all of the way between, since its masses
//! move along straight lines. Parry's boxes are in single precision; they are widened by what that loses.

use glam::{DMat3, DVec3};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};

use super::SheetMotion;
use crate::contact::features::Solid;
use crate::contact::frame::RigidFrame;
use crate::contact::skin::{NONE, Skin};
use crate::sheet::Vectors;

/// A box with sides along the axes, m; the default holds nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cuboid {
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

    /// The box that a sheet sweeps in the stage.
    pub fn swept(sheet: &SheetMotion) -> Self {
        Self::of(sheet.start).joined(&Self::of(sheet.end))
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

/// The triangles of a sheet by where they are in a stage, and the normals they have at its base.
pub(super) struct SkinTree {
    id: u32,
    tree: Bvh,
    fresh: bool,
    /// Unit normals of the triangles, world.
    pub normals: Vec<DVec3>,
    /// Unit normals at the masses, world; zero where no triangle is.
    pub mass_normals: Vec<DVec3>,
}

impl SkinTree {
    pub fn new(id: u32, skin: &Skin) -> Self {
        // The order of triangles along the sheet decides which boxes are joined: any boxes that lie alike will do.
        let boxes = skin.triangles().iter().enumerate().map(|(i, t)| {
            let place = skin.middle(t);
            (i, Aabb::new(place.as_vec3(), place.as_vec3()).loosened(t.size as f32))
        });
        Self {
            id,
            tree: Bvh::from_iter(BvhBuildStrategy::Binned, boxes),
            fresh: false,
            normals: vec![DVec3::ZERO; skin.triangles().len()],
            mass_normals: vec![DVec3::ZERO; skin.masses()],
        }
    }

    pub fn is_of(&self, id: u32, skin: &Skin) -> bool {
        let same = self.normals.len() == skin.triangles().len() && self.mass_normals.len() == skin.masses();
        self.id == id && same
    }

    pub fn forget(&mut self) {
        self.fresh = false;
    }

    /// Brings boxes (grown by offset and `margin`, m) and normals to where the sheet is, once a call.
    pub fn refresh(&mut self, sheet: &SheetMotion, margin: f64) {
        if std::mem::replace(&mut self.fresh, true) {
            return;
        }
        let by = sheet.skin.offset() + margin;
        self.mass_normals.fill(DVec3::ZERO);
        for (i, t) in sheet.skin.triangles().iter().enumerate() {
            let at = |x: &Vectors| t.masses.map(|m| x.get(m as usize));
            let (low, high) = super::box_of(at(sheet.start).into_iter().chain(at(sheet.end)));
            self.tree.insert_or_update_partially(Cuboid { low, high }.grown(by).single(), i as u32, 0.0);
            let [a, b, c] = at(sheet.base);
            let area = (b - a).cross(c - a);
            self.normals[i] = area.normalize_or_zero();
            t.masses.iter().for_each(|m| self.mass_normals[*m as usize] += area);
        }
        self.mass_normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        self.tree.refit_without_opt();
    }

    /// Numbers of the triangles whose boxes meet `around`.
    pub fn triangles_in(&self, around: &Cuboid) -> impl Iterator<Item = u32> + '_ {
        let around = around.single();
        self.tree.leaves(move |node| around.intersects(&node.aabb()))
    }

    /// Pairs of triangles of this sheet and another whose boxes meet.
    pub fn pairs_with<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = (u32, u32)> + 'a {
        self.tree.leaf_pairs(&other.tree, |a, b| a.intersects(b))
    }

    /// Calls `visit` with pairs of triangles of this sheet whose boxes meet, each once.
    pub fn own_pairs(&self, workspace: &mut BvhWorkspace, mut visit: impl FnMut(u32, u32)) {
        self.tree.traverse_bvtt_single_tree::<false>(workspace, &mut visit);
    }

    /// Mean normal of the triangles of an edge, world.
    pub fn edge_normal(&self, triangles: [u32; 2]) -> DVec3 {
        let sum: DVec3 = triangles.into_iter().filter(|t| *t != NONE).map(|t| self.normals[t as usize]).sum();
        sum.normalize_or_zero()
    }
}

/// Whether the normals of all triangles of a sheet lie within 45° of one direction at the start and at the end of a stage.
/// A rectangle that does is a graph over a plane and cannot meet itself.
pub(super) fn is_flat(sheet: &SheetMotion) -> bool {
    [sheet.start, sheet.end].into_iter().all(|x| {
        let areas = || {
            sheet.skin.triangles().iter().map(|t| {
                let [a, b, c] = t.masses.map(|m| x.get(m as usize));
                (b - a).cross(c - a)
            })
        };
        let mean = areas().sum::<DVec3>().normalize_or_zero();
        areas().all(|n| {
            let along = n.dot(mean);
            along > 0.0 && along * along > 0.5 * n.length_squared()
        })
    })
}
