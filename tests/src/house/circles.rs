//! Imports between the files of a crate, and the circles among them.

use super::graph::{Graph, circles};
use super::references::{Reference, Role, Scope, references};
use super::resolve::Target;
use super::source_tree::SourceTree;
use std::collections::{BTreeMap, BTreeSet};

/// Imports between files, by the importing and the imported file, as `line: path`.
pub type FileImports = BTreeMap<(String, String), BTreeSet<(usize, String)>>;

/// Collect the imports between the files of a crate. An import leads to the file that defines the
/// named item, re-exports followed. A `mod` declaration and the re-export of an item of a child
/// module are no imports. A module that is imported counts where a path goes through it.
pub fn file_imports(tree: &SourceTree) -> FileImports {
    let mut found = FileImports::new();
    for (index, module) in tree.modules.iter().enumerate() {
        for reference in references(&module.items) {
            let Some(target) = tree.resolve(index, &reference.segments) else { continue };
            let file = &tree.modules[target.module()].file;
            if *file == module.file || !is_import(tree, index, &reference, &target) {
                continue;
            }
            let place = (reference.line, reference.segments.join("::"));
            found.entry((module.file.clone(), file.clone())).or_default().insert(place);
        }
    }
    found
}

fn is_import(tree: &SourceTree, module: usize, reference: &Reference, target: &Target) -> bool {
    let scope = match &reference.role {
        Role::Inline => return true,
        Role::Import { scope: Scope::Private, .. } if matches!(target, Target::Module(_)) => {
            return false;
        }
        Role::Import { scope, .. } | Role::Glob { scope } => *scope,
    };
    let (here, there) = (&tree.modules[module].path, &tree.modules[target.module()].path);
    scope == Scope::Private || !there.starts_with(here)
}

/// Whether the imports of a module from its own child modules count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OwnChildren {
    /// They do: a child that imports from its parent, which uses the child, is a circle.
    Count,
    /// They do not: a module consists of its children.
    Ignore,
}

/// Circles among the files of a crate.
pub fn file_circles(tree: &SourceTree, children: OwnChildren) -> Vec<Vec<String>> {
    let paths: BTreeMap<&String, &Vec<String>> =
        (tree.modules.iter()).filter(|module| !module.inline).map(|module| (&module.file, &module.path)).collect();
    let mut graph = Graph::new();
    for (from, to) in file_imports(tree).into_keys() {
        let is_child = paths[&to].starts_with(paths[&from]);
        if children == OwnChildren::Count || !is_child {
            graph.entry(from).or_default().insert(to);
        }
    }
    circles(&graph)
}

/// The imports that close a circle, as lines of text.
pub fn describe(tree: &SourceTree, circle: &[String]) -> Vec<String> {
    let mut lines = Vec::new();
    for ((from, to), places) in file_imports(tree) {
        if circle.contains(&from) && circle.contains(&to) {
            lines.extend(places.iter().map(|(line, path)| format!("{from}:{line}: {path} ({to})")));
        }
    }
    lines
}

/// Imports of the top-level modules `excluded` by the files of the top-level module `importer`.
pub fn excluded_imports(tree: &SourceTree, importer: &str, excluded: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    let is_excluded = |path: &[String]| path.first().is_some_and(|first| excluded.contains(&first.as_str()));
    for (index, module) in tree.modules.iter().enumerate() {
        if module.path.first().is_none_or(|first| first != importer) {
            continue;
        }
        for reference in references(&module.items) {
            let written = tree.absolute(index, &reference.segments).unwrap_or_default();
            let target = tree.resolve(index, &reference.segments);
            let defined = target.map(|target| &tree.modules[target.module()].path[..]);
            if is_excluded(&written) || is_excluded(defined.unwrap_or_default()) {
                let path = reference.segments.join("::");
                found.push(format!("{}:{}: {path}", module.file, reference.line));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A crate in which each module is a file named by its path.
    fn tree(source: &str) -> SourceTree {
        let mut tree = SourceTree::from_source(source).unwrap();
        for module in &mut tree.modules {
            module.file = module.path.join("/");
            module.inline = false;
        }
        tree
    }

    #[test]
    fn a_reexport_of_a_child_is_no_import() {
        let source = "mod a { mod x { use super::N; pub struct X; } pub use x::X; pub struct N; }";
        assert!(file_circles(&tree(source), OwnChildren::Count).is_empty());
        let source = "mod a { mod x { use super::N; pub struct X; } use x::X; pub struct N; }";
        assert_eq!(file_circles(&tree(source), OwnChildren::Count), vec![vec!["a", "a/x"]]);
        assert!(file_circles(&tree(source), OwnChildren::Ignore).is_empty());
    }

    #[test]
    fn imports_through_a_parent_lead_to_the_defining_file() {
        let source = "mod a { mod x { pub struct X; } mod y { use super::X; } pub use x::X; }";
        let imports = file_imports(&tree(source));
        let pairs: Vec<_> = imports.into_keys().collect();
        assert_eq!(pairs, vec![("a/y".to_string(), "a/x".to_string())]);
    }

    #[test]
    fn a_module_counts_where_a_path_goes_through_it() {
        let source = "mod a { use crate::b; fn f() { b::c::g() } } mod b { pub mod c { } }";
        let pairs: Vec<_> = file_imports(&tree(source)).into_keys().collect();
        assert_eq!(pairs, vec![("a".to_string(), "b/c".to_string())]);
    }

    #[test]
    fn excluded_imports_are_found_by_path_and_by_definition() {
        let source = "mod core { use crate::asset; fn f(x: crate::Mesh) {} use crate::util::U; }
            mod asset {} mod render { pub struct Mesh; } mod util { pub struct U; }
            pub use render::Mesh;";
        let found = excluded_imports(&tree(source), "core", &["asset", "render"]);
        assert_eq!(found, ["core:1: crate::asset", "core:1: crate::Mesh"]);
    }
}
