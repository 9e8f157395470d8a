//! Lights, camera and backdrop: the same for the window and for pictures.
//!
//! The scene is drawn at a scale at which its content is about one unit across, because shadow biases and cascades have
//! lengths of their own: a sheet of centimetres and one of metres then look alike.

use bevy::camera::visibility::{NoFrustumCulling, RenderLayers};
use bevy::camera::{CameraMainTextureUsages, CameraOutputMode, Viewport};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::light::{
    CascadeShadowConfig, CascadeShadowConfigBuilder, DirectionalLightShadowMap, NotShadowCaster, NotShadowReceiver,
    ShadowFilteringMethod,
};
use bevy::prelude::*;
use bevy::render::render_resource::{BlendState, TextureUsages};
use bevy_egui::{PrimaryEguiContext, egui};

use super::{Editor, shapes};
use crate::session::MOST_BESIDE;
use crate::tiles::tiles;

/// How much is spent on the picture.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Quality {
    /// Samples a pixel.
    pub msaa: Msaa,
    /// Texels along the edge of the shadow map; 0 for no shadows.
    pub shadows: usize,
}

impl Quality {
    /// For pictures to be shown.
    pub const BEST: Self = Self { msaa: Msaa::Sample4, shadows: 4096 };
    /// For a window with a graphics processor.
    pub const WINDOW: Self = Self { msaa: Msaa::Sample4, shadows: 2048 };
    /// For a window drawn by the processor.
    pub const SOFTWARE: Self = Self { msaa: Msaa::Off, shadows: 1024 };
}

/// Drawn units a metre.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Scale(pub f32);

/// The camera that sees world `0` of those that are compared; the first is the scene's own.
#[derive(Component, Clone, Copy)]
pub struct SceneCamera(pub usize);

/// Most worlds that are seen at once.
pub const MOST_SEEN: usize = MOST_BESIDE + 1;

/// How far apart worlds are that are compared, drawn units along x: each is behind the others' backdrops.
const APART: f32 = 1.05 * BACKDROP;

/// How far from the target shadows are drawn, drawn units: the content is about one across.
const SHADOWED: f32 = 1.5;

/// Radius of the ball behind everything, drawn units.
const BACKDROP: f32 = 400.0;

/// Where world `which` of those that are compared is drawn.
pub fn aside(which: usize) -> Vec3 {
    Vec3::X * (APART * which as f32)
}

/// What of world `which` only its own camera sees.
pub fn layer(which: usize) -> RenderLayers {
    RenderLayers::layer(which)
}

/// What every camera sees.
fn all_layers() -> RenderLayers {
    (0..MOST_SEEN).collect()
}

/// The light that throws the shadows.
#[derive(Component)]
pub struct KeyLight;

/// The ball behind everything that camera `0` sees.
#[derive(Component)]
pub struct Backdrop(usize);

/// What the camera of world `which` needs, whatever it draws into. Those of variants rest until there are some.
pub fn camera(quality: &Quality, which: usize) -> impl Bundle {
    // They share one picture, which the first clears.
    let clear_color =
        if which == 0 { ClearColorConfig::Custom(Color::srgb(0.16, 0.17, 0.19)) } else { ClearColorConfig::None };
    let order = which as isize - MOST_SEEN as isize;
    (
        SceneCamera(which),
        layer(which),
        Camera3d::default(),
        Camera { clear_color, order, is_active: which == 0, ..default() },
        Projection::Perspective(PerspectiveProjection { near: 1e-3, far: 1e3, ..default() }),
        Tonemapping::AcesFitted,
        ShadowFilteringMethod::Gaussian,
        quality.msaa,
        Transform::default(),
    )
}

/// The camera of the panels, above the scene's, whatever both draw into.
pub fn panel_camera() -> impl Bundle {
    (
        PrimaryEguiContext,
        Camera2d,
        Msaa::Off,
        // Cameras that agree in all of this share one picture, and clearing the panels' would wipe the scene's.
        CameraMainTextureUsages::default().with(TextureUsages::COPY_DST),
        RenderLayers::none(),
        Camera {
            order: 1,
            output_mode: CameraOutputMode::Write {
                blend_state: Some(BlendState::ALPHA_BLENDING),
                clear_color: ClearColorConfig::None,
            },
            clear_color: ClearColorConfig::Custom(Color::NONE),
            ..default()
        },
    )
}

/// Lets the cameras of the worlds that are compared draw into their parts of `rect`; `scale` is pixels a point, `whole` the size of the picture,
/// pixels.
pub fn share<'a>(
    cameras: impl Iterator<Item = (&'a SceneCamera, Mut<'a, Camera>)>,
    (rect, count): (egui::Rect, usize),
    (scale, whole): (f32, UVec2),
) {
    let tiles = tiles(rect, count);
    for (which, mut camera) in cameras {
        if let Some(tile) = tiles.get(which.0) {
            fit(&mut camera, *tile, scale, whole);
        }
    }
}

