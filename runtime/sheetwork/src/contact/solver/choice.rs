//! Choice of the contact solver, and the position and velocity solve of one stage with it.
//!
//! The outer iteration (`outer_iteration`) calls [`ContactWorkspace::solve_positions`] once per
//! iteration. The position solve finds forces (N) that remove all penetration (m) of the linearised
//! free motion, with friction against the tangential displacement. After the outer iteration,
//! [`ContactWorkspace::solve_velocities`] finds the velocity jumps (m/s) of the contacts that are
//! closed, with restitution. Positions and velocities need separate solves: with a single one, a
//! sheet that should not rebound separates with two thirds of its approach speed.
//!
//! Islands with explicit integrators are solved by PGS, those of lattices alone or with bonds on
//! their nodes. The
//! others are solved by the dual solver for a small working set, otherwise by the primal solver; a
//! single sheet is solved once more by the dual solver if the primal one fails, and by PGS as the
//! last fallback.

use crate::collision::constraint::{ContactConstraint, ContactSide};
use crate::contact::IslandView;
use crate::contact::solver::lattice_sweeps::is_of_lattices;
use crate::contact::workspace::ContactWorkspace;
use crate::sheet::stage;

/// The contact solver that found the positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum PositionSolver {
    /// Dual solver: unknowns are the contact forces.
    #[default]
    Dual,
    /// Primal solver: unknowns are the displacements of nodes and bodies.
    Primal,
    /// Projected Gauss-Seidel.
    Pgs,
    /// Gauss-Seidel on the nodes of explicit lattices.
    Lattice,
}

/// Result of a position solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PositionSolve {
    /// Nothing overlaps.
    Separate,
    /// The penetration is removed by contact forces, or an unconverged solution is accepted.
    Touched,
    /// No solver converged.
    Failed,
}

impl ContactWorkspace {
    /// Remove the penetration of the free motion, in a stage of weight `h` (s). The displacements
    /// are left in the contact arrays of the sheets and in the solver bodies. `rough` lowers the
    /// accuracy.
    pub(crate) fn solve_positions(&mut self, island: &mut IslandView, h: f64, rough: bool) -> PositionSolve {
        self.half_thickness = island.half_thickness();
        self.gaps.measure(&self.detected.contacts, island);
        let is_needed = self.policy.is_explicit && self.has_bonds
            || self.detected.first_attachment < self.detected.contacts.len()
            || self.detected.contacts.iter().any(|contact| contact.compressed.is_some())
            || !self.gaps.free.iter().all(|g| *g >= 0.0);
        if !is_needed {
            if !self.policy.is_explicit {
                self.forget_solution(island);
            }
            return PositionSolve::Separate;
        }
        if self.policy.is_explicit && (self.has_bonds || is_of_lattices(island, &self.detected)) {
            self.solve_positions_on_nodes(island, h);
            self.position_solver = PositionSolver::Lattice;
        } else if self.policy.is_explicit {
            self.solve_positions_by_pgs(island, h);
            self.position_solver = PositionSolver::Pgs;
        } else if !self.choose_position_solver(island, h, rough) {
            if !self.policy.accepts_unconverged {
                return PositionSolve::Failed;
            }
            // An unconverged solution of several sheets is good enough for the next outer
            // iteration, and another solver takes too long.
            if self.is_single_sheet_on_fixed_bodies {
                // The primal solver has left contact in the factor.
                island.for_each_sheet(stage::restore_factor);
                self.solve_positions_by_pgs(island, h);
                self.position_solver = PositionSolver::Pgs;
            }
        }
        let count = match self.position_solver {
            PositionSolver::Pgs => self.pgs.delassus.problem.len(),
            PositionSolver::Lattice => self.lattice_sweeps.len(),
            _ => self.working_set.len(),
        };
        self.gaps.update(&self.detected.contacts, island);
        self.counters.rounds += 1;
        self.counters.contacts += count as u64;
        self.counters.most = self.counters.most.max(count as u64);
        PositionSolve::Touched
    }

    /// Position solve: dual solver for a small working set, otherwise primal solver, and for a
    /// single sheet the dual solver again if the primal one fails. Returns false if none converges.
    fn choose_position_solver(&mut self, island: &mut IslandView, h: f64, rough: bool) -> bool {
        let within =
            |c: &ContactConstraint| matches!((c.a, c.b), (ContactSide::Sheet { .. }, ContactSide::Sheet { .. }));
        let is_folded = island.sheets.len() == 1 && self.detected.contacts.iter().any(within);
        self.is_single_unfolded_sheet = island.sheets.len() == 1 && !is_folded;
        self.is_single_sheet_on_fixed_bodies =
            island.sheets.len() == 1 && island.solver_bodies.iter().all(|m| !m.is_dynamic());
        self.island_tangent.lay_out(island);
        self.store_node_normals(island);
        self.position_solver = PositionSolver::Dual;
        let on_forces =
            if self.is_dual_affordable(island) { self.solve_positions_dual(island, h, rough) } else { None };
        on_forces.unwrap_or_else(|| {
            self.position_solver = PositionSolver::Primal;
            let factors = self.counters.factors;
            let settled = self.solve_positions_primal(island, h, rough);
            let size = self.detected.contacts.len() + island.nodes();
            self.work += (self.counters.factors - factors) * size as u64;
            settled
                || island.sheets.len() == 1 && {
                    self.position_solver = PositionSolver::Dual;
                    self.retry_positions_dual(island, h, rough)
                }
        })
    }

    /// Solve the velocities of the contacts that the last position solve closed, in a stage of
    /// weight `h` (s). The velocity jumps are left in the contact arrays of the sheets and in the
    /// solver bodies. Returns whether the solution is accepted.
    pub fn solve_velocities(&mut self, island: &mut IslandView, h: f64) -> bool {
        self.impulses.set_stage_forces(std::iter::empty());
        if self.position_solver == PositionSolver::Lattice {
            self.solve_velocities_on_nodes(island, h);
            return true;
        }
        if self.position_solver != PositionSolver::Pgs {
            let settled = match self.position_solver {
                PositionSolver::Dual => self.solve_velocities_dual(island, h),
                _ => {
                    self.solve_velocities_primal(island, h)
                        || self.transfer_to_dual(island, h) && self.solve_velocities_dual(island, h)
                }
            };
            if settled || !self.policy.accepts_unconverged || !self.is_single_sheet_on_fixed_bodies {
                return settled || self.policy.accepts_unconverged;
            }
            island.for_each_sheet(stage::restore_factor);
            let mut pgs = std::mem::take(&mut self.pgs);
            pgs.begin_closed(self, island, h);
            self.pgs = pgs;
        }
        self.solve_velocities_by_pgs(island, h);
        true
    }
}
