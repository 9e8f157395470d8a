//! The live link between real processes: `link_role` is started in several roles, and these do to it what happens to
//! games and their watchers. Where each link has its files in a folder of its own, tests do not meet.
//!
//! The long campaigns are the same tests with `SHEETWORK_LINK_KILLS` (how often to kill, 8 otherwise) and
//! `SHEETWORK_LINK_SOAK` (s, 20 otherwise).

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
