//! Triangles as the cells of a sheet that can open.
//!
//! Positions in the sheet are (u, v) of the mesh, m. A point is in a triangle if its smallest
//! weight is not below -`LOCATION_TOLERANCE`. With the rest positions of the corners 0, 1 and 2
//! as columns of M = [p₁ - p₀, p₂ - p₀], the derivatives of the present position x along u
//! and v are [a, b] = [x₁ - x₀, x₂ - x₀] M⁻¹.
//!
//! The slope of an inner edge follows from a patch of nodes around it
//! (`triangle_bending::slope`). It is free, as at a boundary, when a triangle of the edge is open,
//! or when closed triangles no longer join a node of the patch to the edge within as many rings of
//! neighbours as the patch has: the nodes beyond a crack do not bend this side of it.

use std::sync::Arc;

use glam::DVec3;

use crate::elements::triangle_bending::{bend_across, slope};
use crate::mesh::outline::TriangleMesh;
use crate::mesh::outline::locate::TriangleIndex;

/// Magnitude of a negative weight with which a point is still in a triangle: rounding.
const LOCATION_TOLERANCE: f64 = 1e-9;
/// Rings of triangles around an open one in which slopes can become free: those of the largest
/// patch.
const AFFECTED_RINGS: usize = slope::MAXIMUM_RINGS + 1;

/// Cells of a triangle mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleCells {
    mesh: Arc<TriangleMesh>,
    index: TriangleIndex,
    /// Corners of the bounding box, m.
    low: [f64; 2],
    high: [f64; 2],
    /// Square root of twice the mean area, m.
    side: f64,
    /// M⁻¹ of each triangle, row by row, 1/m.
    inverse: Vec<[f64; 4]>,
    /// First triangle of each node in `list`, and the end.
    first: Vec<u32>,
    list: Vec<u32>,
    /// Whether the slope of each edge is free; empty for a mesh without slopes.
    free: Vec<bool>,
    /// Open cells that `free` belongs to.
    open: Vec<bool>,
}

impl TriangleCells {
    /// Cells of `mesh`. `has_slopes` says whether the edges have slopes, as in a shell.
    pub fn new(mesh: Arc<TriangleMesh>, has_slopes: bool) -> Self {
        let (low, high) = mesh.bounds();
        let mut around = vec![Vec::new(); mesh.positions.len()];
        for (k, t) in mesh.triangles.iter().enumerate() {
            t.iter().for_each(|v| around[*v as usize].push(k as u32));
        }
        let mut first = vec![0];
        for list in &around {
            first.push(first[first.len() - 1] + list.len() as u32);
        }
        let inverse = (0..mesh.triangles.len()).map(|k| {
            let [p, q, r] = mesh.triangles[k].map(|v| mesh.positions[v as usize]);
            let ([a, c], [b, d]) = ([q[0] - p[0], q[1] - p[1]], [r[0] - p[0], r[1] - p[1]]);
            [d, -b, -c, a].map(|m| m / (a * d - b * c))
        });
        Self {
            index: TriangleIndex::new(&mesh),
            low,
            high,
            side: (2.0 * mesh.total_area() / mesh.triangles.len().max(1) as f64).sqrt(),
            inverse: inverse.collect(),
            first,
            list: around.concat(),
            free: if has_slopes { vec![false; mesh.edges.len()] } else { Vec::new() },
            open: vec![false; mesh.triangles.len()],
            mesh,
        }
    }

    /// The mesh.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// Size of a cell: square root of twice the mean area, m.
    pub fn side(&self) -> f64 {
        self.side
    }

    /// Place (m) of material coordinates (u, v), 0 to 1.
    pub fn place(&self, (u, v): (f64, f64)) -> (f64, f64) {
        let at = |a: usize, part: f64| self.low[a] + part * (self.high[a] - self.low[a]);
        (at(0, u), at(1, v))
    }

