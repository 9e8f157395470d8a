//! Heat sources of a world: stepped with it, and added, moved and removed while it runs.
//!
//! Added sources become part of the scene, so that a reset keeps them.

use glam::DVec3;

use crate::error::{BuildError, InputError};
use crate::profiler::Phase;
use crate::rigid::{RigidView, RigidWorld};
use crate::scene::{HeatGunSpec, HeaterSpec, OvenSpec, Placement, Scene, SpotSpec, validate};
use crate::sheet::Sheet;
use crate::sheet::temperature::spots;
use crate::thermal::ThermalModel;
use crate::thermal::source::{HeatSource, heat_gun, heater, oven};
use crate::world::ids::HeaterId;
use crate::world::{World, unique_name};

impl World {
    /// Step the thermal model after a step of motion of `dt` (s).
    pub(crate) fn step_thermal(&mut self, view: Option<&RigidView>, rigid: Option<&RigidWorld>, dt: f64) {
        let (sheets, time) = (&mut self.sheets, (self.time - dt, dt));
        if let Some(heat) = &mut self.heat {
            self.profiler.measure(Phase::Heat, || heat.step(sheets, time, view, rigid));
        }
    }

    /// Temperature of the surroundings, °C: ambient temperature of the scene, or of its oven.
    pub fn room_temperature(&self) -> f64 {
        self.heat.as_ref().map_or(self.scene.ambient_temperature, |h| h.surroundings(self.time).celsius)
    }

    /// Id of the heater `name`. A heater without a name has its number in the scene for a name.
    pub fn heater_id(&self, name: &str) -> Option<HeaterId> {
        self.heater_ids.at(self.heater_names.iter().position(|n| n == name)?).map(HeaterId)
    }

