//! Plot of the benchmark: error against CPU time on logarithmic axes, one panel per rig, with the
//! Pareto front.
//!
//! Hollow markers are runs that did not come to rest. Numbers are the nodes along the sheet. One
//! drawing is written as SVG for the README and as a bitmap.

use plotters::prelude::{DrawingBackend, RGBColor, WHITE};

use crate::bench::canvas::{Canvas, DrawResult, Drawing, INK, TextAnchor};
use crate::bench::front::front;
use crate::bench::marker::{MarkerStyle, MarkerStyles};
use crate::bench::point::ParetoPoint;
use crate::bench::sweep::CASES;

/// Size of a panel with its axes, and height of the legend, units.
const PANEL: (f64, f64) = (480.0, 380.0);
const LEGEND: f64 = 172.0;
/// Left border of the axes and the legend, and line spacing of the legend, units.
const LEFT: f64 = 70.0;
const LINE: f64 = 23.0;
/// Sizes of titles, texts and numbers beside markers, units.
const TITLE: f64 = 18.0;
const TEXT: f64 = 15.5;
const SMALL: f64 = 13.0;
/// CPU time (ms) per simulated second of a real-time simulation.
const REAL_TIME: f64 = 1000.0;
/// Range of drawn errors, percent; errors outside are drawn at the border.
const ERRORS: (f64, f64) = (1e-3, 100.0);
const RADIUS: f64 = 4.2;

const FAINT: RGBColor = RGBColor(230, 233, 237);
const LATE: RGBColor = RGBColor(248, 244, 240);
const FRONT: RGBColor = RGBColor(110, 118, 129);

/// Points to draw.
pub struct Plot<'a>(pub &'a [ParetoPoint]);

impl Drawing for Plot<'_> {
    fn size(&self) -> (u32, u32) {
        let rows = cases(self.0).len().div_ceil(2).max(1);
        ((2.0 * PANEL.0) as u32, (PANEL.1 * rows as f64 + LEGEND) as u32)
    }

    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<B>) -> DrawResult<B> {
        let points = self.0;
        canvas.area.fill(&WHITE)?;
        let looks = MarkerStyles::new(points);
        let cases = cases(points);
        for (k, case) in cases.iter().enumerate() {
            let origin = (PANEL.0 * (k % 2) as f64, PANEL.1 * (k / 2) as f64);
            let mine: Vec<&ParetoPoint> = points.iter().filter(|p| p.case == *case && p.error.is_some()).collect();
            let panel = Panel::new(origin, &mine);
            panel.axes(canvas, &format!("({}) {}", char::from(b'a' + (k % 26) as u8), title(case)))?;
            panel.points(canvas, &mine, &looks)?;
        }
        legend(canvas, PANEL.1 * cases.len().div_ceil(2) as f64, &looks)?;
        canvas.area.present()
    }
}

/// Rigs with points, in their order.
fn cases(points: &[ParetoPoint]) -> Vec<&'static str> {
    CASES.iter().copied().filter(|case| points.iter().any(|p| p.case == *case)).collect()
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
    /// Decades of the cost (ms) and of the error (percent).
    cost: (f64, f64),
    error: (f64, f64),
}

impl Panel {
    fn new((x, y): (f64, f64), points: &[&ParetoPoint]) -> Self {
        let decades = |values: &mut dyn Iterator<Item = f64>, start: (f64, f64)| {
            let span = values.fold(start, |(low, high), v| (low.min(v), high.max(v)));
            // Room for the numbers under the lowest marker.
            ((span.0.log10() - 0.12).floor(), span.1.log10().ceil())
        };
        let cost = decades(&mut points.iter().map(|p| p.cpu_ms_per_simulated_s.max(1e-3)), (10.0, 2.0 * REAL_TIME));
        let error = decades(&mut points.iter().map(|p| percent(p)), (0.1, 10.0));
        Self { left: x + LEFT, right: x + PANEL.0 - 26.0, top: y + 36.0, bottom: y + PANEL.1 - 52.0, cost, error }
    }

    fn x(&self, cost: f64) -> f64 {
        let share = (cost.log10() - self.cost.0) / (self.cost.1 - self.cost.0);
        self.left + (self.right - self.left) * share.clamp(0.0, 1.0)
    }

    fn y(&self, error: f64) -> f64 {
        let share = (error.log10() - self.error.0) / (self.error.1 - self.error.0);
        self.bottom - (self.bottom - self.top) * share.clamp(0.0, 1.0)
    }

    fn at(&self, point: &ParetoPoint) -> (f64, f64) {
        (self.x(point.cpu_ms_per_simulated_s), self.y(percent(point)))
    }

    fn axes<B: DrawingBackend>(&self, canvas: &Canvas<B>, title: &str) -> DrawResult<B> {
        let Self { left, right, top, bottom, .. } = *self;
        let real_time = self.x(REAL_TIME);
        canvas.fill(((real_time, top), (right, bottom)), LATE)?;
        for exponent in self.cost.0 as i32..=self.cost.1 as i32 {
            let x = self.x(10f64.powi(exponent));
            canvas.line(&[(x, top), (x, bottom)], FAINT, 1.0)?;
            canvas.text(&decimal(exponent), (x, bottom + 14.0), TEXT, TextAnchor::Centre, INK)?;
        }
        for exponent in self.error.0 as i32..=self.error.1 as i32 {
            let y = self.y(10f64.powi(exponent));
            canvas.line(&[(left, y), (right, y)], FAINT, 1.0)?;
            canvas.text(&format!("{} %", decimal(exponent)), (left - 6.0, y), TEXT, TextAnchor::Right, INK)?;
        }
        canvas.dashes(((real_time, top), (real_time, bottom)), FRONT)?;
        canvas.text("real time", (real_time + 9.0, top + 40.0), TEXT, TextAnchor::Upwards, FRONT)?;
        canvas.line(&[(left, top), (left, bottom), (right, bottom)], INK, 1.0)?;
        canvas.text(title, (left, top - 16.0), TITLE, TextAnchor::Left, INK)?;
        let middle = 0.5 * (left + right);
        canvas.text(
            "CPU time of one core for a simulated second, ms",
            (middle, bottom + 36.0),
            TEXT,
            TextAnchor::Centre,
            INK,
        )?;
        canvas.text("error", (left - 60.0, 0.5 * (top + bottom)), TEXT, TextAnchor::Upwards, INK)
    }

