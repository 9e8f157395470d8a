//! Runs the program in a temporary folder.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// A folder with a copy of the assets, removed at the end.
pub struct TestFolder {
    folder: PathBuf,
}

impl TestFolder {
    /// A new folder; `name` is unique to the test.
    pub fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("sheetwork-cli-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets"), &folder.join("assets"));
        Self { folder }
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes a file and returns its name.
    pub fn write<'a>(&self, name: &'a str, text: &str) -> &'a str {
        std::fs::write(self.path(name), text).expect("writable");
        name
    }

    /// Runs the program in the folder.
    pub fn run(&self, arguments: &[&str]) -> ProgramOutput {
        let output = Command::new(env!("CARGO_BIN_EXE_sheetwork"))
            .args(arguments)
            .current_dir(&self.folder)
            .output()
            .expect("the program starts");
        let ran = ProgramOutput {
            status: output.status.code(),
            out: String::from_utf8(output.stdout).expect("UTF-8"),
            err: String::from_utf8(output.stderr).expect("UTF-8"),
        };
        assert!(!ran.err.contains("panicked"), "{arguments:?}: {}", ran.err);
        ran
    }

    /// Runs the program, requires success, and parses its whole output as JSON.
    pub fn json(&self, arguments: &[&str]) -> Value {
        let ran = self.run(arguments);
        assert_eq!(ran.status, Some(0), "{arguments:?}: {}", ran.err);
        assert_eq!(ran.err, "", "{arguments:?}");
        ran.json()
    }

    /// Runs the program and requires exit status 2 with a message that contains all `parts`.
    pub fn expect_rejection(&self, arguments: &[&str], parts: &[&str]) {
        let ran = self.run(arguments);
        assert_eq!(ran.status, Some(2), "{arguments:?}: {}{}", ran.out, ran.err);
        assert_eq!(ran.out, "", "{arguments:?}");
        for part in parts {
            assert!(ran.err.contains(part), "{arguments:?}: no \"{part}\" in: {}", ran.err);
        }
    }
}

impl Drop for TestFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Exit status and output of the program.
pub struct ProgramOutput {
    pub status: Option<i32>,
    pub out: String,
    pub err: String,
}

impl ProgramOutput {
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}: {}", self.out))
    }
}

/// Names of an object's fields, in order.
pub fn keys(value: &Value) -> Vec<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("writable");
    for entry in std::fs::read_dir(from).expect("assets") {
        let entry = entry.expect("an entry");
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).expect("copied");
        }
    }
}
