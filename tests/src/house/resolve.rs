//! Resolution of paths to the modules that define the named items.

use super::source_tree::SourceTree;

/// Maximum number of re-exports that are followed for one path.
const MAX_DEPTH: usize = 16;

/// Module or item that a path names.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// A module of the crate, by index.
    Module(usize),
    /// An item by the index of the module that defines it and its name.
    Item(usize, String),
}

impl Target {
    /// Index of the module that is named or that defines the item.
    pub fn module(&self) -> usize {
        match self {
            Target::Module(module) | Target::Item(module, _) => *module,
        }
    }
}

impl SourceTree {
    /// Resolve a path as it is written in a module; none for other crates and local names.
    pub fn resolve(&self, module: usize, segments: &[String]) -> Option<Target> {
        self.resolve_within(module, segments, MAX_DEPTH)
    }

    /// Path from the crate root as written, re-exports not followed; none without a leading
    /// `crate`, `self` or `super`, unless the first name is a child module.
    pub fn absolute(&self, module: usize, segments: &[String]) -> Option<Vec<String>> {
        let (base, rest) = self.leading(module, segments)?;
        Some([&self.modules[base].path, rest].concat())
    }

    /// Module from which a path starts, and the names that remain.
    fn leading<'a>(&self, module: usize, segments: &'a [String]) -> Option<(usize, &'a [String])> {
        let first = segments.first()?;
        let mut path = self.modules[module].path.clone();
        let mut rest = segments;
        match first.as_str() {
            "crate" => (path, rest) = (Vec::new(), &segments[1..]),
            "self" => rest = &segments[1..],
            "super" => {}
            name if self.modules[module].children.contains_key(name) => {}
            _ => return None,
        }
        while rest.first().is_some_and(|name| name == "super") {
            path.pop();
            rest = &rest[1..];
        }
        Some((self.find(&path)?, rest))
    }

    fn resolve_within(&self, module: usize, segments: &[String], depth: usize) -> Option<Target> {
        let depth = depth.checked_sub(1)?;
        let leading = self.leading(module, segments);
        let (mut current, rest) = leading.unwrap_or((module, segments));
        for (at, name) in rest.iter().enumerate() {
            match self.lookup(current, name, depth) {
                Lookup::Found(Target::Module(next)) => current = next,
                Lookup::Found(item) => return Some(item),
                Lookup::Foreign => return None,
                // Made by a macro, when the path is one of this crate.
                Lookup::Unknown if leading.is_some() || at > 0 => {
                    return Some(Target::Item(current, name.clone()));
                }
                Lookup::Unknown => return None,
            }
        }
        Some(Target::Module(current))
    }

    fn lookup(&self, module: usize, name: &str, depth: usize) -> Lookup {
        let Some(depth) = depth.checked_sub(1) else { return Lookup::Unknown };
        let here = &self.modules[module];
        if let Some(&child) = here.children.get(name) {
            return Lookup::Found(Target::Module(child));
        }
        if here.names.contains(name) {
            return Lookup::Found(Target::Item(module, name.to_string()));
        }
        let mut foreign = false;
        for (_, reference) in here.bindings().filter(|(bound, _)| *bound == name) {
            // `pub(crate) use name;` gives a macro of this module a path.
            if reference.segments.len() == 1 {
                continue;
            }
            match self.resolve_within(module, &reference.segments, depth) {
                Some(target) => return Lookup::Found(target),
                None => foreign = true,
            }
        }
        if foreign {
            return Lookup::Foreign;
        }
        for glob in here.globs() {
            let Some(Target::Module(source)) = self.resolve_within(module, &glob.segments, depth.min(4)) else {
                continue;
            };
            if source != module
                && let Lookup::Found(target) = self.lookup(source, name, depth.min(4))
            {
                return Lookup::Found(target);
            }
        }
        match self.exported_macros.get(name) {
            Some(&home) if module == 0 => Lookup::Found(Target::Item(home, name.to_string())),
            _ => Lookup::Unknown,
        }
    }
}

enum Lookup {
    Found(Target),
    /// An import from another crate.
    Foreign,
    Unknown,
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "
        mod a { pub struct X; 
            pub mod deep { pub struct Y; #[macro_export] macro_rules! m { () => {} } }
                pub use deep::Y; pub use serde::Serialize; }
        mod b { use super::a; pub use crate::a::deep::*; mod c {} }
        pub use a::X as Renamed; pub use a::*;
    ";

    fn defined(module: &str, path: &str) -> Option<String> {
        let tree = SourceTree::from_source(SOURCE).unwrap();
        let split = |path: &str| path.split("::").map(String::from).collect::<Vec<_>>();
        let from = if module.is_empty() { Some(0) } else { tree.find(&split(module)) };
        let target = tree.resolve(from.unwrap(), &split(path))?;
        let path = tree.modules[target.module()].path.join("::");
        Some(match target {
            Target::Module(_) => path,
            Target::Item(_, name) => format!("{path}::{name}"),
        })
    }

    #[test]
    fn reexports_lead_to_the_definition() {
        assert_eq!(defined("b", "crate::Renamed").as_deref(), Some("a::X"));
        assert_eq!(defined("b", "crate::a::Y").as_deref(), Some("a::deep::Y"));
        assert_eq!(defined("b", "a::Y::new").as_deref(), Some("a::deep::Y"));
        assert_eq!(defined("b::c", "super::Y").as_deref(), Some("a::deep::Y"));
        assert_eq!(defined("b::c", "super::super::a::deep").as_deref(), Some("a::deep"));
        assert_eq!(defined("b", "crate::m").as_deref(), Some("a::deep::m"));
    }

    #[test]
    fn other_crates_and_local_names_lead_nowhere() {
        assert_eq!(defined("b", "glam::Vec3"), None);
        assert_eq!(defined("b", "crate::a::Serialize"), None);
    }
}
