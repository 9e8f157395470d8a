//! Fracture and melting of sheets whose cells are triangles: outlines, holes and cuts, and the
//! lattices with shifted rows. Forces against closed forms, cracks from a notch, energy, melting,
//! snapshots, and detection without allocation.

use allocation_counter::measure as count;
use glam::DVec3;
use sheetwork::World;
use sheetwork::islands::event::EventKind;
use sheetwork::mesh::outline::OutlineSpec;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{
    Material, MaterialChoice, PathKey, PinSpec, Placement, Region, Scene, Shape, SheetSpec, SpringLaw,
};
use sheetwork_tests::fracture::fracture_at_random;
use sheetwork_tests::{Random, body, state_hash, world};

/// A soft material with zero Poisson's ratio, so that uniaxial tension gives uniform strain.
fn soft(tears_at: Option<f64>, melts_at: Option<f64>) -> Material {
    Material {
        young: 1e7,
        poisson: 0.0,
        density: 1000.0,
        thickness: 5e-4,
        damping_ratio: 0.5,
        specific_heat: 1300.0,
        conductivity: 0.2,
        emissivity: 0.9,
        expansion: 0.0,
        tears_at,
        melts_at,
        ..Material::default()
    }
}

/// A rectangle as an outline: a triangle mesh.
fn strip((length, width): (f64, f64), grid: (u32, u32), material: Material) -> SheetSpec {
    let (x, z) = (0.5 * length, 0.5 * width);
    SheetSpec {
        name: "sheet".into(),
        structure: StructureKind::Shell,
        grid: (grid.0, 1, grid.1),
        size: (length, width),
        outline: Some(OutlineSpec::Polygon(vec![(-x, -z), (x, -z), (x, z), (-x, z)])),
        springs: SpringLaw::Uniform,
        material: MaterialChoice::Inline(material),
        tearing: true,
        ..SheetSpec::default()
    }
}

fn lattice(structure: StructureKind, size: (f64, f64), grid: (u32, u32), material: Material) -> SheetSpec {
    SheetSpec {
        structure,
        grid: (grid.0, 2, grid.1),
        outline: None,
        gap: 1e-3,
        springs: SpringLaw::Length,
        ..strip(size, grid, material)
    }
}

/// A disc of 20 cm, held around its border 20 cm above the ground.
fn disc(material: Material) -> SheetSpec {
    SheetSpec {
        outline: Some(OutlineSpec::Disc { radius: 0.1 }),
        placement: Placement { position: DVec3::new(0.0, 0.2, 0.0), ..Placement::default() },
        pins: vec![PinSpec::fixed(Region::Border)],
        ..strip((0.2, 0.2), (21, 21), material)
    }
}

fn scene(sheet: SheetSpec) -> Scene {
    Scene {
        engine: IntegratorKind::TrBdf2,
        dt: 1.0 / 60.0,
        gravity: DVec3::ZERO,
        sheets: vec![sheet],
        ..Scene::default()
    }
}

/// Held at the left end and drawn by `by` (m) at the right one within `time` (s).
fn pulled(mut spec: SheetSpec, by: f64, time: f64) -> Scene {
    let drawn = PathKey { time, offset: DVec3::new(by, 0.0, 0.0), ..PathKey::default() };
    let right = PinSpec { path: vec![PathKey::default(), drawn], ..PinSpec::fixed(Region::Right) };
    spec.pins = vec![PinSpec::fixed(Region::Left), right];
    scene(spec)
}

fn opened(world: &World) -> usize {
    world.sheets()[0].open_count()
}

fn open(world: &World) -> Vec<bool> {
    world.sheets()[0].open_cells().expect("it can open").to_vec()
}

/// Σ k (L - s) cos over the springs across a section, N.
fn section(world: &World) -> f64 {
    let (sheet, springs) = (&world.sheets()[0], world.sheets()[0].springs());
    let mut sum = 0.0;
    for i in 0..springs.len() {
        let (a, b) = (springs.a[i] as usize, springs.b[i] as usize);
        if (sheet.model.uv[a].0 - 0.663) * (sheet.model.uv[b].0 - 0.663) < 0.0 {
            let d = sheet.state.x.get(b) - sheet.state.x.get(a);
            sum += springs.stiffness[i] * (d.length() - springs.rest[i]) * d.x.abs() / d.length();
        }
    }
    sum
}

