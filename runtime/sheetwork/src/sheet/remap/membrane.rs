//! Membrane strain of a lattice: mean over its layers of the tensor (uu, vv, uv), as a function of
//! (u, v).
//!
//! Each cell of a layer has the mean Green strain E = ½ (Fᵀ F - 1) of its two triangles, with F =
//! ∂x/∂(u, v) between their nodes, or its rate ½ (F'ᵀ F + Fᵀ F'). Bending stretches one layer as
//! much as it compresses another, so the mean is the membrane strain, which a change of grid must
//! preserve.

use glam::DVec3;

use crate::mesh::structure::LatticeLayer;
use crate::sheet::remap::layer_offsets::LatticeLayout;
use crate::sheet::remap::row_interpolation::RowInterpolation;
use crate::sheet::remap::strain::{GridStrains, StrainGrid};

/// Strain, or its rate (1/s), of every layer with cells.
pub(crate) struct MembraneStrain {
    layers: Vec<RowInterpolation<3>>,
    width: (f64, f64),
}

impl MembraneStrain {
    /// Strains at the node positions `x` (m).
    pub fn strains(layout: &LatticeLayout, x: &[DVec3]) -> Self {
        let strain = |a: DVec3, b: DVec3, _, _| {
            [0.5 * (a.length_squared() - 1.0), 0.5 * (b.length_squared() - 1.0), 0.5 * a.dot(b)]
        };
        Self::new(layout, x, x, strain)
    }

    /// Rates of strain (1/s) at the node positions `x` (m) and velocities `v` (m/s).
    pub fn rates(layout: &LatticeLayout, x: &[DVec3], v: &[DVec3]) -> Self {
        let rate = |a: DVec3, b: DVec3, p: DVec3, q: DVec3| [a.dot(p), b.dot(q), 0.5 * (a.dot(q) + p.dot(b))];
        Self::new(layout, x, v, rate)
    }

    fn new(
        layout: &LatticeLayout,
        x: &[DVec3],
        v: &[DVec3],
        of: impl Fn(DVec3, DVec3, DVec3, DVec3) -> [f64; 3] + Copy,
    ) -> Self {
        let triangle = |t: &[u32; 3]| {
            let [(a, b), (p, q)] = [slopes(layout, t, x), slopes(layout, t, v)];
            of(a, b, p, q)
        };
        let cell = |pair: &[[u32; 3]]| {
            let masses = pair.iter().flatten().map(|m| layout.uv[*m as usize]);
            let (u, v) = masses.fold((0.0, 0.0), |(u, v), p| (u + p.0 / 6.0, v + p.1 / 6.0));
            let [a, b] = [triangle(&pair[0]), triangle(&pair[1])];
            ((u, v), std::array::from_fn(|k| 0.5 * (a[k] + b[k])))
        };
        let rows = |layer: &LatticeLayer| RowInterpolation::new(layer.triangles().chunks_exact(2).map(cell));
        let with_cells = layout.layers.iter().filter(|l| l.nx > 1 && l.nz > 1);
        Self { layers: with_cells.map(rows).collect(), width: layout.step() }
    }

    /// Change of the strains of `mesh`, the bottom layer of `layout`, from the mean `own` to this
    /// one.
    pub fn change(&self, mesh: &StrainGrid, layout: &LatticeLayout, own: &Self) -> GridStrains {
        mesh.strains_of_field(|masses| {
            let part = 1.0 / masses.len() as f64;
            let places = masses.iter().map(|m| layout.uv[*m]);
            let at = places.fold((0.0, 0.0), |(u, v), p| (u + part * p.0, v + part * p.1));
            let (wanted, there) = (self.interpolate(at), own.interpolate(at));
            std::array::from_fn(|k| wanted[k] - there[k])
        })
    }

    /// Mean over the layers at (u, v).
    fn interpolate(&self, at: (f64, f64)) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for layer in self.layers.iter().filter_map(|l| l.interpolate(at, self.width)) {
            sum.iter_mut().zip(layer).for_each(|(s, e)| *s += e / self.layers.len() as f64);
        }
        sum
    }
}

/// ∂x/∂u and ∂x/∂v of a triangle, per metre at rest.
fn slopes(layout: &LatticeLayout, triangle: &[u32; 3], x: &[DVec3]) -> (DVec3, DVec3) {
    let [a, b, c] = triangle.map(|i| i as usize);
    let place = |i: usize| (layout.uv[i].0 * layout.extent.0, layout.uv[i].1 * layout.extent.1);
    let from = place(a);
    let away = |i: usize| (place(i).0 - from.0, place(i).1 - from.1);
    let ((bu, bv), (cu, cv)) = (away(b), away(c));
    let area = bu * cv - bv * cu;
    let (p, q) = (x[b] - x[a], x[c] - x[a]);
    ((p * cv - q * bv) / area, (q * bu - p * cu) / area)
}
