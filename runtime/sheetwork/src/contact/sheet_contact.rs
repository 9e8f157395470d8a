//! Contact state of one sheet: collision surface, clearance cache, contact arrays.
//!
//! The world keeps one for every sheet, in the order of the sheets. The sheet itself knows nothing
//! of contact.

use crate::collision::collision_surface::Skin;
use crate::contact::node::clearance::Clearance;
use crate::contact::solver::delassus::Unit;
use crate::serialize::{Cut, Keeper, Taken, Taker};
use crate::sheet::Sheet;

/// Contact state of one sheet.
#[derive(Default)]
pub(crate) struct SheetContact {
    /// Collision surface; `None` before the first step near an obstacle.
    pub surface: Option<Box<Skin>>,
    /// Value of [`Sheet::opening_revision`] that the surface follows.
    opened: u64,
    /// Clearance of the nodes, for explicit integrators.
    pub clearance: Clearance,
    /// Contacts of the sheet in the solver.
    pub unit: Unit,
}

impl SheetContact {
    /// Build the collision surface if there is none, and bring it up to date with the open cells.
    pub fn prepare_surface(&mut self, sheet: &Sheet) {
        let revision = sheet.opening_revision();
        match &mut self.surface {
            Some(surface) if self.opened != revision => surface.open(sheet),
            Some(_) => {}
            None => self.surface = Some(Box::new(Skin::of(sheet))),
        }
        self.opened = revision;
    }

    /// Bring the collision surface, if there is one, up to date with the open cells.
    pub fn prepare_opened(&mut self, sheet: &Sheet) {
        if self.surface.is_some() {
            self.prepare_surface(sheet);
        }
    }

    /// Serialise whether there is a collision surface, with its checksum.
    pub fn keep_surface(&self, to: &mut Keeper) {
        to.count(self.surface.as_ref().map_or(0, |surface| 1 + u64::from(surface.make())));
    }

    /// Deserialise the output of [`SheetContact::keep_surface`]. A missing surface is built from
    /// the present state of the sheet, which for a new one is its state before the first step.
    pub fn take_surface(&mut self, sheet: &Sheet, from: &mut Taker) -> Taken {
        let Some(make) = from.count()?.checked_sub(1) else { return Ok(()) };
        self.prepare_surface(sheet);
        let own = self.surface.as_ref().map(|surface| u64::from(surface.make()));
        if own == Some(make) { Ok(()) } else { Err(Cut) }
    }
}
