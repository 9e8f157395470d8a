//! The plot of the benchmark: error against CPU time, both logarithmic, a panel a case, with the efficient front.
//!
//! Hollow is what never came to rest; numbers are the masses along the sheet. SVG for the README, and a bitmap drawn by the same code.

use std::path::Path;

use plotters::prelude::{BitMapBackend, DrawingBackend, IntoDrawingArea, RGBColor, SVGBackend, WHITE};
use sheetwork::InputError;

use super::canvas::{Anchor, Canvas, Drawn, INK, prepare_font};
use super::front::front;
use super::marker::{Entry, Look, Looks};
use super::point::Point;
use super::sweep::CASES;

/// Size of a panel with its axes, and height of the legend, units.
const PANEL: (f64, f64) = (480.0, 372.0);
const LEGEND: f64 = 112.0;
/// Pixels of the bitmap a unit.
const SCALE: u32 = 2;
/// CPU time of a second in real time, ms.
const REAL_TIME: f64 = 1000.0;
/// Errors beyond these, in percent, are drawn at the border.
const ERRORS: (f64, f64) = (1e-3, 100.0);
const RADIUS: f64 = 4.2;

const FAINT: RGBColor = RGBColor(230, 233, 237);
const LATE: RGBColor = RGBColor(248, 244, 240);
const FRONT: RGBColor = RGBColor(110, 118, 129);

/// Writes the plot as SVG.
///
/// # Errors
/// When it cannot be written.
pub fn svg(path: &Path, points: &[Point]) -> Result<(), InputError> {
    prepare_font()?;
    let mut text = String::new();
    let size = size(points);
    let canvas = Canvas { area: SVGBackend::with_string(&mut text, size).into_drawing_area(), scale: 1.0 };
    draw(&canvas, points).map_err(|e| InputError::new("", e.to_string()).in_file(path))?;
    drop(canvas);
    std::fs::write(path, text).map_err(|e| InputError::io(path, &e))
}

/// Writes the plot as a bitmap, PNG.
///
/// # Errors
/// When it cannot be written.
pub fn png(path: &Path, points: &[Point]) -> Result<(), InputError> {
    prepare_font()?;
    let (width, height) = size(points);
    let (width, height) = (SCALE * width, SCALE * height);
    let mut pixels = vec![0; (width * height * 3) as usize];
    let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
    let canvas = Canvas { area, scale: SCALE.into() };
    draw(&canvas, points).map_err(|e| InputError::new("", e.to_string()).in_file(path))?;
    drop(canvas);
    let file = std::fs::File::create(path).map_err(|e| InputError::io(path, &e))?;
    let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), width, height);
    encoder.set_color(png::ColorType::Rgb);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&pixels));
    written.map_err(|e| InputError::new("", e.to_string()).in_file(path))
}

/// The cases that have points, in their order.
fn cases(points: &[Point]) -> Vec<&'static str> {
    CASES.iter().copied().filter(|case| points.iter().any(|p| p.case == *case)).collect()
}

fn size(points: &[Point]) -> (u32, u32) {
    let rows = cases(points).len().div_ceil(2).max(1);
    ((2.0 * PANEL.0) as u32, (PANEL.1 * rows as f64 + LEGEND) as u32)
}

fn draw<B: DrawingBackend>(canvas: &Canvas<B>, points: &[Point]) -> Drawn<B> {
    canvas.area.fill(&WHITE)?;
    let looks = Looks::of(points);
    let cases = cases(points);
    for (k, case) in cases.iter().enumerate() {
        let origin = (PANEL.0 * (k % 2) as f64, PANEL.1 * (k / 2) as f64);
        let mine: Vec<&Point> = points.iter().filter(|p| p.case == *case && p.error.is_some()).collect();
        let panel = Panel::new(origin, &mine);
        panel.axes(canvas, &format!("({}) {}", char::from(b'a' + (k % 26) as u8), title(case)))?;
        panel.points(canvas, &mine, &looks)?;
    }
    legend(canvas, PANEL.1 * cases.len().div_ceil(2) as f64, &looks)?;
    canvas.area.present()
}

