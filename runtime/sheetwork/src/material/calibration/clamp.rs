//! Clamped edges: springs cut by a clamp.
//!
//! A clamp fixes all of the sheet beyond a vertical plane at its edge. A lattice continued beyond
//! it would have springs through that plane; the rest of a spring that is cut at the fraction f of
//! its length, from the free end, has stiffness k/f and is fixed in the plane. Nodes in the plane
//! are fixed. Nodes of the layers in between lie half a cell inside and stay free; otherwise the
//! clamp would begin half a cell too early.

use glam::DVec3;

use crate::material::calibration::ClampedEdges;
use crate::material::calibration::cell::{LatticeSite, sites};
use crate::material::calibration::fit::BulkStiffness;
use crate::material::calibration::free_edge::EdgeStiffness;
use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{Lattice, LatticeLayer, LatticeSpec, assemble};

/// Spring from a node to a point in the plane of a clamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallSpring {
    /// Node.
    pub mass: u32,
    /// Fixed end, m, in the local axes of the sheet at rest; the rest length is the distance from
    /// there.
    pub point: DVec3,
    /// Stiffness k/f, N/m.
    pub stiffness: f64,
    /// Class of the uncut spring.
    pub class: SpringClass,
}

/// Columns and rows added beyond a clamp: the reach of any spring, and even, so that rows keep
/// their shift.
const COLUMNS_BEYOND_CLAMP: u32 = 2;

/// Distances (m) inside the clamped edges; negative beyond them.
fn inside(p: DVec3, size: (f64, f64), clamped: ClampedEdges) -> impl Iterator<Item = f64> {
    let edges = [
        (clamped.left, p.x + 0.5 * size.0),
        (clamped.right, 0.5 * size.0 - p.x),
        (clamped.back, p.z + 0.5 * size.1),
        (clamped.front, 0.5 * size.1 - p.z),
    ];
    edges.into_iter().filter(|(clamped, _)| *clamped).map(|(_, distance)| distance)
}

/// Nodes in the plane of a clamp.
pub(crate) fn fixed_nodes(lattice: &Lattice, size: (f64, f64), clamped: ClampedEdges) -> Vec<u32> {
    let near = 1e-9 * size.0.max(size.1);
    let masses = lattice.positions.iter().enumerate();
    let on_wall = masses.filter(|(_, p)| inside(**p, size, clamped).any(|d| d <= near));
    on_wall.map(|(i, _)| i as u32).collect()
}

/// Springs cut by the clamps, of the lattice generated from `spec`.
pub(crate) fn cut(
    spec: &LatticeSpec,
    lattice: &Lattice,
    bulk: &BulkStiffness,
    edges: &EdgeStiffness,
    clamped: ClampedEdges,
) -> Vec<WallSpring> {
    let wide = ContinuedLattice::new(spec, clamped);
    let near = 1e-9 * spec.size.0.max(spec.size.1);
    let mut found = Vec::new();
    for link in &wide.lattice.links {
        let ends = [link.a, link.b].map(|mass| wide.site(mass));
        let [a, b] = ends.map(|site| place(lattice, site));
        let (mass, other, mine) = match (a, b) {
            (Some(mass), None) => (mass, link.b, link.a),
            (None, Some(mass)) => (mass, link.a, link.b),
            _ => continue,
        };
        let (from, to) = (wide.position(mine), wide.position(other));
        let depths = inside(from, spec.size, clamped).zip(inside(to, spec.size, clamped));
        let crossed = depths.filter(|(_, beyond)| *beyond <= near);
        let fraction = crossed.map(|(depth, beyond)| depth / (depth - beyond.min(0.0))).fold(f64::INFINITY, f64::min);
        let free = inside(from, spec.size, clamped).all(|depth| depth > near);
        if free && fraction.is_finite() {
            let layer = &lattice.layers[link.layer as usize];
            let grid = (i64::from(layer.nx), i64::from(layer.nz));
            let whole = bulk.stiffness(link.class, link.layer, to - from)
                * edges.factor(link.class, ends[0], ends[1], grid, clamped);
            let point = from + fraction * (to - from);
            found.push(WallSpring { mass, point, stiffness: whole / fraction, class: link.class });
        }
    }
    found.retain(|s| s.stiffness > 0.0);
    found
}

