//! Change of the grid of a sheet: state transfer to a refined or coarsened grid.
//!
//! The sheet is built from its description on the other grid and then takes over the state of the
//! old one:
//!
//! - positions and velocities by splines through the nodes (`spline`), corrected to the strains and
//!   rates of strain of the old grid (`strain`); prescribed nodes have their prescribed positions;
//! - momentum and angular momentum of a free sheet, and a kinetic energy of at most the old one
//!   minus the gain of elastic energy;
//! - temperatures of each half of the thickness, and their means;
//! - inelastic strains and thermal expansion of the elements ([`crate::elements::remap`]);
//! - applied forces, distributed to the nodes of their cell by the lever rule; grabs; parameters.
//!
//! The integrator restarts, and the contact cache is discarded.

pub(crate) mod apex;
pub(crate) mod attachments;
pub(crate) mod clamp_springs;
pub(crate) mod lattice;
pub(crate) mod layer_offsets;
pub(crate) mod loads;
pub(crate) mod membrane;
pub(crate) mod motion;
pub(crate) mod outline;
pub(crate) mod patch;
pub(crate) mod row_interpolation;
pub(crate) mod spline;
pub(crate) mod springs;
pub(crate) mod strain;

use crate::elements::remap::{GridRemap, MeshRemap, Remap};
use crate::error::InputError;
use crate::scene::{Region, SheetSpec};
use crate::sheet::remap::layer_offsets::LatticeLayout;
use crate::sheet::{RecoveryState, Sheet, Status};
use crate::units::temperature::REFERENCE;

/// Iterations for the largest frequency, which give an accuracy of a few percent.
const FREQUENCY_ITERATIONS: usize = 60;
/// Stability limit hω of every explicit integrator with damping.
const STABILITY_LIMIT: f64 = 1.0;
/// Minimum length of a substep, s.
const MIN_SUBSTEP: f64 = 1e-9;

impl Sheet {
    /// Check that the grid can change; `spec` is the description of the sheet.
    pub(crate) fn check_grid_change(&self, spec: &SheetSpec) -> Result<(), InputError> {
        let refused = |problem: &str| Err(InputError::new("grid", problem.to_owned()));
        if spec.file.is_some() {
            return refused("cannot change: the sheet is of a file, which has its masses");
        }
        if spec.sticky {
            return refused("cannot change: the sheet is sticky, and what it sticks by are its masses");
        }
        if self.open_count() > 0 {
            return refused("cannot change: cells of the sheet are open, which another grid does not have");
        }
        if spec.pins.iter().any(|p| p.body.is_some()) {
            return refused("cannot change: the sheet is glued to a body by its masses");
        }
        let by_number = |r: &Region| matches!(r, Region::Masses(_));
        if spec.pins.iter().any(|p| by_number(&p.region)) {
            return refused("cannot change: the sheet is pinned at masses by number");
        }
        if matches!(self.status, Status::Unstable { .. }) {
            return refused("cannot change: the sheet went unstable");
        }
        Ok(())
    }

    /// Take over the state of `old`, the same sheet on another grid, at `time` (s). This sheet must
    /// be as built; `tolerance` is that of an adaptive integrator, m.
    ///
    /// # Errors
    /// When a pin at a single node would prescribe another material point.
    pub(crate) fn take_state_from(
        &mut self,
        old: &Self,
        spec: &SheetSpec,
        time: f64,
        tolerance: f64,
    ) -> Result<(), InputError> {
        self.check_points(old, spec)?;
        let (from, to) = (old.meshes.present.clone(), self.meshes.present.clone());
        let carry = match (&from, &to) {
            (Some(from), Some(to)) => Remap::Mesh(MeshRemap::new(from, to)),
            _ => Remap::Grid(GridRemap { from: old.nodes_along(), to: self.nodes_along() }),
        };
        self.copy_settings_from(old, tolerance)?;
        self.remap_temperatures(old, &carry);
        self.release_pins(time);
        match &carry {
            Remap::Mesh(meshes) => self.remap_outline(old, spec, meshes, time),
            Remap::Grid(_) => self.remap_motion(old, spec, time),
        }
        let own = (self.elements.len(), old.elements.len() - old.grabs.len());
        for (element, before) in self.elements[..own.0].iter_mut().zip(&old.elements[..own.1]) {
            element.transfer_state(&**before, &carry);
        }
        self.remap_springs(old);
        self.remap_clamp_springs(old, spec);
        self.limit_kinetic_energy_to(old);
        match &carry {
            Remap::Mesh(meshes) => self.remap_outline_forces(old, meshes),
            Remap::Grid(_) => self.remap_forces(old),
        }
        for pull in old.pulls() {
            let (u, v) = pull.material_point(&old.uv);
            let index = self.grab((u.clamp(0.0, 1.0), v.clamp(0.0, 1.0)), pull.stiffness)?;
            self.pull(index, pull.target)?;
        }
        match &carry {
            Remap::Mesh(meshes) => self.remap_outline_contact_flags(old, meshes),
            Remap::Grid(_) => self.remap_contact_flags(old),
        }
        self.update_max_step();
        (self.counters, self.rest_time, self.status) = (old.counters, old.rest_time, old.status);
        Ok(())
    }

