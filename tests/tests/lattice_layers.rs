//! Layers of lattices. Stiffness of the springs between them (thesis 2.7, 3.3, 3.4, 6.5): droop,
//! thickness after a landing, and the parameter of a running world. Explicit lattices that lie on
//! one another: order, thickness and work.

use sheetwork::World;
use sheetwork::scene::Scene;
use sheetwork::sheet::inter_layer;
use sheetwork_tests::shipped_scene;

/// World of `scene` with these fields.
fn world(scene: Scene, fields: &[(&str, &str)]) -> World {
    let set = |scene: Scene, (path, value): &(&str, &str)| scene.with_override(path, value).expect("valid");
    World::new(&fields.iter().fold(scene, set)).expect("valid")
}

/// Distance of the layers (of 1 mm at rest) after `seconds`.
fn thickness_after(world: &mut World, seconds: f64) -> f64 {
    world.advance(seconds);
    assert!(world.unstable().is_none());
    inter_layer::distance(&world.sheets()[0]).expect("two layers") / 0.001
}

#[test]
fn layers_recover_from_a_flat_landing() {
    // Figure 5.10: the upper layer returns to its place above the lower one. Its weight compresses
    // the springs: with Σ K cos θ = 1.16 N/m by 3.10a and 3.11 and cos θ = 0.57, a node of 0.04
    // g under 0.981 m/s² by 3.9e-5 N/0.65 N/m = 6 % to first order, and 9 % with the flatter
    // springs.
    for name in ["flat_floor_e0", "flat_floor_e01", "slide_11", "slide_14", "slide_17"] {
        let thickness = thickness_after(&mut world(shipped_scene(name), &[]), 3.0);
        assert!((0.9..1.0).contains(&thickness), "{name}: {thickness}");
    }
}

#[test]
fn layers_as_stiff_as_the_planar_springs_snap_through_on_landing() {
    // The load at which three springs of 0.185 N/m snap through is about the weight of their node.
    let fields = [("sheets.0.inter_layer", "Planar")];
    let thickness = thickness_after(&mut world(shipped_scene("flat_floor_e0"), &fields), 3.0);
    assert!(thickness < 0.55, "{thickness}: at the limit of the thickness");
}

#[test]
fn a_stiffness_set_in_a_run_raises_the_layers_and_outlasts_the_modulus() {
    let fields = [("sheets.0.inter_layer", "Planar")];
    let mut world = world(shipped_scene("flat_floor_e0"), &fields);
    thickness_after(&mut world, 1.0);
    let path = "sheets.sheet.inter_layer_stiffness";
    assert_eq!(world.set(path, "1.2 N/m").expect("valid"), "none");
    let raised = thickness_after(&mut world, 2.0);
    assert!((0.9..1.0).contains(&raised), "{raised}");
    world.set("sheets.sheet.material.young", "150").expect("valid");
    let between = |world: &World| inter_layer::stiffness(&world.sheets()[0]).expect("two layers");
    assert!((between(&world) - 1.2).abs() < 1e-12);
    assert_eq!(world.set(path, "none").expect("valid"), "1.2");
    assert!((between(&world) - 0.15).abs() < 1e-12);
    let saved = {
        world.set(path, "0.7").expect("valid");
        world.serialise()
    };
    world.set(path, "none").expect("valid");
    world.deserialise(&saved).expect("its own bytes");
    assert_eq!(world.get(path).expect("known").value, "0.7");
    let refused = world.set(path, "0").expect_err("out of range").to_string();
    assert!(refused.contains("N/m") && refused.contains("1e-9"), "{refused}");
}

#[test]
fn a_cantilever_droops_less_with_stiffer_springs_between_its_layers() {
    let droop = |ratio: f64| {
        let stiffness = (18.5 * ratio).to_string();
        let fields = [
            ("engine", "\"tr-bdf2\""),
            ("dt", "0.016"),
            ("gravity.1", "-0.0981"),
            ("room", "none"),
            ("sheets.0.material.young", "18500"),
            ("sheets.0.inter_layer_stiffness", &*stiffness),
            ("sheets.0.pins", "[(region: Left)]"),
            ("sheets.0.probes", "{\"tip\": (1, 0.5)}"),
        ];
        let mut world = world(shipped_scene("flat_floor_e0"), &fields);
        world.advance(8.0);
        let sheet = &world.sheets()[0];
        0.0025 - sheet.probes[0].at(&sheet.state.x).y
    };
    let found = [0.2, 1.0, 10.0].map(droop);
    assert!(found[0] > 1.1 * found[1] && found[1] > 1.03 * found[2], "{found:?}");
    // Rigid springs between layers leave the bending of the layers' own springs.
    assert!(found[2] > 0.004, "{found:?}");
}

