//! Collision surface of a sheet: triangles between nodes, their edges, and the contact offset.
//!
//! A single layer with the stiffness of its material touches at half its thickness on each side,
//! other lattices at the minimum contact offset from their lowest and highest layers. The triangles
//! equal those of the rendered mesh: in a twisted cell the other diagonal defines another surface,
//! millimetres away on coarse grids. Contacts do not depend on the numbering of the triangles:
//! every edge and every node is owned by one triangle, so that each pair of features is tested once
//! among all pairs of triangles (Curtis, Tamstorf, Manocha, Fast collision detection for deformable
//! models using representative-triangles, 2008). Lengths in m.

use glam::DVec3;

use crate::math::Vectors;
use crate::sheet::{Sheet, node_contact};

/// Index that stands for no triangle and no feature.
pub const NONE: u32 = u32::MAX;

/// An edge of a collision surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceEdge {
    /// Nodes, the lower index first.
    pub nodes: [u32; 2],
    /// Adjacent triangles; the second is [`NONE`] on the border.
    pub triangles: [u32; 2],
}

impl SurfaceEdge {
    /// Whether the edge lies on the border of the surface.
    pub fn is_border(&self) -> bool {
        self.triangles[1] == NONE
    }
}

/// A triangle with its edges and the features that it owns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceTriangle {
    /// Nodes, counter-clockwise seen from the upper side.
    pub nodes: [u32; 3],
    /// Edges, beginning with that from the first node to the second.
    pub edges: [u32; 3],
    /// Whether each of the nodes is owned by this triangle.
    pub owns_node: [bool; 3],
    /// Whether each of the edges is owned by this triangle.
    pub owns_edge: [bool; 3],
    /// Longest side at rest, m.
    pub size: f64,
}

/// Collision surface of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct CollisionSurface {
    triangles: Vec<SurfaceTriangle>,
    edges: Vec<SurfaceEdge>,
    rest: Vec<DVec3>,
    border: Vec<bool>,
    offset: f64,
    half_thickness: f64,
    rectangle: bool,
    is_multilayer: bool,
    /// Whether each node is detached and has no contact; empty if no cell is open.
    detached: Vec<bool>,
    /// Number of changes of the triangles.
    revision: u64,
    make: u32,
}

impl CollisionSurface {
    /// Collision surface of a sheet in its present state, which is taken as its rest state.
    pub fn from_sheet(sheet: &Sheet) -> Self {
        let offset = node_contact::contact_offset(sheet);
        let mut skin = Self::new(&outer_triangles(sheet), &sheet.state.x, offset, is_rectangle(sheet));
        skin.is_multilayer = sheet.model.layers.len() > 1;
        skin.half_thickness = node_contact::half_thickness(sheet);
        skin.update_detached(sheet);
        skin
    }

    /// Rebuild the surface without the open cells of its sheet.
    pub fn rebuild_open(&mut self, sheet: &Sheet) {
        let mut rest = Vectors::default();
        self.rest.iter().for_each(|p| rest.push(*p));
        let (stack, revision) = (self.is_multilayer, self.revision + 1);
        *self = Self {
            is_multilayer: stack,
            half_thickness: self.half_thickness,
            revision,
            ..Self::new(&outer_triangles(sheet), &rest, self.offset, is_rectangle(sheet))
        };
        self.update_detached(sheet);
    }

    /// Take over the thickness, which may change while the sheet moves.
    pub fn set_thickness(&mut self, sheet: &Sheet) {
        self.offset = node_contact::contact_offset(sheet);
        self.half_thickness = node_contact::half_thickness(sheet);
    }

    fn update_detached(&mut self, sheet: &Sheet) {
        if sheet.open_cell_set().is_some() {
            self.detached = (0..sheet.node_count()).map(|i| sheet.is_detached(i)).collect();
        }
    }

    /// Whether node `i` is detached (has no closed cell) and has no contact.
    #[inline]
    pub fn is_detached(&self, i: usize) -> bool {
        self.detached.get(i).is_some_and(|gone| *gone)
    }

    /// Checksum of the rest positions and the contact offset.
    pub(crate) fn checksum(&self) -> u32 {
        self.make
    }

