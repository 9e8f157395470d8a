//! Asset loaders, which parse and validate.

use std::path::{Path, PathBuf};

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;
use sheetwork::scene::{MaterialChoice, Scene, Shape, pol, sht};
use sheetwork::{InputError, World};

use super::{SheetFileAsset, SheetPolyhedra, SheetScene};

/// Loader of scenes. It builds the world once to validate the scene.
#[derive(TypePath)]
pub(super) struct SceneLoader {
    /// Folder of the default asset source.
    pub root: PathBuf,
}

/// Loader of text files of one format.
#[derive(TypePath)]
pub(super) struct TextLoader<A: Asset> {
    read: fn(&str) -> Result<A, InputError>,
    extensions: &'static [&'static str],
}

/// Loader of `.pol` files.
pub(super) const POLYHEDRA: TextLoader<SheetPolyhedra> = TextLoader {
    read: |text| pol::read_pol(text).map(|polyhedra| SheetPolyhedra { polyhedra }),
    extensions: &["pol", "POL"],
};

/// Loader of `.sht` files.
pub(super) const SHEETS: TextLoader<SheetFileAsset> =
    TextLoader { read: |text| sht::read_sht(text).map(|file| SheetFileAsset { file }), extensions: &["sht", "SHT"] };

async fn text(reader: &mut dyn Reader, path: &Path) -> Result<String, InputError> {
    let mut bytes = Vec::new();
    reader.read_to_end(&mut bytes).await.map_err(|e| InputError::io(path, &e))?;
    String::from_utf8(bytes).map_err(|e| InputError::new("", format!("is not text: {e}")).in_file(path))
}

impl AssetLoader for SceneLoader {
    type Asset = SheetScene;
    type Settings = ();
    type Error = InputError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<SheetScene, InputError> {
        let path = context.path().path().to_owned();
        let file = self.root.join(&path);
        let text = text(reader, &file).await?;
        let mut scene = Scene::parse(&text).map_err(|e| InputError::from(e).in_file(&file))?;
        scene.base = file.parent().map(Path::to_path_buf).unwrap_or_default();
        for name in files_of(&scene) {
            // Reading a file registers it with the asset server, which reloads the scene when the
            // file changes. The world built below reports missing or invalid files.
            if let Ok(named) = context.path().resolve_embed_str(&name.to_string_lossy()) {
                let _bytes = context.read_asset_bytes(named).await;
            }
        }
        World::new(&scene).map_err(|e| if e.file.is_none() { InputError::from(e).in_file(&file) } else { e.into() })?;
        Ok(SheetScene { scene })
    }

    fn extensions(&self) -> &[&str] {
        &["sheet.ron"]
    }
}

/// Files named by a scene.
fn files_of(scene: &Scene) -> Vec<PathBuf> {
    let sheets = scene.sheets.iter().filter_map(|s| s.file.clone());
    let materials = scene.sheets.iter().filter_map(|s| match &s.material {
        MaterialChoice::File(file) => Some(file.clone()),
        MaterialChoice::Named(_) | MaterialChoice::Inline(_) => None,
    });
    let bodies = scene.bodies.iter().filter_map(|b| match &b.shape {
        Shape::File(file) | Shape::Part(file, _) => Some(file.clone()),
        Shape::Polyhedron(_) | Shape::Box(_) | Shape::Ball(_) | Shape::HalfSpace => None,
    });
    let heaters = scene.heaters.iter().filter_map(|h| h.file.clone());
    sheets.chain(materials).chain(bodies).chain(heaters).filter(|file| file.is_relative()).collect()
}

impl<A: Asset> AssetLoader for TextLoader<A> {
    type Asset = A;
    type Settings = ();
    type Error = InputError;

    async fn load(&self, reader: &mut dyn Reader, _: &(), context: &mut LoadContext<'_>) -> Result<A, InputError> {
        let path = context.path().path().to_owned();
        (self.read)(&text(reader, &path).await?).map_err(|e| e.in_file(&path))
    }

    fn extensions(&self) -> &[&str] {
        self.extensions
    }
}
