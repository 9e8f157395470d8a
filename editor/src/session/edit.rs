//! Edits of the scene, undo and redo, and updates of the world.

use glam::DVec3;
use sheetwork::scene::{MaterialChoice, PathKey, PinSpec, Region, Scene, SheetSpec};
use sheetwork::sheet::Sheet;
use sheetwork::{InputError, World};

use super::Session;
use crate::document::{Turn, change, change::Change, path, value};

impl Session {
    /// Edit the scene by `change`. The world continues, or restarts where its state does not fit
    /// the new scene. A rejection becomes a message and changes nothing. Consecutive edits with the
    /// same `key` are one undo step. Returns whether the edit was accepted.
    pub fn edit(&mut self, label: &str, key: &str, change: impl FnOnce(&mut Scene)) -> bool {
        let mut scene = self.scene().clone();
        change(&mut scene);
        self.take(label, key, scene, Change::Nothing)
    }

    /// Accept an edited scene; the world is updated at least by `least`.
    fn take(&mut self, label: &str, key: &str, scene: Scene, least: Change) -> bool {
        let taken = self.may_edit().and_then(|()| self.bring(&scene, least));
        let is_taken = self.accept(taken).is_some();
        if is_taken {
            self.document.commit(label, key, scene);
            self.after_edit();
        }
        is_taken
    }

    /// Edit the description of sheet `index`, if there is one, like [`Session::edit`].
    pub fn edit_sheet(&mut self, index: usize, label: &str, key: &str, change: impl FnOnce(&mut SheetSpec)) -> bool {
        self.edit(label, key, |scene| {
            if let Some(spec) = scene.sheets.get_mut(index) {
                change(spec);
            }
        })
    }

    /// Update everything that depends on the scene.
    fn after_edit(&mut self) {
        self.update_heater_centres();
        self.edit_variants();
    }

    fn may_edit(&self) -> Result<(), InputError> {
        if self.playback.is_some() {
            return Err(InputError::new("", "a recording cannot be changed; open its scene for that"));
        }
        Ok(())
    }

    /// Set a parameter of the world by path; it persists through [`Session::reset`]. A rejection
    /// becomes a message and changes nothing. Returns whether the value was accepted.
    pub fn set(&mut self, path: &str, value: &str) -> bool {
        let set = self.try_set(path, value);
        self.accept(set).is_some()
    }

    /// Set a parameter like [`Session::set`]; returns the old value or the reason of a rejection.
    pub(crate) fn try_set(&mut self, path: &str, value: &str) -> Result<String, InputError> {
        if self.playback.is_some() {
            return Err(InputError::new(path, "cannot be changed in a recording; open its scene for that"));
        }
        let value = &*self.world.in_own_unit(path, value)?;
        let field = path::numbered(self.world.sheets(), path);
        let known = self.world.parameters().into_iter().find(|p| path::numbered(self.world.sheets(), &p.path) == field);
        let scene = path::with_value(self.scene(), &field, value);
        // The node mass follows the thickness only when a sheet is built.
        let live = known.is_some() && !field.ends_with("material.thickness");
        let old = match (live, known) {
            (true, _) => self.world.set(path, value)?,
            (_, Some(known)) => known.value,
            // The world reports the error.
            _ if scene.is_err() => return Ok(self.world.set(path, value)?),
            _ => value::at(self.scene(), &field).unwrap_or_default(),
        };
        let scene = scene?;
        if !live {
            self.bring(&scene, Change::Nothing)?;
        }
        self.document.commit(format!("change of {path}"), &field, scene);
        self.after_edit();
        if field == "engine" || field.contains("material") {
            self.find_largest_step();
        }
        if field.starts_with("heaters.") || field.starts_with("heat_gun.") {
            // Their displayed glow changes.
            self.generation += 1;
        }
        Ok(old)
    }

    /// Default value of a parameter: of the material's preset, or of the scene as it was opened.
    pub fn default_of(&self, path: &str) -> Option<String> {
        let field = path::numbered(self.world.sheets(), path);
        let preset = value::of_preset(self.scene(), &field);
        preset.or_else(|| value::at(self.document.opened(), &field)).filter(|v| v != "none")
    }

