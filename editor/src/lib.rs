//! The Sheetwork editor: open a scene, watch it, change it while it runs.
//!
//! `session` holds the world and its clock, `panels` draws the controls with egui alone, `picture` and `headless` do without
//! graphics hardware, and `shell` is the thin Bevy layer that puts it on a screen or into an image file.

pub mod camera;
pub mod cli;
pub mod headless;
pub mod link;
pub mod panels;
pub mod picture;
pub mod playback;
pub mod scenes;
pub mod session;
pub mod shell;
