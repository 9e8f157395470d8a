//! Change of grid, or of local refinement, of a sheet in a running world: see `sheet/remap`.
//!
//! The scene of the world is unchanged, so that a reset returns to its grids; a snapshot stores the
//! grids of its sheets and the levels of refined ones.

use std::sync::Arc;

use crate::collision::settings::{DetectionSettings, OverlapSettings};
use crate::contact::SheetContact;
use crate::contact::node::detection::deepest_penetration;
use crate::error::{InputError, check_range};
use crate::islands::event::{Event, EventKind};
use crate::rigid::{RigidView, RigidWorld};
use crate::scene::Scene;
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter};
use crate::sheet::refine::{RefineWorkspace, Resolution, plan_levels, resolution_of};
use crate::sheet::remap::{self, outline};
use crate::sheet::{Sheet, Status, buckling};
use crate::units::parameters::ParameterId as Id;
use crate::world::World;

const OVERLAP: OverlapSettings = DetectionSettings::DEFAULT.overlap;

/// Result of a change of grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GridChange {
    /// The sheet has the grid.
    Done,
    /// The sheet has its old grid: on the new one, a node would lie in a body.
    Deferred,
}

/// Whether a node of `new`, the sheet `old` on another grid, lies in a body by more than the
/// accepted penetration, and deeper than those of `old`.
fn penetrates(new: &Sheet, old: &Sheet, view: &RigidView) -> bool {
    let accepted = OVERLAP.depth * new.material().thickness;
    let depth = deepest_penetration(new, view);
    depth > accepted && depth > deepest_penetration(old, view) + accepted
}

/// Numbers of nodes along length and width.
pub(crate) type Grid = (u32, u32);

/// Grid of a sheet.
pub(crate) fn grid_of(sheet: &Sheet) -> Grid {
    (sheet.model.grid.0, sheet.model.grid.2)
}

/// Serialise the grids, and the levels of refined sheets, for a snapshot.
pub(crate) fn serialise_grids(sheets: &[Sheet], to: &mut StateWriter) {
    to.count(sheets.len() as u64);
    for sheet in sheets {
        let grid = grid_of(sheet);
        to.count(grid.0.into());
        to.count(grid.1.into());
        sheet.model.refinement.iter().for_each(|levels| to.blob(levels));
    }
}

/// Deserialise the grids and levels of the sheets of `scene`.
pub(crate) fn deserialise_grids(from: &mut StateReader, scene: &Scene) -> ReadResult<Vec<Resolution>> {
    let mut all = Vec::new();
    let bound = Id::GridLength.range().1 as usize + 1;
    for index in 0..from.length(2)? {
        let grid = (from.index(bound)?, from.index(bound)?);
        let most = scene.sheets.get(index).and_then(|s| s.refine).map(|refine| refine.levels);
        let levels: Option<Arc<[u8]>> = if most.is_some() { Some(from.blob()?.into()) } else { None };
        if levels.iter().any(|all| all.iter().any(|level| u32::from(*level) > most.unwrap_or(0))) {
            return Err(CorruptState);
        }
        all.push(Resolution { grid, levels });
    }
    Ok(all)
}

impl World {
    /// Change the sheet `name` to another grid of `grid` nodes along length and width (2 to 2000
    /// each), between two steps, keeping shape, motion, temperatures and creases. Works for shells
    /// and lattices; see `docs/detail.md`.
    ///
    /// # Errors
    /// When there is no such sheet, the grid is out of range, the sheet cannot change its grid, or
    /// would lie in a body on it; nothing changes then.
    pub fn remap(&mut self, name: &str, grid: (u32, u32)) -> Result<(), InputError> {
        let index = self.sheet_index(name)?;
        self.set_grid(index, grid).map_err(|e| e.within(&format!("sheets.{name}")))
    }

    /// Change the sheet `index` to another grid, for a caller.
    pub(crate) fn set_grid(&mut self, index: usize, grid: Grid) -> Result<(), InputError> {
        match self.remap_index(index, grid, None)? {
            GridChange::Done => Ok(()),
            GridChange::Deferred => {
                Err(InputError::new("grid", "the sheet would lie in a body; try again when it has moved"))
            }
        }
    }

    /// Change the sheet `index` to another grid, apart from the bodies of `lent`, the caller's
    /// rigid world, or of the world.
    pub(crate) fn remap_index(
        &mut self,
        index: usize,
        grid: Grid,
        lent: Option<&RigidView>,
    ) -> Result<GridChange, InputError> {
        let (min, max) = Id::GridLength.range();
        check_range("grid", grid.0.into(), min, max, "masses along the length")?;
        check_range("grid", grid.1.into(), min, max, "masses along the width")?;
        if grid_of(&self.sheets[index]) == grid {
            return Ok(GridChange::Done);
        }
        let at = Resolution { grid, levels: None };
        let (new, contact) = self.on_resolution(index, &at)?;
        let own = self.rigid.as_deref().map(RigidWorld::view);
        let old = &self.sheets[index];
        if lent.or(own.as_ref()).is_some_and(|view| penetrates(&new, old, view)) {
            return Ok(GridChange::Deferred);
        }
        self.replace_sheet(index, new, contact, grid);
        Ok(GridChange::Done)
    }

