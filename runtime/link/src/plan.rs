//! Plan of a world's frames: sizes, offsets and neighbours of nodes.
//!
//! A change of sheets creates a new plan. Opening of cells updates only triangles and edges, and
//! only for readers of these.

use std::sync::Arc;

use crate::layout::{ALIGNMENT, FrameHeader, MAXIMUM_SHEETS, SheetHeader, aligned, name_field};
use sheetwork::World;
use sheetwork::mesh::outline::MeshEdge;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::sheet::Sheet;

/// An edge for the strain of its nodes.
#[derive(Clone, Copy)]
pub struct StrainEdge {
    pub a: u32,
    pub b: u32,
    /// 1/m.
    pub inverse_rest: f64,
}

/// Plan of one sheet.
pub struct SheetPlan {
    name: String,
    masses: usize,
    grid: (u32, u32, u32),
    /// Levels of a locally refined mesh.
    refinement: Option<Arc<[u8]>>,
    structure: StructureKind,
    heated: bool,
    /// Headers with the offsets of a frame of positions, and of a complete one.
    pub headers: [SheetHeader; 2],
    /// Cells along length and width of a sheet with fracture or slits; triangles and 1.
    pub cells: (usize, usize),
    /// Number of triangles without open cells.
    triangle_capacity: usize,
    /// Edges without open cells.
    rest_edges: Vec<StrainEdge>,
    /// Revision of open cells at the last check, and at the last update of triangles and edges.
    observed_revision: u64,
    built_revision: Option<u64>,
    /// Triangles of all layers, counter-clockwise seen from the upper side.
    pub triangles: Vec<[u32; 3]>,
    pub edges: Vec<StrainEdge>,
    /// Inverse number of edges at each node.
    pub share: Vec<f32>,
}

/// Plan of a world's frames.
#[derive(Default)]
pub struct FramePlan {
    pub sheets: Vec<SheetPlan>,
    /// Size of a frame of positions, and of a complete one, bytes.
    pub bytes: [usize; 2],
    /// Number of bodies, and offset of their poses.
    pub bodies: usize,
    pub bodies_at: usize,
}

impl FramePlan {
    /// The plan for `world`, limited to [`MAXIMUM_SHEETS`] sheets.
    pub fn new(world: &World) -> Self {
        let n = world.sheets().len().min(MAXIMUM_SHEETS);
        let bodies_at = aligned(size_of::<FrameHeader>() + n * size_of::<SheetHeader>());
        let bodies = bodies_of(world);
        let start = bodies_at + aligned(bodies * size_of::<[f32; 7]>());
        let mut plan = Self { sheets: Vec::with_capacity(n), bytes: [start; 2], bodies, bodies_at };
        for (index, sheet) in world.sheets().iter().enumerate().take(n) {
            let planned = SheetPlan::new(world, index, sheet, &mut plan.bytes);
            plan.sheets.push(planned);
        }
        plan.update_topology(world);
        plan
    }

    /// Whether the plan matches `world`, irrespective of open cells.
    pub fn fits(&self, world: &World) -> bool {
        let same = |(plan, sheet): (&SheetPlan, &Sheet)| {
            plan.masses == sheet.node_count()
                && plan.heated == sheet.temperatures().is_some()
                && plan.grid == sheet.model.grid
                && plan.refinement == sheet.model.refinement
                && plan.structure == sheet.model.structure
                && plan.name == sheet.name
                && (plan.headers[0].contact_force != 0) == sheet.mean_forces().is_some()
        };
        let n = world.sheets().len().min(MAXIMUM_SHEETS);
        self.sheets.len() == n && self.bodies == bodies_of(world) && self.sheets.iter().zip(world.sheets()).all(same)
    }

    /// Whether cells have opened or closed since the last call.
    pub fn has_changed_cells(&mut self, world: &World) -> bool {
        let mut opened = false;
        for (plan, sheet) in self.sheets.iter_mut().zip(world.sheets()) {
            let before = std::mem::replace(&mut plan.observed_revision, sheet.opening_revision());
            opened |= plan.observed_revision != before;
        }
        opened
    }

    /// Updates triangles and edges to the closed cells.
    pub fn update_topology(&mut self, world: &World) {
        for (plan, sheet) in self.sheets.iter_mut().zip(world.sheets()) {
            if plan.built_revision != Some(sheet.opening_revision()) {
                plan.update_topology(sheet);
            }
        }
    }

    /// Number of triangles and cells of each sheet without open cells.
    pub fn largest(&self) -> impl Iterator<Item = (usize, usize)> + Clone {
        self.sheets.iter().map(|s| (s.triangle_capacity, s.cells.0 * s.cells.1))
    }
}

