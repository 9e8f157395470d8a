//! Initial curvature of a sheet: creases and curl as rest curvatures of its curvature groups, in
//! 1/m.
//!
//! A crease with the angle θ along a line with the normal n is the curvature θ δ(line) n⊗n. On a
//! grid, each point of the line is distributed to the surrounding nodes by their bilinear weights
//! N,
//!
//!   k_uu = θ n_u² ∫ N ds / S, k_vv = θ n_v² ∫ N ds / S, 2 k_uv = 2 θ n_u n_v ∫ ds / S in a cell,
//!
//! with S the area of the node or of the cell, so that the angles across any row of nodes sum to θ.
//! On triangles, whose curvature stencil spans several triangles, it is the curvature of a fold
//! with the slope θ on one side of the line, along a parabola three cells wide.

use crate::elements::curvature::CurvatureGroup;
use crate::mesh::outline::TriangleMesh;
use crate::scene::{CreaseSpec, SheetSpec};
use crate::sheet::surface::CreaseLines;

/// Line from `a` to `b` (m) with its unit normal and its angle (rad).
#[derive(Clone, Copy)]
struct CreaseLine {
    a: [f64; 2],
    b: [f64; 2],
    n: [f64; 2],
    angle: f64,
}

impl CreaseLine {
    fn new(crease: &CreaseSpec, place: impl Fn((f64, f64)) -> [f64; 2]) -> Option<Self> {
        let (a, b) = (place(crease.from), place(crease.to));
        let d = [b[0] - a[0], b[1] - a[1]];
        let length = d[0].hypot(d[1]);
        (length > 0.0).then(|| Self { a, b, n: [-d[1] / length, d[0] / length], angle: crease.angle.to_radians() })
    }

    /// n⊗n as (uu, vv, 2uv), times the angle.
    fn tensor(&self) -> [f64; 3] {
        let [u, v] = self.n;
        [u * u * self.angle, v * v * self.angle, 2.0 * u * v * self.angle]
    }

    /// Parameter range, within 0 to 1, of the part of the line with c·x ≤ d for each of `planes`
    /// (c, d).
    fn within(&self, planes: &[([f64; 2], f64)]) -> Option<(f64, f64)> {
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        for (c, d) in planes {
            let at = |p: [f64; 2]| c[0] * p[0] + c[1] * p[1] - d;
            let (from, to) = (at(self.a), at(self.b));
            let cut = from / (from - to);
            match (from <= 0.0, to <= 0.0) {
                (true, true) => {}
                (true, false) => high = high.min(cut),
                (false, true) => low = low.max(cut),
                (false, false) => return None,
            }
        }
        (high > low).then_some((low, high))
    }

    /// The line with half its angle, moved along its normal by `by` (m).
    fn half(&self, by: f64) -> Self {
        let moved = |p: [f64; 2]| [0, 1].map(|i| p[i] + by * self.n[i]);
        Self { a: moved(self.a), b: moved(self.b), angle: 0.5 * self.angle, ..*self }
    }

    /// Distance of `p` from the line along its normal (m), and the parameter along the line, 0 to
    /// 1.
    fn beside(&self, p: [f64; 2]) -> (f64, f64) {
        let (d, length) = ([p[0] - self.a[0], p[1] - self.a[1]], self.length());
        let along = (d[0] * (self.b[0] - self.a[0]) + d[1] * (self.b[1] - self.a[1])) / (length * length);
        (d[0] * self.n[0] + d[1] * self.n[1], along)
    }

    fn at(&self, s: f64) -> [f64; 2] {
        [0, 1].map(|i| self.a[i] + s * (self.b[i] - self.a[i]))
    }

    fn length(&self) -> f64 {
        (self.b[0] - self.a[0]).hypot(self.b[1] - self.a[1])
    }
}

fn rectangle(low: [f64; 2], high: [f64; 2]) -> [([f64; 2], f64); 4] {
    [([-1.0, 0.0], -low[0]), ([1.0, 0.0], high[0]), ([0.0, -1.0], -low[1]), ([0.0, 1.0], high[1])]
}

/// Relative distance within which a line coincides with a row of nodes or with the border.
const ALIGNMENT_TOLERANCE: f64 = 1e-6;

/// Width of a crease on triangles, in cells.
const CREASE_WIDTH_CELLS: f64 = 3.0;

/// Whether the sheet has creases or curl.
pub(crate) fn has_initial_curvature(spec: &SheetSpec) -> bool {
    !spec.creases.is_empty() || spec.curl != (0.0, 0.0)
}

