//! What a sheet touches: Rapier's rigid bodies, found by Rapier's broad phase and Parry's distance and ray queries.
//!
//! The sheet side is its masses, as points (thesis 4.6): a mass that has passed a face is put back on it, its normal
//! velocity is reversed by the restitution, and its tangential velocity is slowed by Coulomb friction (thesis appendix B).
//! Contact sees positions, velocities and masses, and no springs except for who lies above whom (`through_thickness`).
//!
//! Rapier works in `f32` in each body's own frame; positions are taken there in `f64` first, so that a body far from the
//! origin costs no accuracy. Masses are kept [`SKIN`] outside a surface, above what `f32` resolves.

mod clearance;
pub mod coulomb;
mod delassus;
pub mod detect;
mod direct;
mod dual;
pub mod features;
pub mod find;
pub mod frame;
pub mod geometry;
mod memory;
pub(crate) mod mover;
pub mod penetration;
mod primal;
pub mod response;
pub mod rigid;
pub mod row;
pub mod skin;
pub(crate) mod stage;
pub(crate) mod surroundings;
pub mod sweeps;
pub(crate) mod target;
pub mod through_thickness;

pub(crate) use clearance::Clearance;
pub(crate) use delassus::{Group, Unit};
pub use stage::ContactCounters;

/// Distance at which a mass lies on a surface, m.
pub const SKIN: f64 = 1e-5;

/// Approach speed below which restitution is not applied, m/s: a resting mass falls by g·dt into the surface each step and
/// must not bounce off it for ever.
pub const REST_SPEED: f64 = 0.01;
