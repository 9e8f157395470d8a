//! Outlines: geometry of sheets that are not rectangles.
//!
//! An [`Outline`] is a boundary, its holes and its cuts, in the plane of the sheet: coordinates (x,
//! z), m, x along the length and z along the width. Curves are stored as polylines within
//! [`FLATNESS`] of the outline's size; all distances are exact on these polylines. [`mesh()`]
//! covers the outline with triangles:
//!
//! - `boundary_nodes`: nodes on the boundary and the cuts, a cell apart, with corners, and
//!   `inner_row`: a row a cell beside them;
//! - `triangulate`: grid points inside, a constrained Delaunay triangulation of both, square cells
//!   where there is room;
//! - `split`: nodes doubled along cuts;
//! - `mesh`: the result; `locate`: location of a point in it; `refine`: its local refinement.
//!
//! `features` rejects features smaller than a cell; `svg` and `drawing` read SVG paths and files.

pub(crate) mod boundary_nodes;
pub(crate) mod cut;
pub(crate) mod drawing;
pub(crate) mod features;
pub(crate) mod inner_row;
pub(crate) mod line;
pub mod locate;
pub mod mesh;
pub(crate) mod refine;
pub mod ring;
pub(crate) mod spec;
pub(crate) mod split;
pub(crate) mod svg;
#[cfg(test)]
mod tests;
pub(crate) mod triangulate;

use std::path::Path;

use glam::DVec2;
use kurbo::{BezPath, PathEl, Shape};

pub use crate::mesh::outline::mesh::{MeshEdge, NO_TRIANGLE, TriangleMesh};
pub use crate::mesh::outline::ring::Ring;
pub use crate::mesh::outline::spec::{HoleSpec, OutlineSpec, check_cuts, check_holes, check_outline};
pub use crate::mesh::outline::triangulate::mesh;

use crate::error::{InputError, reject_if};

/// Maximum distance between a curve and its polyline, as a fraction of the outline's larger extent.
pub const FLATNESS: f64 = 1e-6;

/// Distance between a curved crease and its lines, as a fraction of the outline's larger extent.
const CREASE_FLATNESS: f64 = 1e-3;

/// Boundary, holes and cuts of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Outer boundary, counter-clockwise in (x, z), then the holes, clockwise: the sheet is on the
    /// left of all.
    rings: Vec<Ring>,
    /// Polylines of the cuts, m, as specified: they may extend beyond the sheet.
    cuts: Vec<Vec<DVec2>>,
    low: DVec2,
    high: DVec2,
}

impl Outline {
    /// Outline from the specification of a sheet of `size` (m); `None` is that rectangle. Files are
    /// relative to `base`.
    ///
    /// # Errors
    /// When a file cannot be read, a boundary crosses itself or another or encloses no area, a hole
    /// is not inside, or a cut is not in the sheet; fields are relative to the sheet.
    pub fn new(
        outline: Option<&OutlineSpec>,
        holes: &[HoleSpec],
        cuts: &[Vec<(f64, f64)>],
        size: (f64, f64),
        base: &Path,
    ) -> Result<Self, InputError> {
        outline.map_or(Ok(()), |spec| check_outline(spec, size))?;
        check_holes(holes)?;
        check_cuts(cuts)?;
        let mut rings = nested(boundary(outline, size, base)?)?;
        for (i, hole) in holes.iter().enumerate() {
            rings.push(hole_ring(hole, &format!("holes.{i}"))?);
        }
        check_rings(&rings)?;
        for (i, ring) in rings.iter_mut().enumerate() {
            if (ring.area() > 0.0) != (i == 0) {
                ring.points.reverse();
            }
        }
        let cuts = cuts.iter().map(|c| c.iter().map(|p| DVec2::new(p.0, p.1)).collect()).collect();
        let (low, high) = bounds(&rings[0].points);
        Ok(Self { rings, cuts, low, high })
    }

    /// Outer boundary and holes.
    pub fn rings(&self) -> &[Ring] {
        &self.rings
    }

    /// Cuts, as specified.
    pub fn cuts(&self) -> &[Vec<DVec2>] {
        &self.cuts
    }

    /// Corners of the bounding box, m.
    pub fn bounds(&self) -> (DVec2, DVec2) {
        (self.low, self.high)
    }

    /// Area without the holes, m².
    pub fn area(&self) -> f64 {
        self.rings.iter().map(Ring::area).sum()
    }

    /// Whether `p` is in the sheet.
    pub fn contains(&self, p: DVec2) -> bool {
        self.rings.iter().filter(|r| r.contains(p)).count() % 2 == 1
    }

