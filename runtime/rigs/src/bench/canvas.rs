//! Drawing surface in units of the SVG: lines, texts, outlines. A bitmap uses the same calls at a
//! larger scale.

use std::path::Path;

use plotters::coord::Shift;
use plotters::element::{PathElement, Polygon, Rectangle, Text};
use plotters::prelude::{
    BitMapBackend, Color, DrawingArea, DrawingAreaErrorKind, DrawingBackend, FontTransform, IntoDrawingArea, IntoFont,
    RGBColor, SVGBackend,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, ShapeStyle, TextStyle, register_font};
use sheetwork::InputError;

const FONT: &str = "sans-serif";
/// Bitmap pixels per unit, and subdivisions of the SVG grid per unit.
const SCALE: u32 = 2;
const FINE: u32 = 8;

/// Colour of texts and axes.
pub const INK: RGBColor = RGBColor(36, 41, 47);

/// Result of a drawing call.
pub type DrawResult<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// Horizontal anchor of a text; vertically it is centred.
#[derive(Clone, Copy, PartialEq)]
pub enum TextAnchor {
    Left,
    Centre,
    Right,
    /// Centred, rotated to read upwards.
    Upwards,
}

/// A drawing for any surface.
pub trait Drawing {
    /// Width and height, units.
    fn size(&self) -> (u32, u32);

    /// Draws the picture.
    ///
    /// # Errors
    /// Errors of the surface.
    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<B>) -> DrawResult<B>;
}

/// Writes a picture as SVG.
///
/// # Errors
/// Failure to write.
pub fn svg(path: &Path, picture: &impl Drawing) -> Result<(), InputError> {
    prepare_font()?;
    let (width, height) = picture.size();
    // The backend has integer coordinates only. A finer grid than the shown one keeps discs round.
    let fine = (FINE * width, FINE * height);
    let mut text = String::new();
    let canvas = Canvas { area: SVGBackend::with_string(&mut text, fine).into_drawing_area(), scale: FINE.into() };
    picture.draw(&canvas).map_err(|e| InputError::new("", e.to_string()).in_file(path))?;
    drop(canvas);
    let [drawn, shown] = [fine, (width, height)].map(|(w, h)| format!("<svg width=\"{w}\" height=\"{h}\""));
    std::fs::write(path, text.replacen(&drawn, &shown, 1)).map_err(|e| InputError::io(path, &e))
}

/// Writes a picture as a PNG bitmap.
///
/// # Errors
/// Failure to write.
pub fn png(path: &Path, picture: &impl Drawing) -> Result<(), InputError> {
    prepare_font()?;
    let (width, height) = picture.size();
    let (width, height) = (SCALE * width, SCALE * height);
    let mut pixels = vec![0; (width * height * 3) as usize];
    let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
    let canvas = Canvas { area, scale: SCALE.into() };
    picture.draw(&canvas).map_err(|e| InputError::new("", e.to_string()).in_file(path))?;
    drop(canvas);
    write_png(path, (width, height), &pixels)
}

/// Writes RGB pixels, 8 bits a channel, as a PNG.
///
/// # Errors
/// Failure to write.
pub fn write_png(path: &Path, (width, height): (u32, u32), pixels: &[u8]) -> Result<(), InputError> {
    let file = std::fs::File::create(path).map_err(|e| InputError::io(path, &e))?;
    let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), width, height);
    encoder.set_color(png::ColorType::Rgb);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels));
    written.map_err(|e| InputError::new("", e.to_string()).in_file(path))
}

/// A surface, and its pixels per unit.
pub struct Canvas<B: DrawingBackend> {
    pub area: DrawingArea<B, Shift>,
    pub scale: f64,
}

/// Registers the built-in font, so that text needs no system font.
///
/// # Errors
/// An unreadable built-in font.
pub fn prepare_font() -> Result<(), InputError> {
    let font = epaint_default_fonts::UBUNTU_LIGHT;
    register_font(FONT, FontStyle::Normal, font).map_err(|_| InputError::new("font", "cannot be read"))
}

impl<B: DrawingBackend> Canvas<B> {
    fn at(&self, (x, y): (f64, f64)) -> (i32, i32) {
        ((x * self.scale).round() as i32, (y * self.scale).round() as i32)
    }

    /// A line through points, `width` units wide.
    pub fn line(&self, points: &[(f64, f64)], colour: RGBColor, width: f64) -> DrawResult<B> {
        let points: Vec<_> = points.iter().map(|&p| self.at(p)).collect();
        self.area.draw(&PathElement::new(points, self.pen(colour, width)))
    }

    /// A dashed line.
    pub fn dashes(&self, (a, b): ((f64, f64), (f64, f64)), colour: RGBColor) -> DrawResult<B> {
        let count = ((b.0 - a.0).hypot(b.1 - a.1) / 8.0).ceil().max(1.0);
        let along = |k: f64| (a.0 + (b.0 - a.0) * k / count, a.1 + (b.1 - a.1) * k / count);
        for dash in 0..count as u32 {
            let k = f64::from(dash);
            self.line(&[along(k), along(k + 0.5)], colour, 1.0)?;
        }
        Ok(())
    }

    /// A filled rectangle.
    pub fn fill(&self, (a, b): ((f64, f64), (f64, f64)), colour: RGBColor) -> DrawResult<B> {
        self.area.draw(&Rectangle::new([self.at(a), self.at(b)], colour.filled()))
    }

    /// A filled polygon.
    pub fn polygon(&self, corners: &[(f64, f64)], colour: RGBColor) -> DrawResult<B> {
        let corners: Vec<_> = corners.iter().map(|&p| self.at(p)).collect();
        self.area.draw(&Polygon::new(corners, colour.filled()))
    }

    /// A text of `size` units at a point.
    pub fn text(&self, text: &str, at: (f64, f64), size: f64, anchor: TextAnchor, colour: RGBColor) -> DrawResult<B> {
        let horizontal = match anchor {
            TextAnchor::Left => HPos::Left,
            TextAnchor::Centre | TextAnchor::Upwards => HPos::Center,
            TextAnchor::Right => HPos::Right,
        };
        let mut font = (FONT, size * self.scale).into_font();
        if anchor == TextAnchor::Upwards {
            font = font.transform(FontTransform::Rotate270);
        }
        let style = TextStyle::from(font).color(&colour).pos(Pos::new(horizontal, VPos::Center));
        self.area.draw(&Text::new(text.to_owned(), self.at(at), style))
    }

    /// Width of a text of `size`, units.
    pub fn width(&self, text: &str, size: f64) -> f64 {
        let style = TextStyle::from((FONT, size * self.scale).into_font());
        self.area
            .estimate_text_size(text, &style)
            .map_or(0.5 * size * text.len() as f64, |(w, _)| f64::from(w) / self.scale)
    }

    fn pen(&self, colour: RGBColor, width: f64) -> ShapeStyle {
        colour.stroke_width((width * self.scale).round().max(1.0) as u32)
    }
}
