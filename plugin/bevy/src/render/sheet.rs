//! Mesh of a sheet, updated from its nodes.
//!
//! One layer is displayed, smoothed by splines ([`DrawingSurface`]). The topology
//! is built once. Positions and normals are then written in place, only for a visible sheet that
//! has moved. Nodes are in world space, the mesh in the space of its entity. Vertex colours exist
//! only where they are requested.

use std::sync::Arc;

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy::reflect::reflect_remote;
use sheetwork::QueryLayer;
use sheetwork::math::Vectors;
use sheetwork::mesh::structure::LatticeLayer;
use sheetwork::rigid::RigidView;
use sheetwork::sheet::Sheet as SheetInWorld;
use sheetwork::sheet::surface::{DrawingSurface, SurfaceSmoothing};

use super::clear::clear_of_bodies;
use super::colour::{ColourScale, SheetColour};
use super::materials::Materials;
use super::tangents::update_tangents;
use super::triangle_mesh::triangle_mesh;
use crate::core::{SheetMotion, SheetState, SheetWorld};

/// Number of vertices above which smoothing is reduced: all vertices are computed and uploaded in
/// every frame.
const MAX_VERTICES: f64 = 10_000.0;

/// Displayed layer of a sheet.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Clone, Debug, Default, PartialEq)]
pub enum SheetLayer {
    /// Upper layer, one thickness above the contact surface.
    #[default]
    Top,
    /// Lower layer, which touches the bodies below.
    Bottom,
}

/// Display settings of a sheet.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
pub struct SheetDisplay {
    /// Displayed layer.
    pub layer: SheetLayer,
    /// Spline segments per cell, 1 to 16; 1 displays flat triangles. Reduced for sheets that would
    /// exceed about 10 000 vertices.
    pub smoothing: u32,
    /// Kind of the splines: through the nodes, or with the nodes as control points.
    #[reflect(remote = SurfaceSmoothingReflect)]
    pub spline: SurfaceSmoothing,
    /// Whether a sheet without `MeshMaterial3d<StandardMaterial>` gets the default material. Unset
    /// it for a material of another type.
    pub default_material: bool,
    /// Whether the displayed surface is moved out of the world's own bodies, which it can intersect
    /// between two nodes. Costs about 1 µs per vertex in each frame with contact and motion.
    pub clear_of_bodies: bool,
    /// Whether the mesh has tangents, for materials with a normal map. A `StandardMaterial` with
    /// `normal_map_texture` gets them in any case. They are computed in each frame with motion.
    pub tangents: bool,
    /// Field displayed by colours. `Plain` costs nothing; other fields cost some tens of
    /// nanoseconds per vertex in a frame after a step.
    pub colour: SheetColour,
}

#[reflect_remote(SurfaceSmoothing)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SurfaceSmoothingReflect {
    Interpolating,
    BSpline,
    Bezier,
}

impl Default for SheetDisplay {
    fn default() -> Self {
        let colour = SheetColour::Plain;
        let spline = SurfaceSmoothing::Interpolating;
        Self {
            layer: SheetLayer::Top,
            smoothing: 4,
            spline,
            default_material: true,
            clear_of_bodies: true,
            tangents: false,
            colour,
        }
    }
}

impl From<SheetLayer> for QueryLayer {
    fn from(layer: SheetLayer) -> Self {
        match layer {
            SheetLayer::Top => Self::Upper,
            SheetLayer::Bottom => Self::Lower,
        }
    }
}

impl SheetLayer {
    /// Number of the layer in `sheet`; `None` for a sheet without layers.
    pub fn index(self, sheet: &SheetInWorld) -> Option<usize> {
        let last = sheet.model.layers.len().checked_sub(1)?;
        Some(if self == Self::Top { last } else { 0 })
    }
}

/// Surface of a sheet that a mesh displays, with the settings that the mesh was made with.
pub struct MeshedSurface {
    surface: DrawingSurface,
    triangles: Vec<[u32; 3]>,
    layer: SheetLayer,
    /// Revision of the open cells.
    opening: u64,
    /// Largest penetration of the surface into a body, and its distance from bodies, m.
    clearance: (f32, f32),
    coloured: bool,
    values: Vec<f32>,
}

