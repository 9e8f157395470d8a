//! Forces of the last step: of every sheet with each of its partners, and on every node.
//!
//! See [`ForceKind`] and `docs/forces.md`.

use glam::DVec3;
use rapier3d::prelude::ColliderHandle;
use serde::Serialize;

use crate::sheet::{ForceKind, ForcePartner, Sheet};
use crate::world::World;

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

/// Force on a sheet in the report of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ForceReport {
    /// Name of the sheet.
    pub sheet: String,
    /// Kind of the force.
    pub kind: ForceKind,
    /// Name of the body or sheet that exerts it, or "pin N".
    pub partner: Option<String>,
    /// Mean force in the last step, N.
    pub force_n: [f64; 3],
    /// Its moment about the origin of the world, N m.
    pub moment_n_m: [f64; 3],
    /// Sum of the magnitudes of the forces of contacts or nodes, N.
    pub magnitude_n: f64,
}

impl World {
    /// Record the forces of every step from the next one on, or stop. Default: off. Results do not
    /// depend on it.
    pub fn record_forces(&mut self, records: bool) {
        self.records_forces = records;
        self.discard_unused_forces();
    }

    /// Whether the sheets record their forces, for the caller or for the contacts.
    fn needs_forces(&self) -> bool {
        self.records_forces || self.contacts.is_some()
    }

    /// Discard the records of forces that nothing needs.
    pub(super) fn discard_unused_forces(&mut self) {
        if !self.records_forces {
            self.forces.clear();
        }
        if !self.needs_forces() {
            self.sheets.iter_mut().for_each(|sheet| sheet.work.forces = None);
        }
    }

    /// Forces of the last step, sheet by sheet; empty unless [`World::record_forces`] is on. Those
    /// of a sheet add up to its change of momentum over the step. A sleeping sheet keeps the forces
    /// of its last step.
    pub fn forces(&self) -> &[ForceEntry] {
        &self.forces
    }

    /// Name of the partner of a force: a sheet or a body.
    pub fn partner_name(&self, entry: &ForceEntry) -> Option<&str> {
        let rigid = self.rigid.as_deref();
        match entry.partner {
            ForcePartner::Itself => Some(&self.sheets.get(entry.sheet)?.name),
            ForcePartner::Sheet(index) => Some(&self.sheets.get(index)?.name),
            ForcePartner::Body(index) => Some(&rigid?.bodies().get(index)?.name),
            _ => None,
        }
    }

    /// The forces of the last step with the names of their objects.
    pub fn force_reports(&self) -> Vec<ForceReport> {
        let report = |entry: &ForceEntry| {
            let pin = || if let ForcePartner::Pin(k) = entry.partner { Some(format!("pin {k}")) } else { None };
            ForceReport {
                sheet: self.sheets[entry.sheet].name.clone(),
                kind: entry.kind,
                partner: self.partner_name(entry).map(str::to_owned).or_else(pin),
                force_n: entry.force.to_array(),
                moment_n_m: entry.moment.to_array(),
                magnitude_n: entry.magnitude,
            }
        };
        self.forces.iter().map(report).collect()
    }

    /// Contact impulse of sheet number `sheet` in the last step, N s, with a collider whose body is
    /// `body`; `None` unless recorded.
    pub(super) fn contact_impulse(&self, sheet: usize, collider: ColliderHandle, body: Option<&str>) -> Option<f64> {
        let is_it = |entry: &&ForceEntry| {
            let is_body = body.is_some() && self.partner_name(entry) == body;
            let is_collider = entry.partner == ForcePartner::Collider(collider);
            entry.sheet == sheet && entry.kind == ForceKind::Contact && (is_body || is_collider)
        };
        self.forces.iter().find(is_it).map(|entry| entry.impulse.length())
    }

    /// Begin the records of a step.
    pub(super) fn begin_forces(&mut self) {
        if !self.needs_forces() {
            return;
        }
        for sheet in &mut self.sheets {
            let mut forces = sheet.work.forces.take().unwrap_or_default();
            forces.begin(sheet);
            sheet.work.forces = Some(forces);
        }
    }

    /// End the records of a step of `dt` (s) and list them.
    pub(super) fn finish_forces(&mut self, dt: f64) {
        if !self.needs_forces() {
            return;
        }
        let listed = self.records_forces;
        let field = self.field();
        self.forces.clear();
        for (index, sheet) in self.sheets.iter_mut().enumerate() {
            crate::sheet::forces::with_record(sheet, |forces, sheet: &mut Sheet| {
                forces.finish(sheet, &field, dt);
                let per_time = 1.0 / forces.dt;
                self.forces.extend(forces.pairs.iter().filter(|_| listed).map(|pair| ForceEntry {
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
