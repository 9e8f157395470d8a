//! Tests of the membrane of a grid: derivatives, rigid motions, and a known strain.

use crate::elements::derivative_check;
use crate::elements::grid_membrane::*;

/// A bent, stretched, sheared grid of 11 by 4 nodes: two packets per row, the second partly filled.
fn grid() -> (CellMembrane, Vectors) {
    let mut membrane = CellMembrane::new(11, 4, (0.1, 0.15));
    membrane.set_law(&derivative_check::law());
    (membrane, derivative_check::bent_grid(11, 4, (0.1, 0.15)))
}

#[test]
fn gradient_and_tangent_are_those_of_the_potential() {
    let (mut membrane, x) = grid();
    derivative_check::derivatives(&mut membrane, &x, 1e-6);
}

#[test]
fn a_rigid_motion_costs_nothing_and_is_not_resisted() {
    let (mut membrane, _) = grid();
    derivative_check::rigid(&mut membrane, &derivative_check::flat_grid(11, 4, (0.1, 0.15)));
}

#[test]
fn energy_of_a_uniform_strain_is_that_of_a_plate_in_plane_stress() {
    let (membrane, _) = grid();
    let flat = derivative_check::flat_grid(11, 4, (0.1, 0.15));
    let (eu, ev, shear) = (0.01, -0.02, 0.03);
    let mut x = Vectors::default();
    for p in flat.iter() {
        x.push(glam::DVec3::new(p.x * (1.0 + eu) + p.z * shear, 0.0, p.z * (1.0 + ev)));
    }
    let e = [
        0.5 * ((1.0 + eu) * (1.0 + eu) - 1.0),
        0.5 * ((1.0 + ev) * (1.0 + ev) + shear * shear - 1.0),
        (1.0 + eu) * shear,
    ];
    let a = derivative_check::law().membrane;
    let mut density = 0.0;
    for i in 0..3 {
        for j in 0..3 {
            density += 0.5 * a[i][j] * e[i] * e[j];
        }
    }
    let wanted = density * 1.0 * 0.45;
    assert!((membrane.energy(&x) / wanted - 1.0).abs() < 1e-12);
}
