//! Tests of bending: derivatives, rigid motions, and the energy of a plate.

use crate::elements::bending::*;
use crate::elements::derivative_check;
use crate::elements::staggered::{StaggeredGrid, curvatures};

fn grid(clamped: &[bool]) -> Bending {
    let grid = StaggeredGrid { columns: 7, rows: 5, spacing: (0.1, 0.15), clamped };
    let mut bending = Bending::new(curvatures(&grid), &[DVec3::X, DVec3::Z]);
    bending.set_law(&derivative_check::law());
    bending
}

#[test]
fn gradient_and_tangent_are_those_of_the_potential() {
    let mut clamped = vec![false; 35];
    (0..5).for_each(|j| clamped[7 * j] = true);
    let mut bending = grid(&clamped);
    // Exact without damping; with damping the normal is not differentiated.
    bending.set_law(&ElementLaw { retardation: 0.0, ..derivative_check::law() });
    derivative_check::derivatives(&mut bending, &derivative_check::bent_grid(7, 5, (0.1, 0.15)), 1e-7);
}

#[test]
fn a_rigid_motion_costs_nothing() {
    let mut bending = grid(&[false; 35]);
    let flat = derivative_check::flat_grid(7, 5, (0.1, 0.15));
    assert!(bending.energy(&flat) < 1e-25);
    bending.set_law(&ElementLaw { retardation: 0.0, ..derivative_check::law() });
    derivative_check::rigid(&mut bending, &flat);
}

#[test]
fn rigid_rotation_of_a_bent_sheet_is_undamped() {
    // An unstretched cylinder: damping of a rotation acts on curvature along the sheet, which is
    // zero here.
    let bending = grid(&[false; 35]);
    let radius = 0.4;
    let (mut x, mut v) = (Vectors::default(), Vectors::default());
    for p in derivative_check::flat_grid(7, 5, (0.1, 0.15)).iter() {
        let q = DVec3::new(radius * (p.x / radius).sin(), radius * (p.x / radius).cos(), p.z);
        x.push(q);
        v.push(DVec3::new(0.4, 0.2, -0.7).cross(q));
    }
    let (mut with, mut without) = (Vectors::zeros(35), Vectors::zeros(35));
    bending.add_forces(&x, &v, &mut with);
    bending.add_forces(&x, &Vectors::zeros(35), &mut without);
    let braking = (0..35).map(|i| (with.get(i) - without.get(i)).length()).fold(0.0, f64::max);
    assert!(braking < 1e-12 * without.max_squared().sqrt(), "{braking}");
}

#[test]
fn a_paraboloid_has_the_energy_of_a_plate() {
    // Free edges relax the curvature across them: the energy there is that of a strip.
    let bending = grid(&[false; 35]);
    let (k1, k2, k3) = (0.3, -0.2, 0.5);
    let mut x = Vectors::default();
    for p in derivative_check::flat_grid(7, 5, (0.1, 0.15)).iter() {
        x.push(DVec3::new(p.x, 0.5 * k1 * p.x * p.x + 0.5 * k2 * p.z * p.z + k3 * p.x * p.z, p.z));
    }
    let d = derivative_check::law().bending;
    let full = 0.5 * (d[0][0] * k1 * k1 + 2.0 * d[0][1] * k1 * k2 + d[1][1] * k2 * k2);
    let (along_u, along_v) = (d[0][0] - d[0][1] * d[0][1] / d[1][1], d[1][1] - d[0][1] * d[0][1] / d[0][0]);
    let twist = 0.5 * d[2][2] * 4.0 * k3 * k3 * 0.6 * 0.6;
    let middle = full * 0.5 * 0.45 + 0.5 * along_u * k1 * k1 * 0.5 * 0.15 + 0.5 * along_v * k2 * k2 * 0.45 * 0.1;
    assert!((bending.energy(&x) / (twist + middle) - 1.0).abs() < 1e-12);
}
