//! Statistics of the thesis's answers equal its printed tables.

use super::common::TestFolder;

/// Printed values of the thesis: test, sheet, statistic, then one value per question.
const PRINTED: &str = include_str!("study_printed.csv");

const THESIS: &str = "assets/study/thesis.csv";

#[test]
fn statistics_of_the_thesis_answers_equal_its_tables() {
    let place = TestFolder::new("study");
    let found = place.json(&["study", "--json"]);
    assert_eq!((found["subjects"].as_u64(), found["against"].as_str()), (Some(10), Some("provot2d")));
    let mut lines = PRINTED.lines();
    let keys: Vec<&str> = lines.next().expect("a head").split(',').skip(3).collect();
    let named = |list: &serde_json::Value, key: &str, name: &str| {
        let all = list.as_array().expect("a list").iter();
        all.clone().find(|v| v[key] == name).unwrap_or_else(|| panic!("{name}")).clone()
    };
    let mut seen = 0;
    for line in lines {
        let parts: Vec<&str> = line.split(',').collect();
        let test = named(&found["tests"], "test", parts[0]);
        for (key, printed) in keys.iter().zip(&parts[3..]).filter(|p| !p.1.is_empty()) {
            let question = named(&test["questions"], "question", key);
            let sheet = named(&question["sheets"], "sheet", parts[1]);
            let value = if parts[2] == "p" { &sheet["against"]["p"] } else { &sheet[parts[2]] };
            let (value, wanted) = (value.as_f64().expect("a number"), printed.parse::<f64>().expect("a number"));
            // The thesis prints six digits, the last one rounded.
            let last = 10_f64.powi(wanted.log10().floor() as i32 - 5).max(1e-5);
            assert!((value - wanted).abs() <= 0.5001 * last, "{line} {key}: {value} is not {wanted}");
            seen += 1;
        }
    }
    assert_eq!(seen, 12 * 3 * 9 + 6 * 8, "every number of its tables");
    let last = |key: &str| named(&found["overall"], "question", key)["sheets"][0].clone();
    for (key, mean, deviation) in [("C1", 6.0, 2.0_f64.sqrt()), ("C2", 5.8, 1.83303)] {
        assert!((last(key)["mean"].as_f64().expect("a number") - mean).abs() < 1e-9);
        assert!((last(key)["deviation"].as_f64().expect("a number") - deviation).abs() < 5e-6);
    }
}

#[test]
fn statements_of_the_thesis_are_checked_against_its_answers() {
    let place = TestFolder::new("study-claims");
    let found = place.json(&["study", "--json"]);
    let verdict = |says: &str| {
        let all = found["claims"].as_array().expect("a list").iter();
        let claim = all.clone().find(|c| c["says"] == says).unwrap_or_else(|| panic!("{says}"));
        claim["verdict"].as_str().expect("a word").to_owned()
    };
    // Section 6.5 ranks TRiMM above Provot 2D; the sums of its answers are 1293 and 1322.
    assert_eq!(verdict("all tests: TRiMM is above Provot 2D"), "contradicted");
    assert_eq!(verdict("cube: TRiMM is above Provot 2D"), "contradicted");
    assert_eq!(verdict("all tests: Provot 3D is above all others"), "order-only");
    assert_eq!(verdict("wedge2: Provot 3D is above all others"), "order-only");
    let all = &found["readings"][3];
    let means: Vec<(&str, f64)> = all["order"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|s| (s["sheet"].as_str().expect("a name"), s["mean"].as_f64().expect("a number")))
        .collect();
    assert_eq!(means, [("provot3d", 139.5), ("provot2d", 132.2), ("slamm", 129.8), ("trimm", 129.3)]);
    // Ranks differ on the cube; no pair of sheets does after correction for 18 comparisons.
    let cube = &found["readings"][0];
    assert!((cube["friedman"]["statistic"].as_f64().expect("a number") - 11.51).abs() < 0.005);
    assert!(cube["pairs"].as_array().expect("a list").iter().all(|p| p["p_holm"].as_f64().expect("a number") > 0.05));
    assert!(found["population"].is_null());
}

#[test]
fn background_and_comments_are_read_and_their_errors_located() {
    let place = TestFolder::new("study-background");
    let head = "subject,test,sheet,A1,A2,A3,A4,A5,B1,B2,B3,C1,C2,age,sex,years,hours,simulation,physics,comment\n";
    let seen = "a,cube,slamm,1,1,1,1,1,1,1,1,,,,,,,,,\n";
    let good = format!(
        "{head}a,background,,,,,,,,,,,,31,female,9.5,>20,yes,no,\n{seen}a,overall,,,,,,,,,,5,6,,,,,,,too slow\n"
    );
    let file = place.write("good.csv", &good);
    let found = place.json(&["study", file, "--json"]);
    let population = &found["population"];
    assert_eq!((population["n"].as_u64(), population["women"].as_u64()), (Some(1), Some(1)));
    assert_eq!(population["years"]["mean"].as_f64(), Some(9.5));
    assert_eq!(found["comments"][0][1], "too slow");
    let bad = place.write("hours.csv", &good.replace(">20", "many"));
    place.expect_rejection(&["study", bad], &["hours.csv:2", "hours", "many", ">20"]);
    let bad = place.write("line.csv", &good.replace("1,,,,,,,,,\n", "1,,,44,,,,,,\n"));
    place.expect_rejection(&["study", bad], &["line.csv:3", "age", "background"]);
}

#[test]
fn tables_are_readable_and_errors_are_located() {
    let place = TestFolder::new("study-tables");
    let ran = place.run(&["study", THESIS, "--against", "slamm"]);
    assert_eq!(ran.status, Some(0));
    assert!(ran.out.contains("6.80 ± 1.17 (6.5)") && ran.out.contains("10 subjects"), "{}", ran.out);
    place.expect_rejection(&["study", THESIS, THESIS], &["thesis.csv", "001 is in two of the tables"]);
    place.expect_rejection(&["study", "no/such.csv"], &["no/such.csv"]);
    let bad =
        place.write("bad.csv", "subject,test,sheet,A1,A2,A3,A4,A5,B1,B2,B3,C1,C2\na,cube,silk,1,1,1,1,1,1,1,1,,\n");
    place.expect_rejection(&["study", bad], &["bad.csv:2", "sheet", "silk"]);
    let head = "subject,order,test,sheet,A1,A2,A3,A4,A5,B1,B2,B3,C1,C2";
    let refused = |more: &str, order: &str, score: &str, parts: &[&str]| {
        let end = if more.is_empty() { "" } else { "," };
        let bad = place.write("bad.csv", &format!("{head}{more}\na,{order},cube,slamm,{score},1,1,1,1,1,1,1,,{end}\n"));
        place.expect_rejection(&["study", bad], parts);
    };
    refused("", "0", "1", &["bad.csv:2: order: \"0\" is not a whole number from 1 to 15, or N/A"]);
    refused("", "1", "-1", &["bad.csv:2: A1: \"-1\" is not a whole number from 1 to 9, or N/A"]);
    refused(",A1", "1", "1", &["bad.csv:1: column 15: \"A1\" is column 5 already"]);
    refused(",A9", "1", "1", &["bad.csv:1: column 15: \"A9\" is none of subject, order, test, sheet, A1"]);
}