fn title(case: &str) -> &str {
    match case {
        "cantilever" => "Cantilever: droop of the tip, stepped to rest",
        "release" => "Release: first swing, depth and time",
        "frequency" => "Frequency: first mode of the cantilever",
        "pedestal" => "Pedestal: droop of the corners, stepped to rest",
        other => other,
    }
}

/// A pair of logarithmic axes.
struct Panel {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    /// Decades of the cost in ms and of the error in percent.
    cost: (f64, f64),
    error: (f64, f64),
}

impl Panel {
    fn new((x, y): (f64, f64), points: &[&Point]) -> Self {
        let decades = |values: &mut dyn Iterator<Item = f64>, start: (f64, f64)| {
            let span = values.fold(start, |(low, high), v| (low.min(v), high.max(v)));
            (span.0.log10().floor(), span.1.log10().ceil())
        };
        let cost = decades(&mut points.iter().map(|p| p.cpu_ms_per_simulated_s.max(1e-3)), (10.0, 2.0 * REAL_TIME));
        let error = decades(&mut points.iter().map(|p| percent(p)), (0.1, 10.0));
        Self { left: x + 62.0, right: x + PANEL.0 - 14.0, top: y + 36.0, bottom: y + PANEL.1 - 46.0, cost, error }
    }

    fn x(&self, cost: f64) -> f64 {
        let share = (cost.log10() - self.cost.0) / (self.cost.1 - self.cost.0);
        self.left + (self.right - self.left) * share.clamp(0.0, 1.0)
    }

    fn y(&self, error: f64) -> f64 {
        let share = (error.log10() - self.error.0) / (self.error.1 - self.error.0);
        self.bottom - (self.bottom - self.top) * share.clamp(0.0, 1.0)
    }

    fn at(&self, point: &Point) -> (f64, f64) {
        (self.x(point.cpu_ms_per_simulated_s), self.y(percent(point)))
    }

    fn axes<B: DrawingBackend>(&self, canvas: &Canvas<B>, title: &str) -> Drawn<B> {
        let Self { left, right, top, bottom, .. } = *self;
        let real_time = self.x(REAL_TIME);
        canvas.fill(((real_time, top), (right, bottom)), LATE)?;
        for exponent in self.cost.0 as i32..=self.cost.1 as i32 {
            let x = self.x(10f64.powi(exponent));
            canvas.line(&[(x, top), (x, bottom)], FAINT, 1.0)?;
            canvas.text(&decimal(exponent), (x, bottom + 13.0), 13.0, Anchor::Centre, INK)?;
        }
        for exponent in self.error.0 as i32..=self.error.1 as i32 {
            let y = self.y(10f64.powi(exponent));
            canvas.line(&[(left, y), (right, y)], FAINT, 1.0)?;
            canvas.text(&format!("{} %", decimal(exponent)), (left - 6.0, y), 13.0, Anchor::Right, INK)?;
        }
        canvas.dashes(((real_time, top), (real_time, bottom)), FRONT)?;
        canvas.text("real time", (real_time - 8.0, top + 36.0), 12.0, Anchor::Upwards, FRONT)?;
        canvas.line(&[(left, top), (left, bottom), (right, bottom)], INK, 1.0)?;
        canvas.text(title, (left, top - 16.0), 15.0, Anchor::Left, INK)?;
        let middle = 0.5 * (left + right);
        canvas.text(
            "CPU time of one core for a simulated second, ms",
            (middle, bottom + 33.0),
            13.0,
            Anchor::Centre,
            INK,
        )?;
        canvas.text("error", (left - 52.0, 0.5 * (top + bottom)), 13.0, Anchor::Upwards, INK)
    }

