//! Geometric queries against brute force over all triangles, closed forms, and bad input.

use allocation_counter::measure as count;
use glam::{DQuat, DVec3};
use sheetwork::scene::Scene;
use sheetwork::{QueryFilter, QueryLayer, QueryShape, SheetId, SurfaceOverlaps, SurfacePoint, Vectors, World};
use sheetwork_tests::{Random, world, world_of};

/// Four crumpled sheets of different kinds, one with an open slit, one with two layers.
fn crumpled() -> World {
    let mut world = world_of(
        r#"(gravity: (0, 0, 0), sheets: [
            (structure: "shell", grid: (15, 1, 11), size: (0.4, 0.3), material: "hips", slits: [((0.3, 0.2), (0.3, 0.8))]),
            (structure: "shell", grid: (13, 1, 13), size: (0.3, 0.3), outline: Disc(radius: 0.15), material: "hips",
                placement: (position: (0, 0.5, 0))),
            (structure: "double-diagonal", grid: (9, 2, 9), size: (0.3, 0.3), gap: 0.02, material: "hips",
                placement: (position: (0.2, -0.5, 0.1))),
            (structure: "trimm", grid: (9, 2, 9), size: (0.3, 0.3), gap: 0.02, material: "hips",
                placement: (position: (1.5, 0, 0)))])"#,
    );
    let mut random = Random::new(7);
    for sheet in world.sheets_mut() {
        for i in 0..sheet.node_count() {
            sheet.state.x.set(i, sheet.state.x.get(i) + 0.02 * random.vector());
            sheet.state.v.set(i, random.vector());
        }
    }
    world
}

/// Triangles of closed cells of the upper layers, with their sheets.
fn triangles(world: &World) -> Vec<(SheetId, [u32; 3], [DVec3; 3])> {
    let mut all = Vec::new();
    for (id, sheet) in world.sheet_ids().zip(world.sheets()) {
        let upper = sheet.model.layers.len() - 1;
        for nodes in sheet.cells().layer_triangles(upper) {
            all.push((id, nodes, nodes.map(|i| sheet.state.x.get(i as usize))));
        }
    }
    all
}

/// Distance of a ray to the plane of a triangle, if it passes through the triangle: the signs of
/// three volumes.
fn through(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let volume = |p: DVec3, q: DVec3| (p - origin).cross(q - origin).dot(direction);
    let volumes = [volume(a, b), volume(b, c), volume(c, a)];
    let inside = volumes.iter().all(|v| *v >= 0.0) || volumes.iter().all(|v| *v <= 0.0);
    let normal = (b - a).cross(c - a);
    let distance = (a - origin).dot(normal) / direction.dot(normal);
    (inside && distance >= 0.0).then_some(distance)
}

