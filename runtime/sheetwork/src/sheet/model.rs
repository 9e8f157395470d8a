//! Model of a sheet: mesh, node masses, layers and rest shape. Only an edit of the structure
//! changes it: another grid, a cut, a clamp. Lengths in m, masses in kg.

use std::sync::Arc;

use crate::mesh::outline::TriangleMesh;
use crate::mesh::outline::refine::Refinement;
use crate::mesh::structure::{LatticeLayer, StructureKind};
use crate::scene::ContactSurface;
use crate::sheet::surface::CreaseLines;

/// Properties that a step does not change.
pub struct SheetModel {
    /// Structure it was generated with.
    pub structure: StructureKind,
    /// Numbers of nodes along the length, of layers, and of nodes along the width.
    pub grid: (u32, u32, u32),
    /// Layers, bottom first.
    pub layers: Vec<LatticeLayer>,
    /// Triangles of a sheet with an outline, counter-clockwise seen from the upper side; such a
    /// sheet has one layer without a grid.
    pub triangles: Option<Vec<[u32; 3]>>,
    /// Material coordinates (u, v) of each node, 0 to 1 over the bottom layer.
    pub uv: Vec<(f64, f64)>,
    /// Nodes on the outline of their layer.
    pub border: Vec<bool>,
    /// Layer of each node.
    pub layer_of: Vec<u32>,
    /// Level of each triangle of the base mesh of a sheet with local refinement: how often its
    /// edges are halved, 0 to 3. The levels identify the present mesh.
    pub refinement: Option<Arc<[u8]>>,
    pub(crate) meshes: OutlineMeshes,
    /// Mass of each node, kg.
    pub(crate) mass: Vec<f64>,
    /// Nodes clamped in position and slope.
    pub(crate) clamped: Vec<bool>,
    /// Longer side, m.
    pub(crate) length: f64,
    /// Length and width (m, at rest) to which `uv` refers.
    pub(crate) extent: (f64, f64),
    /// Initial distance of the layers, m; 1 for a single layer.
    pub(crate) gap: f64,
    /// Initial diagonal of the bounding box, m.
    pub(crate) initial_diagonal: f64,
    /// Columns and rows of nodes along creases.
    pub(crate) folds: CreaseLines,
    /// Surface that meets bodies, with an explicit integrator.
    pub(crate) contact_surface: ContactSurface,
    /// Area per node of an adhesive sheet, m²; empty otherwise.
    pub(crate) adhesion_areas: Vec<f64>,
    pub(crate) described_temperature: DescribedTemperature,
}

impl SheetModel {
    /// Position of node `i` from the corner of the flat sheet along length and width, m.
    pub(crate) fn place(&self, i: u32) -> [f64; 2] {
        let (u, v) = self.uv[i as usize];
        [u * self.extent.0, v * self.extent.1]
    }
}

/// Meshes of an outlined sheet.
#[derive(Default)]
pub(crate) struct OutlineMeshes {
    /// Present mesh.
    pub present: Option<Arc<TriangleMesh>>,
    /// Grid of the scene and its mesh, after a change of grid.
    pub described: Option<((u32, u32), Arc<TriangleMesh>)>,
    /// Local refinement of the present mesh; `None` for a sheet that is not refined.
    pub refinement: Option<Box<Refinement>>,
}

/// Temperature of a sheet in its description.
#[derive(Default)]
pub(crate) struct DescribedTemperature {
    /// Initial temperature, °C; that of the surroundings without a value.
    pub initial: Option<f64>,
    /// Whether the two sides may have different temperatures.
    pub has_gradient: bool,
}
