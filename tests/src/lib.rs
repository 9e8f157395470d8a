//! Common parts of the integration tests: small test sheets, their highest mode, reproducible
//! random numbers, and a hash of a world's state.
//!
//! The tests are in `tests/tests`, one file per subject; each names the source of its expected
//! numbers.

pub mod card;
pub mod fracture;
pub mod game;
pub mod house;
pub mod python;
pub mod rig;

use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;
use sheetwork::World;
use sheetwork::journal::{Journal, JournalInput, JournalWriter};
use sheetwork::math::Vectors;
use sheetwork::mesh::structure;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{BodySpec, Material, MaterialChoice, PathKey, Placement, Scene, Shape, SheetSpec, SpringLaw};
use sheetwork::sheet::Sheet;

/// Folder of the shipped scenes.
pub fn scenes_folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes")
}

/// The scene of that file name (without extension) in [`scenes_folder`].
///
/// # Panics
/// An unreadable scene.
pub fn shipped_scene(name: &str) -> Scene {
    match Scene::load(&scenes_folder().join(format!("{name}.ron"))) {
        Ok(scene) => scene,
        Err(error) => panic!("{error}"),
    }
}

/// A world of this scene.
///
/// # Panics
/// An invalid scene.
pub fn world_of(text: &str) -> World {
    let scene = Scene::parse(text).unwrap_or_else(|e| panic!("{e}"));
    World::new(&scene).unwrap_or_else(|e| panic!("{e}"))
}

/// Changes the first sheet of `world` to another grid.
///
/// # Panics
/// An impossible change.
pub fn change_grid(world: &mut World, grid: (u32, u32)) {
    let name = world.sheets()[0].name.clone();
    world.remap(&name, grid).unwrap_or_else(|e| panic!("{e}"));
}

/// Names of all shipped scenes, sorted.
///
/// # Panics
/// An unreadable folder.
pub fn shipped_scene_names() -> Vec<String> {
    let Ok(folder) = std::fs::read_dir(scenes_folder()) else { panic!("no folder of scenes") };
    let files = folder.filter_map(|entry| entry.ok().map(|e| e.path()));
    let scenes = files.filter(|p| p.extension().is_some_and(|e| e == "ron"));
    let mut names: Vec<String> = scenes.filter_map(|p| Some(p.file_stem()?.to_str()?.to_owned())).collect();
    names.sort();
    names
}

/// Number of layers that a test gives a structure: two, or its only possible number.
pub fn layers_of(structure: StructureKind) -> u32 {
    structure.info().layers.1.min(2)
}

/// A sheet of 4x4 nodes per layer, 0.3 m square, 3 g per node, springs of 10 N/m, with a largest
/// frequency of 100 to 200 rad/s. A shell has an equal E t, and a thickness at which bending
/// matters; `damping` is then about the ratio of its fastest mode.
pub fn small_sheet(structure: StructureKind, damping: f64) -> SheetSpec {
    let mut material = Material { young: 1e4, thickness: 1e-3, ..Material::default() };
    let mut damping_ratio = None;
    if structure == StructureKind::Shell {
        // 0.048 kg on 0.3 m x 0.3 m. Its slowest bending mode has 1.6 rad/s, and the damping ratio
        // is proportional to frequency.
        material = Material { young: 10.0 / 0.03, thickness: 0.03, density: 0.048 / 0.0027, ..material };
        damping_ratio = Some(0.011 * damping);
    }
    SheetSpec {
        name: "small".into(),
        structure,
        grid: (4, layers_of(structure), 4),
        size: (0.3, 0.3),
        gap: 0.05,
        material: MaterialChoice::Inline(material),
        springs: SpringLaw::Uniform,
        node_mass: Some(3e-3),
        damping,
        damping_ratio,
        ..SheetSpec::default()
    }
}

/// A scene of one sheet without gravity, bodies or air.
pub fn scene_without_gravity(sheet: SheetSpec, engine: IntegratorKind) -> Scene {
    Scene { gravity: DVec3::ZERO, engine, tolerance: 1.0, sheets: vec![sheet], ..Scene::thesis() }
}

/// World of the scene, with sleeping disabled.
///
/// # Panics
/// An invalid scene.
pub fn world(scene: &Scene) -> World {
    match World::new(scene) {
        Ok(mut world) => {
            world.set_sleep(false);
            world
        }
        Err(error) => panic!("{error}"),
    }
}

