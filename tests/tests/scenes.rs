//! Every shipped scene runs to rest or to its end, without penetration, and shows its effect. The
//! shipped files of sheets, polyhedra and heaters hold what the scenes need.

use glam::DVec3;
use sheetwork::World;
use sheetwork::islands::event::EventKind;
use sheetwork::scene::Scene;
use sheetwork::scene::heater_file::{HeaterFace, read_heaters};
use sheetwork::scene::pol::read_pol;
use sheetwork::scene::sht::read_sht;
use sheetwork::sheet::Status;
use sheetwork_tests::{scenes_folder, shipped_scene, shipped_scene_names};

/// Runs a scene to its end or to rest. Returns the world, and the largest penetration of a node
/// after any step, m.
fn run_scene(name: &str) -> (World, f64) {
    let scene = shipped_scene(name);
    let mut world = World::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    let mut deepest = 0.0_f64;
    while world.time() < scene.duration && !world.is_resting() {
        world.step();
        deepest = deepest.max(world.penetration());
    }
    (world, deepest)
}

/// Time of an event with a body, s.
fn time_of(world: &World, kind: EventKind, body: &str) -> Option<f64> {
    let event = world.events().iter().find(|e| e.kind == kind && e.body.as_deref().unwrap_or("") == body);
    event.map(|e| e.time_s)
}

#[test]
fn every_scene_ends_stable_and_without_penetration() {
    let names = shipped_scene_names();
    assert!(names.len() >= 12, "{names:?}");
    for name in names {
        let (world, deepest) = run_scene(&name);
        let rests = world.is_resting();
        println!(
            "{name:20} {:.2} s, {}, {deepest:.1e} m deep",
            world.time(),
            if rests { "at rest" } else { "still moving" }
        );
        assert!(world.unstable().is_none(), "{name} went unstable");
        assert!(deepest < 1e-4, "{name}: a mass was {deepest} m deep");
        for sheet in world.sheets() {
            assert!(sheet.state.x.iter().chain(sheet.state.v.iter()).all(|p| p.is_finite()), "{name}");
            let falls = world.scene().sheets.iter().all(|s| s.pins.is_empty());
            let met = sheet.state.counters.contacts > 0 || world.sheets().len() > 1;
            assert!(!falls || met, "{name}: {} met nothing", sheet.name);
            // A sheet on the ground that is still awake moves at most at a few centimetres per
            // second. A hanging sheet may swing for long, with the low damping of steel and rubber
            // or in the wind.
            let is_windy = !world.scene().wind_zones.is_empty();
            let bound = if is_windy {
                30.0
            } else if falls {
                0.1
            } else {
                1.0
            };
            assert!(sheet.max_speed() < bound, "{name}: {} still has {} m/s", sheet.name, sheet.max_speed());
            assert!(sheet.state.status == Status::Asleep || !rests, "{name}");
        }
        if let Some(room) = &world.scene().room {
            let lowest = world.sheets().iter().flat_map(|s| s.state.x.y.iter().copied()).fold(f64::INFINITY, f64::min);
            assert!(lowest > room.y.0 - 1e-4, "{name}: through the floor");
        }
    }
}

#[test]
fn the_sheet_falls_on_the_wedge_and_comes_to_rest_bent_over_it() {
    let (world, _) = run_scene("wedge");
    let first = time_of(&world, EventKind::FirstContact, "wedge").expect("it meets the wedge");
    let rest = time_of(&world, EventKind::AtRest, "").expect("it comes to rest");
    assert!(first < rest, "{first} {rest}");
    // The middle rests on the ridge, about a centimetre above the edges.
    let sheet = &world.sheets()[0];
    let height =
        |name: &str| sheet.probes.iter().find(|p| p.name == name).map(|p| p.at(&sheet.state.x).y).expect("a probe");
    assert!(height("centre") - height("corner") > 0.005);
}

#[test]
fn layers_of_no_sheet_collapse() {
    for name in ["wedge", "two_walls", "slide_11", "slide_17"] {
        let (world, _) = run_scene(name);
        let kept = world.sheets()[0].squeezed_to().expect("two layers");
        assert!(kept > 0.25, "{name}: {kept} of the thickness is left");
    }
}

#[test]
fn the_sheet_slides_over_two_bodies_with_four_timed_events() {
    // Thesis tables 5.2 and 5.3: first contact, second contact, slid off, flat on the floor.
    for name in ["slide_8", "slide_11", "slide_14", "slide_17"] {
        let (world, _) = run_scene(name);
        let at = |kind, body| time_of(&world, kind, body).unwrap_or_else(|| panic!("{name}: no {kind:?} {body}"));
        let first = at(EventKind::FirstContact, "first");
        let second = at(EventKind::FirstContact, "second");
        let off = at(EventKind::SlidOff, "second");
        let flat = at(EventKind::Flat, "floor");
        let rest = at(EventKind::AtRest, "");
        println!("{name}: {first:.3} {second:.3} {off:.3} {flat:.3} s, at rest {rest:.3} s");
        assert!(first < second && second < off && off < flat && flat < rest, "{name}");
    }
}

#[test]
fn a_sheet_sticks_on_a_slope_with_friction_and_slips_without() {
    // 40 degrees: tan 40° = 0.84 is below 0.9.
    let (world, _) = run_scene("slope_friction_09");
    assert!(time_of(&world, EventKind::AtRest, "").is_some());
    // The sheet may creep during the oscillations after its fall, but its centre stays well above
    // the floor at y = -28.1 mm.
    let centre = world.sheets()[0].centre_of_mass();
    assert!(centre.x < 0.005 && centre.y > -0.024, "it slid down: {centre}");
    let (world, _) = run_scene("slope_friction_0");
    assert!(time_of(&world, EventKind::SlidOff, "slope").is_some(), "it is still on the slope");
    // The sheet lies on the floor beyond the foot of the ramp at x = 9.3 mm.
    let sheet = &world.sheets()[0];
    assert!(sheet.centre_of_mass().x > 0.0093, "{}", sheet.centre_of_mass());
}

