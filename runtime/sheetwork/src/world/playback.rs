//! Playback of a frame of a recording: positions, temperatures and open cells, at rest; and
//! interpolation between two steps.

use glam::DVec3;

use crate::error::{InputError, reject_if};
use crate::sheet::temperature::playback;
use crate::sheet::{Sheet, fracture};
use crate::world::World;
use crate::world::recording::RecordedFrame;

impl World {
    /// Check whether [`World::show`] can show `frame`.
    ///
    /// # Errors
    /// When the frame belongs to other sheets or bodies, or holds values that are non-finite or out
    /// of range.
    pub fn can_show(&self, frame: &RecordedFrame) -> Result<(), InputError> {
        let bodies = self.rigid.as_deref().map_or(0, |r| r.bodies().len());
        let same = |(index, sheet): (usize, &Sheet)| {
            let (warmth, cells) = (frame.temperatures_of(index), frame.open_of(index));
            frame.sheets[index].len() == sheet.node_count()
                && warmth.values().len() == warmth.count(sheet.node_count())
                && (cells.is_empty() || sheet.open_cells().is_some_and(|own| own.len() == cells.len()))
        };
        let sheets = frame.sheets.len() == self.sheets.len() && self.sheets.iter().enumerate().all(same);
        reject_if!(!sheets || bodies != frame.bodies.len(), "frame", "is of other sheets or bodies than the scene's");
        let places = frame.sheets.iter().flatten().all(|p| p.is_finite());
        let bodies = frame.bodies.iter().all(|(p, r)| p.is_finite() && r.is_finite());
        reject_if!(!(places && bodies && frame.time.is_finite()), "frame", "holds what is not a finite number");
        frame.temperatures.iter().try_for_each(|w| w.check())
    }

    /// Set the positions of nodes (m) and bodies, the time (s), the temperatures and the open cells
    /// of `frame`, with zero velocities. For display only; [`World::reset`] starts a simulation.
    ///
    /// # Errors
    /// As [`World::can_show`]; nothing changes then.
    pub fn show(&mut self, frame: &RecordedFrame) -> Result<(), InputError> {
        self.can_show(frame)?;
        for (index, (sheet, places)) in self.sheets.iter_mut().zip(&frame.sheets).enumerate() {
            for (i, place) in places.iter().enumerate() {
                sheet.state.x.set(i, place.as_dvec3());
                sheet.state.v.set(i, DVec3::ZERO);
            }
            fracture::set_open(sheet, frame.open_of(index));
            playback::show_temperatures(sheet, frame.temperatures_of(index));
        }
        if let Some(rigid) = &mut self.rigid {
            for (index, (position, rotation)) in frame.bodies.iter().enumerate() {
                rigid.place_static(index, position.as_dvec3(), rotation.as_dquat().normalize());
            }
        }
        self.time = frame.time;
        Ok(())
    }

    /// Set positions of nodes (m) and bodies and the time (s) to the interpolation from `before` to
    /// the present state at `part`, which is between 0 and 1; other state is unchanged. For display
    /// only, as [`World::show`].
    ///
    /// # Errors
    /// As [`World::can_show`]; nothing changes then.
    pub fn show_between(&mut self, before: &RecordedFrame, part: f64) -> Result<(), InputError> {
        self.can_show(before)?;
        let part = part.clamp(0.0, 1.0);
        for (sheet, places) in self.sheets.iter_mut().zip(&before.sheets) {
            for (i, place) in places.iter().enumerate() {
                sheet.state.x.set(i, place.as_dvec3().lerp(sheet.state.x.get(i), part));
            }
        }
        if let Some(rigid) = &mut self.rigid {
            for (index, (position, rotation)) in before.bodies.iter().enumerate() {
                let Some(now) = rigid.pose(index) else { continue };
                let rotation = rotation.as_dquat().normalize().slerp(now.1, part);
                rigid.place_static(index, position.as_dvec3().lerp(now.0, part), rotation);
            }
        }
        self.time = before.time + (self.time - before.time) * part;
        Ok(())
    }
}
