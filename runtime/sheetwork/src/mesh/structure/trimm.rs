//! TRiMM, the triangular mesh (thesis 4.4.2): every other row is shifted by half a cell, so that
//! layers consist of triangles; layers are joined at the three corners of the triangle below each
//! node.
//!
//! With rows at √3/2 of the spacing the triangles are equilateral and the layer is isotropic.

use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{LatticeBuilder, Structure, StructureKind};

pub(crate) const STRUCTURE: Structure = Structure {
    kind: StructureKind::Trimm,
    name: "trimm",
    about: "triangular mesh, layers joined by three springs a mass",
    layers: (1, 64),
    triangular: true,
    flexion: false,
    cross_over: true,
    connect,
};

fn connect(builder: &mut LatticeBuilder) {
    builder.planar(1, 0, SpringClass::X);
    builder.slants();
    builder.inter_layer();
    // Two rows further the shift repeats, and a slanting line has moved by one column.
    builder.cross_over(&[(2, 0), (1, 2), (-1, 2)]);
}
