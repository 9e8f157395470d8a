//! Whether a sheet stands in its own light.
//!
//! A sheet whose triangles all face within an angle β of one direction m is a graph over the plane square to m with slopes up to β: a ray
//! that climbs steeper than β over that plane meets it once. Such rays need no look. Others are tried with the triangles
//! in whose boxes they come, of a tree that is brought up to date once a step, where any is needed.

use glam::{DVec3, Vec3};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};

use crate::serialize::{Keeper, Taken, Taker};
use crate::sheet::Sheet;
use crate::thermal::patches::Faces;

/// A sheet whose sin β is no more than this casts no shadow on itself worth a look.
const GRAZING: f64 = 0.1;

/// The triangles of a sheet, as what stops light.
pub(crate) struct Own {
    triangles: Vec<[u32; 3]>,
    tree: Bvh,
    /// m, and sin β; 1 where the sheet is no graph.
    facing: DVec3,
    steepest: f64,
    /// Boxes that the tree has.
    boxes: Vec<[f32; 6]>,
}

impl Own {
    pub fn new(sheet: &Sheet, faces: &Faces) -> Self {
        let triangles: Vec<[u32; 3]> = faces.triangles().copied().collect();
        let boxes: Vec<[f32; 6]> = triangles.iter().map(|t| around(sheet, *t)).collect();
        let tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes.iter().map(aabb).enumerate());
        Self { triangles, tree, facing: DVec3::ZERO, steepest: 1.0, boxes }
    }

    /// Whether it is of the triangles of `faces`.
    pub fn is_of(&self, faces: &Faces) -> bool {
        self.triangles.iter().eq(faces.triangles())
    }

    /// Keeps it for a snapshot.
    pub fn keep(&self, to: &mut Keeper) {
        to.vector(self.facing);
        to.number(self.steepest);
        self.boxes.iter().for_each(|b| to.singles(b));
    }

    /// Takes it back.
    pub fn take(&mut self, from: &mut Taker) -> Taken {
        (self.facing, self.steepest) = (from.vector()?, from.number()?);
        self.boxes.iter_mut().try_for_each(|b| from.singles(b))?;
        self.refit();
        Ok(())
    }

    fn refit(&mut self) {
        for (i, around) in self.boxes.iter().enumerate() {
            self.tree.insert_or_update_partially(aabb(around), i as u32, 0.0);
        }
        self.tree.refit_without_opt();
    }

    /// Brings it to where the sheet is.
    pub fn refresh(&mut self, sheet: &Sheet, faces: &Faces) {
        let normals = || {
            faces.triangles().map(|t| {
                let [a, b, c] = t.map(|m| sheet.x.get(m as usize));
                (b - a).cross(c - a)
            })
        };
        self.facing = normals().sum::<DVec3>().normalize_or_zero();
        let least = normals().map(|n| n.normalize_or_zero().dot(self.facing)).fold(1.0, f64::min);
        // A degree of room.
        self.steepest = if least > 0.1 { ((1.0 - least * least).max(0.0).sqrt() + 0.02).min(1.0) } else { 1.0 };
        if self.steepest > GRAZING {
            for (to, t) in self.boxes.iter_mut().zip(&self.triangles) {
                *to = around(sheet, *t);
            }
            self.refit();
        }
    }

    /// Whether some triangle that `mass` is no corner of is between `from` and `to`.
    pub fn stops(&self, sheet: &Sheet, mass: u32, from: DVec3, to: DVec3) -> bool {
        let way = to - from;
        if self.steepest <= GRAZING || way.dot(self.facing).abs() > self.steepest * way.length() {
            return false;
        }
        let ray = Aabb::new(from.min(to).as_vec3(), from.max(to).as_vec3());
        let mut near = self.tree.leaves(move |node| ray.intersects(&node.aabb()));
        near.any(|i| {
            let t = self.triangles[i as usize];
            !t.contains(&mass) && pierces(t.map(|m| sheet.x.get(m as usize)), from, way)
        })
    }
}

/// Lowest and highest corner of the box of a triangle.
fn around(sheet: &Sheet, t: [u32; 3]) -> [f32; 6] {
    let [a, b, c] = t.map(|m| sheet.x.get(m as usize));
    // Single precision widens nothing here: a ray that grazes a box's edge grazes the triangle's.
    let (low, high) = (a.min(b).min(c).as_vec3(), a.max(b).max(c).as_vec3());
    [low.x, low.y, low.z, high.x, high.y, high.z]
}

fn aabb(around: &[f32; 6]) -> Aabb {
    let [a, b, c, d, e, f] = *around;
    Aabb::new(Vec3::new(a, b, c), Vec3::new(d, e, f))
}

/// Whether `from` + s `way`, 0 < s < 1, goes through a triangle.
fn pierces([a, b, c]: [DVec3; 3], from: DVec3, way: DVec3) -> bool {
    let (p, q) = (b - a, c - a);
    let across = way.cross(q);
    let volume = p.dot(across);
    if volume == 0.0 {
        return false;
    }
    let to = from - a;
    let u = to.dot(across) / volume;
    let turned = to.cross(p);
    let v = way.dot(turned) / volume;
    let s = q.dot(turned) / volume;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && s > 0.0 && s < 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_pierces_what_it_goes_through() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::Z];
        let below = DVec3::new(0.2, -1.0, 0.2);
        assert!(pierces(t, below, DVec3::Y * 2.0));
        assert!(pierces(t, below + DVec3::Y * 2.0, DVec3::Y * -2.0));
        assert!(!pierces(t, below, DVec3::Y * 0.9) && !pierces(t, below, DVec3::Y * -2.0));
        assert!(!pierces(t, DVec3::new(0.6, -1.0, 0.6), DVec3::Y * 2.0));
        assert!(!pierces(t, below, DVec3::X));
    }
}
