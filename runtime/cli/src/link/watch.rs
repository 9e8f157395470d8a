//! `sheetwork watch`: shows a running game in a terminal, or as lines of CSV or JSON.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args;
use serde_json::{Value, json};
use sheetwork::{InputError, check_range};
use sheetwork_link::layout::{FrameHeader, FrameView, SheetView};
use sheetwork_link::{Client, Frame, LinkError};

use crate::link::GameSelection;
use sheetwork_rigs::output::print_line;
use sheetwork_rigs::quantities::time;

/// Refresh interval of a terminal, and interval of output to anything else.
const DRAWN_EVERY: [Duration; 2] = [Duration::from_millis(100), Duration::from_secs(1)];
/// Characters of a sparkline.
const SPARK: usize = 40;
/// Columns of the CSV.
const COLUMNS: &str = "epoch,frame,time_s,step_time_s,sheet,status,contacts,lowest_m,mean_m,highest_m,\
                       kinetic_j,elastic_j,gravity_j,total_j,coldest_c,mean_c,hottest_c";

/// Shows a running game.
#[derive(Args)]
pub struct Watch {
    #[command(flatten)]
    target: GameSelection,
    /// Show only this sheet.
    #[arg(long)]
    sheet: Option<String>,
    /// Show energies too, which the game computes for every frame read.
    #[arg(long)]
    energy: bool,
    /// Print one line of CSV for every sheet of every frame.
    #[arg(long)]
    csv: bool,
    /// Print one JSON object per line for every frame and every event.
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Stop after this number of frames.
    #[arg(long)]
    frames: Option<u64>,
    /// Duration, s; unlimited by default, until Ctrl-C.
    #[arg(long, value_parser = time)]
    seconds: Option<f64>,
}

/// Displayed values of a sheet.
struct Row {
    name: String,
    status: &'static str,
    contacts: u32,
    /// Lowest, mean and highest y, m.
    heights: [f64; 3],
    energy: [f64; 4],
    /// Lowest, mean and highest temperature, °C, of a sheet with temperatures.
    celsius: Option<[f64; 3]>,
}

/// Minimum, mean and maximum.
fn spread(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let (mut low, mut sum, mut high, mut count) = (f64::INFINITY, 0.0, f64::NEG_INFINITY, 0_u32);
    for value in values {
        (low, sum, high, count) = (low.min(value), sum + value, high.max(value), count + 1);
    }
    [low, sum / f64::from(count.max(1)), high]
}

impl Row {
    fn of(sheet: &SheetView) -> Self {
        let (header, celsius) = (sheet.header(), sheet.temperature());
        Self {
            name: header.name().to_owned(),
            status: ["awake", "asleep", "unstable", "frozen"].get(header.status as usize).copied().unwrap_or("?"),
            contacts: header.contacts,
            heights: spread(sheet.positions().iter().map(|p| f64::from(p[1]))),
            energy: header.energy,
            celsius: (!celsius.is_empty()).then(|| spread(celsius.iter().map(|t| f64::from(*t)))),
        }
    }

    fn csv(&self, h: &FrameHeader) -> String {
        let [low, mean, high] = self.heights;
        let energy = self.energy.map(|e| if e.is_nan() { String::new() } else { format!("{e:.9e}") }).join(",");
        let celsius = self.celsius.map_or_else(|| ",,".to_owned(), |c| c.map(|t| format!("{t:.3}")).join(","));
        format!(
            "{},{},{:.6},{:.3e},{},{},{},{low:.6},{mean:.6},{high:.6},{energy},{celsius}",
            h.epoch, h.frame, h.time, h.step_time, self.name, self.status, self.contacts
        )
    }

    fn json(&self) -> Value {
        let [low, mean, high] = self.heights;
        let mut row = json!({
            "name": self.name, "status": self.status, "contacts": self.contacts,
            "lowest_m": low, "mean_m": mean, "highest_m": high,
        });
        if !self.energy[3].is_nan() {
            let [kinetic, elastic, gravity, total] = self.energy;
            row["energy_j"] = json!({ "kinetic": kinetic, "elastic": elastic, "gravity": gravity, "total": total });
        }
        if let Some([min, mean, max]) = self.celsius {
            row["temperature_c"] = json!({ "min": min, "mean": mean, "max": max });
        }
        row
    }
}