/// Columns and rows of nodes along which a rectangular sheet is creased from edge to edge.
pub(crate) fn folds(spec: &SheetSpec) -> CreaseLines {
    let outlined = spec.outline.is_some() || !spec.holes.is_empty() || !spec.cuts.is_empty();
    let mut folds = CreaseLines::default();
    for CreaseSpec { from, to, .. } in spec.creases.iter().filter(|_| !outlined) {
        let across = |a: f64, b: f64| a.min(b) < ALIGNMENT_TOLERANCE && a.max(b) > 1.0 - ALIGNMENT_TOLERANCE;
        let mass = |at: f64, n: u32| {
            let place = at * f64::from(n - 1);
            let near = (place - place.round()).abs() < ALIGNMENT_TOLERANCE
                && place.round() > 0.0
                && place.round() < f64::from(n - 1);
            near.then_some(place.round() as u32)
        };
        if (from.0 - to.0).abs() < ALIGNMENT_TOLERANCE && across(from.1, to.1) {
            folds.columns.extend(mass(from.0, spec.grid.0));
        } else if (from.1 - to.1).abs() < ALIGNMENT_TOLERANCE && across(from.0, to.0) {
            folds.rows.extend(mass(from.1, spec.grid.2));
        }
    }
    folds.columns.sort_unstable();
    folds.rows.sort_unstable();
    folds
}

fn curl_curvature(spec: &SheetSpec, group: &CurvatureGroup) -> [f64; 3] {
    // A group without a curvature component has no curl in it.
    let known = |a: usize| !group.rows[a].is_empty() || !group.relaxed.is_empty();
    [if known(0) { spec.curl.0 } else { 0.0 }, if known(1) { spec.curl.1 } else { 0.0 }, 0.0]
}

/// Rest curvatures of the groups of a grid of `columns` by `rows` nodes, `spacing` (m) apart.
pub(crate) fn on_grid(
    spec: &SheetSpec,
    source: &[CurvatureGroup],
    (columns, rows): (usize, usize),
    spacing: (f64, f64),
) -> Vec<[f64; 3]> {
    let grid = CreaseGrid { counts: [columns, rows], spacing: [spacing.0, spacing.1] };
    let place = |(u, v): (f64, f64)| [u * spec.size.0, v * spec.size.1];
    // A line along a row of nodes is split between the cells of both sides.
    let aside = |line: CreaseLine| [-1.0, 1.0].map(|side| line.half(1e-9 * side * spacing.0.min(spacing.1)));
    let lines: Vec<CreaseLine> =
        spec.creases.iter().filter_map(|c| CreaseLine::new(c, place)).flat_map(aside).collect();
    let each = source.iter().map(|group| {
        let mut angles = curl_curvature(spec, group);
        for line in &lines {
            let t = line.tensor();
            if group.rows[0].is_empty() && group.rows[1].is_empty() {
                angles[2] += t[2] * grid.in_cell(line, group.home as usize);
            } else {
                for axis in (0..2).filter(|a| !group.rows[*a].is_empty()) {
                    angles[axis] += t[axis] * grid.at_mass(line, group.home as usize, axis);
                }
            }
        }
        angles
    });
    each.collect()
}

/// Rest curvatures of the triangles of a mesh, in their order. A fold is as wide as on the mesh
/// `base`, of which `mesh` may be a refinement.
pub(crate) fn on_mesh(
    spec: &SheetSpec,
    source: &[CurvatureGroup],
    mesh: &TriangleMesh,
    base: &TriangleMesh,
) -> Vec<[f64; 3]> {
    let bound = |i: usize, start: f64, pick: fn(f64, f64) -> f64| mesh.positions.iter().map(|p| p[i]).fold(start, pick);
    let low = [0, 1].map(|i| bound(i, f64::INFINITY, f64::min));
    let high = [0, 1].map(|i| bound(i, f64::NEG_INFINITY, f64::max));
    let place = |(u, v): (f64, f64)| [low[0] + u * (high[0] - low[0]), low[1] + v * (high[1] - low[1])];
    let lines: Vec<CreaseLine> = spec.creases.iter().filter_map(|c| CreaseLine::new(c, place)).collect();
    // The fold extends over several cells, because one triangle represents only a small rotation.
    let cell = (2.0 * base.areas.iter().sum::<f64>() / base.areas.len().max(1) as f64).sqrt();
    let reach = 0.5 * CREASE_WIDTH_CELLS * cell;
    let each = source.iter().enumerate().map(|(k, group)| {
        let mut angles = curl_curvature(spec, group);
        let corners = mesh.triangles[k].map(|v| mesh.positions[v as usize]);
        let middle = [0, 1].map(|i| (corners[0][i] + corners[1][i] + corners[2][i]) / 3.0);
        for line in &lines {
            let (beside, along) = line.beside(middle);
            if !(0.0..=1.0).contains(&along) {
                continue;
            }
            // The side of this triangle is flat, and the other side of the line rises from it,
            // first along a parabola.
            let rise = |v: u32| {
                let beyond = -line.beside(mesh.positions[v as usize]).0 * beside.signum();
                if beyond >= reach { beyond } else { (beyond + reach).max(0.0).powi(2) / (4.0 * reach) }
            };
            for (a, row) in group.rows.iter().enumerate() {
                angles[a] += line.angle * row.iter().map(|(v, w)| w * rise(*v)).sum::<f64>();
            }
        }
        angles
    });
    each.collect()
}

