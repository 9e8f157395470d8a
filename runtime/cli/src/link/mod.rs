//! Commands of the live link: selection of a game, and its clients.

pub(crate) mod grab;
pub(crate) mod haptic;
pub(crate) mod parameters;
pub(crate) mod record;
pub(crate) mod serve;
pub(crate) mod watch;

use clap::Args;
use sheetwork_link::link_place::LinkPlace;
use sheetwork_link::{Client, LinkError};
use sheetwork_rigs::quantities::time;

/// Prints to standard error the sheets that an answer lists as unstable.
fn print_unstable_sheets(answer: &serde_json::Map<String, serde_json::Value>) {
    let names = answer.get("stopped").and_then(serde_json::Value::as_array);
    for name in names.into_iter().flatten().filter_map(serde_json::Value::as_str) {
        eprintln!(
            "note: {name} is unstable and stopped: `sheetwork tell reset` starts it again, `sheetwork tell restore` goes back to a snapshot"
        );
    }
}

/// Selection of a game.
#[derive(Args)]
struct GameSelection {
    /// Name of the link; SHEETWORK_LINK, or "sheetwork", by default.
    #[arg(long, default_value = "")]
    link: String,
    /// Time limit of the wait for a game, s.
    #[arg(long, default_value = "0", value_parser = time)]
    wait: f64,
}

impl GameSelection {
    fn attach(&self) -> Result<Client, LinkError> {
        let patience = std::time::Duration::try_from_secs_f64(self.wait).unwrap_or_default();
        Client::attach_within(&LinkPlace::new(&self.link)?, patience)
    }
}
