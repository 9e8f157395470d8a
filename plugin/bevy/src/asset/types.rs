//! The assets of scene files and sheet files.

use std::path::Path;

use bevy::prelude::*;
use sheetwork::InputError;
use sheetwork::scene::Scene;
use sheetwork::scene::sht::SheetFile;

/// A scene, read from a file or made by a program: `scenes.add(SheetScene::from(scene))`.
#[derive(Asset, TypePath, Clone, Debug, PartialEq)]
pub struct SheetScene {
    /// The description. Files it names are found relative to its `base` folder.
    pub scene: Scene,
}

impl From<Scene> for SheetScene {
    fn from(scene: Scene) -> Self {
        Self { scene }
    }
}

impl SheetScene {
    /// Reads a scene file of this path (relative to the working directory), without the asset server.
    ///
    /// # Errors
    /// When it cannot be read or something in it is not valid: with line and field.
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, InputError> {
        Ok(Self { scene: Scene::load(path.as_ref())? })
    }
}

/// The sheet of a `.sht` file: masses and springs as the file has them. A scene or
/// [`Sheet::from_file`](crate::Sheet::from_file) simulates it.
#[derive(Asset, TypePath, Clone, Debug, PartialEq)]
pub struct SheetFileAsset {
    /// What the file says, in SI units.
    pub file: SheetFile,
}
