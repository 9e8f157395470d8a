//! Contact of single nodes with kinematic and static bodies, for explicit integrators.

pub(crate) mod clearance;
pub mod detection;
pub mod response;
pub(crate) mod target;
pub mod through_thickness;
