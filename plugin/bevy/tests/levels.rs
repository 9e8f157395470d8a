//! Level of detail in an app: sheets follow the viewer and the budget, meshes follow the sheets.
#![cfg(feature = "render")]

mod common;

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use common::{app, frame, run};

fn grid(app: &App) -> u32 {
    app.world().resource::<SheetWorld>().sheets()[0].model.grid.0
}

/// An app with a swinging sheet and a viewer.
fn swinging(detail: impl FnOnce(Entity) -> SheetDetail) -> (App, Entity, Entity) {
    let mut app = app();
    let viewer = app.world_mut().spawn(Transform::from_xyz(0.0, 0.0, 0.5)).id();
    app.insert_resource(detail(viewer));
    let sheet = Sheet::new("hips").clamp(Region::Left).detail_within(1.0);
    let sheet = app.world_mut().spawn((sheet, SheetDisplay::default())).id();
    frame(&mut app, 0.0);
    (app, viewer, sheet)
}

/// Displayed vertices in world space.
fn drawn(app: &App, sheet: Entity) -> Vec<Vec3> {
    let handle = app.world().get::<Mesh3d>(sheet).expect("drawn");
    let mesh = app.world().resource::<Assets<Mesh>>().get(&handle.0).expect("a mesh");
    let places = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|a| a.as_float3()).expect("positions");
    places.iter().map(|p| Vec3::from(*p)).collect()
}

#[test]
fn a_sheet_follows_the_viewer_and_its_mesh_follows_it() {
    let (mut app, viewer, sheet) = swinging(|viewer| SheetDetail { viewer: Some(viewer), ..default() });
    run(&mut app, 0.6);
    assert_eq!(grid(&app), 21);
    let fine = drawn(&app, sheet);
    assert_eq!(fine.len(), 81 * 81);
    app.world_mut().get_mut::<Transform>(viewer).expect("there").translation.z = 20.0;
    run(&mut app, 0.05);
    assert_eq!(grid(&app), 6);
    let masses = app.world().resource::<SheetWorld>().sheets()[0].node_count();
    assert_eq!(app.world().get::<SheetMotion>(sheet).expect("in the world").positions().len(), masses);
    let coarse = drawn(&app, sheet);
    assert_eq!(coarse.len(), 21 * 21);
    // Tolerance: the end of the sheet moves at 0.9 m/s for three ticks.
    for (i, p) in coarse.iter().enumerate() {
        let (column, row) = (i % 21, i / 21);
        let then = fine[row * 4 * 81 + column * 4];
        assert!(p.distance(then) < 0.05, "{p} was {then}");
    }
    app.world_mut().get_mut::<Transform>(viewer).expect("there").translation.z = 0.5;
    run(&mut app, 1.0);
    assert_eq!(grid(&app), 21);
    assert_eq!(drawn(&app, sheet).len(), fine.len());
}

#[test]
fn a_budget_by_the_model_does_not_depend_on_a_clock() {
    let (mut app, viewer, _) = swinging(|viewer| SheetDetail { viewer: Some(viewer), measured: false, ..default() });
    run(&mut app, 0.3);
    let cost = app.world().resource::<SheetWorld>().detail_cost().expect("levels");
    assert_eq!(grid(&app), 21);
    app.insert_resource(SheetDetail { viewer: Some(viewer), measured: false, ..SheetDetail::budget(0.5 * cost) });
    run(&mut app, 1.0);
    let world = app.world().resource::<SheetWorld>();
    assert!(world.sheets()[0].model.grid.0 < 21 && world.detail_cost().expect("levels") < 0.5 * cost);
}

#[test]
fn without_the_resource_nothing_changes() {
    let mut app = app();
    app.world_mut().spawn(Sheet::new("hips").clamp(Region::Left).detail_within(0.001));
    run(&mut app, 0.3);
    // Without camera and viewer the finest grid is used.
    assert_eq!(grid(&app), 21);
}

#[test]
fn a_grid_that_is_changed_in_the_component_is_changed_in_the_running_sheet() {
    let (mut app, _, sheet) = swinging(|viewer| SheetDetail { viewer: Some(viewer), ..default() });
    app.world_mut().get_mut::<Sheet>(sheet).expect("a sheet").spec.detail = None;
    run(&mut app, 0.3);
    let low = |app: &App| app.world().resource::<SheetWorld>().sheets()[0].centre_of_mass().y;
    let before = low(&app);
    assert!(before < -0.01, "it has fallen: {before}");
    app.world_mut().get_mut::<Sheet>(sheet).expect("a sheet").spec.grid = (11, 1, 11);
    run(&mut app, 1.0 / 64.0);
    assert_eq!(grid(&app), 11);
    assert!((low(&app) - before).abs() < 0.02, "it goes on from there: {} from {before}", low(&app));
}

#[test]
fn a_lattice_follows_the_viewer_too() {
    let mut app = app();
    let viewer = app.world_mut().spawn(Transform::from_xyz(0.0, 0.0, 0.5)).id();
    app.insert_resource(SheetDetail { viewer: Some(viewer), ..default() });
    let sheet = Sheet::new("hips").structure(StructureKind::Trimm).layers(2, 0.004).grid(17, 17).clamp(Region::Left);
    let sheet = app.world_mut().spawn((sheet.detail_within(1.0), SheetDisplay::default())).id();
    run(&mut app, 0.3);
    assert_eq!(grid(&app), 17);
    app.world_mut().get_mut::<Transform>(viewer).expect("there").translation.z = 2.0;
    run(&mut app, 0.05);
    let now = app.world().resource::<SheetWorld>().sheets()[0].model.grid;
    assert_eq!(now, (9, 2, 9));
    assert!(drawn(&app, sheet).iter().all(|p| p.is_finite() && p.length() < 0.5));
    app.world_mut().get_mut::<Transform>(viewer).expect("there").translation.z = 0.5;
    run(&mut app, 1.0);
    assert_eq!(grid(&app), 17);
}
