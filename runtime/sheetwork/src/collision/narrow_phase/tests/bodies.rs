//! Sheets against bodies.

use glam::{DQuat, DVec3};
use rapier3d::prelude::SharedShape;

use crate::collision::features::ColliderPart;
use crate::collision::narrow_phase::tests::*;

/// A box with these half sides (m) and its top at y = 0.
fn cuboid(x: f64, y: f64, z: f64) -> ColliderFeatures {
    let corners: Vec<DVec3> = (0..8)
        .map(|i| {
            DVec3::new(
                if i & 1 == 0 { -x } else { x },
                if i & 2 == 0 { -2.0 * y } else { 0.0 },
                if i & 4 == 0 { -z } else { z },
            )
        })
        .collect();
    let sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles: Vec<[u32; 3]> = sides.iter().flat_map(|[a, b, c, d]| [[*a, *c, *b], [*a, *d, *c]]).collect();
    ColliderFeatures::from_solid(ColliderPart::from_triangles(&corners, &triangles).expect("a box"))
}

const HERE: [RigidFrame; 1] = [RigidFrame::IDENTITY];

fn up(by: f64) -> DVec3 {
    DVec3::Y * by
}

#[test]
fn a_sheet_on_a_box_has_node_constraints_on_the_top_and_edge_constraints_on_the_rim() {
    // 21 nodes 12.5 mm apart and a box whose rim lies between nodes: 7 by 7 of them are above it.
    let flat = square(21, 0.25);
    let skin = ensure_collision_surface(21, &flat);
    let features = cuboid(0.042, 0.05, 0.041);
    let start = shifted(&flat, up(HALF + 1e-6));
    let end = shifted(&flat, up(HALF - 1e-4));
    let found = rows(&[moved(3, &skin, &start, &end)], &[still(5, &features)]);
    let (masses, others): (Vec<_>, Vec<_>) = found.iter().partition(|r| carriers(r) == 1);
    assert_eq!(masses.len(), 49);
    // Each side of the rim crosses 7 grid lines and, in 8 cells with parts of diagonals, at least 6
    // more edges.
    let edges = others.iter().filter(|r| carriers(r) == 2).count();
    assert!((4 * 13..=4 * 15).contains(&edges), "{edges}");
    assert_eq!(others.len() - edges, 4);
    for row in &found {
        assert!(row.normal.distance(DVec3::Y) < 1e-9, "{row:?}");
        assert!((gap(row, &[&end], &HERE) + 1e-4).abs() < 1e-9);
    }
}

#[test]
fn constraints_of_a_resting_sheet_persist() {
    let flat = square(21, 0.25);
    let skin = ensure_collision_surface(21, &flat);
    // The rim lies exactly below a line of nodes.
    let features = cuboid(0.05, 0.05, 0.05);
    let wave = |phase: f64| {
        mapped(&flat, move |p| p + up(HALF + 2e-6 * (300.0 * p.x + phase).sin() * (200.0 * p.z - phase).cos()))
    };
    let end = shifted(&flat, up(HALF - 3e-5));
    let mut keys: Vec<Vec<ContactKey>> = Vec::new();
    for phase in 0..8 {
        let start = wave(f64::from(phase));
        let found = rows(&[moved(0, &skin, &start, &end)], &[still(0, &features)]);
        let falls = |r: &&ContactConstraint| r.normal.y < 0.999;
        assert_eq!(found.iter().find(falls), None);
        keys.push(found.iter().map(|r| r.key).collect());
    }
    assert!(keys.iter().all(|k| *k == keys[0]));
    // 9 by 9 nodes on the top.
    assert!(keys[0].len() >= 81);
}

#[test]
fn a_sheet_that_hangs_beside_a_box_is_not_lifted_to_its_top() {
    let flat = square(11, 0.2);
    let skin = ensure_collision_surface(11, &flat);
    let features = cuboid(0.05, 0.05, 0.2);
    // The sheet is upright; its plane touches the side x = 0.05, and half of it is above the top.
    let upright = mapped(&flat, |p| DVec3::new(0.05 + HALF + 1e-6, p.x, p.z));
    for fall in [0.0, 1e-3, 5e-3, 0.03] {
        for push in [0.0, 1e-4, 2e-3] {
            let end = shifted(&upright, DVec3::new(-push, -fall, 0.0));
            for row in rows(&[moved(0, &skin, &upright, &end)], &[still(0, &features)]) {
                assert!(row.normal.distance(DVec3::X) < 1e-9, "{fall} {push}: {row:?}");
                assert!(gap(&row, &[&upright], &HERE) > -1e-5);
            }
        }
    }
}