    /// Change the sheet `index` to another grid or to other levels of its base mesh.
    pub(crate) fn change_resolution(&mut self, index: usize, at: &Resolution) -> Result<(), InputError> {
        if resolution_of(&self.sheets[index]) != *at {
            let (new, contact) = self.on_resolution(index, at)?;
            self.replace_sheet(index, new, contact, at.grid);
        }
        Ok(())
    }

    /// The sheet `index` in its present state on another grid or with other levels.
    fn on_resolution(&mut self, index: usize, at: &Resolution) -> Result<(Sheet, SheetContact), InputError> {
        remap::check_grid_change(&self.sheets[index], &self.scene.sheets[index])?;
        let mut new = self.build_sheet_on_grid(index, at)?;
        let mut contact = SheetContact::default();
        if self.sheet_contacts[index].surface.is_some() {
            // The collision surface is built from the positions at rest, which the sheet has here.
            contact.prepare_surface(&new);
        }
        remap::take_state_from(&mut new, &self.sheets[index], &self.scene.sheets[index], self.time, self.tolerance)?;
        Ok((new, contact))
    }

    /// Put `new` in the place of the sheet `index`, and tell its grid.
    fn replace_sheet(&mut self, index: usize, new: Sheet, contact: SheetContact, grid: Grid) {
        self.discard_contact_cache(index);
        self.sheet_contacts[index] = contact;
        self.sheets[index] = new;
        let event = Event::new(self.time, EventKind::Resampled, &self.sheets[index].name, None);
        self.events.push(Event { grid: Some(grid), ..event });
    }

    /// The sheet `index` of the scene, on that grid and with those levels.
    pub(crate) fn build_sheet_on_grid(&mut self, index: usize, at: &Resolution) -> Result<Sheet, InputError> {
        let mut sheet = Sheet::build_at(&self.scene, index, at)?;
        crate::world::attach_to_bodies(&mut sheet, self.rigid.as_deref())?;
        sheet.name.clone_from(&self.sheets[index].name);
        outline::copy_described_mesh(&mut sheet, &self.sheets[index]);
        Ok(sheet)
    }

    /// The sheet `index` of the scene on that grid and with those levels, with the present
    /// detection of buckling.
    pub(crate) fn fresh_sheet(&mut self, index: usize, at: &Resolution) -> ReadResult<Sheet> {
        let watched = self.sheets[index].state.buckle_detector.is_some();
        let mut sheet = self.build_sheet_on_grid(index, at).map_err(|_| CorruptState)?;
        buckling::set_buckling_detection(&mut sheet, watched);
        Ok(sheet)
    }

    /// Refine or coarsen the meshes of sheets with local refinement, where the number of steps
    /// allows a change.
    pub(crate) fn refine_sheets(&mut self) {
        for index in 0..self.scene.sheets.len() {
            let Some(spec) = self.scene.sheets[index].refine else { continue };
            let sheet = &self.sheets[index];
            let due = self.steps.is_multiple_of(spec.every.into());
            if !due || sheet.state.status != Status::Awake || sheet.open_count() > 0 {
                continue;
            }
            let work: &mut RefineWorkspace = self.refine_work.get_or_insert_default();
            if plan_levels(sheet, &spec, work) {
                let levels = Some(work.levels.as_slice().into());
                let at = Resolution { levels, ..resolution_of(sheet) };
                // A mesh that cannot change stays: nothing that is stored depends on the attempt.
                let _ = self.change_resolution(index, &at);
            }
        }
    }

    /// Discard the detection and contact caches of the sheet `index` and of its islands, and the
    /// visibility for heat.
    pub(crate) fn discard_contact_cache(&mut self, index: usize) {
        self.islands.forget_sheet(index, &mut self.sheet_contacts);
        self.heat.iter_mut().for_each(|heat| heat.discard_views());
    }

    /// Replace sheets on other grids than `grids`, or with other levels, by sheets of the scene on
    /// these grids. Returns the replaced ones.
    pub(crate) fn exchange_grids(&mut self, grids: &[Resolution]) -> ReadResult<Vec<(usize, Sheet, SheetContact)>> {
        if grids.len() != self.sheets.len() {
            return Err(CorruptState);
        }
        let mut new = Vec::new();
        for (index, at) in grids.iter().enumerate() {
            if resolution_of(&self.sheets[index]) != *at {
                new.push((index, self.fresh_sheet(index, at)?, SheetContact::default()));
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