    /// Number of changes of the triangles.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Surface from triangles over nodes with the rest positions `rest` (m) and the contact offset
    /// `offset` (m, at least 0). `rectangle` states that the surface is one rectangle. Triangles
    /// with an index out of range are omitted.
    pub fn new(triangles: &[[u32; 3]], rest: &Vectors, offset: f64, rectangle: bool) -> Self {
        let count = rest.len() as u32;
        let triangles: Vec<[u32; 3]> = triangles.iter().copied().filter(|t| t.iter().all(|i| *i < count)).collect();
        let (edges, of_triangle) = edges_of(&triangles);
        let mut border = vec![false; rest.len()];
        for edge in edges.iter().filter(|e| e.is_border()) {
            edge.nodes.iter().for_each(|i| border[*i as usize] = true);
        }
        let rest: Vec<DVec3> = rest.iter().collect();
        let mut mass_taken = vec![false; rest.len()];
        let mut edge_taken = vec![false; edges.len()];
        let triangles = triangles.into_iter().zip(of_triangle).map(|(masses, edges)| SurfaceTriangle {
            nodes: masses,
            edges,
            owns_node: masses.map(|i| !std::mem::replace(&mut mass_taken[i as usize], true)),
            owns_edge: edges.map(|e| !std::mem::replace(&mut edge_taken[e as usize], true)),
            size: longest_side(masses.map(|i| rest[i as usize])),
        });
        let triangles = triangles.collect();
        let make = checksum_of(&rest, offset);
        Self {
            triangles,
            edges,
            border,
            offset,
            half_thickness: offset,
            rectangle,
            rest,
            is_multilayer: false,
            detached: Vec::new(),
            revision: 0,
            make,
        }
    }

    /// Triangles.
    pub fn triangles(&self) -> &[SurfaceTriangle] {
        &self.triangles
    }

    /// Edges, each once.
    pub fn edges(&self) -> &[SurfaceEdge] {
        &self.edges
    }

    /// Number of nodes of the sheet.
    pub fn node_count(&self) -> usize {
        self.rest.len()
    }

    /// Whether node `i` lies on the border; false for an index out of range.
    pub fn on_border(&self, i: u32) -> bool {
        self.border.get(i as usize).copied().unwrap_or(false)
    }

    /// Contact offset: distance from the triangles at which the surface touches, m.
    pub fn contact_offset(&self) -> f64 {
        self.offset
    }

    /// Length to which tolerances refer, m: half the thickness.
    pub fn half_thickness(&self) -> f64 {
        self.half_thickness
    }

    /// Whether the surface is one rectangle of one layer.
    pub fn is_rectangle(&self) -> bool {
        self.rectangle
    }

    /// Whether the surface consists of the outer layers of a lattice with several layers.
    pub fn is_multilayer(&self) -> bool {
        self.is_multilayer
    }

    /// Centroid of a triangle at rest, m.
    pub(crate) fn middle(&self, triangle: &SurfaceTriangle) -> DVec3 {
        triangle.nodes.iter().map(|i| self.rest[*i as usize]).sum::<DVec3>() / 3.0
    }

    /// Least height of a triangle at rest, m; infinite without triangles.
    pub(crate) fn least_height(&self) -> f64 {
        let heights = self.triangles.iter().map(|t| {
            let [a, b, c] = t.nodes.map(|i| self.rest[i as usize]);
            (b - a).cross(c - a).length() / t.size
        });
        heights.fold(f64::INFINITY, f64::min)
    }

    /// Distance of two nodes at rest, m; 0 for an index out of range.
    #[inline]
    pub fn rest_distance(&self, i: u32, j: u32) -> f64 {
        match (self.rest.get(i as usize), self.rest.get(j as usize)) {
            (Some(a), Some(b)) => a.distance(*b),
            _ => 0.0,
        }
    }

    /// Whether any two of these nodes are one, or nearer at rest than `reach` (m).
    pub fn is_rest_distance_below(&self, p: &[u32], q: &[u32], reach: f64) -> bool {
        p.iter().any(|i| q.iter().any(|j| i == j || self.rest_distance(*i, *j) < reach))
    }

    /// Whether two triangles are nearer at rest than the longest of their sides and `thickness`
    /// (m): they bend into each other's way without contact.
    pub fn are_neighbours(&self, p: &[u32; 3], q: &[u32; 3], thickness: f64) -> bool {
        let side = |t: &[u32; 3]| {
            let [a, b, c] = *t;
            self.rest_distance(a, b).max(self.rest_distance(b, c)).max(self.rest_distance(c, a))
        };
        let is_shared = p.iter().any(|i| q.contains(i));
        is_shared || self.is_rest_distance_below(p, q, thickness + side(p).max(side(q)))
    }
}