/// Distance of a point from a triangle: from its plane where the foot lies inside, else from a
/// side.
fn distance(p: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).normalize();
    let outside = (0..3).any(|k| (corners[(k + 1) % 3] - corners[k]).cross(p - corners[k]).dot(normal) < 0.0);
    if !outside {
        return (p - a).dot(normal).abs();
    }
    let side = |k: usize| {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        let s = ((p - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
        p.distance(from + s * (to - from))
    };
    side(0).min(side(1)).min(side(2))
}

/// Distance of a point from all triangles.
fn least_distance(p: DVec3, triangles: &[(SheetId, [u32; 3], [DVec3; 3])]) -> f64 {
    triangles.iter().map(|t| distance(p, t.2)).fold(f64::INFINITY, f64::min)
}

/// The values of a point agree with its nodes and weights.
fn assert_consistent(world: &World, point: &SurfacePoint) {
    let sheet = world.get_sheet(point.sheet).expect("there");
    let sum =
        |field: &Vectors| -> DVec3 { (0..3).map(|k| field.get(point.nodes[k] as usize) * point.weights[k]).sum() };
    assert!(point.position.distance(sum(&sheet.state.x)) < 1e-12);
    assert!(point.velocity.distance(sum(&sheet.state.v)) < 1e-12);
    assert!((point.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12 && point.weights.iter().all(|w| *w >= 0.0));
    let away = |i: u32| sheet.state.x.get(i as usize).distance(point.position);
    assert!(point.nodes.iter().all(|i| away(point.node) <= away(*i)));
    let [a, b, c] = point.nodes.map(|i| sheet.state.x.get(i as usize));
    assert!((point.normal.length() - 1.0).abs() < 1e-12 && point.normal.dot((b - a).cross(c - a)) > 0.0);
}

/// Random origin and direction towards the sheets.
fn random_ray(random: &mut Random) -> (DVec3, DVec3) {
    let origin = 1.5 * random.vector();
    let target = DVec3::new(0.5 * random.signed(), 0.6 * random.signed(), 0.2 * random.signed());
    (origin, target - origin)
}

#[test]
fn rays_hit_as_among_all_triangles() {
    let world = crumpled();
    let (all, queries) = (triangles(&world), world.queries(QueryFilter::default()));
    let (mut random, mut hits, mut met) = (Random::new(1), Vec::new(), 0);
    for _ in 0..2000 {
        let (origin, direction) = random_ray(&mut random);
        let unit = direction.normalize();
        let mut expected: Vec<(f64, SheetId)> =
            all.iter().filter_map(|t| Some((through(origin, unit, t.2)?, t.0))).collect();
        expected.sort_by(|a, b| a.0.total_cmp(&b.0));
        queries.cast_ray_all(origin, direction, f64::INFINITY, &mut hits);
        assert_eq!(hits.len(), expected.len());
        for (hit, (distance, sheet)) in hits.iter().zip(&expected) {
            assert!((hit.distance - distance).abs() < 1e-9 && hit.sheet == *sheet);
            assert!(hit.position.distance(origin + unit * *distance) < 1e-9);
            assert_consistent(&world, hit);
        }
        let first = queries.cast_ray(origin, direction, f64::INFINITY);
        assert_eq!(first, hits.first().copied());
        if let Some(hit) = first {
            met += 1;
            assert_eq!(queries.cast_ray(origin, direction, 0.999 * hit.distance), None);
            assert_eq!(queries.cast_ray(origin, direction, 1.001 * hit.distance), first);
        }
    }
    assert!(met > 300, "{met} rays hit");
}

#[test]
fn no_ray_passes_through_a_side_or_a_corner_and_each_hits_once() {
    let world = crumpled();
    let queries = world.queries(QueryFilter::default());
    let (sheet, mut hits) = (&world.sheets()[1], Vec::new());
    let id = world.sheet_ids().nth(1).expect("there");
    let only = world.queries(QueryFilter { sheet: Some(id), ..Default::default() });
    for i in (0..sheet.node_count()).filter(|i| !sheet.model.border[*i]) {
        let node = sheet.state.x.get(i);
        for origin in [node + DVec3::Y, node + DVec3::new(0.3, 1.1, -0.2)] {
            only.cast_ray_all(origin, node - origin, 2.0, &mut hits);
            let at_node = hits.iter().filter(|hit| hit.position.distance(node) < 1e-9).count();
            assert_eq!(at_node, 1, "node {i}: {hits:?}");
            assert!(queries.cast_ray(origin, node - origin, 2.0).is_some());
        }
    }
}

#[test]
fn the_closest_point_is_that_of_all_triangles() {
    let world = crumpled();
    let (all, queries) = (triangles(&world), world.queries(QueryFilter::default()));
    let mut random = Random::new(2);
    for _ in 0..500 {
        let p = random.vector();
        let expected = least_distance(p, &all);
        let found = queries.closest_point(p, f64::INFINITY).expect("a sheet");
        assert!((found.distance - expected).abs() < 1e-12 && (found.position.distance(p) - expected).abs() < 1e-12);
        assert_consistent(&world, &found);
        assert_eq!(queries.closest_point(p, 0.99 * expected), None);
        assert_eq!(queries.closest_point(p, 1.01 * expected), Some(found));
    }
}

#[test]
fn a_swept_ball_stops_where_the_distance_is_its_radius() {
    let world = crumpled();
    let (all, queries) = (triangles(&world), world.queries(QueryFilter::default()));
    let (mut random, mut met) = (Random::new(3), 0);
    for k in 0..200 {
        let (origin, direction) = random_ray(&mut random);
        let (unit, radius) = (direction.normalize(), [0.0, 0.01, 0.05, 0.2][k % 4]);
        // Conservative advancement: no step is longer than the distance from all triangles.
        let (mut path, mut gap) = (0.0, f64::INFINITY);
        while path < 4.0 && gap > 1e-10 {
            gap = least_distance(origin + unit * path, &all) - radius;
            path += gap.max(0.0);
        }
        let found = queries.cast_ball(origin, direction, radius, 4.0);
        if gap > 1e-10 {
            // A ball that passes within rounding may go either way.
            assert!(found.is_none(), "{found:?} after {path} m, {gap} m away");
            continue;
        }
        met += 1;
        let hit = found.expect("touches");
        assert!((hit.distance - path).abs() < 1e-6, "{} m instead of {path} m", hit.distance);
        assert!((hit.position.distance(origin + unit * hit.distance) - radius).abs() < 1e-9 || path == 0.0);
        assert_consistent(&world, &hit);
    }
    assert!(met > 50, "{met} balls touch");
}

/// Whether a triangle meets a box about the origin: clipping by its six faces leaves corners.
fn clipped(half: DVec3, corners: [DVec3; 3]) -> bool {
    let mut polygon = corners.to_vec();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let above = |p: &DVec3| sign * p[axis] - half[axis];
            let mut kept = Vec::new();
            for (k, p) in polygon.iter().enumerate() {
                let q = polygon[(k + 1) % polygon.len()];
                if above(p) <= 0.0 {
                    kept.push(*p);
                }
                if (above(p) < 0.0) != (above(&q) < 0.0) && above(p) != above(&q) {
                    kept.push(p.lerp(q, above(p) / (above(p) - above(&q))));
                }
            }
            polygon = kept;
        }
    }
    !polygon.is_empty()
}

