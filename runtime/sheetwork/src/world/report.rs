//! Report of a run: the JSON object of `sheetwork run --json`.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::collision::narrow_phase::DetectionCounters;
use crate::contact::ContactCounters;
use crate::islands::event::Event;
use crate::sheet::{DeliveredStiffness, Energy, Sheet, Status, inter_layer};
use crate::world::{ForceReport, World};

/// Results of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name of the scene.
    pub scene: String,
    /// Integrator at the end of the run.
    pub engine: &'static str,
    /// Time step, s.
    pub dt_s: f64,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// CPU time of the steps, s.
    pub cpu_s: f64,
    /// Number of steps.
    pub steps: u64,
    /// "ok", "unstable" with place and time, or "penetration" where the check of it is on.
    pub status: String,
    /// Results of the sheets.
    pub sheets: Vec<SheetReport>,
    /// Results of the bodies.
    pub bodies: Vec<BodyReport>,
    /// Events of the run.
    pub events: Vec<Event>,
    /// Forces of the last step; empty unless [`World::record_forces`] is on.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub forces: Vec<ForceReport>,
}

/// Results of a sheet at the end of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SheetReport {
    /// Name of the sheet.
    pub name: String,
    /// Structure of the sheet.
    pub structure: &'static str,
    /// Number of nodes.
    pub masses: usize,
    /// Number of springs.
    pub springs: usize,
    /// Whether the sheet is asleep.
    pub asleep: bool,
    /// "ok", "frozen" with time, or "unstable" with place and time.
    pub status: String,
    /// Recovery policy for instability.
    pub when_unstable: String,
    /// Energies, J.
    pub energy_j: Energy,
    /// Largest penetration of a body by a node at any frame of the run, m.
    pub max_penetration_m: f64,
    /// Largest speed of a node at the end, m/s.
    pub max_speed_m_s: f64,
    /// Mean distance of the layers, m; `None` for a single layer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layer_distance_m: Option<f64>,
    /// Temperatures, °C.
    pub temperature_c: TemperatureReport,
    /// Positions of the probes, m.
    pub probes: BTreeMap<String, [f64; 3]>,
    /// Steps accepted by error control (all of them, for a fixed step).
    pub steps_accepted: u64,
    /// Steps rejected by error control.
    pub steps_rejected: u64,
    /// Number of force evaluations; of linear solves for an implicit integrator.
    pub evaluations: u64,
    /// Stages of an implicit integrator that the globalised Newton method finished.
    pub guarded: u64,
    /// Delivered fraction of the requested stiffness; `None` when the springs are not calibrated to
    /// a stiffness.
    pub stiffness: Option<DeliveredStiffness>,
    /// Number of contacts between nodes and surfaces.
    pub contacts: u64,
    /// Fracture; `None` for a sheet that cannot fracture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opening: Option<OpeningReport>,
    /// Folds of a plastic sheet that its cells do not resolve; `None` where they do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unresolved_folds: Option<UnresolvedFolds>,
    /// Work counters of detection and of the contact solver, for the island whose first sheet this
    /// is.
    pub detection: DetectionCounters,
    /// See `detection`.
    pub contact_work: ContactCounters,
}

/// Fracture of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OpeningReport {
    /// Number of open cells.
    pub cells: usize,
    /// Number of cells.
    pub of: usize,
    /// Energy that fracture has removed from the motion, J.
    pub released_j: f64,
}

impl OpeningReport {
    fn of(sheet: &Sheet) -> Option<Self> {
        let of = sheet.open_cells()?.len();
        Some(Self { cells: sheet.open_count(), of, released_j: sheet.energy_released() })
    }
}

/// Rotation (rad) of a cell at yield up to which angles are within 5° of those on finer grids.
const RESOLVED_ROTATION: f64 = 0.4;

/// Cells too long for the radius at which a plastic sheet yields.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct UnresolvedFolds {
    /// Radius D/M_y at which the sheet yields, m.
    pub yield_radius_m: f64,
    /// Shortest edge of a cell, m.
    pub cell_m: f64,
    /// Longest cell that resolves a fold, m.
    pub resolving_cell_m: f64,
}

impl UnresolvedFolds {
    fn of(sheet: &Sheet) -> Option<Self> {
        let law = sheet.state.inelastic.as_ref()?.law.plastic?;
        let yield_radius_m = sheet.material().target().bending[0][0] / law.moment;
        let (cell_m, resolving_cell_m) = (sheet.spacing()?.0, RESOLVED_ROTATION * yield_radius_m);
        (cell_m > resolving_cell_m).then_some(Self { yield_radius_m, cell_m, resolving_cell_m })
    }
}