    /// Point of the boundary or of a hole's rim nearest to `p`.
    pub fn nearest(&self, p: DVec2) -> DVec2 {
        let found = self.rings.iter().map(|r| r.nearest(p)).min_by(|a, b| p.distance(*a).total_cmp(&p.distance(*b)));
        found.unwrap_or(p)
    }
}

/// Bounding box of points.
fn bounds(points: &[DVec2]) -> (DVec2, DVec2) {
    points.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)))
}

fn polygon(corners: &[(f64, f64)], field: &str) -> Ring {
    Ring::new(corners.iter().map(|p| DVec2::new(p.0, p.1)), field)
}

/// Closed polylines of the specification.
fn boundary(outline: Option<&OutlineSpec>, size: (f64, f64), base: &Path) -> Result<Vec<Ring>, InputError> {
    let (x, z) = (0.5 * size.0, 0.5 * size.1);
    let path = match outline {
        None => kurbo::Rect::new(-x, -z, x, z).to_path(FLATNESS),
        Some(OutlineSpec::Polygon(corners)) => return Ok(vec![polygon(corners, "outline")]),
        Some(OutlineSpec::Disc { radius }) => return Ok(vec![circle(DVec2::ZERO, *radius, "outline")]),
        Some(OutlineSpec::RoundedRectangle { radius }) => {
            kurbo::RoundedRect::new(-x, -z, x, z, *radius).to_path(1e-8 * x.max(z))
        }
        Some(OutlineSpec::Path(text)) => svg::path(text).map_err(|e| InputError::new("outline", e))?,
        Some(OutlineSpec::Svg { file, scale, cuts, creases }) => {
            drawing::read(&base.join(file), *scale, cuts, creases)?.outline
        }
    };
    let rings = flatten(&path);
    reject_if!(rings.is_empty(), "outline", "encloses nothing");
    let (low, high) = (path.bounding_box().min_x(), path.bounding_box().max_x());
    let (back, front) = (path.bounding_box().min_y(), path.bounding_box().max_y());
    let far = [low, high, back, front].into_iter().any(|v| !v.is_finite() || v.abs() > 1e3);
    reject_if!(far, "outline", "reaches from ({low}, {back}) to ({high}, {front}) m; it must stay within ±1000 m");
    Ok(rings)
}

/// Lines of an SVG outline.
#[derive(Default)]
pub(crate) struct DrawnLines {
    /// Cuts: polylines (x, z), m.
    pub cuts: Vec<Vec<(f64, f64)>>,
    /// Creases: ends (u, v) as fractions of the outline's box, and angle, degrees.
    pub creases: Vec<([DVec2; 2], f64)>,
}

impl DrawnLines {
    /// Cuts and creases of the file of an outline; none of other outlines.
    ///
    /// # Errors
    /// As [`Outline::new`].
    pub fn read(outline: Option<&OutlineSpec>, base: &Path) -> Result<Self, InputError> {
        let Some(OutlineSpec::Svg { file, scale, cuts, creases }) = outline else { return Ok(Self::default()) };
        if cuts.is_empty() && creases.is_empty() {
            return Ok(Self::default());
        }
        let drawn = drawing::read(&base.join(file), *scale, cuts, creases)?;
        let area = drawn.outline.bounding_box();
        let (low, size) = (DVec2::new(area.x0, area.y0), DVec2::new(area.width(), area.height()));
        let mut lines = Self::default();
        for line in polylines(&drawn.cuts, FLATNESS * size.max_element()) {
            lines.cuts.push(line.into_iter().map(Into::into).collect());
        }
        for (path, (_, angle)) in drawn.creases.iter().zip(creases) {
            let folds = polylines(path, CREASE_FLATNESS * size.max_element());
            let ends = folds.iter().flat_map(|l| l.windows(2)).map(|w| [w[0], w[1]].map(|p| (p - low) / size));
            lines.creases.extend(ends.map(|ends| (ends, *angle)));
        }
        Ok(lines)
    }
}

fn hole_ring(hole: &HoleSpec, field: &str) -> Result<Ring, InputError> {
    Ok(match hole {
        HoleSpec::Polygon(corners) => polygon(corners, field),
        HoleSpec::Disc { centre, radius } => circle(DVec2::new(centre.0, centre.1), *radius, field),
    })
}

