//! Self-contact: folds with prescribed motion do not interpenetrate.

use glam::DVec3;
use sheetwork::collision::geometry::triangles_intersect;
use sheetwork::scene::Scene;
use sheetwork_tests::world;

const COLUMNS: usize = 31;
const ROWS: usize = 7;

/// A strip of paper whose right end is moved over and around its fixed left end, and released
/// there.
const FOLDED_STRIP: &str = r#"(
    engine: "tr-bdf2", dt: 0.0166666666666667, duration: 3,
    room: (x: (-0.3, 0.3), y: (-0.05, 0.3), z: (-0.3, 0.3), back_wall: false), contact: (friction: 0.3, restitution: 0),
    sheets: [(name: "strip", structure: "shell", grid: (31, 1, 7), size: (0.3, 0.06), material: "paper",
        pins: [(region: Left, until: 2), (region: Right, until: 2, path: [(time: 0), (time: 0.5, offset: (-0.15, 0.08, 0)),
            (time: 1.0, offset: (-0.29, 0.03, 0)), (time: 1.5, offset: (-0.31, -0.02, 0))])])],
)"#;

/// Triangles of the cells in these columns.
fn triangles(columns: std::ops::Range<usize>, x: &impl Fn(usize) -> DVec3) -> Vec<[DVec3; 3]> {
    let cells = (0..ROWS - 1).flat_map(|j| columns.clone().map(move |i| j * COLUMNS + i));
    cells.flat_map(|q| [[q, q + 1, q + COLUMNS], [q + 1, q + COLUMNS + 1, q + COLUMNS]]).map(|t| t.map(x)).collect()
}

#[test]
fn a_strip_moved_around_its_own_end_does_not_interpenetrate() {
    let scene = Scene::parse(FOLDED_STRIP).unwrap_or_else(|e| panic!("{e}"));
    let mut world = world(&scene);
    let mut nearest = f64::INFINITY;
    while world.time() < scene.duration {
        world.step();
        let sheet = &world.sheets()[0];
        let x = |i: usize| sheet.state.x.get(i);
        let (first, last) = (triangles(0..3, &x), triangles(COLUMNS - 8..COLUMNS - 1, &x));
        let cuts = first.iter().flat_map(|p| last.iter().filter(|q| triangles_intersect(*p, **q))).count();
        assert_eq!(cuts, 0, "at {} s", world.time());
        nearest = nearest
            .min((0..ROWS).map(|j| x(j * COLUMNS).distance(x(j * COLUMNS + COLUMNS - 3))).fold(nearest, f64::min));
    }
    assert!(world.unstable().is_none());
    let work = world.report(0.0, &[]).sheets[0].contact_work;
    assert_eq!(work.given_up, 0, "{work:?}");
    // The ends have met.
    assert!(work.contacts > 1000 && nearest < 0.02, "{nearest} m, {work:?}");
}
