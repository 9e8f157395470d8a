//! Virtual test rigs and campaigns behind `sheetwork measure`, `sheetwork bench` and `sheetwork
//! study`.
//!
//! [`measure`] has one file and one table row per rig. [`mod@bench`] has the long campaigns with
//! their tables and plots. [`study`] evaluates the answers of a user study. [`drawn_surface`]
//! measures how deep drawn surfaces sink into bodies.

pub mod bench;
pub mod card_scenes;
pub mod drawn_surface;
pub mod measure;
pub mod output;
pub mod quantities;
pub mod study;
