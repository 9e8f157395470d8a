//! The report of the thesis: its verdicts are those of `docs/thesis.csv`.

use std::path::PathBuf;

use sheetwork_rigs::bench::thesis::verdicts;

#[test]
fn the_verdicts_of_the_report_are_those_of_its_document() {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/thesis.csv");
    let mut reader = csv::Reader::from_path(&file).expect("the report");
    let records: Vec<csv::StringRecord> = reader.records().map(|r| r.expect("a row")).collect();
    let found = verdicts().expect("every row runs");
    for (name, verdict) in &found {
        let record = records.iter().find(|r| &r[0] == *name);
        let record = record.unwrap_or_else(|| panic!("{name} is not in the report: run `sheetwork bench thesis`"));
        assert_eq!(&record[5], *verdict, "{name}: run `sheetwork bench thesis`");
    }
    let good = found.iter().filter(|(_, verdict)| ["agrees", "fitted", "works"].contains(verdict)).count();
    assert!(2 * good > found.len(), "only {good} of {} rows agree or work", found.len());
}