impl MeshedSurface {
    /// Mesh of a layer of `sheet` with its nodes at `x`, in `parts` segments per cell of a
    /// `spline`, and its surface; `coloured` meshes have vertex colours. `None` for a sheet without
    /// this layer.
    pub fn new(
        sheet: &SheetInWorld,
        x: &Vectors,
        (layer, parts, spline): (SheetLayer, u32, SurfaceSmoothing),
        coloured: bool,
    ) -> Option<(Mesh, Self)> {
        let surface = DrawingSurface::of_sheet(sheet, layer.index(sheet)?, parts, spline)?;
        let made = surface.mesh(x);
        let indices = made.indices.iter().flatten().copied().collect();
        let mut mesh = triangle_mesh(made.positions, made.normals, made.uvs, indices);
        if coloured {
            mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, vec![[1.0_f32; 4]; surface.len()]);
        }
        let (opening, clearance) = (sheet.opening_revision(), display_clearance(sheet, parts));
        let (triangles, values) = (made.indices, Vec::new());
        Some((mesh, Self { surface, triangles, layer, opening, clearance, coloured, values }))
    }

    /// Whether the mesh has vertex colours.
    pub fn is_coloured(&self) -> bool {
        self.coloured
    }

    /// Whether the mesh was made with these settings, and for the present open cells of `sheet`.
    pub fn fits(&self, sheet: &SheetInWorld, layer: SheetLayer, coloured: bool) -> bool {
        (self.layer, self.coloured, self.opening) == (layer, coloured, sheet.opening_revision())
    }

    /// Writes the shape at the fraction `s` of the way between two states of the nodes into the
    /// mesh, outside of `bodies`, and lets `change` the positions and normals. Returns false for a
    /// mesh without positions.
    pub fn write(
        &self,
        mesh: &mut Mesh,
        (before, after, s): (&Vectors, &Vectors, f32),
        bodies: Option<&RigidView>,
        change: impl FnOnce(&mut [[f32; 3]], &mut [[f32; 3]]),
    ) -> bool {
        let Some((mut positions, mut normals)) = take_arrays(mesh) else { return false };
        self.surface.update(before, after, s, &mut positions, &mut normals);
        if let Some(bodies) = bodies {
            let (reach, clearance) = self.clearance;
            clear_of_bodies(bodies, &self.triangles, reach, clearance, &mut positions, &mut normals);
        }
        change(&mut positions, &mut normals);
        put_arrays(mesh, positions, normals);
        true
    }

    /// Colours the vertices of the mesh, if it has colours, by a field of `sheet`.
    pub fn paint(&mut self, mesh: &mut Mesh, sheet: &SheetInWorld, scale: &ColourScale) {
        if let Ok(VertexAttributeValues::Float32x4(colours)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_COLOR) {
            scale.paint((sheet, self.layer == SheetLayer::Top), &self.surface, &mut self.values, colours);
        }
    }
}

/// Surface and settings of an entity's mesh, and the state that it displays.
#[derive(Component)]
pub(super) struct DisplayedSheet {
    surface: MeshedSurface,
    smoothing: (u32, SurfaceSmoothing),
    has_tangents: bool,
    masses: usize,
    grid: (u32, u32, u32),
    /// Levels of a locally refined mesh.
    refinement: Option<Arc<[u8]>>,
    /// State displayed by the mesh.
    at: Option<DisplayedState>,
}

/// Revision of the motion, time, transform, and steps and scale of the coloured field.
type DisplayedState = (u64, f64, GlobalTransform, Option<(u64, ColourScale)>);

impl DisplayedSheet {
    /// Mesh and component of a sheet; `None` if it has no surface.
    fn new(sheet: &SheetInWorld, motion: &SheetMotion, display: &SheetDisplay, coloured: bool) -> Option<(Mesh, Self)> {
        let (x, layer) = (motion.positions(), (display.layer, segments(sheet, display)?, display.spline));
        let (mut mesh, surface) = MeshedSurface::new(sheet, x, layer, coloured)?;
        let has_tangents = display.tangents;
        if has_tangents {
            update_tangents(&mut mesh, &surface.triangles);
        }
        let (smoothing, grid) = ((display.smoothing, display.spline), sheet.model.grid);
        let refinement = sheet.model.refinement.clone();
        Some((mesh, Self { surface, smoothing, has_tangents, masses: x.len(), grid, refinement, at: None }))
    }

