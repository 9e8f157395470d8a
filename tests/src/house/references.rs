//! Paths that the code of a module names: `use` declarations, paths in code, tokens of macros.

use super::source_tree::{is_public, is_test, item_attributes};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Item, UseTree, Visibility};

/// How a path is named.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Role {
    /// `use path;` or `use path as name;`.
    Import {
        /// Name that the module gets.
        name: String,
        /// Visibility of the name.
        scope: Scope,
    },
    /// `use path::*;`.
    Glob {
        /// Visibility of the names.
        scope: Scope,
    },
    /// A path in an expression, type, pattern, attribute or macro.
    Inline,
}

/// Visibility of an imported name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// The module and its children.
    Private,
    /// `pub(...)`.
    Restricted,
    /// `pub`.
    Public,
}

/// A path as it is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reference {
    /// Names of the path, with leading `crate`, `self` and `super`.
    pub segments: Vec<String>,
    /// Line number, from 1.
    pub line: usize,
    /// How the path is named.
    pub role: Role,
}

/// Paths of the `use` declarations among the items of a module.
pub fn use_references(items: &[Item]) -> Vec<Reference> {
    let mut collector = Collector::default();
    for item in items {
        if let Item::Use(item) = item {
            collector.visit_item_use(item);
        }
    }
    collector.found
}

/// All paths that the items of a module name; child modules and items under `#[cfg(test)]` are
/// left out.
pub fn references(items: &[Item]) -> Vec<Reference> {
    let mut collector = Collector::default();
    for item in items {
        collector.visit_item(item);
    }
    collector.found
}

#[derive(Default)]
struct Collector {
    found: Vec<Reference>,
}

impl Collector {
    fn add_use(&mut self, tree: &UseTree, prefix: &[String], scope: Scope) {
        let with = |name: &syn::Ident| [prefix, &[name.to_string()]].concat();
        let (name, target) = match tree {
            UseTree::Path(path) => return self.add_use(&path.tree, &with(&path.ident), scope),
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.add_use(tree, prefix, scope));
            }
            UseTree::Glob(glob) => {
                let line = glob.star_token.spans[0].start().line;
                let role = Role::Glob { scope };
                return self.found.push(Reference { segments: prefix.to_vec(), line, role });
            }
            UseTree::Name(name) => (&name.ident, &name.ident),
            UseTree::Rename(rename) => (&rename.rename, &rename.ident),
        };
        let line = target.span().start().line;
        let stays = target == "self" && !prefix.is_empty();
        let segments = if stays { prefix.to_vec() } else { with(target) };
        let is_self = name == "self";
        let name = if is_self { segments.last().cloned().unwrap() } else { name.to_string() };
        self.found.push(Reference { segments, line, role: Role::Import { name, scope } });
    }

    fn add_path(&mut self, segments: Vec<String>, line: usize) {
        if segments.len() > 1 {
            self.found.push(Reference { segments, line, role: Role::Inline });
        }
    }

    /// Collect `a::b::c` and `a::{b, c}` from tokens. `prefix` is set inside a group of a path.
    fn add_tokens(&mut self, stream: TokenStream, prefix: &[String]) {
        let trees: Vec<TokenTree> = stream.into_iter().collect();
        let (mut at, mut starts) = (0, true);
        while at < trees.len() {
            match &trees[at] {
                TokenTree::Ident(first) => {
                    let line = first.span().start().line;
                    let mut segments = if starts { prefix.to_vec() } else { Vec::new() };
                    segments.push(first.to_string());
                    at += 1;
                    while is_separator(&trees[at..]) {
                        at += 2;
                        match trees.get(at) {
                            Some(TokenTree::Ident(next)) => segments.push(next.to_string()),
                            Some(TokenTree::Group(group)) if is_brace(group) => {
                                self.add_tokens(group.stream(), &segments);
                            }
                            _ => break,
                        }
                        at += 1;
                    }
                    self.add_path(segments, line);
                    starts = false;
                    continue;
                }
                TokenTree::Group(group) => self.add_tokens(group.stream(), &[]),
                TokenTree::Punct(punct) if punct.as_char() == ',' => {
                    (starts, at) = (true, at + 1);
                    continue;
                }
                TokenTree::Punct(_) if is_separator(&trees[at..]) => {
                    // A path from `::`, or the rest of `<T as Trait>::name`: no module of ours.
                    at += 2;
                    starts = false;
                    at += usize::from(matches!(trees.get(at), Some(TokenTree::Ident(_))));
                    continue;
                }
                _ => {}
            }
            starts = false;
            at += 1;
        }
    }
}

