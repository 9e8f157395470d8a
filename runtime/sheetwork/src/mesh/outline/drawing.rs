//! SVG files: outline, cuts and creases of a drawing (XML by roxmltree, attributes by svgtypes).
//!
//! The elements `path`, `rect`, `circle`, `ellipse`, `polygon`, `polyline` and `line` are drawn
//! with their own and their groups' transforms, `use` draws what it refers to, and elements that
//! are not displayed are left out, as those that exist only in definitions. Elements of a colour or
//! a layer are cuts or creases, all others the outline.

use std::path::Path;

use kurbo::{Affine, BezPath, Shape};
use roxmltree::Node;
use svgtypes::{Color, Length, LengthUnit, PointsParser, Transform, ViewBox};

use crate::error::InputError;
use crate::mesh::outline::svg::path;

/// CSS pixel, 1/96 inch, m.
const PIXEL: f64 = 0.0254 / 96.0;

/// Maximum nesting of the elements of a file, `use` counted.
const MAX_DEPTH: usize = 256;

/// Maximum number of elements drawn, each `use` counted anew.
const MAX_ELEMENTS: usize = 100_000;

/// Curves of an SVG file, m, the middle of the outline's box at the origin.
#[derive(Debug, Default)]
pub(crate) struct SvgDrawing {
    /// Boundary and holes.
    pub outline: BezPath,
    /// Lines of the layers of cuts.
    pub cuts: BezPath,
    /// Lines of each layer of creases.
    pub creases: Vec<BezPath>,
}

/// Role of an element, from its own or a group's layer.
#[derive(Clone, Copy)]
enum SvgRole {
    Outline,
    Cut,
    Crease(usize),
}

/// State of a group while its elements are drawn.
#[derive(Clone, Copy)]
struct SvgGroup {
    place: Affine,
    role: SvgRole,
    depth: usize,
}

/// Layers that are no outline, and what has been drawn.
struct SvgReader<'a> {
    cuts: &'a [String],
    creases: &'a [&'a str],
    drawn: SvgDrawing,
    elements: usize,
}

impl SvgDrawing {
    /// Curves of a file's text. Elements whose stroke colour, `id` or Inkscape layer is one of
    /// `cuts` are cuts, those of one of `creases` are creases.
    ///
    /// # Errors
    /// The fault of the text.
    pub fn new(text: &str, scale: Option<f64>, cuts: &[String], creases: &[&str]) -> Result<Self, String> {
        let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
        let document =
            roxmltree::Document::parse_with_options(text, options).map_err(|e| format!("is not an SVG file: {e}"))?;
        let root = document.root_element();
        if root.tag_name().name() != "svg" {
            return Err(format!("is not an SVG file: its root is <{}>", root.tag_name().name()));
        }
        let drawn = Self { creases: vec![BezPath::new(); creases.len()], ..Self::default() };
        let mut reader = SvgReader { cuts, creases, drawn, elements: 0 };
        reader.collect(root, SvgGroup { place: Affine::IDENTITY, role: SvgRole::Outline, depth: 0 })?;
        let mut drawn = reader.drawn;
        if drawn.outline.elements().is_empty() {
            return Err("has no path or shape for the outline".into());
        }
        let empty = |path: &BezPath| path.elements().is_empty();
        let named = cuts.iter().map(String::as_str).filter(|_| empty(&drawn.cuts));
        let folds = creases.iter().zip(&drawn.creases).filter(|c| empty(c.1)).map(|c| *c.0);
        if let Some(name) = named.chain(folds).next() {
            return Err(format!("has no line of the colour or layer {name:?}"));
        }
        let metres = scale.unwrap_or_else(|| unit(root));
        let middle = drawn.outline.bounding_box().center();
        let place = Affine::scale(metres) * Affine::translate(-middle.to_vec2());
        let all = [&mut drawn.outline, &mut drawn.cuts].into_iter().chain(&mut drawn.creases);
        all.for_each(|path| *path = place * std::mem::take(path));
        Ok(drawn)
    }
}

/// Curves of a file, with the layers of its cuts and creases.
///
/// # Errors
/// A file that cannot be read, and the fault of its text.
pub(crate) fn read(
    file: &Path,
    scale: Option<f64>,
    cuts: &[String],
    creases: &[(String, f64)],
) -> Result<SvgDrawing, InputError> {
    let bytes = std::fs::read(file).map_err(|e| InputError::io(file, &e))?;
    let creases: Vec<&str> = creases.iter().map(|(layer, _)| layer.as_str()).collect();
    let drawn = decode(&bytes).and_then(|text| SvgDrawing::new(&text, scale, cuts, &creases));
    drawn.map_err(|e| InputError::new("", e).in_file(file))
}

