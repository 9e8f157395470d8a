//! The live link between real processes: `link_role` runs in several roles and reproduces the
//! failures of games and clients. Each link has its own folder, so tests are independent.
//!
//! Longer campaigns: `SHEETWORK_LINK_KILLS` (number of kills, default 8) and `SHEETWORK_LINK_SOAK`
//! (s, default 20).

#[path = "link/place.rs"]
mod place;

#[path = "link/knobs.rs"]
mod knobs;
#[path = "link/pull.rs"]
mod pull;
#[path = "link/python.rs"]
mod python;
#[path = "link/reading.rs"]
mod reading;
#[path = "link/same.rs"]
mod same;
#[path = "link/survival.rs"]
mod survival;
#[path = "link/topology.rs"]
mod topology;
