//! Lengths of files and functions, tests left out.

use super::Result;
use super::layout::Layout;
use super::source_tree::{is_test, item_attributes};
use std::collections::BTreeSet;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Item, ItemMod};

/// Maximum length of a function, in lines from its signature to its closing brace.
pub const MAX_FUNCTION_LINES: usize = 60;
/// Maximum length of a file, in lines without those of tests.
pub const MAX_FILE_LINES: usize = 600;

/// Folders whose code is a test, a benchmark or an example.
const TEST_FOLDERS: [&str; 3] = ["tests", "benches", "examples"];

/// A function and its length.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Name without path.
    pub name: String,
    /// Line of the signature, from 1.
    pub line: usize,
    /// Lines from the signature to the closing brace.
    pub length: usize,
}

/// Sizes in one source file.
#[derive(Clone, Debug)]
pub struct FileSize {
    /// Path relative to the repository root.
    pub file: String,
    /// Lines without those of items under `#[cfg(test)]`.
    pub lines: usize,
    /// All lines.
    pub all_lines: usize,
    /// Functions, tests left out.
    pub functions: Vec<Function>,
}

/// Sizes of all source files of the repository except tests, benchmarks and examples.
pub fn measure(layout: &Layout) -> Result<Vec<FileSize>> {
    let files: Vec<String> = layout.rust_files()?.into_iter().filter(|file| !is_test_file(file)).collect();
    let mut sizes = Vec::new();
    let mut test_modules = BTreeSet::new();
    for file in files {
        let source = layout.read(&file)?;
        let (size, modules) = measure_source(&file, &source)?;
        sizes.push(size);
        test_modules.extend(modules);
    }
    sizes.retain(|size| !test_modules.contains(&size.file));
    Ok(sizes)
}

fn is_test_file(file: &str) -> bool {
    let mut parts: Vec<&str> = file.split('/').collect();
    let name = parts.pop().unwrap_or_default();
    name == "tests.rs" || parts.iter().any(|folder| TEST_FOLDERS.contains(folder))
}

/// Sizes in a source text, and the files of its modules that are declared under `#[cfg(test)]`.
fn measure_source(file: &str, source: &str) -> Result<(FileSize, Vec<String>)> {
    let parsed = syn::parse_file(source).map_err(|error| format!("{file}: {error}"))?;
    let mut meter = Meter::default();
    meter.visit_file(&parsed);
    let all_lines = source.lines().count();
    let lines = all_lines - meter.test_lines;
    let (folder, name) = file.rsplit_once('/').unwrap_or(("", file));
    let folder = match name {
        "lib.rs" | "main.rs" | "mod.rs" => folder.to_string(),
        _ => file.trim_end_matches(".rs").to_string(),
    };
    let paths = |module: &String| [format!("{folder}/{module}.rs"), format!("{folder}/{module}/mod.rs")];
    let modules = meter.test_modules.iter().flat_map(paths).collect();
    Ok((FileSize { file: file.to_string(), lines, all_lines, functions: meter.functions }, modules))
}

#[derive(Default)]
struct Meter {
    test_lines: usize,
    test_modules: Vec<String>,
    functions: Vec<Function>,
}

impl Meter {
    fn add(&mut self, signature: &syn::Signature, block: &syn::Block) {
        let line = signature.fn_token.span.start().line;
        let length = block.brace_token.span.close().end().line - line + 1;
        self.functions.push(Function { name: signature.ident.to_string(), line, length });
    }
}

impl<'ast> Visit<'ast> for Meter {
    fn visit_item(&mut self, item: &'ast Item) {
        if !is_test(item_attributes(item)) {
            return visit::visit_item(self, item);
        }
        let (start, end) = (item.span().start().line, item.span().end().line);
        self.test_lines += end + 1 - start;
        if let Item::Mod(ItemMod { ident, content: None, .. }) = item {
            self.test_modules.push(ident.to_string());
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.add(&item.sig, &item.block);
        visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if !is_test(&item.attrs) {
            self.add(&item.sig, &item.block);
            visit::visit_impl_item_fn(self, item);
        }
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        if let Some(block) = &item.default {
            self.add(&item.sig, block);
        }
        visit::visit_trait_item_fn(self, item);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_tests_do_not_count() {
        let source = "fn f() {\n}\n\n#[cfg(test)]\nmod tests {\n    fn g() {}\n}\n";
        let (size, modules) = measure_source("a/b.rs", source).unwrap();
        assert_eq!((size.lines, modules.len()), (3, 0));
        let expected = Function { name: "f".into(), line: 1, length: 2 };
        assert_eq!(size.functions, [expected]);
    }

    #[test]
    fn files_of_test_modules_are_named() {
        let (_, modules) = measure_source("a/b.rs", "#[cfg(test)]\nmod checks;\n").unwrap();
        assert_eq!(modules, ["a/b/checks.rs", "a/b/checks/mod.rs"]);
        assert!(is_test_file("runtime/x/tests/common/mod.rs") && is_test_file("a/tests.rs"));
        assert!(!is_test_file("runtime/sheetwork/src/contact/testing.rs"));
    }
}
