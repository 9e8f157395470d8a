//! Asset with the polyhedra of a body.

use bevy::prelude::*;
use sheetwork::scene::Polyhedron;

/// Polyhedra of a `.pol` file.
#[derive(Asset, TypePath, Clone, Debug, Default, PartialEq)]
pub struct SheetPolyhedra {
    /// Closed polyhedra, m.
    pub polyhedra: Vec<Polyhedron>,
}
