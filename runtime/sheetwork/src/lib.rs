//! Simulation of thin, stiff sheets in real time, without graphics, window or ECS.
//!
//! Read a [`Scene`](scene::Scene), build a [`World`], step it, read its sheets:
//!
//! ```
//! use sheetwork::{World, scene::Scene};
//!
//! let scene = Scene::parse(r#"(
//!     dt: 0.005,
//!     room: (x: (-0.1, 0.1), y: (0.0, 0.2), z: (-0.1, 0.1)),
//!     sheets: [(name: "leaf", placement: (position: (0, 0.02, 0)))],
//! )"#)?;
//! let mut world = World::new(&scene)?;
//! world.advance(2.0);
//! assert!(world.sheets()[0].centre_of_mass().y < 0.01);
//! # Ok::<(), sheetwork::InputError>(())
//! ```
//!
//! Each module imports only modules above it in this order: `math`, `mesh`, `scene`, `material`,
//! `elements`, `linear`, `integrators`, `sheet`, `rigid`, `collision`, `contact`, `thermal`,
//! `islands`, `world`. [`scene`] describes a simulation, [`sheet`] holds model and state of a
//! sheet, [`elements`] its forces, [`integrators`] advance time, [`contact`] computes contact
//! forces, [`thermal`] temperatures, [`islands`] steps sheets that may touch together, and
//! [`world`] owns all of them. Units are SI (temperatures in °C), numbers `f64`; the same input
//! gives the same bits on any number of threads.

pub mod collision;
pub mod contact;
pub mod elements;
pub(crate) mod error;
pub mod integrators;
pub mod islands;
pub mod linear;
pub mod material;
pub mod math;
pub mod mesh;
pub mod profiler;
pub mod rigid;
pub mod scene;
pub(crate) mod serialize;
pub mod sheet;
pub mod thermal;
pub mod units;
pub mod world;

pub use crate::error::{InputError, check_range};
pub use crate::world::{BodyReport, OpeningReport, Parameter, Report, SheetReport, Snapshot, TemperatureReport, World};
