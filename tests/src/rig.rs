//! Virtual test rigs in tests: run one and read its numbers.

use serde_json::Value;
use sheetwork_rigs::measure::{Setup, measure};

/// Result of a rig.
///
/// # Panics
/// An invalid set-up, or a sheet that became unstable.
pub fn measured(case: &str, setup: &Setup) -> Value {
    let found = measure(case, setup).unwrap_or_else(|e| panic!("{case}: {e}"));
    assert_eq!(found["status"], "ok", "{case}: {found}");
    found
}

/// The number `key` of a result.
///
/// # Panics
/// A missing number.
pub fn number(found: &Value, key: &str) -> f64 {
    found[key].as_f64().unwrap_or_else(|| panic!("{key} is {} in {found}", found[key]))
}
