//! Tests of the curvature operator: exactness for quadratics on any mesh, and plates against
//! published solutions.

pub(crate) mod modes;
pub(crate) mod plates;

use std::path::Path;

use crate::elements::curvature::relaxation;
use crate::elements::triangle_bending::triangle_curvatures;
use crate::mesh::outline::{HoleSpec, Outline, OutlineSpec, TriangleMesh, mesh};

/// The mesh of an outline given as RON; a rectangle of `size` (m) if `spec` is empty.
pub fn meshed(spec: &str, holes: &str, cuts: &str, size: (f64, f64), grid: (u32, u32)) -> TriangleMesh {
    let spec: Option<OutlineSpec> = (!spec.is_empty()).then(|| ron::from_str(spec).expect("an outline"));
    let holes: Vec<HoleSpec> = ron::from_str(if holes.is_empty() { "[]" } else { holes }).expect("holes");
    let cuts: Vec<Vec<(f64, f64)>> = ron::from_str(if cuts.is_empty() { "[]" } else { cuts }).expect("cuts");
    let outline = Outline::new(spec.as_ref(), &holes, &cuts, size, Path::new("")).expect("an outline");
    mesh(&outline, grid).expect("a mesh")
}

/// The mesh with its inner nodes moved at random by up to `by` m.
pub fn shaken(mesh: &TriangleMesh, by: f64) -> TriangleMesh {
    let mut seed = 7_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        by * ((seed >> 33) as f64 / (1_u64 << 30) as f64 - 1.0)
    };
    let mut positions = mesh.positions.clone();
    for (p, _) in positions.iter_mut().zip(&mesh.border).filter(|(_, border)| !**border) {
        *p = [p[0] + random(), p[1] + random()];
    }
    TriangleMesh::new(positions, mesh.triangles.clone()).expect("still a mesh")
}

/// Meshes of all kinds.
pub fn meshes() -> Vec<TriangleMesh> {
    let rectangle = meshed("", "", "", (0.25, 0.1), (11, 5));
    let torn = meshed(
        "Disc(radius: 0.1)",
        "[Disc(centre: (0.03, 0), radius: 0.03)]",
        "[[(-0.2, 0), (-0.02, 0.01)]]",
        (0.2, 0.2),
        (15, 16),
    );
    let stretched = meshed("Disc(radius: 0.1)", "", "", (0.2, 0.2), (9, 27));
    vec![shaken(&rectangle, 0.006), shaken(&torn, 0.0025), stretched, rectangle, torn]
}

#[test]
fn quadratics_are_exact_on_any_mesh() {
    // w = c + g·x + ½ xᵀ H x
    let (c, g, h) = (0.3, [0.2, -0.7], [[2.0, 0.9], [0.9, -1.3]]);
    let w = |p: [f64; 2]| {
        let curved = h[0][0] * p[0] * p[0] + 2.0 * h[0][1] * p[0] * p[1] + h[1][1] * p[1] * p[1];
        c + g[0] * p[0] + g[1] * p[1] + 0.5 * curved
    };
    let slope = |p: [f64; 2], n: [f64; 2]| {
        (g[0] + h[0][0] * p[0] + h[0][1] * p[1]) * n[0] + (g[1] + h[0][1] * p[0] + h[1][1] * p[1]) * n[1]
    };
    let wanted = [h[0][0], h[1][1], 2.0 * h[0][1]];
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for mesh in meshes() {
        for clamp in [false, true] {
            let clamped = |e: &crate::mesh::outline::MeshEdge| clamp && mesh.middle(e)[0] < 0.0;
            let (groups, directions) = triangle_curvatures(&mesh, &clamped);
            let edges: Vec<_> = mesh.edges.iter().filter(|e| e.is_boundary() && clamped(e)).collect();
            assert_eq!(edges.len(), directions.len());
            let slopes: Vec<f64> = edges.iter().zip(&directions).map(|(e, n)| slope(mesh.middle(e), *n)).collect();
            let area: f64 = groups.iter().map(|g| g.area).sum();
            assert!(clamp || (area / mesh.total_area() - 1.0).abs() < 1e-12);
            for group in &groups {
                let size = |i: usize| group.rows[i].iter().map(|(_, r)| r.abs()).sum::<f64>() * 0.5;
                let rounding = (0..3).map(size).fold(1.0, f64::max) * 1e-13;
                let missing: [f64; 3] = std::array::from_fn(|i| {
                    let masses: f64 = group.rows[i].iter().map(|(v, r)| r * w(mesh.positions[*v as usize])).sum();
                    let clamps: f64 = group.clamps[i].iter().map(|(j, r)| r * slopes[*j as usize]).sum();
                    wanted[i] - masses - clamps
                });
                // The remaining error lies in relaxed directions only.
                let q = relaxation(&unit, &group.relaxed);
                for row in q {
                    let left: f64 = row.iter().zip(missing).map(|(q, m)| q * m).sum();
                    assert!(left.abs() < 10.0 * rounding, "off by {left}, rounding {rounding}");
                }
            }
        }
    }
}

#[test]
fn no_stencil_reaches_across_a_cut() {
    let mesh = meshed("", "", "[[(-0.2, 0.0001), (0.2, 0.0001)]]", (0.2, 0.2), (13, 13));
    let side = |k: u32| mesh.positions[k as usize][1] > 0.0001;
    let (groups, _) = triangle_curvatures(&mesh, &|_| false);
    for (group, t) in groups.iter().zip(&mesh.triangles) {
        let middle: f64 = t.iter().map(|v| mesh.positions[*v as usize][1]).sum();
        for (v, _) in group.rows.iter().flatten() {
            let on_cut = (mesh.positions[*v as usize][1] - 0.0001).abs() < 1e-9;
            assert!(on_cut || side(*v) == (middle > 0.0));
        }
    }
}
