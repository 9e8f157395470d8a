//! What the user should know: refusals stay until they are dismissed, what is merely told until something else is.

use super::Session;

/// Something the user should know; shown until dismissed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// What.
    pub text: String,
    /// Whether something was refused or failed, rather than merely told.
    pub error: bool,
    /// Whether it is of this run: it goes when another begins.
    pub of_run: bool,
}

impl Session {
    /// Tells the user that something was refused or failed.
    pub fn fail(&mut self, text: impl Into<String>) {
        self.tell(Message { text: text.into(), error: true, of_run: false });
    }

    /// Tells the user something, in place of what was merely told before.
    pub fn note(&mut self, text: impl Into<String>) {
        self.messages.retain(|m| m.error);
        self.tell(Message { text: text.into(), error: false, of_run: false });
    }

    /// Tells the user that something went wrong in the run.
    pub(super) fn fail_of_run(&mut self, text: String) {
        self.tell(Message { text, error: true, of_run: true });
    }

    fn tell(&mut self, message: Message) {
        // A slider held against a limit is refused every frame; it is said once.
        if !self.messages.contains(&message) {
            self.messages.push(message);
        }
    }

    /// Messages not yet dismissed, oldest first.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }

    /// Dismisses message `index`.
    pub fn dismiss(&mut self, index: usize) {
        if index < self.messages.len() {
            self.messages.remove(index);
        }
    }
}
