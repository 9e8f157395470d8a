//! Edited scene with its history: undo, redo, and whether it is saved.
//!
//! Every edit makes a new scene of some kilobytes, and the old one is stored for undo. Consecutive
//! edits with one key, such as those of a dragged slider, are one undo step until
//! [`Document::seal`]. `change` determines the effect of an edit on a running world, `files`
//! adjusts file names when a scene is written to another folder, `path` maps parameters of the
//! world to fields of the scene, and `value` converts fields to text.

pub mod change;
pub mod files;
pub mod path;
pub mod value;

use sheetwork::Snapshot;
use sheetwork::scene::Scene;

/// Maximum number of undo steps.
pub const MAX_UNDO: usize = 200;

/// Scene before or after an edit.
#[derive(Clone, Debug)]
struct Step {
    /// Name of the edit in menus.
    label: String,
    key: String,
    scene: Scene,
    /// State of the world, for an edit that changes it beyond the scene.
    state: Option<Snapshot>,
}

/// Step in the history.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Revert the last edit.
    Undo,
    /// Repeat the last undone edit.
    Redo,
}

/// Scene with its history.
#[derive(Clone, Debug)]
pub struct Document {
    scene: Scene,
    /// Scene as it was opened.
    opened: Scene,
    /// Scene as it is in the file.
    saved: Scene,
    /// Scenes before edits, oldest first.
    past: Vec<Step>,
    /// Undone scenes, the next one to redo last.
    future: Vec<Step>,
    /// Whether the next edit is an undo step of its own, whatever its key.
    sealed: bool,
    revision: u64,
}

impl Document {
    /// Document of an opened scene.
    pub fn new(scene: Scene) -> Self {
        Self {
            opened: scene.clone(),
            saved: scene.clone(),
            scene,
            past: Vec::new(),
            future: Vec::new(),
            sealed: true,
            revision: 0,
        }
    }

    /// Present scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Scene as opened, without edits.
    pub fn opened(&self) -> &Scene {
        &self.opened
    }

    /// Scene as it is in the file.
    pub fn saved(&self) -> &Scene {
        &self.saved
    }

    /// Revision, which changes with every edit, undo and redo.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Store an edited scene. `key` names the edited field: consecutive edits with the same key are
    /// one undo step.
    pub fn commit(&mut self, label: impl Into<String>, key: &str, scene: Scene) {
        if scene != self.scene {
            self.push(label.into(), key, scene);
        }
    }

    fn push(&mut self, label: String, key: &str, scene: Scene) {
        let goes_on = !self.sealed && self.past.last().is_some_and(|step| step.key == key);
        let before = std::mem::replace(&mut self.scene, scene);
        if !goes_on {
            self.past.push(Step { label, key: key.to_owned(), scene: before, state: None });
            if self.past.len() > MAX_UNDO {
                self.past.remove(0);
            }
        }
        self.future.clear();
        self.sealed = false;
        self.revision += 1;
    }

    /// Store an edit that changes the world beyond its scene, or the world alone; `state` is the
    /// world before the edit.
    pub fn commit_with(&mut self, label: impl Into<String>, key: &str, scene: Scene, state: Snapshot) {
        self.push(label.into(), key, scene);
        if let Some(step) = self.past.last_mut() {
            step.state.get_or_insert(state);
        }
    }

    /// End a sequence of edits: the next one is an undo step of its own.
    pub fn seal(&mut self) {
        self.sealed = true;
    }

    /// Name of the edit that undo reverts.
    pub fn undoes(&self) -> Option<&str> {
        self.past.last().map(|step| step.label.as_str())
    }

    /// Name of the edit that redo repeats.
    pub fn redoes(&self) -> Option<&str> {
        self.future.last().map(|step| step.label.as_str())
    }

    /// Scene after a step in the history, and the state of the world then, for an edit that changed
    /// it beyond the scene.
    pub fn next(&self, turn: Turn) -> Option<(&Scene, Option<&Snapshot>)> {
        let steps = if turn == Turn::Undo { &self.past } else { &self.future };
        steps.last().map(|step| (&step.scene, step.state.as_ref()))
    }

