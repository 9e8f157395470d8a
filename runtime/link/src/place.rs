//! Where a link is: its name, the folder of its files, who may attach.
//!
//! A link is a name. Its files lie in a folder of the user's own, `/tmp/sheetwork-link-UID`, mode 0700, or the one that the
//! variable `SHEETWORK_LINK_ROOT` names; its shared memory has mode 0600. So only processes of the same user (and root)
//! attach. A folder that is someone else's, a symbolic link, or open to others is refused.

use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::prelude::*;

use crate::LinkError;

/// An object that has no size yet after so long will never have one: it takes its maker microseconds.
const UNFINISHED: Duration = Duration::from_secs(1);
/// Variable that names another folder.
pub const ROOT_VARIABLE: &str = "SHEETWORK_LINK_ROOT";
/// Variable that names the link that is meant when none is given.
pub const NAME_VARIABLE: &str = "SHEETWORK_LINK";
/// Name of a link that nobody gave a name.
pub const DEFAULT_NAME: &str = "sheetwork";

/// A link's name and folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkPlace {
    name: String,
    root: PathBuf,
}

impl LinkPlace {
    /// The link of that name in the user's folder; an empty name is `SHEETWORK_LINK`'s, or "sheetwork".
    ///
    /// # Errors
    /// When the name is not 1 to 32 letters, digits, `-` or `_`.
    pub fn new(name: &str) -> Result<Self, LinkError> {
        let root = std::env::var_os(ROOT_VARIABLE).filter(|r| !r.is_empty());
        let root = root.map_or_else(|| PathBuf::from(format!("/tmp/sheetwork-link-{}", user())), PathBuf::from);
        Self::within(&root, name)
    }

    /// The link of that name in a folder of the caller's choice.
    ///
    /// # Errors
    /// When the name is not valid.
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

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The folder of its files.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Beginning of the names of its objects in /dev/shm: other folders have others, so that they do not meet.
    pub fn prefix(&self) -> String {
        let bytes = self.root.as_os_str().as_encoded_bytes();
        let hash = bytes.iter().fold(0x811c_9dc5_u32, |h, b| (h ^ u32::from(*b)).wrapping_mul(0x0100_0193));
        format!("sheetwork_{hash:08x}_")
    }

    /// Makes the folder if there is none, and checks whose it is.
    pub(crate) fn ready(&self) -> Result<(), LinkError> {
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

    /// Removes objects of shared memory that a process was killed over before they had a size: iceoryx2 waits without end for those to be
    /// finished when it removes what the dead have left. False where there is one that may yet be: then it must not be asked to.
    pub(crate) fn tidy(&self) -> bool {
        let prefix = self.prefix();
        let mut finished = true;
        for entry in std::fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            let ours = entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes());
            let Some(about) = ours.then(|| entry.metadata().ok()).flatten().filter(|m| m.len() == 0) else { continue };
            let old = about.modified().ok().and_then(|m| m.elapsed().ok()).is_some_and(|age| age > UNFINISHED);
            finished &= old && std::fs::remove_file(entry.path()).is_ok();
        }
        finished
    }

    /// iceoryx2's configuration: its own defaults, and not what a file of the machine says, because both ends must agree.
    pub(crate) fn config(&self) -> Result<Config, LinkError> {
        let bad = |what: &str| LinkError::Refused(format!("{}: {what}", self.root.display()));
        let mut config = Config::default();
        let path = iceoryx2::prelude::Path::new(self.root.as_os_str().as_encoded_bytes());
        config.global.set_root_path(&path.map_err(|_| bad("too long, or not a path"))?);
        config.global.prefix = FileName::new(self.prefix().as_bytes()).map_err(|_| bad("no prefix"))?;
        // A node that goes would wait without end for what a killed process has left unfinished; see `clean_up`, which tidies first.
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        Ok(config)
    }

    /// Name of one of the link's services.
    pub(crate) fn service(&self, what: &str) -> Result<ServiceName, LinkError> {
        let name = format!("sheetwork/{}/{what}", self.name);
        ServiceName::new(&name).map_err(|e| LinkError::Refused(format!("{name}: {e:?}")))
    }
}

/// The user who runs this process.
fn user() -> u32 {
    rustix::process::geteuid().as_raw()
}

/// Free bytes of shared memory; all there can be where that cannot be told.
pub(crate) fn free_shared_memory() -> u64 {
    rustix::fs::statvfs("/dev/shm").map_or(u64::MAX, |s| s.f_bavail.saturating_mul(s.f_frsize))
}
