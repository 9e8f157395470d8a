//! What comes back from the world: the last two states of a sheet or body, and how a sheet fares.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use sheetwork::sheet::{Sheet as SheetInWorld, Status, Vectors};

use super::{Sheet, SheetBody};

/// How a sheet fares, brought up to date every tick.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
pub struct SheetState {
    /// Centre of mass in world space, m.
    pub centre: Vec3,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vec3,
    /// Masses that touched a body in the last step.
    pub contacts: u32,
    /// Whether it has come to rest and is not stepped until something wakes it.
    pub asleep: bool,
    /// Whether it went unstable and was stopped.
    pub unstable: bool,
}

impl SheetState {
    pub(super) fn of(sheet: &SheetInWorld) -> Self {
        Self {
            centre: sheet.centre_of_mass().as_vec3(),
            velocity: (sheet.momentum() / sheet.total_mass()).as_vec3(),
            contacts: sheet.touching().iter().filter(|t| **t).count() as u32,
            asleep: sheet.status == Status::Asleep,
            unstable: matches!(sheet.status, Status::Unstable { .. }),
        }
    }
}

/// A sheet's place in the [`SheetWorld`](super::SheetWorld) and its masses before and after the last tick.
///
/// Put on the entity when its sheet is built, and taken off with its [`Sheet`].
#[derive(Component, Clone, Debug)]
pub struct SheetMotion {
    name: String,
    generation: u32,
    built_from: Sheet,
    before: Vectors,
    after: Vectors,
    moving: bool,
    revision: u64,
}

impl SheetMotion {
    pub(crate) fn new(name: String, generation: u32, built_from: Sheet, x: &Vectors) -> Self {
        Self { name, generation, built_from, before: x.clone(), after: x.clone(), moving: false, revision: 0 }
    }

    /// The sheet's name in the world: `world.sheet(motion.name())`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Positions of the masses before the last tick, m.
    pub fn before(&self) -> &Vectors {
        &self.before
    }

    /// Positions of the masses now, m.
    pub fn after(&self) -> &Vectors {
        &self.after
    }

    /// Whether it moved in the last tick.
    pub fn is_moving(&self) -> bool {
        self.moving
    }

    /// Where mass `i` is shown at fraction `s` (0 to 1) of the way from the last tick but one to the last; `None` when
    /// there is no such mass.
    pub fn at(&self, i: usize, s: f32) -> Option<Vec3> {
        (i < self.after.len()).then(|| self.before.get(i).lerp(self.after.get(i), f64::from(s)).as_vec3())
    }

    /// Changes whenever what is to be drawn may have changed other than by the fraction of the tick.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    pub(super) fn generation(&self) -> u32 {
        self.generation
    }

    pub(super) fn built_from(&self) -> &Sheet {
        &self.built_from
    }

    /// Takes in where the masses are after a tick. Nothing is allocated.
    pub(super) fn push(&mut self, x: &Vectors) {
        if *x != self.after {
            std::mem::swap(&mut self.before, &mut self.after);
            copy(&mut self.after, x);
            self.moving = true;
            self.revision += 1;
        } else if self.moving {
            copy(&mut self.before, &self.after);
            self.moving = false;
            self.revision += 1;
        }
    }
}

/// Copies in place where the number of masses is the same, which it is but for a sheet that was built anew.
fn copy(to: &mut Vectors, from: &Vectors) {
    if to.len() == from.len() {
        to.copy_from(from);
    } else {
        *to = from.clone();
    }
}

/// Position (m) and rotation.
pub(crate) type Pose = (DVec3, DQuat);

/// A body's place in the [`SheetWorld`](super::SheetWorld) and where it was before and after the last tick.
///
/// Put on the entity when its body is built, and taken off with its [`SheetBody`].
#[derive(Component, Clone, Debug)]
pub struct BodyMotion {
    pub(super) names: Vec<String>,
    pub(super) generation: u32,
    pub(super) built_from: SheetBody,
    /// The entity's own transform that the body was last sent to.
    pub(super) given: GlobalTransform,
    pub(super) before: Pose,
    pub(super) after: Pose,
    pub(super) led: bool,
}

impl BodyMotion {
    pub(crate) fn new(names: Vec<String>, generation: u32, built_from: SheetBody, given: GlobalTransform) -> Self {
        let pose = super::placement::pose_of(&given);
        let led = !built_from.path.is_empty();
        Self { names, generation, built_from, given, before: pose, after: pose, led }
    }

    /// The body's name in the world; a body of several polyhedra is as many bodies there, and this is the first's.
    pub fn name(&self) -> &str {
        self.names.first().map_or("", String::as_str)
    }

    /// Whether it goes by this name in the world.
    pub fn is_named(&self, name: &str) -> bool {
        self.names.iter().any(|n| n == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64) -> Vectors {
        let mut v = Vectors::default();
        v.push(DVec3::new(x, 0.0, 0.0));
        v
    }

    #[test]
    fn motion_keeps_the_last_two_states_and_settles_when_nothing_moves() {
        let mut motion = SheetMotion::new("leaf".into(), 0, Sheet::default(), &at(0.0));
        assert!(!motion.is_moving());
        motion.push(&at(1.0));
        motion.push(&at(3.0));
        assert!(motion.is_moving());
        assert_eq!(motion.at(0, 0.5), Some(Vec3::new(2.0, 0.0, 0.0)), "two steps in a frame: between the last two");
        let revision = motion.revision();
        motion.push(&at(3.0));
        assert!(!motion.is_moving());
        assert_eq!(motion.at(0, 0.25), Some(Vec3::new(3.0, 0.0, 0.0)));
        assert_ne!(motion.revision(), revision, "it has to be drawn once more, where it stopped");
        let revision = motion.revision();
        motion.push(&at(3.0));
        assert_eq!(motion.revision(), revision);
        assert_eq!(motion.at(1, 0.5), None);
    }
}
