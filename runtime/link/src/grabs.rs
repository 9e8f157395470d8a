//! Who holds a sheet: grabs by number, which let go when nobody moves them any more.

use std::time::{Duration, Instant};

use glam::DVec3;

use sheetwork::{InputError, World};

/// A grab that is not moved for so long lets go: its client has gone, or was stopped.
const PATIENCE: Duration = Duration::from_secs(2);

struct Grab {
    number: u64,
    sheet: String,
    /// Which of the sheet's pulls it is.
    index: usize,
    moved: Instant,
}

/// All grabs of a link.
#[derive(Default)]
pub struct Grabs {
    list: Vec<Grab>,
    last: u64,
}

impl Grabs {
    /// Takes hold; the number of the grab and where the point is, m.
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
        self.list.push(Grab { number: self.last, sheet: name.to_owned(), index, moved: Instant::now() });
        Ok((self.last, place))
    }

    /// Moves the hand; the force it feels (N) and where the point is, m.
    pub fn pull(&mut self, world: &mut World, number: u64, target: DVec3) -> Result<(DVec3, DVec3), InputError> {
        let gone = || InputError::new("grab", format!("{number} holds nothing any more"));
        let grab = self.list.iter_mut().find(|g| g.number == number).ok_or_else(gone)?;
        let sheet = world.sheet_mut(&grab.sheet).filter(|s| grab.index < s.pulls().len()).ok_or_else(gone)?;
        sheet.pull(grab.index, target)?;
        grab.moved = Instant::now();
        let pull = sheet.pulls()[grab.index];
        Ok((-pull.force(&sheet.x), pull.point(&sheet.x)))
    }

    /// Lets go; false where it held nothing.
    pub fn release(&mut self, world: &mut World, number: u64) -> bool {
        let Some(at) = self.list.iter().position(|g| g.number == number) else { return false };
        let grab = self.list.remove(at);
        for other in self.list.iter_mut().filter(|g| g.sheet == grab.sheet && g.index > grab.index) {
            other.index -= 1;
        }
        world.sheet_mut(&grab.sheet).is_some_and(|s| s.let_go(grab.index))
    }

    /// Lets go of what nobody has moved for a while.
    #[inline]
    pub fn expire(&mut self, world: &mut World) {
        if self.list.is_empty() {
            return;
        }
        let late: Vec<u64> = self.list.iter().filter(|g| g.moved.elapsed() > PATIENCE).map(|g| g.number).collect();
        for number in late {
            self.release(world, number);
        }
    }

    /// Lets go of everything.
    pub fn clear(&mut self, world: &mut World) {
        while let Some(number) = self.list.last().map(|g| g.number) {
            self.release(world, number);
        }
    }

    /// Forgets everything: the sheets are others now.
    pub fn forget(&mut self) {
        self.list.clear();
    }
}
