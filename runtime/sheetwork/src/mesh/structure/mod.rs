//! Structures: nodes of a sheet, their rest positions, and the springs between them.
//!
//! Layers alternate (thesis 4.4.2): the bottom one has nx·nz nodes, the next (nx-1)·(nz-1), each
//! above the middle of a cell of the one below, the third nx·nz again. Local axes: x along the
//! length, z along the width, y through the thickness; the origin is the middle of the bottom
//! layer. Nodes are numbered layer by layer, row by row (z), along x.
//!
//! Each structure is one [`Structure`] in [`TABLE`]; menus, the command line, the conformance tests
//! and the file formats read that table.

mod table;

use glam::DVec3;
use serde::{Deserialize, Serialize};

pub use crate::mesh::grid::{LatticeBuilder, LatticeLayer};
pub use crate::mesh::structure::table::TABLE;

use crate::error::{InputError, named_in_table, reject_if};
use crate::mesh::spring_class::SpringClass;
use crate::units::parameters::ParameterId as Id;

/// Structures by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum StructureKind {
    /// Square mesh, layers joined by four springs per node.
    Samm,
    /// SaMM with one diagonal per cell.
    Slamm,
    /// SLaMM with both diagonals.
    DoubleDiagonal,
    /// Triangular mesh, layers joined by three springs per node.
    Trimm,
    /// Provot's single layer: structural, shear and flexion springs.
    Provot2d,
    /// Two (or more) double-diagonal layers with flexion springs in each.
    Provot3d,
    /// Two (or more) triangular layers with flexion springs in each.
    ProvotTrimm,
    /// Shell: one layer with the stiffness of its material, without springs.
    Shell,
}

/// Row of the table of structures.
pub struct Structure {
    /// Kind of the structure.
    pub kind: StructureKind,
    /// Name in files and on the command line.
    pub name: &'static str,
    /// Description in one line.
    pub about: &'static str,
    /// Minimum and maximum number of layers.
    pub layers: (u32, u32),
    /// Whether every other row is shifted by half a cell.
    pub triangular: bool,
    /// Whether the structure has flexion triples, for an angle limit.
    pub flexion: bool,
    /// Whether the structure supports cross-over springs.
    pub cross_over: bool,
    /// Add the springs to a builder with nodes.
    pub(crate) connect: fn(&mut LatticeBuilder),
}

impl StructureKind {
    /// Row of the structure in the table.
    pub fn info(self) -> &'static Structure {
        // Every kind has a row: `every_kind_is_in_the_table` below.
        TABLE.iter().find(|s| s.kind == self).unwrap_or(&TABLE[0])
    }
}

named_in_table!(StructureKind, TABLE, "structure");

/// Specification of a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeSpec {
    /// Structure.
    pub structure: StructureKind,
    /// Nodes along the length, layers, nodes along the width.
    pub grid: (u32, u32, u32),
    /// Length (x) and width (z) of the bottom layer, m. The length of a triangular layer includes
    /// the half cell by which every other row is shifted.
    pub size: (f64, f64),
    /// Distance between layers, m.
    pub gap: f64,
    /// Whether cross-over springs join second neighbours along every spring line of a layer.
    pub cross_over: bool,
}

impl LatticeSpec {
    /// Distance of neighbours along x, and of rows along z, m.
    pub fn spacing(&self) -> (f64, f64) {
        let half = if self.structure.info().triangular { 0.5 } else { 0.0 };
        let (nx, _, nz) = self.grid;
        (self.size.0 / (f64::from(nx.max(2) - 1) + half), self.size.1 / f64::from(nz.max(2) - 1))
    }
}

/// Spring of a lattice, without its stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeSpring {
    /// First node.
    pub a: u32,
    /// Second node.
    pub b: u32,
    /// Spring class.
    pub class: SpringClass,
    /// Layer of the lower end.
    pub layer: u32,
}

/// Lattice at rest: geometry and connections, without material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lattice {
    /// Rest positions, m, local axes.
    pub positions: Vec<DVec3>,
    /// Layer of each node, 0 the bottom.
    pub layer_of: Vec<u32>,
    /// Whether each node is on the outline of its layer.
    pub border: Vec<bool>,
    /// Springs, ordered so that neighbours in the list join neighbours in the grid.
    pub links: Vec<LatticeSpring>,
    /// Triples (a, b, c) in a row, b the middle one, for the flexion angle limit.
    pub flexion: Vec<[u32; 3]>,
    /// Layers from the bottom up.
    pub layers: Vec<LatticeLayer>,
}

