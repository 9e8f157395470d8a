//! Edits by hand on a sheet: creases, slits, and painted heat.
//!
//! Creases and slits are fields of the scene. Painted heat acts on the present state and is stored
//! as spots of the scene, which a reset applies again; undo restores the state before the stroke.

use sheetwork::mesh::slits::Slit;
use sheetwork::scene::{CreaseSpec, SpotSpec};

use super::Session;
use super::state::HeatStroke;

impl Session {
    /// Crease sheet `sheet` along a line by `angle` degrees. A rejection becomes a message. Returns
    /// whether the edit was accepted.
    pub fn crease(&mut self, sheet: usize, (from, to): Slit, angle: f64) -> bool {
        if is_short(from, to) {
            return false;
        }
        let made = self.edit_sheet(sheet, "crease", &format!("crease {sheet}"), |spec| {
            spec.creases.push(CreaseSpec { from, to, angle });
        });
        self.seal();
        made
    }

    /// Open the cells of sheet `sheet` along a line. A rejection becomes a message. Returns whether
    /// the edit was accepted.
    pub fn cut(&mut self, sheet: usize, line: Slit) -> bool {
        if is_short(line.0, line.1) {
            return false;
        }
        let cut = self.edit_sheet(sheet, "cut", &format!("cut {sheet}"), |spec| spec.slits.push(line));
        self.seal();
        cut
    }

    /// Start to paint heat on sheet `sheet`. An error becomes a message. Returns whether painting
    /// is possible.
    pub fn begin_stroke(&mut self, sheet: usize) -> bool {
        self.end_stroke();
        if self.playback.is_some() {
            self.fail("a recording cannot be painted on; open its scene for that");
            return false;
        }
        // Temperatures are created before the snapshot for undo.
        let heated = self.world.heat_spots(sheet, &[]);
        let is_possible = self.accept(heated).unwrap_or(false);
        if is_possible {
            self.run_state.stroke = Some(HeatStroke { sheet, before: self.world.snapshot(), spots: Vec::new() });
        }
        is_possible
    }

    /// Heat a spot of the sheet of the present stroke. A rejection becomes a message. Returns
    /// whether the spot was accepted.
    pub fn dab(&mut self, spot: SpotSpec) -> bool {
        let Some(mut stroke) = self.run_state.stroke.take() else { return false };
        let done = self.world.heat_spots(stroke.sheet, &[spot]);
        if done.is_ok() {
            stroke.spots.push(spot);
            for other in self.variants.iter_mut().filter_map(|b| b.session.as_mut().ok()) {
                // A variant without this sheet is unchanged.
                let _ = other.world.heat_spots(stroke.sheet, &[spot]);
                other.revision += 1;
            }
        }
        self.run_state.stroke = Some(stroke);
        self.revision += 1;
        self.accept(done).is_some()
    }

    /// End the stroke, as one undo step.
    pub fn end_stroke(&mut self) {
        let Some(stroke) = self.run_state.stroke.take().filter(|s| !s.spots.is_empty()) else { return };
        let mut scene = self.scene().clone();
        let Some(spec) = scene.sheets.get_mut(stroke.sheet) else { return };
        spec.spots.extend(stroke.spots);
        self.document.seal();
        self.document.commit_with("painted heat", "paint", scene, stroke.before);
        self.document.seal();
        self.run_state.timeline.replace_present(&self.world);
    }
}

/// Whether a line is too short to be intended.
fn is_short(from: (f64, f64), to: (f64, f64)) -> bool {
    (to.0 - from.0).hypot(to.1 - from.1) < 1e-3
}
