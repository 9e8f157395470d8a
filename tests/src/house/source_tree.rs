//! Modules of a crate, parsed: the tree that the `mod` declarations of its root describe.

use super::Result;
use super::layout::{read, relative};
use super::references::{Reference, Role, use_references};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::punctuated::Punctuated;
use syn::{Attribute, Expr, Item, ItemMod, Lit, Meta, Token, Visibility};

/// A module, in a file of its own or inline.
pub struct Module {
    /// Names from the crate root; empty for the root.
    pub path: Vec<String>,
    /// File that holds the module, relative to the repository root.
    pub file: String,
    /// True for `mod name { ... }`.
    pub inline: bool,
    /// True for `pub mod`, and for the root.
    pub public: bool,
    /// True under `#[doc(hidden)]`.
    pub hidden: bool,
    /// Items of the module; those under `#[cfg(test)]` are left out.
    pub items: Vec<Item>,
    /// Child modules by name.
    pub children: BTreeMap<String, usize>,
    /// Names of the items that the module defines.
    pub names: BTreeSet<String>,
    /// `use` declarations of the module.
    pub uses: Vec<Reference>,
}

/// A crate: its modules, the root first.
pub struct SourceTree {
    /// Modules; a parent comes before its children.
    pub modules: Vec<Module>,
    /// Macros with `#[macro_export]`, which are names of the root, with their modules.
    pub exported_macros: BTreeMap<String, usize>,
}

impl SourceTree {
    /// Parse the crate whose source is in `folder` (relative to `root`), from `lib.rs` or
    /// `main.rs`.
    pub fn load(root: &Path, folder: &str) -> Result<Self> {
        let folder = root.join(folder);
        let names = ["lib.rs", "main.rs"];
        let file = names.iter().map(|name| folder.join(name)).find(|file| file.is_file());
        let file = file.ok_or_else(|| format!("{}: no lib.rs or main.rs", folder.display()))?;
        let mut tree = Self { modules: Vec::new(), exported_macros: BTreeMap::new() };
        let items = parse(&file)?;
        let place = Place { file, folder, root, inline: false };
        tree.add(Vec::new(), items, (true, false), place)?;
        Ok(tree)
    }

    /// Parse a crate from one text; for tests.
    pub fn from_source(source: &str) -> Result<Self> {
        let file = syn::parse_file(source).map_err(|error| error.to_string())?;
        let mut tree = Self { modules: Vec::new(), exported_macros: BTreeMap::new() };
        let root = Path::new("");
        let place = Place { file: "lib.rs".into(), folder: "".into(), root, inline: false };
        tree.add(Vec::new(), file.items, (true, false), place)?;
        Ok(tree)
    }

    /// Index of the module with a path.
    pub fn find(&self, path: &[String]) -> Option<usize> {
        path.iter().try_fold(0, |module, name| self.modules[module].children.get(name).copied())
    }

    /// Add a module and its children; returns its index.
    fn add(
        &mut self,
        path: Vec<String>,
        items: Vec<Item>,
        (public, hidden): (bool, bool),
        place: Place,
    ) -> Result<usize> {
        let items: Vec<Item> = items.into_iter().filter(|item| !is_test(item_attributes(item))).collect();
        let index = self.modules.len();
        let names: BTreeSet<String> = items.iter().filter_map(item_name).collect();
        for item in &items {
            if let (Item::Macro(item), Some(name)) = (item, item_name(item))
                && item.attrs.iter().any(|attribute| attribute.path().is_ident("macro_export"))
            {
                self.exported_macros.insert(name, index);
            }
        }
        let declared: Vec<ItemMod> = items.iter().filter_map(module_item).collect();
        self.modules.push(Module {
            path: path.clone(),
            file: relative(place.root, &place.file),
            inline: place.inline,
            public,
            hidden,
            uses: use_references(&items),
            items,
            children: BTreeMap::new(),
            names,
        });
        for declaration in declared {
            let name = declaration.ident.to_string();
            let (items, child_place) = place.child(&declaration)?;
            let child_path = [path.clone(), vec![name.clone()]].concat();
            let seen = (is_public(&declaration.vis), hidden || is_hidden(&declaration.attrs));
            let child = self.add(child_path, items, seen, child_place)?;
            self.modules[index].children.insert(name, child);
        }
        Ok(index)
    }
}

