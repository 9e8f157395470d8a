//! Sheets compressed across their thickness: nodes between bodies that come closer than the
//! thickness.
//!
//! Where two bodies with prescribed motion leave the gap g < t to a sheet of thickness t, the
//! surfaces are thinner there, by the factor that leaves the barrier half of its range at g/2, and
//! its stiffness gives the force of compression of the area A of the node, E A (t - g)/t, up to a
//! stated cap. Lengths in m, forces in N.

use glam::DVec3;

use crate::contact::IslandView;
use crate::contact::barrier::surfaces::{Owner, Squeeze};
use crate::contact::barrier::{BarrierSolver, PairFriction};
use crate::contact::settings::{BarrierSettings, ContactSettings};

const SETTINGS: BarrierSettings = ContactSettings::DEFAULT.barrier;

/// A side of a node on which a body is: normal and distance at the end of its motion.
type Side = (u32, DVec3, f64);

impl BarrierSolver {
    /// Find the nodes that are compressed at the end of the substep.
    pub(super) fn squeeze(&mut self, island: &IslandView, friction: PairFriction, h: f64) {
        self.surfaces.squeezed.clear();
        if !island.solver_bodies.iter().any(|body| !body.is_dynamic()) {
            return;
        }
        self.prescribe(island, h, 1.0);
        self.step.clone_from(&self.prescribed);
        self.surfaces.find(island, &self.step, &|pair| friction(island, pair), &mut self.swept);
        let mut sides: Vec<Side> = Vec::new();
        for stencil in &self.swept {
            let closest = stencil.closest(self.corners(stencil));
            let moved = stencil.vertices.iter().zip(closest.weights);
            let closing: f64 = moved.map(|(i, w)| w * closest.normal.dot(self.prescribed[*i as usize])).sum();
            let led = |i: u32| matches!(self.surfaces.owners[i as usize], Owner::Body { body, .. } if !island.solver_bodies[body as usize].is_dynamic());
            if !stencil.vertices.iter().any(|i| led(*i)) {
                continue;
            }
            for (vertex, weight) in stencil.vertices.iter().zip(closest.weights) {
                if !led(*vertex) && weight != 0.0 {
                    sides.push((*vertex, closest.normal * weight.signum(), closest.distance + closing));
                }
            }
        }
        sides.sort_by_key(|side| side.0);
        for of_node in sides.chunk_by(|a, b| a.0 == b.0) {
            let gaps = of_node.iter().enumerate().flat_map(|(k, a)| {
                of_node[..k].iter().filter(move |b| a.1.dot(b.1) < SETTINGS.opposed_cosine).map(move |b| a.2 + b.2)
            });
            let gap = gaps.fold(f64::INFINITY, f64::min);
            let Owner::Node { sheet, node } = self.surfaces.owners[of_node[0].0 as usize] else { continue };
            let Some(half) = island.contacts[sheet as usize].surface.as_ref().map(|s| s.contact_offset()) else {
                continue;
            };
            if gap >= 2.0 * half || gap <= 0.0 {
                continue;
            }
            let (sheet, part) = (island.sheet(sheet), gap / (2.0 * half));
            let area = sheet.model.mass[node as usize] / (sheet.material().density * 2.0 * half);
            let force = (sheet.material().young * area * (1.0 - part)).min(SETTINGS.maximum_compression);
            self.surfaces.squeezed.push(Squeeze {
                vertex: of_node[0].0,
                part: part / (1.0 - 0.5 * SETTINGS.range),
                force,
            });
        }
    }
}
