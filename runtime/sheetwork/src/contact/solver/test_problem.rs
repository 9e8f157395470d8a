//! Contact problems small enough to solve by hand, in the form that each contact solver takes.
//!
//! A problem is a tangent matrix H of a few nodes and contacts of these nodes with fixed bodies or
//! with each other. [`SmallProblem::solve`] gives it to one of the solvers and returns forces and
//! displacements in world axes, so that expected values are sums of forces.

use glam::{DMat3, DVec3};

use crate::contact::coulomb::ContactLaw;
use crate::contact::solver::alart_curnier::AlartCurnierSolver;
use crate::contact::solver::augmented_lagrangian::{
    AugmentedLagrangian, AugmentedLagrangianTolerances, DualSpace, PrimalSpace, SolverConstraint, TangentMatrix,
};
use crate::contact::solver::delassus::frame_of;
use crate::linear::{Factor, Pattern, analyse};

/// Tolerances near the rounding error of displacements of centimetres.
pub(crate) const FINE: AugmentedLagrangianTolerances = AugmentedLagrangianTolerances {
    gap: 1e-10,
    balance: 1e-10,
    balance_late: 1e-10,
    maximum_bound_updates: 60,
    interior_point_iteration: 200,
    half_thickness: 2.5e-4,
    ..AugmentedLagrangianTolerances::SINGLE_SHEET
};

/// Tangent matrix of a few nodes. Its pattern covers contacts between any two of them.
pub(crate) struct SmallTangent {
    pattern: Pattern,
    values: Vec<f64>,
    with_contact: Vec<f64>,
    factor: Factor,
}

impl SmallTangent {
    /// A matrix of zeros for `nodes` nodes.
    pub fn new(nodes: u32) -> Self {
        let pairs = (0..nodes).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let pattern = Pattern::new(nodes as usize, pairs);
        let values = vec![0.0; 9 * pattern.blocks()];
        let places: Vec<[f64; 2]> = (0..nodes).map(|i| [f64::from(i), 0.0]).collect();
        let factor = analyse(&pattern, &places);
        Self { with_contact: values.clone(), pattern, values, factor }
    }

    /// Add a symmetric block (N/m) at row `i` and column `j`.
    pub fn add(&mut self, i: u32, j: u32, block: DMat3) {
        let at = 9 * self.pattern.slot(i.max(j), i.min(j)).expect("the pattern is full") as usize;
        for (to, value) in self.values[at..at + 9].iter_mut().zip(block.to_cols_array()) {
            *to += value;
        }
    }

    /// Add a spring with the stiffness matrix `k` (N/m) between `i` and `j`, or between `i` and a
    /// fixed point.
    pub fn add_spring(&mut self, i: u32, j: Option<u32>, k: DMat3) {
        self.add(i, i, k);
        if let Some(j) = j {
            self.add(j, j, k);
            self.add(i, j, -k);
        }
    }

    /// Diagonal block of node `i`, N/m.
    pub fn diagonal(&self, i: u32) -> DMat3 {
        let at = 9 * self.pattern.starts[i as usize] as usize;
        DMat3::from_cols_slice(&self.values[at..at + 9])
    }

    /// Number of nodes.
    fn nodes(&self) -> usize {
        self.pattern.size()
    }

    /// Displacement H⁻¹ Jᵀ p (m) by the forces `p` (N, contact frames) of `constraints`.
    fn displacement(&mut self, constraints: &[SolverConstraint], p: &[DVec3]) -> Vec<f64> {
        let mut x = vec![0.0; 3 * self.nodes()];
        constraints.iter().zip(p).for_each(|(c, p)| c.add_force(*p, &mut x));
        self.factorize_with(&mut |_| {});
        self.solve(&mut x);
        x
    }

    /// Dual form of the constraints: the Delassus operator J H⁻¹ Jᵀ.
    pub fn dual_space(&mut self, constraints: &[SolverConstraint]) -> DualSpace {
        let mut space = DualSpace::default();
        let problem = &mut space.delassus.problem;
        constraints.iter().for_each(|c| problem.push(c.law, DVec3::ZERO));
        for (j, constraint) in constraints.iter().enumerate() {
            let columns = DVec3::AXES.map(|axis| self.displacement(std::slice::from_ref(constraint), &[axis]));
            for (i, other) in constraints.iter().enumerate().skip(j) {
                let [x, y, z] = columns.each_ref().map(|x| other.displacement(x));
                problem.couple(i, j, DMat3::from_cols(x, y, z));
            }
        }
        space
    }
}

impl TangentMatrix for SmallTangent {
    fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    fn factorize_with(&mut self, add: &mut dyn FnMut(&mut [f64])) -> bool {
        self.with_contact.clone_from(&self.values);
        add(&mut self.with_contact);
        self.factor.factorize(&self.with_contact).is_ok()
    }

    fn solve(&mut self, right: &mut [f64]) {
        self.factor.solve(right);
    }
}

/// A contact solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// Augmented Lagrangian method in displacements.
    Primal,
    /// Augmented Lagrangian method in contact forces.
    Dual,
    /// Interior point method in displacements.
    InteriorPoint,
    /// Projected Gauss-Seidel method, repeated until the proximal term has no effect.
    Pgs,
    /// Alart-Curnier semismooth Newton method.
    AlartCurnier,
}

impl Method {
    /// Every contact solver.
    pub const ALL: [Self; 5] = [Self::Primal, Self::Dual, Self::InteriorPoint, Self::Pgs, Self::AlartCurnier];

