//! SaMM, the square mesh (thesis 4.4.2): springs along x and z, layers joined at the four corners
//! of each cell.
//!
//! No spring resists shear or twist within a layer: a strip bends, a plate folds along its
//! diagonals.

use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{LatticeBuilder, Structure, StructureKind};

pub(crate) const STRUCTURE: Structure = Structure {
    kind: StructureKind::Samm,
    name: "samm",
    about: "square mesh, layers joined by four springs a mass",
    layers: (1, 64),
    triangular: false,
    flexion: false,
    cross_over: false,
    connect,
};

fn connect(builder: &mut LatticeBuilder) {
    builder.planar(1, 0, SpringClass::X);
    builder.planar(0, 1, SpringClass::Z);
    builder.inter_layer();
}
