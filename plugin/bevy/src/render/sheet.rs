//! The mesh of a sheet, kept where its masses are.
//!
//! One layer is drawn, smoothed by splines through its masses, as [`Surface`] has it. Topology is made once; from then on
//! positions and normals are written into the arrays the mesh already has, and only for a sheet that is seen and has moved.
//! A sheet's masses are in world space, its mesh is in its entity's. Colours are written where they are asked for, and the mesh has
//! none otherwise.

use bevy::asset::RenderAssetUsages;
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use sheetwork::math::Vectors;
use sheetwork::mesh::structure::Layer;
use sheetwork::sheet::Sheet as SheetInWorld;
use sheetwork::sheet::surface::Surface;

use super::colour::{ColourScale, SheetColour};
use super::clear_of_bodies;
use super::materials::Materials;
use crate::core::{SheetMotion, SheetState, SheetWorld};

/// Vertices above which a sheet is drawn less smooth: they are worked out and sent anew in every frame.
const MOST_VERTICES: f64 = 10_000.0;

/// Which layer of a sheet is drawn.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Clone, Debug, Default, PartialEq)]
pub enum SheetLayer {
    /// The upper one: it lies above what the sheet lies on, by the sheet's thickness.
    #[default]
    Top,
    /// The lower one, that meets what the sheet falls on.
    Bottom,
}

/// How a sheet is drawn.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
pub struct SheetDisplay {
    /// The layer that is drawn.
    pub layer: SheetLayer,
    /// Spline pieces from one mass to the next, 1 to 16; 1 draws flat triangles between the masses. Fewer are drawn of a sheet
    /// of so many masses that it would have more than some 10 000 vertices.
    pub smoothing: u32,
    /// Whether the sheet is given a material if it has no `MeshMaterial3d<StandardMaterial>`; not wanted for one that is drawn
    /// with a material of another type.
    pub default_material: bool,
    /// Whether the drawn surface is kept out of the world's own bodies, where it would cut across an edge between two masses.
    /// It costs about a microsecond a vertex in a frame in which the sheet touches something and moves.
    pub clear_of_bodies: bool,
    /// What the surface is coloured by: nothing, its temperature, or its stiffness. `Plain` costs nothing; the others some tens of
    /// nanoseconds a vertex in a frame after a step.
    pub colour: SheetColour,
}

impl Default for SheetDisplay {
    fn default() -> Self {
        let colour = SheetColour::Plain;
        Self { layer: SheetLayer::Top, smoothing: 4, default_material: true, clear_of_bodies: true, colour }
    }
}

/// The surface that an entity's mesh was made for, and what was drawn last.
#[derive(Component)]
pub(super) struct Drawn {
    surface: Surface,
    triangles: Vec<[u32; 3]>,
    layer: SheetLayer,
    smoothing: u32,
    masses: usize,
    grid: (u32, u32, u32),
    /// What was open of it.
    opening: u64,
    /// How deep the drawn surface may be inside a body, m.
    reach: f32,
    /// How far outside of a body it is kept, m.
    skin: f32,
    /// Whether the mesh has colours, and room to work them out.
    coloured: bool,
    values: Vec<f32>,
    /// What the picture in the mesh is of.
    at: Option<Moment>,
}

/// Revision of the motion, time, and transform; steps and scale of what is coloured.
type Moment = (u64, f64, GlobalTransform, Option<(u64, ColourScale)>);

