//! The live link between real processes: `link_role` runs in several roles and reproduces the
//! failures of games and clients. Each link has its own folder, so tests are independent.
//!
//! Longer campaigns: `SHEETWORK_LINK_KILLS` (number of kills, default 8) and `SHEETWORK_LINK_SOAK`
//! (s, default 20).

#[path = "link/place.rs"]
mod place;

#[path = "link/determinism.rs"]
mod determinism;
#[path = "link/grab.rs"]
mod grab;
#[path = "link/parameters.rs"]
mod parameters;
#[path = "link/process_failures.rs"]
mod process_failures;
#[path = "link/python.rs"]
mod python;
#[path = "link/readers.rs"]
mod readers;
#[path = "link/topology.rs"]
mod topology;
