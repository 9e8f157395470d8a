//! File names of a scene that is written to another folder: they are relative to the folder of the
//! scene.

use std::path::{Component, Path, PathBuf};

use sheetwork::InputError;
use sheetwork::mesh::outline::OutlineSpec;
use sheetwork::scene::{MaterialChoice, Scene, Shape};

/// The scene for the folder `to`, with names of the same files.
pub fn moved(scene: &Scene, to: &Path) -> Scene {
    let (from, to) = (absolute(&scene.base), absolute(to));
    let mut scene = scene.clone();
    if from != to {
        for file in names(&mut scene) {
            if file.is_relative() {
                *file = relative(&normal(&from.join(&*file)), &to);
            }
        }
    }
    scene.base = to;
    scene
}

/// All file names of a scene.
fn names(scene: &mut Scene) -> Vec<&mut PathBuf> {
    let mut all = Vec::new();
    for sheet in &mut scene.sheets {
        all.extend(&mut sheet.file);
        if let MaterialChoice::File(file) = &mut sheet.material {
            all.push(file);
        }
        if let Some(OutlineSpec::Svg { file, .. }) = &mut sheet.outline {
            all.push(file);
        }
    }
    for body in &mut scene.bodies {
        if let Shape::File(file) | Shape::Part(file, _) = &mut body.shape {
            all.push(file);
        }
    }
    all.extend(scene.heaters.iter_mut().filter_map(|h| h.file.as_mut()));
    all
}

/// Write the scene to `file`; returns it as written.
///
/// # Errors
/// When the file cannot be written, or reading it would not give the same scene.
pub fn save(scene: &Scene, file: &Path) -> Result<Scene, InputError> {
    let folder =
        file.parent().filter(|p| !p.as_os_str().is_empty()).map_or_else(|| PathBuf::from("."), Path::to_path_buf);
    let mut scene = moved(scene, &folder);
    let text = scene.to_text()?;
    // Checked before the old file is replaced.
    let back = Scene::parse(&text).map_err(|e| InputError::from(e).in_file(file))?;
    scene.base = folder.clone();
    scene.file = Some(file.to_path_buf());
    if back != (Scene { base: PathBuf::new(), file: None, ..scene.clone() }) {
        return Err(InputError::new("", "would not be read back as it is, and is not written").in_file(file));
    }
    std::fs::create_dir_all(&folder).map_err(|e| InputError::io(&folder, &e))?;
    // Written beside the old file and renamed, so that a full disk or a crash keeps the old file.
    let beside = file.with_extension("ron.part");
    std::fs::write(&beside, text).map_err(|e| InputError::io(&beside, &e))?;
    std::fs::rename(&beside, file).map_err(|e| InputError::io(file, &e))?;
    Ok(scene)
}

/// Absolute path of the folder.
fn absolute(folder: &Path) -> PathBuf {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    normal(&std::path::absolute(here).unwrap_or_else(|_| here.to_path_buf()))
}

/// Path without `.` and `..` where possible.
fn normal(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if out.file_name().is_some() => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    out
}

/// Relative path from the folder `from` to `file`, both absolute.
fn relative(file: &Path, from: &Path) -> PathBuf {
    let common = file.components().zip(from.components()).take_while(|(a, b)| a == b).count();
    if common <= 1 {
        return file.to_path_buf();
    }
    let up = from.components().skip(common).map(|_| Component::ParentDir);
    up.chain(file.components().skip(common)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::scene::{BodySpec, SheetSpec};

    #[test]
    fn a_scene_in_another_folder_names_the_same_files() {
        let sheet = SheetSpec { file: Some("../sheets/a.sht".into()), ..SheetSpec::thesis() };
        let body = BodySpec::new(Shape::File("/else/where.pol".into()));
        let scene =
            Scene { sheets: vec![sheet], bodies: vec![body], base: "/home/me/assets/scenes".into(), ..Scene::thesis() };
        let there = moved(&scene, Path::new("/home/me/mine/deep"));
        assert_eq!(there.sheets[0].file.as_deref(), Some(Path::new("../../assets/sheets/a.sht")));
        assert_eq!(there.bodies[0].shape, Shape::File("/else/where.pol".into()), "one from the root stays");
        let same = moved(&there, Path::new("/home/me/assets/scenes"));
        assert_eq!(same.sheets[0].file.as_deref(), Some(Path::new("../sheets/a.sht")));
    }
}
