//! Materials: homogenisation and calibration of lattices, and the report of the stiffness a structure delivers.

pub mod law;
pub mod calibration;
pub mod elastica;
