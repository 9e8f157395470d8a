//! A sheet as contact sees it at the end of a step that its engine has taken by itself, as explicit ones do.
//!
//! The engine has taken the masses from (x₀, v₀) to (x₁, v₁), which is their free motion. To a force p (N) that contact adds in a
//! step of h (s) they answer as H = M/h² says, each for itself: Δx = h² p/m, Δv = h p/m. A half solution (see
//! [`HalfSolutions`]) is then √m⁻¹ h p at the masses it is for.

use glam::DVec3;

use crate::integrators::implicit::staged::Jump;
use crate::linear::{HalfSolutions, Loads};
use crate::math::Vectors;
use crate::sheet::Sheet;

impl Sheet {
    /// Whether its engine is an explicit one.
    pub(crate) fn is_explicit(&self) -> bool {
        !self.engine_kind.info().implicit
    }

    /// Whether its masses answer contact each for itself: of an explicit engine, and of an implicit one that met such a sheet.
    pub(crate) fn answers_by_mass(&self) -> bool {
        self.work.stage.by_mass || self.is_explicit()
    }

    /// Distance from the masses at which the sheet is touched, m: half the thickness of one layer that follows its material.
    pub fn contact_offset(&self) -> f64 {
        let has_thickness = self.layers.len() <= 1 && self.follows_material();
        if has_thickness { 0.5 * self.material().thickness } else { crate::contact::SKIN }
    }

    /// Corners of the box around its surface, m.
    pub(crate) fn box_around(&self) -> (DVec3, DVec3) {
        let (low, high) = self.x.bounds().unwrap_or_default();
        let offset = self.contact_offset();
        (low - offset, high + offset)
    }

    /// The same, of a sheet that moves.
    pub(crate) fn surroundings(&mut self) -> (DVec3, DVec3) {
        self.work.resting = None;
        self.box_around()
    }

    /// The same of a sheet that does not move: looked for once. One that somebody has put elsewhere is looked at again.
    pub(crate) fn resting_box(&mut self) -> (DVec3, DVec3) {
        let end = |i: Option<usize>| i.filter(|i| *i < self.masses()).map(|i| self.x.get(i));
        let ends = (end(Some(0)), end(self.masses().checked_sub(1)));
        if let Some((known, around)) = &self.work.resting
            && *known == ends
        {
            return *around;
        }
        let around = self.surroundings();
        self.work.resting = Some((ends, around));
        around
    }

    /// Keeps where a step begins.
    pub(crate) fn keep_start(&mut self) {
        let (x, v) = &mut self.work.start;
        x.clone_from(&self.x);
        v.clone_from(&self.v);
    }

    /// Exchanges its state with that at the start of the engine's step.
    pub(crate) fn swap_before(&mut self) {
        std::mem::swap(&mut self.x, &mut self.work.x_before);
        std::mem::swap(&mut self.v, &mut self.work.v_before);
    }

    /// Makes the state that a step of `dt` (s) has come to the free motion of a stage from where the step began.
    pub(crate) fn begin_contact(&mut self, dt: f64) {
        let Self { work, x, v, .. } = self;
        let stage = &mut work.stage;
        (stage.length, stage.h, stage.done, stage.failed, stage.by_mass) = (dt, dt, false, false, true);
        stage.free.clone_from(x);
        stage.velocity.clone_from(v);
        self.go_to_start();
    }

    /// Goes back to where the step began.
    pub(crate) fn go_to_start(&mut self) {
        let Self { work, x, v, .. } = self;
        x.clone_from(&work.start.0);
        v.clone_from(&work.start.1);
    }

    /// Takes the start of the step for what was before.
    pub(crate) fn take_start_for_before(&mut self) {
        let Self { work, .. } = self;
        work.x_before.clone_from(&work.start.0);
        work.v_before.clone_from(&work.start.1);
    }

    /// Where the step began, m.
    pub(crate) fn start_positions(&self) -> &Vectors {
        &self.work.start.0
    }

    /// Goes back to the free motion, with what contact did to it.
    pub(crate) fn end_contact(&mut self, jump: Option<&Jump>) {
        let Self { work, x, v, .. } = self;
        x.clone_from(&work.stage.free);
        v.clone_from(&work.stage.velocity);
        if let Some(jump) = jump {
            x.add_scaled(1.0, &jump.dx);
            v.add_scaled(1.0, &jump.dv);
        }
    }

    /// Furthest that a mass goes in the stage, m.
    pub(crate) fn travel(&self) -> f64 {
        let pairs = self.x.iter().zip(self.work.stage.free.iter());
        pairs.map(|(p, q)| p.distance_squared(q)).fold(0.0, f64::max).sqrt()
    }

    /// Mass `i` as a block row, and which of its directions are free (1) or held (0); none for a mass that is held in all.
    pub(crate) fn free_mass(&self, i: u32) -> Option<(u32, DVec3)> {
        let is_free = self.inverse_mass.get(i as usize).is_some_and(|w| *w > 0.0);
        is_free.then(|| (i, self.pins.free_axes(i)))
    }

    /// Adds the half solutions of `loads`, given by mass.
    pub(crate) fn half_solve_masses(&self, loads: &Loads, solutions: &mut HalfSolutions) {
        for load in loads.iter() {
            let mut last = None;
            let after = |last: Option<u32>| load.iter().map(|e| e.0).filter(|m| last.is_none_or(|l| *m > l)).min();
            while let Some(mass) = after(last) {
                let here = load.iter().filter(|e| e.0 == mass);
                let sum: DVec3 = here.map(|e| DVec3::from_array(e.1)).sum();
                let scale = self.work.stage.h * self.inverse_mass[mass as usize].sqrt();
                solutions.add_segment(3 * mass as usize, &(sum * scale).to_array());
                last = Some(mass);
            }
            solutions.close();
        }
    }

    /// The displacement (m) of the masses that `force` (N) makes.
    pub(crate) fn answer_masses(&self, force: &Vectors, dx: &mut Vectors) {
        let square = self.work.stage.h * self.work.stage.h;
        for (i, w) in self.inverse_mass.iter().enumerate() {
            dx.set(i, force.get(i) * (square * w));
        }
        for (mass, _) in self.pins.rails() {
            let i = mass as usize;
            dx.set(i, dx.get(i) * self.pins.free_axes(mass));
        }
    }
}
