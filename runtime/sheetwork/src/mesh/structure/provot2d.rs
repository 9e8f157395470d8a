//! Provot's cloth (Provot 1995; thesis 6.2): one layer with structural, shear and flexion springs,
//! and an optional limit on the angle between a spring and the next in line.

use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{LatticeBuilder, Structure, StructureKind};

pub(crate) const STRUCTURE: Structure = Structure {
    kind: StructureKind::Provot2d,
    name: "provot2d",
    about: "Provot's single layer: structural, shear and flexion springs",
    layers: (1, 1),
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
    builder.flexion();
}
