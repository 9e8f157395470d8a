//! Files as assets: scenes (`.ron`), sheets (`.sht`), polyhedra (`.pol`); and scenes as entities.
//!
//! `types` holds the assets, `load` the loaders; `spawn` turns a scene into entities and follows
//! its file. A scene is loaded by type, `server.load::<SheetScene>("scenes/wedge.ron")`; an untyped
//! load needs the extension `.sheet.ron`.
//!
//! With Bevy's `file_watcher` feature, or after [`AssetServer::reload`], a scene is loaded again
//! when its file or a file that it names changes, and its entities are spawned again. An invalid
//! file is reported in the log with line and field; the previous scene continues.

mod load;
mod spawn;
mod types;

use bevy::asset::AssetApp;
use bevy::asset::io::file::FileAssetReader;
use bevy::prelude::*;

pub use crate::core::SheetPolyhedra;
pub use spawn::{SheetSceneRoot, SheetSceneSpawned};
pub use types::{SheetFileAsset, SheetScene};

/// Plugin that loads scenes, sheets and polyhedra, and spawns [`SheetSceneRoot`]s. Add it after
/// Bevy's `AssetPlugin`.
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
            .register_asset_loader(load::POLYHEDRA)
            .register_asset_loader(load::SHEETS)
            .add_message::<SheetSceneSpawned>()
            .register_type::<SheetSceneRoot>()
            .add_systems(PreUpdate, spawn::spawn_scenes);
    }
}
