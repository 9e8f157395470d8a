//! Contact of sheets with rigid bodies, with each other and with themselves.
//!
//! Every contact joins a point of a sheet to a point of a body or sheet. Its gap g (m) along the
//! unit normal n and its force p (N) obey the Signorini conditions and Coulomb's law with friction
//! coefficient μ:
//!
//!   0 ≤ g ⊥ p_n ≥ 0,   |p_t| ≤ μ p_n,   p_t = -μ p_n u_t/|u_t| in slip.
//!
//! `islands/implicit_step` steps an island with implicit integrators. For each stage of the
//! integrator it runs:
//!
//! 1. Free motion: each sheet solves its linearised stage problem without contact.
//! 2. Detection (`collision`): contacts that the free motion may close, with keys that identify
//!    them from step to step (`detected_contacts`).
//! 3. Position solve: forces p and displacements δ with H δ = Jᵀ p, where H = M/h² + K is the
//!    tangent matrix of sheets and bodies, h (s) the weight of the stage and J the contact
//!    Jacobian. Penetration is removed; friction acts against the tangential displacement of the
//!    stage.
//! 4. Update: the iterate moves by free motion plus δ. Steps 1 to 4 are the outer iteration
//!    (`outer_iteration`). It ends when the strain is the predicted one and no surface penetrates
//!    another (`convergence`).
//! 5. Velocity solve: the same matrix for the contacts that are closed, with restitution.
//!
//! If the outer iteration fails, `islands/implicit_step` bisects the step, and at the shortest
//! substep falls back to rigid motion or freezes the island.
//!
//! All data of these phases is in one struct, `workspace::ContactWorkspace`. `solver/choice`
//! chooses the contact solver:
//!
//! | solver | unknowns | used when |
//! |---|---|---|
//! | `solver/dual` | contact forces | the working set is small compared to the nodes |
//! | `solver/primal` | displacements | there are many contacts |
//! | `solver/alart_curnier` | contact forces | the dual solver stagnates, up to 128 contacts |
//! | `solver/pgs_working_set` | contact forces | explicit integrators; last fallback of one sheet |
//!
//! Dual and primal solver share one method, `solver/augmented_lagrangian`: a semismooth Newton
//! method in either set of unknowns, with an interior point method for the primal one when many
//! contacts change state. `solver/pgs_working_set` is projected Gauss-Seidel (PGS). Every solver
//! starts from the contact cache (`contact_cache`) and leaves displacements and velocity jumps in
//! the sheets and in the solver bodies (`solver_body`).
//!
//! To add a friction law, extend `coulomb::ContactLaw` and follow its uses: `coulomb` solves one
//! contact, `solver/augmented_lagrangian/contact_state` projects a force and differentiates the
//! projection, `solver/augmented_lagrangian/interior_point` smooths the law, `solver/alart_curnier`
//! forms residual and derivative, `solver/pgs` projects a force.
//!
//! With explicit integrators, nodes meet kinematic and static bodies one by one, without a solver
//! (`node`; thesis 4.6 and appendix B). Their other contacts go through PGS with H = M/h², those
//! of lattices alone and of sheets with bonds through `solver/lattice_sweeps`.
//!
//! `adhesion` adds the tensile forces of hot sheets to the applied forces; with explicit
//! integrators they are bounds of the contact forces (`explicit_bonds`). `attachment_spin` corrects
//! the spin of bodies with attached sheets. Contact knows positions, velocities, masses and the
//! tangent matrix of a sheet, not its elements.
//!
//! Rapier works in `f32` in the frame of each body. Positions are transformed to that frame in
//! `f64`, so that distance from the origin costs no accuracy.

pub(crate) mod adhesion;
pub(crate) mod attachment_spin;
pub(crate) mod barrier;
pub(crate) mod closed_contacts;
pub(crate) mod compression;
pub(crate) mod contact_cache;
pub(crate) mod convergence;
pub mod coulomb;
pub(crate) mod counters;
pub(crate) mod detected_contacts;
pub(crate) mod explicit_bonds;
pub(crate) mod gap;
pub(crate) mod impulse_log;
pub(crate) mod island_view;
pub mod node;
pub(crate) mod outer_iteration;
pub(crate) mod penetration;
pub(crate) mod relative_motion;
pub(crate) mod settings;
pub(crate) mod sheet_contact;
pub(crate) mod solve_policy;
pub mod solver;
pub(crate) mod solver_body;
pub(crate) mod step_bodies;
#[cfg(test)]
pub(crate) mod test_island;
pub(crate) mod workspace;

pub use crate::contact::counters::ContactCounters;
pub(crate) use crate::contact::island_view::IslandView;
pub(crate) use crate::contact::sheet_contact::SheetContact;
