//! Creep, with and without plasticity: compliance in time, its shift with temperature, permanent
//! shapes and energy.
//!
//! Expected numbers are Burgers' creep compliance by hand.

use glam::DVec3;
use sheetwork::World;
use sheetwork::integrators::TABLE;
use sheetwork::mesh::outline::OutlineSpec;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{
    BurgersCreep, CreaseSpec, IntegratorKind, Material, MaterialChoice, PinSpec, Placement, Region, Scene, Shape,
    SheetSpec, SpringLaw,
};
use sheetwork_rigs::measure::{Setup, Thermal};
use sheetwork_tests::card::{card, rejection};
use sheetwork_tests::rig::{measured, number};
use sheetwork_tests::{body, excite_randomly, state_hash, world};

#[test]
fn creep_follows_burgers_compliance_on_every_structure() {
    let base = Setup { grid: (11, 7), ..Setup::default() };
    let lattice = Setup { structure: StructureKind::DoubleDiagonal, ..base.clone() };
    let triangles = Setup { outlined: true, ..base.clone() };
    let soft = Setup { structure: StructureKind::Trimm, ..base.clone() };
    for setup in [base.clone(), triangles, lattice, soft] {
        let found = measured("creep", &setup);
        println!("{}: {}", found["structure"], found["largest_error"]);
        // 1 + 10/10 + 0.5 (1 - e^-10).
        assert!((number(&found, "expected_compliance") - 2.499_977_3).abs() < 1e-7);
        assert!(number(&found, "largest_error") < 5e-4, "{found}");
    }
    // A dashpot alone creeps at its rate in steps of any length.
    let mut alone = Setup { dt: Some(1.0), ..base };
    alone.material.burgers = Some(BurgersCreep { relaxation_time: 0.2, retardation_time: 1.0, retarded: 0.0 });
    assert!(number(&measured("creep", &alone), "largest_error") < 1e-4);
}

#[test]
fn dynamic_creep_equals_quasi_static_creep_up_to_inertia() {
    let thermal = Thermal { seconds: Some(4.0), ..Thermal::default() };
    // Kelvin-Voigt damping: arms of a loss factor would add to the compliance at 4 s.
    let setup = Setup { grid: (11, 7), thermal, dynamic: true, damping_ratio: 0.2, ..Setup::default() };
    let found = measured("creep", &setup);
    println!("dynamic creep: {} {}", found["compliance_error"], found["largest_error"]);
    assert!(number(&found, "compliance_error").abs() < 5e-3, "{found}");
}

#[test]
fn temperature_shifts_creep() {
    let setup = |celsius: f64| {
        let material = sheetwork::scene::material::by_name("hips").expect("there");
        let thermal = Thermal { seconds: Some(60.0), celsius: Some(celsius), ..Thermal::default() };
        Setup { grid: (11, 5), thermal, material, ..Setup::default() }
    };
    // log10 a_T = -17.44 · 40/91.6; 1e9 s become 24.23 s and 1e8 s 2.423 s: 1 + 60/24.23 + 0.5.
    let hot = measured("creep", &setup(140.0));
    assert!((number(&hot, "compliance") - 3.976).abs() < 0.01, "{hot}");
    assert!((number(&measured("creep", &setup(20.0)), "compliance") - 1.0).abs() < 1e-9);
}

/// A polystyrene sheet fixed at two edges, with a relaxation time of 2.4 s at 140 °C.
fn held(engine: IntegratorKind) -> Scene {
    let mut scene = card((11, 7));
    let hips = sheetwork::scene::material::by_name("hips").expect("there");
    let burgers = Some(BurgersCreep { relaxation_time: 1e8, retardation_time: 1e7, retarded: 0.5 });
    let sheet = &mut scene.sheets[0];
    // Without expansion, because shrinkage on cooling would tighten it between its edges.
    sheet.material = MaterialChoice::Inline(Material { burgers, expansion: 0.0, ..hips });
    sheet.pins = vec![PinSpec::fixed(Region::Left), PinSpec::fixed(Region::Right)];
    sheet.creep = true;
    sheet.temperature = Some(20.0);
    scene.gravity = DVec3::new(0.0, -9.81, 0.0);
    scene.engine = engine;
    scene
}