    /// Relative accuracy of a force. The interior point method ends at an imbalance of 1e-5.
    pub fn accuracy(self) -> f64 {
        if self == Self::InteriorPoint { 1e-4 } else { 1e-7 }
    }
}

/// Solution of a [`SmallProblem`], in world axes.
#[derive(Debug)]
pub(crate) struct SmallSolution {
    /// Whether the solver says that it has converged.
    pub converged: bool,
    /// Force of each contact on its side a, N.
    pub force: Vec<DVec3>,
    /// Relative displacement of each contact, computed from the forces, m.
    pub u: Vec<DVec3>,
    /// Displacement of each node by the contact forces, m.
    pub displacement: Vec<DVec3>,
    /// Newton steps or Gauss-Seidel sweeps.
    pub iterations: u64,
}

/// A contact problem.
pub(crate) struct SmallProblem {
    pub tangent: SmallTangent,
    constraints: Vec<SolverConstraint>,
}

impl SmallProblem {
    /// Free nodes with `masses` (kg) in a stage of weight `h` (s): H = M/h².
    pub fn new(masses: &[f64], h: f64) -> Self {
        let mut tangent = SmallTangent::new(masses.len() as u32);
        for (i, m) in masses.iter().enumerate() {
            tangent.add(i as u32, i as u32, DMat3::IDENTITY * (m / (h * h)));
        }
        Self { tangent, constraints: Vec::new() }
    }

    /// Add a spring of stiffness `k` (N/m) in every direction between `i` and `j`, or between `i`
    /// and a fixed point.
    pub fn spring(mut self, i: u32, j: Option<u32>, k: f64) -> Self {
        self.tangent.add_spring(i, j, DMat3::IDENTITY * k);
        self
    }

    /// Add a contact of node `a` with node `b`, or with a fixed body. Without contact, a moves by
    /// `free` (m) relative to b from the position at which both touch.
    pub fn contact(mut self, a: u32, b: Option<u32>, normal: DVec3, free: DVec3, law: ContactLaw) -> Self {
        let mut constraint = SolverConstraint::new(frame_of(normal), law);
        constraint.add(a, DMat3::IDENTITY);
        if let Some(b) = b {
            constraint.add(b, -DMat3::IDENTITY);
        }
        constraint.b = constraint.frame.transpose() * free;
        self.constraints.push(constraint);
        self
    }

    /// Solve by `method` from zero forces.
    pub fn solve(&mut self, method: Method) -> SmallSolution {
        let zero = vec![DVec3::ZERO; self.constraints.len()];
        self.solve_from(method, &zero, false)
    }

    /// Solve by `method` from the forces `initial` (N, world axes), with which the contacts
    /// `slipped` or not.
    pub fn solve_from(&mut self, method: Method, initial: &[DVec3], slipped: bool) -> SmallSolution {
        let mut constraints = self.constraints.clone();
        let mut slots = Vec::new();
        for constraint in &mut constraints {
            constraint.compute_stiffness(|block| self.tangent.diagonal(block));
            constraint.look_up_slots(self.tangent.pattern(), &mut slots);
            constraint.slipped = slipped;
        }
        let mut force: Vec<DVec3> = constraints.iter().zip(initial).map(|(c, p)| c.frame.transpose() * *p).collect();
        let (converged, iterations) = match method {
            Method::Primal | Method::Dual | Method::InteriorPoint => {
                let mut solver = AugmentedLagrangian::default();
                solver.constraints.clone_from(&constraints);
                solver.force = force;
                let converged = match method {
                    Method::Dual => solver.solve(&mut self.tangent.dual_space(&constraints), &FINE),
                    _ => {
                        let start = if method == Method::Primal { FINE.interior_point_iteration } else { 0 };
                        let accuracy = AugmentedLagrangianTolerances { interior_point_iteration: start, ..FINE };
                        solver.solve(&mut PrimalSpace { tangent: &mut self.tangent, slots: &slots }, &accuracy)
                    }
                };
                force = std::mem::take(&mut solver.force);
                (converged, solver.steps)
            }
            Method::Pgs => self.solve_by_pgs(&constraints, &mut force),
            Method::AlartCurnier => {
                let mut solver = AlartCurnierSolver::default();
                let problem = &self.tangent.dual_space(&constraints).delassus.problem;
                let converged = solver.solve(problem, &constraints, &FINE, (&mut force, &mut Vec::new()));
                (converged, solver.steps)
            }
        };
        let delta = self.tangent.displacement(&constraints, &force);
        SmallSolution {
            converged,
            u: constraints.iter().map(|c| c.frame * (c.displacement(&delta) + c.b)).collect(),
            force: constraints.iter().zip(&force).map(|(c, p)| c.frame * *p).collect(),
            displacement: delta.chunks_exact(3).map(DVec3::from_slice).collect(),
            iterations,
        }
    }

    /// Solve by the projected Gauss-Seidel method from `force` (N, contact frames), until one sweep
    /// suffices. Returns whether it converged, and the number of sweeps.
    fn solve_by_pgs(&mut self, constraints: &[SolverConstraint], force: &mut Vec<DVec3>) -> (bool, u64) {
        let b: Vec<DVec3> = constraints.iter().map(|c| c.b).collect();
        let problem = &mut self.tangent.dual_space(constraints).delassus.problem;
        problem.force = std::mem::take(force);
        let (mut sweeps, mut last) = (0, u32::MAX);
        for _ in 0..500 {
            last = problem.solve(&b, 1e-12, 200).sweeps;
            sweeps += u64::from(last);
            if last == 1 {
                break;
            }
        }
        *force = std::mem::take(&mut problem.force);
        (last == 1, sweeps)
    }
}