/// Temperatures of a sheet, °C; the ambient temperature without a thermal model.
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
    /// Temperatures of `sheet` at an ambient temperature of `room` (°C). The mean is over the
    /// nodes.
    fn of(sheet: &Sheet, room: f64) -> Self {
        let Some(heat) = sheet.heat() else { return Self { min: room, mean: room, max: room } };
        let mean = heat.celsius().iter().sum::<f64>() / heat.celsius().len().max(1) as f64;
        let (low, high) = heat.range();
        Self { min: low, mean, max: high }
    }
}

/// Results of a body at the end of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyReport {
    /// Name of the body.
    pub name: String,
    /// Position, m.
    pub position_m: [f64; 3],
    /// Rotation, quaternion (x, y, z, w).
    pub rotation: [f64; 4],
    /// Velocity of the centre of mass of a dynamic body, of the origin of another, m/s.
    pub velocity_m_s: [f64; 3],
    /// Angular velocity, rad/s.
    pub spin_rad_s: [f64; 3],
    /// Mass of a dynamic body, kg.
    pub mass_kg: Option<f64>,
    /// Whether a dynamic body is asleep.
    pub asleep: bool,
}

impl World {
    /// Report of the present state. `penetration` (m) is the largest of the run per sheet, `cpu_s`
    /// the CPU time; the caller measures both, since the library reads no clock.
    pub fn report(&self, cpu_s: f64, penetration: &[f64]) -> Report {
        let room = self.room_temperature();
        let sheets = self.sheets.iter().enumerate().map(|(index, sheet)| SheetReport {
            name: sheet.name.clone(),
            structure: sheet.model.structure.name(),
            masses: sheet.node_count(),
            springs: sheet.springs().len(),
            asleep: sheet.state.status == Status::Asleep,
            status: describe(&sheet.name, &sheet.state.status),
            when_unstable: sheet.when_unstable().to_string(),
            energy_j: sheet.energy(self.gravity),
            max_penetration_m: penetration.get(index).copied().unwrap_or(0.0),
            max_speed_m_s: sheet.max_speed(),
            layer_distance_m: inter_layer::distance(sheet),
            temperature_c: TemperatureReport::of(sheet, room),
            probes: sheet.probes.iter().map(|p| (p.name.clone(), p.at(&sheet.state.x).to_array())).collect(),
            steps_accepted: sheet.state.counters.accepted,
            steps_rejected: sheet.state.counters.rejected,
            evaluations: sheet.state.counters.evaluations,
            guarded: sheet.state.counters.guarded,
            stiffness: sheet.delivered_stiffness(self.dt),
            contacts: sheet.state.counters.contacts,
            opening: OpeningReport::of(sheet),
            unresolved_folds: UnresolvedFolds::of(sheet),
            detection: self.islands.detection_counters(index),
            contact_work: self.islands.contact_counters(index),
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
                    mass_kg: state.is_dynamic().then(|| state.mass()),
                    asleep: rigid.is_asleep(index),
                })
            })
        });
        // Events that are detected late, as the end of a contact, are sorted by time; the sort is
        // stable.
        let mut events = self.events.clone();
        events.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        Report {
            scene: self.scene.name.clone(),
            engine: self.engine.name(),
            dt_s: self.dt,
            simulated_s: self.time,
            cpu_s,
            steps: self.steps,
            status: self.status(),
            sheets: sheets.collect(),
            bodies: bodies.collect(),
            events,
            forces: self.force_reports(),
        }
    }

    /// "ok", or what is wrong.
    fn status(&self) -> String {
        match (self.unstable(), self.deepest_penetration()) {
            (Some(sheet), _) => describe(&sheet.name, &sheet.state.status),
            (None, Some(penetration)) => penetration.to_owned(),
            (None, None) => "ok".to_owned(),
        }
    }

    /// Raise each value of `so_far` to the present largest penetration of a body by a node of the
    /// sheet, m.
    pub fn update_max_penetration(&self, so_far: &mut Vec<f64>) {
        so_far.resize(self.sheets.len(), 0.0);
        let Some(rigid) = &self.rigid else { return };
        let view = rigid.view();
        for (deepest, sheet) in so_far.iter_mut().zip(&self.sheets) {
            *deepest = deepest.max(crate::contact::node::detection::deepest_penetration(sheet, &view));
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
