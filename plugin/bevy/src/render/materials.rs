//! Default materials of entities without one.

use bevy::prelude::*;

/// Default materials, created when first needed.
#[derive(Resource, Default)]
pub(super) struct Materials {
    /// Materials of sheets without and with thickness, each as the plain and the white variant for
    /// vertex colours.
    sheets: [[Option<Handle<StandardMaterial>>; 2]; 2],
    body: Option<Handle<StandardMaterial>>,
    heater: Option<Handle<StandardMaterial>>,
}

impl Materials {
    /// Saturated plastic, visible from both sides; `solid` for a sheet with thickness.
    pub fn sheet(
        &mut self,
        coloured: bool,
        solid: bool,
        assets: &mut Assets<StandardMaterial>,
    ) -> Handle<StandardMaterial> {
        let make = || {
            let plastic = StandardMaterial {
                base_color: if coloured { Color::WHITE } else { Color::srgb(0.86, 0.13, 0.03) },
                perceptual_roughness: 0.38,
                reflectance: 0.5,
                ..default()
            };
            // Draws a sheet in front of the body on which it rests, by about 0.1 % of the distance.
            let open = |m| StandardMaterial { double_sided: true, cull_mode: None, depth_bias: 10_000.0, ..m };
            if solid { plastic } else { open(plastic) }
        };
        let kept = &mut self.sheets[usize::from(solid)][usize::from(coloured)];
        kept.get_or_insert_with(|| assets.add(make())).clone()
    }

    /// Whether a material came from [`Materials::sheet`].
    pub fn is_of_sheet(&self, material: &Handle<StandardMaterial>) -> bool {
        self.sheets.iter().flatten().flatten().any(|m| m == material)
    }

    /// Dark metal.
    pub fn heater(&mut self, assets: &mut Assets<StandardMaterial>) -> Handle<StandardMaterial> {
        self.heater.get_or_insert_with(|| assets.add(rough(Color::srgb(0.42, 0.43, 0.45), 0.7))).clone()
    }

    /// Cool light grey.
    pub fn body(&mut self, assets: &mut Assets<StandardMaterial>) -> Handle<StandardMaterial> {
        self.body.get_or_insert_with(|| assets.add(rough(Color::srgb(0.60, 0.68, 0.78), 0.62))).clone()
    }
}

fn rough(base_color: Color, perceptual_roughness: f32) -> StandardMaterial {
    StandardMaterial { base_color, perceptual_roughness, reflectance: 0.35, ..default() }
}
