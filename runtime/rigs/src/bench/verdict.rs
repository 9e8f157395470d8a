//! Error of a rig's result: the quantity of each rig and its deviation from the reference, as a
//! fraction.
//!
//! For a rig with two quantities, depth and time of the first extreme, the larger error counts.

use serde_json::Value;

/// A reference value, by the key in the rig's JSON.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceTarget {
    /// Key of the rig's JSON.
    pub quantity: &'static str,
    /// Reference value, in the unit at the end of the key.
    pub value: f64,
    /// Uncertainty of the reference as a fraction; smaller deviations count as zero.
    pub uncertain: f64,
}

impl ReferenceTarget {
    /// A value without uncertainty.
    pub fn exact(quantity: &'static str, value: f64) -> Self {
        Self { quantity, value, uncertain: 0.0 }
    }
}

/// A quantity and its error.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    pub quantity: &'static str,
    pub measured: Option<f64>,
    pub reference: Option<f64>,
    pub error: Option<f64>,
}

/// Quantities that define the error of each rig; none for a rig without error.
pub fn quantities(case: &str) -> &'static [&'static str] {
    match case {
        "cantilever" => &["drop_m"],
        "release" => &["first_extreme_m", "first_extreme_s"],
        "pedestal" => &["corner_drop_m"],
        "frequency" => &["omega_motion_rad_s"],
        _ => &[],
    }
}

/// Compares a rig's result with its targets.
pub fn compare_with_targets(case: &str, found: &Value, targets: &[ReferenceTarget]) -> Verdict {
    let mut worst: Option<(f64, Verdict)> = None;
    for &quantity in quantities(case) {
        let measured = number(&found[quantity]);
        let target = targets.iter().find(|t| t.quantity == quantity);
        let reference = target.map(|t| t.value);
        let error = measured.zip(reference).map(|(m, r)| (m / r - 1.0).abs()).filter(|e| e.is_finite());
        let verdict = Verdict { quantity, measured, reference, error };
        // A missing result is the largest error. A deviation within the uncertainty counts as zero.
        let says = |e: &f64| *e > target.map_or(0.0, |t| t.uncertain);
        let size = error.map_or(f64::INFINITY, |e| Some(e).filter(says).unwrap_or(0.0));
        if worst.as_ref().is_none_or(|(most, _)| size > *most) {
            worst = Some((size, verdict));
        }
    }
    worst.map(|(_, verdict)| verdict).unwrap_or(Verdict { quantity: "", measured: None, reference: None, error: None })
}

/// A number, or the first number of a list.
pub fn number(value: &Value) -> Option<f64> {
    value.as_f64().or_else(|| value.get(0).and_then(Value::as_f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_larger_of_two_errors_counts() {
        let time = ReferenceTarget { quantity: "first_extreme_s", value: 0.2, uncertain: 0.01 };
        let targets = [ReferenceTarget::exact("first_extreme_m", 0.1), time];
        let late =
            compare_with_targets("release", &json!({ "first_extreme_m": 0.101, "first_extreme_s": 0.21 }), &targets);
        assert_eq!(late.quantity, "first_extreme_s");
        assert!((late.error.expect("it has an error") - 0.05).abs() < 1e-12);
        let within =
            compare_with_targets("release", &json!({ "first_extreme_m": 0.1001, "first_extreme_s": 0.201 }), &targets);
        assert_eq!(within.quantity, "first_extreme_m");
        let never =
            compare_with_targets("release", &json!({ "first_extreme_m": null, "first_extreme_s": 0.2 }), &targets);
        assert_eq!((never.quantity, never.error), ("first_extreme_m", None));
    }
}
