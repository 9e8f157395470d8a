//! Heat maps of the longest stable step of an integrator over stiffness and damping, and over
//! stiffness and mass. Colours show the measured step; lines show the predicted step at the
//! boundaries of the colour bands.

use plotters::prelude::{DrawingBackend, RGBColor, WHITE};

use crate::bench::canvas::{Canvas, DrawResult, Drawing, INK, TextAnchor};
use crate::bench::stability::point::StabilityPoint;

/// Size of a panel with its axes, and of the legend, units.
const PANEL: (f64, f64) = (440.0, 250.0);
const LEGEND: f64 = 64.0;
const LEFT: f64 = 74.0;
/// Subdivisions of a cell for colouring.
const PARTS: u32 = 10;
/// Decades of the step (s) with colours, and bands per decade.
const DECADES: (f64, f64) = (-5.0, 0.0);
const BANDS: f64 = 4.0;
const TEXT: f64 = 14.0;

/// Mass (kg) of the panels over damping, and damping of the panels over mass.
const DAMPING_AT: f64 = 4e-4;
const MASS_AT: f64 = 0.14;

/// Log10 of the measured and predicted steps over a grid.
struct MapPanel {
    title: String,
    axis: &'static str,
    x: Vec<f64>,
    y: Vec<f64>,
    found: Vec<f64>,
    predicted: Vec<f64>,
}

/// Maps of one structure.
pub struct StabilityMap {
    structure: String,
    panels: Vec<MapPanel>,
}

impl StabilityMap {
    /// Maps of `structure` from the points of the sweep "map"; a panel needs its complete grid.
    pub fn new(points: &[StabilityPoint], structure: &str) -> Self {
        let mine: Vec<&StabilityPoint> = points
            .iter()
            .filter(|p| p.sweep == "map" && p.structure == structure && p.predicted.is_some_and(|p| p > 0.0))
            .collect();
        let mut engines: Vec<&str> = Vec::new();
        for point in &mine {
            if !engines.contains(&point.engine.as_str()) {
                engines.push(&point.engine);
            }
        }
        let mut panels = Vec::new();
        for engine in engines {
            let of: Vec<&StabilityPoint> = mine.iter().copied().filter(|p| p.engine == engine).collect();
            let damped = |p: &&&StabilityPoint| p.mass_kg == DAMPING_AT && p.damping > 0.0;
            panels.extend(MapPanel::new(engine, "damping, of critical", of.iter().filter(damped), |p| p.damping));
            let massive = |p: &&&StabilityPoint| p.damping == MASS_AT;
            panels.extend(MapPanel::new(engine, "mass of a node, g", of.iter().filter(massive), |p| 1e3 * p.mass_kg));
        }
        Self { structure: structure.to_owned(), panels }
    }

    /// Whether there is no panel.
    pub fn is_empty(&self) -> bool {
        self.panels.is_empty()
    }
}

impl Drawing for StabilityMap {
    fn size(&self) -> (u32, u32) {
        let rows = self.panels.len().div_ceil(2) as f64;
        ((2.0 * PANEL.0) as u32, (PANEL.1 * rows + LEGEND) as u32)
    }

    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<B>) -> DrawResult<B> {
        canvas.area.fill(&WHITE)?;
        for (k, panel) in self.panels.iter().enumerate() {
            panel.draw(canvas, (PANEL.0 * (k % 2) as f64, PANEL.1 * (k / 2) as f64))?;
        }
        let top = PANEL.1 * self.panels.len().div_ceil(2) as f64;
        legend(canvas, top, &self.structure)?;
        canvas.area.present()
    }
}

