//! SLaMM with a second diagonal: proposed by the thesis (5.3.4) to remove the distortion of the
//! single one.

use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{LatticeBuilder, Structure, StructureKind};

pub(crate) const STRUCTURE: Structure = Structure {
    kind: StructureKind::DoubleDiagonal,
    name: "double-diagonal",
    about: "samm with both diagonals of each cell",
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
    builder.planar(-1, 1, SpringClass::AntiDiagonal);
    builder.inter_layer();
    builder.cross_over(&[(2, 0), (0, 2), (2, 2), (-2, 2)]);
}
