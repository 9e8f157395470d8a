//! Packages that a crate depends on.

use super::Result;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Normal dependencies of a package, itself included, as `name vVERSION`.
pub fn packages(root: &Path, package: &str, default_features: bool) -> Result<BTreeSet<String>> {
    let mut command = Command::new(std::env::var("CARGO").unwrap_or("cargo".into()));
    command.current_dir(root);
    command.args(["tree", "--locked", "-p", package, "-e", "normal", "--prefix", "none"]);
    if !default_features {
        command.arg("--no-default-features");
    }
    let output = command.output().map_err(|error| format!("cargo tree: {error}"))?;
    if !output.status.success() {
        return Err(format!("cargo tree: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    Ok(unique(&String::from_utf8_lossy(&output.stdout)))
}

fn unique(output: &str) -> BTreeSet<String> {
    let name = |line: &str| line.split_whitespace().take(2).collect::<Vec<_>>().join(" ");
    output.lines().map(name).filter(|name| !name.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn packages_count_once() {
        let output = "a v1.0.0 (/x)\nb v2.0.0\nb v2.0.0 (*)\nb v1.0.0 (proc-macro)\n";
        assert_eq!(super::unique(output).len(), 3);
    }
}