impl SheetPlan {
    /// Plan of a sheet whose arrays begin at `ends`, without triangles. Advances `ends`.
    fn new(world: &World, index: usize, sheet: &Sheet, ends: &mut [usize; 2]) -> Self {
        let n = sheet.node_count();
        let heated = sheet.temperatures().is_some();
        let mut headers = [header(sheet); 2];
        for (complete, (header, end)) in headers.iter_mut().zip(ends).enumerate() {
            let mut take = |bytes: usize, there: bool| {
                let at = *end;
                *end += if there { aligned(bytes) } else { 0 };
                if there { at as u64 } else { 0 }
            };
            header.positions = take(12 * n, true);
            header.contact = take(n, true);
            header.temperature = take(4 * n, heated);
            header.contact_force = take(12 * n, sheet.mean_forces().is_some());
            header.pin_force = take(12 * n, sheet.mean_forces().is_some());
            header.normals = take(12 * n, complete == 1);
            header.strain = take(4 * n, complete == 1);
        }
        Self {
            name: sheet.name.clone(),
            masses: n,
            grid: sheet.model.grid,
            refinement: sheet.model.refinement.clone(),
            structure: sheet.model.structure,
            heated,
            headers,
            cells: sheet.cells().counts(),
            triangle_capacity: match &sheet.model.triangles {
                Some(triangles) => triangles.len(),
                None => sheet.model.layers.iter().map(|l| l.triangles().len()).sum(),
            },
            rest_edges: edges_of(world, index, sheet),
            observed_revision: sheet.opening_revision(),
            built_revision: None,
            triangles: Vec::new(),
            edges: Vec::new(),
            share: Vec::new(),
        }
    }

    fn update_topology(&mut self, sheet: &Sheet) {
        self.built_revision = Some(sheet.opening_revision());
        self.triangles = sheet.cells().triangles();
        self.edges.clone_from(&self.rest_edges);
        self.edges.retain(|e| !sheet.cells().is_side_cut(e.a, e.b));
        let mut count = vec![0.0_f32; self.masses];
        for edge in &self.edges {
            count[edge.a as usize] += 1.0;
            count[edge.b as usize] += 1.0;
        }
        self.share = count.into_iter().map(|c| if c > 0.0 { 1.0 / c } else { 0.0 }).collect();
    }
}

fn bodies_of(world: &World) -> usize {
    world.rigid().map_or(0, |r| r.bodies().len())
}

fn header(sheet: &Sheet) -> SheetHeader {
    SheetHeader {
        name: name_field(&sheet.name),
        structure: name_field(sheet.model.structure.name()),
        grid: [sheet.model.grid.0, sheet.model.grid.1, sheet.model.grid.2],
        masses: sheet.node_count() as u32,
        status: 0,
        contacts: 0,
        energy: [f64::NAN; 4],
        positions: 0,
        normals: 0,
        strain: 0,
        temperature: 0,
        contact: 0,
        contact_force: 0,
        pin_force: 0,
    }
}

/// Edges of a sheet without open cells, with their rest lengths: springs between nodes of one
/// layer, or the sides of its triangles in the rest shape.
fn edges_of(world: &World, index: usize, sheet: &Sheet) -> Vec<StrainEdge> {
    let inverse = |rest: f64| if rest > 0.0 { 1.0 / rest } else { 0.0 };
    let springs = sheet.springs();
    if !springs.is_empty() {
        let one_layer =
            |i: &usize| sheet.model.layer_of[springs.a[*i] as usize] == sheet.model.layer_of[springs.b[*i] as usize];
        let edge = |i: usize| StrainEdge { a: springs.a[i], b: springs.b[i], inverse_rest: inverse(springs.rest[i]) };
        return (0..springs.len()).filter(one_layer).map(edge).collect();
    }
    if let Some(mesh) = sheet.mesh().filter(|_| sheet.model.refinement.is_some()) {
        let edge =
            |e: &MeshEdge| StrainEdge { a: e.nodes[0], b: e.nodes[1], inverse_rest: inverse(mesh.direction(e).0) };
        return mesh.edges.iter().map(edge).collect();
    }
    let Ok(built) = Sheet::build(world.scene(), index) else { return Vec::new() };
    if built.node_count() != sheet.node_count() {
        return Vec::new();
    }
    let rest = |[a, b]: [u32; 2]| built.state.x.get(a as usize).distance(built.state.x.get(b as usize));
    built.edges().into_iter().map(|e| StrainEdge { a: e[0], b: e[1], inverse_rest: inverse(rest(e)) }).collect()
}

/// Minimum size of samples (bytes), so that small growth of a small scene needs no reallocation.
pub const MINIMUM_SAMPLE_BYTES: usize = 64 * ALIGNMENT;
