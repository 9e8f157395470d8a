//! A scene of another size moves alike: lengths and moduli times s, times and speeds times √s,
//! densities and gravity unchanged. All forces then scale by s³, and every position by s.

use glam::DVec3;
use sheetwork::World;
use sheetwork::scene::Scene;

/// Largest difference of positions of the scene of size 1, m: rounding, which contact amplifies.
const TOLERANCE: f64 = 1e-6;

/// Positions of all nodes after the scaled `seconds` of a scene, in units of the scale. In `text`,
/// `L(x)` is a length, `T(x)` a time and `E(x)` a modulus of the scene of size 1.
fn positions(text: &str, seconds: f64, s: f64) -> Vec<DVec3> {
    let mut scaled = text.to_owned();
    for (unit, factor) in [("L(", s), ("T(", s.sqrt()), ("E(", s)] {
        while let Some(at) = scaled.find(unit) {
            let end = at + scaled[at..].find(')').expect("closed");
            let numbers = scaled[at + 2..end].split(',').map(|n| n.trim().parse::<f64>().expect("a number") * factor);
            let numbers: Vec<String> = numbers.map(|n| format!("{n:?}")).collect();
            scaled.replace_range(at..=end, &numbers.join(", "));
        }
    }
    let scene = Scene::parse(&scaled).unwrap_or_else(|error| panic!("{error}\n{scaled}"));
    let mut world = World::new(&scene).expect("starts apart");
    world.advance(seconds * s.sqrt());
    assert_eq!(world.report(0.0, &[]).status, "ok");
    world.sheets().iter().flat_map(|sheet| sheet.state.x.iter().collect::<Vec<_>>()).map(|x| x / s).collect()
}

/// Assert that a scene of these sheets and bodies moves alike from 0.01 to 100 times its size.
fn assert_scales((step, friction): (f64, f64), sheets: &str, bodies: &str, seconds: f64) {
    let text = &format!(
        "(engine: \"tr-bdf2\", dt: T({step}), contact: (friction: {friction}, restitution: 0), \
         sheets: [{sheets}], bodies: [(name: \"floor\", shape: HalfSpace), {bodies}])"
    );
    let expected = positions(text, seconds, 1.0);
    let start = positions(text, 0.0, 1.0);
    assert!(expected.iter().zip(&start).any(|(x, y)| x.distance(*y) > 0.02), "it moves");
    for s in [0.25, 64.0, 0.01, 7.0, 100.0] {
        let found = positions(text, seconds, s);
        let error = found.iter().zip(&expected).map(|(x, y)| x.distance(*y)).fold(0.0, f64::max);
        println!("s = {s}: largest difference {error:.2e} m of the scene of size 1");
        assert!(error < TOLERANCE, "s = {s}: {error:.2e} m");
    }
}

/// A sheet of the shell of this modulus, placed so. Its damping has a time that scales with the
/// sheet, as the relaxation times of a loss factor do not.
fn sheet(name: &str, young: &str, place: &str) -> String {
    format!(
        "(name: \"{name}\", structure: \"shell\", grid: (9, 1, 8), size: (L(0.2, 0.17)), material: (young: E({young}), \
         poisson: 0.3, density: 1000, thickness: L(5e-4), damping_ratio: 0.16), placement: ({place}))"
    )
}

#[test]
fn a_sheet_on_a_led_box() {
    let sheet = sheet("p", "3e7", "position: (L(0.01, 0.12, 0.005)), rotation: (4, 7, 11)");
    let led = r#"(name: "box", shape: Box((L(0.08, 0.1, 0.06))), placement: (position: (L(0, 0.05, 0))),
        path: [(time: 0), (time: T(1), offset: (L(0.05, 0, 0)))])"#;
    assert_scales((0.00833333333333, 0.4), &sheet, led, 0.6);
}

#[test]
fn two_sheets_on_a_floor() {
    let low = sheet("low", "3e7", "position: (L(0, 0.02, 0)), rotation: (3, 0, 5)");
    let high = sheet("high", "1e8", "position: (L(0.03, 0.06, 0.02)), rotation: (-4, 20, 2)");
    assert_scales((0.01, 0.4), &format!("{low}, {high}"), "", 0.3);
}

#[test]
fn a_sheet_pushed_over_the_floor_by_its_edge() {
    let sheet = sheet("p", "3e9", "position: (L(0, 2.5e-4, 0))");
    let block = r#"(name: "block", shape: Box((L(0.02, 0.04, 0.2))), placement: (position: (L(-0.112, 0.02, 0))),
        path: [(time: 0), (time: T(1), offset: (L(0.1, 0, 0)))])"#;
    assert_scales((0.01, 0.3), &sheet, block, 0.5);
}
