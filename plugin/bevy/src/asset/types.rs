//! Assets of scene files and sheet files.

use std::path::Path;

use bevy::prelude::*;
use sheetwork::InputError;
use sheetwork::scene::Scene;
use sheetwork::scene::sht::SheetFile;

/// Scene from a file or from a program: `scenes.add(SheetScene::from(scene))`.
#[derive(Asset, TypePath, Clone, Debug, PartialEq)]
pub struct SheetScene {
    /// Description of the scene. Its files are relative to its `base` folder.
    pub scene: Scene,
}

impl From<Scene> for SheetScene {
    fn from(scene: Scene) -> Self {
        Self { scene }
    }
}

impl SheetScene {
    /// Read a scene file at this path (relative to the working directory), without the asset
    /// server.
    ///
    /// # Errors
    /// When the file cannot be read or is not valid; the error names line and field.
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, InputError> {
        Ok(Self { scene: Scene::load(path.as_ref())? })
    }
}

/// Sheet of a `.sht` file: nodes and springs. A scene or
/// [`Sheet::from_file`](crate::Sheet::from_file) simulates it.
#[derive(Asset, TypePath, Clone, Debug, PartialEq)]
pub struct SheetFileAsset {
    /// Contents of the file, in SI units.
    pub file: SheetFile,
}