/// Gives a mesh and a material to sheets that have none, and a new mesh to those whose topology is to be another.
pub(super) fn dress(
    mut commands: Commands,
    world: Res<SheetWorld>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut defaults: ResMut<Materials>,
    sheets: Query<(
        Entity,
        &SheetMotion,
        &SheetDisplay,
        Option<&Drawn>,
        Option<&Mesh3d>,
        Option<&MeshMaterial3d<StandardMaterial>>,
    )>,
) {
    for (entity, motion, display, drawn, mesh, material) in &sheets {
        let masses = motion.positions().len();
        let Some(sheet) = world.sheet(motion.name()) else { continue };
        let opening = sheet.opening_revision();
        let coloured = display.colour.scale(&world).is_some_and(|scale| scale.applies_to(sheet));
        let fits = |d: &Drawn| {
            (d.layer, d.smoothing, d.masses, d.grid, d.coloured, d.opening)
                == (display.layer, display.smoothing, masses, sheet.grid, coloured, opening)
        };
        if drawn.is_some_and(fits) || masses != sheet.masses() {
            // One that has gone to another grid since its last tick is drawn as it was.
            continue;
        }
        let Some((surface, parts)) = surface_of(sheet, display) else { continue };
        let (reach, skin) = clearing(sheet, parts);
        let mut made = sheet_mesh(&surface, motion.positions());
        let triangles = triangles_of(&made);
        if coloured {
            made.insert_attribute(Mesh::ATTRIBUTE_COLOR, vec![[1.0_f32; 4]; surface.len()]);
        }
        // The same handle, if there is one: others may hold it.
        let kept = mesh.filter(|m| drawn.is_some() && meshes.contains(&m.0));
        let replaced = kept.is_some_and(|m| meshes.insert(&m.0, made.clone()).is_ok());
        if !replaced {
            commands.entity(entity).try_insert(Mesh3d(meshes.add(made)));
        }
        let (layer, smoothing) = (display.layer, display.smoothing);
        commands.entity(entity).try_insert((
            Drawn {
                surface,
                triangles,
                layer,
                smoothing,
                masses,
                grid: sheet.grid,
                opening,
                reach,
                skin,
                coloured,
                values: Vec::new(),
                at: None,
            },
            NoAutoAabb,
            Aabb::default(),
        ));
        if display.default_material && material.is_none_or(|m| defaults.is_of_sheet(&m.0)) {
            commands.entity(entity).try_insert(MeshMaterial3d(defaults.sheet(coloured, &mut materials)));
        }
    }
}

/// The surface that is drawn of a sheet, and the spline pieces it has from one mass to the next.
fn surface_of(sheet: &SheetInWorld, display: &SheetDisplay) -> Option<(Surface, u32)> {
    let index = match display.layer {
        SheetLayer::Top => sheet.layers.len().checked_sub(1)?,
        SheetLayer::Bottom => 0,
    };
    // A sheet that is not whole is drawn by its own triangles.
    let parts = match &sheet.triangles {
        _ if sheet.open_count() > 0 => 1,
        Some(triangles) => halvings(triangles.len(), display.smoothing),
        None => pieces(sheet.layers.get(index)?, display.smoothing),
    };
    Some((sheet.surface(index, parts)?, parts))
}

/// Spline pieces from one mass of a layer to the next: those wanted, or as many as leave it light enough to draw.
fn pieces(layer: &Layer, wanted: u32) -> u32 {
    let cells = f64::from(layer.nx.saturating_sub(1)) * f64::from(layer.nz.saturating_sub(1));
    let most = (MOST_VERTICES / cells.max(1.0)).sqrt() as u32;
    wanted.clamp(1, 16).min(most.max(1))
}

/// Parts of the sides of so many triangles: those wanted, as far as sides are halved, or as many as leave it light enough to draw.
fn halvings(triangles: usize, wanted: u32) -> u32 {
    let light = |parts: &u32| triangles as f64 * f64::from(parts * parts) <= 2.0 * MOST_VERTICES;
    [4, 2].into_iter().filter(|parts| *parts <= wanted).find(light).unwrap_or(1)
}

/// A mesh of the surface with the masses at `x`, world space, m.
pub fn sheet_mesh(surface: &Surface, x: &Vectors) -> Mesh {
    let made = surface.mesh(x);
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, made.positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, made.normals)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, made.uvs)
        .with_inserted_indices(Indices::U32(made.indices.into_iter().flatten().collect()))
}

/// How deep in a body the drawn surface of `sheet` may be, and how far above bodies it is drawn, m, for
/// [`clear_of_bodies`]; `smoothing` is the number of spline pieces it is drawn with.
pub fn clearing(sheet: &SheetInWorld, smoothing: u32) -> (f32, f32) {
    let spring = sheet.spacing().map_or(0.0, |(_, longest)| longest) as f32;
    // A few cells: between two masses it cannot be deeper, however far the sheet is drawn out.
    let reach = 4.0 * spring;
    // Enough for a triangle to clear a square edge, but not more than the sheet is thick.
    let skin = (0.7 * spring / smoothing.clamp(1, 16) as f32).min(sheet.material().thickness as f32);
    (reach, skin)
}

/// The triangles of a mesh that [`sheet_mesh`] made.
pub fn triangles_of(mesh: &Mesh) -> Vec<[u32; 3]> {
    let Some(Indices::U32(indices)) = mesh.indices() else { return Vec::new() };
    indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()
}

