//! Sheets of a world: access by name and by id, addition and removal.

use std::collections::BTreeSet;

use crate::contact::SheetContact;
use crate::error::{BuildError, InputError};
use crate::islands::contact_log::ContactLog;
use crate::islands::island_builder::broad_phase_margin;
use crate::scene::{Scene, SheetSpec, validate};
use crate::sheet::temperature::spots;
use crate::sheet::{Sheet, Status, node_contact};
use crate::thermal::ThermalModel;
use crate::world::ids::SheetId;
use crate::world::{World, attach_to_bodies, lod, unique_name};

impl World {
    /// The sheets.
    pub fn sheets(&self) -> &[Sheet] {
        &self.sheets
    }

    /// The sheets, for changes between steps.
    pub fn sheets_mut(&mut self) -> &mut [Sheet] {
        &mut self.sheets
    }

    /// The sheet `name`.
    pub fn sheet(&self, name: &str) -> Option<&Sheet> {
        self.sheets.iter().find(|s| s.name == name)
    }

    /// The sheet `name`, for changes between steps.
    pub fn sheet_mut(&mut self, name: &str) -> Option<&mut Sheet> {
        self.get_sheet_mut(self.sheet_id(name)?)
    }

    /// Id of the sheet `name`.
    pub fn sheet_id(&self, name: &str) -> Option<SheetId> {
        self.sheet_ids.at(self.sheets.iter().position(|s| s.name == name)?).map(SheetId)
    }

    /// Index of the sheet `name`.
    pub(crate) fn sheet_index(&self, name: &str) -> Result<usize, InputError> {
        let found = self.sheets.iter().position(|s| s.name == name);
        found.ok_or_else(|| InputError::new("sheet", format!("no sheet is named \"{name}\"")))
    }

    /// Index of the sheet `id`.
    pub(crate) fn index_of_sheet(&self, id: SheetId) -> Result<usize, InputError> {
        self.sheet_ids.position(id.0).ok_or_else(|| InputError::new("sheet", "was removed"))
    }

    /// Ids of all sheets, in the order of [`World::sheets`].
    pub fn sheet_ids(&self) -> impl ExactSizeIterator<Item = SheetId> + '_ {
        self.sheet_ids.iter().map(SheetId)
    }

    /// The sheet `id`; `None` when it was removed.
    pub fn get_sheet(&self, id: SheetId) -> Option<&Sheet> {
        self.sheets.get(self.sheet_ids.position(id.0)?)
    }

    /// The sheet `id`, for changes between steps; `None` when it was removed.
    pub fn get_sheet_mut(&mut self, id: SheetId) -> Option<&mut Sheet> {
        let sheet = self.sheets.get_mut(self.sheet_ids.position(id.0)?)?;
        // The caller may place it so that it intersects another sheet.
        sheet.invalidate_interpenetration();
        Some(sheet)
    }

    /// Add a sheet. Its name is that of the description, with a number where it is not unique.
    ///
    /// # Errors
    /// When the description, or a file it names, is invalid; nothing is added then.
    pub fn add_sheet(&mut self, spec: &SheetSpec) -> Result<SheetId, BuildError> {
        let suspended = self.suspended.iter().map(|suspended| &suspended.sheet);
        let names: BTreeSet<&str> = self.sheets.iter().chain(suspended).map(|s| s.name.as_str()).collect();
        let name = unique_name(&spec.name, "sheet", |name| names.contains(name));
        let index = self.scene.sheets.len();
        let spec = SheetSpec { name, ..spec.clone() };
        validate::added_sheet(&spec, index)?;
        if spec.refine.is_some() {
            self.refine_work.get_or_insert_default();
        }
        self.scene.sheets.push(spec);
        // The sheet gets the present integrator; the scene keeps its own, for a reset.
        let described = (self.scene.engine, self.scene.tolerance);
        (self.scene.engine, self.scene.tolerance) = (self.engine, self.tolerance);
        let built = self.build_last_sheet();
        (self.scene.engine, self.scene.tolerance) = described;
        match built {
            Ok((sheet, heat)) => {
                self.sheets.push(sheet);
                self.heat = heat.or(self.heat.take());
            }
            Err(error) => {
                self.scene.sheets.truncate(index);
                return Err(error.into());
            }
        }
        self.heat.iter_mut().for_each(|heat| heat.discard_views());
        match &mut self.lod {
            Some(detail) => detail.add(0),
            None => self.lod = lod::LodState::of(&self.scene, &self.sheets),
        }
        self.sheet_contacts.push(SheetContact::default());
        self.contact_logs.push(ContactLog::default());
        self.structure.add_sheet(&self.scene);
        Ok(SheetId(self.sheet_ids.push()))
    }

    /// Build the last sheet of the scene, and the thermal model if the sheet is the first with
    /// temperatures.
    fn build_last_sheet(&self) -> Result<(Sheet, Option<Box<ThermalModel>>), InputError> {
        let Scene { sheets, ambient_temperature, .. } = &self.scene;
        let mut sheet = Sheet::build(&self.scene, sheets.len() - 1)?;
        attach_to_bodies(&mut sheet, self.rigid.as_deref())?;
        let heat = if self.heat.is_some() { None } else { ThermalModel::of(&self.scene)?.map(Box::new) };
        if let Some(heat) = self.heat.as_ref().or(heat.as_ref()) {
            heat.prepare(&mut sheet, *ambient_temperature);
        }
        let spots = sheets.last().map_or(&[][..], |spec| &spec.spots);
        spots::heat_spots(&mut sheet, spots, *ambient_temperature)?;
        Ok((sheet, heat))
    }

    /// Remove the sheet `id`, also while it is suspended. Returns `false` when it was removed
    /// before.
    pub fn remove_sheet(&mut self, id: SheetId) -> bool {
        let Some(index) = self.sheet_ids.position(id.0) else { return self.remove_suspended(id) };
        self.wake_around(index);
        self.sheet_ids.remove(index);
        self.take_sheet_at(index);
        true
    }

    /// Take the sheet at `index` out of all lists but that of the ids.
    pub(super) fn take_sheet_at(&mut self, index: usize) -> Sheet {
        let sheet = self.sheets.remove(index);
        self.lod.iter_mut().for_each(|detail| detail.remove(index));
        self.sheet_contacts.remove(index);
        self.contact_logs.remove(index);
        self.islands.remove_sheet(index);
        self.scene.sheets.remove(index);
        self.structure.remove_sheet(index, &self.scene);
        self.heat.iter_mut().for_each(|heat| heat.discard_views());
        sheet
    }

    /// Wake the dynamic bodies, and the sheets that may rest on the sheet `index`, before it goes
    /// elsewhere.
    pub(super) fn wake_around(&mut self, index: usize) {
        let (low, high) = node_contact::bounding_box(&self.sheets[index]);
        for sheet in self.sheets.iter_mut().filter(|sheet| sheet.state.status == Status::Asleep) {
            let reach = broad_phase_margin(sheet);
            let (from, to) = node_contact::resting_box(sheet);
            if from.cmple(high + reach).all() && to.cmpge(low - reach).all() {
                sheet.wake();
            }
        }
        self.rigid.iter_mut().for_each(|rigid| rigid.wake_all());
    }
}
