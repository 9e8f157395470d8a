//! `measure`: JSON keys, numbers and flags of each rig.

use serde_json::Value;

use super::common::{TestFolder, keys};

/// Keys common to all rigs.
const COMMON: [&str; 11] = [
    "case",
    "structure",
    "grid",
    "engine",
    "dt_s",
    "steps",
    "simulated_s",
    "cpu_s",
    "cpu_ms_per_simulated_s",
    "settled",
    "status",
];

/// Flags that make a rig fast.
const FAST: [&str; 5] = ["--json", "--young", "1e5", "--grid", "5x5"];

fn measure(place: &TestFolder, case: &str, flags: &[&str]) -> Value {
    place.json(&[&["measure", case], &FAST[..], flags].concat())
}

fn number(found: &Value, key: &str) -> f64 {
    found[key].as_f64().unwrap_or_else(|| panic!("{key} in {found}"))
}

#[test]
fn every_rig_has_the_keys_of_the_contract() {
    let place = TestFolder::new("measure-keys");
    let own: [(&str, &[&str]); 13] = [
        ("fold", &["angle_deg", "predicted_deg", "folded_deg", "springback_deg"]),
        ("creep", &["compliance", "expected_compliance", "compliance_error", "deflection_m", "temperature_c"]),
        ("incline", &["slid", "acceleration_m_s2", "creep_m_s", "creep_asleep_m_s"]),
        ("bounce", &["heights_m", "energy_ratio"]),
        (
            "drop-box",
            &[
                "max_penetration_m",
                "corner_below_centre_m",
                "at_rest_s",
                "energy_gain",
                "cpu_ms_per_step",
                "worst_step_ms",
            ],
        ),
        ("edge-landing", &["max_penetration_m", "energy_gain", "rebound_m", "rebound_speed_m_s"]),
        ("stack", &["max_penetration_m", "drift_m", "at_rest_s"]),
        ("weight", &["support_force_ratio"]),
        ("impact", &["momentum_error", "angular_momentum_error"]),
        ("free-fall", &["drop_error_m"]),
        ("oscillator", &["order", "stability_limit"]),
        ("slide", &["distance_m"]),
        ("spin", &["angular_momentum_ratio", "energy_ratio"]),
    ];
    for (case, wanted) in own {
        // A pile of many large sheets takes minutes.
        let small: &[&str] = if case == "stack" { &["--sheets", "2"] } else { &[] };
        let found = measure(&place, case, small);
        let keys = keys(&found);
        for key in COMMON.iter().chain(&["setup_cpu_s", "length_m", "width_m"]).chain(wanted) {
            assert!(keys.contains(key), "{case}: no {key}");
        }
        assert_eq!((found["case"].as_str(), found["status"].as_str()), (Some(case), Some("ok")));
        let coarse: &[&str] = match case {
            "stack" => &["--sheets", "2", "--grid", "5x5"],
            _ => &["--young", "1e5", "--grid", "5x5"],
        };
        assert!(place.run(&[&["measure", case], coarse].concat()).out.contains(case));
    }
}

#[test]
fn rigs_reproduce_known_results() {
    let place = TestFolder::new("measure-numbers");
    let slides = measure(&place, "incline", &["--angle", "30", "--friction", "0.3"]);
    let expected = 9.81 * (30_f64.to_radians().sin() - 0.3 * 30_f64.to_radians().cos());
    assert_eq!(slides["slid"], true);
    assert!((number(&slides, "acceleration_m_s2") / expected - 1.0).abs() < 0.01, "{slides}");
    let sticks = measure(&place, "incline", &["--angle", "15", "--friction", "0.3"]);
    assert_eq!((sticks["slid"].as_bool(), sticks["acceleration_m_s2"].as_f64()), (Some(false), Some(0.0)));
    let bounce = measure(&place, "bounce", &["--height", "0.1", "--restitution", "0.6"]);
    let first = bounce["heights_m"][0].as_f64().expect("a height");
    assert!((first / 0.036 - 1.0).abs() < 0.01, "{first}");
    let slide = measure(&place, "slide", &["--speed", "0.5", "--friction", "0.4"]);
    assert!((number(&slide, "distance_m") / (0.25 / (2.0 * 0.4 * 9.81)) - 1.0).abs() < 0.01, "{slide}");
    assert!(number(&measure(&place, "free-fall", &[]), "drop_error_m").abs() < 1e-9);
    let spin = measure(&place, "spin", &["--rate", "5"]);
    assert!((number(&spin, "angular_momentum_ratio") - 1.0).abs() < 1e-2, "{spin}");
    let flags = ["--rate", "5", "--structure", "trimm", "--engine", "verlet"];
    let spin = measure(&place, "spin", &flags);
    assert!((number(&spin, "angular_momentum_ratio") - 1.0).abs() < 1e-9, "{spin}");
}

