//! `sheetwork study`: statistics of the answers of a study.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use clap::builder::PossibleValuesParser;
use sheetwork::InputError;
use sheetwork_rigs::bench::thesis::draw_references;
use sheetwork_rigs::study::{
    AGAINST, ALL_TESTS, Answers, Claim, Findings, LAST_QUESTIONS, QUESTIONS, QuestionFindings, SHEETS, SIGNIFICANCE,
    Share, THESIS_POPULATION, TestReading, TrialSpeed, Verdict, measure_speed,
};

use sheetwork_rigs::output::{OutputFlags, print_json, print_line};

#[derive(Args)]
pub struct StudyArguments {
    /// Tables of answers, as written by the editor's study mode; those of the thesis by default.
    #[arg(default_value = "assets/study/thesis.csv")]
    files: Vec<PathBuf>,
    /// Sheet of comparison.
    #[arg(long, value_name = "SHEET", default_value = AGAINST, value_parser = PossibleValuesParser::new(SHEETS))]
    against: String,
    /// Measure the speed of each sheet in the scenes of the study, in place of the answers.
    #[arg(long)]
    speed: bool,
    /// Draw the real drops that the editor shows beside the tests to this folder; the shipped ones
    /// are in assets/study.
    #[arg(long, value_name = "FOLDER", conflicts_with = "speed")]
    references: Option<PathBuf>,
    #[command(flatten)]
    output: OutputFlags,
}

