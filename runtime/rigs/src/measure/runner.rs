//! Stepping of a world with CPU time.

use cpu_time::ProcessTime;
use serde_json::Value;

use crate::measure::contact_observer::ContactObserver;
use crate::measure::{RigOutcome, Setup, object};
use sheetwork::World;

/// A world, and the CPU time of its steps.
pub(crate) struct Runner {
    pub world: World,
    outcome: RigOutcome,
}

impl Runner {
    pub fn new(world: World) -> Self {
        Self { world, outcome: RigOutcome::default() }
    }

    /// Steps for `duration` s and calls `watch` after each step. Ends early when `watch` returns
    /// false or the sheet becomes unstable. CPU time excludes `watch`.
    pub fn run(&mut self, duration: f64, mut watch: impl FnMut(&World) -> bool) {
        let end = self.world.time() + duration;
        while self.world.time() < end - 0.5 * self.world.dt() && self.world.unstable().is_none() {
            let start = ProcessTime::now();
            self.world.step();
            let taken = start.elapsed().as_secs_f64();
            self.outcome.cpu += taken;
            self.outcome.worst = self.outcome.worst.max(taken);
            if !watch(&self.world) {
                break;
            }
        }
    }

    /// Brings the sheet to rest and returns the number of linear solves.
    ///
    /// The default is an equilibrium solution. With `setup.dynamic` the world is stepped until all
    /// nodes have been slower than 1 mm/s for 0.5 s, at most 10 s.
    pub fn bring_to_rest(&mut self, setup: &Setup) -> u64 {
        if !setup.dynamic {
            let start = ProcessTime::now();
            let found = self.world.find_equilibrium(1e-9 * setup.length);
            self.outcome.cpu += start.elapsed().as_secs_f64();
            self.outcome.settled = Some(found.iter().all(|e| e.converged));
            self.outcome.stable = Some(found.iter().all(|e| e.is_stable));
            return found.iter().map(|e| u64::from(e.solves)).sum();
        }
        let mut quiet = 0.0;
        self.run(10.0, |world| {
            quiet = if world.sheets()[0].max_speed() < 1e-3 { quiet + world.dt() } else { 0.0 };
            quiet < 0.5
        });
        self.outcome.settled = Some(quiet >= 0.5);
        self.world.sheets()[0].state.counters.evaluations
    }

    /// Outcome with the keys of all rigs with contact, and the rig's own; `scale` is the energy (J)
    /// of the situation.
    pub fn contact_outcome(self, watch: &ContactObserver, scale: f64, own: Value) -> RigOutcome {
        let mut keys = watch.keys(&self.world, scale);
        keys.extend(object(own));
        self.outcome(Value::Object(keys))
    }

    pub fn outcome(self, keys: Value) -> RigOutcome {
        let status = self.world.report(0.0, &[]).status;
        RigOutcome {
            keys: object(keys),
            dt: self.world.dt(),
            steps: self.world.steps(),
            simulated: self.world.time(),
            status,
            ..self.outcome
        }
    }
}
