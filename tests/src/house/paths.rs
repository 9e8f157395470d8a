//! Paths and links of the documentation that must lead somewhere.

use super::Result;
use super::layout::{Layout, files_below};
use super::markdown::{anchors, code_spans, links};
use std::path::{Component, Path, PathBuf};

/// Folder of dated notes, whose paths may be of the past.
const NOTES: &str = "docs/notes/";

/// Paths in code spans and relative links of the documentation that lead nowhere, as
/// `file:line: path`.
pub fn broken(layout: &Layout) -> Result<Vec<String>> {
    let mut found = Vec::new();
    let folders = layout.top_folders()?;
    for file in documents(layout)? {
        let source = layout.read(&file)?;
        let mut lines = Vec::new();
        for span in code_spans(&source) {
            for path in repository_paths(&span.text, &folders) {
                if !path_exists(layout, &file, &path) {
                    lines.push((span.line, path));
                }
            }
        }
        for link in links(&source) {
            if !link_resolves(layout, &file, &link.text)? {
                lines.push((link.line, link.text));
            }
        }
        lines.sort();
        found.extend(lines.into_iter().map(|(line, path)| format!("{file}:{line}: {path}")));
    }
    Ok(found)
}

/// Documents that are checked: Markdown at the root, in `docs` and `assets`, and the README files
/// of the crates.
pub fn documents(layout: &Layout) -> Result<Vec<String>> {
    let mut files = files_below(&layout.root, &layout.root, "md")?;
    files.retain(|file| {
        let parts: Vec<&str> = file.split('/').collect();
        match parts.as_slice() {
            ["README.md" | "CONTRIBUTING.md" | "SECURITY.md"] | ["assets", "README.md"] => true,
            ["docs", ..] => !file.starts_with(NOTES),
            ["plugin" | "runtime", .., "README.md"] => parts.len() <= 3,
            ["editor" | "tests", "README.md"] => true,
            _ => false,
        }
    });
    Ok(files)
}

/// Words of a code span that name a path from the root of the repository.
fn repository_paths(span: &str, folders: &[String]) -> Vec<String> {
    let mut found = Vec::new();
    for word in span.split_whitespace() {
        let word = word.trim_end_matches(|c: char| ".,;:!?)]}'\"".contains(c));
        let Some((first, rest)) = word.split_once('/') else { continue };
        let is_plain = |c: char| c.is_alphanumeric() || "/._-+".contains(c);
        let path = word.split(':').next().unwrap_or(word);
        if folders.iter().any(|folder| folder == first)
            && path.chars().all(is_plain)
            && !rest.contains("..")
            && !path.split('/').any(is_placeholder)
        {
            found.push(path.to_string());
        }
    }
    found
}

/// True for a part of a path that stands for any name, as `NAME` and `N.ron` do.
fn is_placeholder(part: &str) -> bool {
    let stem = part.split('.').next().unwrap_or(part);
    let known = ["README", "CHANGELOG", "CONTRIBUTING", "SECURITY", "LICENSE"];
    let capital = |c: char| c.is_ascii_uppercase() || c == '_';
    !stem.is_empty()
        && stem.chars().any(|c| c.is_ascii_uppercase())
        && stem.chars().all(capital)
        && !known.contains(&stem)
}

/// True if a path exists from the root or from the folder of the document.
fn path_exists(layout: &Layout, document: &str, path: &str) -> bool {
    let folder = Path::new(document).parent().unwrap_or(Path::new(""));
    layout.root.join(path).exists() || layout.root.join(folder).join(path).exists()
}

/// True if a link leads to a file and, with `#`, to one of its headings; also for other sites.
fn link_resolves(layout: &Layout, document: &str, link: &str) -> Result<bool> {
    if link.is_empty() || link.contains("://") || link.starts_with("mailto:") {
        return Ok(true);
    }
    let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
    let folder = Path::new(document).parent().unwrap_or(Path::new(""));
    let file = if path.is_empty() { PathBuf::from(document) } else { folder.join(path) };
    let file = layout.root.join(normal(&file));
    if !file.exists() {
        return Ok(false);
    }
    if anchor.is_empty() || file.extension().is_none_or(|extension| extension != "md") {
        return Ok(true);
    }
    let source = super::layout::read(&file)?;
    let mut known = anchors(&source);
    for included in included_files(&source, file.parent().unwrap_or(Path::new(""))) {
        known.extend(anchors(&super::layout::read(&included)?));
    }
    Ok(known.contains(anchor))
}

/// Files that `{{#include FILE}}` and `{{#include FILE:ANCHOR}}` insert into a chapter of the book.
fn included_files(source: &str, folder: &Path) -> Vec<PathBuf> {
    let inside = source.split("{{#include ").skip(1).filter_map(|rest| rest.split("}}").next());
    inside.map(|file| folder.join(file.split(':').next().unwrap_or(file).trim())).collect()
}

/// Path with `.` and `..` worked out.
fn normal(path: &Path) -> PathBuf {
    let mut parts = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(parts.pop()),
            Component::CurDir => {}
            other => parts.push(other),
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_are_paths_are_told_from_others() {
        let folders = ["docs".to_string(), "runtime".to_string()];
        let paths = |span: &str| repository_paths(span, &folders);
        assert_eq!(paths("docs/x.md"), ["docs/x.md"]);
        assert_eq!(paths("cat runtime/a/b.rs:12 docs/README.md."), ["runtime/a/b.rs", "docs/README.md"]);
        assert!(paths("docs/*.md docs/NAME.md docs/<x>/y other/z docs runtime/{a,b}").is_empty());
    }

    #[test]
    fn broken_paths_links_and_anchors_are_reported() {
        let root = std::env::temp_dir().join(format!("house-paths-{}", std::process::id()));
        std::fs::create_dir_all(root.join("docs/notes")).unwrap();
        let write = |file: &str, text: &str| std::fs::write(root.join(file), text).unwrap();
        write("README.md", "`docs/a.md` `docs/b.md`\n[x](docs/a.md#top) [y](docs/a.md#no) [z](c.md)\n");
        write("docs/a.md", "# Top\n[up](../README.md) [here](#top) [web](https://x.y/z)\n");
        write("docs/notes/old.md", "`docs/gone.md`\n");
        let found = broken(&Layout::new(&root)).unwrap();
        std::fs::remove_dir_all(&root).unwrap();
        let expected = ["README.md:1: docs/b.md", "README.md:2: c.md", "README.md:2: docs/a.md#no"];
        assert_eq!(found, expected);
    }
}
