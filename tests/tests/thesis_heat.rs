//! The heat experiments of the thesis (5.2.4): the events of figures 5.8 and 5.9 happen in their
//! order and, to a fifth, at their times, by the criteria of `measure::hot_wedge`. Bodies that warm
//! up: their schedule, and a temperature that falls with height.

use sheetwork::World;
use sheetwork_rigs::measure::hot_wedge::{Wedge, WedgeCriteria, WedgeEvent, figure_5_8, figure_5_9};
use sheetwork_tests::{mean_and_range_of_temperatures, shipped_scene, world_of};

/// Part by which a time may miss that of the thesis.
const TOLERANCE: f64 = 0.2;

fn check(events: &[WedgeEvent]) {
    for event in events {
        println!("{:40} {:6.0?} s, thesis {:?} s", event.name, event.time_s, event.thesis_s);
    }
    for event in events {
        assert!(event.agrees(TOLERANCE), "{}: {:?} s, not {:?} s", event.name, event.time_s, event.thesis_s);
    }
    for pair in events.windows(2) {
        assert!(pair[0].time_s <= pair[1].time_s, "{} comes after {}", pair[0].name, pair[1].name);
    }
}

#[test]
fn styrene_on_the_hot_wedge_follows_figure_5_8() {
    let events = figure_5_8(&shipped_scene("hot_wedge"), &WedgeCriteria::default()).expect("valid");
    assert_eq!(events.len(), 7);
    check(&events);
}

#[test]
fn packaging_pvc_on_the_hot_wedge_follows_figure_5_9() {
    let events = figure_5_9(&shipped_scene("pvc_hot_wedge"), &WedgeCriteria::default()).expect("valid");
    assert_eq!(events.len(), 6);
    check(&events);
}

#[test]
fn the_half_cylinder_deforms_its_sheet_less_than_the_wedge() {
    // Thesis 5.2.4: as on the wedge, with less deformation. After 26 minutes the overhang hides
    // less than half as much of the front.
    let cover = |name: &str| {
        let scene = shipped_scene(name);
        let body = Wedge::of(&scene, WedgeCriteria::default().samples).expect("a polyhedron");
        let mut world = World::new(&scene).expect("valid");
        while world.time() < 1.0 + 26.0 * 60.0 / scene.time_lapse {
            world.step();
        }
        body.observe(&world.sheets()[0]).cover
    };
    let (wedge, cylinder) = (cover("hot_wedge"), cover("hot_half_cylinder"));
    assert!(cylinder > 0.05 && cylinder < 0.5 * wedge, "{cylinder} and {wedge} of the front");
}

/// A strip that lies on a box with the fields `heat`, in a room at 20 °C.
fn lying(heat: &str) -> World {
    world_of(&format!(
        "(engine: \"tr-bdf2\", dt: 0.0166666666666667, duration: 10, time_lapse: 20, contact_conductance: 5000,
            sheets: [(structure: \"shell\", grid: (9, 1, 5), size: (0.08, 0.04), material: \"hips\",
                placement: (position: (0, 0.0003, 0)))],
            bodies: [(name: \"box\", shape: Box((0.1, 0.02, 0.1)), placement: (position: (0, -0.01, 0)), {heat})])"
    ))
}

fn mean(world: &World) -> f64 {
    let celsius = world.sheets()[0].temperatures().expect("it is heated");
    celsius.iter().sum::<f64>() / celsius.len() as f64
}

#[test]
fn a_sheet_follows_the_schedule_of_the_body_it_lies_on() {
    let heat = "temperature_schedule: [(time: 0.5, temperature: 30), (time: 2.5, temperature: 70), (time: 4)]";
    let mut world = lying(heat);
    let at = |world: &mut World, time: f64| {
        while world.time() < time - 1e-9 {
            world.step();
        }
        mean(world)
    };
    assert!((at(&mut world, 0.4) - 20.0).abs() < 1e-6, "no exchange before the first entry");
    // The sheet follows within half a second of thermal time, and loses a little to the air.
    let half = at(&mut world, 1.5);
    assert!((half - 50.0).abs() < 1.0, "{half} °C halfway");
    let parameter = world.get("bodies.box.temperature").expect("live").value.parse::<f64>().expect("a number");
    assert!((parameter - 50.0).abs() < 0.5, "{parameter} °C is shown");
    let last = at(&mut world, 3.5);
    assert!((last - 70.0).abs() < 1.0, "{last} °C after the last temperature");
    let bytes = world.serialise();
    let mut other = lying(heat);
    other.deserialise(&bytes).expect("the same scene");
    assert_eq!(at(&mut world, 5.0), at(&mut other, 5.0), "a restored world follows it to the bit");
    assert!(mean(&world) < 68.0, "it cools where the schedule ends with none: {}", mean(&world));
    // A temperature that is set replaces the schedule.
    world.set("bodies.box.temperature", "40").expect("live");
    let set = at(&mut world, 7.0);
    assert!((set - 40.0).abs() < 0.5, "{set} °C");
}

#[test]
fn the_slope_of_a_body_warms_one_end_of_the_sheet_more() {
    let mut world = lying("temperature: 60, temperature_slope: (250, 0, 0)");
    while world.time() < 2.0 {
        world.step();
    }
    let sheet = &world.sheets()[0];
    let celsius = sheet.temperatures().expect("it is heated");
    for (celsius, place) in celsius.iter().zip(sheet.state.x.iter()) {
        let wanted = 60.0 + 250.0 * place.x;
        assert!((celsius - wanted).abs() < 0.8, "{celsius} °C at {place}, not {wanted}");
    }
}

#[test]
fn a_slope_does_not_lead_below_absolute_zero() {
    let mut world = lying("temperature: 60, temperature_slope: (1e5, 0, 0)");
    while world.time() < 2.0 {
        world.step();
        let (_, least, most) = mean_and_range_of_temperatures(&world.sheets()[0]);
        assert!(least >= -273.15 && most <= 5000.0, "{least} to {most} °C");
    }
}
