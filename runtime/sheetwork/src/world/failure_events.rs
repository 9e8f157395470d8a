//! Sheets that give way: looked for after every step, and told of as events. Tearing: `sheet/tears`; buckling: `sheet/buckle`.

use crate::islands::event::{Event, EventKind};
use crate::sheet::Status;
use crate::world::World;

impl World {
    /// Looks whether sheets open, after motion and heat.
    pub(crate) fn tear_sheets(&mut self) {
        let mut changed = false;
        for index in 0..self.sheets.len() {
            let sheet = &mut self.sheets[index];
            if !sheet.can_open() || sheet.status != Status::Awake {
                continue;
            }
            let before = sheet.opening_revision();
            let opening = sheet.tear();
            changed |= sheet.opening_revision() != before;
            if opening.is_some() {
                let event = Event::new(self.time, EventKind::Torn, &sheet.name, None);
                self.events.push(Event { place_m: opening.map(|o| o.place_m), opening, ..event });
            }
        }
        if let Some(heat) = self.heat.as_mut().filter(|_| changed) {
            heat.forget();
        }
    }

    /// Looks for sheets that buckle, after every step from now on, or no longer: an [`EventKind::Buckled`] for each time, with place and
    /// energy. Costs an evaluation of forces and energy a step of every sheet that moves.
    pub fn watch_buckling(&mut self, watch: bool) {
        self.buckling = watch;
        self.sheets.iter_mut().for_each(|s| s.watch_buckling(watch));
    }

    /// Whether it looks for sheets that buckle.
    pub fn watches_buckling(&self) -> bool {
        self.buckling
    }

    pub(crate) fn look_for_buckling(&mut self, from: f64) {
        if !self.buckling {
            return;
        }
        for sheet in &mut self.sheets {
            // One that came in since is watched from here on.
            sheet.watch_buckling(true);
            if let Some(buckle) = sheet.look_for_buckling(from) {
                let event = Event::new(buckle.time, EventKind::Buckled, &sheet.name, None);
                let (place_m, energy_j) = (Some(buckle.place.to_array()), Some(buckle.energy));
                self.events.push(Event { place_m, energy_j, ..event });
            }
        }
    }
}
