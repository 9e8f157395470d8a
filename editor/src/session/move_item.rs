//! Translation of sheets, bodies, heaters and the heat gun by hand.
//!
//! Static and kinematic bodies, heaters and the heat gun are moved in the scene, from the start of
//! the run. A sheet can be moved before the first step. A dynamic body that has left its initial
//! pose is moved in the run, at rest, and its initial pose is kept. Both can be undone.

use glam::DVec3;
use sheetwork::scene::{BodySpec, Placement, path_at};

use super::Session;
use super::item::{Item, MovedItem};
use crate::document::change::shifted;
use crate::pick::box_of;

impl Session {
    /// Placement of an item in the scene; `None` when there is no such item.
    pub fn placement_of(&self, item: Item) -> Option<Placement> {
        let scene = self.scene();
        match item {
            Item::Sheet(i) => scene.sheets.get(i).map(|s| s.placement),
            Item::Body(i) => scene.bodies.get(i).map(|b| b.placement),
            Item::Heater(i) => scene.heaters.get(i).map(|h| h.placement),
            Item::HeatGun => scene.heat_gun.as_ref().map(|g| Placement { position: g.position, rotation: DVec3::ZERO }),
        }
    }

    /// Name of an item.
    pub fn name_of(&self, item: Item) -> String {
        let or = |name: &str, otherwise: String| if name.is_empty() { otherwise } else { name.to_owned() };
        match item {
            Item::Sheet(i) => self.world.sheets().get(i).map_or(String::new(), |s| s.name.clone()),
            Item::Body(i) => self.scene().bodies.get(i).map_or(String::new(), |b| or(&b.name, format!("body {i}"))),
            Item::Heater(i) => {
                self.scene().heaters.get(i).map_or(String::new(), |h| or(&h.name, format!("heater {i}")))
            }
            Item::HeatGun => "heat gun".to_owned(),
        }
    }

    /// All items that can be moved at present.
    pub fn items(&self) -> Vec<Item> {
        let scene = self.scene();
        let sheets = (0..scene.sheets.len()).filter(|_| self.world.steps() == 0).map(Item::Sheet);
        let bodies = (0..scene.bodies.len()).map(Item::Body);
        let heaters = (0..scene.heaters.len()).map(Item::Heater);
        sheets.chain(bodies).chain(heaters).chain(scene.heat_gun.is_some().then_some(Item::HeatGun)).collect()
    }

    /// Displayed position of the nozzle of the heat gun, m, and the unit vector of its jet; `None`
    /// without a gun.
    pub fn gun_aim(&self) -> Option<(DVec3, DVec3)> {
        let spec = self.scene().heat_gun.as_ref()?;
        let (offset, rotation) = path_at(&spec.path, self.world.time());
        let turn = Placement { position: DVec3::ZERO, rotation }.quaternion();
        let there = self.moved_position(Item::HeatGun).unwrap_or(spec.position + offset);
        Some((there, (turn * spec.direction).normalize_or(DVec3::NEG_Y)))
    }

    /// Display `item` moved by `by` (m) from its position at the grab, until
    /// [`Session::release_item`]. A static body is moved in a running world at once, so that it
    /// pushes what it meets.
    pub fn move_item(&mut self, item: Item, by: DVec3) {
        if self.playback.is_some() {
            return;
        }
        let taken = self.run_state.moved_item.filter(|c| c.item == item).map(|c| c.from);
        let Some(from) = taken.or_else(|| self.displayed_position(item)) else { return };
        self.run_state.moved_item = Some(MovedItem { item, from, by });
        self.revision += 1;
        let Item::Body(index) = item else { return };
        let Some(spec) = self.scene().bodies.get(index) else { return };
        if self.playing && !spec.is_dynamic() && spec.path.is_empty() {
            let there = shifted(&spec.placement, by);
            let body = self.world.body_ids().nth(index);
            if let Some(body) = body {
                _ = self.world.move_body(body, there.position, there.quaternion());
            }
        }
    }

    /// Item that is being moved, and its displacement, m.
    pub fn moved_item(&self) -> Option<(Item, DVec3)> {
        self.run_state.moved_item.map(|c| (c.item, c.by))
    }

    /// Displayed position of `item` while it is being moved, m.
    pub(super) fn moved_position(&self, item: Item) -> Option<DVec3> {
        self.run_state.moved_item.filter(|c| c.item == item).map(|c| c.from + c.by)
    }

    /// Release the moved item: at its start, or in the run for a dynamic body that has left its
    /// start. Returns whether an item was moved.
    pub fn release_item(&mut self) -> bool {
        let Some(MovedItem { item, from, by }) = self.run_state.moved_item.take() else { return false };
        self.revision += 1;
        let Some(placement) = self.placement_of(item).filter(|_| by != DVec3::ZERO) else { return false };
        match item {
            Item::Body(index) if self.has_left_start(index) => self.place_dynamic_body(index, from + by),
            _ => self.place(item, shifted(&placement, by)),
        }
    }

