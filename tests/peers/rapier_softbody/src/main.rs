//! Rapier's soft body on the square cantilever: one JSON object a configuration, on standard
//! output.
//!
//!     rapier_softbody [--grid 11,21] [--case cantilever|release] [--hz 60]
//!         [--solver fem|constraints] [--hinges lines|surface]
//!
//! The sheet: 0.25 m square, 0.5 mm thick, E 3 GPa, Poisson ratio 0, 1050 kg/m³, clamped along one
//! edge, let go from flat. `cantilever` is damped and stepped until no mass moves faster than 1
//! mm/s for 0.5 s, 10 s at most; `release` has no damping but the integrator's own and reports the
//! first extreme of the free edge's mean, interpolated between steps; it runs for 2 s.
//!
//! Settings of Rapier, with reasons:
//! - `fem`: its implicit solver, one substep a step (four cost four times as much and rest no
//!   nearer), up to 1000 iterations of its conjugate gradients: with its default of 20, and at
//!   21x21 with 100, the sheet is not held at all.
//! - `constraints`: its default solver, with 16 substeps and 10 iterations in each; it never comes
//!   to rest.
//! - Hinges and springs: see `sheet.rs`. Rapier takes frequencies, not E and t; they are computed,
//!   none is fitted.
//! - Damping in `cantilever`: with `fem` proportional to stiffness, 0.05 s, a third of critical in
//!   the first mode; with `constraints` its default, every spring critical by itself (more makes it
//!   creep and look settled at twice the drop).
//! - Nothing can touch: the sheet has no collider.
//!
//! CPU time is that of the process over `step` alone; the crate's `parallel` feature is off.

mod reference;
mod sheet;

use cpu_time::ProcessTime;
use rapier3d::prelude::*;

use crate::sheet::{DENSITY, GRAVITY, Grid, Hinges, LENGTH, THICKNESS, YOUNG};

const REST_SPEED: f64 = 1e-3;
const REST_TIME: f64 = 0.5;
const LONGEST: f64 = 10.0;
const RELEASE_TIME: f64 = 2.0;
const DAMPING: f64 = 0.05;

/// The command line.
struct Options {
    grids: Vec<usize>,
    release: bool,
    hz: f64,
    fem: bool,
    hinges: Hinges,
}

impl Options {
    fn parse() -> Result<Self, String> {
        let mut options = Self { grids: vec![11, 21], release: false, hz: 60.0, fem: true, hinges: Hinges::Lines };
        let mut words = std::env::args().skip(1);
        while let Some(flag) = words.next() {
            let value = words.next().ok_or_else(|| format!("{flag} needs a value"))?;
            let bad = || format!("{flag} cannot be \"{value}\"");
            match (flag.as_str(), value.as_str()) {
                ("--grid", _) => {
                    let grids: Result<_, _> = value.split(',').map(str::parse).collect();
                    options.grids = grids.map_err(|_| bad())?;
                }
                ("--case", "cantilever" | "release") => options.release = value == "release",
                ("--hz", _) => options.hz = value.parse().map_err(|_| bad())?,
                ("--solver", "fem" | "constraints") => options.fem = value == "fem",
                ("--hinges", "lines") => options.hinges = Hinges::Lines,
                ("--hinges", "surface") => options.hinges = Hinges::Surface,
                _ => return Err(bad()),
            }
        }
        let good = options.grids.iter().all(|n| (5..=200).contains(n)) && options.hz > 0.0;
        good.then_some(options).ok_or_else(|| "--grid is 5 to 200 and --hz above 0".into())
    }
}

/// A world with the sheet, its free edge, and the CPU time of its steps, s.
struct Rig {
    world: PhysicsWorld,
    sheet: SoftBodyHandle,
    edge: std::ops::Range<usize>,
    time: f64,
    cpu: f64,
}

