//! Meshes of sheets: grids, lattice structures, outlines and their triangulation, cells cut by
//! slits.

pub(crate) mod grid;
pub mod outline;
pub mod slits;
pub mod spring_class;
pub mod structure;
