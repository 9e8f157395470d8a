//! Rooms of the library (its top-level modules), their order and the imports between them.

use super::Result;
use super::graph::Graph;
use super::layout::Layout;
use super::references::{Reference, Role, references};
use super::source_tree::SourceTree;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Rooms in order, with the content of each: a room imports only rooms above it.
pub const ROOMS: [(&str, &str); 19] = [
    ("error", "error types that several rooms return"),
    ("units", "units, their conversion to SI, and the table of parameters"),
    ("math", "structure-of-arrays vectors, frames, small dense kernels, complex numbers"),
    ("serialize", "binary encoding of state for snapshots"),
    ("parallel", "parallel iterators and thread pools, or sequential stand-ins"),
    ("profiler", "phases of a step, for an observer that has a clock"),
    ("mesh", "grids, outlines, triangulation, topology, interpolation between grids"),
    ("material", "material laws and the library; homogenisation and calibration of lattices"),
    ("scene", "specifications, builders, file formats in and out"),
    ("elements", "springs, membrane, bending; plasticity, creep, fracture"),
    ("linear", "sparsity pattern, ordering, Cholesky factorisation"),
    ("integrators", "explicit and implicit time integrators"),
    ("rigid", "rigid bodies, bridge to Rapier, colliders"),
    ("sheet", "model, parameters and state of a sheet"),
    ("collision", "collision surfaces, narrow phase, CCD, contact constraints"),
    ("contact", "contact problem, friction law, warm start, solvers"),
    ("thermal", "temperatures, conduction, radiative exchange, heat sources"),
    ("islands", "island building, contact state of islands, sleeping, step policy"),
    ("world", "world, ids, events, parameters, snapshots, journals, recordings"),
];

/// Top-level modules that only re-export: they import any room and no room imports them.
pub const FACADES: [&str; 1] = ["prelude"];

/// Opening marker of the table in `docs/architecture.md`.
pub const OPENING: &str = "<!-- rooms -->";
/// Closing marker of the table.
pub const CLOSING: &str = "<!-- /rooms -->";
/// File that shows the table.
pub const DOCUMENT: &str = "docs/architecture.md";

/// A place where a room names an item of another one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Import {
    /// File, relative to the repository root.
    pub file: String,
    /// Line number, from 1.
    pub line: usize,
    /// Path from the crate root.
    pub name: String,
}

/// Imports between rooms, by the importing and the imported room.
pub type Imports = BTreeMap<(String, String), BTreeSet<Import>>;

/// Collect the imports between the rooms of a crate. An item of the crate root that is defined in
/// `lib.rs`, and a glob import of the root, count as imports from `lib.rs`.
pub fn imports(tree: &SourceTree) -> Imports {
    let mut found = Imports::new();
    for (index, module) in tree.modules.iter().enumerate() {
        let Some(room) = room_of(tree, index) else { continue };
        for reference in references(&module.items) {
            let Some((target, name)) = imported_room(tree, index, &reference) else { continue };
            if target != room {
                let import = Import { file: module.file.clone(), line: reference.line, name };
                found.entry((room.clone(), target)).or_default().insert(import);
            }
        }
    }
    found
}

/// Room of a module; none for the root and modules written inline in it.
fn room_of(tree: &SourceTree, module: usize) -> Option<String> {
    let room = tree.modules[module].path.first()?;
    let top = tree.modules[0].children[room];
    (!tree.modules[top].inline).then(|| room.clone())
}

/// Room that a reference names, with the path from the crate root.
fn imported_room(tree: &SourceTree, module: usize, of: &Reference) -> Option<(String, String)> {
    let path = tree.absolute(module, &of.segments)?;
    let is_glob = matches!(of.role, Role::Glob { .. });
    let name = if is_glob { format!("{}::*", path.join("::")) } else { path.join("::") };
    let Some(first) = path.first() else {
        return is_glob.then(|| ("lib.rs".to_string(), name));
    };
    if let Some(&top) = tree.modules[0].children.get(first)
        && !tree.modules[top].inline
    {
        return Some((first.clone(), name));
    }
    let target = tree.resolve(0, &path)?;
    let room = room_of(tree, target.module()).unwrap_or_else(|| "lib.rs".to_string());
    Some((room, name))
}

/// Graph of the rooms.
pub fn graph(imports: &Imports) -> Graph {
    let mut graph = Graph::new();
    for (from, to) in imports.keys() {
        graph.entry(from.clone()).or_default().insert(to.clone());
    }
    graph
}

