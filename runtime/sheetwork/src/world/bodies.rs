//! Rigid bodies that are added, removed, moved and made sensors while a world runs.

use glam::{DQuat, DVec3};
use rapier3d::prelude::InteractionGroups;

use crate::error::{BuildError, InputError};
use crate::rigid::{BodyState, RigidWorld};
use crate::scene::{BodySpec, Scene, validate};
use crate::sheet::{Sheet, attachment};
use crate::thermal::ThermalModel;
use crate::units::parameters::ParameterId as Id;
use crate::world::ids::BodyId;
use crate::world::penetration::PenetratedObject;
use crate::world::serialization::StructureChecksum;
use crate::world::{World, unique_name};

impl World {
    /// Id of the rigid body `name`.
    pub fn body_id(&self, name: &str) -> Option<BodyId> {
        self.body_ids.at(self.rigid.as_deref()?.index_of(name)?).map(BodyId)
    }

    /// Ids of the world's own rigid bodies: those of the scene, then floor and back wall, then
    /// those added.
    pub fn body_ids(&self) -> impl ExactSizeIterator<Item = BodyId> + '_ {
        self.body_ids.iter().map(BodyId)
    }

    /// Name of the rigid body `id`; `None` when it was removed.
    pub fn body_name(&self, id: BodyId) -> Option<&str> {
        let body = self.rigid.as_deref()?.bodies().get(self.body_ids.position(id.0)?)?;
        Some(&body.name)
    }

    /// State of the rigid body `id`; `None` when it was removed.
    pub fn get_body(&self, id: BodyId) -> Option<&BodyState> {
        self.rigid.as_deref()?.state(self.body_ids.position(id.0)?)
    }

    /// Add a rigid body. Its name is that of the description, with a number where it is not unique.
    ///
    /// # Errors
    /// When the world has no bodies of its own, or the description, or a file it names, is invalid.
    pub fn add_body(&mut self, spec: &BodySpec) -> Result<BodyId, BuildError> {
        let Some(rigid) = &mut self.rigid else {
            let problem = "this world meets bodies that are lent to it and has none of its own";
            return Err(BuildError::Refused(InputError::new("bodies", problem)));
        };
        let name = unique_name(&spec.name, "body", |name| rigid.bodies().iter().any(|b| b.name == name));
        let spec = BodySpec { name: name.clone(), ..spec.clone() };
        let checked = Scene { bodies: vec![spec.clone()], ..Scene::default() };
        validate::scene(&checked)?;
        rigid.add(&self.scene, &spec, 0)?;
        if spec.is_hot() {
            if self.heat.is_none() {
                self.heat = Some(Box::new(ThermalModel::new(&self.scene)?));
            }
            let conductance = self.scene.contact_conductance;
            self.heat.iter_mut().for_each(|heat| heat.add_body(&name, &spec, conductance));
        }
        self.scene.bodies.push(spec);
        self.structure.add_body(&self.scene);
        self.sheets.iter_mut().for_each(Sheet::wake);
        Ok(BodyId(self.body_ids.push()))
    }

    /// Remove the rigid body `id`, detach the nodes attached to it, and wake the sheets. Returns
    /// `false` when it was removed before.
    pub fn remove_body(&mut self, id: BodyId) -> bool {
        let (Some(index), Some(rigid)) = (self.body_ids.position(id.0), &mut self.rigid) else { return false };
        let name = rigid.remove(index);
        self.body_ids.remove(index);
        self.scene.bodies.retain(|b| b.name != name);
        let suspended = self.suspended.iter_mut();
        for sheet in self.scene.sheets.iter_mut().chain(suspended.map(|suspended| &mut suspended.spec)) {
            sheet.pins.retain(|p| p.body.as_ref() != Some(&name));
        }
        self.structure = StructureChecksum::new(&self.scene);
        let suspended = self.suspended.iter_mut();
        for sheet in self.sheets.iter_mut().chain(suspended.map(|suspended| &mut suspended.sheet)) {
            attachment::detach_body(sheet, index);
            sheet.wake();
        }
        true
    }

    /// Prescribe the pose of a rigid body at the end of the next step (m). A dynamic body becomes
    /// kinematic. Returns `false` when it was removed, or when the pose is not finite or farther
    /// than 10 km from the origin.
    pub fn move_body(&mut self, id: BodyId, position: DVec3, rotation: DQuat) -> bool {
        if !is_valid_pose(position, rotation) {
            return false;
        }
        let (Some(index), Some(rigid)) = (self.body_ids.position(id.0), &mut self.rigid) else { return false };
        let was_free = rigid.state(index).is_some_and(BodyState::is_dynamic);
        let sent = rigid.set_target(index, position, rotation);
        if sent && was_free {
            // Contact with a kinematic body differs from contact with a dynamic one.
            self.sheets.iter_mut().for_each(Sheet::wake);
        }
        sent
    }

    /// Place a dynamic body at a position (m), at once and at rest, and wake the sheets. Objects on
    /// the way are not touched. Returns `false` when it was removed or is not dynamic, or when the
    /// pose is not finite or farther than 10 km from the origin.
    pub fn place_body(&mut self, id: BodyId, position: DVec3, rotation: DQuat) -> bool {
        if !is_valid_pose(position, rotation) {
            return false;
        }
        let (Some(index), Some(rigid)) = (self.body_ids.position(id.0), &mut self.rigid) else { return false };
        let placed = rigid.teleport(index, position, rotation);
        if placed {
            self.sheets.iter_mut().for_each(Sheet::wake);
        }
        placed
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
    /// When the body does not exist, or a sheet is in a body that is to be solid; nothing changes
    /// then.
    pub fn set_body_sensor(&mut self, id: BodyId, is_sensor: bool) -> Result<(), InputError> {
        let body = self.own_body(id)?.1;
        let mut change = |is_sensor| self.rigid.as_mut().is_some_and(|rigid| rigid.set_sensor(body, is_sensor));
        if !change(is_sensor) {
            return Ok(());
        }
        if !is_sensor && self.penetrations().iter().any(|found| found.with == PenetratedObject::Body(body)) {
            self.rigid.iter_mut().for_each(|rigid| _ = rigid.set_sensor(body, true));
            return Err(InputError::new("sensor", "a sheet is in the body: move one of them before it is solid"));
        }
        self.sheets.iter_mut().for_each(Sheet::wake);
        Ok(())
    }

    /// The rigid world and the index of the body `id`.
    pub(super) fn own_body(&self, id: BodyId) -> Result<(&RigidWorld, usize), InputError> {
        self.rigid.as_deref().zip(self.body_ids.position(id.0)).ok_or_else(no_body)
    }
}

pub(super) fn no_body() -> InputError {
    InputError::new("body", "was removed, or this world has no bodies of its own")
}

/// Whether a body may stand there: within the range of positions, with a rotation of unit length.
pub(crate) fn is_valid_pose(position: DVec3, rotation: DQuat) -> bool {
    let row = Id::PlacementPosition.row();
    let (min, max) = row.range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    position.to_array().iter().all(|p| (min..=max).contains(p)) && (rotation.length() - 1.0).abs() < 1e-3
}
