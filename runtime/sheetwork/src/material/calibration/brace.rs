//! Braces: springs for nodes without inter-layer springs.
//!
//! A triangular layer has one corner that lies under no node of the next layer, so that only
//! springs of its own plane support it and it moves freely out of plane. Each such node is joined
//! to the nearest node of the next layer. Uniform bending does not strain a spring between layers
//! in any direction (with κ the curvature and s the distance between layers, its ends separate by
//! (r·κ r) s/2 along r and by -(r·κ r)/2 along the normal, which cancel), so a brace does not
//! change the stiffness of the sheet.

use crate::material::calibration::fit::BulkStiffness;
use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{Lattice, LatticeSpring};

/// Braces of a lattice, with their stiffness, N/m.
pub(crate) fn braces(lattice: &Lattice, bulk: &BulkStiffness) -> Vec<(LatticeSpring, f64)> {
    let mut joined = vec![false; lattice.positions.len()];
    for link in lattice.links.iter().filter(|l| l.class == SpringClass::Inter) {
        joined[link.a as usize] = true;
        joined[link.b as usize] = true;
    }
    let loose = (0..joined.len()).filter(|i| !joined[*i] && lattice.layers.len() > 1);
    loose.filter_map(|i| brace(lattice, i)).map(|link| (link, bulk.inter)).collect()
}

/// Brace from node `i` to the nearest of the layer above, or below the top one.
fn brace(lattice: &Lattice, i: usize) -> Option<LatticeSpring> {
    let layer = lattice.layer_of[i];
    let next = if layer as usize + 1 < lattice.layers.len() { layer + 1 } else { layer.checked_sub(1)? };
    let distance = |m: &usize| lattice.positions[*m].distance_squared(lattice.positions[i]);
    let near = lattice.layers[next as usize].range().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let (a, b) = (i.min(near) as u32, i.max(near) as u32);
    Some(LatticeSpring { a, b, class: SpringClass::Inter, layer: layer.min(next) })
}
