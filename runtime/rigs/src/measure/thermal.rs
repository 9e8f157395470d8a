//! Input of the thermal rigs, and a sheet that exchanges heat with its room.

use clap::Args;
use glam::DVec3;
use serde_json::Value;

use crate::measure::setup::flag_defaults;
use crate::measure::{RigOutcome, Setup, object};
use crate::quantities::{convection, parse_number, parse_vector, temperature as parse_temperature, time};
use sheetwork::scene::Scene;
use sheetwork::sheet::{Sheet, temperature};
use sheetwork::thermal::ThermalModel;
use sheetwork::thermal::source::HeatSource;
use sheetwork::{InputError, ParameterId as Id, check_range};

/// The situation of the thermal rigs. Each rig uses a part of the fields.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct Thermal {
    /// Corners of the polygon, m: "x,y,z;x,y,z;..." (view-factor).
    #[arg(long, default_value = "-0.5,1,-0.5;0.5,1,-0.5;0.5,1,0.5;-0.5,1,0.5")]
    #[arg(hide_default_value = true, value_parser = polygon, allow_hyphen_values = true)]
    pub polygon: Polygon,
    /// Position of the patch, m: x,y,z (view-factor).
    #[arg(long, default_value = "0,0,0", value_parser = vector, allow_hyphen_values = true)]
    pub point: DVec3,
    /// Normal of the patch: x,y,z (view-factor).
    #[arg(long, default_value = "0,1,0", value_parser = vector, allow_hyphen_values = true)]
    pub normal: DVec3,
    /// Fourier number: diffusivity times time over the length squared (conduction).
    #[arg(id = "fo", long, value_name = "FO", default_value = "0.1", value_parser = parse_number)]
    pub fourier: f64,
    /// Initial temperature, °C (cooling: default 120; radiate: that of the surroundings).
    #[arg(long, value_parser = parse_temperature)]
    pub from: Option<f64>,
    /// Final temperature, °C (cooling).
    #[arg(long, default_value = "60", value_parser = parse_temperature)]
    pub to: f64,
    /// Temperature of the surroundings, °C (cooling, radiate).
    #[arg(long, default_value = "20", value_parser = parse_temperature)]
    pub ambient: f64,
    /// Convection coefficient, sum of both sides, W/(m² K) (cooling, radiate).
    #[arg(long, default_value = "0", value_parser = convection)]
    pub convection: f64,
    /// Temperature of the black heater, °C (radiate).
    #[arg(long, default_value = "400", value_parser = parse_temperature)]
    pub heater: f64,
    /// View factor of the heater from one side (radiate).
    #[arg(long, default_value = "0.5", value_parser = parse_number)]
    pub view: f64,
    /// Duration, s (default 60 for radiate, 10 for creep).
    #[arg(long, value_parser = time)]
    pub seconds: Option<f64>,
    /// Temperature of the sheet, °C (default 100 for softening; for creep 40 K above the glass
    /// transition, or 20 without one).
    #[arg(long, value_parser = parse_temperature)]
    pub celsius: Option<f64>,
}

/// Corners of a polygon. The name keeps clap from taking them as a list of arguments.
type Polygon = Vec<DVec3>;

impl Default for Thermal {
    fn default() -> Self {
        flag_defaults()
    }
}

/// Parses three numbers separated by commas.
fn vector(text: &str) -> Result<DVec3, String> {
    parse_vector(text).map(DVec3::from_array)
}

fn polygon(text: &str) -> Result<Polygon, String> {
    text.split(';').filter(|p| !p.trim().is_empty()).map(vector).collect()
}

impl Thermal {
    /// Checks the range of every value.
    ///
    /// # Errors
    /// The first value out of range, named as its flag.
    pub fn check(&self) -> Result<(), InputError> {
        let warm = |name: &str, value: f64| Id::Temperature.check(name, value);
        let places = [("point", self.point), ("normal", self.normal)];
        let corners = self.polygon.iter().map(|p| ("polygon", *p));
        for (name, p) in corners.chain(places) {
            p.to_array().into_iter().try_for_each(|v| check_range(name, v, -1e6, 1e6, "m"))?;
        }
        if self.polygon.len() < 3 {
            return Err(InputError::new("polygon", format!("{} corners: it takes 3 at least", self.polygon.len())));
        }
        if self.normal == DVec3::ZERO {
            return Err(InputError::new("normal", "points nowhere"));
        }
        check_range("fo", self.fourier, 1e-6, 100.0, "")?;
        self.from.map_or(Ok(()), |from| warm("from", from))?;
        warm("to", self.to)?;
        warm("ambient", self.ambient)?;
        Id::Convection.check("convection", self.convection)?;
        warm("heater", self.heater)?;
        check_range("view", self.view, 0.0, 1.0, "")?;
        self.seconds.map_or(Ok(()), |seconds| check_range("seconds", seconds, 1e-6, 1e6, "s"))?;
        self.celsius.map_or(Ok(()), |celsius| warm("celsius", celsius))
    }
}

/// A sheet at rest in a room.
pub(crate) struct HeatRig {
    pub sheets: Vec<Sheet>,
    pub room: ThermalModel,
    pub time: f64,
    steps: u64,
    cpu: f64,
}

impl HeatRig {
    /// The sheet of `setup` at `from` °C, with the surroundings of `setup`.
    pub fn new(setup: &Setup, from: f64) -> Result<Self, InputError> {
        let mut scene: Scene = setup.scene();
        scene.ambient_temperature = setup.thermal.ambient;
        scene.convection = setup.thermal.convection;
        scene.sheets[0].temperature = Some(from);
        let room = ThermalModel::new(&scene)?;
        let mut sheet = Sheet::build(&scene, 0)?;
        temperature::start_temperatures(&mut sheet, from);
        Ok(Self { sheets: vec![sheet], room, time: 0.0, steps: 0, cpu: 0.0 })
    }

    /// Adds a heat source to the room.
    pub fn add(&mut self, source: Box<dyn HeatSource>) {
        self.room.add(source);
    }

    /// Takes a thermal step of `dt` s.
    pub fn step(&mut self, dt: f64) {
        let start = cpu_time::ProcessTime::now();
        self.room.step_whole(&mut self.sheets, (self.time, dt));
        self.cpu += start.elapsed().as_secs_f64();
        self.time += dt;
        self.steps += 1;
    }

    /// Mean temperature of the sheet's nodes, °C.
    pub fn mean(&self) -> f64 {
        let celsius = self.sheets[0].temperatures().unwrap_or_default();
        celsius.iter().sum::<f64>() / celsius.len().max(1) as f64
    }

    pub fn outcome(self, dt: f64, keys: Value) -> RigOutcome {
        outcome(dt, (self.steps, self.time, self.cpu), keys)
    }
}

/// Result of a rig without motion: step (s), steps, simulated time (s), CPU time (s), keys.
pub(crate) fn outcome(dt: f64, (steps, simulated, cpu): (u64, f64, f64), keys: Value) -> RigOutcome {
    let (keys, worst) = (object(keys), cpu / steps.max(1) as f64);
    RigOutcome { keys, dt, steps, simulated, cpu, worst, settled: None, stable: None, status: "ok".into() }
}