    /// Fields changed since the scene was opened or saved: path and value.
    pub fn changes(&self) -> Vec<(String, String)> {
        value::changed(self.document.saved(), self.scene())
    }

    /// Set the material of sheet `index` to one of the library, and restart the scene; other
    /// changes are kept. A rejection becomes a message and changes nothing. Returns whether the
    /// material was accepted.
    pub fn choose_material(&mut self, index: usize, name: &str) -> bool {
        self.take_material(index, name.into())
    }

    /// Set the material of sheet `index`, and restart the scene.
    pub fn take_material(&mut self, index: usize, material: MaterialChoice) -> bool {
        let mut scene = self.scene().clone();
        let Some(sheet) = scene.sheets.get_mut(index) else { return false };
        let label = format!("material {}", material.name());
        sheet.material = material;
        // The damping ratio of the material replaces the sheet's own.
        sheet.damping_ratio = None;
        self.take(&label, "material", scene, Change::Anew)
    }

    /// Undo the last edit. Returns whether there was one.
    pub fn undo(&mut self) -> bool {
        self.turn_history(Turn::Undo)
    }

    /// Redo the last undone edit. Returns whether there was one.
    pub fn redo(&mut self) -> bool {
        self.turn_history(Turn::Redo)
    }

    fn turn_history(&mut self, turn: Turn) -> bool {
        let Some((scene, then)) = self.document.next(turn).map(|(scene, state)| (scene.clone(), state.cloned())) else {
            return false;
        };
        let now = then.is_some().then(|| self.world.snapshot());
        let brought = self.bring(&scene, Change::Nothing);
        if self.accept(brought).is_none() {
            return false;
        }
        let turned = self.document.turn(turn, now);
        if let Some(then) = then {
            self.go_to(&then);
            self.run_state.timeline.replace_present(&self.world);
        }
        self.after_edit();
        turned
    }

    /// End a sequence of edits: the next one is an undo step of its own.
    pub fn seal(&mut self) {
        self.document.seal();
    }

    /// Return to the start with all changes kept. Returns whether it succeeded.
    pub fn reset(&mut self) -> bool {
        if self.playback.is_some() {
            self.seek(0.0);
            return true;
        }
        let scene = self.scene().clone();
        let rebuilt = self.rebuild(&scene, false);
        self.accept(rebuilt).is_some()
    }

    /// Update the world from the present scene to `scene`.
    fn bring(&mut self, scene: &Scene, least: Change) -> Result<(), InputError> {
        match change::between(self.scene(), scene).max(least) {
            Change::Nothing => Ok(()),
            Change::Live => self.turn(scene),
            Change::GoesOn => self.rebuild(scene, true),
            Change::Anew => self.rebuild(scene, false),
        }
    }

    /// Set the parameters that differ from those of a world of `scene`.
    fn turn(&mut self, scene: &Scene) -> Result<(), InputError> {
        let wanted = World::with_start_overlaps(scene)?.parameters();
        let now = self.world.parameters();
        for parameter in wanted {
            let state = parameter.path.starts_with("sheets.") && parameter.path.ends_with(".temperature");
            let differs = now.iter().find(|p| p.path == parameter.path).is_some_and(|p| p.value != parameter.value);
            if differs && !state {
                self.world.set(&parameter.path, &parameter.value)?;
            }
        }
        if scene.heaters != self.scene().heaters || scene.heat_gun != self.scene().heat_gun {
            self.generation += 1;
        }
        self.find_largest_step();
        Ok(())
    }

    /// Build a world of `scene`, which continues from the present state if possible and requested.
    pub(super) fn rebuild(&mut self, scene: &Scene, goes_on: bool) -> Result<(), InputError> {
        let fresh = if goes_on && self.world.steps() > 0 { self.continued(scene)? } else { None };
        let continued = fresh.is_some();
        if goes_on && !continued && self.world.steps() > 0 {
            self.note("The run was restarted: its state does not fit the changed dynamic bodies.");
        }
        self.world = fresh.map_or_else(|| World::with_start_overlaps(scene), Ok)?;
        self.watch_world();
        self.generation += 1;
        self.link.look_again();
        if continued {
            self.run_state.hand = None;
            self.run_state.moved_item = None;
            self.run_state.timeline.follow_rollback(&self.world);
            self.show_present();
            self.find_largest_step();
        } else {
            self.begin();
        }
        Ok(())
    }

