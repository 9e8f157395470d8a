//! Plan of the map: all trials, in a fixed order.

use crate::measure::stability_limit::{StabilityTrial, VariedParameter};
use sheetwork::InputError;
use sheetwork::integrators::TABLE;
use sheetwork::mesh::structure::{self, StructureKind};
use sheetwork::scene::IntegratorKind;

use crate::bench::stability::point::StabilityPoint;

/// Stiffnesses (N/m), node masses (kg) and dampings (fraction of critical) of the map.
const STIFFNESS: [f64; 4] = [0.02, 0.2, 2.0, 20.0];
const MASS: [f64; 3] = [4e-5, 4e-4, 4e-3];
const DAMPING: [f64; 5] = [0.0, 0.02, 0.14, 0.34, 1.0];
/// Nodes along length and width of the map's sheets.
const GRID: (u32, u32) = (4, 4);

/// Values of the sweeps of a single parameter: length over width, thickness (m), temperature jump
/// (K), speed (m/s).
const ASPECT: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];
const THICKNESS: [f64; 5] = [1e-4, 3e-4, 1e-3, 3e-3, 6e-3];
const JUMP: [f64; 4] = [-100.0, -50.0, 50.0, 100.0];
const SPEED: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0];
/// Damping of the sweeps, as a fraction of critical.
const SWEEP_DAMPING: f64 = 0.14;

/// Speed of the thesis's sheets at a ridge, m/s: a fall of some millimetres at its gravity.
const FALL: f64 = 0.1;
/// Step over stability limit, for the thesis's integrators whose printed step exceeds the limit.
const STEP_MARGIN: f64 = 0.85;

/// The thesis's integrators (table 5.4): stiffness (N/m), damping, step (s).
pub const THESIS: [(IntegratorKind, f64, f64, f64); 3] = [
    (IntegratorKind::EulerCromer, 0.06, 0.34, 0.010),
    (IntegratorKind::EulerRichardson, 0.2, 0.14, 0.020),
    (IntegratorKind::Rk4, 0.4, 0.14, 0.040),
];

/// Names of the sweeps.
pub const SWEEPS: [&str; 7] = ["map", "aspect", "thickness", "jump", "speed", "thesis", "thesis-common"];

/// One point of the map.
#[derive(Clone, Debug)]
pub struct PlannedTrial {
    /// One of [`SWEEPS`].
    pub sweep: &'static str,
    pub setting: StabilityTrial,
    /// Searched parameter: the longest step, or the largest stable factor on another parameter.
    pub varied: VariedParameter,
}

/// All points.
pub fn plan(quick: bool) -> Vec<PlannedTrial> {
    let engines: Vec<IntegratorKind> = if quick {
        THESIS.map(|row| row.0).to_vec()
    } else {
        TABLE.iter().filter(|e| !e.adaptive && !e.implicit).map(|e| e.kind).collect()
    };
    let mut all = Vec::new();
    map(&mut all, &engines, quick);
    sweeps(&mut all, &engines, quick);
    implicit(&mut all, quick);
    thesis(&mut all, quick);
    all
}

fn structures(quick: bool) -> Vec<StructureKind> {
    let all = structure::TABLE.iter().map(|s| s.kind);
    all.filter(|s| !quick || [StructureKind::Trimm, StructureKind::Shell].contains(s)).collect()
}

/// Stiffness x mass x damping x integrator x structure, with a search for the step.
fn map(all: &mut Vec<PlannedTrial>, engines: &[IntegratorKind], quick: bool) {
    let some = |list: &[f64]| if quick { list.iter().copied().skip(1).take(2).collect() } else { list.to_vec() };
    for structure in structures(quick) {
        for engine in engines {
            for damping in some(&DAMPING) {
                // Without damping every step of this integrator lets some mode grow.
                if damping == 0.0 && engine.info().stability_limit == 0.0 {
                    continue;
                }
                for stiffness in some(&STIFFNESS) {
                    for mass in if quick { vec![4e-4] } else { MASS.to_vec() } {
                        let setting = StabilityTrial {
                            structure,
                            engine: *engine,
                            grid: GRID,
                            stiffness,
                            mass,
                            damping,
                            ..StabilityTrial::default()
                        };
                        all.push(PlannedTrial { sweep: "map", setting, varied: VariedParameter::Step });
                    }
                }
            }
        }
    }
}

