//! Calibrated lattices against closed forms of plates and beams.

pub(crate) mod linear;

use crate::material::calibration::cell::{CellSpring, LatticePattern};
use crate::material::calibration::homogenise::{PlateStiffness, homogenise};
use crate::material::calibration::target::along;
use crate::material::calibration::tests::linear::Linear;
use crate::material::calibration::*;
use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::TABLE;

use StructureKind::{DoubleDiagonal, Provot2d, Provot3d, Samm, Slamm, Trimm};

const THICKNESS: f64 = 5e-4;
const AREAL: f64 = 1050.0 * THICKNESS;
const LEFT: ClampedEdges = ClampedEdges { left: true, right: false, back: false, front: false };

fn target(poisson: f64) -> StiffnessTarget {
    StiffnessTarget::of_plate(3e9, poisson, THICKNESS)
}

/// Two layers of the structure, `n` nodes along 0.25 m and `cells` cells across; triangles are
/// equilateral.
fn request(structure: StructureKind, n: u32, cells: u32, clamped: ClampedEdges) -> CalibrationRequest {
    let half = if structure.info().triangular { 0.5 } else { 0.0 };
    let spacing = 0.25 / (f64::from(n - 1) + half);
    let row = if structure.info().triangular { 0.75_f64.sqrt() * spacing } else { spacing };
    let size = (0.25, row * f64::from(cells));
    CalibrationRequest {
        clamped,
        ..CalibrationRequest::new(structure, (n, 2, cells + 1), size, target(1.0 / 3.0), AREAL)
    }
}

/// Request for a sheet about as wide as long.
fn square(structure: StructureKind, n: u32, clamped: ClampedEdges) -> CalibrationRequest {
    let rows = isotropic_rows(structure, n, (0.25, 0.25)).unwrap_or(n);
    request(structure, n, rows - 1, clamped)
}

/// Plate of springs of stiffness `k(class)` in two layers a distance `gap` apart, cells of 1 m.
fn plate(structure: StructureKind, gap: f64, k: impl Fn(SpringClass) -> f64) -> PlateStiffness {
    let row = if structure.info().triangular { 0.75_f64.sqrt() } else { 1.0 };
    let cell = LatticePattern { structure, layers: 2, spacing: (1.0, row), gap, cross_over: false }.periodic();
    let k: Vec<f64> = cell.springs.iter().map(|b: &CellSpring| k(b.class)).collect();
    homogenise(&cell, &k)
}

#[test]
fn known_springs_give_the_textbook_plate_stiffness() {
    // A layer of stiffness A_l = 1 along x: square cells k + k_d = 1, triangles k = 4/(3√3). Then
    // D11 = s²/2.
    let gap: f64 = 0.3;
    let d11 = gap * gap / 2.0;
    let diagonal = |c: SpringClass| matches!(c, SpringClass::Diagonal | SpringClass::AntiDiagonal);
    let two = |axial: f64, slant: f64| {
        move |c: SpringClass| match c {
            SpringClass::Inter => 4.0,
            c if diagonal(c) => slant,
            _ => axial,
        }
    };
    let equilateral = 4.0 / 27.0_f64.sqrt();
    // Structure, springs, then D66, D16 and the stiffness along 45 and 135 degrees, all over D11.
    let rows = [
        (Samm, two(1.0, 0.0), 0.0, 0.0, 0.5, 0.5),
        (Slamm, two(2.0 / 3.0, 2.0 / 3.0), 1.0 / 3.0, 1.0 / 3.0, 5.0 / 3.0, 1.0 / 3.0),
        (DoubleDiagonal, two(2.0 / 3.0, 1.0 / 3.0), 1.0 / 3.0, 0.0, 1.0, 1.0),
        (Trimm, two(equilateral, equilateral), 1.0 / 3.0, 0.0, 1.0, 1.0),
    ];
    for (structure, k, twist, coupling, at_45, at_135) in rows {
        let d = plate(structure, gap, k).free_bending();
        let found = [
            d[0][0],
            d[1][1],
            d[2][2],
            d[0][1],
            d[0][2],
            along(&d, 45_f64.to_radians()),
            along(&d, 135_f64.to_radians()),
        ];
        let wanted = [1.0, 1.0, twist, twist, coupling, at_45, at_135];
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found / d11 - wanted).abs() < 1e-9, "{structure}: {found} is not {wanted} of {d11}");
        }
    }
}

