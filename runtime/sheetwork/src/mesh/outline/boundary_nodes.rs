//! Nodes on the boundary and along cuts, and the sides between them.

use std::collections::BTreeMap;

use glam::DVec2;

use crate::error::InputError;
use crate::mesh::outline::line::{CellScale, OutlineLine};
use crate::mesh::outline::{Outline, cut, features};

/// Points and sides that a triangulation must contain.
#[derive(Debug, Default)]
pub struct BoundaryNodes {
    /// Positions of the nodes, cells.
    pub points: Vec<DVec2>,
    /// Sides of the boundary.
    pub sides: Vec<[u32; 2]>,
    /// Sides along cuts.
    pub slits: Vec<[u32; 2]>,
    /// Number of points on the boundary, which come first.
    pub rim: usize,
    /// Field of the scene that each point comes from, an index into `fields`.
    pub from: Vec<u32>,
    /// Fields of the scene.
    pub fields: Vec<String>,
    /// Points by position, to the bit: lines that meet share a point.
    at: BTreeMap<(u64, u64), u32>,
}

impl BoundaryNodes {
    fn node(&mut self, p: DVec2) -> u32 {
        // Adding zero turns -0 into 0.
        let key = ((p.x + 0.0).to_bits(), (p.y + 0.0).to_bits());
        *self.at.entry(key).or_insert_with(|| {
            self.points.push(p);
            self.from.push(self.fields.len() as u32);
            self.points.len() as u32 - 1
        })
    }

    fn add(&mut self, line: &OutlineLine) {
        let nodes: Vec<u32> = line.sample().into_iter().map(|p| self.node(p)).collect();
        self.fields.push(line.field.clone());
        let sides = if line.closed { &mut self.sides } else { &mut self.slits };
        sides.extend(nodes.windows(2).map(|w| [w[0], w[1]]));
        if let (true, Some(first), Some(last)) = (line.closed, nodes.first(), nodes.last()) {
            sides.push([*last, *first]);
        }
    }
}

/// Place nodes along the boundary, holes and cuts.
///
/// # Errors
/// When a feature is smaller than a cell, or a cut is not in the sheet.
pub fn place(outline: &Outline, cells: &CellScale) -> Result<BoundaryNodes, InputError> {
    let mut rings = Vec::new();
    for ring in outline.rings() {
        rings.push(OutlineLine::new(&ring.points, true, &ring.field, cells)?);
    }
    features::check(&rings, cells)?;
    let pieces = cut::pieces(outline, &mut rings, cells)?;
    let mut nodes = BoundaryNodes::default();
    rings.iter().for_each(|line| nodes.add(line));
    nodes.rim = nodes.points.len();
    pieces.iter().for_each(|line| nodes.add(line));
    Ok(nodes)
}
