//! Fracture of a sheet: cells open when they are stretched or heated beyond the limits of the
//! material.
//!
//! A cell is a rectangle of the grid of the lowest layer, or a triangle of its mesh (outline, or
//! shifted rows). Every closed cell is tested after every step. With a and b the mean derivatives
//! of the position along u and v over the cell (from its nodes, per length at rest), the largest
//! principal stretch λ is the square root of the larger eigenvalue of [a·a, a·b; a·b, b·b], and
//! the strain of the mid-surface is λ/(1 + α (T - 20 °C)) - 1. The temperature T is the mean of the
//! nodes of the cell. In a lattice with several layers, the strain is that of the lowest layer and
//! the temperature is the mean over the nodes of all layers in the cell.
//!
//! A cell hotter than `melts_at` opens. Among the cells strained by more than `tears_at`, each step
//! opens the one with the largest strain of the sheet and, at each end of a crack, the cell with
//! the largest strain of its neighbourhood. The neighbours then take up the load, and the next step
//! tests them. A crack therefore starts in one cell, grows by one cell a step, and its path is
//! independent of other cracks.
//!
//! An open cell has no stiffness (its elastic energy is released and never restored), contact, area
//! for drawing and drag, or heat flow. A node keeps its mass while one of its cells is closed. A
//! detached node, with no closed cell left, is fixed, has no kinetic or elastic energy, keeps the
//! potential energy of its last position, and follows the nearest remaining node.

use glam::DVec3;
use serde::Serialize;

use crate::elements::flexion_limit::FlexionLimit;
use crate::elements::fracture::{CellCorners, OpenCells};
use crate::elements::thickness_limit::ThicknessLimit;
use crate::error::InputError;
use crate::mesh::slits::Slit;
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter};
use crate::sheet::cell_state::{CellState, state_of_rectangle, state_of_triangle, upper_nodes};
use crate::sheet::cells::{SheetCells, closed_cells};
use crate::sheet::{Sheet, attachment, slits, stage};

/// Relative tolerance within which strains are equal.
const EQUAL_STRAIN_TOLERANCE: f64 = 1e-9;

/// First opening of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FractureOpening {
    /// Position of the cell, m.
    pub place_m: [f64; 3],
    /// Largest principal strain of the mid-surface of the cell.
    pub strain: f64,
    /// Temperature of the cell, °C; `None` for a sheet without temperatures.
    pub temperature_c: Option<f64>,
    /// Whether the cell melted; otherwise it tore.
    pub melted: bool,
}

/// Fracture state of a sheet whose cells can open.
pub(crate) struct FractureState {
    open: OpenCells,
    /// Nodes of the upper layers in each triangle; empty for rectangles and for a single layer.
    upper_nodes: Vec<Vec<u32>>,
    /// Whether each node is detached: without a closed cell around it.
    detached: Vec<bool>,
    /// Position of each node when it was detached, m, for its potential energy. Empty while all
    /// cells are closed.
    detached_at: Vec<DVec3>,
    /// Detached nodes without a prescribed motion, each with the node that it follows.
    followers: Vec<(u32, u32)>,
    /// Workspace: strain of each cell over its limit, and the cells that open.
    strain_ratio: Vec<f64>,
    opening_cells: Vec<u32>,
    /// Stiffness per unit of every spring of the intact sheet.
    springs: Vec<f64>,
    /// Number of changes of the open cells.
    revision: u64,
    /// Energy released by opening, J.
    released_energy: f64,
    /// Whether the first opening has been reported.
    is_reported: bool,
    /// Whether cells can open during the run.
    can_grow: bool,
    /// Initially open cells; empty without slits.
    initial_cells: Vec<bool>,
    /// Whether the description of the sheet has tearing or slits; otherwise it was cut.
    is_described: bool,
}

impl FractureState {
    /// Create the state of `sheet` with all cells closed; `runs` allows cells to open during the
    /// run.
    pub fn new(sheet: &Sheet, runs: bool) -> Self {
        let open = closed_cells(sheet);
        Self {
            upper_nodes: upper_nodes(sheet, &open),
            strain_ratio: vec![0.0; open.cells().len()],
            opening_cells: Vec::with_capacity(open.cells().len()),
            open,
            detached: vec![false; sheet.node_count()],
            detached_at: Vec::new(),
            followers: Vec::new(),
            springs: sheet.parameters.springs.per_unit.clone(),
            revision: 0,
            released_energy: 0.0,
            is_reported: false,
            can_grow: runs,
            initial_cells: Vec::new(),
            is_described: true,
        }
    }

