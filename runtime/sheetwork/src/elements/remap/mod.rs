//! Remapping of element state between two grids of a sheet.
//!
//! State at points of a grid (rest curvature, creep, rest strain) becomes, on the new grid, the
//! mean weighted with a hat function as wide as a cell of the coarser grid. To a finer grid this is
//! linear interpolation. To a coarser grid it conserves the sum over a line, so that a fold keeps
//! its angle. Constant fields stay constant. `meshes` handles triangle meshes.

pub(crate) mod meshes;

pub use crate::elements::remap::meshes::{MeshRemap, hat_weights};

/// Remapping between two grids or two meshes.
pub enum Remap<'a> {
    /// Between rectangular grids of a shell or a lattice.
    Grid(GridRemap),
    /// Between triangle meshes of a sheet with outline, holes or cuts.
    Mesh(MeshRemap<'a>),
}

/// State at the points of the old sheet, from [`Remap::gather`].
pub enum SourceField<const K: usize> {
    /// At nodes or cell centres.
    Grid(GridField<K>),
    /// One value per triangle.
    Mesh(Vec<Option<[f64; K]>>),
}

impl Remap<'_> {
    /// Collects values at `homes` of the old sheet: nodes, or first nodes of cells for values at
    /// cell centres (`middle`); triangles of a mesh.
    pub fn gather<const K: usize>(&self, middle: bool, homes: impl Iterator<Item = (u32, [f64; K])>) -> SourceField<K> {
        match self {
            Self::Grid(grids) => {
                let mut places = if middle { GridField::cells(grids.from) } else { GridField::masses(grids.from) };
                for (home, value) in homes {
                    let (i, j) = grids.column_and_row(home as usize);
                    places.put(i, j, value);
                }
                SourceField::Grid(places)
            }
            Self::Mesh(meshes) => {
                let mut each = vec![None; meshes.from.triangles.len()];
                homes.for_each(|(home, value)| each[home as usize] = Some(value));
                SourceField::Mesh(each)
            }
        }
    }

    /// Values at the nodes of the new sheet from `values` at the nodes of the old one.
    pub fn at_nodes(&self, values: &[f64]) -> Vec<f64> {
        match self {
            Self::Grid(grids) => {
                let places = self.gather(false, values.iter().enumerate().map(|(k, v)| (k as u32, [*v])));
                let at = |k: u32| self.interpolate(&places, k, false).map_or(0.0, |v| v[0]);
                (0..(grids.to[0] * grids.to[1]) as u32).map(at).collect()
            }
            Self::Mesh(meshes) => {
                let values: Vec<[f64; 1]> = values.iter().map(|v| [*v]).collect();
                (0..meshes.to.positions.len()).map(|i| meshes.at_node(&values, i)[0]).collect()
            }
        }
    }

    /// Value at `home` of the new sheet; `None` where no value is known.
    pub fn interpolate<const K: usize>(&self, held: &SourceField<K>, home: u32, middle: bool) -> Option<[f64; K]> {
        match (self, held) {
            (Self::Grid(grids), SourceField::Grid(places)) => {
                grids.interpolate(places, grids.place(home as usize, middle))
            }
            (Self::Mesh(meshes), SourceField::Mesh(each)) => meshes.interpolate(each, home as usize),
            _ => None,
        }
    }
}

/// Remapping between two rectangular grids: numbers of nodes along u and v.
#[derive(Clone, Copy, Debug)]
pub struct GridRemap {
    /// Old grid.
    pub from: [usize; 2],
    /// New grid.
    pub to: [usize; 2],
}

/// Values at the nodes or cell centres of a grid, where they are known.
pub struct GridField<const K: usize> {
    columns: usize,
    rows: usize,
    /// Distance of the first point from the border, in cells.
    offset: f64,
    values: Vec<Option<[f64; K]>>,
}

impl<const K: usize> GridField<K> {
    /// At the nodes of a grid.
    pub fn masses([columns, rows]: [usize; 2]) -> Self {
        Self { columns, rows, offset: 0.0, values: vec![None; columns * rows] }
    }

    /// At the cell centres of a grid.
    pub fn cells([columns, rows]: [usize; 2]) -> Self {
        let (columns, rows) = (columns - 1, rows - 1);
        Self { columns, rows, offset: 0.5, values: vec![None; columns * rows] }
    }

    /// Sets the value at point (i, j).
    pub fn put(&mut self, i: usize, j: usize, value: [f64; K]) {
        self.values[j * self.columns + i] = Some(value);
    }
}