#[test]
fn restitution_makes_the_sheet_bounce() {
    // With a restitution of 0.1 the sheet leaves the floor again: more of its nodes are above the
    // floor 0.05 s after the landing.
    let airborne = |name: &str| {
        let mut world = World::new(&shipped_scene(name)).unwrap_or_else(|e| panic!("{e}"));
        while time_of(&world, EventKind::FirstContact, "floor").is_none() {
            world.step();
        }
        (0..4)
            .map(|_| {
                world.step();
                world.sheets()[0].centre_of_mass().y
            })
            .fold(f64::NEG_INFINITY, f64::max)
    };
    assert!(airborne("flat_floor_e01") > airborne("flat_floor_e0") + 1e-5);
}

/// A bounce within a single step counts as contact, also on a sheet that rests on the floor.
#[test]
fn a_bounce_off_a_sleeping_sheet_counts_as_contact() {
    let text = r#"(
        engine: "tr-bdf2", dt: 0.0166666666666667, duration: 2.2,
        room: (x: (-1, 1), y: (0, 30), z: (-1, 1), back_wall: false), contact: (friction: 0.4, restitution: 0.3),
        sheets: [(name: "sheet", structure: "shell", grid: (15, 1, 15), size: (0.25, 0.25), material: "hips",
            placement: (position: (0, 0.001, 0)))],
        bodies: [(name: "ball", shape: Ball(0.01), mass: 0.01, placement: (position: (0, 20, 0)))],
    )"#;
    let scene = Scene::parse(text).unwrap_or_else(|e| panic!("{e}"));
    let mut world = World::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    while world.time() < scene.duration {
        world.step();
    }
    assert!(time_of(&world, EventKind::AtRest, "").is_some_and(|at| at < 1.9), "it sleeps before the ball comes");
    // √(2 · 20 m/g), to within two steps.
    let first = time_of(&world, EventKind::FirstContact, "ball").expect("the ball meets it");
    assert!((first - (40.0_f64 / 9.81).sqrt()).abs() < 0.04, "{first} s");
    let away = world.body_state("ball").expect("it is there").velocity().y;
    assert!((4.0..7.0).contains(&away), "0.3 of 19.8 m/s, less what it has fallen since: {away} m/s");
}

/// Text of the file `name` of the assets.
fn asset(name: &str) -> String {
    std::fs::read_to_string(scenes_folder().join("..").join(name)).expect("readable")
}

#[test]
fn the_shipped_polyhedra_stand_in_the_room_of_the_thesis() {
    let files = [
        ("polyhedra/wedge.pol", 1),
        ("polyhedra/cube.pol", 1),
        ("polyhedra/hemisphere.pol", 1),
        ("polyhedra/half_cylinder.pol", 1),
        ("polyhedra/upright_cylinder.pol", 1),
        ("polyhedra/slope.pol", 1),
        ("polyhedra/two_walls.pol", 2),
        ("polyhedra/two_bodies.pol", 2),
    ];
    for (file, count) in files {
        let read = read_pol(&asset(file)).expect("good");
        assert_eq!(read.len(), count);
        for polyhedron in read {
            // All polyhedra stand on the floor of the thesis's room and inside it.
            let (low, high) = polyhedron.bounds();
            assert_eq!(low.y, -0.0281);
            assert!(high.y < 0.0025 && low.x > -0.065 && high.x < 0.065 && low.z > -0.0299 && high.z < 0.0333);
        }
    }
}

#[test]
fn the_shipped_sheet_file_is_slamm_at_rest() {
    let sheet = read_sht(&asset("sheets/slamm_5x2x5.sht")).expect("good");
    assert_eq!((sheet.masses.len(), sheet.springs.len()), (41, 153));
    assert_eq!((sheet.structure.as_str(), sheet.dimensions, sheet.damping), ("slamm", [5, 2, 5], 0.115));
    for spring in &sheet.springs {
        let length = sheet.masses[spring.a as usize].position.distance(sheet.masses[spring.b as usize].position);
        assert!((length - spring.rest).abs() < 1e-9 && spring.stiffness == 0.185);
    }
    let corner = |index: usize| sheet.masses[sheet.corners[index] as usize].position;
    assert!((corner(3) - corner(0) - DVec3::new(0.025, 0.0, 0.025)).length() < 1e-9);
    assert!(((corner(0) + corner(3)) / 2.0).distance(sheet.masses[sheet.centre as usize].position) < 1e-9);
}

#[test]
fn the_shipped_heater_panel_glows_downwards() {
    let read = read_heaters(&asset("heaters/panel.heater")).expect("good");
    assert_eq!(read.len(), 1);
    let hot: Vec<usize> = (0..6).filter(|face| read[0].faces[*face].temperature.is_some()).collect();
    assert_eq!(hot.len(), 1);
    assert_eq!(read[0].polyhedron.face_normal(hot[0]), DVec3::NEG_Y);
    assert!((read[0].polyhedron.face_area(hot[0]) - 9e-4).abs() < 1e-12);
    assert_eq!(read[0].faces[hot[0]], HeaterFace::hot(250.0, 0.9));
    assert_eq!(read[0].polyhedron.bounds().0.y, 0.025);
}
