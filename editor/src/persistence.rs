//! Files that persist between runs: the list of recent files, and a backup of unsaved work for
//! recovery after a crash.
//!
//! Both are in the user's state folder (`$XDG_STATE_HOME/sheetwork`, or
//! `~/.local/state/sheetwork`). The name of a backup holds the process id of its writer; a backup
//! of an ended process is offered for recovery. Errors of writing are ignored, so that they cannot
//! stop the editor.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use sheetwork::scene::Scene;

use crate::document::files;
use crate::session::Session;

/// Interval between backups of unsaved work.
pub const BACKUP_INTERVAL: Duration = Duration::from_secs(5);
/// Maximum number of recent files.
pub const MAX_RECENT: usize = 12;

/// State folder and its contents.
#[derive(Clone, Debug)]
pub struct Persistence {
    folder: Option<PathBuf>,
    recent: Vec<PathBuf>,
    /// Generation and revision of the document in the backup.
    written: Option<(u64, u64)>,
    last: Instant,
}

/// State folder of the user; `None` without a home folder.
pub fn usual_folder() -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let state = set("XDG_STATE_HOME").or_else(|| Some(set("HOME")?.join(".local").join("state")))?;
    Some(state.join("sheetwork"))
}

impl Persistence {
    /// State in `folder`, or nothing persistent with `None`.
    pub fn new(folder: Option<PathBuf>) -> Self {
        let list = folder.as_ref().and_then(|f| std::fs::read_to_string(f.join("recent.txt")).ok());
        let recent = list.iter().flat_map(|text| text.lines()).map(PathBuf::from).take(MAX_RECENT).collect();
        Self { folder, recent, written: None, last: Instant::now() }
    }

    /// Files opened or saved, latest first.
    pub fn recent(&self) -> &[PathBuf] {
        &self.recent
    }

    /// Add `file` to the recent files.
    pub fn note(&mut self, file: &Path) {
        let file = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
        self.recent.retain(|f| *f != file);
        self.recent.insert(0, file);
        self.recent.truncate(MAX_RECENT);
        let list: String = self.recent.iter().map(|f| format!("{}\n", f.display())).collect();
        self.write("recent.txt", &list);
    }

    fn write(&self, name: &str, text: &str) -> bool {
        let Some(folder) = &self.folder else { return false };
        std::fs::create_dir_all(folder).is_ok() && std::fs::write(folder.join(name), text).is_ok()
    }

    fn own_copy(&self) -> Option<PathBuf> {
        Some(self.folder.as_ref()?.join(copy_name(std::process::id())))
    }

    /// Write a backup of unsaved work, at most every [`BACKUP_INTERVAL`]; remove it once the work
    /// is saved.
    pub fn back_up_periodically(&mut self, session: &Session) {
        if self.last.elapsed() >= BACKUP_INTERVAL {
            self.last = Instant::now();
            self.back_up(session);
        }
    }

    /// Write a backup of unsaved work at once, unless it exists.
    pub fn back_up(&mut self, session: &Session) {
        let now = (session.generation(), session.document().revision());
        if self.written == Some(now) || session.playback().is_some() {
            return;
        }
        self.written = Some(now);
        let Some(copy) = self.own_copy() else { return };
        if !session.document().is_unsaved() {
            let _ = std::fs::remove_file(copy);
            return;
        }
        // Relative to a distant folder, file names become absolute.
        let scene = files::moved(session.scene(), Path::new("/nowhere/near"));
        if let Ok(text) = scene.to_text() {
            self.write(&copy_name(std::process::id()), &text);
        }
    }

    /// Write unsaved work, before another scene replaces it, to a file of its own among the recent
    /// ones. Returns the file, if there was unsaved work.
    pub fn write_aside(&mut self, session: &Session) -> Option<PathBuf> {
        if !session.document().is_unsaved() || session.playback().is_some() {
            return None;
        }
        let folder = self.folder.clone()?;
        let stem: String =
            session.scene().name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).take(60).collect();
        let names = (1..1000).map(|n| format!("{stem}_set_aside_{n}.ron"));
        let name = names.into_iter().find(|name| !folder.join(name).exists())?;
        let text = files::moved(session.scene(), Path::new("/nowhere/near")).to_text().ok()?;
        if !self.write(&name, &text) {
            return None;
        }
        let file = folder.join(name);
        self.note(&file);
        Some(file)
    }

    /// Backup of an ended process: file and scene. An unreadable backup is kept.
    pub fn find_backup(&self) -> Option<(PathBuf, Scene)> {
        let entries = std::fs::read_dir(self.folder.as_ref()?).ok()?;
        let copies =
            entries.filter_map(|e| Some(e.ok()?.path())).filter(|p| writer_of(p).is_some_and(|pid| !runs(pid)));
        let mut copies: Vec<PathBuf> = copies.collect();
        copies.sort_by_key(|p| std::fs::metadata(p).and_then(|m| m.modified()).ok());
        copies.into_iter().rev().find_map(|p| Some((p.clone(), Scene::load(&p).ok()?)))
    }

    /// Delete a backup.
    pub fn forget(&self, copy: &Path) {
        let _ = std::fs::remove_file(copy);
    }
}

