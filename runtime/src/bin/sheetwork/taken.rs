//! Which cases of `sheetwork measure` take which flags: a flag that is given to a case which does not is told, since what is measured is then
//! not what was asked for.

use clap::ArgMatches;
use clap::parser::ValueSource;
use sheetwork::measure::TABLE;

/// Flags, by their names in [`crate::measure::Measure`], of some cases only, and those.
const OF_CASES: &[(&str, &[&str])] = &[
    ("angle", &["edge-landing", "fold", "incline"]),
    ("height", &["bounce", "drop-box", "edge-landing"]),
    ("speed", &["impact", "slide"]),
    ("throw", &["card-house"]),
    ("rate", &["spin"]),
    ("boundary", &["disc", "frequency", "hole"]),
    ("modes", &["disc", "frequency", "hole"]),
    ("side", &["hole", "pedestal", "supports"]),
    ("patch", &["pedestal"]),
    ("radius", &["disc"]),
    ("hole", &["hole"]),
    ("box_side", &["detail", "drop-box", "weight"]),
    ("sheets", &["stack"]),
    ("corner", &["edge-landing"]),
    ("edge_of_body", &["edge-landing"]),
    ("on_sheet", &["incline", "slide"]),
    ("refine", &["edge-landing"]),
    ("threads", &["card-house", "card-pack", "stack"]),
    ("friction", &["bounce", "drop-box", "edge-landing", "impact", "incline", "slide", "stack"]),
    ("restitution", &["bounce", "drop-box", "edge-landing", "impact"]),
    ("relaxation_time", &["creep"]),
    ("retardation_time", &["creep"]),
    ("retarded", &["creep"]),
    ("polygon", &["view-factor"]),
    ("point", &["view-factor"]),
    ("normal", &["view-factor"]),
    ("fo", &["conduction"]),
    ("from", &["cooling", "radiate"]),
    ("to", &["cooling"]),
    ("ambient", &["cooling", "radiate"]),
    ("convection", &["cooling", "radiate"]),
    ("heater", &["radiate"]),
    ("view", &["radiate"]),
    ("seconds", &["creep", "radiate"]),
    ("celsius", &["creep", "softening"]),
];

/// Cases that are scenes of their own, and all that they take.
const SCENES: &[&str] = &["card-house", "card-pack"];
const OF_SCENES: &[&str] = &["case", "engine", "dt", "threads", "throw", "json"];

/// Flags among `given` that `case` does not take, as they are written.
fn left_out<'a>(case: &str, given: impl Iterator<Item = &'a str>) -> Vec<String> {
    let takes = |id: &str| {
        let of = OF_CASES.iter().find(|(flag, _)| *flag == id);
        of.is_none_or(|(_, cases)| cases.contains(&case)) && (!SCENES.contains(&case) || OF_SCENES.contains(&id))
    };
    let written = |id: &str| if id == "box_side" { "--box".to_owned() } else { format!("--{}", id.replace('_', "-")) };
    given.filter(|id| !takes(id)).map(written).collect()
}

/// Says on standard error which flags of the command line `case` does not take.
pub fn tell(case: &str, matches: &ArgMatches) {
    if !TABLE.iter().any(|c| c.name == case) {
        return;
    }
    let ids = matches.ids().map(clap::Id::as_str);
    let given = ids.filter(|id| matches.value_source(id) == Some(ValueSource::CommandLine));
    for flag in left_out(case, given.filter(|id| matches.try_get_raw(id).is_ok())) {
        eprintln!("note: {case} does not take {flag}, which changes nothing");
    }
}

#[cfg(test)]
mod tests {
    use clap::{Args, Command};

    use super::*;

    #[test]
    fn flags_of_other_cases_are_told() {
        let left = |case, given: &[&str]| left_out(case, given.iter().copied());
        assert_eq!(left("drop-box", &["case", "height", "box_side", "friction", "grid", "json"]), [""; 0]);
        assert_eq!(left("weight", &["case", "box_side", "edge_of_body"]), ["--edge-of-body"]);
        assert_eq!(left("impact", &["case", "box_side"]), ["--box"]);
        assert_eq!(left("card-house", &["case", "throw", "threads", "grid", "friction"]), ["--grid", "--friction"]);
    }

    #[test]
    fn every_flag_and_case_of_the_table_is_there() {
        let command = crate::measure::Measure::augment_args(Command::new("measure"));
        for (flag, cases) in OF_CASES {
            assert!(command.get_arguments().any(|a| a.get_id() == flag), "{flag}");
            for case in *cases {
                assert!(TABLE.iter().any(|c| c.name == *case), "{case}");
            }
        }
        for id in OF_SCENES {
            assert!(command.get_arguments().any(|a| a.get_id() == id), "{id}");
        }
    }
}