#[test]
fn bending_stiffness_is_as_requested_in_every_direction_for_any_poisson_ratio() {
    for structure in [DoubleDiagonal, Trimm, Provot3d] {
        for poisson in [0.0, 1.0 / 3.0, 0.38, 0.45] {
            let request = CalibrationRequest { target: target(poisson), ..square(structure, 21, LEFT) };
            let found = calibrate(&request).expect("valid").delivered;
            assert!(found.bends_within(1e-6), "{structure} {poisson}: {:?}", found.bending);
            assert!((found.poisson_ratio - 1.0 / 3.0).abs() < 1e-6, "{structure}: {}", found.poisson_ratio);
            // D66 = D/3, where D (1-ν)/2 is requested.
            assert!((found.twist - 2.0 / 3.0 / (1.0 - poisson)).abs() < 1e-6);
            let lost = found.shear_loss.expect("it bends");
            assert!(lost > 0.0 && lost < 0.025, "{structure}: {lost}");
            assert_eq!(found.notes.iter().any(|n| n.contains("Poisson")), (poisson - 1.0 / 3.0).abs() > 0.01);
        }
    }
    // Cells that are not square: exact up to a ratio of √3, beyond which one family of springs
    // would need a negative stiffness.
    for rows in [21, 30, 15] {
        let base = square(DoubleDiagonal, 21, LEFT);
        let found = calibrate(&CalibrationRequest { grid: (21, 2, rows), ..base }).expect("valid").delivered;
        assert!(found.bends_within(1e-6), "{rows}: {:?}", found.bending);
    }
}

#[test]
fn limits_of_a_structure_are_reported() {
    let of = |structure: StructureKind, layers: u32| {
        let base = CalibrationRequest::new(structure, (21, layers, 21), (0.25, 0.25), target(0.38), AREAL);
        calibrate(&base).expect("valid").delivered
    };
    let says = |found: &DeliveredRatios, what: &str| found.notes.iter().any(|n| n.contains(what));
    let samm = of(Samm, 2);
    assert_eq!(samm.twist, 0.0);
    assert!(says(&samm, "no twist stiffness") && (samm.bending[0] - 1.0).abs() < 1e-6);
    let slamm = of(Slamm, 2);
    assert!(slamm.bend_to_twist > 0.1 && slamm.residual > 0.1 && says(&slamm, "bending turns into twist"));
    let provot = of(Provot2d, 1);
    assert_eq!(provot.bending, [0.0; 4]);
    assert!(
        (provot.membrane - 1.0).abs() < 1e-6 && provot.shear_loss.is_none() && says(&provot, "no bending stiffness")
    );
    // On a square of 21 x 21 the triangles are too high; the note names the rows that fit.
    let trimm = of(Trimm, 2);
    assert!(!trimm.bends_within(0.005) && says(&trimm, "nearest with 25 rows"));
    // Membrane: soft with two layers, as requested with three.
    assert!(samm.membrane < 0.02 && says(&samm, "times softer"));
    let three = of(DoubleDiagonal, 3);
    assert!((three.membrane - 1.0).abs() < 0.01 && three.bends_within(1e-4), "{three:?}");
}

#[test]
fn every_structure_is_calibrated_with_any_layers_it_has() {
    for row in TABLE {
        for layers in (row.layers.0..=row.layers.1.min(6)).chain([row.layers.1.min(12)]) {
            for cross_over in [false, row.cross_over] {
                let clamped = ClampedEdges { left: true, front: true, ..ClampedEdges::default() };
                let base = CalibrationRequest::new(row.kind, (7, layers, 6), (0.2, 0.1), target(0.3), AREAL);
                let found = calibrate(&CalibrationRequest { cross_over, clamped, ..base }).expect("valid");
                assert_eq!(found.stiffness.len(), found.lattice.links.len());
                let sound = |k: &f64| k.is_finite() && *k >= 0.0;
                assert!(found.stiffness.iter().all(sound), "{} {layers}", row.name);
                assert!(found.walls.iter().all(|w| sound(&w.stiffness)) && found.braces.iter().all(|(_, k)| sound(k)));
                assert!((found.mass.iter().sum::<f64>() - AREAL * 0.02).abs() < 1e-12);
                assert!(found.delivered.residual.is_finite() && !found.delivered.bending[0].is_nan());
                let bends = if layers == 1 && row.kind != StructureKind::Shell { 0.0 } else { 1.0 };
                assert!(
                    (found.delivered.bending[0] - bends).abs() < 0.2,
                    "{} {layers} {:?}",
                    row.name,
                    found.delivered
                );
            }
        }
    }
}

