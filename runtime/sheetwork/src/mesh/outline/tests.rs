//! Meshes of many shapes: fitted, complete, oriented, of bounded quality; and rejected
//! specifications.

use std::collections::BTreeSet;
use std::path::Path;

use crate::mesh::outline::triangulate::quality;
use crate::mesh::outline::*;

const SIZE: (f64, f64) = (0.25, 0.2);

fn outline(spec: &str, holes: &str, cuts: &str) -> Result<Outline, InputError> {
    let spec: Option<OutlineSpec> = (!spec.is_empty()).then(|| ron::from_str(spec).expect("an outline"));
    let holes: Vec<HoleSpec> = ron::from_str(if holes.is_empty() { "[]" } else { holes }).expect("holes");
    let cuts: Vec<Vec<(f64, f64)>> = ron::from_str(if cuts.is_empty() { "[]" } else { cuts }).expect("cuts");
    Outline::new(spec.as_ref(), &holes, &cuts, SIZE, Path::new(""))
}

/// Numbers of closed lines of boundary edges, and of pieces joined by edges.
fn topology(mesh: &TriangleMesh) -> (usize, usize) {
    let count = |joins: Vec<[u32; 2]>| {
        let mut root: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        fn find(root: &mut [u32], mut i: u32) -> u32 {
            while root[i as usize] != i {
                i = root[i as usize];
            }
            i
        }
        for [a, b] in &joins {
            let (a, b) = (find(&mut root, *a), find(&mut root, *b));
            root[a as usize] = b;
        }
        let touched: BTreeSet<u32> = joins.iter().flatten().copied().collect();
        touched.into_iter().map(|v| find(&mut root, v)).collect::<BTreeSet<_>>().len()
    };
    let boundary = mesh.edges.iter().filter(|e| e.is_boundary()).map(|e| e.nodes).collect();
    (count(boundary), count(mesh.edges.iter().map(|e| e.nodes).collect()))
}

fn worst(mesh: &TriangleMesh, cell: DVec2) -> f64 {
    let at = |v: u32| DVec2::from_array(mesh.positions[v as usize]) / cell;
    mesh.triangles.iter().map(|t| quality(t.map(at))).fold(f64::INFINITY, f64::min)
}

/// Check the properties of a mesh of an outline with `loops` closed boundary lines in `pieces`
/// pieces.
fn check(name: &str, outline: &Outline, grid: (u32, u32), (loops, pieces): (usize, usize)) -> TriangleMesh {
    let mesh = mesh(outline, grid).unwrap_or_else(|e| panic!("{name}: {e}"));
    let (low, high) = outline.bounds();
    let cell = (high - low) / DVec2::new(f64::from(grid.0 - 1), f64::from(grid.1 - 1));
    assert_eq!(topology(&mesh), (loops, pieces), "{name}");
    let missing = (mesh.total_area() / outline.area() - 1.0).abs();
    assert!(missing < 0.03, "{name}: area off by {missing}");
    let lumped: f64 = mesh.lumped.iter().sum();
    assert!((lumped / mesh.total_area() - 1.0).abs() < 1e-12, "{name}");
    let least = worst(&mesh, cell);
    assert!(least > 0.2, "{name}: worst quality {least}");
    for (p, border) in mesh.positions.iter().zip(&mesh.border) {
        let d = signed_distance(outline, DVec2::from_array(*p));
        assert!(d < 1e-9, "{name}: a mass {d} m outside");
        let on_cut = !outline.cuts().is_empty();
        assert!(!border || on_cut || d.abs() < 1e-9, "{name}: a mass of the boundary {d} m off it");
    }
    mesh
}

fn star(points: u32, inner: f64) -> String {
    let corner = |i: u32| {
        let r = if i.is_multiple_of(2) { 0.1 } else { 0.1 * inner };
        let p = DVec2::from_angle(f64::from(i) * std::f64::consts::PI / f64::from(points)) * r;
        format!("({}, {})", p.x, p.y)
    };
    format!("Polygon([{}])", (0..2 * points).map(corner).collect::<Vec<_>>().join(","))
}

const LETTER_B: &str = r#"Path("M0 0H.06C.1 0 .12 .02 .12 .04 C.12 .06 .11 .07 .09 .075 C.12 .08 .13 .1 .13 .115
    C.13 .14 .11 .16 .07 .16 H0Z M.03 .025V.06H.06C.08 .06 .09 .055 .09 .0425 C.09 .03 .08 .025 .06 .025Z
    m0 .065v.045h.04c.02 0 .03-.01 .03-.0225 c0-.0125-.01-.0225-.03-.0225z")"#;

