//! Snapshots: stored states of a world for rollback.
//!
//! In the world of the snapshot, restoring is bit-exact (`serialise`). Parameters keep their
//! present values, so that a snapshot is a start for trying others. A world of another structure
//! with the same sheets and bodies (after an edit of the scene) takes over time, positions,
//! velocities, temperatures, the state of heat, creep and plasticity, and sleeping; its integrators
//! restart, as after a change of integrator.

use crate::error::{InputError, SnapshotError};
use crate::islands::contact_log::ContactLog;
use crate::rigid::BodyState;
use crate::serialize::CorruptState;
use crate::sheet::{SavedSheetState, snapshot};
use crate::world::World;

/// State of a world at one time.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Serialised world.
    whole: Vec<u8>,
    time: f64,
    steps: u64,
    sheets: Vec<(String, SavedSheetState)>,
    /// Dynamic bodies: index, state, whether asleep.
    bodies: Vec<(usize, BodyState, bool)>,
    touches: Vec<ContactLog>,
    events: usize,
}

impl Snapshot {
    /// Simulated time of the snapshot, s.
    pub fn time(&self) -> f64 {
        self.time
    }
}

impl World {
    /// Store the present state.
    pub fn snapshot(&self) -> Snapshot {
        let rigid = self.rigid.as_deref();
        let free = |i: usize| {
            let rigid = rigid?;
            let state = rigid.state(i).filter(|s| s.is_dynamic())?;
            Some((i, *state, rigid.is_asleep(i)))
        };
        Snapshot {
            whole: self.serialise(),
            time: self.time,
            steps: self.steps,
            sheets: self.sheets.iter().map(|s| (s.name.clone(), snapshot::to_state(s))).collect(),
            bodies: (0..rigid.map_or(0, |r| r.bodies().len())).filter_map(free).collect(),
            touches: self.contact_logs.clone(),
            events: self.events.len(),
        }
    }

