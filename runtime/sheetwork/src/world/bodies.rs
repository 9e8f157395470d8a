//! Rigid bodies that are added, removed and moved while a world runs.

use glam::{DQuat, DVec3};

use crate::error::InputError;
use crate::rigid::BodyState;
use crate::scene::{BodySpec, Scene, validate};
use crate::sheet::Sheet;
use crate::thermal::ThermalModel;
use crate::world::serialization::StructureChecksum;
use crate::world::{World, unique_name};

impl World {
    /// Add a rigid body and return its name: the name of the description, with a number where it is
    /// not unique.
    ///
    /// # Errors
    /// When the world has no bodies of its own, or the description, or a file it names, is invalid.
    pub fn add_body(&mut self, spec: &BodySpec) -> Result<String, InputError> {
        let Some(rigid) = &mut self.rigid else {
            return Err(InputError::new(
                "bodies",
                "this world meets bodies that are lent to it and has none of its own",
            ));
        };
        let base = if spec.name.is_empty() { "body" } else { spec.name.as_str() };
        let name = unique_name(base, |name| rigid.bodies().iter().any(|b| b.name == name));
        let spec = BodySpec { name: name.clone(), ..spec.clone() };
        let checked = Scene { bodies: vec![spec.clone()], ..Scene::default() };
        validate::scene(&checked)?;
        rigid.add(&self.scene, &spec, 0)?;
        if let Some(celsius) = spec.temperature {
            if self.heat.is_none() {
                self.heat = Some(Box::new(ThermalModel::new(&self.scene)?));
            }
            let conductance = self.scene.contact_conductance;
            self.heat.iter_mut().for_each(|heat| heat.add_body(&name, celsius, conductance));
        }
        self.scene.bodies.push(spec);
        self.make.add_body(&self.scene);
        self.sheets.iter_mut().for_each(Sheet::wake);
        Ok(name)
    }

    /// Remove the rigid body `name`, detach the nodes attached to it, and wake the sheets. Returns
    /// `false` when there is no such body.
    pub fn remove_body(&mut self, name: &str) -> bool {
        let index = self.rigid.as_ref().and_then(|r| r.index_of(name));
        let removed = self.rigid.as_mut().is_some_and(|r| r.remove(name));
        if removed {
            self.scene.bodies.retain(|b| b.name != name);
            for sheet in &mut self.scene.sheets {
                sheet.pins.retain(|p| p.body.as_deref() != Some(name));
            }
            self.make = StructureChecksum::new(&self.scene);
            for sheet in &mut self.sheets {
                index.into_iter().for_each(|i| sheet.detach_body(i));
                sheet.wake();
            }
        }
        removed
    }

    /// Prescribe the pose of a rigid body at the end of the next step (m). A dynamic body becomes
    /// kinematic. Returns `false` when there is no body `name`.
    pub fn move_body(&mut self, name: &str, position: DVec3, rotation: DQuat) -> bool {
        let was_free = self.body_state(name).is_some_and(BodyState::is_dynamic);
        let sent = self.rigid.as_mut().is_some_and(|r| r.set_target(name, position, rotation));
        if sent && was_free {
            // Contact with a kinematic body differs from contact with a dynamic one.
            self.sheets.iter_mut().for_each(Sheet::wake);
        }
        sent
    }

    /// Place a dynamic body at a position (m), at once and at rest, and wake the sheets. Objects on
    /// the way are not touched. Returns `false` when there is no dynamic body `name`.
    pub fn place_body(&mut self, name: &str, position: DVec3, rotation: DQuat) -> bool {
        let placed = self.rigid.as_mut().is_some_and(|r| r.teleport(name, position, rotation));
        if placed {
            self.sheets.iter_mut().for_each(Sheet::wake);
        }
        placed
    }
}
