//! Sheets against sheets.

use glam::{DQuat, DVec3};

use crate::collision::narrow_phase::tests::*;

fn up(by: f64) -> DVec3 {
    DVec3::Y * by
}

#[test]
fn a_sheet_that_lies_on_another_is_met_by_the_masses_of_both() {
    let (large, small) = (square(9, 0.2), square(5, 0.06));
    let (under, over) = (ensure_collision_surface(9, &large), ensure_collision_surface(5, &small));
    // The rotation keeps nodes of one sheet off the mesh lines of the other.
    let turned = mapped(&small, |p| DQuat::from_rotation_y(0.4) * p + DVec3::new(0.003, 2.0 * HALF + 1e-6, 0.002));
    let end = shifted(&turned, up(-1e-4));
    let sheets = [moved(0, &under, &large, &large), moved(1, &over, &turned, &end)];
    let found = rows(&sheets, &[]);
    let of_small = found.iter().filter(|r| matches!(r.a, ContactSide::Sheet { sheet: 1, .. })).count();
    assert_eq!(of_small, 25);
    for row in &found {
        let sign = if matches!(row.a, ContactSide::Sheet { sheet: 1, .. }) { 1.0 } else { -1.0 };
        assert!(row.normal.distance(DVec3::Y * sign) < 1e-9);
        assert!((gap(row, &[&large, &end], &[]) + 1e-4 - 1e-6).abs() < 1e-9);
    }
    // Only nodes of the large sheet below the small one have constraints, and no edge crossings.
    assert!(found.len() < 25 + 9 && found.len() > 25);
}

#[test]
fn sheets_do_not_pass_each_other_at_20_m_per_s() {
    let flat = square(5, 0.06);
    let own = ensure_collision_surface(5, &flat);
    let tilted = mapped(&flat, |p| DQuat::from_rotation_z(0.5) * DQuat::from_rotation_y(0.3) * p);
    for side in [1.0, -1.0] {
        let start = shifted(&tilted, DVec3::new(0.004, 0.1 * side, 0.003));
        let end = shifted(&start, up(-20.0 / 60.0 * side));
        let sheets = [moved(0, &own, &flat, &flat), moved(1, &own, &start, &end)];
        let found = rows(&sheets, &[]);
        assert!(found.len() >= 25);
        for row in &found {
            // Each pair is apart at the start and crossed at the end.
            assert!(gap(row, &[&flat, &start], &[]) > 0.0 && gap(row, &[&flat, &end], &[]) < 0.0, "{row:?}");
        }
        // All nodes that fall on the inside of the sheet have constraints.
        let through = start.iter().filter(|p| p.x.abs() < 0.029 && p.z.abs() < 0.029).count();
        let met = found.iter().filter(|r| matches!(r.a, ContactSide::Sheet { sheet: 1, .. })).count();
        assert!(met >= through && through > 15, "{met} of {through}");
    }
}

#[test]
fn crossed_strips_meet_at_their_borders() {
    // Two crossing strips of one cell each; no node of either lies on the other.
    let cell = |x: f64, z: f64| {
        let mut v = Vectors::default();
        [(-x, -z), (x, -z), (-x, z), (x, z)].iter().for_each(|(x, z)| v.push(DVec3::new(*x, 0.0, *z)));
        v
    };
    let (long, wide) = (cell(0.05, 0.004), cell(0.004, 0.05));
    let (a, b) = (ensure_collision_surface(2, &long), ensure_collision_surface(2, &wide));
    let start = shifted(&wide, up(2.0 * HALF + 1e-6));
    let end = shifted(&start, up(-1e-3));
    let found = rows(&[moved(0, &a, &long, &long), moved(1, &b, &start, &end)], &[]);
    // Four crossings of borders; the diagonals are flat.
    assert_eq!(found.len(), 4);
    for row in &found {
        assert!(row.normal.distance(DVec3::NEG_Y) < 1e-9);
        assert!((gap(row, &[&long, &end], &[]) + 1e-3 - 1e-6).abs() < 1e-9);
    }
}

