//! Report of the thesis as Markdown, CSV, JSON and text.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;
use sheetwork::InputError;

use crate::bench::thesis::{Finding, Row, Verdict, diagram, picture};
use crate::bench::write_csv;

/// Instruments and scenes that have a command in place of a row.
const INSTRUMENTS: &str = "
Without a row, since nothing is printed about them that could be compared:

| in the thesis | here |
|---|---|
| the steps of the simulation (figure 3.7, a flow chart) | `cargo run -p sheetwork --example hello_sheet` |
| the sheet generator (4.4) | `sheetwork generate --help`: start, velocity, force, acceleration, mass, stiffness, damping, any number of layers |
| half and upright cylinder | `sheetwork run hot_half_cylinder`, `sheetwork run hot_upright_cylinder` |
| a solid of several layers (3.4, 7.3 f) | `sheetwork run solid_five_layers` |
| questionnaire, population, footage beside the tests (6.3) | `sheetwork-editor --study`, `sheetwork study`, `sheetwork study --references DIR` |
| moduli in any direction (1.14 to 1.17) | `sheetwork material assets/materials/wool_polyester.ron` |
| LDPE, PP | `sheetwork material assets/materials/ldpe.ron`, `assets/materials/polypropylene.ron` |
| mouse modes, manipulation of the sheet (7.3 b) | the editor's mouse modes and its hand |
| haptic device (7.4 ii) | `sheetwork haptic`: a force loop of 1 kHz with joystick or mouse, rate and latency |
| Maxwell and Kelvin-Voigt elements together (7.4 vii) | row `figure-3.13`, `creep` of a sheet |
| exposure of each spring to a heater (7.4 xi) | `sheetwork run heat_modes`: view factors and shadows of each patch |
| conductivity that cannot be enough while the sheet is stable (5.3.4) | the thesis's formulas have no heat equation; `heat_mode: Physical` conducts stably at any conductivity (docs/heat.md) |
| smooth bodies melt better than blunt ones (5.3.4) | rows `figure-5.24` and `figure-5.26` |
| little gain of speed by SaMM (5.3.4) | row `figures-4.11-4.13`: 800 springs in place of 881 and 981 |
| both diagonals not expected to reach TRiMM (5.3.4) | row `5.3.4-second-diagonal`: the opposite, 1.33 of its length where TRiMM has 1.52 (row `figure-5.18`) |
| the 3D Provot sheet beside TRiMM, second and fourth order (7.3 a) | rows `6.1-speed`, `6.2-flexion`; `sheetwork run wedge --set sheets.0.structure=provot3d --engine rk4` |
| graphics processors (7.3 g) | not here |
";

/// A row of the CSV and of the JSON.
#[derive(Serialize)]
pub(crate) struct Record {
    name: &'static str,
    title: &'static str,
    thesis: &'static str,
    here: &'static str,
    measured: String,
    verdict: &'static str,
    reason: String,
    command: String,
}

/// Records of all rows.
pub(crate) fn records(found: &[(&Row, Finding)]) -> Vec<Record> {
    let record = |(row, finding): &(&Row, Finding)| Record {
        name: row.name,
        title: row.title,
        thesis: row.says,
        here: row.here,
        measured: finding.measured.clone(),
        verdict: finding.verdict.word(),
        reason: finding.verdict.reason().to_owned(),
        command: command(row),
    };
    found.iter().map(record).collect()
}

/// Command that runs a row alone.
fn command(row: &Row) -> String {
    format!("sheetwork bench thesis --row {}", row.name)
}

/// A row as text.
pub(crate) fn text(row: &Row, finding: &Finding) -> String {
    let mut text = format!("{} ({}): {}", row.title, row.name, finding.verdict.word());
    // Writing to a string is infallible.
    let _ = write!(text, "\n  thesis:   {}\n  here:     {}\n  measured: {}", row.says, row.here, finding.measured);
    if !finding.verdict.reason().is_empty() {
        let _ = write!(text, "\n  because:  {}", finding.verdict.reason());
    }
    text + "\n"
}

