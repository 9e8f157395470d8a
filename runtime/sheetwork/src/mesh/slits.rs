//! Slits: cells that are open initially, along lines of the sheet.
//!
//! A line in (u, v) opens every cell of the lowest layer that it crosses by more than a thousandth
//! of a cell. A line along a row of nodes opens the cells on its far side, at the end of the sheet
//! the cells before it. No node is split: a strip one cell wide is lost, as in any fracture. A slit
//! grows only if the sheet can fracture.
//!
//! Among triangles the line is moved to its far side by a few thousandths of a cell, so that one
//! through nodes opens a strip of triangles with common sides, and does not hang on single nodes.

use crate::mesh::outline::TriangleMesh;

/// Minimum length of a line in a cell that opens it, cells.
const MIN_CROSSED_LENGTH: f64 = 1e-3;

/// Distance by which a line among triangles is moved to its far side, cells.
const FAR_SIDE_OFFSET: f64 = 4e-3;

/// Line from (u, v) to (u, v), each 0 to 1.
pub type Slit = ((f64, f64), (f64, f64));

/// Indices of the cells of a grid of `columns` by `rows` that `slit` crosses, in its order.
pub fn crossed((columns, rows): (usize, usize), (from, to): Slit) -> Vec<usize> {
    let (nu, nv) = (columns as f64, rows as f64);
    let (a, b) = ((from.0 * nu, from.1 * nv), (to.0 * nu, to.1 * nv));
    let (du, dv) = (b.0 - a.0, b.1 - a.1);
    let length = du.hypot(dv);
    // Parameters at which the line changes column or row.
    let mut breaks = vec![0.0, 1.0];
    for (start, d, count) in [(a.0, du, columns), (a.1, dv, rows)] {
        if d != 0.0 {
            breaks.extend((0..=count).map(|k| (k as f64 - start) / d).filter(|s| (0.0..=1.0).contains(s)));
        }
    }
    breaks.sort_by(f64::total_cmp);
    let mut cells: Vec<usize> = Vec::new();
    for pair in breaks.windows(2) {
        if (pair[1] - pair[0]) * length < MIN_CROSSED_LENGTH {
            continue;
        }
        let s = 0.5 * (pair[0] + pair[1]);
        let at = |start: f64, d: f64, count: usize| ((start + s * d).floor().max(0.0) as usize).min(count.max(1) - 1);
        let cell = at(a.1, dv, rows) * columns + at(a.0, du, columns);
        if columns > 0 && rows > 0 && cells.last() != Some(&cell) {
            cells.push(cell);
        }
    }
    cells
}

/// Indices of the triangles of `mesh` that a line between two places (m) crosses, ascending; `cell`
/// is the size of a triangle, m. A line along the far border opens the triangles before it.
pub fn crossed_triangles(mesh: &TriangleMesh, (from, to): ((f64, f64), (f64, f64)), cell: f64) -> Vec<usize> {
    let (du, dv) = (to.0 - from.0, to.1 - from.1);
    let length = du.hypot(dv);
    if length < MIN_CROSSED_LENGTH * cell {
        return Vec::new();
    }
    // The far side is that of larger v, or of larger u for a line along v.
    let sign = if du > 0.0 || (du == 0.0 && dv < 0.0) { 1.0 } else { -1.0 };
    let normal = (-dv / length * sign, du / length * sign);
    let beside = |offset: f64| -> Vec<usize> {
        let start = [from.0 + normal.0 * offset, from.1 + normal.1 * offset];
        let is_crossed = |k: &usize| {
            let corners = mesh.triangles[*k].map(|v| mesh.positions[v as usize]);
            length_inside(corners, start, [du, dv]) * length > MIN_CROSSED_LENGTH * cell
        };
        (0..mesh.triangles.len()).filter(is_crossed).collect()
    };
    let far = beside(FAR_SIDE_OFFSET * cell);
    if far.is_empty() { beside(-FAR_SIDE_OFFSET * cell) } else { far }
}

/// Part of the line from `start` along `d` that lies in a triangle, counter-clockwise in (u, v).
fn length_inside(corners: [[f64; 2]; 3], start: [f64; 2], d: [f64; 2]) -> f64 {
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for c in 0..3 {
        let (p, q) = (corners[c], corners[(c + 1) % 3]);
        let side = [q[0] - p[0], q[1] - p[1]];
        let across = |v: [f64; 2]| side[0] * v[1] - side[1] * v[0];
        // The line is inside this side where here + s change >= 0.
        let (here, change) = (across([start[0] - p[0], start[1] - p[1]]), across(d));
        if change > 0.0 {
            low = low.max(-here / change);
        } else if change < 0.0 {
            high = high.min(-here / change);
        } else if here < 0.0 {
            return 0.0;
        }
    }
    (high - low).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_opens_the_cells_that_it_passes_through() {
        // Four columns, three rows.
        let cells = |from, to| crossed((4, 3), (from, to));
        assert_eq!(cells((0.1, 0.5), (0.9, 0.5)), [4, 5, 6, 7], "along the middle row");
        assert_eq!(cells((0.9, 0.5), (0.1, 0.5)), [7, 6, 5, 4], "and back");
        assert_eq!(cells((0.3, 0.0), (0.3, 1.0)), [1, 5, 9], "across");
        assert_eq!(cells((0.0, 0.0), (1.0, 1.0)).len(), 6, "askew: 4 + 3 - 1");
        assert_eq!(cells((0.25, 0.0), (0.25, 0.2)), [1], "along a row of masses: the far side");
        assert_eq!(cells((1.0, 0.0), (1.0, 0.2)), [3], "at the end the last");
        assert!(cells((0.5, 0.5), (0.5, 0.5)).is_empty(), "a point is no line");
    }

    #[test]
    fn a_line_through_nodes_opens_a_strip_of_triangles() {
        // Two by two squares of side 1, each of two triangles.
        let positions = (0..9).map(|i| [f64::from(i % 3), f64::from(i / 3)]).collect();
        let square = |i: u32| [[i, i + 1, i + 3], [i + 1, i + 4, i + 3]];
        let mesh = TriangleMesh::new(positions, [0, 1, 3, 4].into_iter().flat_map(square).collect()).expect("a mesh");
        let cells = |from, to| crossed_triangles(&mesh, (from, to), 1.0);
        assert_eq!(cells((0.0, 1.0), (2.0, 1.0)), [4, 5, 6, 7], "along a row of nodes: the far side");
        assert_eq!(cells((2.0, 1.0), (0.0, 1.0)), [4, 5, 6, 7], "and back");
        assert_eq!(cells((0.0, 2.0), (2.0, 2.0)), [4, 5, 6, 7], "along the far border: the triangles before it");
        assert_eq!(cells((0.1, 0.2), (0.3, 0.2)), [0]);
        assert_eq!(cells((0.0, 0.0), (2.0, 2.0)), [0, 1, 4, 5, 6, 7], "through the middle node");
        assert!(cells((0.5, 0.5), (0.5, 0.5)).is_empty(), "a point is no line");
    }
}
