//! Chart of a run: lines over time, with ticks, names and a readout under the mouse.

use std::sync::Arc;

use bevy_egui::egui::{
    Align2, Color32, FontId, Galley, Painter, Rect, Response, RichText, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2,
};

use super::timeline::nice;
use crate::samples::Sample;
use crate::units::format_si;

/// Maximum number of points of a line.
const MAX_POINTS: usize = 300;

/// Line of a chart: name, colour, value of a sample.
pub(super) struct Line<'a> {
    name: String,
    colour: Color32,
    /// Samples of another run than the chart's own.
    history: Option<&'a [Sample]>,
    value: Box<dyn Fn(&Sample) -> Option<f64> + 'a>,
}

impl<'a> Line<'a> {
    /// Line of the chart's own run.
    pub fn new(name: impl Into<String>, colour: Color32, value: impl Fn(&Sample) -> Option<f64> + 'a) -> Self {
        Self { name: name.into(), colour, history: None, value: Box::new(value) }
    }

    /// The line with the samples of another run.
    pub fn with_history(self, history: &'a [Sample]) -> Self {
        Self { history: Some(history), ..self }
    }

    /// Points of the line: time, s, and value.
    fn points(&self, history: &[Sample]) -> Vec<(f64, f64)> {
        let all = self.history.unwrap_or(history);
        let some = all.iter().step_by(all.len() / MAX_POINTS + 1).chain(all.last());
        some.filter_map(|s| Some((s.time, (self.value)(s).filter(|v| v.is_finite())?))).collect()
    }
}

/// Value with its unit; temperatures and percentages have no prefix.
fn written(value: f64, unit: &str) -> String {
    if unit == "°C" || unit == "%" { format!("{value:.1} {unit}") } else { format_si(value, unit) }
}

/// Transformation from time and value to window coordinates.
struct Frame {
    inner: Rect,
    times: (f64, f64),
    values: (f64, f64),
}

impl Frame {
    fn x(&self, time: f64) -> f32 {
        self.inner.left() + self.inner.width() * ((time - self.times.0) / (self.times.1 - self.times.0)) as f32
    }

    fn y(&self, value: f64) -> f32 {
        let part = (value - self.values.0) / (self.values.1 - self.values.0);
        self.inner.bottom() - self.inner.height() * part as f32
    }

    /// Ticks of the values and the two ends of time.
    fn marks(&self, painter: &Painter, unit: &str, colour: Color32) {
        let (inner, step) = (self.inner, nice((self.values.1 - self.values.0) / 3.0));
        let small = FontId::proportional(9.5);
        let mut mark = (self.values.0 / step).ceil() * step;
        while mark <= self.values.1 {
            let y = self.y(mark);
            let stroke = Stroke::new(0.5, colour.gamma_multiply(0.4));
            painter.line_segment([pos2(inner.left(), y), pos2(inner.right(), y)], stroke);
            // Rounding errors about zero are shown as zero.
            let text = written(if mark.abs() < 1e-9 * step { 0.0 } else { mark }, unit);
            painter.text(pos2(inner.left() - 4.0, y), Align2::RIGHT_CENTER, text, small.clone(), colour);
            mark += step;
        }
        for (time, align) in [(self.times.0, Align2::LEFT_TOP), (self.times.1, Align2::RIGHT_TOP)] {
            let at = pos2(self.x(time), inner.bottom() + 2.0);
            painter.text(at, align, format!("{time:.2} s"), small.clone(), colour);
        }
    }
}

/// Draw a chart of `size`: title and unit, samples, lines.
pub(super) fn chart(ui: &mut Ui, size: Vec2, (title, unit): (&str, &str), history: &[Sample], lines: &[Line<'_>]) {
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let top = names(ui, &painter, rect, title, lines);
    let (Some(first), Some(last)) = (history.first(), history.last()) else { return };
    let drawn: Vec<Vec<(f64, f64)>> = lines.iter().map(|line| line.points(history)).collect();
    let widen = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
    let (low, high) = drawn.iter().flatten().map(|p| p.1).fold((f64::INFINITY, f64::NEG_INFINITY), widen);
    if low > high {
        return;
    }
    let pad = (0.05 * (high - low)).max(1e-12 + 1e-3 * high.abs());
    let inner = Rect::from_min_max(rect.min + vec2(58.0, top), rect.max - vec2(8.0, 16.0));
    let times = (first.time, last.time.max(first.time + 1e-9));
    let frame = Frame { inner, times, values: (low - pad, high + pad) };
    frame.marks(&painter, unit, ui.visuals().weak_text_color());
    for (line, points) in lines.iter().zip(&drawn).rev() {
        let points = points.iter().map(|(t, v)| pos2(frame.x(*t), frame.y(*v))).collect();
        painter.add(Shape::line(points, Stroke::new(1.4, line.colour)));
    }
    readout(&painter, response, &frame, unit, history, lines);
}

/// Draw the title and, beside it or in rows below, the names of the lines.
/// Returns the offset of the chart.
fn names(ui: &Ui, painter: &Painter, rect: Rect, title: &str, lines: &[Line<'_>]) -> f32 {
    let title = painter.text(
        rect.left_top() + vec2(6.0, 3.0),
        Align2::LEFT_TOP,
        title,
        FontId::proportional(12.0),
        ui.visuals().text_color(),
    );
    let name = |line: &Line| painter.layout_no_wrap(line.name.clone(), FontId::proportional(10.0), line.colour);
    let mut all: Vec<_> = lines.iter().map(name).collect();
    let taken = |name: &Arc<Galley>| name.size().x + 7.0;
    let below = all.iter().map(taken).sum::<f32>() + title.width() + 14.0 > rect.width();
    let mut top = if below { 18.0 } else { 4.0 };
    while !all.is_empty() {
        let mut room = rect.width() - 12.0;
        let fits = |name: &&Arc<Galley>| {
            room -= taken(name);
            room > -7.0
        };
        let count = all.iter().take_while(fits).count().max(1);
        let mut at = rect.right_top() + vec2(-6.0, top);
        for name in all.drain(..count).rev() {
            at.x -= name.size().x;
            painter.galley(at, name, Color32::WHITE);
            at.x -= 7.0;
        }
        top += 13.0;
    }
    if below { top + 3.0 } else { 20.0 }
}

/// Values under the mouse.
fn readout(painter: &Painter, response: Response, frame: &Frame, unit: &str, history: &[Sample], lines: &[Line<'_>]) {
    let inner = frame.inner;
    let Some(pointer) = response.hover_pos().filter(|p| inner.contains(*p)) else { return };
    let part = f64::from((pointer.x - inner.left()) / inner.width());
    let time = frame.times.0 + (frame.times.1 - frame.times.0) * part;
    let hair = [pos2(pointer.x, inner.top()), pos2(pointer.x, inner.bottom())];
    painter.line_segment(hair, Stroke::new(0.8, Color32::GRAY));
    let at = |all: &[Sample]| all.partition_point(|s| s.time < time).min(all.len().saturating_sub(1));
    response.on_hover_ui(|ui| {
        ui.label(RichText::new(format!("{time:.4} s")).strong());
        for line in lines {
            let all = line.history.unwrap_or(history);
            if let Some(value) = all.get(at(all)).and_then(|s| (line.value)(s)) {
                ui.label(RichText::new(format!("{}  {}", line.name, written(value, unit))).color(line.colour));
            }
        }
    });
}
