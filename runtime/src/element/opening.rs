//! Which cells of a sheet are open: torn or melted away. What elements, heat, contact and drawing ask.
//!
//! Cells are those of the grid of the lowest layer, side by side along u (columns) and then along v (rows). A place in the sheet is
//! (u, v) in cells. What is outside of the sheet is as good as open. A spring is cut where at a quarter of its way or at three quarters
//! there is no closed cell on either side of it; a mass is gone when no closed cell is around it. Upper layers, whose masses lie over
//! the middles of cells, are asked the same questions.

/// How far beside a line or a place it is looked, in cells.
const BESIDE: f64 = 1e-3;

/// The cells of a sheet, and which of them are open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Open {
    columns: usize,
    rows: usize,
    open: Vec<bool>,
    count: usize,
}

impl Open {
    /// A sheet of `columns` by `rows` masses in its lowest layer, all of it closed.
    pub fn none(columns: usize, rows: usize) -> Self {
        let (columns, rows) = (columns.saturating_sub(1), rows.saturating_sub(1));
        Self { columns, rows, open: vec![false; columns * rows], count: 0 }
    }

    /// Cells along u and along v.
    pub fn size(&self) -> (usize, usize) {
        (self.columns, self.rows)
    }

    /// Of each cell, whether it is open.
    pub fn cells(&self) -> &[bool] {
        &self.open
    }

    /// How many are open.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether none is.
    pub fn is_whole(&self) -> bool {
        self.count == 0
    }

    /// Opens cell number `cell`; nothing where there is none.
    pub fn set(&mut self, cell: usize) {
        if let Some(open) = self.open.get_mut(cell).filter(|open| !**open) {
            *open = true;
            self.count += 1;
        }
    }

    /// Opens the cells of `other`, and no more; nothing where that is of another sheet.
    pub fn set_all(&mut self, other: &[bool]) {
        if other.len() == self.open.len() {
            self.open.copy_from_slice(other);
            self.count = other.iter().filter(|o| **o).count();
        }
    }

    /// Number of the cell in column `i` of row `j`; none outside of the sheet.
    pub fn number(&self, i: i64, j: i64) -> Option<usize> {
        let within = i >= 0 && j >= 0 && i < self.columns as i64 && j < self.rows as i64;
        within.then(|| j as usize * self.columns + i as usize)
    }

    /// Whether there is a cell in column `i` of row `j`, and it is closed.
    pub fn is_closed(&self, i: i64, j: i64) -> bool {
        self.number(i, j).is_some_and(|c| !self.open[c])
    }

    /// Whether a closed cell is at (u, v), in cells.
    pub fn is_closed_at(&self, u: f64, v: f64) -> bool {
        self.is_closed(u.floor() as i64, v.floor() as i64)
    }

    /// Whether no closed cell is around (u, v), in cells.
    pub fn is_gone(&self, (u, v): (f64, f64)) -> bool {
        let around = [(-BESIDE, -BESIDE), (BESIDE, -BESIDE), (-BESIDE, BESIDE), (BESIDE, BESIDE)];
        !around.iter().any(|(du, dv)| self.is_closed_at(u + du, v + dv))
    }

    /// Whether a spring from `a` to `b`, each (u, v) in cells, is cut.
    pub fn cuts(&self, a: (f64, f64), b: (f64, f64)) -> bool {
        let (du, dv) = (b.0 - a.0, b.1 - a.1);
        let length = du.hypot(dv);
        if length < BESIDE {
            return self.is_gone(a);
        }
        let beside = (-dv / length * BESIDE, du / length * BESIDE);
        let held = |s: f64| {
            let (u, v) = (a.0 + s * du, a.1 + s * dv);
            self.is_closed_at(u + beside.0, v + beside.1) || self.is_closed_at(u - beside.0, v - beside.1)
        };
        !(held(0.25) && held(0.75))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spring_is_cut_where_nothing_is_beside_it() {
        let mut open = Open::none(4, 3);
        open.set(1);
        // Across the open cell, along an edge it shares, along the border it had.
        assert!(open.cuts((1.0, 0.0), (2.0, 1.0)));
        assert!(!open.cuts((1.0, 1.0), (2.0, 1.0)));
        assert!(open.cuts((1.0, 0.0), (2.0, 0.0)));
        // Second neighbours over it, and between middles of cells.
        assert!(open.cuts((0.0, 0.0), (2.0, 0.0)));
        assert!(open.cuts((0.5, 0.5), (1.5, 0.5)));
        assert!(!open.cuts((0.5, 1.5), (1.5, 1.5)));
        // Every mass has a cell yet but the open one's middle.
        assert!(open.is_gone((1.5, 0.5)) && !open.is_gone((1.0, 0.0)) && !open.is_gone((2.0, 1.0)));
        open.set(0);
        assert!(open.is_gone((0.0, 0.0)) && open.is_gone((1.0, 0.0)) && !open.is_gone((1.0, 1.0)));
        assert_eq!(open.count(), 2);
        open.set_all(&[false; 6]);
        assert!(open.is_whole());
    }
}
