//! The state of the dialog that chooses a file.

use std::path::PathBuf;

use crate::browser::Browser;

/// What a file is chosen for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// To be opened, or added to the scene.
    Open,
    /// To save the scene in.
    Save,
    /// To write the samples in.
    Csv,
    /// To draw the scene in, as it is seen.
    Picture,
    /// To draw a run in, picture by picture.
    Sequence,
    /// To write a run in as glTF.
    Gltf,
}

/// A dialog that chooses a file.
#[derive(Clone, Debug)]
pub struct Dialog {
    pub(super) purpose: Purpose,
    pub(super) browser: Browser,
    /// A file that is there already, and would be written over.
    pub(super) over: Option<PathBuf>,
    /// Whether it was shown before: what is typed at once is a name.
    pub(super) shown: bool,
}
