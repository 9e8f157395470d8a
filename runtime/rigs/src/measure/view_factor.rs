//! View factor of a polygon from a small patch.

use serde_json::json;

use crate::measure::thermal::outcome;
use crate::measure::{RigResult, Setup};
use sheetwork::thermal::view_factor::view_factor;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let t = &setup.thermal;
    let found = view_factor(&t.polygon, t.point, t.normal);
    Ok(outcome(0.0, (0, 0.0, 0.0), json!({ "view_factor": found })))
}
