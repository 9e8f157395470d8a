//! Selection of a Python interpreter for tests that need packages: SHEETWORK_PYTHON, the system's,
//! or a virtual environment created in a folder.

use std::path::{Path, PathBuf};
use std::process::Command;

/// An interpreter that can run `import` (a line of Python). Otherwise a virtual environment in
/// `folder` with `packages` is created; none on failure.
pub fn python(import: &str, folder: &Path, packages: &[&str]) -> Option<PathBuf> {
    let has_all = |python: &Path| Command::new(python).args(["-c", import]).output().is_ok_and(|o| o.status.success());
    let named = std::env::var_os("SHEETWORK_PYTHON").map(PathBuf::from);
    if let Some(python) = named.into_iter().chain([PathBuf::from("python3")]).find(|p| has_all(p)) {
        return Some(python);
    }
    let python = folder.join("bin/python");
    if has_all(&python) {
        return Some(python);
    }
    let made = Command::new("python3").args(["-m", "venv"]).arg(folder).output().is_ok_and(|o| o.status.success());
    let install = ["-m", "pip", "install", "-q", "--retries", "0", "--timeout", "5"];
    let installed =
        made && Command::new(&python).args(install).args(packages).output().is_ok_and(|o| o.status.success());
    (installed && has_all(&python)).then_some(python)
}
