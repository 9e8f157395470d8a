//! What the user should know: refusals stay until they are dismissed, what is merely told until something else is.

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
