//! Curvatures of a rectangular grid by central differences, each at the point where it has
//! second-order accuracy: x_uu and x_vv at nodes, x_uv at cell centres.
//!
//! At a clamped node the curvature towards a free neighbour is one-sided, 2 (x₁ - x₀ - h t)/h²,
//! with t the direction that the clamp prescribes: the sheet continues as a mirror image behind the
//! clamp. This alone leaves a second-order error at the clamp. The area factors 6/5 at the clamp
//! and 12/13 in the next row (Gregory's end-corrected quadrature for a parabolic curvature) remove
//! most of it. Across a free edge the curvature is relaxed (natural boundary condition: no moment).

use crate::elements::curvature::CurvatureGroup;
use crate::elements::fracture::OpenCells;

/// Area factor of the curvature at a clamp.
const CLAMP_AREA_FACTOR: f64 = 6.0 / 5.0;
/// Area factor of the curvature one row from a clamp.
const SECOND_ROW_AREA_FACTOR: f64 = 12.0 / 13.0;

/// A rectangular grid of nodes.
pub struct StaggeredGrid<'a> {
    /// Nodes along u, contiguous in memory.
    pub columns: usize,
    /// Nodes along v.
    pub rows: usize,
    /// Spacings along u and v, m.
    pub spacing: (f64, f64),
    /// Whether each node is clamped: fixed position and slope.
    pub clamped: &'a [bool],
}

/// Curvatures of the grid. Prescribed slopes refer to directions 0 (u) and 1 (v).
pub fn curvatures(grid: &StaggeredGrid) -> Vec<CurvatureGroup> {
    let mut groups = Vec::new();
    for j in 0..grid.rows {
        for i in 0..grid.columns {
            if grid.clamped[grid.at(i, j)] {
                grid.clamps(i, j, &mut groups);
            } else {
                groups.extend(grid.at_mass(i, j));
            }
        }
    }
    for j in 0..grid.rows - 1 {
        for i in 0..grid.columns - 1 {
            groups.push(grid.twist(i, j));
        }
    }
    // A group of clamped nodes alone is constant.
    let moves = |g: &CurvatureGroup| g.rows.iter().flatten().any(|(m, _)| !grid.clamped[*m as usize]);
    groups.retain(moves);
    groups
}

/// Part of a group that remains beside open cells; its stencil does not change.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedPart {
    /// Area that it represents, m².
    pub area: f64,
    /// Relaxed directions of curvature.
    pub relaxed: Vec<[f64; 3]>,
    /// Nodes that give the normal.
    pub frame: [u32; 4],
}

impl ClosedPart {
    /// The whole of `group`.
    pub fn from_group(group: &CurvatureGroup) -> Self {
        Self { area: group.area, relaxed: group.relaxed.clone(), frame: group.frame }
    }

    /// The part that remains of it beside `open` cells; `group` belongs to a grid of `columns`
    /// nodes along u.
    ///
    /// A node has a curvature along a line where two neighbouring cells along it are closed; each
    /// closed cell carries a share of its area. The edge of the open cells has no moment, as a free
    /// edge has none. Opening cells therefore never raises the energy.
    pub fn closed_part(&self, group: &CurvatureGroup, columns: usize, open: &OpenCells) -> Self {
        let (i, j) = ((group.home as usize % columns) as i64, (group.home as usize / columns) as i64);
        let is_twist = group.rows[0].is_empty() && group.rows[1].is_empty();
        if is_twist {
            let area = if open.is_closed(i, j) { self.area } else { 0.0 };
            return Self { area, ..self.clone() };
        }
        let cells = [(i - 1, j - 1), (i, j - 1), (i - 1, j), (i, j)];
        let [sw, se, nw, ne] = cells.map(|(i, j)| open.is_closed(i, j));
        if let Some(axis) = (0..2).find(|a| !group.clamps[*a].is_empty()) {
            return self.clamp(group, axis, [sw, se, nw, ne], cells, open);
        }
        let there = |all: &[bool]| all.iter().filter(|c| **c).count() as f64;
        let all = cells.map(|(i, j)| open.cell_index(i, j).is_some());
        let known = [(sw && se) || (nw && ne), (sw && nw) || (se && ne)];
        let mut left = self.clone();
        left.area *= there(&[sw, se, nw, ne]) / there(&all);
        for (axis, direction) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].into_iter().enumerate() {
            if !known[axis] && !left.relaxed.contains(&direction) {
                left.relaxed.push(direction);
            }
        }
        if !(0..2).any(|a| known[a] && !group.rows[a].is_empty()) {
            left.area = 0.0;
        }
        left.frame = self.frame(group.home, [sw, se, nw, ne]);
        left
    }

    /// Frame nodes that closed cells connect to the node `home`, and `home` in place of the others:
    /// nodes beyond an open cell do not determine the normal.
    fn frame(&self, home: u32, [sw, se, nw, ne]: [bool; 4]) -> [u32; 4] {
        let joined = [sw || se, nw || ne, sw || nw, se || ne];
        std::array::from_fn(|k| if joined[k] { self.frame[k] } else { home })
    }

    /// Remaining part of a group at a clamped node, which has the curvature towards one neighbour
    /// along `axis`.
    fn clamp(
        &self,
        group: &CurvatureGroup,
        axis: usize,
        closed: [bool; 4],
        cells: [(i64, i64); 4],
        open: &OpenCells,
    ) -> Self {
        let after = group.rows[axis].iter().any(|(m, w)| *m > group.home && *w > 0.0);
        let beside = match (axis, after) {
            (0, false) => [0, 2],
            (0, true) => [1, 3],
            (_, false) => [0, 1],
            (_, true) => [2, 3],
        };
        let there = beside.iter().filter(|c| open.cell_index(cells[**c].0, cells[**c].1).is_some()).count();
        let left = beside.iter().filter(|c| closed[**c]).count();
        let area = self.area * left as f64 / there.max(1) as f64;
        Self { area, frame: self.frame(group.home, closed), relaxed: self.relaxed.clone() }
    }
}

