//! Layers of a regular grid, and the spring families of structures.
//!
//! A layer is `nx` by `nz` nodes with spacings (dx, dz). A triangular layer shifts every other row
//! by half a cell: row j lies at x offset dx/2 when j is odd. The smaller layers in between lie
//! over the middles of the cells (triangular: over the centroid of the triangle that points to the
//! next row) of the larger ones.

use glam::DVec3;

use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{Lattice, LatticeSpec, LatticeSpring};

/// Layer of a lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LatticeLayer {
    /// Index of the first node.
    pub first: u32,
    /// Nodes in a row (along x).
    pub nx: u32,
    /// Rows (along z).
    pub nz: u32,
    /// Whether odd rows are shifted by half a cell.
    pub triangular: bool,
    /// Whether the last row is joined to the first: the layer is a tube about x. Only layers of a
    /// sheet file may be.
    pub tubular: bool,
}

impl LatticeLayer {
    /// Index of the node in column `i` of row `j`.
    pub fn at(&self, i: u32, j: u32) -> u32 {
        self.first + j * self.nx + i
    }

    /// Nodes in line: that in column `i` of row `j`, that at the offset (di, dj) from it, a second
    /// neighbour, and that in between; `None` where the line leaves the layer.
    ///
    /// A slanting line of a triangular layer moves by one column in two rows. From an even row it
    /// moves half a cell back or forth, from an odd row, which is shifted, half a cell more.
    fn triple(&self, (i, j): (u32, u32), (di, dj): (i32, i32)) -> Option<[u32; 3]> {
        let end_i = i.checked_add_signed(di).filter(|i| *i < self.nx)?;
        let end_j = j.checked_add_signed(dj).filter(|j| *j < self.nz)?;
        let step = if self.triangular && dj != 0 { (di - 1) / 2 + (j % 2) as i32 } else { di / 2 };
        let middle = self.at(i.checked_add_signed(step)?, j.checked_add_signed(dj / 2)?);
        Some([self.at(i, j), middle, self.at(end_i, end_j)])
    }

    /// Number of nodes.
    pub fn len(&self) -> u32 {
        self.nx * self.nz
    }

    /// Whether the layer has no nodes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Range of the node indices.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.len()) as usize
    }

    /// Triangles that cover the layer, counter-clockwise seen from above (+y), from outside a tube.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        let strips = if self.tubular { self.nz } else { self.nz.saturating_sub(1) };
        for j in 0..strips {
            // The strip after the last row of a tube ends at the first row.
            let next = (j + 1) % self.nz;
            for i in 0..self.nx.saturating_sub(1) {
                let (a, b) = (self.at(i, j), self.at(i + 1, j));
                let (c, d) = (self.at(i, next), self.at(i + 1, next));
                // The diagonal is that of the structure: in an odd triangular row it has the other
                // direction.
                if self.triangular && j % 2 == 1 {
                    triangles.extend([[a, c, d], [a, d, b]]);
                } else {
                    triangles.extend([[a, c, b], [b, c, d]]);
                }
            }
        }
        triangles
    }
}

/// Builder of a lattice: lays out the nodes, then collects springs family by family.
pub struct LatticeBuilder {
    lattice: Lattice,
    cross_over: bool,
}

impl LatticeBuilder {
    pub(crate) fn new(spec: &LatticeSpec) -> Self {
        let triangular = spec.structure.info().triangular;
        let (nx, count, nz) = spec.grid;
        let half = if triangular { 0.5 } else { 0.0 };
        let (dx, dz) = spec.spacing();
        // Middle of cell (0, 0) relative to node (0, 0): the centre of the cell, or the centroid of
        // its triangle.
        let middle = if triangular { (0.5 * dx, dz / 3.0) } else { (0.5 * dx, 0.5 * dz) };
        let mut lattice = Lattice::default();
        for index in 0..count {
            let small = index % 2 == 1;
            let (lx, lz) = if small { (nx - 1, nz - 1) } else { (nx, nz) };
            let shift = if small { middle } else { (0.0, 0.0) };
            let layer =
                LatticeLayer { first: lattice.positions.len() as u32, nx: lx, nz: lz, triangular, tubular: false };
            for j in 0..lz {
                for i in 0..lx {
                    let stagger = if j % 2 == 1 { half * dx } else { 0.0 };
                    let x = f64::from(i) * dx + stagger + shift.0 - 0.5 * spec.size.0;
                    let z = f64::from(j) * dz + shift.1 - 0.5 * spec.size.1;
                    lattice.positions.push(DVec3::new(x, f64::from(index) * spec.gap, z));
                    lattice.layer_of.push(index);
                    lattice.border.push(i == 0 || j == 0 || i + 1 == lx || j + 1 == lz);
                }
            }
            lattice.layers.push(layer);
        }
        Self { lattice, cross_over: spec.cross_over }
    }

