//! Collision detection: collision surfaces, broad phase, narrow phase, continuous collision
//! detection.

pub(crate) mod bvh;
pub mod collision_surface;
pub mod constraint;
pub mod features;
pub mod geometry;
pub mod narrow_phase;
pub mod overlap;
pub(crate) mod settings;
