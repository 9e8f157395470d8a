//! Contact state of one sheet: collision surface, clearance cache, contact arrays.
//!
//! The world keeps one for every sheet, in the order of the sheets. The sheet itself knows nothing
//! of contact.

use crate::collision::collision_surface::CollisionSurface;
use crate::contact::node::clearance::Clearance;
use crate::contact::node::drawn_contact::DrawnContact;
use crate::contact::solver::sheet_response::SheetResponse;
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter};
use crate::sheet::Sheet;

/// Contact state of one sheet.
#[derive(Default)]
pub(crate) struct SheetContact {
    /// Collision surface; `None` before the first step near an obstacle.
    pub surface: Option<Box<CollisionSurface>>,
    /// Value of [`Sheet::opening_revision`] that the surface follows.
    opening_revision: u64,
    /// Clearance of the nodes, for explicit integrators.
    pub clearance: Clearance,
    /// Drawn surface in contact with bodies, for explicit integrators; `None` without one.
    pub drawn: Option<Box<DrawnContact>>,
    /// Contacts of the sheet in the solver.
    pub response: SheetResponse,
}

impl SheetContact {
    /// Build the collision surface if there is none, and bring it up to date with the open cells.
    pub fn prepare_surface(&mut self, sheet: &Sheet) {
        let revision = sheet.opening_revision();
        match &mut self.surface {
            Some(surface) if self.opening_revision != revision => surface.rebuild_open(sheet),
            Some(surface) => surface.set_thickness(sheet),
            None => self.surface = Some(Box::new(CollisionSurface::from_sheet(sheet))),
        }
        self.opening_revision = revision;
    }

    /// Bring the collision surface, if there is one, up to date with the open cells.
    pub fn prepare_opened(&mut self, sheet: &Sheet) {
        if self.surface.is_some() {
            self.prepare_surface(sheet);
        }
    }

    /// Serialise whether there is a collision surface, with its checksum.
    pub fn serialise_surface(&self, to: &mut StateWriter) {
        to.count(self.surface.as_ref().map_or(0, |surface| 1 + u64::from(surface.checksum())));
    }

    /// Deserialise the output of [`SheetContact::serialise_surface`]. A missing surface is built
    /// from the present state of the sheet, which for a new one is its state before the first step.
    pub fn deserialise_surface(&mut self, sheet: &Sheet, from: &mut StateReader) -> ReadResult {
        let Some(make) = from.count()?.checked_sub(1) else { return Ok(()) };
        self.prepare_surface(sheet);
        let own = self.surface.as_ref().map(|surface| u64::from(surface.checksum()));
        if own == Some(make) { Ok(()) } else { Err(CorruptState) }
    }
}