    /// Whether a dynamic body has left its initial pose, and is therefore moved in the run.
    pub fn has_left_start(&self, index: usize) -> bool {
        let mut pins = self.scene().sheets.iter().flat_map(|sheet| &sheet.pins);
        let name = self.body_name(index);
        // A body with an attached sheet is moved at its start: the attachment would tear.
        let is_glued = pins.any(|pin| pin.body.is_some() && pin.body == name);
        self.world.steps() > 0 && !is_glued && self.scene().bodies.get(index).is_some_and(BodySpec::is_dynamic)
    }

    /// Move a dynamic body in the run to a position (m), at rest, as one undo step. Returns whether
    /// the body exists.
    fn place_dynamic_body(&mut self, index: usize, position: DVec3) -> bool {
        let rotation = self.world.rigid().and_then(|r| r.pose(index)).map(|pose| pose.1);
        let (Some(name), Some(rotation)) = (self.body_name(index), rotation) else { return false };
        let before = self.world.snapshot();
        let Some(body) = self.world.body_id(&name) else { return false };
        if !self.world.place_body(body, position, rotation) {
            return false;
        }
        for other in self.variants.iter_mut().filter_map(|b| b.session.as_mut().ok()) {
            // A variant without this body is unchanged.
            other.world.body_id(&name).map(|body| other.world.place_body(body, position, rotation));
            other.show_present();
        }
        self.document.seal();
        self.document.commit_with(format!("move of {name}"), "carry", self.scene().clone(), before);
        self.document.seal();
        self.discard_future();
        self.run_state.timeline.replace_present(&self.world);
        self.show_present();
        true
    }

    /// Name of body `index` in the world.
    fn body_name(&self, index: usize) -> Option<String> {
        self.world.rigid().and_then(|r| r.bodies().get(index)).map(|b| b.name.clone())
    }

    /// Displayed position of the origin of an item, m.
    pub(crate) fn displayed_position(&self, item: Item) -> Option<DVec3> {
        match item {
            Item::Body(i) => self.body_pose(i).map(|p| p.0),
            Item::HeatGun => self.gun_aim().map(|aim| aim.0),
            Item::Sheet(_) | Item::Heater(_) => {
                self.moved_position(item).or_else(|| self.placement_of(item).map(|p| p.position))
            }
        }
    }

    /// Position of the handle of an item, m: the centre of its displayed shape, which may be far
    /// from its origin.
    pub fn handle_of(&self, item: Item) -> Option<DVec3> {
        let origin = self.displayed_position(item)?;
        Some(match item {
            Item::Sheet(i) => {
                let by = self.run_state.moved_item.filter(|c| c.item == item).map_or(DVec3::ZERO, |c| c.by);
                let (low, high) = self.world.sheets().get(i).filter(|_| self.world.steps() == 0)?.state.x.bounds()?;
                0.5 * (low + high) + by
            }
            Item::Body(i) => {
                // A ball has no vertices; its origin is its centre.
                let corners =
                    self.world.rigid()?.bodies().get(i)?.polyhedra.iter().flat_map(|p| p.vertices.iter().copied());
                origin + self.body_pose(i)?.1 * middle(corners).unwrap_or_default()
            }
            Item::Heater(i) => {
                let local = self.heater_centres.get(i).copied().unwrap_or_default();
                origin + self.placement_of(item)?.quaternion() * local
            }
            Item::HeatGun => origin,
        })
    }

    /// Compute the centres of the heaters in their own axes. Heater files are read once.
    pub(super) fn update_heater_centres(&mut self) {
        let scene = self.document.scene();
        let of = |heaters: Vec<sheetwork::scene::heater_file::Heater>| {
            middle(heaters.iter().flat_map(|h| h.polyhedron.vertices.iter().copied())).unwrap_or_default()
        };
        let middles = scene.heaters.iter().map(|spec| spec.resolve(&scene.base).map(of).unwrap_or_default());
        self.heater_centres = middles.collect();
    }

    /// Change the placement of an item, as an edit. Returns whether it was accepted.
    pub fn place(&mut self, item: Item, placement: Placement) -> bool {
        let name = self.name_of(item);
        self.edit(&format!("move of {name}"), &format!("place {name}"), |scene| match item {
            Item::Sheet(i) => scene.sheets.iter_mut().skip(i).take(1).for_each(|s| s.placement = placement),
            Item::Body(i) => scene.bodies.iter_mut().skip(i).take(1).for_each(|b| b.placement = placement),
            Item::Heater(i) => scene.heaters.iter_mut().skip(i).take(1).for_each(|h| h.placement = placement),
            Item::HeatGun => scene.heat_gun.iter_mut().for_each(|g| g.position = placement.position),
        })
    }
}

/// Centre of the bounding box of points.
fn middle(points: impl Iterator<Item = DVec3>) -> Option<DVec3> {
    box_of(points).map(|(low, high)| 0.5 * (low + high))
}
