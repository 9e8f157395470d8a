//! Checkpoints: states of a world that can be restored after sheets, bodies or heaters were added
//! or removed.
//!
//! A checkpoint is a snapshot and the layout that the snapshot belongs to: the descriptions of all
//! objects, their ids, and Rapier's sets. Checkpoints of one layout share it. To restore another
//! layout, the world keeps the sheets that both have, builds the missing ones from their
//! descriptions, removes the others, and then reads the snapshot.

use std::sync::Arc;

use crate::contact::SheetContact;
use crate::error::{InputError, SnapshotError};
use crate::islands::contact_log::ContactLog;
use crate::islands::island_manager::IslandManager;
use crate::rigid::RigidWorld;
use crate::rigid::serialization::RigidLayout;
use crate::scene::{BodySpec, HeaterSpec, Scene, SheetSpec};
use crate::sheet::Sheet;
use crate::thermal::ThermalModel;
use crate::world::ids::{IdTable, SheetId, Slot};
use crate::world::serialization::StructureChecksum;
use crate::world::{World, attach_to_bodies, lod};

/// State of a world with its objects. A clone shares the objects.
#[derive(Clone)]
pub struct Checkpoint {
    /// Serialised state.
    bytes: Vec<u8>,
    layout: Arc<WorldLayout>,
    /// Sheets that record their contacts, with their thresholds, N.
    recorded: Vec<(SheetId, f64)>,
}

/// Objects of a world.
pub(crate) struct WorldLayout {
    sheets: Vec<SheetSpec>,
    bodies: Vec<BodySpec>,
    heaters: Vec<HeaterSpec>,
    sheet_ids: IdTable,
    body_ids: IdTable,
    heater_ids: IdTable,
    heater_names: Vec<String>,
    structure: StructureChecksum,
    rigid: Option<RigidLayout>,
    heat_sources: Option<usize>,
    has_lod: bool,
}

/// Sheet with its contact state.
type SheetParts = ((Sheet, SheetContact), ContactLog);

impl World {
    /// Store the present state with the objects of the world. A suspended sheet is not stored.
    pub fn checkpoint(&mut self) -> Checkpoint {
        let layout = self.layout.take().filter(|layout| self.has_layout(layout));
        let layout = layout.unwrap_or_else(|| Arc::new(self.layout_now()));
        self.layout = Some(Arc::clone(&layout));
        let recorded = self.contacts.as_ref().map(|records| records.thresholds().to_vec()).unwrap_or_default();
        Checkpoint { bytes: self.serialise(), layout, recorded }
    }

    /// Return to a checkpoint of this world: sheets, bodies and heaters that were added since are
    /// gone, those that were removed are back, and all have the ids of that time. The following
    /// steps repeat those after the checkpoint bit for bit. Suspended sheets have no state in a
    /// checkpoint: one that was suspended then and still is remains so, and one that has been
    /// resumed since is gone.
    ///
    /// # Errors
    /// When the checkpoint is of another world, or a file that a description names cannot be read;
    /// nothing changes then.
    pub fn restore_checkpoint(&mut self, checkpoint: &Checkpoint) -> Result<(), SnapshotError> {
        let Checkpoint { bytes, layout, recorded } = checkpoint;
        if self.has_layout(layout) {
            self.deserialise(bytes)?;
        } else {
            let before = self.checkpoint();
            let taken = self.take_layout(layout).map_err(SnapshotError::OtherWorld);
            if let Err(problem) = taken.and_then(|()| self.deserialise(bytes)) {
                // The world's own layout and state are accepted.
                let _ = self.take_layout(&before.layout);
                let _ = self.deserialise(&before.bytes);
                return Err(problem);
            }
        }
        for (sheet, threshold) in recorded {
            if !self.contacts.as_ref().is_some_and(|records| records.has(*sheet)) {
                // The sheet exists, and the threshold was accepted before.
                let _ = self.record_contacts(*sheet, Some(*threshold));
            }
        }
        Ok(())
    }

    /// Whether the objects of the world are those of `layout`.
    fn has_layout(&self, layout: &WorldLayout) -> bool {
        layout.sheet_ids == self.sheet_ids
            && layout.body_ids == self.body_ids
            && layout.heater_ids == self.heater_ids
            && layout.heat_sources == self.heat.as_ref().map(|heat| heat.sources())
            && layout.structure.value() == self.structure.value()
    }

    fn layout_now(&self) -> WorldLayout {
        let Scene { sheets, bodies, heaters, .. } = &self.scene;
        WorldLayout {
            sheets: sheets.clone(),
            bodies: bodies.clone(),
            heaters: heaters.clone(),
            sheet_ids: self.sheet_ids.clone(),
            body_ids: self.body_ids.clone(),
            heater_ids: self.heater_ids.clone(),
            heater_names: self.heater_names.clone(),
            structure: self.structure.clone(),
            rigid: self.rigid.as_deref().map(RigidWorld::layout),
            heat_sources: self.heat.as_ref().map(|heat| heat.sources()),
            has_lod: self.lod.is_some(),
        }
    }

