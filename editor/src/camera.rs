//! Camera: orbits a target, pans in the picture plane and zooms. Plain geometry, in metres and
//! radians.

use glam::{Vec2, Vec3};
use sheetwork::World;

use crate::pick::{Ray, body_boxes};
use crate::session::Session;

/// Position and direction of the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Target of the view, m.
    pub target: Vec3,
    /// Rotation about the vertical, radians; 0 looks along -z (at the back wall).
    pub yaw: f32,
    /// Elevation of the eye above the target, radians; within ±1.55.
    pub pitch: f32,
    /// Distance from eye to target, m; 1e-4 to 1e4.
    pub distance: f32,
    /// Angle between the upper and the lower edge of the picture, radians; in a portrait picture
    /// the angle between its sides, so that the view is not cropped.
    pub field_of_view: f32,
}

impl Default for Camera {
    fn default() -> Self {
        Self { target: Vec3::ZERO, yaw: 0.45, pitch: 0.42, distance: 0.15, field_of_view: 0.6 }
    }
}

impl Camera {
    /// Camera at `eye` that looks at `target`, m.
    pub fn looking(eye: Vec3, target: Vec3) -> Self {
        let back = eye - target;
        let distance = back.length().max(1e-4);
        let pitch = (back.y / distance).clamp(-1.0, 1.0).asin().clamp(-1.55, 1.55);
        Self { target, yaw: back.x.atan2(back.z), pitch, distance, ..Self::default() }
    }

    /// View of the world's scene, or a fitted one.
    pub fn from_world(world: &World) -> Self {
        if let Some(spec) = &world.scene().camera {
            return Self::looking(spec.eye.as_vec3(), spec.target.as_vec3());
        }
        Self::fitted(world)
    }

    /// View of a session's scene, or a fitted one.
    pub fn from_session(session: &Session) -> Self {
        Self::from_world(session.world())
    }

    /// View from the right and above that contains the sheets and bodies of `world`.
    pub fn fitted(world: &World) -> Self {
        let (low, high) = content(world).unwrap_or((Vec3::splat(-0.05), Vec3::splat(0.05)));
        let base = Self::default();
        let radius = (0.5 * (high - low).length()).max(1e-3);
        let distance = 1.05 * radius / (0.5 * base.field_of_view).sin();
        Self { target: 0.5 * (low + high), distance, ..base }
    }

    /// Unit vector from the target to the eye.
    pub fn back(&self) -> Vec3 {
        let (sy, cy) = self.yaw.sin_cos();
        let (sp, cp) = self.pitch.sin_cos();
        Vec3::new(cp * sy, sp, cp * cy)
    }

    /// Position of the eye, m.
    pub fn eye(&self) -> Vec3 {
        self.target + self.back() * self.distance
    }

    /// Unit vectors to the right and upwards in the picture.
    pub fn axes(&self) -> (Vec3, Vec3) {
        let back = self.back();
        let right = Vec3::Y.cross(back).normalize_or(Vec3::X);
        (right, back.cross(right))
    }

    /// Rotate the eye about the target by a drag of the mouse, points.
    pub fn orbit(&mut self, drag: Vec2) {
        self.yaw = (self.yaw - 0.008 * drag.x) % std::f32::consts::TAU;
        self.pitch = (self.pitch + 0.008 * drag.y).clamp(-1.55, 1.55);
    }

    /// Move eye and target so that the plane of the target follows a drag of the mouse, points, in
    /// a picture of `size`, points.
    pub fn pan(&mut self, drag: Vec2, size: Vec2) {
        let scale = self.distance * self.slope(size);
        let (right, up) = self.axes();
        self.target += (up * drag.y - right * drag.x) * scale;
    }

    /// Ray from the eye through the position (x, y) of a picture of `size` (width, height), in
    /// points from its upper left.
    pub fn ray(&self, at: Vec2, size: Vec2) -> Ray {
        let (right, up) = self.axes();
        let from_middle = (at - 0.5 * size) * self.slope(size);
        Ray::new(self.eye(), -self.back() + right * from_middle.x - up * from_middle.y)
    }

    /// Position of a point (m) in a picture of `size`, in points from its upper left; `None` behind
    /// the eye.
    pub fn project(&self, point: Vec3, size: Vec2) -> Option<Vec2> {
        let (right, up) = self.axes();
        let way = point - self.eye();
        let depth = -way.dot(self.back());
        if depth <= 1e-6 * self.distance {
            return None;
        }
        let scale = 1.0 / (self.slope(size) * depth);
        Some(0.5 * size + Vec2::new(way.dot(right), -way.dot(up)) * scale)
    }

    /// Intersection of the ray through a position of the picture with the plane through `point`
    /// parallel to the picture plane, m.
    pub fn on_plane(&self, at: Vec2, size: Vec2, point: Vec3) -> Vec3 {
        let ray = self.ray(at, size);
        let to = ray.to.as_vec3();
        let depth = (point - self.eye()).dot(self.back());
        self.eye() + to * (depth / to.dot(self.back()).min(-1e-6))
    }

    /// Metres per point of a picture of `size`, at the distance of `point`.
    pub fn metres_a_point(&self, point: Vec3, size: Vec2) -> f32 {
        let depth = -(point - self.eye()).dot(self.back());
        depth.max(1e-6) * self.slope(size)
    }

