//! Cuts of a running sheet.

use glam::DVec3;
use sheetwork::scene::Scene;
use sheetwork::{SheetId, World};
use sheetwork_tests::state_hash;

/// A sheet pinned at its left edge, hanging in the air; `more` are further fields.
fn hanging(more: &str) -> (World, SheetId) {
    let scene = format!(
        r#"(sheets: [(name: "card", size: (0.2, 0.1), material: "card", placement: (position: (0, 1, 0)),
            pins: [(region: Left)], {more})])"#
    );
    let world = World::new(&Scene::parse(&scene).expect("a scene")).expect("a world");
    let id = world.sheet_id("card").expect("there");
    (world, id)
}

const SHELL: &str = r#"structure: "shell", grid: (11, 1, 6)"#;

/// Heights of the ends of the middle row, m.
fn ends(world: &World) -> [f64; 2] {
    let sheet = &world.sheets()[0];
    let nearest = |place: (f64, f64)| {
        let apart = |i: &usize| (sheet.model.uv[*i].0 - place.0).hypot(sheet.model.uv[*i].1 - place.1);
        let node = (0..sheet.node_count()).min_by(|a, b| apart(a).total_cmp(&apart(b))).expect("nodes");
        sheet.state.x.get(node).y
    };
    [nearest((0.0, 0.5)), nearest((1.0, 0.5))]
}

#[test]
fn the_part_beyond_a_cut_falls_and_the_other_stays() {
    let outline = r#"structure: "shell", grid: (11, 1, 6), outline: Disc(radius: 0.05)"#;
    let lattice = r#"structure: "trimm", grid: (11, 2, 6)"#;
    for more in [SHELL, outline, lattice] {
        let (mut world, id) = hanging(more);
        world.advance(0.1);
        let opened = world.cut(id, (0.5, 0.0), (0.5, 1.0)).expect("crosses the sheet");
        assert!(opened >= 5, "{opened}");
        assert_eq!(world.sheets()[0].open_count(), opened);
        assert_eq!(world.cut(id, (0.5, 0.0), (0.5, 1.0)), Ok(0), "already open");
        world.advance(0.7);
        let [held, free] = ends(&world);
        assert!(held > 0.99 && free < 0.0, "{held} and {free} m: {more}");
        assert!(world.unstable().is_none() && world.energy().total.is_finite());
    }
}

#[test]
fn a_cut_changes_no_position_and_no_momentum() {
    let (mut world, id) = hanging(SHELL);
    world.advance(0.2);
    let state =
        |world: &World| (world.sheets()[0].state.x.iter().collect::<Vec<DVec3>>(), world.sheets()[0].momentum());
    let before = state(&world);
    world.cut(id, (0.55, 0.0), (0.55, 1.0)).expect("crosses the sheet");
    assert_eq!(state(&world), before);
}

#[test]
fn snapshots_hold_the_cuts_of_their_time() {
    let (mut world, id) = hanging(SHELL);
    world.advance(0.1);
    let whole = world.serialise();
    let light = world.snapshot();
    world.advance(0.2);
    let never_cut = state_hash(&world);
    world.deserialise(&whole).expect("its own");
    world.cut(id, (0.5, 0.0), (0.5, 0.7)).expect("crosses the sheet");
    world.advance(0.1);
    let cut = world.serialise();
    world.advance(0.1);
    let end = state_hash(&world);
    world.deserialise(&cut).expect("its own");
    world.advance(0.1);
    assert_eq!(state_hash(&world), end, "continues bit for bit");
    world.deserialise(&whole).expect("its own");
    assert_eq!(world.sheets()[0].open_count(), 0);
    world.advance(0.2);
    assert_eq!(state_hash(&world), never_cut, "as if it had never been cut");
    let (mut other, _) = hanging(SHELL);
    other.deserialise(&cut).expect("of the same scene");
    other.advance(0.1);
    assert_eq!(state_hash(&other), end);
    other.restore(&light).expect("of the same sheets");
    assert_eq!(other.sheets()[0].open_count(), 0);
    other.reset().expect("valid");
    assert!(!other.sheets()[0].can_open());
}

#[test]
fn bad_cuts_are_refused_and_change_nothing() {
    let (mut world, id) = hanging(SHELL);
    let hash = state_hash(&world);
    for (from, to, field) in
        [((0.5, 0.5), (0.5, 0.5), "to"), ((f64::NAN, 0.0), (0.5, 1.0), "from.0"), ((0.0, 0.0), (1.0, 2.0), "to.1")]
    {
        let problem = world.cut(id, from, to).expect_err("refused");
        assert_eq!(problem.field, field, "{problem}");
    }
    let hole = r#"structure: "shell", grid: (21, 1, 11), holes: [Disc(centre: (0, 0), radius: 0.03)]"#;
    let (mut holed, holed_id) = hanging(hole);
    let problem = holed.cut(holed_id, (0.48, 0.48), (0.52, 0.52)).expect_err("in the hole");
    assert!(problem.to_string().contains("crosses no cell"), "{problem}");
    assert_eq!(state_hash(&world), hash);
    assert!(world.remove_sheet(id));
    world.cut(id, (0.0, 0.0), (1.0, 1.0)).expect_err("removed");
}