#[test]
fn overlaps_are_those_of_all_nodes_and_triangles() {
    let world = crumpled();
    let (all, queries) = (triangles(&world), world.queries(QueryFilter::default()));
    let (mut random, mut overlaps, mut between) = (Random::new(4), SurfaceOverlaps::default(), 0);
    for k in 0..1000 {
        let centre = DVec3::new(0.6, 0.6, 0.3) * random.vector();
        let size = 0.05 * (1.01 + random.signed());
        let rotation = DQuat::from_scaled_axis(3.0 * random.vector());
        let half_extents = size * (random.vector() + 1.01);
        let shape = if k % 2 == 0 {
            QueryShape::Ball { centre, radius: size }
        } else {
            QueryShape::Cuboid { centre, rotation, half_extents }
        };
        let local = |p: DVec3| rotation.inverse() * (p - centre);
        let contains = |p: DVec3| match k % 2 {
            0 => p.distance(centre) <= size,
            _ => local(p).abs().cmple(half_extents).all(),
        };
        let meets = |corners: [DVec3; 3]| match k % 2 {
            0 => distance(centre, corners) <= size,
            _ => clipped(half_extents, corners.map(local)),
        };
        queries.overlaps(&shape, &mut overlaps);
        let mut sheets: Vec<SheetId> = all.iter().filter(|t| meets(t.2)).map(|t| t.0).collect();
        sheets.dedup();
        assert_eq!(overlaps.sheets, sheets, "{shape:?}");
        let corners = all.iter().flat_map(|t| t.1.iter().zip(t.2).map(|(i, p)| (t.0, *i, p)));
        let mut nodes: Vec<(SheetId, u32)> = corners.filter(|n| contains(n.2)).map(|n| (n.0, n.1)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        assert_eq!(overlaps.nodes, nodes, "{shape:?}");
        between += usize::from(nodes.is_empty() && !sheets.is_empty());
    }
    assert!(between > 3, "{between} shapes between nodes");
}

/// A flat shell of 21 by 21 nodes and 20 cm, moved by `place` (from x, z to a position).
fn bent(place: impl Fn(f64, f64) -> DVec3) -> (World, SheetId) {
    let mut world = world_of(
        r#"(gravity: (0, 0, 0), sheets: [(structure: "shell", grid: (21, 1, 21), size: (0.2, 0.2), material: "hips")])"#,
    );
    let sheet = &mut world.sheets_mut()[0];
    for i in 0..sheet.node_count() {
        let p = sheet.state.x.get(i);
        sheet.state.x.set(i, place(p.x, p.z));
    }
    let id = world.sheet_ids().next().expect("one");
    (world, id)
}

#[test]
fn a_cylinder_has_its_curvature_on_the_side_of_its_axis() {
    let radius = 0.1;
    // The axis is above (+y) the sheet, or below.
    for side in [1.0, -1.0] {
        let (world, id) = bent(|x, z| {
            let (sin, cos) = (x / radius).sin_cos();
            DVec3::new(radius * sin, side * radius * (1.0 - cos), z)
        });
        let queries = world.queries(QueryFilter::default());
        for uv in [(0.5, 0.5), (0.33, 0.61), (0.02, 0.5), (0.0, 0.0), (0.97, 0.93)] {
            let found = queries.curvature_at(id, uv).expect("defined");
            let [first, second] = found.principal;
            let (bend, straight, along) = if side > 0.0 { (first, second, 0) } else { (second, first, 1) };
            assert!((bend * radius - side).abs() < 0.04 && straight.abs() * radius < 0.01, "{uv:?} {found:?}");
            assert!(found.directions[along].z.abs() < 0.02 && found.directions[1 - along].z.abs() > 0.99, "{found:?}");
            assert!((found.mean - 0.5 * side / radius).abs() < 0.025 / radius);
        }
    }
}

#[test]
fn a_saddle_and_a_paraboloid_have_their_principal_curvatures() {
    let k = 4.0;
    let (saddle, id) = bent(|x, z| DVec3::new(x, 0.5 * k * (x * x - z * z), z));
    let found = saddle.queries(QueryFilter::default()).curvature_at(id, (0.5, 0.5)).expect("defined");
    assert!((found.principal[0] - k).abs() < 1e-5 && (found.principal[1] + k).abs() < 1e-5, "{found:?}");
    assert!((found.gaussian + k * k).abs() < 1e-4 && found.mean.abs() < 1e-9);
    assert!(found.directions[0].x.abs() > 1.0 - 1e-6 && found.directions[1].z.abs() > 1.0 - 1e-6);
    // On a slope: k/(1 + s²)^(3/2) along it and k/(1 + s²)^(1/2) across it, with s = k x.
    let (bowl, id) = bent(|x, z| DVec3::new(x, 0.5 * k * (x * x + z * z), z));
    let queries = bowl.queries(QueryFilter::default());
    for x in [0.0, 0.05] {
        let found = queries.curvature_at(id, (0.5 + x / 0.2, 0.5)).expect("defined");
        let root = (1.0 + (k * x) * (k * x)).sqrt();
        let (across, along) = (k / root, k / root.powi(3));
        assert!((found.principal[0] / across - 1.0).abs() < 0.005, "{found:?} {across}");
        assert!((found.principal[1] / along - 1.0).abs() < 0.015, "{found:?} {along}");
        assert!((found.gaussian / (across * along) - 1.0).abs() < 0.02);
    }
}

#[test]
fn a_strip_of_two_rows_has_no_curvature() {
    let strip = r#"(sheets: [(structure: "shell", grid: (21, 1, 2), size: (0.2, 0.01), material: "hips")])"#;
    let world = world_of(strip);
    let id = world.sheet_ids().next().expect("one");
    let queries = world.queries(QueryFilter::default());
    assert!(queries.point_at(id, (0.5, 0.5)).is_some() && queries.curvature_at(id, (0.5, 0.5)).is_none());
}

#[test]
fn areas_are_those_of_the_outline_the_stretch_and_the_open_cells() {
    let disc = r#"(sheets: [(structure: "shell", grid: (41, 1, 41), size: (0.2, 0.2), outline: Disc(radius: 0.1),
        material: "hips")])"#;
    let mut disc = world_of(disc);
    let id = disc.sheet_ids().next().expect("one");
    let area = |world: &World| world.queries(QueryFilter::default()).area(id).expect("there");
    let whole = std::f64::consts::PI * 0.01;
    assert!((area(&disc).rest / whole - 1.0).abs() < 0.005, "{:?} {whole}", area(&disc));
    assert!((area(&disc).present / area(&disc).rest - 1.0).abs() < 1e-9);
    let sheet = &mut disc.sheets_mut()[0];
    for i in 0..sheet.node_count() {
        sheet.state.x.set(i, sheet.state.x.get(i) * DVec3::new(1.1, 1.0, 1.0));
    }
    assert!((area(&disc).present / area(&disc).rest - 1.1).abs() < 1e-9);
    // Four open cells of 100.
    let torn = world_of(
        r#"(sheets: [(structure: "shell", grid: (11, 1, 11), size: (0.2, 0.1), material: "hips",
            slits: [((0.35, 0.32), (0.35, 0.68))])])"#,
    );
    assert!((area(&torn).rest - 0.02 * 0.96).abs() < 1e-12, "{:?}", area(&torn));
}

