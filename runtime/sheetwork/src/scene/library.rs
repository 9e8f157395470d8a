//! Shipped scenes: the folder `assets/scenes` and its files.

use std::path::{Path, PathBuf};

use crate::error::{InputError, did_you_mean, most_similar, similarity};

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
    folder().and_then(|f| find_in(&f, name)).unwrap_or_else(|| name.to_path_buf())
}

fn find_in(folder: &Path, name: &Path) -> Option<PathBuf> {
    let file = folder.join(name);
    [file.clone(), file.with_extension("ron")].into_iter().find(|p| p.is_file())
}

/// Error of a scene file that cannot be opened. If there is no such file, it names the most similar
/// scenes: of the file's folder, or of the scenes folder and the current one for a bare name.
pub(crate) fn unreadable(file: &Path, error: &std::io::Error) -> InputError {
    let unreadable = InputError::io(file, error);
    if error.kind() != std::io::ErrorKind::NotFound {
        return unreadable;
    }
    let known = match file.parent().filter(|p| !p.as_os_str().is_empty()) {
        Some(parent) => list(parent),
        None => folder().map(|f| stems(&f)).into_iter().flatten().chain(list(Path::new("."))).collect(),
    };
    let question = question(file, &known);
    InputError { problem: format!("{}{question}", unreadable.problem), ..unreadable }
}

/// Names of the scenes of `folder`, without folder and extension.
fn stems(folder: &Path) -> Vec<PathBuf> {
    list(folder).iter().filter_map(|f| f.file_stem()).map(PathBuf::from).collect()
}

/// Question for the scenes of `known` whose names are most similar to that of `file`; empty without
/// any.
fn question(file: &Path, known: &[PathBuf]) -> String {
    let stem = |file: &Path| file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let wanted = stem(file);
    let known: Vec<String> = known.iter().map(|f| f.display().to_string()).collect();
    let near = most_similar(known.iter().map(String::as_str), |other| similarity(&wanted, &stem(Path::new(other))));
    did_you_mean(&near).map_or_else(String::new, |question| format!("; {question}"))
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
    fn a_scene_is_found_by_its_name_and_a_misspelt_one_suggested() {
        let scenes = std::env::temp_dir().join(format!("sheetwork-names-{}", std::process::id()));
        std::fs::create_dir_all(&scenes).expect("a folder");
        for name in ["wedge.ron", "wedge_stiff.ron", "oven.ron"] {
            std::fs::write(scenes.join(name), "()").expect("a file");
        }
        for name in ["wedge", "wedge.ron"] {
            assert_eq!(find_in(&scenes, Path::new(name)), Some(scenes.join("wedge.ron")));
        }
        assert_eq!(find_in(&scenes, Path::new("wegde")), None);
        assert_eq!(question(Path::new("wegde"), &stems(&scenes)), "; did you mean wedge?");
        assert_eq!(question(Path::new("xyzzy"), &stems(&scenes)), "");
        let missing = std::io::Error::from(std::io::ErrorKind::NotFound);
        let problem = unreadable(&scenes.join("Ovne.ron"), &missing).problem;
        assert!(problem.contains(&format!("did you mean {}?", scenes.join("oven.ron").display())), "{problem}");
        std::fs::remove_dir_all(&scenes).expect("removed");
    }

    #[test]
    fn an_unknown_name_is_left_as_it_is() {
        assert_eq!(find(Path::new("no/such/scene.ron")), PathBuf::from("no/such/scene.ron"));
    }
}