    /// State of a running sheet that is cut.
    fn of_cut(sheet: &Sheet) -> Self {
        Self { is_described: false, ..Self::new(sheet, false) }
    }

    /// Whether each cell is open.
    pub fn cells(&self) -> &[bool] {
        self.open.cells()
    }

    /// Cells along length and width; of triangles, their number and 1.
    pub fn size(&self) -> (usize, usize) {
        self.open.size()
    }

    /// Strain and temperature of cell `c`.
    fn state_of(&self, sheet: &Sheet, c: usize) -> CellState {
        match self.open.triangles() {
            None => state_of_rectangle(sheet, self.open.size().0, c),
            Some(cells) => state_of_triangle(sheet, cells, &self.upper_nodes, c),
        }
    }

    /// Serialise the state that does not follow from the open cells.
    pub fn serialise(&self, to: &mut StateWriter) {
        to.flag(self.is_reported);
        to.number(self.released_energy);
        to.states(&self.followers);
        for (i, place) in self.detached_at.iter().enumerate().filter(|(i, _)| self.detached[*i]) {
            to.count(i as u64);
            to.vector(*place);
        }
    }

    /// Deserialise that state; the same cells must already be open.
    pub fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        self.is_reported = from.flag()?;
        self.released_energy = from.number()?;
        let masses = self.detached.len();
        self.followers = from.states(2)?;
        if self.followers.iter().any(|(mass, with)| *mass.max(with) as usize >= masses) {
            return Err(CorruptState);
        }
        for i in 0..self.detached_at.len() {
            if self.detached[i] {
                if from.count()? != i as u64 {
                    return Err(CorruptState);
                }
                self.detached_at[i] = from.vector()?;
            }
        }
        Ok(())
    }
}

impl Sheet {
    /// Whether its cells can open.
    pub fn can_open(&self) -> bool {
        self.state.fracture.is_some()
    }

    /// Whether each cell of the lowest layer is open; `None` for a sheet that cannot open.
    /// Rectangles are numbered with the index along the length running fastest, triangles as in
    /// the mesh of an outline or, in shifted rows, as in
    /// [`crate::mesh::structure::LatticeLayer::triangles`].
    pub fn open_cells(&self) -> Option<&[bool]> {
        self.state.fracture.as_ref().map(|t| t.open.cells())
    }

    /// Number of open cells.
    pub fn open_count(&self) -> usize {
        self.state.fracture.as_ref().map_or(0, |t| t.open.count())
    }

    /// Number of changes of the open cells; a renderer rebuilds its triangles when it changes.
    pub fn opening_revision(&self) -> u64 {
        self.state.fracture.as_ref().map_or(0, |t| t.revision)
    }

    /// Energy released by opening so far, J: elastic energy of the cells and energy of detached
    /// nodes.
    pub fn energy_released(&self) -> f64 {
        self.state.fracture.as_ref().map_or(0.0, |t| t.released_energy)
    }

    /// Whether node `i` is detached: without a closed cell.
    pub fn is_detached(&self, i: usize) -> bool {
        self.state.fracture.as_ref().is_some_and(|t| t.detached[i])
    }

    /// Open cells of a sheet that has some.
    #[doc(hidden)]
    pub fn open_cell_set(&self) -> Option<&OpenCells> {
        self.state.fracture.as_ref().map(|t| &t.open).filter(|o| !o.is_whole())
    }

    /// Cells of the sheet, and the triangles and sides that they hold.
    pub fn cells(&self) -> SheetCells<'_> {
        SheetCells::new(self, self.open_cell_set())
    }
}

/// Position of node `i` when it was detached, m; `None` for any other node.
pub(crate) fn detached_at(sheet: &Sheet, i: usize) -> Option<DVec3> {
    sheet.state.fracture.as_ref().filter(|t| t.detached[i]).map(|t| t.detached_at[i])
}

/// Whether no diagonal of a closed rectangle and no side of a closed triangle is longer than `most`
/// (m). The pieces of a torn sheet
/// may be any distance apart.
pub(crate) fn is_intact_within(sheet: &Sheet, most: f64) -> bool {
    let Some(open) = sheet.open_cell_set() else { return true };
    let closed = open.cells().iter().enumerate().filter(|c| !c.1);
    let mut sound = (0..sheet.node_count()).all(|i| sheet.state.x.get(i).is_finite());
    let near =
        |a: u32, b: u32| sheet.state.x.get(a as usize).distance_squared(sheet.state.x.get(b as usize)) < most * most;
    for (c, _) in closed {
        sound &= match open.corners(c) {
            CellCorners::Rectangle([a, b, d, e]) => near(a, e) && near(b, d),
            CellCorners::Triangle([a, b, c]) => near(a, b) && near(b, c) && near(c, a),
        };
    }
    sound
}

