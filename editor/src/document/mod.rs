//! The scene that is being edited, with what came before it: undo, redo, and whether it is saved.
//!
//! Every edit makes a new scene, and the old one is kept: a scene is a description of some kilobytes, and going back to one cannot go wrong.
//! Edits in a row with one key, as a slider makes while it is dragged, are one step of undo until [`Document::seal`] ends it.
//! What an edit means for a world that runs is worked out in `change`, where files go when a scene moves in `files`, and which
//! field of the scene a parameter of the world is in `path`; `value` has fields as text.

pub mod change;
pub mod files;
pub mod path;
pub mod value;

use sheetwork::Snapshot;
use sheetwork::scene::Scene;

/// Most steps that can be undone.
pub const MOST_UNDO: usize = 200;

/// A scene before or after an edit.
#[derive(Clone, Debug)]
struct Step {
    /// What the edit did, as menus say it.
    label: String,
    key: String,
    scene: Scene,
    /// The world then, where the edit changed it beyond what its scene says.
    state: Option<Snapshot>,
}

/// The scene and its past.
#[derive(Clone, Debug)]
pub struct Document {
    scene: Scene,
    /// As it was opened.
    opened: Scene,
    /// As the file has it.
    saved: Scene,
    /// Scenes before edits, oldest first.
    past: Vec<Step>,
    /// Scenes that were undone, the next to be redone last.
    future: Vec<Step>,
    /// Whether the next edit is a step of its own whatever its key.
    sealed: bool,
    revision: u64,
}

impl Document {
    /// A scene as it was read.
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

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene as it was opened, before any edit.
    pub fn opened(&self) -> &Scene {
        &self.opened
    }

    /// The scene as its file has it.
    pub fn saved(&self) -> &Scene {
        &self.saved
    }

    /// Changes with every edit, undo and redo.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Takes up an edited scene. `key` says what was edited: edits in a row with the same one are undone together.
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
            if self.past.len() > MOST_UNDO {
                self.past.remove(0);
            }
        }
        self.future.clear();
        self.sealed = false;
        self.revision += 1;
    }

    /// The same of an edit that changes the world beyond what its scene says, or the world alone: `state` is the world before it.
    pub fn commit_with(&mut self, label: impl Into<String>, key: &str, scene: Scene, state: Snapshot) {
        self.push(label.into(), key, scene);
        if let Some(step) = self.past.last_mut() {
            step.state.get_or_insert(state);
        }
    }

    /// The world that undo goes back to, where the edit changed it beyond what its scene says.
    pub fn state_before(&self) -> Option<&Snapshot> {
        self.past.last()?.state.as_ref()
    }

    /// The world that redo leads to, likewise.
    pub fn state_after(&self) -> Option<&Snapshot> {
        self.future.last()?.state.as_ref()
    }

    /// Keeps the world as it was before the last undo, for redo.
    pub fn keep_undone(&mut self, state: Option<Snapshot>) {
        if let Some(step) = self.future.last_mut() {
            step.state = state;
        }
    }

    /// Keeps the world as it was before the last redo, for undo.
    pub fn keep_redone(&mut self, state: Option<Snapshot>) {
        if let Some(step) = self.past.last_mut() {
            step.state = state;
        }
    }

    /// Ends a row of edits: the next is undone apart.
    pub fn seal(&mut self) {
        self.sealed = true;
    }

    /// What undo would undo.
    pub fn undoes(&self) -> Option<&str> {
        self.past.last().map(|step| step.label.as_str())
    }

    /// What redo would do again.
    pub fn redoes(&self) -> Option<&str> {
        self.future.last().map(|step| step.label.as_str())
    }

    /// The scene that undo leads to.
    pub fn before(&self) -> Option<&Scene> {
        self.past.last().map(|step| &step.scene)
    }

    /// The scene that redo leads to.
    pub fn after(&self) -> Option<&Scene> {
        self.future.last().map(|step| &step.scene)
    }

    /// Goes one edit back; whether there was one.
    pub fn undo(&mut self) -> bool {
        let Some(Step { label, key, scene, .. }) = self.past.pop() else { return false };
        let undone = std::mem::replace(&mut self.scene, scene);
        self.future.push(Step { label, key, scene: undone, state: None });
        self.moved();
        true
    }

    /// Takes up an undone edit again; whether there was one.
    pub fn redo(&mut self) -> bool {
        let Some(Step { label, key, scene, .. }) = self.future.pop() else { return false };
        let before = std::mem::replace(&mut self.scene, scene);
        self.past.push(Step { label, key, scene: before, state: None });
        self.moved();
        true
    }

    fn moved(&mut self) {
        self.sealed = true;
        self.revision += 1;
    }

    /// Whether there is work that no file has.
    pub fn is_unsaved(&self) -> bool {
        !same(&self.scene, &self.saved)
    }

    /// Says that `scene`, the present one as it was written, is in its file now.
    pub fn wrote(&mut self, scene: Scene) {
        // What came before lies where it lies now: undo must not find other file names in it.
        for step in self.past.iter_mut().chain(&mut self.future) {
            step.scene = Scene { file: scene.file.clone(), ..files::moved(&step.scene, &scene.base) };
        }
        self.saved = scene.clone();
        self.scene = scene;
        self.moved();
    }

    /// Takes a scene that no file has, as one that was recovered.
    pub fn never_saved(&mut self) {
        self.saved = Scene::default();
    }
}

/// Whether two scenes are the same but for where they lie.
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
        Scene { dt, ..Scene::default() }
    }

    #[test]
    fn edits_are_undone_and_redone_one_by_one() {
        let mut document = Document::new(with_dt(1e-3));
        assert!(!document.undo() && !document.redo() && !document.is_unsaved());
        document.commit("a", "dt", with_dt(2e-3));
        document.seal();
        document.commit("b", "dt", with_dt(3e-3));
        assert_eq!((document.undoes(), document.redoes()), (Some("b"), None));
        assert!(document.undo());
        assert_eq!((document.scene().dt, document.redoes()), (2e-3, Some("b")));
        assert!(document.undo() && !document.is_unsaved());
        assert!(document.redo() && document.redo() && !document.redo());
        assert_eq!(document.scene().dt, 3e-3);
        document.undo();
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
        assert!(document.undo() && document.undo());
        assert_eq!(document.scene().dt, 1e-3);
        assert!(!document.undo());
        let revision = document.revision();
        document.commit("nothing", "dt", with_dt(1e-3));
        assert_eq!((document.revision(), document.undoes()), (revision, None), "no edit at all");
    }

    #[test]
    fn undo_is_bounded_and_saving_is_remembered() {
        let mut document = Document::new(with_dt(1e-3));
        for i in 0..2 * MOST_UNDO {
            document.commit("dt", "dt", with_dt(1e-3 + 1e-6 * (i + 1) as f64));
            document.seal();
        }
        assert!(document.is_unsaved());
        let now = document.scene().clone();
        document.wrote(now);
        assert!(!document.is_unsaved());
        let mut undone = 0;
        while document.undo() {
            undone += 1;
        }
        assert_eq!(undone, MOST_UNDO);
        assert!(document.is_unsaved(), "before the save is not what the file has");
    }
}