    pub(crate) fn finish(self) -> Lattice {
        self.lattice
    }

    /// For each (di, dj, class): join (i, j) to (i + di, j + dj) in every layer where both exist.
    pub(crate) fn families(&mut self, families: &[(i32, i32, SpringClass)]) {
        for (di, dj, class) in families {
            for index in 0..self.lattice.layers.len() {
                self.planar_where(index, *di, *dj, *class, |_| true);
            }
        }
    }

    /// Join (i, j) to (i + di, j + dj) in layer `index`, in the rows j with `rows(j)`.
    fn planar_where(&mut self, index: usize, di: i32, dj: i32, class: SpringClass, rows: impl Fn(u32) -> bool) {
        let layer = self.lattice.layers[index];
        let (nx, nz) = (layer.nx as i32, layer.nz as i32);
        for j in (0..nz).filter(|j| (0..nz).contains(&(j + dj)) && rows(*j as u32)) {
            for i in (0..nx).filter(|i| (0..nx).contains(&(i + di))) {
                let a = layer.at(i as u32, j as u32);
                let b = layer.at((i + di) as u32, (j + dj) as u32);
                self.lattice.links.push(LatticeSpring { a, b, class, layer: index as u32 });
            }
        }
    }

    /// Add the two slanting families of a triangular layer: forward (to larger x) and backward.
    ///
    /// From an even row the forward neighbour has the same column and the backward one the column
    /// before; from an odd row, which is shifted, the column after and the same column.
    pub(crate) fn slants(&mut self) {
        for index in 0..self.lattice.layers.len() {
            for odd in [false, true] {
                let (forward, backward) = if odd { (1, 0) } else { (0, -1) };
                self.planar_where(index, forward, 1, SpringClass::Diagonal, |j| (j % 2 == 1) == odd);
                self.planar_where(index, backward, 1, SpringClass::AntiDiagonal, |j| (j % 2 == 1) == odd);
            }
        }
    }

    /// Add springs from every node of a smaller layer to the corners of its cell in the layers
    /// below and above.
    pub(crate) fn inter_layer(&mut self) {
        for index in (1..self.lattice.layers.len()).step_by(2) {
            self.corners(index, index - 1);
            if index + 1 < self.lattice.layers.len() {
                self.corners(index, index + 1);
            }
        }
    }

    fn corners(&mut self, small: usize, large: usize) {
        let (from, to) = (self.lattice.layers[small], self.lattice.layers[large]);
        let layer = small.min(large) as u32;
        for j in 0..from.nz {
            // In an odd triangular row the apex of the triangle is one column further.
            let apex = j % 2;
            let square = [(0, 0), (1, 0), (0, 1), (1, 1)];
            let triangle = [(0, 0), (1, 0), (apex, 1)];
            let cell: &[(u32, u32)] = if from.triangular { &triangle } else { &square };
            for (di, dj) in cell {
                for i in 0..from.nx {
                    let (a, b) = (to.at(i + di, j + dj), from.at(i, j));
                    self.lattice.links.push(LatticeSpring { a, b, class: SpringClass::Inter, layer });
                }
            }
        }
    }

    /// Add flexion springs between second neighbours along the given straight lines, and their
    /// triples for the angle limit.
    pub(crate) fn flexion(&mut self, lines: &[(i32, i32)]) {
        lines.iter().for_each(|(di, dj)| self.families(&[(*di, *dj, SpringClass::Flexion)]));
        for layer in self.lattice.layers.clone() {
            for j in 0..layer.nz {
                for i in 0..layer.nx {
                    let triples = lines.iter().filter_map(|line| layer.triple((i, j), *line));
                    self.lattice.flexion.extend(triples);
                }
            }
        }
    }

    /// Add cross-over springs, where enabled, between second neighbours along the given straight
    /// lines.
    pub(crate) fn cross_over(&mut self, lines: &[(i32, i32)]) {
        if self.cross_over {
            lines.iter().for_each(|(di, dj)| self.families(&[(*di, *dj, SpringClass::CrossOver)]));
        }
    }
}
