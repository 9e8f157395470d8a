//! Specification of outlines, holes and cuts, and the checks that need no geometry.
//!
//! Coordinates are (x, z) in the sheet's plane, m: x along the length, z along the width, the
//! origin in the sheet's middle.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::error::{InputError, check_range, reject_if};
use crate::units::parameters::ParameterId as Id;

/// Outer boundary of a sheet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum OutlineSpec {
    /// Corners (x, z) in order, m, each within ±1000; 3 or more. Turns of less than 20° count as
    /// parts of a curve.
    Polygon(Vec<(f64, f64)>),
    /// Disc about the origin.
    Disc {
        /// Radius, m; 1e-6 to 1e3.
        radius: f64,
    },
    /// Rectangle of the sheet's size with round corners.
    RoundedRectangle {
        /// Radius of the corners, m; 0 to half the shorter side.
        radius: f64,
    },
    /// SVG path in metres: x along the length, y along the width. Subpaths inside the first are
    /// holes (even-odd).
    Path(String),
    /// Paths and shapes of an SVG file, with the middle of the outline's box at the origin.
    Svg {
        /// File, relative to the scene.
        file: PathBuf,
        /// Metres per unit of the drawing; 1e-9 to 1e3. `None` uses the file's `width` and
        /// `viewBox`, else 1/96 inch.
        scale: Option<f64>,
        /// Stroke colours, or names of layers (`id`, or Inkscape's label), whose lines are cuts.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        cuts: Vec<String>,
        /// Stroke colours or layers whose lines are creases, each with its angle, degrees, -175 to
        /// 175.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        creases: Vec<(String, f64)>,
    },
}

/// Hole in a sheet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum HoleSpec {
    /// Corners (x, z) in order, m; 3 or more.
    Polygon(Vec<(f64, f64)>),
    /// A round hole.
    Disc {
        /// Centre (x, z), m; each within ±1000.
        centre: (f64, f64),
        /// Radius, m; 1e-6 to 1e3.
        radius: f64,
    },
}

/// Maximum number of corners of a polygon or a cut.
const MAX_CORNERS: usize = 100_000;

fn corners(field: &str, list: &[(f64, f64)], fewest: usize) -> Result<(), InputError> {
    let count = list.len();
    let fits = (fewest..=MAX_CORNERS).contains(&count);
    reject_if!(!fits, field, "{count} points are outside {fewest} to {MAX_CORNERS}");
    let mut list = list.iter().enumerate();
    list.try_for_each(|(i, p)| Id::OutlineCorner.check_each(&format!("{field}.{i}"), [p.0, p.1]))
}

/// Check the ranges of an outline of a sheet of `size` (m).
///
/// # Errors
/// The first value out of range; an SVG file is not read.
pub fn check_outline(spec: &OutlineSpec, size: (f64, f64)) -> Result<(), InputError> {
    match spec {
        OutlineSpec::Polygon(list) => corners("outline", list, 3),
        OutlineSpec::Disc { radius } => check_range("outline.radius", *radius, 1e-6, 1e3, "m"),
        OutlineSpec::RoundedRectangle { radius } => {
            check_range("outline.radius", *radius, 0.0, 0.5 * size.0.min(size.1), "m")
        }
        OutlineSpec::Path(text) => {
            crate::mesh::outline::svg::path(text).map(drop).map_err(|e| InputError::new("outline", e))
        }
        OutlineSpec::Svg { scale, creases, .. } => {
            scale.map_or(Ok(()), |s| check_range("outline.scale", s, 1e-9, 1e3, "m"))?;
            let mut angles = creases.iter().enumerate();
            angles.try_for_each(|(i, (_, angle))| Id::CreaseAngle.check(&format!("outline.creases.{i}.1"), *angle))
        }
    }
}

/// Check the ranges of holes.
///
/// # Errors
/// The first value out of range.
pub fn check_holes(holes: &[HoleSpec]) -> Result<(), InputError> {
    holes.iter().enumerate().try_for_each(|(i, hole)| match hole {
        HoleSpec::Polygon(list) => corners(&format!("holes.{i}"), list, 3),
        HoleSpec::Disc { centre, radius } => {
            Id::HoleCorner.check_each(&format!("holes.{i}.centre"), [centre.0, centre.1])?;
            check_range(&format!("holes.{i}.radius"), *radius, 1e-6, 1e3, "m")
        }
    })
}

/// Check the ranges of cuts.
///
/// # Errors
/// The first value out of range.
pub fn check_cuts(cuts: &[Vec<(f64, f64)>]) -> Result<(), InputError> {
    cuts.iter().enumerate().try_for_each(|(i, cut)| corners(&format!("cuts.{i}"), cut, 2))
}
