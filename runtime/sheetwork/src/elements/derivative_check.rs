//! Consistency checks for elements, used by tests: the gradient against differences of the
//! potential, the tangent against differences of the gradient, and invariance under rigid motion.

use glam::{DMat3, DQuat, DVec3};

use crate::elements::{Anchor, Element, Geometric};
use crate::material::law::ElementLaw;
use crate::math::Vectors;

/// An orthotropic law with damping; all stiffnesses are of order 1.
pub fn law() -> ElementLaw {
    ElementLaw {
        membrane: [[3.0, 0.8, 0.0], [0.8, 2.0, 0.0], [0.0, 0.0, 0.9]],
        bending: [[1.1, 0.3, 0.0], [0.3, 0.7, 0.0], [0.0, 0.0, 0.4]],
        retardation: 0.02,
        membrane_retardation: 0.02,
        arms: [0.0; crate::material::loss_factor::ARMS],
    }
}

/// A flat grid in the plane y = 0, columns along x contiguous.
pub fn flat_grid(columns: usize, rows: usize, (hx, hz): (f64, f64)) -> Vectors {
    let mut x = Vectors::default();
    for j in 0..rows {
        for i in 0..columns {
            x.push(DVec3::new(i as f64 * hx, 0.0, j as f64 * hz));
        }
    }
    x
}

/// The flat grid, bent, stretched and sheared.
pub fn bent_grid(columns: usize, rows: usize, spacing: (f64, f64)) -> Vectors {
    let mut x = flat_grid(columns, rows, spacing);
    for i in 0..x.len() {
        x.set(i, wave(x.get(i)));
    }
    x
}

fn wave(p: DVec3) -> DVec3 {
    let lift = 0.2 * (3.0 * p.x + 1.7 * p.z).sin();
    p * 1.05 + DVec3::new(0.03 * p.z, lift, 0.04 * (2.0 * p.x).cos())
}

/// An arbitrary velocity field, m/s.
fn drift(x: &Vectors) -> Vectors {
    let mut v = Vectors::default();
    x.iter().for_each(|p| v.push(DVec3::new((5.0 * p.z).sin(), (4.0 * p.x + p.y).cos(), (3.0 * p.x * p.z).sin())));
    v
}

/// The dense tangent, column by column.
fn dense(element: &mut dyn Element, x: &Vectors, per_time: f64, geometric: Geometric) -> Vec<Vec<f64>> {
    let n = x.len();
    let mut pairs: Vec<(u32, u32)> = (0..n as u32).map(|i| (i, i)).collect();
    element.visit_coupled_nodes(&mut |a, b| {
        assert!(a > b, "pairs are of the lower triangle");
        pairs.push((a, b));
    });
    pairs.sort_unstable();
    pairs.dedup();
    element.bind_blocks(&|a, b| pairs.binary_search(&(a, b)).expect("a pair that couples() named") as u32);
    let mut values = vec![0.0; 9 * pairs.len()];
    element.add_constant_tangent(per_time, &mut values);
    element.add_tangent(x, geometric, &mut values);
    let mut all = vec![vec![0.0; 3 * n]; 3 * n];
    for ((a, b), block) in pairs.iter().zip(values.chunks(9)) {
        for r in 0..3 {
            for c in 0..3 {
                let (i, j) = (3 * *a as usize + r, 3 * *b as usize + c);
                all[j][i] = block[3 * r + c];
                if a != b {
                    all[i][j] = block[3 * r + c];
                }
            }
        }
    }
    all
}

fn moved(x: &Vectors, dof: usize, by: f64) -> Vectors {
    let mut y = x.clone();
    let mut p = y.get(dof / 3);
    p[dof % 3] += by;
    y.set(dof / 3, p);
    y
}

