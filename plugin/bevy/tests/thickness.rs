//! Sheets with thickness: closed meshes, materials of their faces, texture coordinates.
#![cfg(feature = "render")]

mod common;

use std::collections::HashMap;

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::RenderLayers;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::material;
use common::{app, frame, run};

fn mesh(app: &App, entity: Entity) -> &Mesh {
    let mesh = app.world().get::<Mesh3d>(entity).expect("has a mesh");
    app.world().resource::<Assets<Mesh>>().get(&mesh.0).expect("there")
}

fn vectors(mesh: &Mesh, attribute: bevy::mesh::MeshVertexAttribute) -> Vec<Vec3> {
    let values = mesh.attribute(attribute).and_then(|a| a.as_float3()).expect("there");
    values.iter().map(|v| Vec3::from(*v)).collect()
}

/// Child entities of a sheet that display a face.
fn sides(app: &App, sheet: Entity) -> Vec<(SheetSide, Entity)> {
    let children = app.world().get::<Children>(sheet).map(|c| c.to_vec()).unwrap_or_default();
    children.into_iter().filter_map(|c| Some((*app.world().get::<SheetSide>(c)?, c))).collect()
}

/// Corners of the triangles of all meshes of a sheet.
fn triangles(app: &App, sheet: Entity) -> Vec<[Vec3; 3]> {
    let all = std::iter::once(sheet).chain(sides(app, sheet).into_iter().map(|side| side.1));
    let mut corners = Vec::new();
    for entity in all {
        let mesh = mesh(app, entity);
        let positions = vectors(mesh, Mesh::ATTRIBUTE_POSITION);
        corners.extend(mesh.indices().expect("indexed").iter().map(|i| positions[i]));
    }
    corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()
}

