//! Gizmos of springs and nodes.

use bevy::math::Isometry3d;
use bevy::prelude::*;
use bevy::transform::TransformSystems;
use sheetwork::sheet::Sheet as SheetInWorld;

use crate::core::{SheetMotion, SheetWorld, SheetworkDisplay};

/// Debug drawing of all sheets. The colour of a spring is its strain: blue in compression, white at
/// rest, yellow in tension.
#[derive(Resource, Reflect, Clone, Debug, PartialEq)]
#[reflect(Resource, Clone, Debug, Default, PartialEq)]
pub struct SheetDebug {
    /// Whether springs are drawn.
    pub springs: bool,
    /// Whether nodes are drawn; nodes in contact with a body are highlighted.
    pub masses: bool,
    /// Strain of the full colour of a spring; more than 0.
    pub full_strain: f32,
    /// Size of a node as a fraction of the length of the sheet's springs.
    pub mass_size: f32,
}

impl Default for SheetDebug {
    fn default() -> Self {
        Self { springs: true, masses: true, full_strain: 0.02, mass_size: 0.12 }
    }
}

/// Gizmo group of the debug drawing; line width and depth bias are set in `GizmoConfigStore`.
#[derive(Default, Reflect, GizmoConfigGroup)]
pub struct SheetGizmos;

/// Plugin that draws springs and nodes by [`SheetDebug`]. Not part of
/// [`SheetworkPlugins`](crate::SheetworkPlugins).
#[derive(Clone, Copy, Debug, Default)]
pub struct SheetworkDebugPlugin;

impl Plugin for SheetworkDebugPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<SheetDebug>().register_type::<SheetDebug>();
        let mut config = GizmoConfig { depth_bias: -0.02, ..default() };
        config.line.width = 1.5;
        app.insert_gizmo_config(SheetGizmos, config);
        app.add_systems(PostUpdate, draw.after(SheetworkDisplay).before(TransformSystems::Propagate));
    }
}

fn draw(
    mut gizmos: Gizmos<SheetGizmos>,
    settings: Res<SheetDebug>,
    world: Res<SheetWorld>,
    sheets: Query<&SheetMotion>,
) {
    if !settings.springs && !settings.masses {
        return;
    }
    let time = world.shown_time();
    for motion in &sheets {
        let Some(sheet) = motion.sheet(&world) else { continue };
        let at = |i: usize| motion.at(i, time);
        if settings.springs {
            draw_springs(&mut gizmos, sheet, at, settings.full_strain.max(1e-9));
        }
        if settings.masses {
            draw_masses(&mut gizmos, sheet, at, settings.mass_size);
        }
    }
}

fn draw_springs(
    gizmos: &mut Gizmos<SheetGizmos>,
    sheet: &SheetInWorld,
    at: impl Fn(usize) -> Option<Vec3>,
    full_strain: f32,
) {
    let springs = sheet.springs();
    if springs.is_empty() {
        // A shell has no springs: its mesh edges are drawn as unstrained.
        for [a, b] in sheet.edges() {
            let (Some(a), Some(b)) = (at(a as usize), at(b as usize)) else { continue };
            gizmos.line(a, b, strain_colour(0.0));
        }
    }
    for i in 0..springs.len() {
        let (Some(a), Some(b)) = (at(springs.a[i] as usize), at(springs.b[i] as usize)) else { continue };
        let rest = springs.rest[i] as f32;
        let strain = if rest > 0.0 { a.distance(b) / rest - 1.0 } else { 0.0 };
        gizmos.line(a, b, strain_colour(strain / full_strain));
    }
}

/// Blue at -1, white at 0, yellow at 1: each differs from the default colour of a sheet.
fn strain_colour(s: f32) -> Color {
    let s = s.clamp(-1.0, 1.0);
    let faded = 1.0 - s.abs();
    if s < 0.0 {
        Color::linear_rgb(0.9 * faded, 0.9 * faded, 0.95)
    } else {
        Color::linear_rgb(0.95, 0.7 + 0.2 * faded, 0.9 * faded)
    }
}

fn draw_masses(gizmos: &mut Gizmos<SheetGizmos>, sheet: &SheetInWorld, at: impl Fn(usize) -> Option<Vec3>, size: f32) {
    let size = sheet.spacing().map_or(0.01, |(shortest, _)| shortest as f32 * size);
    for i in 0..sheet.node_count() {
        let Some(p) = at(i) else { continue };
        let touching = sheet.touching().get(i).copied().unwrap_or(false);
        let colour = if touching { Color::linear_rgb(0.05, 0.9, 0.2) } else { Color::linear_rgb(0.03, 0.03, 0.05) };
        gizmos.cross(Isometry3d::from_translation(p), size, colour);
    }
}
