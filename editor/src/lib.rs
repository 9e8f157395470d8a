//! The Sheetwork editor: open a scene, watch it, change it while it runs.
//!
//! `document` is the scene that is edited, with its undo; `session` holds it with the world and its clock, `timeline` and `samples` what has been of
//! a run, `keeping` what stays between runs. `panels` draws the controls with egui alone, `picture` and `headless` do without graphics hardware,
//! and `shell` is the thin Bevy layer that puts it on a screen or into an image file.

pub mod browser;
pub mod camera;
pub mod cli;
pub mod document;
pub mod export;
pub mod gap;
pub mod gizmo;
pub mod headless;
pub mod keeping;
pub mod link;
pub mod pages;
pub mod panels;
pub mod pick;
pub mod picture;
pub mod playback;
pub mod samples;
pub mod scenes;
pub mod session;
pub mod shell;
pub mod stages;
pub mod study;
pub mod templates;
pub mod tiles;
pub mod timeline;

pub use bevy_sheetwork::inspector::{hang, units};