impl Watch {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--seconds", self.seconds.unwrap_or(0.0), 0.0, 1e9, "s")?;
        let client = self.target.attach()?;
        if self.csv || self.json { self.lines(&client) } else { self.view(&client) }
    }

    fn rows(&self, view: &FrameView) -> Vec<Row> {
        let wanted = |s: &SheetView| self.sheet.as_deref().is_none_or(|name| name == s.header().name());
        view.sheets().filter(wanted).map(|s| Row::of(&s)).collect()
    }

    fn is_over(&self, start: Instant, frames: u64) -> bool {
        let late = self.seconds.is_some_and(|s| start.elapsed().as_secs_f64() >= s);
        late || self.frames.is_some_and(|n| frames >= n)
    }

    /// Prints every frame as lines, until the reader closes, the game is silent, or a limit is
    /// reached.
    fn lines(&self, client: &Client) -> Result<ExitCode, InputError> {
        let mut frames = client.frames(self.energy)?;
        let mut events = client.events()?;
        let (start, mut count) = (Instant::now(), 0);
        let mut out = std::io::stdout().lock();
        let mut say = |line: &str| writeln!(out, "{line}").is_ok();
        if self.csv && !say(COLUMNS) {
            return Ok(ExitCode::SUCCESS);
        }
        while !self.is_over(start, count) {
            let frame = match frames.wait(Duration::from_millis(50)) {
                Ok(frame) => frame,
                Err(LinkError::Silent) => continue,
                Err(error) => return Err(error.into()),
            };
            count += 1;
            let view = frame.view()?;
            let (header, rows) = (view.header(), self.rows(&view));
            let written = if self.csv {
                rows.iter().all(|row| say(&row.csv(header)))
            } else {
                let mut told = true;
                while let Some(event) = events.next()? {
                    told &= say(&json!({ "event": event }).to_string());
                }
                let object = json!({
                    "epoch": header.epoch, "frame": header.frame, "time_s": header.time,
                    "step_time_s": header.step_time, "playing": header.playing == 1,
                    "sheets": rows.iter().map(Row::json).collect::<Vec<_>>(),
                });
                told && say(&object.to_string())
            };
            if !written {
                break;
            }
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Refreshes the terminal view.
    fn view(&self, client: &Client) -> Result<ExitCode, InputError> {
        let mut frames = client.frames(self.energy)?;
        let mut events = client.events()?;
        let standing = client.status()?;
        let mut screen = Screen::new(&standing.scene, &standing.engine);
        let (start, mut count, mut drawn) = (Instant::now(), 0, Instant::now());
        let mut newest: Option<Frame> = None;
        while !self.is_over(start, count) {
            while let Some(event) = events.next()? {
                screen.note(&event);
            }
            while let Some(frame) = frames.next()? {
                screen.count(frame.header());
                count += 1;
                newest = Some(frame);
            }
            if drawn.elapsed() >= DRAWN_EVERY[usize::from(!screen.live)] {
                drawn = Instant::now();
                if let Some(frame) = &newest {
                    let view = frame.view()?;
                    screen.draw(view.header(), &self.rows(&view), (frames.missed(), frames.restarts()))?;
                }
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        if let Some(frame) = &newest {
            let view = frame.view()?;
            screen.draw(view.header(), &self.rows(&view), (frames.missed(), frames.restarts()))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Terminal view.
struct Screen {
    title: String,
    live: bool,
    lines: usize,
    /// Mean heights, energies and highest temperatures of each sheet, oldest first.
    history: BTreeMap<String, [Vec<f64>; 3]>,
    events: Vec<String>,
    /// Start and count of the present second's arrivals, and frames per second in the last second.
    arrived: (Instant, u32),
    rate: f64,
    heard: Instant,
}

impl Screen {
    fn new(scene: &str, engine: &str) -> Self {
        Self {
            title: format!("{scene} · {engine}"),
            live: std::io::stdout().is_terminal(),
            lines: 0,
            history: BTreeMap::new(),
            events: Vec::new(),
            arrived: (Instant::now(), 0),
            rate: 0.0,
            heard: Instant::now(),
        }
    }

    fn note(&mut self, event: &serde_json::Map<String, Value>) {
        let text = |key: &str| event.get(key).and_then(Value::as_str).unwrap_or_default();
        let time = event.get("time_s").and_then(Value::as_f64).unwrap_or_default();
        self.events.push(format!("{time:9.4} s  {}: {} {}", text("sheet"), text("kind"), text("body")));
        let from = self.events.len().saturating_sub(5);
        self.events.drain(..from);
    }

    fn count(&mut self, _header: &FrameHeader) {
        self.heard = Instant::now();
        self.arrived.1 += 1;
        let elapsed = self.arrived.0.elapsed().as_secs_f64();
        if elapsed >= 1.0 {
            self.rate = f64::from(self.arrived.1) / elapsed;
            self.arrived = (Instant::now(), 0);
        }
    }

    fn draw(&mut self, h: &FrameHeader, rows: &[Row], (missed, restarts): (u64, u64)) -> Result<(), InputError> {
        let state = match (h.playing, self.heard.elapsed().as_secs_f64()) {
            (_, quiet) if quiet > 1.0 => format!("quiet for {quiet:.0} s"),
            (1, _) => "playing".into(),
            _ => "paused".into(),
        };
        let mut lines = vec![
            format!("{} · {state}", self.title),
            format!(
                "{:.3} s, step {:.3} ms took {:.3} ms · {:.0} frames/s, {missed} missed, {restarts} restarts",
                h.time,
                1e3 * h.dt,
                1e3 * h.step_time,
                self.rate
            ),
            String::new(),
        ];
        for row in rows {
            let kept = self.history.entry(row.name.clone()).or_default();
            let hottest = row.celsius.map_or(f64::NAN, |c| c[2]);
            for (list, value) in kept.iter_mut().zip([row.heights[1], row.energy[0], hottest]) {
                list.push(value);
                let from = list.len().saturating_sub(SPARK);
                list.drain(..from);
            }
            let [low, mean, high] = row.heights;
            lines.push(format!("{:<20} {:<8} {:>5} touch", row.name, row.status, row.contacts));
            lines.push(format!("  height {low:>9.4} {mean:>9.4} {high:>9.4} m  {}", spark(&kept[0])));
            if let Some([low, mean, high]) = row.celsius {
                lines.push(format!("  temp   {low:>9.2} {mean:>9.2} {high:>9.2} °C {}", spark(&kept[2])));
            }
            if !row.energy[3].is_nan() {
                let [kinetic, elastic, ..] = row.energy;
                lines.push(format!("  energy {kinetic:>9.2e} kinetic {elastic:>9.2e} elastic J  {}", spark(&kept[1])));
            }
        }
        lines.extend(std::iter::once(String::new()).chain(self.events.iter().cloned()));
        let mut text = String::new();
        if self.live && self.lines > 0 {
            // Cursor to the first line; each line is cleared as it is written.
            text = format!("\x1b[{}A", self.lines);
        }
        let clear = if self.live { "\x1b[K" } else { "" };
        text.push_str(&lines.iter().map(|l| format!("{l}{clear}")).collect::<Vec<_>>().join("\n"));
        if self.live && self.lines > lines.len() {
            text.push_str("\x1b[J");
        }
        self.lines = lines.len();
        print_line(&text)
    }
}

/// Values as a row of block characters, scaled to their range.
fn spark(values: &[f64]) -> String {
    const BLOCKS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let level = |v: &f64| {
        let part = if high > low { (v - low) / (high - low) } else { 0.0 };
        BLOCKS[((part * 7.0).round() as usize).min(7)]
    };
    values.iter().map(level).collect()
}
