//! Measures and checks the code base. `house` without arguments prints its commands.

use sheetwork_tests::house::layout::Layout;
use sheetwork_tests::house::source_tree::SourceTree;
use sheetwork_tests::house::{Result, api, circles, comments, numbers, paths, rooms, tokens};
use std::path::Path;
use std::process::ExitCode;

const USAGE: &str = "\
usage: house [OPTIONS] COMMAND
commands:
  numbers [--list TEXT]          table of figures; with TEXT, the places of the figures that have
                                 TEXT in their name
  rooms [--write]                table of rooms and violations of their order; --write renews the
                                 table in docs/architecture.md
  circles                        circles of the files of plugin and editor, with their imports
  api [--write FILE | --check FILE]   public interface of the library
  paths                          paths and links of the documentation that lead nowhere
  comments [FILE...]             wide comment lines and vague openings of sentences
  same-code REVISION FILE...     compare code with a Git revision, comments left out
  same-code --against DIR FILE...     compare code with a copy of the tree in DIR
options:
  --root DIR                     root of the repository (default: .)
  --library, --plugin, --editor DIR   source folders, relative to the root
  --constant-rooms A,B           rooms whose private numeric constants are counted";

fn main() -> ExitCode {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let outcome = layout(&mut arguments).and_then(|layout| run(&layout, &arguments));
    match outcome {
        Ok(report) if report.is_empty() => ExitCode::SUCCESS,
        Ok(report) => {
            report.iter().for_each(|line| println!("{line}"));
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

/// Take the options from the front of the arguments.
fn layout(arguments: &mut Vec<String>) -> Result<Layout> {
    let mut layout = Layout::new(".");
    while arguments.len() > 1 && arguments[0].starts_with("--") {
        let value = arguments.remove(1);
        match arguments.remove(0).as_str() {
            "--root" => layout.root = value.into(),
            "--library" => layout.library = value,
            "--plugin" => layout.plugin = value,
            "--editor" => layout.editor = value,
            "--constant-rooms" => {
                layout.constant_rooms = value.split(',').map(String::from).collect();
            }
            other => return Err(format!("unknown option {other}\n{USAGE}")),
        }
    }
    Ok(layout)
}

/// Run a command. The result holds what is wrong, a line each.
fn run(layout: &Layout, arguments: &[String]) -> Result<Vec<String>> {
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["numbers", options @ ..] => print_numbers(layout, options),
        ["rooms", options @ ..] => check_rooms(layout, options.contains(&"--write")),
        ["circles"] => list_circles(layout),
        ["api", options @ ..] => snapshot(layout, options),
        ["paths"] => paths::broken(layout),
        ["comments", ..] => list_comments(layout, &arguments[1..]),
        ["same-code", "--against", directory, _, ..] => {
            let reference = tokens::Reference::Directory(Path::new(directory));
            Ok(tokens::compare_files(&layout.root, reference, &arguments[3..]))
        }
        ["same-code", revision, _, ..] if !revision.starts_with('-') => {
            let reference = tokens::Reference::Revision(revision);
            Ok(tokens::compare_files(&layout.root, reference, &arguments[2..]))
        }
        _ => Err(USAGE.to_string()),
    }
}

fn print_numbers(layout: &Layout, options: &[&str]) -> Result<Vec<String>> {
    let numbers = numbers::all(layout)?;
    match options {
        ["--list", text] => {
            for number in numbers.iter().filter(|number| number.what.contains(text)) {
                println!("{}: {}", number.what, number.value);
                number.places.iter().for_each(|place| println!("  {place}"));
            }
        }
        _ => print!("{}", numbers::table(&numbers)),
    }
    Ok(Vec::new())
}

fn check_rooms(layout: &Layout, write: bool) -> Result<Vec<String>> {
    let library = SourceTree::load(&layout.root, &layout.library)?;
    let table = rooms::table(&library, &rooms::ROOMS);
    print!("{table}");
    if write {
        let document = layout.read(rooms::DOCUMENT)?;
        let missing = || format!("{}: {} is missing", rooms::DOCUMENT, rooms::OPENING);
        let text = rooms::renewed(&document, &table).ok_or_else(missing)?;
        let file = layout.root.join(rooms::DOCUMENT);
        std::fs::write(&file, text).map_err(|error| format!("{}: {error}", file.display()))?;
    }
    let mut report = rooms::violations(&library, &rooms::ROOMS);
    report.extend(rooms::check_document(layout, &table)?);
    Ok(report)
}

fn list_circles(layout: &Layout) -> Result<Vec<String>> {
    let mut report = Vec::new();
    for folder in [&layout.plugin, &layout.editor] {
        let tree = SourceTree::load(&layout.root, folder)?;
        for circle in circles::file_circles(&tree, circles::OwnChildren::Count) {
            report.push(format!("{folder}: circle of {} files", circle.len()));
            let lines = circles::describe(&tree, &circle);
            report.extend(lines.iter().map(|line| format!("  {line}")));
        }
    }
    let plugin = SourceTree::load(&layout.root, &layout.plugin)?;
    for place in circles::excluded_imports(&plugin, "core", &["asset", "render"]) {
        report.push(format!("core imports asset or render: {place}"));
    }
    Ok(report)
}

fn snapshot(layout: &Layout, options: &[&str]) -> Result<Vec<String>> {
    let library = SourceTree::load(&layout.root, &layout.library)?;
    let text = api::snapshot(&api::interface(&library, numbers::LIBRARY));
    match options {
        ["--write", file] => {
            let file = layout.root.join(file);
            std::fs::write(&file, text).map_err(|error| format!("{}: {error}", file.display()))?;
            Ok(Vec::new())
        }
        ["--check", file] => Ok(api::difference(&layout.read(file)?, &text)),
        _ => {
            print!("{text}");
            Ok(Vec::new())
        }
    }
}

fn list_comments(layout: &Layout, files: &[String]) -> Result<Vec<String>> {
    let files = if files.is_empty() { layout.rust_files()? } else { files.to_vec() };
    let mut report = Vec::new();
    for file in files {
        let source = layout.read(&file)?;
        let mut lines = Vec::new();
        for (line, width) in comments::wide_lines(&source) {
            lines.push((line, format!("{file}:{line}: {width} columns")));
        }
        for sentence in comments::vague_sentences(&source) {
            let start: String = sentence.text.chars().take(80).collect();
            lines.push((sentence.line, format!("{file}:{}: sentence: {start}", sentence.line)));
        }
        lines.sort();
        report.extend(lines.into_iter().map(|(_, text)| text));
    }
    Ok(report)
}
