//! The user study (thesis chapter 6), from the answers of its ten subjects.

use std::path::Path;

use sheetwork::InputError;
use sheetwork::scene::library;

use crate::bench::thesis::{Finding, Row, Verdict};
use crate::study::{AGAINST, Answers, Findings, QuestionFindings, SheetFindings};

fn findings() -> Result<Findings, InputError> {
    let file = library::folder().map(|scenes| scenes.join("../study/thesis.csv"));
    let file = file.unwrap_or_else(|| Path::new("assets/study/thesis.csv").to_path_buf());
    Ok(Answers::read(&file)?.findings(AGAINST))
}

/// Mean of `Total` of each sheet in a test, the best first.
fn totals(found: &Findings, test: &str) -> Vec<(String, f64, f64)> {
    let of = |sheet: &SheetFindings| {
        let summary = sheet.summary.as_ref();
        (sheet.sheet.clone(), summary.map_or(f64::NAN, |s| s.mean), summary.map_or(f64::NAN, |s| s.deviation))
    };
    let tests = found.tests.iter().filter(|t| t.test == test);
    let mut all: Vec<_> = tests
        .flat_map(|t| t.questions.iter().filter(|q| q.question == "Total"))
        .flat_map(|q| q.sheets.iter().map(of))
        .collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all
}

fn line(test: &str, all: &[(String, f64, f64)]) -> String {
    let each: Vec<String> =
        all.iter().map(|(sheet, mean, deviation)| format!("{sheet} {mean:.1} ± {deviation:.1}")).collect();
    format!("{test}: {}", each.join(", "))
}

/// Number of the accuracy questions of a test in which one sheet has the higher mean.
fn ahead(found: &Findings, test: &str, sheet: &str, other: &str) -> (usize, usize) {
    let questions = found.tests.iter().filter(|t| t.test == test).flat_map(|t| &t.questions);
    let accuracy: Vec<_> = questions.filter(|q| q.question.starts_with('A')).collect();
    let mean = |question: &QuestionFindings, name: &str| {
        let found = question.sheets.iter().find(|s| s.sheet == name);
        found.and_then(|s| s.summary.as_ref()).map_or(f64::NAN, |s| s.mean)
    };
    (accuracy.iter().filter(|q| mean(q, sheet) > mean(q, other)).count(), accuracy.len())
}

pub(crate) const MEANS: Row = Row {
    name: "figures-6.5-6.6",
    title: "Figures 6.5 and 6.6: means and medians",
    says: "On the cube TRiMM looks better than Provot 2D and is behind it in speed only; on wedge 1 Provot 2D is best and \
           SLaMM second, ahead in sliding; on wedge 2 Provot 3D is clearly best.",
    run: || {
        let found = findings()?;
        let [cube, first, second] = ["cube", "wedge1", "wedge2"].map(|test| totals(&found, test));
        let place = |all: &[(String, f64, f64)], sheet: &str| all.iter().position(|s| s.0 == sheet).unwrap_or(9);
        let (better, of) = ahead(&found, "cube", "trimm", "provot2d");
        let holds = 2 * better > of
            && place(&first, "provot2d") == 0
            && place(&first, "slamm") == 1
            && place(&second, "provot3d") == 0;
        let measured = format!(
            "on the cube TRiMM is ahead of Provot 2D in {better} of {of} questions on accuracy; mean totals of {} subjects: \
             {}; {}; {}",
            found.subjects,
            line("cube", &cube),
            line("wedge 1", &first),
            line("wedge 2", &second)
        );
        let reason =
            "on the cube Provot 2D has the higher mean in most questions of appendix D; the wedges are as described";
        Ok(Finding::new(measured, Verdict::of(holds, reason)))
    },
};

pub(crate) const DEVIATIONS: Row = Row {
    name: "figure-6.7",
    title: "Figure 6.7: standard deviations",
    says: "The answers for Provot 3D vary little, in particular on wedge 2; those for the two sheets of its own vary more, \
           SLaMM most.",
    run: || {
        let found = findings()?;
        let second = totals(&found, "wedge2");
        let spread = |sheet: &str| second.iter().find(|s| s.0 == sheet).map_or(f64::NAN, |s| s.2);
        let holds = spread("provot3d") < spread("slamm") && spread("provot3d") < spread("trimm");
        let verdict = Verdict::of(holds, "Provot 3D does not vary least");
        Ok(Finding::new(line("wedge 2", &second), verdict))
    },
};

pub(crate) const OVERALL: Row = Row {
    name: "figure-6.8",
    title: "Figure 6.8: the questions at the end",
    says: "Means 6.0 (C1) and 5.8 (C2), deviations 1.41 and 1.83.",
    run: || {
        let found = findings()?;
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

pub(crate) const ORDER: Row = Row {
    name: "6.5-summary",
    title: "6.5: the winner of the study",
    says: "Provot 3D performed better than the others in all three tests, clearly so on wedge 2, against Provot 2D.",
    run: || {
        let found = findings()?;
        let mut lines = Vec::new();
        let mut significant = 0;
        let mut compared = 0;
        for test in &found.tests {
            let totals = test.questions.iter().filter(|q| q.question == "Total");
            for sheet in totals.flat_map(|q| &q.sheets) {
                if let Some(paired) = &sheet.against {
                    compared += 1;
                    let two_sided = 2.0 * paired.p;
                    significant += usize::from(two_sided * 9.0 < 0.05);
                    lines.push(format!("{} {}: {:+.1}, p = {two_sided:.3}", test.test, sheet.sheet, paired.difference));
                }
            }
        }
        let measured = format!(
            "difference of the totals from Provot 2D, two-sided p: {}; {significant} of {compared} differ at 5 % after \
             Bonferroni's correction",
            lines.join("; ")
        );
        let reason = "ten subjects and nine comparisons: the order is as printed on wedge 2, but few of the differences can \
                      be told from chance, and Provot 3D is not first in all tests";
        let first =
            ["cube", "wedge1", "wedge2"].iter().all(|t| totals(&found, t).first().is_some_and(|s| s.0 == "provot3d"));
        Ok(Finding::new(measured, Verdict::of(first && significant > 0, reason)))
    },
};
