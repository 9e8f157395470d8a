//! `sheetwork bench stability`: runs the map of stability limits, or merges the results of its
//! shards, and writes table, CSV and pictures.

pub(crate) mod map;
pub(crate) mod plan;
pub(crate) mod point;
pub(crate) mod table;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use sheetwork::InputError;
use sheetwork::mesh::structure::StructureKind;

use crate::bench::stability::map::StabilityMap;
use crate::bench::stability::plan::{PlannedTrial, SWEEPS, plan};
use crate::bench::stability::point::{StabilityPoint, merge};
use crate::bench::{canvas, run_shard, shard, write_csv};
use crate::output::print_line;

#[derive(Args)]
pub struct Stability {
    /// Folder for stability.csv, .md, and stability-STRUCTURE.svg and .png.
    #[arg(long, default_value = "sheetwork-out/stability")]
    out: PathBuf,
    /// Run only every N-th point from the I-th on, 1 to N, and write only stability-I-of-N.csv.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,
    /// Run nothing: read the CSV files that shards wrote to these folders.
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["shard", "quick"])]
    merge: Vec<PathBuf>,
    /// Run only these sweeps, comma-separated: map, aspect, thickness, jump, speed, thesis,
    /// thesis-common.
    #[arg(long, value_name = "SWEEP", value_delimiter = ',', value_parser = SWEEPS, conflicts_with = "merge")]
    only: Vec<String>,
    /// Run only these structures, comma-separated.
    #[arg(long, value_name = "NAME", value_delimiter = ',', conflicts_with = "merge")]
    structures: Vec<StructureKind>,
    /// A few points of each kind, as a smoke test.
    #[arg(long)]
    quick: bool,
}

impl Stability {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        std::fs::create_dir_all(&self.out).map_err(|e| InputError::io(&self.out, &e))?;
        let points = if self.merge.is_empty() { self.run()? } else { merge(&self.merge)? };
        if let Some((which, of)) = self.shard {
            let path = self.out.join(format!("stability-{which}-of-{of}.csv"));
            write_csv(&path, &points)?;
            print_line(&path.display().to_string())?;
            return Ok(ExitCode::SUCCESS);
        }
        self.write(&points)?;
        Ok(ExitCode::SUCCESS)
    }

    /// Runs all points, or those of the shard.
    fn run(&self) -> Result<Vec<StabilityPoint>, InputError> {
        let wanted = |sweep: &str| self.only.is_empty() || self.only.iter().any(|s| s == sweep);
        let of_these = |kind: StructureKind| self.structures.is_empty() || self.structures.contains(&kind);
        let fits = |trial: &PlannedTrial| wanted(trial.sweep) && of_these(trial.setting.structure);
        // Numbered within the selection, so that shards of a selection can be merged.
        let chosen: Vec<PlannedTrial> = plan(self.quick).into_iter().filter(fits).collect();
        if chosen.is_empty() {
            return Err(InputError::new("--only", "nothing of the plan is left with these sweeps and structures"));
        }
        let count = chosen.len();
        let numbered = chosen.into_iter().enumerate();
        run_shard(self.shard, numbered, |(_, trial)| trial.name(), |(number, trial)| trial.run(number, count))
    }

    fn write(&self, points: &[StabilityPoint]) -> Result<(), InputError> {
        let [csv, md] = ["csv", "md"].map(|kind| self.out.join(format!("stability.{kind}")));
        write_csv(&csv, points)?;
        let text = table::markdown(points);
        std::fs::write(&md, &text).map_err(|e| InputError::io(&md, &e))?;
        print_line(text.trim_end())?;
        let mut written = vec![csv, md];
        for structure in [StructureKind::Trimm, StructureKind::Shell] {
            let map = StabilityMap::new(points, structure.info().name);
            if map.is_empty() {
                continue;
            }
            let [svg, png] = ["svg", "png"].map(|kind| self.out.join(format!("stability-{structure}.{kind}")));
            canvas::svg(&svg, &map)?;
            canvas::png(&png, &map)?;
            written.extend([svg, png]);
        }
        written.iter().try_for_each(|path| print_line(&path.display().to_string()))
    }
}
