//! A square sheet with a round hole in its middle, clamped or supported along its outer edges: its
//! slowest vibrations without gravity, and the sag of the hole's rim with gravity.
//!
//! Supported edges are fixed vertically, with free rotation and in-plane motion.

use serde_json::json;

use crate::measure::{Boundary, RigResult, Runner, Setup};
use sheetwork::InputError;
use sheetwork::mesh::outline::HoleSpec;
use sheetwork::scene::{PinSpec, Region, Scene};
use sheetwork::sheet::Sheet;

const EDGES: [Region; 4] = [Region::Left, Region::Right, Region::Back, Region::Front];

pub(crate) fn run(setup: &Setup) -> RigResult {
    let side = setup.side.unwrap_or(setup.length);
    let setup = &Setup { length: side, width: side, ..setup.clone() };
    let radius = 0.5 * setup.hole;
    let mut scene = setup.scene();
    scene.sheets[0].holes = vec![HoleSpec::Disc { centre: (0.0, 0.0), radius }];
    match setup.boundary {
        // The edges are clamped by default.
        Boundary::Clamped | Boundary::Cantilever => scene.sheets[0].pins = EDGES.map(PinSpec::clamped).to_vec(),
        Boundary::Supported => support(&mut scene, setup)?,
        Boundary::Free => {
            return Err(InputError::new("boundary", "a sheet with a hole is supported or clamped"));
        }
    }
    let mut runner = Runner::new(setup.world(&scene)?);
    let modes = runner.world.sheets_mut()[0].modes(setup.modes as usize);
    let solves = runner.bring_to_rest(setup);
    let sheet = &runner.world.sheets()[0];
    let rim = rim(sheet, radius, side);
    let sag = rim.iter().map(|m| -sheet.state.x.get(*m as usize).y).sum::<f64>() / rim.len().max(1) as f64;
    let keys = json!({
        "boundary": if setup.boundary == Boundary::Cantilever { "clamped" } else { setup.boundary.name() },
        "length_m": side,
        "width_m": side,
        "hole_diameter_m": setup.hole,
        "masses": sheet.node_count(),
        "omega_rad_s": modes.iter().map(|m| m.omega).collect::<Vec<f64>>(),
        "rim_sag_m": sag,
        "linear_solves": solves,
    });
    Ok(runner.outcome(keys))
}

/// Fixes the edges vertically, and the rigid in-plane motion at nodes without reaction force.
fn support(scene: &mut Scene, setup: &Setup) -> Result<(), InputError> {
    let axes = |region, axes| PinSpec { axes, ..PinSpec::fixed(region) };
    let level = EDGES.map(|edge| axes(edge, (false, true, false)));
    // The nodes in the middle of edges are known only from a built sheet.
    let world = setup.world(scene)?;
    let sheet = &world.sheets()[0];
    let nearest = |u: f64, v: f64| {
        let distance = |i: &usize| (sheet.model.uv[*i].0 - u).powi(2) + (sheet.model.uv[*i].1 - v).powi(2);
        (0..sheet.node_count()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0) as u32
    };
    let (left, back) = (nearest(0.0, 0.5), nearest(0.5, 0.0));
    let right = nearest(1.0, 0.5);
    scene.sheets[0].pins.extend(level);
    scene.sheets[0].pins.extend([
        axes(Region::Masses(vec![left]), (false, true, true)),
        axes(Region::Masses(vec![right]), (false, true, true)),
        axes(Region::Masses(vec![back]), (true, true, false)),
    ]);
    Ok(())
}

/// Nodes on the rim of the hole.
fn rim(sheet: &Sheet, radius: f64, side: f64) -> Vec<u32> {
    let away = |i: u32| {
        let (u, v) = sheet.model.uv[i as usize];
        (((u - 0.5) * side).hypot((v - 0.5) * side) - radius).abs()
    };
    (0..sheet.node_count() as u32).filter(|i| sheet.model.border[*i as usize] && away(*i) < 1e-3 * radius).collect()
}
