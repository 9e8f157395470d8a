//! Self-shadowing of a sheet.
//!
//! A sheet whose triangle normals all lie within an angle β of one direction m is a graph over the
//! plane normal to m with slopes up to β: a ray steeper than β against that plane meets it once.
//! Such rays are skipped. Others are tested against the triangles whose boxes they cross, found in
//! a tree that is refitted at most once a step.

use glam::{DVec3, Vec3};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};

use crate::serialize::state;
use crate::sheet::Sheet;
use crate::sheet::temperature::patches::SheetPatches;

/// Value of sin β up to which self-shadowing is neglected.
const NEGLIGIBLE_SLOPE: f64 = 0.1;

/// Triangles of a sheet as obstacles of radiation.
pub(crate) struct SelfShadow {
    triangles: Vec<[u32; 3]>,
    tree: Bvh,
    /// m, and sin β; 1 where the sheet is no graph.
    facing: DVec3,
    steepest: f64,
    /// Boxes in the tree.
    boxes: Vec<[f32; 6]>,
}

state!(SelfShadow: facing, steepest, boxes; then refit);

impl SelfShadow {
    pub fn new(sheet: &Sheet, faces: &SheetPatches) -> Self {
        let triangles: Vec<[u32; 3]> = faces.triangles().copied().collect();
        let boxes: Vec<[f32; 6]> = triangles.iter().map(|t| around(sheet, *t)).collect();
        let tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes.iter().map(aabb).enumerate());
        Self { triangles, tree, facing: DVec3::ZERO, steepest: 1.0, boxes }
    }

    /// Whether the triangles are those of `faces`.
    pub fn is_of(&self, faces: &SheetPatches) -> bool {
        self.triangles.iter().eq(faces.triangles())
    }

    fn refit(&mut self) {
        for (i, around) in self.boxes.iter().enumerate() {
            self.tree.insert_or_update_partially(aabb(around), i as u32, 0.0);
        }
        self.tree.refit_without_opt();
    }

    /// Update direction, slope and tree to the present shape of the sheet.
    pub fn refresh(&mut self, sheet: &Sheet, faces: &SheetPatches) {
        let normals = || {
            faces.triangles().map(|t| {
                let [a, b, c] = t.map(|m| sheet.state.x.get(m as usize));
                (b - a).cross(c - a)
            })
        };
        self.facing = normals().sum::<DVec3>().normalize_or_zero();
        let least = normals().map(|n| n.normalize_or_zero().dot(self.facing)).fold(1.0, f64::min);
        // Margin of a degree.
        self.steepest = if least > 0.1 { ((1.0 - least * least).max(0.0).sqrt() + 0.02).min(1.0) } else { 1.0 };
        if self.steepest > NEGLIGIBLE_SLOPE {
            for (to, t) in self.boxes.iter_mut().zip(&self.triangles) {
                *to = around(sheet, *t);
            }
            self.refit();
        }
    }

    /// Whether a triangle without the corner `mass` blocks the line from `from` to `to`.
    pub fn stops(&self, sheet: &Sheet, mass: u32, from: DVec3, to: DVec3) -> bool {
        let way = to - from;
        if self.steepest <= NEGLIGIBLE_SLOPE || way.dot(self.facing).abs() > self.steepest * way.length() {
            return false;
        }
        let ray = Aabb::new(from.min(to).as_vec3(), from.max(to).as_vec3());
        let mut near = self.tree.leaves(move |node| ray.intersects(&node.aabb()));
        near.any(|i| {
            let t = self.triangles[i as usize];
            !t.contains(&mass) && pierces(t.map(|m| sheet.state.x.get(m as usize)), from, way)
        })
    }
}

/// Lowest and highest corner of the box of a triangle.
fn around(sheet: &Sheet, t: [u32; 3]) -> [f32; 6] {
    let [a, b, c] = t.map(|m| sheet.state.x.get(m as usize));
    // Boxes are rounded to single precision without a margin: a ray at the edge of a box only
    // grazes the triangle.
    let (low, high) = (a.min(b).min(c).as_vec3(), a.max(b).max(c).as_vec3());
    [low.x, low.y, low.z, high.x, high.y, high.z]
}

fn aabb(around: &[f32; 6]) -> Aabb {
    let [a, b, c, d, e, f] = *around;
    Aabb::new(Vec3::new(a, b, c), Vec3::new(d, e, f))
}

/// Whether `from` + s `way`, 0 < s < 1, intersects a triangle.
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
    fn a_ray_intersects_the_triangle_in_its_path() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::Z];
        let below = DVec3::new(0.2, -1.0, 0.2);
        assert!(pierces(t, below, DVec3::Y * 2.0));
        assert!(pierces(t, below + DVec3::Y * 2.0, DVec3::Y * -2.0));
        assert!(!pierces(t, below, DVec3::Y * 0.9) && !pierces(t, below, DVec3::Y * -2.0));
        assert!(!pierces(t, DVec3::new(0.6, -1.0, 0.6), DVec3::Y * 2.0));
        assert!(!pierces(t, below, DVec3::X));
    }
}