/// Axial force (N) from the energy between two steps, and from the springs across a section, and
/// the mean strain, just before fracture; the world after fracture.
fn pulled_apart(spec: SheetSpec, limit: f64) -> ([f64; 2], f64, World) {
    let length = spec.size.0;
    let pull = 2.0 * limit * length;
    let mut world = world(&pulled(spec, pull, 8.0));
    let (mut last, mut springs) = ((0.0, 0.0), 0.0);
    for _ in 0..600 {
        world.step();
        if opened(&world) > 0 {
            let strain = pull * world.time() / 8.0 / length;
            return ([last.0, springs], strain, world);
        }
        let energy = world.sheets()[0].energy(DVec3::ZERO).elastic;
        last = ((energy - last.1) / (pull / 8.0 / 60.0), energy);
        springs = section(&world);
    }
    panic!("it did not tear");
}

#[test]
fn an_outlined_strip_fractures_at_the_force_of_its_fracture_strain() {
    for limit in [0.01, 0.1] {
        let spec = strip((0.2, 0.05), (21, 6), soft(Some(limit), None));
        let ([force, _], strain, world) = pulled_apart(spec, limit);
        // S = E ε (1 + ε/2) with Green's strain, and the force per area is S (1 + ε).
        let hooke = 1e7 * 5e-4 * 0.05 * limit;
        let green = hooke * (1.0 + limit) * (1.0 + 0.5 * limit);
        println!("outline, limit {limit}: {force:.4} N at {strain:.5}; with Green's strain {green:.4} N");
        assert!((force / green - 1.0).abs() < 0.01, "{force}, not {green}");
        assert!((strain / limit - 1.0).abs() < 0.01, "{strain}");
        let event = world.events().iter().find(|e| e.kind == EventKind::Torn).expect("told");
        let opening = event.opening.expect("of what");
        assert!(!opening.melted && (opening.strain / limit - 1.0).abs() < 0.01, "{opening:?}");
        assert!(world.sheets()[0].energy_released() > 0.0);
    }
}

#[test]
fn a_lattice_of_shifted_rows_fractures_at_the_force_of_its_springs() {
    for structure in [StructureKind::Trimm, StructureKind::ProvotTrimm] {
        let limit = 0.05;
        let spec = lattice(structure, (0.2, 0.05), (21, 7), soft(Some(limit), None));
        let ([force, sum], strain, world) = pulled_apart(spec, limit);
        println!("{structure}: {force:.4} N at {strain:.5}, its springs {sum:.4} N: {:.4}", force / sum);
        assert!((force / sum - 1.0).abs() < 0.02, "{structure}: {force}, its springs {sum}");
        assert!((0.7..1.01).contains(&(strain / limit)), "{structure}: {strain}");
        assert!(opened(&world) >= 1);
    }
}

/// Number of nodes of each part of the lowest layer that closed cells hold together.
fn parts(world: &World) -> Vec<usize> {
    let sheet = &world.sheets()[0];
    let nodes = sheet.model.layers[0].len() as usize;
    let mut part: Vec<usize> = (0..nodes).collect();
    let triangles = sheet.cells().layer_triangles(0);
    loop {
        let before = part.clone();
        for t in &triangles {
            let least = t.iter().map(|m| part[*m as usize]).min().unwrap_or(0);
            t.iter().for_each(|m| part[*m as usize] = least);
        }
        if part == before {
            break;
        }
    }
    let mut sizes = vec![0; nodes];
    part.iter().for_each(|p| sizes[*p] += 1);
    sizes.retain(|n| *n > 1);
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes
}

