//! Snapshot of the public interface of the library: one line for each reachable public item.

use super::inventory::{implemented_type, inherent_impl};
use super::references::{Role, use_references};
use super::resolve::Target;
use super::signature::text;
use super::source_tree::{SourceTree, is_hidden, is_public, item_attributes, item_name};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use syn::{Attribute, Fields, ImplItem, Item, TraitItem, Type};

/// Public interface: its lines, and the number of functions among them.
#[derive(Clone, Debug, Default)]
pub struct Interface {
    /// Lines, sorted.
    pub lines: BTreeSet<String>,
    /// Number of `pub fn`: free functions, methods and associated functions, not those of traits.
    pub functions: usize,
}

/// Macros of the library that make public items.
const DECLARING_MACROS: [&str; 3] = ["parameters", "named_in_table", "string_conversions"];

/// Read the public interface of a crate. Items under `#[doc(hidden)]` are left out. For items
/// that a macro makes, the entries of its invocation are listed. An item that several paths reach
/// is listed under the first of them.
pub fn interface(tree: &SourceTree, crate_name: &str) -> Interface {
    let mut walk = Walk { tree, homes: BTreeMap::new(), interface: Interface::default() };
    walk.find_public_modules(0, crate_name.to_string());
    let modules: Vec<(Target, String)> = walk.homes.clone().into_iter().collect();
    for (module, path) in &modules {
        walk.add_items(module.module(), path);
    }
    // The first of several re-exports of a private item becomes its path.
    for (module, path) in &modules {
        walk.add_reexports(module.module(), path, &mut BTreeSet::new());
    }
    walk.add_impl_blocks();
    walk.add_invocations(crate_name);
    walk.interface
}

/// Lines of the new interface that the old one lacks, with `+`, and the reverse, with `-`.
pub fn difference(old: &str, new: &str) -> Vec<String> {
    let old: BTreeSet<&str> = old.lines().collect();
    let new: BTreeSet<&str> = new.lines().collect();
    let mut lines: Vec<(&str, &str)> = old.difference(&new).map(|line| (*line, "-")).collect();
    lines.extend(new.difference(&old).map(|line| (*line, "+")));
    lines.sort_by_key(|(line, sign)| (sort_key(line), *sign));
    lines.into_iter().map(|(line, sign)| format!("{sign} {line}")).collect()
}

/// Path of a line without the kind of the item, so that changes of one item stand together.
fn sort_key(line: &str) -> String {
    line.split_once(' ').map_or(line, |(_, rest)| rest).to_string()
}

/// Text of a snapshot file.
pub fn snapshot(interface: &Interface) -> String {
    interface.lines.iter().map(|line| format!("{line}\n")).collect()
}

/// Entries of an invocation: its tokens between commas, without attributes and comments.
fn entries(tokens: TokenStream) -> Vec<TokenStream> {
    let mut entries = vec![Vec::new()];
    let mut trees = tokens.into_iter().peekable();
    while let Some(tree) = trees.next() {
        match &tree {
            TokenTree::Punct(mark) if mark.as_char() == ',' => entries.push(Vec::new()),
            TokenTree::Punct(mark)
                if mark.as_char() == '#'
                    && trees
                        .next_if(|next| matches!(next, TokenTree::Group(g) if g.delimiter() == Delimiter::Bracket))
                        .is_some() => {}
            _ => entries.last_mut().into_iter().for_each(|entry| entry.push(tree.clone())),
        }
    }
    entries.retain(|entry| !entry.is_empty());
    entries.into_iter().map(TokenStream::from_iter).collect()
}

struct Walk<'a> {
    tree: &'a SourceTree,
    /// Public paths of modules and items.
    homes: BTreeMap<Target, String>,
    interface: Interface,
}

