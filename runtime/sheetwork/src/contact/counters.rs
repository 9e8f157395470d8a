//! Counters of the contact solver, for reports and for the work budget of a step.

use crate::serialize::{ReadResult, StateReader, StateWriter};

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

impl ContactCounters {
    /// Serialise the counters.
    pub(crate) fn serialise(&self, to: &mut StateWriter) {
        let mut copy = *self;
        copy.all_mut().into_iter().for_each(|count| to.count(*count));
    }

    /// Deserialise the counters.
    pub(crate) fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        self.all_mut().into_iter().try_for_each(|count| from.count().map(|value| *count = value))
    }

    /// All counters, in the order of their serialisation.
    fn all_mut(&mut self) -> [&mut u64; 9] {
        let Self { rounds, contacts, most, unsettled, sweeps, newton, factors, halved, given_up } = self;
        [rounds, contacts, most, unsettled, sweeps, newton, factors, halved, given_up]
    }
}
