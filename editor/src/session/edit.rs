//! Edits of the scene, undone and redone, and the world brought after them.

use glam::DVec3;
use sheetwork::scene::{MaterialChoice, PathKey, PinSpec, Region, Scene};
use sheetwork::sheet::Sheet;
use sheetwork::{InputError, World};

use super::Session;
use crate::document::{change, change::Change, path, value};

impl Session {
    /// Edits the scene: `change` changes it, and the world goes on, or begins anew where its state would mean nothing. A refusal becomes a
    /// message and changes nothing. Edits in a row with one `key` are undone together. Returns whether it was taken.
    pub fn edit(&mut self, label: &str, key: &str, change: impl FnOnce(&mut Scene)) -> bool {
        let mut scene = self.scene().clone();
        change(&mut scene);
        self.take(label, key, scene, Change::Nothing)
    }

    /// Takes up an edited scene; the world is changed by no less than `least`.
    fn take(&mut self, label: &str, key: &str, scene: Scene, least: Change) -> bool {
        let taken = self.may_edit().and_then(|()| self.bring(&scene, least));
        match taken {
            Ok(()) => {
                self.document.commit(label, key, scene);
                self.after_edit();
                true
            }
            Err(error) => {
                self.fail(error.to_string());
                false
            }
        }
    }

    /// Brings what goes with the scene after it.
    fn after_edit(&mut self) {
        self.find_heaters();
        self.pass_on();
    }

    fn may_edit(&self) -> Result<(), InputError> {
        if self.playback.is_some() {
            return Err(InputError::new("", "a recording cannot be changed; open its scene for that"));
        }
        Ok(())
    }

    /// Changes a parameter of the world by path; kept through [`Session::reset`]. A refusal becomes a message and changes
    /// nothing. Returns whether it was taken.
    pub fn set(&mut self, path: &str, value: &str) -> bool {
        match self.try_set(path, value) {
            Ok(_) => true,
            Err(error) => {
                self.fail(error.to_string());
                false
            }
        }
    }

    /// Sets a parameter as [`Session::set`] does, but returns the old value, or why not.
    pub(crate) fn try_set(&mut self, path: &str, value: &str) -> Result<String, InputError> {
        if self.playback.is_some() {
            return Err(InputError::new(path, "cannot be changed in a recording; open its scene for that"));
        }
        let value = &*self.world.in_own_unit(path, value)?;
        let field = path::numbered(self.world.sheets(), path);
        let known = self.world.parameters().into_iter().find(|p| path::numbered(self.world.sheets(), &p.path) == field);
        let scene = path::with_value(self.scene(), &field, value);
        // The mass follows the thickness where a sheet is made, not where a number of it is set.
        let live = known.is_some() && !field.ends_with("material.thickness");
        let old = match (live, known) {
            (true, _) => self.world.set(path, value)?,
            (_, Some(known)) => known.value,
            // The world says what there is.
            _ if scene.is_err() => return self.world.set(path, value),
            _ => value::of(self.scene(), &field).unwrap_or_default(),
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
            // They glow otherwise.
            self.generation += 1;
        }
        Ok(old)
    }

    /// The value that a double click brings back: of the material's preset, or of the scene as it was opened.
    pub fn default_of(&self, path: &str) -> Option<String> {
        let field = path::numbered(self.world.sheets(), path);
        let preset = value::of_preset(self.scene(), &field);
        preset.or_else(|| value::of(self.document.opened(), &field)).filter(|v| v != "none")
    }

    /// Sets the parameter at `path` to its default. Returns whether there was one that was taken.
    pub fn set_default(&mut self, path: &str) -> bool {
        self.default_of(path).is_some_and(|value| self.set(path, &value))
    }

    /// Fields changed since the scene was opened or saved: path and value.
    pub fn changes(&self) -> Vec<(String, String)> {
        value::changed(self.document.saved(), self.scene())
    }

    /// Makes sheet `index` of another material of the library, and starts the scene anew with it; what else was changed
    /// stays. A refusal becomes a message and changes nothing. Returns whether it was taken.
    pub fn choose_material(&mut self, index: usize, name: &str) -> bool {
        self.take_material(index, name.into())
    }

    /// Makes sheet `index` of `material` and starts the scene anew.
    pub fn take_material(&mut self, index: usize, material: MaterialChoice) -> bool {
        let mut scene = self.scene().clone();
        let Some(sheet) = scene.sheets.get_mut(index) else { return false };
        let label = format!("material {}", material.name());
        sheet.material = material;
        // Its own damping is the material's now.
        sheet.damping_ratio = None;
        self.take(&label, "material", scene, Change::Anew)
    }

    /// Goes one edit back. Returns whether there was one.
    pub fn undo(&mut self) -> bool {
        let Some(scene) = self.document.before().cloned() else { return false };
        let then = self.document.state_before().cloned();
        let now = then.is_some().then(|| self.world.snapshot());
        if let Err(error) = self.bring(&scene, Change::Nothing) {
            self.fail(error.to_string());
            return false;
        }
        let undone = self.document.undo();
        if let Some(then) = then {
            self.document.keep_undone(now);
            self.go_to(&then);
            self.timeline.renew(&self.world);
        }
        self.after_edit();
        undone
    }