    /// Numbers of nodes along length and width.
    pub(crate) fn nodes_along(&self) -> [usize; 2] {
        [self.grid.0 as usize, self.grid.2 as usize]
    }

    /// Refuse a grid on which a pin at a point prescribes another material point.
    fn check_points(&self, old: &Self, spec: &SheetSpec) -> Result<(), InputError> {
        for (i, pin) in spec.pins.iter().enumerate() {
            let Region::Point(u, v) = pin.region else { continue };
            let of = |sheet: &Self| {
                let mass = crate::sheet::select(&pin.region, sheet).ok().and_then(|list| list.first().copied());
                mass.map_or((f64::NAN, f64::NAN), |m| sheet.uv[m as usize])
            };
            let (now, then) = (of(self), of(old));
            if (now.0 - then.0).abs().max((now.1 - then.1).abs()) > 1e-9 {
                let (nu, nv) = (self.grid.0, self.grid.2);
                let problem = format!(
                    "{nu}x{nv} has no mass at ({}, {}), where pins.{i} holds the one next to ({u}, {v})",
                    then.0, then.1
                );
                return Err(InputError::new("grid", problem));
            }
        }
        Ok(())
    }

    fn copy_settings_from(&mut self, old: &Self, tolerance: f64) -> Result<(), InputError> {
        (self.friction, self.restitution) = (old.friction, old.restitution);
        (self.spring_parameters.damping, self.damping_ratio) = (old.spring_parameters.damping, old.damping_ratio);
        if self.material != old.material {
            self.set_material(old.material.clone())?;
        } else {
            self.refresh();
        }
        if !self.flexion.triples.is_empty() {
            self.set_flexion_limit(old.flexion_angle_limit())?;
        }
        self.drag.copy_settings(&old.drag);
        if let Some((flow, before)) = self.inelastic.as_mut().zip(old.inelastic.as_ref()) {
            flow.set_celsius(before.celsius());
        }
        self.change_engine(old.chosen_engine(), tolerance);
        self.set_recovery_policy(old.when_unstable(), tolerance);
        if let Some((own, before)) = self.recovery.as_mut().zip(old.recovery.as_ref()) {
            own.state = RecoveryState { delay: before.state.delay, ..RecoveryState::default() };
        }
        self.set_buckling_detection(old.detects_buckling());
        self.initial_diagonal = old.initial_diagonal;
        Ok(())
    }

    /// Remap the temperatures, and restore their mean, weighted by mass, in each half of the
    /// thickness.
    fn remap_temperatures(&mut self, old: &Self, carry: &Remap) {
        if old.heat.is_none() {
            return;
        }
        self.start_temperatures(REFERENCE);
        let both = [false, true].map(|upper| {
            let before = old.side_temperatures(upper).unwrap_or_default();
            let mut now = self.read_temperatures(old, before, carry);
            let mean = |celsius: &[f64], mass: &[f64]| {
                celsius.iter().zip(mass).map(|(t, m)| t * m).sum::<f64>() / mass.iter().sum::<f64>()
            };
            let lost = mean(before, &old.mass) - mean(&now, &self.mass);
            now.iter_mut().for_each(|t| *t += lost);
            now
        });
        self.set_side_temperatures(&both);
    }

    /// Interpolate the temperatures `before` of `old` at the nodes of this sheet.
    fn read_temperatures(&self, old: &Self, before: &[f64], carry: &Remap) -> Vec<f64> {
        if self.is_lattice() {
            let before: Vec<[f64; 1]> = before.iter().map(|t| [*t]).collect();
            return LatticeLayout::from_sheet(self)
                .means(&LatticeLayout::from_sheet(old), &before)
                .into_iter()
                .map(|[t]| t)
                .collect();
        }
        carry.at_nodes(before)
    }

    /// Compute the longest stable step of an explicit integrator on this grid.
    pub(crate) fn update_max_step(&mut self) {
        let engine = self.engine_kind.info();
        let limited = !engine.implicit && !engine.adaptive;
        let frequency = if limited { self.largest_frequency(FREQUENCY_ITERATIONS) } else { 0.0 };
        // The highest mode of a Kelvin-Voigt solid has the damping ratio τ ω/2, which shortens the
        // stable step. Dashpots that are a fraction of each spring's own critical damping give two
        // to three times that ratio where a dozen springs meet.
        let solid = self.follows_material();
        let damping =
            if solid { 0.5 * self.law().retardation * frequency } else { 2.5 * self.spring_parameters.damping };
        let borne = STABILITY_LIMIT / (damping.hypot(1.0) + damping);
        self.max_step = if frequency > 0.0 { (borne / frequency).max(MIN_SUBSTEP) } else { f64::INFINITY };
    }

    /// Number of substeps of a step of `dt` (s): more than one on a changed grid whose explicit
    /// integrator is unstable for the whole step.
    pub fn substeps_of_step(&self, dt: f64) -> u32 {
        (dt / self.max_step).ceil().max(1.0) as u32
    }
}