fn checksum_of(rest: &[DVec3], offset: f64) -> u32 {
    let mut sum = crc32fast::Hasher::new();
    let numbers = rest.iter().flat_map(|p| p.to_array()).chain([offset]);
    numbers.for_each(|v| sum.update(&v.to_le_bytes()));
    sum.finalize()
}

/// Triangles of closed cells of the lowest and the highest layer.
pub(crate) fn outer_triangles(sheet: &Sheet) -> Vec<[u32; 3]> {
    let count = sheet.model.layers.len();
    (0..count).filter(|i| *i == 0 || *i + 1 == count).flat_map(|i| sheet.cells().layer_triangles(i)).collect()
}

/// Whether the surface is a single rectangle.
fn is_rectangle(sheet: &Sheet) -> bool {
    sheet.model.triangles.is_none() && sheet.model.layers.len() == 1 && sheet.open_cell_set().is_none()
}

/// Sides of `triangles`, each once, and the indices of the sides of each triangle.
fn edges_of(triangles: &[[u32; 3]]) -> (Vec<SurfaceEdge>, Vec<[u32; 3]>) {
    let mut sides: Vec<([u32; 2], usize, usize)> = Vec::with_capacity(3 * triangles.len());
    for (t, m) in triangles.iter().enumerate() {
        for side in 0..3 {
            let (a, b) = (m[side], m[(side + 1) % 3]);
            sides.push(([a.min(b), a.max(b)], t, side));
        }
    }
    sides.sort_unstable();
    let mut edges: Vec<SurfaceEdge> = Vec::with_capacity(sides.len() / 2);
    let mut of_triangle = vec![[NONE; 3]; triangles.len()];
    for (masses, t, side) in sides {
        match edges.last_mut() {
            // A third triangle at one edge replaces the second, since the surface is not a manifold
            // there.
            Some(last) if last.nodes == masses => last.triangles[1] = t as u32,
            _ => edges.push(SurfaceEdge { nodes: masses, triangles: [t as u32, NONE] }),
        }
        of_triangle[t][side] = edges.len() as u32 - 1;
    }
    (edges, of_triangle)
}

fn longest_side([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::structure::LatticeLayer;

    fn grid(nx: u32, nz: u32) -> CollisionSurface {
        let layer = LatticeLayer { first: 0, nx, nz, triangular: false, tubular: false };
        let mut rest = Vectors::default();
        for j in 0..nz {
            (0..nx).for_each(|i| rest.push(DVec3::new(f64::from(i), 0.0, f64::from(j))));
        }
        CollisionSurface::new(&layer.triangles(), &rest, 0.1, true)
    }

    #[test]
    fn a_grid_has_eulers_number_of_edges_and_every_feature_has_one_owner() {
        let skin = grid(5, 4);
        let (v, f) = (20, skin.triangles().len());
        assert_eq!(f, 24);
        // v - e + f = 1 for a disc.
        assert_eq!(skin.edges().len(), v + f - 1);
        assert_eq!(skin.edges().iter().filter(|e| e.is_border()).count(), 2 * (4 + 3));
        let owned = |f: fn(&SurfaceTriangle) -> [bool; 3]| -> usize {
            skin.triangles().iter().map(|t| f(t).iter().filter(|o| **o).count()).sum()
        };
        assert_eq!(owned(|t| t.owns_node), v);
        assert_eq!(owned(|t| t.owns_edge), skin.edges().len());
        assert!(skin.on_border(0) && !skin.on_border(6) && !skin.on_border(1000));
        for t in skin.triangles() {
            for side in 0..3 {
                let edge = skin.edges()[t.edges[side] as usize];
                assert!(edge.nodes.contains(&t.nodes[side]) && edge.nodes.contains(&t.nodes[(side + 1) % 3]));
            }
            assert_eq!(t.size, 2.0_f64.sqrt());
        }
    }

    #[test]
    fn triangles_wind_alike_and_those_of_no_mass_are_left_out() {
        let skin = grid(4, 4);
        for t in skin.triangles() {
            let [a, b, c] = t.nodes.map(|i| skin.rest[i as usize]);
            assert!((b - a).cross(c - a).y > 0.0);
        }
        let one = CollisionSurface::new(&[[0, 1, 2], [0, 1, 9]], &Vectors::zeros(3), 0.0, false);
        assert_eq!(one.triangles().len(), 1);
    }
}
