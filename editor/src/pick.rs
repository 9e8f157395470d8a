//! Ray casting: the point of a sheet, the nearest node, the body or the heater under the mouse.

use glam::{DVec3, Vec3};
use sheetwork::rigid::RigidBodyInfo;
use sheetwork::scene::{Scene, Shape};
use sheetwork::{QueryFilter, QueryLayer, World};

/// Ray from the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin, m.
    pub from: DVec3,
    /// Unit vector of its direction.
    pub to: DVec3,
}

/// Hit on a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetHit {
    /// Index of the sheet.
    pub sheet: usize,
    /// Material coordinates, each 0 to 1.
    pub uv: (f64, f64),
    /// Nearest node of the triangle.
    pub node: u32,
    /// Position, m.
    pub place: DVec3,
    /// Distance from the eye, m.
    pub distance: f64,
}

impl Ray {
    /// Ray of single-precision vectors.
    pub fn new(from: Vec3, to: Vec3) -> Self {
        Self { from: from.as_dvec3(), to: to.as_dvec3().normalize_or(DVec3::NEG_Z) }
    }

    /// Distance to a triangle and the weights of its second and third corner, from both sides
    /// (Möller and Trumbore, *Fast, minimum storage ray/triangle intersection*, 1997).
    fn triangle(&self, [a, b, c]: [DVec3; 3]) -> Option<(f64, f64, f64)> {
        let (ab, ac) = (b - a, c - a);
        let p = self.to.cross(ac);
        let det = ab.dot(p);
        if det == 0.0 {
            return None;
        }
        let from = self.from - a;
        let u = from.dot(p) / det;
        let q = from.cross(ab);
        let v = self.to.dot(q) / det;
        let t = ac.dot(q) / det;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some((t, u, v))
    }

    fn ball(&self, centre: DVec3, radius: f64) -> Option<f64> {
        let to = centre - self.from;
        let along = to.dot(self.to);
        let beside = to.length_squared() - along * along;
        let half = (radius * radius - beside).max(0.0).sqrt();
        (beside <= radius * radius && along > half).then_some(along - half)
    }
}

/// Position of the material point (u, v) of the sheet with this index, m; `None` outside the sheet
/// and in an open cell.
pub fn place(world: &World, sheet: usize, uv: (f64, f64), layer: QueryLayer) -> Option<DVec3> {
    let id = world.sheet_ids().nth(sheet)?;
    Some(world.queries(QueryFilter { layer, sheet: Some(id) }).point_at(id, uv)?.position)
}

/// Nearest hit on any sheet.
pub fn sheet(world: &World, ray: Ray, layer: QueryLayer) -> Option<SheetHit> {
    let queries = world.queries(QueryFilter { layer, sheet: None });
    let hit = queries.cast_ray(ray.from, ray.to, f64::INFINITY)?;
    let sheet = world.sheet_ids().position(|id| id == hit.sheet)?;
    Some(SheetHit { sheet, uv: hit.uv, node: hit.node, place: hit.position, distance: hit.distance })
}

/// Nearest heater of `scene` on the ray: index and distance, m.
pub fn heater(scene: &Scene, ray: Ray) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for (index, spec) in scene.heaters.iter().enumerate() {
        // The files were validated when the world was built.
        for heater in spec.resolve(&scene.base).unwrap_or_default() {
            let vertices = &heater.polyhedron.vertices;
            for corners in heater.polyhedron.triangulate() {
                let at = corners.map(|i| spec.placement.apply(vertices.get(i as usize).copied().unwrap_or_default()));
                let Some((distance, ..)) = ray.triangle(at) else { continue };
                if best.is_none_or(|b| distance < b.1) {
                    best = Some((index, distance));
                }
            }
        }
    }
    best
}

/// Nearest bounded body on the ray: index and distance, m.
pub fn body(world: &World, ray: Ray) -> Option<(usize, f64)> {
    let rigid = world.rigid()?;
    let mut best: Option<(usize, f64)> = None;
    for (index, body) in rigid.bodies().iter().enumerate() {
        let Some((place, turn)) = rigid.pose(index) else { continue };
        let hit = if let Shape::Ball(radius) = body.shape {
            ray.ball(place, radius)
        } else {
            let faces = body.polyhedra.iter().flat_map(|p| {
                let all = (0..p.faces.len()).flat_map(|f| p.triangulate_face(f));
                all.map(|t| t.map(|i| turn * p.vertices[i as usize] + place))
            });
            faces.filter_map(|t| ray.triangle(t)).map(|h| h.0).min_by(f64::total_cmp)
        };
        if let Some(distance) = hit.filter(|d| best.is_none_or(|b| *d < b.1)) {
            best = Some((index, distance));
        }
    }
    best
}

/// Bounding box of points: lowest and highest corner; `None` without points.
pub fn box_of(points: impl Iterator<Item = DVec3>) -> Option<(DVec3, DVec3)> {
    points.map(|p| (p, p)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Bounding boxes of the bounded bodies at their present poses, m: lowest and highest corners.
pub fn body_boxes(world: &World) -> Vec<(DVec3, DVec3)> {
    let Some(rigid) = world.rigid() else { return Vec::new() };
    let of = |(index, body): (usize, &RigidBodyInfo)| {
        let (place, turn) = rigid.pose(index)?;
        if let Shape::Ball(radius) = body.shape {
            return Some((place - radius, place + radius));
        }
        box_of(body.polyhedra.iter().flat_map(|p| &p.vertices).map(|v| turn * *v + place))
    };
    rigid.bodies().iter().enumerate().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::scene::Scene;

    fn world() -> World {
        let scene = Scene::parse(
            r#"(sheets: [(structure: "shell", grid: (5, 1, 5), size: (0.4, 0.4), material: "hips", placement: (position: (0, 1, 0)))],
                bodies: [(shape: Ball(0.1), placement: (position: (2, 0, 0))), (shape: Box((0.2, 0.2, 0.2)))])"#,
        );
        World::new(&scene.expect("valid")).expect("valid")
    }

    #[test]
    fn the_point_of_the_sheet_under_the_mouse_is_found() {
        let world = world();
        let down = |x: f32, z: f32| Ray::new(Vec3::new(x, 3.0, z), Vec3::NEG_Y);
        let hit = sheet(&world, down(0.1, -0.05), QueryLayer::Upper).expect("over it");
        assert!((hit.uv.0 - 0.75).abs() < 1e-6 && (hit.uv.1 - 0.375).abs() < 1e-6, "{hit:?}");
        assert!((hit.distance - 2.0).abs() < 1e-6 && hit.place.distance(DVec3::new(0.1, 1.0, -0.05)) < 1e-6);
        let near = world.sheets()[0].state.x.get(hit.node as usize);
        assert!(near.distance(hit.place) < 0.08);
        assert_eq!(sheet(&world, down(0.3, 0.0), QueryLayer::Upper), None);
        let below = Ray::new(Vec3::ZERO, Vec3::Y);
        assert!(sheet(&world, below, QueryLayer::Upper).is_some(), "from below too");
    }

    #[test]
    fn the_nearest_body_is_found() {
        let world = world();
        let from = |x: f32| Ray::new(Vec3::new(x, 0.0, 5.0), Vec3::NEG_Z);
        assert_eq!(body(&world, from(2.0)).map(|b| b.0), Some(0));
        assert!(body(&world, from(2.0)).is_some_and(|b| (b.1 - 4.9).abs() < 1e-6));
        assert_eq!(body(&world, from(0.05)).map(|b| b.0), Some(1));
        assert_eq!(body(&world, from(1.0)), None);
    }
}
