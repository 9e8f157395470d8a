//! Stage of the examples: window, light, ground and camera; or one picture without a window, with
//! `-- --picture FILE.png [SECONDS]`.

use std::path::PathBuf;
use std::time::Duration;

use bevy::app::PluginsState;
use bevy::camera::RenderTarget;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::view::screenshot::{Screenshot, save_to_disk};
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_sheetwork::prelude::*;

const FRAME: f64 = 1.0 / 60.0;
const SIZE: (u32, u32) = (800, 500);
/// Frames that lights, shadows and the file take.
const LAST_FRAMES: u32 = 12;

/// File of the picture and simulated time, s.
#[derive(Resource)]
struct PictureOf(PathBuf, f64);

/// Camera of an example.
#[derive(Component)]
#[require(Camera3d)]
pub struct Eye;

/// An app with the plugins, a light, the ground, and a camera at `eye` that looks at `target` (m).
pub fn app(title: &str, eye: Vec3, target: Vec3, seconds: f64) -> App {
    let mut arguments = std::env::args().skip_while(|argument| argument != "--picture").skip(1);
    let picture = arguments.next().map(|file| {
        let time = arguments.next().and_then(|time| time.parse().ok()).unwrap_or(seconds);
        PictureOf(file.into(), time)
    });
    let mut app = App::new();
    let window = Window { title: title.to_owned(), ..default() };
    let exit_condition = if picture.is_some() { ExitCondition::DontExit } else { ExitCondition::OnAllClosed };
    let plugins = DefaultPlugins
        .set(AssetPlugin { file_path: "../../assets".into(), ..default() })
        .set(WindowPlugin { primary_window: picture.is_none().then_some(window), exit_condition, ..default() })
        .set(RenderPlugin { synchronous_pipeline_compilation: picture.is_some(), ..default() });
    match picture {
        Some(picture) => {
            app.add_plugins(plugins.disable::<WinitPlugin>().disable::<PipelinedRenderingPlugin>());
            app.insert_resource(picture).set_runner(draw);
        }
        None => _ = app.add_plugins(plugins),
    }
    app.add_plugins(SheetworkPlugins).insert_resource(ClearColor(Color::srgb(0.80, 0.84, 0.89)));
    app.insert_resource(Time::<Fixed>::from_hz(60.0));
    app.add_systems(
        Startup,
        move |commands: Commands, meshes: ResMut<Assets<Mesh>>, paints: ResMut<Assets<StandardMaterial>>| {
            light(commands, meshes, paints, eye, target);
        },
    );
    app
}

fn light(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut paints: ResMut<Assets<StandardMaterial>>,
    eye: Vec3,
    target: Vec3,
) {
    let ambient = AmbientLight { brightness: 380.0, ..default() };
    let near = Projection::Perspective(PerspectiveProjection { near: 0.01, ..default() });
    commands.spawn((Eye, near, ambient, Transform::from_translation(eye).looking_at(target, Vec3::Y)));
    let shadows = bevy::light::CascadeShadowConfigBuilder {
        minimum_distance: 0.02,
        first_cascade_far_bound: 1.2 * eye.distance(target),
        maximum_distance: 4.0 * eye.distance(target),
        ..default()
    };
    let sun = DirectionalLight { illuminance: 7_500.0, shadow_maps_enabled: true, ..default() };
    commands.spawn((sun, shadows.build(), Transform::from_xyz(0.7, 1.4, 0.9).looking_at(Vec3::ZERO, Vec3::Y)));
    let ground = paints.add(StandardMaterial {
        base_color: Color::srgb(0.62, 0.60, 0.57),
        perceptual_roughness: 0.95,
        ..default()
    });
    let plane = Mesh3d(meshes.add(Plane3d::default().mesh().size(60.0, 60.0)));
    commands.spawn((plane, MeshMaterial3d(ground), SheetBody::floor()));
}

/// Run for the time of the picture, draw the camera's view into an image, and write it.
fn draw(mut app: App) -> AppExit {
    while app.plugins_state() == PluginsState::Adding {
        std::thread::sleep(Duration::from_millis(1));
    }
    app.finish();
    app.cleanup();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(FRAME)));
    let mut image = Image::new_target_texture(SIZE.0, SIZE.1, TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    let Some(PictureOf(file, time)) = app.world_mut().remove_resource::<PictureOf>() else { return AppExit::error() };
    // The view is drawn only in the last frames.
    for frame in 0..(time / FRAME) as u32 + LAST_FRAMES {
        app.update();
        let mut cameras = app.world_mut().query_filtered::<(Entity, &mut Camera), With<Eye>>();
        let shown = frame >= (time / FRAME) as u32;
        app.world_mut().resource_mut::<SheetClock>().paused = shown;
        let found: Vec<Entity> = cameras
            .iter_mut(app.world_mut())
            .map(|(entity, mut camera)| {
                camera.is_active = shown;
                entity
            })
            .collect();
        for camera in found.into_iter().filter(|_| frame == 0) {
            app.world_mut().entity_mut(camera).insert(RenderTarget::Image(target.clone().into()));
        }
    }
    app.world_mut().spawn(Screenshot::image(target)).observe(save_to_disk(file));
    for _ in 0..LAST_FRAMES {
        app.update();
    }
    AppExit::Success
}