/// Checks gradient and tangent (with σ* at `x`) against central differences, to `tolerance` of the
/// largest entry, and that the forces at zero velocity are minus the gradient.
pub fn derivatives(element: &mut dyn Element, x: &Vectors, tolerance: f64) {
    let per_time = 30.0;
    let v = drift(x);
    // Reference strain: the sheet 0.01 s earlier.
    let mut earlier = x.clone();
    earlier.add_scaled(-0.01, &v);
    element.begin_stage(per_time, &[Anchor { weight: 1.0, x: &earlier }], 0.0);
    element.update_stress(x);
    let n = x.len();
    let gradient = |element: &mut dyn Element, x: &Vectors| {
        let mut g = Vectors::zeros(n);
        element.add_gradient(x, &mut g);
        g
    };
    let g = gradient(element, x);
    let largest = g.max_squared().sqrt();
    let h = 1e-5;
    for dof in 0..3 * n {
        let slope = (element.potential(&moved(x, dof, h)) - element.potential(&moved(x, dof, -h))) / (2.0 * h);
        let (got, scale) = (g.get(dof / 3)[dof % 3], tolerance * largest);
        assert!((slope - got).abs() < scale, "gradient {dof}: {got}, by differences {slope}");
    }
    let tangent = dense(element, x, per_time, Geometric::Mixed);
    let largest = tangent.iter().flatten().fold(0.0_f64, |m, t| m.max(t.abs()));
    for (dof, column) in tangent.iter().enumerate() {
        let (ahead, behind) = (gradient(element, &moved(x, dof, h)), gradient(element, &moved(x, dof, -h)));
        for (row, got) in column.iter().enumerate() {
            let slope = (ahead.get(row / 3)[row % 3] - behind.get(row / 3)[row % 3]) / (2.0 * h);
            assert!((slope - got).abs() < tolerance * largest, "tangent {row}, {dof}: {got}, by differences {slope}");
        }
    }
    element.begin_stage(0.0, &[], 0.0);
    let (g, still) = (gradient(element, x), Vectors::zeros(n));
    let mut force = Vectors::zeros(n);
    element.add_forces(x, &still, &mut force);
    for i in 0..n {
        assert!((force.get(i) + g.get(i)).length() < 1e-9 * largest, "force on {i} is not minus the gradient");
    }
}

/// Checks that a rigid motion of `rest` stores no energy, that a rigid rotation is undamped, and
/// that forces have no resultant and no moment.
pub fn rigid(element: &mut dyn Element, rest: &Vectors) {
    let turn = DQuat::from_rotation_z(0.7) * DQuat::from_rotation_x(-1.1);
    let mut x = Vectors::default();
    rest.iter().for_each(|p| x.push(turn * p + DVec3::new(3.0, -2.0, 5.0)));
    let scale: f64 = {
        let mut bent = Vectors::default();
        rest.iter().for_each(|p| bent.push(wave(p)));
        element.energy(&bent)
    };
    assert!(element.energy(&x) < 1e-20 * scale.max(1.0), "a rigid motion stores {} J", element.energy(&x));
    // A bent sheet in rotation: strain rates vanish to the order of the angle per stage.
    let mut bent = Vectors::default();
    rest.iter().for_each(|p| bent.push(wave(p)));
    let axis = DVec3::new(0.3, -0.5, 0.8);
    let mut v = Vectors::default();
    bent.iter().for_each(|p| v.push(axis.cross(p)));
    let (mut with, mut without) = (Vectors::zeros(rest.len()), Vectors::zeros(rest.len()));
    element.add_forces(&bent, &v, &mut with);
    element.add_forces(&bent, &Vectors::zeros(rest.len()), &mut without);
    let largest = without.max_squared().sqrt();
    let resisted = (0..rest.len()).map(|i| (with.get(i) - without.get(i)).length()).fold(0.0, f64::max);
    assert!(resisted < 1e-3 * largest, "a rotation is resisted by {resisted} of {largest} N");
    let total: DVec3 = without.iter().sum();
    let moment: DVec3 = without.iter().zip(bent.iter()).map(|(f, p)| p.cross(f)).sum();
    assert!(total.length() < 1e-10 * largest * rest.len() as f64, "forces add up to {total}");
    assert!(moment.length() < 1e-10 * largest * rest.len() as f64, "moments add up to {moment}");
    // A rotated sheet has equal energy.
    let spun = DMat3::from_quat(turn);
    let mut turned = Vectors::default();
    bent.iter().for_each(|p| turned.push(spun * p));
    assert!((element.energy(&turned) / element.energy(&bent) - 1.0).abs() < 1e-11);
}
