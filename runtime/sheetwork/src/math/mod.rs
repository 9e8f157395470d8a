//! Vectors as structures of arrays, rigid frames, roots of cubics, SIMD lanes.

pub(crate) mod cubic;
#[cfg(test)]
pub(crate) mod drawn;
pub(crate) mod frame;
pub mod lanes;
pub(crate) mod vectors;

pub use frame::RigidFrame;
pub use vectors::Vectors;
