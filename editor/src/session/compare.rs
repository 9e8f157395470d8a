//! Comparison: variants of the scene with one field changed, simulated at the same time as the
//! edited scene.
//!
//! Each variant is a session of its own. Edits are passed on to it, except for its own field; it
//! follows the time of the main session by steps of its own length. Grabs, pins by hand and
//! recordings act on the main session only.

use std::time::Instant;

use super::state::VariantSession;
use super::{ROUNDING, Session, Variant};
use crate::samples::heights;

/// Maximum wall-clock time in which variants may reach the present time, s, and number of steps
/// between checks of that time.
const CATCH_UP_LIMIT: f64 = 2.0;
const CHECK_INTERVAL: u32 = 4;

/// Maximum number of variants.
pub const MAX_VARIANTS: usize = 3;

impl Session {
    /// Set the variants, at most [`MAX_VARIANTS`]; an empty list ends the comparison. Variants are
    /// simulated from the start to the present time or, where that takes too long, the scene is
    /// restarted with them.
    pub fn compare_with(&mut self, variants: Vec<Variant>) {
        if self.playback.is_some() {
            self.fail("a recording has no variants; open its scene for that");
            return;
        }
        let begun = variants.into_iter().take(MAX_VARIANTS);
        self.variants = begun.map(|variant| VariantSession { variant, session: Err(String::new()) }).collect();
        self.generation += 1;
        self.rebuild_variants();
        if !self.simulate_variants() && self.reset() {
            self.note(
                "The run was restarted with its variants: simulating them to the present time would take too long.",
            );
        }
    }

    /// Simulate the variants from their start to the present time. Returns false when that takes
    /// too long.
    fn simulate_variants(&mut self) -> bool {
        let (now, start) = (self.world.time(), Instant::now());
        for one in self.variants.iter_mut().filter_map(|b| b.session.as_mut().ok()) {
            while one.world.time() < now - ROUNDING * one.world.dt() {
                let soon = one.world.time() + f64::from(CHECK_INTERVAL) * one.world.dt();
                one.run_to(soon.min(now));
                if start.elapsed().as_secs_f64() > CATCH_UP_LIMIT {
                    return false;
                }
            }
        }
        true
    }

    /// Variants, each with its session or the reason why it is invalid.
    pub fn variants(&self) -> impl Iterator<Item = (&Variant, Result<&Self, &str>)> {
        self.variants.iter().map(|b| (&b.variant, b.session.as_deref().map_err(String::as_str)))
    }

    /// Session `which` of those displayed: 0 is this one, the others are its valid variants.
    pub fn shown(&self, which: usize) -> Option<&Self> {
        let Some(index) = which.checked_sub(1) else { return Some(self) };
        self.variants.iter().filter_map(|b| b.session.as_deref().ok()).nth(index)
    }

    /// Number of displayed sessions: this one and its valid variants.
    pub fn shown_count(&self) -> usize {
        1 + self.variants.iter().filter(|b| b.session.is_ok()).count()
    }

    /// Rebuild the variants from the present scene, at its start.
    pub(super) fn rebuild_variants(&mut self) {
        let mut variants = std::mem::take(&mut self.variants);
        for one in &mut variants {
            let made = one.variant.applied_to(self.scene(), self.world.sheets()).and_then(|scene| Self::new(&scene));
            one.session = made.map(Box::new).map_err(|e| e.to_string());
        }
        self.variants = variants;
    }

    /// Apply an edit of the scene to the variants.
    pub(super) fn edit_variants(&mut self) {
        if self.variants.is_empty() {
            return;
        }
        let mut variants = std::mem::take(&mut self.variants);
        for one in &mut variants {
            let scene = one.variant.applied_to(self.scene(), self.world.sheets());
            match (&mut one.session, scene) {
                (Ok(session), Ok(scene)) => _ = session.edit("", "", |s| *s = scene),
                (_, Ok(scene)) => one.session = Self::new(&scene).map(Box::new).map_err(|e| e.to_string()),
                (_, Err(error)) => one.session = Err(error.to_string()),
            }
        }
        self.variants = variants;
        self.generation += 1;
        self.advance_variants();
    }

    /// Bring the variants to the present time, each by steps of its own length; the last step may
    /// end a little later.
    pub(super) fn advance_variants(&mut self) {
        let now = self.world.time();
        for one in self.variants.iter_mut().filter_map(|b| b.session.as_mut().ok()) {
            let slack = ROUNDING * one.world.dt();
            if one.world.time() > now + slack && one.shown_from > now + slack {
                one.scrub(now);
                while one.world.time() > now + slack && one.step_back() {}
            }
            one.run_to(now);
        }
    }

    /// Height of the first probe at `time` (s), a moment of this run, m: steps of variants end at
    /// other times than those of the scene.
    pub fn height_at(&self, time: f64) -> Option<f64> {
        if (time - self.world.time()).abs() <= ROUNDING * self.world.dt() {
            return heights(&self.world).next();
        }
        self.run_state.samples.height_at(time)
    }
}
