//! Remapping between two triangle meshes of a sheet.
//!
//! State per triangle (rest curvature, rest strain, creep) moves between triangles that contain
//! each other's centroids. A finer triangle takes the state of the coarse triangle that contains
//! its centroid. A coarser triangle takes the area-weighted mean of the triangles whose centroids
//! it contains. A fold keeps its angle and its width (or becomes one triangle wide), and does not
//! spread when a sheet changes grids repeatedly.
//!
//! State per node (temperature, stretch) is piecewise linear. A finer mesh interpolates it; a node
//! of a coarser mesh takes the mean weighted with its hat function. Neither exceeds the range of
//! the values.
//!
//! Between two refinements of a base mesh, a triangle takes the mean of the triangles that it
//! overlaps, weighted by the overlap: a part of the sheet that does not change keeps its state to
//! the bit, and integrals over any base triangle are preserved. Nodes of both meshes keep their
//! values, and receive those of the nodes that disappear around them.

use crate::mesh::outline::TriangleMesh;
use crate::mesh::outline::locate::{PointLocator, inward};
use crate::mesh::outline::refine::Refinement;

/// Indices and weights of old nodes or triangles.
type Combination = Vec<(u32, f64)>;

/// Two meshes, and the combinations of old values for each place of the new mesh.
pub struct MeshRemap<'a> {
    /// Old mesh.
    pub from: &'a TriangleMesh,
    /// New mesh.
    pub to: &'a TriangleMesh,
    /// Old triangles of each new triangle; the sum of the weights is 1.
    triangles: Vec<Combination>,
    /// Old nodes of each new node; weights are not negative and their sum is 1.
    masses: Vec<Combination>,
    /// Old node of each new node that both refinements of a base mesh have; empty for meshes
    /// without a common base.
    pub shared: Vec<Option<u32>>,
}

impl<'a> MeshRemap<'a> {
    /// Combinations for remapping from `from` to `to`.
    pub fn new(from: &'a TriangleMesh, to: &'a TriangleMesh) -> Self {
        let mean = |mesh: &TriangleMesh| mesh.total_area() / mesh.triangles.len().max(1) as f64;
        let coarser = mean(to) > mean(from);
        let (there, here) = (PointLocator::new(from), PointLocator::new(to));
        let inside = |mesh: &TriangleMesh, locator: &PointLocator, k: usize| {
            let middle = mesh.middle_of(k);
            locator.find(middle, middle)
        };
        let mut triangles = vec![Combination::new(); to.triangles.len()];
        let mut masses = vec![Combination::new(); to.positions.len()];
        if coarser {
            for k in 0..from.triangles.len() {
                triangles[inside(from, &here, k) as usize].push((k as u32, from.areas[k]));
            }
            let sides = inward(from);
            for (i, p) in from.positions.iter().enumerate() {
                for (v, w) in hat_weights(to, &here, *p, sides[i]) {
                    masses[v as usize].push((i as u32, w * from.lumped[i]));
                }
            }
        }
        for (k, parts) in triangles.iter_mut().enumerate().filter(|(_, parts)| parts.is_empty()) {
            parts.push((inside(to, &there, k), 1.0));
        }
        let sides = inward(to);
        for (i, parts) in masses.iter_mut().enumerate().filter(|(_, parts)| parts.is_empty()) {
            parts.extend(hat_weights(from, &there, to.positions[i], sides[i]));
        }
        triangles.iter_mut().chain(&mut masses).for_each(make_whole);
        Self { from, to, triangles, masses, shared: Vec::new() }
    }

    /// Combinations for remapping between two refinements of a base mesh.
    pub(crate) fn nested(from: (&'a TriangleMesh, &Refinement), to: (&'a TriangleMesh, &Refinement)) -> Self {
        let mut parts: Vec<Vec<u32>> = vec![Vec::new(); from.1.levels.len()];
        from.1.parents.iter().zip(0..).for_each(|(parent, k)| parts[*parent as usize].push(k));
        let corners = |mesh: &TriangleMesh, k: u32| mesh.triangles[k as usize].map(|v| mesh.positions[v as usize]);
        let overlaps = |(k, parent): (u32, &u32)| {
            let own = corners(to.0, k);
            let each = parts[*parent as usize].iter().map(|old| (*old, overlap(own, corners(from.0, *old))));
            let least = 1e-9 * to.0.areas[k as usize];
            each.filter(|(_, area)| *area > least).collect::<Combination>()
        };
        let mut triangles: Vec<Combination> = (0..).zip(&to.1.parents).map(overlaps).collect();
        let shared = to.1.shared(from.1);
        let (there, here) = (PointLocator::new(from.0), PointLocator::new(to.0));
        let (old_sides, sides) = (inward(from.0), inward(to.0));
        let kept = |old: &Option<u32>| old.map_or_else(Vec::new, |i| vec![(i, from.0.lumped[i as usize])]);
        let mut masses: Vec<Combination> = shared.iter().map(kept).collect();
        for (i, _) in from.1.shared(to.1).iter().enumerate().filter(|(_, now)| now.is_none()) {
            for (v, w) in hat_weights(to.0, &here, from.0.positions[i], old_sides[i]) {
                masses[v as usize].push((i as u32, w * from.0.lumped[i]));
            }
        }
        for (i, parts) in masses.iter_mut().enumerate().filter(|(i, _)| shared[*i].is_none()) {
            *parts = hat_weights(from.0, &there, to.0.positions[i], sides[i]);
        }
        triangles.iter_mut().chain(&mut masses).for_each(make_whole);
        Self { from: from.0, to: to.0, triangles, masses, shared }
    }

