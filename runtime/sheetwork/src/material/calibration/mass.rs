//! Mass of every node, from the area of sheet around it.
//!
//! Layers have equal shares. Within a layer each row has the strip of sheet nearest to it, and each
//! node of a row the piece of that strip nearest to it, so that every layer covers the sheet
//! exactly.

use crate::mesh::structure::Lattice;

/// Mass of every node of a lattice that covers `size` (m, along x and z) with `areal` (kg/m²) in
/// all layers together, kg.
pub(crate) fn node_masses(lattice: &Lattice, size: (f64, f64), areal: f64) -> Vec<f64> {
    let mut mass = Vec::with_capacity(lattice.positions.len());
    let density = areal / lattice.layers.len() as f64;
    for layer in &lattice.layers {
        let row = |j: u32| lattice.positions[layer.at(0, j) as usize].z;
        let rows: Vec<f64> = (0..layer.nz).map(row).collect();
        for (j, depth) in nearest(&rows, size.1).into_iter().enumerate() {
            let column = |i: u32| lattice.positions[layer.at(i, j as u32) as usize].x;
            let columns: Vec<f64> = (0..layer.nx).map(column).collect();
            mass.extend(nearest(&columns, size.0).into_iter().map(|width| density * depth * width));
        }
    }
    mass
}

/// Lengths of the parts of an interval centred at 0 that are nearest to each of `places`,
/// ascending.
fn nearest(places: &[f64], length: f64) -> Vec<f64> {
    let border = |i: usize| match i {
        0 => -0.5 * length,
        i if i == places.len() => 0.5 * length,
        i => 0.5 * (places[i - 1] + places[i]),
    };
    (0..places.len()).map(|i| border(i + 1) - border(i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::structure::{LatticeSpec, TABLE, generate};

    #[test]
    fn node_masses_add_up_and_corners_have_a_quarter() {
        for row in TABLE {
            for layers in [1, 2, 3].into_iter().filter(|n| (row.layers.0..=row.layers.1).contains(n)) {
                let (size, gap, grid) = ((0.3, 0.2), 0.01, (6, layers, 5));
                let spec = LatticeSpec { structure: row.kind, grid, size, gap, cross_over: false };
                let lattice = generate(&spec).expect("valid");
                let mass = node_masses(&lattice, size, 0.5);
                assert_eq!(mass.len(), lattice.positions.len());
                assert!((mass.iter().sum::<f64>() - 0.5 * 0.06).abs() < 1e-12, "{}", row.name);
                assert!(mass.iter().all(|m| *m > 0.0));
                let cell = 0.3 / if row.triangular { 5.5 } else { 5.0 } * 0.05;
                assert!((mass[0] - 0.25 * cell * 0.5 / f64::from(layers)).abs() < 1e-12, "{}", row.name);
            }
        }
    }
}