#[test]
fn free_edges_miss_no_width() {
    for structure in [DoubleDiagonal, Trimm, Provot3d, Slamm, Samm] {
        for gap in [None, Some(0.5 * 0.0125)] {
            let found = calibrate(&CalibrationRequest { gap, ..square(structure, 21, LEFT) }).expect("valid").delivered;
            let (bend, twist) = found.missing_sides;
            assert!(bend.abs() < 2e-4 && twist.abs() < 2e-4, "{structure}: {bend} m, {twist} m");
        }
    }
    // Zigzag ends have no row to adjust: the sheet ends a third of a spacing inside each, and a
    // note says so.
    let found = calibrate(&square(Trimm, 21, LEFT)).expect("valid").delivered;
    let spacing = 0.25 / 20.5;
    assert!((found.missing_ends.0 / spacing + 2.0 / 3.0).abs() < 0.02, "{:?}", found.missing_ends);
    assert!(found.notes.iter().any(|n| n.contains("zigzag")));
}

#[test]
fn orthotropic_bending_is_fitted_where_central_springs_can() {
    // Cloth whose twist stiffness is that of central springs along its two bending stiffnesses.
    let (warp, weft) = (12e-6_f64, 6e-6_f64);
    let poisson = 0.25;
    let data = Orthotropic {
        young_warp: 4000.0,
        young_weft: 2000.0,
        shear: 40.0,
        poisson,
        bending_warp: warp,
        bending_weft: weft,
        twist: (poisson * poisson * 0.5 * warp * weft).sqrt(),
        ..Orthotropic::default()
    };
    let target = StiffnessTarget::orthotropic(&data).expect("valid");
    let found = calibrate(&CalibrationRequest { target, ..square(DoubleDiagonal, 21, LEFT) }).expect("valid").delivered;
    assert!(found.bends_within(1e-6) && (found.twist - 1.0).abs() < 1e-6, "{found:?}");
    // Twist that springs cannot represent enters the residual; the stiffness along warp and weft is
    // kept.
    let data = Orthotropic { twist: 0.0, poisson: 0.0, ..data };
    let target = StiffnessTarget::orthotropic(&data).expect("valid");
    let found = calibrate(&CalibrationRequest { target, ..square(DoubleDiagonal, 21, LEFT) }).expect("valid").delivered;
    assert!((found.bending[0] - 1.0).abs() < 1e-6 && (found.bending[2] - 1.0).abs() < 1e-6 && found.residual < 1e-6);
}

#[test]
fn a_clamped_square_rings_as_a_clamped_plate() {
    // λ = ω a² √(ρ t/D) = 35.985 for any Poisson's ratio. The error falls with the square of the
    // spacing.
    let all = ClampedEdges { left: true, right: true, back: true, front: true };
    for structure in [DoubleDiagonal, Trimm] {
        let error = [11, 21].map(|n| {
            let request = square(structure, n, all);
            let found = calibrate(&request).expect("valid");
            let frequency = Linear::new(&found, |_, _| false).frequency();
            let scale = request.size.0 * request.size.1 * (AREAL / request.target.largest_bending()).sqrt();
            frequency * scale / 35.985 - 1.0
        });
        assert!(error[0].abs() < 0.045 && error[1].abs() < 0.012, "{structure}: {error:?}");
    }
}

#[test]
fn a_cantilever_square_rings_as_a_cantilever_plate() {
    // λ = 3.471 for a Poisson's ratio of 0.3 (Bardell, J. Sound Vib. 151, 1991); 1/3 is about 0.3 %
    // lower.
    for structure in [DoubleDiagonal, Trimm] {
        let request = square(structure, 21, LEFT);
        let found = calibrate(&request).expect("valid");
        let frequency = Linear::new(&found, |_, _| false).frequency();
        let lambda = frequency * 0.0625 * (AREAL / request.target.largest_bending()).sqrt();
        assert!((lambda / 3.471 - 1.0).abs() < 0.007, "{structure}: {lambda}");
    }
}