/// Maximum number of nodes of a lattice.
pub const MAX_NODES: u64 = 10_000_000;

/// Generate a lattice.
///
/// # Errors
/// When the grid or the size is out of range, or the structure does not support the number of
/// layers.
pub fn generate(spec: &LatticeSpec) -> Result<Lattice, InputError> {
    check(spec)?;
    Ok(assemble(spec))
}

/// Nodes of a lattice without springs.
///
/// # Errors
/// As [`generate`].
pub(crate) fn lay_out(spec: &LatticeSpec) -> Result<Lattice, InputError> {
    check(spec)?;
    Ok(LatticeBuilder::new(spec).finish())
}

/// Number of nodes of a lattice of this grid.
pub(crate) fn nodes_of((nx, layers, nz): (u32, u32, u32)) -> u64 {
    let layer = |index: u32| {
        let less = u64::from(index % 2);
        (u64::from(nx) - less) * (u64::from(nz) - less)
    };
    (0..layers).map(layer).sum()
}

/// Nodes and springs of a specification that has been checked.
pub(crate) fn assemble(spec: &LatticeSpec) -> Lattice {
    let mut builder = LatticeBuilder::new(spec);
    (spec.structure.info().connect)(&mut builder);
    builder.finish()
}

fn check(spec: &LatticeSpec) -> Result<(), InputError> {
    let (nx, layers, nz) = spec.grid;
    let info = spec.structure.info();
    Id::GridLength.check("grid.0", nx.into())?;
    Id::GridWidth.check("grid.2", nz.into())?;
    let (name, (fewest, most)) = (info.name, info.layers);
    let fits = (fewest..=most).contains(&layers);
    reject_if!(!fits, "grid.1", "{layers} layers, but {name} has {fewest} to {most}");
    let masses = u64::from(nx) * u64::from(nz) * u64::from(layers);
    reject_if!(masses > MAX_NODES, "grid", "about {masses} masses, more than {MAX_NODES}");
    Id::Size.check_each("size", [spec.size.0, spec.size.1])?;
    Id::Gap.check("gap", spec.gap)?;
    reject_if!(spec.cross_over && !info.cross_over, "cross_over", "{} has no cross-over springs", info.name);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(structure: StructureKind, grid: (u32, u32, u32)) -> (usize, usize) {
        let spec = LatticeSpec { structure, grid, size: (0.025, 0.025), gap: 0.001, cross_over: false };
        let lattice = generate(&spec).expect("valid");
        (lattice.positions.len(), lattice.links.len())
    }

    #[test]
    fn every_kind_is_in_the_table() {
        for row in TABLE {
            assert_eq!(row.kind.name(), row.name);
            assert_eq!(row.name.parse::<StructureKind>(), Ok(row.kind));
        }
    }

    #[test]
    fn counts_are_those_of_the_thesis() {
        use StructureKind::{Samm, Slamm, Trimm};
        assert_eq!(counts(Samm, (5, 3, 4)), (52, 175));
        assert_eq!(counts(Samm, (11, 2, 11)), (221, 800));
        assert_eq!(counts(Slamm, (11, 2, 11)), (221, 981));
        assert_eq!(counts(Trimm, (8, 2, 8)), (113, 428));
        assert_eq!(counts(Trimm, (11, 2, 11)), (221, 881));
        assert_eq!(counts(Trimm, (14, 2, 14)), (365, 1496));
        assert_eq!(counts(Trimm, (17, 2, 17)), (545, 2273));
    }

    #[test]
    fn counts_of_the_other_structures_follow_from_their_construction() {
        use StructureKind::{DoubleDiagonal, Provot2d, Provot3d, ProvotTrimm};
        // 981 of SLaMM and a second diagonal for each of 100 + 81 cells.
        assert_eq!(counts(DoubleDiagonal, (11, 2, 11)), (221, 981 + 181));
        // 220 structural, 200 shear, 2 x 9 x 11 flexion.
        assert_eq!(counts(Provot2d, (11, 1, 11)), (121, 220 + 200 + 198));
        // Double diagonal, and flexion in layers of 11x11 and 10x10.
        assert_eq!(counts(Provot3d, (11, 2, 11)), (221, 1162 + 198 + 160));
        // 881 of TRiMM. Flexion in a layer of n x n: n (n - 2) along x, and (n - 1)(n - 2) along
        // each slanting line, which moves by one column in two rows: 99 + 90 + 90, 80 + 72 + 72.
        assert_eq!(counts(ProvotTrimm, (11, 2, 11)), (221, 881 + 279 + 224));
        // A third layer: 121 nodes, 320 springs and 279 for flexion, and 3 to each of 100 nodes.
        assert_eq!(counts(ProvotTrimm, (11, 3, 11)), (342, 1384 + 320 + 279 + 300));
    }

    #[test]
    fn flexion_triples_are_straight_and_have_a_spring_each() {
        for row in TABLE.iter().filter(|row| row.flexion) {
            let grid = (8, row.layers.1.min(3), 7);
            let spec = LatticeSpec { structure: row.kind, grid, size: (0.3, 0.2), gap: 0.01, cross_over: false };
            let lattice = generate(&spec).expect("valid");
            let place = |i: u32| lattice.positions[i as usize];
            for [a, b, c] in &lattice.flexion {
                assert!(((place(*a) + place(*c)) * 0.5).distance(place(*b)) < 1e-12, "{}: {a} {b} {c}", row.name);
            }
            let ends = |class: SpringClass| lattice.links.iter().filter(move |l| l.class == class).map(|l| (l.a, l.b));
            let mut springs: Vec<_> = ends(SpringClass::Flexion).collect();
            let mut triples: Vec<_> = lattice.flexion.iter().map(|[a, _, c]| (*a, *c)).collect();
            springs.sort_unstable();
            triples.sort_unstable();
            assert_eq!(springs, triples, "{}", row.name);
        }
    }

    #[test]
    fn every_layer_of_every_structure_fills_the_asked_size() {
        for row in TABLE {
            let grid = (7, row.layers.0.max(1), 6);
            let spec = LatticeSpec { structure: row.kind, grid, size: (0.3, 0.2), gap: 0.01, cross_over: false };
            let lattice = generate(&spec).expect("valid");
            let low = lattice.positions.iter().copied().reduce(DVec3::min).expect("masses");
            let high = lattice.positions.iter().copied().reduce(DVec3::max).expect("masses");
            assert!((high.x - low.x - 0.3).abs() < 1e-12, "{}", row.name);
            assert!((high.z - low.z - 0.2).abs() < 1e-12, "{}", row.name);
            assert!((high.x + low.x).abs() < 1e-12 && (high.z + low.z).abs() < 1e-12, "{}: not centred", row.name);
        }
    }

    #[test]
    fn springs_are_unique_and_join_different_nodes() {
        for row in TABLE {
            for cross_over in [false, row.cross_over] {
                let spec = LatticeSpec {
                    structure: row.kind,
                    grid: (6, row.layers.1.min(3), 7),
                    size: (0.1, 0.1),
                    gap: 0.01,
                    cross_over,
                };
                let lattice = generate(&spec).expect("valid");
                let mut ends: Vec<_> = lattice.links.iter().map(|l| (l.a.min(l.b), l.a.max(l.b))).collect();
                assert!(ends.iter().all(|(a, b)| a < b && (*b as usize) < lattice.positions.len()));
                ends.sort_unstable();
                ends.dedup();
                assert_eq!(ends.len(), lattice.links.len(), "{} has a doubled spring", row.name);
            }
        }
    }

    #[test]
    fn cross_over_springs_are_straight_and_second_neighbours() {
        let spec = LatticeSpec {
            structure: StructureKind::Trimm,
            grid: (9, 1, 9),
            size: (0.1, 0.1),
            gap: 0.01,
            cross_over: true,
        };
        let lattice = generate(&spec).expect("valid");
        let cross: Vec<_> = lattice.links.iter().filter(|l| l.class == SpringClass::CrossOver).collect();
        assert!(!cross.is_empty());
        for link in cross {
            let middle = (lattice.positions[link.a as usize] + lattice.positions[link.b as usize]) * 0.5;
            let nearest = lattice.positions.iter().map(|p| p.distance(middle)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-12, "a cross-over spring jumps over no mass");
        }
    }

    #[test]
    fn bad_grids_are_refused_with_the_range() {
        let spec = LatticeSpec {
            structure: StructureKind::Provot2d,
            grid: (5, 2, 5),
            size: (0.1, 0.1),
            gap: 0.01,
            cross_over: false,
        };
        let error = generate(&spec).expect_err("two layers");
        assert!(error.problem.contains("1 to 1"), "{error}");
        let error = generate(&LatticeSpec { grid: (1, 1, 5), ..spec }).expect_err("one mass");
        assert_eq!(error.field, "grid.0");
    }
}
