//! Slowest vibrations of a round sheet without gravity, with a clamped or free rim.
//!
//! The grid counts nodes across. Closed forms: clamped ω = 10.2158/R² √(D/ρt); free (ν = 0.3)
//! 5.358/R² √(D/ρt), a double mode.

use serde_json::json;

use crate::measure::{Boundary, RigResult, Runner, Setup};
use sheetwork::mesh::outline::OutlineSpec;
use sheetwork::scene::{PinSpec, Region};

pub(crate) fn run(setup: &Setup) -> RigResult {
    let across = 2.0 * setup.radius;
    let setup = &Setup { damping_ratio: 0.0, gravity: 0.0, length: across, width: across, ..setup.clone() };
    let mut scene = setup.scene();
    let sheet = &mut scene.sheets[0];
    sheet.outline = Some(OutlineSpec::Disc { radius: setup.radius });
    let rigid = match setup.boundary {
        Boundary::Free => 6,
        // The rim is clamped by default.
        Boundary::Clamped | Boundary::Cantilever => {
            sheet.pins.push(PinSpec::clamped(Region::Border));
            0
        }
        Boundary::Supported => {
            sheet.pins.push(PinSpec::fixed(Region::Border));
            0
        }
    };
    let mut runner = Runner::new(setup.world(&scene)?);
    let modes = runner.world.sheets_mut()[0].modes(setup.modes as usize + rigid);
    let keys = json!({
        "boundary": if setup.boundary == Boundary::Cantilever { "clamped" } else { setup.boundary.name() },
        "length_m": across,
        "width_m": across,
        "radius_m": setup.radius,
        "masses": runner.world.sheets()[0].node_count(),
        "omega_rad_s": modes.iter().skip(rigid).map(|m| m.omega).collect::<Vec<f64>>(),
    });
    Ok(runner.outcome(keys))
}
