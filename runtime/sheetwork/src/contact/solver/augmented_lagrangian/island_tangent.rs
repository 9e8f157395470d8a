//! Tangent matrix to which contact is added: that of a single sheet, or the joint matrix of several
//! sheets and dynamic bodies.
//!
//! A dynamic body has two block rows, the displacement of its centre of mass and its rotation, with
//! m/h² and I/h² on the diagonal: the tangent M/h² + K of a sheet for K = 0. Only contacts couple
//! sheets and bodies. The pattern of the joint matrix is the union of the patterns of the sheets
//! and the pairs of the contacts. It is analysed again when a contact couples a new pair; a resting
//! scene keeps its pattern.

use glam::DMat3;

use crate::contact::IslandView;
use crate::contact::settings::{AugmentedLagrangianSettings, ContactSettings};
use crate::contact::solver::augmented_lagrangian::SolverConstraint;
use crate::contact::solver_body::SolverBody;
use crate::linear::{Factor, Pattern, analyse_joined};
use crate::serialize::{CorruptState, ReadResult, State, StateReader, StateWriter};
use crate::sheet::{ImplicitSystem, stage};

const SETTINGS: AugmentedLagrangianSettings = ContactSettings::DEFAULT.augmented_lagrangian;

/// Block row of a kinematic or static body, which has none.
pub(crate) const NO_ROWS: u32 = u32::MAX;

/// A symmetric matrix of 3×3 blocks that can be factorised together with contact terms.
pub(crate) trait TangentMatrix {
    /// Sparsity pattern of the blocks.
    fn pattern(&self) -> &Pattern;

    /// Factorise the matrix after `add` has added to its values. Returns false if it has no factor.
    fn factorize_with(&mut self, add: &mut dyn FnMut(&mut [f64])) -> bool;

    /// Solve with the last factor, in place.
    fn solve(&mut self, right: &mut [f64]);
}

/// Joint tangent matrix of an island.
#[derive(Default)]
pub(crate) struct IslandTangent {
    /// First block row of every sheet and then of every body of the island; [`NO_ROWS`] for
    /// kinematic and static bodies.
    first: Vec<u32>,
    /// Present layout: first block row and number of blocks of every sheet and body.
    layout: Vec<(u32, u32)>,
    /// Layout for which the pattern was made.
    pattern_layout: Vec<(u32, u32)>,
    pattern: Pattern,
    factor: Option<Factor>,
    /// Slot in the joint pattern of every block of every sheet.
    slots: Vec<u32>,
    /// Values of the matrix without contact.
    base: Vec<f64>,
    /// Values of the matrix with contact.
    values: Vec<f64>,
    /// Horizontal position of each block row, m.
    places: Vec<[f64; 2]>,
    /// Height of the sheet or body of each block row, m.
    depths: Vec<f64>,
    /// Number of analyses of a pattern.
    pub analyses: u64,
    /// Whether the pattern was deserialised and has no factor yet.
    restored: bool,
}

impl IslandTangent {
    /// Lay out the block rows of `island`. Constraints are assembled after this.
    pub fn lay_out(&mut self, island: &IslandView) {
        self.first.clear();
        self.layout.clear();
        let mut next = 0;
        for local in 0..island.sheets.len() as u32 {
            let sheet = island.sheet(local);
            let (rows, blocks) = stage::tangent(sheet).map_or((0, 0), |t| (t.pattern().size(), t.pattern().blocks()));
            self.first.push(next);
            self.layout.push((next, blocks as u32));
            next += rows as u32;
        }
        for solver_body in &island.solver_bodies {
            let first = if solver_body.is_dynamic() { next } else { NO_ROWS };
            self.first.push(first);
            self.layout.push((first, 0));
            next += if solver_body.is_dynamic() { 2 } else { 0 };
        }
        self.layout.push((next, 0));
    }

    /// Number of block rows.
    pub fn size(&self) -> usize {
        self.layout.last().map_or(0, |s| s.0 as usize)
    }

    /// First block row of sheet number `local` of the island.
    pub fn sheet(&self, local: u32) -> u32 {
        self.first[local as usize]
    }

    /// First block row of body number `body` of an island with `sheets` sheets, if the body is
    /// dynamic.
    pub fn body(&self, sheets: usize, body: u32) -> Option<u32> {
        Some(self.first[sheets + body as usize]).filter(|f| *f != NO_ROWS)
    }

