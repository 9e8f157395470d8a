//! `sheetwork list`: names of structures, integrators, materials, rigs, scenes and parameters.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use sheetwork::mesh::structure;
use sheetwork::scene::{Scene, material};
use sheetwork::{InputError, ParameterRow, ParameterScope, integrators};
use sheetwork_rigs::bench::files_of;
use sheetwork_rigs::measure;

use sheetwork_rigs::output::{OutputFlags, print_json, print_line};

#[derive(Args)]
pub struct List {
    /// Kind of names to list.
    what: ListKind,
    /// Folder of the scenes.
    #[arg(long, default_value = "assets/scenes")]
    folder: PathBuf,
    #[command(flatten)]
    output: OutputFlags,
}

#[derive(Clone, Copy, ValueEnum)]
enum ListKind {
    Structures,
    Engines,
    Materials,
    Cases,
    Scenes,
    Parameters,
}

impl List {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let rows = match self.what {
            ListKind::Structures => structures(),
            ListKind::Engines => engines(),
            ListKind::Materials => materials(),
            ListKind::Cases => measure::TABLE.iter().map(|c| json!({ "name": c.name, "about": c.about })).collect(),
            ListKind::Scenes => scenes(&self.folder)?,
            ListKind::Parameters => ParameterRow::all().iter().map(parameter).collect(),
        };
        if self.output.json {
            print_json(&rows)?;
            return Ok(ExitCode::SUCCESS);
        }
        let text = |row: &Value, key: &str| row[key].as_str().unwrap_or_default().to_owned();
        let width = rows.iter().map(|r| text(r, "name").len()).max().unwrap_or(0);
        let constants = matches!(self.what, ListKind::Materials);
        if constants {
            let heads = CONSTANTS.map(|(_, head, _)| format!("{head:>10}")).join("");
            print_line(&format!("{:<width$}{heads}", ""))?;
        }
        for row in &rows {
            let values = if constants { CONSTANTS.map(|column| cell(row, column)).join("") } else { String::new() };
            print_line(&format!("{:<width$}{values}  {}", text(row, "name"), text(row, "about")))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Columns of the material table: key, heading with unit, factor to that unit.
const CONSTANTS: [(&str, &str, f64); 7] = [
    ("young_pa", "E GPa", 1e-9),
    ("poisson", "ν", 1.0),
    ("density_kg_m3", "kg/m³", 1.0),
    ("thickness_m", "t mm", 1e3),
    ("damping_ratio", "damping", 1.0),
    ("yield_stress_pa", "yield MPa", 1e-6),
    ("glass_transition_c", "Tg °C", 1.0),
];

fn cell(row: &Value, (key, _, factor): (&str, &str, f64)) -> String {
    let text = row[key].as_f64().map_or_else(
        || "-".to_owned(),
        |value| {
            // Rounding removes the last digits that the factor may disturb.
            let value = value * factor;
            if value != 0.0 && value.abs() < 1e-3 {
                format!("{value:.2e}")
            } else {
                format!("{}", (value * 1e6).round() / 1e6)
            }
        },
    );
    format!("{text:>10}")
}

/// Row of a parameter; `*` in its path stands for a name or a number.
fn parameter(row: &ParameterRow) -> Value {
    let unit = if row.unit.is_empty() { String::new() } else { format!(" {}", row.unit) };
    let range = row.range.map_or_else(|| row.kind.name().to_owned(), |(min, max)| format!("{min} to {max}{unit}"));
    let default = row.default_text();
    let about = default.as_ref().map_or_else(|| range.clone(), |text| format!("{range}, default {text}"));
    json!({
        "name": row.path, "about": about, "unit": row.unit, "kind": row.kind.name(),
        "min": row.range.map(|r| r.0), "max": row.range.map(|r| r.1), "default": default,
        "live": row.scope != ParameterScope::Scene,
    })
}

fn structures() -> Vec<Value> {
    let row = |s: &structure::Structure| {
        json!({
            "name": s.name, "about": s.about, "layers": s.layers,
            "triangular": s.triangular, "flexion": s.flexion, "cross_over": s.cross_over,
        })
    };
    structure::TABLE.iter().map(row).collect()
}

fn engines() -> Vec<Value> {
    let row = |e: &integrators::IntegratorInfo| {
        json!({
            "name": e.name, "about": e.about, "order": e.order, "stability_limit": e.stability_limit,
            "evaluations": e.evaluations, "adaptive": e.adaptive,
            "implicit": e.implicit,
        })
    };
    integrators::TABLE.iter().map(row).collect()
}

fn materials() -> Vec<Value> {
    let row = |(name, about, m): &(&str, &str, material::Material)| {
        json!({
            "name": name, "about": about, "young_pa": m.young, "poisson": m.poisson,
            "density_kg_m3": m.density, "thickness_m": m.thickness, "damping_ratio": m.damping(),
            "yield_stress_pa": m.yield_stress, "specific_heat_j_kg_k": m.specific_heat,
            "conductivity_w_m_k": m.conductivity, "emissivity": m.emissivity,
            "glass_transition_c": m.glass_transition, "wlf": m.wlf, "tears_at": m.tears_at, "melts_at_c": m.melts_at,
        })
    };
    material::LIBRARY.iter().map(row).collect()
}

/// Scenes of a folder, by file name; an invalid scene is listed with its error.
fn scenes(folder: &Path) -> Result<Vec<Value>, InputError> {
    let files = files_of(folder, "ron")?;
    let row = |file: &PathBuf| match Scene::load(file) {
        Ok(scene) => json!({ "name": file.display().to_string(), "about": scene.description }),
        Err(error) => json!({ "name": file.display().to_string(), "about": format!("not valid: {error}") }),
    };
    Ok(files.iter().map(row).collect())
}
