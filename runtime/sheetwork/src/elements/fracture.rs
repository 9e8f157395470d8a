//! Open cells of a sheet: cells without stiffness, contact and heat after fracture or melting.
//!
//! Cells are those of the lowest layer: the rectangles of its grid, numbered along u (columns) and
//! then along v (rows), or the triangles of its mesh. Positions in the sheet are (u, v) in cells
//! of a grid, in metres of a mesh. The outside of the sheet counts as open. A spring is cut where
//! no closed cell lies on either side of it at one or three quarters of its length. A node is
//! removed when no closed cell touches it. Upper layers, whose nodes lie above the cell centres,
//! use the same rules. The two sides of a cut in a mesh have the same places and different nodes:
//! nodes and sides of the mesh are judged by their own triangles.

use crate::elements::triangle_cells::TriangleCells;

/// Distance from a line or a point at which cells are tested, in cells.
const SIDE_OFFSET: f64 = 1e-3;

/// Cells of a sheet, and which of them are open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpenCells {
    columns: usize,
    rows: usize,
    open: Vec<bool>,
    count: usize,
    /// The triangles, if the cells are triangles: a single row.
    triangles: Option<Box<TriangleCells>>,
}

/// Corners of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellCorners {
    /// Nodes at (0, 0), (1, 0), (0, 1), (1, 1) of a rectangle.
    Rectangle([u32; 4]),
    /// Nodes of a triangle.
    Triangle([u32; 3]),
}

impl CellCorners {
    /// The nodes.
    pub fn nodes(&self) -> &[u32] {
        match self {
            Self::Rectangle(nodes) => nodes,
            Self::Triangle(nodes) => nodes,
        }
    }
}

impl OpenCells {
    /// Closed cells of a sheet with `columns` by `rows` nodes in its lowest layer.
    pub fn closed(columns: usize, rows: usize) -> Self {
        let (columns, rows) = (columns.saturating_sub(1), rows.saturating_sub(1));
        Self { columns, rows, open: vec![false; columns * rows], count: 0, triangles: None }
    }

    /// Closed cells of a sheet whose lowest layer is a triangle mesh.
    pub fn closed_triangles(triangles: TriangleCells) -> Self {
        let columns = triangles.mesh().triangles.len();
        Self { columns, rows: 1, open: vec![false; columns], count: 0, triangles: Some(Box::new(triangles)) }
    }

    /// Cells along u and along v; of a mesh, its triangles and 1.
    pub fn size(&self) -> (usize, usize) {
        (self.columns, self.rows)
    }

