//! Bending curvatures of a triangle mesh, without rotational degrees of freedom.
//!
//! The curvature of a triangle of area A is constant and follows from the slopes of its edges
//! (Morley triangle). With length l, direction t and outward normal n of an edge from a to b, and
//! the slope φ = x_n at its middle,
//!
//! κ = 1/A Σ_e [l φ n⊗n + sym(n⊗t) (x_b - x_a)].
//!
//! Slopes are not unknowns. An edge between two triangles has one slope, reconstructed from nearby
//! nodes (`slope`); a clamped edge has a prescribed slope; any other boundary edge has the slope of
//! least energy, which [`CurvatureGroup::relaxed`] leaves to the bending element. Constant
//! curvatures are exact on any mesh.
//!
//! Beside a clamp slopes are one-sided, which loses one order of accuracy. Two area factors restore
//! it: one for triangles with a clamped edge, one for triangles that touch a clamped edge with a
//! corner. A one-parameter family of pairs gives second-order convergence of a cantilever's first
//! frequency; this pair is also accurate for clamped plates, whose moments change quickly at the
//! clamp.

pub(crate) mod slope;
pub(crate) mod symmetric;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use crate::elements::curvature::CurvatureGroup;
use crate::elements::staggered::ClosedPart;
use crate::elements::triangle_cells::TriangleCells;
use crate::mesh::outline::{MeshEdge, TriangleMesh};

/// Area factor of a triangle with a clamped edge.
const CLAMPED_EDGE_AREA_FACTOR: f64 = 7.0 / 5.0;
/// Area factor of a triangle that touches a clamped edge with a corner only.
const CLAMPED_CORNER_AREA_FACTOR: f64 = 3.0 / 4.0;
/// Weight below which a term is rounding, in units of 1/area.
const WEIGHT_TOLERANCE: f64 = 1e-12;

/// One group per triangle of `mesh`, in their order, and the outward unit normals (u, v) of the
/// clamped edges, to which [`CurvatureGroup::clamps`] refers. Only boundary edges can be clamped.
pub fn triangle_curvatures(
    mesh: &TriangleMesh,
    clamped: &dyn Fn(&MeshEdge) -> bool,
) -> (Vec<CurvatureGroup>, Vec<[f64; 2]>) {
    let mut clamp_of: BTreeMap<u32, u32> = BTreeMap::new();
    let mut directions = Vec::new();
    let mut clamped_nodes = BTreeSet::new();
    for (e, edge) in mesh.edges.iter().enumerate() {
        if edge.is_boundary() && clamped(edge) {
            let (_, t) = mesh.direction(edge);
            clamp_of.insert(e as u32, directions.len() as u32);
            directions.push([t[1], -t[0]]);
            clamped_nodes.extend(edge.nodes);
        }
    }
    let slopes = slope::slopes(mesh);
    let groups = (0..mesh.triangles.len())
        .map(|k| {
            let mut group = curvature(mesh, k, &slopes, &clamp_of);
            if mesh.triangle_edges[k].iter().any(|e| clamp_of.contains_key(e)) {
                group.area *= CLAMPED_EDGE_AREA_FACTOR;
            } else if mesh.triangles[k].iter().any(|v| clamped_nodes.contains(v)) {
                group.area *= CLAMPED_CORNER_AREA_FACTOR;
            }
            group
        })
        .collect();
    (groups, directions)
}

/// Direction of curvature (uu, vv, 2uv) that the slope of an edge along the unit vector `t`
/// changes.
pub(crate) fn bend_across(t: [f64; 2]) -> [f64; 3] {
    let n = [t[1], -t[0]];
    [n[0] * n[0], n[1] * n[1], 2.0 * n[0] * n[1]]
}

impl ClosedPart {
    /// The part that remains of triangle `k` beside the `open` ones: nothing of an open triangle;
    /// the curvature across an edge with a free slope is relaxed.
    pub(crate) fn closed_triangle(&self, k: usize, cells: &TriangleCells, open: &[bool]) -> Self {
        let mut left = self.clone();
        left.relaxed.extend(cells.freed_directions(k));
        // With all three directions relaxed no stiffness is left but rounding.
        if open[k] || left.relaxed.len() > 2 {
            left.area = 0.0;
        }
        left
    }
}

/// The curvature of triangle `k`.
fn curvature(
    mesh: &TriangleMesh,
    k: usize,
    slopes: &[slope::Stencil],
    clamp_of: &BTreeMap<u32, u32>,
) -> CurvatureGroup {
    let (area, nodes) = (mesh.areas[k], mesh.triangles[k]);
    let mut group = CurvatureGroup {
        area,
        // Counter-clockwise in (u, v) is clockwise seen from above.
        frame: [nodes[0], nodes[2], nodes[0], nodes[1]],
        home: k as u32,
        // A fold along an edge is shared by two triangles and changes the slope at the centre of
        // each by half.
        span: [2.0 * (2.0 * area).sqrt(); 3],
        ..Default::default()
    };
    let mut rows: BTreeMap<u32, [f64; 3]> = BTreeMap::new();
    let mut add = |mass: u32, weight: [f64; 3], times: f64| {
        let row = rows.entry(mass).or_default();
        (0..3).for_each(|i| row[i] += weight[i] * times);
    };
    for c in 0..3 {
        let e = mesh.triangle_edges[k][c];
        let edge = &mesh.edges[e as usize];
        let own = edge.triangles[0] == k as u32;
        let sign = if own { 1.0 } else { -1.0 };
        let (length, t) = mesh.direction(edge);
        let t = t.map(|v| v * sign);
        let n = [t[1], -t[0]];
        let twist = [n[0] * t[0] / area, n[1] * t[1] / area, (n[0] * t[1] + n[1] * t[0]) / area];
        add(nodes[(c + 1) % 3], twist, 1.0);
        add(nodes[c], twist, -1.0);
        let bend = bend_across(t);
        let per_slope = bend.map(|b| b * length / area);
        if let Some(clamp) = clamp_of.get(&e) {
            (0..3).for_each(|i| group.clamps[i].push((*clamp, per_slope[i])));
        } else if edge.is_boundary() {
            group.relaxed.push(bend);
        } else {
            slopes[e as usize].iter().for_each(|(mass, weight)| add(*mass, per_slope, sign * weight));
        }
    }
    for (mass, weights) in rows {
        for (row, weight) in group.rows.iter_mut().zip(weights).filter(|w| w.1.abs() * area > WEIGHT_TOLERANCE) {
            row.push((mass, weight));
        }
    }
    group
}