/// Open cells after a step. Return the first opening of the sheet, once.
pub(crate) fn open_cells_after_step(sheet: &mut Sheet) -> Option<FractureOpening> {
    let mut tears = sheet.state.fracture.take()?;
    tears.opening_cells.clear();
    let worst = if tears.can_grow { find_opening_cells(sheet, &mut tears) } else { None };
    if tears.opening_cells.is_empty() {
        sheet.state.fracture = Some(tears);
        move_detached_nodes(sheet);
        return None;
    }
    let told = std::mem::replace(&mut tears.is_reported, true);
    let first = (!told).then(|| opening(sheet, &tears, worst.unwrap_or(tears.opening_cells[0] as usize)));
    for k in 0..tears.opening_cells.len() {
        tears.open.set(tears.opening_cells[k] as usize);
    }
    sheet.state.fracture = Some(tears);
    update_open_cells(sheet);
    move_detached_nodes(sheet);
    first
}

/// Collect the cells that open; return the one with the largest strain.
fn find_opening_cells(sheet: &Sheet, tears: &mut FractureState) -> Option<usize> {
    let columns = tears.open.size().0;
    // The kind of the cells is chosen once, outside the loop over them.
    let (worst, melted) = match tears.open.triangles() {
        None => test_cells(sheet, tears, |_, c| state_of_rectangle(sheet, columns, c)),
        Some(_) => test_cells(sheet, tears, |tears, c| tears.state_of(sheet, c)),
    };
    if worst.is_some() {
        for c in 0..tears.strain_ratio.len() {
            if tears.strain_ratio[c] > 1.0 && (Some(c) == worst || is_crack_tip_maximum(tears, c)) {
                tears.opening_cells.push(c as u32);
            }
        }
        tears.opening_cells.sort_unstable();
    }
    worst.or(melted)
}

/// Compare strain and temperature of every closed cell with the limits, and collect the cells that
/// melt. Return the cell with the largest strain beyond the limit, and the first that melts.
fn test_cells(
    sheet: &Sheet,
    tears: &mut FractureState,
    state: impl Fn(&FractureState, usize) -> CellState,
) -> (Option<usize>, Option<usize>) {
    let (melts_at, tears_at) = (sheet.parameters.material.melts_at, sheet.parameters.material.tears_at);
    let (mut worst, mut most, mut melted) = (None, 1.0, None);
    for c in 0..tears.strain_ratio.len() {
        tears.strain_ratio[c] = 0.0;
        if tears.open.cells()[c] {
            continue;
        }
        let state = state(tears, c);
        if melts_at.zip(state.celsius).is_some_and(|(limit, t)| t > limit) {
            tears.opening_cells.push(c as u32);
            melted.get_or_insert(c);
            continue;
        }
        // A non-finite strain is an instability, not a fracture.
        let over = tears_at.map_or(0.0, |limit| state.strain / limit);
        tears.strain_ratio[c] = over;
        if over > most * (1.0 + EQUAL_STRAIN_TOLERANCE) {
            (worst, most) = (Some(c), over);
        }
    }
    (worst, melted)
}

/// Report of the opening of cell `c`.
fn opening(sheet: &Sheet, tears: &FractureState, c: usize) -> FractureOpening {
    let state = tears.state_of(sheet, c);
    let corners = tears.open.corners(c);
    let nodes = corners.nodes();
    let middle = nodes.iter().map(|m| sheet.state.x.get(*m as usize)).sum::<DVec3>() / nodes.len() as f64;
    let melted = sheet.parameters.material.melts_at.zip(state.celsius).is_some_and(|(limit, t)| t > limit);
    FractureOpening { place_m: middle.to_array(), strain: state.strain, temperature_c: state.celsius, melted }
}

/// Open the cells along `slits` permanently.
///
/// # Errors
/// When a slit crosses no cell.
pub(crate) fn open_slits(sheet: &mut Sheet, slits: &[Slit]) -> Result<(), InputError> {
    if let Some(tears) = sheet.state.fracture.as_mut().filter(|_| !slits.is_empty()) {
        tears.initial_cells = slits::slit_cells(&tears.open, slits)?;
        set_open(sheet, &[]);
    }
    Ok(())
}