    /// Return to a snapshot of this world, or of one with the same sheets and bodies.
    ///
    /// # Errors
    /// When sheets or bodies have been added, removed or replaced after it; nothing changes then.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        if self.roll_back(&snapshot.whole) {
            return Ok(());
        }
        let same = |(sheet, (name, state)): (&crate::sheet::Sheet, &(String, SavedSheetState))| {
            sheet.name == *name && snapshot::accepts_state(sheet, state)
        };
        let sheets = self.sheets.len() == snapshot.sheets.len() && self.sheets.iter().zip(&snapshot.sheets).all(same);
        let gives = |i: usize| self.rigid.as_deref().and_then(|r| r.state(i)).is_some_and(|s| s.is_dynamic());
        let free = (0..self.rigid.as_deref().map_or(0, |r| r.bodies().len())).filter(|i| gives(*i)).count();
        let bodies = free == snapshot.bodies.len() && snapshot.bodies.iter().all(|b| gives(b.0));
        if !(sheets && bodies) {
            let problem = "is of other sheets or bodies than there are now";
            return Err(SnapshotError::OtherWorld(InputError::new("snapshot", problem)));
        }
        for (sheet, (_, state)) in self.sheets.iter_mut().zip(&snapshot.sheets) {
            let unreadable = |CorruptState| SnapshotError::Damaged(InputError::new("snapshot", "cannot be read"));
            snapshot::restore(sheet, state).map_err(unreadable)?;
        }
        if let Some(rigid) = &mut self.rigid {
            for (index, state, asleep) in &snapshot.bodies {
                rigid.set_state(*index, *state);
                if *asleep {
                    rigid.put_to_sleep(*index);
                }
            }
        }
        self.heat.iter_mut().for_each(|heat| heat.discard_views());
        self.contact_logs.clone_from(&snapshot.touches);
        self.events.truncate(snapshot.events);
        (self.time, self.steps) = (snapshot.time, snapshot.steps);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn world() -> World {
        let scene = Scene::parse(
            r#"(engine: "euler-richardson", dt: 0.005, room: (x: (-1, 1), y: (0, 1), z: (-1, 1)),
                sheets: [(name: "leaf", structure: "shell", grid: (6, 1, 5), size: (0.2, 0.15), material: "pet",
                    placement: (position: (0, 0.05, 0)))],
                bodies: [(name: "ball", shape: Ball(0.02), mass: 0.01, placement: (position: (0.3, 0.2, 0)))])"#,
        );
        World::new(&scene.expect("valid")).expect("valid")
    }

    #[test]
    fn runs_from_a_snapshot_are_identical() {
        let mut world = world();
        world.advance(0.08);
        let snapshot = world.snapshot();
        assert!((snapshot.time() - 0.08).abs() < 1e-12);
        let run = |world: &mut World| {
            world.advance(0.1);
            let ball = world.body_state("ball").expect("there").origin();
            (world.sheets()[0].state.x.clone(), ball, world.time(), world.steps(), world.events().len())
        };
        let first = run(&mut world);
        world.restore(&snapshot).expect("of this world");
        assert!((world.time() - 0.08).abs() < 1e-12);
        let second = run(&mut world);
        world.restore(&snapshot).expect("of this world");
        let third = run(&mut world);
        assert_eq!((&second.0, second.1, second.2), (&third.0, third.1, third.2));
        assert_eq!((first.2, first.3, first.4), (second.2, second.3, second.4));
        let apart = first.0.iter().zip(second.0.iter()).map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
        assert!(apart < 1e-3 && first.1.distance(second.1) < 1e-6, "{apart}");
    }

    /// A clamped strip and a lattice that an oven softens, so that they sag permanently, in
    /// strongly damping air. A state that is not restored stays visible for long.
    #[test]
    fn a_snapshot_restores_heat_creep_and_plasticity() {
        let scene = Scene::parse(
            r#"(engine: "tr-bdf2", dt: 0.02, time_lapse: 10, air: (factor: 0.9),
                oven: (convection: 20, schedule: [(time: 0, temperature: 150)]),
                sheets: [(name: "hot", structure: "shell", grid: (9, 1, 3), size: (0.2, 0.05), material: "hips", creep: true,
                        pins: [(region: Left, clamp: true)]),
                    (name: "lattice", structure: "slamm", grid: (5, 2, 3), size: (0.1, 0.05), material: "hips",
                        springs: Uniform, creep: true, placement: (position: (0, 0.3, 0)), pins: [(region: Left)])])"#,
        );
        let mut world = World::new(&scene.expect("valid")).expect("valid");
        let seen = |world: &World| {
            let of = |s: &crate::sheet::Sheet| (s.state.x.clone(), s.temperatures().map(<[f64]>::to_vec));
            world.sheets().iter().map(of).collect::<Vec<_>>()
        };
        world.advance(1.0);
        let snapshot = world.snapshot();
        let then = seen(&world);
        world.advance(1.0);
        let later = seen(&world);
        assert!(then[0].1 != later[0].1, "it warms");
        let mut ends = Vec::new();
        for _ in 0..2 {
            world.restore(&snapshot).expect("of this world");
            assert_eq!(seen(&world), then);
            world.advance(1.0);
            ends.push(seen(&world));
        }
        assert_eq!(ends[0], ends[1], "two runs from one snapshot");
        // Only the shell: a soft lattice falls differently, by millimetres, after a restart of its
        // integrator.
        for (a, b) in ends[0].iter().zip(&later).take(1) {
            let apart = a.0.iter().zip(b.0.iter()).map(|(p, q)| p.distance(q)).fold(0.0, f64::max);
            assert!(apart < 5e-4, "{apart} m from the run it was taken of");
            let (a, b) = (a.1.as_deref().unwrap_or_default(), b.1.as_deref().unwrap_or_default());
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.5), "as warm");
        }
    }

    #[test]
    fn a_snapshot_of_another_world_is_refused() {
        let mut world = world();
        let snapshot = world.snapshot();
        world.remove_sheet(world.sheet_id("leaf").expect("there"));
        let error = world.restore(&snapshot).expect_err("refused");
        assert!(matches!(error, SnapshotError::OtherWorld(_)) && error.problem.contains("other sheets"));
    }
}
