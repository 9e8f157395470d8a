//! Software rendering: room, bodies and sheets by a small rasteriser, without graphics hardware.
//!
//! `model` converts a world into triangles, `raster` determines visibility at every sample, `shade`
//! the colour, `legend` draws the colour scale, `image` stores the result. 2 x 2 samples per pixel
//! and a shadow map of the key light.

mod image;
mod legend;
mod model;
mod raster;
mod shade;

use sheetwork::World;

use crate::camera::Camera;
use image::encode;
pub use image::{LARGEST, Picture};
pub use model::Look;

/// Samples along each edge of a pixel.
const SAMPLES: usize = 2;

impl Picture {
    /// Draw the present state of `world`, seen by `camera`; width and height in pixels, each
    /// clamped to 1 to [`LARGEST`].
    pub fn draw(world: &World, camera: &Camera, look: &Look, (width, height): (u32, u32)) -> Self {
        let (width, height) = (width.clamp(1, LARGEST), height.clamp(1, LARGEST));
        let model = model::Model::from_world(world, look);
        let (columns, rows) = (width as usize * SAMPLES, height as usize * SAMPLES);
        let view = raster::View::perspective(camera, columns, rows);
        let seen = raster::VisibilityBuffer::find(&model, &view);
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
}

#[cfg(test)]
mod tests {
    use super::image::{GAP, decode};
    use super::*;
    use sheetwork::scene::Scene;
    use std::fs::File;

    fn world() -> World {
        let scene = Scene::parse(include_str!("../../tests/scenes/wedge.ron")).expect("valid");
        World::new(&scene).expect("valid")
    }

    fn share(picture: &Picture, like: impl Fn([u8; 3]) -> bool) -> f64 {
        let all = picture.width * picture.height;
        let hits = (0..all).filter(|i| like(picture.at(i % picture.width, i / picture.width))).count();
        hits as f64 / f64::from(all)
    }

    /// Only the sheet has much more red than blue.
    fn red([r, _, b]: [u8; 3]) -> bool {
        i32::from(r) - i32::from(b) > 70
    }

    #[test]
    fn sheet_body_and_floor_are_all_in_the_picture() {
        let world = world();
        let picture = Picture::draw(&world, &Camera::from_world(&world), &Look::default(), (160, 120));
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
        let front = Camera { pitch: 0.4, ..Camera::from_world(&world) };
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
    fn a_camera_inside_the_scene_and_an_empty_size_are_drawn() {
        let world = world();
        let inside = Camera { distance: 1e-4, ..Camera::from_world(&world) };
        let picture = Picture::draw(&world, &inside, &Look::default(), (64, 48));
        assert_eq!(picture.pixels.len(), 64 * 48 * 3);
        assert_eq!(Picture::draw(&world, &inside, &Look::default(), (0, 0)).pixels.len(), 3);
    }

    #[test]
    fn a_halved_picture_has_the_mean_light_of_four_pixels() {
        let picture =
            Picture { width: 3, height: 2, pixels: [[0; 3], [255; 3], [9; 3], [255; 3], [0; 3], [9; 3]].concat() };
        // Half the linear light of white is 188 in sRGB.
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
    fn a_written_picture_is_read_back_unchanged() {
        let world = world();
        let picture = Picture::draw(&world, &Camera::from_world(&world), &Look::default(), (40, 30));
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
