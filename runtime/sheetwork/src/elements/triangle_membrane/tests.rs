//! Tests of the membrane: derivatives, rigid motions, and known strains.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::elements::derivative_check;
use crate::elements::triangle_bending::triangle_curvatures;
use crate::elements::triangle_membrane::*;
use crate::mesh::outline::{HoleSpec, MeshEdge, Outline, OutlineSpec, mesh};

struct RandomNodes(u64);

impl RandomNodes {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / (1_u64 << 30) as f64 - 1.0
    }

    fn vectors(&mut self, n: usize, size: f64) -> Vectors {
        let mut all = Vectors::default();
        (0..n).for_each(|_| all.push(DVec3::new(self.next(), self.next(), self.next()) * size));
        all
    }
}

/// A disc with a cut and a hole, 0.2 m times `scale` across, with randomly moved inner nodes.
fn sheet(across: u32, scale: f64) -> TriangleMesh {
    let disc = OutlineSpec::Disc { radius: 0.1 };
    let hole = HoleSpec::Disc { centre: (0.03, 0.0), radius: 0.03 };
    let cuts = [vec![(-0.2, 0.0), (-0.02, 0.01)]];
    let outline = Outline::new(Some(&disc), &[hole], &cuts, (0.2, 0.2), std::path::Path::new("")).expect("an outline");
    let flat = mesh(&outline, (across, across)).expect("a mesh");
    let mut random = RandomNodes(3);
    let mut positions = flat.positions.clone();
    for (p, _) in positions.iter_mut().zip(&flat.border).filter(|(_, border)| !**border) {
        *p = p.map(|c| c + 0.03 / f64::from(across) * random.next());
    }
    positions.iter_mut().for_each(|p| *p = p.map(|c| c * scale));
    TriangleMesh::new(positions, flat.triangles).expect("still a mesh")
}

const LAW: ElementLaw = ElementLaw {
    membrane: [[900.0, 200.0, 30.0], [200.0, 500.0, -40.0], [30.0, -40.0, 150.0]],
    bending: [[0.04, 0.01, 0.002], [0.01, 0.02, 0.0], [0.002, 0.0, 0.01]],
    retardation: 0.004,
    membrane_retardation: 0.004,
    arms: [0.0; crate::material::loss_factor::ARMS],
};

fn left(mesh: &TriangleMesh) -> impl Fn(&MeshEdge) -> bool {
    |e| mesh.middle(e)[0] < -0.8 * mesh.positions.iter().fold(0.0, |m: f64, p| m.max(p[0]))
}

/// The membrane with clamped edges on the left, and its nodes at rest in the x-z plane.
fn membrane(mesh: &TriangleMesh, law: &ElementLaw) -> (EdgeMembrane, Vectors) {
    let (groups, directions) = triangle_curvatures(mesh, &left(mesh));
    let mut membrane = EdgeMembrane::new(mesh, &groups);
    membrane.set_law(law);
    let tangents: Vec<DVec3> = directions.iter().map(|d| DVec3::new(d[0], 0.0, d[1])).collect();
    membrane.set_clamps(&tangents);
    let mut x = Vectors::default();
    mesh.positions.iter().for_each(|p| x.push(DVec3::new(p[0], 0.0, p[1])));
    (membrane, x)
}

fn sum(a: &Vectors, h: f64, d: &Vectors) -> Vectors {
    let mut s = a.clone();
    s.add_scaled(h, d);
    s
}

fn inner(a: &Vectors, b: &Vectors) -> f64 {
    a.iter().zip(b.iter()).map(|(a, b)| a.dot(b)).sum()
}

fn size(a: &Vectors) -> f64 {
    inner(a, a).sqrt()
}

/// Begins a stage of equilibrium: no strain rates.
fn still(membrane: &mut EdgeMembrane) {
    membrane.begin_stage(0.0, &[], 0.0);
}

fn gradient(membrane: &mut EdgeMembrane, x: &Vectors) -> Vectors {
    let mut g = Vectors::zeros(x.len());
    membrane.add_gradient(x, &mut g);
    g
}

/// The tangent at `x` times `d`.
fn tangent_times(membrane: &mut EdgeMembrane, x: &Vectors, kind: Geometric, d: &Vectors) -> Vectors {
    let mut slots: BTreeMap<(u32, u32), u32> = (0..x.len() as u32).zip(0..).map(|(i, s)| ((i, i), s)).collect();
    let mut pairs = Vec::new();
    membrane.visit_coupled_nodes(&mut |a, b| pairs.push((a, b)));
    for pair in pairs {
        assert!(pair.0 > pair.1);
        let next = slots.len() as u32;
        slots.entry(pair).or_insert(next);
    }
    membrane.bind_blocks(&|a, b| slots.get(&(a, b)).copied().unwrap_or(NO_BLOCK));
    let mut values = vec![0.0; 9 * slots.len()];
    membrane.add_tangent(x, kind, &mut values);
    let mut y = Vectors::zeros(x.len());
    for ((a, b), slot) in slots {
        let block = &values[9 * slot as usize..][..9];
        let rows = [0, 3, 6].map(|r| DVec3::new(block[r], block[r + 1], block[r + 2]));
        let (a, b) = (a as usize, b as usize);
        y.set(a, y.get(a) + DVec3::from_array(rows.map(|r| r.dot(d.get(b)))));
        if a != b {
            let da = d.get(a);
            y.set(b, y.get(b) + rows[0] * da.x + rows[1] * da.y + rows[2] * da.z);
        }
    }
    y
}

