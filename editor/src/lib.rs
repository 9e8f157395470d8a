//! The Sheetwork editor: open a scene, run it, edit it at run time.
//!
//! `document` is the edited scene with undo; `session` owns it together with the world and its
//! clock; `timeline` and `samples` record the run; `persistence` persists between runs. `panels`
//! are the controls, in egui alone; `picture` and `headless` need no graphics hardware; `shell` is
//! the Bevy layer for a window or an image file.

pub mod browser;
pub mod camera;
pub mod cli;
pub mod document;
pub mod export;
pub mod gap;
pub mod gizmo;
pub mod headless;
pub mod link;
pub mod pages;
pub mod panels;
pub mod persistence;
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
