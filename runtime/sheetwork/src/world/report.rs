//! The report of a run: the JSON object of `sheetwork run --json`.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::collision::narrow_phase::FindCounters;
use crate::contact::ContactCounters;
use crate::islands::event::Event;
use crate::sheet::{DeliveredStiffness, Energy, Sheet, Status};
use crate::world::World;

/// A run, in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name of the scene.
    pub scene: String,
    /// Engine at the end of the run.
    pub engine: &'static str,
    /// Step of the engine, s.
    pub dt_s: f64,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// CPU time of the stepping, s.
    pub cpu_s: f64,
    /// Steps taken.
    pub steps: u64,
    /// "ok", or "unstable" with where and when.
    pub status: String,
    /// The sheets.
    pub sheets: Vec<SheetReport>,
    /// The bodies.
    pub bodies: Vec<BodyReport>,
    /// What happened.
    pub events: Vec<Event>,
}

/// A sheet at the end of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SheetReport {
    /// Name.
    pub name: String,
    /// Structure.
    pub structure: &'static str,
    /// Masses.
    pub masses: usize,
    /// Springs.
    pub springs: usize,
    /// Whether it sleeps.
    pub asleep: bool,
    /// "ok", "frozen" with when, or "unstable" with where and when.
    pub status: String,
    /// What is done when it is about to go unstable.
    pub when_unstable: String,
    /// Energies, J.
    pub energy_j: Energy,
    /// Deepest a mass was inside a body at any frame of the run, m.
    pub max_penetration_m: f64,
    /// Largest speed of a mass now, m/s.
    pub max_speed_m_s: f64,
    /// Temperature, °C.
    pub temperature_c: TemperatureReport,
    /// Named points, m.
    pub probes: BTreeMap<String, [f64; 3]>,
    /// Engine steps accepted by error control (all of them, for a fixed step).
    pub steps_accepted: u64,
    /// Engine steps rejected by error control.
    pub steps_rejected: u64,
    /// Evaluations of the forces; linear solves of an implicit engine.
    pub evaluations: u64,
    /// Stages of an implicit engine that its guarded descent had to finish.
    pub guarded: u64,
    /// What is delivered now of the stiffness asked for; nothing where springs do not aim at it.
    pub stiffness: Option<DeliveredStiffness>,
    /// Times a mass met a surface.
    pub contacts: u64,
    /// What has opened; nothing of a sheet that cannot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opening: Option<OpeningReport>,
    /// Work of looking for contact, and of solving it, of the group that the sheet is the first of.
    pub detection: FindCounters,
    /// See `detection`.
    pub contact_work: ContactCounters,
}

/// What has opened of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OpeningReport {
    /// Cells that are open.
    pub cells: usize,
    /// Of how many.
    pub of: usize,
    /// Energy that opening has taken out of the motion, J.
    pub released_j: f64,
}

impl OpeningReport {
    fn of(sheet: &Sheet) -> Option<Self> {
        let of = sheet.open_cells()?.len();
        Some(Self { cells: sheet.open_count(), of, released_j: sheet.energy_released() })
    }
}

/// Temperatures of a sheet, °C. Without a source of heat, those of the surroundings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TemperatureReport {
    /// Lowest.
    pub min: f64,
    /// Mean.
    pub mean: f64,
    /// Highest.
    pub max: f64,
}

impl TemperatureReport {
    /// That of `sheet` in a room at `room` °C. The mean is of its masses.
    fn of(sheet: &Sheet, room: f64) -> Self {
        let Some(heat) = sheet.heat() else { return Self { min: room, mean: room, max: room } };
        let mean = heat.celsius().iter().sum::<f64>() / heat.celsius().len().max(1) as f64;
        let (low, high) = heat.range();
        Self { min: low, mean, max: high }
    }
}