/// Volume of a closed surface, m³.
fn volume(triangles: &[[Vec3; 3]]) -> f64 {
    triangles.iter().map(|t| t.map(|p| p.as_dvec3())).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// Every side of a triangle is that of a neighbour in the opposite direction.
#[track_caller]
fn assert_watertight(triangles: &[[Vec3; 3]]) {
    let bits = |p: Vec3| p.to_array().map(f32::to_bits);
    let mut balance: HashMap<_, i32> = HashMap::new();
    for [a, b, c] in triangles {
        for (p, q) in [(a, b), (b, c), (c, a)].map(|(p, q)| (bits(*p), bits(*q))) {
            *balance.entry((p.min(q), p.max(q))).or_default() += if p < q { 1 } else { -1 };
        }
    }
    let open = balance.values().filter(|n| **n != 0).count();
    assert_eq!(open, 0, "of {} sides", balance.len());
}

/// Normals are unit vectors on the outer side of their triangles.
#[track_caller]
fn assert_normals(mesh: &Mesh) {
    let (positions, normals) = (vectors(mesh, Mesh::ATTRIBUTE_POSITION), vectors(mesh, Mesh::ATTRIBUTE_NORMAL));
    let indices: Vec<usize> = mesh.indices().expect("indexed").iter().collect();
    for corners in indices.chunks_exact(3) {
        let [p, q, r] = [0, 1, 2].map(|k| positions[corners[k]]);
        for normal in corners.iter().map(|i| normals[*i]) {
            assert!((normal.length() - 1.0).abs() < 1e-5, "{normal}");
            assert!((q - p).cross(r - p).normalize().dot(normal) > 0.9, "{normal} at {p}");
        }
    }
}

/// Area of the upper side of a flat horizontal sheet, m².
fn upper_area(triangles: &[[Vec3; 3]]) -> f64 {
    let areas = triangles.iter().map(|[a, b, c]| 0.5 * f64::from((*b - *a).cross(*c - *a).y));
    areas.filter(|area| *area > 1e-12).sum()
}

/// Thick card, 2 mm.
fn loose_board() -> Sheet {
    let card = SheetMaterial { thickness: 0.002, ..material::by_name("card").expect("in the library") };
    Sheet::default().material(card).size(0.2, 0.1).grid(11, 6)
}

fn board() -> Sheet {
    loose_board().clamp(Region::Left)
}

fn materials(app: &mut App) -> [Handle<StandardMaterial>; 2] {
    let mut assets = app.world_mut().resource_mut::<Assets<StandardMaterial>>();
    [Color::WHITE, Color::BLACK].map(|colour| assets.add(colour))
}

#[test]
fn a_sheet_with_thickness_is_closed_and_has_its_volume() {
    let hole = HoleSpec::Polygon(vec![(0.0, -0.02), (0.05, -0.02), (0.05, 0.02), (0.0, 0.02)]);
    for (sheet, area) in [(board(), 0.02), (board().hole(hole), 0.018)] {
        for smoothing in [1, 4] {
            let mut app = app();
            let there = Transform::from_xyz(0.4, 1.0, -0.2).with_rotation(Quat::from_rotation_y(0.5));
            let display = SheetDisplay { smoothing, ..default() };
            let entity = app.world_mut().spawn((sheet.clone(), there, display, SheetSides::default())).id();
            frame(&mut app, 0.0);
            let triangles = triangles(&app, entity);
            assert_watertight(&triangles);
            assert_normals(mesh(&app, entity));
            let expected = upper_area(&triangles) * 0.002;
            assert!((volume(&triangles) / expected - 1.0).abs() < 1e-3, "{} {expected}", volume(&triangles));
            assert!((volume(&triangles) / (0.002 * area) - 1.0).abs() < 0.01, "{} {area}", volume(&triangles));
            assert!(sides(&app, entity).is_empty(), "one mesh");
        }
    }
}

#[test]
fn the_mesh_stays_closed_in_motion_and_after_a_cut() {
    let mut app = app();
    let [back, rim] = materials(&mut app);
    for sides in [SheetSides::default(), SheetSides::new(back.clone(), rim), SheetSides { back: Some(back), rim: None }]
    {
        let sheet = app.world_mut().spawn((board(), Transform::from_xyz(0.0, 1.0, 0.0), sides)).id();
        run(&mut app, 0.1);
        let whole = triangles(&app, sheet);
        assert_watertight(&whole);
        assert!((volume(&whole) / (0.02 * 0.002) - 1.0).abs() < 0.01, "{}", volume(&whole));
        let array = mesh(&app, sheet).attribute(Mesh::ATTRIBUTE_POSITION).map(|a| a.get_bytes().as_ptr());
        run(&mut app, 0.1);
        let later = mesh(&app, sheet).attribute(Mesh::ATTRIBUTE_POSITION).map(|a| a.get_bytes().as_ptr());
        assert_eq!(later, array, "not allocated again");
        let id = app.world().get::<SheetMotion>(sheet).expect("built").id();
        let opened = app.world_mut().resource_mut::<SheetWorld>().cut(id, (0.5, 0.0), (0.5, 0.7)).expect("crosses");
        assert!(opened > 0);
        run(&mut app, 0.1);
        let cut = triangles(&app, sheet);
        assert_watertight(&cut);
        let area = app.world().resource::<SheetWorld>().queries(default()).area(id).expect("there").present;
        assert!(area < 0.0199 && (volume(&cut) / (area * 0.002) - 1.0).abs() < 0.01, "{} {area}", volume(&cut));
        for entity in std::iter::once(sheet).chain(self::sides(&app, sheet).into_iter().map(|side| side.1)) {
            assert_normals(mesh(&app, entity));
        }
        app.world_mut().despawn(sheet);
    }
}

#[test]
fn faces_with_materials_are_children_that_go_with_them() {
    let mut app = app();
    let [back, rim] = materials(&mut app);
    let layers = RenderLayers::layer(3);
    let there = Transform::from_xyz(0.0, 1.0, 0.0);
    let sheet =
        app.world_mut().spawn((board(), there, layers.clone(), SheetSides::new(back.clone(), rim.clone()))).id();
    run(&mut app, 0.1);
    let found = sides(&app, sheet);
    assert_eq!(found.iter().map(|side| side.0).collect::<Vec<_>>(), [SheetSide::Back, SheetSide::Rim]);
    let material = |app: &App, entity| {
        app.world().get::<MeshMaterial3d<StandardMaterial>>(entity).map(|m| m.0.clone()).expect("has one")
    };
    assert_eq!(found.iter().map(|side| material(&app, side.1)).collect::<Vec<_>>(), [back.clone(), rim.clone()]);
    for (_, child) in &found {
        assert_eq!(app.world().get::<RenderLayers>(*child), Some(&layers));
        assert_eq!(app.world().get::<Aabb>(*child), app.world().get::<Aabb>(sheet));
        assert!(vectors(mesh(&app, *child), Mesh::ATTRIBUTE_POSITION).iter().all(|p| p.length() > 1e-6), "written");
    }
    app.world_mut().entity_mut(sheet).insert(SheetSides { back: Some(rim.clone()), rim: None });
    run(&mut app, 0.1);
    let rest = sides(&app, sheet);
    assert_eq!(rest, found[..1], "the back stays, the rim goes");
    assert_eq!(material(&app, rest[0].1), rim);
    app.world_mut().despawn(rest[0].1);
    run(&mut app, 0.1);
    assert_eq!(sides(&app, sheet).len(), 1, "spawned again");
    app.world_mut().entity_mut(sheet).remove::<SheetSides>();
    run(&mut app, 0.1);
    assert!(sides(&app, sheet).is_empty());
    let plain = app.world_mut().spawn((board(), Transform::from_xyz(0.0, 3.0, 0.0))).id();
    run(&mut app, 0.1);
    assert_eq!(mesh(&app, sheet).count_vertices(), mesh(&app, plain).count_vertices());
    assert_eq!(material(&app, sheet), material(&app, plain));
    app.world_mut().despawn(sheet);
    run(&mut app, 0.1);
}

#[test]
fn a_sheet_without_sides_is_unchanged() {
    let mut app = app();
    let plain = app.world_mut().spawn((board(), Transform::from_xyz(0.0, 1.0, 0.0))).id();
    run(&mut app, 0.1);
    // Ten by five cells in four pieces each.
    assert_eq!(mesh(&app, plain).count_vertices(), 41 * 21);
    assert_eq!(mesh(&app, plain).indices().expect("indexed").len(), 40 * 20 * 6);
    assert!(app.world().get::<Children>(plain).is_none());
}

#[test]
fn a_resting_sheet_with_sides_is_not_sent_again() {
    let mut app = app();
    app.world_mut().spawn(SheetBody::floor());
    let [back, rim] = materials(&mut app);
    let entity =
        app.world_mut().spawn((loose_board(), Transform::from_xyz(0.0, 0.002, 0.0), SheetSides::new(back, rim))).id();
    run(&mut app, 6.0);
    assert!(app.world().get::<SheetState>(entity).expect("has one").asleep);
    let there = *app.world().get::<GlobalTransform>(entity).expect("there");
    let low = triangles(&app, entity).iter().flatten().map(|p| there.transform_point(*p).y).fold(f32::MAX, f32::min);
    let high = triangles(&app, entity).iter().flatten().map(|p| there.transform_point(*p).y).fold(f32::MIN, f32::max);
    assert!((-1e-4..3e-4).contains(&low) && (high - low - 0.002).abs() < 2e-4, "lies on the floor: {low} {high}");
    let changes = |app: &mut App| {
        let mut events = app.world_mut().resource_mut::<Messages<AssetEvent<Mesh>>>();
        events.drain().filter(|e| matches!(e, AssetEvent::Modified { .. })).count()
    };
    changes(&mut app);
    run(&mut app, 0.2);
    assert_eq!(changes(&mut app), 0);
}

#[test]
fn texture_coordinates_stay_on_the_material_through_a_cut() {
    let mut app = app();
    let sheet = app.world_mut().spawn((board(), Transform::from_xyz(0.0, 1.0, 0.0), SheetSides::default())).id();
    let plain = app.world_mut().spawn((board(), Transform::from_xyz(0.0, 2.0, 0.0))).id();
    run(&mut app, 0.1);
    for entity in [sheet, plain] {
        let id = app.world().get::<SheetMotion>(entity).expect("built").id();
        app.world_mut().resource_mut::<SheetWorld>().cut(id, (0.5, 0.0), (0.5, 1.0)).expect("crosses");
    }
    run(&mut app, 0.4);
    for (entity, apart) in [(sheet, 0.001), (plain, 0.0)] {
        let mesh = mesh(&app, entity);
        let Some(VertexAttributeValues::Float32x2(uvs)) = mesh.attribute(Mesh::ATTRIBUTE_UV_0) else { panic!("no uv") };
        let world = app.world().resource::<SheetWorld>();
        let motion = app.world().get::<SheetMotion>(entity).expect("built");
        let there = app.world().get::<GlobalTransform>(entity).expect("there");
        let positions = vectors(mesh, Mesh::ATTRIBUTE_POSITION);
        // Vertices of a sheet with open cells are its nodes.
        let of_nodes = &motion.sheet(world).expect("built").model.uv;
        assert_eq!(of_nodes.len(), 66);
        let mut lowest = f32::MAX;
        for (i, (u, v)) in of_nodes.iter().enumerate() {
            assert!(Vec2::from(uvs[i]).distance(Vec2::new(*u as f32, *v as f32)) < 1e-6, "{:?} at node {i}", uvs[i]);
            let (shown, node) = (there.transform_point(positions[i]), motion.at(i, world.shown_time()).expect("there"));
            assert!((shown.distance(node) - apart).abs() < 1e-5, "{shown} {node} at node {i}");
            lowest = lowest.min(shown.y);
        }
        let fallen = motion.at(0, world.shown_time()).expect("there").y - lowest;
        assert!(fallen > 0.3, "torn apart: {fallen} m");
    }
}

#[test]
fn colours_and_tangents_reach_all_faces() {
    let mut app = app();
    let [back, rim] = materials(&mut app);
    let display = SheetDisplay { colour: SheetColour::Speed, tangents: true, ..default() };
    let sheet = app.world_mut().spawn((board(), display, SheetSides::new(back, rim))).id();
    run(&mut app, 0.2);
    for entity in std::iter::once(sheet).chain(sides(&app, sheet).into_iter().map(|side| side.1)) {
        let mesh = mesh(&app, entity);
        let count = mesh.count_vertices();
        let four = |attribute| match mesh.attribute(attribute) {
            Some(VertexAttributeValues::Float32x4(values)) => values.clone(),
            _ => panic!("not there"),
        };
        let (colours, tangents) = (four(Mesh::ATTRIBUTE_COLOR), four(Mesh::ATTRIBUTE_TANGENT));
        assert_eq!((colours.len(), tangents.len()), (count, count));
        assert!(colours.iter().any(|c| c != &colours[0]), "of different speeds");
        for (tangent, normal) in tangents.iter().zip(vectors(mesh, Mesh::ATTRIBUTE_NORMAL)) {
            let direction = Vec4::from(*tangent).truncate();
            assert!((direction.length() - 1.0).abs() < 1e-4 && direction.dot(normal).abs() < 1e-3);
        }
    }
}
