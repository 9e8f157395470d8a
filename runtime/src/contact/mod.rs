//! What a sheet touches: Rapier's rigid bodies, other sheets, itself.
//!
//! `skin` and `features` are the surfaces, `find` says which of their parts may touch, as rows (`row`). Of implicit engines `stage`
//! puts apart what would overlap and solves for velocities, by `primal`: on the forces of few contacts (`on_forces`, with the operator
//! of `delassus`) or on the displacements of masses and bodies (`on_masses`), and where that does not settle by `at_once`. Where masses answer
//! each for itself, sweeps do (`dual`).
//! `places` says where the sides of a contact are; `coulomb` is friction at one. Contact knows of a sheet its positions, velocities, masses and how its tangent answers a
//! force, and no springs.
//!
//! Masses of explicit engines meet bodies that do not give way each for itself (`detect`, `response`; thesis 4.6 and appendix B), with who
//! lies above whom (`through_thickness`); the rest of theirs are rows too.
//!
//! What is hot and sticky is held on by forces that the solvers do not know from the scene's own (`stick`).
//!
//! Rapier works in `f32` in each body's own frame; positions are taken there in `f64` first, so that a body far from the
//! origin costs no accuracy. A surface without thickness is kept [`SKIN`] outside another, above what `f32` resolves.

mod at_once;
mod clearance;
pub mod coulomb;
mod delassus;
pub mod detect;
mod direct;
mod dual;
pub mod features;
pub mod find;
pub(crate) mod found;
pub mod frame;
pub mod geometry;
mod glue;
mod memory;
pub(crate) mod mover;
mod on_forces;
mod on_masses;
pub mod penetration;
mod pick;
pub(crate) mod places;
mod primal;
pub mod response;
pub mod rigid;
pub(crate) mod rounds;
pub mod row;
pub(crate) mod settled;
pub mod skin;
pub(crate) mod stage;
pub(crate) mod stick;
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
