//! Snapshots, journals, fuzzing and random scenes by the program.

use super::common::TestFolder;

#[test]
fn scenes_continue_bit_exactly_from_a_snapshot_and_costs_are_reported() {
    let place = TestFolder::new("rollback");
    let result = place.json(&["bench", "rollback", "wedge", "curl", "--first", "20", "--steps", "30", "--json"]);
    assert_eq!((result["equal"].as_u64(), result["of"].as_u64()), (Some(2), Some(2)));
    assert!(result["scenes"][1]["bytes"].as_u64().is_some_and(|bytes| bytes > 1000));
    place.expect_rejection(&["bench", "rollback", "nowhere"], &["nowhere.ron"]);
}

#[test]
fn a_journal_is_replayed_checked_and_seeked() {
    let place = TestFolder::new("journal");
    let run = ["run", "assets/scenes/curl.ron", "--seconds", "0.5", "--journal", "a.journal", "--key-every", "7"];
    let gravity = ["--at", "0.1:gravity=(0, -2, 0)", "--at", "0.05:gravity=(0, 0, 1)", "--json"];
    place.json(&[&run[..], &gravity[..]].concat());
    for threads in ["1", "2"] {
        let same = place.json(&["replay", "a.journal", "--threads", threads, "--json"]);
        assert_eq!(same["same"], true, "{same}");
        assert!(same["steps"].as_u64().is_some_and(|steps| steps > 10));
    }
    let there = place.json(&["replay", "a.journal", "--seek", "9"]);
    assert_eq!(there["steps"], 9);
    place.expect_rejection(&["replay", "a.journal", "--seek", "100000"], &["--seek", "is outside 0 to"]);
    let bytes = std::fs::read(place.path("a.journal")).expect("there");
    std::fs::write(place.path("cut.journal"), &bytes[..bytes.len() - 5]).expect("writable");
    place.expect_rejection(&["replay", "cut.journal"], &["cut.journal", "ends within part"]);
    std::fs::write(place.path("later.journal"), "sheetwork journal 2\n{}\n").expect("writable");
    place.expect_rejection(&["replay", "later.journal"], &["later.journal", "version 2", "reads version 1"]);
    place.expect_rejection(&["replay", "assets/scenes/curl.ron"], &["curl.ron", "not a journal"]);
    place.expect_rejection(&["run", "assets/scenes/curl.ron", "--key-every", "0"], &["--key-every", "1 to"]);
    place.expect_rejection(&["run", "assets/scenes/curl.ron", "--at", "soon"], &["--at", "TIME:PATH=VALUE"]);
    place.expect_rejection(&["run", "assets/scenes/curl.ron", "--at", "0:no.such=1"], &["no.such"]);
}

#[test]
fn damaged_input_of_every_kind_is_accepted_or_rejected() {
    let place = TestFolder::new("fuzz");
    let corpus = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/corpus");
    let all = place.json(&["bench", "fuzz", "--count", "1500", "--corpus", corpus, "--json"]);
    let rows = all.as_array().expect("rows");
    assert_eq!(rows.len(), 9);
    for row in rows {
        let count = |key: &str| row[key].as_u64().unwrap_or(0);
        assert!(row["faults"].as_array().is_some_and(Vec::is_empty), "{row}");
        // A useful set of mutations has both accepted and rejected inputs.
        assert!(count("read") >= 20 && count("refused") >= 100 && count("read") + count("refused") == 1500, "{row}");
    }
    place.expect_rejection(&["bench", "fuzz", "--reader", "tarot"], &["tarot", "snapshot"]);
    place.expect_rejection(&["bench", "fuzz", "--count", "0"], &["--count", "1 to"]);
    place.expect_rejection(&["bench", "fuzz", "--corpus", "nowhere"], &["--corpus", "no folder nowhere"]);
}

#[test]
fn random_scenes_stay_finite_and_hashes_of_builds_compare() {
    let place = TestFolder::new("random");
    let run = place.run(&["bench", "scenes", "--count", "12", "--seconds", "0.05", "--json"]);
    let summary = run.json();
    assert_eq!((summary["scenes"].as_u64(), summary["broken"].as_u64()), (Some(12), Some(0)), "{summary}");
    assert!(summary["refused"].as_u64().is_some_and(|refused| refused <= 2), "{summary}");
    let program = env!("CARGO_BIN_EXE_sheetwork");
    let same = place.run(&["bench", "hashes", "wedge", "--steps", "20", "--threads", "2", "--against", program]);
    assert_eq!(same.status, Some(0), "{}", same.out);
    assert!(same.out.starts_with("wedge ") && same.out.trim_end().ends_with("same"), "{}", same.out);
    place
        .expect_rejection(&["bench", "hashes", "wedge", "--steps", "2", "--against", "/bin/true"], &["gave no hashes"]);
}

#[test]
fn a_kicked_heated_and_cooled_sheet_has_constant_position_and_memory() {
    let place = TestFolder::new("day");
    let day = place.json(&["bench", "day", "--hours", "0.4", "--masses", "5", "--json"]);
    let number = |key: &str| day[key].as_f64().unwrap_or(f64::NAN);
    assert!((number("simulated_s") - 1200.0).abs() < 1e-3 && day["well"] == true, "{day}");
    assert!(number("rise_over_kick") < 0.02 && number("tip_drift_m") < 1e-4, "{day}");
    assert!(day["parts"][0]["warmest_c"].as_f64().is_some_and(|c| (c - 90.0).abs() < 1.0), "{day}");
    place.expect_rejection(&["bench", "day", "--hours", "0"], &["--hours", "h"]);
    place.expect_rejection(&["bench", "day", "--masses", "1"], &["--masses", "3 to"]);
}
