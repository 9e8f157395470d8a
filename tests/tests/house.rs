//! The code base keeps to its order, sizes and style. `cargo run -p sheetwork-tests --bin house`
//! prints the figures and the places behind them.

use sheetwork_tests::house::circles::{OwnChildren, describe, excluded_imports, file_circles};
use sheetwork_tests::house::layout::Layout;
use sheetwork_tests::house::numbers::{self, Number};
use sheetwork_tests::house::packages::packages;
use sheetwork_tests::house::source_tree::SourceTree;
use sheetwork_tests::house::{api, paths, rooms};
use std::path::PathBuf;

/// Snapshot of the public interface of the library, relative to the root.
const SNAPSHOT: &str = "tests/tests/public_api.txt";

/// Maximum of figures, by the beginning of the figure's name: the goal, or the present value of a
/// figure that has not reached its goal (constants 40, fields 20, methods 80, functions 0, files 0)
/// and must not grow.
const MAXIMA: [(&str, usize); 12] = [
    ("`pub fn` reachable from outside", 394),
    ("private numeric constants", 39),
    ("fields of `Sheet`", 19),
    ("methods of `Sheet`", 80),
    ("`impl Sheet` blocks outside", 0),
    ("comment lines over 100 columns", 0),
    ("comment sentences that begin with", 19),
    ("lines of the library without tests", 70_400),
    ("lines of all crates without tests", 113_400),
    ("functions over 60 lines", 3),
    ("files over 600 lines", 0),
    ("rooms of the library in circles", 0),
];

/// Layout of this repository; `HOUSE_ROOT` names another one.
fn layout() -> Layout {
    let parent = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
    Layout::new(std::env::var("HOUSE_ROOT").map_or_else(|_| parent(), PathBuf::from))
}

fn library(layout: &Layout) -> SourceTree {
    SourceTree::load(&layout.root, &layout.library).unwrap()
}

#[track_caller]
fn assert_none(problems: &[String]) {
    assert!(problems.is_empty(), "{} problems\n{}", problems.len(), problems.join("\n"));
}

#[test]
fn rooms_import_only_rooms_above_them() {
    assert_none(&rooms::violations(&library(&layout()), &rooms::ROOMS));
}

#[test]
fn the_architecture_document_shows_the_rooms() {
    let layout = layout();
    let table = rooms::table(&library(&layout), &rooms::ROOMS);
    assert_none(&rooms::check_document(&layout, &table).unwrap());
}

#[test]
fn files_of_plugin_and_editor_import_without_circles() {
    let layout = layout();
    for folder in [&layout.plugin, &layout.editor] {
        let tree = SourceTree::load(&layout.root, folder).unwrap();
        let circles = file_circles(&tree, OwnChildren::Count);
        let lines = circles.iter().flat_map(|circle| describe(&tree, circle)).collect::<Vec<_>>();
        assert_none(&lines);
    }
}

#[test]
fn the_core_of_the_plugin_imports_neither_asset_nor_render() {
    let layout = layout();
    let plugin = SourceTree::load(&layout.root, &layout.plugin).unwrap();
    assert_none(&excluded_imports(&plugin, "core", &["asset", "render"]));
}

#[test]
fn figures_stay_within_their_maxima() {
    let layout = layout();
    let library = library(&layout);
    let mut figures: Vec<Number> = numbers::circle_numbers(&layout, &library).unwrap();
    figures.extend(numbers::library_numbers(&layout, &library));
    figures.extend(numbers::comment_numbers(&layout).unwrap());
    figures.extend(numbers::size_numbers(&layout).unwrap());
    let mut problems = Vec::new();
    for (name, maximum) in MAXIMA {
        let figure = figures.iter().find(|figure| figure.what.starts_with(name)).unwrap();
        if figure.value > maximum {
            problems.push(format!("{}: {} of at most {maximum}", figure.what, figure.value));
            problems.extend(figure.places.iter().take(20).map(|place| format!("  {place}")));
        }
    }
    assert_none(&problems);
}

#[test]
fn the_library_depends_on_few_packages() {
    let layout = layout();
    for (default_features, maximum) in [(true, 83), (false, 78)] {
        let found = packages(&layout.root, numbers::LIBRARY, default_features).unwrap();
        assert!(found.len() <= maximum, "{} of at most {maximum}: {found:#?}", found.len());
    }
}

/// The plugin without its feature `render`, as a server depends on it.
#[test]
fn a_server_with_the_plugin_compiles_no_graphics() {
    let layout = layout();
    let found = packages(&layout.root, "bevy_sheetwork", false).unwrap();
    let graphics = ["wgpu", "naga", "winit", "x11", "bevy_render", "bevy_pbr", "bevy_window", "bevy_winit"];
    let is_graphics = |package: &&String| graphics.iter().any(|name| package.starts_with(name));
    assert_none(&found.iter().filter(is_graphics).cloned().collect::<Vec<_>>());
    assert!(found.len() <= 179, "{} of at most 179: {found:#?}", found.len());
    let drawn = packages(&layout.root, "bevy_sheetwork", true).unwrap();
    assert!(graphics.iter().all(|name| drawn.iter().any(|package| package.starts_with(name))), "{drawn:#?}");
}

#[test]
fn the_public_interface_is_that_of_the_snapshot() {
    let layout = layout();
    let new = api::snapshot(&api::interface(&library(&layout), numbers::LIBRARY));
    let difference = api::difference(&layout.read(SNAPSHOT).unwrap(), &new);
    let renew = format!("renew with `house api --write {SNAPSHOT}`");
    assert!(difference.is_empty(), "{renew}\n{}", difference.join("\n"));
}

#[test]
fn paths_and_links_of_the_documents_exist() {
    assert_none(&paths::broken(&layout()).unwrap());
}