#[test]
fn a_hot_sag_remains_when_cold() {
    let mut world = world(&held(IntegratorKind::TrBdf2));
    let sag = |world: &World| -world.sheets()[0].state.x.get(3 * 11 + 5).y;
    let energy = |world: &World| world.sheets()[0].energy(DVec3::new(0.0, -9.81, 0.0)).total;
    world.advance(2.0);
    let mut highest = energy(&world);
    let stiff = sag(&world);
    // 20 to 140 °C and back, 4 K per step.
    let path = (0..30).map(|k| 24.0 + 4.0 * f64::from(k)).chain((0..1200).map(|_| 140.0));
    let path = path.chain((0..30).map(|k| 136.0 - 4.0 * f64::from(k)));
    let mut hot = 0.0;
    for celsius in path {
        world.set("sheets.card.temperature", &celsius.to_string()).expect("a temperature");
        world.step();
        let now = energy(&world);
        assert!(now <= highest + 1e-9, "{celsius} °C: {now} J after {highest} J");
        highest = now;
        hot = if celsius >= 140.0 { sag(&world) } else { hot };
    }
    let cold = sag(&world);
    world.set_gravity(DVec3::ZERO).expect("in range");
    world.advance(4.0);
    let kept = sag(&world);
    println!("sag {stiff:.5} stiff, {hot:.5} hot, {cold:.5} cold, {kept:.5} without load");
    assert!(hot > 2.0 * stiff, "{hot} after {stiff}");
    assert!((cold / hot - 1.0).abs() < 0.01, "{cold} after {hot}");
    assert!((kept / cold - 1.0).abs() < 0.05, "{kept} after {cold}");
}

#[test]
fn a_creeping_sheet_does_not_fall_asleep() {
    let mut scene = held(IntegratorKind::TrBdf2);
    scene.sheets[0].temperature = Some(125.0);
    scene.sheets[0].damping_ratio = Some(0.5);
    let mut world = World::new(&scene).expect("valid");
    world.advance(3.0);
    let sag = |world: &World| -world.sheets()[0].state.x.get(3 * 11 + 5).y;
    let before = sag(&world);
    world.advance(3.0);
    assert!(sag(&world) > before + 1e-8, "{} after {before}", sag(&world));
    world.set("sheets.card.temperature", "20").expect("a temperature");
    world.advance(3.0);
    assert!(world.sheets()[0].state.status == sheetwork::sheet::Status::Asleep);
}

#[test]
fn hot_sheets_gain_no_energy_with_any_implicit_integrator_and_structure() {
    for engine in TABLE.iter().filter(|e| e.implicit) {
        for structure in [StructureKind::Shell, StructureKind::DoubleDiagonal] {
            let mut scene = held(engine.kind);
            let sheet = &mut scene.sheets[0];
            sheet.structure = structure;
            sheet.springs = SpringLaw::Calibrated;
            sheet.grid.1 = if structure == StructureKind::Shell { 1 } else { 2 };
            sheet.temperature = Some(130.0);
            sheet.damping_ratio = Some(0.02);
            scene.gravity = DVec3::ZERO;
            let mut world = world(&scene);
            let still: Vec<usize> =
                (0..world.sheets()[0].node_count()).filter(|i| world.sheets()[0].is_held(*i)).collect();
            excite_randomly(&mut world.sheets_mut()[0], 0.5, 5);
            still.iter().for_each(|i| world.sheets_mut()[0].state.v.set(*i, DVec3::ZERO));
            let energy = |world: &World| world.sheets()[0].energy(DVec3::ZERO).total;
            let mut before = energy(&world);
            let start = before;
            for step in 0..180 {
                world.step();
                let now = energy(&world);
                assert!(now <= before + 1e-3 * start, "{} {structure}, step {step}: {now} after {before}", engine.name);
                before = now;
            }
            assert!(world.unstable().is_none());
        }
    }
}