#[test]
fn a_narrow_strip_bends_as_a_beam() {
    // Four cells wide: without the edge factors a quarter of the width would be missing. EI = D
    // (1-ν²) W.
    for structure in [DoubleDiagonal, Trimm] {
        let request = request(structure, 41, 4, LEFT);
        let found = calibrate(&request).expect("valid");
        let sheet = Linear::new(&found, |_, _| false);
        let stiffness = request.target.largest_bending() * (1.0 - 1.0 / 9.0);
        // Cantilever under its weight: q L⁴/(8 EI); first frequency 1.8751² √(EI/(ρA L⁴)). The wall
        // also suppresses the transverse curvature that beam theory leaves free, which makes a
        // strip a tenth as wide as long 1 % stiffer.
        let weight = 9.81 * AREAL;
        let tips = found.lattice.positions.iter().zip(sheet.sag(9.81)).filter(|(p, _)| p.x > 0.125 - 1e-9);
        let tips: Vec<f64> = tips.map(|(_, sag)| sag).collect();
        let tip = tips.iter().sum::<f64>() / tips.len() as f64 / (weight * 0.25_f64.powi(4) / (8.0 * stiffness));
        assert!((tip - 1.0).abs() < 0.025, "{structure}: {tip}");
        let lambda = sheet.frequency() * 0.0625 * (AREAL / stiffness).sqrt() / 1.8751_f64.powi(2);
        assert!((lambda - 1.0).abs() < 0.015, "{structure}: {lambda}");
    }
}

#[test]
fn a_supported_strip_sags_as_a_beam() {
    let request = request(DoubleDiagonal, 41, 4, ClampedEdges::default());
    let found = calibrate(&request).expect("valid");
    let stiffness = request.target.largest_bending() * (1.0 - 1.0 / 9.0);
    // Both end rows of the bottom layer rest on lines; two nodes prevent sliding and rotation.
    let end = |i: usize| found.lattice.layer_of[i] == 0 && found.lattice.positions[i].x.abs() > 0.125 - 1e-9;
    let held = |i: usize, axis: usize| (axis == 1 && end(i)) || (i == 0 && axis != 1) || (i == 40 && axis == 2);
    let middle = Linear::new(&found, held).sag(9.81)[2 * 41 + 20];
    let beam = 5.0 / 384.0 * 9.81 * AREAL * 0.25_f64.powi(4) / stiffness;
    assert!((middle / beam - 1.0).abs() < 0.005, "{}", middle / beam);
}

#[test]
fn huge_and_tiny_sheets_are_calibrated_alike() {
    let base = square(DoubleDiagonal, 3, LEFT);
    for scale in [4e-6, 1e2, 4e3] {
        let request = CalibrationRequest { size: (0.25 * scale, 0.25 * scale), ..base.clone() };
        let found = calibrate(&request).expect("valid").delivered;
        assert!(found.bends_within(1e-6) && found.missing_sides.0.abs() < 2e-3 * scale, "{found:?}");
    }
}

#[test]
fn bad_requests_are_refused_by_field() {
    let base = CalibrationRequest::new(Trimm, (11, 2, 11), (0.25, 0.25), target(0.3), AREAL);
    let refuse = |request: CalibrationRequest| calibrate(&request).expect_err("bad").field;
    assert_eq!(refuse(CalibrationRequest { areal_mass: -1.0, ..base.clone() }), "areal_mass");
    assert_eq!(refuse(CalibrationRequest { gap: Some(f64::NAN), ..base.clone() }), "gap");
    assert_eq!(refuse(CalibrationRequest { second_neighbour: 2e3, ..base.clone() }), "second_neighbour");
    assert_eq!(refuse(CalibrationRequest { grid: (1, 2, 3), ..base.clone() }), "grid.0");
    assert_eq!(refuse(CalibrationRequest { wavelength: Some(0.0), ..base.clone() }), "wavelength");
    let mut target = base.target;
    target.bending = Voigt::default();
    assert_eq!(refuse(CalibrationRequest { target, ..base }), "target");
}
