//! Start states: sheets whose surface intersects a body or another sheet when a scene is built.
//!
//! A sheet may start in contact, and nearer than its thickness: the first step moves it apart. A
//! surface that lies deeper in a body than [`StartSettings::depth`], or that intersects another
//! sheet, is refused with the pair, the place and the depth. With the scene's `repair` the sheet is
//! moved, undeformed, by the shortest of the translations that free it along the normals of what it
//! intersects. Held nodes, and bodies that are not convex, do not count. Lengths in m.

use glam::DVec3;

use crate::collision::overlap::half_thickness;
use crate::collision::overlap::sheets::PlacedSheet;
use crate::error::InputError;
use crate::rigid::RigidWorld;
use crate::sheet::Sheet;
use crate::units::settings::settings;
use crate::world::placed_solids::{PlacedSolid, placed_solids};

settings! {
    /// Settings of the check of start states; distances are in thicknesses.
    pub struct StartSettings {
        /// Accepted depth of a surface in a body: that of the invariant of contact.
        pub depth: f64 = 0.1,
        /// Distance of another sheet below which surfaces intersect: rounding.
        pub intersection: f64 = 1e-6,
        /// Halvings of the interval of a translation: from a sheet's size to rounding.
        pub halvings: u32 = 50,
    }
}

const SETTINGS: StartSettings = StartSettings::DEFAULT;

/// Depth in a body and distance of another sheet in contact, in thicknesses.
const CONTACT: (f64, f64) = (-0.5, 1.0);

/// Intersection of a sheet at its start.
struct StartOverlap {
    /// Kind and name of the other.
    with: String,
    place: DVec3,
    /// Depth in a body; `None` between sheets.
    depth: Option<f64>,
    /// Directions along which the sheet may leave.
    ways: Vec<DVec3>,
}

/// Everything that sheet `index` may intersect: the bodies and the sheets before it.
struct Surroundings<'a> {
    solids: &'a [PlacedSolid<'a>],
    sheets: &'a [PlacedSheet<'a>],
}

impl Surroundings<'_> {
    /// First intersection of a sheet moved by `by`, with bodies in the order of the scene: deeper
    /// than `depth` in a body, nearer than `gap` to a sheet, in thicknesses.
    fn find(&self, sheet: &PlacedSheet, by: DVec3, (depth, gap): (f64, f64)) -> Option<StartOverlap> {
        let half = half_thickness(sheet.sheet);
        let tolerance = 2.0 * depth * half;
        for solid in self.solids {
            let Some(found) = solid.depth_of(sheet, by).filter(|found| found.distance > tolerance) else { continue };
            let (depth, place) = (found.distance, found.place);
            let mut ways = solid.normals.clone();
            ways.extend([sheet.normal(), -sheet.normal()]);
            return Some(StartOverlap { with: format!("body {:?}", solid.name), place, depth: Some(depth), ways });
        }
        self.sheets.iter().find_map(|other| {
            let reach = gap * (half + half_thickness(other.sheet));
            let place = sheet.nearest(by, other, reach, |_, _| false)?.place;
            let ways = [sheet.normal(), other.normal()].into_iter().flat_map(|n| [n, -n]).collect();
            Some(StartOverlap { with: format!("sheet {:?}", other.sheet.name), place, depth: None, ways })
        })
    }

    /// Shortest translation along one of `ways` that brings a sheet out of everything, to contact.
    fn way_out(&self, sheet: &PlacedSheet, ways: &[DVec3]) -> Option<DVec3> {
        let half = half_thickness(sheet.sheet);
        let clear = |by: DVec3| self.find(sheet, by, CONTACT).is_none();
        let far = 4.0 * sheet.low.distance(sheet.high).max(half);
        let along = |way: &DVec3| {
            let mut length = half;
            while !clear(length * *way) {
                length *= 2.0;
                if length > far {
                    return None;
                }
            }
            let (mut inside, mut outside) = (0.0, length);
            for _ in 0..SETTINGS.halvings {
                let middle = 0.5 * (inside + outside);
                if clear(middle * *way) { outside = middle } else { inside = middle }
            }
            Some((outside, outside * *way))
        };
        let found = ways.iter().filter_map(along).min_by(|a, b| a.0.total_cmp(&b.0));
        found.map(|(_, by)| by)
    }
}

/// Check the sheets from `first` on against bodies and the sheets before them. With `repair` the
/// first of them that intersects is returned with the translation that frees it.
///
/// # Errors
/// The first intersection, where `repair` is not set or no translation frees the sheet.
pub(crate) fn check(
    sheets: &[Sheet],
    first: usize,
    rigid: Option<&RigidWorld>,
    repair: bool,
) -> Result<Option<(usize, DVec3)>, InputError> {
    let solids = placed_solids(rigid);
    let placed: Vec<PlacedSheet> = sheets.iter().map(PlacedSheet::free).collect();
    for index in first..sheets.len() {
        let sheet = &placed[index];
        let around = Surroundings { solids: &solids, sheets: &placed[..index] };
        let Some(found) = around.find(sheet, DVec3::ZERO, (SETTINGS.depth, SETTINGS.intersection)) else { continue };
        let is_free = (0..sheet.sheet.node_count()).all(|i| !sheet.sheet.is_held(i));
        if let Some(by) = (repair && is_free).then(|| around.way_out(sheet, &found.ways)).flatten() {
            return Ok(Some((index, by)));
        }
        let StartOverlap { with, place: p, depth, .. } = found;
        let depth = depth.map_or_else(String::new, |d| format!(" {d:.3e} m deep"));
        let cure = match (repair, is_free) {
            (true, true) => "no translation frees it",
            (true, false) => "`repair` does not move a sheet with held nodes",
            _ => "move it, or set `repair: true` of the scene",
        };
        let problem = format!("starts inside {with}:{depth} near ({:.4}, {:.4}, {:.4}) m; {cure}", p.x, p.y, p.z);
        return Err(InputError::new(format!("sheets.{index}.placement"), problem));
    }
    Ok(None)
}
