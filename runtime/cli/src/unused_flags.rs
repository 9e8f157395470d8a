//! Flags of `sheetwork measure` by rig. A flag that a rig ignores is reported, because the
//! measurement then differs from the request.

use clap::ArgMatches;
use clap::parser::ValueSource;
use sheetwork_rigs::measure::TABLE;

/// Flags of some rigs only, by their names in [`crate::measure::Measure`], and those rigs.
const CASE_FLAGS: &[(&str, &[&str])] = &[
    ("angle", &["edge-landing", "fold", "incline"]),
    ("height", &["bounce", "drop-box", "edge-landing"]),
    ("speed", &["impact", "pull", "slide"]),
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
    ("on_sheet", &["impact", "incline", "pull", "slide"]),
    ("refine", &["edge-landing"]),
    ("threads", &["card-house", "card-pack", "stack"]),
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

/// Flags of rigs with bodies.
const CONTACT_FLAGS: &[&str] = &["friction", "restitution"];

/// Rigs with scenes of their own, and their flags.
const SCENES: &[&str] = &["card-house", "card-pack"];
const SCENE_FLAGS: &[&str] = &["case", "engine", "dt", "threads", "throw", "json"];

/// Flags among `given` that `case` ignores, as written on the command line.
fn unused_flags<'a>(case: &str, given: impl Iterator<Item = &'a str>) -> Vec<String> {
    let takes = |id: &str| {
        let of = CASE_FLAGS.iter().find(|(flag, _)| *flag == id);
        let meets = || TABLE.iter().any(|c| c.name == case && c.contact);
        if SCENES.contains(&case) && !SCENE_FLAGS.contains(&id) {
            false
        } else if CONTACT_FLAGS.contains(&id) {
            meets()
        } else {
            of.is_none_or(|(_, cases)| cases.contains(&case))
        }
    };
    let written = |id: &str| if id == "box_side" { "--box".to_owned() } else { format!("--{}", id.replace('_', "-")) };
    given.filter(|id| !takes(id)).map(written).collect()
}

/// Reports on standard error the flags of the command line that `case` ignores.
pub fn report_unused_flags(case: &str, matches: &ArgMatches) {
    if !TABLE.iter().any(|c| c.name == case) {
        return;
    }
    let ids = matches.ids().map(clap::Id::as_str);
    let given = ids.filter(|id| matches.value_source(id) == Some(ValueSource::CommandLine));
    for flag in unused_flags(case, given.filter(|id| matches.try_get_raw(id).is_ok())) {
        eprintln!("note: {case} does not take {flag}, which changes nothing");
    }
}

#[cfg(test)]
mod tests {
    use clap::{Args, Command, FromArgMatches};
    use sheetwork_rigs::measure::measure;

    use super::*;
    use crate::measure::Measure;

    #[test]
    fn flags_of_other_rigs_are_reported() {
        let left = |case, given: &[&str]| unused_flags(case, given.iter().copied());
        assert_eq!(left("drop-box", &["case", "height", "box_side", "friction", "grid", "json"]), [""; 0]);
        assert_eq!(left("weight", &["case", "box_side", "edge_of_body", "friction"]), ["--edge-of-body"]);
        assert_eq!(left("cantilever", &["case", "friction"]), ["--friction"]);
        assert_eq!(left("impact", &["case", "box_side"]), ["--box"]);
        assert_eq!(left("card-house", &["case", "throw", "threads", "grid", "friction"]), ["--grid", "--friction"]);
    }

    /// Result of `measure` with `arguments`, without times.
    fn measured(arguments: &[&str]) -> serde_json::Value {
        let command = Measure::augment_args(Command::new("measure"));
        let matches = command.get_matches_from([&["measure"], arguments].concat());
        let rig = Measure::from_arg_matches(&matches).expect("clap has taken them");
        let mut found = measure(rig.case(), &rig.setup().expect("a set-up")).expect("it can be measured");
        let is_time = |key: &str| key.contains("cpu") || key.ends_with("_ms");
        found.as_object_mut().expect("keys and values").retain(|key, _| !is_time(key));
        found
    }

    #[test]
    fn flags_reported_as_unused_have_no_effect() {
        let others = [
            ("angle", "25"),
            ("height", "0.3"),
            ("speed", "2"),
            ("throw", "2"),
            ("rate", "5"),
            ("boundary", "free"),
            ("modes", "2"),
            ("side", "0.2"),
            ("patch", "0.04"),
            ("radius", "0.1"),
            ("hole", "0.05"),
            ("box_side", "0.08"),
            ("sheets", "2"),
            ("refine", "1"),
            ("threads", "2"),
            ("friction", "0.9"),
            ("restitution", "0.7"),
            ("fo", "0.3"),
            ("from", "90"),
            ("to", "50"),
            ("ambient", "30"),
            ("convection", "20"),
            ("heater", "300"),
            ("view", "0.2"),
            ("seconds", "5"),
            ("celsius", "80"),
        ];
        let mut tried = 0;
        for case in
            ["cantilever", "conduction", "free-fall", "incline", "radiate", "softening", "view-factor", "weight"]
        {
            let own = [case, "--grid", "5x5", "--polygon", "0,1,0;1,1,0;0,1,1"];
            let own = if case == "view-factor" { &own[..] } else { &own[..3] };
            let plain = measured(own);
            for (id, value) in others {
                for flag in unused_flags(case, [id].into_iter()) {
                    assert_eq!(plain, measured(&[own, &[&flag, value]].concat()), "{case} {flag}");
                    tried += 1;
                }
            }
        }
        assert!(tried > 150, "{tried}");
    }

    #[test]
    fn every_flag_and_rig_of_the_table_exists() {
        let command = Measure::augment_args(Command::new("measure"));
        for (flag, cases) in CASE_FLAGS {
            assert!(command.get_arguments().any(|a| a.get_id() == flag), "{flag}");
            for case in *cases {
                assert!(TABLE.iter().any(|c| c.name == *case), "{case}");
            }
        }
        for id in SCENE_FLAGS {
            assert!(command.get_arguments().any(|a| a.get_id() == id), "{id}");
        }
    }
}
