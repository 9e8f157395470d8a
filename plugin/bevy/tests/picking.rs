//! Picking: pointers over and clicks on sheets, the hit data, and queries of displayed sheets.
#![cfg(feature = "render")]

mod common;

use bevy::app::PluginGroup;
use bevy::camera::{Camera, CameraProjection, NormalizedRenderTarget, RenderTarget, RenderTargetInfo};
use bevy::ecs::system::SystemState;
use bevy::picking::backend::HitData;
use bevy::picking::pointer::{Location, PointerAction, PointerId, PointerInput};
use bevy::picking::{InteractionPlugin, PickingPlugin};
use bevy::prelude::*;
use bevy::window::{PrimaryWindow, WindowRef};
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::{QueryFilter, SurfacePoint};
use common::{app_with, frame, run};

const SIZE: UVec2 = UVec2::new(400, 300);

/// Events on sheets, by entity.
#[derive(Resource, Default)]
struct Seen(Vec<(&'static str, Entity, HitData)>);

/// An app with a window, a mouse and a camera 1 m above the origin that looks down, with -z at the
/// top of the picture; nothing is drawn.
fn picking_app() -> App {
    let plugins = SheetworkPlugins.build().add(SheetPickingPlugin);
    let mut app = app_with(plugins.add(PickingPlugin).add(InteractionPlugin));
    app.init_resource::<Seen>();
    app.world_mut().spawn((Window::default(), PrimaryWindow));
    app.world_mut().spawn(PointerId::Mouse);
    let mut projection = PerspectiveProjection { aspect_ratio: SIZE.x as f32 / SIZE.y as f32, ..default() };
    projection.update(SIZE.x as f32, SIZE.y as f32);
    let mut camera = Camera::default();
    camera.computed.clip_from_view = projection.get_clip_from_view();
    camera.computed.target_info = Some(RenderTargetInfo { physical_size: SIZE, scale_factor: 1.0 });
    let place = Transform::from_xyz(0.0, 1.0, 0.0).looking_at(Vec3::ZERO, Vec3::NEG_Z);
    app.world_mut().spawn((camera, RenderTarget::Window(WindowRef::Primary), place));
    app.add_observer(|over: On<Pointer<Over>>, mut seen: ResMut<Seen>| {
        seen.0.push(("over", over.entity, over.hit.clone()));
    });
    app.add_observer(|out: On<Pointer<Out>>, mut seen: ResMut<Seen>| {
        seen.0.push(("out", out.entity, out.hit.clone()));
    });
    app.add_observer(|click: On<Pointer<Click>>, mut seen: ResMut<Seen>| {
        seen.0.push(("click", click.entity, click.hit.clone()));
    });
    app
}

/// A card that floats at the height `y`, 20 cm square.
fn floating(app: &mut App, y: f32) -> Entity {
    app.world_mut().resource_mut::<SheetWorld>().set("gravity", "(0, 0, 0)").expect("allowed");
    app.world_mut().spawn((Sheet::new("card").size(0.2, 0.2), Transform::from_xyz(0.0, y, 0.0))).id()
}

/// Send an action of the mouse at a point of the window and run a frame.
fn point(app: &mut App, position: Vec2, action: PointerAction) {
    let window = app.world_mut().query_filtered::<Entity, With<PrimaryWindow>>().single(app.world()).expect("one");
    let target = WindowRef::Entity(window).normalize(Some(window)).expect("a window");
    let location = Location { target: NormalizedRenderTarget::Window(target), position };
    app.world_mut().write_message(PointerInput::new(PointerId::Mouse, location, action));
    frame(app, 1.0 / 64.0);
}

fn move_to(app: &mut App, position: Vec2) {
    point(app, position, PointerAction::Move { delta: Vec2::ONE });
}

fn click(app: &mut App, position: Vec2) {
    point(app, position, PointerAction::Press(PointerButton::Primary));
    point(app, position, PointerAction::Release(PointerButton::Primary));
}

/// Events on `entity` since the last call.
fn take(app: &mut App, entity: Entity) -> Vec<(&'static str, HitData)> {
    let seen = std::mem::take(&mut app.world_mut().resource_mut::<Seen>().0);
    seen.into_iter().filter(|(_, on, _)| *on == entity).map(|(name, _, hit)| (name, hit)).collect()
}

/// Point of the window over (x, 0, z) m.
fn over(x: f32, z: f32) -> Vec2 {
    let focal = 0.5 * SIZE.y as f32 / (0.5 * PerspectiveProjection::default().fov).tan();
    0.5 * SIZE.as_vec2() + focal * Vec2::new(x, z)
}

#[test]
fn a_pointer_over_a_sheet_and_a_click_on_it_are_told_with_place_and_uv() {
    let mut app = picking_app();
    let sheet = floating(&mut app, 0.0);
    run(&mut app, 0.1);
    move_to(&mut app, over(0.3, 0.0));
    assert!(take(&mut app, sheet).is_empty(), "beside it");
    move_to(&mut app, over(0.05, -0.03));
    let events = take(&mut app, sheet);
    let [("over", hit)] = &events[..] else { panic!("{events:?}") };
    assert!(hit.position.expect("given").distance(Vec3::new(0.05, 0.0, -0.03)) < 1e-4, "{hit:?}");
    assert!(hit.normal.expect("given").distance(Vec3::Y) < 1e-4);
    let point = hit.extra_as::<SurfacePoint>().expect("extra data");
    assert!((point.uv.0 - 0.75).abs() < 1e-3 && (point.uv.1 - 0.35).abs() < 1e-3, "{point:?}");
    click(&mut app, over(0.05, -0.03));
    let events = take(&mut app, sheet);
    assert!(
        events.iter().any(|(name, hit)| *name == "click" && hit.extra_as::<SurfacePoint>().is_some()),
        "{events:?}"
    );
    move_to(&mut app, over(0.3, 0.0));
    assert!(take(&mut app, sheet).iter().any(|(name, _)| *name == "out"));
}

#[test]
fn the_upper_of_two_sheets_is_hit_and_one_that_is_hidden_or_ignored_is_not() {
    let mut app = picking_app();
    let (lower, upper) = (floating(&mut app, 0.0), floating(&mut app, 0.2));
    run(&mut app, 0.1);
    let at = over(0.01, 0.02);
    move_to(&mut app, at);
    let seen: Vec<Entity> = app.world().resource::<Seen>().0.iter().map(|seen| seen.1).collect();
    assert!(seen.contains(&upper) && !seen.contains(&lower), "{seen:?}");
    app.world_mut().entity_mut(upper).insert(Pickable::IGNORE);
    move_to(&mut app, at);
    let seen = std::mem::take(&mut app.world_mut().resource_mut::<Seen>().0);
    assert!(seen.iter().any(|seen| seen.0 == "over" && seen.1 == lower));
    app.world_mut().entity_mut(lower).insert(Visibility::Hidden);
    run(&mut app, 0.1);
    move_to(&mut app, at);
    assert!(take(&mut app, lower).iter().any(|(name, _)| *name == "out"));
}

#[test]
fn queries_meet_the_displayed_state_and_know_the_entities() {
    let mut app = picking_app();
    let sheet = app.world_mut().spawn((Sheet::new("card").velocity(Vec3::Y * 2.0), Transform::default())).id();
    run(&mut app, 0.25);
    // Between two ticks.
    frame(&mut app, 0.4 / 64.0);
    let mut state: SystemState<(SheetRayCast, Res<SheetWorld>, Query<&SheetMotion>)> =
        SystemState::new(app.world_mut());
    let (sheets, world, motions) = state.get(app.world()).expect("valid");
    let ray = Ray3d::new(Vec3::new(0.01, 5.0, 0.02), Dir3::NEG_Y);
    let (entity, hit) = sheets.cast_ray(ray, 9.0).expect("under the ray");
    assert_eq!(entity, sheet);
    assert_eq!(sheets.entity_of(hit.sheet), Some(sheet));
    let motion = motions.get(sheet).expect("there");
    let shown = motion.at(hit.node as usize, world.shown_time()).expect("there");
    assert!((shown.y as f64 - hit.position.y).abs() < 1e-3, "{shown} {hit:?}");
    let simulated =
        world.queries(QueryFilter::default()).cast_ray(ray.origin.as_dvec3(), ray.direction.as_dvec3(), 9.0);
    let ahead = simulated.expect("under the ray").position.y - hit.position.y;
    assert!(ahead.abs() > 1e-3, "the displayed sheet lags by {ahead} m");
    assert!(sheets.cast_ray(ray, 0.1).is_none());
}
