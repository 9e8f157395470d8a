//! A pile of sheets dropped flat on a floor, 1 mm apart. They must come to rest on one another
//! without overlap or drift.

use glam::DVec3;
use serde_json::json;

use crate::measure::contact_observer::{self, ContactObserver};
use crate::measure::{RigOutcome, RigResult, Runner, Setup, plane};
use sheetwork::collision::overlap::pairs;
use sheetwork::scene::{Placement, SheetSpec};
use sheetwork::sheet::Sheet;

/// Distance between the sheets, and of the lowest sheet from the floor, m.
const APART: f64 = 1e-3;
/// Time limit to come to rest, s.
const REST_TIMEOUT: f64 = 5.0;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = setup.scene();
    let sheet = Sheet::build(&scene, 0)?;
    let (low, high) = sheet.state.x.bounds().unwrap_or_default();
    let half = setup.contact_offset()?;
    let pitch = high.y - low.y + 2.0 * half + APART;
    let spec = scene.sheets[0].clone();
    scene.sheets = (0..setup.sheets)
        .map(|i| SheetSpec {
            name: format!("sheet {i}"),
            placement: Placement { position: DVec3::Y * (APART + half + f64::from(i) * pitch), ..spec.placement },
            ..spec.clone()
        })
        .collect();
    scene.bodies.push(plane("floor", Placement::default()));
    let mut runner = Runner::new(setup.world_with_sleep(&scene)?);
    runner.world.set_threads(setup.threads as usize)?;
    let mut watch = ContactObserver::new(&runner.world);
    let start = contact_observer::centres(&runner.world);
    let scale: f64 = (0..setup.sheets)
        .map(|i| contact_observer::fall_energy(&runner.world, f64::from(i + 1) * APART) / f64::from(setup.sheets))
        .sum();
    watch.run_to_sleep(&mut runner, REST_TIMEOUT);
    let overlaps = pairs(runner.world.sheets(), 0.0);
    let own = json!({
        "sheets": setup.sheets,
        "friction": setup.friction,
        "drift_m": contact_observer::drift(&runner.world, &start),
        "in_order": contact_observer::is_in_order(&runner.world),
        "max_sheet_overlap_m": watch.sheets,
        "max_floor_penetration_m": watch.masses,
        "overlap_at_rest_m": overlaps.iter().map(|(_, _, overlap)| *overlap).fold(0.0, f64::max),
        "overlapping_pairs_at_rest": overlaps.len(),
        "height_m": runner.world.sheets().last().map(|s| s.centre_of_mass().y),
        "height_without_overlap_m": half + f64::from(setup.sheets - 1) * (pitch - APART),
    });
    let settled = Some(watch.still_since().is_some());
    Ok(RigOutcome { settled, ..runner.contact_outcome(&watch, scale, own) })
}