/// Strains (uu, vv, uv with engineering shear) of every triangle at `x` (m).
fn strains(membrane: &EdgeMembrane, x: &Vectors) -> Vec<[f64; 3]> {
    let of = |t: &MembraneTriangle| product(&t.from_edges, &t.edges.map(|e| membrane.strains[e as usize].at(x)));
    membrane.triangles.iter().map(of).collect()
}

#[test]
fn gradient_and_tangent_are_those_of_the_potential() {
    let mesh = sheet(9, 10.0);
    let (mut membrane, rest) = membrane(&mesh, &derivative_check::law());
    let bent = sum(&rest, 1.0, &RandomNodes(1).vectors(rest.len(), 0.05));
    derivative_check::derivatives(&mut membrane, &bent, 1e-6);
}

#[test]
fn rigid_motions_cost_nothing_and_are_not_resisted() {
    let mesh = sheet(11, 10.0);
    let (groups, _) = triangle_curvatures(&mesh, &|_| false);
    let mut free = EdgeMembrane::new(&mesh, &groups);
    free.set_law(&derivative_check::law());
    derivative_check::rigid(&mut free, &membrane(&mesh, &derivative_check::law()).1);
}

#[test]
fn the_clipped_tangent_is_never_negative() {
    let mesh = sheet(11, 1.0);
    let (mut membrane, rest) = membrane(&mesh, &LAW);
    let mut random = RandomNodes(5);
    still(&mut membrane);
    let x = sum(&rest, 1.0, &random.vectors(rest.len(), 0.003));
    let mut squeezed = Vectors::default();
    x.iter().for_each(|p| squeezed.push(p * 0.97));
    membrane.update_stress(&squeezed);
    let mut negative = |kind: Geometric| {
        let n = 3 * x.len();
        let unit = |j: usize| {
            let mut d = Vectors::zeros(x.len());
            d.axes_mut()[j % 3][j / 3] = 1.0;
            d
        };
        let columns: Vec<Vectors> = (0..n).map(|j| tangent_times(&mut membrane, &squeezed, kind, &unit(j))).collect();
        negative_pivots((0..n).map(|i| columns.iter().map(|c| c.axes()[i % 3][i / 3]).collect()).collect())
    };
    assert_eq!(negative(Geometric::Clipped), 0);
    assert!(negative(Geometric::Mixed) > 0, "the test squeezes nothing");
}

/// Number of negative eigenvalues of a symmetric matrix beyond rounding, counted as negative pivots
/// (Sylvester's law of inertia).
fn negative_pivots(mut a: Vec<Vec<f64>>) -> usize {
    let n = a.len();
    let shift = 1e-9 * (0..n).map(|i| a[i][i]).fold(0.0, f64::max);
    (0..n).for_each(|i| a[i][i] += shift);
    for k in 0..n {
        let (top, rest) = a.split_at_mut(k + 1);
        for row in rest {
            let times = row[k] / top[k][k];
            row[k..].iter_mut().zip(&top[k][k..]).for_each(|(r, t)| *r -= times * t);
        }
    }
    (0..n).filter(|k| a[*k][*k] < 0.0).count()
}

#[test]
fn prediction_is_the_linearised_stress_and_its_error_is_second_order() {
    let mesh = sheet(11, 1.0);
    let (mut membrane, rest) = membrane(&mesh, &LAW);
    let mut random = RandomNodes(4);
    still(&mut membrane);
    let x = sum(&rest, 1.0, &random.vectors(rest.len(), 0.003));
    let d = random.vectors(x.len(), 1e-4);
    let mismatch = membrane.predict_stress(&x, &d);
    let linear = membrane.stress.clone();
    // The prediction error is the energy of strain(x + d) - strain(x) - rate.
    let moved = sum(&x, 1.0, &d);
    let missed: Vec<f64> = membrane.strains.iter().map(|s| s.at(&moved) - s.at(&x) - s.rate(&x, &d)).collect();
    let wanted = membrane.stored_energy(|e| missed[e]);
    assert!((mismatch - wanted).abs() < 1e-6 * wanted, "{mismatch} {wanted}");
    membrane.update_stress(&moved);
    let far: f64 = membrane.stress.iter().zip(&linear).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    membrane.update_stress(&x);
    let near: f64 = membrane.stress.iter().zip(&linear).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(far < 0.05 * near, "{far} {near}");
}

