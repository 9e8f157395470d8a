//! Forces of the last step: of every sheet with each of its partners, and on every node.
//!
//! See [`ForceKind`] and `docs/forces.md`.

use glam::DVec3;

use crate::math::Vectors;
use crate::sheet::{ForceKind, ForcePartner, Sheet};
use crate::world::{SheetId, World};

/// Mean force of one kind on a sheet in the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ForceEntry {
    /// Index of the sheet in [`World::sheets`].
    pub sheet: usize,
    /// Kind of the force.
    pub kind: ForceKind,
    /// Partner that exerts it. The force on the partner is the opposite one.
    pub partner: ForcePartner,
    /// Force on the sheet, N.
    pub force: DVec3,
    /// Moment of the force about the origin of the world, N m.
    pub moment: DVec3,
    /// Sum of the magnitudes of the forces of contacts or nodes, N; at least the length of `force`.
    pub magnitude: f64,
    /// Impulse on the sheet in the step, N s.
    pub impulse: DVec3,
}

impl World {
    /// Record the forces of every step from the next one on, or stop. Default: off. Results do not
    /// depend on it.
    pub fn record_forces(&mut self, records: bool) {
        self.records_forces = records;
        self.forces.clear();
        if !records {
            self.sheets.iter_mut().for_each(|sheet| sheet.work.forces = None);
        }
    }

    /// Whether forces are recorded.
    pub fn records_forces(&self) -> bool {
        self.records_forces
    }

    /// Forces of the last step, sheet by sheet; empty unless [`World::record_forces`] is on. Those
    /// of a sheet add up to its change of momentum over the step. A sleeping sheet keeps the forces
    /// of its last step.
    pub fn forces(&self) -> &[ForceEntry] {
        &self.forces
    }

    /// Mean contact force on each node of a sheet in the last step, N; `None` unless recorded.
    pub fn contact_forces(&self, id: SheetId) -> Option<&Vectors> {
        Some(&self.get_sheet(id)?.work.forces.as_ref()?.contact)
    }

    /// Mean force of the pins on each node of a sheet in the last step, N; `None` unless recorded.
    pub fn pin_forces(&self, id: SheetId) -> Option<&Vectors> {
        Some(&self.get_sheet(id)?.work.forces.as_ref()?.pins)
    }

    /// Name of the partner of a force: a sheet or a body.
    pub fn partner_name(&self, entry: &ForceEntry) -> Option<&str> {
        let rigid = self.rigid.as_ref();
        match entry.partner {
            ForcePartner::Itself => Some(&self.sheets.get(entry.sheet)?.name),
            ForcePartner::Sheet(index) => Some(&self.sheets.get(index)?.name),
            ForcePartner::Body(index) => Some(&rigid?.bodies().get(index)?.name),
            _ => None,
        }
    }

    /// Begin the records of a step.
    pub(super) fn begin_forces(&mut self) {
        for sheet in self.sheets.iter_mut().filter(|_| self.records_forces) {
            let mut forces = sheet.work.forces.take().unwrap_or_default();
            forces.begin(sheet);
            sheet.work.forces = Some(forces);
        }
    }

    /// End the records of a step of `dt` (s) and list them.
    pub(super) fn finish_forces(&mut self, dt: f64) {
        if !self.records_forces {
            return;
        }
        let field = self.field();
        self.forces.clear();
        for (index, sheet) in self.sheets.iter_mut().enumerate() {
            crate::sheet::forces::with_record(sheet, |forces, sheet: &mut Sheet| {
                forces.finish(sheet, &field, dt);
                let per_time = 1.0 / forces.dt;
                self.forces.extend(forces.pairs.iter().map(|pair| ForceEntry {
                    sheet: index,
                    kind: pair.kind,
                    partner: pair.partner,
                    force: pair.impulse * per_time,
                    moment: pair.moment * per_time,
                    magnitude: pair.magnitude * per_time,
                    impulse: pair.impulse,
                }));
            });
        }
    }
}
