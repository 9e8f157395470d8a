//! Joints, forces, velocities, collision groups and sensors of the world's own bodies.

use glam::DVec3;
use rapier3d::prelude::{GenericJoint, ImpulseJointHandle, InteractionGroups};

use crate::contact::node::detection::deepest_penetration;
use crate::error::{InputError, check_range};
use crate::rigid::body_loads::BodyLoad;
use crate::rigid::joints::check_joint;
use crate::rigid::{BodyState, RigidWorld};
use crate::sheet::Sheet;
use crate::units::parameters::ParameterId as Id;
use crate::world::World;
use crate::world::ids::BodyId;
use crate::world::loads::LoadSettings;
use crate::world::penetration::PenetrationSettings;

const SETTINGS: LoadSettings = LoadSettings::DEFAULT;
const PENETRATION: PenetrationSettings = PenetrationSettings::DEFAULT;

/// Id of a joint between two bodies of a [`World`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct JointId(ImpulseJointHandle);

impl World {
    /// Join two of the world's own bodies, at least one of them dynamic, by one of Rapier's joints:
    /// `RevoluteJointBuilder`, `PrismaticJointBuilder`, `SphericalJointBuilder`,
    /// `FixedJointBuilder`, `RopeJointBuilder`, `SpringJointBuilder` or `GenericJoint`, with
    /// limits and motors. Its frames are those of the bodies, m. The joint ends with its bodies.
    ///
    /// # Errors
    /// When a body does not exist, both are the same or none is dynamic, or a number of the joint
    /// is not finite.
    pub fn insert_joint(
        &mut self,
        a: BodyId,
        b: BodyId,
        joint: impl Into<GenericJoint>,
    ) -> Result<JointId, InputError> {
        let joint = joint.into();
        check_joint(&joint)?;
        let (rigid, first) = self.own_body(a)?;
        let second = self.own_body(b)?.1;
        let is_dynamic = |index| rigid.state(index).is_some_and(BodyState::is_dynamic);
        if first == second || !(is_dynamic(first) || is_dynamic(second)) {
            return Err(InputError::new("joint", "needs two different bodies, one of them dynamic"));
        }
        let rigid = self.rigid.as_mut().ok_or_else(no_body)?;
        Ok(JointId(rigid.insert_joint((first, second), joint)))
    }

    /// Joint `id`; `None` when it was removed, also with a body.
    pub fn joint(&self, id: JointId) -> Option<&GenericJoint> {
        Some(self.rigid.as_ref()?.joint(id.0)?.0)
    }

    /// Change the joint `id`, as its motors and limits, and wake its bodies. Returns `false` when
    /// it was removed.
    ///
    /// # Errors
    /// When a number of the joint is not finite; nothing changes then.
    pub fn set_joint(&mut self, id: JointId, joint: impl Into<GenericJoint>) -> Result<bool, InputError> {
        let joint = joint.into();
        check_joint(&joint)?;
        Ok(self.rigid.as_mut().is_some_and(|rigid| rigid.set_joint(id.0, joint)))
    }

    /// Remove the joint `id` and wake its bodies. Returns `false` when it was removed before.
    pub fn remove_joint(&mut self, id: JointId) -> bool {
        self.rigid.as_mut().is_some_and(|rigid| rigid.remove_joint(id.0))
    }

    /// Apply `force` (N, each component within ±1e6) to a dynamic body during the next step or the
    /// whole of the next advance, at the point of the body that is at `place` (m) now, or at its
    /// centre of mass. Forces add up.
    ///
    /// # Errors
    /// When the body does not exist or is not dynamic, or a number is out of range.
    pub fn apply_body_force(&mut self, id: BodyId, force: DVec3, place: Option<DVec3>) -> Result<(), InputError> {
        Id::RegionForce.check_each("force", force.to_array())?;
        let (body, local) = self.point_of_body(id, place)?;
        let rigid = self.rigid.as_mut().ok_or_else(no_body)?;
        rigid.add_load(BodyLoad { body, force, local });
        Ok(())
    }