#[test]
fn constant_strain_is_exact_on_any_mesh() {
    let mesh = sheet(15, 1.0);
    let (groups, _) = triangle_curvatures(&mesh, &|_| false);
    let mut membrane = EdgeMembrane::new(&mesh, &groups);
    membrane.set_law(&LAW);
    // x = F (u, v): E = ½ (Fᵀ F - 1).
    let (fu, fv) = (DVec3::new(1.02, 0.03, -0.01), DVec3::new(0.04, -0.05, 0.97));
    let mut x = Vectors::default();
    mesh.positions.iter().for_each(|p| x.push(fu * p[0] + fv * p[1]));
    let wanted = [0.5 * (fu.length_squared() - 1.0), 0.5 * (fv.length_squared() - 1.0), fu.dot(fv)];
    for strain in strains(&membrane, &x) {
        for (s, w) in strain.iter().zip(wanted) {
            assert!((s - w).abs() < 1e-12, "{s} {w}");
        }
    }
    let density = 0.5 * dot(&wanted, &product(&LAW.membrane, &wanted));
    assert!((membrane.energy(&x) / (density * mesh.total_area()) - 1.0).abs() < 1e-12);
    // Inner nodes are in equilibrium.
    still(&mut membrane);
    let g = gradient(&mut membrane, &x);
    let scale = size(&g);
    let touched = |v: usize| {
        mesh.triangles.iter().filter(|t| t.contains(&(v as u32))).any(|t| t.iter().any(|w| mesh.border[*w as usize]))
    };
    for i in (0..g.len()).filter(|i| !touched(*i)) {
        assert!(g.get(i).length() < 1e-10 * scale, "mass {i} is pulled");
    }
}

#[test]
fn bending_to_a_cylinder_stretches_nothing_to_second_order() {
    // Gentle roll about an axis at an angle to all edges: the chord shortens by h²κ²/24, which the
    // arc term compensates.
    let mesh = sheet(21, 1.0);
    let (groups, _) = triangle_curvatures(&mesh, &|_| false);
    let mut membrane = EdgeMembrane::new(&mesh, &groups);
    membrane.set_law(&LAW);
    let along = DVec3::new(0.8, 0.0, 0.6);
    let across = DVec3::new(-0.6, 0.0, 0.8);
    let strain_at = |radius: f64| {
        let mut x = Vectors::default();
        for p in &mesh.positions {
            let p = DVec3::new(p[0], 0.0, p[1]);
            let s = along.dot(p) / radius;
            x.push(along * (radius * s.sin()) + DVec3::Y * (radius * (1.0 - s.cos())) + across * across.dot(p));
        }
        let inner = |t: &[u32; 3]| t.iter().all(|v| !mesh.border[*v as usize]);
        let strains = strains(&membrane, &x);
        let inside = strains.iter().zip(&mesh.triangles).filter(|(_, t)| inner(t));
        inside.flat_map(|(s, _)| s.iter().map(|s| s.abs())).fold(0.0, f64::max)
    };
    // Strain of the chord alone: l²/(24 R²).
    let chord = |radius: f64| 1e-4 / (24.0 * radius * radius);
    assert!(strain_at(1.0) < 0.03 * chord(1.0), "{} {}", strain_at(1.0), chord(1.0));
    // The remaining strain decreases at least with the square of the radius.
    assert!(strain_at(1.0) < strain_at(0.5) / 3.9);
}

#[test]
fn only_rigid_motions_are_free_in_the_plane_at_rest() {
    // Membrane and bending together have six rigid motions at rest: three in the plane, tested
    // here, and three out of it, tested with the plates.
    let mesh = sheet(9, 1.0);
    let (groups, _) = triangle_curvatures(&mesh, &|_| false);
    let mut membrane = EdgeMembrane::new(&mesh, &groups);
    membrane.set_law(&LAW);
    let (_, rest) = tests::membrane(&mesh, &LAW);
    still(&mut membrane);
    membrane.update_stress(&rest);
    let n = rest.len();
    let mut matrix = vec![vec![0.0; 2 * n]; 2 * n];
    for j in 0..2 * n {
        let mut d = Vectors::zeros(n);
        if j < n {
            d.x[j] = 1.0
        } else {
            d.z[j - n] = 1.0
        }
        let y = tangent_times(&mut membrane, &rest, Geometric::Mixed, &d);
        for i in 0..n {
            matrix[i][j] = y.x[i];
            matrix[n + i][j] = y.z[i];
        }
    }
    assert_eq!(rank(matrix), 2 * n - 3);
}

/// Rank by elimination with full pivoting.
fn rank(mut a: Vec<Vec<f64>>) -> usize {
    let n = a.len();
    let scale = a.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
    for k in 0..n {
        let all = (k..n).flat_map(|i| (k..n).map(move |j| (i, j)));
        let (i, j) = all.max_by(|p, q| a[p.0][p.1].abs().total_cmp(&a[q.0][q.1].abs())).expect("a pivot");
        if a[i][j].abs() < 1e-9 * scale {
            return k;
        }
        a.swap(k, i);
        a.iter_mut().for_each(|row| row.swap(k, j));
        let (top, rest) = a.split_at_mut(k + 1);
        for row in rest {
            let times = row[k] / top[k][k];
            row[k..].iter_mut().zip(&top[k][k..]).for_each(|(r, t)| *r -= times * t);
        }
    }
    n
}