    /// Whether the mesh has the topology and settings of `sheet`, which has `nodes` nodes.
    fn fits(&self, sheet: &SheetInWorld, nodes: usize, display: &SheetDisplay, coloured: bool) -> bool {
        self.surface.fits(sheet, display.layer, coloured)
            && self.smoothing == (display.smoothing, display.spline)
            && self.has_tangents == display.tangents
            && (self.masses, self.grid) == (nodes, sheet.model.grid)
            && self.refinement == sheet.model.refinement
    }
}

/// Insert mesh and material where they are missing, and a new mesh after a change of topology.
pub(super) fn insert_meshes(
    mut commands: Commands,
    world: Res<SheetWorld>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut defaults: ResMut<Materials>,
    sheets: Query<(
        Entity,
        &SheetMotion,
        &SheetDisplay,
        Option<&DisplayedSheet>,
        Option<&Mesh3d>,
        Option<&MeshMaterial3d<StandardMaterial>>,
    )>,
) {
    for (entity, motion, display, drawn, mesh, material) in &sheets {
        let Some(sheet) = motion.sheet(&world) else { continue };
        let coloured = display.colour.scale(&world).is_some_and(|scale| scale.applies_to(sheet));
        let bumpy = material.and_then(|m| materials.get(&m.0)).is_some_and(|m| m.normal_map_texture.is_some());
        let display = &SheetDisplay { tangents: display.tangents || bumpy, ..*display };
        let nodes = motion.positions().len();
        let present = nodes == sheet.node_count() && *motion.refinement() == sheet.model.refinement;
        if drawn.is_some_and(|d| d.fits(sheet, nodes, display, coloured)) || !present {
            // After a change of grid within a tick the old grid is displayed until the next tick.
            continue;
        }
        let Some((made, displayed)) = DisplayedSheet::new(sheet, motion, display, coloured) else { continue };
        // The handle is kept: other entities may use it.
        let kept = mesh.filter(|m| drawn.is_some() && meshes.contains(&m.0));
        let replaced = kept.is_some_and(|m| meshes.insert(&m.0, made.clone()).is_ok());
        if !replaced {
            commands.entity(entity).try_insert(Mesh3d(meshes.add(made)));
        }
        commands.entity(entity).try_insert((displayed, NoAutoAabb, Aabb::default()));
        if display.default_material && material.is_none_or(|m| defaults.is_of_sheet(&m.0)) {
            commands.entity(entity).try_insert(MeshMaterial3d(defaults.sheet(coloured, &mut materials)));
        }
    }
}

/// Spline segments per cell of the displayed layer of a sheet; `None` without this layer.
fn segments(sheet: &SheetInWorld, display: &SheetDisplay) -> Option<u32> {
    let index = display.layer.index(sheet)?;
    // A sheet with open cells is displayed by its own triangles.
    Some(match &sheet.model.triangles {
        _ if sheet.open_count() > 0 => 1,
        Some(triangles) => subdivisions(triangles.len(), display.smoothing),
        None => segments_per_cell(sheet.model.layers.get(index)?, display.smoothing),
    })
}

/// Spline segments per cell of a layer: `wanted`, or as many as the vertex limit permits.
fn segments_per_cell(layer: &LatticeLayer, wanted: u32) -> u32 {
    let cells = f64::from(layer.nx.saturating_sub(1)) * f64::from(layer.nz.saturating_sub(1));
    let most = (MAX_VERTICES / cells.max(1.0)).sqrt() as u32;
    wanted.clamp(1, 16).min(most.max(1))
}

/// Subdivisions of the sides of `triangles` triangles, a power of two up to `wanted` that the
/// vertex limit permits.
fn subdivisions(triangles: usize, wanted: u32) -> u32 {
    let light = |parts: &u32| triangles as f64 * f64::from(parts * parts) <= 2.0 * MAX_VERTICES;
    [4, 2].into_iter().filter(|parts| *parts <= wanted).find(light).unwrap_or(1)
}