    /// World of `scene` in the present state; `None` where the state does not fit.
    fn continued(&mut self, scene: &Scene) -> Result<Option<World>, InputError> {
        if !change::same_free_bodies(self.scene(), scene) {
            return Ok(None);
        }
        let pinned = self.pinned_where_they_are(scene)?;
        let mut fresh = World::with_start_overlaps(&with_pins(scene, &pinned))?;
        if fresh.restore(&self.world.snapshot()).is_err() {
            return Ok(None);
        }
        self.run_state.pinned_here = pinned;
        Ok(Some(fresh))
    }

    /// Copy of the world in its present state, independent of it.
    ///
    /// # Errors
    /// When the scene cannot be built: one of its files is missing.
    pub fn world_again(&self) -> Result<World, InputError> {
        let mut world = World::with_start_overlaps(&with_pins(self.scene(), &self.run_state.pinned_here))?;
        world.restore(&self.world.snapshot())?;
        Ok(world)
    }

    /// Nodes that `scene` pins singly, and the displacements from their initial positions at which
    /// they are fixed: earlier pins keep theirs, new ones take the present displacement.
    fn pinned_where_they_are(&self, scene: &Scene) -> Result<Vec<(usize, u32, DVec3)>, InputError> {
        let mut all = Vec::new();
        for (index, (spec, sheet)) in scene.sheets.iter().zip(self.world.sheets()).enumerate() {
            let now = single_masses(&spec.pins);
            if now.is_empty() {
                continue;
            }
            let before = self.scene().sheets.get(index).map(|s| single_masses(&s.pins)).unwrap_or_default();
            let built = Sheet::build(scene, index)?;
            for mass in now {
                let (i, was) = (mass as usize, self.run_state.pinned_here.iter().find(|p| (p.0, p.1) == (index, mass)));
                let offset = match was {
                    Some(was) if before.contains(&mass) => was.2,
                    _ if before.contains(&mass) => DVec3::ZERO,
                    _ if i < sheet.node_count() && i < built.node_count() => {
                        sheet.state.x.get(i) - built.state.x.get(i)
                    }
                    _ => continue,
                };
                all.push((index, mass, offset));
            }
        }
        Ok(all)
    }
}

/// Nodes of pins that fix nodes by number and nothing else.
fn single_masses(pins: &[PinSpec]) -> Vec<u32> {
    let lists = pins.iter().filter(|p| is_plain(p)).filter_map(|p| match &p.region {
        Region::Masses(list) => Some(list.iter().copied()),
        _ => None,
    });
    lists.flatten().collect()
}

/// Whether a pin fixes positions only.
fn is_plain(pin: &PinSpec) -> bool {
    pin.path.is_empty() && !pin.clamp && pin.body.is_none() && pin.until.is_none() && pin.axes == (true, true, true)
}

/// The scene with single nodes fixed at these displacements from their initial positions.
fn with_pins(scene: &Scene, pinned: &[(usize, u32, DVec3)]) -> Scene {
    let mut scene = scene.clone();
    for (index, sheet) in scene.sheets.iter_mut().enumerate() {
        let mut pins = Vec::new();
        for pin in std::mem::take(&mut sheet.pins) {
            let (true, Region::Masses(list)) = (is_plain(&pin), &pin.region) else {
                pins.push(pin);
                continue;
            };
            for mass in list {
                let moved = pinned.iter().find(|p| (p.0, p.1) == (index, *mass)).map_or(DVec3::ZERO, |p| p.2);
                let path = if moved == DVec3::ZERO {
                    Vec::new()
                } else {
                    vec![PathKey { offset: moved, ..PathKey::default() }]
                };
                pins.push(PinSpec { path, ..PinSpec::fixed(Region::Masses(vec![*mass])) });
            }
        }
        sheet.pins = pins;
    }
    scene
}