/// Where a module is: its file and the folder of its children.
struct Place<'a> {
    file: PathBuf,
    folder: PathBuf,
    root: &'a Path,
    inline: bool,
}

impl<'a> Place<'a> {
    fn child(&self, declaration: &ItemMod) -> Result<(Vec<Item>, Place<'a>)> {
        let name = declaration.ident.to_string();
        let name = name.trim_start_matches("r#");
        let folder = self.folder.join(name);
        if let Some((_, items)) = &declaration.content {
            let place = Place { file: self.file.clone(), folder, root: self.root, inline: true };
            return Ok((items.clone(), place));
        }
        let beside = self.folder.join(format!("{name}.rs"));
        let (file, folder) = match path_attribute(&declaration.attrs) {
            Some(path) => {
                let file = self.file.with_file_name(path);
                let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
                (file, folder)
            }
            None if beside.is_file() => (beside, folder),
            None => (folder.join("mod.rs"), folder),
        };
        let items = parse(&file)?;
        Ok((items, Place { file, folder, root: self.root, inline: false }))
    }
}

/// Parse a file into its items.
fn parse(file: &Path) -> Result<Vec<Item>> {
    let parsed = syn::parse_file(&read(file)?);
    let place = |error: &syn::Error| error.span().start().line;
    let parsed = parsed.map_err(|e| format!("{}:{}: {e}", file.display(), place(&e)))?;
    if is_test(&parsed.attrs) { Ok(Vec::new()) } else { Ok(parsed.items) }
}

fn module_item(item: &Item) -> Option<ItemMod> {
    match item {
        Item::Mod(item) => Some(item.clone()),
        _ => None,
    }
}

fn path_attribute(attributes: &[Attribute]) -> Option<String> {
    let attribute = attributes.iter().find(|attribute| attribute.path().is_ident("path"))?;
    let Meta::NameValue(meta) = &attribute.meta else { return None };
    let Expr::Lit(value) = &meta.value else { return None };
    if let Lit::Str(text) = &value.lit { Some(text.value()) } else { None }
}

/// True for `pub` without a restriction.
pub fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

/// True under `#[doc(hidden)]`.
pub fn is_hidden(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) if list.path.is_ident("doc") => list.tokens.to_string() == "hidden",
        _ => false,
    })
}

/// True under `#[test]`, `#[cfg(test)]` and `#[cfg(all(test, ...))]`.
pub fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) if list.path.is_ident("cfg") => {
            list.parse_args().is_ok_and(|condition| requires_test(&condition))
        }
        _ => false,
    })
}

fn requires_test(condition: &Meta) -> bool {
    match condition {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) if list.path.is_ident("all") => {
            let parts = list.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated);
            parts.is_ok_and(|parts| parts.iter().any(requires_test))
        }
        _ => false,
    }
}

/// Attributes of an item.
pub fn item_attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::ExternCrate(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::ForeignMod(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::TraitAlias(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// Name that an item defines in its module.
pub fn item_name(item: &Item) -> Option<String> {
    let name = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::TraitAlias(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(name.to_string())
}

impl Module {
    /// `use` declarations that bind a name, not globs.
    pub fn bindings(&self) -> impl Iterator<Item = (&str, &Reference)> {
        self.uses.iter().filter_map(|reference| match &reference.role {
            Role::Import { name, .. } => Some((name.as_str(), reference)),
            _ => None,
        })
    }

    /// `use` declarations that end in `*`.
    pub fn globs(&self) -> impl Iterator<Item = &Reference> {
        self.uses.iter().filter(|reference| matches!(reference.role, Role::Glob { .. }))
    }
}
