//! Change of grid of a sheet in a running world: see `sheet/remap`.
//!
//! The scene of the world is unchanged, so that a reset returns to its grids; a snapshot stores the
//! grids of its sheets.

use crate::contact::SheetContact;
use crate::error::{InputError, check_range};
use crate::islands::event::{Event, EventKind};
use crate::serialize::{Cut, Keeper, Taken, Taker};
use crate::sheet::Sheet;
use crate::world::World;

/// Numbers of nodes along length and width.
pub(crate) type Grid = (u32, u32);

/// Maximum number of nodes along a side.
const MOST: u32 = 2000;

/// Grid of a sheet.
pub(crate) fn grid_of(sheet: &Sheet) -> Grid {
    (sheet.grid.0, sheet.grid.2)
}

/// Serialise the grids for a snapshot.
pub(crate) fn keep_grids(sheets: &[Sheet], to: &mut Keeper) {
    to.count(sheets.len() as u64);
    for grid in sheets.iter().map(grid_of) {
        to.count(grid.0.into());
        to.count(grid.1.into());
    }
}

/// Deserialise the grids.
pub(crate) fn take_grids(from: &mut Taker) -> Taken<Vec<Grid>> {
    let mut all = Vec::new();
    for _ in 0..from.length(2)? {
        all.push((from.index(MOST as usize + 1)?, from.index(MOST as usize + 1)?));
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
    pub fn resample(&mut self, name: &str, grid: (u32, u32)) -> Result<(), InputError> {
        let Some(index) = self.sheets.iter().position(|s| s.name == name) else {
            return Err(InputError::new("sheet", format!("no sheet is named \"{name}\"")));
        };
        self.resample_index(index, grid).map_err(|e| {
            let field = format!("sheets.{name}.{}", e.field);
            InputError { field, ..e }
        })
    }

    /// Change the sheet `index` to another grid.
    pub(crate) fn resample_index(&mut self, index: usize, grid: Grid) -> Result<(), InputError> {
        check_range("grid", grid.0.into(), 2.0, MOST.into(), "masses along the length")?;
        check_range("grid", grid.1.into(), 2.0, MOST.into(), "masses along the width")?;
        let old = &self.sheets[index];
        if grid_of(old) == grid {
            return Ok(());
        }
        old.check_resample(&self.scene.sheets[index])?;
        let mut new = self.built_at(index, grid)?;
        let mut contact = SheetContact::default();
        if self.contacts[index].surface.is_some() {
            // The collision surface is built from the positions at rest, which the sheet has now.
            contact.prepare_surface(&new);
        }
        new.take_over(&self.sheets[index], &self.scene.sheets[index], self.time, self.tolerance)?;
        self.forget_contacts(index);
        self.contacts[index] = contact;
        self.sheets[index] = new;
        let event = Event::new(self.time, EventKind::Resampled, &self.sheets[index].name, None);
        self.events.push(Event { grid: Some(grid), ..event });
        Ok(())
    }

    /// The sheet `index` of the scene, on that grid.
    pub(crate) fn built_at(&mut self, index: usize, grid: Grid) -> Result<Sheet, InputError> {
        let mut sheet = Sheet::build_at(&self.scene, index, grid)?;
        crate::world::glue(&mut sheet, self.rigid.as_ref())?;
        sheet.name.clone_from(&self.sheets[index].name);
        sheet.take_first_mesh_of(&self.sheets[index]);
        Ok(sheet)
    }

    /// Discard the detection and contact caches of the sheet `index` and of its islands, and the
    /// visibility for heat.
    fn forget_contacts(&mut self, index: usize) {
        self.groups.forget_sheet(index, &mut self.contacts);
        if let Some(heat) = &mut self.heat {
            heat.forget();
        }
    }

    /// Replace sheets on other grids than `grids` by sheets of the scene on these grids. Returns
    /// the replaced ones.
    pub(crate) fn go_to_grids(&mut self, grids: &[Grid]) -> Taken<Vec<(usize, Sheet, SheetContact)>> {
        if grids.len() != self.sheets.len() {
            return Err(Cut);
        }
        let mut new = Vec::new();
        for (index, grid) in grids.iter().enumerate() {
            if grid_of(&self.sheets[index]) != *grid {
                let watched = self.sheets[index].is_watched();
                let mut sheet = self.built_at(index, *grid).map_err(|_| Cut)?;
                sheet.watch_buckling(watched);
                new.push((index, sheet, SheetContact::default()));
            }
        }
        for (index, sheet, contact) in &mut new {
            self.forget_contacts(*index);
            std::mem::swap(&mut self.sheets[*index], sheet);
            std::mem::swap(&mut self.contacts[*index], contact);
        }
        Ok(new)
    }

    /// Restore the replaced sheets.
    pub(crate) fn put_back(&mut self, sheets: Vec<(usize, Sheet, SheetContact)>) {
        for (index, sheet, contact) in sheets {
            self.forget_contacts(index);
            self.sheets[index] = sheet;
            self.contacts[index] = contact;
        }
    }
}
