//! Contact solvers, primal (in displacements) and dual (in contact forces).
//!
//! With H the tangent matrix (N/m), J the contact Jacobian, W = J H⁻¹ Jᵀ the Delassus operator
//! (m/N) and b the relative position or velocity without contact, all solvers find forces p and u =
//! W p + b = J δ + b that obey Coulomb's law at every contact.
//!
//! - `choice`: choice of the solver, position and velocity solve of a stage.
//! - `primal`, `dual`: assemble the problem, choose the working set, store the result.
//! - `augmented_lagrangian`: semismooth Newton method in either set of unknowns; interior point
//!   method.
//! - `alart_curnier`: Newton method on normal force and friction bound together.
//! - `pgs`, `pgs_working_set`: projected Gauss-Seidel, and its working set.
//! - `lattice_sweeps`: Gauss-Seidel on the nodes of explicit lattices that meet one another.
//! - `sheet_response`: the share of a sheet; `delassus`: W; `force_newton`: linear systems in
//!   contact forces; `working_set`: choice of contacts.

pub(crate) mod alart_curnier;
pub(crate) mod augmented_lagrangian;
pub(crate) mod choice;
pub(crate) mod delassus;
pub(crate) mod dual;
pub(crate) mod force_newton;
pub(crate) mod lattice_sweeps;
pub mod pgs;
pub(crate) mod pgs_working_set;
pub(crate) mod primal;
pub(crate) mod sheet_response;
#[cfg(test)]
pub(crate) mod test_problem;
#[cfg(test)]
mod tests;
pub(crate) mod working_set;
