//! SVG paths as curves (kurbo), by the SVG 1.1 grammar (svgtypes): all commands, M L H V C S Q T A
//! Z, absolute and relative.

use kurbo::{Arc, BezPath, Point, SvgArc, Vec2};
use svgtypes::{PathParser, PathSegment};

/// Error of the cubics that approximate an arc, as a fraction of its radius.
const ARC_ERROR: f64 = 1e-8;

/// Curves of a path's text, in its own units.
///
/// # Errors
/// The fault of the text.
pub fn path(text: &str) -> Result<BezPath, String> {
    let mut pen = SvgPen::default();
    for segment in PathParser::from(text) {
        pen.draw(&segment.map_err(|e| format!("is not an SVG path: {e}"))?);
    }
    if pen.path.elements().is_empty() {
        return Err("is an SVG path without anything in it".into());
    }
    if !pen.path.is_finite() {
        return Err("has a coordinate that is not finite".into());
    }
    Ok(pen.path)
}

/// State of the pen.
#[derive(Default)]
struct SvgPen {
    path: BezPath,
    at: Point,
    start: Point,
    /// Last control point of a cubic, of a quadratic, for reflection by S and T.
    cubic: Option<Point>,
    quadratic: Option<Point>,
    closed: bool,
}

impl SvgPen {
    fn place(&self, abs: bool, x: f64, y: f64) -> Point {
        if abs { Point::new(x, y) } else { self.at + Vec2::new(x, y) }
    }

    fn reflected(&self, control: Option<Point>) -> Point {
        control.map_or(self.at, |c| self.at + (self.at - c))
    }

    fn draw(&mut self, segment: &PathSegment) {
        // After Z the next command starts a new subpath at the start of the closed one.
        if self.closed && !matches!(segment, PathSegment::MoveTo { .. } | PathSegment::ClosePath { .. }) {
            self.path.move_to(self.at);
            self.closed = false;
        }
        let (mut cubic, mut quadratic) = (None, None);
        let from = self.at;
        match *segment {
            PathSegment::MoveTo { abs, x, y } => {
                self.at = self.place(abs, x, y);
                self.start = self.at;
                self.closed = false;
                self.path.move_to(self.at);
            }
            PathSegment::LineTo { abs, x, y } => self.line(self.place(abs, x, y)),
            PathSegment::HorizontalLineTo { abs, x } => {
                self.line(Point::new(if abs { x } else { from.x + x }, from.y));
            }
            PathSegment::VerticalLineTo { abs, y } => self.line(Point::new(from.x, if abs { y } else { from.y + y })),
            PathSegment::CurveTo { abs, x1, y1, x2, y2, x, y } => {
                cubic = Some(self.place(abs, x2, y2));
                self.cubic(self.place(abs, x1, y1), self.place(abs, x2, y2), self.place(abs, x, y));
            }
            PathSegment::SmoothCurveTo { abs, x2, y2, x, y } => {
                cubic = Some(self.place(abs, x2, y2));
                self.cubic(self.reflected(self.cubic), self.place(abs, x2, y2), self.place(abs, x, y));
            }
            PathSegment::Quadratic { abs, x1, y1, x, y } => {
                quadratic = Some(self.place(abs, x1, y1));
                self.quadratic(self.place(abs, x1, y1), self.place(abs, x, y));
            }
            PathSegment::SmoothQuadratic { abs, x, y } => {
                let control = self.reflected(self.quadratic);
                quadratic = Some(control);
                self.quadratic(control, self.place(abs, x, y));
            }
            PathSegment::EllipticalArc { abs, rx, ry, x_axis_rotation, large_arc, sweep, x, y } => {
                let (radii, x_rotation) = (Vec2::new(rx, ry), x_axis_rotation.to_radians());
                self.arc(&SvgArc { from, to: self.place(abs, x, y), radii, x_rotation, large_arc, sweep });
            }
            PathSegment::ClosePath { .. } => {
                if !self.closed {
                    self.path.close_path();
                }
                self.at = self.start;
                self.closed = true;
            }
        }
        (self.cubic, self.quadratic) = (cubic, quadratic);
    }

    fn line(&mut self, to: Point) {
        self.path.line_to(to);
        self.at = to;
    }

    fn cubic(&mut self, p1: Point, p2: Point, to: Point) {
        self.path.curve_to(p1, p2, to);
        self.at = to;
    }

    fn quadratic(&mut self, p1: Point, to: Point) {
        self.path.quad_to(p1, to);
        self.at = to;
    }

    fn arc(&mut self, arc: &SvgArc) {
        match Arc::from_svg_arc(arc) {
            Some(curve) => {
                let tolerance = ARC_ERROR * curve.radii.x.max(curve.radii.y);
                let path = &mut self.path;
                curve.to_cubic_beziers(tolerance, |p1, p2, p3| path.curve_to(p1, p2, p3));
            }
            None => self.path.line_to(arc.to),
        }
        self.at = arc.to;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kurbo::Shape;

    fn area(text: &str) -> f64 {
        path(text).expect("a path").area().abs()
    }

    #[test]
    fn every_command_draws_what_the_standard_says() {
        for text in [
            "M 0 0 L 2 0 L 2 1 L 0 1 Z",
            "m 0 0 l 2 0 l 0 1 l -2 0 z",
            "M0,0H2V1H0Z",
            "m0 0h2v1h-2z",
            "M 0 0 2 0 2 1 0 1z",
            "M0 0 C 1 0 2 0 2 0 S 2 1 2 1 Q 1 1 0 1 Z",
        ] {
            assert!((area(text) - 2.0).abs() < 1e-12, "{text}: {}", area(text));
        }
        let disc = std::f64::consts::PI;
        assert!((area("M 1 0 A 1 1 0 0 1 -1 0 A 1 1 0 0 1 1 0 Z") - disc).abs() < 1e-7);
        assert!((area("M1,0a1 1 0 01-2 0a1 1 0 012 0z") - disc).abs() < 1e-7);
        // Reflected control points: half a wave up, half a wave down.
        for text in ["M0 0Q1 1 2 0T4 0", "M0 0c.5 .66666666666667 1.5 .66666666666667 2 0s1.5-.66666666666667 2 0"] {
            let bounds = path(text).expect("a path").bounding_box();
            assert!((bounds.max_y() - 0.5).abs() < 1e-12 && (bounds.min_y() + 0.5).abs() < 1e-12, "{text}: {bounds:?}");
            assert!((bounds.width() - 4.0).abs() < 1e-12);
        }
    }

    #[test]
    fn invalid_paths_are_rejected() {
        for text in ["", "L 1 1", "M 0 0 L 1 x", "M 0 0 X 3"] {
            assert!(path(text).is_err(), "{text}");
        }
    }
}
