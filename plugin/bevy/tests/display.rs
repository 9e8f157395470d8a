//! Display: meshes, materials, bounds; no cost for resting or hidden sheets.
#![cfg(feature = "render")]

mod common;

use bevy::camera::primitives::Aabb;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use common::{frame, run, thesis_app};

fn positions(app: &App, entity: Entity) -> &[[f32; 3]] {
    let mesh = app.world().get::<Mesh3d>(entity).expect("dressed");
    let mesh = app.world().resource::<Assets<Mesh>>().get(&mesh.0).expect("there");
    mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|a| a.as_float3()).expect("positions")
}

/// Number of changes of meshes since the last call.
fn changes(app: &mut App) -> usize {
    let mut events = app.world_mut().resource_mut::<Messages<AssetEvent<Mesh>>>();
    events.drain().filter(|e| matches!(e, AssetEvent::Modified { .. })).count()
}

#[test]
fn a_falling_sheet_is_drawn_in_the_same_arrays() {
    let mut app = thesis_app();
    let sheet = app.world_mut().spawn((Sheet::thesis(), Transform::from_xyz(0.0, 0.5, 0.0))).id();
    frame(&mut app, 0.0);
    let mesh = app.world().get::<Mesh3d>(sheet).expect("dressed").0.id();
    assert!(app.world().get::<MeshMaterial3d<StandardMaterial>>(sheet).is_some());
    let height = |app: &App| {
        let there = app.world().get::<GlobalTransform>(sheet).expect("there");
        there.transform_point(positions(app, sheet)[0].into()).y
    };
    let (array, first) = (positions(&app, sheet).as_ptr(), height(&app));
    run(&mut app, 0.2);
    assert_eq!(positions(&app, sheet).as_ptr(), array, "not allocated again");
    assert_eq!(app.world().get::<Mesh3d>(sheet).expect("dressed").0.id(), mesh);
    let fallen = height(&app) - first;
    assert!((-0.25..-0.1).contains(&fallen), "{fallen}");
}

#[test]
fn bounds_follow_the_sheet_and_hold_every_vertex() {
    let mut app = thesis_app();
    let there = Transform::from_xyz(0.2, 0.5, -0.3).with_rotation(Quat::from_rotation_x(0.7));
    let sheet = app.world_mut().spawn((Sheet::thesis().velocity(Vec3::new(3.0, 1.0, 0.0)), there)).id();
    run(&mut app, 0.5);
    let bounds = app.world().get::<Aabb>(sheet).expect("has bounds");
    for p in positions(&app, sheet) {
        let from_centre = (Vec3::from(*p) - Vec3::from(bounds.center)).abs();
        assert!((from_centre - Vec3::from(bounds.half_extents)).max_element() < 1e-5);
    }
    let there = app.world().get::<GlobalTransform>(sheet).expect("there");
    let shown = there.transform_point(Vec3::from(bounds.center));
    let state = app.world().get::<SheetState>(sheet).expect("has one");
    assert!(shown.distance(state.centre) < 0.1, "drawn where it is: {shown} {}", state.centre);
    assert!(state.centre.x > 1.0);
}

#[test]
fn a_sheet_at_rest_or_hidden_is_not_sent_again() {
    let mut app = thesis_app();
    app.world_mut().spawn(SheetBody::floor());
    let sheet = app.world_mut().spawn((Sheet::thesis(), Transform::from_xyz(0.0, 0.01, 0.0))).id();
    run(&mut app, 0.1);
    assert!(changes(&mut app) > 0);
    app.world_mut().entity_mut(sheet).insert(Visibility::Hidden);
    run(&mut app, 0.1);
    changes(&mut app);
    run(&mut app, 0.1);
    assert_eq!(changes(&mut app), 0, "hidden");
    app.world_mut().entity_mut(sheet).insert(Visibility::Visible);
    run(&mut app, 4.0);
    assert!(app.world().get::<SheetState>(sheet).expect("has one").asleep);
    changes(&mut app);
    run(&mut app, 0.2);
    assert_eq!(changes(&mut app), 0, "asleep");
}

#[test]
fn layer_and_smoothing_can_be_changed_while_it_runs() {
    let mut app = thesis_app();
    let sheet = app.world_mut().spawn(Sheet::thesis()).id();
    run(&mut app, 0.1);
    assert_eq!(positions(&app, sheet).len(), (9 * 4 + 1) * (9 * 4 + 1), "the upper layer, four pieces a cell");
    *app.world_mut().get_mut::<SheetDisplay>(sheet).expect("required") =
        SheetDisplay { layer: SheetLayer::Bottom, smoothing: 1, ..default() };
    run(&mut app, 0.1);
    assert_eq!(positions(&app, sheet).len(), 121, "the lower layer, flat");
}

