//! View factor of a polygon from a small patch.

use serde_json::json;

use crate::measure::thermal::outcome;
use crate::measure::{RigCase, RigResult, Setup};
use sheetwork::thermal::view_factor::view_factor;

pub(crate) const CASE: RigCase =
    RigCase::new("view-factor", "share of a patch's view that a polygon takes up: --polygon, --point, --normal", run);

fn run(setup: &Setup) -> RigResult {
    let t = &setup.thermal;
    let found = view_factor(&t.polygon, t.point, t.normal);
    Ok(outcome(0.0, (0, 0.0, 0.0), json!({ "view_factor": found })))
}
