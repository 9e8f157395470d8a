//! Forces, impulses and velocities of a program on the world's own dynamic bodies.

use glam::DVec3;

use crate::error::{InputError, check_range};
use crate::rigid::body_loads::BodyLoad;
use crate::units::parameters::ParameterId as Id;
use crate::world::World;
use crate::world::bodies::no_body;
use crate::world::ids::BodyId;
use crate::world::loads::LoadSettings;

const SETTINGS: LoadSettings = LoadSettings::DEFAULT;

impl World {
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

/// Refuse a vector with a component beyond ±`most` or not finite.
fn check_vector(field: &str, value: DVec3, most: f64, unit: &str) -> Result<(), InputError> {
    let each = value.to_array().into_iter().enumerate();
    each.into_iter().try_for_each(|(axis, value)| check_range(&format!("{field}.{axis}"), value, -most, most, unit))
}