#[test]
fn a_sheet_formed_hot_over_a_ball_keeps_its_shape_cold() {
    let mut scene = held(IntegratorKind::TrBdf2);
    let sheet = &mut scene.sheets[0];
    let hips = sheet.material.resolve("".as_ref()).expect("there");
    // A relaxation time of 0.24 s at 140 °C.
    let burgers = Some(BurgersCreep { relaxation_time: 1e7, retardation_time: 1e6, retarded: 0.5 });
    sheet.material = MaterialChoice::Inline(Material { burgers, ..hips });
    sheet.size = (0.2, 0.2);
    sheet.grid = (13, 1, 13);
    sheet.pins.clear();
    sheet.damping_ratio = Some(0.2);
    sheet.placement.position.y = 0.0505;
    scene.bodies = vec![body("mould", Shape::Ball(0.05), Placement::default(), Vec::new())];
    scene.contact.friction = 0.6;
    let mut world = world(&scene);
    let sag = |world: &World| {
        let x = &world.sheets()[0].state.x;
        let corners = [0, 12, 156, 168].map(|i| x.get(i).y);
        x.get(84).y - 0.25 * corners.iter().sum::<f64>()
    };
    let energy = |world: &World| world.sheets()[0].energy(DVec3::new(0.0, -9.81, 0.0)).total;
    world.advance(1.0);
    let stiff = sag(&world);
    // Energy of the depenetration that contact allows in a step, 0.1 mm.
    let lift = 1e-4 * 9.81 * world.sheets()[0].total_mass();
    let (start, mut before) = (energy(&world), energy(&world));
    let path = (0..60).map(|k| 22.0 + 2.0 * f64::from(k)).chain((0..480).map(|_| 140.0));
    for celsius in path.chain((0..60).map(|k| 138.0 - 2.0 * f64::from(k))) {
        world.set("sheets.card.temperature", &celsius.to_string()).expect("a temperature");
        world.step();
        let now = energy(&world);
        assert!(now <= before + lift && now <= start + lift, "{celsius} °C: {now} J after {before} J of {start} J");
        before = now;
    }
    assert!(world.unstable().is_none());
    let cold = sag(&world);
    world.set_gravity(DVec3::ZERO).expect("in range");
    world.advance(2.0);
    let kept = sag(&world);
    println!("over a ball: {stiff:.5} stiff, {cold:.5} formed, {kept:.5} without load");
    assert!(cold > 3.0 * stiff.max(1e-3), "{cold} after {stiff}");
    assert!((kept / cold - 1.0).abs() < 0.05, "{kept} after {cold}");
}

#[test]
fn a_sheet_creeps_and_softens_where_it_is_hot() {
    // A cantilever that is hot at its root bends in its middle; one that is hot at its tip does
    // not.
    let bent = |hot: &dyn Fn(f64) -> bool| {
        let mut scene = held(IntegratorKind::TrBdf2);
        scene.sheets[0].pins = vec![PinSpec::clamped(Region::Left)];
        scene.sheets[0].damping_ratio = Some(0.2);
        let mut world = world(&scene);
        let sheet = &mut world.sheets_mut()[0];
        let uv = sheet.model.uv.clone();
        sheet.set_temperatures(|i| if hot(uv[i].0) { 125.0 } else { 20.0 }).expect("in range");
        world.advance(2.0);
        world.sheets_mut()[0].set_temperatures(|_| 20.0).expect("in range");
        world.set_gravity(DVec3::ZERO).expect("in range");
        world.advance(3.0);
        assert!(world.unstable().is_none());
        -world.sheets()[0].state.x.get(3 * 11 + 5).y
    };
    let (none, tip, root) = (bent(&|_| false), bent(&|u| u > 0.7), bent(&|u| u < 0.4));
    println!("set by heat: {none:.6} nowhere, {tip:.5} at the tip, {root:.5} at the root");
    assert!(none.abs() < 1e-4 && tip.abs() < 2e-3 && root > 0.02, "{none} {tip} {root}");
}