#[test]
fn a_torn_sheet_lets_the_ray_through() {
    let torn = world_of(
        r#"(sheets: [(structure: "shell", grid: (11, 1, 11), size: (0.2, 0.2), material: "hips",
            slits: [((0.35, 0.32), (0.35, 0.68))])])"#,
    );
    let id = torn.sheet_ids().next().expect("one");
    let queries = torn.queries(QueryFilter::default());
    let below = |u: f64, v: f64| queries.cast_ray(DVec3::new(0.2 * u - 0.1, 1.0, 0.2 * v - 0.1), DVec3::NEG_Y, 9.0);
    for v in [0.33, 0.5, 0.65] {
        assert_eq!(below(0.35, v), None, "{v}");
        assert_eq!(queries.point_at(id, (0.35, v)), None);
        assert_eq!(queries.curvature_at(id, (0.35, v)), None);
    }
    for (u, v) in [(0.25, 0.5), (0.45, 0.5), (0.35, 0.25), (0.35, 0.75)] {
        let hit = below(u, v).expect("closed");
        assert!((hit.uv.0 - u).abs() < 1e-9 && (hit.uv.1 - v).abs() < 1e-9);
        assert!((hit.distance - 1.0).abs() < 1e-9 && hit.normal.distance(DVec3::Y) < 1e-9, "{hit:?}");
    }
}

