//! Place of a link: its name, the folder of its files, and its permissions.
//!
//! A link has a name. Its files are in a folder of the user, `/tmp/sheetwork-link-UID` with mode
//! 0700, or the folder in the variable `SHEETWORK_LINK_ROOT`; its shared memory has mode 0600. Only
//! processes of the same user (and root) can attach. A folder of another user, a symbolic link, or
//! a folder open to others is rejected.

use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::prelude::*;

use crate::LinkError;

/// Age of an object without a size after which its creator must have terminated; creation takes
/// microseconds.
const UNFINISHED_OBJECT_AGE: Duration = Duration::from_secs(1);
/// Environment variable with another folder.
pub const ROOT_VARIABLE: &str = "SHEETWORK_LINK_ROOT";
/// Environment variable with the default name of the link.
pub const NAME_VARIABLE: &str = "SHEETWORK_LINK";
/// Default name of a link.
pub const DEFAULT_NAME: &str = "sheetwork";

/// Name and folder of a link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkPlace {
    name: String,
    root: PathBuf,
}

impl LinkPlace {
    /// The link of that name in the user's folder. An empty name stands for `SHEETWORK_LINK`, or
    /// "sheetwork".
    ///
    /// # Errors
    /// A name other than 1 to 32 letters, digits, `-` or `_`.
    pub fn new(name: &str) -> Result<Self, LinkError> {
        let root = std::env::var_os(ROOT_VARIABLE).filter(|r| !r.is_empty());
        let root = root.map_or_else(|| PathBuf::from(format!("/tmp/sheetwork-link-{}", user())), PathBuf::from);
        Self::within(&root, name)
    }

    /// The link of that name in a given folder.
    ///
    /// # Errors
    /// An invalid name.
    pub fn within(root: &Path, name: &str) -> Result<Self, LinkError> {
        let fallback = || std::env::var(NAME_VARIABLE).ok().filter(|n| !n.is_empty());
        let name = match name {
            "" => fallback().unwrap_or_else(|| DEFAULT_NAME.into()),
            name => name.to_owned(),
        };
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if name.len() > 32 || !name.chars().all(plain) {
            return Err(LinkError::Refused(format!("link \"{name}\": a name is 1 to 32 letters, digits, - or _")));
        }
        Ok(Self { name, root: root.to_path_buf() })
    }

    /// Name of the link.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Folder of its files.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Prefix of the names of its objects in /dev/shm, different for each folder.
    pub fn prefix(&self) -> String {
        let bytes = self.root.as_os_str().as_encoded_bytes();
        let hash = bytes.iter().fold(0x811c_9dc5_u32, |h, b| (h ^ u32::from(*b)).wrapping_mul(0x0100_0193));
        format!("sheetwork_{hash:08x}_")
    }

    /// Creates the folder if it is missing and checks its owner and mode.
    pub(crate) fn prepare_folder(&self) -> Result<(), LinkError> {
        let refused = |why: String| Err(LinkError::Refused(format!("{}: {why}", self.root.display())));
        let made = std::fs::DirBuilder::new().recursive(true).mode(0o700).create(&self.root);
        if let Err(error) = made {
            return refused(format!("cannot be made: {error}"));
        }
        match std::fs::symlink_metadata(&self.root) {
            Err(error) => refused(format!("cannot be looked at: {error}")),
            Ok(m) if !m.is_dir() => refused("is no folder".into()),
            Ok(m) if m.uid() != user() => refused(format!("belongs to user {}, who is not this one", m.uid())),
            Ok(m) if m.permissions().mode() & 0o077 != 0 => {
                refused("is open to other users; its mode must be 0700".into())
            }
            Ok(_) => Ok(()),
        }
    }

    /// Removes shared-memory objects of processes that were killed before they set a size. The
    /// clean-up of iceoryx2 would wait for these objects without a time limit. Returns false while
    /// such an object may still be finished; the clean-up must not run then.
    pub(crate) fn remove_unfinished(&self) -> bool {
        let prefix = self.prefix();
        let mut finished = true;
        for entry in std::fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            let ours = entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes());
            let Some(about) = ours.then(|| entry.metadata().ok()).flatten().filter(|m| m.len() == 0) else { continue };
            let old =
                about.modified().ok().and_then(|m| m.elapsed().ok()).is_some_and(|age| age > UNFINISHED_OBJECT_AGE);
            finished &= old && std::fs::remove_file(entry.path()).is_ok();
        }
        finished
    }

    /// Configuration of iceoryx2: its built-in defaults, independent of configuration files,
    /// because both ends must agree.
    pub(crate) fn config(&self) -> Result<Config, LinkError> {
        let bad = |what: &str| LinkError::Refused(format!("{}: {what}", self.root.display()));
        let mut config = Config::default();
        let path = iceoryx2::prelude::Path::new(self.root.as_os_str().as_encoded_bytes());
        config.global.set_root_path(&path.map_err(|_| bad("too long, or not a path"))?);
        config.global.prefix = FileName::new(self.prefix().as_bytes()).map_err(|_| bad("no prefix"))?;
        // The destruction of a node would wait without a time limit for unfinished objects of
        // killed processes; see `clean_up`, which removes these first.
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        Ok(config)
    }

    /// Name of one of the link's services.
    pub(crate) fn service(&self, what: &str) -> Result<ServiceName, LinkError> {
        let name = format!("sheetwork/{}/{what}", self.name);
        ServiceName::new(&name).map_err(|e| LinkError::Refused(format!("{name}: {e:?}")))
    }
}

/// Effective user of this process.
fn user() -> u32 {
    rustix::process::geteuid().as_raw()
}

/// Free shared memory, bytes; the maximum on systems that do not report it.
pub(crate) fn free_shared_memory() -> u64 {
    rustix::fs::statvfs("/dev/shm").map_or(u64::MAX, |s| s.f_bavail.saturating_mul(s.f_frsize))
}