    /// The triangles; `None` for rectangles.
    pub fn triangles(&self) -> Option<&TriangleCells> {
        self.triangles.as_deref()
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

    /// Finds the slopes of a triangle mesh that the open cells free, before elements use them.
    pub fn update_slopes(&mut self) {
        if let Some(triangles) = &mut self.triangles {
            triangles.update_slopes(&self.open);
        }
    }

    /// Corners of cell `cell`; the nodes of the lowest layer have the first numbers.
    #[inline]
    pub fn corners(&self, cell: usize) -> CellCorners {
        match &self.triangles {
            None => CellCorners::Rectangle(rectangle(self.columns, cell)),
            Some(triangles) => CellCorners::Triangle(triangles.mesh().triangles[cell]),
        }
    }

    /// Visits the cells that share a node with cell `cell`; some more than once.
    pub fn visit_neighbours(&self, cell: usize, visit: &mut dyn FnMut(usize)) {
        if let Some(triangles) = &self.triangles {
            let around = triangles.mesh().triangles[cell].into_iter().flat_map(|v| triangles.around(v));
            return around.map(|k| *k as usize).filter(|k| *k != cell).for_each(visit);
        }
        let (i, j) = ((cell % self.columns) as i64, (cell / self.columns) as i64);
        let around = (-1..=1).flat_map(|dj| (-1..=1).map(move |di| (di, dj))).filter(|d| *d != (0, 0));
        around.filter_map(|(di, dj)| self.cell_index(i + di, j + dj)).for_each(visit);
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

    /// Place in the sheet of material coordinates (u, v), 0 to 1.
    pub fn place(&self, (u, v): (f64, f64)) -> (f64, f64) {
        match &self.triangles {
            None => (u * self.columns as f64, v * self.rows as f64),
            Some(triangles) => triangles.place((u, v)),
        }
    }

    /// Index of a cell at the place `at`, the first of several; `None` outside the sheet.
    pub fn cell_at(&self, at: (f64, f64)) -> Option<usize> {
        match &self.triangles {
            None => self.cell_index(at.0.floor() as i64, at.1.floor() as i64),
            Some(triangles) => triangles.at(at).next(),
        }
    }

    /// Whether a closed cell lies at the place (u, v). A place on a side of triangles is in both.
    pub fn is_closed_at(&self, u: f64, v: f64) -> bool {
        match &self.triangles {
            None => self.is_closed(u.floor() as i64, v.floor() as i64),
            Some(triangles) => triangles.at((u, v)).any(|k| !self.open[k]),
        }
    }

    /// Distance from a line or a point at which cells are tested.
    fn side_offset(&self) -> f64 {
        SIDE_OFFSET * self.triangles.as_ref().map_or(1.0, |t| t.side())
    }

    /// Whether no closed cell touches the place (u, v).
    pub fn is_gone(&self, (u, v): (f64, f64)) -> bool {
        let d = self.side_offset();
        let around = [(-d, -d), (d, -d), (-d, d), (d, d)];
        !around.iter().any(|(du, dv)| self.is_closed_at(u + du, v + dv))
    }

    /// Whether no closed cell touches `node` at the place `at`.
    pub fn is_node_gone(&self, node: u32, at: (f64, f64)) -> bool {
        match self.triangles.as_ref().map(|t| t.around(node)) {
            Some(around) if !around.is_empty() => around.iter().all(|k| self.open[*k as usize]),
            _ => self.is_gone(at),
        }
    }

    /// Whether a spring or side between two nodes, each with its place, is cut.
    pub fn is_side_cut(&self, (a, from): (u32, (f64, f64)), (b, to): (u32, (f64, f64))) -> bool {
        if let Some(triangles) = &self.triangles {
            let beside = |k: &&u32| triangles.mesh().triangles[**k as usize].contains(&b);
            let mut beside = triangles.around(a).iter().filter(beside).peekable();
            if beside.peek().is_some() {
                return beside.all(|k| self.open[*k as usize]);
            }
        }
        self.is_spring_cut(from, to)
    }

    /// Whether a spring between the places `a` and `b` is cut.
    pub fn is_spring_cut(&self, a: (f64, f64), b: (f64, f64)) -> bool {
        let (du, dv) = (b.0 - a.0, b.1 - a.1);
        let (length, offset) = (du.hypot(dv), self.side_offset());
        if length < offset {
            return self.is_gone(a);
        }
        let beside = (-dv / length * offset, du / length * offset);
        let held = |s: f64| {
            let (u, v) = (a.0 + s * du, a.1 + s * dv);
            self.is_closed_at(u + beside.0, v + beside.1) || self.is_closed_at(u - beside.0, v - beside.1)
        };
        !(held(0.25) && held(0.75))
    }
}

/// Corners of cell `cell` of a grid with `columns` cells in a row.
#[inline]
pub fn rectangle(columns: usize, cell: usize) -> [u32; 4] {
    let first = (cell / columns) * (columns + 1) + cell % columns;
    [first, first + 1, first + columns + 1, first + columns + 2].map(|node| node as u32)
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

    #[test]
    fn sides_of_triangles_are_cut_by_their_own_triangles() {
        // A square of four triangles around its middle; node 5 is at the place of node 0 on the
        // other side of a cut, with a triangle of its own.
        let positions =
            vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0], [0.0, 0.0], [-2.0, 0.0], [0.0, 2.0]];
        let triangles = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [5, 7, 6]];
        let mesh = crate::mesh::outline::TriangleMesh::new(positions, triangles).expect("a mesh");
        let mut open = OpenCells::closed_triangles(TriangleCells::new(std::sync::Arc::new(mesh), false));
        let corner = (0.0, 0.0);
        open.set(0);
        assert!(open.is_side_cut((0, corner), (1, (2.0, 0.0))) && !open.is_side_cut((0, corner), (4, (1.0, 1.0))));
        assert!(!open.is_node_gone(0, corner) && open.is_closed_at(1.0, 1.5) && !open.is_closed_at(1.0, 0.5));
        // Second neighbours through the middle keep a closed side on each half.
        assert!(!open.is_spring_cut(corner, (2.0, 2.0)));
        open.set(3);
        assert!(open.is_node_gone(0, corner) && !open.is_node_gone(5, corner));
        assert!(open.is_side_cut((0, corner), (3, (0.0, 2.0))) && !open.is_side_cut((5, corner), (7, (0.0, 2.0))));
        assert!(open.is_spring_cut(corner, (2.0, 2.0)));
        let mut near = Vec::new();
        open.visit_neighbours(4, &mut |k| near.push(k));
        assert!(near.is_empty(), "{near:?}: a cut separates");
        open.visit_neighbours(0, &mut |k| near.push(k));
        assert!([1, 2, 3].iter().all(|k| near.contains(k)));
    }
}