/// Aspect ratio, thickness, temperature and impact, one at a time.
fn sweeps(all: &mut Vec<PlannedTrial>, engines: &[IntegratorKind], quick: bool) {
    for structure in [StructureKind::Trimm, StructureKind::Shell] {
        for engine in engines {
            let base =
                StabilityTrial { structure, engine: *engine, damping: SWEEP_DAMPING, ..StabilityTrial::default() };
            let mut push = |sweep, values: &[f64], with: &dyn Fn(f64) -> StabilityTrial| {
                let count = if quick { 2 } else { values.len() };
                for value in &values[..count] {
                    all.push(PlannedTrial { sweep, setting: with(*value), varied: VariedParameter::Step });
                }
            };
            push("aspect", &ASPECT, &|aspect| StabilityTrial { aspect, ..base });
            push("thickness", &THICKNESS, &|thickness| StabilityTrial { thickness, ..base });
            push("jump", &JUMP, &|jump| StabilityTrial { jump, ..base });
            push("speed", &SPEED, &|speed| StabilityTrial { speed, grid: (9, 9), ..base });
        }
    }
}

/// Implicit integrators, which should be stable at every step.
fn implicit(all: &mut Vec<PlannedTrial>, quick: bool) {
    let stiff: &[f64] = if quick { &[0.2] } else { &[0.02, 0.2, 20.0, 2e4, 2e7] };
    for engine in TABLE.iter().filter(|e| e.implicit) {
        for structure in structures(quick) {
            for stiffness in stiff {
                let setting = StabilityTrial {
                    structure,
                    engine: engine.kind,
                    stiffness: *stiffness,
                    ..StabilityTrial::default()
                };
                all.push(PlannedTrial { sweep: "map", setting, varied: VariedParameter::Step });
            }
        }
    }
}

/// The thesis's integrators at their settings, and all at the second-order setting: largest stable
/// factor on each parameter.
fn thesis(all: &mut Vec<PlannedTrial>, quick: bool) {
    let (_, stiffness, damping, _) = THESIS[1];
    let what = [VariedParameter::Step, VariedParameter::Stiffness, VariedParameter::Mass, VariedParameter::Damping];
    for varied in &what[..if quick { 1 } else { what.len() }] {
        for (engine, own_stiffness, own_damping, _) in THESIS {
            for (sweep, stiffness, damping) in
                [("thesis", own_stiffness, own_damping), ("thesis-common", stiffness, damping)]
            {
                let setting = StabilityTrial {
                    engine,
                    stiffness,
                    damping,
                    grid: (11, 11),
                    speed: FALL,
                    ..StabilityTrial::default()
                };
                all.push(PlannedTrial { sweep, setting, varied: *varied });
            }
        }
    }
}

impl PlannedTrial {
    /// Description.
    pub fn name(&self) -> String {
        format!("{} {} on {}", self.sweep, self.setting.engine, self.setting.structure)
    }

    /// The printed step (s) of the thesis for this integrator, or for all.
    fn printed(&self) -> f64 {
        let engine = if self.sweep == "thesis" { self.setting.engine } else { IntegratorKind::EulerRichardson };
        THESIS.iter().find(|row| row.0 == engine).map_or(0.02, |row| row.3)
    }

    /// Runs the trial.
    ///
    /// # Errors
    /// Parameters out of range, which is a defect of the plan.
    pub fn run(&self, number: usize, count: usize) -> Result<StabilityPoint, InputError> {
        let predicted = self.setting.predict_longest_step()?;
        let mut point = StabilityPoint::new(self, number, count);
        point.predicted = predicted.is_finite().then_some(predicted);
        if !self.sweep.starts_with("thesis") {
            point.found = self.setting.find_longest_step(predicted)?;
            return Ok(point);
        }
        let mut dt = self.printed().min(STEP_MARGIN * longest_step_at_ridge(&self.setting)?);
        // A common step uses the smallest limit of the integrators.
        if self.sweep == "thesis-common" {
            for (engine, ..) in THESIS {
                dt = dt.min(STEP_MARGIN * longest_step_at_ridge(&StabilityTrial { engine, ..self.setting })?);
            }
        }
        let steps = predicted / dt;
        point.dt_s = Some(dt);
        point.predicted = match self.varied {
            VariedParameter::Step => Some(steps),
            // The limit is proportional to √(m/k).
            VariedParameter::Stiffness | VariedParameter::Mass => Some(steps * steps),
            VariedParameter::Damping => None,
        };
        point.found = self.setting.margin(self.varied, dt)?;
        Ok(point)
    }
}

/// Longest stable step (s) of the sheet at the ridge.
fn longest_step_at_ridge(setting: &StabilityTrial) -> Result<f64, InputError> {
    Ok(setting.find_longest_step(setting.predict_longest_step()?)?.unwrap_or(f64::INFINITY))
}