/// Circle as a regular polygon with corners on the circle.
fn circle(centre: DVec2, radius: f64, field: &str) -> Ring {
    // A chord of angle φ stays within r φ²/8 of its arc, and the circle's extent is 2r.
    let sides = 4 * (0.25 * std::f64::consts::TAU / (16.0 * FLATNESS).sqrt()).ceil() as u32;
    let angle = |i: u32| f64::from(i) * std::f64::consts::TAU / f64::from(sides);
    Ring::new((0..sides).map(|i| centre + radius * DVec2::from_angle(angle(i))), field)
}

/// Subpaths as closed polylines; an open one is closed by a straight side.
fn flatten(path: &BezPath) -> Vec<Ring> {
    let size = path.bounding_box();
    let lines = polylines(path, FLATNESS * size.width().max(size.height()));
    let rings = lines.into_iter().map(|line| Ring::new(line, "outline"));
    rings.filter(|ring| ring.points.len() > 1).collect()
}

/// Subpaths as polylines within `tolerance` (m).
fn polylines(path: &BezPath, tolerance: f64) -> Vec<Vec<DVec2>> {
    let mut lines: Vec<Vec<DVec2>> = Vec::new();
    kurbo::flatten(path.iter(), tolerance.max(f64::MIN_POSITIVE), |element| match (element, lines.last_mut()) {
        (PathEl::MoveTo(p), _) => lines.push(vec![DVec2::new(p.x, p.y)]),
        (PathEl::LineTo(p), Some(line)) => line.push(DVec2::new(p.x, p.y)),
        (PathEl::ClosePath, Some(line)) => line.push(line[0]),
        _ => {}
    });
    lines.retain(|line| line.len() > 1);
    lines
}

/// Rings of one outline with the outer one first: even-odd, one piece.
fn nested(mut rings: Vec<Ring>) -> Result<Vec<Ring>, InputError> {
    for ring in &rings {
        check_area(ring)?;
    }
    let depth = |i: usize| {
        let p = rings[i].points[0];
        (0..rings.len()).filter(|j| *j != i && rings[*j].contains(p)).count()
    };
    let depths: Vec<usize> = (0..rings.len()).map(depth).collect();
    let outer: Vec<usize> = (0..rings.len()).filter(|i| depths[*i].is_multiple_of(2)).collect();
    if outer.len() != 1 {
        // A crossing is the likelier cause of two pieces, and the better message.
        check_crossings(&rings)?;
        return Err(InputError::new("outline", format!("is {} separate pieces; a sheet is one piece", outer.len())));
    }
    rings.swap(0, outer[0]);
    Ok(rings)
}

fn check_area(ring: &Ring) -> Result<(), InputError> {
    let (low, high) = bounds(&ring.points);
    let extent = (high - low).max_element();
    let least = 1e-9 * extent * extent;
    let straight = ring.sides().all(|(a, b)| (a - ring.points[0]).perp_dot(b - ring.points[0]).abs() <= least);
    if !straight && ring.area().abs() <= least {
        // The areas of the two loops of a figure eight can cancel.
        check_crossings(std::slice::from_ref(ring))?;
    }
    reject_if!(straight || ring.area().abs() <= least, &ring.field, "encloses no area ({} m across)", metres(extent));
    Ok(())
}

fn check_crossings(rings: &[Ring]) -> Result<(), InputError> {
    let Some((a, b, p)) = ring::crossing(rings) else { return Ok(()) };
    let place = format!("near ({}, {}) m", metres(p.x), metres(p.y));
    let (a, b) = (&rings[a].field, &rings[b].field);
    let problem = if a == b { format!("crosses itself {place}") } else { format!("crosses {a} {place}") };
    Err(InputError::new(b, problem))
}

fn check_rings(rings: &[Ring]) -> Result<(), InputError> {
    rings.iter().try_for_each(check_area)?;
    for ring in rings {
        check_crossings(std::slice::from_ref(ring))?;
    }
    let fits = |i: usize, j: usize| rings[j].contains(rings[i].points[0]);
    for i in 1..rings.len() {
        if !fits(i, 0) {
            check_crossings(rings)?;
            return Err(InputError::new(&rings[i].field, "lies outside the outline"));
        }
        if let Some(j) = (1..rings.len()).find(|j| *j != i && fits(i, *j)) {
            return Err(InputError::new(&rings[i].field, format!("lies inside another hole, {}", rings[j].field)));
        }
    }
    check_crossings(rings)
}

/// Text of a length or coordinate, to four digits.
pub(crate) fn metres(value: f64) -> String {
    if value.abs() < 1e-15 {
        return "0".into();
    }
    let digits = (3.0 - value.abs().log10().floor()).clamp(0.0, 12.0) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