    /// Takes up an undone edit again. Returns whether there was one.
    pub fn redo(&mut self) -> bool {
        let Some(scene) = self.document.after().cloned() else { return false };
        let then = self.document.state_after().cloned();
        let now = then.is_some().then(|| self.world.snapshot());
        if let Err(error) = self.bring(&scene, Change::Nothing) {
            self.fail(error.to_string());
            return false;
        }
        let redone = self.document.redo();
        if let Some(then) = then {
            self.document.keep_redone(now);
            self.go_to(&then);
            self.timeline.renew(&self.world);
        }
        self.after_edit();
        redone
    }

    /// Ends a row of edits: the next is undone apart.
    pub fn seal(&mut self) {
        self.document.seal();
    }

    /// Puts everything back to the start and keeps what was changed. Returns whether it could.
    pub fn reset(&mut self) -> bool {
        if self.playback.is_some() {
            self.seek(0.0);
            return true;
        }
        let scene = self.scene().clone();
        match self.rebuild(&scene, false) {
            Ok(()) => true,
            Err(error) => {
                self.fail(error.to_string());
                false
            }
        }
    }

    /// Changes the world from the present scene's to `scene`'s.
    fn bring(&mut self, scene: &Scene, least: Change) -> Result<(), InputError> {
        match change::between(self.scene(), scene).max(least) {
            Change::Nothing => Ok(()),
            Change::Live => self.turn(scene),
            Change::GoesOn => self.rebuild(scene, true),
            Change::Anew => self.rebuild(scene, false),
        }
    }

    /// Sets the parameters that differ from those of a world of `scene`.
    fn turn(&mut self, scene: &Scene) -> Result<(), InputError> {
        let wanted = World::new(scene)?.parameters();
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

    /// Makes a world of `scene`, which goes on from the present state if it can, or else begins.
    pub(super) fn rebuild(&mut self, scene: &Scene, goes_on: bool) -> Result<(), InputError> {
        let mut fresh = if goes_on && self.world.steps() > 0 { self.continued(scene)? } else { None };
        let continued = fresh.is_some();
        if goes_on && !continued && self.world.steps() > 0 {
            self.note("The run began again: it could not go on with other bodies that move freely.");
        }
        if fresh.is_none() {
            fresh = Some(World::new(scene)?);
        }
        if let Some(fresh) = fresh {
            self.world = fresh;
            self.watch_world();
        }
        self.generation += 1;
        self.link.look_again();
        if continued {
            self.hand = None;
            self.carried = None;
            self.timeline.went(&self.world);
            self.settle_display();
            self.find_largest_step();
        } else {
            self.begin();
        }
        Ok(())
    }

    /// A world of `scene` in the present state; none where that cannot be.
    fn continued(&mut self, scene: &Scene) -> Result<Option<World>, InputError> {
        if !change::same_free_bodies(self.scene(), scene) {
            return Ok(None);
        }
        let pinned = self.pinned_where_they_are(scene)?;
        let mut fresh = World::new(&with_pins(scene, &pinned))?;
        if fresh.restore(&self.world.snapshot()).is_err() {
            return Ok(None);
        }
        self.pinned_here = pinned;
        Ok(Some(fresh))
    }

    /// The world once more, as it is now: what becomes of it leaves this one alone.
    ///
    /// # Errors
    /// When the scene cannot be built any more: a file that it names has gone.
    pub fn world_again(&self) -> Result<World, InputError> {
        let mut world = World::new(&with_pins(self.scene(), &self.pinned_here))?;
        world.restore(&self.world.snapshot())?;
        Ok(world)
    }

    /// Masses that `scene` pins one by one, and how far from their places at the start they are held: those that were held go on so, the
    /// others are held where they are.
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
                let (i, was) = (mass as usize, self.pinned_here.iter().find(|p| (p.0, p.1) == (index, mass)));
                let offset = match was {
                    Some(was) if before.contains(&mass) => was.2,
                    _ if before.contains(&mass) => DVec3::ZERO,
                    _ if i < sheet.masses() && i < built.masses() => sheet.x.get(i) - built.x.get(i),
                    _ => continue,
                };
                all.push((index, mass, offset));
            }
        }
        Ok(all)
    }
}

/// Masses of pins that hold masses by number and nothing else of them.
fn single_masses(pins: &[PinSpec]) -> Vec<u32> {
    let lists = pins.iter().filter(|p| is_plain(p)).filter_map(|p| match &p.region {
        Region::Masses(list) => Some(list.iter().copied()),
        _ => None,
    });
    lists.flatten().collect()
}

/// Whether a pin holds its masses still and no more.
fn is_plain(pin: &PinSpec) -> bool {
    pin.path.is_empty() && !pin.clamp && pin.body.is_none() && pin.until.is_none() && pin.axes == (true, true, true)
}

/// The scene with single masses held so far from where they start.
fn with_pins(scene: &Scene, pinned: &[(usize, u32, DVec3)]) -> Scene {
    let mut scene = scene.clone();
    for (index, sheet) in scene.sheets.iter_mut().enumerate() {
        let mut pins = Vec::new();
        for pin in std::mem::take(&mut sheet.pins) {
            let Region::Masses(list) = &pin.region else {
                pins.push(pin);
                continue;
            };
            if !is_plain(&pin) {
                pins.push(pin);
                continue;
            }
            for mass in list {
                let moved = pinned.iter().find(|p| (p.0, p.1) == (index, *mass)).map_or(DVec3::ZERO, |p| p.2);
                let path = if moved == DVec3::ZERO {
                    Vec::new()
                } else {
                    vec![PathKey { offset: moved, ..PathKey::default() }]
                };
                pins.push(PinSpec { path, ..PinSpec::held(Region::Masses(vec![*mass])) });
            }
        }
        sheet.pins = pins;
    }
    scene
}
