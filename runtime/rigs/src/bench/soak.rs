//! `sheetwork bench soak`: endurance of the live link.
//!
//! A small sheet is stepped and published at full speed for as many frames as an hour at 240 Hz has
//! (default). A second process of this program reads throughout. A third attaches, reads all
//! streams, sets a parameter and detaches, in a loop, and is killed twenty times. The game's memory
//! and its objects in shared memory are recorded before any reader attaches, after a tenth of the
//! frames, and at the end; between the last two neither may grow.

use std::path::Path;
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use clap::Args;
use serde::Serialize;
use serde_json::{Value, json};
use sheetwork::scene::{PinSpec, Region, Scene, SheetSpec};
use sheetwork::{InputError, World, check_range};
use sheetwork_link::link_place::{LinkPlace, ROOT_VARIABLE};
use sheetwork_link::{Client, Link, LinkError};

use crate::bench::link::BenchedGame;
use crate::bench::memory;
use crate::output::{OutputFlags, print_line};

/// Number of times that the visiting process is killed.
const KILLS: u64 = 20;
/// Tolerance on the number of shared-memory objects, for a reader that is attaching or detaching.
const OBJECTS: usize = 12;
/// Name of the link.
const NAME: &str = "soak";

#[derive(Args)]
pub struct Soak {
    /// Frames; 864000 are an hour at 240 Hz.
    #[arg(long, default_value_t = 864_000)]
    frames: u64,
    #[command(flatten)]
    output: OutputFlags,
    /// Role of a reader process: one that stays, or one that attaches and detaches.
    #[arg(long, hide = true)]
    reader: Option<String>,
}

/// Resources that must not grow.
#[derive(Clone, Copy, Serialize)]
struct ResourceUsage {
    memory_bytes: u64,
    objects: usize,
}

impl ResourceUsage {
    /// Present memory of this process (bytes), and objects of the link in shared memory.
    fn now(place: &LinkPlace) -> Self {
        let memory_bytes = memory::process_memory();
        let prefix = place.prefix();
        let all = std::fs::read_dir("/dev/shm").into_iter().flatten().flatten();
        let objects = all.filter(|e| e.file_name().to_string_lossy().starts_with(&prefix)).count();
        Self { memory_bytes, objects }
    }
}

impl Soak {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--frames", self.frames as f64, 100.0, 1e12, "")?;
        match self.reader.as_deref() {
            Some("stays") => return read_until_killed(),
            Some(_) => return attach_and_detach(),
            None => {}
        }
        let root = std::env::temp_dir().join(format!("sheetwork-soak-{}", std::process::id()));
        let result = self.run(&root);
        let _ = std::fs::remove_dir_all(&root);
        let (result, grown) = result?;
        let last = if grown { "it has grown" } else { "nothing has grown" };
        let (seconds, commands) = (&result["seconds"], &result["commands"]);
        self.output.print(
            || &result,
            || format!("{} frames in {seconds:.0} s, {commands} commands, {KILLS} kills; {last}", self.frames),
        )?;
        Ok(if grown { ExitCode::from(1) } else { ExitCode::SUCCESS })
    }

    /// Runs the game; returns its report, and whether a resource has grown.
    fn run(&self, root: &Path) -> Result<(Value, bool), InputError> {
        let mut game = BenchedGame(World::new(&scene())?);
        game.0.set_sleep(false);
        let place = LinkPlace::within(root, NAME)?;
        let mut link = Link::new(&place, &game.0)?;
        let before = ResourceUsage::now(&place);
        self.print_progress("before", 0, before)?;
        let mut stays = ReaderProcess::start(root, "stays")?;
        while link.statistics().readers[0] == 0 {
            link.exchange(&mut game, 0.0);
            std::thread::sleep(Duration::from_millis(1));
            stays.check()?;
        }
        let mut visits = ReaderProcess::start(root, "visits")?;
        let (start, mut warm) = (Instant::now(), before);
        for frame in 1..=self.frames {
            game.0.step();
            link.exchange(&mut game, 0.0);
            if frame.is_multiple_of(self.frames / (KILLS + 1)) && frame < self.frames {
                visits = ReaderProcess::start(root, "visits")?;
            }
            if frame.is_multiple_of(self.frames / 10) {
                let held = ResourceUsage::now(&place);
                self.print_progress("frames", frame, held)?;
                if frame == self.frames / 10 {
                    warm = held;
                }
            }
        }
        let seconds = start.elapsed().as_secs_f64();
        let (after, now) = (ResourceUsage::now(&place), link.statistics());
        drop((stays, visits));
        let grown = after.memory_bytes > warm.memory_bytes + memory::MEMORY_GROWTH_TOLERANCE
            || after.objects > warm.objects + OBJECTS;
        let result = json!({
            "frames": self.frames, "seconds": seconds, "written": now.frames, "bytes": now.bytes, "dropped": now.dropped,
            "commands": now.accepted, "kills": KILLS, "before": before, "warm": warm, "after": after,
            "grown": grown,
        });
        Ok((result, grown))
    }

    fn print_progress(&self, what: &str, frame: u64, held: ResourceUsage) -> Result<(), InputError> {
        if self.output.json {
            return Ok(());
        }
        let kb = held.memory_bytes as f64 / 1024.0;
        print_line(&format!("{what:<7}{frame:>9} {kb:>8.0} kB {:>4} objects in shared memory", held.objects))
    }
}