fn copy_name(pid: u32) -> String {
    format!("unsaved-{pid}.ron")
}

/// Process id in the name of a backup.
fn writer_of(file: &Path) -> Option<u32> {
    file.file_name()?.to_str()?.strip_prefix("unsaved-")?.strip_suffix(".ron")?.parse().ok()
}

/// Whether a process exists; false where the system does not tell.
fn runs(pid: u32) -> bool {
    pid == std::process::id() || Path::new("/proc").join(pid.to_string()).exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("sheetwork-keeping-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        folder
    }

    #[test]
    fn recent_files_are_listed_in_order_and_once() {
        let folder = folder("recent");
        let mut persistence = Persistence::new(Some(folder.clone()));
        for name in ["/a.ron", "/b.ron", "/a.ron"] {
            persistence.note(Path::new(name));
        }
        let again = Persistence::new(Some(folder.clone()));
        assert_eq!(again.recent(), [PathBuf::from("/a.ron"), PathBuf::from("/b.ron")]);
        for i in 0..30 {
            persistence.note(Path::new(&format!("/{i}.ron")));
        }
        assert_eq!(persistence.recent().len(), MAX_RECENT);
        std::fs::remove_dir_all(folder).expect("removed");
    }

    #[test]
    fn unsaved_work_that_makes_room_is_set_aside_among_recent_files() {
        let folder = folder("aside");
        let mut persistence = Persistence::new(Some(folder.clone()));
        let mut session = Session::new(&Scene::default()).expect("valid");
        assert!(persistence.write_aside(&session).is_none(), "nothing to lose");
        assert!(session.set("gravity", "(0, -2, 0)"));
        let (first, second) = (persistence.write_aside(&session).expect("written"), persistence.write_aside(&session));
        assert!(second.is_some_and(|file| file != first), "each a file of its own");
        assert!(persistence.recent().contains(&first));
        assert_eq!(Scene::load(&first).expect("a scene").gravity.y, -2.0);
        std::fs::remove_dir_all(folder).expect("removed");
    }

    #[test]
    fn unsaved_work_is_copied_and_found_by_the_next() {
        let folder = folder("copy");
        let mut persistence = Persistence::new(Some(folder.clone()));
        let mut session = Session::new(&Scene::default()).expect("valid");
        persistence.back_up(&session);
        assert!(persistence.own_copy().is_some_and(|c| !c.exists()), "nothing to lose");
        assert!(session.set("gravity", "(0, -2, 0)"));
        persistence.back_up(&session);
        let own = persistence.own_copy().expect("a folder");
        assert!(own.exists() && persistence.find_backup().is_none(), "its writer is there");
        // Backup of a process id that cannot exist.
        let other = folder.join(copy_name(u32::MAX));
        std::fs::rename(&own, &other).expect("moved");
        let (copy, scene) = persistence.find_backup().expect("found");
        assert_eq!((copy.as_path(), scene.gravity.y), (other.as_path(), -2.0));
        persistence.forget(&copy);
        assert!(persistence.find_backup().is_none());
        let file = folder.join("saved.ron");
        assert!(session.save_as(&file));
        persistence.back_up(&session);
        assert!(!own.exists(), "saved work needs no copy");
        std::fs::remove_dir_all(folder).expect("removed");
    }

    #[test]
    fn without_a_folder_nothing_is_written_and_nothing_fails() {
        let mut persistence = Persistence::new(None);
        persistence.note(Path::new("/a.ron"));
        persistence.back_up(&Session::new(&Scene::default()).expect("valid"));
        assert!(persistence.find_backup().is_none() && persistence.recent().len() == 1);
    }
}