    /// Apply `impulse` (N s, each component within ±1e6) to a dynamic body at once, as
    /// [`World::apply_body_force`].
    ///
    /// # Errors
    /// As [`World::apply_body_force`].
    pub fn apply_body_impulse(&mut self, id: BodyId, impulse: DVec3, place: Option<DVec3>) -> Result<(), InputError> {
        check_vector("impulse", impulse, SETTINGS.maximum_impulse, "N s")?;
        let (body, local) = self.point_of_body(id, place)?;
        let rigid = self.rigid.as_mut().ok_or_else(no_body)?;
        rigid.apply_impulse(body, impulse, local);
        Ok(())
    }

    /// Set the velocity of the centre of mass (m/s) and the angular velocity (rad/s) of a dynamic
    /// body, each component within ±1e4.
    ///
    /// # Errors
    /// When the body does not exist or is not dynamic, or a number is out of range.
    pub fn set_body_velocity(&mut self, id: BodyId, velocity: DVec3, spin: DVec3) -> Result<(), InputError> {
        check_vector("velocity", velocity, SETTINGS.maximum_body_speed, "m/s")?;
        check_vector("spin", spin, SETTINGS.maximum_body_speed, "rad/s")?;
        let body = self.point_of_body(id, None)?.0;
        let rigid = self.rigid.as_mut().ok_or_else(no_body)?;
        rigid.set_velocity(body, velocity, spin);
        Ok(())
    }

    /// Set Rapier's collision groups of a body, for contact with other bodies. Sheets meet every
    /// body that is no sensor.
    ///
    /// # Errors
    /// When the body does not exist.
    pub fn set_body_groups(&mut self, id: BodyId, groups: InteractionGroups) -> Result<(), InputError> {
        let body = self.own_body(id)?.1;
        self.rigid.iter_mut().for_each(|rigid| rigid.set_groups(body, groups));
        Ok(())
    }

    /// Let a body be a sensor, which touches nothing, or solid again; sheets wake.
    /// [`SheetQueries::overlaps`](crate::SheetQueries::overlaps) tells which sheets are in it.
    ///
    /// # Errors
    /// When the body does not exist, or a sheet is in a body that is to be solid.
    pub fn set_body_sensor(&mut self, id: BodyId, is_sensor: bool) -> Result<(), InputError> {
        let body = self.own_body(id)?.1;
        let rigid = self.rigid.as_mut().ok_or_else(no_body)?;
        rigid.set_sensor(body, is_sensor);
        let deepest = |sheet: &Sheet| deepest_penetration(sheet, &rigid.view()) / sheet.material().thickness;
        if !is_sensor && self.sheets.iter().any(|sheet| deepest(sheet) > PENETRATION.depth) {
            rigid.set_sensor(body, true);
            return Err(InputError::new("sensor", "a sheet is in the body: move one of them before it is solid"));
        }
        self.sheets.iter_mut().for_each(Sheet::wake);
        Ok(())
    }

    /// The rigid world and the index of the body `id`.
    fn own_body(&self, id: BodyId) -> Result<(&RigidWorld, usize), InputError> {
        self.rigid.as_ref().zip(self.body_ids.position(id.0)).ok_or_else(no_body)
    }

    /// Index of a dynamic body and the point of its frame that is at `place` (m) or its centre of
    /// mass.
    fn point_of_body(&self, id: BodyId, place: Option<DVec3>) -> Result<(usize, DVec3), InputError> {
        let (rigid, index) = self.own_body(id)?;
        place.map_or(Ok(()), |place| check_vector("place", place, SETTINGS.maximum_coordinate, "m"))?;
        let state = rigid.state(index).filter(|state| state.is_dynamic());
        let state = state.ok_or_else(|| InputError::new("body", "is not dynamic: no force moves it"))?;
        Ok((index, state.local_point(place.unwrap_or(state.centre()))))
    }
}

fn no_body() -> InputError {
    InputError::new("body", "was removed, or this world has no bodies of its own")
}

/// Refuse a vector with a component beyond ±`most` or not finite.
fn check_vector(field: &str, value: DVec3, most: f64, unit: &str) -> Result<(), InputError> {
    let each = value.to_array().into_iter().enumerate();
    each.into_iter().try_for_each(|(axis, value)| check_range(&format!("{field}.{axis}"), value, -most, most, unit))
}
