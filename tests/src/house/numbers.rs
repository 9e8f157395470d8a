//! Figures of the code base, each with the list behind it.

use super::Result;
use super::api::interface;
use super::circles::{OwnChildren, file_circles};
use super::comments::{VAGUE_OPENINGS, vague_sentences, wide_lines};
use super::graph::circles;
use super::inventory::{private_constants, public_functions, summarise_struct};
use super::layout::Layout;
use super::packages::packages;
use super::rooms;
use super::sizes::{self, FileSize, MAX_FILE_LINES, MAX_FUNCTION_LINES};
use super::source_tree::SourceTree;

/// Name of the library.
pub const LIBRARY: &str = "sheetwork";

/// A figure: its name, its value, and the places that were counted where there is a list.
#[derive(Clone, Debug)]
pub struct Number {
    /// Name of the figure.
    pub what: String,
    /// Value.
    pub value: usize,
    /// Places, as `file:line: name`.
    pub places: Vec<String>,
}

impl Number {
    fn new(what: impl Into<String>, value: usize) -> Self {
        Self { what: what.into(), value, places: Vec::new() }
    }

    fn listed(what: impl Into<String>, places: Vec<String>) -> Self {
        Self { what: what.into(), value: places.len(), places }
    }
}

/// All figures, in the order of the table.
pub fn all(layout: &Layout) -> Result<Vec<Number>> {
    let library = SourceTree::load(&layout.root, &layout.library)?;
    let mut numbers = circle_numbers(layout, &library)?;
    numbers.extend(library_numbers(layout, &library));
    numbers.extend(comment_numbers(layout)?);
    numbers.extend(size_numbers(layout)?);
    for (what, default_features) in [("", true), (", without default features", false)] {
        let what = format!("packages of `cargo tree -p {LIBRARY} -e normal`{what}");
        let found = packages(&layout.root, LIBRARY, default_features)?;
        numbers.push(Number::listed(what, found.into_iter().collect()));
    }
    Ok(numbers)
}

/// Table of figures as Markdown.
pub fn table(numbers: &[Number]) -> String {
    let mut text = String::from("| what | value |\n|---|---|\n");
    for Number { what, value, .. } in numbers {
        text.push_str(&format!("| {what} | {value} |\n"));
    }
    text
}

/// Rooms and files in circles: each member is a place.
pub fn circle_numbers(layout: &Layout, library: &SourceTree) -> Result<Vec<Number>> {
    let places = |circles: Vec<Vec<String>>| -> Vec<String> {
        let line = |(index, circle): (usize, Vec<String>)| -> Vec<String> {
            circle.into_iter().map(|name| format!("circle {}: {name}", index + 1)).collect()
        };
        circles.into_iter().enumerate().flat_map(line).collect()
    };
    let imports = rooms::imports(library);
    let room_circles = places(circles(&rooms::graph(&imports)));
    let mut numbers = vec![Number::listed("rooms of the library in circles", room_circles)];
    for (name, folder) in [("plugin", &layout.plugin), ("editor", &layout.editor)] {
        let tree = SourceTree::load(&layout.root, folder)?;
        let what = format!("files of the {name} in circles");
        let found = places(file_circles(&tree, OwnChildren::Count));
        numbers.push(Number::listed(&what, found));
        let found = places(file_circles(&tree, OwnChildren::Ignore));
        numbers.push(Number::listed(format!("{what}, a module with its own children aside"), found));
    }
    Ok(numbers)
}

/// Public functions, private constants, and the size of `Sheet`.
pub fn library_numbers(layout: &Layout, library: &SourceTree) -> Vec<Number> {
    let constants = private_constants(library, &layout.constant_rooms);
    let place = |c: &super::inventory::Constant| format!("{}:{}: {}", c.file, c.line, c.name);
    let constants: Vec<String> = constants.iter().map(place).collect();
    let sheet = summarise_struct(library, "sheet", "Sheet").unwrap_or_default();
    let rooms = layout.constant_rooms.join(", ");
    vec![
        Number::new("`pub fn` reachable from outside", interface(library, LIBRARY).functions),
        Number::new("`pub fn` written in the library", public_functions(library)),
        Number::listed(format!("private numeric constants in {rooms}"), constants),
        Number::new("fields of `Sheet`", sheet.fields),
        Number::new("methods of `Sheet`", sheet.methods),
        Number::listed("`impl Sheet` blocks outside `sheet/`", sheet.outside),
    ]
}

/// Wide comment lines and vague openings of sentences, in all Rust files.
pub fn comment_numbers(layout: &Layout) -> Result<Vec<Number>> {
    let (mut wide, mut vague) = (Vec::new(), Vec::new());
    for file in layout.rust_files()? {
        let source = layout.read(&file)?;
        let line = |(line, width): (usize, usize)| format!("{file}:{line}: {width} columns");
        wide.extend(wide_lines(&source).into_iter().map(line));
        let sentences = vague_sentences(&source);
        vague.extend(sentences.iter().map(|s| format!("{file}:{}: {}", s.line, s.text)));
    }
    let openings = VAGUE_OPENINGS.map(|opening| format!("\"{}\"", opening.trim())).join(", ");
    Ok(vec![
        Number::listed("comment lines over 100 columns", wide),
        Number::listed(format!("comment sentences that begin with {openings}"), vague),
    ])
}

/// Lines of code, long functions and long files, without tests.
pub fn size_numbers(layout: &Layout) -> Result<Vec<Number>> {
    let sizes = sizes::measure(layout)?;
    let total = |folder: &str, lines: fn(&FileSize) -> usize| -> usize {
        sizes.iter().filter(|size| size.file.starts_with(folder)).map(lines).sum()
    };
    let (plain, whole) = (|size: &FileSize| size.lines, |size: &FileSize| size.all_lines);
    let library = format!("{}/", layout.library);
    let long: Vec<String> = sizes.iter().flat_map(long_functions).collect();
    let files = sizes.iter().filter(|size| size.lines > MAX_FILE_LINES);
    let files = files.map(|size| format!("{}: {} lines", size.file, size.lines)).collect();
    Ok(vec![
        Number::new("lines of the library without tests", total(&library, plain)),
        Number::new("lines of all crates without tests", total("", plain)),
        Number::new("lines of the library, unit tests inside files included", total(&library, whole)),
        Number::new("lines of all crates, unit tests inside files included", total("", whole)),
        Number::listed(format!("functions over {MAX_FUNCTION_LINES} lines"), long),
        Number::listed(format!("files over {MAX_FILE_LINES} lines"), files),
    ])
}

fn long_functions(size: &FileSize) -> Vec<String> {
    let long = size.functions.iter().filter(|function| function.length > MAX_FUNCTION_LINES);
    long.map(|f| format!("{}:{}: {}, {} lines", size.file, f.line, f.name, f.length)).collect()
}