impl Walk<'_> {
    fn find_public_modules(&mut self, module: usize, path: String) {
        self.homes.insert(Target::Module(module), path.clone());
        for (name, &child) in &self.tree.modules[module].children {
            let here = &self.tree.modules[child];
            if here.public && !here.hidden {
                self.find_public_modules(child, format!("{path}::{name}"));
            }
        }
    }

    fn line(&mut self, line: String) {
        self.interface.lines.insert(line);
    }

    fn add_items(&mut self, module: usize, path: &str) {
        self.line(format!("mod {path}"));
        let tree = self.tree;
        for item in &tree.modules[module].items {
            if let Some(name) = item_name(item)
                && is_public_item(item)
            {
                self.homes.insert(Target::Item(module, name.clone()), format!("{path}::{name}"));
                self.add_item(item, &format!("{path}::{name}"));
            }
        }
    }

    /// Add the public re-exports of a module. `visited` holds the private modules whose content
    /// `pub use module::*` shows at this path.
    fn add_reexports(&mut self, module: usize, path: &str, visited: &mut BTreeSet<usize>) {
        let tree = self.tree;
        for item in &tree.modules[module].items {
            let Item::Use(item) = item else { continue };
            if !is_public(&item.vis) || is_hidden(&item.attrs) {
                continue;
            }
            let uses = use_references(&[Item::Use(item.clone())]);
            for reference in uses {
                let target = tree.resolve(module, &reference.segments);
                match (&reference.role, target) {
                    (Role::Import { name, .. }, Some(target)) => {
                        self.add_reexport(target, &format!("{path}::{name}"));
                    }
                    (Role::Glob { .. }, Some(Target::Module(source)))
                        if !self.homes.contains_key(&Target::Module(source)) =>
                    {
                        if visited.insert(source) {
                            self.add_glob(source, path);
                            self.add_reexports(source, path, visited);
                        }
                    }
                    (Role::Import { name, .. }, None) => {
                        let source = reference.segments.join("::");
                        self.line(format!("use {path}::{name} = {source}"));
                    }
                    (_, target) => {
                        let source = target.and_then(|target| self.homes.get(&target).cloned());
                        let source = source.unwrap_or_else(|| reference.segments.join("::"));
                        self.line(format!("use {path}::* = {source}::*"));
                    }
                }
            }
        }
    }

    /// Add the entries of macros that declare items, without their comments.
    fn add_invocations(&mut self, crate_name: &str) {
        for module in &self.tree.modules {
            let path = std::iter::once(crate_name).chain(module.path.iter().map(String::as_str));
            let path = path.collect::<Vec<_>>().join("::");
            for item in &module.items {
                let Item::Macro(item) = item else { continue };
                let name = text(&item.mac.path);
                if !DECLARING_MACROS.contains(&name.as_str()) {
                    continue;
                }
                for entry in entries(item.mac.tokens.clone()) {
                    self.interface.lines.insert(format!("made {path}::{name}! {}", text(&entry)));
                }
            }
        }
    }

    fn add_reexport(&mut self, target: Target, path: &str) {
        if let Some(home) = self.homes.get(&target) {
            if home != path {
                let line = format!("use {path} = {home}");
                self.line(line);
            }
            return;
        }
        self.homes.insert(target.clone(), path.to_string());
        match target {
            Target::Module(module) => {
                self.add_items(module, path);
                self.add_reexports(module, path, &mut BTreeSet::new());
            }
            Target::Item(module, name) => {
                let tree = self.tree;
                let mut items = tree.modules[module].items.iter();
                match items.find(|item| item_name(item).as_deref() == Some(&name)) {
                    Some(item) if is_hidden(item_attributes(item)) => {}
                    Some(item) => self.add_item(item, path),
                    None => self.line(format!("use {path}")),
                }
            }
        }
    }

    fn add_glob(&mut self, module: usize, path: &str) {
        let tree = self.tree;
        let items = tree.modules[module].items.iter().filter(|item| is_public_item(item));
        for name in items.filter_map(item_name) {
            self.add_reexport(Target::Item(module, name.clone()), &format!("{path}::{name}"));
        }
    }

    fn add_item(&mut self, item: &Item, path: &str) {
        match item {
            Item::Fn(item) => {
                self.interface.functions += 1;
                self.line(signature("fn", path, &item.sig));
            }
            Item::Const(item) => self.line(format!("const {path}: {}", text(&item.ty))),
            Item::Static(item) => self.line(format!("static {path}: {}", text(&item.ty))),
            Item::Type(item) => {
                let generics = text(&item.generics);
                self.line(format!("type {path}{generics} = {}", text(&item.ty)));
            }
            Item::Macro(_) => self.line(format!("macro {path}!")),
            Item::Struct(item) => {
                let mark = exhaustive_mark(&item.attrs);
                self.line(format!("struct {path}{}{mark}", text(&item.generics)));
                self.add_derives(&item.attrs, path);
                self.add_fields(&item.fields, path, false);
            }
            Item::Enum(item) => {
                let mark = exhaustive_mark(&item.attrs);
                self.line(format!("enum {path}{}{mark}", text(&item.generics)));
                self.add_derives(&item.attrs, path);
                for variant in item.variants.iter().filter(|variant| !is_hidden(&variant.attrs)) {
                    let path = format!("{path}::{}", variant.ident);
                    self.line(format!("variant {path}{}", exhaustive_mark(&variant.attrs)));
                    self.add_fields(&variant.fields, &path, true);
                }
            }
            Item::Trait(item) => {
                let bounds = text(&item.supertraits);
                let bounds = if bounds.is_empty() { bounds } else { format!(": {bounds}") };
                self.line(format!("trait {path}{}{bounds}", text(&item.generics)));
                item.items.iter().for_each(|item| self.add_trait_item(item, path));
            }
            _ => {}
        }
    }

    fn add_trait_item(&mut self, item: &TraitItem, path: &str) {
        match item {
            TraitItem::Fn(item) if !is_hidden(&item.attrs) => {
                let kind = if item.default.is_some() { "provided fn" } else { "required fn" };
                self.line(signature(kind, &format!("{path}::{}", item.sig.ident), &item.sig));
            }
            TraitItem::Const(item) => {
                self.line(format!("const {path}::{}: {}", item.ident, text(&item.ty)));
            }
            TraitItem::Type(item) => {
                self.line(format!("type {path}::{} {}", item.ident, text(&item.bounds)));
            }
            _ => {}
        }
    }

    fn add_fields(&mut self, fields: &Fields, path: &str, of_variant: bool) {
        for (index, field) in fields.iter().enumerate() {
            if (of_variant || is_public(&field.vis)) && !is_hidden(&field.attrs) {
                let name = field.ident.as_ref().map_or(index.to_string(), |name| name.to_string());
                self.line(format!("field {path}::{name}: {}", text(&field.ty)));
            }
        }
    }

    fn add_derives(&mut self, attributes: &[Attribute], path: &str) {
        for attribute in attributes.iter().filter(|a| a.path().is_ident("derive")) {
            let _ = attribute.parse_nested_meta(|meta| {
                self.line(format!("impl {} for {path}", text(&meta.path)));
                Ok(())
            });
        }
    }

    fn add_impl_blocks(&mut self) {
        let tree = self.tree;
        for (index, module) in tree.modules.iter().enumerate() {
            for item in &module.items {
                let Item::Impl(block) = item else { continue };
                let target = implemented_type(tree, index, block);
                let Some(path) = target.and_then(|target| self.homes.get(&target).cloned()) else {
                    continue;
                };
                if is_hidden(&block.attrs) {
                    continue;
                }
                if let Some((_, name, _)) = &block.trait_ {
                    let name = name.segments.last().map(text).unwrap_or_default();
                    let Type::Path(kind) = &*block.self_ty else { continue };
                    let arguments = kind.path.segments.last().map(|last| text(&last.arguments));
                    let arguments = arguments.unwrap_or_default();
                    self.line(format!("impl {name} for {path}{arguments}"));
                } else if let Some(block) = inherent_impl(item) {
                    block.items.iter().for_each(|item| self.add_method(item, &path));
                }
            }
        }
    }

    fn add_method(&mut self, item: &ImplItem, path: &str) {
        match item {
            ImplItem::Fn(item) if is_public(&item.vis) && !is_hidden(&item.attrs) => {
                self.interface.functions += 1;
                self.line(signature("fn", &format!("{path}::{}", item.sig.ident), &item.sig));
            }
            ImplItem::Const(item) if is_public(&item.vis) && !is_hidden(&item.attrs) => {
                self.line(format!("const {path}::{}: {}", item.ident, text(&item.ty)));
            }
            _ => {}
        }
    }
}

