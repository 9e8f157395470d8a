//! Hybrid structure of the thesis (thesis 6.2): double-diagonal layers joined as in SaMM, with
//! Provot's flexion springs in each layer. The thesis's user study preferred it.

use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{LatticeBuilder, Structure, StructureKind};

pub(crate) const STRUCTURE: Structure = Structure {
    kind: StructureKind::Provot3d,
    name: "provot3d",
    about: "double-diagonal layers with Provot's flexion springs in each",
    layers: (2, 64),
    triangular: false,
    flexion: true,
    cross_over: false,
    connect,
};

fn connect(builder: &mut LatticeBuilder) {
    builder.planar(1, 0, SpringClass::X);
    builder.planar(0, 1, SpringClass::Z);
    builder.planar(1, 1, SpringClass::Diagonal);
    builder.planar(-1, 1, SpringClass::AntiDiagonal);
    builder.inter_layer();
    builder.flexion();
}