    /// Give the world the objects of `layout`, in any state.
    ///
    /// # Errors
    /// When an object cannot be built; nothing changes then.
    fn take_layout(&mut self, layout: &WorldLayout) -> Result<(), InputError> {
        let WorldLayout { sheets, bodies, heaters, .. } = layout;
        let (sheets, bodies, heaters) = (sheets.clone(), bodies.clone(), heaters.clone());
        let scene = Scene { sheets, bodies, heaters, ..self.scene.clone() };
        let has_bodies = layout.body_ids == self.body_ids;
        let rigid = match &layout.rigid {
            Some(rigid) if !has_bodies => Some(Box::new(RigidWorld::from_layout(rigid, &scene)?)),
            _ => None,
        };
        let keeps_heat = has_bodies
            && layout.heater_ids == self.heater_ids
            && layout.heat_sources == self.heat.as_ref().map(|heat| heat.sources());
        let heat =
            if keeps_heat || layout.heat_sources.is_none() { None } else { Some(Box::new(ThermalModel::new(&scene)?)) };
        let built = self.build_missing(&scene, layout, (rigid.as_deref(), heat.as_deref()))?;
        self.rigid = rigid.or(self.rigid.take());
        self.heat = heat.or(self.heat.take()).filter(|_| layout.heat_sources.is_some());
        self.heat.iter_mut().for_each(|heat| heat.discard_views());
        self.scene = scene;
        self.exchange_sheets(layout, built);
        self.sheet_ids = layout.sheet_ids.clone();
        self.body_ids = layout.body_ids.clone();
        self.heater_ids = layout.heater_ids.clone();
        self.heater_names.clone_from(&layout.heater_names);
        self.structure = layout.structure.clone();
        self.islands = IslandManager::default();
        self.lod = layout.has_lod.then(|| lod::LodState::with_sheets(&self.scene, &self.sheets));
        Ok(())
    }

    /// Whether the sheet in `slot` exists and has this description.
    fn has_sheet(&self, slot: Slot, spec: &SheetSpec) -> bool {
        match self.sheet_ids.position(slot) {
            Some(index) => self.scene.sheets[index] == *spec,
            None => self.suspended.iter().any(|suspended| suspended.slot == slot && suspended.spec == *spec),
        }
    }

    /// Build the sheets of `layout` that the world lacks; `None` for the others.
    fn build_missing(
        &self,
        scene: &Scene,
        layout: &WorldLayout,
        (rigid, heat): (Option<&RigidWorld>, Option<&ThermalModel>),
    ) -> Result<Vec<Option<Sheet>>, InputError> {
        let (rigid, heat) = (rigid.or(self.rigid.as_deref()), heat.or(self.heat.as_deref()));
        let scene = Scene { engine: self.engine, tolerance: self.tolerance, ..scene.clone() };
        let build = |(index, slot)| {
            if self.has_sheet(slot, &layout.sheets[index]) {
                return Ok(None);
            }
            let mut sheet = Sheet::build(&scene, index)?;
            attach_to_bodies(&mut sheet, rigid)?;
            heat.iter().for_each(|heat| heat.prepare(&mut sheet, scene.ambient_temperature));
            Ok(Some(sheet))
        };
        layout.sheet_ids.iter().enumerate().map(build).collect()
    }

    /// Let the sheets be those of `layout`, in its order; `built` are those that the world lacks.
    fn exchange_sheets(&mut self, layout: &WorldLayout, built: Vec<Option<Sheet>>) {
        let sheets = std::mem::take(&mut self.sheets).into_iter();
        let contacts = std::mem::take(&mut self.sheet_contacts).into_iter();
        let logs = std::mem::take(&mut self.contact_logs).into_iter();
        let slots: Vec<Slot> = self.sheet_ids.iter().collect();
        let mut present: Vec<(Slot, SheetParts)> = slots.into_iter().zip(sheets.zip(contacts).zip(logs)).collect();
        for (slot, built) in layout.sheet_ids.iter().zip(built) {
            let new = |sheet| ((sheet, SheetContact::default()), ContactLog::default());
            let found = present.iter().position(|(other, _)| *other == slot);
            let suspended = self.suspended.iter().position(|suspended| suspended.slot == slot);
            let parts = match (built, found, suspended) {
                (Some(sheet), ..) => new(sheet),
                (None, Some(at), _) => present.swap_remove(at).1,
                (None, None, Some(at)) => new(self.suspended.remove(at).sheet),
                (None, None, None) => unreachable!("a sheet that is not built is there"),
            };
            let ((sheet, contact), log) = parts;
            self.sheets.push(sheet);
            self.sheet_contacts.push(contact);
            self.contact_logs.push(log);
        }
        self.suspended.retain(|suspended| layout.sheet_ids.is_suspended(suspended.slot));
    }
}
