//! Triangulation of a sheet: halved square cells wherever there is room, fitted to the boundary and
//! the cuts.
//!
//! The grid has `grid.0` by `grid.1` points over the outline's box. Nodes are its points at least
//! [`CLEARANCE`] cells from every boundary and cut, points about a cell apart along these, and a
//! row beside them (`inner_row`). A constrained Delaunay triangulation (Chew 1989; crate spade) of
//! all in units of cells contains the sides of the boundary and of the cuts; triangles outside are
//! removed. Whole cells are halved by parallel diagonals.

use std::collections::BTreeMap;

use glam::DVec2;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use crate::error::{InputError, reject_if};
use crate::mesh::outline::boundary_nodes::{self, BoundaryNodes};
use crate::mesh::outline::inner_row::{self, MIN_POINT_DISTANCE};
use crate::mesh::outline::line::CellScale;
use crate::mesh::outline::mesh::TriangleMesh;
use crate::mesh::outline::ring::distance;
use crate::mesh::outline::{Outline, metres, split};
use crate::units::parameters::ParameterId as Id;

/// Minimum distance of a grid point from boundaries and cuts, cells.
const CLEARANCE: f64 = 0.6;

/// Minimum quality of a triangle: 4√3 area over the sum of squared edges, in cells; 1 for an
/// equilateral one.
const MIN_QUALITY: f64 = 0.05;

/// Maximum ratio of a cell's sides. In free fall the elastic energy of a triangle of 0.1 m by 0.1
/// m/ratio is below 1e-11 J up to a ratio of 20, 0.2 µJ at 50, and 8 mJ at 200.
const MAX_CELL_RATIO: f64 = 20.0;

/// Point of the triangulation.
struct TriangulationPoint {
    at: Point2<f64>,
}

