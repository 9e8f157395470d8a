//! `sheetwork run`: steps a scene to its end and reports the result.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use cpu_time::ProcessTime;
use indicatif::{ProgressBar, ProgressStyle};
use sheetwork::scene::{IntegratorKind, Scene, library};
use sheetwork::sheet::FractureOpening;
use sheetwork::world::journal::{JournalInput, JournalWriter};
use sheetwork::world::recording::RecordingWriter;
use sheetwork::{InputError, Report, World, check_range};

use crate::apply_overrides;
use crate::force_table::ForceTable;
use sheetwork_rigs::drawn_surface::{DrawnSurface, drawn_surfaces};
use sheetwork_rigs::output::{check_writable, print_json, print_line};
use sheetwork_rigs::quantities::{self, time};

/// Frames per simulated second for the recording, the progress bar and the penetration statistics.
const FRAME_RATE: f64 = 60.0;

#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct Run {
    /// Scene file (RON), or the name of one in assets/scenes.
    scene: PathBuf,
    /// Simulated time, s; default the scene's own.
    #[arg(long, value_parser = time)]
    seconds: Option<f64>,
    /// Time step, s, or a fraction such as 1/60.
    #[arg(long, value_parser = time)]
    dt: Option<f64>,
    /// Time integrator, by name (see `sheetwork list engines`).
    #[arg(long)]
    engine: Option<IntegratorKind>,
    /// Number of threads that step sheets, 1 by default; the result is independent of it.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Disable sleeping of sheets at rest.
    #[arg(long)]
    no_sleep: bool,
    /// Set any field of the scene: PATH=VALUE, as in sheets.0.material.young=2e9. May be repeated.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Write the report to a file, as JSON.
    #[arg(long)]
    report: Option<PathBuf>,
    /// Record positions, 60 frames per simulated second.
    #[arg(long)]
    record: Option<PathBuf>,
    /// Record the forces on the sheets: in the report those of the last step, in this CSV file
    /// those of the last step of every frame.
    #[arg(long)]
    forces: Option<PathBuf>,
    /// Write a journal of inputs and checksums of every step, for `sheetwork replay`.
    #[arg(long)]
    journal: Option<PathBuf>,
    /// Steps between snapshots in the journal.
    #[arg(long, default_value_t = 60)]
    key_every: u32,
    /// Set a parameter during the run, at a simulated time (s): TIME:PATH=VALUE, as in
    /// 0.5:gravity=(0,0,0). May be repeated.
    #[arg(long = "at", value_name = "TIME:PATH=VALUE")]
    changes: Vec<String>,
    /// Measure at the end how deep each drawn surface of the sheets lies in bodies, and how ragged
    /// its edges are.
    #[arg(long)]
    surfaces: bool,
    /// Check each step, independently of the contact solver, that no sheet is within a body,
    /// another sheet or itself by more than a tenth of its thickness; the status is not ok if one
    /// is.
    #[arg(long)]
    check_penetration: bool,
    /// Print the report as JSON and nothing else.
    #[arg(long)]
    json: bool,
}