/// A small sheet, clamped at one edge, at 240 Hz.
fn scene() -> Scene {
    let pins = vec![PinSpec::clamped(Region::Left)];
    let sheet = SheetSpec {
        name: "strip".into(),
        structure: sheetwork::mesh::structure::StructureKind::Shell,
        grid: (9, 1, 5),
        size: (0.2, 0.1),
        material: "pet".into(),
        pins,
        ..SheetSpec::thesis()
    };
    let engine = sheetwork::scene::IntegratorKind::TrBdf2;
    Scene { name: "soak".into(), engine, sheets: vec![sheet], dt: 1.0 / 240.0, ..Scene::default() }
}

/// A reader process, killed on drop.
struct ReaderProcess(Child);

impl ReaderProcess {
    fn start(root: &Path, reader: &str) -> Result<Self, InputError> {
        let failed = |e: std::io::Error| InputError::new("reader", e.to_string());
        let program = std::env::current_exe().map_err(failed)?;
        let mut command = Command::new(program);
        command.args(["bench", "soak", "--reader", reader]).env(ROOT_VARIABLE, root).stdout(Stdio::null());
        command.spawn().map(Self).map_err(failed)
    }

    /// Checks that the process is running.
    fn check(&mut self) -> Result<(), InputError> {
        match self.0.try_wait() {
            Ok(None) => Ok(()),
            _ => Err(InputError::new("reader", "has ended")),
        }
    }
}

impl Drop for ReaderProcess {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Reads frames until killed.
fn read_until_killed() -> Result<ExitCode, InputError> {
    let client = Client::attach_within(&LinkPlace::new(NAME)?, Duration::from_secs(10))?;
    let mut frames = client.frames(false)?;
    loop {
        match frames.wait(Duration::from_secs(1)) {
            Ok(_) | Err(LinkError::Silent) => {}
            Err(error) => return Err(error.into()),
        }
    }
}

/// Attaches, reads all streams, sets a parameter and detaches, in a loop until killed.
fn attach_and_detach() -> Result<ExitCode, InputError> {
    let place = LinkPlace::new(NAME)?;
    for visit in 0_u64.. {
        let client = Client::attach_within(&place, Duration::from_secs(10))?;
        let (mut frames, mut topology) = (client.frames(true)?, client.topology()?);
        let mut events = client.events()?;
        for _ in 0..20 {
            let frame = frames.wait(Duration::from_secs(10))?;
            topology.follow(frame.header())?;
            while events.next()?.is_some() {}
        }
        client.set("gravity", if visit.is_multiple_of(2) { "(0, -9.81, 0)" } else { "(0, -5, 0)" })?;
    }
    Ok(ExitCode::SUCCESS)
}