    fn points<B: DrawingBackend>(
        &self,
        canvas: &Canvas<B>,
        points: &[&ParetoPoint],
        looks: &MarkerStyles,
    ) -> DrawResult<B> {
        let best = front(points);
        // The front is a staircase: a smaller error costs the next step of it.
        let mut stairs: Vec<(f64, f64)> = Vec::new();
        for (x, y) in best.iter().map(|&i| self.at(points[i])) {
            if let Some(&(_, before)) = stairs.last() {
                stairs.push((x, before));
            }
            stairs.push((x, y));
        }
        canvas.line(&stairs, FRONT, 1.6)?;
        // Peers are drawn last, on top; the front is above the remaining points.
        let rank = |i: usize| if points[i].peer { 2 } else { u8::from(best.contains(&i)) };
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by_key(|&i| rank(i));
        for &i in &order {
            let look = looks.look(points[i]);
            let colour = if rank(i) == 0 { pale(look.colour) } else { look.colour };
            marker(canvas, self.at(points[i]), MarkerStyle { colour, ..look }, points[i].settled == Some(false))?;
        }
        for &i in order.iter().filter(|&&i| rank(i) > 0) {
            let (x, y) = self.at(points[i]);
            let colour = looks.look(points[i]).colour;
            // Labels of own points are below and left of the staircase, labels of peers above.
            let (at, anchor) = if points[i].peer {
                ((x + 7.0, y - 8.0), TextAnchor::Left)
            } else {
                ((x - 6.0, y + 9.0), TextAnchor::Right)
            };
            canvas.text(points[i].side(), at, SMALL, anchor, colour)?;
        }
        Ok(())
    }
}

/// Error in percent, limited to the drawn range.
fn percent(point: &ParetoPoint) -> f64 {
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

/// A marker with a white rim, or a hollow one with a rim of its colour.
fn marker<B: DrawingBackend>(canvas: &Canvas<B>, (x, y): (f64, f64), look: MarkerStyle, hollow: bool) -> DrawResult<B> {
    let outline = |share: f64| -> Vec<_> {
        look.shape.outline(share * RADIUS).into_iter().map(|(dx, dy)| (x + dx, y + dy)).collect()
    };
    let (rim, inside) = if hollow { (look.colour, WHITE) } else { (WHITE, look.colour) };
    let (outer, inner) = if hollow { (1.1, 0.65) } else { (1.25, 1.0) };
    canvas.polygon(&outline(outer), rim)?;
    canvas.polygon(&outline(inner), inside)
}

fn legend<B: DrawingBackend>(canvas: &Canvas<B>, top: f64, looks: &MarkerStyles) -> DrawResult<B> {
    let mut y = top + 12.0;
    for (name, entries) in looks.rows() {
        canvas.text(name, (LEFT, y), TEXT, TextAnchor::Left, FRONT)?;
        let mut x = LEFT + 96.0;
        for entry in entries {
            let wide = canvas.width(&entry.name, TEXT) + 36.0;
            if x + wide > 2.0 * PANEL.0 {
                (x, y) = (LEFT + 96.0, y + LINE);
            }
            marker(canvas, (x, y + 1.0), entry.look, false)?;
            canvas.text(&entry.name, (x + 12.0, y), TEXT, TextAnchor::Left, INK)?;
            x += wide;
        }
        y += LINE;
    }
    canvas.text("line", (LEFT, y), TEXT, TextAnchor::Left, FRONT)?;
    let (x, step) = (LEFT + 92.0, 5.0);
    canvas.line(&[(x, y - step), (x + 12.0, y - step), (x + 12.0, y + step), (x + 24.0, y + step)], FRONT, 1.6)?;
    let note = "efficient front: nothing is both cheaper and more exact; the rest of ours is pale";
    canvas.text(note, (x + 34.0, y), TEXT, TextAnchor::Left, INK)?;
    let note = "hollow: never came to rest; numbers: masses along the sheet";
    canvas.text(note, (x + 34.0, y + LINE), TEXT, TextAnchor::Left, INK)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::canvas::svg;
    use crate::bench::front::tests::point;

    #[test]
    fn every_marker_and_case_is_drawn() {
        let points: Vec<ParetoPoint> = (0..8)
            .map(|k| {
                let mut point = point(10f64.powi(k - 2), 10f64.powi(-k));
                point.case = CASES[k as usize % CASES.len()].into();
                point.peer = k % 3 == 0;
                point
            })
            .collect();
        let path = std::env::temp_dir().join(format!("sheetwork-plot-{}.svg", std::process::id()));
        svg(&path, &Plot(&points)).expect("it is drawn");
        let text = std::fs::read_to_string(&path);
        std::fs::remove_file(&path).expect("it is removed");
        let text = text.expect("it is there");
        assert!(text.contains("(d) Pedestal"), "{text}");
        assert!(text.matches("<polygon").count() >= points.len());
    }
}
