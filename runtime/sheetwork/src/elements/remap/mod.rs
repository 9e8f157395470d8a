//! What elements hold, from one grid to another of the same sheet.
//!
//! What is held at places of a grid (rest curvatures, creep, strains that have set) is taken to those of another as the mean under a hat as
//! wide as the coarser grid's cells. To a finer grid that is linear in between; to a coarser one what stands in a line, such as a fold, keeps
//! its sum: an angle stays that angle. What is the same everywhere stays so. Between meshes of triangles: `meshes`.

pub(crate) mod meshes;

pub use crate::elements::remap::meshes::{Meshes, hats};

/// From what to what.
pub enum Carry<'a> {
    /// Of a rectangle, or a lattice.
    Grid(Grids),
    /// Of a sheet with an outline, holes or cuts.
    Mesh(Meshes<'a>),
}

/// What is held at places of the old sheet, as [`Carry::gather`] has it.
pub enum Held<const K: usize> {
    /// At masses or in the middles of cells.
    Grid(Places<K>),
    /// Of each triangle.
    Mesh(Vec<Option<[f64; K]>>),
}

impl Carry<'_> {
    /// What is held at `homes` of the old sheet: masses, or the first masses of cells if it is in their middles; triangles of a mesh.
    pub fn gather<const K: usize>(&self, middle: bool, homes: impl Iterator<Item = (u32, [f64; K])>) -> Held<K> {
        match self {
            Self::Grid(grids) => {
                let mut places = if middle { Places::cells(grids.from) } else { Places::masses(grids.from) };
                for (home, value) in homes {
                    let (i, j) = grids.row_of(home as usize);
                    places.put(i, j, value);
                }
                Held::Grid(places)
            }
            Self::Mesh(meshes) => {
                let mut each = vec![None; meshes.from.triangles.len()];
                homes.for_each(|(home, value)| each[home as usize] = Some(value));
                Held::Mesh(each)
            }
        }
    }

    /// What `values`, one a mass of the old sheet, come to at those of the new one.
    pub fn at_masses(&self, values: &[f64]) -> Vec<f64> {
        match self {
            Self::Grid(grids) => {
                let places = self.gather(false, values.iter().enumerate().map(|(k, v)| (k as u32, [*v])));
                let at = |k: u32| self.read(&places, k, false).map_or(0.0, |v| v[0]);
                (0..(grids.to[0] * grids.to[1]) as u32).map(at).collect()
            }
            Self::Mesh(meshes) => {
                let values: Vec<[f64; 1]> = values.iter().map(|v| [*v]).collect();
                (0..meshes.to.positions.len()).map(|i| meshes.at_mass(&values, i)[0]).collect()
            }
        }
    }

    /// What `held` comes to at `home` of the new sheet; `None` where nothing is known.
    pub fn read<const K: usize>(&self, held: &Held<K>, home: u32, middle: bool) -> Option<[f64; K]> {
        match (self, held) {
            (Self::Grid(grids), Held::Grid(places)) => grids.read(places, grids.place(home as usize, middle)),
            (Self::Mesh(meshes), Held::Mesh(each)) => meshes.read(each, home as usize),
            _ => None,
        }
    }
}

/// From a grid to another: masses along u and v of each.
#[derive(Clone, Copy, Debug)]
pub struct Grids {
    /// There were.
    pub from: [usize; 2],
    /// There are.
    pub to: [usize; 2],
}

/// Values at the masses of a grid, or in the middles of cells, where they are known.
pub struct Places<const K: usize> {
    columns: usize,
    rows: usize,
    /// How far the first is from the border, in cells.
    offset: f64,
    values: Vec<Option<[f64; K]>>,
}

impl<const K: usize> Places<K> {
    /// At the masses of a grid.
    pub fn masses([columns, rows]: [usize; 2]) -> Self {
        Self { columns, rows, offset: 0.0, values: vec![None; columns * rows] }
    }

    /// In the middles of its cells.
    pub fn cells([columns, rows]: [usize; 2]) -> Self {
        let (columns, rows) = (columns - 1, rows - 1);
        Self { columns, rows, offset: 0.5, values: vec![None; columns * rows] }
    }

