//! Prints of a run as a picture: sheets and bodies in perspective, with a depth buffer, shadows on
//! the floor and a grid, without a graphics card.
//!
//! A print is drawn at three times its size and averaged (3x3 samples a pixel). The camera is that
//! of the scene. Light falls from one direction; a surface of normal n has the brightness ambient +
//! (1 - ambient) |n·l|, the lower side of a sheet less.

use std::path::Path;

use glam::{DMat3, DVec2, DVec3};
use plotters::prelude::{BitMapBackend, IntoDrawingArea};
use sheetwork::scene::{CameraSpec, Shape};
use sheetwork::sheet::Sheet;
use sheetwork::sheet::surface::DrawingSurface;
use sheetwork::{InputError, World};

use crate::bench::canvas::{Canvas, INK, TextAnchor, prepare_font, write_png};

/// Width and height of a print, pixels.
const SIZE: (usize, usize) = (320, 220);
/// Samples of a pixel along each side.
const SAMPLES: usize = 3;
/// Prints in a row of the picture.
const COLUMNS: usize = 3;
/// Distance between prints, pixels.
const MARGIN: usize = 6;
/// Tangent of half the vertical field of view.
const HALF_VIEW: f64 = 0.27;
/// Direction to the light.
const LIGHT: DVec3 = DVec3::new(0.35, 0.87, 0.35);
/// Part of the light that has no direction.
const AMBIENT: f64 = 0.45;
/// Part of the floor's brightness in a shadow.
const SHADOW: f64 = 0.72;
/// Triangles of a ball along a meridian.
const BALL_PARTS: u32 = 16;

type Colour = [f64; 3];
const SKY: Colour = [0.93, 0.94, 0.95];
const FLOOR: Colour = [0.88, 0.87, 0.84];
const GRID: Colour = [0.74, 0.73, 0.70];
const BODY: Colour = [0.60, 0.68, 0.80];
/// Upper and lower side of each sheet; further sheets begin anew.
const SHEETS: [[Colour; 2]; 3] = [
    [[0.93, 0.33, 0.18], [0.62, 0.20, 0.12]],
    [[0.95, 0.68, 0.20], [0.66, 0.45, 0.12]],
    [[0.27, 0.60, 0.45], [0.17, 0.40, 0.30]],
];

/// Prints in a row, with a caption for the report.
pub(crate) struct Strip {
    pub caption: String,
    pub prints: Vec<Print>,
}

/// A triangle of a print: corners (m), and the colours of its two sides.
struct Face {
    corners: [DVec3; 3],
    colours: [Colour; 2],
}

/// State of a scene at one time.
pub(crate) struct Print {
    label: String,
    faces: Vec<Face>,
    camera: CameraSpec,
    /// Height of the floor and spacing of its grid, m.
    floor: Option<(f64, f64)>,
}

impl Print {
    /// The present state of a world, its sheets drawn by their top layers.
    pub fn new(world: &World, label: String) -> Self {
        Self::drawn(world, label, |sheet| sheet.surface(sheet.model.layers.len().saturating_sub(1), 2))
    }

    /// The present state of a world, its sheets drawn as `surface` says.
    pub fn drawn(world: &World, label: String, surface: impl Fn(&Sheet) -> Option<DrawingSurface>) -> Self {
        let scene = world.scene();
        let camera = scene.camera.unwrap_or(CameraSpec { eye: DVec3::new(0.5, 0.4, 0.8), target: DVec3::ZERO });
        let floor = scene.room.as_ref().map(|room| (room.y.0, room.grid));
        let mut print = Self { label, faces: Vec::new(), camera, floor };
        print.add_bodies(world);
        for (sheet, colours) in world.sheets().iter().zip(SHEETS.into_iter().cycle()) {
            let Some(surface) = surface(sheet) else { continue };
            let mesh = surface.mesh(&sheet.state.x);
            let at = |i: u32| DVec3::from(mesh.positions[i as usize].map(f64::from));
            print.faces.extend(mesh.indices.iter().map(|t| Face { corners: t.map(at), colours }));
        }
        print
    }