#[test]
fn a_sheet_that_slides_over_a_rim_stays_on_the_top() {
    let flat = square(11, 0.2);
    let skin = ensure_collision_surface(11, &flat);
    let features = cuboid(0.05, 0.05, 0.05);
    for (x, z) in [(0.0, 0.0), (0.011, 0.0), (0.0491, 0.0499), (-0.031, 0.07)] {
        let start = shifted(&flat, DVec3::new(x, HALF + 1e-6, z));
        for (u, w) in [(5e-3, 0.0), (-5e-3, 2e-3), (0.02, 0.02), (-0.02, 1e-3)] {
            let end = shifted(&start, DVec3::new(u, -4e-4, w));
            let found = rows(&[moved(0, &skin, &start, &end)], &[still(0, &features)]);
            assert!(found.len() > 20);
            for row in found {
                assert!(row.normal.distance(DVec3::Y) < 1e-6, "{x} {z} {u} {w}: {row:?}");
            }
        }
    }
}

#[test]
fn a_needle_and_a_ridge_are_detected_between_nodes() {
    let flat = square(5, 0.1);
    let skin = ensure_collision_surface(5, &flat);
    // A pyramid with its apex at the origin, 2 mm wide and 40 mm high.
    let base = [(-1e-3, -1e-3), (1e-3, -1e-3), (1e-3, 1e-3), (-1e-3, 1e-3)];
    let mut corners: Vec<DVec3> = base.iter().map(|(x, z)| DVec3::new(*x, -0.04, *z)).collect();
    corners.push(DVec3::ZERO);
    let triangles = [[0, 1, 2], [0, 2, 3], [0, 4, 1], [1, 4, 2], [2, 4, 3], [3, 4, 0]];
    let needle = ColliderFeatures::from_solid(ColliderPart::from_triangles(&corners, &triangles).expect("a pyramid"));
    let start = shifted(&flat, DVec3::new(0.008, HALF + 1e-5, 0.004));
    for fall in [1e-4, 1e-2, 0.3] {
        let end = shifted(&start, up(-fall));
        let found = rows(&[moved(0, &skin, &start, &end)], &[still(0, &needle)]);
        let point = found.iter().find(|r| carriers(r) == 3).expect("the point is felt");
        assert!(point.normal.distance(DVec3::Y) < 1e-9);
        assert!(place(&point.a, &[&start], &HERE).distance(DVec3::Y * start.y[0]) < 1e-12);
        assert!(found.iter().all(|r| gap(r, &[&start], &HERE) > -1e-9));
    }
    // A wedge with its ridge along z, beside a line of nodes.
    let section = [DVec3::new(-0.015, -0.016, 0.0), DVec3::new(0.015, -0.016, 0.0), DVec3::ZERO];
    let ends = [-0.05, 0.05].map(|z| section.map(|p| p + DVec3::Z * z));
    let corners: Vec<DVec3> = ends.into_iter().flatten().collect();
    let triangles = [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]];
    let wedge = ColliderFeatures::from_solid(ColliderPart::from_triangles(&corners, &triangles).expect("a wedge"));
    let start = shifted(&flat, DVec3::new(0.01, HALF + 1e-5, 0.001));
    let end = shifted(&start, up(-1e-3));
    let found = rows(&[moved(0, &skin, &start, &end)], &[still(0, &wedge)]);
    assert!(found.iter().filter(|r| carriers(r) == 2).count() >= 8);
    assert!(found.iter().all(|r| carriers(r) == 1 || r.normal.distance(DVec3::Y) < 1e-9));
}

#[test]
fn a_corner_is_felt_where_a_sheet_slides_and_turns_over_it() {
    let flat = square(5, 0.1);
    let skin = ensure_collision_surface(5, &flat);
    let features = cuboid(0.05, 0.05, 0.05);
    let corner = DVec3::new(0.05, 0.0, 0.05);
    let normal = DVec3::new(1.0, 1.0, 1.0).normalize();
    let leant = DQuat::from_rotation_arc(DVec3::Y, normal);
    for (slide, turn) in [(7e-3, 0.15), (7e-3, -0.15), (-5e-3, 0.2), (-5e-3, -0.2)] {
        // The corner is below the inside of a triangle that slides by `slide` and turns about the
        // corner.
        let placed = |slide: f64, turn: f64, height: f64| {
            let turn = DQuat::from_axis_angle(leant * DVec3::Z, turn) * leant;
            mapped(&flat, |p| corner + turn * (p + DVec3::new(0.009 + slide, height, 0.004)))
        };
        let start = placed(0.0, 0.0, HALF + 1e-6);
        let (base, end) = (placed(slide, turn, HALF), placed(slide, turn, HALF - 1e-3));
        let sheet = SheetStageMotion { base: &base, ..moved(0, &skin, &start, &end) };
        let found = rows(&[sheet], &[still(0, &features)]);
        let row = found.iter().find(|r| carriers(r) == 3).expect("the corner is felt");
        let wanted = DQuat::from_axis_angle(leant * DVec3::Z, turn) * normal;
        assert!(row.normal.distance(wanted) < 1e-9 && (gap(row, &[&end], &HERE) + 1e-3).abs() < 1e-9, "{row:?}");
    }
}

