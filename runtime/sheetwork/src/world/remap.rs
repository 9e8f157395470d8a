//! Change of grid of a sheet in a running world: see `sheet/remap`.
//!
//! The scene of the world is unchanged, so that a reset returns to its grids; a snapshot stores the
//! grids of its sheets.

use crate::contact::SheetContact;
use crate::error::{InputError, check_range};
use crate::islands::event::{Event, EventKind};
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter};
use crate::sheet::remap::{self, outline};
use crate::sheet::{Sheet, buckling};
use crate::units::parameters::ParameterId as Id;
use crate::world::World;

/// Numbers of nodes along length and width.
pub(crate) type Grid = (u32, u32);

/// Grid of a sheet.
pub(crate) fn grid_of(sheet: &Sheet) -> Grid {
    (sheet.model.grid.0, sheet.model.grid.2)
}

/// Serialise the grids for a snapshot.
pub(crate) fn serialise_grids(sheets: &[Sheet], to: &mut StateWriter) {
    to.count(sheets.len() as u64);
    for grid in sheets.iter().map(grid_of) {
        to.count(grid.0.into());
        to.count(grid.1.into());
    }
}

/// Deserialise the grids.
pub(crate) fn deserialise_grids(from: &mut StateReader) -> ReadResult<Vec<Grid>> {
    let mut all = Vec::new();
    let bound = Id::GridLength.range().1 as usize + 1;
    for _ in 0..from.length(2)? {
        all.push((from.index(bound)?, from.index(bound)?));
    }
    Ok(all)
}

impl World {
    /// Change the sheet `name` to another grid of `grid` nodes along length and width (2 to 2000
    /// each), between two steps, keeping shape, motion, temperatures and creases. Works for shells
    /// and lattices; see `docs/detail.md`.
    ///
    /// # Errors
    /// When there is no such sheet, the grid is out of range, or the sheet cannot change its grid;
    /// nothing changes then.
    pub fn remap(&mut self, name: &str, grid: (u32, u32)) -> Result<(), InputError> {
        let index = self.sheet_index(name)?;
        self.remap_index(index, grid).map_err(|e| e.within(&format!("sheets.{name}")))
    }

    /// Change the sheet `index` to another grid.
    pub(crate) fn remap_index(&mut self, index: usize, grid: Grid) -> Result<(), InputError> {
        let (min, max) = Id::GridLength.range();
        check_range("grid", grid.0.into(), min, max, "masses along the length")?;
        check_range("grid", grid.1.into(), min, max, "masses along the width")?;
        let old = &self.sheets[index];
        if grid_of(old) == grid {
            return Ok(());
        }
        remap::check_grid_change(old, &self.scene.sheets[index])?;
        let mut new = self.build_sheet_on_grid(index, grid)?;
        let mut contact = SheetContact::default();
        if self.sheet_contacts[index].surface.is_some() {
            // The collision surface is built from the positions at rest, which the sheet has here.
            contact.prepare_surface(&new);
        }
        remap::take_state_from(&mut new, &self.sheets[index], &self.scene.sheets[index], self.time, self.tolerance)?;
        self.discard_contact_cache(index);
        self.sheet_contacts[index] = contact;
        self.sheets[index] = new;
        let event = Event::new(self.time, EventKind::Resampled, &self.sheets[index].name, None);
        self.events.push(Event { grid: Some(grid), ..event });
        Ok(())
    }

    /// The sheet `index` of the scene, on that grid.
    pub(crate) fn build_sheet_on_grid(&mut self, index: usize, grid: Grid) -> Result<Sheet, InputError> {
        let mut sheet = Sheet::build_at(&self.scene, index, grid)?;
        crate::world::attach_to_bodies(&mut sheet, self.rigid.as_ref())?;
        sheet.name.clone_from(&self.sheets[index].name);
        outline::copy_described_mesh(&mut sheet, &self.sheets[index]);
        Ok(sheet)
    }

    /// The sheet `index` of the scene on that grid, with the present detection of buckling.
    pub(crate) fn fresh_sheet(&mut self, index: usize, grid: Grid) -> ReadResult<Sheet> {
        let watched = self.sheets[index].state.buckle_detector.is_some();
        let mut sheet = self.build_sheet_on_grid(index, grid).map_err(|_| CorruptState)?;
        buckling::set_buckling_detection(&mut sheet, watched);
        Ok(sheet)
    }

    /// Discard the detection and contact caches of the sheet `index` and of its islands, and the
    /// visibility for heat.
    fn discard_contact_cache(&mut self, index: usize) {
        self.islands.forget_sheet(index, &mut self.sheet_contacts);
        self.heat.iter_mut().for_each(|heat| heat.discard_views());
    }

    /// Replace sheets on other grids than `grids` by sheets of the scene on these grids. Returns
    /// the replaced ones.
    pub(crate) fn exchange_grids(&mut self, grids: &[Grid]) -> ReadResult<Vec<(usize, Sheet, SheetContact)>> {
        if grids.len() != self.sheets.len() {
            return Err(CorruptState);
        }
        let mut new = Vec::new();
        for (index, grid) in grids.iter().enumerate() {
            if grid_of(&self.sheets[index]) != *grid {
                new.push((index, self.fresh_sheet(index, *grid)?, SheetContact::default()));
            }
        }
        for (index, sheet, contact) in &mut new {
            self.discard_contact_cache(*index);
            std::mem::swap(&mut self.sheets[*index], sheet);
            std::mem::swap(&mut self.sheet_contacts[*index], contact);
        }
        Ok(new)
    }

    /// Restore the replaced sheets.
    pub(crate) fn restore_sheets(&mut self, sheets: Vec<(usize, Sheet, SheetContact)>) {
        for (index, sheet, contact) in sheets {
            self.discard_contact_cache(index);
            self.sheets[index] = sheet;
            self.sheet_contacts[index] = contact;
        }
    }
}