impl SvgReader<'_> {
    fn collect(&mut self, node: Node, outer: SvgGroup) -> Result<(), String> {
        let name = node.tag_name().name();
        let only_defined = ["defs", "clipPath", "mask", "marker", "pattern", "symbol"];
        if node.is_element() && !only_defined.contains(&name) { self.draw(node, name, outer) } else { Ok(()) }
    }

    /// Draws an element and its children.
    fn draw(&mut self, node: Node, name: &str, outer: SvgGroup) -> Result<(), String> {
        self.elements += 1;
        if outer.depth > MAX_DEPTH {
            return Err(format!("nests elements more than {MAX_DEPTH} deep"));
        } else if self.elements > MAX_ELEMENTS {
            return Err(format!("draws more than {MAX_ELEMENTS} elements"));
        } else if style(node, "display") == Some("none") {
            return Ok(());
        }
        let mut group = SvgGroup { depth: outer.depth + 1, role: self.role(node).unwrap_or(outer.role), ..outer };
        if let Some(text) = node.attribute("transform") {
            let t: Transform = text.parse().map_err(|e| format!("has a transform that cannot be read: {e}"))?;
            group.place *= Affine::new([t.a, t.b, t.c, t.d, t.e, t.f]);
        }
        if name == "use" {
            let target = href(node).ok_or_else(|| "has a <use> of what is not in it".to_owned())?;
            group.place *= Affine::translate((length(node, "x", 0.0)?, length(node, "y", 0.0)?));
            return self.draw(target, target.tag_name().name(), group);
        }
        if style(node, "visibility").is_none_or(|v| v == "visible") {
            let curve = group.place * shape(node, name)?;
            let drawn = match group.role {
                SvgRole::Outline => &mut self.drawn.outline,
                SvgRole::Cut => &mut self.drawn.cuts,
                SvgRole::Crease(k) => &mut self.drawn.creases[k],
            };
            drawn.extend(curve.iter());
        }
        node.children().try_for_each(|child| self.collect(child, group))
    }

    /// Role by the element's own stroke colour, `id` or layer.
    fn role(&self, node: Node) -> Option<SvgRole> {
        let colour = style(node, "stroke").and_then(|c| c.parse::<Color>().ok());
        let layer = node.attributes().find(|a| a.name() == "label").map(|a| a.value());
        let is = |name: &str| {
            let same = colour.is_some_and(|c| name.parse::<Color>().is_ok_and(|n| n == c));
            same || node.attribute("id") == Some(name) || layer == Some(name)
        };
        let crease = || self.creases.iter().position(|name| is(name)).map(SvgRole::Crease);
        if self.cuts.iter().any(|name| is(name)) { Some(SvgRole::Cut) } else { crease() }
    }
}

/// Property of an element from its `style` or its attribute.
fn style<'a>(node: Node<'a, '_>, property: &str) -> Option<&'a str> {
    let own = node.attribute("style").and_then(|style| {
        let mut entries = style.split(';').filter_map(|entry| entry.split_once(':'));
        entries.find(|(name, _)| name.trim() == property).map(|(_, value)| value.trim())
    });
    own.or_else(|| node.attribute(property).map(str::trim))
}

/// Element that a `use` refers to.
fn href<'a, 'input>(node: Node<'a, 'input>) -> Option<Node<'a, 'input>> {
    let id = node.attributes().find(|a| a.name() == "href")?.value().strip_prefix('#')?;
    node.document().descendants().find(|n| n.attribute("id") == Some(id))
}

/// Length of an attribute in units of the drawing.
fn length(node: Node, attribute: &str, default: f64) -> Result<f64, String> {
    let Some(text) = node.attribute(attribute) else { return Ok(default) };
    let found = text.parse::<Length>().ok().and_then(|l| metres(l.unit).map(|m| l.number * m / PIXEL));
    found
        .filter(|l| l.is_finite())
        .ok_or_else(|| format!("has a <{}> whose {attribute} cannot be read: {text:?}", node.tag_name().name()))
}

