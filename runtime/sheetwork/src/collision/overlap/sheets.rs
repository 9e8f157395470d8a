//! Surfaces of sheets as they lie, and their overlap: sum of the half thicknesses minus the
//! distance of the surfaces, m. Surfaces that intersect overlap by the whole sum.

use glam::DVec3;

use crate::collision::collision_surface::CollisionSurface;
use crate::collision::overlap::rim::inset_border;
use crate::collision::overlap::{BodyPose, OverlapSolid, corners, distance, faces, half_thickness};
use crate::math::Vectors;
use crate::sheet::Sheet;

/// Triangle of a sheet: nodes and corners.
type PlacedTriangle = ([u32; 3], [DVec3; 3]);

/// Where a surface is nearest to another object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearestPlace {
    /// Distance of another sheet, or depth in a solid, m.
    pub distance: f64,
    /// Place, m.
    pub place: DVec3,
    /// Corners of the triangle, and of that of the other sheet, m.
    pub triangles: [[DVec3; 3]; 2],
}

/// Surface of a sheet in its present position.
pub(crate) struct PlacedSheet<'a> {
    pub sheet: &'a Sheet,
    /// Triangles by their least x.
    triangles: Vec<PlacedTriangle>,
    /// Greatest extent of a triangle along x, m.
    wide: f64,
    /// Corners of the box around the nodes, m.
    pub low: DVec3,
    pub high: DVec3,
}

impl<'a> PlacedSheet<'a> {
    /// The surface, without the triangles that `keep` excludes.
    pub fn new(sheet: &'a Sheet, keep: impl Fn(&[u32; 3]) -> bool) -> Self {
        Self::at(sheet, &sheet.state.x, keep)
    }

    /// The surface with the nodes at `x` (m), without the triangles that `keep` excludes.
    fn at(sheet: &'a Sheet, x: &Vectors, keep: impl Fn(&[u32; 3]) -> bool) -> Self {
        let each = faces(sheet).into_iter().filter(keep).map(|t| (t, corners(x, &t)));
        let mut triangles: Vec<PlacedTriangle> = each.collect();
        triangles.sort_by(|a, b| bounds(a.1).0.x.total_cmp(&bounds(b.1).0.x));
        let (low, high) = x.bounds().unwrap_or_default();
        let wide = triangles.iter().map(|(_, t)| bounds(*t).1.x - bounds(*t).0.x).fold(0.0, f64::max);
        Self { sheet, triangles, wide, low, high }
    }

    /// The surface without the triangles whose nodes are all held.
    pub fn free(sheet: &'a Sheet) -> Self {
        Self::new(sheet, |t| t.iter().any(|i| !sheet.is_held(*i as usize)))
    }

    /// The surface as it meets itself, with a flat rim.
    pub fn with_flat_rim(sheet: &'a Sheet, surface: &CollisionSurface) -> Self {
        let mut x = sheet.state.x.clone();
        inset_border(surface, &mut x, &mut Vec::new(), half_thickness(sheet));
        Self::at(sheet, &x, |t| t.iter().any(|i| !sheet.is_held(*i as usize)))
    }

    /// Mean normal.
    pub fn normal(&self) -> DVec3 {
        self.triangles.iter().map(|(_, [a, b, c])| (*b - *a).cross(*c - *a)).sum::<DVec3>().normalize_or(DVec3::Y)
    }

    /// Greatest depth of the surface, moved by `by`, in a solid, with the place; negative outside.
    /// Exact down to the negative thickness.
    pub fn depth(&self, by: DVec3, solid: &OverlapSolid, pose: &BodyPose) -> Option<NearestPlace> {
        let reach = 2.0 * half_thickness(self.sheet);
        let depth = |(_, t): &PlacedTriangle| {
            let t = t.map(|p| p + by);
            let local = t.map(|p| pose.local(p));
            let deepest = t.into_iter().zip(local).max_by(|a, b| solid.depth(a.1).total_cmp(&solid.depth(b.1)));
            let place = deepest.map_or(t[0], |d| d.0);
            NearestPlace { distance: solid.overlap(&local, reach), place, triangles: [t; 2] }
        };
        self.triangles.iter().map(depth).max_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// Least distance below `reach` (m) from the surface, moved by `by`, to another, with the
    /// place. Pairs of triangles that `skips` accepts do not count.
    pub fn nearest(
        &self,
        by: DVec3,
        other: &PlacedSheet,
        reach: f64,
        skips: impl Fn(&[u32; 3], &[u32; 3]) -> bool,
    ) -> Option<NearestPlace> {
        let around = (other.low, other.high);
        if apart((self.low + by, self.high + by), around, reach) {
            return None;
        }
        let mut found: Option<NearestPlace> = None;
        for (nodes, t) in &self.triangles {
            let least = found.map_or(reach, |f| f.distance);
            let t = t.map(|p| p + by);
            let own = bounds(t);
            if least <= 0.0 || apart(own, around, least) {
                continue;
            }
            let first = other.triangles.partition_point(|(_, u)| bounds(*u).0.x < own.0.x - least - other.wide);
            let along = other.triangles[first..].iter().take_while(|(_, u)| bounds(*u).0.x <= own.1.x + least);
            for (others, u) in along.filter(|(_, u)| !apart(own, bounds(*u), least)) {
                if skips(nodes, others) {
                    continue;
                }
                let distance = distance::triangles(&t, u);
                if distance < found.map_or(reach, |f| f.distance) {
                    let place = t.iter().sum::<DVec3>() / 3.0;
                    found = Some(NearestPlace { distance, place, triangles: [t, *u] });
                }
            }
        }
        found
    }
}

/// Largest overlap (m) of any two sheets; 0 if none touch.
pub fn between(sheets: &[Sheet]) -> f64 {
    pairs(sheets, 0.0).into_iter().map(|(_, _, overlap)| overlap).fold(0.0, f64::max)
}

/// Indices and overlap (m) of all pairs of sheets nearer than `slack` (m) to contact.
pub fn pairs(sheets: &[Sheet], slack: f64) -> Vec<(usize, usize, f64)> {
    let placed: Vec<PlacedSheet> = sheets.iter().map(|sheet| PlacedSheet::new(sheet, |_| true)).collect();
    let mut found = Vec::new();
    for (i, a) in placed.iter().enumerate() {
        for (j, b) in placed.iter().enumerate().skip(i + 1) {
            let touching = half_thickness(a.sheet) + half_thickness(b.sheet);
            let nearest = a.nearest(DVec3::ZERO, b, touching + slack, |_, _| false);
            found.extend(nearest.map(|found| (i, j, touching - found.distance)));
        }
    }
    found
}

/// Corners of the box around a triangle, m.
pub(crate) fn bounds([a, b, c]: [DVec3; 3]) -> (DVec3, DVec3) {
    (a.min(b).min(c), a.max(b).max(c))
}

/// Whether two boxes are farther than `by` (m) from each other along an axis.
pub(crate) fn apart(a: (DVec3, DVec3), b: (DVec3, DVec3), by: f64) -> bool {
    (a.0 - b.1).max(b.0 - a.1).max_element() > by
}
