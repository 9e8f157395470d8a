//! One period of a lattice, extracted from the middle of a generated one, so that a structure needs
//! no second description.
//!
//! A cell is periodic along x, along z, or both. In the other direction it extends from free edge
//! to free edge. Its bonds join representatives of nodes; their ends are given as positions, m, so
//! that a bond may leave the cell.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{Lattice, LatticeSpec, StructureKind, assemble};

/// Place of a node in the grid of its layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct LatticeSite {
    /// Layer, 0 the bottom.
    pub layer: u32,
    /// Column (along x).
    pub i: i64,
    /// Row (along z).
    pub j: i64,
}

/// Sites of all nodes of a lattice, in order.
pub(crate) fn sites(lattice: &Lattice) -> Vec<LatticeSite> {
    let mut found = Vec::with_capacity(lattice.positions.len());
    for (index, layer) in lattice.layers.iter().enumerate() {
        for j in 0..layer.nz {
            found.extend((0..layer.nx).map(|i| LatticeSite { layer: index as u32, i: i64::from(i), j: i64::from(j) }));
        }
    }
    found
}

/// Spring of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellSpring {
    /// Representative of the first node.
    pub a: usize,
    /// Representative of the second node.
    pub b: usize,
    /// Position of the first node, m; heights from the middle of the sheet.
    pub from: DVec3,
    /// Position of the second node, m.
    pub to: DVec3,
    /// Site of the first node.
    pub site_a: LatticeSite,
    /// Site of the second node.
    pub site_b: LatticeSite,
    /// Spring class.
    pub class: SpringClass,
    /// Layer of the lower end.
    pub layer: u32,
}

impl CellSpring {
    /// Unit vector from a to b.
    pub fn direction(&self) -> DVec3 {
        (self.to - self.from).normalize_or_zero()
    }

    /// Middle between its ends, m.
    pub fn middle(&self) -> DVec3 {
        0.5 * (self.from + self.to)
    }
}

/// One period of a lattice.
#[derive(Clone, Debug)]
pub(crate) struct PeriodicCell {
    /// Number of nodes.
    pub masses: usize,
    /// Springs; each is in one cell only.
    pub springs: Vec<CellSpring>,
    /// Length along x and along z, m: of the period, or from edge to edge.
    pub extent: (f64, f64),
    /// Nodes along x and z in each layer of the original lattice.
    pub grid: Vec<(i64, i64)>,
}

/// Lattice from which a cell is extracted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LatticePattern {
    /// Structure.
    pub structure: StructureKind,
    /// Number of layers.
    pub layers: u32,
    /// Distance of neighbours along x, and of rows along z, m.
    pub spacing: (f64, f64),
    /// Distance between layers, m.
    pub gap: f64,
    /// Whether cross-over springs join second neighbours.
    pub cross_over: bool,
}

/// Number of columns or rows in a periodic direction: no spring of the middle reaches an edge.
const PERIODIC_LENGTH: u32 = 10;

impl LatticePattern {
    /// Cell that is periodic both ways: a sheet without edges.
    pub fn periodic(&self) -> PeriodicCell {
        self.cut(None, None)
    }

    /// Strip along x, `cells` wide, between free edges back and front.
    pub fn strip_along_x(&self, cells: u32) -> PeriodicCell {
        self.cut(None, Some(cells))
    }

    /// Strip along z, `cells` wide, between free edges left and right.
    pub fn strip_along_z(&self, cells: u32) -> PeriodicCell {
        self.cut(Some(cells), None)
    }

    /// Height of the middle of the sheet over the bottom layer, m.
    fn middle(&self) -> f64 {
        0.5 * self.gap * f64::from(self.layers - 1)
    }

    /// Lattice of this pattern with `columns` by `rows` nodes in its bottom layer.
    fn lattice(&self, columns: u32, rows: u32) -> (Lattice, (f64, f64)) {
        let half = if self.structure.info().triangular { 0.5 } else { 0.0 };
        let size = ((f64::from(columns - 1) + half) * self.spacing.0, f64::from(rows - 1) * self.spacing.1);
        let lattice = assemble(&LatticeSpec {
            structure: self.structure,
            grid: (columns, self.layers, rows),
            size,
            gap: self.gap,
            cross_over: self.cross_over,
        });
        (lattice, size)
    }