    /// Ids of all heaters, in the order of the scene.
    pub fn heater_ids(&self) -> impl ExactSizeIterator<Item = HeaterId> + '_ {
        self.heater_ids.iter().map(HeaterId)
    }

    /// Description of the heater `id`; `None` when it was removed.
    pub fn get_heater(&self, id: HeaterId) -> Option<&HeaterSpec> {
        self.scene.heaters.get(self.heater_ids.position(id.0)?)
    }

    /// Add a heater. Its name is that of the description, with a number where it is not unique.
    ///
    /// # Errors
    /// When the description, or a file it names, is invalid; nothing is added then.
    pub fn add_heater(&mut self, spec: &HeaterSpec) -> Result<HeaterId, BuildError> {
        let taken = |name: &str| self.scene.heaters.iter().any(|h| h.name == name);
        let spec = HeaterSpec { name: unique_name(&spec.name, "heater", taken), ..spec.clone() };
        let source = heater::of(&spec.name, &spec, &self.scene.base)?;
        let mut scene = self.scene.clone();
        scene.heaters.push(spec.clone());
        self.replace_heat_settings(scene)?;
        self.replace_source(&heater::path_of(&spec.name), Some(source));
        self.heater_names.push(spec.name);
        Ok(HeaterId(self.heater_ids.push()))
    }

    /// Remove the heater `id`. Returns `false` when it was removed before, or when it has no name
    /// of its own.
    pub fn remove_heater(&mut self, id: HeaterId) -> bool {
        let (Some(index), Some(heat)) = (self.heater_ids.position(id.0), &mut self.heat) else { return false };
        // A heater without a name is known by its number, which would pass to another.
        let named = !self.scene.heaters[index].name.is_empty();
        let removed = named && heat.remove(&heater::path_of(&self.heater_names[index]));
        if removed {
            self.heater_ids.remove(index);
            self.heater_names.remove(index);
            self.scene.heaters.remove(index);
            self.sheets.iter_mut().for_each(Sheet::wake);
        }
        removed
    }

    /// Place the heater `id` at `placement` from the next thermal step on. Returns `false` when it
    /// was removed before, or when the placement is not finite or out of range.
    pub fn move_heater(&mut self, id: HeaterId, placement: &Placement) -> bool {
        if validate::placement(placement).is_err() {
            return false;
        }
        let (Some(index), Some(heat)) = (self.heater_ids.position(id.0), &mut self.heat) else { return false };
        let moved = heat.place(&heater::path_of(&self.heater_names[index]), placement);
        if moved {
            self.scene.heaters[index].placement = *placement;
            self.sheets.iter_mut().for_each(Sheet::wake);
        }
        moved
    }

    /// Add hot spots to the sheet `index`, at once and after each reset; an empty list only starts
    /// its thermal model. Returns `false` when there is no such sheet.
    ///
    /// # Errors
    /// When a spot is out of range; nothing changes then.
    pub fn heat_spots(&mut self, index: usize, spots: &[SpotSpec]) -> Result<bool, InputError> {
        if index >= self.sheets.len() {
            return Ok(false);
        }
        spots.iter().try_for_each(SpotSpec::check)?;
        if self.heat.is_none() {
            let heat = Box::new(ThermalModel::new(&self.scene)?);
            self.sheets.iter_mut().for_each(|s| heat.prepare(s, self.scene.ambient_temperature));
            self.heat = Some(heat);
        }
        spots::heat_spots(&mut self.sheets[index], spots, self.scene.ambient_temperature)?;
        if let Some(spec) = self.scene.sheets.get_mut(index) {
            spec.spots.extend_from_slice(spots);
        }
        Ok(true)
    }

    /// Set, replace or remove the oven.
    ///
    /// # Errors
    /// When the description is invalid; nothing changes then.
    pub fn set_oven(&mut self, spec: Option<OvenSpec>) -> Result<(), InputError> {
        let source = spec.as_ref().map(oven::of);
        self.replace_heat_settings(Scene { oven: spec, ..self.scene.clone() })?;
        self.replace_source(oven::PATH, source);
        Ok(())
    }

    /// Set, replace or remove the heat gun.
    ///
    /// # Errors
    /// When the description is invalid; nothing changes then.
    pub fn set_heat_gun(&mut self, spec: Option<HeatGunSpec>) -> Result<(), InputError> {
        let source = spec.as_ref().map(heat_gun::of);
        self.replace_heat_settings(Scene { heat_gun: spec, ..self.scene.clone() })?;
        self.replace_source(heat_gun::PATH, source);
        Ok(())
    }

    /// Replace the source at `path` by `source`, if any.
    fn replace_source(&mut self, path: &str, source: Option<Box<dyn HeatSource>>) {
        if let Some(heat) = &mut self.heat {
            heat.remove(path);
            source.into_iter().for_each(|s| heat.add(s));
        }
    }

    /// Place the nozzle of the heat gun at `placement`, blowing along its -z axis. Returns `false`
    /// when there is no heat gun.
    pub fn place_heat_gun(&mut self, placement: &Placement) -> bool {
        let Some(heat) = &mut self.heat else { return false };
        let aimed = heat.place(heat_gun::PATH, placement);
        if let Some(spec) = self.scene.heat_gun.as_mut().filter(|_| aimed) {
            spec.position = placement.position;
            spec.direction = placement.quaternion() * DVec3::NEG_Z;
            self.sheets.iter_mut().for_each(Sheet::wake);
        }
        aimed
    }

    /// Set the temperature, convection, contact conductance, time-lapse and heat mode of
    /// `settings`; its sources, sheets and bodies are ignored.
    ///
    /// # Errors
    /// When one is out of range; nothing changes then.
    pub fn set_surroundings(&mut self, settings: &Scene) -> Result<(), InputError> {
        self.replace_heat_settings(Scene {
            ambient_temperature: settings.ambient_temperature,
            convection: settings.convection,
            contact_conductance: settings.contact_conductance,
            time_lapse: settings.time_lapse,
            heat_mode: settings.heat_mode,
            ..self.scene.clone()
        })?;
        if let Some(heat) = &mut self.heat {
            heat.set_surroundings(&self.scene);
        }
        Ok(())
    }

    /// Replace the scene by `scene`, which differs only in heat, and start the thermal model where
    /// it is needed.
    fn replace_heat_settings(&mut self, scene: Scene) -> Result<(), InputError> {
        validate::heat(&scene)?;
        match &mut self.heat {
            Some(heat) => heat.set_heat_mode(scene.heat_mode),
            None => self.heat = ThermalModel::of(&scene)?.map(Box::new),
        }
        if let Some(heat) = &self.heat {
            // Sheets without temperatures start at the ambient temperature of the old scene.
            self.sheets.iter_mut().for_each(|s| heat.prepare(s, self.scene.ambient_temperature));
        }
        self.scene = scene;
        self.sheets.iter_mut().for_each(Sheet::wake);
        Ok(())
    }
}