    /// Diagonal block of `row` in a stage of weight `h` (s), N/m.
    pub fn diagonal_of(&self, island: &IslandView, row: u32, h: f64) -> DMat3 {
        let sheets = island.sheets.len();
        let local = self.first[..sheets].partition_point(|first| *first <= row) - 1;
        let within = row - self.first[local];
        let tangent = stage::tangent(island.sheet(local as u32));
        if let Some(tangent) = tangent.filter(|t| (within as usize) < t.pattern().size()) {
            return tangent.diagonal(within);
        }
        let bodies = self.first[sheets..].iter().zip(&island.solver_bodies);
        let of = bodies.into_iter().find(|(first, _)| **first != NO_ROWS && row.wrapping_sub(**first) < 2);
        of.map_or(DMat3::IDENTITY, |(first, solver_body)| {
            let (mass, inertia) = inertia_blocks(solver_body, h);
            if row == *first { mass } else { inertia }
        })
    }

    /// Copy the tangents of the sheets and the inertia of the bodies in a stage of weight `h` (s)
    /// into the joint matrix. The pattern is extended if it does not cover the block `pairs`, each
    /// the larger row first.
    pub fn fill(&mut self, island: &IslandView, pairs: impl Iterator<Item = (u32, u32)> + Clone, h: f64) {
        if std::mem::take(&mut self.restored) && self.pattern_layout == self.layout {
            self.analyse_factor(island);
        }
        let mut covered = pairs.clone();
        if self.pattern_layout != self.layout || !covered.all(|(a, b)| self.pattern.slot(a, b).is_some()) {
            self.analyse(island, pairs);
        }
        if let Some(factor) = &mut self.factor {
            factor.set_parallel(island.parallel);
        }
        self.base.fill(0.0);
        let mut slots = self.slots.iter();
        for local in 0..island.sheets.len() as u32 {
            let Some(tangent) = stage::tangent(island.sheet(local)) else { continue };
            for (block, slot) in tangent.values().chunks_exact(9).zip(slots.by_ref()) {
                let at = 9 * *slot as usize;
                self.base[at..at + 9].copy_from_slice(block);
            }
        }
        for (i, solver_body) in island.solver_bodies.iter().enumerate() {
            if let Some(first) = self.body(island.sheets.len(), i as u32) {
                let (mass, inertia) = inertia_blocks(solver_body, h);
                for (row, block) in [(first, mass), (first + 1, inertia)] {
                    let at = 9 * self.pattern.starts[row as usize] as usize;
                    self.base[at..at + 9].copy_from_slice(&block.to_cols_array());
                }
            }
        }
    }

    /// Analyse the pattern of the sheets and of `coupled` pairs.
    fn analyse(&mut self, island: &IslandView, coupled: impl Iterator<Item = (u32, u32)>) {
        self.analyses += 1;
        let same = self.pattern_layout == self.layout;
        self.pattern_layout.clone_from(&self.layout);
        let mut pairs = Vec::new();
        for (local, first) in (0..island.sheets.len() as u32).zip(&self.first) {
            if let Some(tangent) = stage::tangent(island.sheet(local)) {
                pairs.extend(tangent.pattern().iter().map(|(_, row, column)| (first + row, first + column)));
            }
        }
        pairs.extend(coupled);
        // Earlier pairs are kept: they may touch again, and another analysis costs more than a few
        // zero blocks.
        let fresh = Pattern::new(self.size(), pairs.iter().copied());
        pairs.extend(self.pattern.iter().filter(|_| same).map(|(_, row, column)| (row, column)));
        let joined = Pattern::new(self.size(), pairs);
        let is_little = joined.blocks() as f64 <= SETTINGS.maximum_fill_ratio * fresh.blocks() as f64;
        self.pattern = if is_little { joined } else { fresh };
        self.compute_ordering_positions(island);
        self.analyse_factor(island);
    }

    /// Serialise the pattern and the data of the elimination order, which depend on earlier steps.
    pub fn serialise(&self, to: &mut StateWriter) {
        to.states(&self.pattern_layout);
        to.count(self.pattern.size() as u64);
        for column in 0..self.pattern.size() {
            let rows = &self.pattern.rows[self.pattern.column(column)];
            to.count(rows.len() as u64);
            // The diagonal comes first, and rows ascend.
            rows.windows(2).for_each(|pair| to.count(u64::from(pair[1] - pair[0])));
        }
        self.places.serialise(to);
        self.depths.serialise(to);
    }

