//! Report of a step: how the islands were solved, and what replaced a solution that was not found.

use crate::serialize::state;

/// How a step was solved, from best to worst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum StepOutcome {
    /// Every island converged in one step.
    #[default]
    Converged,
    /// An island was stepped in shorter substeps.
    Bisected,
    /// The contact solution of several sheets was accepted at the shortest substep before it
    /// converged.
    Unconverged,
    /// The barrier method replaced a substep.
    Barrier,
    /// The barrier method ended before it converged: motion may lag.
    Fallback,
    /// Sheets were stopped for the rest of the step, and are unstable or frozen from now on; or
    /// joints were removed.
    Stopped,
}

/// Counts of a step of a world, or of one island.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct StepReport {
    /// Islands with an awake sheet.
    pub islands: u32,
    /// Bisections that lead to the shortest substep: 2 for a quarter of the step.
    pub deepest_bisection: u32,
    /// Substeps of several sheets accepted before the contact solution converged.
    pub unconverged: u32,
    /// Substeps that the barrier method solved in place of the contact solver.
    pub barrier: u32,
    /// Substeps in which the barrier method ended before it converged.
    pub fallbacks: u32,
    /// Islands that were stopped for the rest of the step, or sheets that became unstable in it,
    /// whichever are more.
    pub stopped: u32,
    /// Joints of bodies that were removed because their forces exceeded the range of Rapier's
    /// numbers.
    pub lost_joints: u32,
}

impl StepReport {
    /// The worst that happened in the step.
    pub fn outcome(&self) -> StepOutcome {
        match self {
            Self { stopped: 1.., .. } | Self { lost_joints: 1.., .. } => StepOutcome::Stopped,
            Self { fallbacks: 1.., .. } => StepOutcome::Fallback,
            Self { barrier: 1.., .. } => StepOutcome::Barrier,
            Self { unconverged: 1.., .. } => StepOutcome::Unconverged,
            Self { deepest_bisection: 1.., .. } => StepOutcome::Bisected,
            _ => StepOutcome::Converged,
        }
    }

    /// Add the counts of another island.
    pub(crate) fn add(&mut self, other: &Self) {
        self.islands += other.islands;
        self.deepest_bisection = self.deepest_bisection.max(other.deepest_bisection);
        self.unconverged += other.unconverged;
        self.barrier += other.barrier;
        self.fallbacks += other.fallbacks;
        self.stopped += other.stopped;
        self.lost_joints += other.lost_joints;
    }
}

state!(StepReport { islands, deepest_bisection, unconverged, barrier, fallbacks, stopped, lost_joints });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outcome_of_a_world_is_that_of_its_worst_island() {
        let mut world = StepReport::default();
        assert_eq!(world.outcome(), StepOutcome::Converged);
        world.add(&StepReport { islands: 1, deepest_bisection: 2, ..StepReport::default() });
        assert_eq!(world.outcome(), StepOutcome::Bisected);
        world.add(&StepReport { islands: 1, barrier: 2, fallbacks: 1, ..StepReport::default() });
        world.add(&StepReport { islands: 1, deepest_bisection: 1, ..StepReport::default() });
        assert_eq!((world.outcome(), world.islands, world.deepest_bisection), (StepOutcome::Fallback, 3, 2));
    }
}
