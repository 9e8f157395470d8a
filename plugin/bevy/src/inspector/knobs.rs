//! What panels turn: the parameters of a world by path, whoever holds it.

use sheetwork::World;

use crate::core::SheetWorld;

/// A world whose parameters panels show and change. The editor's sessions are one, a game's [`SheetWorld`] under the inspector is another.
pub trait Knobs {
    /// The world.
    fn world(&self) -> &World;

    /// Sets the parameter at `path`; why not is told, and nothing changed. Whether it was taken.
    fn set(&mut self, path: &str, value: &str) -> bool;

    /// Sets it to what it was before anybody changed it. Whether there was such a value.
    fn set_default(&mut self, path: &str) -> bool;

    /// Tells the user that something was refused.
    fn fail(&mut self, text: String);

    /// Wall-clock time of a step, s; 0 where that is not known.
    fn step_s(&self) -> f64;

    /// Simulated seconds a real second, as asked for.
    fn speed(&self) -> f64;

    /// Largest step at which the undamped sheets hold, s; none where there is no limit or it is not known.
    fn largest_step(&self) -> Option<f64> {
        None
    }

    /// How many times faster than real time steps are; `None` before the first.
    fn real_time_factor(&self) -> Option<f64> {
        (self.step_s() > 0.0).then(|| self.world().dt() / self.step_s())
    }

    /// A parameter that is a number, as it is now; `None` when there is none at this path.
    fn parameter(&self, path: &str) -> Option<f64> {
        self.world().parameters().into_iter().find(|p| p.path == path)?.value.parse().ok()
    }
}

/// What the inspector has changed of a game's world.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// Every parameter that was changed, with the value it had first.
    first: Vec<(String, String)>,
    /// What each edit changed, and the value before, oldest first.
    undo: Vec<(String, String)>,
    /// Whether the next edit is a step of undo of its own.
    sealed: bool,
    /// What was refused.
    pub messages: Vec<String>,
}

/// Most edits that can be undone.
const MOST_UNDO: usize = 200;

impl Changes {
    /// Parameters that were changed and the values that the game had them at.
    pub fn all(&self) -> &[(String, String)] {
        &self.first
    }

    /// The parameter that undo would bring back.
    pub fn undoes(&self) -> Option<&str> {
        self.undo.last().map(|u| u.0.as_str())
    }

    /// Ends a row of edits, as a drag makes them.
    pub fn seal(&mut self) {
        self.sealed = true;
    }

    /// Forgets what was changed: the world is another.
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
            if self.undo.len() > MOST_UNDO {
                self.undo.remove(0);
            }
        }
        self.sealed = false;
    }
}

/// A game under the inspector.
pub struct Game<'a> {
    /// Its world.
    pub world: &'a mut SheetWorld,
    /// Its speed.
    pub speed: f64,
    /// What was changed of it.
    pub changes: &'a mut Changes,
}

impl Game<'_> {
    /// Takes the last edit back. Whether there was one.
    pub fn undo(&mut self) -> bool {
        let Some((path, before)) = self.changes.undo.pop() else { return false };
        self.changes.sealed = true;
        match self.world.set(&path, &before) {
            Ok(_) => true,
            Err(error) => {
                self.fail(error.to_string());
                false
            }
        }
    }
}

impl Knobs for Game<'_> {
    fn world(&self) -> &World {
        self.world
    }

    fn set(&mut self, path: &str, value: &str) -> bool {
        match self.world.set(path, value) {
            Ok(before) => {
                self.changes.note(path, before);
                true
            }
            Err(error) => {
                self.fail(error.to_string());
                false
            }
        }
    }

    fn set_default(&mut self, path: &str) -> bool {
        let first = self.changes.first.iter().find(|f| f.0 == path).map(|f| f.1.clone());
        first.is_some_and(|value| self.set(path, &value))
    }

    fn fail(&mut self, text: String) {
        // A slider held against a limit is refused every frame; it is said once.
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