impl Run {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let scene = self.scene()?;
        // Before the run, so that an invalid path fails at once.
        [&self.report, &self.record, &self.forces, &self.journal]
            .into_iter()
            .flatten()
            .try_for_each(|file| check_writable(file))?;
        let mut world = World::new(&scene)?;
        if self.threads == 0 || self.threads > 1024 {
            return Err(InputError::new("--threads", format!("{} is outside 1 to 1024", self.threads)));
        }
        check_range("--key-every", f64::from(self.key_every), 1.0, 1e6, "steps")?;
        world.set_threads(self.threads)?;
        world.set_sleep(!self.no_sleep);
        world.set_penetration_check(self.check_penetration);
        world.record_forces(self.forces.is_some());
        let report = self.step(&mut world)?;
        let surfaces = if self.surfaces { drawn_surfaces(&world) } else { Vec::new() };
        let mut tree = serde_json::to_value(&report).map_err(|e| InputError::new("report", e.to_string()))?;
        if self.surfaces {
            tree["drawn_surfaces"] =
                serde_json::to_value(&surfaces).map_err(|e| InputError::new("report", e.to_string()))?;
        }
        if let Some(file) = &self.report {
            let text = serde_json::to_string_pretty(&tree).map_err(|e| InputError::new("report", e.to_string()))?;
            std::fs::write(file, text).map_err(|e| InputError::io(file, &e))?;
        }
        if self.json {
            print_json(&tree)?;
        } else {
            print_line(&table(&report))?;
            surfaces.iter().try_for_each(|s| print_line(&surface_line(s)))?;
        }
        if world.unstable().is_some() {
            stable_steps(&World::new(&scene)?).iter().for_each(|note| eprintln!("note: {note}"));
        }
        unresolved_folds(&report).iter().for_each(|note| eprintln!("note: {note}"));
        Ok(if report.status == "ok" { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    /// The scene with the overrides of the command line.
    fn scene(&self) -> Result<Scene, InputError> {
        let mut scene = apply_overrides(Scene::load(&library::find(&self.scene))?, &self.overrides)?;
        for (flag, path, value) in [("--seconds", "duration", self.seconds), ("--dt", "dt", self.dt)] {
            if let Some(value) = value {
                let set = scene.with_override(path, &value.to_string());
                scene = set.map_err(|e| InputError::new(flag, e.problem.as_str()))?;
            }
        }
        if let Some(engine) = self.engine {
            scene.engine = engine;
        }
        Ok(scene)
    }

    fn step(&self, world: &mut World) -> Result<Report, InputError> {
        let duration = world.scene().duration;
        let (mut dt, mut steps, mut per_frame) = plan(duration, world);
        let mut recorder = self
            .record
            .as_ref()
            .map(|f| RecordingWriter::create(f, world, 1.0 / (per_frame as f64 * world.dt())))
            .transpose()?;
        let mut journal = self.journal.as_ref().map(|f| JournalWriter::create(f, world, self.key_every)).transpose()?;
        let mut forces = self.forces.as_deref().map(ForceTable::create).transpose()?;
        let mut changes = self.changes(duration)?;
        let bar = self.bar(steps);
        let mut penetration = Vec::new();
        let mut cpu = 0.0;
        let mut done = 0;
        loop {
            world.update_max_penetration(&mut penetration);
            recorder.as_mut().map_or(Ok(()), |recorder| recorder.frame(world))?;
            forces.as_mut().map_or(Ok(()), |forces| forces.frame(world))?;
            if done >= steps || (world.unstable().is_some() && world.is_resting()) {
                break;
            }
            let batch = per_frame.min(steps - done);
            let start = ProcessTime::now();
            for _ in 0..batch {
                // Sorted by time, the last first.
                while let Some((_, input)) = changes.pop_if(|(time, _)| *time <= world.time() + 1e-9 * world.dt()) {
                    match &mut journal {
                        Some(journal) => journal.input(world, input)?,
                        None => input.apply(world)?,
                    }
                }
                match &mut journal {
                    Some(journal) => journal.step(world)?,
                    None => _ = world.step(),
                }
            }
            cpu += start.elapsed().as_secs_f64();
            done += batch;
            if world.dt() != dt {
                (dt, steps, per_frame) = plan(duration, world);
                steps += done;
                bar.set_length(steps);
            }
            bar.set_position(done);
        }
        bar.finish_and_clear();
        recorder.map_or(Ok(0), |recorder| recorder.finish())?;
        forces.map_or(Ok(()), ForceTable::finish)?;
        journal.map_or(Ok(()), |journal| journal.finish())?;
        Ok(world.report(cpu, &penetration))
    }

    /// Parameter changes during the run, sorted by time, the last first.
    fn changes(&self, duration: f64) -> Result<Vec<(f64, JournalInput)>, InputError> {
        let bad = |item: &str| InputError::new("--at", format!("\"{item}\" is not TIME:PATH=VALUE"));
        let mut all = Vec::with_capacity(self.changes.len());
        for item in &self.changes {
            let (time, set) = item.split_once(':').ok_or_else(|| bad(item))?;
            let (path, value) = set.split_once('=').ok_or_else(|| bad(item))?;
            let time = quantities::time(time).map_err(|e| InputError::new("--at", e))?;
            check_range("--at", time, 0.0, duration, "s")?;
            all.push((time, JournalInput::Set { path: path.trim().to_owned(), value: value.to_owned() }));
        }
        all.reverse();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        Ok(all)
    }

    /// A progress bar on standard error; indicatif hides it where that is not a terminal.
    fn bar(&self, steps: u64) -> ProgressBar {
        if self.json {
            return ProgressBar::hidden();
        }
        let style = ProgressStyle::with_template("{bar:40.cyan/blue} {percent:>3} %  {elapsed} elapsed, {eta} left");
        ProgressBar::new(steps).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
    }
}

/// Present step (s), number of such steps to a time (s), and between two frames of a recording.
fn plan(duration: f64, world: &World) -> (f64, u64, u64) {
    let (dt, left) = (world.dt(), duration - world.time());
    (dt, (left / dt - 1e-9).ceil().max(0.0) as u64, ((1.0 / FRAME_RATE / dt).round() as u64).max(1))
}

/// For every sheet of an explicit integrator with a fixed step that is longer than 1 rad of the
/// fastest mode at rest: the step in radians, and the step of 1 rad, which every explicit
/// integrator holds.
fn stable_steps(world: &World) -> Vec<String> {
    let engine = world.engine().info();
    if engine.implicit || engine.adaptive {
        return Vec::new();
    }
    let dt = world.dt();
    let each = world.sheets().iter().filter_map(|sheet| {
        let radians = sheet.largest_frequency(200) * dt;
        (radians > 1.0).then(|| {
            let (name, stable) = (&sheet.name, dt / radians);
            format!("{name}: the step of {dt} s is {radians:.2} rad of its fastest mode; {stable:.2e} s is 1 rad")
        })
    });
    each.collect()
}

/// For every plastic sheet with cells too long for its folds: radius of yield and longest cell that
/// resolves it.
fn unresolved_folds(report: &Report) -> Vec<String> {
    let each = report.sheets.iter().filter_map(|sheet| {
        let f = sheet.unresolved_folds?;
        let (radius, most, cell) = (1e3 * f.yield_radius_m, 1e3 * f.resolving_cell_m, 1e3 * f.cell_m);
        let name = &sheet.name;
        Some(format!(
            "{name}: yields at a radius of {radius:.3} mm; folds need cells of at most {most:.3} mm, not {cell:.3} mm"
        ))
    });
    each.collect()
}

fn table(report: &Report) -> String {
    let mut lines = vec![
        format!("scene      {}", report.scene),
        format!("engine     {}, step {:.6} s", report.engine, report.dt_s),
        format!(
            "simulated  {:.3} s in {} steps, {:.4} s of CPU ({:.3} times real time)",
            report.simulated_s,
            report.steps,
            report.cpu_s,
            report.simulated_s / report.cpu_s.max(1e-9)
        ),
        format!("status     {}", report.status),
    ];
    for sheet in &report.sheets {
        let e = &sheet.energy_j;
        lines.push(String::new());
        lines.push(format!(
            "{}: {}, {} masses, {} springs{}",
            sheet.name,
            sheet.structure,
            sheet.masses,
            sheet.springs,
            if sheet.asleep { ", asleep" } else { "" }
        ));
        lines.push(format!(
            "  energy   {:.3e} J kinetic, {:.3e} elastic, {:.3e} gravity, {:.3e} total",
            e.kinetic, e.elastic, e.gravity, e.total
        ));
        lines.push(format!(
            "  fastest  {:.3e} m/s; deepest in a body {:.2e} m; {} steps rejected",
            sheet.max_speed_m_s, sheet.max_penetration_m, sheet.steps_rejected
        ));
        for (name, p) in &sheet.probes {
            lines.push(format!("  {name:<8} ({:.5}, {:.5}, {:.5}) m", p[0], p[1], p[2]));
        }
    }
    if !report.events.is_empty() {
        lines.push(String::new());
    }
    for event in &report.events {
        let kind = serde_json::to_value(event.kind).ok().and_then(|v| v.as_str().map(str::to_owned));
        let body = event.body.as_ref().map_or_else(String::new, |b| format!(", {b}"));
        let opening = event.opening.as_ref().map_or_else(String::new, opening);
        lines.push(format!("{:>9.4} s  {}: {}{body}{opening}", event.time_s, event.sheet, kind.unwrap_or_default()));
    }
    lines.join("\n")
}

/// Line of a drawn surface.
fn surface_line(s: &DrawnSurface) -> String {
    let depth = s.depth_m.map_or("outside of bodies".to_owned(), |d| format!("{:.3} mm inside a body", 1e3 * d));
    format!(
        "surface    {} layer {}, {:<13}  {depth}; {:.3} mm from the nodes, edge bends by {:.1}°",
        s.sheet,
        s.layer,
        s.smoothing,
        1e3 * s.off_nodes_m,
        s.edge_kink_deg
    )
}

/// Place and cause of an opened cell.
fn opening(o: &FractureOpening) -> String {
    let [x, y, z] = o.place_m;
    let how = if o.melted { "melted" } else { "torn" };
    let warm = o.temperature_c.map_or_else(String::new, |t| format!(", {t:.1} °C"));
    format!(", {how} at ({x:.4}, {y:.4}, {z:.4}) m, strain {:.3} %{warm}", 100.0 * o.strain)
}