/// Open the cells that `slit` crosses in a running sheet; return how many were closed.
///
/// # Errors
/// When it crosses no cell; nothing changes then.
pub(crate) fn cut(sheet: &mut Sheet, slit: Slit) -> Result<usize, InputError> {
    let crossed = match &sheet.state.fracture {
        Some(tears) => slits::slit_cells(&tears.open, &[slit])?,
        None => slits::slit_cells(&closed_cells(sheet), &[slit])?,
    };
    prepare_cut(sheet);
    let Some(tears) = &mut sheet.state.fracture else { return Ok(0) };
    let closed = |c: &usize| crossed[*c] && !tears.open.cells()[*c];
    let cells: Vec<usize> = (0..crossed.len()).filter(closed).collect();
    cells.iter().for_each(|c| tears.open.set(*c));
    if !cells.is_empty() {
        update_open_cells(sheet);
        move_detached_nodes(sheet);
    }
    Ok(cells.len())
}

/// Give a sheet whose cells cannot open the state of one that is cut.
pub(crate) fn prepare_cut(sheet: &mut Sheet) {
    if sheet.state.fracture.is_none() {
        sheet.state.fracture = Some(Box::new(FractureState::of_cut(sheet)));
    }
}

/// Close the cells of a sheet that is cut only; false for one whose description has open cells.
pub(crate) fn undo_cuts(sheet: &mut Sheet) -> bool {
    if is_described(sheet) {
        return false;
    }
    set_open(sheet, &[]);
    sheet.state.fracture = None;
    true
}

/// Whether the description of the sheet has tearing or slits.
pub(crate) fn is_described(sheet: &Sheet) -> bool {
    sheet.state.fracture.as_ref().is_some_and(|tears| tears.is_described)
}

/// Whether each cell has opened since the start, without the slits; empty for a sheet that
/// cannot open.
pub(crate) fn torn_cells(sheet: &Sheet) -> Vec<bool> {
    let Some(tears) = &sheet.state.fracture else { return Vec::new() };
    let slit = tears.initial_cells.iter().copied().chain(std::iter::repeat(false));
    tears.open.cells().iter().zip(slit).map(|(open, slit)| *open && !slit).collect()
}

/// Restore the open cells to `torn` (empty: none) and the slits, for a return to another time.
pub(crate) fn set_open(sheet: &mut Sheet, torn: &[bool]) {
    let Some(tears) = sheet.state.fracture.as_mut() else { return };
    let of = |list: &[bool], c: usize| list.get(c).copied().unwrap_or(false);
    let cells: Vec<bool> = (0..tears.open.cells().len()).map(|c| of(torn, c) || of(&tears.initial_cells, c)).collect();
    if tears.open.cells() == cells {
        return;
    }
    tears.open.set_all(&cells);
    tears.is_reported = torn.contains(&true);
    update_open_cells(sheet);
}

/// Update everything that depends on the open cells.
fn update_open_cells(sheet: &mut Sheet) {
    let before = sheet.energy(DVec3::ZERO).total;
    let Some(mut tears) = sheet.state.fracture.take() else { return };
    tears.revision += 1;
    tears.open.update_slopes();
    tears.detached_at.resize(tears.detached.len(), DVec3::ZERO);
    for i in 0..tears.detached.len() {
        let (node, at) = node_at(sheet, &tears.open, i as u32);
        let was = std::mem::replace(&mut tears.detached[i], tears.open.is_node_gone(node, at));
        if tears.detached[i] && !was {
            tears.detached_at[i] = sheet.state.x.get(i);
        }
    }
    for i in 0..sheet.springs.len() {
        let (a, b) = (sheet.springs.a[i], sheet.springs.b[i]);
        let cut = tears.open.is_side_cut(node_at(sheet, &tears.open, a), node_at(sheet, &tears.open, b))
            || tears.detached[a as usize]
            || tears.detached[b as usize];
        sheet.parameters.springs.per_unit[i] = if cut { 0.0 } else { tears.springs[i] };
    }
    let x = &sheet.state.x;
    sheet.elements.iter_mut().for_each(|e| e.open(x, &tears.open, &tears.detached));
    fix_detached_nodes(sheet, &mut tears);
    sheet.state.fracture = Some(tears);
    sheet.parameters.drag.set_triangles(sheet.cells().triangles());
    update_contact_of_open_cells(sheet);
    if let Some(heat) = &mut sheet.state.heat {
        heat.discard_network();
    }
    sheet.refresh();
    // The stored accelerations of the integrator are of forces that have vanished.
    stage::restart_engine(sheet);
    attachment::invalidate_system(sheet);
    let after = sheet.energy(DVec3::ZERO).total;
    if let Some(tears) = &mut sheet.state.fracture {
        tears.released_energy += before - after;
    }
}

