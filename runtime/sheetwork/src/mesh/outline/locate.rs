//! Location of a point in a mesh: the triangle, and the weights of its corners.
//!
//! Triangles are found by cells over the mesh's bounding box. A point on a cut belongs to two
//! unconnected triangles; the search point is moved slightly towards the given inner point to
//! select one. A point beyond a curved boundary, as on the chords of another mesh, gets the
//! triangle with the least negative weights.

use crate::mesh::outline::mesh::TriangleMesh;

/// Fraction of the way towards the inner point at which the search is made.
const INWARD_FRACTION: f64 = 1e-3;

/// Search cells over the bounding box of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleIndex {
    low: [f64; 2],
    /// Search cells per metre along u and v.
    per_metre: [f64; 2],
    count: [usize; 2],
    /// Triangles whose box overlaps each cell, in ascending order.
    cells: Vec<Vec<u32>>,
}

impl TriangleIndex {
    /// Search cells of `mesh`.
    pub fn new(mesh: &TriangleMesh) -> Self {
        let (low, high) = mesh.bounds();
        let side = (mesh.triangles.len() as f64).sqrt().ceil().max(1.0);
        let per_metre: [f64; 2] = std::array::from_fn(|a| side / (high[a] - low[a]).max(f64::MIN_POSITIVE));
        let count = [side as usize; 2];
        let mut index = Self { low, per_metre, count, cells: vec![Vec::new(); count[0] * count[1]] };
        for (k, t) in mesh.triangles.iter().enumerate() {
            let corners = t.map(|v| index.cell(mesh.positions[v as usize]));
            let range = |a: usize| {
                let each = corners.map(|c| c[a]);
                each.into_iter().min().unwrap_or(0)..=each.into_iter().max().unwrap_or(0)
            };
            for j in range(1) {
                for i in range(0) {
                    index.cells[j * count[0] + i].push(k as u32);
                }
            }
        }
        index
    }

    fn cell(&self, p: [f64; 2]) -> [usize; 2] {
        std::array::from_fn(|a| {
            let place = ((p[a] - self.low[a]) * self.per_metre[a]).floor().max(0.0);
            (place as usize).min(self.count[a] - 1)
        })
    }

    /// Triangles that may contain `p` (m), in ascending order.
    pub fn near(&self, p: [f64; 2]) -> &[u32] {
        let [i, j] = self.cell(p);
        self.cells.get(j * self.count[0] + i).map_or(&[], Vec::as_slice)
    }
}

/// Point location in a mesh.
pub struct PointLocator<'a> {
    mesh: &'a TriangleMesh,
    index: TriangleIndex,
}

impl<'a> PointLocator<'a> {
    /// Point location in `mesh`.
    pub fn new(mesh: &'a TriangleMesh) -> Self {
        Self { mesh, index: TriangleIndex::new(mesh) }
    }

    /// Weights of the corners of triangle `k` at `p` (m).
    pub fn weights(&self, k: u32, p: [f64; 2]) -> [f64; 3] {
        self.mesh.weights(k, p)
    }

    /// Triangle that contains `p` (m), or has the least negative weights, seen from the side of
    /// `inside`.
    pub fn find(&self, p: [f64; 2], inside: [f64; 2]) -> u32 {
        let at = std::array::from_fn(|a| p[a] + INWARD_FRACTION * (inside[a] - p[a]));
        let outside = |k: &u32| -self.weights(*k, at).into_iter().fold(f64::INFINITY, f64::min);
        let best = |list: &mut dyn Iterator<Item = u32>| {
            list.map(|k| (outside(&k), k)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
        };
        match best(&mut self.index.near(at).iter().copied()) {
            Some((out, k)) if out <= 0.0 => k,
            _ => best(&mut (0..self.mesh.triangles.len() as u32)).map_or(0, |b| b.1),
        }
    }
}

/// For each node the mean of the middles of its triangles, m: it selects a side of a cut.
pub fn inward(mesh: &TriangleMesh) -> Vec<[f64; 2]> {
    let mut sums = vec![([0.0; 2], 0.0); mesh.positions.len()];
    for (k, t) in mesh.triangles.iter().enumerate() {
        let middle = mesh.middle_of(k);
        for v in t {
            let (sum, count) = &mut sums[*v as usize];
            *count += 1.0;
            (0..2).for_each(|a| sum[a] += middle[a]);
        }
    }
    // A node without triangles has no side.
    sums.into_iter().map(|(sum, count)| sum.map(|x| x / f64::max(count, 1.0))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::outline::{Outline, mesh};
    use std::path::Path;

    fn cut_square(grid: (u32, u32)) -> TriangleMesh {
        let cuts = [vec![(-0.02, 0.0), (0.05, 0.0)]];
        let outline = Outline::new(None, &[], &cuts, (0.1, 0.1), Path::new(".")).expect("an outline");
        mesh(&outline, grid).expect("a mesh")
    }

    #[test]
    fn every_node_is_located_in_one_of_its_triangles() {
        let mesh = cut_square((11, 11));
        let (locator, inward) = (PointLocator::new(&mesh), inward(&mesh));
        for (i, p) in mesh.positions.iter().enumerate() {
            let k = locator.find(*p, inward[i]);
            assert!(mesh.triangles[k as usize].contains(&(i as u32)), "mass {i} at {p:?} in triangle {k}");
            let weights = locator.weights(k, *p);
            let own = mesh.triangles[k as usize].iter().zip(weights).find(|(v, _)| **v == i as u32);
            assert!((own.expect("a corner").1 - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_point_on_a_cut_is_on_the_side_it_is_asked_for() {
        let mesh = cut_square((9, 9));
        let locator = PointLocator::new(&mesh);
        for side in [-0.01, 0.01] {
            let k = locator.find([0.021, 0.0], [0.021, side]);
            assert!(mesh.middle_of(k as usize)[1] * side > 0.0, "{side}");
        }
    }

    #[test]
    fn a_point_beyond_the_boundary_has_the_nearest_triangle() {
        let mesh = cut_square((9, 9));
        let locator = PointLocator::new(&mesh);
        let p = [0.0501, 0.02];
        let weights = locator.weights(locator.find(p, [0.0, 0.0]), p);
        assert!(weights.iter().all(|w| *w > -0.02), "{weights:?}");
    }
}
