//! Subdivision of triangles for drawing: a smooth surface through the nodes of a mesh.
//!
//! The new vertex of an edge lies -⅛ l² x_tt from the middle of the edge, with the rest length l of
//! the edge and the curvature x_tt along it. The curvature is that of the parabola that fits, by
//! least squares, the two end nodes and their neighbours. Flat sheets stay flat, polygonal outlines
//! stay polygons, and nodes keep their positions. The result has four times as many triangles and
//! can be subdivided again.
//!
//! Every new vertex is a fixed combination of old ones.

use nalgebra::{SMatrix, SVector};

use crate::mesh::outline::TriangleMesh;

/// Number of coefficients of a parabola in two variables.
const TERMS: usize = 6;
/// Regularisation of the quadratic terms, relative to the moments, for fewer nodes than a parabola
/// needs.
const REGULARISATION: f64 = 1e-6;

/// Weighted sum of nodes.
pub(crate) type NodeWeights = Vec<(u32, f64)>;

/// Subdivide the edges of `mesh`; return the new mesh and its vertices as combinations of nodes.
/// `vertices` are those of `mesh`.
pub(crate) fn halve(mesh: &TriangleMesh, vertices: &[NodeWeights]) -> Option<(TriangleMesh, Vec<NodeWeights>)> {
    let n = mesh.positions.len();
    let neighbours = mesh.neighbours();
    let (mut positions, mut all) = (mesh.positions.clone(), vertices.to_vec());
    for edge in &mesh.edges {
        positions.push(mesh.middle(edge));
        let mut sum = NodeWeights::new();
        for (vertex, weight) in bowed_middle(mesh, &neighbours, edge.nodes) {
            for (mass, part) in &vertices[vertex as usize] {
                match sum.iter_mut().find(|(m, _)| m == mass) {
                    Some((_, s)) => *s += weight * part,
                    None => sum.push((*mass, weight * part)),
                }
            }
        }
        all.push(sum);
    }
    let parts = mesh.triangles.iter().zip(&mesh.triangle_edges).flat_map(|([a, b, c], edges)| {
        let [ab, bc, ca] = edges.map(|e| n as u32 + e);
        [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
    });
    Some((TriangleMesh::new(positions, parts.collect()).ok()?, all))
}

/// Vertex in the middle of edge `a`, `b` as a combination of the surrounding vertices.
fn bowed_middle(mesh: &TriangleMesh, neighbours: &[Vec<u32>], [a, b]: [u32; 2]) -> NodeWeights {
    let mut around = vec![a, b];
    for m in neighbours[a as usize].iter().chain(&neighbours[b as usize]) {
        if !around.contains(m) {
            around.push(*m);
        }
    }
    let [p, q] = [a, b].map(|v| mesh.positions[v as usize]);
    let (du, dv) = (q[0] - p[0], q[1] - p[1]);
    let length = du.hypot(dv);
    let middle = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
    let rows: Vec<[f64; TERMS]> = around
        .iter()
        .map(|v| {
            let [u, v] = mesh.positions[*v as usize];
            let (s, t) = ((u - middle[0]) / length, (v - middle[1]) / length);
            [1.0, s, t, s * s, s * t, t * t]
        })
        .collect();
    let ridge = |i: usize, j: usize| if i == j && i > 2 { REGULARISATION } else { 0.0 };
    let moments =
        SMatrix::<f64, TERMS, TERMS>::from_fn(|i, j| rows.iter().map(|r| r[i] * r[j]).sum::<f64>() + ridge(i, j));
    let mut sum = vec![(a, 0.5), (b, 0.5)];
    let Some(factor) = moments.cholesky() else { return sum };
    let (s, t) = (du / length, dv / length);
    let along = SVector::from([0.0, 0.0, 0.0, 2.0 * s * s, 2.0 * s * t, 2.0 * t * t]);
    let second = factor.solve(&along);
    for (k, (vertex, row)) in around.iter().zip(&rows).enumerate() {
        let weight = -0.125 * row.iter().enumerate().map(|(i, r)| r * second[i]).sum::<f64>();
        match sum.get_mut(k).filter(|_| k < 2) {
            Some(end) => end.1 += weight,
            None => sum.push((*vertex, weight)),
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::outline::{HoleSpec, Outline, OutlineSpec, mesh};
    use std::path::Path;

    fn ring(n: u32) -> TriangleMesh {
        let disc = OutlineSpec::Disc { radius: 0.5 };
        let hole = HoleSpec::Disc { centre: (0.1, 0.0), radius: 0.15 };
        let outline = Outline::new(Some(&disc), &[hole], &[], (1.0, 1.0), Path::new(".")).expect("an outline");
        mesh(&outline, (n, n)).expect("a mesh")
    }

    /// Largest distance of the drawn surface from w = f.
    fn worst(n: u32, levels: u32, f: impl Fn(f64, f64) -> f64) -> f64 {
        let mut mesh = ring(n);
        let heights: Vec<f64> = mesh.positions.iter().map(|[u, v]| f(*u, *v)).collect();
        let mut vertices: Vec<NodeWeights> = (0..heights.len() as u32).map(|i| vec![(i, 1.0)]).collect();
        for _ in 0..levels {
            (mesh, vertices) = halve(&mesh, &vertices).expect("a mesh");
        }
        let off =
            mesh.positions.iter().zip(&vertices).map(|([u, v], sum)| {
                (sum.iter().map(|(m, w)| w * heights[*m as usize]).sum::<f64>() - f(*u, *v)).abs()
            });
        off.fold(0.0, f64::max)
    }

    #[test]
    fn halving_reproduces_planes_and_parabolas() {
        assert!(worst(11, 2, |u, v| 1.0 + 2.0 * u - v) < 1e-9);
        assert!(worst(11, 2, |u, v| u * u - 0.5 * u * v + 2.0 * v * v) < 1e-3);
    }

    #[test]
    fn halving_draws_a_wave_better_than_flat_triangles() {
        // The bow between nodes is h² κ/8 = 0.02.
        let wave = worst(11, 2, |u, v| (4.0 * u).sin() * (3.0 * v).cos());
        assert!(wave < 5e-3, "{wave}");
    }
}
