//! Settings of contact: tolerances, thresholds and iteration limits.
//!
//! Lengths are multiples of the half thickness of the thinnest sheet of the island, where a field
//! does not say otherwise; speeds are in m/s and forces in newtons.

use glam::DVec3;

use crate::scene::contact::MINIMUM_CONTACT_OFFSET;
use crate::units::settings::settings;

settings! {
    /// Settings of contact, by method.
    pub struct ContactSettings {
        /// Gap below which a contact is closed after the position solve. Closed contacts take
        /// part in the velocity solve.
        pub closed_gap: f64 = 0.04,
        /// Gap below which a contact is closed at the end of a step: that of the position
        /// solve, and as much for the motion of the other contacts after it.
        pub closed_gap_at_end: f64 = 0.08,
        /// Penetration that converged contact may leave at the end of a step. A larger one at
        /// the start of a stage existed before contact began; a fallback accepts an increase by
        /// this much.
        pub residual_penetration: f64 = 0.08,
        /// Cosine between two normals below which two contacts of the same features oppose each
        /// other.
        pub opposed_normal_cosine: f64 = -0.9,
        /// Contact offset of the second face on a compressed sheet, as a fraction of half the
        /// distance of the faces: this contact stays open.
        pub compressed_offset: f64 = 0.95,
        /// Impact distance. A contact with a gap above it at the start and a penetration above it
        /// after the free motion is an impact.
        pub impact_distance: f64 = 8.0,
        /// Depth inside a body, as a fraction of the sheet's diagonal, above which a node at the
        /// start of a stage was placed there by an edit of the scene.
        pub buried_depth: f64 = 0.1,
        /// Approach speed (m/s) above which restitution applies; resting contacts stay below it.
        pub restitution_speed: f64 = 0.2,
        /// Work budget of one step, in node-iterations: the sum of outer iterations × nodes,
        /// factorisations of the primal solver × (nodes + contacts), factorisations of the dual
        /// solver × contacts² / 16, PGS sweeps × contacts, and 4 × Newton steps of the barrier
        /// method × (nodes + pairs). Beyond it the outer iteration ends and the barrier method
        /// solves the remaining substeps; beyond as much again it takes few Newton steps. The
        /// largest value in the shipped scenes is 2.5 million: a ball that hits a house of fifteen
        /// cards.
        pub maximum_work: u64 = 4_000_000,
        /// Work budget of one step of a single sheet on kinematic and static bodies, in
        /// node-iterations. The largest value in the shipped scenes is 120,000: a film drawn onto
        /// its mould.
        pub maximum_work_of_single_sheet: u64 = 400_000,
        /// Contact of single nodes, for explicit integrators.
        pub node: NodeContactSettings = NodeContactSettings::DEFAULT,
        /// Barrier method.
        pub barrier: BarrierSettings = BarrierSettings::DEFAULT,
        /// Bonds.
        pub adhesion: AdhesionSettings = AdhesionSettings::DEFAULT,
        /// Convergence of the outer iteration.
        pub convergence: ConvergenceSettings = ConvergenceSettings::DEFAULT,
        /// Outer iteration: free motion, detection and position solve.
        pub outer_iteration: OuterIterationSettings = OuterIterationSettings::DEFAULT,
        /// Solution of one contact.
        pub coulomb: CoulombSettings = CoulombSettings::DEFAULT,
        /// Working set of contacts.
        pub working_set: WorkingSetSettings = WorkingSetSettings::DEFAULT,
        /// Primal solver: assembly and working set.
        pub primal: PrimalSettings = PrimalSettings::DEFAULT,
        /// Augmented Lagrangian iteration of the primal and dual solver.
        pub augmented_lagrangian: AugmentedLagrangianSettings = AugmentedLagrangianSettings::DEFAULT,
        /// Interior point method.
        pub interior_point: InteriorPointSettings = InteriorPointSettings::DEFAULT,
        /// Dual solver.
        pub dual: DualSettings = DualSettings::DEFAULT,
        /// Alart-Curnier semismooth Newton method.
        pub alart_curnier: AlartCurnierSettings = AlartCurnierSettings::DEFAULT,
        /// Projected Gauss-Seidel method.
        pub pgs: PgsSettings = PgsSettings::DEFAULT,
        /// PGS solver of contacts between nodes and dynamic bodies.
        pub node_sweeps: NodeSweepSettings = NodeSweepSettings::DEFAULT,
        /// Sweeps on the nodes of explicit lattices.
        pub lattice_sweeps: LatticeSweepSettings = LatticeSweepSettings::DEFAULT,
    }

    /// Barrier method.
    pub struct BarrierSettings {
        /// Least and greatest growth of the diagonal of a system that is not positive definite, as
        /// parts of its largest value.
        pub least_shift: f64 = 1e-3,
        pub maximum_shift: f64 = 10.0,
        /// Range of the barrier as a fraction of the thickness of the thinner sheet, or of the half
        /// thickness on a body: the accepted penetration.
        pub range: f64 = 0.1,
        /// Stiffness of the barrier as a multiple of that of its vertices in the stage.
        pub stiffness: f64 = 300.0,
        /// Stiffness of an attachment as a multiple of that of node and body in the stage.
        pub attachment: f64 = 1e4,
        /// Margin of the search as a fraction of the half thickness: rounding.
        pub search_margin: f64 = 1e-3,
        /// Velocity below which friction sticks, m/s.
        pub slip_speed: f64 = 1e-4,
        /// Least sum of squared weights of the free nodes of a stencil that takes the velocity of
        /// a body.
        pub least_share: f64 = 0.1,
        /// Fraction of a gap that a step keeps.
        pub kept_gap: f64 = 0.1,
        /// Least distance, as a fraction of that at the start of a substep, of features that start
        /// within the range: a sheet is compressed by less in a substep.
        pub kept_distance: f64 = 0.5,
        /// Sine of the angle below which two edges are parallel.
        pub parallel_sine: f64 = 1e-3,
        /// Cosine between the normals of a rectangle and their mean above which it does not meet
        /// itself.
        pub graph_cosine: f64 = 0.3,
        /// Maximum number of advancements of continuous collision detection for one stencil.
        pub maximum_advancements: u32 = 64,
        /// Maximum number of Newton steps: the work budget of a substep.
        pub maximum_iterations: u32 = 40,
        /// Maximum number of Newton steps of a substep beyond the work budget of the step.
        pub iterations_beyond_budget: u32 = 10,
        /// Work of a Newton step for each node and pair, in node-iterations.
        pub work: u64 = 4,
        /// Displacement of a Newton step, as a multiple of the free and prescribed motion, up to
        /// which it is taken for a led body even if it raises the potential.
        pub reach: f64 = 4.0,
        /// Displacement or rotation of a Newton step beyond which it is not a solution, m or rad.
        pub maximum_displacement: f64 = 1e6,
        /// Maximum number of halvings of a Newton step.
        pub maximum_halvings: u32 = 12,
        /// Fraction of the predicted fall of the potential that a step must reach (Armijo).
        pub sufficient_fall: f64 = 1e-4,
        /// Rise of the potential that the motion of led bodies may cause, as a multiple of their
        /// work by the force at the end: the mean force of a step is unknown.
        pub led_work: f64 = 2.0,
        /// Relative rise of the potential that counts as rounding.
        pub rounding: f64 = 1e-12,
        /// Speed of the reference kinetic energy of rounding, m/s.
        pub speed: f64 = 1.0,
        /// Displacement of the last Newton step, as a fraction of the half thickness.
        pub displacement: f64 = 2e-3,
    }

    /// Contact of single nodes, for explicit integrators.
    pub struct NodeContactSettings {
        /// Search margin around the swept box, as a fraction of the sheet's diagonal.
        pub search_margin: f64 = 0.05,
        /// Maximum number of iterations for nodes between two bodies.
        pub maximum_corner_iterations: usize = 3,
        /// Remaining path (m) below which a node is not tested again after a contact; it cannot
        /// penetrate deeper than that.
        pub minimum_remaining_path: f64 = 10.0 * MINIMUM_CONTACT_OFFSET,
        /// Cosine between two normals above which they belong to the same face.
        pub same_face_cosine: f64 = 1.0 - 1e-6,
        /// Radius of an unbounded body, m: the largest allowed coordinate.
        pub maximum_body_radius: f64 = 1e4,
        /// Approach speed (m/s) above which a node rebounds. A resting node falls into the surface
        /// by g dt per step and must stay on it.
        pub restitution_speed: f64 = 0.01,
        /// Vertices of the drawn surface per cell, along either side, that meet bodies: those that
        /// the editor draws.
        pub surface_parts: u32 = 5,
        /// Maximum number of sweeps over the contacts of the drawn surface.
        pub surface_sweeps: u32 = 30,
        /// Correction in a step below which the sweeps end.
        pub surface_tolerance: f64 = 0.004,
    }

    /// Bonds: load that a bond bears before it opens.
    pub struct AdhesionSettings {
        /// Acceleration of a node (m/s²) that a bond bears without an earlier load.
        pub node_acceleration: f64 = 200.0,
        /// Displacement (m) in a substep of an explicit integrator by a bond without an earlier
        /// load, whose acceleration it bounds: the free motion stays near the surface in long
        /// steps.
        pub node_displacement: f64 = 5e-5,
        /// Acceleration of a body that hangs on the sheet (m/s²) that its bonds bear without an
        /// earlier load.
        pub body_acceleration: f64 = 20.0,
        /// Maximum ratio of the bond force to the load in the last step.
        pub maximum_load_growth: f64 = 2.0,
    }

    /// Convergence of the outer iteration: displacements and penetrations.
    pub struct ConvergenceSettings {
        /// Displacement of all nodes below which a stage of a single sheet needs no further
        /// detection.
        pub displacement_single: f64 = 0.08,
        /// Displacement of all nodes below which a stage of several sheets needs no further
        /// detection. It is smaller because sheets would otherwise creep into each other.
        pub displacement_several: f64 = 0.008,
        /// Outer iterations with the finer penetration tolerance.
        pub fine_iterations: u32 = 5,
        /// Penetration tolerance of a single sheet in the first [`Self::fine_iterations`]
        /// iterations.
        pub fine_penetration: f64 = 0.04,
        /// Penetration tolerance: a tenth of the thickness.
        pub penetration: f64 = 0.2,
        /// Penetration of two sheets, as a fraction of the contact offset, above which they may
        /// exit on the opposite side.
        pub crossed_penetration: f64 = 0.1,
        /// Growth of the penetration of two sheets in a stage, as a fraction of the contact offset,
        /// that would add up from step to step.
        pub crossed_growth: f64 = 0.05,
    }

    /// Outer iteration: free motion, detection and position solve in turn.
    pub struct OuterIterationSettings {
        /// Maximum number of outer iterations of a single sheet.
        pub maximum_iterations_single: u32 = 10,
        /// Maximum number of outer iterations with several sheets, which rarely converge fully in
        /// an impact.
        pub maximum_iterations_several: u32 = 3,
        /// Maximum number of outer iterations with several sheets in the shortest substep, where
        /// interpenetration leads to a fallback.
        pub maximum_iterations_shortest_substep: u32 = 8,
        /// Additional outer iterations that may be used until the contact status of the last one
        /// agrees with that of the earlier ones.
        pub additional_iterations: u32 = 3,
        /// Outer iterations after which divergence is tested.
        pub iterations_before_divergence: u32 = 2,
        /// Strain error, as a multiple of the tolerance, that counts as divergence; the step is
        /// then bisected.
        pub divergence_threshold: f64 = 100.0,
        /// Strain error, as a multiple of the tolerance, that counts as divergence after the second
        /// outer iteration of several sheets, whose iterations are expensive.
        pub early_divergence_threshold: f64 = 1e4,
        /// Ratio of the penetration to that of the previous iteration above which the iteration has
        /// stagnated.
        pub stagnation_ratio: f64 = 0.8,
        /// Search margin.
        pub margin: f64 = 2.0,
        /// Search margin between several sheets as a fraction of [`Self::margin`].
        pub margin_between_several: f64 = 0.4,
        /// Maximum search margin.
        pub maximum_margin: f64 = 400.0,
        /// Maximum number of times that the margins are widened in one position solve.
        pub maximum_widenings: u32 = 3,
        /// Displacement by contact above which a single sheet is searched at its displaced
        /// position, as for a kinematic sheet that is pushed into a body in every step.
        pub displaced_search_distance: f64 = 20.0,
    }

    /// Fixed-point iteration on the friction bound of one contact.
    pub struct CoulombSettings {
        /// Maximum number of fixed-point iterations.
        pub maximum_iterations: u32 = 40,
        /// Maximum number of Newton steps of a substep beyond the work budget of the step.
        pub iterations_beyond_budget: u32 = 10,
        /// Work of a Newton step for each node and pair, in node-iterations.
        pub work: u64 = 4,
        /// Tolerance of the fixed-point iteration, as a fraction of the normal force.
        pub tolerance: f64 = 1e-12,
    }

    /// Working set: contacts that a solver includes, extended while others penetrate.
    pub struct WorkingSetSettings {
        /// Minimum number of contacts of a pair that are added at a time.
        pub minimum_addition: usize = 6,
        /// Maximum number of extensions of the working set in a solve.
        pub maximum_extensions: u32 = 40,
    }

    /// Primal solver: initial states, working set and tolerances.
    pub struct PrimalSettings {
        /// Gap at the start of the stage above which a contact counts as new and starts as
        /// closed.
        pub new_contact_gap: f64 = 4.0,
        /// Gap after the free motion above which contacts of several sheets are not in the
        /// working set.
        pub working_set_gap: f64 = 0.2,
        /// Gap above which contacts of several sheets are not in the working set, as a fraction of
        /// the deepest penetration.
        pub relative_working_set_gap: f64 = 0.05,
        /// Maximum of the enlarged margin. With a larger one, a second solve costs less than the
        /// additional contacts.
        pub maximum_enlarged_gap: f64 = 0.4,
        /// Gap tolerance of a single sheet as a fraction of the deepest penetration.
        pub gap_tolerance_single: f64 = 5e-5,
        /// Gap tolerance of several sheets as a fraction of the deepest penetration.
        pub gap_tolerance_several: f64 = 1e-2,
        /// Maximum of the gap tolerance of several sheets.
        pub maximum_gap_tolerance: f64 = 0.04,
        /// Maximum number of sheets that are solved with the finest settings for several sheets.
        pub maximum_sheets_of_finest: usize = 4,
        /// Maximum number of solves with an extended working set.
        pub maximum_solves: u32 = 2,
        /// Minimum number of constraints that one thread assembles.
        pub constraints_per_task: usize = 64,
    }

    /// Augmented Lagrangian iteration: when it changes method, weights, stagnation, line search.
    pub struct AugmentedLagrangianSettings {
        /// Fraction of contacts that open or close unexpectedly above which steps are regularised,
        /// or the interior point method is used.
        pub changes_threshold: f64 = 0.03,
        /// Iterations without regularisation after which [`Self::changes_threshold`] changes switch
        /// to the interior point method.
        pub iterations_before_interior_point: u32 = 3,
        /// Regularised iterations at which the residual decides whether to switch to the interior
        /// point method. Regularised steps that have not converged by then converge slowly or not
        /// at all.
        pub regularised_checks: [u32; 2] = [6, 10],
        /// Ratio of the residual to its initial value above which the first check switches.
        pub first_check_ratio: f64 = 0.5,
        /// Residual, as a multiple of the tolerance, above which the second check switches.
        pub second_check_residual: f64 = 4.0,
        /// Additional iterations for each update of the friction bounds.
        pub iterations_per_update: u32 = 6,
        /// Maximum number of iterations in contact forces, before additional ones; the primal
        /// solver may converge where they do not.
        pub maximum_iterations_in_forces: u32 = 20,
        /// Minimum relaxation factor of the friction bounds.
        pub minimum_relaxation: f64 = 0.1,
        /// Iterations after which the tolerance of the force balance is
        /// `AugmentedLagrangianTolerances::balance_late`.
        pub iterations_before_late_balance: u32 = 3,
        /// Weight of the gap of an attachment in the residual. On a stiff sheet, a gap of a
        /// micrometre between two attached rows of nodes means a force of newtons.
        pub attachment_weight: f64 = 100.0,
        /// Tolerance of the friction force as a fraction of the friction bound.
        pub friction_tolerance: f64 = 1e-3,
        /// Stagnation: relative decrease of the residual in an update of the forces below which it
        /// is accepted, if it also meets [`Self::stagnation_residual`]. Over-constrained contacts
        /// leave such a residual.
        pub stagnation_decrease: f64 = 0.1,
        /// Largest residual that is accepted after stagnation, as a multiple of the tolerance.
        pub stagnation_residual: f64 = 10.0,
        /// Ratio of the residual to that before an update of the forces above which the weights ρ
        /// grow. Many contacts that hold a soft sheet together are stiffer than each of them alone.
        pub slow_convergence_ratio: f64 = 0.4,
        /// Growth factor of the weights ρ.
        pub weight_growth: f64 = 5.0,
        /// Sum of forces, as a fraction of the largest sum in the solve, below which only rounding
        /// errors are left.
        pub rounding: f64 = 1e-6,
        /// Fraction of the total normal force below which a contact has no friction.
        pub negligible_force: f64 = 1e-6,
        /// Minimum tolerance of a friction bound, as a fraction of the total friction bound times
        /// [`Self::friction_tolerance`], for contacts with little force.
        pub minimum_bound_tolerance: f64 = 0.1,
        /// Maximum number of trial points of a line search.
        pub maximum_line_search_points: u32 = 12,
        /// Fraction of the initial slope of Φ at which a line search ends.
        pub line_search_slope: f64 = 0.1,
        /// Maximum ratio of the number of blocks with earlier contact pairs to that without them. A
        /// sparsity pattern that covers earlier pairs is reused up to this size.
        pub maximum_fill_ratio: f64 = 1.3,
    }

    /// Interior point method: iteration limit and acceptance at that limit.
    pub struct InteriorPointSettings {
        /// Maximum number of iterations; about twenty suffice for any number of contacts.
        pub maximum_iterations: u32 = 25,
        /// Value of m, as a fraction of its initial one, that is accepted at the iteration limit.
        pub accepted_mean: f64 = 1e-3,
        /// Error of gaps and slips that is accepted at the iteration limit.
        pub accepted_error: f64 = 0.004,
        /// Minimum of the penetration from which the path starts.
        pub least_penetration: f64 = 0.004,
        /// Minimum of the smoothing length ε.
        pub least_smoothing: f64 = 4e-6,
        /// Exponent with which the smoothing length ε decreases with m.
        pub smoothing_exponent: f64 = 0.75,
        /// Fraction of the step to the boundary that is taken, so that gaps and forces stay
        /// positive.
        pub boundary_fraction: f64 = 0.995,
    }

    /// Dual solver: when it is used, its working set and its work.
    pub struct DualSettings {
        /// Block rows per contact below which the primal solver is used: W is dense in the contacts
        /// of a sheet.
        pub minimum_rows_per_contact: usize = 7,
        /// Divisor of the work of a factorisation, which is the square of the number of contacts
        /// divided by this.
        pub work_divisor: u64 = 16,
        /// Penetration tolerance outside the working set.
        pub penetration: f64 = 0.004,
    }

    /// Alart-Curnier semismooth Newton method on normal and friction forces together.
    pub struct AlartCurnierSettings {
        /// Maximum number of contacts: the cost grows with the cube.
        pub maximum_contacts: usize = 128,
        /// Maximum number of iterations of a variant; doubled if it shortens steps.
        pub maximum_iterations: u32 = 20,
        /// Ratio of a contact force to the largest force that would open a single contact, above
        /// which contacts contradict each other. The ratio reaches 1000 in folds, and at least
        /// 10⁴ where a needle is touched from within.
        pub contradiction_ratio: f64 = 2000.0,
        /// Required relative decrease of the squared residual for a full step; proportional to the
        /// step length.
        pub required_decrease: f64 = 0.1,
        /// Relative addition to the diagonal of W in the matrix, which redundant contacts would
        /// make singular.
        pub diagonal_shift: f64 = 1e-9,
        /// Pivot, as a fraction of the largest entry, below which the matrix is singular.
        pub minimum_pivot: f64 = 1e-14,
    }

    /// Projected Gauss-Seidel method: sweeps, and Newton steps between them.
    pub struct PgsSettings {
        /// Tolerance of position solves, and of velocity solves per weight of the stage.
        pub tolerance: f64 = 4e-5,
        /// Maximum number of sweeps.
        pub maximum_sweeps: u32 = 200,
        /// ε of the proximal term, along the normal and the tangents.
        pub proximal: DVec3 = DVec3::new(3e-3, 1e-1, 1e-1),
        /// Maximum number of proximal iterations of a solve.
        pub maximum_proximal_iterations: u32 = 2,
        /// Sweeps before the first Newton steps.
        pub first_sweeps: u32 = 8,
        /// Sweeps between Newton steps.
        pub sweeps_between: u32 = 8,
        /// Newton steps at a time.
        pub newton_steps: u32 = 3,
        /// Maximum number of step lengths of a line search.
        pub maximum_step_lengths: u32 = 4,
    }

    /// Sweeps on the nodes of explicit lattices that meet one another.
    pub struct LatticeSweepSettings {
        /// Tolerance of position solves, and of velocity solves per step.
        pub tolerance: f64 = 0.004,
        /// Maximum number of sweeps of a solve. A stack of n layers needs about n² from rest, and
        /// a few from the forces of the step before.
        pub maximum_sweeps: u32 = 60,
        /// Gap after the sweeps from which on a bond is open: ten times their tolerance.
        pub open_gap: f64 = 0.04,
        /// Height above the limit of the thickness from which on a node is a contact, as a fraction
        /// of the rest height.
        pub thickness_margin: f64 = 0.2,
    }

    /// PGS solver of contacts between nodes and dynamic bodies: its working set.
    pub struct NodeSweepSettings {
        /// Penetration tolerance outside the working set. Explicit integrators use
        /// [`PgsSettings::tolerance`] instead: their steps are short, and penetration would add up.
        pub penetration: f64 = 0.04,
        /// Maximum number of sweeps before the working set is extended.
        pub rough_sweeps: u32 = 20,
        /// Maximum size of the working set without sheets and bodies. Further contacts wait for the
        /// next stage, since the cost grows with the cube.
        pub maximum_contacts: usize = 60,
        /// Increase of the maximum size of the working set per sheet and body.
        pub maximum_contacts_per_object: usize = 40,
    }
}
