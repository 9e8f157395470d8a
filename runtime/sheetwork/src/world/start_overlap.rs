//! Start states: sheets whose surface intersects a body or another sheet when a scene is built.
//!
//! A sheet may start in contact, and nearer than its thickness: the first step moves it apart. A
//! surface that lies deeper in a body than [`StartSettings::depth`], or that intersects another
//! sheet, is refused with the pair, the place and the depth. With the scene's `repair` the sheet is
//! moved, undeformed, by the shortest of the translations that free it along the normals of what it
//! intersects. Held nodes, and bodies that are not convex, do not count. Lengths in m.

use glam::DVec3;

use crate::collision::overlap::distance::triangles;
use crate::collision::overlap::sheets::{apart, bounds};
use crate::collision::overlap::solid::ConvexSolid;
use crate::collision::overlap::{BodyPose, OverlapSolid, corners, faces, half_thickness};
use crate::error::InputError;
use crate::rigid::RigidWorld;
use crate::scene::Shape;
use crate::sheet::Sheet;
use crate::units::settings::settings;

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

/// A convex part of a body at its start.
struct PlacedSolid<'a> {
    name: &'a str,
    solid: OverlapSolid,
    pose: BodyPose,
    normals: Vec<DVec3>,
    /// Centre and radius of a sphere around it; `None` for a half space.
    sphere: Option<(DVec3, f64)>,
}

fn placed_solids(rigid: Option<&RigidWorld>) -> Vec<PlacedSolid<'_>> {
    let mut all = Vec::new();
    for (index, body) in rigid.into_iter().flat_map(|r| r.bodies().iter().enumerate()) {
        let Some(state) = rigid.and_then(|r| r.state(index)) else { continue };
        let pose = BodyPose { position: state.origin(), rotation: state.rotation() };
        let mut add = |solid, normals: Vec<DVec3>, sphere: Option<(DVec3, f64)>| {
            let normals = normals.into_iter().map(|n| pose.rotation * n).collect();
            let sphere = sphere.map(|(centre, radius)| (pose.position + pose.rotation * centre, radius));
            all.push(PlacedSolid { name: &body.name, solid, pose, normals, sphere });
        };
        match body.shape {
            Shape::HalfSpace => add(OverlapSolid::HalfSpace, vec![DVec3::Y], None),
            Shape::Ball(radius) => {
                add(OverlapSolid::Ball(radius), DVec3::AXES.to_vec(), Some((DVec3::ZERO, radius)));
            }
            _ => {
                for polyhedron in body.polyhedra.iter().filter(|p| crate::rigid::shape::is_convex(p)) {
                    let normals = (0..polyhedron.faces.len()).map(|face| polyhedron.face_normal(face)).collect();
                    let (low, high) = polyhedron.bounds();
                    let sphere = (low.midpoint(high), 0.5 * low.distance(high));
                    add(OverlapSolid::Convex(ConvexSolid::new(polyhedron)), normals, Some(sphere));
                }
            }
        }
    }
    all
}

/// Surface of a sheet in a position, without the triangles whose nodes are all held.
struct PlacedSheet<'a> {
    sheet: &'a Sheet,
    /// Corners, by the least x of each triangle.
    triangles: Vec<[DVec3; 3]>,
    /// Greatest extent of a triangle along x.
    wide: f64,
    low: DVec3,
    high: DVec3,
}

impl<'a> PlacedSheet<'a> {
    fn new(sheet: &'a Sheet) -> Self {
        let free = |t: &[u32; 3]| t.iter().any(|i| !sheet.is_held(*i as usize));
        let each = faces(sheet).into_iter().filter(free).map(|t| corners(&sheet.state.x, &t));
        let mut triangles: Vec<[DVec3; 3]> = each.collect();
        triangles.sort_by(|a, b| bounds(*a).0.x.total_cmp(&bounds(*b).0.x));
        let (low, high) = sheet.state.x.bounds().unwrap_or_default();
        let wide = triangles.iter().map(|t| bounds(*t).1.x - bounds(*t).0.x).fold(0.0, f64::max);
        Self { sheet, triangles, wide, low, high }
    }

    fn at(&self, by: DVec3) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        self.triangles.iter().map(move |t| t.map(|p| p + by))
    }

    fn normal(&self) -> DVec3 {
        self.triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a)).sum::<DVec3>().normalize_or(DVec3::Y)
    }

    /// Greatest depth in a solid, with the place; negative outside.
    fn depth(&self, by: DVec3, placed: &PlacedSolid) -> Option<(f64, DVec3)> {
        let reach = 2.0 * half_thickness(self.sheet);
        let away = |(centre, radius): (DVec3, f64)| {
            centre.clamp(self.low + by, self.high + by).distance(centre) > radius + reach
        };
        if placed.sphere.is_some_and(away) {
            return None;
        }
        let depth = |t: [DVec3; 3]| {
            let local = t.map(|p| placed.pose.local(p));
            let deepest =
                t.into_iter().zip(local).max_by(|a, b| placed.solid.depth(a.1).total_cmp(&placed.solid.depth(b.1)));
            (placed.solid.overlap(&local, reach), deepest.map_or(t[0], |d| d.0))
        };
        self.at(by).map(depth).max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Place where it is nearer than `gap` to another sheet.
    fn meets(&self, by: DVec3, other: &PlacedSheet, gap: f64) -> Option<DVec3> {
        let around = (other.low, other.high);
        if apart((self.low + by, self.high + by), around, gap) {
            return None;
        }
        let meets = |t: [DVec3; 3]| {
            let (low, high) = bounds(t);
            let (low, high) = (low - gap, high + gap);
            if apart((low, high), around, 0.0) {
                return false;
            }
            let first = other.triangles.partition_point(|u| bounds(*u).0.x < low.x - other.wide);
            let around = other.triangles[first..].iter().take_while(|u| bounds(**u).0.x <= high.x);
            let mut near = around.filter(|u| {
                let (under, over) = bounds(**u);
                under.cmple(high).all() && over.cmpge(low).all()
            });
            near.any(|u| triangles(&t, u) < gap)
        };
        self.at(by).find(|t| meets(*t)).map(|[a, b, c]| (a + b + c) / 3.0)
    }
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
            let Some((depth, place)) = sheet.depth(by, solid).filter(|found| found.0 > tolerance) else { continue };
            let mut ways = solid.normals.clone();
            ways.extend([sheet.normal(), -sheet.normal()]);
            return Some(StartOverlap { with: format!("body {:?}", solid.name), place, depth: Some(depth), ways });
        }
        self.sheets.iter().find_map(|other| {
            let place = sheet.meets(by, other, gap * (half + half_thickness(other.sheet)))?;
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
    let placed: Vec<PlacedSheet> = sheets.iter().map(PlacedSheet::new).collect();
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
