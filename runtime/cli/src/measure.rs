//! `sheetwork measure`: a sheet on a virtual test rig.

use std::process::ExitCode;

use clap::Args;
use serde_json::Value;
use sheetwork::InputError;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{BurgersCreep, IntegratorKind, Material, SpringLaw, material};
use sheetwork_rigs::measure::{Boundary, Setup, TABLE, measure};

use crate::heat_flags::HeatFlags;
use sheetwork_rigs::output::{parse_counts, print_json, print_line};
use sheetwork_rigs::quantities::{acceleration, angle, density, length, parse_number, pressure, speed, time};

#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct Measure {
    /// Rig, by name (see `sheetwork list cases`).
    case: String,
    /// Structure.
    #[arg(long, default_value = "shell")]
    structure: StructureKind,
    /// Nodes along length and width of the bottom layer.
    #[arg(long, default_value = "21x21", value_parser = parse_counts::<2>)]
    grid: [u32; 2],
    /// Number of layers; default 2, limited to the structure's range.
    #[arg(long)]
    layers: Option<u32>,
    /// Time integrator.
    #[arg(long, default_value = "tr-bdf2")]
    engine: IntegratorKind,
    /// Step, s, or a fraction such as 1/60. Default: 1/60 with an implicit integrator, a stable
    /// step with an explicit one.
    #[arg(long, value_parser = time)]
    dt: Option<f64>,
    /// Young's modulus, Pa (default 3e9).
    #[arg(long, value_parser = pressure)]
    young: Option<f64>,
    /// Poisson's ratio (default 0.35).
    #[arg(long, value_parser = parse_number)]
    poisson: Option<f64>,
    /// Density, kg/m³ (default 1050).
    #[arg(long, value_parser = density)]
    density: Option<f64>,
    /// Thickness, m (default 5e-4).
    #[arg(long, value_parser = length)]
    thickness: Option<f64>,
    /// Material by name, for constants without a flag above.
    #[arg(long)]
    material: Option<String>,
    /// Length of the sheet, m (default 0.25), or of the bending part (fold, default 0.02).
    #[arg(long, value_parser = length)]
    length: Option<f64>,
    /// Width of the sheet, m.
    #[arg(long, default_value = "0.25", value_parser = length)]
    width: f64,
    /// Gravity, m/s².
    #[arg(long, default_value = "9.81", value_parser = acceleration)]
    gravity: f64,
    /// Damping ratio of the slowest bending mode; for springs of rigs with bodies, a fraction of
    /// their critical damping.
    #[arg(long, default_value = "0.05", value_parser = parse_number)]
    damping_ratio: f64,
    /// Angle of the incline, of the landing sheet, or of the fold, degrees (default 20 for incline,
    /// 30 for edge-landing, 90 for fold).
    #[arg(long, value_parser = angle)]
    angle: Option<f64>,
    /// Friction coefficient (rigs with bodies).
    #[arg(long, default_value = "0.3", value_parser = parse_number)]
    friction: f64,
    /// Restitution coefficient (rigs with bodies; default 0.5 for bounce, else 0).
    #[arg(long, value_parser = parse_number)]
    restitution: Option<f64>,
    /// Drop height, m (default 0.2 for bounce, 0.05 for drop-box, 1 for edge-landing).
    #[arg(long, value_parser = length)]
    height: Option<f64>,
    /// Initial speed, m/s (slide, impact).
    #[arg(long, default_value = "1", value_parser = speed)]
    speed: f64,
    /// Factor on the ball speed of the scene, 0.1 to 3 (card-house).
    #[arg(long, default_value = "1", value_parser = parse_number)]
    throw: f64,
    /// Angular velocity, rad/s (spin).
    #[arg(long, default_value = "10", value_parser = parse_number)]
    rate: f64,
    /// Boundary condition of the edges: cantilever, clamped, supported or free (frequency).
    #[arg(long, default_value = "cantilever")]
    boundary: Boundary,
    /// Number of vibration modes (frequency).
    #[arg(long, default_value = "3")]
    modes: u32,
    /// Side of the square, m; default the length (pedestal, supports).
    #[arg(long, value_parser = length)]
    side: Option<f64>,
    /// Side of the clamped patch, m (pedestal).
    #[arg(long, default_value = "0.05", value_parser = length)]
    patch: f64,
    /// Radius, m (disc).
    #[arg(long, default_value = "0.125", value_parser = length)]
    radius: f64,
    /// Diameter of the hole, m (hole).
    #[arg(long, default_value = "0.1", value_parser = length)]
    hole: f64,
    /// Side of the box, m (drop-box, weight).
    #[arg(long = "box", default_value = "0.1", value_parser = length)]
    box_side: f64,
    /// Number of sheets in the pile (stack).
    #[arg(long, default_value = "5")]
    sheets: u32,
    /// Land on a corner in place of an edge (edge-landing).
    #[arg(long)]
    corner: bool,
    /// Land with the surface on the ridge of a wedge, with --corner on the tip of a needle
    /// (edge-landing).
    #[arg(long)]
    edge_of_body: bool,
    /// Use a sheet with all nodes fixed in place of a plane (incline, slide), or a striking sheet
    /// in place of a ball (impact).
    #[arg(long)]
    on_sheet: bool,
    /// Number of halvings of the step, each with a measurement of the rebound (edge-landing).
    #[arg(long, default_value = "0")]
    refine: u32,
    /// Threads that step several sheets (stack, card-pack, card-house).
    #[arg(long, default_value = "1")]
    threads: u32,
    /// Yield stress, Pa (fold; default 3e7).
    #[arg(long, value_parser = pressure)]
    yield_stress: Option<f64>,
    /// Hardening modulus, Pa (fold; default 0).
    #[arg(long, value_parser = pressure)]
    hardening: Option<f64>,
    /// Relaxation time of the dashpot, s (creep; default 10).
    #[arg(long, value_parser = time)]
    relaxation_time: Option<f64>,
    /// Retardation time, s (creep; default 1).
    #[arg(long, value_parser = time)]
    retardation_time: Option<f64>,
    /// Retarded strain over instantaneous strain (creep; default 0.5).
    #[arg(long, value_parser = parse_number)]
    retarded: Option<f64>,
    /// Step from flat to rest in place of the equilibrium solution (cantilever and other
    /// equilibrium rigs).
    #[arg(long)]
    dynamic: bool,
    /// Mesh the rectangle with the triangles of sheets with an outline.
    #[arg(long)]
    outlined: bool,
    #[command(flatten)]
    heat: HeatFlags,
    /// Print JSON and nothing else.
    #[arg(long)]
    json: bool,
}

