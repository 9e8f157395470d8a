//! Parameters of a world for panels, whoever owns the world.

use sheetwork::World;

use crate::core::SheetWorld;

/// World whose parameters panels display and change. Implemented by the editor's sessions and, for
/// a game's [`SheetWorld`], by [`InspectedGame`].
pub trait ParameterAccess {
    /// World of the parameters.
    fn world(&self) -> &World;

    /// Set the parameter at `path`. Returns whether the value was accepted; a rejection is reported
    /// and changes nothing.
    fn set(&mut self, path: &str, value: &str) -> bool;

    /// Set the parameter at `path` to its value before the first change. Returns whether there is
    /// one.
    fn set_default(&mut self, path: &str) -> bool;

    /// Report a rejection to the user.
    fn fail(&mut self, text: String);

    /// Wall-clock time of a step, s; 0 where unknown.
    fn step_s(&self) -> f64;

    /// Requested simulated seconds per real second.
    fn speed(&self) -> f64;

    /// Stability limit of the undamped sheets, s; `None` without limit or where unknown.
    fn largest_step(&self) -> Option<f64> {
        None
    }

    /// Simulated time over wall-clock time of a step; `None` before the first step.
    fn real_time_factor(&self) -> Option<f64> {
        (self.step_s() > 0.0).then(|| self.world().dt() / self.step_s())
    }

    /// Present value of a numeric parameter; `None` when there is none at this path.
    fn parameter(&self, path: &str) -> Option<f64> {
        self.world().parameters().into_iter().find(|p| p.path == path)?.value.parse().ok()
    }
}

/// Parameters of a game's world changed by the inspector.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// Each changed parameter with its first value.
    first: Vec<(String, String)>,
    /// Parameter and previous value of each edit, oldest first.
    undo: Vec<(String, String)>,
    /// Whether the next edit starts an undo step of its own.
    sealed: bool,
    /// Messages about rejected values.
    pub messages: Vec<String>,
}

/// Maximum number of undo steps.
const MAX_UNDO: usize = 200;

impl Changes {
    /// Changed parameters and their values in the game.
    pub fn all(&self) -> &[(String, String)] {
        &self.first
    }

    /// Parameter that the next undo restores.
    pub fn undoes(&self) -> Option<&str> {
        self.undo.last().map(|u| u.0.as_str())
    }

    /// End a sequence of edits, such as a drag, which is one undo step.
    pub fn seal(&mut self) {
        self.sealed = true;
    }

    /// Forget all changes, after a restart of the world.
    pub fn forget(&mut self) {
        *self = Self { messages: std::mem::take(&mut self.messages), sealed: true, ..Self::default() };
    }

    fn note(&mut self, path: &str, before: String) {
        if !self.first.iter().any(|f| f.0 == path) {
            self.first.push((path.to_owned(), before.clone()));
        }
        let goes_on = !self.sealed && self.undo.last().is_some_and(|u| u.0 == path);
        if !goes_on {
            self.undo.push((path.to_owned(), before));
            if self.undo.len() > MAX_UNDO {
                self.undo.remove(0);
            }
        }
        self.sealed = false;
    }
}

/// A game under the inspector.
pub struct InspectedGame<'a> {
    /// World of the game.
    pub world: &'a mut SheetWorld,
    /// Speed of the game's clock.
    pub speed: f64,
    /// Changes of the game's world.
    pub changes: &'a mut Changes,
}

impl InspectedGame<'_> {
    /// Undo the last edit. Returns whether there was one.
    pub fn undo(&mut self) -> bool {
        let Some((path, before)) = self.changes.undo.pop() else { return false };
        self.changes.sealed = true;
        self.world.set(&path, &before).map_err(|error| self.fail(error.to_string())).is_ok()
    }
}

impl ParameterAccess for InspectedGame<'_> {
    fn world(&self) -> &World {
        self.world
    }

    fn set(&mut self, path: &str, value: &str) -> bool {
        let before = self.world.set(path, value).map_err(|error| self.fail(error.to_string()));
        before.map(|before| self.changes.note(path, before)).is_ok()
    }

    fn set_default(&mut self, path: &str) -> bool {
        let first = self.changes.first.iter().find(|f| f.0 == path).map(|f| f.1.clone());
        first.is_some_and(|value| self.set(path, &value))
    }

    fn fail(&mut self, text: String) {
        // A slider held against a limit is rejected in every frame; one message suffices.
        if !self.changes.messages.contains(&text) {
            self.changes.messages.push(text);
        }
    }

    fn step_s(&self) -> f64 {
        self.world.mean_step_time()
    }

    fn speed(&self) -> f64 {
        self.speed
    }
}