    /// Extract a cell; the arguments are widths in cells in directions without period.
    fn cut(&self, along_x: Option<u32>, along_z: Option<u32>) -> PeriodicCell {
        let (lattice, size) =
            self.lattice(along_x.map_or(PERIODIC_LENGTH, |c| c + 1), along_z.map_or(PERIODIC_LENGTH, |c| c + 1));
        // Every other row of a triangular layer is shifted: two make a period.
        let rows = if self.structure.info().triangular { 2 } else { 1 };
        let window_x = PeriodWindow { first: 4, count: 1, repeats: along_x.is_none() };
        let window_z = PeriodWindow { first: 4, count: rows, repeats: along_z.is_none() };
        let sites = sites(&lattice);
        let home = |s: &LatticeSite| LatticeSite { layer: s.layer, i: window_x.home(s.i), j: window_z.home(s.j) };
        let inside = |s: &LatticeSite| home(s) == *s;
        let homes: BTreeMap<LatticeSite, usize> =
            sites.iter().filter(|s| inside(s)).enumerate().map(|(n, s)| (*s, n)).collect();
        let up = DVec3::Y * self.middle();
        let mut bonds = Vec::new();
        for link in lattice.links.iter().filter(|l| inside(&sites[l.a as usize])) {
            let (site_a, site_b) = (sites[link.a as usize], sites[link.b as usize]);
            if let (Some(a), Some(b)) = (homes.get(&site_a), homes.get(&home(&site_b))) {
                let (from, to) = (lattice.positions[link.a as usize] - up, lattice.positions[link.b as usize] - up);
                bonds.push(CellSpring { a: *a, b: *b, from, to, site_a, site_b, class: link.class, layer: link.layer });
            }
        }
        let extent = (
            if window_x.repeats { self.spacing.0 } else { size.0 },
            if window_z.repeats { rows as f64 * self.spacing.1 } else { size.1 },
        );
        let grid = lattice.layers.iter().map(|l| (i64::from(l.nx), i64::from(l.nz))).collect();
        PeriodicCell { masses: homes.len(), springs: bonds, extent, grid }
    }
}

/// Columns (or rows) of a lattice that make one period.
#[derive(Clone, Copy)]
struct PeriodWindow {
    first: i64,
    count: i64,
    repeats: bool,
}

impl PeriodWindow {
    /// Equivalent index in the home period.
    fn home(&self, i: i64) -> i64 {
        if self.repeats { self.first + (i - self.first).rem_euclid(self.count) } else { i }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::structure::TABLE;

    #[test]
    fn a_cell_has_as_many_springs_per_node_as_a_large_lattice() {
        for row in TABLE {
            let layers = row.layers.1.min(3);
            let cross_over = row.cross_over;
            let pattern =
                LatticePattern { structure: row.kind, layers, spacing: (0.02, 0.015), gap: 0.004, cross_over };
            let cell = pattern.periodic();
            let count = |n: u32| {
                let (lattice, _) = pattern.lattice(n, n);
                lattice.links.len() as f64
            };
            // Springs grow as a n² + b n + c; the second difference over 2 h² is a, the number in
            // one cell.
            let a = (count(60) - 2.0 * count(40) + count(20)) / (2.0 * 400.0);
            let rows = if row.triangular { 2.0 } else { 1.0 };
            assert!(
                (cell.springs.len() as f64 - a * rows).abs() < 1e-9,
                "{}: {} for {a}",
                row.name,
                cell.springs.len()
            );
            assert_eq!(cell.masses, layers as usize * rows as usize);
        }
    }

    #[test]
    fn a_strip_reaches_from_edge_to_edge() {
        let structure = StructureKind::Trimm;
        let pattern = LatticePattern { structure, layers: 2, spacing: (0.01, 0.008), gap: 0.002, cross_over: false };
        let along_x = pattern.strip_along_x(6);
        assert_eq!(along_x.masses, 7 + 6);
        assert!((along_x.extent.1 - 0.048).abs() < 1e-12);
        let along_z = pattern.strip_along_z(6);
        assert_eq!(along_z.masses, 2 * (7 + 6));
        assert!((along_z.extent.0 - 0.065).abs() < 1e-12);
    }
}