#[test]
fn material_points_are_where_rays_find_them() {
    let world = crumpled();
    let queries = world.queries(QueryFilter::default());
    let (mut random, mut hits) = (Random::new(5), Vec::new());
    for _ in 0..500 {
        let (origin, direction) = random_ray(&mut random);
        queries.cast_ray_all(origin, direction, 9.0, &mut hits);
        for hit in &hits {
            let found = queries.point_at(hit.sheet, hit.uv).expect("on the sheet");
            assert!(found.position.distance(hit.position) < 1e-6, "{hit:?} {found:?}");
        }
    }
}

#[test]
fn layers_sheets_and_other_positions_can_be_chosen() {
    let world = world_of(
        r#"(sheets: [(structure: "samm", grid: (9, 2, 9), size: (0.3, 0.3), gap: 0.02, material: "hips"),
            (structure: "shell", size: (0.3, 0.3), material: "hips", placement: (position: (0, 0.5, 0)))])"#,
    );
    let ids: Vec<SheetId> = world.sheet_ids().collect();
    let height = |filter: QueryFilter| {
        let hit = world.queries(filter).cast_ray(DVec3::new(0.01, 2.0, 0.02), DVec3::NEG_Y, 9.0);
        hit.map(|hit| (hit.sheet, (hit.position.y * 1e9).round() / 1e9))
    };
    assert_eq!(height(QueryFilter::default()), Some((ids[1], 0.5)));
    let lattice = QueryFilter { sheet: Some(ids[0]), ..Default::default() };
    let upper = world.sheets()[0].state.x.iter().map(|p| p.y).fold(0.0, f64::max);
    assert!(upper > 0.005);
    assert_eq!(height(lattice), Some((ids[0], upper)));
    assert_eq!(height(QueryFilter { layer: QueryLayer::Lower, ..lattice }), Some((ids[0], 0.0)));
    // Half way from the state to a position 1 m above.
    let x = &world.sheets()[1].state.x;
    let mut raised = Vectors::zeros(0);
    x.iter().for_each(|p| raised.push(p + DVec3::Y));
    let queries = world.queries_at(QueryFilter::default(), |id| (id == ids[1]).then_some((x, &raised, 0.5)));
    let hit = queries.cast_ray(DVec3::new(0.01, 2.0, 0.02), DVec3::NEG_Y, 9.0).expect("there");
    assert!((hit.position.y - 1.0).abs() < 1e-9 && hit.sheet == ids[1]);
    // Positions of another number of nodes are not used.
    let none = Vectors::zeros(3);
    let queries = world.queries_at(QueryFilter::default(), |_| Some((&none, &none, 0.5)));
    assert!(queries.cast_ray(DVec3::new(0.01, 2.0, 0.02), DVec3::NEG_Y, 9.0).is_some_and(|h| h.position.y < 0.6));
}

