//! World as triangles with materials: surfaces of sheets, bodies, heaters, floor and back wall.
//! Metres, world coordinates.

use bevy_sheetwork::render::{ColourScale, clear_of_bodies, display_clearance, glow};
use bevy_sheetwork::{SheetColour, SheetLayer};
use glam::{DQuat, DVec3, Vec3};
use sheetwork::World;
use sheetwork::rigid::RigidBodyInfo;
use sheetwork::scene::{Polyhedron, Room, Shape};
use sheetwork::sheet::Sheet;
use sheetwork::sheet::surface::{DrawingSurface, SurfaceSmoothing};

/// Display settings of the sheets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Layer of the surface.
    pub layer: SheetLayer,
    /// Spline segments per cell: 1 (flat) to 16.
    pub parts: u32,
    /// Kind of the splines.
    pub spline: SurfaceSmoothing,
    /// Field that colours the sheets; `None` for the one that displays the scene's heat.
    pub colour: Option<SheetColour>,
}

impl Default for Look {
    fn default() -> Self {
        Self { layer: SheetLayer::Top, parts: 4, spline: SurfaceSmoothing::Interpolating, colour: None }
    }
}

impl Look {
    /// Colour scale of the sheets of `world`; `None` where they have the colour of their material.
    pub fn scale(&self, world: &World) -> Option<ColourScale> {
        self.colour.unwrap_or_else(|| SheetColour::of_heat(world)).scale(world)
    }
}

/// Material of a triangle; colours are linear red, green, blue.
#[derive(Clone, Copy, Debug)]
pub(super) enum Paint {
    /// Face of a body.
    Matt(Vec3),
    /// Glossy sheet: colour of the upper and of the lower side.
    Sheet(Vec3, Vec3),
    /// Glossy sheet: colours of the corners of the upper and of the lower side.
    Graded([Vec3; 3], [Vec3; 3]),
    /// Self-luminous hot face of a heater. Heaters cast no shadow, which would hide the heated
    /// sheet.
    Glowing(Vec3),
    /// Cold face of a heater.
    Metal(Vec3),
    /// Plane with a square grid of this spacing, m, visible from its front only; the indices are
    /// the axes of the grid.
    Grid(Vec3, f32, [usize; 2]),
}

/// Triangle, counter-clockwise seen from its front.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub corners: [Vec3; 3],
    pub normals: [Vec3; 3],
    pub paint: Paint,
}

impl Triangle {
    /// Normal of the plane, not normalised.
    pub fn across(&self) -> Vec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }

    /// Whether it is transparent from behind.
    pub fn one_sided(&self) -> bool {
        !matches!(self.paint, Paint::Sheet(..) | Paint::Graded(..))
    }

    /// Whether it casts a shadow.
    pub fn throws_shadow(&self) -> bool {
        !matches!(self.paint, Paint::Grid(..) | Paint::Glowing(_) | Paint::Metal(_))
    }
}

/// All triangles of a picture.
pub(super) struct Model {
    pub triangles: Vec<Triangle>,
}

const SHEET_ABOVE: Vec3 = Vec3::new(0.80, 0.115, 0.035);
const SHEET_BELOW: Vec3 = Vec3::new(0.52, 0.075, 0.03);
const BODY: Vec3 = Vec3::new(0.36, 0.44, 0.56);
const HEATER: Vec3 = Vec3::new(0.16, 0.165, 0.18);
const FLOOR: Vec3 = Vec3::new(0.66, 0.635, 0.60);
const WALL: Vec3 = Vec3::new(0.70, 0.69, 0.675);

/// Vertex colours of one side of a sheet's surface.
fn colours(scale: &ColourScale, of: (&Sheet, bool), surface: &DrawingSurface) -> Vec<Vec3> {
    let (mut values, mut colours) = (Vec::new(), Vec::new());
    scale.paint(of, surface, &mut values, &mut colours);
    colours.into_iter().map(|[r, g, b, _]| Vec3::new(r, g, b)).collect()
}

impl Model {
    pub fn from_world(world: &World, look: &Look) -> Self {
        let mut model = Self { triangles: Vec::new() };
        if let Some(room) = &world.scene().room {
            model.add_room(room);
        }
        if let Some(rigid) = world.rigid() {
            for (index, body) in rigid.bodies().iter().enumerate() {
                if let Some((position, rotation)) = rigid.pose(index) {
                    model.add_body(body, position, rotation);
                }
            }
        }
        model.add_heaters(world);
        let scale = look.scale(world);
        for sheet in world.sheets() {
            model.add_sheet(world, sheet, look, scale.filter(|_| sheet.heat().is_some()).as_ref());
        }
        // A non-finite corner would corrupt the depth buffer.
        model.triangles.retain(|t| t.corners.iter().all(|c| c.is_finite()));
        model
    }

