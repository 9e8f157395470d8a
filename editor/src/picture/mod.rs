//! A picture without graphics hardware: the scene's room, bodies and sheets drawn by a small rasteriser of our own.
//!
//! `model` turns a world into triangles, `raster` finds what is seen at every sample, `shade` gives it its colour, `legend` says what
//! colours stand for. Several samples a pixel and a shadow map of the key light make it fit to be shown.

mod legend;
mod model;
mod raster;
mod shade;

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use sheetwork::World;

use crate::camera::Camera;
pub use model::{Layer, Look};

/// Samples along each edge of a pixel.
const SAMPLES: usize = 2;

/// Width of the line between pictures, pixels.
const GAP: u32 = 6;

/// Largest width and height, pixels.
pub const LARGEST: u32 = 8192;

/// A picture: 8-bit red, green, blue, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Three bytes a pixel, sRGB.
    pub pixels: Vec<u8>,
}

impl Picture {
    /// Draws the world as it is now, seen by `camera`; width and height in pixels, each taken to 1 to [`LARGEST`].
    pub fn draw(world: &World, camera: &Camera, look: &Look, (width, height): (u32, u32)) -> Self {
        let (width, height) = (width.clamp(1, LARGEST), height.clamp(1, LARGEST));
        let model = model::Model::of(world, look);
        let (columns, rows) = (width as usize * SAMPLES, height as usize * SAMPLES);
        let view = raster::View::perspective(camera, columns, rows);
        let seen = raster::Seen::find(&model, &view);
        let light = shade::Light::new(&model);
        let mut pixels = Vec::with_capacity(3 * width as usize * height as usize);
        for y in 0..height as usize {
            for x in 0..width as usize {
                let mut sum = glam::Vec3::ZERO;
                for sample in 0..SAMPLES * SAMPLES {
                    let at = (x * SAMPLES + sample % SAMPLES, y * SAMPLES + sample / SAMPLES);
                    sum += light.colour(&model, &view, &seen, at);
                }
                let mean = sum / (SAMPLES * SAMPLES) as f32;
                pixels.extend(mean.to_array().map(encode));
            }
        }
        let mut picture = Self { width, height, pixels };
        if let Some(scale) = look.scale(world) {
            legend::draw(&mut picture, &scale);
        }
        picture
    }

    /// Pictures of one size side by side, row below row, with a white line between them.
    pub fn tiled(rows: &[Vec<Self>]) -> Self {
        let (width, height) = rows.iter().flatten().next().map_or((1, 1), |p| (p.width, p.height));
        let columns = rows.iter().map(Vec::len).max().unwrap_or(1).max(1) as u32;
        let across = columns * width + (columns - 1) * GAP;
        let down = rows.len().max(1) as u32 * height + (rows.len().max(1) as u32 - 1) * GAP;
        let mut pixels = vec![255; 3 * across as usize * down as usize];
        for (r, row) in rows.iter().enumerate() {
            for (c, tile) in row.iter().enumerate() {
                let (left, top) = (c as u32 * (width + GAP), r as u32 * (height + GAP));
                for (y, line) in tile.pixels.chunks_exact(3 * tile.width as usize).enumerate() {
                    let first = 3 * ((top as usize + y) * across as usize + left as usize);
                    if let Some(to) = pixels.get_mut(first..first + line.len()) {
                        to.copy_from_slice(line);
                    }
                }
            }
        }
        Self { width: across, height: down, pixels }
    }

    /// The picture at half its width and height, each pixel the mean light of four; an odd last row or column is left out.
    pub fn halved(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let linear: Vec<f32> = (0..=255).map(decode).collect();
        let mut pixels = Vec::with_capacity(3 * width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| self.at(2 * x + dx, 2 * y + dy));
                pixels.extend(
                    [0, 1, 2].map(|c| encode(four.iter().map(|p| linear[usize::from(p[c])]).sum::<f32>() / 4.0)),
                );
            }
        }
        Self { width, height, pixels }
    }

    /// Colour of the pixel in column `x` of row `y`; black outside.
    pub fn at(&self, x: u32, y: u32) -> [u8; 3] {
        if x >= self.width || y >= self.height {
            return [0; 3];
        }
        let first = 3 * (y as usize * self.width as usize + x as usize);
        match self.pixels.get(first..first + 3) {
            Some([r, g, b]) => [*r, *g, *b],
            _ => [0; 3],
        }
    }

    /// Writes a PNG file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn save(&self, file: &Path) -> std::io::Result<()> {
        let mut encoder = png::Encoder::new(BufWriter::new(File::create(file)?), self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        Ok(writer.finish()?)
    }
}

