//! Open cells of a sheet: cells without stiffness, contact and heat after fracture or melting.
//!
//! Cells are those of the grid of the lowest layer, numbered along u (columns) and then along v
//! (rows). Positions in the sheet are (u, v) in cells. The outside of the sheet counts as open. A
//! spring is cut where no closed cell lies on either side of it at one or three quarters of its
//! length. A node is removed when no closed cell touches it. Upper layers, whose nodes lie above
//! the cell centres, use the same rules.

/// Distance from a line or a point at which cells are tested, in cells.
const SIDE_OFFSET: f64 = 1e-3;

/// Cells of a sheet, and which of them are open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpenCells {
    columns: usize,
    rows: usize,
    open: Vec<bool>,
    count: usize,
}

impl OpenCells {
    /// Closed cells of a sheet with `columns` by `rows` nodes in its lowest layer.
    pub fn closed(columns: usize, rows: usize) -> Self {
        let (columns, rows) = (columns.saturating_sub(1), rows.saturating_sub(1));
        Self { columns, rows, open: vec![false; columns * rows], count: 0 }
    }

    /// Cells along u and along v.
    pub fn size(&self) -> (usize, usize) {
        (self.columns, self.rows)
    }

    /// Whether each cell is open.
    pub fn cells(&self) -> &[bool] {
        &self.open
    }

    /// Number of open cells.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether all cells are closed.
    pub fn is_whole(&self) -> bool {
        self.count == 0
    }

    /// Opens cell `cell`; no effect for an index out of range.
    pub fn set(&mut self, cell: usize) {
        if let Some(open) = self.open.get_mut(cell).filter(|open| !**open) {
            *open = true;
            self.count += 1;
        }
    }

    /// Opens exactly the cells marked in `other`; no effect if the lengths differ.
    pub fn set_all(&mut self, other: &[bool]) {
        if other.len() == self.open.len() {
            self.open.copy_from_slice(other);
            self.count = other.iter().filter(|o| **o).count();
        }
    }

    /// Index of the cell in column `i` of row `j`; `None` outside the sheet.
    pub fn cell_index(&self, i: i64, j: i64) -> Option<usize> {
        let within = i >= 0 && j >= 0 && i < self.columns as i64 && j < self.rows as i64;
        within.then(|| j as usize * self.columns + i as usize)
    }

    /// Whether the cell in column `i` of row `j` exists and is closed.
    pub fn is_closed(&self, i: i64, j: i64) -> bool {
        self.cell_index(i, j).is_some_and(|c| !self.open[c])
    }

    /// Whether a closed cell lies at (u, v), in cells.
    pub fn is_closed_at(&self, u: f64, v: f64) -> bool {
        self.is_closed(u.floor() as i64, v.floor() as i64)
    }

    /// Whether no closed cell touches (u, v), in cells.
    pub fn is_gone(&self, (u, v): (f64, f64)) -> bool {
        let around = [
            (-SIDE_OFFSET, -SIDE_OFFSET),
            (SIDE_OFFSET, -SIDE_OFFSET),
            (-SIDE_OFFSET, SIDE_OFFSET),
            (SIDE_OFFSET, SIDE_OFFSET),
        ];
        !around.iter().any(|(du, dv)| self.is_closed_at(u + du, v + dv))
    }

    /// Whether a spring from `a` to `b`, each (u, v) in cells, is cut.
    pub fn is_spring_cut(&self, a: (f64, f64), b: (f64, f64)) -> bool {
        let (du, dv) = (b.0 - a.0, b.1 - a.1);
        let length = du.hypot(dv);
        if length < SIDE_OFFSET {
            return self.is_gone(a);
        }
        let beside = (-dv / length * SIDE_OFFSET, du / length * SIDE_OFFSET);
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
    fn a_spring_without_adjacent_closed_cells_is_cut() {
        let mut open = OpenCells::closed(4, 3);
        open.set(1);
        // Across the open cell, along an edge it shares, along its border edge.
        assert!(open.is_spring_cut((1.0, 0.0), (2.0, 1.0)));
        assert!(!open.is_spring_cut((1.0, 1.0), (2.0, 1.0)));
        assert!(open.is_spring_cut((1.0, 0.0), (2.0, 0.0)));
        // Second neighbours across it, and between cell centres.
        assert!(open.is_spring_cut((0.0, 0.0), (2.0, 0.0)));
        assert!(open.is_spring_cut((0.5, 0.5), (1.5, 0.5)));
        assert!(!open.is_spring_cut((0.5, 1.5), (1.5, 1.5)));
        // Every node touches a closed cell; the centre of the open cell does not.
        assert!(open.is_gone((1.5, 0.5)) && !open.is_gone((1.0, 0.0)) && !open.is_gone((2.0, 1.0)));
        open.set(0);
        assert!(open.is_gone((0.0, 0.0)) && open.is_gone((1.0, 0.0)) && !open.is_gone((1.0, 1.0)));
        assert_eq!(open.count(), 2);
        open.set_all(&[false; 6]);
        assert!(open.is_whole());
    }
}
