//! A sheet that slides on a sheet, against Coulomb's law in closed form. The lines of the two
//! meshes cross throughout the slide.

use sheetwork::World;
use sheetwork::scene::IntegratorKind;
use sheetwork_rigs::measure::Setup;
use sheetwork_tests::rig::{measured, number};
use sheetwork_tests::shipped_scene;

/// A sheet of card on a fixed sheet.
fn setup(engine: IntegratorKind) -> Setup {
    Setup { engine, grid: (11, 11), length: 0.12, on_sheet: true, ..Setup::default() }
}

const IMPLICIT: [IntegratorKind; 3] = [IntegratorKind::TrBdf2, IntegratorKind::BackwardEuler, IntegratorKind::Bdf2];

#[test]
fn a_sheet_slides_down_a_sheet_with_g_sin_minus_mu_cos() {
    for engine in IMPLICIT {
        for (angle, friction) in [(20.0_f64, 0.3), (35.0, 0.1), (25.0, 0.2), (40.0, 0.75)] {
            let found = measured("incline", &Setup { angle, friction, ..setup(engine) });
            let a = number(&found, "acceleration_m_s2");
            let expected = 9.81 * (angle.to_radians().sin() - friction * angle.to_radians().cos());
            println!("{engine}, {angle}°, {friction}: {a:.5} of {expected:.5} m/s²");
            assert!((a / expected - 1.0).abs() < 0.005, "{engine}, {angle}°, {friction}: {a}, {expected}");
        }
    }
}

#[test]
fn a_sheet_sticks_on_a_sheet_up_to_the_angle_of_friction() {
    // tan 16.699° = 0.3.
    for engine in IMPLICIT {
        for (angle, slides) in [(16.62, false), (16.78, true)] {
            let found = measured("incline", &Setup { angle, friction: 0.3, ..setup(engine) });
            assert_eq!(found["slid"], slides, "{engine}, {angle}°: {found}");
            if !slides {
                let creep = number(&found, "creep_m_s");
                assert!(creep < 1e-8, "{engine}: {creep} m/s");
                assert_eq!(number(&found, "creep_asleep_m_s"), 0.0, "{engine}");
            }
        }
    }
}

#[test]
fn a_sheet_that_slides_on_a_sheet_stops_after_v_squared_over_two_mu_g() {
    let found = measured("slide", &Setup { speed: 1.0, friction: 0.3, ..setup(IntegratorKind::TrBdf2) });
    let (distance, expected) = (number(&found, "distance_m"), 1.0 / (2.0 * 0.3 * 9.81));
    println!("{distance:.5} of {expected:.5} m");
    assert!((distance / expected - 1.0).abs() < 0.005, "{distance}, {expected}");
}

#[test]
fn a_house_of_cards_stands_with_other_integrators_and_steps() {
    // The house stands by friction between cards only, so the friction bound must follow the normal
    // force within a solve.
    for (engine, dt) in [
        (IntegratorKind::Bdf2, 1.0 / 60.0),
        (IntegratorKind::BackwardEuler, 1.0 / 60.0),
        (IntegratorKind::TrBdf2, 1.0 / 30.0),
    ] {
        let mut scene = shipped_scene("cards_house");
        (scene.engine, scene.dt) = (engine, dt);
        let mut world = World::new(&scene).expect("a valid scene");
        let top = |world: &World| world.sheets().iter().flat_map(|s| s.x.iter()).map(|x| x.y).fold(0.0, f64::max);
        let before = top(&world);
        world.advance(3.0);
        let after = top(&world);
        assert!((after - before).abs() < 1e-3, "{engine}, {dt} s: {after} m after {before}");
        assert!(world.is_resting(), "{engine}, {dt} s");
    }
}
