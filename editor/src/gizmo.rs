//! Gizmo for translation along an axis or in the picture plane: geometry of its handles, and
//! displacement of a drag. No drawing.

use glam::{DVec3, Vec2, Vec3};

use crate::camera::Camera;

/// Length of the arrows, points.
pub const LENGTH: f32 = 72.0;
/// Largest distance of the mouse from a handle, points.
const REACH: f32 = 9.0;

/// Handle of the gizmo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handle {
    /// Translation along an axis: 0 x, 1 y, 2 z.
    Axis(usize),
    /// Translation parallel to the picture plane.
    Plane,
}

/// Gizmo projected into a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gizmo {
    /// Position, m.
    pub place: Vec3,
    /// Centre in the picture.
    pub middle: Vec2,
    /// Ends of the arrows in the picture; an arrow towards the eye is foreshortened.
    pub ends: [Vec2; 3],
    camera: Camera,
    size: Vec2,
}

impl Gizmo {
    /// Gizmo at `place` (m) in a picture of `size`; `None` behind the eye.
    pub fn new(place: Vec3, camera: &Camera, size: Vec2) -> Option<Self> {
        let middle = camera.project(place, size)?;
        let length = LENGTH * camera.metres_a_point(place, size);
        let end = |axis: Vec3| camera.project(place + axis * length, size);
        let ends = [end(Vec3::X)?, end(Vec3::Y)?, end(Vec3::Z)?];
        Some(Self { place, middle, ends, camera: *camera, size })
    }

    /// Handle under the mouse.
    pub fn handle_at(&self, at: Vec2) -> Option<Handle> {
        if at.distance(self.middle) < REACH {
            return Some(Handle::Plane);
        }
        let near = |axis: usize| (distance(at, self.middle, self.ends[axis]), axis);
        let (away, axis) = (0..3).map(near).min_by(|a, b| a.0.total_cmp(&b.0))?;
        (away < REACH).then_some(Handle::Axis(axis))
    }

    /// Displacement (m) of a drag of a handle from one position of the picture to another.
    pub fn moved(&self, handle: Handle, from: Vec2, to: Vec2) -> DVec3 {
        match handle {
            Handle::Plane => {
                let on = |at: Vec2| self.camera.on_plane(at, self.size, self.place).as_dvec3();
                on(to) - on(from)
            }
            Handle::Axis(axis) => {
                let seen = self.ends[axis] - self.middle;
                // A drag along an arrow towards the eye is undefined.
                if seen.length() < 4.0 {
                    return DVec3::ZERO;
                }
                let length = LENGTH * self.camera.metres_a_point(self.place, self.size);
                let mut by = DVec3::ZERO;
                by[axis] = f64::from((to - from).dot(seen) / seen.length_squared() * length);
                by
            }
        }
    }
}

/// Distance of a point from a segment.
fn distance(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    let along = b - a;
    let part = ((p - a).dot(along) / along.length_squared().max(1e-6)).clamp(0.0, 1.0);
    p.distance(a + along * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arrow_moves_an_item_along_its_axis_with_the_mouse() {
        let camera = Camera { yaw: 0.6, pitch: 0.4, distance: 0.5, ..Camera::default() };
        let size = Vec2::new(900.0, 600.0);
        let place = Vec3::new(0.02, -0.01, 0.03);
        let gizmo = Gizmo::new(place, &camera, size).expect("in view");
        for axis in 0..3 {
            let from = gizmo.middle.lerp(gizmo.ends[axis], 0.7);
            assert_eq!(gizmo.handle_at(from), Some(Handle::Axis(axis)));
            let to = gizmo.middle.lerp(gizmo.ends[axis], 1.1);
            let by = gizmo.moved(Handle::Axis(axis), from, to);
            let others = (0..3).filter(|i| *i != axis).map(|i| by[i].abs()).fold(0.0, f64::max);
            assert!(by[axis] > 0.0 && others == 0.0);
            // The projected position follows the mouse, up to perspective.
            let seen = camera.project(place + by.as_vec3(), size).expect("in view");
            assert!(seen.distance(gizmo.middle + (to - from)) < 3.0, "{axis}");
        }
    }

    #[test]
    fn the_centre_of_the_gizmo_moves_an_item_in_the_picture_plane() {
        let camera = Camera::default();
        let size = Vec2::new(900.0, 600.0);
        let gizmo = Gizmo::new(camera.target, &camera, size).expect("in view");
        assert_eq!(gizmo.handle_at(gizmo.middle + Vec2::new(3.0, 3.0)), Some(Handle::Plane));
        assert_eq!(gizmo.handle_at(gizmo.middle + Vec2::new(-200.0, 90.0)), None);
        let to = gizmo.middle + Vec2::new(120.0, -40.0);
        let by = gizmo.moved(Handle::Plane, gizmo.middle, to).as_vec3();
        assert!(by.dot(camera.back()).abs() < 1e-6);
        assert!(camera.project(camera.target + by, size).is_some_and(|p| p.distance(to) < 0.5));
        assert_eq!(Gizmo::new(camera.eye() + camera.back(), &camera, size), None);
    }
}
