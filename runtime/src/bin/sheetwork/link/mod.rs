//! The live link on the command line: a game to attach to, and what attaches.

mod grab;
mod knobs;
mod record;
mod serve;
mod watch;

use crate::quantities::time;
use clap::Args;
use sheetwork::link::{Client, LinkError, LinkPlace};

pub use grab::Grab;
pub use knobs::{Get, Parameters, Set, Tell};
pub use record::Record;
pub use serve::Serve;
pub use watch::Watch;

/// Tells, on standard error, of sheets that an answer says are stopped.
fn tell_of_stopped(answer: &serde_json::Map<String, serde_json::Value>) {
    let names = answer.get("stopped").and_then(serde_json::Value::as_array);
    for name in names.into_iter().flatten().filter_map(serde_json::Value::as_str) {
        eprintln!(
            "note: {name} went unstable and stands still: `sheetwork tell reset` starts it again, `sheetwork tell restore` goes back to a snapshot"
        );
    }
}

/// Which game is meant.
#[derive(Args)]
struct Target {
    /// Name of the link; SHEETWORK_LINK, or "sheetwork", if left out.
    #[arg(long, default_value = "")]
    link: String,
    /// Wait up to so long for a game to be there, s.
    #[arg(long, default_value = "0", value_parser = time)]
    wait: f64,
}

impl Target {
    fn attach(&self) -> Result<Client, LinkError> {
        let patience = std::time::Duration::try_from_secs_f64(self.wait).unwrap_or_default();
        Client::attach_within(&LinkPlace::new(&self.link)?, patience)
    }
}