struct CreaseGrid {
    counts: [usize; 2],
    spacing: [f64; 2],
}

impl CreaseGrid {
    fn place(&self, home: usize) -> [usize; 2] {
        [home % self.counts[0], home / self.counts[0]]
    }

    /// ∫ ds / S in the cell whose first node is `home`.
    fn in_cell(&self, line: &CreaseLine, home: usize) -> f64 {
        let at = self.place(home);
        let low = [0, 1].map(|i| at[i] as f64 * self.spacing[i]);
        let high = [0, 1].map(|i| low[i] + self.spacing[i]);
        let inside = line.within(&rectangle(low, high)).map_or(0.0, |(low, high)| (high - low) * line.length());
        inside / (self.spacing[0] * self.spacing[1])
    }

    /// ∫ N ds / S of the node `home` for the curvature along `axis`. A border node has no curvature
    /// across the border, so its share goes to the next node.
    fn at_mass(&self, line: &CreaseLine, home: usize, axis: usize) -> f64 {
        let at = self.place(home);
        let last = [self.counts[0] - 1, self.counts[1] - 1];
        let inner = (at[axis] == 1, at[axis] + 1 == last[axis]);
        if at[axis] == 0 || at[axis] == last[axis] {
            return 0.0;
        }
        let weight = |p: [f64; 2]| {
            let one = |i: usize| {
                let t = p[i] / self.spacing[i] - at[i] as f64;
                let beyond = i == axis && ((inner.0 && t < 0.0) || (inner.1 && t > 0.0));
                if beyond { 1.0 } else { (1.0 - t.abs()).max(0.0) }
            };
            one(0) * one(1)
        };
        let mut sum = 0.0;
        for part in 0..4_usize {
            // The weight is bilinear in each of the four cells around, so Simpson's rule is exact.
            let mut low = [0.0; 2];
            let mut high = [0.0; 2];
            let mut there = true;
            for i in 0..2 {
                let ahead = (part >> i) & 1;
                there &= if ahead == 1 { at[i] < last[i] } else { at[i] > 0 };
                low[i] = (at[i] as f64 - 1.0 + ahead as f64) * self.spacing[i];
                high[i] = low[i] + self.spacing[i];
            }
            if let Some((from, to)) = line.within(&rectangle(low, high)).filter(|_| there) {
                let ends = weight(line.at(from)) + weight(line.at(to));
                sum += (to - from) * line.length() * (ends + 4.0 * weight(line.at(0.5 * (from + to)))) / 6.0;
            }
        }
        let across = 1 - axis;
        let share = if at[across] == 0 || at[across] == last[across] { 0.5 } else { 1.0 };
        sum / (self.spacing[0] * self.spacing[1] * share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::staggered::{StaggeredGrid, curvatures};

    /// Angle across each row of nodes along u, of a sheet of 0.3 m by 0.2 m.
    fn across_rows(crease: CreaseSpec, columns: usize, rows: usize) -> Vec<f64> {
        let spec = SheetSpec { size: (0.3, 0.2), creases: vec![crease], ..SheetSpec::thesis() };
        let spacing = (0.3 / (columns - 1) as f64, 0.2 / (rows - 1) as f64);
        let clamped = vec![false; columns * rows];
        let source = curvatures(&StaggeredGrid { columns, rows, spacing, clamped: &clamped });
        let angles = on_grid(&spec, &source, (columns, rows), spacing);
        let mut sums = vec![0.0; rows];
        for (group, k) in source.iter().zip(angles).filter(|(g, _)| !g.rows[0].is_empty()) {
            sums[group.home as usize / columns] += k[0] * spacing.0;
        }
        sums
    }

    #[test]
    fn a_crease_across_the_sheet_has_its_full_angle_in_every_row_on_any_grid() {
        for u in [0.5, 0.37, 0.02, 0.99] {
            for columns in [4, 7, 11, 40] {
                let crease = CreaseSpec { from: (u, 0.0), to: (u, 1.0), angle: 80.0 };
                for sum in across_rows(crease, columns, 6) {
                    assert!((sum.to_degrees() - 80.0).abs() < 1e-9, "{u} {columns}: {}", sum.to_degrees());
                }
            }
        }
    }

    #[test]
    fn a_slanting_crease_has_its_normal_component_in_every_row() {
        // From (0.06, 0) to (0.24, 0.2) m: n_u² = 0.2²/(0.18² + 0.2²), and each row is crossed over
        // 1/|n_u| of its width.
        let crease = CreaseSpec { from: (0.2, 0.0), to: (0.8, 1.0), angle: 30.0 };
        let nu = 0.2 / 0.18_f64.hypot(0.2);
        for sum in across_rows(crease, 13, 9) {
            assert!((sum.to_degrees() / (30.0 * nu) - 1.0).abs() < 1e-9, "{}", sum.to_degrees());
        }
    }
}
