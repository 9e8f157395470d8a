//! Shipped scenes: the folder `assets/scenes` and its files.

use std::path::{Path, PathBuf};

/// The folder `assets/scenes`: below the current folder or one above it, below the folder of the
/// executable or one above it, or in the source tree of the build. `None` when there is none.
pub fn folder() -> Option<PathBuf> {
    let mut starts = Vec::new();
    if let Ok(here) = std::env::current_dir() {
        starts.push(here);
    }
    if let Some(root) = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2) {
        starts.push(root.to_path_buf());
    }
    if let Ok(program) = std::env::current_exe() {
        starts.extend(program.parent().map(Path::to_path_buf));
    }
    starts.iter().find_map(|start| folder_from(start))
}

fn folder_from(start: &Path) -> Option<PathBuf> {
    start.ancestors().map(|above| above.join("assets").join("scenes")).find(|folder| folder.is_dir())
}

/// Scene files of `folder`, sorted by name.
pub fn list(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).filter(|p| is_scene(p)).collect();
    files.sort();
    files
}

/// Whether a file's name has the extension of a scene.
pub fn is_scene(file: &Path) -> bool {
    file.extension().is_some_and(|e| e.eq_ignore_ascii_case("ron"))
}

/// File of `name`: an existing path, or a scene of the scenes folder with or without its extension.
pub fn find(name: &Path) -> PathBuf {
    if name.exists() {
        return name.to_path_buf();
    }
    let known = folder().map(|f| f.join(name));
    let candidates = known.into_iter().flat_map(|p| [p.clone(), p.with_extension("ron")]);
    candidates.into_iter().find(|p| p.is_file()).unwrap_or_else(|| name.to_path_buf())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scenes_folder_is_found_from_folders_below_it() {
        let root = std::env::temp_dir().join(format!("sheetwork-scenes-{}", std::process::id()));
        let deep = root.join("target").join("debug");
        let scenes = root.join("assets").join("scenes");
        std::fs::create_dir_all(&deep).expect("a folder");
        std::fs::create_dir_all(&scenes).expect("a folder");
        for name in ["two_walls.ron", "a.ron", "notes.txt"] {
            std::fs::write(scenes.join(name), "()").expect("a file");
        }
        assert_eq!(folder_from(&deep).as_deref(), Some(scenes.as_path()));
        let names: Vec<_> = list(&scenes).iter().filter_map(|f| Some(f.file_name()?.to_owned())).collect();
        assert_eq!(names, ["a.ron", "two_walls.ron"]);
        assert!(list(&root.join("nowhere")).is_empty());
        std::fs::remove_dir_all(&root).expect("removed");
    }

    #[test]
    fn an_unknown_name_is_left_as_it_is_and_a_known_one_found() {
        assert_eq!(find(Path::new("no/such/scene.ron")), PathBuf::from("no/such/scene.ron"));
        assert!(find(Path::new("wedge")).ends_with("assets/scenes/wedge.ron"));
    }
}