    fn add_bodies(&mut self, world: &World) {
        for (index, body) in world.rigid().into_iter().flat_map(|r| r.bodies().iter().enumerate()) {
            let Some(state) = world.rigid().and_then(|r| r.state(index)) else { continue };
            let pose = |p: DVec3| state.world_point(p);
            if let Shape::Ball(radius) = body.shape {
                ball(radius, |corners| self.add(corners.map(pose)));
            }
            for polyhedron in &body.polyhedra {
                for face in 0..polyhedron.faces.len() {
                    let corners: Vec<DVec3> = polyhedron.corners(face).into_iter().map(pose).collect();
                    for pair in corners.windows(2).skip(1) {
                        self.add([corners[0], pair[0], pair[1]]);
                    }
                }
            }
        }
    }

    fn add(&mut self, corners: [DVec3; 3]) {
        self.faces.push(Face { corners, colours: [BODY; 2] });
    }

    /// Pixels of the print, three samples along each side of a pixel.
    fn render(&self) -> Samples {
        let mut samples = Samples::new(&self.camera);
        if let Some((height, grid)) = self.floor {
            samples.draw_floor(height, grid);
            for face in &self.faces {
                let shadow = face.corners.map(|p| p - LIGHT * ((p.y - height) / LIGHT.y));
                samples.fill(shadow, |sample, _| *sample = sample.map(|c| c.min(SHADOW * FLOOR[0])), true);
            }
        }
        for face in &self.faces {
            let [a, b, c] = face.corners;
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let upper = normal.dot(self.camera.eye - a) > 0.0;
            let brightness = AMBIENT + (1.0 - AMBIENT) * normal.dot(LIGHT.normalize()).abs();
            let colour = face.colours[usize::from(!upper)].map(|c| c * brightness);
            samples.fill(face.corners, |sample, _| *sample = colour, false);
        }
        samples
    }
}

/// Triangles of a ball about the origin.
fn ball(radius: f64, mut add: impl FnMut([DVec3; 3])) {
    let step = std::f64::consts::PI / f64::from(BALL_PARTS);
    let at = |i: u32, j: u32| {
        let (polar, round) = (f64::from(i) * step, f64::from(j) * step);
        radius * DVec3::new(polar.sin() * round.cos(), polar.cos(), polar.sin() * round.sin())
    };
    for i in 0..BALL_PARTS {
        for j in 0..2 * BALL_PARTS {
            add([at(i, j), at(i, j + 1), at(i + 1, j)]);
            add([at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]);
        }
    }
}

/// Samples of a print with their depth, and the camera.
struct Samples {
    colours: Vec<Colour>,
    depths: Vec<f64>,
    eye: DVec3,
    /// Right, up and forwards as columns.
    axes: DMat3,
}

const WIDE: usize = SIZE.0 * SAMPLES;
const HIGH: usize = SIZE.1 * SAMPLES;

impl Samples {
    fn new(camera: &CameraSpec) -> Self {
        let forwards = (camera.target - camera.eye).normalize_or(DVec3::NEG_Z);
        let right = forwards.cross(DVec3::Y).normalize_or(DVec3::X);
        let axes = DMat3::from_cols(right, right.cross(forwards), forwards);
        Self { colours: vec![SKY; WIDE * HIGH], depths: vec![f64::INFINITY; WIDE * HIGH], eye: camera.eye, axes }
    }

    /// Position in samples, and depth (m), of a point.
    fn project(&self, point: DVec3) -> (DVec2, f64) {
        let view = self.axes.transpose() * (point - self.eye);
        let scale = 0.5 * HIGH as f64 / HALF_VIEW / view.z;
        (DVec2::new(0.5 * WIDE as f64 + scale * view.x, 0.5 * HIGH as f64 - scale * view.y), view.z)
    }

    fn draw_floor(&mut self, height: f64, grid: f64) {
        for row in 0..HIGH {
            for column in 0..WIDE {
                let across = (column as f64 + 0.5 - 0.5 * WIDE as f64) * HALF_VIEW / (0.5 * HIGH as f64);
                let up = (0.5 * HIGH as f64 - row as f64 - 0.5) * HALF_VIEW / (0.5 * HIGH as f64);
                let ray = self.axes * DVec3::new(across, up, 1.0);
                let depth = (height - self.eye.y) / ray.y;
                if ray.y < 0.0 && depth > 0.0 {
                    let point = self.eye + ray * depth;
                    // A line is 3 % of a cell wide, and at least two samples.
                    let wide = (0.03 * grid).max(depth * 2.0 * HALF_VIEW / HIGH as f64);
                    let is_line = |v: f64| (v / grid - (v / grid).round()).abs() * grid < 0.5 * wide;
                    let colour = if is_line(point.x) || is_line(point.z) { GRID } else { FLOOR };
                    // Lines closer than a few samples fade into the floor.
                    let fade = (8.0 * wide / grid - 0.6).clamp(0.0, 1.0);
                    let colour = std::array::from_fn(|k| colour[k] + fade * (FLOOR[k] - colour[k]));
                    (self.colours[row * WIDE + column], self.depths[row * WIDE + column]) = (colour, depth);
                }
            }
        }
    }