#[test]
fn sheets_side_by_side_push_each_other_in_their_plane() {
    let flat = square(5, 0.06);
    let own = ensure_collision_surface(5, &flat);
    let start = shifted(&flat, DVec3::new(0.06 + 2.0 * HALF + 1e-5, 0.0, 0.004));
    let end = shifted(&start, DVec3::new(-3e-4, 0.0, 0.0));
    let found = rows(&[moved(0, &own, &flat, &flat), moved(1, &own, &start, &end)], &[]);
    assert!(found.len() >= 4);
    for row in &found {
        let sign = if matches!(row.a, ContactSide::Sheet { sheet: 1, .. }) { 1.0 } else { -1.0 };
        assert!(row.normal.distance(DVec3::X * sign) < 1e-6, "{row:?}");
    }
}

#[test]
fn a_folded_sheet_meets_itself_and_a_curved_one_does_not() {
    let flat = square(21, 0.25);
    let own = ensure_collision_surface(21, &flat);
    // The sheet is rolled about an axis along z: half a turn places the halves 2 radii apart.
    let rolled = |radius: f64, turn: f64| {
        mapped(&flat, move |p| {
            let angle = (p.x / radius).clamp(-0.5 * turn, 0.5 * turn);
            let beyond = p.x - angle * radius;
            let (sin, cos) = angle.sin_cos();
            DVec3::new(radius * sin + beyond * cos, radius * (1.0 - cos) + beyond * sin, p.z)
        })
    };
    let open = rolled(0.05, 3.0);
    assert!(rows(&[moved(0, &own, &open, &open)], &[]).is_empty());
    // Two flat halves 4 half thicknesses apart, joined by a bend.
    let start = rolled(2.0 * HALF, std::f64::consts::PI);
    let pressed = mapped(&start, |p| DVec3::new(0.4 * p.x, p.y, p.z));
    let found = rows(&[SheetStageMotion { base: &start, ..moved(0, &own, &start, &pressed) }], &[]);
    assert!(found.len() > 150, "{}", found.len());
    for row in &found {
        assert!(row.normal.x.abs() > 0.9, "{row:?}");
        let before = gap(row, &[&start], &[]);
        assert!(before > -1e-5, "{before} {row:?}");
    }
}

#[test]
fn flat_and_sleeping_sheets_look_at_no_triangles() {
    let flat = square(11, 0.1);
    let own = ensure_collision_surface(11, &flat);
    let bent = mapped(&flat, |p| DVec3::new(p.x, 4.0 * p.x * p.x, p.z));
    // A sheet over a ball, whose sides are inclined by 69°.
    let draped = mapped(&flat, |p| {
        let r = (p.x * p.x + p.z * p.z).sqrt().max(1e-12);
        let angle = (r / 0.05).min(1.2);
        let down = 0.05 * (1.0 - angle.cos()) + (r - 0.05 * angle) * angle.sin();
        let out = (0.05 * angle.sin() + (r - 0.05 * angle) * angle.cos()) / r;
        DVec3::new(out * p.x, -down, out * p.z)
    });
    let sunk = mapped(&draped, |p| DVec3::new(p.x, 1.2 * p.y, p.z));
    let far = shifted(&flat, up(1.0));
    let touching = shifted(&flat, up(2.0 * HALF));
    let count = |sheets: &[SheetStageMotion]| {
        let problem = DetectionInput {
            sheets,
            bodies: &[],
            margin: MARGIN,
            fall: 0.0,
            between: Some(MARGIN),
            surfaces: &|_| (0.0, 0.0),
        };
        let mut finder = CollisionDetector::default();
        finder.run_broad_phase(&problem, 0.1);
        finder.detect_contacts(&problem, &mut Vec::new());
        let counters = finder.counters();
        counters.self_tests + counters.sheet_sheet_tests
    };
    let awake = |x| moved(0, &own, x, x);
    let asleep = |x| SheetStageMotion { awake: false, ..moved(1, &own, x, x) };
    assert_eq!(count(&[awake(&flat), awake(&far)]), 0);
    assert_eq!(count(&[awake(&bent)]), 0);
    assert_eq!(count(&[moved(0, &own, &draped, &sunk)]), 0);
    // A sheet that is folded, or becomes folded, is tested.
    let folded = mapped(&flat, |p| DVec3::new(p.x.abs(), 0.1 * p.x, p.z));
    assert!(count(&[moved(0, &own, &draped, &folded)]) > 0);
    assert!(count(&[awake(&folded)]) > 0);
    assert_eq!(count(&[asleep(&flat), asleep(&touching)]), 0);
    assert!(count(&[awake(&flat), asleep(&touching)]) > 0);
}