#[test]
fn a_sheet_without_such_springs_rejects_the_stiffness() {
    let refused = |fields: &[(&str, &str)], parts: &[&str]| {
        let mut scene = Ok(shipped_scene("cantilever_sheet"));
        for (path, value) in fields {
            scene = scene.and_then(|s: Scene| s.with_override(path, value));
        }
        let error = scene.map(drop).expect_err("not valid").to_string();
        parts.iter().for_each(|part| assert!(error.contains(part), "{error}"));
    };
    refused(&[("sheets.0.inter_layer_stiffness", "1")], &["inter_layer_stiffness", "two layers", "shell"]);
    refused(&[("sheets.0.inter_layer", "SumModulus(185)")], &["inter_layer:", "two layers", "shell"]);
    let lattice = [("sheets.0.structure", "\"samm\""), ("sheets.0.grid", "(9, 2, 9)")];
    let with = |last| [lattice[0], lattice[1], last];
    refused(&with(("sheets.0.inter_layer_stiffness", "1")), &["springs: Uniform", "Calibrated"]);
    refused(&with(("sheets.0.inter_layer", "Modulus(1e9)")), &["inter_layer:", "springs: Uniform"]);
    refused(&with(("sheets.0.inter_layer", "Modulus(-3)")), &["-3 Pa"]);
    let mut running = world(shipped_scene("cantilever_sheet"), &[]);
    let error = running.set("sheets.0.inter_layer_stiffness", "1").expect_err("a shell").to_string();
    assert!(error.contains("springs between layers"), "{error}");
}

/// Two lattices of the thesis, the upper one of `upper` m, dropped on one another above the floor.
fn dropped(structure: &str, inter_layer: &str, upper: f64) -> World {
    let sheet = |(name, size, height): (&str, f64, f64)| {
        format!(
            r#"(name: "{name}", structure: "{structure}", grid: (11, 2, 11), size: ({size}, {size}), material: "thesis",
                springs: Uniform, inter_layer: {inter_layer}, node_mass: 4e-5, placement: (position: (0, {height}, 0))),"#
        )
    };
    let sheets: String = [("lower", 0.025, 0.008), ("upper", upper, 0.018)].map(sheet).concat();
    let text = format!(
        r#"(gravity: (0, -0.981, 0), engine: "euler-richardson", dt: 0.005,
            room: (x: (-0.065, 0.065), y: (0, 0.06), z: (-0.03, 0.033)), contact: (friction: 0.3, restitution: 0.1),
            air: (factor: 0.97, per: 0.015), sheets: [{sheets}])"#
    );
    World::new(&Scene::parse(&text).expect("valid")).expect("valid")
}

#[test]
fn lattices_dropped_on_one_another_keep_their_layers_and_their_order() {
    for (structure, inter_layer, upper) in [
        ("trimm", "Planar", 0.025),
        ("trimm", "SumModulus(185)", 0.025),
        ("trimm", "SumModulus(185)", 0.02),
        ("samm", "SumModulus(185)", 0.025),
    ] {
        let case = format!("{structure}, {inter_layer}, {upper} m");
        let mut world = dropped(structure, inter_layer, upper);
        world.advance(3.0);
        assert!(world.sheets().iter().all(|s| s.max_speed() < 1e-3), "{case}: at rest");
        let mut below = 0.0;
        for sheet in world.sheets() {
            // The limit of the thickness is a half, which the weight of four layers reaches.
            let thickness = inter_layer::distance(sheet).expect("two layers") / 0.001;
            assert!((0.48..1.0).contains(&thickness), "{case}, {}: {thickness}", sheet.name);
            for layer in &sheet.model.layers {
                // Without the outer rows, which overhang the upper layer of the lower sheet and
                // droop.
                let inner = || layer.range().map(|i| sheet.state.x.get(i)).filter(|p| p.x.abs().max(p.z.abs()) < 0.009);
                let mean = inner().map(|p| p.y).sum::<f64>() / inner().count() as f64;
                assert!(mean > below, "{case}, {}: {mean} m is not above {below} m", sheet.name);
                below = mean;
            }
        }
        // Those rows of an equal sheet reach the floor.
        let meets_floor =
            |name: &str| world.events().iter().any(|e| e.sheet == name && e.body.as_deref() == Some("floor"));
        assert!(meets_floor("lower") && (upper == 0.025 || !meets_floor("upper")), "{case}");
    }
}
