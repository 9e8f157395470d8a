//! Joints between the world's own bodies.

use rapier3d::prelude::{GenericJoint, ImpulseJointHandle};

use crate::error::InputError;
use crate::rigid::BodyState;
use crate::rigid::joints::check_joint;
use crate::world::World;
use crate::world::bodies::no_body;
use crate::world::ids::BodyId;

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
        Some(self.rigid.as_deref()?.joint(id.0)?.0)
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
}
