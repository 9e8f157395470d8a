//! Materials: homogenisation and calibration of lattices, loss factors, and the report of the
//! stiffness that a structure delivers.

pub mod calibration;
pub mod elastica;
pub mod law;
pub mod loss_factor;
