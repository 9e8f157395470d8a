//! SLaMM, the square-lattice mesh (thesis 4.4.2): SaMM with one diagonal per cell, in the same
//! direction in all cells.
//!
//! The single diagonal couples bending with twist, which the thesis describes as a yaw distortion.

use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{LatticeBuilder, Structure, StructureKind};

pub(crate) const STRUCTURE: Structure = Structure {
    kind: StructureKind::Slamm,
    name: "slamm",
    about: "samm with one diagonal a cell",
    layers: (1, 64),
    triangular: false,
    flexion: false,
    cross_over: true,
    connect,
};

fn connect(builder: &mut LatticeBuilder) {
    builder.planar(1, 0, SpringClass::X);
    builder.planar(0, 1, SpringClass::Z);
    builder.planar(1, 1, SpringClass::Diagonal);
    builder.inter_layer();
    builder.cross_over(&[(2, 0), (0, 2), (2, 2)]);
}
