//! `sheetwork bench hashes`: a hash of the final state of every scene, to compare builds, threads
//! and machines bit for bit.

use std::path::PathBuf;
use std::process::{Command, ExitCode};

use clap::Args;
use sheetwork::scene::Scene;
use sheetwork::{InputError, World, check_range};

use crate::bench::shard;
use crate::output::print_line;

/// Number of digits of a hash.
const DIGITS: usize = 16;

#[derive(Args)]
pub struct Hashes {
    /// Scenes by name; all of the folder by default.
    scenes: Vec<String>,
    /// Folder of the scenes.
    #[arg(long, default_value = "assets/scenes")]
    folder: PathBuf,
    /// Steps of each scene.
    #[arg(long, default_value_t = 60)]
    steps: u32,
    /// Threads to step sheets on.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Run only every N-th scene from the I-th on, 1 to N.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,
    /// Another build of `sheetwork`, which computes the same hashes; differences are listed.
    #[arg(long, value_name = "PROGRAM")]
    against: Option<PathBuf>,
    /// Threads of the other build, if different.
    #[arg(long, requires = "against")]
    their_threads: Option<usize>,
}

impl Hashes {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--steps", f64::from(self.steps), 1.0, 1e9, "")?;
        for threads in std::iter::once(self.threads).chain(self.their_threads) {
            check_range("--threads", threads as f64, 1.0, 1024.0, "")?;
        }
        let names =
            if self.scenes.is_empty() { crate::bench::rollback::scenes_of(&self.folder)? } else { self.scenes.clone() };
        let (which, of) = self.shard.unwrap_or((1, 1));
        let mut differs = 0;
        for name in names.iter().skip(which - 1).step_by(of) {
            let line = format!("{name} {:0DIGITS$x}", self.hash(name)?);
            match &self.against {
                None => print_line(&line)?,
                Some(other) => {
                    let theirs = self.asked(other, name)?;
                    let same = theirs == line;
                    differs += usize::from(!same);
                    print_line(&format!("{line}  {}", if same { "same".into() } else { format!("there {theirs}") }))?;
                }
            }
        }
        Ok(if differs == 0 { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    fn hash(&self, name: &str) -> Result<u64, InputError> {
        let mut world = World::new(&Scene::load(&self.folder.join(format!("{name}.ron")))?)?;
        world.set_threads(self.threads)?;
        (0..self.steps).for_each(|_| _ = world.step());
        Ok(world.state_hash())
    }

    /// Hash of a scene from another build.
    fn asked(&self, program: &PathBuf, name: &str) -> Result<String, InputError> {
        let threads = self.their_threads.unwrap_or(self.threads);
        let output = Command::new(program)
            .args(["bench", "hashes", name, "--steps", &self.steps.to_string(), "--threads", &threads.to_string()])
            .arg("--folder")
            .arg(&self.folder)
            .output()
            .map_err(|e| InputError::io(program, &e))?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let said = said.trim().lines().next().unwrap_or_default();
            return Err(InputError::new("--against", format!("{} does not answer: {said}", program.display())));
        }
        let theirs = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        // Rejects the output of a program other than `sheetwork`.
        if is_hash_of(&theirs, name) {
            Ok(theirs)
        } else {
            Err(InputError::new("--against", format!("{} gave no hashes", program.display())))
        }
    }
}

/// Whether a line is this program's output for the scene `name`.
fn is_hash_of(line: &str, name: &str) -> bool {
    let hash = line.strip_prefix(name).and_then(|rest| rest.strip_prefix(' ')).unwrap_or_default();
    hash.len() == DIGITS && hash.bytes().all(|b| b.is_ascii_hexdigit())
}
