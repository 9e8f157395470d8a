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
}
