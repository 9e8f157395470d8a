//! Showing a frame of a recording: everything where it was then, and still.

use glam::DVec3;

use super::World;
use crate::error::InputError;
use crate::recording::Frame;

impl World {
    /// Puts every mass (m), every body and the clock (s) where `frame` has them, at rest: to be looked at, not to be gone on from, for which
    /// [`World::reset`] is.
    ///
    /// # Errors
    /// When the frame is of other sheets or bodies, or holds what is not finite; nothing is changed then.
    pub fn show(&mut self, frame: &Frame) -> Result<(), InputError> {
        let bodies = self.rigid.as_ref().map_or(0, |r| r.bodies().len());
        let masses = frame.sheets.iter().map(Vec::len).eq(self.sheets.iter().map(|s| s.masses()));
        if !masses || bodies != frame.bodies.len() {
            return Err(InputError::new("frame", "is of other sheets or bodies than the scene's"));
        }
        let places = frame.sheets.iter().flatten().all(|p| p.is_finite());
        if !(places && frame.bodies.iter().all(|(p, r)| p.is_finite() && r.is_finite()) && frame.time.is_finite()) {
            return Err(InputError::new("frame", "holds what is not a finite number"));
        }
        for (sheet, places) in self.sheets.iter_mut().zip(&frame.sheets) {
            for (i, place) in places.iter().enumerate() {
                sheet.x.set(i, place.as_dvec3());
                sheet.v.set(i, DVec3::ZERO);
            }
        }
        if let Some(rigid) = &mut self.rigid {
            for (index, (position, rotation)) in frame.bodies.iter().enumerate() {
                rigid.show(index, position.as_dvec3(), rotation.as_dquat().normalize());
            }
        }
        self.time = frame.time;
        Ok(())
    }
}
