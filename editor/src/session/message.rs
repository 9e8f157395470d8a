//! Messages to the user. Errors stay until dismissed; notes stay until the next note.

/// Message to the user, shown until dismissed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Text of the message.
    pub text: String,
    /// Whether it reports an error.
    pub error: bool,
    /// Whether it belongs to this run, and is removed with the next.
    pub of_run: bool,
}