fn is_edge(side: &ContactSide) -> bool {
    matches!(side, ContactSide::Sheet { point, .. } if point.weights.iter().filter(|w| **w > 0.0).count() == 2)
}

/// Edge orientation is evaluated at the time of impact: a corner rises below the border of a card
/// that turns within the stage.
#[test]
fn borders_that_turn_in_the_stage_meet_as_they_then_lean() {
    let cell = |x: [f64; 2], z: [f64; 2]| {
        let mut v = Vectors::default();
        [(0, 0), (1, 0), (0, 1), (1, 1)].iter().for_each(|(i, j)| v.push(DVec3::new(x[*i], 0.0, z[*j])));
        v
    };
    let leaning = |x: &Vectors, degrees: f64, height: f64| {
        mapped(x, |p| DQuat::from_rotation_z(f64::to_radians(degrees)) * p + up(height))
    };
    let (low, high) = (cell([0.0, 0.03], [-0.02, 0.02]), cell([-0.02, 0.02], [-0.004, 0.03]));
    let (under, over) = (ensure_collision_surface(2, &low), ensure_collision_surface(2, &high));
    let low = [leaning(&low, 36.0, 0.0), leaning(&low, 26.0, 0.0)];
    let high = [leaning(&high, 32.0, 5e-3), leaning(&high, 29.0, -3e-4)];
    let found = rows(&[moved(0, &under, &low[0], &low[1]), moved(1, &over, &high[0], &high[1])], &[]);
    let crossed = |row: &&ContactConstraint| {
        let [start, end] = [0, 1].map(|k| gap(row, &[&low[k], &high[k]], &[]));
        is_edge(&row.a) && is_edge(&row.b) && start > 1e-3 && end < -2e-4
    };
    assert_eq!(found.iter().filter(crossed).count(), 1, "{found:#?}");
}

/// Two sheets that lie on each other fold along lines that cross between their nodes.
#[test]
fn sheets_that_fold_within_the_stage_are_found_with_crossing_detection() {
    let flat = square(5, 0.08);
    let own = ensure_collision_surface(5, &flat);
    let start = shifted(&flat, DVec3::new(0.005, 2.0 * HALF + 1e-6, 0.01));
    let fold = |x: &Vectors, height: &dyn Fn(DVec3) -> f64| mapped(x, |p| p + up(height(p)));
    let below = fold(&flat, &|p| -0.2 * p.z.abs());
    let above = fold(&start, &|p| 0.2 * (p.x - 0.005).abs() - 4e-4);
    let through = fold(&start, &|p| 0.2 * (p.x - 0.005).abs() - 3.0 * HALF);
    let look = |under: [&Vectors; 2], over: [&Vectors; 2], crossings: bool| {
        let sheets = [moved(0, &own, under[0], under[1]), moved(1, &own, over[0], over[1])];
        let problem = DetectionInput {
            sheets: &sheets,
            bodies: &[],
            margin: MARGIN,
            fall: 0.0,
            between: Some(MARGIN),
            surfaces: &|_| (0.3, 0.1),
        };
        let mut finder = CollisionDetector::default();
        finder.set_detect_crossings(crossings);
        finder.run_broad_phase(&problem, 0.1);
        let mut found = Vec::new();
        finder.detect_contacts(&problem, &mut found);
        let edges = found.iter().filter(|row| is_edge(&row.a) && is_edge(&row.b)).count();
        (edges, finder.has_interpenetration())
    };
    assert_eq!(look([&flat, &below], [&start, &above], false), (0, false));
    assert_eq!(look([&flat, &below], [&start, &above], true), (1, false));
    assert!(look([&flat, &below], [&start, &through], true).1);
    assert!(!look([&flat, &below], [&start, &through], false).1, "nobody asked");
    assert!(!look([&below, &below], [&through, &through], true).1, "they began so");
}