impl Rig {
    fn new(options: &Options, n: usize) -> Self {
        let grid = Grid::new(n);
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, -GRAVITY, 0.0);
        let parameters = &mut world.integration_parameters;
        parameters.dt = 1.0 / options.hz;
        parameters.num_solver_iterations = if options.fem { 1 } else { 16 };
        parameters.soft_bodies.fem.max_linear_iterations = 1000;
        let solver = if options.fem { SoftBodySolver::Fem } else { SoftBodySolver::Constraints };
        let damping = |omega: f64| match (options.release, options.fem) {
            (true, _) => 0.0,
            (false, true) => 0.5 * DAMPING * omega,
            (false, false) => 1.0,
        };
        let body = grid.body(options.hinges, damping).solver(solver).additional_pgs_iterations(10);
        let sheet = world.insert_soft_body(body);
        Self { world, sheet, edge: grid.free_edge(), time: 0.0, cpu: 0.0 }
    }

    fn step(&mut self) {
        let start = ProcessTime::now();
        self.world.step();
        self.cpu += start.elapsed().as_secs_f64();
        self.time += self.world.integration_parameters.dt;
    }

    /// How far the mean of the free edge hangs below the clamp, m.
    fn drop(&self) -> f64 {
        let sheet = &self.world.soft_bodies[self.sheet];
        -self.edge.clone().map(|i| sheet.particle_position(i).y).sum::<f64>() / self.edge.len() as f64
    }

    fn fastest(&self) -> f64 {
        self.world.soft_bodies[self.sheet].particle_velocities().map(|v| v.length()).fold(0.0, f64::max)
    }

    /// Steps until at rest; whether it came to rest.
    fn settle(&mut self) -> bool {
        let mut still = 0.0;
        while self.time < LONGEST && still < REST_TIME && self.drop().is_finite() {
            self.step();
            still = if self.fastest() < REST_SPEED { still + self.world.integration_parameters.dt } else { 0.0 };
        }
        still >= REST_TIME
    }

    /// Steps for `RELEASE_TIME`; drop, m, and time, s, of the first extreme, on a parabola through
    /// three steps.
    fn first_extreme(&mut self) -> Option<(f64, f64)> {
        let dt = self.world.integration_parameters.dt;
        let mut drops = vec![self.drop()];
        while self.time < RELEASE_TIME {
            self.step();
            drops.push(self.drop());
        }
        let middle = (1..drops.len() - 1).find(|&k| drops[k] >= drops[k + 1])?;
        let (before, at, after) = (drops[middle - 1], drops[middle], drops[middle + 1]);
        let shift = 0.5 * (before - after) / (before - 2.0 * at + after);
        Some((at - 0.25 * (before - after) * shift, (middle as f64 + shift) * dt))
    }
}

/// The JSON object of one configuration.
fn measure(options: &Options, n: usize) -> String {
    let mut rig = Rig::new(options, n);
    let label = match (options.fem, options.hinges) {
        (true, Hinges::Lines) => "implicit, line hinges",
        (true, Hinges::Surface) => "implicit, its triangulation",
        (false, Hinges::Lines) => "constraints, line hinges",
        (false, Hinges::Surface) => "constraints, its triangulation",
    };
    let (case, own) = if options.release {
        let (depth, at) = rig.first_extreme().map_or((None, None), |(depth, at)| (Some(depth), Some(at)));
        (
            "release",
            format!(r#""first_extreme_m": {}, "first_extreme_s": {}, "settled": null"#, or_null(depth), or_null(at)),
        )
    } else {
        let settled = rig.settle();
        let gamma = 12.0 * DENSITY * GRAVITY * LENGTH.powi(3) / (YOUNG * THICKNESS * THICKNESS);
        let reference = reference::tip_drop(gamma) * LENGTH;
        let drop = Some(rig.drop()).filter(|d| d.is_finite());
        let error = or_null(drop.map(|d| d / reference - 1.0));
        let drop = or_null(drop);
        (
            "cantilever",
            format!(r#""drop_m": {drop}, "reference_drop_m": {reference}, "error": {error}, "settled": {settled}"#),
        )
    };
    format!(
        r#"{{"peer": "Rapier soft body", "version": "0.36.1 f64", "case": "{case}", "grid": {n}, "dt_s": {}, "label": "{label}", "simulated_s": {}, "cpu_ms_per_simulated_s": {}, {own}}}"#,
        1.0 / options.hz,
        rig.time,
        1e3 * rig.cpu / rig.time,
    )
}

fn or_null(value: Option<f64>) -> String {
    value.map_or_else(|| "null".into(), |v| v.to_string())
}

fn main() -> std::process::ExitCode {
    match Options::parse() {
        Ok(options) => {
            for &n in &options.grids {
                println!("{}", measure(&options, n));
            }
            std::process::ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("error: {message}");
            std::process::ExitCode::from(2)
        }
    }
}