#[test]
fn a_sharp_fold_is_felt_on_a_rim() {
    let flat = square(5, 0.1);
    let skin = ensure_collision_surface(5, &flat);
    let features = cuboid(0.05, 0.05, 0.2);
    // The sheet is folded along its middle line, which crosses the rim at x = 0.05 obliquely, from
    // both halves upright to both halves inclined.
    for (open, back) in [(0.1, 0.0_f64), (0.3, 0.7), (0.1, -1.2), (0.05, 1.2)] {
        let folded = |height: f64| {
            mapped(&flat, move |p| {
                let (side, along) = (p.x.abs(), DVec3::new(1.0, 0.0, 1.0).normalize());
                let across = DVec3::new(1.0, 0.0, -1.0).normalize();
                let up = DVec3::Y * back.cos() + across * back.sin();
                let out = across * back.cos() - DVec3::Y * back.sin();
                DVec3::new(0.05, HALF + height, 0.003)
                    + along * (p.z + 0.007)
                    + up * side * f64::cos(open)
                    + out * p.x * f64::sin(open)
            })
        };
        let (start, end) = (folded(1e-6), folded(-5e-4));
        let found = rows(&[moved(0, &skin, &start, &end)], &[still(0, &features)]);
        let felt = found.iter().any(|r| carriers(r) == 2 && gap(r, &[&end], &HERE) < -3e-4 && r.normal.y > 0.6);
        assert!(felt, "{open} {back}: {found:#?}");
    }
}

#[test]
fn a_sheet_that_cuts_across_a_rim_gets_edge_constraints() {
    let flat = square(5, 0.1);
    let skin = ensure_collision_surface(5, &flat);
    let features = cuboid(0.05, 0.05, 0.2);
    // The last line of nodes moves over the rim and down, less than 1 mm inside the box on its way.
    let start = shifted(&flat, DVec3::new(-0.0009, HALF + 1e-6, 0.0));
    let end = mapped(&flat, |p| p + DVec3::new(0.0031, HALF - if p.x > 0.04 { 3.3e-3 } else { 0.0 }, 0.0));
    let found = rows(&[moved(0, &skin, &start, &end)], &[still(0, &features)]);
    let held = |z: f64| {
        found.iter().any(|r| {
            let at = place(&r.a, &[&end], &HERE);
            (at.z - z).abs() < 1e-6 && (at.x - 0.05).abs() < 2e-3 && gap(r, &[&end], &HERE) < -2e-3 && r.normal.x >= 0.0
        })
    };
    assert!([-0.05, -0.025, 0.0, 0.025, 0.05].into_iter().all(held), "{found:#?}");
}

#[test]
fn a_ball_is_met_where_it_is_round() {
    let flat = square(9, 0.2);
    let skin = ensure_collision_surface(9, &flat);
    let radius = 0.03;
    let ball = ColliderFeatures::from_shape(SharedShape::ball(0.03).0.as_ref());
    let start = shifted(&flat, DVec3::new(0.004, 0.03 + HALF + 1e-6, 0.009));
    let end = shifted(&start, up(-1e-3));
    let found = rows(&[moved(0, &skin, &start, &end)], &[still(0, &ball)]);
    // The triangle above the pole is known.
    let deepest = found.iter().min_by(|a, b| gap(a, &[&end], &HERE).total_cmp(&gap(b, &[&end], &HERE)));
    let deepest = deepest.expect("a row");
    assert!(deepest.normal.distance(DVec3::Y) < 1e-7 && (gap(deepest, &[&end], &HERE) + 1e-3 - 1e-6).abs() < 1e-8);
    // The ball comes from either side, from afar and fast.
    for side in [1.0, -1.0] {
        let mut body = still(0, &ball);
        body.start.origin = up(0.2 * side);
        (body.base, body.end.origin, body.awake) = (body.start, up(-0.2 * side), true);
        let found = rows(&[moved(0, &skin, &flat, &flat)], &[body]);
        assert!(!found.is_empty());
        for row in found {
            assert!(row.normal.y * side < 0.0, "{row:?}");
            let before = gap(&row, &[&flat], &[body.start]);
            assert!(before > 0.1 && before < 0.2 - radius + 1e-3);
        }
    }
}

