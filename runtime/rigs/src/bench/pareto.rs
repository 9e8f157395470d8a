//! `sheetwork bench pareto`: runs the sweep, or merges the results of its shards, and writes table,
//! CSV and plot.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use sheetwork::InputError;

use crate::bench::plot::Plot;
use crate::bench::point::{ParetoPoint, read_csv, read_peers};
use crate::bench::reference::References;
use crate::bench::sweep::plan;
use crate::bench::{canvas, files_of, run_shard, shard, table, write_csv};
use crate::output::print_line;

#[derive(Args)]
pub struct Pareto {
    /// Folder for pareto.csv, .md, .svg and .png.
    #[arg(long, default_value = "sheetwork-out/pareto")]
    out: PathBuf,
    /// Points of peers, JSON lines as written by `tests/peers/run.sh FILE` on the same machine; may
    /// be repeated.
    #[arg(long, value_name = "FILE.jsonl", conflicts_with = "shard")]
    peers: Vec<PathBuf>,
    /// Run only every N-th configuration from the I-th on, 1 to N; write only pareto-I-of-N.csv.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,
    /// Run nothing: read the CSV files that shards wrote to these folders.
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["shard", "quick"])]
    merge: Vec<PathBuf>,
    /// A few configurations of each kind, as a smoke test.
    #[arg(long)]
    quick: bool,
}

impl Pareto {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        std::fs::create_dir_all(&self.out).map_err(|e| InputError::io(&self.out, &e))?;
        let mut references = References::new(self.quick);
        let mut points = if self.merge.is_empty() { self.run(&mut references)? } else { merge(&self.merge)? };
        if let Some((which, of)) = self.shard {
            let path = self.out.join(format!("pareto-{which}-of-{of}.csv"));
            write_csv(&path, &points)?;
            print_line(&path.display().to_string())?;
            return Ok(ExitCode::SUCCESS);
        }
        for path in &self.peers {
            points.extend(read_peers(path, &mut references)?);
        }
        self.write(&points)?;
        Ok(ExitCode::SUCCESS)
    }

    /// Runs all configurations, or those of the shard.
    fn run(&self, references: &mut References) -> Result<Vec<ParetoPoint>, InputError> {
        run_shard(self.shard, plan(self.quick).into_iter(), |c| c.name(), |c| c.run(references))
    }

    fn write(&self, points: &[ParetoPoint]) -> Result<(), InputError> {
        let [csv, md, svg, png] = ["csv", "md", "svg", "png"].map(|kind| self.out.join(format!("pareto.{kind}")));
        write_csv(&csv, points)?;
        let text = table::markdown(points);
        std::fs::write(&md, &text).map_err(|e| InputError::io(&md, &e))?;
        canvas::svg(&svg, &Plot(points))?;
        canvas::png(&png, &Plot(points))?;
        print_line(text.trim_end())?;
        for path in [csv, md, svg, png] {
            print_line(&path.display().to_string())?;
        }
        Ok(())
    }
}

/// Points of all CSV files of the folders, in the order of file names. The first result of a
/// configuration counts.
fn merge(folders: &[PathBuf]) -> Result<Vec<ParetoPoint>, InputError> {
    let mut points = Vec::new();
    for folder in folders {
        for file in files_of(folder, "csv")? {
            for point in read_csv(&file)? {
                if !points.iter().any(|p: &ParetoPoint| p.is_same_configuration(&point)) {
                    points.push(point);
                }
            }
        }
    }
    if points.is_empty() {
        return Err(InputError::new("merge", "the folders hold no CSV file with points"));
    }
    Ok(points)
}