/// Curve of an element in its own coordinates; empty for groups and elements without a shape.
fn shape(node: Node, name: &str) -> Result<BezPath, String> {
    let of = |attribute| length(node, attribute, 0.0);
    let exact = 1e-8;
    Ok(match name {
        "path" => node.attribute("d").map_or_else(|| Ok(BezPath::new()), path)?,
        "rect" => {
            let (x, y, wide, high) = (of("x")?, of("y")?, of("width")?, of("height")?);
            // A missing radius is the other one, or none.
            let (rx, ry) = (length(node, "rx", of("ry")?)?, length(node, "ry", of("rx")?)?);
            let (rx, ry) = (rx.clamp(0.0, 0.5 * wide.max(0.0)), ry.clamp(0.0, 0.5 * high.max(0.0)));
            if rx > 0.0 && ry > 0.0 {
                let squeezed = kurbo::RoundedRect::new(x, y * rx / ry, x + wide, (y + high) * rx / ry, rx);
                Affine::scale_non_uniform(1.0, ry / rx) * squeezed.to_path(exact * wide)
            } else {
                kurbo::Rect::new(x, y, x + wide, y + high).to_path(exact)
            }
        }
        "circle" => kurbo::Circle::new((of("cx")?, of("cy")?), of("r")?).to_path(exact * of("r")?.max(exact)),
        "ellipse" => {
            let (rx, ry) = (of("rx")?, of("ry")?);
            kurbo::Ellipse::new((of("cx")?, of("cy")?), (rx, ry), 0.0).to_path(exact * rx.max(ry).max(exact))
        }
        "line" => kurbo::Line::new((of("x1")?, of("y1")?), (of("x2")?, of("y2")?)).to_path(exact),
        "polygon" | "polyline" => {
            let mut curve = BezPath::new();
            for (i, point) in PointsParser::from(node.attribute("points").unwrap_or("")).enumerate() {
                if i == 0 { curve.move_to(point) } else { curve.line_to(point) }
            }
            if name == "polygon" && !curve.elements().is_empty() {
                curve.close_path();
            }
            curve
        }
        _ => BezPath::new(),
    })
}

/// Metres of a unit; `None` where it depends on the page or the font.
fn metres(unit: LengthUnit) -> Option<f64> {
    Some(match unit {
        LengthUnit::None | LengthUnit::Px => PIXEL,
        LengthUnit::In => 0.0254,
        LengthUnit::Cm => 0.01,
        LengthUnit::Mm => 0.001,
        LengthUnit::Pt => 0.0254 / 72.0,
        LengthUnit::Pc => 0.0254 / 6.0,
        LengthUnit::Em | LengthUnit::Ex | LengthUnit::Percent => return None,
    })
}

/// Metres per unit of the drawing: `width` over the width of the `viewBox`, where both exist.
fn unit(root: Node) -> f64 {
    let width = root.attribute("width").and_then(|w| w.parse::<Length>().ok());
    let width = width.and_then(|w| metres(w.unit).map(|m| w.number * m));
    let view = root.attribute("viewBox").and_then(|v| v.parse::<ViewBox>().ok());
    let scale = width.zip(view).map(|(width, view)| width / view.w);
    scale.filter(|s| s.is_finite() && *s > 0.0).unwrap_or(PIXEL)
}