/// Lets the cameras of `count` worlds draw, or all of them rest.
pub fn wake<'a>(cameras: impl Iterator<Item = (&'a SceneCamera, Mut<'a, Camera>)>, count: usize, awake: bool) {
    for (which, mut camera) in cameras {
        let awake = awake && which.0 < count;
        if camera.is_active != awake {
            camera.is_active = awake;
        }
    }
}

/// Lets a scene's camera draw into a part of the picture.
fn fit(camera: &mut Mut<'_, Camera>, rect: egui::Rect, scale: f32, whole: UVec2) {
    let pixel = |p: egui::Pos2| UVec2::new((p.x * scale).round() as u32, (p.y * scale).round() as u32).min(whole);
    let (low, high) = (pixel(rect.min), pixel(rect.max));
    let size = high.saturating_sub(low);
    let viewport =
        (size.x > 0 && size.y > 0).then(|| Viewport { physical_position: low, physical_size: size, ..default() });
    let place = |v: &Option<Viewport>| v.as_ref().map(|v| (v.physical_position, v.physical_size));
    if place(&camera.viewport) != place(&viewport) {
        camera.viewport = viewport;
    }
}

/// Puts up the lights and the backdrop.
pub fn set_up(
    mut commands: Commands,
    quality: Res<Quality>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut gizmos: ResMut<GizmoConfigStore>,
) {
    gizmos.config_mut::<DefaultGizmoConfigGroup>().0.render_layers = all_layers();
    let shadows = quality.shadows > 0;
    commands.insert_resource(DirectionalLightShadowMap { size: quality.shadows.max(64) });
    commands.insert_resource(GlobalAmbientLight {
        color: Color::srgb(0.96, 0.97, 1.0),
        brightness: 520.0,
        ..default()
    });
    let light = |colour: Color, illuminance: f32, from: Vec3, shadows: bool| {
        (
            DirectionalLight {
                color: colour,
                illuminance,
                shadow_maps_enabled: shadows,
                shadow_depth_bias: 0.01,
                shadow_normal_bias: 1.4,
                ..default()
            },
            Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y),
            all_layers(),
        )
    };
    // From behind and to the right, so that shadows fall towards the viewer and gloss shows.
    commands.spawn((KeyLight, light(Color::srgb(1.0, 0.955, 0.88), 6_600.0, Vec3::new(0.66, 1.0, -0.30), shadows)));
    commands.spawn(light(Color::srgb(0.92, 0.95, 1.0), 3_000.0, Vec3::new(-0.50, 0.45, 1.0), false));
    commands.spawn(light(Color::srgb(1.0, 0.93, 0.85), 900.0, Vec3::new(1.0, 0.35, 0.5), false));
    let (ball, paint) = (
        meshes.add(shapes::backdrop()),
        materials.add(StandardMaterial { unlit: true, cull_mode: None, fog_enabled: false, ..default() }),
    );
    for which in 0..MOST_SEEN {
        commands.spawn((
            (Backdrop(which), layer(which)),
            (Mesh3d(ball.clone()), MeshMaterial3d(paint.clone())),
            Transform::from_scale(Vec3::splat(BACKDROP)),
            (NotShadowCaster, NotShadowReceiver, NoFrustumCulling),
        ));
    }
}

/// Puts the cameras where the editor's state has them: they go together.
pub fn move_camera(
    editor: Res<Editor>,
    scale: Res<Scale>,
    mut cameras: Query<(&SceneCamera, &Camera, &mut Transform, &mut Projection)>,
    mut backdrops: Query<(&Backdrop, &mut Transform), Without<SceneCamera>>,
    mut shadows: Query<&mut CascadeShadowConfig, With<KeyLight>>,
    mut shadowed: Local<f32>,
) {
    let camera = &editor.state.camera;
    let wanted = Transform::from_translation(camera.eye() * scale.0).looking_at(camera.target * scale.0, Vec3::Y);
    let moved = |which: usize| wanted.with_translation(wanted.translation + aside(which));
    for (which, seen, mut transform, mut projection) in &mut cameras {
        transform.set_if_neq(moved(which.0));
        let opening = camera.opening(seen.logical_viewport_size().unwrap_or(Vec2::ONE));
        if let Projection::Perspective(perspective) = &mut *projection
            && perspective.fov != opening
        {
            perspective.fov = opening;
        }
    }
    for (which, mut transform) in &mut backdrops {
        transform.translation = moved(which.0).translation;
    }
    // The shadow map covers what is near the target, at whatever distance that is looked at, and little else: texels that show the room are not
    // there for the outline of a shadow.
    let distance = camera.distance * scale.0;
    if (distance / *shadowed - 1.0).abs() > 0.05 || !(distance / *shadowed).is_finite() {
        *shadowed = distance;
        for mut config in &mut shadows {
            let (near, far) = ((distance - SHADOWED).max(0.05 * distance), distance + SHADOWED);
            *config = CascadeShadowConfigBuilder {
                num_cascades: 1,
                minimum_distance: near,
                maximum_distance: far,
                first_cascade_far_bound: far,
                ..default()
            }
            .build();
        }
    }
}
