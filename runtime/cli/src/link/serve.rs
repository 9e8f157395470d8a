//! `sheetwork serve`: runs a scene in real time, for clients to observe and control.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args;
use sheetwork::scene::{Scene, library};
use sheetwork::{InputError, World, check_range};
use sheetwork_link::link_place::LinkPlace;
use sheetwork_link::{Host, Link, LinkError};

use crate::apply_overrides;
use sheetwork_rigs::output::print_line;
use sheetwork_rigs::quantities::{parse_number, time};

/// Maximum simulated time that one pass catches up, s. After a stop of the process the scene
/// continues without a leap.
const MAXIMUM_PENDING_TIME: f64 = 0.1;
/// Interval between polls for commands, with and without a commanding client.
const POLL_INTERVALS: [Duration; 2] = [Duration::from_micros(250), Duration::from_millis(2)];

#[derive(Args)]
pub struct Serve {
    /// Scene file (RON).
    scene: PathBuf,
    /// Name of the link; SHEETWORK_LINK, or "sheetwork", by default.
    #[arg(long, default_value = "")]
    link: String,
    /// Set any field of the scene: PATH=VALUE. May be repeated.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Simulated seconds per real second.
    #[arg(long, default_value = "1", value_parser = parse_number)]
    speed: f64,
    /// Start paused.
    #[arg(long)]
    paused: bool,
    /// Duration, s of real time; unlimited by default, until Ctrl-C.
    #[arg(long, value_parser = time)]
    seconds: Option<f64>,
    /// Number of threads that step sheets, 1 by default; the result is independent of it.
    #[arg(long, default_value_t = 1)]
    threads: usize,
}

/// A world that runs in real time.
struct RealTimeWorld {
    world: World,
    threads: usize,
    playing: bool,
    /// Simulated time due but not yet stepped, s.
    pending_time: f64,
}

impl Host for RealTimeWorld {
    fn world(&self) -> &World {
        &self.world
    }

    fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    fn playing(&self) -> bool {
        self.playing
    }

    fn play(&mut self, playing: bool) -> Result<(), InputError> {
        (self.playing, self.pending_time) = (playing, 0.0);
        Ok(())
    }

    fn load(&mut self, file: &Path) -> Result<(), InputError> {
        let mut world = World::new(&Scene::load(file)?)?;
        world.set_threads(self.threads)?;
        (self.world, self.pending_time) = (world, 0.0);
        Ok(())
    }
}

/// The error of a link, with the flag that chooses another name where the name is taken.
fn with_option(error: LinkError) -> InputError {
    match error {
        LinkError::Taken(_) => InputError::new("--link", format!("{error} or the flag --link NAME")),
        other => other.into(),
    }
}

impl Serve {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        let scene = apply_overrides(Scene::load(&library::find(&self.scene))?, &self.overrides)?;
        check_range("--speed", self.speed, 1e-3, 1e3, "")?;
        check_range("--threads", self.threads as f64, 1.0, 1024.0, "")?;
        check_range("--seconds", self.seconds.unwrap_or(0.0), 0.0, 1e9, "s")?;
        let mut world = World::new(&scene)?;
        world.set_threads(self.threads)?;
        let mut game = RealTimeWorld { world, threads: self.threads, playing: !self.paused, pending_time: 0.0 };
        let place = LinkPlace::new(&self.link)?;
        let mut link = Link::new(&place, &game.world).map_err(with_option)?;
        print_line(&format!("serving {} as \"{}\"; Ctrl-C ends", scene.name, place.name()))?;
        self.run(&mut game, &mut link);
        Ok(ExitCode::SUCCESS)
    }

    fn run(&self, game: &mut RealTimeWorld, link: &mut Link) {
        let start = Instant::now();
        let mut last = start;
        loop {
            let now = Instant::now();
            if game.playing {
                game.pending_time = (game.pending_time + (now - last).as_secs_f64() * self.speed)
                    .min(MAXIMUM_PENDING_TIME.max(game.world.dt()));
            }
            last = now;
            link.exchange(game, 0.0);
            while game.playing && game.pending_time >= game.world.dt() {
                game.pending_time -= game.world.dt();
                let step = Instant::now();
                game.world.step();
                link.exchange(game, step.elapsed().as_secs_f64());
            }
            let next = if game.playing { (game.world.dt() - game.pending_time) / self.speed } else { f64::INFINITY };
            let look = POLL_INTERVALS[usize::from(!link.is_commanded())];
            let pause = Duration::try_from_secs_f64(next).unwrap_or(look).min(look);
            let over = self.seconds.is_some_and(|s| start.elapsed().as_secs_f64() >= s);
            if over || !link.sleep(pause) {
                return;
            }
        }
    }
}