/// Two cards inclined away from each other touch border to border at an angle of 4°, where neither
/// surface normal gives the contact direction.
#[test]
fn borders_that_run_nearly_side_by_side_meet_head_on() {
    let card = |into: DVec3| {
        let mut v = Vectors::default();
        [(0.0, -1.0), (1.0, -1.0), (0.0, 1.0), (1.0, 1.0)]
            .iter()
            .for_each(|(along, across)| v.push(into * (0.02 * along) + DVec3::Z * (0.016 * across)));
        v
    };
    let apart = DVec3::new(0.8, 0.6, 0.0);
    let (right, left) = (card(DVec3::new(0.8, -0.6, 0.0)), card(DVec3::new(-0.9, -0.4, 0.0).normalize()));
    let (one, other) = (ensure_collision_surface(2, &right), ensure_collision_surface(2, &left));
    let askew = mapped(&left, |p| DQuat::from_axis_angle(apart, 0.07) * p);
    for (from, to) in [(2.0 * HALF + 1e-4, 2.0 * HALF - 1e-4), (1.4 * HALF, HALF), (5e-3, -5e-3)] {
        let [start, end] = [from, to].map(|distance| shifted(&askew, -apart * distance));
        let found = rows(&[moved(0, &one, &right, &right), moved(1, &other, &start, &end)], &[]);
        let mut edges = found.iter().filter(|row| is_edge(&row.a) && is_edge(&row.b));
        let row = edges.next().expect("a row of the borders");
        assert!(row.normal.dot(apart) > 0.99, "{row:?}");
        assert!(
            (gap(row, &[&right, &end], &[]) - (to - 2.0 * HALF)).abs() < 2e-5 * (1.0 + 1e3 * (from - to).abs()),
            "{row:?}"
        );
    }
}

/// The border of a card lies on that of another, 0.6 mm from a corner. The contact of the corner
/// with the face of the card has another normal.
#[test]
fn borders_that_meet_near_an_end_meet_along_their_own_normal() {
    let card = |at: DVec3, into: DVec3, along: DVec3| {
        let mut v = Vectors::default();
        for (j, i) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)] {
            v.push(at + into * (0.04 * i) + along * (0.03 * j));
        }
        v
    };
    let lying = card(DVec3::ZERO, DVec3::X, -DVec3::Z);
    let up = DVec3::new(-0.8, 0.6, 0.0);
    let leaning = card(DVec3::new(6e-4, 2.0 * HALF + 1e-5, -0.03 + 4e-4), up, DVec3::Z);
    let end = shifted(&leaning, DVec3::Y * -1e-4);
    let (under, over) = (ensure_collision_surface(2, &lying), ensure_collision_surface(2, &leaning));
    let found = rows(&[moved(0, &under, &lying, &lying), moved(1, &over, &leaning, &end)], &[]);
    let holds = |row: &&ContactConstraint| is_edge(&row.a) && is_edge(&row.b) && row.normal.y.abs() > 0.99;
    assert!(found.iter().any(|row| holds(&row)), "{found:#?}");
}

/// Cards of a pack lie over each other with nearly parallel borders. Their nodes have constraints,
/// and no constraint of the borders is oblique.
#[test]
fn borders_of_cards_that_lie_one_over_the_other_are_not_met_aslant() {
    let card = |yaw: f64, at: DVec3| {
        let mut v = Vectors::default();
        for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            v.push(at + DQuat::from_rotation_y(yaw) * DVec3::new(0.044 * x, 0.0, 0.0315 * z));
        }
        v
    };
    let lower = card(0.0, DVec3::ZERO);
    for aside in [DVec3::ZERO, DVec3::new(4e-4, 0.0, -3e-4), DVec3::new(-2e-3, 0.0, 1e-3)] {
        let upper = card(0.03, aside + DVec3::Y * (2.0 * HALF + 1e-6));
        let end = shifted(&upper, DVec3::Y * -1e-4);
        let (under, over) = (ensure_collision_surface(2, &lower), ensure_collision_surface(2, &upper));
        let found = rows(&[moved(0, &under, &lower, &lower), moved(1, &over, &upper, &end)], &[]);
        let mut edges = found.iter().filter(|row| is_edge(&row.a) && is_edge(&row.b));
        assert!(!found.is_empty() && edges.all(|row| row.normal.y.abs() > 0.999), "{found:#?}");
    }
}
