//! Rays and swept balls against bounding boxes and triangles.

use glam::DVec3;

use crate::collision::bvh::BoundingBox;
use crate::collision::geometry::{barycentric_along, point_triangle};
use crate::world::query::settings::QuerySettings;
use crate::world::query::surface::combine;

const SETTINGS: QuerySettings = QuerySettings::DEFAULT;

/// Ray with a unit direction; lengths in m.
pub(super) struct QueryRay {
    origin: DVec3,
    direction: DVec3,
    pub max_distance: f64,
    /// Axis of the largest component of the direction, and the two others, in an order that keeps
    /// the orientation.
    axes: [usize; 3],
    /// Shear that maps the direction to the first of `axes`, and the scale along it.
    shear: [f64; 3],
}

impl QueryRay {
    /// Ray of any direction but zero; `None` for values that are not finite. `max_distance` may
    /// be infinite.
    pub fn new(origin: DVec3, direction: DVec3, max_distance: f64) -> Option<Self> {
        let largest = direction.abs().max_element();
        let is_valid = origin.is_finite() && direction.is_finite() && largest > 0.0 && max_distance >= 0.0;
        if !is_valid {
            return None;
        }
        let direction = (direction / largest).try_normalize()?;
        let size = direction.abs();
        let z = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
        let (x, y) = if direction[z] < 0.0 { ((z + 2) % 3, (z + 1) % 3) } else { ((z + 1) % 3, (z + 2) % 3) };
        let along = direction[z];
        let shear = [1.0 / along, direction[x] / along, direction[y] / along];
        Some(Self { origin, direction, max_distance, axes: [z, x, y], shear })
    }

    /// Whether a ball of `radius` that moves by up to `limit` may meet the box.
    pub fn meets_bounds(&self, bounds: &BoundingBox, radius: f64, limit: f64) -> bool {
        let (mut enter, mut leave) = (0.0_f64, limit);
        for axis in 0..3 {
            let (low, high) =
                (bounds.low[axis] - radius - self.origin[axis], bounds.high[axis] + radius - self.origin[axis]);
            let along = self.direction[axis];
            if along == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return false;
                }
                continue;
            }
            let (a, b) = (low / along, high / along);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        enter * (1.0 - SETTINGS.distance_rounding) <= leave * (1.0 + SETTINGS.distance_rounding)
    }

    /// Distance to a triangle and the weights of its corners, from both sides. Adjacent triangles
    /// evaluate their common side with the same rounding, so one of them is hit (Woop, Benthin,
    /// Wald, *Watertight ray/triangle intersection*, 2013).
    pub fn meet_triangle(&self, corners: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let [z, x, y] = self.axes;
        let [scale, shear_x, shear_y] = self.shear;
        let [a, b, c] = corners.map(|p| {
            let p = p - self.origin;
            (p[x] - shear_x * p[z], p[y] - shear_y * p[z], scale * p[z])
        });
        let sides = [c.0 * b.1 - c.1 * b.0, a.0 * c.1 - a.1 * c.0, b.0 * a.1 - b.1 * a.0];
        if sides.iter().any(|s| *s < 0.0) && sides.iter().any(|s| *s > 0.0) {
            return None;
        }
        let sum: f64 = sides.iter().sum();
        if sum == 0.0 {
            return None;
        }
        let weights = sides.map(|s| s / sum);
        let distance = weights[0] * a.2 + weights[1] * b.2 + weights[2] * c.2;
        (distance >= 0.0 && weights.iter().all(|w| w.is_finite())).then_some((distance, weights))
    }

    /// Path of a ball of `radius` up to its first touch of a triangle, and the weights of the
    /// touched point: the least path to the interior, to a side (a cylinder) or to a corner (a
    /// ball).
    pub fn sweep_ball(&self, radius: f64, corners: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let weights = point_triangle(self.origin, corners);
        if self.origin.distance(combine(corners, weights)) <= radius {
            return Some((0.0, weights));
        }
        if let Some(hit) = self.sweep_to_interior(radius, corners) {
            return Some(hit);
        }
        let mut best: Option<(f64, [f64; 3])> = None;
        let mut propose = |path: f64, weights: [f64; 3]| {
            if path >= 0.0 && best.is_none_or(|b| path < b.0) {
                best = Some((path, weights));
            }
        };
        for k in 0..3 {
            let next = (k + 1) % 3;
            if let Some((path, t)) = self.sweep_to_side(radius, corners[k], corners[next]) {
                let mut weights = [0.0; 3];
                (weights[k], weights[next]) = (1.0 - t, t);
                propose(path, weights);
            }
            let from = self.origin - corners[k];
            let (b, c) = (from.dot(self.direction), from.length_squared() - radius * radius);
            let squared = b * b - c;
            if squared >= 0.0 {
                let mut weights = [0.0; 3];
                weights[k] = 1.0;
                propose(-b - squared.sqrt(), weights);
            }
        }
        best
    }

    fn sweep_to_interior(&self, radius: f64, corners: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).try_normalize()?;
        let height = (self.origin - corners[0]).dot(normal);
        let normal = if height < 0.0 { -normal } else { normal };
        let (height, approach) = (height.abs(), -self.direction.dot(normal));
        if height < radius || approach <= 0.0 {
            return None;
        }
        let path = (height - radius) / approach;
        let weights = barycentric_along(self.origin + self.direction * path, normal, corners)?;
        weights.iter().all(|w| *w >= 0.0).then_some((path, weights))
    }

    /// Path up to the touch of the segment from `a` to `b`, and the parameter, 0 to 1, of the
    /// touched point.
    fn sweep_to_side(&self, radius: f64, a: DVec3, b: DVec3) -> Option<(f64, f64)> {
        let length = a.distance(b);
        let axis = (b - a).try_normalize()?;
        let from = self.origin - a;
        let (along, start) = (self.direction.dot(axis), from.dot(axis));
        let across = self.direction - axis * along;
        let beside = from - axis * start;
        let (square, b, c) = (across.length_squared(), across.dot(beside), beside.length_squared() - radius * radius);
        let root = b * b - square * c;
        // A ball that moves along the side touches a corner first.
        if square < SETTINGS.distance_rounding || root < 0.0 {
            return None;
        }
        let path = (-b - root.sqrt()) / square;
        let t = (start + path * along) / length;
        (0.0..=1.0).contains(&t).then_some((path, t))
    }
}
