//! Contact of the drawn surface (`contact_surface`): the surface that is drawn stays out of bodies,
//! and the sheet rests, slips and sticks as with contact of its nodes alone.

use sheetwork::World;
use sheetwork::scene::{ContactSurface, IntegratorKind, Scene};
use sheetwork_rigs::drawn_surface::drawn_surfaces;
use sheetwork_tests::{shipped_scene, state_hash, world_of};

/// A shipped scene whose first sheet has this contact surface.
fn scene(name: &str, contact_surface: ContactSurface) -> Scene {
    let mut scene = shipped_scene(name);
    scene.sheets[0].contact_surface = contact_surface;
    scene
}

/// Depth of the drawn bottom layer in bodies, m.
fn depth(world: &World, smoothing: &str) -> f64 {
    let all = drawn_surfaces(world);
    all.iter().find(|s| s.layer == 0 && s.smoothing == smoothing).and_then(|s| s.depth_m).unwrap_or(0.0)
}

/// Depths (m) at the impact and at the end, whether it rests, and the largest gain of energy (J)
/// over an earlier value.
fn drop_on(name: &str, contact_surface: ContactSurface, smoothing: &str) -> (f64, f64, bool, f64) {
    let mut world = World::new(&scene(name, contact_surface)).expect("valid");
    let (mut impact, mut gain, mut least) = (0.0_f64, 0.0_f64, f64::INFINITY);
    for step in 0..1600 {
        world.step();
        if step < 120 && step % 4 == 0 {
            impact = impact.max(depth(&world, smoothing));
        }
        let energy = world.energy().total;
        least = least.min(energy);
        gain = gain.max(energy - least);
    }
    assert!(world.unstable().is_none());
    (impact, depth(&world, smoothing), world.is_resting(), gain)
}

#[test]
fn the_drawn_surface_stays_out_of_a_wedge_and_a_cube() {
    for name in ["wedge", "cube"] {
        for (surface, smoothing) in [(ContactSurface::Smooth, "interpolating"), (ContactSurface::BSpline, "b-spline")] {
            let (impact, end, _, gain) = drop_on(name, ContactSurface::Masses, smoothing);
            let (own_impact, own_end, rests, own_gain) = drop_on(name, surface, smoothing);
            println!(
                "{name}, {smoothing}: contact of the nodes {:.3} mm at impact, {:.3} mm at the end, gain {gain:.2e} J; of the \
                 surface {:.3} mm, {:.3} mm, rests {rests}, gain {own_gain:.2e} J",
                1e3 * impact,
                1e3 * end,
                1e3 * own_impact,
                1e3 * own_end
            );
            assert!(end > 5e-4, "{name}: it sinks without");
            // A tenth of the distance of the layers; a quarter of it at the impact.
            assert!(own_end < 1e-4 && own_impact < 2.5e-4, "{name}, {smoothing}");
            assert!(rests, "{name}, {smoothing}: it does not rest");
            // The sheet falls by 15 mm, 1.4e-4 J.
            assert!(own_gain < gain.max(3e-6), "{name}, {smoothing}");
        }
    }
}

#[test]
fn the_drawn_surface_slips_and_sticks_by_coulombs_law() {
    let slid = |surface: &str, factor: f64| {
        let angle = 0.4_f64.atan() * factor;
        let mut world = world_of(&format!(
            r#"(gravity: ({}, {}, 0), engine: "rk4", dt: 0.002, contact: (friction: 0.4, restitution: 0),
                sheets: [(structure: "slamm", grid: (11, 2, 11), size: (0.025, 0.025), gap: 0.001, material: "thesis",
                    springs: Uniform, inter_layer: SumModulus(185), node_mass: 4e-5, damping: 0.3,
                    placement: (position: (0, 0.0001, 0)), contact_surface: {surface})],
                bodies: [(name: "floor", shape: Box((0.3, 0.02, 0.3)), placement: (position: (0, -0.01, 0)))])"#,
            0.981 * angle.sin(),
            -0.981 * angle.cos(),
        ));
        world.set_sleep(false);
        (0..500).for_each(|_| _ = world.step());
        let from = world.sheets()[0].centre_of_mass().x;
        (0..250).for_each(|_| _ = world.step());
        world.sheets()[0].centre_of_mass().x - from
    };
    for surface in ["Masses", "Smooth", "BSpline"] {
        let (sticks, slips) = (slid(surface, 0.9), slid(surface, 1.1));
        println!("{surface}: {sticks:.2e} m at 0.9, {slips:.2e} m at 1.1 of the angle of friction");
        assert!(sticks.abs() < 1e-5 && slips > 1e-3, "{surface}: {sticks} {slips}");
    }
}

#[test]
fn contact_of_the_drawn_surface_continues_bit_for_bit_from_a_snapshot() {
    for surface in [ContactSurface::Smooth, ContactSurface::BSpline] {
        let mut world = World::new(&scene("wedge", surface)).expect("valid");
        world.set_sleep(false);
        (0..60).for_each(|_| _ = world.step());
        let snapshot = world.snapshot();
        (0..60).for_each(|_| _ = world.step());
        let end = state_hash(&world);
        world.restore(&snapshot).expect("its own");
        (0..60).for_each(|_| _ = world.step());
        assert_eq!(state_hash(&world), end, "{surface:?}");
        // A new world of the same scene, as after a restart.
        let mut other = World::new(&scene("wedge", surface)).expect("valid");
        other.restore(&snapshot).expect("of the same scene");
        other.set_sleep(false);
        (0..60).for_each(|_| _ = other.step());
        assert_eq!(state_hash(&other), end, "{surface:?}");
    }
}

#[test]
fn a_contact_surface_of_unsuitable_sheets_is_rejected_with_the_reason() {
    let refused = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene("wedge", ContactSurface::Smooth);
        change(&mut scene);
        World::new(&scene).map(drop).expect_err("refused").to_string()
    };
    let implicit = refused(&|s| s.engine = IntegratorKind::TrBdf2);
    assert!(implicit.contains("contact_surface") && implicit.contains("explicit"), "{implicit}");
    let mut world = World::new(&scene("wedge", ContactSurface::Smooth)).expect("valid");
    let live = world.set("engine", "tr-bdf2").expect_err("refused").to_string();
    assert!(live.contains("contact_surface") && live.contains("explicit"), "{live}");
    world.set("engine", "rk4").expect("an explicit one");
    let limited = refused(&|s| s.sheets[0].flexion_limit = Some(30.0));
    assert!(limited.contains("contact_surface") && limited.contains("flexion_limit"), "{limited}");
    let opened = refused(&|s| s.sheets[0].slits = vec![((0.2, 0.5), (0.8, 0.5))]);
    assert!(opened.contains("contact_surface") || opened.contains("slits"), "{opened}");
}