/// Distance of `p` from the nearest boundary, m; negative in the sheet.
fn signed_distance(outline: &Outline, p: DVec2) -> f64 {
    let d = p.distance(outline.nearest(p));
    if outline.contains(p) { -d } else { d }
}

#[test]
fn every_shape_is_covered() {
    let ring = "[Disc(centre: (0, 0), radius: 0.04)]";
    let comb = "Polygon([(0,0),(0.2,0),(0.2,0.1),(0.19,0.1),(0.19,0.02),(0.11,0.02),(0.11,0.1),(0.1,0.1),(0.1,0.02),
        (0.01,0.02),(0.01,0.1),(0,0.1)])";
    for (name, spec, holes, loops, grids) in [
        ("rectangle", "", "", 1, [(6, 5), (26, 21), (31, 51)]),
        ("disc", "Disc(radius: 0.1)", "", 1, [(6, 6), (11, 11), (41, 41)]),
        ("rounded", "RoundedRectangle(radius: 0.03)", "", 1, [(9, 7), (26, 21), (41, 21)]),
        ("tightly rounded", "RoundedRectangle(radius: 0.004)", "", 1, [(9, 7), (26, 21), (51, 41)]),
        ("annulus", "Disc(radius: 0.1)", ring, 2, [(11, 11), (21, 21), (40, 41)]),
        ("five-pointed star", &star(5, 0.4), "", 1, [(11, 11), (21, 21), (42, 40)]),
        ("seven-pointed star", &star(7, 0.5), "", 1, [(16, 16), (21, 21), (42, 40)]),
        ("letter", LETTER_B, "", 3, [(14, 17), (27, 33), (40, 60)]),
        ("tongues a cell wide", comb, "", 1, [(21, 11), (41, 21), (81, 41)]),
        ("turned square", "Polygon([(0.1,0),(0,0.1),(-0.1,0),(0,-0.1)])", "", 1, [(9, 9), (22, 21), (41, 41)]),
        (
            "plate with a hole",
            "",
            "[Polygon([(0.02,0.02),(-0.05,0.02),(-0.05,-0.03)])]",
            2,
            [(11, 11), (21, 21), (41, 41)],
        ),
    ] {
        let outline = outline(spec, holes, "").unwrap_or_else(|e| panic!("{name}: {e}"));
        for grid in grids {
            check(&format!("{name} {grid:?}"), &outline, grid, (loops, 1));
        }
    }
}

#[test]
fn cuts_part_the_sheet_and_end_inside() {
    for (name, spec, cuts, loops, pieces) in [
        ("from the edge", "", "[[(0, -0.2), (0, 0.033)]]", 1, 1),
        ("from the edge, ending on it", "", "[[(0.01, -0.1), (0.02, 0.033)]]", 1, 1),
        ("inside", "", "[[(-0.05, 0.01), (0.06, 0.02)]]", 2, 1),
        ("bent", "", "[[(-0.05, 0.01), (0.06, 0.02), (0.06, -0.05)]]", 2, 1),
        ("crossing", "", "[[(-0.05, 0), (0.06, 0)], [(0, -0.05), (0, 0.05)]]", 2, 1),
        ("a branch", "", "[[(-0.05, 0), (0.06, 0)], [(0, 0), (0.01, 0.05)]]", 2, 1),
        ("crossing itself", "", "[[(-0.06, -0.06), (0.05, 0.05), (0.06, -0.05), (-0.05, 0.06)]]", 3, 2),
        ("through", "", "[[(0.02, -0.2), (-0.03, 0.2)]]", 2, 2),
        (
            "tongues",
            "",
            "[[(0.2, 0.05), (-0.05, 0.05)], [(0.2, 0.0), (-0.05, 0.0)], [(0.2, -0.05), (-0.05, -0.05)]]",
            1,
            1,
        ),
        ("across a disc", "Disc(radius: 0.1)", "[[(-0.2, 0.01), (0.2, -0.01)]]", 2, 2),
    ] {
        let outline = outline(spec, "", cuts).unwrap_or_else(|e| panic!("{name}: {e}"));
        for grid in [(13, 11), (26, 21), (37, 33)] {
            check(name, &outline, grid, (loops, pieces));
        }
    }
    // A cut that ends inside doubles its nodes except that at the end.
    let whole = check("whole", &outline("", "", "").expect("a sheet"), (26, 21), (1, 1));
    let cut = check("cut", &outline("", "", "[[(0.005, -0.1), (0.005, 0)]]").expect("a sheet"), (26, 21), (1, 1));
    assert_eq!(cut.triangles.len(), whole.triangles.len());
    assert_eq!(cut.positions.len(), whole.positions.len() + 10);
}