/// Writes the present shape into the mesh of every sheet that is seen and has moved.
pub(super) fn update(
    world: Res<SheetWorld>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut sheets: Query<(
        (&SheetMotion, &SheetState, &SheetDisplay, &GlobalTransform, &InheritedVisibility),
        (&Mesh3d, &mut Drawn, &mut Aabb),
    )>,
) {
    let time = world.shown_time();
    let bodies = world.rigid().map(|rigid| rigid.view());
    for ((motion, state, display, there, visible), (handle, mut drawn, mut bounds)) in &mut sheets {
        let scale = if drawn.coloured { display.colour.scale(&world) } else { None };
        // What stands still looks the same at every time, unless it warms or cools.
        let warmth = scale.map(|scale| (world.steps(), scale));
        let now = (motion.revision(), if motion.is_moving() { time } else { 0.0 }, *there, warmth);
        if !visible.get() || drawn.at == Some(now) || drawn.masses != motion.positions().len() {
            continue;
        }
        let Some(mut mesh) = meshes.get_mut(&handle.0) else { continue };
        let (before, after, s) = motion.around(time);
        let written = update_sheet_mesh(&mut mesh, |positions, normals| {
            drawn.surface.update(before, after, s, positions, normals);
            if let Some(bodies) = bodies.as_ref().filter(|_| display.clear_of_bodies && state.contacts > 0) {
                clear_of_bodies(bodies, &drawn.triangles, drawn.reach, drawn.skin, positions, normals);
            }
            to_local(there, positions, normals);
            if let Some(new) = Aabb::enclosing(positions.iter().map(|p| Vec3::from(*p))) {
                *bounds = new;
            }
        });
        if let (Some(scale), Some(sheet)) = (scale, world.sheet(motion.name())) {
            let Drawn { surface, values, .. } = &mut *drawn;
            let upper = display.layer == SheetLayer::Top;
            update_sheet_colours(&mut mesh, |colours| scale.paint((sheet, upper), surface, values, colours));
        }
        if written {
            drawn.at = Some(now);
        }
    }
}

/// Lets `write` change the positions and normals of a mesh in place; nothing is copied. Whether there were any to change.
pub fn update_sheet_mesh(mesh: &mut Mesh, write: impl FnOnce(&mut [[f32; 3]], &mut [[f32; 3]])) -> bool {
    let Some((mut positions, mut normals)) = take_arrays(mesh) else { return false };
    write(&mut positions, &mut normals);
    put_arrays(mesh, positions, normals);
    true
}

/// Lets `write` change the colours of a mesh in place, if it has any; nothing is copied.
pub fn update_sheet_colours(mesh: &mut Mesh, write: impl FnOnce(&mut Vec<[f32; 4]>)) {
    if let Ok(VertexAttributeValues::Float32x4(colours)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_COLOR) {
        write(colours);
    }
}

/// From world space into the entity's.
fn to_local(there: &GlobalTransform, positions: &mut [[f32; 3]], normals: &mut [[f32; 3]]) {
    let affine = there.affine();
    if affine == bevy::math::Affine3A::IDENTITY || affine.matrix3.determinant() == 0.0 {
        return;
    }
    let inverse = affine.inverse();
    // Normals go by the inverse transpose of what points go by.
    let turn = affine.matrix3.transpose();
    for p in positions {
        *p = inverse.transform_point3(Vec3::from(*p)).to_array();
    }
    for n in normals {
        *n = (turn * Vec3::from(*n)).normalize_or(Vec3::Y).to_array();
    }
}

type Array = Vec<[f32; 3]>;

/// Takes the positions and normals out of a mesh, to be written to together; nothing is copied.
fn take_arrays(mesh: &mut Mesh) -> Option<(Array, Array)> {
    let mut take = |attribute| match mesh.try_attribute_mut(attribute) {
        Ok(VertexAttributeValues::Float32x3(values)) => Some(std::mem::take(values)),
        _ => None,
    };
    let positions = take(Mesh::ATTRIBUTE_POSITION)?;
    Some((positions, take(Mesh::ATTRIBUTE_NORMAL).unwrap_or_default()))
}

/// Puts them back.
fn put_arrays(mesh: &mut Mesh, positions: Array, normals: Array) {
    for (attribute, array) in [(Mesh::ATTRIBUTE_POSITION, positions), (Mesh::ATTRIBUTE_NORMAL, normals)] {
        if let Ok(VertexAttributeValues::Float32x3(values)) = mesh.try_attribute_mut(attribute) {
            *values = array;
        }
    }
}
