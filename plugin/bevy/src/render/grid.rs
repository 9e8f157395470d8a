//! Texture of a square grid: thin lines on warm light grey, each fifth line stronger, with mipmaps
//! against aliasing at a distance.

use bevy::asset::RenderAssetUsages;
use bevy::image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};

/// Squares per side of the texture.
pub(super) const SQUARES: u32 = 5;

/// Pixels per side, a power of two.
const SIDE: u32 = 512;

/// Background colour, sRGB.
const PAPER: [f32; 3] = [0.875, 0.862, 0.838];
/// Line colour, sRGB.
const INK: [f32; 3] = [0.47, 0.465, 0.46];

/// Repeating texture of a room's squares; one unit of the texture coordinate is five squares.
pub fn grid_picture() -> Image {
    let mut data = Vec::new();
    let mut side = SIDE;
    let mut levels = 0;
    while side >= 1 {
        for y in 0..side {
            for x in 0..side {
                let ink = covered(x, side).max(covered(y, side));
                for (paper, line) in PAPER.iter().zip(INK) {
                    data.push(((paper + (line - paper) * ink) * 255.0 + 0.5) as u8);
                }
                data.push(255);
            }
        }
        levels += 1;
        side /= 2;
    }
    let size = Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 };
    let mut image =
        Image::new_uninit(size, TextureDimension::D2, TextureFormat::Rgba8UnormSrgb, RenderAssetUsages::default());
    image.data = Some(data);
    image.texture_descriptor.mip_level_count = levels;
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        mipmap_filter: ImageFilterMode::Linear,
        anisotropy_clamp: 16,
        ..default()
    });
    image
}

/// Coverage of pixel `i` of `side` by the lines across its row, 0 to 1.
fn covered(i: u32, side: u32) -> f32 {
    // In squares; the pixel spans a to b.
    let scale = SQUARES as f32 / side as f32;
    let (a, b) = (i as f32 * scale, (i + 1) as f32 * scale);
    let mut ink: f32 = 0.0;
    for line in 0..=SQUARES {
        let strong = line % SQUARES == 0;
        let (half, strength) = if strong { (0.022, 0.8) } else { (0.014, 0.5) };
        let (from, to) = (line as f32 - half, line as f32 + half);
        let cover = (b.min(to) - a.max(from)).max(0.0) / (b - a);
        ink += cover * strength;
    }
    ink.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_smaller_copy_is_as_dark_as_the_picture() {
        let mean = |side: u32| (0..side).map(|i| covered(i, side)).sum::<f32>() / side as f32;
        for level in 0..10 {
            assert!((mean(SIDE >> level) - mean(SIDE)).abs() < 1e-3, "level {level}");
        }
    }
}