#[test]
fn invalid_queries_have_no_result() {
    let mut world = crumpled();
    let id = world.sheet_ids().next().expect("one");
    let (nan, inf) = (DVec3::new(0.0, f64::NAN, 0.0), DVec3::new(f64::INFINITY, 0.0, 0.0));
    let queries = world.queries(QueryFilter::default());
    let mut hits = vec![queries.closest_point(DVec3::ZERO, 9.0).expect("there")];
    for (origin, direction) in
        [(nan, DVec3::Y), (inf, DVec3::Y), (DVec3::Y, DVec3::ZERO), (DVec3::Y, nan), (DVec3::Y, inf)]
    {
        assert_eq!(queries.cast_ray(origin, direction, 9.0), None);
        assert_eq!(queries.cast_ball(origin, direction, 0.1, 9.0), None);
        queries.cast_ray_all(origin, direction, 9.0, &mut hits);
        assert!(hits.is_empty());
    }
    for limit in [f64::NAN, -1.0] {
        assert_eq!(queries.cast_ray(DVec3::Y, DVec3::NEG_Y, limit), None);
        assert_eq!(queries.cast_ball(DVec3::Y, DVec3::NEG_Y, limit, 9.0), None);
        assert_eq!(queries.closest_point(DVec3::Y, limit), None);
    }
    // Directions of any length.
    let down = queries.cast_ray(DVec3::Y, DVec3::NEG_Y, 9.0);
    assert!(down.is_some());
    for length in [1e-300, 1e300, 5e-324] {
        assert_eq!(queries.cast_ray(DVec3::Y, DVec3::NEG_Y * length, 9.0), down);
    }
    let mut overlaps = SurfaceOverlaps::default();
    let (rotation, half_extents) = (DQuat::IDENTITY, DVec3::ONE);
    for shape in [
        QueryShape::Ball { centre: nan, radius: 1.0 },
        QueryShape::Ball { centre: DVec3::ZERO, radius: -1.0 },
        QueryShape::Ball { centre: DVec3::ZERO, radius: f64::NAN },
        QueryShape::Cuboid { centre: inf, rotation, half_extents },
        QueryShape::Cuboid { centre: DVec3::ZERO, rotation: DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), half_extents },
        QueryShape::Cuboid { centre: DVec3::ZERO, rotation, half_extents: -half_extents },
        QueryShape::Cuboid { centre: DVec3::ZERO, rotation, half_extents: nan },
    ] {
        queries.overlaps(&shape, &mut overlaps);
        assert_eq!(overlaps, SurfaceOverlaps::default(), "{shape:?}");
    }
    for uv in [(f64::NAN, 0.5), (0.5, 1.5), (-0.1, 0.5), (f64::INFINITY, 0.5)] {
        assert_eq!(queries.point_at(id, uv), None);
        assert_eq!(queries.curvature_at(id, uv), None);
    }
    world.remove_sheet(id);
    let queries = world.queries(QueryFilter { sheet: Some(id), ..Default::default() });
    assert_eq!(queries.closest_point(DVec3::ZERO, 9.0), None);
    assert_eq!((queries.point_at(id, (0.5, 0.5)), queries.area(id)), (None, None));
    // A node that is not finite takes its triangles out of the queries.
    let sheet = &mut world.sheets_mut()[0];
    (0..sheet.node_count()).for_each(|i| sheet.state.x.set(i, DVec3::NAN));
    let queries = world.queries(QueryFilter::default());
    let found = queries.cast_ray(DVec3::Y, DVec3::NEG_Y, 9.0);
    assert!(found.is_none_or(|hit| hit.position.is_finite()));
    assert!(queries.closest_point(DVec3::ZERO, 9.0).is_some_and(|point| point.position.is_finite()));
    assert_eq!(self::world(&Scene::new()).queries(QueryFilter::default()).closest_point(DVec3::ZERO, 9.0), None);
}

#[test]
fn warm_queries_allocate_nothing() {
    let world = crumpled();
    let queries = world.queries(QueryFilter::default());
    let (mut hits, mut overlaps) = (Vec::new(), SurfaceOverlaps::default());
    let mut all = || {
        let mut random = Random::new(6);
        for _ in 0..100 {
            let (origin, direction) = random_ray(&mut random);
            queries.cast_ray(origin, direction, 9.0);
            queries.cast_ray_all(origin, direction, 9.0, &mut hits);
            queries.cast_ball(origin, direction, 0.05, 9.0);
            queries.closest_point(origin, 9.0);
            queries.overlaps(&QueryShape::Ball { centre: origin * 0.3, radius: 0.2 }, &mut overlaps);
        }
    };
    all();
    assert_eq!(count(&mut all).count_total, 0);
}
