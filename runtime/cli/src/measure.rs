//! `sheetwork measure`: a sheet on a virtual test rig.

use std::process::ExitCode;

use clap::Args;
use serde_json::Value;
use sheetwork::InputError;
use sheetwork::scene::SpringLaw;
use sheetwork_rigs::measure::{Setup, TABLE, measure};

use sheetwork_rigs::output::{OutputFlags, print_json, print_line};

#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct Measure {
    /// Rig, by name (see `sheetwork list cases`).
    case: String,
    #[command(flatten)]
    setup: Setup,
    #[command(flatten)]
    output: OutputFlags,
}

impl Measure {
    pub fn case(&self) -> &str {
        &self.case
    }

    pub fn execute(self) -> Result<ExitCode, InputError> {
        let found = measure(&self.case, &self.setup()?)?;
        if self.output.json {
            print_json(&found)?;
        } else if let Value::Object(map) = &found {
            let width = map.keys().map(String::len).max().unwrap_or(0);
            for (key, value) in map {
                if let Some(lines) = changes(value) {
                    print_line(key)?;
                    lines.iter().try_for_each(|line| print_line(&format!("  {line}")))?;
                    continue;
                }
                let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                print_line(&format!("{key:<width$}  {text}"))?;
            }
        }
        Ok(if found["status"] == "ok" { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    pub fn setup(&self) -> Result<Setup, InputError> {
        let contact = TABLE.iter().any(|c| c.name == self.case && c.contact);
        let explicit = !self.setup.engine.info().implicit;
        let springs = if contact && explicit { SpringLaw::Length } else { SpringLaw::Calibrated };
        Setup { springs, ..self.setup.clone() }.with_flags_applied()
    }
}

/// Changes of grid of the rig `detail` as a table: a row per shape, a column per change, with the
/// pop in percent of the deflection.
fn changes(value: &Value) -> Option<Vec<String>> {
    let mut rows: Vec<(&str, Vec<f64>)> = Vec::new();
    let mut columns: Vec<&str> = Vec::new();
    for change in value.as_array().filter(|all| !all.is_empty())? {
        let (shape, grids, pop) = (change["shape"].as_str()?, change["change"].as_str()?, change["pop"].as_f64()?);
        let column = columns.iter().position(|c| *c == grids).unwrap_or_else(|| {
            columns.push(grids);
            columns.len() - 1
        });
        let row = rows.iter().position(|r| r.0 == shape).unwrap_or_else(|| {
            rows.push((shape, Vec::new()));
            rows.len() - 1
        });
        let pops = &mut rows[row].1;
        pops.resize(pops.len().max(column + 1), f64::NAN);
        pops[column] = 100.0 * pop;
    }
    let mut lines = vec![format!("{:<12}", "pop, %") + &columns.iter().map(|c| format!("{c:>10}")).collect::<String>()];
    let cells = |pops: &[f64]| pops.iter().map(|p| format!("{p:>10.2}")).collect::<String>();
    lines.extend(rows.iter().map(|(shape, pops)| format!("{shape:<12}") + &cells(pops)));
    Some(lines)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::changes;

    #[test]
    fn changes_of_grid_are_printed_as_a_table() {
        let row = |shape: &str, change: &str, pop: f64| json!({ "shape": shape, "change": change, "pop": pop });
        let all =
            json!([row("droop", "11 to 21", 0.0031), row("box", "11 to 21", 0.0085), row("droop", "21 to 11", 0.01)]);
        let words = |line: &String| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>().join(" ");
        let lines: Vec<String> = changes(&all).expect("a table").iter().map(words).collect();
        assert_eq!(lines, ["pop, % 11 to 21 21 to 11", "droop 0.31 1.00", "box 0.85"]);
        assert_eq!(changes(&json!([1.0, 2.0])), None);
        assert_eq!(changes(&json!([])), None);
    }
}