impl StudyArguments {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        if self.speed {
            let found = measure_speed()?;
            return if self.output.json { print_json(&found) } else { speeds(&found) }.map(|()| ExitCode::SUCCESS);
        }
        if let Some(folder) = self.references {
            let files = draw_references(&folder)?;
            let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
            return if self.output.json { print_json(&names) } else { print_line(&names.join("\n")) }
                .map(|()| ExitCode::SUCCESS);
        }
        let mut all = Answers::default();
        for file in &self.files {
            all.merge(Answers::read(file)?).map_err(|e| e.in_file(file))?;
        }
        if all.subjects().is_empty() {
            return Err(InputError::new("", "has no answers").in_file(&self.files[0]));
        }
        let findings = all.findings(&self.against);
        if self.output.json {
            print_json(&findings)?;
        } else {
            tables(&findings)?;
            people(&findings)?;
            t_tests(&findings)?;
            findings.readings.iter().try_for_each(reading)?;
            claims(&findings.claims)?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Width of the column with the questions.
const ASKED: usize = 44;

fn tables(findings: &Findings) -> Result<(), InputError> {
    print_line(&format!(
        "{} subjects; mean ± deviation (median), and under it p of the difference from",
        findings.subjects
    ))?;
    print_line(&format!("{}: Student's t of pairs, one-sided.", findings.against))?;
    for test in &findings.tests {
        let names = test.questions.first().map(|q| q.sheets.iter().map(|s| s.sheet.as_str())).into_iter().flatten();
        let heads: String = names.map(|name| format!("{name:>22}")).collect();
        print_line(&format!("\n{:<ASKED$}{heads}", test.test))?;
        test.questions.iter().try_for_each(row)?;
    }
    if findings.overall.iter().any(|q| q.sheets.iter().any(|s| s.summary.is_some())) {
        print_line("\nat the end")?;
        findings.overall.iter().try_for_each(row)?;
    }
    Ok(())
}

fn row(found: &QuestionFindings) -> Result<(), InputError> {
    let asks = QUESTIONS.iter().chain(&LAST_QUESTIONS).find(|q| q.key == found.question).map_or("", |q| q.asks);
    let values = found.sheets.iter().map(|sheet| match sheet.summary {
        Some(s) => format!("{:>22}", format!("{:.2} ± {:.2} ({})", s.mean, s.deviation, s.median)),
        None => format!("{:>22}", "-"),
    });
    print_line(&format!("{:<6}{asks:<38}{}", found.question, values.collect::<String>()))?;
    if found.sheets.iter().any(|s| s.against.is_some()) {
        let chances = found.sheets.iter().map(|sheet| match sheet.against {
            Some(paired) => format!("{:>22}", format!("p {:.5}", paired.p)),
            None => format!("{:>22}", ""),
        });
        print_line(format!("{:<ASKED$}{}", "", chances.collect::<String>()).trim_end())?;
    }
    Ok(())
}

/// Population and comments.
fn people(findings: &Findings) -> Result<(), InputError> {
    print_line("\npopulation")?;
    match &findings.population {
        Some(p) => {
            let percent = |share: Share| share.percent().map_or("-".to_owned(), |v| format!("{v:.0} %"));
            let ages = p.age_range.map_or("-".to_owned(), |(least, most)| format!("{least} to {most}"));
            let years = p.years.map_or("-".to_owned(), |y| format!("{:.1} ± {:.1}", y.mean, y.deviation));
            print_line(&format!("{} people, {} men and {} women, {ages} years old", p.n, p.men, p.women))?;
            print_line(&format!("{years} years of computing; over 20 h a week: {}", percent(p.over_20_hours)))?;
            let (simulation, physics) = (percent(p.simulation), percent(p.physics));
            print_line(&format!("know simulation: {simulation}; know engineering or physics: {physics}"))?;
        }
        None => print_line("no line of the table has a background")?,
    }
    print_line(&format!("thesis (6.3.3): {THESIS_POPULATION}"))?;
    if !findings.comments.is_empty() {
        print_line("\ncomments")?;
    }
    findings.comments.iter().try_for_each(|(subject, text)| print_line(&format!("{subject}: {text}")))
}

/// Number of significant t tests, before and after correction.
fn t_tests(findings: &Findings) -> Result<(), InputError> {
    let t = &findings.t_tests;
    let survive = if t.significant_holm.is_empty() { "none".to_owned() } else { t.significant_holm.join(", ") };
    print_line(&format!(
        "\n{} t tests of single questions against {}: {} have p < {SIGNIFICANCE}, where chance alone gives {:.1}; by Holm: \
         {survive}",
        t.tests, findings.against, t.significant, t.expected
    ))
}

/// Order of the sheets in one test and its significance.
fn reading(found: &TestReading) -> Result<(), InputError> {
    let title = if found.test == ALL_TESTS { "all tests together" } else { found.test.as_str() };
    let friedman = found.friedman.as_ref().map_or("no test of ranks".to_owned(), |f| {
        let word = if f.p < SIGNIFICANCE { "significant" } else { "not significant" };
        format!("Friedman χ² {:.2}, p {:.4} ({word}), {} subjects", f.statistic, f.p, f.n)
    });
    print_line(&format!("\norder in {title}: {friedman}"))?;
    for score in &found.order {
        let s = score.summary;
        let rank = score.mean_rank.map_or("-".to_owned(), |r| format!("{r:.2}"));
        print_line(&format!(
            "  {:<10} mean {:>6.2} ± {:>5.2}  median {:>5.1}  mean rank {rank}",
            score.sheet, s.mean, s.deviation, s.median
        ))?;
    }
    for pair in &found.pairs {
        let word = if pair.p_holm < SIGNIFICANCE { "significant" } else { "not significant" };
        let names = format!("{} > {}", pair.better, pair.worse);
        print_line(&format!("  {names:<22} Wilcoxon p {:.4}, by Holm {:.4}: {word}", pair.p, pair.p_holm))?;
    }
    Ok(())
}

/// Statements of the thesis and what the answers say.
fn claims(all: &[Claim]) -> Result<(), InputError> {
    if all.is_empty() {
        return Ok(());
    }
    print_line("\nstatements of the thesis (6.4, 6.5) against these answers; p one-sided, of the weakest pair")?;
    for claim in all {
        let verdict = match claim.verdict {
            Verdict::Supported => "supported",
            Verdict::OrderOnly if claim.p.is_none() => "order holds, not tested",
            Verdict::OrderOnly => "order holds, not significant",
            Verdict::Contradicted => "not so",
        };
        let values: Vec<String> = claim.values.iter().map(|(sheet, value)| format!("{sheet} {value:.2}")).collect();
        let p = claim.p.zip(claim.p_holm).map_or_else(String::new, |(p, h)| format!("; p {p:.4}, by Holm {h:.4}"));
        print_line(&format!("  {} {}: {verdict}", claim.section, claim.says))?;
        print_line(&format!("      {}{p}", values.join(", ")))?;
    }
    Ok(())
}

/// Speed of each sheet in each scene of the study.
fn speeds(all: &[TrialSpeed]) -> Result<(), InputError> {
    print_line("CPU time of this machine; the factor is simulated time over CPU time")?;
    let heads = ["nodes", "step, ms", "steps/s", "× real time", "× provot2d"].map(|head| format!("{head:>13}"));
    print_line(&format!("{:<8}{:<10}{:<17}{}", "test", "sheet", "engine", heads.concat()))?;
    for one in all {
        let base = all.iter().find(|other| other.test == one.test && other.sheet == AGAINST);
        let relative = base.map_or(f64::NAN, |b| one.real_time_factor / b.real_time_factor);
        let note = if one.stable { "" } else { "  unstable" };
        print_line(&format!(
            "{:<8}{:<10}{:<17}{:>13}{:>13.2}{:>13.0}{:>13.1}{relative:>13.2}{note}",
            one.test,
            one.sheet,
            one.engine,
            one.nodes,
            1e3 * one.dt_s,
            one.steps_per_cpu_s,
            one.real_time_factor
        ))?;
    }
    Ok(())
}
