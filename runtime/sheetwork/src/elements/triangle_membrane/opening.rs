//! Membrane of a mesh with open triangles.
//!
//! An open triangle has no stiffness. The arc of an edge comes from its closed triangles whose
//! curvature is known, that is, with a bound slope left. Where the arc term |k|² of an edge
//! changes as cells open, the edge takes the change as a rest strain, ½ Δ|k|², so that the
//! stress of the closed triangles and their energy stay the same at that moment.

use std::collections::BTreeSet;

use crate::elements::NO_BLOCK;
use crate::elements::fracture::OpenCells;
use crate::elements::triangle_cells::TriangleCells;
use crate::elements::triangle_membrane::EdgeMembrane;
use crate::elements::triangle_membrane::edge_strain::{Sources, sources_of};
use crate::math::Vectors;

/// Changes by open triangles; none while all are closed.
#[derive(Clone, Debug)]
pub(super) struct Opening {
    /// Relaxed directions of each group and sources of each edge while all triangles are closed.
    relaxed: Vec<Vec<[f64; 3]>>,
    sources: Vec<Sources>,
    /// Whether each triangle is open.
    pub(super) open: Vec<bool>,
    /// Sum of the changes of |k|² of each edge.
    pub(super) arc_change: Vec<f64>,
}

impl EdgeMembrane {
    /// Rest part of twice the strain of edge `e` from changes of its arc.
    pub(super) fn arc_change(&self, e: usize) -> f64 {
        self.opening.as_ref().map_or(0.0, |o| o.arc_change[e])
    }

    /// Sets the open triangles at the positions `x` (m).
    pub(super) fn open_triangles(&mut self, x: &Vectors, cells: &TriangleCells, open: &OpenCells) {
        let squared =
            |all: &Self| -> Vec<f64> { all.strains.iter().map(|s| (s.bow(x) + s.offset).length_squared()).collect() };
        let before = squared(self);
        let intact = |all: &Self| Opening {
            relaxed: all.groups.iter().map(|g| g.relaxed.clone()).collect(),
            sources: all.sources.clone(),
            open: Vec::new(),
            arc_change: vec![0.0; all.strains.len()],
        };
        let mut opening = self.opening.take().unwrap_or_else(|| Box::new(intact(self)));
        opening.open = open.cells().to_vec();
        self.find_sources(&opening, cells, open.is_whole());
        self.compute_arcs(&self.bending.clone());
        self.gather_nodes();
        self.compute_weights();
        self.compute_offsets();
        let after = squared(self);
        for (e, change) in opening.arc_change.iter_mut().enumerate() {
            *change += after[e] - before[e];
        }
        self.opening = (!open.is_whole()).then_some(opening);
        let creep = self.creep.take();
        for e in 0..self.strains.len() {
            match &creep {
                Some(creeping) => self.apply_rest_strain(e, creeping),
                None => self.strains[e].unit = 1.0 + self.arc_change(e),
            }
        }
        self.creep = creep;
    }

    /// Sets relaxed directions of the groups and sources of the edges beside open triangles.
    fn find_sources(&mut self, opening: &Opening, cells: &TriangleCells, is_whole: bool) {
        let mesh = cells.mesh();
        for (k, (group, relaxed)) in self.groups.iter_mut().zip(&opening.relaxed).enumerate() {
            group.relaxed.clone_from(relaxed);
            group.relaxed.extend(cells.freed_directions(k));
        }
        if is_whole {
            return self.sources.clone_from(&opening.sources);
        }
        let known = |k: u32| !opening.open[k as usize] && self.groups[k as usize].relaxed.len() < 3;
        for ((to, whole), edge) in self.sources.iter_mut().zip(&opening.sources).zip(&mesh.edges) {
            *to = sources_of(*whole, edge, known);
        }
    }

    /// Finds the nodes that the strains of each triangle depend on.
    pub(super) fn gather_nodes(&mut self) {
        for triangle in &mut self.triangles {
            let used = triangle.edges.iter().flat_map(|e| {
                let strain = &self.strains[*e as usize];
                strain.arc.iter().map(|a| a.0).chain(strain.ends)
            });
            triangle.masses = used.collect::<BTreeSet<u32>>().into_iter().collect();
            let pairs = triangle.masses.len() * (triangle.masses.len() + 1) / 2;
            triangle.blocks = vec![NO_BLOCK; pairs];
        }
        let most = self.triangles.iter().map(|t| t.masses.len()).max().unwrap_or(0);
        self.gradients = vec![[glam::DVec3::ZERO; 3]; 2 * most];
    }
}
