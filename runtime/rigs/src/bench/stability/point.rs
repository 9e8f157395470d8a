//! One point of the map, and its file.

use std::path::{Path, PathBuf};

use crate::measure::stability_limit::VariedParameter;
use serde::{Deserialize, Serialize};
use sheetwork::InputError;

use crate::bench::files_of;
use crate::bench::stability::plan::PlannedTrial;

/// A trial and its stability limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StabilityPoint {
    /// Index in the plan, from 0.
    pub number: usize,
    /// Number of points of the plan.
    pub of: usize,
    /// Sweep of the point.
    pub sweep: String,
    /// Structure.
    pub structure: String,
    /// Time integrator.
    pub engine: String,
    /// Nodes along length and width.
    pub grid: String,
    /// Stiffness, N/m.
    pub stiffness_n_m: f64,
    /// Node mass, kg.
    pub mass_kg: f64,
    /// Damping as a fraction of critical.
    pub damping: f64,
    /// Length over width.
    pub aspect: f64,
    /// Thickness, m.
    pub thickness_m: f64,
    /// Temperature jump, K.
    pub jump_k: f64,
    /// Impact speed, m/s.
    pub speed_m_s: f64,
    /// Step (s) of a search over another parameter.
    pub dt_s: Option<f64>,
    /// Searched parameter: "step", "stiffness", "mass", "damping".
    pub varied: String,
    /// Predicted longest step (s), or largest stable factor; none without a limit.
    pub predicted: Option<f64>,
    /// Measured longest step (s), or largest stable factor; none if every trial was stable.
    pub found: Option<f64>,
}

impl StabilityPoint {
    /// The point of `trial` before its run.
    pub fn new(trial: &PlannedTrial, number: usize, of: usize) -> Self {
        let s = &trial.setting;
        let varied = match trial.varied {
            VariedParameter::Step => "step",
            VariedParameter::Stiffness => "stiffness",
            VariedParameter::Mass => "mass",
            VariedParameter::Damping => "damping",
        };
        Self {
            number,
            of,
            sweep: trial.sweep.into(),
            structure: s.structure.info().name.into(),
            engine: s.engine.name().into(),
            grid: format!("{}x{}", s.grid.0, s.grid.1),
            stiffness_n_m: s.stiffness,
            mass_kg: s.mass,
            damping: s.damping,
            aspect: s.aspect,
            thickness_m: s.thickness,
            jump_k: s.jump,
            speed_m_s: s.speed,
            dt_s: None,
            varied: varied.into(),
            predicted: None,
            found: None,
        }
    }

    /// Measured over predicted value, where both exist.
    pub fn ratio(&self) -> Option<f64> {
        self.found.zip(self.predicted).filter(|(_, p)| *p > 0.0).map(|(f, p)| f / p)
    }
}

fn read_csv(path: &Path) -> Result<Vec<StabilityPoint>, InputError> {
    let refused = |e: csv::Error| InputError::new("", e.to_string()).in_file(path);
    let text = std::fs::read(path).map_err(|e| InputError::io(path, &e))?;
    // A truncated number is still a valid number.
    if text.last().is_some_and(|last| *last != b'\n') {
        return Err(InputError::new("", "is cut off: its last line has no end").in_file(path));
    }
    let mut reader = csv::Reader::from_reader(text.as_slice());
    reader.deserialize().collect::<Result<Vec<StabilityPoint>, _>>().map_err(refused)
}

/// Points of all CSV files of the folders, in the order of the plan.
///
/// # Errors
/// An unreadable file, files of different plans, or missing points.
pub fn merge(folders: &[PathBuf]) -> Result<Vec<StabilityPoint>, InputError> {
    let mut points: Vec<StabilityPoint> = Vec::new();
    for folder in folders {
        for path in files_of(folder, "csv")? {
            if path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("stability-")) {
                points.extend(read_csv(&path)?);
            }
        }
    }
    points.sort_by_key(|p| p.number);
    let Some(of) = points.first().map(|p| p.of) else {
        return Err(InputError::new("merge", "the folders hold no stability-I-of-N.csv with points"));
    };
    if points.iter().any(|p| p.of != of) {
        let problem = "the files are of different plans: some of --quick, or of another --only, some not?";
        return Err(InputError::new("merge", problem));
    }
    points.dedup();
    if points.windows(2).any(|two| two[0].number == two[1].number) {
        let problem = "a point is there twice, and not the same: shards of different builds or choices?";
        return Err(InputError::new("merge", problem));
    }
    if points.len() != of {
        let problem =
            format!("{} of {of} points are missing: a shard was not run, or not to its end", of - points.len());
        return Err(InputError::new("merge", problem));
    }
    Ok(points)
}