    /// Calls `paint` for every sample inside a triangle that is nearer than what is there; a shadow
    /// is painted on what is there, a little behind it.
    fn fill(&mut self, corners: [DVec3; 3], mut paint: impl FnMut(&mut Colour, f64), shadow: bool) {
        let [(a, da), (b, db), (c, dc)] = corners.map(|p| self.project(p));
        let area = (b - a).perp_dot(c - a);
        if da.min(db).min(dc) <= 0.0 || area == 0.0 {
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let range = |low: f64, high: f64, most: usize| {
            (low.floor().clamp(0.0, most as f64) as usize)..(high.ceil().clamp(0.0, most as f64) as usize)
        };
        for row in range(low.y, high.y, HIGH) {
            for column in range(low.x, high.x, WIDE) {
                let p = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                let (u, v) = ((b - p).perp_dot(c - p) / area, (c - p).perp_dot(a - p) / area);
                if u < 0.0 || v < 0.0 || u + v > 1.0 {
                    continue;
                }
                // Perspective: the inverse of the depth is linear in the picture.
                let depth = 1.0 / (u / da + v / db + (1.0 - u - v) / dc);
                let index = row * WIDE + column;
                if shadow && (depth / self.depths[index] - 1.0).abs() < 1e-3 {
                    paint(&mut self.colours[index], depth);
                } else if !shadow && depth < self.depths[index] {
                    paint(&mut self.colours[index], depth);
                    self.depths[index] = depth;
                }
            }
        }
    }

    /// Mean of the samples of a pixel, 0 to 255.
    fn pixel(&self, column: usize, row: usize) -> [u8; 3] {
        let mut sum = [0.0; 3];
        for y in 0..SAMPLES {
            for x in 0..SAMPLES {
                let colour = self.colours[(row * SAMPLES + y) * WIDE + column * SAMPLES + x];
                (0..3).for_each(|k| sum[k] += colour[k]);
            }
        }
        sum.map(|c| (255.0 * c / (SAMPLES * SAMPLES) as f64).clamp(0.0, 255.0) as u8)
    }
}

/// Writes prints as a PNG, three in a row, each with its time.
///
/// # Errors
/// Failure to write.
pub(crate) fn png(path: &Path, strip: &Strip) -> Result<(), InputError> {
    let rows = strip.prints.len().div_ceil(COLUMNS);
    let columns = strip.prints.len().min(COLUMNS);
    let (width, height) = (columns * (SIZE.0 + MARGIN) - MARGIN, rows * (SIZE.1 + MARGIN) - MARGIN);
    let mut pixels = vec![255_u8; 3 * width * height];
    let corner = |index: usize| ((index % COLUMNS) * (SIZE.0 + MARGIN), (index / COLUMNS) * (SIZE.1 + MARGIN));
    for (index, print) in strip.prints.iter().enumerate() {
        let samples = print.render();
        let (left, top) = corner(index);
        for row in 0..SIZE.1 {
            for column in 0..SIZE.0 {
                let at = 3 * ((top + row) * width + left + column);
                pixels[at..at + 3].copy_from_slice(&samples.pixel(column, row));
            }
        }
    }
    prepare_font()?;
    let area = BitMapBackend::with_buffer(&mut pixels, (width as u32, height as u32)).into_drawing_area();
    let canvas = Canvas { area, scale: 1.0 };
    for (index, print) in strip.prints.iter().enumerate() {
        let (left, top) = corner(index);
        let letter = char::from(b'A' + (index % 26) as u8);
        let at = ((left + 8) as f64, (top + 14) as f64);
        let drawn = canvas.text(&format!("{letter}  {}", print.label), at, 14.0, TextAnchor::Left, INK);
        drawn.map_err(|e| InputError::new("", e.to_string()).in_file(path))?;
    }
    drop(canvas);
    write_png(path, (width as u32, height as u32), &pixels)
}
