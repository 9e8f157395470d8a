//! The shell: one layer of masses without springs. Its membrane and bending are finite differences of a continuous sheet
//! (`element/cell_membrane`, `element/bending`), so it has the sheet's own stiffness on any grid.

use crate::mesh::structure::{Structure, StructureKind};

pub(crate) const STRUCTURE: Structure = Structure {
    kind: StructureKind::Shell,
    name: "shell",
    about: "one layer with the true membrane and bending stiffness of its material",
    layers: (1, 1),
    triangular: false,
    flexion: false,
    cross_over: false,
    connect: |_| {},
};
