//! One measured configuration of the run-time-against-error benchmark, and its files: CSV of this
//! library, JSON lines of peers.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use sheetwork::InputError;

use crate::bench::reference::References;
use crate::bench::verdict::compare_with_targets;

/// A configuration with its cost and its error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParetoPoint {
    /// Rig, as named by `sheetwork measure`.
    pub case: String,
    /// Structure, or name of the peer.
    pub structure: String,
    /// Time integrator, or settings of the peer.
    pub engine: String,
    /// Nodes along length and width, as in `21x21`.
    pub grid: String,
    /// Step, s.
    pub dt_s: f64,
    /// Requested Poisson's ratio.
    pub poisson: f64,
    /// CPU time of the steps per second of simulated time, ms.
    pub cpu_ms_per_simulated_s: f64,
    /// Deviation from the reference as a fraction of it; none without a result.
    pub error: Option<f64>,
    /// Measured quantity: the key in the rig's JSON.
    pub quantity: String,
    /// Measured value, in the unit at the end of the quantity's name.
    pub measured: Option<f64>,
    /// Reference value.
    pub reference: Option<f64>,
    /// Whether the sheet came to rest, for a rig that waits for rest.
    pub settled: Option<bool>,
    /// "ok", or the reason of a failure.
    pub status: String,
    /// Whether the point belongs to a peer.
    pub peer: bool,
}

impl ParetoPoint {
    /// Whether `other` is the same configuration, irrespective of results.
    pub fn is_same_configuration(&self, other: &Self) -> bool {
        let key = |p: &Self| (p.peer, p.dt_s.to_bits(), p.poisson.to_bits());
        let names = |p: &Self| [p.case.clone(), p.structure.clone(), p.engine.clone(), p.grid.clone()];
        key(self) == key(other) && names(self) == names(other)
    }

    /// Whether the point may be on the Pareto front: a successful run that came to rest where
    /// required, with an error below 100 %.
    pub fn is_valid(&self) -> bool {
        self.status == "ok" && self.settled != Some(false) && self.error.is_some_and(|e| e < 1.0)
    }

    /// Nodes along the length.
    pub fn side(&self) -> &str {
        self.grid.split('x').next().unwrap_or(&self.grid)
    }
}

/// Reads points from a CSV file.
///
/// # Errors
/// An unreadable file, or a line that is not a point.
pub fn read_csv(path: &Path) -> Result<Vec<ParetoPoint>, InputError> {
    let failed = |e: csv::Error| InputError::new("", e.to_string()).in_file(path);
    let mut reader = csv::Reader::from_path(path).map_err(failed)?;
    reader.deserialize().map(|row| row.map_err(failed)).collect()
}

/// Reads the JSON lines of `tests/peers/run.sh`. Peers use Poisson's ratio 0 and the same
/// references.
///
/// # Errors
/// An unreadable file, or a line with missing values.
pub fn read_peers(path: &Path, references: &mut References) -> Result<Vec<ParetoPoint>, InputError> {
    let text = std::fs::read_to_string(path).map_err(|e| InputError::io(path, &e))?;
    let mut points = Vec::new();
    for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let wrong = |problem: String| InputError::new("", problem).in_file(path).at_line(number + 1);
        let found: Value = serde_json::from_str(line).map_err(|e| wrong(e.to_string()))?;
        points.push(peer(&found, references).ok_or_else(|| {
            let needed = "peer, version, label, case, grid, dt_s and cpu_ms_per_simulated_s";
            wrong(format!("a peer's line has {needed}, and a case that is judged"))
        })?);
    }
    Ok(points)
}

fn peer(found: &Value, references: &mut References) -> Option<ParetoPoint> {
    let text = |key: &str| found[key].as_str();
    let (case, side) = (text("case")?, found["grid"].as_u64()?);
    let verdict = compare_with_targets(case, found, &references.get(case, 0.0).ok()?);
    Some(ParetoPoint {
        case: case.into(),
        structure: format!("{} {}", text("peer")?, text("version")?),
        engine: text("label")?.into(),
        grid: format!("{side}x{side}"),
        dt_s: found["dt_s"].as_f64()?,
        poisson: 0.0,
        cpu_ms_per_simulated_s: found["cpu_ms_per_simulated_s"].as_f64()?,
        error: verdict.error,
        quantity: verdict.quantity.into(),
        measured: verdict.measured,
        reference: verdict.reference,
        settled: found["settled"].as_bool(),
        status: "ok".into(),
        peer: true,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::write_csv;

    #[test]
    fn points_survive_a_round_trip() {
        let mut point = crate::bench::front::tests::point(12.5, 0.003);
        point.engine = "implicit, its \"own\"".into();
        let mut unstable = point.clone();
        (unstable.error, unstable.measured, unstable.settled) = (None, None, Some(false));
        let path = std::env::temp_dir().join(format!("sheetwork-points-{}.csv", std::process::id()));
        write_csv(&path, &[point.clone(), unstable.clone()]).expect("the file is written");
        let read = read_csv(&path);
        std::fs::remove_file(&path).expect("the file is removed");
        assert_eq!(read.expect("the file is read"), [point, unstable]);
    }

    #[test]
    fn the_error_of_a_peer_is_relative_to_the_elastica() {
        let line = r#"{"peer": "P", "version": "1", "label": "l", "case": "cantilever", "grid": 11, "dt_s": 0.01,
            "cpu_ms_per_simulated_s": 30, "drop_m": 0.0821, "settled": true}"#;
        let found = serde_json::from_str(line).expect("it is JSON");
        let point = peer(&found, &mut References::new(true)).expect("it has all that is needed");
        // Γ = 12 ρ g L³ / (E t²) = 2.575: the tip of the elastica drops by 0.298561 of its length.
        assert!((point.error.expect("it has an error") - (0.0821 / 0.0746403 - 1.0)).abs() < 1e-5);
        assert_eq!((point.structure.as_str(), point.grid.as_str()), ("P 1", "11x11"));
    }
}
