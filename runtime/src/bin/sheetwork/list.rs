//! `sheetwork list`: what there is to choose from.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use sheetwork::InputError;
use sheetwork::scene::{Scene, material};
use sheetwork::{engine, lattice, measure};

use crate::{print_json, print_line};

#[derive(Args)]
pub struct List {
    /// What to list.
    what: What,
    /// Folder of the scenes.
    #[arg(long, default_value = "assets/scenes")]
    folder: PathBuf,
    /// Print JSON and nothing else.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum What {
    Structures,
    Engines,
    Materials,
    Cases,
    Scenes,
}

impl List {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let rows = match self.what {
            What::Structures => structures(),
            What::Engines => engines(),
            What::Materials => materials(),
            What::Cases => measure::TABLE.iter().map(|c| json!({ "name": c.name, "about": c.about })).collect(),
            What::Scenes => scenes(&self.folder)?,
        };
        if self.json {
            print_json(&rows)?;
            return Ok(ExitCode::SUCCESS);
        }
        let text = |row: &Value, key: &str| row[key].as_str().unwrap_or_default().to_owned();
        let width = rows.iter().map(|r| text(r, "name").len()).max().unwrap_or(0);
        for row in &rows {
            print_line(&format!("{:<width$}  {}", text(row, "name"), text(row, "about")))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn structures() -> Vec<Value> {
    let row = |s: &lattice::Structure| {
        json!({
            "name": s.name, "about": s.about, "layers": s.layers,
            "triangular": s.triangular, "flexion": s.flexion, "cross_over": s.cross_over,
        })
    };
    lattice::TABLE.iter().map(row).collect()
}

fn engines() -> Vec<Value> {
    let row = |e: &engine::EngineInfo| {
        json!({
            "name": e.name, "about": e.about, "order": e.order, "stability_limit": e.stability_limit,
            "evaluations": e.evaluations, "adaptive": e.adaptive,
        })
    };
    engine::TABLE.iter().map(row).collect()
}

fn materials() -> Vec<Value> {
    let row = |(name, about, m): &(&str, &str, material::Material)| {
        json!({
            "name": name, "about": about, "young_pa": m.young, "poisson": m.poisson,
            "density_kg_m3": m.density, "thickness_m": m.thickness,
        })
    };
    material::LIBRARY.iter().map(row).collect()
}

/// The scenes of a folder, by file name; a file that is not a valid scene is listed with its fault.
fn scenes(folder: &Path) -> Result<Vec<Value>, InputError> {
    let entries = std::fs::read_dir(folder).map_err(|e| InputError::io(folder, &e))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "ron"));
    files.sort();
    let row = |file: &PathBuf| match Scene::load(file) {
        Ok(scene) => json!({ "name": file.display().to_string(), "about": scene.description }),
        Err(error) => json!({ "name": file.display().to_string(), "about": format!("not valid: {error}") }),
    };
    Ok(files.iter().map(row).collect())
}
