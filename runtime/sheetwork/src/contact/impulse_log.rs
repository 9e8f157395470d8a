//! Log of the impulses of contact in a step, for the record of forces ([`crate::sheet::forces`]).
//!
//! A contact with the force p (N) of the velocity solve changes the velocities of its two sides in
//! a stage of weight h (s) by the impulse h p. A substep that is rolled back loses its impulses.

use glam::DVec3;

use crate::collision::constraint::{ContactSide, SheetPoint};
use crate::contact::IslandView;
use crate::contact::workspace::ContactWorkspace;
use crate::sheet::ForceKind;

/// Impulse between two sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoggedImpulse {
    pub kind: ForceKind,
    /// Sides a and b; the same one twice for a numerical impulse.
    pub sides: [ContactSide; 2],
    /// Impulse on side a, N s.
    pub impulse: DVec3,
    /// Place of each side that is on a sheet, m.
    pub places: [DVec3; 2],
    /// Unit normal from side b to side a; zero for a numerical impulse.
    pub normal: DVec3,
}

/// Impulses of an island in a step.
#[derive(Default)]
pub(crate) struct ImpulseLog {
    pub is_recording: bool,
    /// Impulses of the step so far.
    pub list: Vec<LoggedImpulse>,
    /// Contact, and its force in the last velocity solve of the stage, N, world axes, on side a.
    stage: Vec<(u32, DVec3)>,
    /// Length of the list at the start of the substep.
    substep: usize,
}

impl ImpulseLog {
    /// Begin a step; `is_recording` says whether any sheet of the island records forces.
    pub fn begin_step(&mut self, is_recording: bool) {
        self.is_recording = is_recording;
        self.list.clear();
        self.stage.clear();
        self.substep = 0;
    }

    /// Begin a substep.
    pub fn begin_substep(&mut self) {
        self.substep = self.list.len();
    }

    /// Remove the impulses of the substep.
    pub fn roll_back(&mut self) {
        self.list.truncate(self.substep);
    }

    /// Replace the forces of the stage.
    pub fn set_stage_forces(&mut self, forces: impl Iterator<Item = (u32, DVec3)>) {
        self.stage.clear();
        if self.is_recording {
            self.stage.extend(forces.filter(|(_, force)| *force != DVec3::ZERO));
        }
    }

    /// Add the momentum of every sheet, multiplied by `sign`, as a numerical impulse: once before
    /// and once after a change without forces.
    pub fn add_momenta(&mut self, island: &IslandView, sign: f64) {
        for (number, sheet) in (0..).zip(island.sheets.iter()).filter(|_| self.is_recording) {
            let side = ContactSide::Sheet { sheet: number, point: SheetPoint::default() };
            let impulse = sheet.momentum() * sign;
            self.list.push(LoggedImpulse {
                kind: ForceKind::Numerical,
                sides: [side; 2],
                impulse,
                places: [sheet.centre_of_mass(); 2],
                normal: DVec3::ZERO,
            });
        }
    }
}

impl ContactWorkspace {
    /// Add the impulses of a stage of weight `h` (s) to the log, once the sheets are at its end.
    pub(crate) fn log_stage_impulses(&mut self, island: &IslandView, h: f64) {
        let ImpulseLog { list, stage, .. } = &mut self.impulses;
        for (i, force) in stage.drain(..) {
            let contact = &self.detected.contacts[i as usize];
            let is_attachment = i as usize >= self.detected.first_attachment;
            let place = |side: &ContactSide| match side {
                ContactSide::Sheet { sheet, point } => point.position(&island.sheet(*sheet).state.x),
                ContactSide::Body { .. } => DVec3::ZERO,
            };
            list.push(LoggedImpulse {
                kind: if is_attachment { ForceKind::Attachment } else { ForceKind::Contact },
                sides: [contact.a, contact.b],
                impulse: force * h,
                places: [place(&contact.a), place(&contact.b)],
                normal: contact.normal,
            });
        }
    }
}
