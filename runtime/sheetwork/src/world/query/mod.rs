//! Geometric queries: rays, swept balls, closest points, overlaps, and the surface at a material
//! point.
//!
//! The surface of a sheet is one of its layers, flat between the nodes: the middle surface of a
//! shell, the upper or the lower layer of a lattice. Its triangles belong to the collision surface
//! too. Open cells and detached nodes are no part of the surface. Queries are exact on the
//! triangles and see both sides. The earlier sheet and triangle of two equally distant ones is the
//! result.
//!
//! A query with an argument that is not finite, or without a direction, has no result. Lengths are
//! in m.

mod curvature;
mod overlap;
mod ray;
mod settings;
mod surface;

use std::cell::Cell;

use glam::{DQuat, DVec3};

use crate::collision::geometry::point_triangle;
use crate::sheet::Vectors;
use crate::world::World;
use crate::world::ids::SheetId;
use crate::world::query::overlap::OverlapShape;
use crate::world::query::ray::QueryRay;
use crate::world::query::surface::QuerySurface;

/// Layer of a sheet that queries meet. A shell has one layer, its middle surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum QueryLayer {
    /// Highest layer.
    #[default]
    Upper,
    /// Lowest layer.
    Lower,
}

/// Choice of the surfaces that queries meet; by default the upper layers of all sheets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct QueryFilter {
    /// Layer.
    pub layer: QueryLayer,
    /// Only sheet; `None` for all. The id of a removed sheet gives no results.
    pub sheet: Option<SheetId>,
}

/// Point of the surface of a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfacePoint {
    /// Sheet.
    pub sheet: SheetId,
    /// Nodes of the triangle, counter-clockwise seen from the upper side.
    pub nodes: [u32; 3],
    /// Weights of the nodes, each 0 to 1; they sum to 1.
    pub weights: [f64; 3],
    /// Nearest of the three nodes.
    pub node: u32,
    /// Material coordinates (u, v), each 0 to 1 over the bottom layer. On the seam of a tube v is
    /// that of the nearer row.
    pub uv: (f64, f64),
    /// Position, m.
    pub position: DVec3,
    /// Unit normal of the triangle, out of the upper side; zero for a triangle without area.
    pub normal: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Distance from the origin or point of the query, m; path of the centre for a swept ball, 0
    /// for a material point.
    pub distance: f64,
}

/// Curvature of a surface at a material point, 1/m; positive where the centre of curvature is on
/// the upper side.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfaceCurvature {
    /// Principal curvatures, the larger first, 1/m.
    pub principal: [f64; 2],
    /// Unit tangents of the principal curvatures; any two orthogonal ones at an umbilic point.
    pub directions: [DVec3; 2],
    /// Mean curvature (κ₁ + κ₂)/2, 1/m.
    pub mean: f64,
    /// Gaussian curvature κ₁ κ₂, 1/m².
    pub gaussian: f64,
}

/// Area of the closed cells of a layer, m².
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfaceArea {
    /// At the present positions, m².
    pub present: f64,
    /// Flat at rest, m², without thermal expansion.
    pub rest: f64,
}

/// Solid that is tested for overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum QueryShape {
    /// Ball.
    Ball {
        /// Centre, m.
        centre: DVec3,
        /// Radius, m, at least 0.
        radius: f64,
    },
    /// Cuboid.
    Cuboid {
        /// Centre, m.
        centre: DVec3,
        /// Rotation from the axes of the cuboid to those of the world.
        rotation: DQuat,
        /// Half lengths along its axes, m, each at least 0.
        half_extents: DVec3,
    },
}

/// Sheets and nodes in a solid. A buffer that is used again allocates nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceOverlaps {
    /// Sheets whose surface meets the solid, in the order of the world.
    pub sheets: Vec<SheetId>,
    /// Nodes of their surfaces in the solid, ascending in each sheet; a sheet that the solid meets
    /// between its nodes has none.
    pub nodes: Vec<(SheetId, u32)>,
}

/// Node positions (m) at a time between two states: those of the first at 0, of the second at 1.
pub type InterpolatedNodes<'a> = (&'a Vectors, &'a Vectors, f32);

/// Queries of the surfaces of a world in its present state, from [`World::queries`].
///
/// The bounding boxes of all sheets are computed once, the triangles of a sheet at the first query
/// that comes near it. Keep the value for all queries of a frame; the queries themselves allocate
/// nothing but their results. A query costs a box test per sheet, and one per 32 triangles of the
/// sheets whose boxes it meets.
pub struct SheetQueries<'w> {
    surfaces: Vec<QuerySurface<'w>>,
}