#[test]
fn a_user_material_is_not_replaced() {
    let mut app = thesis_app();
    let mine = app.world_mut().resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial::default());
    let sheet = app.world_mut().spawn((Sheet::thesis(), MeshMaterial3d(mine.clone()))).id();
    let body = app.world_mut().spawn((SheetBody::ball(0.1), MeshMaterial3d(mine.clone()))).id();
    run(&mut app, 0.1);
    for entity in [sheet, body] {
        assert!(app.world().get::<Mesh3d>(entity).is_some());
        assert_eq!(app.world().get::<MeshMaterial3d<StandardMaterial>>(entity).map(|m| m.0.id()), Some(mine.id()));
    }
}

#[test]
fn tangents_follow_the_sheet_where_a_normal_map_or_the_display_asks_for_them() {
    let mut app = thesis_app();
    let image = app.world_mut().resource_mut::<Assets<Image>>().add(Image::default());
    let material = StandardMaterial { normal_map_texture: Some(image), ..default() };
    let bumpy = app.world_mut().resource_mut::<Assets<StandardMaterial>>().add(material);
    let there = Transform::from_xyz(0.2, 0.5, -0.3).with_rotation(Quat::from_rotation_x(0.7));
    let asked = app.world_mut().spawn((Sheet::thesis(), there, SheetDisplay { tangents: true, ..default() })).id();
    let mapped = app.world_mut().spawn((Sheet::thesis(), MeshMaterial3d(bumpy))).id();
    let plain = app.world_mut().spawn((Sheet::thesis(), Transform::from_xyz(3.0, 0.0, 0.0))).id();
    app.world_mut().spawn((SheetBody::ball(0.1), Transform::from_xyz(0.2, 0.3, -0.3)));
    run(&mut app, 0.4);
    let mesh = |app: &App, entity: Entity| {
        let mesh = &app.world().get::<Mesh3d>(entity).expect("dressed").0;
        app.world().resource::<Assets<Mesh>>().get(mesh).expect("there").clone()
    };
    assert!(mesh(&app, plain).attribute(Mesh::ATTRIBUTE_TANGENT).is_none());
    for entity in [asked, mapped] {
        let mesh = mesh(&app, entity);
        let Some(VertexAttributeValues::Float32x4(tangents)) = mesh.attribute(Mesh::ATTRIBUTE_TANGENT) else {
            panic!("no tangents");
        };
        let normals = mesh.attribute(Mesh::ATTRIBUTE_NORMAL).and_then(|a| a.as_float3()).expect("normals");
        let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|a| a.as_float3()).expect("positions");
        assert_eq!(tangents.len(), positions.len());
        // Rows of 37 vertices along u.
        for (i, (tangent, normal)) in tangents.iter().zip(normals).enumerate() {
            let (tangent, normal) = (Vec4::from(*tangent), Vec3::from(*normal));
            let (direction, at) = (tangent.truncate(), |k: usize| Vec3::from(positions[k]));
            assert!((direction.length() - 1.0).abs() < 1e-4 && direction.dot(normal).abs() < 1e-4, "{i}");
            let (column, row) = (i % 37, i / 37);
            let along_u = if column < 36 { at(i + 1) - at(i) } else { at(i) - at(i - 1) };
            let along_v = if row < 36 { at(i + 37) - at(i) } else { at(i) - at(i - 37) };
            assert!(direction.dot(along_u) > 0.0, "{i}");
            assert!((tangent.w * normal.cross(direction)).dot(along_v) < 0.0, "{i}");
        }
        // The reference: MikkTSpace, as Bevy computes it for meshes from files.
        let mut reference = mesh.clone();
        reference.generate_tangents().expect("valid");
        let Some(VertexAttributeValues::Float32x4(expected)) = reference.attribute(Mesh::ATTRIBUTE_TANGENT) else {
            panic!("no tangents");
        };
        for (found, expected) in tangents.iter().zip(expected).map(|(a, b)| (Vec4::from(*a), Vec4::from(*b))) {
            assert_eq!(found.w, expected.w, "handedness");
            assert!(found.truncate().angle_between(expected.truncate()) < 0.05, "{found} {expected}");
        }
    }
}

#[test]
fn a_server_without_graphics_runs_too() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), SheetworkPlugins));
    let sheet = app.world_mut().spawn(Sheet::thesis()).id();
    run(&mut app, 0.2);
    assert!(app.world().get::<SheetState>(sheet).expect("has one").centre.y < -0.1);
}