    /// Value in new triangle `k` from `values` of old triangles; `None` where no contributing value
    /// is known.
    pub fn interpolate<const K: usize>(&self, values: &[Option<[f64; K]>], k: usize) -> Option<[f64; K]> {
        let (mut sum, mut whole) = ([0.0; K], 0.0);
        for (old, weight) in &self.triangles[k] {
            if let Some(value) = &values[*old as usize] {
                whole += weight;
                sum.iter_mut().zip(value).for_each(|(s, x)| *s += weight * x);
            }
        }
        (whole > 0.0).then(|| sum.map(|s| s / whole))
    }

    /// Value at new node `i` from `values` at old nodes.
    pub fn at_node<const K: usize>(&self, values: &[[f64; K]], i: usize) -> [f64; K] {
        let mut sum = [0.0; K];
        for (old, weight) in &self.masses[i] {
            sum.iter_mut().zip(&values[*old as usize]).for_each(|(s, x)| *s += weight * x);
        }
        sum
    }
}

/// Corners of the triangle of `mesh` that contains `p` (m), approached from `inside`, and their
/// barycentric weights, clipped to non-negative.
pub fn hat_weights(mesh: &TriangleMesh, locator: &PointLocator, p: [f64; 2], inside: [f64; 2]) -> Combination {
    let k = locator.find(p, inside);
    let weights = locator.weights(k, p).map(|w| w.max(0.0));
    let mut parts: Combination = mesh.triangles[k as usize].into_iter().zip(weights).filter(|w| w.1 > 1e-9).collect();
    make_whole(&mut parts);
    parts
}

/// Area that two counter-clockwise triangles share, m².
fn overlap(a: [[f64; 2]; 3], b: [[f64; 2]; 3]) -> f64 {
    let mut polygon = a.to_vec();
    for c in 0..3 {
        let (p, q) = (b[c], b[(c + 1) % 3]);
        let inside = |r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        let mut clipped = Vec::with_capacity(polygon.len() + 1);
        for (i, r) in polygon.iter().enumerate() {
            let s = polygon[(i + 1) % polygon.len()];
            let (here, next) = (inside(*r), inside(s));
            if here >= 0.0 {
                clipped.push(*r);
            }
            if (here > 0.0 && next < 0.0) || (here < 0.0 && next > 0.0) {
                let t = here / (here - next);
                clipped.push([r[0] + t * (s[0] - r[0]), r[1] + t * (s[1] - r[1])]);
            }
        }
        polygon = clipped;
    }
    let twice = |(i, r): (usize, &[f64; 2])| {
        let s = polygon[(i + 1) % polygon.len()];
        r[0] * s[1] - s[0] * r[1]
    };
    0.5 * polygon.iter().enumerate().map(twice).sum::<f64>()
}