impl World {
    /// Queries of the present surfaces of the sheets that `filter` selects.
    pub fn queries(&self, filter: QueryFilter) -> SheetQueries<'_> {
        self.queries_at(filter, |_| None)
    }

    /// Queries as [`World::queries`], of sheets with other node positions than those of their
    /// state, as displayed ones. A sheet for which `positions` has none, or not one per node, is
    /// queried in its state. Velocities are always those of the state.
    pub fn queries_at<'w>(
        &'w self,
        filter: QueryFilter,
        positions: impl Fn(SheetId) -> Option<InterpolatedNodes<'w>>,
    ) -> SheetQueries<'w> {
        let new = |(id, sheet)| QuerySurface::new((id, sheet), filter.layer, positions(id));
        let surfaces = match filter.sheet {
            Some(only) => self.get_sheet(only).and_then(|sheet| new((only, sheet))).into_iter().collect(),
            None => self.sheet_ids().zip(self.sheets()).filter_map(new).collect(),
        };
        SheetQueries { surfaces }
    }
}

impl SheetQueries<'_> {
    /// First point of a surface on a ray, at most `max_distance` (m) from `origin` (m). `direction`
    /// has any length but 0. A triangle seen edge-on is not hit. No ray passes between two
    /// triangles with a common side (Woop, Benthin, Wald, *Watertight ray/triangle intersection*,
    /// 2013).
    pub fn cast_ray(&self, origin: DVec3, direction: DVec3, max_distance: f64) -> Option<SurfacePoint> {
        self.cast(&QueryRay::new(origin, direction, max_distance)?, 0.0, |ray, corners| ray.meet_triangle(corners))
    }

    /// All points of surfaces on a ray, nearest first, as [`SheetQueries::cast_ray`]. Replaces the
    /// contents of `hits`. A ray through a common side or corner of triangles hits once.
    pub fn cast_ray_all(&self, origin: DVec3, direction: DVec3, max_distance: f64, hits: &mut Vec<SurfacePoint>) {
        hits.clear();
        let Some(ray) = QueryRay::new(origin, direction, max_distance) else { return };
        for surface in &self.surfaces {
            let near = |bounds: &_| ray.meets_bounds(bounds, 0.0, max_distance);
            surface.visit_triangles(near, |nodes| {
                let hit = ray.meet_triangle(surface.corners(nodes)).filter(|(distance, _)| *distance <= max_distance);
                hits.extend(hit.map(|(distance, weights)| surface.point(nodes, weights, distance)));
            });
        }
        hits.sort_unstable_by(|a, b| {
            a.distance.total_cmp(&b.distance).then(a.sheet.cmp(&b.sheet)).then(a.nodes.cmp(&b.nodes))
        });
        let mut kept = 0;
        for next in 0..hits.len() {
            let hit = hits[next];
            let near = 1e-9 * (1.0 + hit.distance);
            let mut before = hits[..kept].iter().rev().take_while(|last| hit.distance - last.distance <= near);
            if !before.any(|last| hit.repeats(last)) {
                hits[kept] = hit;
                kept += 1;
            }
        }
        hits.truncate(kept);
    }

    /// First touch of a surface by a ball of `radius` (m, at least 0) whose centre moves from
    /// `origin` (m) along `direction` by at most `max_distance` (m). The result is the touched
    /// point; a ball that touches at its start has distance 0.
    pub fn cast_ball(&self, origin: DVec3, direction: DVec3, radius: f64, max_distance: f64) -> Option<SurfacePoint> {
        let ray = QueryRay::new(origin, direction, max_distance)?;
        let is_valid = radius.is_finite() && radius >= 0.0;
        is_valid.then(|| self.cast(&ray, radius, |ray, corners| ray.sweep_ball(radius, corners)))?
    }

    /// Nearest hit of a ray or of a ball that moves along it.
    fn cast(
        &self,
        ray: &QueryRay,
        radius: f64,
        meet: impl Fn(&QueryRay, [DVec3; 3]) -> Option<(f64, [f64; 3])>,
    ) -> Option<SurfacePoint> {
        let limit = Cell::new(ray.max_distance);
        let mut best: Option<SurfacePoint> = None;
        for surface in &self.surfaces {
            let mut found = None;
            surface.visit_triangles(
                |bounds| ray.meets_bounds(bounds, radius, limit.get()),
                |nodes| {
                    let Some((distance, weights)) = meet(ray, surface.corners(nodes)) else { return };
                    let is_first = best.is_none() && found.is_none();
                    if distance < limit.get() || (is_first && distance <= limit.get()) {
                        limit.set(distance);
                        found = Some((nodes, weights, distance));
                    }
                },
            );
            best = found.map(|(nodes, weights, distance)| surface.point(nodes, weights, distance)).or(best);
        }
        best
    }

    /// Closest point of the surfaces to `point` (m), at most `max_distance` (m) away; the infinite
    /// distance is allowed.
    pub fn closest_point(&self, point: DVec3, max_distance: f64) -> Option<SurfacePoint> {
        if !point.is_finite() || max_distance.is_nan() || max_distance < 0.0 {
            return None;
        }
        let limit = Cell::new(max_distance * max_distance);
        let mut best: Option<SurfacePoint> = None;
        for surface in &self.surfaces {
            let mut found = None;
            surface.visit_triangles(
                |bounds| surface::distance_squared(bounds, point) <= limit.get(),
                |nodes| {
                    let corners = surface.corners(nodes);
                    let weights = point_triangle(point, corners);
                    let squared = point.distance_squared(surface::combine(corners, weights));
                    let is_first = best.is_none() && found.is_none();
                    if squared < limit.get() || (is_first && squared <= limit.get()) {
                        limit.set(squared);
                        found = Some((nodes, weights, squared.sqrt()));
                    }
                },
            );
            best = found.map(|(nodes, weights, distance)| surface.point(nodes, weights, distance)).or(best);
        }
        best
    }

    /// Sheets whose surface meets `shape`, and nodes in it. Replaces the contents of `overlaps`.
    pub fn overlaps(&self, shape: &QueryShape, overlaps: &mut SurfaceOverlaps) {
        overlaps.sheets.clear();
        overlaps.nodes.clear();
        let Some(shape) = OverlapShape::new(shape) else { return };
        for surface in &self.surfaces {
            if !surface.bounds().overlaps(&shape.bounds) {
                continue;
            }
            let first = overlaps.nodes.len();
            let within = surface.nodes().filter(|i| shape.contains(surface.position(*i)));
            overlaps.nodes.extend(within.map(|i| (surface.id, i)));
            let mut meets = overlaps.nodes.len() > first;
            surface.visit_triangles(
                |bounds| bounds.overlaps(&shape.bounds),
                |nodes| meets = meets || shape.meets_triangle(surface.corners(nodes)),
            );
            if meets {
                overlaps.sheets.push(surface.id);
            }
        }
    }

    /// Surface of `sheet` at the material point (u, v), each 0 to 1; `None` outside the outline, in
    /// an open cell, beyond the zigzag edge of a triangular layer, and for another sheet than those
    /// of the filter.
    pub fn point_at(&self, sheet: SheetId, uv: (f64, f64)) -> Option<SurfacePoint> {
        let surface = self.surface(sheet)?;
        let (nodes, weights) = surface.locate(uv)?;
        Some(surface.point(nodes, weights, 0.0))
    }

    /// Curvature of `sheet` at the material point (u, v), each 0 to 1.
    ///
    /// The nodes up to two triangles around are fitted by least squares with a height
    /// z = a + b x + c y + (d x x + 2 e x y + f y y)/2 over their tangent plane at the point
    /// (Garimella and Swartz, *Curvature estimation for unstructured triangulations of surfaces*,
    /// 2003). The result is the shape operator of z at the point: exact where z is quadratic,
    /// otherwise of first order in the node spacing, of second order where the nodes lie
    /// symmetrically. A crease is smeared over two cells. `None` where [`SheetQueries::point_at`]
    /// has none, and where the nodes around do not define the fit, as in a strip of two rows.
    /// Allocates.
    pub fn curvature_at(&self, sheet: SheetId, uv: (f64, f64)) -> Option<SurfaceCurvature> {
        let surface = self.surface(sheet)?;
        let (nodes, weights) = surface.locate(uv)?;
        curvature::fit(surface, nodes, surface::combine(surface.corners(nodes), weights))
    }

    /// Area of `sheet`; `None` for another sheet than those of the filter.
    pub fn area(&self, sheet: SheetId) -> Option<SurfaceArea> {
        self.surface(sheet).map(QuerySurface::area)
    }

    fn surface(&self, sheet: SheetId) -> Option<&QuerySurface<'_>> {
        self.surfaces.iter().find(|surface| surface.id == sheet)
    }
}

impl SurfacePoint {
    /// Whether two hits of a ray at equal distances are one, on a common side or corner.
    fn repeats(&self, other: &Self) -> bool {
        let lies_on_side = |hit: &Self| hit.weights.contains(&0.0);
        let is_joined = self.nodes.iter().any(|i| other.nodes.contains(i));
        self.sheet == other.sheet && is_joined && lies_on_side(self) && lies_on_side(other)
    }
}