#[test]
fn a_notched_sheet_tears_from_the_notch_into_two_parts() {
    let slit = vec![((0.5, 0.0), (0.5, 0.3))];
    for spec in [
        strip((0.2, 0.1), (41, 21), soft(Some(0.05), None)),
        lattice(StructureKind::Trimm, (0.2, 0.1), (41, 21), soft(Some(0.05), None)),
        lattice(StructureKind::ProvotTrimm, (0.2, 0.1), (41, 21), soft(Some(0.05), None)),
    ] {
        let structure = spec.structure;
        let mut world = world(&pulled(SheetSpec { slits: slit.clone(), ..spec }, 0.02, 4.0));
        let (notch, whole) = (opened(&world), parts(&world)[0]);
        assert!(notch > 4, "{structure}: {notch} cells");
        assert_eq!(parts(&world).len(), 1, "{structure}");
        let mut before = open(&world);
        for _ in 0..300 {
            world.step();
            let now = open(&world);
            assert!(before.iter().zip(&now).all(|(was, is)| !was || *is), "what is open stays open");
            before = now;
        }
        let opening = world.events().iter().find_map(|e| e.opening).expect("it tore");
        let tip = DVec3::new(0.0, 0.0, -0.05 + 0.3 * 0.1);
        let away = (DVec3::from(opening.place_m) - tip).length();
        println!("{structure}: {notch} cells, then {}; parts {:?}; from {away:.4} m", opened(&world), parts(&world));
        assert!(away < 0.01, "{structure}: it tears {away} m from the notch");
        let sizes = parts(&world);
        assert!(sizes.len() >= 2 && sizes[1] > whole / 4, "{structure}: {sizes:?} of {whole}");
        assert!(world.unstable().is_none(), "{structure}");
        let strain = world.sheets()[0].energy(DVec3::ZERO).elastic;
        assert!(strain < 0.02 * 0.5 * 1e7 * 5e-4 * 0.1 * 0.2 * 0.05 * 0.05, "{structure}: {strain} J");
    }
}

#[test]
fn random_fractures_of_triangles_are_stable_and_add_no_energy() {
    let mut random = Random::new(34);
    let mut draw = |low: f64, high: f64| low + (high - low) * 0.5 * (1.0 + random.signed());
    let engines = [IntegratorKind::TrBdf2, IntegratorKind::TrBdf2, IntegratorKind::Bdf2, IntegratorKind::BackwardEuler];
    let (mut torn, mut worst) = (0, [0.0_f64; 2]);
    let mut trial = 0;
    while torn < 120 {
        trial += 1;
        let limit = 10.0_f64.powf(draw(-3.0, -1.0));
        let material =
            Material { young: 10.0_f64.powf(draw(5.0, 9.5)), damping_ratio: draw(0.0, 0.3), ..soft(Some(limit), None) };
        let mut spec = match trial % 4 {
            0 => lattice(StructureKind::Trimm, (0.2, 0.15), (9, 7), material),
            1 => lattice(StructureKind::ProvotTrimm, (0.2, 0.15), (9, 7), material),
            2 => strip((0.2, 0.15), (9, 7), material),
            _ => SheetSpec { pins: Vec::new(), ..disc(material) },
        };
        if trial % 4 == 3 {
            (spec.grid.0, spec.grid.2) = (10, 10);
        }
        let of = usize::from(trial % 4 < 2);
        spec.placement.position.y = 1.0;
        spec.pins = vec![PinSpec::fixed(if trial % 3 == 0 { Region::Border } else { Region::Left })];
        let engine = engines[(trial / 4) % 4];
        let scene = Scene { engine, gravity: DVec3::new(0.0, -9.81, 0.0), ..scene(spec) };
        let pull = (draw(0.1, 8.0), draw(0.9, 2.5) * limit);
        let what = format!("trial {trial}, {engine}");
        if let Some(rise) = fracture_at_random(&scene, pull, trial as u64, [5e-3, 3e-2][of], &what) {
            worst[of] = worst[of].max(rise);
            torn += 1;
        }
    }
    println!("{torn} of {trial} tore; largest rise in a step {worst:?} (shell, lattices), once torn");
    assert!(trial < 400, "{trial} trials");
}

