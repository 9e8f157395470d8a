//! Files as assets: scenes (`.ron`), sheets (`.sht`), polyhedra (`.pol`); and scenes as entities.
//!
//! `load` has the loaders, `spawn` turns a scene into entities and follows its file. A scene file is found by its typed load,
//! `server.load::<SheetScene>("scenes/wedge.ron")`; without a type it is known by the ending `.sheet.ron`.
//!
//! A scene is loaded again when its file, or one that it names, changes on disk, if Bevy's `file_watcher` feature is on (or
//! [`AssetServer::reload`] is called); whoever shows it follows. A file with a mistake is reported in the log with line and
//! field, and what was there before goes on.

mod load;
mod spawn;

use std::path::Path;

use bevy::asset::AssetApp;
use bevy::asset::io::file::FileAssetReader;
use bevy::prelude::*;
use sheetwork::InputError;
use sheetwork::scene::sht::SheetFile;
use sheetwork::scene::{Polyhedron, Scene};

pub use spawn::{SheetSceneRoot, SheetSceneSpawned};

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

/// The polyhedra of a `.pol` file.
#[derive(Asset, TypePath, Clone, Debug, Default, PartialEq)]
pub struct SheetPolyhedra {
    /// Closed polyhedra, m.
    pub polyhedra: Vec<Polyhedron>,
}

/// The sheet of a `.sht` file: masses and springs as the file has them. A scene or
/// [`Sheet::from_file`](crate::Sheet::from_file) simulates it.
#[derive(Asset, TypePath, Clone, Debug, PartialEq)]
pub struct SheetFileAsset {
    /// What the file says, in SI units.
    pub file: SheetFile,
}

/// Loads scenes, sheets and polyhedra, and spawns [`SheetSceneRoot`]s. Needs Bevy's `AssetPlugin` before it.
#[derive(Clone, Copy, Debug, Default)]
pub struct SheetworkAssetPlugin;

impl Plugin for SheetworkAssetPlugin {
    fn build(&self, app: &mut App) {
        let folder =
            app.get_added_plugins::<AssetPlugin>().first().map_or("assets", |p| p.file_path.as_str()).to_owned();
        let root = FileAssetReader::get_base_path().join(folder);
        app.init_asset::<SheetScene>()
            .init_asset::<SheetPolyhedra>()
            .init_asset::<SheetFileAsset>()
            .register_asset_loader(load::SceneLoader { root })
            .register_asset_loader(load::PolyhedraLoader)
            .register_asset_loader(load::SheetLoader)
            .add_message::<SheetSceneSpawned>()
            .register_type::<SheetSceneRoot>()
            .add_systems(PreUpdate, spawn::spawn_scenes);
    }
}