/// Violations of the order: top-level modules that are not in the table, rows of the table without
/// a module, and imports from a room further down.
pub fn violations(tree: &SourceTree, rooms: &[(&str, &str)]) -> Vec<String> {
    let mut found = Vec::new();
    let order = |name: &str| rooms.iter().position(|(room, _)| *room == name);
    let root = &tree.modules[0];
    for (name, &module) in &root.children {
        let known = order(name).is_some() || FACADES.contains(&name.as_str());
        if !tree.modules[module].inline && !known {
            found.push(format!("{}: `{name}` is not in the table", tree.modules[module].file));
        }
    }
    for (name, _) in rooms {
        if !root.children.contains_key(*name) {
            found.push(format!("the table has `{name}`, the library has no such room"));
        }
    }
    for ((from, to), places) in imports(tree) {
        let Some(importer) = order(&from) else { continue };
        if order(&to).is_some_and(|imported| imported < importer) {
            continue;
        }
        for Import { file, line, name } in places {
            found.push(format!("{file}:{line}: `{from}` imports `{to}` below it: {name}"));
        }
    }
    found
}

/// Table for the documentation: each room, what it holds and which rooms it imports.
pub fn table(tree: &SourceTree, rooms: &[(&str, &str)]) -> String {
    let imports = imports(tree);
    let mut text = String::from("| room | holds | imports |\n|---|---|---|\n");
    for (room, holds) in rooms {
        let imported: Vec<String> = (rooms.iter())
            .filter(|(other, _)| imports.contains_key(&(room.to_string(), other.to_string())))
            .map(|(other, _)| format!("`{other}`"))
            .collect();
        let imported = if imported.is_empty() { "-".to_string() } else { imported.join(", ") };
        writeln!(text, "| `{room}` | {holds} | {imported} |").unwrap();
    }
    text
}

/// Text of the document with the table renewed; none when the markers are missing.
pub fn renewed(document: &str, table: &str) -> Option<String> {
    let start = document.find(OPENING)? + OPENING.len();
    let end = start + document[start..].find(CLOSING)?;
    Some(format!("{}\n{table}{}", &document[..start], &document[end..]))
}

/// Check that the document shows the table.
pub fn check_document(layout: &Layout, table: &str) -> Result<Vec<String>> {
    let document = layout.read(DOCUMENT)?;
    Ok(match renewed(&document, table) {
        None => vec![format!("{DOCUMENT}: no table between {OPENING} and {CLOSING}")],
        Some(text) if text != document => {
            vec![format!("{DOCUMENT}: the table of rooms is old: run `house rooms --write`")]
        }
        Some(_) => Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: [(&str, &str); 2] = [("math", "vectors"), ("world", "everything")];

    /// A crate whose rooms are files: `inline` is reset.
    fn tree(source: &str) -> SourceTree {
        let mut tree = SourceTree::from_source(source).unwrap();
        for module in tree.modules.iter_mut().filter(|module| module.path.len() == 1) {
            module.inline = module.path[0] == "prelude";
        }
        tree
    }

    #[test]
    fn an_import_from_below_is_a_violation() {
        let tree = tree(
            "mod math { fn f(w: crate::World) {} } mod world { pub struct World; }
                         pub use world::World;",
        );
        let found = violations(&tree, &TABLE);
        assert_eq!(found, ["lib.rs:1: `math` imports `world` below it: World"]);
    }

    #[test]
    fn imports_from_above_and_inside_are_none() {
        let tree = tree(
            "mod math { pub struct V; } mod prelude { pub use crate::world::*; }
             mod world { use super::math::V; mod a { use super::b::X; } mod b { pub struct X; } }",
        );
        assert!(violations(&tree, &TABLE).is_empty());
        let expected = "| `math` | vectors | - |\n| `world` | everything | `math` |\n";
        assert!(table(&tree, &TABLE).ends_with(expected));
    }

    #[test]
    fn unknown_and_missing_rooms_are_violations() {
        let found = violations(&tree("mod math {} mod extra { use crate::*; }"), &TABLE);
        assert!(found[0].contains("`extra` is not in the table"));
        assert!(found[1].contains("no such room"));
    }

    #[test]
    fn the_table_is_renewed_between_its_markers() {
        let old = format!("a\n{OPENING}\nold\n{CLOSING}\nb\n");
        let new = renewed(&old, "| new |\n").unwrap();
        assert_eq!(new, format!("a\n{OPENING}\n| new |\n{CLOSING}\nb\n"));
        assert_eq!(renewed(&new, "| new |\n"), Some(new));
    }
}
