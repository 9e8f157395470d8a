//! Choice of a file in a folder: contents and navigation, without a window.

use std::path::{Path, PathBuf};

/// Folder with its contents.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Browser {
    folder: PathBuf,
    /// File name, typed or clicked.
    pub name: String,
    endings: &'static [&'static str],
    folders: Vec<PathBuf>,
    files: Vec<PathBuf>,
}

impl Browser {
    /// Browser of `folder`, or of the current folder where `folder` does not exist, with files of
    /// these extensions (lower case; all files when empty).
    pub fn new(folder: &Path, endings: &'static [&'static str]) -> Self {
        let mut browser =
            Self { folder: PathBuf::new(), name: String::new(), endings, folders: Vec::new(), files: Vec::new() };
        if !browser.go(folder) {
            browser.go(Path::new("."));
        }
        browser
    }

    /// Change to another folder. Returns false, without a change, when it cannot be read.
    pub fn go(&mut self, folder: &Path) -> bool {
        let Ok(folder) = std::fs::canonicalize(folder) else { return false };
        let Ok(entries) = std::fs::read_dir(&folder) else { return false };
        let hidden = |p: &PathBuf| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'));
        let mut all: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).filter(|p| !hidden(p)).collect();
        all.sort();
        let ends = |p: &PathBuf| {
            let ending = p.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
            self.endings.is_empty() || self.endings.contains(&ending.as_str())
        };
        self.folders = all.iter().filter(|p| p.is_dir()).cloned().collect();
        self.files = all.into_iter().filter(|p| p.is_file() && ends(p)).collect();
        self.folder = folder;
        true
    }

    /// Change to the parent folder. Returns false at the root.
    pub fn up(&mut self) -> bool {
        self.folder.parent().map(Path::to_path_buf).is_some_and(|above| self.go(&above))
    }

    /// Present folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Folders in it, by name.
    pub fn folders(&self) -> &[PathBuf] {
        &self.folders
    }

    /// Files in it, by name.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// File of the present name; `None` without a name. The name of a folder changes to that
    /// folder.
    pub fn chosen(&mut self) -> Option<PathBuf> {
        let name = self.name.trim();
        if name.is_empty() {
            return None;
        }
        let path = self.folder.join(name);
        if path.is_dir() {
            self.go(&path);
            self.name.clear();
            return None;
        }
        Some(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_by_their_endings_and_folders_are_walked() {
        let root = std::env::temp_dir().join(format!("sheetwork-browser-{}", std::process::id()));
        std::fs::create_dir_all(root.join("deep")).expect("a folder");
        for name in ["b.ron", "A.RON", "c.txt", ".hidden.ron"] {
            std::fs::write(root.join(name), "()").expect("a file");
        }
        let mut browser = Browser::new(&root, &["ron"]);
        let names = |b: &Browser| -> Vec<String> {
            b.files().iter().map(|f| f.file_name().expect("a name").to_string_lossy().into_owned()).collect()
        };
        assert_eq!(names(&browser), ["A.RON", "b.ron"]);
        assert_eq!(browser.chosen(), None, "nothing named");
        browser.name = "deep".into();
        assert_eq!(browser.chosen(), None);
        assert!(browser.folder().ends_with("deep") && browser.files().is_empty());
        browser.name = "new.ron".into();
        assert_eq!(browser.chosen().as_deref(), Some(browser.folder().join("new.ron").as_path()));
        assert!(browser.up() && names(&browser).len() == 2);
        assert!(!browser.go(&root.join("nowhere")) && names(&browser).len() == 2);
        std::fs::remove_dir_all(&root).expect("removed");
    }
}
