//! State of the file dialog.

use std::path::PathBuf;

use crate::browser::Browser;

/// Purpose of a file dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Open a file, or add it to the scene.
    Open,
    /// Save the scene.
    Save,
    /// Write the samples as CSV.
    Csv,
    /// Draw the present view.
    Picture,
    /// Draw a run as a sequence of pictures.
    Sequence,
    /// Write a run as glTF.
    Gltf,
}

impl Purpose {
    /// Title of the dialog, and extensions of its files.
    pub(super) fn row(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Open => ("Open, or add to the scene", &["ron", "swr", "sht", "pol", "heater"]),
            Self::Save => ("Save as", &["ron"]),
            Self::Csv => ("Export samples", &["csv"]),
            Self::Picture => ("Export a picture", &["png"]),
            Self::Sequence => ("Export pictures", &["png"]),
            Self::Gltf => ("Export glTF", &["glb"]),
        }
    }
}

/// File dialog.
#[derive(Clone, Debug)]
pub struct Dialog {
    pub(super) purpose: Purpose,
    pub(super) browser: Browser,
    /// Existing file that would be overwritten.
    pub(super) over: Option<PathBuf>,
    /// Whether the dialog has been shown: the first typed text is the name.
    pub(super) shown: bool,
}