/// A body with the scene's friction and restitution.
pub fn body(name: &str, shape: Shape, placement: Placement, path: Vec<PathKey>) -> BodySpec {
    BodySpec { name: name.into(), placement, path, ..BodySpec::new(shape) }
}

/// Takes `steps` steps of `dt` s.
///
/// # Panics
/// A `dt` out of range, or an unstable sheet.
pub fn run(world: &mut World, steps: u32, dt: f64) {
    if let Err(error) = world.set_dt(dt) {
        panic!("{error}");
    }
    (0..steps).for_each(|_| _ = world.step());
    assert!(world.unstable().is_none(), "unstable");
}

/// Reproducible pseudo-random numbers (a 64-bit linear congruential generator; its upper bits).
pub struct Random(u64);

impl Random {
    /// A separate sequence for every `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678_9abc_def1)
    }

    /// Next number, uniform in -1 to 1.
    pub fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Next three numbers, each in -1 to 1.
    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }
}

/// Deforms and moves a sheet smoothly: displacements of `amplitude` (m) and velocities of
/// `amplitude` · `rate` in shapes with one or two periods over the sheet, so that neighbouring
/// nodes move nearly alike. Nodes in `pinned` are unchanged.
pub fn excite_smoothly(sheet: &mut Sheet, amplitude: f64, rate: f64, pinned: &[u32]) {
    for i in (0..sheet.node_count()).filter(|i| !pinned.contains(&(*i as u32))) {
        let (u, v) = sheet.model.uv[i];
        let (p, q) = (std::f64::consts::PI * u, std::f64::consts::PI * v);
        let shape = DVec3::new((2.0 * q).cos(), p.cos() * (q + 0.4).cos(), (2.0 * p).sin());
        let moving = DVec3::new((p + 0.3).cos(), (2.0 * p).cos(), (2.0 * q + 0.7).cos());
        sheet.state.x.set(i, sheet.state.x.get(i) + shape * amplitude);
        sheet.state.v.set(i, sheet.state.v.get(i) + moving * (amplitude * rate));
    }
}

/// Gives every node a pseudo-random velocity with components up to `speed` (m/s).
pub fn excite_randomly(sheet: &mut Sheet, speed: f64, seed: u64) {
    let mut random = Random::new(seed);
    for i in 0..sheet.node_count() {
        sheet.state.v.set(i, random.vector() * speed);
    }
}

/// Largest angular frequency (rad/s) of a free sheet at rest and its mode (length 1), by power
/// iteration on M⁻¹K. Independent of the library's implementation, as a test of it. All node masses
/// must be equal. For a sheet without springs, K follows from its energy; the positions are
/// restored.
pub fn highest_mode(sheet: &mut Sheet) -> (f64, Vectors) {
    let dense = sheet.springs().is_empty().then(|| hessian(sheet));
    let mut random = Random::new(1);
    let mut mode = Vectors::default();
    (0..sheet.node_count()).for_each(|_| mode.push(random.vector()));
    let mut squared = 0.0;
    for _ in 0..20_000 {
        let mut next = match &dense {
            Some(rows) => rows_times(sheet, rows, &mode),
            None => stiffness_times(sheet, &mode),
        };
        let length = next.iter().map(|p| p.length_squared()).sum::<f64>().sqrt();
        next.axes_mut().into_iter().flatten().for_each(|c| *c /= length);
        mode = next;
        let settled = (length - squared).abs() < 1e-15 * length;
        squared = length;
        if settled {
            break;
        }
    }
    (squared.sqrt(), mode)
}

/// M⁻¹ K d for unstretched springs: k d̂ d̂ᵀ each.
fn stiffness_times(sheet: &Sheet, d: &Vectors) -> Vectors {
    let springs = sheet.springs();
    let mut out = Vectors::zeros(d.len());
    for i in 0..springs.len() {
        let (a, b) = (springs.a[i] as usize, springs.b[i] as usize);
        let unit = (sheet.state.x.get(b) - sheet.state.x.get(a)).normalize();
        let force = unit * (springs.stiffness[i] * unit.dot(d.get(b) - d.get(a)));
        out.set(a, out.get(a) - force / sheet.node_mass(a));
        out.set(b, out.get(b) + force / sheet.node_mass(b));
    }
    out
}

