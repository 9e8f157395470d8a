//! Counts of items in the library: private numeric constants, fields and methods of a type.

use super::resolve::Target;
use super::source_tree::{Module, SourceTree, is_public};
use syn::visit::{self, Visit};
use syn::{ImplItem, Item, ItemImpl, Type, Visibility};

/// Types of a numeric constant.
const NUMERIC: [&str; 8] = ["f64", "f32", "usize", "u8", "u32", "u64", "i32", "i64"];

/// A private numeric constant.
#[derive(Clone, Debug)]
pub struct Constant {
    /// File, relative to the repository root.
    pub file: String,
    /// Line number, from 1.
    pub line: usize,
    /// Name.
    pub name: String,
}

/// A struct of the crate with its inherent `impl` blocks.
#[derive(Clone, Debug, Default)]
pub struct StructSummary {
    /// Number of fields.
    pub fields: usize,
    /// Number of methods and associated functions in all inherent `impl` blocks.
    pub methods: usize,
    /// Inherent `impl` blocks outside the room that defines the struct, as `file:line`.
    pub outside: Vec<String>,
}

/// Numeric constants of the given rooms that are not `pub`, those in `impl` blocks and function
/// bodies included.
pub fn private_constants(tree: &SourceTree, rooms: &[String]) -> Vec<Constant> {
    let mut found = Vec::new();
    for module in &tree.modules {
        if module.path.first().is_some_and(|room| rooms.contains(room)) {
            let mut collector = ConstantCollector { module, found: &mut found };
            module.items.iter().for_each(|item| collector.visit_item(item));
        }
    }
    found
}

struct ConstantCollector<'a> {
    module: &'a Module,
    found: &'a mut Vec<Constant>,
}

impl ConstantCollector<'_> {
    fn add(&mut self, visibility: &Visibility, name: &syn::Ident, kind: &Type) {
        if !is_public(visibility) && is_numeric(kind) {
            let (file, line) = (self.module.file.clone(), name.span().start().line);
            self.found.push(Constant { file, line, name: name.to_string() });
        }
    }
}

impl<'ast> Visit<'ast> for ConstantCollector<'_> {
    fn visit_item_mod(&mut self, _: &'ast syn::ItemMod) {}

    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        self.add(&item.vis, &item.ident, &item.ty);
    }

    fn visit_impl_item_const(&mut self, item: &'ast syn::ImplItemConst) {
        self.add(&item.vis, &item.ident, &item.ty);
    }

    fn visit_item_impl(&mut self, item: &'ast ItemImpl) {
        if item.trait_.is_none() {
            visit::visit_item_impl(self, item);
        }
    }
}

fn is_numeric(kind: &Type) -> bool {
    let Type::Path(path) = kind else { return false };
    NUMERIC.iter().any(|name| path.path.is_ident(name))
}

/// Number of free functions and inherent methods that are `pub`, reachable or not.
pub fn public_functions(tree: &SourceTree) -> usize {
    let mut count = 0;
    for item in tree.modules.iter().flat_map(|module| &module.items) {
        count += match item {
            Item::Fn(item) => usize::from(is_public(&item.vis)),
            Item::Impl(block) => block.items.iter().filter(|item| is_public_method(item)).count(),
            _ => 0,
        };
    }
    count
}

fn is_public_method(item: &ImplItem) -> bool {
    matches!(item, ImplItem::Fn(item) if is_public(&item.vis))
}

/// Summary of the struct `name` that the room `room` defines; none if there is no such struct.
pub fn summarise_struct(tree: &SourceTree, room: &str, name: &str) -> Option<StructSummary> {
    let mut summary = StructSummary::default();
    let home = tree.modules.iter().position(|module| {
        let fields = module.items.iter().find_map(|item| struct_fields(item, name));
        summary.fields = fields.unwrap_or_default();
        module.path.first().is_some_and(|first| first == room) && fields.is_some()
    })?;
    let definition = Target::Item(home, name.to_string());
    for (index, module) in tree.modules.iter().enumerate() {
        for block in module.items.iter().filter_map(inherent_impl) {
            if implemented_type(tree, index, block) != Some(definition.clone()) {
                continue;
            }
            let is_method = |item: &&ImplItem| matches!(item, ImplItem::Fn(_));
            summary.methods += block.items.iter().filter(is_method).count();
            if module.path.first().is_none_or(|first| first != room) {
                let line = block.impl_token.span.start().line;
                summary.outside.push(format!("{}:{line}", module.file));
            }
        }
    }
    Some(summary)
}

fn struct_fields(item: &Item, name: &str) -> Option<usize> {
    match item {
        Item::Struct(item) if item.ident == name => Some(item.fields.len()),
        _ => None,
    }
}

/// The `impl` block of an item, when it implements no trait.
pub fn inherent_impl(item: &Item) -> Option<&ItemImpl> {
    match item {
        Item::Impl(item) if item.trait_.is_none() => Some(item),
        _ => None,
    }
}

/// Type of this crate that an `impl` block is for.
pub fn implemented_type(tree: &SourceTree, module: usize, block: &ItemImpl) -> Option<Target> {
    let Type::Path(path) = &*block.self_ty else { return None };
    let names: Vec<String> = path.path.segments.iter().map(|segment| segment.ident.to_string()).collect();
    tree.resolve(module, &names)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "
        mod contact { const A: f64 = 1.0; pub const B: f64 = 1.0; pub(crate) const C: usize = 1;
            const D: [f64; 2] = [0.0; 2]; fn f() { const E: u32 = 1; }
            use crate::sheet::Sheet; impl Sheet { fn c(&self) {} } }
        mod sheet { pub struct Sheet { a: f64, b: f64 } 
            impl Sheet { fn new() {} const F: f64 = 0.0; }
            impl Clone for Sheet { fn clone(&self) {} } }
        mod other { struct Sheet; impl Sheet { fn no() {} } }";

    #[test]
    fn private_numeric_constants_are_counted() {
        let tree = SourceTree::from_source(SOURCE).unwrap();
        let found = private_constants(&tree, &["contact".to_string()]);
        let names: Vec<&str> = found.iter().map(|constant| constant.name.as_str()).collect();
        assert_eq!(names, ["A", "C", "E"]);
    }

    #[test]
    fn fields_and_methods_of_a_struct_are_counted() {
        let tree = SourceTree::from_source(SOURCE).unwrap();
        let sheet = summarise_struct(&tree, "sheet", "Sheet").unwrap();
        assert_eq!((sheet.fields, sheet.methods, sheet.outside.len()), (2, 2, 1));
    }
}
