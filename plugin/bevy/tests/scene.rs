//! Scenes from files: loaded, spawned, changed, rejected.
#![cfg(feature = "render")]

mod common;

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::Scene;
use common::{app, frame, run, run_until};

fn scene(text: &str) -> SheetScene {
    Scene::parse(text).expect("valid").into()
}

const TWO: &str = r#"(
    name: "two", gravity: (0, -1, 0), engine: "euler-richardson", dt: 0.005,
    room: (x: (-0.1, 0.1), y: (0.0, 0.1), z: (-0.1, 0.1)),
    sheets: [
        (
            name: "a", structure: "trimm", grid: (11, 2, 11), size: (0.025, 0.025), material: "thesis", springs: Uniform,
            placement: (position: (0, 0.02, 0)),
        ),
        (
            name: "b", structure: "trimm", grid: (11, 2, 11), size: (0.025, 0.025), material: "thesis", springs: Uniform,
            placement: (position: (0, 0.05, 0)),
        ),
    ],
    bodies: [(name: "ball", shape: Ball(0.01))],
)"#;

fn spawn(app: &mut App, scene: SheetScene) -> (Entity, Handle<SheetScene>) {
    let handle = app.world_mut().resource_mut::<Assets<SheetScene>>().add(scene);
    let root = app.world_mut().spawn(SheetSceneRoot(handle.clone())).id();
    (root, handle)
}

fn names(app: &App) -> (Vec<String>, Vec<String>) {
    let world = app.world().resource::<SheetWorld>();
    let sheets = world.sheets().iter().map(|s| s.name.clone()).collect();
    let bodies = world.rigid().map_or(vec![], |r| r.bodies().iter().map(|b| b.name.clone()).collect());
    (sheets, bodies)
}

#[test]
fn the_wedge_scene_is_loaded_from_its_file_and_runs_as_it_does_headless() {
    let mut app = app();
    let server = app.world().resource::<AssetServer>();
    let root = SheetSceneRoot(server.load("scenes/wedge.ron"));
    let root = app.world_mut().spawn(root).id();
    let came = run_until(&mut app, 400, |app| !app.world().resource::<SheetWorld>().is_empty());
    assert!(came, "the scene was not spawned");
    assert_eq!(app.world().get::<Children>(root).map(|c| c.len()), Some(5), "room, floor, back wall, wedge, sheet");
    run(&mut app, 2.0);
    let world = app.world().resource::<SheetWorld>();
    let scene = Scene::load(std::path::Path::new("../../assets/scenes/wedge.ron")).expect("valid");
    let mut alone = sheetwork::World::new(&scene).expect("valid");
    while alone.steps() < world.steps() {
        alone.step();
    }
    assert!(alone.steps() > 100);
    assert_eq!(world.sheets()[0].state.x, alone.sheets()[0].state.x, "to the last bit");
}

#[test]
fn a_scene_is_spawned_under_its_root_and_removed_with_it() {
    let mut app = app();
    let (root, _) = spawn(&mut app, scene(TWO));
    run(&mut app, 0.5);
    assert_eq!(names(&app).0, ["a", "b"]);
    assert_eq!(names(&app).1, ["ball", "floor", "back wall"]);
    let world = app.world().resource::<SheetWorld>();
    assert_eq!((world.gravity().y, world.dt()), (-1.0, 0.005));
    assert!(world.time() > 0.3);
    app.world_mut().despawn(root);
    assert!(app.world().resource::<SheetWorld>().is_empty());
}

#[test]
fn a_scene_that_is_changed_starts_again() {
    let mut app = app();
    let (root, handle) = spawn(&mut app, scene(TWO));
    run(&mut app, 1.0);
    let children = |app: &App| app.world().get::<Children>(root).map_or(0, |c| c.len());
    assert_eq!(children(&app), 6);
    let changed = scene(&TWO.replace("\"b\"", "\"c\"").replace("-1, 0)", "-2, 0)"));
    *app.world_mut().resource_mut::<Assets<SheetScene>>().get_mut(&handle).expect("there") = changed;
    run(&mut app, 0.1);
    assert_eq!(names(&app).0, ["a", "c"]);
    let world = app.world().resource::<SheetWorld>();
    assert_eq!(world.gravity().y, -2.0);
    assert!(world.time() < 0.2, "from the start");
    assert_eq!(children(&app), 6);

    let root_again = app.world().get::<SheetSceneRoot>(root).cloned().expect("has one");
    run(&mut app, 0.5);
    app.world_mut().entity_mut(root).insert(root_again);
    run(&mut app, 0.1);
    assert!(app.world().resource::<SheetWorld>().time() < 0.2, "inserting the root again resets it");
}

#[test]
fn a_bad_change_leaves_the_scene_running() {
    let mut app = app();
    let (_, handle) = spawn(&mut app, scene(TWO));
    run(&mut app, 0.5);
    let mut bad = scene(TWO);
    bad.scene.sheets[0].size.0 = -1.0;
    *app.world_mut().resource_mut::<Assets<SheetScene>>().get_mut(&handle).expect("there") = bad;
    run(&mut app, 0.5);
    assert_eq!(names(&app).0, ["a", "b"]);
    assert!(app.world().resource::<SheetWorld>().time() > 0.9, "as if nothing had been");
    *app.world_mut().resource_mut::<Assets<SheetScene>>().get_mut(&handle).expect("there") = scene(TWO);
    run(&mut app, 0.1);
    assert!(app.world().resource::<SheetWorld>().time() < 0.2, "mended");
}

