//! Image of 8-bit colours, and its file.

use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::Path;

/// Width of the line between tiles, pixels.
pub(super) const GAP: u32 = 6;

/// Largest width and height, pixels.
pub const LARGEST: u32 = 8192;

/// Image of 8-bit red, green, blue, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Three bytes per pixel, sRGB.
    pub pixels: Vec<u8>,
}

impl Picture {
    /// Images of one size in rows, with a white line between them.
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

    /// Image of a PNG file of 8-bit red, green, blue; `None` for a file that cannot be read, is of
    /// another kind, or is larger than [`LARGEST`].
    pub fn read(path: &Path) -> Option<Self> {
        let mut reader = png::Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok()?;
        let info = reader.info();
        let (width, height) = (info.width, info.height);
        let is_rgb = info.color_type == png::ColorType::Rgb && info.bit_depth == png::BitDepth::Eight;
        if !is_rgb || width > LARGEST || height > LARGEST {
            return None;
        }
        let mut pixels = vec![0; 3 * width as usize * height as usize];
        reader.next_frame(&mut pixels).ok()?;
        Some(Self { width, height, pixels })
    }

    /// Image at half width and height: each pixel is the mean linear light of four; an odd last row
    /// or column is dropped.
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

    /// Write a PNG file.
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

/// Linear light as an sRGB byte.
pub(super) fn encode(linear: f32) -> u8 {
    let c = linear.clamp(0.0, 1.0);
    let s = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (255.0 * s + 0.5) as u8
}

/// An sRGB byte as linear light.
pub(super) fn decode(byte: u8) -> f32 {
    let s = f32::from(byte) / 255.0;
    if s <= 0.040_45 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}
