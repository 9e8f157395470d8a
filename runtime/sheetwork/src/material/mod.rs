//! Materials: homogenisation and calibration of lattices, and the report of the stiffness that a
//! structure delivers.

pub mod calibration;
pub mod elastica;
pub mod law;
