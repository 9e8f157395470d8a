//! Failure of sheets: detection after every step, and its events. Fracture: `sheet/fracture`;
//! buckling: `sheet/buckling`. Cuts of a running sheet.

use crate::error::{InputError, reject_if};
use crate::islands::event::{Event, EventKind};
use crate::scene;
use crate::sheet::{Status, buckling, fracture};
use crate::units::parameters::ParameterId as Id;
use crate::world::World;
use crate::world::ids::SheetId;

impl World {
    /// Test sheets for fracture, after motion and heat.
    pub(crate) fn fracture_sheets(&mut self) {
        let mut changed = false;
        for index in 0..self.sheets.len() {
            let sheet = &mut self.sheets[index];
            if !sheet.can_open() || sheet.state.status != Status::Awake {
                continue;
            }
            let before = sheet.opening_revision();
            let opening = fracture::open_cells_after_step(sheet);
            changed |= sheet.opening_revision() != before;
            if opening.is_some() {
                let event = Event::new(self.time, EventKind::Torn, &sheet.name, None);
                self.events.push(Event { place_m: opening.map(|o| o.place_m), opening, ..event });
            }
        }
        if let Some(heat) = self.heat.as_mut().filter(|_| changed) {
            heat.discard_views();
        }
    }

    /// Cut the sheet `id` along the line between two material points (u, v), each 0 to 1: the cells
    /// that it crosses open, as along [`SheetSpec::slits`](crate::scene::SheetSpec::slits).
    /// Returns how many were closed. They are part of snapshots; a reset closes them. The cut grows
    /// only in a sheet with `tearing`. The sheet keeps its grid from then on.
    ///
    /// # Errors
    /// When there is no such sheet, the line is out of range, has no length or crosses no cell, or
    /// the sheet is of a file, changes its grid by itself, or has a drawn contact surface; nothing
    /// changes then.
    pub fn cut(&mut self, id: SheetId, from: (f64, f64), to: (f64, f64)) -> Result<usize, InputError> {
        let index = self.index_of_sheet(id)?;
        Id::SlitEnd.check_each("from", [from.0, from.1])?;
        Id::SlitEnd.check_each("to", [to.0, to.1])?;
        reject_if!(from == to, "to", "is where the cut begins");
        let mut spec = self.scene.sheets[index].clone();
        spec.slits = vec![(from, to)];
        scene::validate::sheet(&spec)?;
        let opened = fracture::cut(&mut self.sheets[index], (from, to))?;
        self.sheet_contacts[index].prepare_opened(&self.sheets[index]);
        self.heat.iter_mut().for_each(|heat| heat.discard_views());
        Ok(opened)
    }

    /// Enable or disable the detection of buckling: an [`EventKind::Buckled`] for each occurrence,
    /// with place and energy. Costs one evaluation of forces and energy per step and moving sheet.
    pub fn set_buckling_detection(&mut self, watch: bool) {
        self.buckling = watch;
        self.sheets.iter_mut().for_each(|s| buckling::set_buckling_detection(s, watch));
    }

    /// Whether the detection of buckling is enabled.
    pub fn detects_buckling(&self) -> bool {
        self.buckling
    }

    pub(crate) fn detect_buckling(&mut self, from: f64) {
        if !self.buckling {
            return;
        }
        for sheet in &mut self.sheets {
            // Sheets added later are enabled here.
            buckling::set_buckling_detection(sheet, true);
            if let Some(buckle) = buckling::detect_buckling(sheet, from) {
                let event = Event::new(buckle.time, EventKind::Buckled, &sheet.name, None);
                let (place_m, energy_j) = (Some(buckle.place.to_array()), Some(buckle.energy));
                self.events.push(Event { place_m, energy_j, ..event });
            }
        }
    }
}
