//! What the map is made of: every setting that is tried, in an order that does not change.

use crate::measure::limit::{Setting, Varied};
use sheetwork::InputError;
use sheetwork::integrators::{EngineKind, TABLE};
use sheetwork::mesh::structure;
use sheetwork::mesh::structure::StructureKind;

use crate::bench::stability::point::Point;

/// Stiffnesses (N/m), masses (kg) and dampings (of critical) of the map.
const STIFFNESS: [f64; 4] = [0.02, 0.2, 2.0, 20.0];
const MASS: [f64; 3] = [4e-5, 4e-4, 4e-3];
const DAMPING: [f64; 5] = [0.0, 0.02, 0.14, 0.34, 1.0];
/// Masses along length and width of the map's sheets.
const GRID: (u32, u32) = (4, 4);

/// Values of the sweeps of one number.
const ASPECT: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];
const THICKNESS: [f64; 5] = [1e-4, 3e-4, 1e-3, 3e-3, 6e-3];
const JUMP: [f64; 4] = [-100.0, -50.0, 50.0, 100.0];
const SPEED: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0];
/// Damping of the sweeps.
const SWEPT: f64 = 0.14;

/// Speed of the thesis's sheets at a ridge, m/s: a fall of some millimetres at its gravity.
const FALL: f64 = 0.1;
/// Step of the thesis's engines, where the printed one is beyond their limit, over that limit.
const WITHIN: f64 = 0.85;

/// The thesis's engines (table 5.4): stiffness (N/m), damping, step (s).
pub const THESIS: [(EngineKind, f64, f64, f64); 3] = [
    (EngineKind::EulerCromer, 0.06, 0.34, 0.010),
    (EngineKind::EulerRichardson, 0.2, 0.14, 0.020),
    (EngineKind::Rk4, 0.4, 0.14, 0.040),
];

/// What is swept.
pub const SWEEPS: [&str; 7] = ["map", "aspect", "thickness", "jump", "speed", "thesis", "thesis-common"];

/// One point of the map.
#[derive(Clone, Debug)]
pub struct Trial {
    /// One of [`SWEEPS`].
    pub sweep: &'static str,
    pub setting: Setting,
    /// What is looked for: the longest step, or how much harder something may be made.
    pub varied: Varied,
}

/// Every point there is.
pub fn plan(quick: bool) -> Vec<Trial> {
    let engines: Vec<EngineKind> = if quick {
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

/// Stiffness x mass x damping x engine x structure; the step is what is looked for.
fn map(all: &mut Vec<Trial>, engines: &[EngineKind], quick: bool) {
    let some = |list: &[f64]| if quick { list.iter().copied().skip(1).take(2).collect() } else { list.to_vec() };
    for structure in structures(quick) {
        for engine in engines {
            for damping in some(&DAMPING) {
                // Any step makes some of them grow.
                if damping == 0.0 && engine.info().stability_limit == 0.0 {
                    continue;
                }
                for stiffness in some(&STIFFNESS) {
                    for mass in if quick { vec![4e-4] } else { MASS.to_vec() } {
                        let setting = Setting {
                            structure,
                            engine: *engine,
                            grid: GRID,
                            stiffness,
                            mass,
                            damping,
                            ..Setting::default()
                        };
                        all.push(Trial { sweep: "map", setting, varied: Varied::Step });
                    }
                }
            }
        }
    }
}

/// Aspect ratio, thickness, temperature and impact, one at a time.
fn sweeps(all: &mut Vec<Trial>, engines: &[EngineKind], quick: bool) {
    for structure in [StructureKind::Trimm, StructureKind::Shell] {
        for engine in engines {
            let base = Setting { structure, engine: *engine, damping: SWEPT, ..Setting::default() };
            let mut push = |sweep, values: &[f64], with: &dyn Fn(f64) -> Setting| {
                let count = if quick { 2 } else { values.len() };
                for value in &values[..count] {
                    all.push(Trial { sweep, setting: with(*value), varied: Varied::Step });
                }
            };
            push("aspect", &ASPECT, &|aspect| Setting { aspect, ..base });
            push("thickness", &THICKNESS, &|thickness| Setting { thickness, ..base });
            push("jump", &JUMP, &|jump| Setting { jump, ..base });
            push("speed", &SPEED, &|speed| Setting { speed, grid: (9, 9), ..base });
        }
    }
}

/// Implicit engines, which nothing should break.
fn implicit(all: &mut Vec<Trial>, quick: bool) {
    let stiff: &[f64] = if quick { &[0.2] } else { &[0.02, 0.2, 20.0, 2e4, 2e7] };
    for engine in TABLE.iter().filter(|e| e.implicit) {
        for structure in structures(quick) {
            for stiffness in stiff {
                let setting = Setting { structure, engine: engine.kind, stiffness: *stiffness, ..Setting::default() };
                all.push(Trial { sweep: "map", setting, varied: Varied::Step });
            }
        }
    }
}

/// The thesis's engines at its settings, and all at that of the second order: how much harder each may be made.
fn thesis(all: &mut Vec<Trial>, quick: bool) {
    let (_, stiffness, damping, _) = THESIS[1];
    let what = [Varied::Step, Varied::Stiffness, Varied::Mass, Varied::Damping];
    for varied in &what[..if quick { 1 } else { what.len() }] {
        for (engine, own_stiffness, own_damping, _) in THESIS {
            for (sweep, stiffness, damping) in
                [("thesis", own_stiffness, own_damping), ("thesis-common", stiffness, damping)]
            {
                let setting = Setting { engine, stiffness, damping, grid: (11, 11), speed: FALL, ..Setting::default() };
                all.push(Trial { sweep, setting, varied: *varied });
            }
        }
    }
}

impl Trial {
    /// What it is, in words.
    pub fn name(&self) -> String {
        format!("{} {} on {}", self.sweep, self.setting.engine, self.setting.structure)
    }

    /// The step (s) of the thesis for this engine, or for all.
    fn printed(&self) -> f64 {
        let engine = if self.sweep == "thesis" { self.setting.engine } else { EngineKind::EulerRichardson };
        THESIS.iter().find(|row| row.0 == engine).map_or(0.02, |row| row.3)
    }

    /// Tries it.
    ///
    /// # Errors
    /// When its setting is refused, which would be a fault of the plan.
    pub fn run(&self, number: usize, count: usize) -> Result<Point, InputError> {
        let predicted = self.setting.predicted()?;
        let mut point = Point::of(self, number, count);
        point.predicted = predicted.is_finite().then_some(predicted);
        if !self.sweep.starts_with("thesis") {
            point.found = self.setting.found(predicted)?;
            return Ok(point);
        }
        let mut dt = self.printed().min(WITHIN * bears(&self.setting)?);
        // All engines at one step are at what the weakest of them bears.
        if self.sweep == "thesis-common" {
            for (engine, ..) in THESIS {
                dt = dt.min(WITHIN * bears(&Setting { engine, ..self.setting })?);
            }
        }
        let steps = predicted / dt;
        point.dt_s = Some(dt);
        point.predicted = match self.varied {
            Varied::Step => Some(steps),
            // The limit is as √(m/k).
            Varied::Stiffness | Varied::Mass => Some(steps * steps),
            Varied::Damping => None,
        };
        point.found = self.setting.margin(self.varied, dt)?;
        Ok(point)
    }
}

/// The longest step (s) that the sheet bears as it meets the ridge.
fn bears(setting: &Setting) -> Result<f64, InputError> {
    Ok(setting.found(setting.predicted()?)?.unwrap_or(f64::INFINITY))
}