    fn points<B: DrawingBackend>(&self, canvas: &Canvas<B>, points: &[&Point], looks: &Looks) -> Drawn<B> {
        let best = front(points);
        // A staircase: to be more exact one pays for the next step of it.
        let mut stairs: Vec<(f64, f64)> = Vec::new();
        for (x, y) in best.iter().map(|&i| self.at(points[i])) {
            if let Some(&(_, before)) = stairs.last() {
                stairs.push((x, before));
            }
            stairs.push((x, y));
        }
        canvas.line(&stairs, FRONT, 1.6)?;
        // Peers last, so that they are never hidden; the front above the rest of ours.
        let rank = |i: usize| if points[i].peer { 2 } else { u8::from(best.contains(&i)) };
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by_key(|&i| rank(i));
        for &i in &order {
            let (look, hollow) = (looks.look(points[i]), points[i].settled == Some(false));
            marker(canvas, self.at(points[i]), look, hollow, rank(i) == 0)?;
        }
        for &i in order.iter().filter(|&&i| rank(i) > 0) {
            let (x, y) = self.at(points[i]);
            let colour = looks.look(points[i]).colour;
            // Ours below and left of the staircase, peers above.
            let (at, anchor) =
                if points[i].peer { ((x + 7.0, y - 8.0), Anchor::Left) } else { ((x - 6.0, y + 9.0), Anchor::Right) };
            canvas.text(points[i].side(), at, 11.0, anchor, colour)?;
        }
        Ok(())
    }
}

/// The error in percent, within what is drawn.
fn percent(point: &Point) -> f64 {
    (100.0 * point.error.unwrap_or(f64::INFINITY)).clamp(ERRORS.0, ERRORS.1)
}

/// A power of ten in full.
fn decimal(exponent: i32) -> String {
    let places = (-exponent).max(0) as usize;
    format!("{:.places$}", 10f64.powi(exponent))
}

/// Mixes a colour with white.
fn pale(RGBColor(r, g, b): RGBColor) -> RGBColor {
    let mix = |c: u8| (u16::from(c) * 2 / 5 + 153).min(255) as u8;
    RGBColor(mix(r), mix(g), mix(b))
}

fn marker<B: DrawingBackend>(
    canvas: &Canvas<B>,
    (x, y): (f64, f64),
    Look { colour, shape }: Look,
    hollow: bool,
    behind: bool,
) -> Drawn<B> {
    let corners: Vec<_> = shape.outline(RADIUS).into_iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
    let colour = if behind { pale(colour) } else { colour };
    let (inside, rim) = if hollow { (WHITE, colour) } else { (colour, WHITE) };
    canvas.outline(&corners, inside, rim, if hollow { 1.3 } else { 0.6 })
}

fn legend<B: DrawingBackend>(canvas: &Canvas<B>, top: f64, looks: &Looks) -> Drawn<B> {
    let rows: [(&str, &[Entry]); 3] =
        [("structure", &looks.structures), ("engine", &looks.engines), ("peers", &looks.peers)];
    let mut y = top + 14.0;
    for (name, entries) in rows {
        if entries.is_empty() {
            continue;
        }
        canvas.text(name, (62.0, y), 13.0, Anchor::Left, FRONT)?;
        let mut x = 142.0;
        for entry in entries {
            marker(canvas, (x, y), entry.look, false, false)?;
            canvas.text(&entry.name, (x + 10.0, y), 13.0, Anchor::Left, INK)?;
            x += canvas.width(&entry.name, 13.0) + 40.0;
        }
        y += 22.0;
    }
    canvas.text("efficient front", (62.0, y), 13.0, Anchor::Left, FRONT)?;
    canvas.line(&[(142.0 + 20.0, y + 4.0), (172.0 + 20.0, y + 4.0), (172.0 + 20.0, y - 4.0)], FRONT, 1.6)?;
    let note = "pale: beaten in both; hollow: never came to rest; numbers: masses along the sheet";
    canvas.text(note, (210.0, y), 13.0, Anchor::Left, INK)
}

#[cfg(test)]
mod tests {
    use super::super::front::tests::point;
    use super::*;

    #[test]
    fn every_marker_and_case_is_drawn() {
        let points: Vec<Point> = (0..8)
            .map(|k| {
                let mut point = point(10f64.powi(k - 2), 10f64.powi(-k));
                point.case = CASES[k as usize % CASES.len()].into();
                point.peer = k % 3 == 0;
                point
            })
            .collect();
        let path = std::env::temp_dir().join(format!("sheetwork-plot-{}.svg", std::process::id()));
        svg(&path, &points).expect("it is drawn");
        let text = std::fs::read_to_string(&path);
        std::fs::remove_file(&path).expect("it is removed");
        let text = text.expect("it is there");
        assert!(text.contains("(d) Pedestal"), "{text}");
        assert!(text.matches("<polygon").count() >= points.len());
    }
}