#[test]
fn a_hot_spot_melts_a_hole_in_a_disc_and_a_ball_falls_through() {
    let melting = Material { young: 1e9, ..soft(None, Some(150.0)) };
    let held = |spec: SheetSpec| SheetSpec { pins: vec![PinSpec::fixed(Region::Border)], ..spec };
    let mut trimm = lattice(StructureKind::Trimm, (0.2, 0.2), (21, 21), melting.clone());
    trimm.placement.position.y = 0.2;
    for spec in [disc(melting), held(trimm)] {
        let structure = spec.structure;
        let mut scene = scene(spec);
        scene.gravity = DVec3::new(0.0, -9.81, 0.0);
        let at = |x: f64| Placement { position: DVec3::new(x, 0.215, 0.0), ..Placement::default() };
        let ball = |name: &str, x: f64| sheetwork::scene::BodySpec {
            mass: Some(0.003),
            ..body(name, Shape::Ball(0.01), at(x), vec![])
        };
        scene.bodies = vec![ball("ball", 0.0)];
        let mut world = world(&scene);
        let uv = world.sheets()[0].model.uv.clone();
        let hot = move |i: usize| if (uv[i].0 - 0.5).hypot(uv[i].1 - 0.5) < 0.16 { 200.0 } else { 20.0 };
        world.sheets_mut()[0].set_temperatures(hot).expect("in range");
        (0..60).for_each(|_| _ = world.step());
        let opening = world.events().iter().find_map(|e| e.opening).expect("told");
        let sheet = &world.sheets()[0];
        let hole = sheet.open_count() as f64 / sheet.open_cells().expect("it can open").len() as f64;
        // Cells of nodes within 3.2 cm of the middle.
        let height = world.body_state("ball").expect("there").origin().y;
        println!("{structure}: a fraction {hole:.4} is open, the ball at {height:.3} m");
        assert!(opening.melted && opening.temperature_c.is_some_and(|t| t > 150.0), "{opening:?}");
        assert!((0.03..0.12).contains(&hole), "{structure}: {hole}");
        assert!(height < -1.0, "{structure}: it hangs in the hole");
        assert!(world.unstable().is_none(), "{structure}");
    }
}

/// A disc that is pulled apart, melts and lies on a ball, and a lattice that tears above it.
fn busy() -> Scene {
    let mut first = strip((0.1, 0.1), (13, 13), soft(Some(0.05), Some(150.0)));
    first.cuts = vec![vec![(-0.02, 0.0), (0.02, 0.005)]];
    first.creep = false;
    first.placement.position.y = 0.05;
    let mut scene = pulled(first, 0.03, 0.5);
    let mut second = lattice(StructureKind::Trimm, (0.1, 0.1), (11, 11), soft(Some(0.05), Some(150.0)));
    second.name = "second".into();
    second.placement.position.y = 0.08;
    scene.gravity = DVec3::new(0.0, -9.81, 0.0);
    scene.sheets.push(second);
    let at = Placement { position: DVec3::new(0.0, 0.14, 0.0), ..Placement::default() };
    scene.bodies = vec![sheetwork::scene::BodySpec { mass: Some(0.05), ..body("ball", Shape::Ball(0.02), at, vec![]) }];
    scene
}

fn heat(world: &mut World) {
    let hot = |i: usize| if i % 17 < 3 { 180.0 } else { 30.0 };
    world.sheets_mut()[0].set_temperatures(hot).expect("in range");
}

