//! SVG paths and files as curves (kurbo), by the SVG 1.1 grammar of paths and transforms (svgtypes)
//! and XML (roxmltree).
//!
//! All commands of paths are read: M L H V C S Q T A Z, absolute and relative. A file contributes
//! its `path` elements with their own and their groups' transforms; definitions (`defs`,
//! `clipPath`, `mask`, `marker`, `pattern`, `symbol`) are skipped.

use kurbo::{Affine, Arc, BezPath, Point, SvgArc, Vec2};
use svgtypes::{Length, LengthUnit, PathParser, PathSegment, Transform, ViewBox};

/// Error of the cubics that approximate an arc, as a fraction of its radius.
const ARC_ERROR: f64 = 1e-8;

/// CSS pixel, 1/96 inch, m.
const PIXEL: f64 = 0.0254 / 96.0;

/// Maximum nesting of the elements of a file.
const MAX_DEPTH: usize = 256;

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

/// All paths of an SVG file's text as one, in metres, the middle of their box at the origin.
///
/// # Errors
/// The fault of the text.
pub fn drawing(text: &str, scale: Option<f64>) -> Result<BezPath, String> {
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let document =
        roxmltree::Document::parse_with_options(text, options).map_err(|e| format!("is not an SVG file: {e}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        return Err(format!("is not an SVG file: its root is <{}>", root.tag_name().name()));
    }
    let mut all = BezPath::new();
    collect(root, Affine::IDENTITY, 0, &mut all)?;
    if all.elements().is_empty() {
        return Err("has no path element".into());
    }
    let metres = scale.unwrap_or_else(|| unit(root));
    let middle = kurbo::Shape::bounding_box(&all).center();
    Ok(Affine::scale(metres) * Affine::translate(-middle.to_vec2()) * all)
}

fn collect(node: roxmltree::Node, outer: Affine, depth: usize, all: &mut BezPath) -> Result<(), String> {
    if depth > MAX_DEPTH {
        return Err(format!("nests elements more than {MAX_DEPTH} deep"));
    }
    let only_defined = ["defs", "clipPath", "mask", "marker", "pattern", "symbol"];
    if !node.is_element() || only_defined.contains(&node.tag_name().name()) {
        return Ok(());
    }
    let mut place = outer;
    if let Some(text) = node.attribute("transform") {
        let t: Transform = text.parse().map_err(|e| format!("has a transform that cannot be read: {e}"))?;
        place *= Affine::new([t.a, t.b, t.c, t.d, t.e, t.f]);
    }
    if let Some(text) = node.attribute("d").filter(|_| node.tag_name().name() == "path") {
        all.extend((place * path(text)?).iter());
    }
    node.children().try_for_each(|child| collect(child, place, depth + 1, all))
}

/// Metres per unit of the drawing: `width` over the width of the `viewBox`, where both exist.
fn unit(root: roxmltree::Node) -> f64 {
    let width = root.attribute("width").and_then(|w| w.parse::<Length>().ok());
    let view = root.attribute("viewBox").and_then(|v| v.parse::<ViewBox>().ok());
    let (Some(width), Some(view)) = (width, view) else { return PIXEL };
    let metres = match width.unit {
        LengthUnit::None | LengthUnit::Px => PIXEL,
        LengthUnit::In => 0.0254,
        LengthUnit::Cm => 0.01,
        LengthUnit::Mm => 0.001,
        LengthUnit::Pt => 0.0254 / 72.0,
        LengthUnit::Pc => 0.0254 / 6.0,
        LengthUnit::Em | LengthUnit::Ex | LengthUnit::Percent => return PIXEL,
    };
    let scale = width.number * metres / view.w;
    if scale.is_finite() && scale > 0.0 { scale } else { PIXEL }
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
    fn files_have_units_groups_and_transforms() {
        let text = r#"<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="50mm" viewBox="0 0 200 100">
            <defs><path d="M0 0h500v500h-500z"/></defs>
            <g transform="translate(10 5) scale(2)"><path transform="rotate(90)" d="M0 0h20v40h-20z"/></g></svg>"#;
        let shape = drawing(text, None).expect("a drawing");
        let bounds = shape.bounding_box();
        // 40 units along the width, 80 along the length, at half a millimetre each.
        assert!((bounds.width() - 0.04).abs() < 1e-12 && (bounds.height() - 0.02).abs() < 1e-12, "{bounds:?}");
        assert!(bounds.center().to_vec2().hypot() < 1e-12);
        let scaled = drawing(text, Some(0.001)).expect("a drawing").bounding_box();
        assert!((scaled.width() - 0.08).abs() < 1e-12);
    }

    #[test]
    fn invalid_paths_are_rejected() {
        for text in ["", "L 1 1", "M 0 0 L 1 x", "M 0 0 X 3"] {
            assert!(path(text).is_err(), "{text}");
        }
        for text in ["<svg/>", "<html/>", "hello", "<svg><path d='M 0 0 L 1'/></svg>"] {
            assert!(drawing(text, None).is_err(), "{text}");
        }
    }
}
