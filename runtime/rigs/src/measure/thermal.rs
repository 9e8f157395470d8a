//! Input of the thermal rigs, and a sheet that exchanges heat with its room.

use glam::DVec3;
use serde_json::Value;

use crate::measure::{RigOutcome, Setup, object};
use sheetwork::scene::Scene;
use sheetwork::sheet::{Sheet, temperature};
use sheetwork::thermal::ThermalModel;
use sheetwork::thermal::source::HeatSource;
use sheetwork::{InputError, ParameterId as Id, check_range};

/// The situation of the thermal rigs. Each rig uses a part of the fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Thermal {
    /// Corners of a polygon, m.
    pub polygon: Vec<DVec3>,
    /// Position of a patch, m.
    pub point: DVec3,
    /// Normal of the patch, of any length but 0.
    pub normal: DVec3,
    /// Fourier number κ τ/L², 1e-6 to 100.
    pub fourier: f64,
    /// Initial temperature, °C, -273.15 to 5000. `None` gives 120 for cooling and the surroundings'
    /// temperature for heating.
    pub from: Option<f64>,
    /// Final temperature, °C, -273.15 to 5000.
    pub to: f64,
    /// Temperature of the surroundings, °C, -273.15 to 5000.
    pub ambient: f64,
    /// Convection coefficient, sum of both sides, W/(m² K), 0 to 1e6.
    pub convection: f64,
    /// Temperature of a heater, °C, -273.15 to 5000.
    pub heater: f64,
    /// View factor of the heater from one side, 0 to 1.
    pub view: f64,
    /// Duration, s, 1e-6 to 1e6.
    pub seconds: f64,
    /// Temperature of the sheet, °C, -273.15 to 5000.
    pub celsius: f64,
}

impl Default for Thermal {
    fn default() -> Self {
        let square = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
        Self {
            polygon: square.map(|(x, z)| DVec3::new(x, 1.0, z)).to_vec(),
            point: DVec3::ZERO,
            normal: DVec3::Y,
            fourier: 0.1,
            from: None,
            to: 60.0,
            ambient: 20.0,
            convection: 0.0,
            heater: 400.0,
            view: 0.5,
            seconds: 60.0,
            celsius: 100.0,
        }
    }
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
        check_range("seconds", self.seconds, 1e-6, 1e6, "s")?;
        warm("celsius", self.celsius)
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