/// Node `i` and its place among the cells.
fn node_at(sheet: &Sheet, open: &OpenCells, i: u32) -> (u32, (f64, f64)) {
    (i, open.place(sheet.model.uv[i as usize]))
}

/// Fix detached nodes, remove their attachments, and find the node that each follows.
fn fix_detached_nodes(sheet: &mut Sheet, tears: &mut FractureState) {
    let mut pinned = vec![false; sheet.node_count()];
    sheet.pins.masses().for_each(|m| pinned[m as usize] = true);
    tears.followers.clear();
    sheet.pins.set_gone(&tears.detached);
    for i in 0..sheet.node_count() {
        sheet.inverse_mass[i] = if pinned[i] || tears.detached[i] { 0.0 } else { 1.0 / sheet.model.mass[i] };
        if tears.detached[i] && !pinned[i] {
            let here = sheet.model.uv[i];
            let apart = |k: &usize| {
                let (u, v) = sheet.model.uv[*k];
                ((u - here.0) * sheet.model.extent.0).hypot((v - here.1) * sheet.model.extent.1)
            };
            let left = (0..sheet.node_count()).filter(|k| !tears.detached[*k]);
            let nearest = left.min_by(|a, b| apart(a).total_cmp(&apart(b)));
            tears.followers.push((i as u32, nearest.unwrap_or(i) as u32));
        }
    }
}

/// Move detached nodes with the nodes that they follow.
fn move_detached_nodes(sheet: &mut Sheet) {
    let Some(tears) = sheet.state.fracture.as_ref().filter(|t| !t.followers.is_empty()) else { return };
    for (mass, with) in &tears.followers {
        let (mass, with) = (*mass as usize, *with as usize);
        sheet.state.x.set(mass, sheet.state.x.get(with));
        sheet.state.v.set(mass, if mass == with { DVec3::ZERO } else { sheet.state.v.get(with) });
    }
}

/// Update the limits after a change of the open cells.
fn update_contact_of_open_cells(sheet: &mut Sheet) {
    if let Some(limit) = sheet.parameters.flexion.limit.as_ref().map(|l| l.limit) {
        sheet.parameters.flexion.limit = Some(FlexionLimit { triples: closed_triples(sheet), limit });
    }
    if let (Some(limit), Some(tears)) = (&mut sheet.parameters.thickness_limit, &sheet.state.fracture) {
        limit.set_open_cells(&tears.detached);
    }
    reset_flexion_impulses(sheet);
}

/// Clear the impulses of the flexion limit and of the thickness limit solved with it.
pub(crate) fn reset_flexion_impulses(sheet: &mut Sheet) {
    let parameters = &sheet.parameters;
    let triples = parameters.flexion.limit.as_ref().map(|limit| limit.triples.len());
    let cells = triples.and(parameters.thickness_limit.as_ref()).map_or(0, ThicknessLimit::len);
    sheet.state.flexion_impulses.reset(triples.unwrap_or(0), cells);
}

/// Flexion triples whose two springs are intact.
pub(crate) fn closed_triples(sheet: &Sheet) -> Vec<[u32; 3]> {
    let mut triples = sheet.parameters.flexion.triples.clone();
    if let Some(open) = sheet.open_cell_set() {
        triples.retain(|t| {
            let [a, b, c] = t.map(|m| node_at(sheet, open, m));
            !open.is_side_cut(a, b) && !open.is_side_cut(b, c)
        });
    }
    triples
}

/// Whether cell `c` is at the end of a crack and has the largest strain of its neighbourhood.
fn is_crack_tip_maximum(tears: &FractureState, c: usize) -> bool {
    let (mut at_end, mut is_largest) = (false, true);
    tears.open.visit_neighbours(c, &mut |n| {
        at_end |= tears.open.cells()[n];
        let (mine, other) = (tears.strain_ratio[c], tears.strain_ratio[n]);
        // The first of several cells with equal strain opens.
        is_largest &= !(other > mine * (1.0 + EQUAL_STRAIN_TOLERANCE)
            || (n < c && other >= mine * (1.0 - EQUAL_STRAIN_TOLERANCE)));
    });
    at_end && is_largest
}
