//! Mesh of a sheet, updated from its nodes.
//!
//! One layer is displayed, smoothed by splines ([`DrawingSurface`]). The topology
//! is built once. Positions and normals are then written in place, only for a visible sheet that
//! has moved. Nodes are in world space, the mesh in the space of its entity. Vertex colours exist
//! only where they are requested.

use std::cell::OnceCell;
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
use super::mesh_arrays::{to_local, write_arrays};
use super::sides::{SheetSide, SheetSides, SideChildren, replace_children};
use super::solid::{Face, Solid};
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
        states: (&Vectors, &Vectors, f32),
        bodies: Option<&RigidView>,
        change: impl FnOnce(&mut [[f32; 3]], &mut [[f32; 3]]),
    ) -> bool {
        write_arrays(mesh, |positions, normals| {
            self.evaluate(states, bodies, positions, normals);
            change(positions, normals);
        })
    }

    /// Computes positions and normals in world space, as [`MeshedSurface::write`].
    fn evaluate(
        &self,
        (before, after, s): (&Vectors, &Vectors, f32),
        bodies: Option<&RigidView>,
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
    ) {
        self.surface.update(before, after, s, positions, normals);
        if let Some(bodies) = bodies {
            let (reach, clearance) = self.clearance;
            clear_of_bodies(bodies, &self.triangles, reach, clearance, positions, normals);
        }
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
    /// Revision of the topology of the sheet's motion.
    topology: u64,
    grid: (u32, u32, u32),
    /// Levels of a locally refined mesh.
    refinement: Option<Arc<[u8]>>,
    /// Faces of a sheet with [`SheetSides`].
    solid: Option<Box<Solid>>,
    /// State displayed by the mesh.
    at: Option<DisplayedState>,
}

/// Revision of the motion, time, transform, and steps and scale of the coloured field.
type DisplayedState = (u64, f64, GlobalTransform, Option<(u64, ColourScale)>);

/// Meshes of a sheet: its own, and those of its children.
struct MadeMeshes {
    own: Mesh,
    children: Vec<(SheetSide, Mesh)>,
}

/// Settings that a mesh is made with.
#[derive(Clone, Copy)]
struct MeshSettings<'a> {
    display: &'a SheetDisplay,
    coloured: bool,
    tangents: bool,
    sides: Option<&'a SheetSides>,
}

impl DisplayedSheet {
    /// Meshes and component of a sheet; `None` if it has no surface.
    fn new(sheet: &SheetInWorld, motion: &SheetMotion, settings: MeshSettings) -> Option<(MadeMeshes, Self)> {
        let (display, x) = (settings.display, motion.positions());
        let parts = segments(sheet, display)?;
        let (own, surface) = MeshedSurface::new(sheet, x, (display.layer, parts, display.spline), settings.coloured)?;
        let (smoothing, grid) = ((display.smoothing, display.spline), sheet.model.grid);
        let topology = motion.topology();
        let (has_tangents, refinement) = (settings.tangents, sheet.model.refinement.clone());
        let mut made = MadeMeshes { own, children: Vec::new() };
        let mut shown = Self {
            surface,
            smoothing,
            has_tangents,
            masses: x.len(),
            topology,
            grid,
            refinement,
            solid: None,
            at: None,
        };
        if let Some(sides) = settings.sides {
            shown.add_solid(&mut made, sides, (seam(sheet, display, parts), face_offsets(sheet, display.layer)));
        } else if has_tangents {
            update_tangents(&mut made.own, &shown.surface.triangles);
        }
        Some((made, shown))
    }

    /// Replace the mesh of the displayed surface by those of a closed surface.
    fn add_solid(&mut self, made: &mut MadeMeshes, sides: &SheetSides, (seam, offsets): (usize, (f32, f32))) {
        let (triangles, coloured) = (&self.surface.triangles, self.surface.coloured);
        let uvs = match made.own.attribute(Mesh::ATTRIBUTE_UV_0) {
            Some(VertexAttributeValues::Float32x2(uvs)) => uvs.clone(),
            _ => return,
        };
        let mut solid = Solid::new(uvs.len(), triangles, seam, offsets);
        let is_own = |face: &Face| sides.own().all(|side| side.face() != *face);
        let faces: Vec<Face> = [Face::Upper, Face::Lower, Face::Rim].into_iter().filter(is_own).collect();
        made.own = solid.add_mesh(&faces, triangles, &uvs, coloured);
        for side in sides.own() {
            made.children.push((side, solid.add_mesh(&[side.face()], triangles, &uvs, coloured)));
        }
        let meshes = std::iter::once(&mut made.own).chain(made.children.iter_mut().map(|(_, mesh)| mesh));
        for (part, mesh) in meshes.enumerate().filter(|_| self.has_tangents) {
            solid.add_tangents(part, mesh);
        }
        if offsets.0 == -offsets.1 {
            // The lower face touches bodies where the nodes do.
            self.surface.clearance.1 = offsets.0;
        }
        self.solid = Some(Box::new(solid));
    }