impl GridRemap {
    /// Width of a cell of the coarser grid along `axis`, as a fraction of the sheet.
    fn width(&self, axis: usize) -> f64 {
        1.0 / (self.from[axis].min(self.to[axis]) - 1) as f64
    }

    /// Points of a row and their weights under a hat function centred at `at` (0 to 1), with its
    /// width multiplied by `wide`.
    fn hat(&self, axis: usize, (count, offset): (usize, f64), at: f64, wide: f64) -> Vec<(usize, f64)> {
        let cells = (self.from[axis] - 1) as f64;
        let width = self.width(axis) * wide;
        let first = ((at - width) * cells - offset).floor().max(0.0) as usize;
        let weight = |i: usize| {
            let place = (i as f64 + offset) / cells;
            // In a sum over a line, points on the border count half.
            let border = offset == 0.0 && (i == 0 || i + 1 == count);
            let share = if border && self.from[axis] > self.to[axis] { 0.5 } else { 1.0 };
            share * (1.0 - (place - at).abs() / width).max(0.0)
        };
        let last = (((at + width) * cells - offset).ceil().max(0.0) as usize).min(count - 1);
        (first.min(count - 1)..=last).map(|i| (i, weight(i))).filter(|w| w.1 > 1e-9).collect()
    }

    /// Value at (u, v), each 0 to 1 over the sheet; `None` if no value is known anywhere.
    pub fn interpolate<const K: usize>(&self, values: &GridField<K>, at: [f64; 2]) -> Option<[f64; K]> {
        // A wider hat where no value is near, as beside a border, which has no curvature across it.
        for wide in [1.0, 2.0, 4.0, 1e3] {
            let u = self.hat(0, (values.columns, values.offset), at[0], wide);
            let v = self.hat(1, (values.rows, values.offset), at[1], wide);
            let (mut sum, mut whole) = ([0.0; K], 0.0);
            for (j, b) in &v {
                for (i, a) in &u {
                    if let Some(value) = &values.values[j * values.columns + i] {
                        whole += a * b;
                        sum.iter_mut().zip(value).for_each(|(s, x)| *s += a * b * x);
                    }
                }
            }
            if whole > 1e-9 {
                return Some(sum.map(|s| s / whole));
            }
        }
        None
    }

    /// Position of node `home` of the new grid, each coordinate 0 to 1 over the sheet, or of the
    /// centre of the cell with this first node.
    pub fn place(&self, home: usize, middle: bool) -> [f64; 2] {
        let [columns, rows] = self.to;
        let half = if middle { 0.5 } else { 0.0 };
        let (i, j) = ((home % columns) as f64 + half, (home / columns) as f64 + half);
        [i / (columns - 1) as f64, j / (rows - 1) as f64]
    }

    /// Column and row of node `home` of the old grid.
    pub fn column_and_row(&self, home: usize) -> (usize, usize) {
        (home % self.from[0], home / self.from[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(from: usize, to: usize, f: impl Fn(usize) -> Option<f64>) -> Vec<f64> {
        let carry = GridRemap { from: [from, 3], to: [to, 3] };
        let mut values = GridField::masses(carry.from);
        for j in 0..3 {
            (0..from).filter_map(|i| Some((i, f(i)?))).for_each(|(i, x)| values.put(i, j, [x]));
        }
        (0..to).map(|i| carry.interpolate(&values, carry.place(to + i, false)).expect("known")[0]).collect()
    }

    #[test]
    fn a_constant_field_stays_constant() {
        for (from, to) in [(11, 21), (21, 11), (41, 11), (21, 16), (7, 30)] {
            let inner = line(from, to, |i| (i > 0 && i + 1 < from).then_some(3.5));
            assert!(inner.iter().all(|x| (x - 3.5).abs() < 1e-12), "{from} to {to}: {inner:?}");
        }
    }

    #[test]
    fn the_sum_along_a_fold_is_conserved() {
        // A fold of angle 1 has a curvature of one over the spacing.
        for (from, to, at) in [(41, 11, 20), (41, 11, 13), (21, 11, 7), (11, 21, 4), (11, 41, 6), (41, 21, 9)] {
            let angles = line(from, to, |i| Some(if i == at { (from - 1) as f64 } else { 0.0 }));
            let sum: f64 = angles.iter().sum::<f64>() / (to - 1) as f64;
            assert!((sum - 1.0).abs() < 1e-12, "{from} to {to} at {at}: {sum}");
        }
    }
}