/// Node of a lattice at a site, if any.
fn place(lattice: &Lattice, site: LatticeSite) -> Option<u32> {
    let layer: &LatticeLayer = lattice.layers.get(site.layer as usize)?;
    let within = |i: i64, n: u32| u32::try_from(i).ok().filter(|i| *i < n);
    Some(layer.at(within(site.i, layer.nx)?, within(site.j, layer.nz)?))
}

/// Lattice continued beyond its clamped edges.
struct ContinuedLattice {
    lattice: Lattice,
    sites: Vec<LatticeSite>,
    /// Columns and rows added before the first.
    before: (u32, u32),
    /// Displacement of its nodes from those of the lattice at the same sites, m.
    shift: DVec3,
}

impl ContinuedLattice {
    fn new(spec: &LatticeSpec, clamped: ClampedEdges) -> Self {
        let add = |edge: bool| if edge { COLUMNS_BEYOND_CLAMP } else { 0 };
        let (before, after) = ((add(clamped.left), add(clamped.back)), (add(clamped.right), add(clamped.front)));
        let (nx, layers, nz) = spec.grid;
        let (dx, dz) = spec.spacing();
        let size = (spec.size.0 + dx * f64::from(before.0 + after.0), spec.size.1 + dz * f64::from(before.1 + after.1));
        let grid = (nx + before.0 + after.0, layers, nz + before.1 + after.1);
        let lattice = assemble(&LatticeSpec { grid, size, ..*spec });
        // Both lattices are centred on their own middles.
        let shift = |wide: f64, size: f64, before: u32, spacing: f64| 0.5 * (wide - size) - spacing * f64::from(before);
        let along_x = shift(size.0, spec.size.0, before.0, dx);
        let shift = DVec3::new(along_x, 0.0, shift(size.1, spec.size.1, before.1, dz));
        Self { sites: sites(&lattice), lattice, before, shift }
    }

    /// Site of a node, counted as in the original lattice.
    fn site(&self, mass: u32) -> LatticeSite {
        let site = self.sites[mass as usize];
        LatticeSite { i: site.i - i64::from(self.before.0), j: site.j - i64::from(self.before.1), ..site }
    }

    /// Position of a node, m, in the axes of the original lattice.
    fn position(&self, mass: u32) -> DVec3 {
        self.lattice.positions[mass as usize] + self.shift
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::structure::{TABLE, generate};

    #[test]
    fn a_lattice_continued_lies_on_itself() {
        for row in TABLE {
            let layers = row.layers.1.min(2);
            let (size, gap, grid) = ((0.3, 0.2), 0.01, (6, layers, 5));
            let spec = LatticeSpec { structure: row.kind, grid, size, gap, cross_over: false };
            let lattice = generate(&spec).expect("valid");
            for clamped in [
                ClampedEdges { left: true, ..ClampedEdges::default() },
                ClampedEdges { right: true, back: true, ..ClampedEdges::default() },
                ClampedEdges { left: true, right: true, back: true, front: true },
            ] {
                let wide = ContinuedLattice::new(&spec, clamped);
                let masses = 0..wide.lattice.positions.len() as u32;
                let same = masses.filter_map(|m| Some((m, place(&lattice, wide.site(m))?))).collect::<Vec<_>>();
                assert_eq!(same.len(), lattice.positions.len());
                for (there, here) in same {
                    assert!(wide.position(there).distance(lattice.positions[here as usize]) < 1e-12, "{}", row.name);
                }
            }
        }
    }
}