/// Normalises the sum of the weights to 1.
fn make_whole(parts: &mut Combination) {
    let whole: f64 = parts.iter().map(|p| p.1).sum();
    parts.iter_mut().for_each(|p| p.1 /= whole);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::outline::{HoleSpec, Outline, OutlineSpec, mesh};
    use std::path::Path;
    use std::sync::Arc;

    fn ring(n: u32) -> TriangleMesh {
        let disc = OutlineSpec::Disc { radius: 0.1 };
        let hole = HoleSpec::Disc { centre: (0.02, 0.0), radius: 0.03 };
        let outline = Outline::new(Some(&disc), &[hole], &[], (0.2, 0.2), Path::new(".")).expect("an outline");
        mesh(&outline, (n, n)).expect("a mesh")
    }

    #[test]
    fn a_constant_field_stays_constant() {
        for (a, b) in [(13, 25), (25, 13), (25, 20), (13, 41)] {
            let (from, to) = (ring(a), ring(b));
            let meshes = MeshRemap::new(&from, &to);
            let (each, masses) = (vec![Some([2.5]); from.triangles.len()], vec![[2.5]; from.positions.len()]);
            assert!(
                (0..to.triangles.len()).all(|k| (meshes.interpolate(&each, k).expect("known")[0] - 2.5).abs() < 1e-12)
            );
            assert!((0..to.positions.len()).all(|i| (meshes.at_node(&masses, i)[0] - 2.5).abs() < 1e-12));
        }
    }

    #[test]
    fn a_linear_field_is_exact_on_a_finer_mesh() {
        let (from, to) = (ring(13), ring(25));
        let meshes = MeshRemap::new(&from, &to);
        let values: Vec<[f64; 1]> = from.positions.iter().map(|[u, v]| [3.0 * u - v]).collect();
        for (i, [u, v]) in to.positions.iter().enumerate().filter(|(i, _)| !to.border[*i]) {
            assert!((meshes.at_node(&values, i)[0] - (3.0 * u - v)).abs() < 1e-3, "{u} {v}");
        }
    }

    #[test]
    fn refinements_conserve_integrals_and_keep_unchanged_parts() {
        let base = Arc::new(ring(25));
        let levels = |f: &dyn Fn(f64) -> u8| -> Arc<[u8]> {
            (0..base.triangles.len()).map(|k| f(base.middle_of(k)[0])).collect()
        };
        let refined = |f: &dyn Fn(f64) -> u8| Refinement::new(base.clone(), levels(f)).expect("levels");
        let (from, a) = refined(&|u| if u < -0.02 { 2 } else { 0 });
        let (to, b) = refined(&|u| u8::from(u < -0.05) + 2 * u8::from(u > 0.03));
        let meshes = MeshRemap::nested((&from, &a), (&to, &b));
        let field = |[u, v]: [f64; 2]| (30.0 * u).sin() + v;
        let each: Vec<_> = (0..from.triangles.len()).map(|k| Some([field(from.middle_of(k))])).collect();
        let before: f64 = each.iter().zip(&from.areas).map(|(v, area)| area * v.expect("known")[0]).sum();
        let now = |k: usize| meshes.interpolate(&each, k).expect("known")[0];
        let after: f64 = to.areas.iter().enumerate().map(|(k, area)| area * now(k)).sum();
        assert!((after / before - 1.0).abs() < 1e-9, "{after} of {before}");
        // Triangles that both have, to the bit; nodes, where no neighbour disappears.
        // The inner of four parts has the middle of the whole.
        let equal = |j: usize, k: usize| {
            from.middle_of(j) == to.middle_of(k) && (from.areas[j] / to.areas[k] - 1.0).abs() < 1e-9
        };
        let same = |k: usize| (0..from.triangles.len()).find(|j| equal(*j, k));
        let kept: Vec<_> = (0..to.triangles.len()).filter_map(|k| Some((k, same(k)?))).collect();
        let off = |(k, j): &(usize, usize)| (now(*k) - each[*j].expect("known")[0]).abs();
        let worst = kept.iter().map(off).fold(0.0, f64::max);
        assert!(kept.len() > 20 && worst == 0.0, "{} triangles, {worst}", kept.len());
        let values: Vec<[f64; 1]> = from.positions.iter().map(|p| [field(*p)]).collect();
        for (i, old) in meshes.shared.iter().enumerate().filter(|(i, _)| to.positions[*i][0] > 0.0) {
            assert!(old.is_none_or(|j| meshes.at_node(&values, i) == values[j as usize]));
        }
    }

    #[test]
    fn the_integral_along_a_fold_is_conserved() {
        // A fold along a line of triangles: the sum over the area is angle times length.
        for (a, b) in [(25, 13), (13, 25), (41, 21)] {
            let (from, to) = (ring(a), ring(b));
            let meshes = MeshRemap::new(&from, &to);
            let bent = |k: usize| Some([if from.middle_of(k)[0].abs() < 0.008 { 1.0 } else { 0.0 }]);
            let each: Vec<_> = (0..from.triangles.len()).map(bent).collect();
            let sum = |mesh: &TriangleMesh, of: &dyn Fn(usize) -> Option<[f64; 1]>| {
                (0..mesh.triangles.len()).map(|k| mesh.areas[k] * of(k).map_or(0.0, |v| v[0])).sum::<f64>()
            };
            let (before, after) = (sum(&from, &|k| each[k]), sum(&to, &|k| meshes.interpolate(&each, k)));
            assert!((after / before - 1.0).abs() < 0.06, "{a} to {b}: {after} of {before}");
        }
    }
}
