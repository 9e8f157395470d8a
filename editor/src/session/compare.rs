//! Comparing: the same scene with one field different, beside the one that is edited and in step with it.
//!
//! Each variant is a session of its own. What is edited here is passed on to it, but for its own field; it goes where this one goes in time, by
//! steps of its own length. Nothing is pulled, pinned by hand or recorded there.

use std::time::Instant;

use super::state::Beside;
use super::{ROUNDING, Session, Variant};
use crate::samples::heights;

/// Wall-clock time that variants may take to come to the present moment, s, and after how many steps it is looked at.
const PATIENCE: f64 = 2.0;
const STRIDE: u32 = 4;

/// Most variants beside the scene.
pub const MOST_BESIDE: usize = 3;

impl Session {
    /// Compares with these variants, at most [`MOST_BESIDE`]; with none it is alone again. They are taken from the start to the present moment, or, where
    /// that would take long, the scene begins again with them.
    pub fn compare_with(&mut self, variants: Vec<Variant>) {
        if self.playback.is_some() {
            self.fail("a recording is compared with nothing; open its scene for that");
            return;
        }
        let begun = variants.into_iter().take(MOST_BESIDE);
        self.beside = begun.map(|variant| Beside { variant, session: Err(String::new()) }).collect();
        self.generation += 1;
        self.begin_beside();
        if !self.catch_up() && self.reset() {
            self.note("The run began again, with its variants: to take them to where it was would take too long.");
        }
    }

    /// Takes the variants from their start to the present moment; false when that took too long.
    fn catch_up(&mut self) -> bool {
        let (now, start) = (self.world.time(), Instant::now());
        for one in self.beside.iter_mut().filter_map(|b| b.session.as_mut().ok()) {
            while one.world.time() < now - ROUNDING * one.world.dt() {
                let soon = one.world.time() + f64::from(STRIDE) * one.world.dt();
                one.run_to(soon.min(now));
                if start.elapsed().as_secs_f64() > PATIENCE {
                    return false;
                }
            }
        }
        true
    }

    /// The variants, each with its session or why there is none.
    pub fn beside(&self) -> impl Iterator<Item = (&Variant, Result<&Self, &str>)> {
        self.beside.iter().map(|b| (&b.variant, b.session.as_deref().map_err(String::as_str)))
    }

    /// Session number `which` of those that are shown: 0 is this one, the others are its variants that could be made.
    pub fn shown(&self, which: usize) -> Option<&Self> {
        let Some(index) = which.checked_sub(1) else { return Some(self) };
        self.beside.iter().filter_map(|b| b.session.as_deref().ok()).nth(index)
    }

    /// How many are shown: this one and its variants that could be made.
    pub fn shown_count(&self) -> usize {
        1 + self.beside.iter().filter(|b| b.session.is_ok()).count()
    }

    /// Makes the variants anew from the present scene, at its start.
    pub(super) fn begin_beside(&mut self) {
        let mut beside = std::mem::take(&mut self.beside);
        for one in &mut beside {
            let made = one.variant.of(self.scene(), self.world.sheets()).and_then(|scene| Self::new(&scene));
            one.session = made.map(Box::new).map_err(|e| e.to_string());
        }
        self.beside = beside;
    }

    /// Passes an edit of the scene on.
    pub(super) fn pass_on(&mut self) {
        if self.beside.is_empty() {
            return;
        }
        let mut beside = std::mem::take(&mut self.beside);
        for one in &mut beside {
            let scene = one.variant.of(self.scene(), self.world.sheets());
            match (&mut one.session, scene) {
                (Ok(session), Ok(scene)) => _ = session.edit("", "", |s| *s = scene),
                (_, Ok(scene)) => one.session = Self::new(&scene).map(Box::new).map_err(|e| e.to_string()),
                (_, Err(error)) => one.session = Err(error.to_string()),
            }
        }
        self.beside = beside;
        self.generation += 1;
        self.lead();
    }

    /// Brings the variants to the present time, each by steps of its own: its last may end a little later.
    pub(super) fn lead(&mut self) {
        let now = self.world.time();
        for one in self.beside.iter_mut().filter_map(|b| b.session.as_mut().ok()) {
            let slack = ROUNDING * one.world.dt();
            if one.world.time() > now + slack && one.shown_from > now + slack {
                one.scrub(now);
                while one.world.time() > now + slack && one.step_back() {}
            }
            one.run_to(now);
        }
    }

    /// Height of the first probe at `time` (s), a moment of this run, m: steps of variants end at other moments than those of the scene.
    pub fn height_at(&self, time: f64) -> Option<f64> {
        if (time - self.world.time()).abs() <= ROUNDING * self.world.dt() {
            return heights(&self.world).next();
        }
        self.samples.height_at(time)
    }
}