    /// Puts a value to place (i, j).
    pub fn put(&mut self, i: usize, j: usize, value: [f64; K]) {
        self.values[j * self.columns + i] = Some(value);
    }
}

impl Grids {
    /// Width of a cell of the coarser grid along `axis`, of the sheet.
    fn width(&self, axis: usize) -> f64 {
        1.0 / (self.from[axis].min(self.to[axis]) - 1) as f64
    }

    /// Places of a row with their weights under a hat about `at` (0 to 1), `wide` times as wide as it is.
    fn hat(&self, axis: usize, (count, offset): (usize, f64), at: f64, wide: f64) -> Vec<(usize, f64)> {
        let cells = (self.from[axis] - 1) as f64;
        let width = self.width(axis) * wide;
        let first = ((at - width) * cells - offset).floor().max(0.0) as usize;
        let weight = |i: usize| {
            let place = (i as f64 + offset) / cells;
            // Of what is summed up, what lies on the border stands for half as much.
            let border = offset == 0.0 && (i == 0 || i + 1 == count);
            let share = if border && self.from[axis] > self.to[axis] { 0.5 } else { 1.0 };
            share * (1.0 - (place - at).abs() / width).max(0.0)
        };
        let last = (((at + width) * cells - offset).ceil().max(0.0) as usize).min(count - 1);
        (first.min(count - 1)..=last).map(|i| (i, weight(i))).filter(|w| w.1 > 1e-9).collect()
    }

    /// What `values` come to at (u, v), each 0 to 1 over the sheet; `None` where nothing is known of any place.
    pub fn read<const K: usize>(&self, values: &Places<K>, at: [f64; 2]) -> Option<[f64; K]> {
        // Wider where nothing is known near by, as across a border that has no curvature.
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

    /// Where mass `home` of the new grid is, each 0 to 1 over the sheet, or the middle of the cell whose first mass it is.
    pub fn place(&self, home: usize, middle: bool) -> [f64; 2] {
        let [columns, rows] = self.to;
        let half = if middle { 0.5 } else { 0.0 };
        let (i, j) = ((home % columns) as f64 + half, (home / columns) as f64 + half);
        [i / (columns - 1) as f64, j / (rows - 1) as f64]
    }

    /// Row and column of mass `home` of the old grid.
    pub fn row_of(&self, home: usize) -> (usize, usize) {
        (home % self.from[0], home / self.from[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(from: usize, to: usize, f: impl Fn(usize) -> Option<f64>) -> Vec<f64> {
        let carry = Grids { from: [from, 3], to: [to, 3] };
        let mut values = Places::masses(carry.from);
        for j in 0..3 {
            (0..from).filter_map(|i| Some((i, f(i)?))).for_each(|(i, x)| values.put(i, j, [x]));
        }
        (0..to).map(|i| carry.read(&values, carry.place(to + i, false)).expect("known")[0]).collect()
    }

    #[test]
    fn what_is_the_same_everywhere_stays_so() {
        for (from, to) in [(11, 21), (21, 11), (41, 11), (21, 16), (7, 30)] {
            let inner = line(from, to, |i| (i > 0 && i + 1 < from).then_some(3.5));
            assert!(inner.iter().all(|x| (x - 3.5).abs() < 1e-12), "{from} to {to}: {inner:?}");
        }
    }

    #[test]
    fn the_sum_of_a_line_is_kept() {
        // A fold of the angle 1: its curvature is one over the spacing.
        for (from, to, at) in [(41, 11, 20), (41, 11, 13), (21, 11, 7), (11, 21, 4), (11, 41, 6), (41, 21, 9)] {
            let angles = line(from, to, |i| Some(if i == at { (from - 1) as f64 } else { 0.0 }));
            let sum: f64 = angles.iter().sum::<f64>() / (to - 1) as f64;
            assert!((sum - 1.0).abs() < 1e-12, "{from} to {to} at {at}: {sum}");
        }
    }
}