/// Largest penetration of the displayed surface of `sheet` into a body, and its distance above
/// bodies, m, for [`clear_of_bodies`]; `smoothing` is the number of spline segments per cell.
pub fn display_clearance(sheet: &SheetInWorld, smoothing: u32) -> (f32, f32) {
    let spring = sheet.spacing().map_or(0.0, |(_, longest)| longest) as f32;
    // Four cells: an upper bound between two nodes, even for a strongly stretched sheet.
    let reach = 4.0 * spring;
    // Enough to clear a square edge, at most the thickness of the sheet.
    let clearance = (0.7 * spring / smoothing.clamp(1, 16) as f32).min(sheet.material().thickness as f32);
    (reach, clearance)
}

/// Write the present shape into the mesh of every visible sheet that has moved.
pub(super) fn update(
    world: Res<SheetWorld>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut sheets: Query<(
        (&SheetMotion, &SheetState, &SheetDisplay, &GlobalTransform, &InheritedVisibility),
        (&Mesh3d, &mut DisplayedSheet, &mut Aabb),
    )>,
) {
    let time = world.shown_time();
    let bodies = world.rigid().map(|rigid| rigid.view());
    for ((motion, state, display, there, visible), (handle, mut drawn, mut bounds)) in &mut sheets {
        let scale = if drawn.surface.is_coloured() { display.colour.scale(&world) } else { None };
        // The mesh of a resting sheet depends on time only through its temperature.
        let warmth = scale.map(|scale| (world.steps(), scale));
        let now = (motion.revision(), if motion.is_moving() { time } else { 0.0 }, *there, warmth);
        if !visible.get() || drawn.at == Some(now) || drawn.masses != motion.positions().len() {
            continue;
        }
        let Some(mut mesh) = meshes.get_mut(&handle.0) else { continue };
        let bodies = bodies.as_ref().filter(|_| display.clear_of_bodies && state.contacts > 0);
        let written = drawn.surface.write(&mut mesh, motion.around(time), bodies, |positions, normals| {
            to_local(there, positions, normals);
            if let Some(new) = Aabb::enclosing(positions.iter().map(|p| Vec3::from(*p))) {
                *bounds = new;
            }
        });
        if written && drawn.has_tangents {
            update_tangents(&mut mesh, &drawn.surface.triangles);
        }
        if let (Some(scale), Some(sheet)) = (scale, motion.sheet(&world)) {
            drawn.surface.paint(&mut mesh, sheet, &scale);
        }
        if written {
            drawn.at = Some(now);
        }
    }
}

/// Transform from world space into the space of the entity.
fn to_local(there: &GlobalTransform, positions: &mut [[f32; 3]], normals: &mut [[f32; 3]]) {
    let affine = there.affine();
    if affine == bevy::math::Affine3A::IDENTITY || affine.matrix3.determinant() == 0.0 {
        return;
    }
    let inverse = affine.inverse();
    // Normals transform by the inverse transpose.
    let turn = affine.matrix3.transpose();
    for p in positions {
        *p = inverse.transform_point3(Vec3::from(*p)).to_array();
    }
    for n in normals {
        *n = (turn * Vec3::from(*n)).normalize_or(Vec3::Y).to_array();
    }
}

type Array = Vec<[f32; 3]>;

/// Take positions and normals out of a mesh, to write to both at once without a copy.
fn take_arrays(mesh: &mut Mesh) -> Option<(Array, Array)> {
    let mut take = |attribute| match mesh.try_attribute_mut(attribute) {
        Ok(VertexAttributeValues::Float32x3(values)) => Some(std::mem::take(values)),
        _ => None,
    };
    let positions = take(Mesh::ATTRIBUTE_POSITION)?;
    Some((positions, take(Mesh::ATTRIBUTE_NORMAL).unwrap_or_default()))
}

/// Return positions and normals to the mesh.
fn put_arrays(mesh: &mut Mesh, positions: Array, normals: Array) {
    for (attribute, array) in [(Mesh::ATTRIBUTE_POSITION, positions), (Mesh::ATTRIBUTE_NORMAL, normals)] {
        if let Ok(VertexAttributeValues::Float32x3(values)) = mesh.try_attribute_mut(attribute) {
            *values = array;
        }
    }
}