#[test]
fn a_rectangle_has_square_cells() {
    let mesh = check("rectangle", &outline("", "", "").expect("a sheet"), (26, 21), (1, 1));
    assert_eq!(mesh.positions.len(), 26 * 21);
    assert_eq!(mesh.triangles.len(), 2 * 25 * 20);
    assert!(mesh.areas.iter().all(|a| (a - 0.5e-4).abs() < 1e-15));
    assert_eq!(mesh.positions[0], [-0.125, -0.1]);
}

#[test]
fn meshing_is_deterministic() {
    let outline = outline(LETTER_B, "", "[[(0.01, 0.02), (0.02, 0.12)]]").expect("a letter");
    assert_eq!(mesh(&outline, (40, 50)), mesh(&outline, (40, 50)));
}

#[test]
fn distance_is_exact_on_a_disc() {
    let disc = outline("Disc(radius: 0.1)", "[Disc(centre: (0.02, 0), radius: 0.03)]", "").expect("a ring");
    for (p, d) in
        [((0.0, 0.0), 0.01), ((0.0, -0.09), -0.01), ((0.3, 0.4), 0.4), ((0.02, 0.01), 0.02), ((0.06, 0.0), -0.01)]
    {
        // Exact to the flatness of the polygon of the circle.
        let found: f64 = signed_distance(&disc, DVec2::new(p.0, p.1));
        assert!((found - d).abs() < 0.3 * FLATNESS, "{p:?}: {found}");
    }
    let area = std::f64::consts::PI * (0.01 - 0.0009);
    assert!((disc.area() / area - 1.0).abs() < 1e-5);
}

#[test]
fn invalid_outlines_are_rejected() {
    for (spec, holes, cuts, field, says) in [
        ("Polygon([(0,0),(0.1,0.1),(0.1,0),(0,0.1)])", "", "", "outline", "crosses itself near (0.05, 0.05) m"),
        ("Polygon([(0,0),(0.1,0),(0.2,0)])", "", "", "outline", "encloses no area"),
        ("Polygon([(0,0),(0.1,0)])", "", "", "outline", "2 points are outside 3 to"),
        ("Disc(radius: -1)", "", "", "outline.radius", "-1 m is outside"),
        ("RoundedRectangle(radius: 0.11)", "", "", "outline.radius", "0.11 m is outside 0 to 0.1 m"),
        ("Path(\"M 0 0 L 1\")", "", "", "outline", "is not an SVG path"),
        ("Path(\"M0 0h.1v.1h-.1zM.2 0h.1v.1h-.1z\")", "", "", "outline", "is 2 separate pieces"),
        ("Svg(file: \"none.svg\")", "", "", "", "cannot be opened"),
        ("", "[Disc(centre: (0.3, 0), radius: 0.01)]", "", "holes.0", "lies outside the outline"),
        ("", "[Disc(centre: (0.12, 0), radius: 0.01)]", "", "holes.0", "crosses outline near"),
        (
            "",
            "[Disc(centre: (0, 0), radius: 0.05), Disc(centre: (0.01, 0), radius: 0.01)]",
            "",
            "holes.1",
            "inside another",
        ),
        ("", "", "[[(0.2, 0.3), (0.5, 0.3)]]", "cuts.0", "lies outside the sheet"),
        ("", "", "[[(0.2, 0.3)]]", "cuts.0", "1 points are outside 2 to"),
    ] {
        let error = outline(spec, holes, cuts).and_then(|o| mesh(&o, (26, 21))).expect_err(says);
        assert_eq!(error.field, field, "{error}");
        assert!(error.problem.contains(says), "{error}");
    }
}