/// Hessian of the elastic energy of a sheet at rest, N/m, by second differences. The energy at rest
/// is zero, so there is no cancellation. Rows and columns by node: x, y, z.
fn hessian(sheet: &mut Sheet) -> Vec<Vec<f64>> {
    let (n, step) = (3 * sheet.node_count(), 1e-6);
    let mut energy = |moves: [(usize, f64); 2]| {
        let before = moves.map(|(i, _)| sheet.state.x.get(i / 3));
        for (i, by) in moves {
            let mut p = sheet.state.x.get(i / 3);
            p[i % 3] += by;
            sheet.state.x.set(i / 3, p);
        }
        let energy = sheet.energy(DVec3::ZERO).elastic;
        moves.iter().zip(before).rev().for_each(|((i, _), p)| sheet.state.x.set(i / 3, p));
        energy
    };
    let mut rows = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let alike = energy([(i, step), (j, step)]) + energy([(i, -step), (j, -step)]);
            let unlike = energy([(i, step), (j, -step)]) + energy([(i, -step), (j, step)]);
            let value = (alike - unlike) / (4.0 * step * step);
            (rows[i][j], rows[j][i]) = (value, value);
        }
    }
    rows
}

/// M⁻¹ K d for a K given by its rows.
fn rows_times(sheet: &Sheet, rows: &[Vec<f64>], d: &Vectors) -> Vectors {
    let flat: Vec<f64> = d.iter().flat_map(|p| p.to_array()).collect();
    let mut out = Vectors::default();
    for (i, three) in rows.chunks(3).enumerate() {
        let dot = |k: usize| three[k].iter().zip(&flat).map(|(a, b)| a * b).sum::<f64>();
        out.push(DVec3::new(dot(0), dot(1), dot(2)) / sheet.node_mass(i));
    }
    out
}

/// Mean over the mass of a sheet with temperatures, and their lowest and highest, °C.
///
/// # Panics
/// When it has none.
pub fn mean_and_range_of_temperatures(sheet: &Sheet) -> (f64, f64, f64) {
    let celsius = sheet.temperatures().expect("temperatures");
    let sum: f64 = (0..sheet.node_count()).map(|i| sheet.node_mass(i) * celsius[i]).sum();
    let range = sheet.heat().expect("temperatures").range();
    (sum / sheet.total_mass(), range.0, range.1)
}

/// Largest distance between nodes of equal number, m.
pub fn distance(a: &Vectors, b: &Vectors) -> f64 {
    a.iter().zip(b.iter()).map(|(p, q)| p.distance(q)).fold(0.0, f64::max)
}

/// Hash of a world's state: [`World::state_hash`].
pub fn state_hash(world: &World) -> u64 {
    world.state_hash()
}

/// One sheet of every structure, each `height` (m) above a floor and in the path of a kinematic
/// box.
pub fn one_of_every_structure(engine: IntegratorKind, height: f64) -> Scene {
    let mut scene = Scene { name: engine.name().into(), engine, dt: 2e-3, ..Scene::default() };
    for (i, structure) in structure::TABLE.iter().enumerate() {
        let mut sheet = small_sheet(structure.kind, 0.2);
        sheet.name = structure.name.into();
        sheet.placement =
            Placement { position: DVec3::new(0.5 * i as f64, height, 0.0), rotation: DVec3::new(7.0, 40.0, -9.0) };
        scene.sheets.push(sheet);
    }
    scene.bodies.push(body("floor", Shape::HalfSpace, Placement::default(), vec![]));
    let path = vec![
        PathKey::default(),
        PathKey { time: 1.0, offset: DVec3::new(3.0, 0.0, 0.1), rotation: DVec3::new(0.0, 90.0, 0.0) },
    ];
    scene.bodies.push(body("box", Shape::Box(DVec3::new(0.2, 0.2, 0.6)), Placement::default(), path));
    scene
}

/// Record `inputs`, each before `steps` steps, of `world` in a journal, and check that a world made
/// from the journal repeats them.
///
/// # Panics
/// An input that is refused, and a step that is not repeated.
pub fn journal_repeats(world: &mut World, inputs: impl IntoIterator<Item = JournalInput>, steps: u32) {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let file = std::env::temp_dir().join(format!("sheetwork-{}-{number}.journal", std::process::id()));
    let mut journal = JournalWriter::create(&file, world, 4).expect("writable");
    for input in inputs {
        journal.input(world, input).expect("valid");
        (0..steps).for_each(|_| journal.step(world).map(|_| ()).expect("writable"));
    }
    journal.finish().expect("writable");
    let read = Journal::read(&file).expect("readable");
    std::fs::remove_file(&file).expect("there");
    let mut again = read.world(None).expect("valid");
    assert_eq!(read.check(&mut again).expect("applies"), None);
    assert_eq!(state_hash(&again), state_hash(world));
}