#[test]
fn a_changed_file_is_reloaded_and_an_invalid_one_is_not() {
    let folder = std::env::temp_dir().join(format!("bevy_sheetwork_{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let file = folder.join("here.sheet.ron");
    std::fs::write(&file, TWO).expect("written");
    let mut app = App::new();
    let assets = AssetPlugin { file_path: folder.to_string_lossy().into_owned(), ..default() };
    app.add_plugins((MinimalPlugins, TransformPlugin, assets, SheetworkPlugins));
    let server = app.world().resource::<AssetServer>().clone();
    app.world_mut().spawn(SheetSceneRoot(server.load("here.sheet.ron")));
    assert!(run_until(&mut app, 400, |app| names(app).0 == ["a", "b"]), "loaded");

    std::fs::write(&file, TWO.replace("dt: 0.005", "dt: -3")).expect("written");
    server.reload("here.sheet.ron");
    assert!(!run_until(&mut app, 60, |app| names(app).0 != ["a", "b"]), "the old scene goes on");
    std::fs::write(&file, TWO.replace("\"b\"", "\"new\"")).expect("written");
    server.reload("here.sheet.ron");
    assert!(run_until(&mut app, 400, |app| names(app).0 == ["a", "new"]), "followed");
    std::fs::remove_dir_all(&folder).ok();
}

#[test]
fn two_scenes_share_the_world_at_their_own_placements() {
    let mut app = app();
    spawn(&mut app, scene(TWO));
    run(&mut app, 0.5);
    let (second, _) = spawn(&mut app, scene(TWO));
    let there = Transform::from_xyz(1.0, 0.0, 0.0).with_rotation(Quat::from_rotation_y(1.0));
    app.world_mut().entity_mut(second).insert(there);
    frame(&mut app, 1.0 / 64.0);
    assert_eq!(names(&app).0, ["a", "b", "a 2", "b 2"]);
    let world = app.world().resource::<SheetWorld>();
    assert!(world.time() > 0.4, "the first goes on");
    let centre = world.sheet("a 2").expect("there").centre_of_mass();
    assert!((centre.x - 1.0).abs() < 1e-3 && centre.y > 0.01, "{centre}");
    app.world_mut().despawn(second);
    assert_eq!(names(&app).0, ["a", "b"]);
}

#[test]
fn polyhedra_and_sheets_are_assets_too() {
    let mut app = app();
    let server = app.world().resource::<AssetServer>().clone();
    let pol: Handle<SheetPolyhedra> = server.load("polyhedra/two_bodies.pol");
    let sht: Handle<bevy_sheetwork::SheetFileAsset> = server.load("sheets/slamm_5x2x5.sht");
    let body = app.world_mut().spawn(SheetBody::from_asset(pol.clone())).id();
    let loaded = |app: &mut App| {
        app.world().resource::<Assets<SheetPolyhedra>>().get(&pol).is_some()
            && app.world().resource::<Assets<bevy_sheetwork::SheetFileAsset>>().get(&sht).is_some()
    };
    assert!(run_until(&mut app, 400, loaded));
    frame(&mut app, 1.0 / 64.0);
    assert_eq!(names(&app).1.len(), 2, "one body a polyhedron");
    assert!(app.world().get::<Mesh3d>(body).is_some());
    app.world_mut().despawn(body);
    assert!(names(&app).1.is_empty());
}

#[test]
fn the_heat_sources_of_a_scene_are_spawned_with_it() {
    let mut app = app();
    let text = r#"(
        name: "hot", engine: "tr-bdf2", dt: 0.015625, gravity: (0, 0, 0), ambient_temperature: 30, time_lapse: 20,
        oven: (temperature: 90),
        heat_gun: (position: (0, 0.05, 0)),
        heaters: [(name: "lamp", size: (0.1, 0.01, 0.1), hot: [(face: 2, temperature: 300)], placement: (position: (0, 0.1, 0)))],
        sheets: [(name: "a", structure: "shell", grid: (5, 1, 5), size: (0.1, 0.1), material: "hips")],
        bodies: [(name: "ball", shape: Ball(0.01), placement: (position: (0, -0.2, 0)), temperature: 60)],
    )"#;
    let (root, _) = spawn(&mut app, scene(text));
    app.world_mut().entity_mut(root).insert(Transform::from_xyz(1.0, 0.0, 0.0));
    run(&mut app, 1.0);
    let value = |app: &App, path: &str| {
        let all = app.world().resource::<SheetWorld>().parameters();
        all.into_iter().find(|p| p.path == path).map(|p| p.value.parse::<f64>().expect("a number"))
    };
    let wanted = [
        ("ambient_temperature", 30.0),
        ("time_lapse", 20.0),
        ("oven.temperature", 90.0),
        ("heat_gun.position.0", 1.0),
        ("heaters.lamp.temperature", 300.0),
        ("bodies.ball.temperature", 60.0),
    ];
    for (path, wanted) in wanted {
        assert_eq!(value(&app, path), Some(wanted), "{path}");
    }
    let heaters: Vec<_> = app.world_mut().query::<(&SheetHeater, &GlobalTransform)>().iter(app.world()).collect();
    assert_eq!(heaters.len(), 1);
    assert_eq!(heaters[0].1.translation(), Vec3::new(1.0, 0.1, 0.0));
    let state = *app.world_mut().query::<&SheetState>().single(app.world()).expect("one sheet");
    let (coldest, hottest) = state.temperature.expect("heated");
    assert!(coldest > 31.0 && hottest > coldest + 5.0, "hotter below the jet: {coldest} {hottest}");
    app.world_mut().despawn(root);
    assert_eq!(value(&app, "heaters.lamp.temperature"), None, "goes with its entity");
}