/// Defaults of flags that depend on the case.
struct CaseDefaults {
    /// Length of the sheet, m.
    length: f64,
    /// Height of a drop, m.
    height: f64,
    /// Angle, degrees.
    angle: f64,
    restitution: f64,
}

impl CaseDefaults {
    fn of(case: &str) -> Self {
        let usual = Self { length: 0.25, height: 0.2, angle: 20.0, restitution: 0.0 };
        match case {
            "bounce" => Self { restitution: 0.5, ..usual },
            "drop-box" => Self { height: 0.05, ..usual },
            "edge-landing" => Self { height: 1.0, angle: 30.0, ..usual },
            "fold" => Self { length: 0.02, angle: 90.0, ..usual },
            _ => usual,
        }
    }
}

impl Measure {
    pub fn case(&self) -> &str {
        &self.case
    }

    pub fn execute(self) -> Result<ExitCode, InputError> {
        let found = measure(&self.case, &self.setup()?)?;
        if self.json {
            print_json(&found)?;
        } else if let Value::Object(map) = &found {
            let width = map.keys().map(String::len).max().unwrap_or(0);
            for (key, value) in map {
                if let Some(lines) = changes(value) {
                    print_line(key)?;
                    lines.iter().try_for_each(|line| print_line(&format!("  {line}")))?;
                    continue;
                }
                let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                print_line(&format!("{key:<width$}  {text}"))?;
            }
        }
        Ok(if found["status"] == "ok" { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    pub fn setup(&self) -> Result<Setup, InputError> {
        let defaults = Setup::default();
        let base = match &self.material {
            Some(name) => material::by_name(name)?,
            None => defaults.material.clone(),
        };
        let contact = TABLE.iter().any(|c| c.name == self.case && c.contact);
        let explicit = !self.engine.info().implicit;
        let case = CaseDefaults::of(&self.case);
        let structure = self.structure;
        let (fewest, most) = structure.info().layers;
        Ok(Setup {
            structure,
            grid: (self.grid[0], self.grid[1]),
            layers: self.layers.unwrap_or_else(|| 2.clamp(fewest, most)),
            engine: self.engine,
            springs: if contact && explicit { SpringLaw::Length } else { SpringLaw::Calibrated },
            dt: self.dt,
            material: self.changed(base),
            length: self.length.unwrap_or(case.length),
            width: self.width,
            gravity: self.gravity,
            damping_ratio: self.damping_ratio,
            angle: self.angle.unwrap_or(case.angle),
            friction: self.friction,
            restitution: self.restitution.unwrap_or(case.restitution),
            height: self.height.unwrap_or(case.height),
            speed: self.speed,
            throw: self.throw,
            rate: self.rate,
            dynamic: self.dynamic,
            outlined: self.outlined,
            boundary: self.boundary,
            modes: self.modes,
            side: self.side,
            patch: self.patch,
            radius: self.radius,
            hole: self.hole,
            box_side: self.box_side,
            sheets: self.sheets,
            corner: self.corner,
            edge_of_body: self.edge_of_body,
            on_sheet: self.on_sheet,
            refine: self.refine,
            threads: self.threads,
            thermal: self.heat.thermal(),
            celsius: self.heat.celsius,
            seconds: self.heat.seconds.unwrap_or(10.0),
        })
    }

    /// The material `base` with the constants that flags replace.
    fn changed(&self, base: Material) -> Material {
        Material {
            young: self.young.unwrap_or(base.young),
            poisson: self.poisson.unwrap_or(base.poisson),
            density: self.density.unwrap_or(base.density),
            thickness: self.thickness.unwrap_or(base.thickness),
            yield_stress: self.yield_stress.or(base.yield_stress),
            hardening: self.hardening.unwrap_or(base.hardening),
            burgers: self.burgers(base.burgers),
            ..base
        }
    }

    /// Creep constants: those of `base` or the defaults, replaced by the flags given.
    fn burgers(&self, base: Option<BurgersCreep>) -> Option<BurgersCreep> {
        let flags = [self.relaxation_time, self.retardation_time, self.retarded];
        let from = base.or_else(|| Setup::default().material.burgers.filter(|_| flags.iter().any(Option::is_some)));
        from.map(|b| BurgersCreep {
            relaxation_time: self.relaxation_time.unwrap_or(b.relaxation_time),
            retardation_time: self.retardation_time.unwrap_or(b.retardation_time),
            retarded: self.retarded.unwrap_or(b.retarded),
        })
    }
}

/// Changes of grid of the rig `detail` as a table: a row per shape, a column per change, with the
/// pop in percent of the deflection.
fn changes(value: &Value) -> Option<Vec<String>> {
    let mut rows: Vec<(&str, Vec<f64>)> = Vec::new();
    let mut columns: Vec<&str> = Vec::new();
    for change in value.as_array().filter(|all| !all.is_empty())? {
        let (shape, grids, pop) = (change["shape"].as_str()?, change["change"].as_str()?, change["pop"].as_f64()?);
        let column = columns.iter().position(|c| *c == grids).unwrap_or_else(|| {
            columns.push(grids);
            columns.len() - 1
        });
        let row = rows.iter().position(|r| r.0 == shape).unwrap_or_else(|| {
            rows.push((shape, Vec::new()));
            rows.len() - 1
        });
        let pops = &mut rows[row].1;
        pops.resize(pops.len().max(column + 1), f64::NAN);
        pops[column] = 100.0 * pop;
    }
    let mut lines = vec![format!("{:<12}", "pop, %") + &columns.iter().map(|c| format!("{c:>10}")).collect::<String>()];
    let cells = |pops: &[f64]| pops.iter().map(|p| format!("{p:>10.2}")).collect::<String>();
    lines.extend(rows.iter().map(|(shape, pops)| format!("{shape:<12}") + &cells(pops)));
    Some(lines)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::changes;

    #[test]
    fn changes_of_grid_are_printed_as_a_table() {
        let row = |shape: &str, change: &str, pop: f64| json!({ "shape": shape, "change": change, "pop": pop });
        let all =
            json!([row("droop", "11 to 21", 0.0031), row("box", "11 to 21", 0.0085), row("droop", "21 to 11", 0.01)]);
        let words = |line: &String| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>().join(" ");
        let lines: Vec<String> = changes(&all).expect("a table").iter().map(words).collect();
        assert_eq!(lines, ["pop, % 11 to 21 21 to 11", "droop 0.31 1.00", "box 0.85"]);
        assert_eq!(changes(&json!([1.0, 2.0])), None);
        assert_eq!(changes(&json!([])), None);
    }
}
