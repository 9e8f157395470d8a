//! `sheetwork material`: properties of a material in a sheet, and the delivered stiffness of the
//! sheet's structure.

use std::path::Path;
use std::process::ExitCode;

use clap::Args;
use serde_json::{Value, json};
use sheetwork::InputError;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{Material, MaterialChoice};
use sheetwork::sheet::material_report::{DirectionalModuli, MaterialReport, ReportRequest, material_report};
use sheetwork_rigs::measure::Setup;

use sheetwork_rigs::output::{OutputFlags, parse_counts, print_json, print_line};
use sheetwork_rigs::quantities::{acceleration, density, length, parse_number, pressure};

#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct MaterialCommand {
    /// Material: a name (see `sheetwork list materials`), or a file with the extension `.ron`.
    material: String,
    /// Structure.
    #[arg(long, default_value = "shell")]
    structure: StructureKind,
    /// Nodes along length and width of the bottom layer.
    #[arg(long, default_value = "21x21", value_parser = parse_counts::<2>)]
    grid: [u32; 2],
    /// Number of layers; default 2, limited to the structure's range.
    #[arg(long)]
    layers: Option<u32>,
    /// Length of the sheet, m.
    #[arg(long, default_value = "0.25", value_parser = length)]
    length: f64,
    /// Width of the sheet, m. In a triangular structure it is rounded to whole rows of equilateral
    /// triangles.
    #[arg(long, default_value = "0.25", value_parser = length)]
    width: f64,
    /// Distance between layers, m (default a quarter of the node spacing).
    #[arg(long, value_parser = length)]
    gap: Option<f64>,
    /// Thickness, m, in place of the material's.
    #[arg(long, value_parser = length)]
    thickness: Option<f64>,
    /// Young's modulus, Pa, in place of the material's.
    #[arg(long, value_parser = pressure)]
    young: Option<f64>,
    /// Poisson's ratio in place of the material's.
    #[arg(long, value_parser = parse_number)]
    poisson: Option<f64>,
    /// Density, kg/m³, in place of the material's.
    #[arg(long, value_parser = density)]
    density: Option<f64>,
    /// Gravity, m/s².
    #[arg(long, default_value = "9.81", value_parser = acceleration)]
    gravity: f64,
    #[command(flatten)]
    output: OutputFlags,
}

impl MaterialCommand {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let request = self.request()?;
        let report = material_report(&request)?;
        if self.output.json {
            let mut object = json!({ "material": self.material });
            let fields = serde_json::to_value(&report).map_err(|e| InputError::new("", e.to_string()))?;
            if let (Value::Object(all), Value::Object(fields)) = (&mut object, fields) {
                all.extend(fields);
            }
            print_json(&object)?;
        } else {
            table(&self.material, &report)?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn request(&self) -> Result<ReportRequest, InputError> {
        let base = MaterialChoice::from(self.material.as_str()).resolve(Path::new(""))?;
        let material = Material {
            young: self.young.unwrap_or(base.young),
            poisson: self.poisson.unwrap_or(base.poisson),
            density: self.density.unwrap_or(base.density),
            thickness: self.thickness.unwrap_or(base.thickness),
            ..base
        };
        let setup = Setup {
            structure: self.structure,
            grid: (self.grid[0], self.grid[1]),
            layers: self.layers,
            material,
            length: self.length,
            width: self.width,
            ..Setup::default()
        };
        setup.check()?;
        let ((nx, nz), width) = setup.as_built();
        Ok(ReportRequest {
            structure: setup.structure,
            grid: (nx, setup.layer_count(), nz),
            size: (setup.length, width),
            gap: self.gap,
            gravity: self.gravity,
            material: setup.material,
        })
    }
}

/// Four significant digits, with an exponent outside 1e-3 to 1e5.
fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&size) {
        let digits = (3 - size.log10().floor() as i32).max(0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

fn table(name: &str, r: &MaterialReport) -> Result<(), InputError> {
    let or_dash = |value: Option<f64>, unit: &str| value.map_or("-".to_owned(), |v| format!("{}{unit}", short(v)));
    let percent = |value: f64| format!("{:.2} %", 100.0 * value);
    let [nx, layers, nz] = r.grid;
    let bending = r.bending_0_45_90_135.map(|b| format!("{b:.4}")).join("  ");
    let across =
        if r.orthotropic { format!(", across {} N m", short(r.plate_stiffness_across_n_m)) } else { String::new() };
    let rows = [
        ("material", name.to_owned()),
        ("Young's modulus", format!("{} GPa", short(r.young_pa * 1e-9))),
        ("Poisson's ratio", short(r.poisson)),
        ("density", format!("{} kg/m³", short(r.density_kg_m3))),
        ("thickness", format!("{} mm", short(r.thickness_m * 1e3))),
        ("damping ratio", short(r.damping_ratio)),
        ("yield stress", or_dash(r.yield_stress_pa.map(|s| s * 1e-6), " MPa")),
        ("glass transition", or_dash(r.glass_transition_c, " °C")),
        ("bending stiffness D", format!("{} N m{across}", short(r.plate_stiffness_n_m))),
        ("twist stiffness", format!("{} N m", short(r.twist_stiffness_n_m))),
        ("membrane stiffness", format!("{} N/m", short(r.membrane_stiffness_n_m))),
        ("plate modulus E'", format!("{} GPa", short(r.plate_modulus_pa * 1e-9))),
        ("mass per area", format!("{} kg/m²", short(r.areal_mass_kg_m2))),
        ("gravito-bending length", format!("{} m", short(r.gravito_bending_length_m))),
        ("Γ of this length", short(r.gamma_plate)),
        ("sheet", format!("{} {nx}x{layers}x{nz}, {} x {} m", r.structure, short(r.length_m), short(r.width_m))),
        ("gap", or_dash(r.gap_m.map(|g| g * 1e3), " mm")),
        ("bending, of requested", format!("{bending}  at 0, 45, 90, 135°")),
        ("twist, of requested", format!("{:.4}", r.twist)),
        ("membrane, of requested", short(r.membrane)),
        ("its Poisson's ratio", format!("{:.4}", r.poisson_ratio)),
        ("lost to shear", r.shear_loss.map_or("-".to_owned(), percent)),
        ("lost to soft membrane", percent(r.soft_membrane_loss)),
    ];
    let moduli = |of: fn(&DirectionalModuli) -> f64| {
        let all: Vec<String> = r.directions.iter().map(|d| short(of(d))).collect();
        all.join("  ")
    };
    let rows =
        rows.into_iter().chain((!r.directions.is_empty()).then(|| {
            ("strip in tension, N/m", format!("{}  at 0, 15, ... 90° to the warp", moduli(|d| d.tensile_n_m)))
        }));
    let rows =
        rows.chain((!r.directions.is_empty()).then(|| {
            ("strip in bending, N m", format!("{}  at 0, 15, ... 90° to the warp", moduli(|d| d.bending_n_m)))
        }));
    let rows: Vec<(&str, String)> = rows.collect();
    let width = rows.iter().map(|(key, _)| key.chars().count()).max().unwrap_or(0);
    for (key, value) in rows {
        print_line(&format!("{key:<width$}  {value}"))?;
    }
    r.notes.iter().try_for_each(|note| print_line(&format!("- {note}")))
}