impl HasPosition for TriangulationPoint {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// Grid points that are nodes: index by column and row.
type Interior = BTreeMap<(u32, u32), u32>;

/// Triangle mesh of an outline. `grid` is the number of nodes along x and along z of its box, 2 to
/// 2000.
///
/// # Errors
/// When the grid is out of range or too coarse for the outline, or a cut lies outside.
pub fn mesh(outline: &Outline, grid: (u32, u32)) -> Result<TriangleMesh, InputError> {
    Id::GridLength.check("grid.0", grid.0.into())?;
    Id::GridWidth.check("grid.2", grid.1.into())?;
    let (low, high) = outline.bounds();
    let size = (high - low) / DVec2::new(f64::from(grid.0 - 1), f64::from(grid.1 - 1));
    let cells = CellScale { low, size };
    let ratio = size.max_element() / size.min_element();
    reject_if!(
        ratio > MAX_CELL_RATIO * (1.0 + 1e-9),
        "grid",
        "has cells of {} x {} m, a ratio of {ratio:.0}; beyond {MAX_CELL_RATIO} the triangles are too slender",
        metres(size.x),
        metres(size.y)
    );
    let mut nodes = boundary_nodes::place(outline, &cells)?;
    let interior = grid_points(&mut nodes, grid);
    let mut triangles = triangulate(&nodes, &cells)?;
    align_diagonals(&mut triangles, &nodes, &interior);
    check_quality(&nodes, &triangles, &cells)?;
    let positions = nodes.points.iter().map(|p| cells.metres(*p)).collect();
    let rows = nodes.points.iter().map(|p| p.y.round() as i64).collect();
    split::finish(positions, rows, triangles, &nodes.slits)
}

/// Add the points of the grid that are clear of boundaries and cuts, inside or out.
fn grid_points(nodes: &mut BoundaryNodes, grid: (u32, u32)) -> Interior {
    let mut taken = vec![false; (grid.0 * grid.1) as usize];
    for [a, b] in nodes.sides.iter().chain(&nodes.slits) {
        let (a, b) = (nodes.points[*a as usize], nodes.points[*b as usize]);
        let low = (a.min(b) - CLEARANCE).ceil().max(DVec2::ZERO);
        let high = (a.max(b) + CLEARANCE).floor();
        for j in low.y as u32..=(high.y.max(0.0) as u32).min(grid.1 - 1) {
            for i in low.x as u32..=(high.x.max(0.0) as u32).min(grid.0 - 1) {
                if distance(DVec2::new(i.into(), j.into()), a, b) < CLEARANCE {
                    taken[(j * grid.0 + i) as usize] = true;
                }
            }
        }
    }
    let (row, bins) = inner_row::points(nodes);
    nodes.points.extend(row);
    let mut interior = Interior::new();
    for j in 0..grid.1 {
        for i in (0..grid.0).filter(|i| !taken[(j * grid.0 + i) as usize]) {
            let p = DVec2::new(i.into(), j.into());
            if bins.near(p, MIN_POINT_DISTANCE) && !bins.near(p, 1e-6) {
                continue;
            }
            interior.insert((i, j), nodes.points.len() as u32);
            nodes.points.push(p);
        }
    }
    interior
}

/// Triangles inside the boundary, counter-clockwise in (x, z).
fn triangulate(nodes: &BoundaryNodes, cells: &CellScale) -> Result<Vec<[u32; 3]>, InputError> {
    let vertices = nodes.points.iter().map(|p| TriangulationPoint { at: Point2::new(p.x, p.y) }).collect();
    let kept = nodes.sides.iter().chain(&nodes.slits).map(|s| s.map(|i| i as usize)).collect();
    let mut conflict = None;
    let made = ConstrainedDelaunayTriangulation::<TriangulationPoint>::try_bulk_load_cdt(vertices, kept, |side| {
        conflict.get_or_insert(side);
    });
    let made = made.map_err(|e| InputError::new("outline", format!("cannot be triangulated: {e}")))?;
    if let Some([a, b]) = conflict {
        let (p, q) = (nodes.points[a], nodes.points[b]);
        let size = cells.distance(p, q);
        let field =
            nodes.fields.get(nodes.from[a.min(nodes.from.len() - 1)] as usize).map_or("outline", |f| f.as_str());
        return Err(cells.too_small(field, "crosses itself or another within", size, p.midpoint(q)));
    }
    let merged = made.num_vertices() != nodes.points.len();
    reject_if!(merged, "outline", "has points of the grid that fall together; use another grid");
    Ok(inside(&made, nodes))
}

/// Faces that an odd number of boundaries separates from the outside.
fn inside(made: &ConstrainedDelaunayTriangulation<TriangulationPoint>, nodes: &BoundaryNodes) -> Vec<[u32; 3]> {
    let key = |a: u32, b: u32| (a.min(b), a.max(b));
    let boundary: std::collections::BTreeSet<(u32, u32)> = nodes.sides.iter().map(|s| key(s[0], s[1])).collect();
    let mut is_inside: Vec<Option<bool>> = vec![None; made.num_all_faces()];
    let outer = made.outer_face().fix().index();
    is_inside[outer] = Some(false);
    // From the hull inwards, then from face to face; crossing a boundary changes the side.
    let mut open: Vec<_> = made.convex_hull().map(|e| e.rev().fix()).collect();
    open.extend(made.convex_hull().map(|e| e.fix()));
    while let Some(edge) = open.pop() {
        let edge = made.directed_edge(edge);
        let (from, to) = (edge.face().fix().index(), edge.rev().face().fix().index());
        let Some(side) = is_inside[from].filter(|_| is_inside[to].is_none()) else { continue };
        let (a, b) = (edge.from().fix().index() as u32, edge.to().fix().index() as u32);
        is_inside[to] = Some(side != boundary.contains(&key(a, b)));
        if let Some(face) = edge.rev().face().as_inner() {
            open.extend(face.adjacent_edges().map(|e| e.fix()));
        }
    }
    let mut triangles = Vec::new();
    for face in made.inner_faces() {
        if is_inside[face.fix().index()] == Some(true) {
            triangles.push(face.vertices().map(|v| v.fix().index() as u32));
        }
    }
    triangles
}

/// Use the same diagonal in all whole cells of the grid, so that every node has the same
/// neighbours.
fn align_diagonals(triangles: &mut Vec<[u32; 3]>, nodes: &BoundaryNodes, interior: &Interior) {
    let first = interior.values().next().copied().unwrap_or(u32::MAX);
    let mut halves: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let cell = |t: &[u32; 3]| -> Option<(u32, u32)> {
        if t.iter().any(|v| *v < first) {
            return None;
        }
        let p = t.map(|v| nodes.points[v as usize]);
        let (low, high) = crate::mesh::outline::bounds(&p);
        (high - low == DVec2::ONE).then_some((low.x as u32, low.y as u32))
    };
    for t in triangles.iter() {
        if let Some(c) = cell(t) {
            *halves.entry(c).or_default() += 1;
        }
    }
    triangles.retain(|t| cell(t).is_none_or(|c| halves.get(&c) != Some(&2)));
    for ((i, j), _) in halves.iter().filter(|h| *h.1 == 2) {
        let corner = |di: u32, dj: u32| interior.get(&(i + di, j + dj)).copied();
        if let (Some(a), Some(b), Some(c), Some(d)) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)) {
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
}

/// Quality of a triangle: 4√3 area over the sum of squared edges.
pub fn quality([a, b, c]: [DVec2; 3]) -> f64 {
    let edges = (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
    2.0 * 3.0_f64.sqrt() * (b - a).perp_dot(c - a) / edges
}

fn check_quality(nodes: &BoundaryNodes, triangles: &[[u32; 3]], cells: &CellScale) -> Result<(), InputError> {
    reject_if!(triangles.is_empty(), "outline", "has no triangle inside; use a finer grid");
    for t in triangles {
        let p = t.map(|v| nodes.points[v as usize]);
        if quality(p) < MIN_QUALITY {
            let real = p.map(|p| cells.metres(p));
            let longest = (0..3).map(|i| real[i].distance(real[(i + 1) % 3])).fold(0.0, f64::max);
            let height = (real[1] - real[0]).perp_dot(real[2] - real[0]).abs() / longest;
            let owner = t.iter().find_map(|v| nodes.from.get(*v as usize));
            let field = owner.and_then(|f| nodes.fields.get(*f as usize)).map_or("outline", |f| f.as_str());
            return Err(cells.too_small(field, "leaves a sliver of", height, p[0]));
        }
    }
    Ok(())
}