impl MapPanel {
    /// A panel from points; none for an incomplete grid or one below two by two.
    fn new<'a>(
        engine: &str,
        axis: &'static str,
        points: impl Iterator<Item = &'a &'a StabilityPoint>,
        value: impl Fn(&StabilityPoint) -> f64,
    ) -> Option<Self> {
        let points: Vec<&StabilityPoint> = points.copied().collect();
        let ticks = |of: &dyn Fn(&StabilityPoint) -> f64| {
            let mut all: Vec<f64> = points.iter().map(|p| of(p)).collect();
            all.sort_by(f64::total_cmp);
            all.dedup();
            all
        };
        let (x, y) = (ticks(&|p| p.stiffness_n_m), ticks(&value));
        if x.len() < 2 || y.len() < 2 {
            return None;
        }
        let (mut found, mut predicted) = (Vec::new(), Vec::new());
        for v in &y {
            for k in &x {
                let point = points.iter().find(|p| p.stiffness_n_m == *k && value(p) == *v)?;
                found.push(point.found?.log10());
                predicted.push(point.predicted?.log10());
            }
        }
        Some(Self { title: engine.to_owned(), axis, x, y, found, predicted })
    }

    /// Position of a point of the grid, in columns and rows from 0 to one less than their number.
    fn at(&self, (x, y): (f64, f64), column: f64, row: f64) -> (f64, f64) {
        let (width, height) = (PANEL.0 - LEFT - 16.0, PANEL.1 - 30.0 - 46.0);
        let (columns, rows) = ((self.x.len() - 1) as f64, (self.y.len() - 1) as f64);
        (x + LEFT + width * column / columns, y + 30.0 + height * (1.0 - row / rows))
    }

    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<B>, origin: (f64, f64)) -> DrawResult<B> {
        self.colours(canvas, origin)?;
        self.lines(canvas, origin)?;
        for (i, value) in self.x.iter().enumerate() {
            let (x, y) = self.at(origin, i as f64, 0.0);
            canvas.text(&value.to_string(), (x, y + 11.0), TEXT, TextAnchor::Centre, INK)?;
        }
        for (j, value) in self.y.iter().enumerate() {
            let (x, y) = self.at(origin, 0.0, j as f64);
            canvas.text(&short(*value), (x - 6.0, y), TEXT, TextAnchor::Right, INK)?;
        }
        let (x, y) = self.at(origin, 0.5 * (self.x.len() - 1) as f64, 0.0);
        canvas.text("stiffness, N/m", (x, y + 29.0), TEXT, TextAnchor::Centre, INK)?;
        let (x, y) = self.at(origin, 0.0, 0.5 * (self.y.len() - 1) as f64);
        canvas.text(self.axis, (x - 58.0, y), TEXT, TextAnchor::Upwards, INK)?;
        let (x, y) = self.at(origin, 0.0, (self.y.len() - 1) as f64);
        canvas.text(&self.title, (x, y - 14.0), 16.0, TextAnchor::Left, INK)
    }

    /// Colour bands of the measured step; adjacent parts of one band are drawn as one.
    fn colours<B: DrawingBackend>(&self, canvas: &Canvas<B>, origin: (f64, f64)) -> DrawResult<B> {
        let (columns, rows) = (PARTS * (self.x.len() as u32 - 1), PARTS * (self.y.len() as u32 - 1));
        let place = |k: u32| f64::from(k) / f64::from(PARTS);
        for j in 0..rows {
            let mut from = 0;
            for i in 0..columns {
                let band =
                    |i: u32| band_of(self.between(&self.found, place(i) + 0.5 * place(1), place(j) + 0.5 * place(1)));
                if i + 1 < columns && band(i + 1) == band(i) {
                    continue;
                }
                let (a, b) = (self.at(origin, place(from), place(j + 1)), self.at(origin, place(i + 1), place(j)));
                canvas.fill((a, b), colour(band(i)))?;
                from = i + 1;
            }
        }
        Ok(())
    }

    /// Bilinear interpolation in a cell.
    fn between(&self, values: &[f64], column: f64, row: f64) -> f64 {
        let (i, j) = ((column as usize).min(self.x.len() - 2), (row as usize).min(self.y.len() - 2));
        let (s, t) = (column - i as f64, row - j as f64);
        let at = |i: usize, j: usize| values[j * self.x.len() + i];
        (1.0 - t) * ((1.0 - s) * at(i, j) + s * at(i + 1, j)) + t * ((1.0 - s) * at(i, j + 1) + s * at(i + 1, j + 1))
    }

    /// Contour lines of the predicted step at the boundaries of the bands.
    fn lines<B: DrawingBackend>(&self, canvas: &Canvas<B>, origin: (f64, f64)) -> DrawResult<B> {
        let (columns, rows) = (PARTS * (self.x.len() as u32 - 1), PARTS * (self.y.len() as u32 - 1));
        let place = |k: u32| f64::from(k) / f64::from(PARTS);
        let levels = ((DECADES.1 - DECADES.0) * BANDS) as u32;
        for j in 0..rows {
            for i in 0..columns {
                let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                let values = corners.map(|(i, j)| self.between(&self.predicted, place(i), place(j)));
                for level in (1..levels).map(|k| DECADES.0 + f64::from(k) / BANDS) {
                    let mut ends = Vec::with_capacity(2);
                    for side in 0..4 {
                        let (a, b) = (values[side], values[(side + 1) % 4]);
                        if (a < level) != (b < level) {
                            let s = (level - a) / (b - a);
                            let (p, q) = (corners[side], corners[(side + 1) % 4]);
                            let mix = |a: u32, b: u32| place(a) + (place(b) - place(a)) * s;
                            ends.push(self.at(origin, mix(p.0, q.0), mix(p.1, q.1)));
                        }
                    }
                    if let [a, b] = ends[..] {
                        canvas.line(&[a, b], INK, 1.2)?;
                    }
                }
            }
        }
        Ok(())
    }
}