/// Counts of the verdicts.
pub(crate) fn summary(found: &[(&Row, Finding)]) -> String {
    let count = |word: &str| found.iter().filter(|(_, f)| f.verdict.word() == word).count();
    format!(
        "{} rows: {} agree, {} fitted, {} proposals work, {} disagree, {} misprints",
        found.len(),
        count("agrees"),
        count("fitted"),
        count("works"),
        count("disagrees"),
        count("misprint")
    )
}

/// Writes thesis.md, thesis.csv and the pictures.
pub(crate) fn write(folder: &Path, found: &[(&Row, Finding)], pictures: bool) -> Result<(), InputError> {
    let drawn = folder.join("thesis");
    std::fs::create_dir_all(&drawn).map_err(|e| InputError::io(&drawn, &e))?;
    if pictures {
        for (row, finding) in found {
            let file = drawn.join(format!("{}.png", row.name));
            if let Some(strip) = &finding.strip {
                picture::png(&file, strip)?;
            }
            if let Some(diagram) = &finding.diagram {
                diagram::png(&file, diagram)?;
            }
        }
    }
    write_csv(&folder.join("thesis.csv"), &records(found))?;
    let file = folder.join("thesis.md");
    std::fs::write(&file, markdown(found)).map_err(|e| InputError::io(&file, &e))
}

fn markdown(found: &[(&Row, Finding)]) -> String {
    let mut text = String::from(
        "# The thesis, row by row\n\n\
         Every table, figure and finding of the thesis (B. S. Mahal, Heriot-Watt University, 2010) that can be run, beside\n\
         what Sheetwork measures. Generated by `sheetwork bench thesis`; `--row NAME` runs one row, and the scenes that a row\n\
         names open in the editor. Times of the host (CPU time, times of the users) are those of the machine that ran it.\n\n\
         \"Fitted\" says that numbers of the scene, which its comment names, are fitted to the printed times. A proposal is what the thesis recommends for further work, or left out; \"works\" says that it is built here and does\n\
         what the row states. In the pictures a sheet of one of the thesis's scenes is drawn smoothly through its masses, while\n\
         contact knows the masses alone: edges of bodies show through it, as in the thesis (row `7.3e-contact-surface`).\n\n\
         Where a scene does not state `inter_layer`, all its springs are equal, as in the thesis, and draped layers rest at 0.3\n\
         to 0.6 of their distance, flat ones at 0.5; `inter_layer: SumModulus(185)` restores flat ones to 0.9 (at 0.5 in\n\
         slide_8, whose wide cells would need a shorter step).\n\n",
    );
    let _ = writeln!(text, "{}.\n", summary(found));
    text.push_str("| row | subject | verdict |\n|---|---|---|\n");
    for (row, finding) in found {
        // Anchors of headings have no dots.
        let anchor = row.name.replace('.', "");
        let _ = writeln!(text, "| [`{}`](#{anchor}) | {} | {} |", row.name, row.title, finding.verdict.word());
    }
    text.push_str(INSTRUMENTS);
    for (row, finding) in found {
        section(&mut text, row, finding);
    }
    text
}

fn section(text: &mut String, row: &Row, finding: &Finding) {
    let _ = write!(
        text,
        "\n## {}\n\n**{}**: {}\n\n| | |\n|---|---|\n| thesis | {} |\n| here | {} |\n| measured | {} |\n",
        row.name,
        row.title,
        finding.verdict.word(),
        row.says,
        row.here,
        finding.measured.replace('\n', "<br>")
    );
    match &finding.verdict {
        Verdict::Agrees | Verdict::Fitted | Verdict::Works => {}
        Verdict::Disagrees(reason) => _ = writeln!(text, "| why not | {reason} |"),
        Verdict::Misprint(arithmetic) => _ = writeln!(text, "| arithmetic | {arithmetic} |"),
    }
    let _ = writeln!(text, "| command | `{}` |", command(row));
    let caption = finding.strip.as_ref().map(|s| &s.caption).or(finding.diagram.as_ref().map(|d| &d.caption));
    if let Some(caption) = caption {
        let _ = writeln!(text, "\n![{caption}](thesis/{}.png)", row.name);
    }
}
