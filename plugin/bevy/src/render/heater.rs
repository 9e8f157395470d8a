//! Meshes of heaters: their cold faces, and their hot faces, which glow.
//!
//! The brightness of a hot face grows with its temperature, on one scale from 20 to 800 °C. A real
//! face does not glow visibly at 250 °C.

use bevy::light::NotShadowCaster;
use bevy::prelude::*;
use sheetwork::scene::Polyhedron;
use sheetwork::scene::heater_file::Heater;

use super::colour::heat_colour;
use super::materials::Materials;
use super::polyhedra_mesh;
use crate::core::{SheetHeater, SheetWorld};

/// Temperatures of the darkest and the brightest colour, °C.
const GLOW_RANGE: (f64, f64) = (20.0, 800.0);

/// Colour of a face of this temperature, °C.
pub fn glow(celsius: f64) -> LinearRgba {
    // The square root makes 200 °C visible.
    let s = ((celsius - GLOW_RANGE.0) / (GLOW_RANGE.1 - GLOW_RANGE.0)).clamp(0.0, 1.0).sqrt();
    heat_colour(s as f32)
}

/// Mesh of the cold faces of heaters, and meshes of their hot faces with temperatures, °C; in their
/// own axes, m. Empty meshes are omitted.
pub fn heater_meshes(heaters: &[Heater]) -> (Option<Mesh>, Vec<(Mesh, f64)>) {
    let part = |heater: &Heater, hot: Option<f64>| {
        let of = heater.faces.iter().zip(&heater.polyhedron.faces).filter(|(face, _)| face.temperature == hot);
        let faces = of.map(|(_, corners)| corners.clone()).collect();
        Polyhedron { vertices: heater.polyhedron.vertices.clone(), faces }
    };
    let cold: Vec<_> = heaters.iter().map(|h| part(h, None)).filter(|p| !p.faces.is_empty()).collect();
    let mut hot = Vec::new();
    for heater in heaters {
        let mut temperatures: Vec<f64> = heater.faces.iter().filter_map(|f| f.temperature).collect();
        temperatures.sort_by(f64::total_cmp);
        temperatures.dedup();
        hot.extend(temperatures.into_iter().map(|t| (polyhedra_mesh(&[part(heater, Some(t))]), t)));
    }
    ((!cold.is_empty()).then(|| polyhedra_mesh(&cold)), hot)
}

/// Entities of the parts of a displayed heater.
#[derive(Component)]
pub(super) struct DisplayedHeater(Vec<Entity>);

/// Insert meshes and materials of heaters, each part as a child entity; rebuild them after a
/// change. They cast no shadow, which would hide the heated sheet.
pub(super) fn insert_meshes(
    mut commands: Commands,
    world: Res<SheetWorld>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut defaults: ResMut<Materials>,
    heaters: Query<(Entity, &SheetHeater, Option<&DisplayedHeater>, Has<Mesh3d>), Changed<SheetHeater>>,
) {
    for (entity, heater, drawn, own) in &heaters {
        for part in drawn.iter().flat_map(|d| &d.0) {
            commands.entity(*part).try_despawn();
        }
        // A mesh on the entity itself belongs to the user. An invalid heater was reported when it
        // was added to the world.
        let Ok(all) = heater.spec.resolve(&world.scene().base) else { continue };
        if own {
            continue;
        }
        let (cold, hot) = heater_meshes(&all);
        let at = Transform::from_translation(heater.spec.placement.position.as_vec3())
            .with_rotation(heater.spec.placement.quaternion().as_quat());
        let metal = defaults.heater(&mut materials);
        let mut parts: Vec<_> = cold.into_iter().map(|mesh| (mesh, metal.clone())).collect();
        for (mesh, celsius) in hot {
            let glowing = || StandardMaterial { base_color: glow(celsius).into(), unlit: true, ..default() };
            let material = if heater.spec.on { materials.add(glowing()) } else { metal.clone() };
            parts.push((mesh, material));
        }
        let spawn = |(mesh, material)| {
            commands
                .spawn((Mesh3d(meshes.add(mesh)), MeshMaterial3d(material), at, NotShadowCaster, ChildOf(entity)))
                .id()
        };
        let parts = parts.into_iter().map(spawn).collect();
        commands.entity(entity).try_insert(DisplayedHeater(parts));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::scene::{HeaterSpec, HotFaceSpec};

    #[test]
    fn cold_and_hot_faces_have_separate_meshes() {
        let hot = |face, temperature| HotFaceSpec { face, temperature, emissivity: 1.0 };
        let spec = HeaterSpec {
            size: Some(bevy::math::DVec3::ONE),
            hot: vec![hot(2, 300.0), hot(3, 200.0), hot(0, 300.0)],
            ..HeaterSpec::default()
        };
        let (cold, hot) = heater_meshes(&spec.resolve(std::path::Path::new("")).expect("valid"));
        let faces = |mesh: &Mesh| mesh.count_vertices() / 6;
        assert_eq!(cold.as_ref().map(faces), Some(3));
        assert_eq!(
            hot.iter().map(|(mesh, celsius)| (faces(mesh), *celsius)).collect::<Vec<_>>(),
            [(1, 200.0), (2, 300.0)]
        );
        let lightness = |celsius| Oklaba::from(glow(celsius)).lightness;
        assert!(lightness(100.0) < lightness(200.0) && lightness(200.0) < lightness(700.0));
    }
}
