//! Shading: a key light with soft shadows, ambient light from sky and floor, gloss on the sheet.

use glam::Vec3;

use super::model::{Model, Paint, Triangle};
use super::raster::{NOTHING, View, VisibilityBuffer};

/// Samples along each edge of the shadow map.
const SHADOW_SIZE: usize = 1024;

/// Half-width of the shadow filter, samples of the shadow map.
const SHADOW_REACH: i32 = 3;

/// Light intensities, linear red, green, blue.
const KEY: Vec3 = Vec3::new(0.88, 0.83, 0.76);
const FILL: Vec3 = Vec3::new(0.50, 0.52, 0.54);
const SKY: Vec3 = Vec3::new(0.36, 0.40, 0.46);
const GROUND: Vec3 = Vec3::new(0.25, 0.23, 0.21);

/// Direction to the fill light, unit length.
const FILL_FROM: Vec3 = Vec3::new(-0.414, 0.373, 0.829);

/// Lights with the shadow map of the model.
pub(super) struct Light {
    towards: Vec3,
    view: View,
    shadow: VisibilityBuffer,
    bias: f32,
}

impl Light {
    pub fn new(model: &Model) -> Self {
        let towards = Vec3::new(0.66, 1.0, -0.30).normalize();
        let (low, high) = model.bounds();
        let radius = (0.5 * (high - low).length()).max(1e-6);
        let view = View::parallel(0.5 * (low + high), towards, 1.02 * radius, SHADOW_SIZE);
        let shadow = VisibilityBuffer::by_light(model, &view);
        Self { towards, view, shadow, bias: 6.0 * radius / SHADOW_SIZE as f32 }
    }

    /// Linear colour at sample `at`.
    pub fn colour(&self, model: &Model, view: &View, seen: &VisibilityBuffer, at: (usize, usize)) -> Vec3 {
        let index = at.1 * view.columns + at.0;
        let direction = view.direction(at);
        let triangle = match seen.triangle.get(index) {
            Some(i) if *i != NOTHING => &model.triangles[*i as usize],
            _ => return background(at.1 as f32 / view.rows as f32),
        };
        let depth = seen.depth[index];
        let point = view.point(at, depth);
        let front = triangle.across().dot(direction) < 0.0;
        let normal = if front { normal_at(triangle, point) } else { -normal_at(triangle, point) };
        let (base, gloss) = match triangle.paint {
            Paint::Matt(colour) | Paint::Metal(colour) => (colour, 0.06),
            Paint::Sheet(above, below) => (if front { above } else { below }, 0.30),
            Paint::Graded(above, below) => {
                let [a, b, c] = if front { above } else { below };
                let [wa, wb, wc] = weights(triangle, point).unwrap_or([1.0, 0.0, 0.0]);
                (a * wa + b * wb + c * wc, 0.22)
            }
            Paint::Glowing(colour) => return colour,
            Paint::Grid(colour, spacing, axes) => (grid(colour, spacing, axes, point, view.sample_width(depth)), 0.0),
        };
        let lit = normal.dot(self.towards).max(0.0);
        let shade = if lit > 0.0 { lit * self.reaches(point + normal * self.bias) } else { 0.0 };
        let half = (self.towards - direction).normalize_or(Vec3::Y);
        let highlight = gloss * normal.dot(half).max(0.0).powi(48) * shade;
        let ambient = GROUND.lerp(SKY, 0.5 + 0.5 * normal.y) + FILL * normal.dot(FILL_FROM).max(0.0);
        soften(base * (ambient + KEY * shade) + Vec3::splat(highlight))
    }

    /// Fraction of the key light that reaches a point: a weighted mean over the shadow map.
    fn reaches(&self, point: Vec3) -> f32 {
        let p = self.view.project(point);
        let (mut clear, mut all) = (0.0, 0.0);
        for dy in -SHADOW_REACH..=SHADOW_REACH {
            for dx in -SHADOW_REACH..=SHADOW_REACH {
                let (x, y) = (p.x + 1.5 * dx as f32, p.y + 1.5 * dy as f32);
                // A round kernel avoids corners.
                let weight = (1.0 - (dx * dx + dy * dy) as f32 / 19.0).max(0.0);
                let inside = x >= 0.0 && y >= 0.0 && x < SHADOW_SIZE as f32 && y < SHADOW_SIZE as f32;
                let index = if inside { y as usize * SHADOW_SIZE + x as usize } else { 0 };
                let blocked = inside && self.shadow.depth[index] > p.z + self.bias;
                clear += if blocked { 0.0 } else { weight };
                all += weight;
            }
        }
        clear / all
    }
}

/// Interpolated normal at a point of a triangle.
fn normal_at(triangle: &Triangle, point: Vec3) -> Vec3 {
    let [na, nb, nc] = triangle.normals;
    let Some([wa, wb, wc]) = weights(triangle, point) else { return na };
    (na * wa + nb * wb + nc * wc).normalize_or(na)
}

/// Barycentric weights of a point of a triangle; `None` for a degenerate one.
fn weights(triangle: &Triangle, point: Vec3) -> Option<[f32; 3]> {
    let [a, b, c] = triangle.corners;
    let across = triangle.across();
    let area = across.length_squared();
    if area <= 0.0 {
        return None;
    }
    let wb = (point - a).cross(c - a).dot(across) / area;
    let wc = (b - a).cross(point - a).dot(across) / area;
    Some([1.0 - wb - wc, wb, wc])
}

/// Colour of a plane with grid lines, every fifth stronger; lines finer than a sample fade.
fn grid(colour: Vec3, spacing: f32, axes: [usize; 2], point: Vec3, sample: f32) -> Vec3 {
    let mut strength: f32 = 0.0;
    for axis in axes {
        for (every, weight) in [(1.0, 0.16), (5.0, 0.30)] {
            let step = spacing * every;
            let x = point[axis] / step;
            let distance = (x - x.round()).abs() * step;
            let width = (0.018 * spacing).max(0.7 * sample);
            let cover = (1.0 - distance / width).clamp(0.0, 1.0);
            strength = strength.max(weight * cover * (0.25 * step / sample).min(1.0));
        }
    }
    colour * (1.0 - strength)
}

/// Background gradient; `y` is 0 at the top and 1 at the bottom of the picture.
fn background(y: f32) -> Vec3 {
    Vec3::new(0.60, 0.68, 0.78).lerp(Vec3::new(0.86, 0.86, 0.84), y)
}

/// Tone mapping of bright values against clipping.
fn soften(colour: Vec3) -> Vec3 {
    colour.map(|c| if c < 0.7 { c } else { 0.7 + 0.3 * (1.0 - (-(c - 0.7) / 0.3).exp()) })
}
