//! Commands of the live link: selection of a game, and its clients.

pub(crate) mod grab;
pub(crate) mod haptic;
pub(crate) mod parameters;
pub(crate) mod record;
pub(crate) mod serve;
pub(crate) mod watch;

use clap::Args;
use sheetwork_link::link_place::LinkPlace;
use sheetwork_link::{Client, Command, LinkError};
use sheetwork_rigs::quantities::{parse_number, time};

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

/// Material point of a sheet.
#[derive(Args)]
struct MaterialPoint {
    /// Name of the sheet.
    sheet: String,
    /// Material coordinate along the length, 0 to 1.
    #[arg(value_parser = parse_number)]
    u: f64,
    /// Material coordinate along the width, 0 to 1.
    #[arg(value_parser = parse_number)]
    v: f64,
}

impl MaterialPoint {
    /// Grabs the point with a spring (N/m); returns the number of the grab and the position, m.
    fn grab(&self, client: &Client, stiffness: f64) -> Result<(u64, [f64; 3]), LinkError> {
        let request = Command::Grab { sheet: self.sheet.clone(), u: self.u, v: self.v, stiffness };
        let taken = client.send(&request)?;
        let position = [0, 1, 2].map(|axis| taken["position"][axis].as_f64().unwrap_or_default());
        Ok((taken["grab"].as_u64().unwrap_or_default(), position))
    }
}

impl GameSelection {
    fn attach(&self) -> Result<Client, LinkError> {
        let patience = std::time::Duration::try_from_secs_f64(self.wait).unwrap_or_default();
        Client::attach_within(&LinkPlace::new(&self.link)?, patience)
    }
}