/// A body at the end of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyReport {
    /// Name.
    pub name: String,
    /// Position, m.
    pub position_m: [f64; 3],
    /// Rotation, quaternion (x, y, z, w).
    pub rotation: [f64; 4],
    /// Velocity of the centre of mass, m/s; of the origin of a body that does not move freely.
    pub velocity_m_s: [f64; 3],
    /// Angular velocity, rad/s.
    pub spin_rad_s: [f64; 3],
    /// Mass, kg, of a body that moves freely.
    pub mass_kg: Option<f64>,
    /// Whether it moves freely, came to rest and sleeps.
    pub asleep: bool,
}

impl World {
    /// The world as it is now. `penetration` (m) is the deepest seen in the run per sheet, `cpu_s` the time it took; both
    /// are the caller's to measure, since the core reads no clock.
    pub fn report(&self, cpu_s: f64, penetration: &[f64]) -> Report {
        let room = self.room_temperature();
        let sheets = self.sheets.iter().enumerate().map(|(index, sheet)| SheetReport {
            name: sheet.name.clone(),
            structure: sheet.structure.name(),
            masses: sheet.masses(),
            springs: sheet.springs().len(),
            asleep: sheet.status == Status::Asleep,
            status: describe(&sheet.name, &sheet.status),
            when_unstable: sheet.when_unstable().to_string(),
            energy_j: sheet.energy(self.gravity),
            max_penetration_m: penetration.get(index).copied().unwrap_or(0.0),
            max_speed_m_s: sheet.max_speed(),
            temperature_c: TemperatureReport::of(sheet, room),
            probes: sheet.probes.iter().map(|p| (p.name.clone(), p.of(&sheet.x).to_array())).collect(),
            steps_accepted: sheet.counters.accepted,
            steps_rejected: sheet.counters.rejected,
            evaluations: sheet.counters.evaluations,
            guarded: sheet.counters.guarded,
            stiffness: sheet.delivered_stiffness(self.dt),
            contacts: sheet.counters.contacts,
            opening: OpeningReport::of(sheet),
            detection: sheet.detection(),
            contact_work: sheet.contact_counters(),
        });
        let bodies = self.rigid.iter().flat_map(|rigid| {
            rigid.bodies().iter().enumerate().filter_map(|(index, body)| {
                let state = rigid.state(index)?;
                Some(BodyReport {
                    name: body.name.clone(),
                    position_m: state.origin().to_array(),
                    rotation: state.rotation().to_array(),
                    velocity_m_s: state.velocity().to_array(),
                    spin_rad_s: state.spin().to_array(),
                    mass_kg: state.gives().then(|| state.mass()),
                    asleep: rigid.is_asleep(index),
                })
            })
        });
        // An event that is only known later, like having slid off, goes where it belongs; the sort is stable.
        let mut events = self.events.clone();
        events.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let status = self.unstable().map_or_else(|| "ok".to_owned(), |s| describe(&s.name, &s.status));
        Report {
            scene: self.scene.name.clone(),
            engine: self.engine.name(),
            dt_s: self.dt,
            simulated_s: self.time,
            cpu_s,
            steps: self.steps,
            status,
            sheets: sheets.collect(),
            bodies: bodies.collect(),
            events,
        }
    }

    /// How deep the deepest mass of each sheet is inside a body now, m: deepens the values in `so_far`.
    pub fn watch_penetration(&self, so_far: &mut Vec<f64>) {
        so_far.resize(self.sheets.len(), 0.0);
        let Some(rigid) = &self.rigid else { return };
        let view = rigid.view();
        for (deepest, sheet) in so_far.iter_mut().zip(&self.sheets) {
            *deepest = deepest.max(crate::contact::node::detection::deepest(sheet, &view));
        }
    }
}

fn describe(name: &str, status: &Status) -> String {
    match status {
        Status::Awake | Status::Asleep => "ok".to_owned(),
        Status::Frozen { time } => format!("frozen: {name} at {time:.6} s"),
        Status::Unstable { time, mass, place, speed } => format!(
            "unstable: {name} at {time:.6} s, mass {mass} at ({:.5}, {:.5}, {:.5}) m, {speed:.3e} m/s",
            place.x, place.y, place.z
        ),
    }
}
