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
mod types;

use bevy::asset::AssetApp;
use bevy::asset::io::file::FileAssetReader;
use bevy::prelude::*;

pub use crate::core::SheetPolyhedra;
pub use spawn::{SheetSceneRoot, SheetSceneSpawned};
pub use types::{SheetFileAsset, SheetScene};

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
