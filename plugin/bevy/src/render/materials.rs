//! The materials of entities that bring none.

use bevy::prelude::*;

/// The materials that are given to what has none of its own; made when first needed.
#[derive(Resource, Default)]
pub(super) struct Materials {
    sheet: Option<Handle<StandardMaterial>>,
    /// The same in white, for sheets that are coloured vertex by vertex.
    coloured: Option<Handle<StandardMaterial>>,
    body: Option<Handle<StandardMaterial>>,
    heater: Option<Handle<StandardMaterial>>,
}

impl Materials {
    /// A saturated plastic, seen from both sides.
    pub fn sheet(&mut self, coloured: bool, assets: &mut Assets<StandardMaterial>) -> Handle<StandardMaterial> {
        let make = || StandardMaterial {
            base_color: if coloured { Color::WHITE } else { Color::srgb(0.86, 0.13, 0.03) },
            perceptual_roughness: 0.38,
            reflectance: 0.5,
            double_sided: true,
            cull_mode: None,
            // A sheet that lies on a body is in its surface, and drawn before it: by some 0.1 % of its distance.
            depth_bias: 10_000.0,
            ..default()
        };
        let kept = if coloured { &mut self.coloured } else { &mut self.sheet };
        kept.get_or_insert_with(|| assets.add(make())).clone()
    }

    /// Whether a material is one that [`Materials::sheet`] gave.
    pub fn is_of_sheet(&self, material: &Handle<StandardMaterial>) -> bool {
        [&self.sheet, &self.coloured].into_iter().flatten().any(|m| m == material)
    }

    /// A dark metal.
    pub fn heater(&mut self, assets: &mut Assets<StandardMaterial>) -> Handle<StandardMaterial> {
        let make = || StandardMaterial {
            base_color: Color::srgb(0.42, 0.43, 0.45),
            perceptual_roughness: 0.7,
            reflectance: 0.35,
            ..default()
        };
        self.heater.get_or_insert_with(|| assets.add(make())).clone()
    }

    /// A cool light grey.
    pub fn body(&mut self, assets: &mut Assets<StandardMaterial>) -> Handle<StandardMaterial> {
        let make = || StandardMaterial {
            base_color: Color::srgb(0.60, 0.68, 0.78),
            perceptual_roughness: 0.62,
            reflectance: 0.35,
            ..default()
        };
        self.body.get_or_insert_with(|| assets.add(make())).clone()
    }
}