fn band_of(log_step: f64) -> u32 {
    ((log_step.clamp(DECADES.0, DECADES.1 - 1e-9) - DECADES.0) * BANDS) as u32
}

/// Dark blue for short steps, over green, to light yellow for long steps.
fn colour(band: u32) -> RGBColor {
    const STOPS: [[f64; 3]; 5] =
        [[68.0, 30.0, 110.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 120.0]];
    let share = f64::from(band) / ((DECADES.1 - DECADES.0) * BANDS - 1.0) * (STOPS.len() - 1) as f64;
    let i = (share as usize).min(STOPS.len() - 2);
    let mix = |k: usize| (STOPS[i][k] + (STOPS[i + 1][k] - STOPS[i][k]) * (share - i as f64)).round() as u8;
    RGBColor(mix(0), mix(1), mix(2))
}

/// A number with at most six decimals and no trailing zeros.
fn short(value: f64) -> String {
    let rounded = format!("{value:.6}");
    rounded.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn legend<B: DrawingBackend>(canvas: &Canvas<B>, top: f64, structure: &str) -> DrawResult<B> {
    let bands = ((DECADES.1 - DECADES.0) * BANDS) as u32;
    let wide = 16.0;
    for band in 0..bands {
        let x = LEFT + wide * f64::from(band);
        canvas.fill(((x, top + 6.0), (x + wide, top + 22.0)), colour(band))?;
    }
    for decade in DECADES.0 as i32..=DECADES.1 as i32 {
        let x = LEFT + wide * BANDS * (f64::from(decade) - DECADES.0);
        canvas.text(&short(10f64.powi(decade)), (x, top + 32.0), TEXT, TextAnchor::Centre, INK)?;
    }
    canvas.text("longest step found, s", (LEFT, top + 50.0), TEXT, TextAnchor::Left, INK)?;
    let x = LEFT + wide * f64::from(bands) + 30.0;
    canvas.line(&[(x, top + 14.0), (x + 28.0, top + 14.0)], INK, 1.2)?;
    canvas.text("predicted by the largest frequency,", (x + 36.0, top + 14.0), TEXT, TextAnchor::Left, INK)?;
    canvas.text("at the steps where colours change", (x + 36.0, top + 32.0), TEXT, TextAnchor::Left, INK)?;
    let note = format!("{structure}; left at {} g, right at {MASS_AT} of critical", 1e3 * DAMPING_AT);
    canvas.text(&note, (x + 36.0, top + 50.0), TEXT, TextAnchor::Left, INK)
}