    /// Triangles around node `v`, in ascending order; none for a node of another layer.
    pub fn around(&self, v: u32) -> &[u32] {
        let v = v as usize;
        if v + 1 < self.first.len() { &self.list[self.first[v] as usize..self.first[v + 1] as usize] } else { &[] }
    }

    /// Triangles that contain `p` (m), those that touch it included.
    pub fn at(&self, p: (f64, f64)) -> impl Iterator<Item = usize> {
        let p = [p.0, p.1];
        let inside = move |k: &u32| self.mesh.weights(*k, p).iter().all(|w| *w >= -LOCATION_TOLERANCE);
        self.index.near(p).iter().copied().filter(inside).map(|k| k as usize)
    }

    /// Derivatives of the position along u and v over triangle `k` with its corners at `x` (m).
    #[inline]
    pub fn derivatives(&self, k: usize, x: [DVec3; 3]) -> (DVec3, DVec3) {
        let [a, b, c, d] = self.inverse[k];
        let (p, q) = (x[1] - x[0], x[2] - x[0]);
        (p * a + q * c, p * b + q * d)
    }

    /// Directions of curvature (uu, vv, 2uv) of triangle `k` across its edges with free slopes.
    pub fn freed_directions(&self, k: usize) -> impl Iterator<Item = [f64; 3]> {
        let freed = self.mesh.triangle_edges[k].into_iter().filter(|e| self.free.get(*e as usize) == Some(&true));
        freed.map(|e| bend_across(self.mesh.direction(&self.mesh.edges[e as usize]).1))
    }

    /// Find the free slopes beside the open cells `open`.
    pub fn update_slopes(&mut self, open: &[bool]) {
        if self.free.is_empty() || self.open == open {
            return;
        }
        if self.open.iter().zip(open).any(|(was, is)| *was && !is) {
            self.free.fill(false);
            self.open.fill(false);
        }
        // Slopes become free near the cells that have opened since; no free slope is bound again.
        let new: Vec<bool> = open.iter().zip(&self.open).map(|(is, was)| *is && !was).collect();
        let near = self.grown(new, AFFECTED_RINGS);
        self.open.copy_from_slice(open);
        let mesh = self.mesh.clone();
        for (e, edge) in mesh.edges.iter().enumerate() {
            let [first, second] = edge.triangles.map(|k| k as usize);
            if edge.is_boundary() || self.free[e] || !(near[first] || near[second]) {
                continue;
            }
            self.free[e] = open[first] || open[second] || !self.is_joined(e, open);
        }
    }

    /// Whether closed triangles join edge `e` to all nodes of its patch.
    fn is_joined(&self, e: usize, open: &[bool]) -> bool {
        let edge = &self.mesh.edges[e];
        let (nodes, rings) = slope::patch_nodes(&self.mesh, edge);
        let mut joined: Vec<u32> = edge.triangles.iter().flat_map(|k| self.mesh.triangles[*k as usize]).collect();
        let mut begin = 0;
        for _ in 0..rings {
            let end = joined.len();
            for i in begin..end {
                for k in self.around(joined[i]).iter().filter(|k| !open[**k as usize]) {
                    for v in self.mesh.triangles[*k as usize] {
                        if !joined.contains(&v) {
                            joined.push(v);
                        }
                    }
                }
            }
            begin = end;
        }
        nodes.iter().all(|v| joined.contains(v))
    }

    /// `cells` and `rings` rings of the cells around them.
    fn grown(&self, mut cells: Vec<bool>, rings: usize) -> Vec<bool> {
        for _ in 0..rings {
            let mut nodes = vec![false; self.mesh.positions.len()];
            for (t, _) in self.mesh.triangles.iter().zip(&cells).filter(|(_, is_in)| **is_in) {
                t.iter().for_each(|v| nodes[*v as usize] = true);
            }
            for (cell, t) in cells.iter_mut().zip(&self.mesh.triangles) {
                *cell |= t.iter().any(|v| nodes[*v as usize]);
            }
        }
        cells
    }
}