fn is_brace(group: &proc_macro2::Group) -> bool {
    group.delimiter() == Delimiter::Brace
}

fn is_separator(trees: &[TokenTree]) -> bool {
    matches!(trees, [TokenTree::Punct(a), TokenTree::Punct(b), ..]
        if a.as_char() == ':' && b.as_char() == ':' && a.spacing() == proc_macro2::Spacing::Joint)
}

impl<'ast> Visit<'ast> for Collector {
    fn visit_item(&mut self, item: &'ast Item) {
        if !is_test(item_attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if !is_test(&item.attrs) {
            visit::visit_impl_item_fn(self, item);
        }
    }

    fn visit_field(&mut self, field: &'ast syn::Field) {
        if !is_test(&field.attrs) {
            visit::visit_field(self, field);
        }
    }

    fn visit_local(&mut self, local: &'ast syn::Local) {
        if !is_test(&local.attrs) {
            visit::visit_local(self, local);
        }
    }

    fn visit_expr_block(&mut self, block: &'ast syn::ExprBlock) {
        if !is_test(&block.attrs) {
            visit::visit_expr_block(self, block);
        }
    }

    fn visit_item_mod(&mut self, _: &'ast syn::ItemMod) {}

    fn visit_vis_restricted(&mut self, _: &'ast syn::VisRestricted) {}

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let scope = match &item.vis {
            vis if is_public(vis) => Scope::Public,
            Visibility::Inherited => Scope::Private,
            _ => Scope::Restricted,
        };
        if item.leading_colon.is_none() {
            self.add_use(&item.tree, &[], scope);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.leading_colon.is_none() {
            let names = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
            let line = path.segments.first().map_or(0, |first| first.ident.span().start().line);
            self.add_path(names, line);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, item: &'ast syn::Macro) {
        self.add_tokens(item.tokens.clone(), &[]);
        visit::visit_macro(self, item);
    }

    /// Attributes name paths as strings: `#[serde(with = "crate::units::angle")]`.
    fn visit_attribute(&mut self, attribute: &'ast syn::Attribute) {
        let syn::Meta::List(list) = &attribute.meta else { return };
        for tree in list.tokens.clone() {
            let TokenTree::Literal(literal) = tree else { continue };
            let text = literal.to_string();
            let text = text.trim_matches('"');
            let inside = ["crate::", "super::", "self::"].iter().any(|s| text.starts_with(s));
            if let (true, Ok(path)) = (inside, syn::parse_str::<syn::Path>(text)) {
                let names = path.segments.iter().map(|segment| segment.ident.to_string());
                self.add_path(names.collect(), literal.span().start().line);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(source: &str) -> Vec<String> {
        let file = syn::parse_file(source).unwrap();
        references(&file.items).iter().map(|reference| reference.segments.join("::")).collect()
    }

    #[test]
    fn use_groups_are_opened_up() {
        let found = paths("use crate::{a::{self, X}, b as c, d::*}; use ::e::f; use super::g;");
        assert_eq!(found, ["crate::a", "crate::a::X", "crate::b", "crate::d", "super::g"]);
    }

    #[test]
    fn paths_in_code_types_and_patterns_are_found() {
        let found = paths("fn f(x: crate::a::X) -> super::Y { match x { crate::b::P => self::c::g::<u8>() } }");
        assert_eq!(found, ["crate::a::X", "super::Y", "crate::b::P", "self::c::g"]);
    }

    #[test]
    fn paths_in_macros_and_attribute_strings_are_found() {
        let found = paths(
            "fn f() { println!(\"{}\", crate::a::X); m! { use $crate::{b::Y, c}; ::d::e } }
             struct S { #[serde(with = \"crate::units::angle\")] a: f64 }",
        );
        let expected = ["crate::a::X", "crate::b::Y", "crate::c", "crate::units::angle"];
        for path in expected {
            assert!(found.iter().any(|found| found == path), "{path} in {found:?}");
        }
        assert!(!found.iter().any(|found| found.contains("d::e")));
    }

    #[test]
    fn code_of_tests_and_visibilities_are_left_out() {
        let found = paths(
            "#[cfg(test)] use crate::a::X; #[cfg(all(test, unix))] fn f() { crate::b::g() }
             pub(in crate::c) fn h() {} #[cfg(not(test))] use crate::d::Y;",
        );
        assert_eq!(found, ["crate::d::Y"]);
    }
}
