//! Counters of the contact solver, for reports and for the work budget of a step.

use crate::serialize::state;

/// Counters of the contact solver since the start of the simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ContactCounters {
    /// Outer iterations with contact.
    pub rounds: u64,
    /// Contacts in the problem, summed over all outer iterations.
    pub contacts: u64,
    /// Largest number of contacts in one solve.
    pub most: u64,
    /// Solves that did not converge.
    pub unsettled: u64,
    /// PGS sweeps over all contacts.
    pub sweeps: u64,
    /// Newton iterations of the contact solvers.
    pub newton: u64,
    /// Matrix factorisations of the contact solvers.
    pub factors: u64,
    /// Step bisections.
    pub halved: u64,
    /// Substeps that ended in a fallback: the sheets moved rigidly or were frozen.
    pub given_up: u64,
}

state!(ContactCounters { rounds, contacts, most, unsettled, sweeps, newton, factors, halved, given_up });