#[test]
fn nothing_passes_a_thin_plate_at_20_m_per_s() {
    let flat = square(11, 0.1);
    let skin = ensure_collision_surface(11, &flat);
    let plate = cuboid(0.2, 5e-4, 0.2);
    let step = 20.0 / 60.0;
    for side in [1.0, -1.0] {
        // The tilted sheet moves to the plate, and the plate to the sheet.
        let turned = mapped(&flat, |p| DQuat::from_rotation_x(0.3) * p);
        let start = shifted(&turned, up(0.1 * side));
        let end = shifted(&start, up(-step * side));
        let found = rows(&[moved(0, &skin, &start, &end)], &[still(0, &plate)]);
        assert_eq!(found.iter().filter(|r| carriers(r) == 1).count(), 121);
        assert!(found.iter().all(|r| r.normal.y * side > 0.99 && gap(r, &[&start], &HERE) > 0.0));
        let mut body = still(0, &plate);
        (body.end.origin, body.awake) = (up(step * side), true);
        let found = rows(&[moved(0, &skin, &start, &start)], &[body]);
        assert_eq!(found.iter().filter(|r| carriers(r) == 1).count(), 121);
        assert!(found.iter().all(|r| r.normal.y * side > 0.99 && gap(r, &[&start], &[body.start]) > 0.0));
    }
    // A bar narrower than a cell hits the sheet between nodes with its edges.
    let bar = cuboid(0.002, 5e-4, 0.03);
    let mut body = still(0, &bar);
    (body.start.origin, body.awake) = (DVec3::new(0.005, -0.1, 0.0), true);
    (body.base, body.end) = (body.start, RigidFrame { origin: DVec3::new(0.005, step - 0.1, 0.0), ..body.start });
    let found = rows(&[moved(0, &skin, &flat, &flat)], &[body]);
    assert!(found.iter().filter(|r| carriers(r) == 2).count() > 8);
    assert!(found.iter().all(|r| r.normal.y > 0.99));
}

#[test]
fn a_floor_and_a_cylinder_hold_from_above() {
    let flat = square(11, 0.1);
    let skin = ensure_collision_surface(11, &flat);
    let floor = ColliderFeatures::from_shape(SharedShape::halfspace(glam::Vec3::Y).0.as_ref());
    let end = shifted(&flat, up(-0.2));
    let found = rows(&[moved(0, &skin, &shifted(&flat, up(HALF)), &end)], &[still(0, &floor)]);
    assert_eq!(found.len(), 121);
    assert!(found.iter().all(|r| (gap(r, &[&end], &HERE) + 0.2 + HALF).abs() < 1e-12));
    // A cylinder along z; its surface has many faces.
    let cylinder = ColliderFeatures::from_shape(SharedShape::cylinder(0.1, 0.03).0.as_ref());
    let mut body = still(0, &cylinder);
    body.start = RigidFrame::from_parts(up(-0.03), DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2));
    (body.base, body.end) = (body.start, body.start);
    let start = shifted(&flat, DVec3::new(0.003, HALF + 1e-6, 0.001));
    let end = shifted(&start, up(-1e-3));
    let found = rows(&[moved(0, &skin, &start, &end)], &[body]);
    let worst = found.iter().map(|r| gap(r, &[&end], &[body.end])).fold(0.0, f64::min);
    assert!(found.len() > 11 && worst < -9e-4 && worst > -1.05e-3, "{worst}");
    // At the lowest contact the normal deviates by up to half a facet.
    assert!(found.iter().filter(|r| gap(r, &[&end], &[body.end]) < -8e-4).all(|r| r.normal.y > 0.98));
}

#[test]
fn distant_or_sleeping_pairs_are_not_tested() {
    let flat = square(11, 0.1);
    let skin = ensure_collision_surface(11, &flat);
    let features = cuboid(0.05, 0.05, 0.05);
    let count = |height: f64, awake: bool| {
        let start = shifted(&flat, up(height));
        let sheet = SheetStageMotion { awake, ..moved(0, &skin, &start, &start) };
        let (sheets, bodies) = ([sheet], [still(0, &features)]);
        let problem = DetectionInput {
            sheets: &sheets,
            bodies: &bodies,
            margin: MARGIN,
            fall: 0.0,
            between: Some(MARGIN),
            surfaces: &|_| (0.0, 0.0),
        };
        let mut finder = CollisionDetector::default();
        let mut out = Vec::new();
        finder.run_broad_phase(&problem, 0.1);
        finder.detect_contacts(&problem, &mut out);
        finder.counters()
    };
    let far = count(1.0, true);
    assert_eq!(far, DetectionCounters { boxes: 1, ..DetectionCounters::default() });
    assert_eq!(count(HALF, false), DetectionCounters::default());
    assert!(count(HALF, true).mass_body_tests > 0);
}