    /// Metres per point of a picture of `size`, at a distance of 1 m.
    fn slope(&self, size: Vec2) -> f32 {
        2.0 * (0.5 * self.field_of_view).tan() / size.min_element().max(1.0)
    }

    /// Angle between the upper and the lower edge of a picture of `size`, radians.
    pub fn opening(&self, size: Vec2) -> f32 {
        2.0 * (0.5 * size.y.max(1.0) * self.slope(size)).atan()
    }

    /// Camera with another yaw and pitch, radians.
    pub fn from_side(&self, yaw: f32, pitch: f32) -> Self {
        Self { yaw, pitch: pitch.clamp(-1.55, 1.55), ..*self }
    }

    /// Camera with target and distance of the whole content of `world`.
    pub fn focused(&self, world: &World) -> Self {
        let fitted = Self::fitted(world);
        Self { target: fitted.target, distance: fitted.distance, ..*self }
    }

    /// Move back until `point` (m) is well within a picture of `size`.
    pub fn hold(&mut self, point: Vec3, size: Vec2) {
        let inner = |at: Vec2| (0.08 * size).cmple(at).all() && (0.92 * size).cmpge(at).all();
        for _ in 0..40 {
            if self.project(point, size).is_some_and(inner) {
                return;
            }
            self.zoom(-1.0);
        }
    }

    /// Zoom in by notches of the wheel; out for negative ones.
    pub fn zoom(&mut self, notches: f32) {
        self.distance = (self.distance * (-0.12 * notches.clamp(-20.0, 20.0)).exp()).clamp(1e-4, 1e4);
    }
}

/// Bounding box of the sheets and bounded bodies, m.
fn content(world: &World) -> Option<(Vec3, Vec3)> {
    let mut points = Vec::new();
    for sheet in world.sheets() {
        points.extend(sheet.state.x.bounds().into_iter().flat_map(|(low, high)| [low.as_vec3(), high.as_vec3()]));
    }
    points.extend(body_boxes(world).into_iter().flat_map(|(low, high)| [low.as_vec3(), high.as_vec3()]));
    let low = points.iter().copied().reduce(Vec3::min)?;
    let high = points.iter().copied().reduce(Vec3::max)?;
    Some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eye_of_a_camera_is_the_given_one() {
        let (eye, target) = (Vec3::new(0.3, 0.2, 0.5), Vec3::new(0.0, 0.1, 0.0));
        let camera = Camera::looking(eye, target);
        assert!(camera.eye().distance(eye) < 1e-6);
        let (right, up) = camera.axes();
        assert!(right.dot(camera.back()).abs() < 1e-6 && up.dot(right).abs() < 1e-6 && up.y > 0.0);
    }

    #[test]
    fn projection_inverts_the_ray_of_a_point() {
        let camera = Camera { target: Vec3::new(0.1, 0.2, 0.3), yaw: 0.7, pitch: 0.3, ..Camera::default() };
        let size = Vec2::new(800.0, 500.0);
        for at in [Vec2::new(400.0, 250.0), Vec2::new(13.0, 420.0), Vec2::new(777.0, 5.0)] {
            let ray = camera.ray(at, size);
            let point = (ray.from + ray.to * 0.37).as_vec3();
            assert!(camera.project(point, size).is_some_and(|p| p.distance(at) < 0.02), "{at}");
            let on = camera.on_plane(at, size, camera.target);
            assert!((on - camera.target).dot(camera.back()).abs() < 1e-6);
            assert!(camera.project(on, size).is_some_and(|p| p.distance(at) < 0.02));
        }
        assert!(camera.project(camera.target, size).is_some_and(|p| p.distance(0.5 * size) < 1e-2));
        assert_eq!(camera.project(camera.eye() + camera.back(), size), None, "behind");
        let wide = camera.metres_a_point(camera.target, size) * size.y;
        assert!((wide / (2.0 * camera.distance * (0.5 * camera.field_of_view).tan()) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn the_content_stays_in_view_in_a_narrow_picture() {
        let camera = Camera::default();
        let (right, _) = camera.axes();
        let point = camera.target + right * (0.99 * camera.distance * (0.5 * camera.field_of_view).tan());
        for size in [Vec2::new(500.0, 500.0), Vec2::new(200.0, 700.0), Vec2::new(900.0, 300.0)] {
            let at = camera.project(point, size).expect("before the eye");
            assert!((0.0..=size.x).contains(&at.x) && (at.y - 0.5 * size.y).abs() < 1e-2, "{at} of {size}");
            let ray = camera.ray(at, size);
            assert!(ray.to.as_vec3().cross(point - camera.eye()).length() < 1e-5 * camera.distance);
        }
        assert_eq!(camera.opening(Vec2::new(900.0, 300.0)), camera.field_of_view);
        assert!(camera.opening(Vec2::new(200.0, 700.0)) > 1.5);
    }

    #[test]
    fn orbit_pan_and_zoom_stay_within_their_limits() {
        let mut camera = Camera::default();
        camera.orbit(Vec2::new(0.0, 1e6));
        assert!(camera.pitch <= 1.55);
        camera.zoom(1e9);
        assert!(camera.distance >= 1e-4);
        let mut camera = Camera { pitch: 0.0, yaw: 0.0, ..Camera::default() };
        camera.pan(Vec2::new(10.0, 0.0), Vec2::new(160.0, 100.0));
        // The scene follows the mouse to the right, so the eye moves left.
        assert!(camera.target.x < 0.0 && camera.target.y.abs() < 1e-9);
    }
}
