//! View factor of a polygon from a small patch.

use serde_json::json;

use crate::measure::thermal::outcome;
use crate::measure::{RigCase, RigOutcome, Setup};
use sheetwork::InputError;
use sheetwork::thermal::view_factor::view_factor;

pub(crate) const CASE: RigCase = RigCase {
    name: "view-factor",
    about: "share of a patch's view that a polygon takes up: --polygon, --point, --normal",
    contact: false,
    run,
};

fn run(setup: &Setup) -> Result<RigOutcome, InputError> {
    let t = &setup.thermal;
    let found = view_factor(&t.polygon, t.point, t.normal);
    Ok(outcome(0.0, (0, 0.0, 0.0), json!({ "view_factor": found })))
}
