//! Visibility at every sample: projection, clipping at the eye, and a depth buffer.
//!
//! Depth is linear across the projected triangle and grows towards the eye: 1/z for a perspective
//! view, -z for a parallel one. One buffer type serves eye and light.

use glam::{Vec2, Vec3};

use super::model::Model;
use crate::camera::Camera;

/// Index of a sample without a triangle.
pub(super) const NOTHING: u32 = u32::MAX;

/// Projection onto a grid of samples.
pub(super) struct View {
    origin: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Samples per unit of slope (perspective) or per metre (parallel).
    scale: f32,
    perspective: bool,
    pub columns: usize,
    pub rows: usize,
}

impl View {
    pub fn perspective(camera: &Camera, columns: usize, rows: usize) -> Self {
        let (right, up) = camera.axes();
        let scale = 0.5 * rows.min(columns) as f32 / (0.5 * camera.field_of_view).tan();
        Self { origin: camera.eye(), right, up, forward: -camera.back(), scale, perspective: true, columns, rows }
    }

    /// Parallel light from the direction `towards` (unit vector) that covers `radius` m about
    /// `centre`.
    pub fn parallel(centre: Vec3, towards: Vec3, radius: f32, size: usize) -> Self {
        let right = towards.any_orthonormal_vector();
        let up = towards.cross(right);
        let scale = 0.5 * size as f32 / radius.max(1e-9);
        Self { origin: centre, right, up, forward: -towards, scale, perspective: false, columns: size, rows: size }
    }

    /// Sample coordinates and depth; in a perspective view only for points in front of the eye.
    pub fn project(&self, point: Vec3) -> Vec3 {
        let p = point - self.origin;
        let z = p.dot(self.forward);
        let factor = if self.perspective { self.scale / z } else { self.scale };
        let x = 0.5 * self.columns as f32 + p.dot(self.right) * factor;
        let y = 0.5 * self.rows as f32 - p.dot(self.up) * factor;
        Vec3::new(x, y, if self.perspective { 1.0 / z } else { -z })
    }

    /// Unit vector from a perspective eye through the centre of sample `at`.
    pub fn direction(&self, (x, y): (usize, usize)) -> Vec3 {
        let right = (x as f32 + 0.5 - 0.5 * self.columns as f32) / self.scale;
        let up = (0.5 * self.rows as f32 - y as f32 - 0.5) / self.scale;
        (self.forward + self.right * right + self.up * up).normalize()
    }

    /// Point at sample `at` with this depth.
    pub fn point(&self, at: (usize, usize), depth: f32) -> Vec3 {
        let direction = self.direction(at);
        self.origin + direction / (depth * direction.dot(self.forward))
    }

    /// Width of a sample at a point with this depth, m.
    pub fn sample_width(&self, depth: f32) -> f32 {
        1.0 / (depth * self.scale)
    }

    /// Part of a triangle in front of the eye, as a convex polygon.
    fn clip(&self, corners: [Vec3; 3], near: f32) -> Vec<Vec3> {
        if !self.perspective {
            return corners.to_vec();
        }
        let depth = |p: Vec3| (p - self.origin).dot(self.forward) - near;
        let mut kept = Vec::with_capacity(4);
        for i in 0..3 {
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            let (dp, dq) = (depth(p), depth(q));
            if dp >= 0.0 {
                kept.push(p);
            }
            if (dp < 0.0) != (dq < 0.0) {
                kept.push(p.lerp(q, dp / (dp - dq)));
            }
        }
        kept
    }
}

/// Nearest triangle and its depth at every sample.
pub(super) struct VisibilityBuffer {
    pub triangle: Vec<u32>,
    pub depth: Vec<f32>,
    columns: usize,
    rows: usize,
}

impl VisibilityBuffer {
    /// Triangles visible from the eye; single-sided faces are culled from behind.
    pub fn find(model: &Model, view: &View) -> Self {
        let mut seen = Self::empty(view);
        for (index, triangle) in model.triangles.iter().enumerate() {
            let facing = triangle.across().dot(view.origin - triangle.corners[0]);
            if facing > 0.0 || !triangle.one_sided() {
                seen.add(view, triangle.corners, index as u32);
            }
        }
        seen
    }

    /// First triangles hit by parallel light; planes of the room cast no shadow.
    pub fn by_light(model: &Model, view: &View) -> Self {
        let mut seen = Self::empty(view);
        for (index, triangle) in model.triangles.iter().enumerate().filter(|(_, t)| t.throws_shadow()) {
            seen.add(view, triangle.corners, index as u32);
        }
        seen
    }

    fn empty(view: &View) -> Self {
        let n = view.columns * view.rows;
        let (columns, rows) = (view.columns, view.rows);
        Self { triangle: vec![NOTHING; n], depth: vec![f32::NEG_INFINITY; n], columns, rows }
    }

    fn add(&mut self, view: &View, corners: [Vec3; 3], index: u32) {
        // A near plane at 1e-6 m keeps 1/z finite.
        let polygon = view.clip(corners, 1e-6);
        for i in 2..polygon.len() {
            self.fill([polygon[0], polygon[i - 1], polygon[i]].map(|p| view.project(p)), index);
        }
    }

    /// Write the samples whose centre lies in the projected triangle and that are not occluded.
    fn fill(&mut self, [a, b, c]: [Vec3; 3], index: u32) {
        let area = (b - a).truncate().perp_dot((c - a).truncate());
        if !area.is_finite() || area == 0.0 {
            return;
        }
        let low = a.min(b).min(c).truncate().max(Vec2::ZERO);
        let high = a.max(b).max(c).truncate().min(Vec2::new(self.columns as f32, self.rows as f32));
        if low.x >= high.x || low.y >= high.y {
            return;
        }
        for y in low.y as usize..(high.y.ceil() as usize).min(self.rows) {
            for x in low.x as usize..(high.x.ceil() as usize).min(self.columns) {
                let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let wb = (p - a.truncate()).perp_dot((c - a).truncate()) / area;
                let wc = (b - a).truncate().perp_dot(p - a.truncate()) / area;
                let wa = 1.0 - wb - wc;
                if wa < 0.0 || wb < 0.0 || wc < 0.0 {
                    continue;
                }
                let depth = wa * a.z + wb * b.z + wc * c.z;
                let at = y * self.columns + x;
                if depth > self.depth[at] {
                    self.depth[at] = depth;
                    self.triangle[at] = index;
                }
            }
        }
    }
}
