//! Sheets that start inside a body or another sheet: refused with the pair, the place and the
//! depth, or moved out with `repair`.

use sheetwork::World;
use sheetwork::collision::overlap::half_thickness;
use sheetwork::scene::Scene;

const BOX: &str = "(name: \"block\", shape: Box((0.1, 0.1, 0.1)))";
const BALL: &str = "(name: \"block\", shape: Ball(0.05))";

/// A sheet of 0.2 m at a height (m), with more fields.
fn sheet(height: f64, more: &str) -> String {
    format!(
        "(structure: \"shell\", grid: (11, 1, 11), size: (0.2, 0.2), material: \"hips\", \
         placement: (position: (0, {height}, 0)), {more}),"
    )
}

fn scene(sheets: &[String], body: &str, repair: bool) -> Scene {
    let text = format!(
        "(engine: \"tr-bdf2\", dt: 0.016666666666666666, duration: 1, repair: {repair}, sheets: [{}], bodies: [{body}], \
         room: (x: (-1, 1), y: (-0.2, 1), z: (-1, 1), back_wall: false))",
        sheets.concat()
    );
    Scene::parse(&text).expect("a scene")
}

fn refusal(scene: &Scene) -> String {
    World::new(scene).err().expect("starts inside").to_string()
}

#[test]
fn a_sheet_that_starts_in_a_body_is_refused_with_pair_depth_and_place() {
    for body in [BOX, BALL] {
        let error = refusal(&scene(&[sheet(0.048, "")], body, false));
        for part in ["sheets.0.placement", "body \"block\"", "2.000e-3 m deep", "near (", "0.0480"] {
            assert!(error.contains(part), "{error}");
        }
    }
    let error = refusal(&scene(&[sheet(-0.203, "")], "", false));
    assert!(error.contains("3.000e-3 m deep"), "{error}");
}

#[test]
fn sheets_that_start_in_the_same_place_or_through_each_other_are_refused() {
    let through = sheet(0.0, "").replace("0, 0, 0)", "0, 0, 0), rotation: (90, 0, 0)");
    for other in [sheet(0.0, ""), through] {
        let error = refusal(&scene(&[sheet(0.0, ""), other], "", false));
        assert!(error.contains("sheets.1.placement") && error.contains("inside sheet"), "{error}");
    }
}

#[test]
fn a_sheet_may_start_in_contact_and_with_held_nodes_in_a_body() {
    World::new(&scene(&[sheet(0.05, ""), sheet(0.0501, "")], BOX, false)).expect("in contact");
    World::new(&scene(&[sheet(0.0, "pins: [(region: All)]")], BOX, false)).expect("held");
}

#[test]
fn repair_moves_sheets_out_to_contact_by_the_shortest_way() {
    let sheets = [sheet(0.048, ""), sheet(0.048, ""), sheet(0.048, "")];
    let mut world = World::new(&scene(&sheets, BOX, true)).expect("repaired");
    let heights: Vec<f64> = world.sheets().iter().map(|s| s.centre_of_mass().y).collect();
    let half = half_thickness(&world.sheets()[0]);
    for (k, height) in heights.iter().enumerate() {
        let wanted = 0.05 + half * (2 * k + 1) as f64;
        assert!((height - wanted).abs() < 1e-9, "{heights:?}");
    }
    world.advance(0.5);
    assert!(world.penetration() < 0.1 * half && world.unstable().is_none());
    assert!(world.sheets().iter().all(|s| s.max_speed() < 0.5));
    assert!(world.sheets()[2].centre_of_mass().y > 0.03);
}

#[test]
fn repair_says_what_it_cannot_do() {
    let held = sheet(0.0, "pins: [(region: Left)]");
    assert!(refusal(&scene(&[held], BOX, true)).contains("held nodes"));
}
