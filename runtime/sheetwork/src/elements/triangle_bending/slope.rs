//! Slope across an edge between two triangles, from the surrounding nodes.
//!
//! The initial weights are the mean of the two triangles' gradients, each weighted by the height of
//! the other; they are exact for planes. Least squares then make them exact for every quadratic
//! over a patch of nodes. With P the six monomials at the nodes (relative to the edge's middle, in
//! units of its length), r the initial weights and c the required sums,
//!
//! r ← r + W Pᵀ (P W Pᵀ)⁺ (c - P r), W = 1/(0.3 + d²)², d the distance from the middle.
//!
//! A patch consists of the edge's two triangles and all triangles that share an edge with them,
//! plus another ring where the nodes lie too close to a conic. It does not grow across corners, so
//! a cut divides the patch as it divides the sheet.

use std::collections::BTreeSet;

use crate::elements::triangle_bending::symmetric::{eigen, pseudo_inverse};
use crate::mesh::outline::{MeshEdge, NO_TRIANGLE, TriangleMesh};

/// Nodes and weights, 1/m.
pub type Stencil = Vec<(u32, f64)>;

/// Smallest ratio of the singular values of P at which the patch determines a quadratic.
const MINIMUM_SINGULAR_VALUE_RATIO: f64 = 0.02;
/// Maximum number of additional rings of a patch.
pub(crate) const MAXIMUM_RINGS: usize = 2;
/// Eigenvalue of P W Pᵀ, relative to the largest, below which the pseudo-inverse drops it.
const EIGENVALUE_TOLERANCE: f64 = 1e-7;

/// Slope of each edge along the normal out of its first triangle; empty for boundary edges.
pub fn slopes(mesh: &TriangleMesh) -> Vec<Stencil> {
    mesh.edges.iter().map(|edge| if edge.is_boundary() { Vec::new() } else { slope(mesh, edge) }).collect()
}

/// Gradient (u, v) of the plane over triangle `k`: weight of each corner, 1/m.
fn gradient(mesh: &TriangleMesh, k: u32) -> [[f64; 2]; 3] {
    let p = mesh.triangles[k as usize].map(|v| mesh.positions[v as usize]);
    let twice = 2.0 * mesh.areas[k as usize];
    std::array::from_fn(|i| {
        let (a, b) = (p[(i + 1) % 3], p[(i + 2) % 3]);
        [(a[1] - b[1]) / twice, (b[0] - a[0]) / twice]
    })
}

fn grown(mesh: &TriangleMesh, patch: &BTreeSet<u32>) -> BTreeSet<u32> {
    let edges = patch.iter().flat_map(|k| mesh.triangle_edges[*k as usize]);
    edges.flat_map(|e| mesh.edges[e as usize].triangles).filter(|k| *k != NO_TRIANGLE).collect()
}

/// The six monomials at `d`: 1, x, y, ½x², ½y², xy.
fn monomials(d: [f64; 2]) -> [f64; 6] {
    [1.0, d[0], d[1], 0.5 * d[0] * d[0], 0.5 * d[1] * d[1], d[0] * d[1]]
}

/// Σ w m mᵀ over the nodes.
fn moments(all: &[[f64; 6]], weight: &[f64]) -> [[f64; 6]; 6] {
    let mut sum = [[0.0; 6]; 6];
    for (m, w) in all.iter().zip(weight) {
        for i in 0..6 {
            (0..6).for_each(|j| sum[i][j] += w * m[i] * m[j]);
        }
    }
    sum
}

fn slope(mesh: &TriangleMesh, edge: &MeshEdge) -> Stencil {
    let (length, t) = mesh.direction(edge);
    let (n, middle) = ([t[1], -t[0]], mesh.middle(edge));
    let (masses, all, _) = patch(mesh, edge, length, middle);
    let mut r = start(mesh, edge, n, &masses);
    // From here in units of the edge's length.
    r.iter_mut().for_each(|w| *w *= length);
    let weight: Vec<f64> = all.iter().map(|m| (0.3 + m[1] * m[1] + m[2] * m[2]).powi(-2)).collect();
    let inverse = pseudo_inverse(&moments(&all, &weight), EIGENVALUE_TOLERANCE);
    let wanted = [0.0, n[0], n[1], 0.0, 0.0, 0.0];
    // The second pass removes the rounding of the first.
    for _ in 0..2 {
        let missing: [f64; 6] =
            std::array::from_fn(|i| wanted[i] - r.iter().zip(&all).map(|(r, m)| r * m[i]).sum::<f64>());
        let times: [f64; 6] = std::array::from_fn(|i| (0..6).map(|j| inverse[i][j] * missing[j]).sum());
        for ((r, m), w) in r.iter_mut().zip(&all).zip(&weight) {
            *r += w * (0..6).map(|i| m[i] * times[i]).sum::<f64>();
        }
    }
    masses.into_iter().zip(r).filter(|(_, r)| r.abs() > 1e-13).map(|(v, r)| (v, r / length)).collect()
}

/// Nodes that the slope of an inner edge depends on, and the number of rings of triangles around
/// the edge's own two.
pub fn patch_nodes(mesh: &TriangleMesh, edge: &MeshEdge) -> (Vec<u32>, usize) {
    let (masses, _, rings) = patch(mesh, edge, mesh.direction(edge).0, mesh.middle(edge));
    (masses, rings)
}

/// Nodes of the patch, their monomials, and the number of its rings.
fn patch(mesh: &TriangleMesh, edge: &MeshEdge, length: f64, middle: [f64; 2]) -> (Vec<u32>, Vec<[f64; 6]>, usize) {
    let mut triangles = grown(mesh, &edge.triangles.into_iter().collect());
    for ring in 0..=MAXIMUM_RINGS {
        let masses: BTreeSet<u32> = triangles.iter().flat_map(|k| mesh.triangles[*k as usize]).collect();
        let place = |v: &u32| {
            let p = mesh.positions[*v as usize];
            monomials([(p[0] - middle[0]) / length, (p[1] - middle[1]) / length])
        };
        let all: Vec<[f64; 6]> = masses.iter().map(place).collect();
        let (values, _) = eigen(&moments(&all, &vec![1.0; all.len()]));
        let (low, high) = values.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
        if ring == MAXIMUM_RINGS
            || (all.len() >= 6 && low > MINIMUM_SINGULAR_VALUE_RATIO * MINIMUM_SINGULAR_VALUE_RATIO * high)
        {
            return (masses.into_iter().collect(), all, ring + 1);
        }
        triangles = grown(mesh, &triangles);
    }
    (Vec::new(), Vec::new(), 0)
}

/// Mean of the two triangles' gradients along `n`, each weighted by the other's height.
fn start(mesh: &TriangleMesh, edge: &MeshEdge, n: [f64; 2], masses: &[u32]) -> Vec<f64> {
    let [first, second] = edge.triangles;
    let (a, b) = (mesh.areas[first as usize], mesh.areas[second as usize]);
    let mut r = vec![0.0; masses.len()];
    for (k, share) in [(first, b / (a + b)), (second, a / (a + b))] {
        for (v, g) in mesh.triangles[k as usize].iter().zip(gradient(mesh, k)) {
            if let Ok(at) = masses.binary_search(v) {
                r[at] += share * (g[0] * n[0] + g[1] * n[1]);
            }
        }
    }
    r
}