    /// Whether the mesh has the topology and settings of `sheet`, which has `nodes` nodes.
    fn fits(&self, sheet: &SheetInWorld, nodes: usize, settings: MeshSettings) -> bool {
        let display = settings.display;
        self.surface.fits(sheet, display.layer, settings.coloured)
            && self.smoothing == (display.smoothing, display.spline)
            && self.has_tangents == settings.tangents
            && (self.masses, self.grid) == (nodes, sheet.model.grid)
            && self.refinement == sheet.model.refinement
            && self.solid.as_ref().map(|s| s.offsets()) == settings.sides.map(|_| face_offsets(sheet, display.layer))
    }

    /// Whether the mesh was made for the present topology, as far as the motion of a sheet without
    /// colours tells.
    fn is_current(&self, motion: &SheetMotion, tangents: bool, has_sides: bool) -> bool {
        (self.topology, self.has_tangents) == (motion.topology(), tangents)
            && self.solid.is_some() == has_sides
            && !self.surface.is_coloured()
    }

    /// Write all meshes of a sheet with thickness; `meshes_of` are its own and those of its
    /// children. Returns the bounds in the space of its entity, at `there`.
    fn write_solid(
        &mut self,
        meshes: &mut Assets<Mesh>,
        meshes_of: impl Iterator<Item = AssetId<Mesh>>,
        (states, bodies, there): ((&Vectors, &Vectors, f32), Option<&RigidView>, &GlobalTransform),
        coloured: Option<(&ColourScale, &SheetInWorld)>,
    ) -> Option<Aabb> {
        let solid = self.solid.as_mut()?;
        let (positions, normals) = solid.surface_arrays();
        self.surface.evaluate(states, bodies, positions, normals);
        solid.join_seam();
        if let Some((scale, sheet)) = coloured {
            let MeshedSurface { surface, values, .. } = &mut self.surface;
            for (upper, colours) in [true, false].into_iter().zip(solid.colours()) {
                scale.paint((sheet, upper), surface, values, colours);
            }
        }
        let mut bounds: Option<(Vec3, Vec3)> = None;
        for (part, id) in meshes_of.enumerate() {
            let Some(mut mesh) = meshes.get_mut(id) else { continue };
            let Some((low, high)) = solid.write(part, &mut mesh, there) else { continue };
            bounds = Some(bounds.map_or((low, high), |b| (b.0.min(low), b.1.max(high))));
            if coloured.is_some() {
                solid.write_colours(part, &mut mesh);
            }
        }
        bounds.filter(|(low, _)| low.is_finite()).map(|(low, high)| Aabb::from_min_max(low, high))
    }
}

/// Distances of the upper and the lower face of `sheet` from its displayed layer, m. A single layer
/// lies in the middle, a layer of several at one of the faces.
fn face_offsets(sheet: &SheetInWorld, layer: SheetLayer) -> (f32, f32) {
    let thickness = sheet.material().thickness as f32;
    match layer {
        _ if sheet.model.layers.len() <= 1 => (0.5 * thickness, -0.5 * thickness),
        SheetLayer::Top => (0.0, -thickness),
        SheetLayer::Bottom => (thickness, 0.0),
    }
}

/// Number of vertices at the end of a displayed tube that coincide with the first ones.
fn seam(sheet: &SheetInWorld, display: &SheetDisplay, parts: u32) -> usize {
    let layer = display.layer.index(sheet).and_then(|index| sheet.model.layers.get(index));
    let smoothed = parts > 1 && sheet.model.triangles.is_none();
    layer.filter(|layer| smoothed && layer.tubular).map_or(0, |layer| ((layer.nx - 1) * parts + 1) as usize)
}