#[test]
fn measured_orders_and_limits_equal_the_table_of_integrators() {
    let place = TestFolder::new("measure-oscillator");
    let rows = place.json(&["list", "engines", "--json"]);
    for row in rows.as_array().expect("rows") {
        let name = row["name"].as_str().expect("a name");
        let found = measure(&place, "oscillator", &["--engine", name]);
        assert!((number(&found, "order") - number(row, "order")).abs() < 0.2, "{name}: {found}");
        // An adaptive integrator shortens its steps before any limit.
        if row["implicit"] == true {
            // The limit is infinite, which JSON cannot represent.
            assert!(found["stability_limit"].is_null() && row["stability_limit"].is_null(), "{name}: {found}");
        } else if row["adaptive"] == false {
            let (limit, tabled) = (number(&found, "stability_limit"), number(row, "stability_limit"));
            assert!((limit - tabled).abs() <= 0.02 * tabled, "{name}: {limit}, tabled {tabled}");
        }
    }
}

#[test]
fn flags_choose_the_sheet() {
    let place = TestFolder::new("measure-sheet");
    let found = measure(&place, "free-fall", &["--structure", "provot2d", "--length", "0.1", "--width", "0.2"]);
    assert_eq!((found["structure"].as_str(), found["layers"].as_u64()), (Some("provot2d"), Some(1)));
    assert_eq!((number(&found, "length_m"), number(&found, "width_m")), (0.1, 0.2));
    let found = measure(&place, "free-fall", &["--engine", "rk4", "--dt", "1/1000", "--gravity", "1.62"]);
    assert_eq!((found["engine"].as_str(), number(&found, "dt_s")), (Some("rk4"), 1e-3));
    assert!((number(&found, "drop_m") - 0.81).abs() < 1e-6);
}

#[test]
fn an_unstable_measurement_has_status_1() {
    let place = TestFolder::new("measure-unstable");
    let flags = "measure bounce --structure trimm --engine verlet --grid 5x5 --dt 0.01 --json";
    let flags: Vec<&str> = flags.split(' ').collect();
    let ran = place.run(&flags);
    assert_eq!(ran.status, Some(1), "{}", ran.out);
    assert!(ran.json()["status"].as_str().is_some_and(|s| s.starts_with("unstable")));
}

#[test]
fn flags_of_measure_are_checked() {
    let place = TestFolder::new("measure-flags");
    let refused = |flags: &[&str], parts: &[&str]| place.expect_rejection(&[&["measure"], flags].concat(), parts);
    refused(&["jump"], &["jump", "bounce"]);
    refused(&["bounce", "--height", "-1"], &["height: -1 m is outside 0.001 to 1000 m"]);
    refused(&["bounce", "--restitution", "1.5"], &["restitution: 1.5 is outside 0 to 1"]);
    refused(&["incline", "--angle", "90"], &["angle: 90 degrees is outside 0 to 89 degrees"]);
    refused(&["incline", "--friction", "nan"], &["--friction", "nan", "finite"]);
    refused(&["slide", "--speed", "0"], &["speed: 0 m/s"]);
    refused(&["spin", "--rate", "fast"], &["--rate", "fast", "not a number"]);
    refused(&["spin", "--grid", "5"], &["--grid", "\"5\"", "2 whole numbers"]);
    refused(&["spin", "--grid", "1x5"], &["grid: 1 masses"]);
    refused(&["spin", "--structure", "satin"], &["satin", "samm"]);
    refused(&["spin", "--structure", "provot2d", "--layers", "2"], &["layers: 2 layers is outside 1 to 1"]);
    refused(&["spin", "--engine", "euler-kramer"], &["euler-kramer", "verlet"]);
    refused(&["spin", "--young", "0"], &["young: 0 Pa is outside 0.001 to 2e12 Pa"]);
    refused(&["spin", "--material", "cheese"], &["cheese", "hips"]);
    refused(&["spin", "--dt", "2"], &["dt: 2 s is outside 1e-7 to 1 s"]);
}

#[test]
fn a_strip_cut_at_an_angle_droops_as_its_modulus_says() {
    // Wool-polyester of the thesis's table 2.1: H is 5.1 µN m along the warp, 3.7 at 45° and 4.4
    // along the weft; 30° follows from equation 1.15. A small droop of a narrow strip is inversely
    // proportional to H.
    let place = TestFolder::new("measure-direction");
    let wool = "assets/materials/wool_polyester.ron";
    let strip = ["measure", "cantilever", "--json", "--material", wool, "--outlined", "--gravity", "0.2"];
    let size = ["--length", "0.05", "--width", "0.005", "--grid", "61x7", "--direction"];
    let drop = |degrees: &str| number(&place.json(&[&strip[..], &size[..], &[degrees]].concat()), "drop_m");
    let warp = drop("0");
    for (degrees, h) in [("30", 4.035), ("45", 3.7), ("90", 4.4)] {
        let ratio = drop(degrees) / warp * h / 5.1;
        // The clamp keeps the root of a strip at an angle from twisting: 1 % at this width.
        assert!((ratio - 1.0).abs() < 0.02, "{degrees}: {ratio}");
    }
    let grid = ["measure", "cantilever", "--material", wool, "--direction", "45"];
    place.expect_rejection(&grid, &["direction", "outline"]);
    place.expect_rejection(&["measure", "cantilever", "--direction", "45"], &["direction", "warp and weft"]);
}