/// Sheets with creases, plasticity and creep, side by side.
fn all_that_flows(engine: IntegratorKind) -> Scene {
    let mut scene = held(engine);
    // Full stiffness at all temperatures, because limp sheets would fold onto themselves.
    let stiff = scene.sheets[0].material.resolve("".as_ref()).expect("there");
    let softening = vec![(0.0, 1.0), (200.0, 1.0)];
    scene.sheets[0].material = MaterialChoice::Inline(Material { softening, ..stiff });
    scene.sheets[0].temperature = Some(120.0);
    scene.sheets[0].plastic = true;
    scene.sheets[0].creases = vec![CreaseSpec { from: (0.2, 0.0), to: (0.9, 1.0), angle: 30.0 }];
    let mut triangles = scene.sheets[0].clone();
    triangles.name = "triangles".into();
    triangles.placement.position.z = 0.5;
    triangles.outline = Some(OutlineSpec::Disc { radius: 0.08 });
    triangles.pins = vec![PinSpec::fixed(Region::Left), PinSpec::fixed(Region::Right)];
    let mut lattice = scene.sheets[0].clone();
    lattice.name = "lattice".into();
    lattice.placement.position.z = 1.0;
    lattice.structure = StructureKind::DoubleDiagonal;
    lattice.springs = SpringLaw::Calibrated;
    lattice.grid.1 = 2;
    lattice.plastic = false;
    lattice.creases.clear();
    lattice.pins = vec![PinSpec::clamped(Region::Left)];
    scene.sheets.extend([triangles, lattice]);
    scene
}

#[test]
fn creep_and_plasticity_are_bit_identical_on_any_number_of_threads() {
    let scene = all_that_flows(IntegratorKind::TrBdf2);
    let run = |threads: usize| {
        let mut world = world(&scene);
        world.set_threads(threads).expect("in range");
        (0..40).for_each(|_| _ = world.step());
        assert!(world.unstable().is_none());
        state_hash(&world)
    };
    let one = run(1);
    assert!([2, 3].into_iter().all(|threads| run(threads) == one));
}

#[test]
fn a_warm_step_with_creep_and_plasticity_allocates_nothing() {
    for engine in TABLE.iter().filter(|e| e.implicit) {
        let mut world = world(&all_that_flows(engine.kind));
        let change = |world: &mut World, celsius: &str| {
            for sheet in world.sheets_mut() {
                sheet.set_temperature(celsius.parse().expect("a number")).expect("in range");
            }
        };
        (0..20).for_each(|_| _ = world.step());
        change(&mut world, "123");
        (0..3).for_each(|_| _ = world.step());
        let counted = allocation_counter::measure(|| {
            change(&mut world, "121");
            (0..20).for_each(|_| _ = world.step());
        });
        assert_eq!(counted.count_total, 0, "{}", engine.name);
    }
}

#[test]
fn creep_of_unsuitable_sheets_is_rejected() {
    let rubber = rejection(&|s| {
        s.material = MaterialChoice::Named("rubber".into());
        s.creep = true;
    });
    assert!(rubber.1.contains("burgers"));
    assert!(rejection(&|s| s.temperature = Some(-300.0)).1.contains("°C"));
    let bad = |b: BurgersCreep| {
        rejection(&move |s: &mut SheetSpec| {
            s.material = MaterialChoice::Inline(Material { burgers: Some(b), ..Material::default() });
        })
    };
    let good = BurgersCreep { relaxation_time: 1.0, retardation_time: 1.0, retarded: 1.0 };
    assert!(bad(BurgersCreep { relaxation_time: 0.0, ..good }).1.contains("0 s is outside 1e-6 to 1e30 s"));
    assert!(bad(BurgersCreep { retarded: -1.0, ..good }).0.ends_with("burgers.retarded"));
}
