//! Curves over time in one diagram.

use std::path::Path;

use plotters::prelude::{DrawingBackend, RGBColor};
use sheetwork::InputError;

use crate::bench::canvas::{self, Canvas, DrawResult, Drawing, INK, TextAnchor};

const SIZE: (u32, u32) = (640, 300);
const LEFT: f64 = 60.0;
const RIGHT: f64 = 190.0;
const TOP: f64 = 32.0;
const BOTTOM: f64 = 40.0;
const TEXT: f64 = 13.0;
const COLOURS: [RGBColor; 6] = [
    RGBColor(200, 60, 30),
    RGBColor(40, 110, 190),
    RGBColor(50, 140, 70),
    RGBColor(150, 90, 170),
    RGBColor(190, 140, 20),
    RGBColor(90, 100, 110),
];

/// Curves with common axes.
pub(crate) struct Diagram {
    pub caption: String,
    /// Labels of the axes with units.
    pub axes: (&'static str, &'static str),
    /// Name and points of each curve.
    pub curves: Vec<(String, Vec<(f64, f64)>)>,
}

impl Drawing for Diagram {
    fn size(&self) -> (u32, u32) {
        SIZE
    }

    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<B>) -> DrawResult<B> {
        let points = || self.curves.iter().flat_map(|(_, points)| points);
        let (most_x, most_y) = points().fold((1e-12_f64, 1e-12_f64), |(x, y), p| (x.max(p.0), y.max(p.1)));
        let (width, height) = (f64::from(SIZE.0) - LEFT - RIGHT, f64::from(SIZE.1) - TOP - BOTTOM);
        let place = |(x, y): (f64, f64)| (LEFT + width * x / most_x, TOP + height * (1.0 - (y / most_y).max(0.0)));
        canvas.fill(((0.0, 0.0), (f64::from(SIZE.0), f64::from(SIZE.1))), RGBColor(255, 255, 255))?;
        canvas.line(&[(LEFT, TOP), (LEFT, TOP + height), (LEFT + width, TOP + height)], INK, 1.0)?;
        for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let label = |most: f64| format!("{:.3}", part * most);
            let (x, y) = place((part * most_x, part * most_y));
            canvas.text(&label(most_x), (x, TOP + height + 12.0), TEXT, TextAnchor::Centre, INK)?;
            canvas.text(&label(most_y), (LEFT - 6.0, y), TEXT, TextAnchor::Right, INK)?;
        }
        canvas.text(self.axes.0, (LEFT + 0.5 * width, TOP + height + 30.0), TEXT, TextAnchor::Centre, INK)?;
        canvas.text(self.axes.1, (LEFT, 12.0), TEXT, TextAnchor::Left, INK)?;
        for (index, (name, points)) in self.curves.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let points: Vec<(f64, f64)> = points.iter().map(|p| place(*p)).collect();
            canvas.line(&points, colour, 1.8)?;
            let y = TOP + 12.0 + 18.0 * index as f64;
            let x = LEFT + width + 12.0;
            canvas.line(&[(x, y), (x + 20.0, y)], colour, 2.4)?;
            canvas.text(name, (x + 26.0, y), TEXT, TextAnchor::Left, INK)?;
        }
        Ok(())
    }
}

/// Writes the diagram as a PNG.
///
/// # Errors
/// Failure to write.
pub(crate) fn png(path: &Path, diagram: &Diagram) -> Result<(), InputError> {
    canvas::png(path, diagram)
}
