//! Velocities after the barrier method: bodies, and impacts of kinematic bodies.
//!
//! One pass over the active stencils. At a stencil the features have the relative velocity u = Σ
//! w_i v_i and the inverse mass Σ w_i²/m_i. A kinematic body that approaches faster than the
//! sheet leaves (u·n < 0) gives it its own normal velocity: the mean velocity of the substep is
//! smaller where they met within it.

use glam::{DMat3, DVec3};

use crate::contact::IslandView;
use crate::contact::barrier::stencil::Stencil;
use crate::contact::barrier::surfaces::Owner;
use crate::contact::barrier::{BarrierSolver, PairFriction, displacement};
use crate::contact::settings::{BarrierSettings, ContactSettings};

const SETTINGS: BarrierSettings = ContactSettings::DEFAULT.barrier;

impl BarrierSolver {
    /// Set the states of the bodies after a substep of `h` (s), and apply the impacts of
    /// kinematic bodies to the velocities of the sheets.
    pub fn finish(&mut self, island: &mut IslandView, friction: PairFriction, h: f64) {
        for (solver_body, now) in island.solver_bodies.iter_mut().zip(&self.bodies) {
            let (shift, turn) = displacement(&solver_body.free, now);
            solver_body.start = if solver_body.is_dynamic() {
                now.with_velocity(solver_body.free.velocity() + shift / h, solver_body.free.spin() + turn / h)
            } else {
                solver_body.free
            };
        }
        self.step.fill(DVec3::ZERO);
        self.surfaces.find(island, &self.step, &|pair| friction(island, pair), &mut self.active);
        let active = std::mem::take(&mut self.active);
        for stencil in &active {
            let Some(stiffness) = self.stiffness(stencil) else { continue };
            let closest = stencil.closest(self.corners(stencil));
            let [_, first, _] = stencil.barrier(closest.distance, stiffness);
            if first < 0.0 && first.is_finite() {
                self.apply_impulses(island, stencil, (closest.normal, closest.weights));
            }
        }
        self.active = active;
    }

    fn apply_impulses(&self, island: &mut IslandView, stencil: &Stencil, (normal, weights): (DVec3, [f64; 4])) {
        let (mut velocity, mut mobility, mut is_led) = (DVec3::ZERO, DMat3::ZERO, false);
        let mut share = 0.0;
        for (vertex, weight) in stencil.vertices.iter().zip(weights) {
            let x = self.surfaces.x[*vertex as usize];
            match self.surfaces.owners[*vertex as usize] {
                Owner::Node { sheet, node } => {
                    let sheet = island.sheet(sheet);
                    velocity += sheet.state.v.get(node as usize) * weight;
                    if self.compliance[*vertex as usize] > 0.0 {
                        share += weight * weight;
                        mobility += DMat3::IDENTITY * (weight * weight * sheet.inverse_mass[node as usize]);
                    }
                }
                Owner::Body { body, .. } => {
                    let state = &island.solver_bodies[body as usize].start;
                    velocity += state.velocity_at(x) * weight;
                    is_led |= !state.is_dynamic() && weight != 0.0;
                    if state.is_dynamic() {
                        mobility += state.mobility(x, x) * (weight * weight);
                    }
                }
            }
        }
        let approach = velocity.dot(normal);
        // A stencil whose free nodes hardly take part would give them any velocity.
        if !is_led || approach >= 0.0 || share < SETTINGS.least_share {
            return;
        }
        let impulse = normal * (-approach / normal.dot(mobility * normal));
        if !impulse.is_finite() {
            return;
        }
        for (vertex, weight) in stencil.vertices.iter().zip(weights) {
            match self.surfaces.owners[*vertex as usize] {
                Owner::Node { sheet, node } => {
                    if self.compliance[*vertex as usize] > 0.0 {
                        let sheet = island.sheet_mut(sheet);
                        let by = impulse * (weight * sheet.inverse_mass[node as usize]);
                        sheet.state.v.add(node as usize, by);
                    }
                }
                Owner::Body { body, .. } => {
                    let x = self.surfaces.x[*vertex as usize];
                    let state = &mut island.solver_bodies[body as usize].start;
                    *state = state.with_impulse_at(impulse * weight, x);
                }
            }
        }
    }
}