    fn add_room(&mut self, room: &Room) {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z).as_vec3();
        let (x, y, z, grid) = (room.x, room.y, room.z, room.grid as f32);
        let floor = [at(x.0, y.0, z.0), at(x.0, y.0, z.1), at(x.1, y.0, z.1), at(x.1, y.0, z.0)];
        self.add_quad(floor, Paint::Grid(FLOOR, grid, [0, 2]));
        if room.back_wall {
            let wall = [at(x.0, y.0, z.0), at(x.1, y.0, z.0), at(x.1, y.1, z.0), at(x.0, y.1, z.0)];
            self.add_quad(wall, Paint::Grid(WALL, grid, [0, 1]));
        }
    }

    fn add_quad(&mut self, [a, b, c, d]: [Vec3; 4], paint: Paint) {
        let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
        for corners in [[a, b, c], [a, c, d]] {
            self.triangles.push(Triangle { corners, normals: [normal; 3], paint });
        }
    }

    fn add_flat(&mut self, corners: [Vec3; 3], paint: Paint) {
        let mut triangle = Triangle { corners, normals: [Vec3::Y; 3], paint };
        triangle.normals = [triangle.across().normalize_or(Vec3::Y); 3];
        self.triangles.push(triangle);
    }

    fn add_body(&mut self, body: &RigidBodyInfo, position: DVec3, rotation: DQuat) {
        let place = |p: DVec3| (rotation * p + position).as_vec3();
        for polyhedron in &body.polyhedra {
            for face in polyhedron.triangulate() {
                let corners = face.map(|i| polyhedron.vertices.get(i as usize).map_or(Vec3::ZERO, |v| place(*v)));
                self.add_flat(corners, Paint::Matt(BODY));
            }
        }
        if let Shape::Ball(radius) = body.shape {
            let half = Polyhedron::hemisphere(radius, 16, 48);
            for turn in [DQuat::IDENTITY, DQuat::from_rotation_x(std::f64::consts::PI)] {
                let round = half.triangulate().into_iter().map(|t| t.map(|i| half.vertices[i as usize]));
                // The flat base is inside the ball.
                for local in round.filter(|t| t.iter().any(|p| p.y > 1e-9 * radius)) {
                    let corners = local.map(|p| place(turn * p));
                    let normals = corners.map(|c| (c - position.as_vec3()).normalize_or(Vec3::Y));
                    self.triangles.push(Triangle { corners, normals, paint: Paint::Matt(BODY) });
                }
            }
        }
    }

    fn add_heaters(&mut self, world: &World) {
        let scene = world.scene();
        for spec in &scene.heaters {
            // The files were validated when the world was built.
            for heater in spec.resolve(&scene.base).unwrap_or_default() {
                for (face, heat) in heater.faces.iter().enumerate() {
                    let paint = match heat.temperature.filter(|_| spec.on) {
                        Some(celsius) => {
                            let colour = glow(celsius);
                            Paint::Glowing(Vec3::new(colour.red, colour.green, colour.blue))
                        }
                        None => Paint::Metal(HEATER),
                    };
                    for triangle in heater.polyhedron.triangulate_face(face) {
                        let corner = |i: u32| heater.polyhedron.vertices.get(i as usize).copied().unwrap_or_default();
                        self.add_flat(triangle.map(|i| spec.placement.apply(corner(i)).as_vec3()), paint);
                    }
                }
            }
        }
    }

    fn add_sheet(&mut self, world: &World, sheet: &Sheet, look: &Look, scale: Option<&ColourScale>) {
        let layer = look.layer.index(sheet);
        let surface = layer.and_then(|layer| DrawingSurface::of_sheet(sheet, layer, look.parts, look.spline));
        let Some(surface) = surface else { return };
        let mut mesh = surface.mesh(&sheet.state.x);
        if let Some(view) = world.rigid().map(|rigid| rigid.view()) {
            let (reach, skin) = display_clearance(sheet, look.parts);
            clear_of_bodies(&view, &mesh.indices, reach, skin, &mut mesh.positions, &mut mesh.normals);
        }
        let position = |i: u32| mesh.positions.get(i as usize).map_or(Vec3::ZERO, |p| Vec3::from(*p));
        let normal = |i: u32| mesh.normals.get(i as usize).map_or(Vec3::Y, |n| Vec3::from(*n));
        let scale = scale.filter(|scale| scale.applies_to(sheet));
        let sides = scale.map(|scale| [true, false].map(|upper| colours(scale, (sheet, upper), &surface)));
        for triangle in &mesh.indices {
            let (corners, normals) = (triangle.map(position), triangle.map(normal));
            let paint = match &sides {
                Some(sides) => {
                    let [above, below] =
                        [0, 1].map(|s| triangle.map(|i| sides[s].get(i as usize).copied().unwrap_or(Vec3::ONE)));
                    Paint::Graded(above, below)
                }
                None => Paint::Sheet(SHEET_ABOVE, SHEET_BELOW),
            };
            self.triangles.push(Triangle { corners, normals, paint });
        }
    }

    /// Bounding box of everything that casts a shadow, m; the origin when nothing does.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let corners = || self.triangles.iter().filter(|t| t.throws_shadow()).flat_map(|t| t.corners);
        (corners().reduce(Vec3::min).unwrap_or_default(), corners().reduce(Vec3::max).unwrap_or_default())
    }
}
