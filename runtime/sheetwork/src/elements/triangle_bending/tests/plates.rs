//! Plates of unit stiffness and mass per area against published frequencies and deflections.
//!
//! λ² = ω a² √(m/D): Leissa, Vibration of Plates (NASA SP-160, 1969), chapters 2 and 4;
//! deflections: Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, 2nd edition,
//! sections 16, 30 and 44.

use crate::elements::triangle_bending::tests::meshed;
use crate::elements::triangle_bending::tests::modes::PlateModel;
use crate::elements::triangle_bending::triangle_curvatures;
use crate::mesh::outline::{MeshEdge, TriangleMesh};

const NU: f64 = 0.3;

fn law(nu: f64) -> [[f64; 3]; 3] {
    [[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]]
}

fn plate(
    mesh: &TriangleMesh,
    nu: f64,
    clamped: &dyn Fn(&MeshEdge) -> bool,
    held: &dyn Fn(usize) -> bool,
) -> PlateModel {
    let (groups, _) = triangle_curvatures(mesh, clamped);
    PlateModel::new(&groups, &law(nu), &mesh.lumped, held)
}

/// Asserts a relative error (%) and prints it.
fn within(what: &str, found: f64, wanted: f64, percent: f64) {
    let error = 100.0 * (found / wanted - 1.0);
    println!("{what}: {error:+.3} % (allowed {percent})");
    assert!(error.abs() <= percent, "{what}: {found} for {wanted}, off by {error:.3} %");
}

#[test]
fn clamped_disc_frequencies_match_the_literature() {
    for (across, percent) in [(11, 1.6), (21, 0.5), (41, 0.1)] {
        let mesh = meshed("Disc(radius: 1)", "", "", (2.0, 2.0), (across, across));
        let plate = plate(&mesh, NU, &|_| true, &|i| mesh.border[i]);
        let squares = plate.squares(100.0);
        within(&format!("clamped disc, {across} across, first"), squares[0].sqrt(), 10.2158, percent);
        within(&format!("clamped disc, {across} across, second"), squares[1].sqrt(), 21.26, 4.0 * percent);
        let middle = plate.deflection().into_iter().fold(0.0, f64::max);
        within(&format!("clamped disc, {across} across, sag"), middle, 1.0 / 64.0, 2.0 * percent);
    }
}

#[test]
fn free_disc_frequencies_match_the_literature() {
    for (across, percent) in [(11, 3.2), (21, 0.8), (41, 0.2)] {
        let mesh = meshed("Disc(radius: 1)", "", "", (2.0, 2.0), (across, across));
        let squares = plate(&mesh, NU, &|_| false, &|_| false).squares(20.0);
        assert!(squares[..3].iter().all(|s| s.abs() < 1e-6), "{squares:?}");
        for (k, wanted, times) in [(3, 5.3583, 1.0), (4, 5.3583, 1.0), (5, 9.0031, 1.9)] {
            within(&format!("free disc, {across} across, {k}"), squares[k].sqrt(), wanted, times * percent);
        }
    }
}

#[test]
fn square_plate_frequencies_and_deflections_match_the_literature() {
    let supported = [19.739, 49.348, 49.348, 78.957];
    let clamped = [35.985, 73.394, 73.394, 108.217];
    for (across, percent) in [(11, 2.0), (21, 0.4), (41, 0.11)] {
        let mesh = meshed("", "", "", (1.0, 1.0), (across, across));
        for (name, clamp, sounds, sag) in
            [("supported", false, supported, 0.00406235), ("clamped", true, clamped, 0.00126532)]
        {
            let plate = plate(&mesh, NU, &|_| clamp, &|i| mesh.border[i]);
            let squares = plate.squares(400.0);
            for k in 0..4 {
                let allowed = if k == 0 { percent } else { 5.0 * percent };
                within(&format!("{name} square, {across} across, {k}"), squares[k].sqrt(), sounds[k], allowed);
            }
            let middle = plate.deflection().into_iter().fold(0.0, f64::max);
            within(&format!("{name} square, {across} across, sag"), middle, sag, 2.0 * percent);
        }
    }
}

#[test]
fn cantilever_frequency_matches_a_beam_at_any_grid_angle() {
    let first = 1.875_104_068_711_961_f64.powi(2);
    for (across, percent) in [(11, 0.3), (21, 0.08), (41, 0.03)] {
        for degrees in [0.0_f64, 30.0, 45.0] {
            let (s, c) = degrees.to_radians().sin_cos();
            let turn = |(x, z): (f64, f64)| format!("({}, {})", c * x - s * z, s * x + c * z);
            let corners = [(-0.5, -0.2), (0.5, -0.2), (0.5, 0.2), (-0.5, 0.2)].map(turn).join(",");
            // The grid with cells as large as those of `across` cells along the beam.
            let box_of = |a: f64, b: f64| ((a * c.abs() + b * s.abs()) * f64::from(across - 1)).round() as u32 + 1;
            let mesh =
                meshed(&format!("Polygon([{corners}])"), "", "", (1.0, 1.0), (box_of(1.0, 0.4), box_of(0.4, 1.0)));
            let at_wall = |p: [f64; 2]| c * p[0] + s * p[1] < -0.5 + 1e-9;
            let clamped = |e: &MeshEdge| at_wall(mesh.middle(e));
            let plate = plate(&mesh, 0.0, &clamped, &|i| at_wall(mesh.positions[i]));
            let name = format!("cantilever, {across} long, {degrees}°");
            within(&name, plate.squares(10.0)[0].sqrt(), first, percent);
            let tip = plate.deflection().into_iter().fold(0.0, f64::max);
            within(&format!("{name}, tip"), tip, 0.125, 2.0 * percent);
        }
    }
}

#[test]
fn a_plate_with_a_round_hole_converges() {
    let hole = "[Disc(centre: (0, 0), radius: 0.2)]";
    let outer =
        |mesh: &TriangleMesh, p: [f64; 2]| p[0].abs().max(p[1].abs()) > 0.5 - 1e-9 && !mesh.positions.is_empty();
    for (name, clamp) in [("supported", false), ("clamped", true)] {
        let first = |across: u32| {
            let mesh = meshed("", hole, "", (1.0, 1.0), (across, across));
            let clamped = |e: &MeshEdge| clamp && outer(&mesh, mesh.middle(e));
            plate(&mesh, NU, &clamped, &|i| outer(&mesh, mesh.positions[i])).squares(400.0)[0].sqrt()
        };
        let finest = first(101);
        println!("{name} with a hole, 101 across: {finest}");
        for (across, percent) in [(21, 1.0), (41, 0.25)] {
            within(&format!("{name} with a hole, {across} across"), first(across), finest, percent);
        }
    }
}
