//! TRiMM, the triangular mesh (thesis 4.4.2): rows shifted by half a cell in turn, so that every layer is triangles;
//! layers joined at the three corners of the triangle below each mass.
//!
//! With rows a factor √3/2 of the spacing apart the triangles are equilateral and the layer is isotropic.

use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{Builder, Structure, StructureKind};

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

fn connect(builder: &mut Builder) {
    builder.planar(1, 0, SpringClass::X);
    builder.slants();
    builder.inter_layer();
    // Two rows on, the stagger is back where it was and a slanting line has moved by one column.
    builder.cross_over(&[(2, 0), (1, 2), (-1, 2)]);
}
