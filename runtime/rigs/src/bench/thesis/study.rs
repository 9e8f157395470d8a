//! The user study (thesis chapter 6), from the answers of its ten subjects.

use std::path::Path;

use sheetwork::InputError;
use sheetwork::scene::library;

use crate::bench::thesis::{Finding, Row, Verdict};
use crate::study::claims::{self, Claim};
use crate::study::trial::measure_speed;
use crate::study::{AGAINST, Answers, SHEETS, TESTS};

fn answers() -> Result<Answers, InputError> {
    let file = library::folder().map(|scenes| scenes.join("../study/thesis.csv"));
    Answers::read(&file.unwrap_or_else(|| Path::new("assets/study/thesis.csv").to_path_buf()))
}

/// The statements of one section, checked, as a row.
fn claims_of(section: &str) -> Result<Finding, InputError> {
    let claims = answers()?.claims();
    let of_section: Vec<&Claim> = claims.iter().filter(|c| c.section == section).collect();
    let count = |verdict| of_section.iter().filter(|c| c.verdict == verdict).count();
    let lines: Vec<String> = of_section.iter().map(|claim| claim_text(claim)).collect();
    let (supported, order) = (count(claims::Verdict::Supported), count(claims::Verdict::OrderOnly));
    let contradicted = count(claims::Verdict::Contradicted);
    let reason = format!(
        "{supported} of {} statements hold and are significant at 5 % after Holm's correction, {order} hold in the order \
         only, {contradicted} are contradicted by the answers of appendix D; ten subjects are few",
        of_section.len()
    );
    let holds = supported == of_section.len();
    Ok(Finding::new(lines.join("; "), Verdict::of(holds, &reason)))
}

fn claim_text(claim: &Claim) -> String {
    let values: Vec<String> = claim.values.iter().map(|(sheet, value)| format!("{sheet} {value:.1}")).collect();
    let p = claim.p_holm.map_or_else(String::new, |p| format!(", p = {p:.3}"));
    let verdict = match claim.verdict {
        claims::Verdict::Supported => "supported",
        claims::Verdict::OrderOnly => "order only",
        claims::Verdict::Contradicted => "contradicted",
    };
    format!("{}: {verdict} ({}{p})", claim.says, values.join(", "))
}

pub(crate) const RESULTS: Row = Row {
    name: "6.4-results",
    title: "6.4, figures 6.5 to 6.7: means, medians, deviations",
    says: "Cube: TRiMM above Provot 2D. Wedge 1: Provot 2D best, SLaMM second and ahead in sliding. Wedge 2: Provot \
           3D clearly above all. Provot 3D varies least.",
    here: "The answers of appendix D in `assets/study`: `sheetwork study`.",
    run: || claims_of("6.4"),
};

pub(crate) const SUMMARY: Row = Row {
    name: "6.5-summary",
    title: "6.5: the winner of the study",
    says: "Provot 3D performed better than the others, most of all on wedge 2; TRiMM better than SLaMM (printed \
           SaMM, which was not in the study) and Provot 2D.",
    here: "The answers of appendix D in `assets/study`: `sheetwork study`.",
    run: || claims_of("6.5"),
};

pub(crate) const OVERALL: Row = Row {
    name: "figure-6.8",
    title: "Figure 6.8: the questions at the end",
    says: "Means 6.0 (C1) and 5.8 (C2), deviations 1.41 and 1.83.",
    here: "The answers of appendix D in `assets/study`: `sheetwork study`.",
    run: || {
        let found = answers()?.findings(AGAINST);
        let mut lines = Vec::new();
        let mut worst = 0.0_f64;
        for (question, printed) in found.overall.iter().zip([(6.0, 1.41), (5.8, 1.83)]) {
            let summary = question.sheets.first().and_then(|s| s.summary.as_ref());
            let (mean, deviation) = summary.map_or((f64::NAN, f64::NAN), |s| (s.mean, s.deviation));
            worst = worst.max((mean - printed.0).abs()).max((deviation - printed.1).abs());
            lines.push(format!("{}: {mean:.2} ± {deviation:.2}", question.question));
        }
        Ok(Finding::new(lines.join("; "), Verdict::of(worst < 0.01, "the answers give other numbers")))
    },
};

pub(crate) const SPEED: Row = Row {
    name: "6.1-speed",
    title: "6.1, 7.5: speed of the sheets in the same scenes",
    says: "The three-dimensional sheets cost little or nothing in speed; Provot 3D has no substantial overhead over \
           SLaMM and TRiMM. (6.5 calls them often slightly slower, and unlikely to match a two-dimensional sheet.)",
    here: "Scenes cube, wedge1 and wedge2 of the study with each sheet.",
    run: || {
        let speeds = measure_speed()?;
        let cost = |test: &str, sheet: &str| {
            let found = speeds.iter().find(|s| s.test == test && s.sheet == sheet);
            found.map_or(f64::NAN, |s| 1.0 / s.steps_per_cpu_s)
        };
        let mut lines = Vec::new();
        let (mut of_provot3d, mut of_layers) = (0.0_f64, 0.0_f64);
        for test in TESTS {
            let each = SHEETS.iter().map(|sheet| {
                let found = speeds.iter().find(|s| s.test == test && s.sheet == *sheet);
                format!("{sheet} {:.0}", found.map_or(f64::NAN, |s| s.real_time_factor))
            });
            lines.push(format!("{test}: {}", each.collect::<Vec<_>>().join(", ")));
            of_provot3d = of_provot3d.max(cost(test, "provot3d") / cost(test, "slamm"));
            of_layers = of_layers.max(cost(test, "trimm") / cost(test, "provot2d"));
        }
        let measured = format!(
            "times real time: {}; a step of Provot 3D costs at most {of_provot3d:.2} times one of SLaMM, one of TRiMM at \
             most {of_layers:.2} times one of Provot 2D, against the sentence of 6.5",
            lines.join("; ")
        );
        let reason = "two layers have nearly twice the masses of one; all sheets are far above real time";
        Ok(Finding::new(measured, Verdict::of(of_provot3d < 1.5 && of_layers < 1.25, reason)))
    },
};
