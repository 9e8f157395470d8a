//! Shell: one layer of nodes without springs. Its membrane and bending elements are finite
//! differences of a continuous sheet (`elements/grid_membrane`, `elements/bending`), with the
//! stiffness of the material on any grid.

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
