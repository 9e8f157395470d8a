//! How the contact of a substep is solved: set by the islands, read by the outer iteration and the
//! solvers.

/// Demands on the contact solution of a substep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SolvePolicy {
    /// Whether the integrators of the island are explicit: nodes respond with their mass alone.
    pub is_explicit: bool,
    /// Whether an unconverged solution is accepted.
    pub accepts_unconverged: bool,
    /// Whether the substep is the shortest allowed one.
    pub is_shortest_substep: bool,
    /// Whether no substep of the step is the result of a bisection so far.
    pub is_unbisected_step: bool,
}
