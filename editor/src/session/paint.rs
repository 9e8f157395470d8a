//! Work with a hand on a sheet that becomes part of the scene: creases, slits, and warmth painted on.
//!
//! Creases and slits are fields of the scene, and the world follows. Warmth is put on the sheet as it is now and kept as spots of the scene, so that it is
//! there again after a reset; undo brings the world back to the moment before the stroke.

use sheetwork::mesh::slits::Slit;
use sheetwork::scene::{CreaseSpec, SpotSpec};

use super::Session;
use super::state::Stroke;

impl Session {
    /// Folds sheet `sheet` along a line in it by `angle` degrees. Returns whether it was taken; a refusal becomes a message.
    pub fn crease(&mut self, sheet: usize, (from, to): Slit, angle: f64) -> bool {
        if is_short(from, to) {
            return false;
        }
        let made = self.edit("crease", &format!("crease {sheet}"), |scene| {
            if let Some(spec) = scene.sheets.get_mut(sheet) {
                spec.creases.push(CreaseSpec { from, to, angle });
            }
        });
        self.seal();
        made
    }

    /// Opens the cells of sheet `sheet` along a line in it. Returns whether it was taken; a refusal becomes a message.
    pub fn cut(&mut self, sheet: usize, line: Slit) -> bool {
        if is_short(line.0, line.1) {
            return false;
        }
        let cut = self.edit("cut", &format!("cut {sheet}"), |scene| {
            if let Some(spec) = scene.sheets.get_mut(sheet) {
                spec.slits.push(line);
            }
        });
        self.seal();
        cut
    }

    /// Begins to paint warmth on sheet `sheet`. Returns whether that can be done; why not becomes a message.
    pub fn begin_stroke(&mut self, sheet: usize) -> bool {
        self.end_stroke();
        if self.playback.is_some() {
            self.fail("a recording cannot be painted on; open its scene for that");
            return false;
        }
        // It begins to have temperatures before what is gone back to is kept.
        match self.world.warm(sheet, &[]) {
            Ok(true) => {
                let before = self.world.snapshot();
                self.stroke = Some(Stroke { sheet, before, spots: Vec::new() });
                true
            }
            Ok(false) => false,
            Err(error) => {
                self.fail(error.to_string());
                false
            }
        }
    }

    /// Puts a spot on the sheet whose stroke has begun. Returns whether it was taken; a refusal becomes a message.
    pub fn dab(&mut self, spot: SpotSpec) -> bool {
        let Some(mut stroke) = self.stroke.take() else { return false };
        let done = self.world.warm(stroke.sheet, &[spot]);
        if done.is_ok() {
            stroke.spots.push(spot);
            for other in self.beside.iter_mut().filter_map(|b| b.session_mut()) {
                // One that has no such sheet is not warmed.
                let _ = other.world.warm(stroke.sheet, &[spot]);
                other.revision += 1;
            }
        }
        self.stroke = Some(stroke);
        self.revision += 1;
        if let Err(error) = &done {
            self.fail(error.to_string());
        }
        done.is_ok()
    }

    /// Whether a stroke is being painted.
    pub fn is_painting(&self) -> bool {
        self.stroke.is_some()
    }

    /// Ends the stroke: it is one step of undo.
    pub fn end_stroke(&mut self) {
        let Some(stroke) = self.stroke.take().filter(|s| !s.spots.is_empty()) else { return };
        let mut scene = self.scene().clone();
        let Some(spec) = scene.sheets.get_mut(stroke.sheet) else { return };
        spec.spots.extend(stroke.spots);
        self.document.seal();
        self.document.commit_with("painted warmth", "paint", scene, stroke.before);
        self.document.seal();
        self.timeline.renew(&self.world);
    }
}

/// Whether a line is too short to be meant.
fn is_short(from: (f64, f64), to: (f64, f64)) -> bool {
    (to.0 - from.0).hypot(to.1 - from.1) < 1e-3
}