/// Line of a function: its kind, its path and its signature from the generics on.
fn signature(kind: &str, path: &str, signature: &syn::Signature) -> String {
    let whole = text(signature);
    let head = format!("fn {}", signature.ident);
    let (before, after) = whole.split_once(&head).unwrap_or(("", &whole));
    let before = before.trim();
    let before = if before.is_empty() { String::new() } else { format!(" [{before}]") };
    format!("{kind} {path}{after}{before}")
}

fn exhaustive_mark(attributes: &[Attribute]) -> &'static str {
    let exhaustive = !attributes.iter().any(|a| a.path().is_ident("non_exhaustive"));
    if exhaustive { "" } else { " [non_exhaustive]" }
}

fn is_public_item(item: &Item) -> bool {
    let visibility = match item {
        Item::Const(item) => &item.vis,
        Item::Enum(item) => &item.vis,
        Item::Fn(item) => &item.vis,
        Item::Static(item) => &item.vis,
        Item::Struct(item) => &item.vis,
        Item::Trait(item) => &item.vis,
        Item::Type(item) => &item.vis,
        _ => return false,
    };
    is_public(visibility) && !is_hidden(item_attributes(item))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "
        pub mod a { #[derive(Clone)] #[non_exhaustive] pub struct X<T> { pub p: Vec<T>, q: u8 }
            impl<T> X<T> { pub fn new(p: &[T]) -> Self {} fn no() {} #[doc(hidden)] pub fn h() {} }
            pub trait T: Copy { fn r(&self); fn d(&self) {} } impl T for X<f64> {}
            pub use super::b::W; }
        mod b { pub struct W; impl W { pub const fn w(self) {} } pub enum E { A, B { n: u8 } }
            pub fn out() {} }
        #[doc(hidden)] pub mod internals { pub fn i() {} }
        pub use a::X; pub use b::*; pub use glam::Vec3; pub(crate) use b::out as o;";

    #[test]
    fn each_reachable_item_has_one_line() {
        let interface = interface(&SourceTree::from_source(SOURCE).unwrap(), "s");
        let expected = "\
            enum s::E|field s::E::B::n: u8|field s::a::X::p: Vec<T>|fn s::W::w(self) [const]|\
            fn s::a::X::new(p: &[T]) -> Self|fn s::out()|impl Clone for s::a::X|\
            impl T for s::a::X<f64>|mod s|mod s::a|provided fn s::a::T::d(&self)|\
            required fn s::a::T::r(&self)|struct s::W|struct s::a::X<T> [non_exhaustive]|\
            trait s::a::T: Copy|use s::Vec3 = glam::Vec3|use s::X = s::a::X|use s::a::W = s::W|\
            variant s::E::A|variant s::E::B";
        let lines: Vec<&str> = interface.lines.iter().map(String::as_str).collect();
        assert_eq!(lines, expected.split('|').collect::<Vec<_>>());
        assert_eq!(interface.functions, 3);
    }

    #[test]
    fn entries_of_macros_are_listed_without_their_comments() {
        let source = "parameters! { /// First.\n A: f(1, 2).g(), B: h(), } other! { C: k() }";
        let interface = interface(&SourceTree::from_source(source).unwrap(), "s");
        let lines: Vec<&str> = interface.lines.iter().map(String::as_str).collect();
        assert_eq!(lines, ["made s::parameters! A: f(1, 2).g()", "made s::parameters! B: h()", "mod s"]);
    }

    #[test]
    fn a_difference_puts_changes_of_an_item_together() {
        let found = difference("fn a::f()\nfn b::g()\n", "fn a::f(x: u8)\nfn b::g()\nmod c\n");
        assert_eq!(found, ["- fn a::f()", "+ fn a::f(x: u8)", "+ mod c"]);
    }
}
