//! Lights, cameras and backdrop of window and pictures.
//!
//! The scene is scaled so that its content is about one unit wide, because shadow biases and
//! cascades have absolute lengths: sheets of centimetres and of metres then look alike.

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
use crate::session::MAX_VARIANTS;
use crate::tiles::tiles;

/// Rendering quality.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Quality {
    /// Samples per pixel.
    pub msaa: Msaa,
    /// Texels along the edge of the shadow map; 0 for no shadows.
    pub shadows: usize,
}

impl Quality {
    /// Quality of pictures.
    pub const BEST: Self = Self { msaa: Msaa::Sample4, shadows: 4096 };
    /// Quality of a window with a graphics processor.
    pub const WINDOW: Self = Self { msaa: Msaa::Sample4, shadows: 2048 };
    /// Quality of a window with software rendering.
    pub const SOFTWARE: Self = Self { msaa: Msaa::Off, shadows: 1024 };
}

/// Displayed units per metre.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Scale(pub f32);

/// Camera of world `0` of the comparison; index 0 is the scene itself.
#[derive(Component, Clone, Copy)]
pub struct SceneCamera(pub usize);

/// Maximum number of displayed worlds.
pub const MAX_WORLDS: usize = MAX_VARIANTS + 1;

/// Distance between compared worlds, displayed units along x: each is behind the backdrops of the
/// others.
const APART: f32 = 1.05 * BACKDROP;

/// Range of shadows around the target, displayed units: the content is about one unit wide.
const SHADOWED: f32 = 1.5;

/// Radius of the backdrop, displayed units.
const BACKDROP: f32 = 400.0;

/// Offset of world `which` of the comparison.
pub fn aside(which: usize) -> Vec3 {
    Vec3::X * (APART * which as f32)
}

/// Render layer of the entities that only the camera of world `which` sees.
pub fn layer(which: usize) -> RenderLayers {
    RenderLayers::layer(which)
}

/// Render layers of every camera.
fn all_layers() -> RenderLayers {
    (0..MAX_WORLDS).collect()
}

/// Light that casts shadows.
#[derive(Component)]
pub struct KeyLight;

/// Backdrop of camera `0`.
#[derive(Component)]
pub struct Backdrop(usize);

/// Components of the camera of world `which`, for any target. Cameras of variants are inactive
/// until there are some.
pub fn camera(quality: &Quality, which: usize) -> impl Bundle {
    // All cameras share one picture, which the first clears.
    let clear_color =
        if which == 0 { ClearColorConfig::Custom(Color::srgb(0.16, 0.17, 0.19)) } else { ClearColorConfig::None };
    let order = which as isize - MAX_WORLDS as isize;
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

/// Components of the camera of the panels, above those of the scene, for any target.
pub fn panel_camera() -> impl Bundle {
    (
        PrimaryEguiContext,
        Camera2d,
        Msaa::Off,
        // Cameras with equal settings share one texture, and clearing that of the panels would
        // erase the scene.
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

/// Assign parts of `rect` to the cameras of the compared worlds; `scale` is pixels per point,
/// `whole` the size of the picture, pixels.
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

/// Activate the cameras of `count` worlds, or deactivate all.
pub fn wake<'a>(cameras: impl Iterator<Item = (&'a SceneCamera, Mut<'a, Camera>)>, count: usize, awake: bool) {
    for (which, mut camera) in cameras {
        let awake = awake && which.0 < count;
        if camera.is_active != awake {
            camera.is_active = awake;
        }
    }
}

/// Set the viewport of a camera.
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

/// Spawn the lights and the backdrop.
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
    // From behind and the right: shadows fall towards the viewer, and gloss is visible.
    commands.spawn((KeyLight, light(Color::srgb(1.0, 0.955, 0.88), 6_600.0, Vec3::new(0.66, 1.0, -0.30), shadows)));
    commands.spawn(light(Color::srgb(0.92, 0.95, 1.0), 3_000.0, Vec3::new(-0.50, 0.45, 1.0), false));
    commands.spawn(light(Color::srgb(1.0, 0.93, 0.85), 900.0, Vec3::new(1.0, 0.35, 0.5), false));
    let (ball, paint) = (
        meshes.add(shapes::backdrop()),
        materials.add(StandardMaterial { unlit: true, cull_mode: None, fog_enabled: false, ..default() }),
    );
    for which in 0..MAX_WORLDS {
        commands.spawn((
            (Backdrop(which), layer(which)),
            (Mesh3d(ball.clone()), MeshMaterial3d(paint.clone())),
            Transform::from_scale(Vec3::splat(BACKDROP)),
            (NotShadowCaster, NotShadowReceiver, NoFrustumCulling),
        ));
    }
}

/// Move all cameras to the pose of the editor's camera.
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
    // The shadow map covers the neighbourhood of the target at every viewing distance, so that its
    // texels are not spent on the room.
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
