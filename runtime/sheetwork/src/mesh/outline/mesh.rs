//! Triangle mesh in the plane of the sheet, with the topology and geometry for elements.
//!
//! Coordinates are (u, v) = (x, z) of the sheet at rest, m. Triangles run counter-clockwise in (u,
//! v). An edge runs from `a` to `b` in the sense of its first triangle, so that this is on its left
//! and the normal (t_v, -t_u) of its direction t points out of it.

use std::collections::BTreeMap;

use crate::error::InputError;

/// Marker of a missing second triangle at an edge of the boundary.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Edge of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshEdge {
    /// Start and end.
    pub nodes: [u32; 2],
    /// Triangle on the left, and the one on the right or [`NO_TRIANGLE`].
    pub triangles: [u32; 2],
}

impl MeshEdge {
    /// Whether the edge is on the boundary, the rim of a hole or a cut.
    pub fn is_boundary(&self) -> bool {
        self.triangles[1] == NO_TRIANGLE
    }
}

/// Plane triangle mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Nodes (u, v) at rest, m; those along cuts twice.
    pub positions: Vec<[f64; 2]>,
    /// Nodes of each triangle, counter-clockwise in (u, v), all of positive area.
    pub triangles: Vec<[u32; 3]>,
    /// Every edge once.
    pub edges: Vec<MeshEdge>,
    /// Edges of each triangle; edge c joins its corners c and c + 1.
    pub triangle_edges: Vec<[u32; 3]>,
    /// Area of each triangle, m².
    pub areas: Vec<f64>,
    /// Area of each node, a third of each of its triangles, m².
    pub lumped: Vec<f64>,
    /// Whether each node is on the boundary, the rim of a hole or a cut.
    pub border: Vec<bool>,
}

impl TriangleMesh {
    /// Mesh of nodes and triangles.
    ///
    /// # Errors
    /// When a triangle has an unknown node or no positive area, or an edge has three triangles or
    /// two with the same sense.
    pub fn new(positions: Vec<[f64; 2]>, triangles: Vec<[u32; 3]>) -> Result<Self, InputError> {
        let mut mesh =
            Self { lumped: vec![0.0; positions.len()], border: vec![false; positions.len()], ..Self::default() };
        mesh.positions = positions;
        let mut seen: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        for (k, t) in triangles.iter().enumerate() {
            let fault = |problem: &str| InputError::new(format!("triangles.{k}"), problem);
            if t.iter().any(|v| *v as usize >= mesh.positions.len()) {
                return Err(fault("names a mass that is not there"));
            }
            let area = mesh.area(*t);
            // The comparison rejects NaN too.
            if !(area > 0.0 && area.is_finite()) {
                return Err(fault("has no positive area"));
            }
            mesh.areas.push(area);
            t.iter().for_each(|v| mesh.lumped[*v as usize] += area / 3.0);
            let mut edges = [0; 3];
            for c in 0..3 {
                let (a, b) = (t[c], t[(c + 1) % 3]);
                edges[c] = *seen.entry((a.min(b), a.max(b))).or_insert(mesh.edges.len() as u32);
                match mesh.edges.get_mut(edges[c] as usize) {
                    None => mesh.edges.push(MeshEdge { nodes: [a, b], triangles: [k as u32, NO_TRIANGLE] }),
                    Some(edge) if edge.is_boundary() && edge.nodes == [b, a] => edge.triangles[1] = k as u32,
                    Some(_) => return Err(fault("has an edge that its neighbours do not fit")),
                }
            }
            mesh.triangle_edges.push(edges);
        }
        for edge in mesh.edges.iter().filter(|e| e.is_boundary()) {
            edge.nodes.iter().for_each(|v| mesh.border[*v as usize] = true);
        }
        mesh.triangles = triangles;
        Ok(mesh)
    }

    fn area(&self, t: [u32; 3]) -> f64 {
        let [a, b, c] = t.map(|v| self.positions[v as usize]);
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
    }

    /// Corners of the bounding box, m.
    pub fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (p, a) in self.positions.iter().flat_map(|p| [(p, 0), (p, 1)]) {
            (low[a], high[a]) = (low[a].min(p[a]), high[a].max(p[a]));
        }
        (low, high)
    }

    /// Weights of the corners of triangle `k` at `p` (m).
    pub fn weights(&self, k: u32, p: [f64; 2]) -> [f64; 3] {
        let [a, b, c] = self.triangles[k as usize].map(|v| self.positions[v as usize]);
        let twice =
            |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        let whole = twice(a, b, c);
        let (s, t) = (twice(p, b, c) / whole, twice(a, p, c) / whole);
        [s, t, 1.0 - s - t]
    }

    /// Neighbours of each node by edges.
    pub fn neighbours(&self) -> Vec<Vec<u32>> {
        let mut all = vec![Vec::new(); self.positions.len()];
        for [a, b] in self.edges.iter().map(|e| e.nodes) {
            all[a as usize].push(b);
            all[b as usize].push(a);
        }
        all
    }

    /// Middle of triangle `k`, m.
    pub fn middle_of(&self, k: usize) -> [f64; 2] {
        let [a, b, c] = self.triangles[k].map(|v| self.positions[v as usize]);
        [(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0]
    }

    /// Total area, m².
    pub fn total_area(&self) -> f64 {
        self.areas.iter().sum()
    }

    /// Middle of an edge, m.
    pub fn middle(&self, edge: &MeshEdge) -> [f64; 2] {
        let [a, b] = edge.nodes.map(|v| self.positions[v as usize]);
        [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
    }

    /// Length (m) and unit direction of an edge.
    pub fn direction(&self, edge: &MeshEdge) -> (f64, [f64; 2]) {
        let [a, b] = edge.nodes.map(|v| self.positions[v as usize]);
        let (du, dv) = (b[0] - a[0], b[1] - a[1]);
        let length = du.hypot(dv);
        (length, [du / length, dv / length])
    }
}
