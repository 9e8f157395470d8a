//! The free edge of a sheet, opposite its clamp: mean position and corners.

use glam::DVec3;

use sheetwork::math::Vectors;
use sheetwork::sheet::Sheet;

/// Positions on the edge at u = 1 of the bottom layer, m.
pub(crate) struct FreeEdge {
    /// Mean over the edge. The two corner nodes have half the weight of the others.
    pub middle: DVec3,
    /// Mean of the two corners.
    pub corners: DVec3,
}

impl FreeEdge {
    /// The edge of `sheet` with its nodes at `x`. The rows of a triangular layer end at two
    /// alternating distances; both kinds of rows have equal weight.
    pub fn new(sheet: &Sheet, x: &Vectors) -> Self {
        if sheet.model.triangles.is_some() {
            return Self::of_mesh(sheet, x);
        }
        let mut sums = [(DVec3::ZERO, 0.0); 2];
        let Some(bottom) = sheet.model.layers.first() else {
            return Self { middle: DVec3::ZERO, corners: DVec3::ZERO };
        };
        let last = bottom.nz - 1;
        let end = |j: u32| x.get(bottom.at(bottom.nx - 1, j) as usize);
        for j in 0..bottom.nz {
            let weight = if j == 0 || j == last { 0.5 } else { 1.0 };
            let kind = if bottom.triangular { (j % 2) as usize } else { 0 };
            sums[kind].0 += end(j) * weight;
            sums[kind].1 += weight;
        }
        let means: Vec<DVec3> = sums.iter().filter(|(_, w)| *w > 0.0).map(|(sum, w)| *sum / *w).collect();
        Self { middle: means.iter().sum::<DVec3>() / means.len() as f64, corners: (end(0) + end(last)) * 0.5 }
    }

    /// The edge of a triangle mesh: nodes at u = 1, weighted by half of the distance to each
    /// neighbour.
    fn of_mesh(sheet: &Sheet, x: &Vectors) -> Self {
        let mut row: Vec<usize> = (0..sheet.node_count()).filter(|i| sheet.model.uv[*i].0 > 1.0 - 1e-9).collect();
        row.sort_by(|a, b| sheet.model.uv[*a].1.total_cmp(&sheet.model.uv[*b].1));
        let (Some(first), Some(last)) = (row.first(), row.last()) else {
            return Self { middle: DVec3::ZERO, corners: DVec3::ZERO };
        };
        let (mut sum, mut length) = (DVec3::ZERO, 0.0);
        for pair in row.windows(2) {
            let step = sheet.model.uv[pair[1]].1 - sheet.model.uv[pair[0]].1;
            sum += (x.get(pair[0]) + x.get(pair[1])) * (0.5 * step);
            length += step;
        }
        Self { middle: sum / length, corners: (x.get(*first) + x.get(*last)) * 0.5 }
    }
}
