//! Slowest vibrations of a flat sheet without gravity: modes of the linearised sheet, and the
//! slowest one as the integrator simulates it.
//!
//! Boundaries: `cantilever` one edge clamped, `clamped` all edges, `supported` all edges fixed in
//! position with free rotation, `free` none (without rigid modes). The simulation starts in the
//! shape of the slowest mode with a small velocity; its frequency follows from the zero crossings
//! of the amplitude.

use serde_json::json;

use crate::measure::release::cubic;
use crate::measure::{Boundary, RigResult, Runner, Setup, bisect};
use sheetwork::scene::{PinSpec, Region, Scene};
use sheetwork::sheet::{Mode, Sheet};

/// Half periods of the simulated vibration.
const CROSSINGS: usize = 8;
/// Largest displacement as a fraction of the thickness, in the linear range.
const AMPLITUDE: f64 = 0.01;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = Setup { damping_ratio: 0.0, gravity: 0.0, ..setup.clone() }.scene();
    add_boundary_pins(setup.boundary, &mut scene);
    let mut runner = Runner::new(setup.world(&scene)?);
    let rigid = if setup.boundary == Boundary::Free { 6 } else { 0 };
    let modes = runner.world.sheets_mut()[0].modes(setup.modes as usize + rigid);
    let modes: Vec<Mode> = modes.into_iter().skip(rigid).collect();
    let motion = modes.first().and_then(|mode| vibrate(setup, &mut runner, mode));
    let keys = json!({
        "boundary": setup.boundary.name(),
        "omega_rad_s": modes.iter().map(|m| m.omega).collect::<Vec<f64>>(),
        "omega_motion_rad_s": motion,
    });
    Ok(runner.outcome(keys))
}

/// Pins of a boundary condition.
pub(crate) fn add_boundary_pins(boundary: Boundary, scene: &mut Scene) {
    let all = [Region::Left, Region::Right, Region::Back, Region::Front];
    let pins = match boundary {
        Boundary::Cantilever => vec![PinSpec::clamped(Region::Left)],
        Boundary::Clamped => all.map(PinSpec::clamped).to_vec(),
        Boundary::Supported => all.map(PinSpec::fixed).to_vec(),
        Boundary::Free => Vec::new(),
    };
    scene.sheets[0].pins.extend(pins);
}

/// Simulates vibration in `mode` and returns its angular frequency, rad/s.
pub(crate) fn vibrate(setup: &Setup, runner: &mut Runner, mode: &Mode) -> Option<f64> {
    if mode.omega <= 0.0 {
        return None;
    }
    let sheet = &mut runner.world.sheets_mut()[0];
    let largest = mode.shape.max_squared().sqrt();
    let speed = AMPLITUDE * setup.material.thickness * mode.omega / largest;
    for i in 0..sheet.node_count() {
        let v = mode.shape.get(i) * speed;
        sheet.state.v.set(i, v);
    }
    let rest = sheet.state.x.clone();
    let amplitude = |sheet: &Sheet| -> f64 {
        (0..sheet.node_count())
            .map(|i| sheet.node_mass(i) * mode.shape.get(i).dot(sheet.state.x.get(i) - rest.get(i)))
            .sum()
    };
    let rate = |sheet: &Sheet| -> f64 {
        (0..sheet.node_count()).map(|i| sheet.node_mass(i) * mode.shape.get(i).dot(sheet.state.v.get(i))).sum()
    };
    let mut last = (0.0, 0.0, rate(&runner.world.sheets()[0]));
    let mut crossings: Vec<f64> = Vec::new();
    let longest = 3.0 * CROSSINGS as f64 * std::f64::consts::PI / mode.omega;
    runner.run(longest, |world| {
        let sheet = &world.sheets()[0];
        let now = (world.time(), amplitude(sheet), rate(sheet));
        if last.1 * now.1 < 0.0 {
            crossings.push(zero(last, now));
        }
        last = now;
        crossings.len() <= CROSSINGS
    });
    let (first, end) = (crossings.first()?, crossings.last()?);
    let halves = crossings.len() - 1;
    (halves > 0).then(|| std::f64::consts::PI * halves as f64 / (end - first))
}

/// Zero of the cubic through two times with values and slopes.
fn zero(a: (f64, f64, f64), b: (f64, f64, f64)) -> f64 {
    a.0 + bisect((0.0, 1.0), 60, |s| cubic(a, b, s) * a.1 > 0.0).0 * (b.0 - a.0)
}
