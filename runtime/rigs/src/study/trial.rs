//! Scenes of the study, and the speed of each sheet in them.
//!
//! The sheets are those of the thesis: 11x2x11 nodes of 0.04 g, 2.5 cm square, its room and
//! gravity, springs of 405 mN/m (the second test, stiff, by rk4) and 205 mN/m (the third, by
//! euler-richardson) as in its table 3.1, and 305 mN/m in the first, which the thesis calls medium.
//! The shell has the stiffness of two layers with such springs: E t = 2 k and t = √3 h, with h
//! the distance of the layers, in membrane and bending.

use cpu_time::ProcessTime;
use serde::Serialize;
use sheetwork::scene::Scene;
use sheetwork::{InputError, World};

use crate::study::{SHEETS, TESTS};

/// Trial of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trial {
    /// Name of the test.
    pub test: &'static str,
    /// Name of the sheet.
    pub sheet: &'static str,
}

const CUBE: &str =
    r#"(name: "cube", shape: Box((0.016, 0.016, 0.016)), placement: (position: (-0.0015, -0.0201, -0.0015)))"#;
const WEDGE: &str = r#"(name: "wedge", shape: Polyhedron((
    vertices: [(-0.0165, -0.0281, 0.0145), (0.0135, -0.0281, 0.0145), (-0.0015, -0.0121, 0.0145),
        (-0.0165, -0.0281, -0.0175), (0.0135, -0.0281, -0.0175), (-0.0015, -0.0121, -0.0175)],
    faces: [[0, 1, 2], [5, 4, 3], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]])))"#;

/// Distance of the layers, m, and node mass, kg.
const GAP: f64 = 0.001;
const NODE: f64 = 4e-5;

/// Scene of a trial, called `title`, which need not reveal the sheet.
///
/// # Errors
/// None for tests of [`TESTS`] and sheets of [`SHEETS`]: the tests build each of them.
pub fn scene(trial: Trial, title: &str) -> Result<Scene, InputError> {
    let (body, stiffness, engine, dt) = match trial.test {
        "cube" => (CUBE, 0.305, "rk4", 0.005),
        "wedge1" => (WEDGE, 0.405, "rk4", 0.004),
        _ => (WEDGE, 0.205, "euler-richardson", 0.0025),
    };
    let (sheet, engine, dt) = match trial.sheet {
        "shell" => {
            let thickness = 3.0_f64.sqrt() * GAP;
            let nodes = f64::from(11 * 11 + 10 * 10);
            let density = nodes * NODE / (0.025 * 0.025 * thickness);
            let young = 2.0 * stiffness / thickness;
            let material = format!("(young: {young}, thickness: {thickness}, density: {density}, poisson: 0.3)");
            (
                format!(r#"structure: "shell", grid: (11, 1, 11), material: {material}, damping_ratio: 0.1"#),
                "tr-bdf2",
                1.0 / 60.0,
            )
        }
        lattice => {
            let layers = if lattice == "provot2d" { 1 } else { 2 };
            let material = format!("(young: {}, thickness: {GAP})", stiffness / GAP);
            (
                format!(
                    r#"structure: "{lattice}", grid: (11, {layers}, 11), gap: {GAP}, material: {material}, springs: Uniform,
                        node_mass: {NODE}"#
                ),
                engine,
                dt,
            )
        }
    };
    Ok(Scene::parse(&format!(
        r#"(name: "{title}", engine: "{engine}", dt: {dt}, gravity: (0, -0.981, 0), duration: 6,
            room: (x: (-0.065, 0.065), y: (-0.0281, 0.03), z: (-0.0299, 0.0333), grid: 0.005),
            contact: (friction: 0.3, restitution: 0.1), air: (factor: 0.97, per: 0.015),
            sheets: [({sheet}, size: (0.025, 0.025), placement: (position: (-0.0015, 0.0025, -0.0015)))],
            bodies: [{body}], camera: (eye: (0.036, 0.03, 0.066), target: (-0.0015, -0.0185, -0.002)))"#
    ))?)
}

/// Speed of one sheet in one test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrialSpeed {
    /// Test.
    pub test: &'static str,
    /// Sheet.
    pub sheet: &'static str,
    /// Integrator.
    pub engine: String,
    /// Step, s.
    pub dt_s: f64,
    /// Number of nodes.
    pub nodes: usize,
    /// Steps that were made.
    pub steps: u64,
    /// Steps per second of CPU time.
    pub steps_per_cpu_s: f64,
    /// Simulated time over CPU time; above 1 the sheet is faster than real.
    pub real_time_factor: f64,
    /// Whether the sheet stayed stable to the end.
    pub stable: bool,
}

/// Runs every sheet in every test for the time that a subject sees, and measures its CPU time.
///
/// # Errors
/// As [`scene`].
pub fn measure_speed() -> Result<Vec<TrialSpeed>, InputError> {
    let trials = TESTS.iter().flat_map(|test| SHEETS.iter().map(|sheet| Trial { test, sheet }));
    trials.map(speed_of).collect()
}

fn speed_of(trial: Trial) -> Result<TrialSpeed, InputError> {
    let scene = scene(trial, trial.test)?;
    let mut world = World::new(&scene)?;
    // A sheet that sleeps costs nothing, and when it falls asleep differs from sheet to sheet.
    world.set_sleep(false);
    let start = ProcessTime::now();
    while world.time() < scene.duration && world.unstable().is_none() {
        world.step();
    }
    // A clock of coarse resolution may read nothing.
    let cpu = start.elapsed().as_secs_f64().max(1e-9);
    Ok(TrialSpeed {
        test: trial.test,
        sheet: trial.sheet,
        engine: scene.engine.name().to_owned(),
        dt_s: scene.dt,
        nodes: world.sheets()[0].node_count(),
        steps: world.steps(),
        steps_per_cpu_s: world.steps() as f64 / cpu,
        real_time_factor: world.time() / cpu,
        stable: world.unstable().is_none(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sheet_of_the_study_falls_and_stays_stable() {
        for trial in TESTS.iter().flat_map(|test| SHEETS.iter().map(|sheet| Trial { test, sheet })) {
            let scene = scene(trial, "x").expect("valid");
            let mut world = World::new(&scene).expect("valid");
            let height = world.sheets()[0].centre_of_mass().y;
            world.advance(1.2);
            let now = world.sheets()[0].centre_of_mass().y;
            assert!(world.unstable().is_none() && now < height - 0.008, "{trial:?}: {height} {now}");
        }
    }
}
