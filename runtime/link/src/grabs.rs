//! Grabs of sheets by number, with automatic release.

use std::time::{Duration, Instant};

use glam::DVec3;

use sheetwork::{InputError, World};

/// Time without a move after which a grab is released, because its client has gone or was stopped.
const GRAB_TIMEOUT: Duration = Duration::from_secs(2);

struct HeldGrab {
    number: u64,
    sheet: String,
    /// Index among the sheet's pulls.
    index: usize,
    moved: Instant,
}

/// All grabs of a link.
#[derive(Default)]
pub struct Grabs {
    list: Vec<HeldGrab>,
    last: u64,
}

impl Grabs {
    /// Grabs a point and returns the number of the grab and the point's position, m.
    pub fn grab(
        &mut self,
        world: &mut World,
        name: &str,
        uv: (f64, f64),
        stiffness: f64,
    ) -> Result<(u64, DVec3), InputError> {
        let sheet = world.sheet_mut(name).ok_or_else(|| InputError::new("sheet", format!("there is no \"{name}\"")))?;
        let index = sheet.grab(uv, stiffness)?;
        let place = sheet.pulls().get(index).map_or(DVec3::ZERO, |p| p.target);
        self.last += 1;
        self.list.push(HeldGrab { number: self.last, sheet: name.to_owned(), index, moved: Instant::now() });
        Ok((self.last, place))
    }

    /// Moves the hand and returns the force on it (N) and the point's position, m.
    pub fn pull(&mut self, world: &mut World, number: u64, target: DVec3) -> Result<(DVec3, DVec3), InputError> {
        let gone = || InputError::new("grab", format!("{number} holds nothing any more"));
        let grab = self.list.iter_mut().find(|g| g.number == number).ok_or_else(gone)?;
        let sheet = world.sheet_mut(&grab.sheet).filter(|s| grab.index < s.pulls().len()).ok_or_else(gone)?;
        sheet.pull(grab.index, target)?;
        grab.moved = Instant::now();
        let pull = sheet.pulls()[grab.index];
        Ok((-pull.force(&sheet.state.x), pull.point(&sheet.state.x)))
    }

    /// Releases a grab; false for an unknown number.
    pub fn release(&mut self, world: &mut World, number: u64) -> bool {
        let Some(at) = self.list.iter().position(|g| g.number == number) else { return false };
        let grab = self.list.remove(at);
        for other in self.list.iter_mut().filter(|g| g.sheet == grab.sheet && g.index > grab.index) {
            other.index -= 1;
        }
        world.sheet_mut(&grab.sheet).is_some_and(|s| s.release_grab(grab.index))
    }

    /// Releases grabs without a recent move.
    #[inline]
    pub fn expire(&mut self, world: &mut World) {
        if self.list.is_empty() {
            return;
        }
        let late: Vec<u64> = self.list.iter().filter(|g| g.moved.elapsed() > GRAB_TIMEOUT).map(|g| g.number).collect();
        for number in late {
            self.release(world, number);
        }
    }

    /// Releases all grabs.
    pub fn clear(&mut self, world: &mut World) {
        while let Some(number) = self.list.last().map(|g| g.number) {
            self.release(world, number);
        }
    }

    /// Discards all grabs without a release, after a replacement of the sheets.
    pub fn forget(&mut self) {
        self.list.clear();
    }
}