#[test]
fn features_smaller_than_a_cell_are_reported_with_their_size() {
    // Cells of 0.01 m.
    let notched = "Polygon([(0,0),(0.2,0),(0.2,0.05),(0.197,0.05),(0.197,0.053),(0.2,0.053),(0.2,0.1),(0,0.1)])";
    let thin = "Polygon([(0,0),(0.2,0),(0.2,0.004),(0.05,0.004),(0.05,0.1),(0,0.1)])";
    for (spec, holes, cuts, grid, field, says) in [
        (notched, "", "", (21, 11), "outline", "has a feature of"),
        (thin, "", "", (21, 11), "outline", "0.004 m near"),
        (
            "",
            "[Disc(centre: (0, 0), radius: 0.003)]",
            "",
            (26, 21),
            "holes.0",
            "is only 0.006 m near (0, 0) m, smaller than the cell of 0.01 x 0.01 m",
        ),
        ("", "[Disc(centre: (0.1, 0), radius: 0.02)]", "", (26, 21), "holes.0", "leaves, to outline, 0.005 m"),
        ("", "", "[[(0, 0), (0.122, 0)]]", (26, 21), "cuts.0", "leaves, to outline, 0.003 m"),
        ("", "", "[[(0, 0), (0.002, 0)]]", (26, 21), "cuts.0", "has a part of 0.002 m"),
    ] {
        let error = mesh(&outline(spec, holes, cuts).expect("an outline"), grid).expect_err(says);
        assert_eq!(error.field, field, "{error}");
        assert!(error.problem.contains(says), "{error}");
    }
}

#[test]
fn a_circle_of_two_arcs_is_meshed_as_a_disc() {
    let arcs = r#"Path("M0.05 0a.05.05 0 1 1-.1 0 .05.05 0 1 1 .1 0z")"#;
    let nodes = |spec: &str| mesh(&outline(spec, "", "").expect("an outline"), (21, 21)).map(|m| m.positions.len());
    assert_eq!(nodes(arcs), nodes("Disc(radius: 0.05)"));
    assert_eq!(nodes(arcs), Ok(349));
}

#[test]
fn cells_whose_triangles_are_too_slender_are_refused_with_their_ratio() {
    for (height, fits) in [(0.1, true), (0.005, true), (0.002, false), (0.0005, false)] {
        let spec = format!("Polygon([(0, 0), (0.1, 0), (0.1, {height})])");
        let made = mesh(&outline(&spec, "", "").expect("an outline"), (21, 21));
        assert_eq!(made.is_ok(), fits, "{height}");
        if let Err(error) = made {
            assert_eq!(error.field, "grid", "{error}");
            assert!(error.problem.contains(&format!("a ratio of {}", 0.1 / height)), "{error}");
        }
    }
}

#[test]
fn random_shapes_give_a_mesh_or_an_error() {
    let mut seed = 11_u64;
    let mut random = move |low: f64, high: f64| {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        low + (high - low) * (seed >> 33) as f64 / (1_u64 << 31) as f64
    };
    let mut meshes = 0;
    for case in 0..400 {
        let corners = random(3.0, 14.0) as u32;
        let (rough, place) = (random(0.0, 0.9), [random(-9.0, 9.0), random(-9.0, 9.0)]);
        let around = |i: u32, r: f64| {
            let angle = f64::from(i) * std::f64::consts::TAU / f64::from(corners);
            (place[0] + r * angle.cos(), place[1] + r * angle.sin())
        };
        let ring = (0..corners).map(|i| around(i, random(1.0 - rough, 1.0))).collect();
        let centre = (place[0] + random(-0.4, 0.4), place[1] + random(-0.4, 0.4));
        let holes = if case % 3 == 0 { vec![HoleSpec::Disc { centre, radius: random(0.02, 0.4) }] } else { Vec::new() };
        let mut cut = || (0..4).map(|_| (place[0] + random(-1.2, 1.2), place[1] + random(-1.2, 1.2))).collect();
        let cuts: Vec<Vec<(f64, f64)>> = (0..case % 4).map(|_| cut()).collect();
        let spec = OutlineSpec::Polygon(ring);
        let Ok(outline) = Outline::new(Some(&spec), &holes, &cuts, (1.0, 1.0), Path::new("")) else { continue };
        let grid = (random(4.0, 60.0) as u32, random(4.0, 60.0) as u32);
        let Ok(mesh) = mesh(&outline, grid) else { continue };
        meshes += 1;
        let missing = (mesh.total_area() / outline.area() - 1.0).abs();
        assert!(missing < 0.1, "case {case}: area off by {missing}");
        let (low, high) = outline.bounds();
        let cell = (high - low) / DVec2::new(f64::from(grid.0 - 1), f64::from(grid.1 - 1));
        assert!(worst(&mesh, cell) > 0.04, "case {case}: quality {}", worst(&mesh, cell));
        // A cut may join a hole to the boundary or divide the sheet; without cuts every ring is a
        // line of the mesh.
        let lines = topology(&mesh);
        assert!(!cuts.is_empty() || lines == (outline.rings().len(), 1), "case {case}: {lines:?}");
    }
    println!("{meshes} meshes");
    assert!(meshes > 100, "only {meshes} meshes");
}