impl StaggeredGrid<'_> {
    fn at(&self, i: usize, j: usize) -> usize {
        j * self.columns + i
    }

    /// Along axis 0 (u) or 1 (v): the nodes before and after (i, j), the spacing (m), and the width
    /// of the node's area across, in cells.
    fn line(&self, axis: usize, i: usize, j: usize) -> (Option<usize>, Option<usize>, f64, f64) {
        let half = |k: usize, n: usize| if k == 0 || k + 1 == n { 0.5 } else { 1.0 };
        if axis == 0 {
            let before = (i > 0).then(|| self.at(i - 1, j));
            let after = (i + 1 < self.columns).then(|| self.at(i + 1, j));
            (before, after, self.spacing.0, half(j, self.rows))
        } else {
            let before = (j > 0).then(|| self.at(i, j - 1));
            let after = (j + 1 < self.rows).then(|| self.at(i, j + 1));
            (before, after, self.spacing.1, half(i, self.columns))
        }
    }

    /// Four nodes around (i, j) whose differences span the tangent plane.
    fn frame(&self, i: usize, j: usize) -> [u32; 4] {
        let (west, east) = (i.saturating_sub(1), (i + 1).min(self.columns - 1));
        let (back, front) = (j.saturating_sub(1), (j + 1).min(self.rows - 1));
        // v × u points to the upper side: u along x, v along z.
        [self.at(i, back), self.at(i, front), self.at(west, j), self.at(east, j)].map(|m| m as u32)
    }

    fn at_mass(&self, i: usize, j: usize) -> Option<CurvatureGroup> {
        let here = self.at(i, j);
        let mut group = CurvatureGroup { frame: self.frame(i, j), home: here as u32, ..CurvatureGroup::default() };
        let mut shares = [0.0; 2];
        for axis in 0..2 {
            let (before, after, h, across) = self.line(axis, i, j);
            let (Some(before), Some(after)) = (before, after) else { continue };
            let next = self.clamped[before] || self.clamped[after];
            group.gain[axis] = if next { SECOND_ROW_AREA_FACTOR.sqrt() } else { 1.0 };
            group.span[axis] = h;
            let w = group.gain[axis] / (h * h);
            group.rows[axis] = vec![(before as u32, w), (here as u32, -2.0 * w), (after as u32, w)];
            shares[axis] = across;
        }
        let cell = self.spacing.0 * self.spacing.1;
        let known = [!group.rows[0].is_empty(), !group.rows[1].is_empty()];
        match known {
            [false, false] => return None,
            [true, true] => group.area = cell,
            [true, false] => {
                group.area = cell * shares[0];
                group.relaxed.push([0.0, 1.0, 0.0]);
            }
            [false, true] => {
                group.area = cell * shares[1];
                group.relaxed.push([1.0, 0.0, 0.0]);
            }
        }
        Some(group)
    }

    fn clamps(&self, i: usize, j: usize, groups: &mut Vec<CurvatureGroup>) {
        let here = self.at(i, j);
        for axis in 0..2 {
            let (before, after, h, across) = self.line(axis, i, j);
            for (neighbour, side) in [(before, -1.0), (after, 1.0)] {
                let Some(neighbour) = neighbour.filter(|n| !self.clamped[*n]) else { continue };
                let w = 2.0 / (h * h);
                let mut group =
                    CurvatureGroup { frame: self.frame(i, j), home: here as u32, ..CurvatureGroup::default() };
                // From the clamp's direction to the middle of the first cell the sheet turns by
                // half of the angle of a whole cell.
                group.span[axis] = 0.5 * h;
                group.rows[axis] = vec![(neighbour as u32, w), (here as u32, -w)];
                group.clamps[axis] = vec![(axis as u32, -side * 2.0 / h)];
                group.area = 0.5 * CLAMP_AREA_FACTOR * across * self.spacing.0 * self.spacing.1;
                groups.push(group);
            }
        }
    }

    fn twist(&self, i: usize, j: usize) -> CurvatureGroup {
        let (hu, hv) = self.spacing;
        let w = 2.0 / (hu * hv);
        let m = [self.at(i, j), self.at(i + 1, j), self.at(i, j + 1), self.at(i + 1, j + 1)].map(|m| m as u32);
        let row = vec![(m[0], w), (m[1], -w), (m[2], -w), (m[3], w)];
        CurvatureGroup {
            rows: [Vec::new(), Vec::new(), row],
            area: hu * hv,
            // The diagonals: of the order of the sides, and never parallel in a valid cell.
            frame: [m[1], m[2], m[0], m[3]],
            home: m[0],
            ..CurvatureGroup::default()
        }
    }
}