    /// Take a step in the history; `state` is the present world, for the step back. Returns whether
    /// there was one.
    pub fn turn(&mut self, turn: Turn, state: Option<Snapshot>) -> bool {
        let (from, to) = match turn {
            Turn::Undo => (&mut self.past, &mut self.future),
            Turn::Redo => (&mut self.future, &mut self.past),
        };
        let Some(Step { label, key, scene, .. }) = from.pop() else { return false };
        let scene = std::mem::replace(&mut self.scene, scene);
        to.push(Step { label, key, scene, state });
        self.moved();
        true
    }

    fn moved(&mut self) {
        self.sealed = true;
        self.revision += 1;
    }

    /// Whether there are unsaved changes.
    pub fn is_unsaved(&self) -> bool {
        !same(&self.scene, &self.saved)
    }

    /// Record that the present scene was written to its file as `scene`.
    pub fn wrote(&mut self, scene: Scene) {
        // Earlier scenes take the new folder too, so that undo keeps the file names valid.
        for step in self.past.iter_mut().chain(&mut self.future) {
            step.scene = Scene { file: scene.file.clone(), ..files::moved(&step.scene, &scene.base) };
        }
        self.saved = scene.clone();
        self.scene = scene;
        self.moved();
    }

    /// Mark the scene as unsaved, as after recovery.
    pub fn never_saved(&mut self) {
        self.saved = Scene::default();
    }
}

/// Whether two scenes are equal apart from their file and folder.
fn same(a: &Scene, b: &Scene) -> bool {
    if a == b {
        return true;
    }
    let bare = |s: &Scene| Scene { base: Default::default(), file: None, ..s.clone() };
    bare(a) == bare(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_dt(dt: f64) -> Scene {
        Scene { dt, ..Scene::thesis() }
    }

    #[test]
    fn edits_are_undone_and_redone_one_by_one() {
        let mut document = Document::new(with_dt(1e-3));
        assert!(!document.turn(Turn::Undo, None) && !document.turn(Turn::Redo, None) && !document.is_unsaved());
        document.commit("a", "dt", with_dt(2e-3));
        document.seal();
        document.commit("b", "dt", with_dt(3e-3));
        assert_eq!((document.undoes(), document.redoes()), (Some("b"), None));
        assert!(document.turn(Turn::Undo, None));
        assert_eq!((document.scene().dt, document.redoes()), (2e-3, Some("b")));
        assert!(document.turn(Turn::Undo, None) && !document.is_unsaved());
        assert!(document.turn(Turn::Redo, None) && document.turn(Turn::Redo, None) && !document.turn(Turn::Redo, None));
        assert_eq!(document.scene().dt, 3e-3);
        document.turn(Turn::Undo, None);
        document.commit("c", "name", Scene { name: "other".into(), ..with_dt(2e-3) });
        assert_eq!(document.redoes(), None, "an edit ends what could be redone");
    }

    #[test]
    fn a_dragged_slider_is_one_step() {
        let mut document = Document::new(with_dt(1e-3));
        for i in 2..50 {
            document.commit("dt", "dt", with_dt(f64::from(i) * 1e-3));
        }
        document.commit("name", "name", Scene { name: "other".into(), ..with_dt(0.05) });
        assert!(document.turn(Turn::Undo, None) && document.turn(Turn::Undo, None));
        assert_eq!(document.scene().dt, 1e-3);
        assert!(!document.turn(Turn::Undo, None));
        let revision = document.revision();
        document.commit("nothing", "dt", with_dt(1e-3));
        assert_eq!((document.revision(), document.undoes()), (revision, None), "no edit at all");
    }

    #[test]
    fn undo_is_bounded_and_saving_is_remembered() {
        let mut document = Document::new(with_dt(1e-3));
        for i in 0..2 * MAX_UNDO {
            document.commit("dt", "dt", with_dt(1e-3 + 1e-6 * (i + 1) as f64));
            document.seal();
        }
        assert!(document.is_unsaved());
        let now = document.scene().clone();
        document.wrote(now);
        assert!(!document.is_unsaved());
        let mut undone = 0;
        while document.turn(Turn::Undo, None) {
            undone += 1;
        }
        assert_eq!(undone, MAX_UNDO);
        assert!(document.is_unsaved(), "before the save is not what the file has");
    }
}