#[test]
fn fracture_of_triangles_is_bit_identical_on_any_number_of_threads_and_from_a_snapshot() {
    let run = |threads: usize| {
        let mut world = world(&busy());
        world.set_threads(threads).expect("threads");
        heat(&mut world);
        (0..60).for_each(|_| _ = world.step());
        let open: Vec<usize> = world.sheets().iter().map(|s| s.open_count()).collect();
        (state_hash(&world), open)
    };
    let one = run(1);
    println!("{one:?}");
    assert!(one.1[0] > 10);
    assert_eq!(one, run(2));
    assert_eq!(one, run(3));
    // A world of its own goes on from the bytes of the torn one.
    let mut first = world(&busy());
    heat(&mut first);
    (0..30).for_each(|_| _ = first.step());
    assert!(opened(&first) > 0);
    let bytes = first.serialise();
    let mut second = world(&busy());
    second.deserialise(&bytes).expect("its own");
    assert_eq!(state_hash(&first), state_hash(&second));
    for step in 0..30 {
        first.step();
        second.step();
        assert_eq!(state_hash(&first), state_hash(&second), "step {step}");
    }
    assert_eq!(open(&first), open(&second));
    // A reset is the beginning.
    first.reset().expect("the same scene");
    heat(&mut first);
    (0..60).for_each(|_| _ = first.step());
    assert_eq!(state_hash(&first), one.0);
}

#[test]
fn a_snapshot_restores_closed_triangles() {
    let mut world = world(&pulled(strip((0.2, 0.05), (21, 6), soft(Some(0.05), None)), 0.02, 2.0));
    (0..30).for_each(|_| _ = world.step());
    let snapshot = world.snapshot();
    let mut run = || {
        world.restore(&snapshot).expect("its own");
        assert!(!open(&world).contains(&true));
        (0..200).for_each(|_| _ = world.step());
        (open(&world), state_hash(&world))
    };
    let first = run();
    assert!(first.0.contains(&true));
    assert_eq!(first, run());
}

#[test]
fn detection_in_triangles_allocates_nothing() {
    let trimm = lattice(StructureKind::Trimm, (0.2, 0.2), (21, 21), soft(Some(0.5), Some(150.0)));
    for spec in [disc(soft(Some(0.5), Some(150.0))), SheetSpec { pins: vec![PinSpec::fixed(Region::Border)], ..trimm }]
    {
        let structure = spec.structure;
        let mut world = world(&Scene { gravity: DVec3::new(0.0, -9.81, 0.0), ..scene(spec) });
        world.sheets_mut()[0].set_temperatures(|i| if i == 150 { 600.0 } else { 20.0 }).expect("in range");
        (0..90).for_each(|_| _ = world.step());
        let before = opened(&world);
        assert!(before > 0, "{structure}");
        let counted = count(|| (0..30).for_each(|_| _ = world.step()));
        assert_eq!((counted.count_total, opened(&world)), (0, before), "{structure}");
    }
}

#[test]
fn heat_stays_in_the_closed_triangles() {
    // Insulated parts on both sides of a slit across: each keeps its own mean temperature.
    let spec = SheetSpec {
        slits: vec![((0.5, 0.0), (0.5, 1.0))],
        tearing: false,
        ..strip((0.02, 0.01), (21, 11), soft(None, None))
    };
    let trimm = SheetSpec {
        slits: vec![((0.5, 0.0), (0.5, 1.0))],
        tearing: false,
        ..lattice(StructureKind::Trimm, (0.02, 0.01), (21, 11), soft(None, None))
    };
    for spec in [spec, trimm] {
        let mut scene = scene(spec);
        scene.sheets[0].pins = vec![PinSpec::fixed(Region::Border)];
        let mut world = world(&scene);
        let uv = world.sheets()[0].model.uv.clone();
        let hot = uv.clone();
        world.sheets_mut()[0].set_temperatures(move |i| if hot[i].0 < 0.5 { 60.0 } else { 20.0 }).expect("in range");
        (0..600).for_each(|_| _ = world.step());
        let sheet = &world.sheets()[0];
        let celsius = sheet.temperatures().expect("it has them");
        let cold = (0..uv.len()).filter(|i| uv[*i].0 > 0.6).map(|i| celsius[i]).fold(f64::NEG_INFINITY, f64::max);
        let warm = (0..uv.len()).filter(|i| uv[*i].0 < 0.4).map(|i| celsius[i]).fold(f64::INFINITY, f64::min);
        println!("{}: {warm:.2} °C and {cold:.2} °C beside the slit", scene.sheets[0].structure);
        assert!(cold < 20.5, "{cold}");
        assert!(warm > 30.0, "{warm}");
    }
}
