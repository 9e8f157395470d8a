//! Cuts and creases of an SVG file reach the sheet.

use sheetwork::World;
use sheetwork::scene::Scene;

const CARD: &str = "<svg><rect width='100' height='60'/><line x1='50' y1='0' x2='50' y2='30' stroke='red'/>\
    <g id='folds'><line x1='25' y1='0' x2='25' y2='60'/></g></svg>";

/// World with the card, in mm, with further fields of its outline.
fn world(folder: &std::path::Path, lines: &str) -> World {
    let text = format!(
        "(gravity: (0, 0, 0), engine: \"tr-bdf2\", sheets: [(structure: \"shell\", grid: (21, 1, 13), size: (0.1, 0.06), \
         material: \"card\", outline: Svg(file: \"card.svg\", scale: 0.001, {lines}))])"
    );
    let mut scene = Scene::parse(&text).expect("a scene");
    scene.base = folder.into();
    World::new(&scene).expect("a world")
}

#[test]
fn lines_of_the_named_colours_and_layers_are_cuts_and_creases() {
    let folder = std::env::temp_dir().join(format!("sheetwork-svg-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("card.svg"), CARD).expect("a file");
    let both = "cuts: [\"red\"], creases: [(\"folds\", 60)]";
    let mut creased = world(&folder, both);
    let flat = world(&folder, &both.replace("60)", "0)"));
    // The cut doubles the nodes on its 30 mm from the border on, but for its end inside.
    let rows = |world: &World| world.sheets()[0].state.x.iter().filter(|p| p.x.abs() < 1e-9).count();
    assert_eq!(rows(&flat), 13 + 6, "the middle column, doubled along half of it");
    creased.find_equilibrium(1e-9);
    let heights = creased.sheets()[0].state.x.y.iter().fold((0.0_f64, 0.0_f64), |(a, b), y| (a.min(*y), b.max(*y)));
    assert!(heights.1 - heights.0 > 0.01, "the crease stands up: {heights:?}");
    std::fs::remove_dir_all(&folder).expect("removed");
}