/// Linear light to an sRGB byte.
fn encode(linear: f32) -> u8 {
    let c = linear.clamp(0.0, 1.0);
    let s = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (255.0 * s + 0.5) as u8
}

/// An sRGB byte as linear light.
fn decode(byte: u8) -> f32 {
    let s = f32::from(byte) / 255.0;
    if s <= 0.040_45 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::scene::Scene;

    fn world() -> World {
        let scene = Scene::parse(include_str!("../../tests/scenes/wedge.ron")).expect("valid");
        World::new(&scene).expect("valid")
    }

    fn share(picture: &Picture, like: impl Fn([u8; 3]) -> bool) -> f64 {
        let all = picture.width * picture.height;
        let hits = (0..all).filter(|i| like(picture.at(i % picture.width, i / picture.width))).count();
        hits as f64 / f64::from(all)
    }

    /// The sheet is the only thing with much more red than blue.
    fn red([r, _, b]: [u8; 3]) -> bool {
        i32::from(r) - i32::from(b) > 70
    }

    #[test]
    fn sheet_body_and_floor_are_all_in_the_picture() {
        let world = world();
        let picture = Picture::draw(&world, &Camera::of(&world), &Look::default(), (160, 120));
        let sheet = share(&picture, red);
        assert!((0.03..0.5).contains(&sheet), "the sheet covers {sheet}");
        let blue = share(&picture, |[r, _, b]| i32::from(b) - i32::from(r) > 12);
        assert!(blue > 0.02, "the wedge covers {blue}");
        let tones: std::collections::BTreeSet<&[u8]> = picture.pixels.chunks(3).collect();
        assert!(tones.len() > 200, "a shaded picture has many tones, not {}", tones.len());
    }

    #[test]
    fn the_room_is_seen_through_from_behind() {
        let world = world();
        let front = Camera { pitch: 0.4, ..Camera::of(&world) };
        let behind = Camera { yaw: std::f32::consts::PI, ..front };
        let below = Camera { pitch: -1.2, ..front };
        let drawn = |camera| Picture::draw(&world, camera, &Look::default(), (120, 90));
        for camera in [&front, &behind] {
            assert!(share(&drawn(camera), red) > 0.01, "the sheet is hidden from {camera:?}");
        }
        let blue = share(&drawn(&below), |[r, _, b]| i32::from(b) - i32::from(r) > 12);
        assert!(blue > 0.05, "the floor hides the wedge's base from below: {blue}");
    }

    #[test]
    fn a_camera_inside_the_scene_and_a_size_of_nothing_are_survived() {
        let world = world();
        let inside = Camera { distance: 1e-4, ..Camera::of(&world) };
        let picture = Picture::draw(&world, &inside, &Look::default(), (64, 48));
        assert_eq!(picture.pixels.len(), 64 * 48 * 3);
        assert_eq!(Picture::draw(&world, &inside, &Look::default(), (0, 0)).pixels.len(), 3);
    }

    #[test]
    fn half_a_picture_has_the_mean_light_of_four_pixels() {
        let picture =
            Picture { width: 3, height: 2, pixels: [[0; 3], [255; 3], [9; 3], [255; 3], [0; 3], [9; 3]].concat() };
        // Half the light of white is 188 in sRGB.
        assert_eq!(picture.halved(), Picture { width: 1, height: 1, pixels: vec![188; 3] });
        assert!((0..=255).all(|byte| encode(decode(byte)) == byte));
    }

    #[test]
    fn pictures_are_put_side_by_side_and_below_one_another() {
        let tile = |shade| Picture { width: 4, height: 2, pixels: vec![shade; 24] };
        let all = Picture::tiled(&[vec![tile(10), tile(20)], vec![tile(30), tile(40)]]);
        assert_eq!((all.width, all.height), (4 + GAP + 4, 2 + GAP + 2));
        assert_eq!(
            [all.at(0, 0), all.at(4 + GAP, 1), all.at(3, 2 + GAP), all.at(4, 0)],
            [[10; 3], [20; 3], [30; 3], [255; 3]]
        );
        assert_eq!(Picture::tiled(&[vec![tile(7)]]), tile(7));
    }

    #[test]
    fn a_picture_comes_back_from_its_file() {
        let world = world();
        let picture = Picture::draw(&world, &Camera::of(&world), &Look::default(), (40, 30));
        let file = std::env::temp_dir().join(format!("sheetwork-picture-{}.png", std::process::id()));
        picture.save(&file).expect("written");
        let decoder = png::Decoder::new(std::io::BufReader::new(File::open(&file).expect("there")));
        let mut reader = decoder.read_info().expect("a PNG");
        let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut bytes).expect("a frame");
        assert_eq!(bytes, picture.pixels);
        std::fs::remove_file(&file).expect("removed");
    }
}