    /// Deserialise. The factor is analysed at the next use, unless it matches the deserialised
    /// data.
    pub fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        let made_for: Vec<(u32, u32)> = from.states(2)?;
        let size = from.length(25)?;
        let mut pairs = Vec::new();
        for column in 0..size as u32 {
            let mut row = column;
            for _ in 1..from.length(1)? {
                row = row.checked_add(from.count_u32()?).filter(|r| (*r as usize) < size).ok_or(CorruptState)?;
                pairs.push((row, column));
            }
        }
        let pattern = Pattern::new(size, pairs);
        let (mut places, mut depths) = (vec![[0.0; 2]; size], vec![0.0; size]);
        places.deserialise(from)?;
        depths.deserialise(from)?;
        let has_factor = self.factor.is_some() && !self.restored;
        if has_factor
            && (&self.pattern_layout, &self.pattern, &self.places, &self.depths)
                == (&made_for, &pattern, &places, &depths)
        {
            return Ok(());
        }
        // A pattern of inconsistent size is discarded.
        self.restored = !made_for.is_empty() && made_for.last().is_some_and(|s| s.0 as usize == size);
        (self.pattern_layout, self.pattern, self.places, self.depths) = (made_for, pattern, places, depths);
        if !self.restored {
            self.pattern_layout.clear();
        }
        Ok(())
    }

    /// Analyse the present pattern for factorisation.
    fn analyse_factor(&mut self, island: &IslandView) {
        self.slots.clear();
        for (local, first) in (0..island.sheets.len() as u32).zip(&self.first) {
            if let Some(tangent) = stage::tangent(island.sheet(local)) {
                let slot =
                    |(_, row, column): (usize, u32, u32)| self.pattern.slot(first + row, first + column).unwrap_or(0);
                self.slots.extend(tangent.pattern().iter().map(slot));
            }
        }
        self.factor = Some(analyse_joined(&self.pattern, &self.places, &self.depths));
        self.base.clear();
        self.base.resize(9 * self.pattern.blocks(), 0.0);
    }

    /// Compute the positions of the block rows that guide the elimination order: horizontal
    /// position, and height of the sheet's centre, which separates the sheets of a pile.
    fn compute_ordering_positions(&mut self, island: &IslandView) {
        self.places.clear();
        self.depths.clear();
        for local in 0..island.sheets.len() as u32 {
            let sheet = island.sheet(local);
            let height = sheet.centre_of_mass().y;
            for mass in stage::block_masses(sheet) {
                let x = sheet.state.x.get(*mass as usize);
                self.places.push([x.x, x.z]);
                self.depths.push(height);
            }
        }
        for solver_body in island.solver_bodies.iter().filter(|m| m.is_dynamic()) {
            let centre = solver_body.free.centre();
            self.places.extend([[centre.x, centre.z]; 2]);
            self.depths.extend([centre.y; 2]);
        }
    }
}

impl TangentMatrix for IslandTangent {
    fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    fn factorize_with(&mut self, add: &mut dyn FnMut(&mut [f64])) -> bool {
        self.values.clone_from(&self.base);
        add(&mut self.values);
        self.factor.as_mut().is_some_and(|f| f.factorize(&self.values).is_ok())
    }

    fn solve(&mut self, right: &mut [f64]) {
        if let Some(factor) = &mut self.factor {
            factor.solve(right);
        }
    }
}

impl TangentMatrix for ImplicitSystem {
    fn pattern(&self) -> &Pattern {
        self.pattern()
    }

    fn factorize_with(&mut self, add: &mut dyn FnMut(&mut [f64])) -> bool {
        self.factorize_with(add)
    }

    fn solve(&mut self, right: &mut [f64]) {
        self.solve(right);
    }
}

/// Diagonal blocks m/h² (kg/s²) and I/h² of a dynamic body.
fn inertia_blocks(solver_body: &SolverBody, h: f64) -> (DMat3, DMat3) {
    let per = 1.0 / (h * h);
    (DMat3::from_diagonal(glam::DVec3::splat(per / solver_body.free.inverse_mass())), solver_body.free.inertia() * per)
}

/// Whether `pattern` covers all pairs of `row`.
pub(crate) fn covers_constraint(pattern: &Pattern, row: &SolverConstraint) -> bool {
    row.pairs().all(|(row, column)| pattern.slot(row, column).is_some())
}
