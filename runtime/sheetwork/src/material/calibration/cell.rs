//! One period of a lattice, cut out of the middle of a generated one: a structure needs no second description.
//!
//! A cell may repeat along x, along z, or both. Where it does not repeat it reaches from free edge to free edge. Its bonds
//! join representatives of masses; their ends are given as positions, m, so that a bond may leave the cell.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{Lattice, LatticeSpec, StructureKind, assemble};

/// Where a mass is in the grid of its layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Site {
    /// Layer, 0 the bottom.
    pub layer: u32,
    /// Column (along x).
    pub i: i64,
    /// Row (along z).
    pub j: i64,
}

/// Sites of all masses of a lattice, in order.
pub(crate) fn sites(lattice: &Lattice) -> Vec<Site> {
    let mut found = Vec::with_capacity(lattice.positions.len());
    for (index, layer) in lattice.layers.iter().enumerate() {
        for j in 0..layer.nz {
            found.extend((0..layer.nx).map(|i| Site { layer: index as u32, i: i64::from(i), j: i64::from(j) }));
        }
    }
    found
}

/// A spring of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bond {
    /// Representative of its first mass.
    pub a: usize,
    /// Representative of its second mass.
    pub b: usize,
    /// Where its first mass is, m; heights from the middle of the sheet.
    pub from: DVec3,
    /// Where its second mass is, m.
    pub to: DVec3,
    /// Site of its first mass.
    pub site_a: Site,
    /// Site of its second mass.
    pub site_b: Site,
    /// What it does in the structure.
    pub class: SpringClass,
    /// Layer of its lower end.
    pub layer: u32,
}

impl Bond {
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
pub(crate) struct Cell {
    /// Masses in it.
    pub masses: usize,
    /// Its springs; each is in one cell only.
    pub bonds: Vec<Bond>,
    /// Length along x and along z, m: of the period, or from edge to edge.
    pub extent: (f64, f64),
    /// Masses along x and z in each layer of the lattice it was cut from.
    pub grid: Vec<(i64, i64)>,
}

/// What a cell is cut from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pattern {
    /// Structure.
    pub structure: StructureKind,
    /// Layers.
    pub layers: u32,
    /// Distance of neighbours along x and of rows along z, m.
    pub spacing: (f64, f64),
    /// Distance between layers, m.
    pub gap: f64,
    /// Whether second neighbours are joined.
    pub cross_over: bool,
}

/// Columns or rows of a lattice that is cut along them: enough that no spring of the middle reaches an edge.
const LONG: u32 = 10;

impl Pattern {
    /// The cell that repeats both ways: a sheet without edges.
    pub fn periodic(&self) -> Cell {
        self.cut(None, None)
    }

    /// The strip along x that is `cells` wide between free edges back and front.
    pub fn strip_along_x(&self, cells: u32) -> Cell {
        self.cut(None, Some(cells))
    }

    /// The strip along z that is `cells` wide between free edges left and right.
    pub fn strip_along_z(&self, cells: u32) -> Cell {
        self.cut(Some(cells), None)
    }

    /// Height of the middle of the sheet over the bottom layer, m.
    fn middle(&self) -> f64 {
        0.5 * self.gap * f64::from(self.layers - 1)
    }

    /// A lattice of this pattern with `columns` by `rows` masses in its bottom layer.
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

    /// Cuts a cell; a width in cells where it does not repeat.
    fn cut(&self, along_x: Option<u32>, along_z: Option<u32>) -> Cell {
        let (lattice, size) = self.lattice(along_x.map_or(LONG, |c| c + 1), along_z.map_or(LONG, |c| c + 1));
        // Rows of a triangular layer are shifted in turn: two make a period.
        let rows = if self.structure.info().triangular { 2 } else { 1 };
        let window_x = Window { first: 4, count: 1, repeats: along_x.is_none() };
        let window_z = Window { first: 4, count: rows, repeats: along_z.is_none() };
        let sites = sites(&lattice);
        let home = |s: &Site| Site { layer: s.layer, i: window_x.home(s.i), j: window_z.home(s.j) };
        let inside = |s: &Site| home(s) == *s;
        let homes: BTreeMap<Site, usize> =
            sites.iter().filter(|s| inside(s)).enumerate().map(|(n, s)| (*s, n)).collect();
        let up = DVec3::Y * self.middle();
        let mut bonds = Vec::new();
        for link in lattice.links.iter().filter(|l| inside(&sites[l.a as usize])) {
            let (site_a, site_b) = (sites[link.a as usize], sites[link.b as usize]);
            if let (Some(a), Some(b)) = (homes.get(&site_a), homes.get(&home(&site_b))) {
                let (from, to) = (lattice.positions[link.a as usize] - up, lattice.positions[link.b as usize] - up);
                bonds.push(Bond { a: *a, b: *b, from, to, site_a, site_b, class: link.class, layer: link.layer });
            }
        }
        let extent = (
            if window_x.repeats { self.spacing.0 } else { size.0 },
            if window_z.repeats { rows as f64 * self.spacing.1 } else { size.1 },
        );
        let grid = lattice.layers.iter().map(|l| (i64::from(l.nx), i64::from(l.nz))).collect();
        Cell { masses: homes.len(), bonds, extent, grid }
    }
}

/// The columns (or rows) of a lattice that make one period.
#[derive(Clone, Copy)]
struct Window {
    first: i64,
    count: i64,
    repeats: bool,
}

impl Window {
    /// The same place in the home period.
    fn home(&self, i: i64) -> i64 {
        if self.repeats { self.first + (i - self.first).rem_euclid(self.count) } else { i }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::structure::TABLE;

    #[test]
    fn a_cell_has_as_many_springs_a_mass_as_a_large_lattice() {
        for row in TABLE {
            let layers = row.layers.1.min(3);
            let cross_over = row.cross_over;
            let pattern = Pattern { structure: row.kind, layers, spacing: (0.02, 0.015), gap: 0.004, cross_over };
            let cell = pattern.periodic();
            let count = |n: u32| {
                let (lattice, _) = pattern.lattice(n, n);
                lattice.links.len() as f64
            };
            // Springs grow as a n² + b n + c; the second difference over 2 h² is a, those of one cell.
            let a = (count(60) - 2.0 * count(40) + count(20)) / (2.0 * 400.0);
            let rows = if row.triangular { 2.0 } else { 1.0 };
            assert!((cell.bonds.len() as f64 - a * rows).abs() < 1e-9, "{}: {} for {a}", row.name, cell.bonds.len());
            assert_eq!(cell.masses, layers as usize * rows as usize);
        }
    }

    #[test]
    fn a_strip_reaches_from_edge_to_edge() {
        let structure = StructureKind::Trimm;
        let pattern = Pattern { structure, layers: 2, spacing: (0.01, 0.008), gap: 0.002, cross_over: false };
        let along_x = pattern.strip_along_x(6);
        assert_eq!(along_x.masses, 7 + 6);
        assert!((along_x.extent.1 - 0.048).abs() < 1e-12);
        let along_z = pattern.strip_along_z(6);
        assert_eq!(along_z.masses, 2 * (7 + 6));
        assert!((along_z.extent.0 - 0.065).abs() < 1e-12);
    }
}
