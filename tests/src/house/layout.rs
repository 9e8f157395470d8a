//! Folders of the repository and the files below them.

use super::Result;
use std::path::{Path, PathBuf};

/// Folders that no check enters, hidden ones aside.
const SKIPPED_FOLDERS: [&str; 3] = ["target", "sheetwork-out", "node_modules"];

/// Where the parts of the repository are.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Root of the repository.
    pub root: PathBuf,
    /// Source folder of the library, relative to the root.
    pub library: String,
    /// Source folder of the Bevy plugin, relative to the root.
    pub plugin: String,
    /// Source folder of the editor, relative to the root.
    pub editor: String,
    /// Rooms whose private numeric constants are counted.
    pub constant_rooms: Vec<String>,
}

impl Layout {
    /// Layout of the repository at `root`.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        let rooms = ["contact", "collision", "rigid", "islands", "integrators"];
        Self {
            root: root.into(),
            library: "runtime/sheetwork/src".into(),
            plugin: "plugin/bevy/src".into(),
            editor: "editor/src".into(),
            constant_rooms: rooms.map(String::from).to_vec(),
        }
    }

    /// Text of a file, by its path relative to the root.
    pub fn read(&self, file: &str) -> Result<String> {
        read(&self.root.join(file))
    }

    /// All Rust files of the repository, relative to the root, sorted.
    pub fn rust_files(&self) -> Result<Vec<String>> {
        files_below(&self.root, &self.root, "rs")
    }

    /// Names of the folders at the root, hidden ones and build output aside.
    pub fn top_folders(&self) -> Result<Vec<String>> {
        let entries = entries(&self.root)?;
        let folders = entries.into_iter().filter(|path| path.is_dir() && !is_skipped(path));
        Ok(folders.map(|path| file_name(&path)).collect())
    }
}

/// Files with an extension below a folder, as paths relative to `root`, sorted.
pub fn files_below(root: &Path, folder: &Path, extension: &str) -> Result<Vec<String>> {
    let mut found = Vec::new();
    collect(folder, extension, &mut found)?;
    let mut names: Vec<String> = found.iter().map(|path| relative(root, path)).collect();
    names.sort();
    Ok(names)
}

/// Path relative to `root`, with `/` between folders.
pub fn relative(root: &Path, path: &Path) -> String {
    let path = path.strip_prefix(root).unwrap_or(path);
    path.to_string_lossy().replace('\\', "/")
}

/// Text of a file; the error names the file.
pub fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn collect(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) -> Result<()> {
    for path in entries(folder)? {
        if path.is_dir() {
            if !is_skipped(&path) {
                collect(&path, extension, found)?;
            }
        } else if path.extension().is_some_and(|end| end == extension) {
            found.push(path);
        }
    }
    Ok(())
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let error = |error| format!("{}: {error}", folder.display());
    let entries = std::fs::read_dir(folder).map_err(error)?;
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.sort();
    Ok(paths)
}

fn is_skipped(folder: &Path) -> bool {
    let name = file_name(folder);
    name.starts_with('.') || SKIPPED_FOLDERS.contains(&name.as_str())
}

fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}