/// Text of a file in UTF-8, UTF-16 with a byte-order mark, or ISO 8859-1 where its first line says
/// so.
///
/// # Errors
/// Another encoding.
fn decode(bytes: &[u8]) -> Result<String, String> {
    let wide = |join: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|b| join([b[0], b[1]])).collect();
        String::from_utf16(&units).map_err(|e| format!("is not UTF-16: {e}"))
    };
    let first = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).to_ascii_lowercase();
    let latin = ["iso-8859-1", "windows-1252", "latin1"].iter().any(|name| first.contains(name));
    match bytes {
        [0xff, 0xfe, ..] => wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] => wide(u16::from_be_bytes),
        _ if latin && first.starts_with("<?xml") => Ok(bytes.iter().map(|b| char::from(*b)).collect()),
        _ => match std::str::from_utf8(bytes) {
            Ok(text) => Ok(text.trim_start_matches('\u{feff}').to_owned()),
            Err(error) => Err(format!("is not UTF-8: {error}")),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> BezPath {
        SvgDrawing::new(text, None, &[], &[]).expect("a drawing").outline
    }

    #[test]
    fn files_have_units_groups_and_transforms() {
        let text = r#"<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="50mm" viewBox="0 0 200 100">
            <defs><path d="M0 0h500v500h-500z"/></defs>
            <g transform="translate(10 5) scale(2)"><path transform="rotate(90)" d="M0 0h20v40h-20z"/></g></svg>"#;
        let shape = read(text);
        let bounds = shape.bounding_box();
        // 40 units along the width, 80 along the length, at half a millimetre each.
        assert!((bounds.width() - 0.04).abs() < 1e-12 && (bounds.height() - 0.02).abs() < 1e-12, "{bounds:?}");
        assert!(bounds.center().to_vec2().hypot() < 1e-12);
        let scaled = SvgDrawing::new(text, Some(0.001), &[], &[]).expect("a drawing").outline.bounding_box();
        assert!((scaled.width() - 0.08).abs() < 1e-12);
    }

    #[test]
    fn every_shape_has_its_area() {
        let pi = std::f64::consts::PI;
        for (shape, area) in [
            ("<rect x='1' y='2' width='4' height='3'/>", 12.0),
            ("<rect width='4' height='3' rx='1'/>", 12.0 - 4.0 + pi),
            ("<rect width='4' height='3' rx='1' ry='0.5'/>", 12.0 - 4.0 * 0.5 + 0.5 * pi),
            ("<circle cx='5' r='2'/>", 4.0 * pi),
            ("<ellipse rx='2' ry='1'/>", 2.0 * pi),
            ("<polygon points='0,0 2,0 2,1'/>", 1.0),
            ("<polyline points='0 0 2 0 2 1 0 1 0 0'/>", 2.0),
            ("<rect width='2in' height='96'/>", 192.0 * 96.0),
            ("<defs><rect id='a' width='2' height='2'/></defs><use href='#a' x='3'/>", 4.0),
            ("<rect width='2' height='2'/><rect width='9' height='9' display='none'/>", 4.0),
            ("<rect width='2' height='2'/><g style='display:none'><rect width='9' height='9'/></g>", 4.0),
        ] {
            let drawn = SvgDrawing::new(&format!("<svg>{shape}</svg>"), Some(1.0), &[], &[]).expect(shape);
            assert!((drawn.outline.area().abs() / area - 1.0).abs() < 1e-6, "{shape}: {}", drawn.outline.area());
        }
    }

    #[test]
    fn lines_of_a_colour_or_a_layer_are_cuts_and_creases() {
        let text = "<svg xmlns:inkscape='i'><rect width='4' height='2'/><line x1='1' x2='1' y2='1' stroke='#F00'/>\
            <g inkscape:label='folds'><line x1='2' x2='2' y2='2'/></g></svg>";
        let drawn = SvgDrawing::new(text, Some(1.0), &["red".into()], &["folds"]).expect("a drawing");
        assert_eq!(drawn.outline.bounding_box(), kurbo::Rect::new(-2.0, -1.0, 2.0, 1.0));
        assert_eq!(drawn.cuts.bounding_box(), kurbo::Rect::new(-1.0, -1.0, -1.0, 0.0));
        assert_eq!(drawn.creases[0].bounding_box(), kurbo::Rect::new(0.0, -1.0, 0.0, 1.0));
        let error = SvgDrawing::new(text, Some(1.0), &[], &["green"]).expect_err("no green line");
        assert!(error.contains("green"), "{error}");
    }

    #[test]
    fn files_may_have_other_encodings() {
        let text = "<svg id='é'/>";
        let latin = "<?xml version='1.0' encoding='ISO-8859-1'?>";
        let wide = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
        assert_eq!(decode(&[&[0xff, 0xfe], wide(text).as_slice()].concat()).as_deref(), Ok(text));
        assert_eq!(decode(&[b"\xef\xbb\xbf", text.as_bytes()].concat()).as_deref(), Ok(text));
        let bytes = [latin.as_bytes(), b"<svg id='\xe9'/>"].concat();
        assert_eq!(decode(&bytes), Ok(format!("{latin}{text}")));
        assert!(decode(b"<svg id='\xe9'/>").is_err());
    }

    #[test]
    fn invalid_files_are_rejected() {
        for text in [
            "<svg/>",
            "<html/>",
            "hello",
            "<svg><path d='M 0 0 L 1'/></svg>",
            "<svg><rect width='10%' height='2'/></svg>",
            "<svg><use href='#a'/></svg>",
            "<svg><g id='a'><use href='#a'/></g></svg>",
        ] {
            assert!(SvgDrawing::new(text, None, &[], &[]).is_err(), "{text}");
        }
    }
}