/// Insert mesh and material where they are missing, and a new mesh after a change of topology.
pub(super) fn insert_meshes(
    mut commands: Commands,
    world: Res<SheetWorld>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut defaults: ResMut<Materials>,
    mut sheets: Query<(
        Entity,
        (&SheetMotion, Ref<SheetDisplay>, Option<&mut DisplayedSheet>),
        (Option<&Mesh3d>, Option<&MeshMaterial3d<StandardMaterial>>),
        (Option<Ref<SheetSides>>, Option<&SideChildren>),
    )>,
    side_meshes: Query<(), (With<SheetSide>, With<Mesh3d>)>,
) {
    for (entity, (motion, display, mut drawn), (mesh, material), (sides, children)) in &mut sheets {
        let tangents = display.tangents || has_normal_map(material, sides.as_deref(), &materials);
        let is_changed = display.is_changed() || sides.as_ref().is_some_and(Ref::is_changed);
        let is_current = drawn.as_deref().is_some_and(|d| d.is_current(motion, tangents, sides.is_some()));
        // A look at the sheet would wait for its step.
        if world.is_stepping() && display.colour == SheetColour::Plain && !is_changed && is_current {
            continue;
        }
        let Some(sheet) = motion.sheet(&world) else { continue };
        let coloured = display.colour.scale(&world).is_some_and(|scale| scale.applies_to(sheet));
        let settings = MeshSettings { display: &display, coloured, tangents, sides: sides.as_deref() };
        let nodes = motion.positions().len();
        let present = nodes == sheet.node_count() && *motion.refinement() == sheet.model.refinement;
        let complete = match (settings.sides, children) {
            (None, None) => true,
            (Some(sides), Some(children)) => children.fit(sides, |child| side_meshes.contains(child)),
            _ => false,
        };
        if let (Some(changed), Some(children)) = (sides.as_ref().filter(|sides| sides.is_changed()), children) {
            children.insert_materials(&mut commands, changed);
        }
        let fits = drawn.as_deref().is_some_and(|d| d.fits(sheet, nodes, settings));
        if let Some(drawn) = drawn.as_deref_mut().filter(|_| fits && present) {
            drawn.topology = motion.topology();
        }
        if fits && complete || !present {
            // After a change of grid within a tick the old grid is displayed until the next tick.
            continue;
        }
        let Some((made, displayed)) = DisplayedSheet::new(sheet, motion, settings) else { continue };
        // The handle is kept: other entities may use it.
        let kept = mesh.filter(|m| drawn.is_some() && meshes.contains(&m.0));
        let replaced = kept.is_some_and(|m| meshes.insert(&m.0, made.own.clone()).is_ok());
        if !replaced {
            commands.entity(entity).try_insert(Mesh3d(meshes.add(made.own)));
        }
        if settings.sides.is_some() || children.is_some() {
            replace_children(&mut commands, &mut meshes, (entity, children), settings.sides, made.children);
        }
        commands.entity(entity).try_insert((displayed, NoAutoAabb, Aabb::default()));
        if display.default_material && material.is_none_or(|m| defaults.is_of_sheet(&m.0)) {
            let own = defaults.sheet(coloured, settings.sides.is_some(), &mut materials);
            commands.entity(entity).try_insert(MeshMaterial3d(own));
        }
    }
}

/// Whether a material of a sheet has a normal map.
fn has_normal_map(
    material: Option<&MeshMaterial3d<StandardMaterial>>,
    sides: Option<&SheetSides>,
    materials: &Assets<StandardMaterial>,
) -> bool {
    let of_sides = sides.into_iter().flat_map(|sides| sides.back.iter().chain(&sides.rim));
    let mut all = material.map(|material| &material.0).into_iter().chain(of_sides);
    all.any(|handle| materials.get(handle).is_some_and(|material| material.normal_map_texture.is_some()))
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
        (&Mesh3d, &mut DisplayedSheet, &mut Aabb, Option<&SideChildren>),
    )>,
    mut side_bounds: Query<&mut Aabb, (With<SheetSide>, Without<SheetMotion>)>,
) {
    let time = world.shown_time();
    // Looked at only where a surface needs it: that waits for a step on another thread.
    let view = OnceCell::new();
    let bodies = || view.get_or_init(|| world.rigid().map(|rigid| rigid.view())).as_ref();
    for ((motion, state, display, there, visible), (handle, mut drawn, mut bounds, children)) in &mut sheets {
        let scale = if drawn.surface.is_coloured() { display.colour.scale(&world) } else { None };
        // The mesh of a resting sheet depends on time only through its temperature.
        let warmth = scale.map(|scale| (world.steps(), scale));
        let now = (motion.revision(), if motion.is_moving() { time } else { 0.0 }, *there, warmth);
        if !visible.get() || drawn.at == Some(now) || drawn.masses != motion.positions().len() {
            continue;
        }
        let bodies = if display.clear_of_bodies && state.contacts > 0 { bodies() } else { None };
        let coloured = scale.as_ref().and_then(|scale| Some((scale, motion.sheet(&world)?)));
        let drawn = &mut *drawn;
        if drawn.solid.is_some() {
            let of_sides = children.iter().flat_map(|children| &children.0).map(|child| child.mesh.id());
            let all = std::iter::once(handle.0.id()).chain(of_sides);
            let Some(new) = drawn.write_solid(&mut meshes, all, (motion.around(time), bodies, there), coloured) else {
                continue;
            };
            *bounds = new;
            for child in children.iter().flat_map(|children| children.entities()) {
                if let Ok(mut bounds) = side_bounds.get_mut(child) {
                    *bounds = new;
                }
            }
            drawn.at = Some(now);
            continue;
        }
        let Some(mut mesh) = meshes.get_mut(&handle.0) else { continue };
        let written = drawn.surface.write(&mut mesh, motion.around(time), bodies, |positions, normals| {
            to_local(there, positions, normals);
            if let Some(new) = Aabb::enclosing(positions.iter().map(|p| Vec3::from(*p))) {
                *bounds = new;
            }
        });
        if written && drawn.has_tangents {
            update_tangents(&mut mesh, &drawn.surface.triangles);
        }
        if let Some((scale, sheet)) = coloured {
            drawn.surface.paint(&mut mesh, sheet, scale);
        }
        if written {
            drawn.at = Some(now);
        }
    }
}
