//! Tubes, bags and cables from the masses and springs of a sheet, in sheet files (thesis 7.4 i).

use glam::DVec3;
use sheetwork::World;
use sheetwork::collision::collision_surface::CollisionSurface;
use sheetwork::mesh::spring_class::SpringClass;
use sheetwork::mesh::structure::{LatticeSpec, StructureKind};
use sheetwork::scene::Scene;
use sheetwork::scene::sht::{BodySprings, SheetFile, TubeSpec, prism, read_sht_file, tube, write_sht_file};
use sheetwork::sheet::surface::{DrawingSurface, SurfaceSmoothing};
use sheetwork::sheet::{Sheet, from_file};
use sheetwork_tests::{scenes_folder, shipped_scene, world};

const TUBE: TubeSpec = TubeSpec { grid: (25, 2, 20), length: 0.06, radius: 0.008, gap: 0.002, closed: false };
const BAG: TubeSpec = TubeSpec { grid: (14, 2, 20), length: 0.0325, closed: true, ..TUBE };
const CABLE: LatticeSpec = LatticeSpec {
    structure: StructureKind::DoubleDiagonal,
    grid: (41, 3, 3),
    size: (0.1, 0.0025),
    gap: 0.00125,
    cross_over: false,
};

/// The node mass and damping of the thesis; its 0.185 N/m let a tube collapse under its weight.
const fn springs(stiffness: f64) -> BodySprings {
    BodySprings { stiffness, node_mass: 4e-5, damping: 0.115 }
}

fn made(name: &str) -> SheetFile {
    let file = match name {
        "tube" => tube(&TUBE, &springs(6.0)),
        "bag" => tube(&BAG, &springs(6.0)),
        _ => prism(&CABLE, &springs(10.0)),
    };
    file.unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[test]
fn the_shipped_files_are_those_that_the_library_makes() {
    for name in ["tube", "bag", "cable"] {
        let path = scenes_folder().join(format!("../sheets/{name}.sht"));
        let made = made(name);
        if std::env::var_os("SHEETWORK_RENEW").is_some() {
            write_sht_file(&path, &made).unwrap_or_else(|e| panic!("{e}"));
        }
        let read = read_sht_file(&path).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((read.masses.len(), read.springs.len()), (made.masses.len(), made.springs.len()), "{name}");
        // Sine and cosine may differ in the last bit between platforms.
        for (a, b) in read.masses.iter().zip(&made.masses) {
            assert!(a.position.distance(b.position) < 1e-15 && a.mass == b.mass && a.layer == b.layer, "{name}");
        }
        for (a, b) in read.springs.iter().zip(&made.springs) {
            assert_eq!((a.kind, a.a, a.b, a.stiffness), (b.kind, b.a, b.b, b.stiffness), "{name}");
            assert!((a.rest - b.rest).abs() < 1e-15, "{name}");
        }
    }
}

#[test]
fn counts_follow_from_the_construction() {
    let counts = |file: &SheetFile| (file.masses.len(), file.springs.len());
    // Inner layer 25 x 20: 24 x 20 along x, 25 x 20 around, 2 x 24 x 20 diagonals. Outer layer
    // 24 x 19: 23 x 19, 24 x 19, 2 x 23 x 19. Four springs to each outer node. Braces through the
    // seam: 2 x 24 from the last inner row and 2 x 24 to the first.
    let tube = made("tube");
    assert_eq!(counts(&tube), (500 + 456, 480 + 500 + 960 + 437 + 456 + 874 + 4 * 456 + 96));
    // 14 columns in the place of 25, and 10 springs across the innermost ring.
    assert_eq!(counts(&made("bag")), (280 + 247, 260 + 280 + 520 + 228 + 247 + 456 + 4 * 247 + 52 + 10));
    // Layers of 41 x 3, 40 x 2 and 41 x 3, each inner node joined to four corners below and above.
    let layer = |n: usize, m: usize| (n - 1) * m + n * (m - 1) + 2 * (n - 1) * (m - 1);
    assert_eq!(counts(&made("cable")), (123 + 80 + 123, 2 * layer(41, 3) + layer(40, 2) + 8 * 80));
}

#[test]
fn a_tube_is_round_at_rest_and_closed() {
    for (name, edges) in [("tube", 2 * (20 + 19)), ("bag", 2 * 20 + 2 * 19)] {
        let sheet = from_file(&made(name)).unwrap_or_else(|e| panic!("{e}"));
        for i in 0..sheet.springs().len() {
            let (a, b) = (sheet.springs().a[i] as usize, sheet.springs().b[i] as usize);
            let length = sheet.state.x.get(a).distance(sheet.state.x.get(b));
            assert!((length - sheet.springs().rest[i]).abs() < 1e-15, "{name}: spring {i}");
        }
        // The only borders of its two layers are the rims at both ends.
        let surface = CollisionSurface::from_sheet(&sheet);
        assert_eq!(surface.edges().iter().filter(|e| e.is_border()).count(), edges, "{name}");
        // Every triangle of the wall looks outwards, those of the seam too.
        for t in surface.triangles() {
            let [a, b, c] = t.nodes.map(|i| sheet.state.x.get(i as usize));
            let (normal, middle) = ((b - a).cross(c - a), (a + b + c) / 3.0);
            let outward = if middle.x < 0.0 && name == "bag" { DVec3::NEG_X } else { middle.with_x(0.0) };
            assert!(normal.dot(outward) > -1e-15, "{name}: triangle {:?}", t.nodes);
        }
    }
}

#[test]
fn a_tube_is_drawn_round_across_its_seam() {
    let sheet = from_file(&made("tube")).unwrap_or_else(|e| panic!("{e}"));
    for (smoothing, name) in SurfaceSmoothing::ALL {
        let surface = DrawingSurface::of_sheet(&sheet, 0, 4, smoothing).unwrap_or_else(|| panic!("a layer"));
        let mesh = surface.mesh(&sheet.state.x);
        assert_eq!(mesh.positions.len(), (24 * 4 + 1) * (20 * 4 + 1), "{name}");
        // A chord of a twentieth of the circle lies 1.2 % inside it, the spline 0.02 %.
        for p in &mesh.positions {
            let radius = f64::from(p[1]).hypot(f64::from(p[2]));
            assert!((radius / 0.008 - 1.0).abs() < 1e-3, "{name}: {radius}");
        }
    }
}

/// The shipped scene at its end, and its start.
fn at_the_end(name: &str) -> (World, World) {
    let scene: Scene = shipped_scene(name);
    let (start, mut end) = (world(&scene), world(&scene));
    let mut last_second = None;
    while end.time() < scene.duration {
        end.step();
        assert!(end.unstable().is_none(), "{name} at {} s", end.time());
        if last_second.is_none() && end.time() > scene.duration - 1.0 {
            last_second = Some(end.sheets()[0].state.x.clone());
        }
    }
    let (floor, sheet) = (scene.room.map_or(0.0, |room| room.y.0), &end.sheets()[0]);
    let lowest = sheet.state.x.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let before = last_second.unwrap_or_default();
    let moved = before.iter().zip(sheet.state.x.iter()).map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
    println!("{name}: lowest {:.3} mm over the floor, moved {:.4} mm", (lowest - floor) * 1e3, moved * 1e3);
    assert!(lowest > floor, "{name}: {lowest} is in the floor");
    assert!(moved < 1e-4, "{name}: moved {moved} m in the last second");
    (start, end)
}

/// Height of the inner layer of a tube in a column, m.
fn height(sheet: &Sheet, column: u32) -> f64 {
    let layer = sheet.model.layers[0];
    let heights = || (0..layer.nz).map(|j| sheet.state.x.get(layer.at(column, j) as usize).y);
    heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min)
}

#[test]
fn a_tube_on_a_wedge_is_dented_and_rests() {
    let (_, end) = at_the_end("tube");
    let sheet = &end.sheets()[0];
    let (ridge, ends) = (height(sheet, 12), [height(sheet, 0), height(sheet, 24)]);
    println!("height {:.2} mm over the ridge, {:.2?} mm at the ends", ridge * 1e3, ends.map(|h| h * 1e3));
    // Its ends keep their 16 mm; the ridge carries half of the weight on a line.
    assert!(ends.iter().all(|h| (h / 0.016 - 1.0).abs() < 0.2) && ridge < 0.6 * ends[0] && ridge > 0.002);
}

#[test]
fn a_bag_stands_open_on_the_floor() {
    let (start, end) = at_the_end("bag");
    let rim = |world: &World| {
        let sheet = &world.sheets()[0];
        let layer = sheet.model.layers[0];
        (0..layer.nz).map(|j| sheet.state.x.get(layer.at(layer.nx - 1, j) as usize)).collect::<Vec<_>>()
    };
    let width = |ring: &[DVec3]| ring[0].distance(ring[ring.len() / 2]);
    let height = |ring: &[DVec3]| ring.iter().map(|p| p.y).sum::<f64>() / ring.len() as f64 + 0.0281;
    let (before, after) = (rim(&start), rim(&end));
    println!(
        "rim {:.2} mm high, {:.2} of {:.2} mm wide",
        height(&after) * 1e3,
        width(&after) * 1e3,
        width(&before) * 1e3
    );
    assert!(height(&after) > 0.02 && width(&after) > 0.8 * width(&before));
}

#[test]
fn a_cable_hangs_straight_from_its_end() {
    let (_, end) = at_the_end("cable");
    let sheet = &end.sheets()[0];
    let layer = sheet.model.layers[0];
    let (top, bottom) = (sheet.state.x.get(layer.at(0, 1) as usize), sheet.state.x.get(layer.at(40, 1) as usize));
    let hanging = top - bottom;
    println!("hangs {:.2} mm below its end, {:.2} mm beside it", hanging.y * 1e3, hanging.with_y(0.0).length() * 1e3);
    // 326 masses of 4e-5 kg at 0.981 m/s² on springs of 10 N/m stretch it by less than a tenth.
    assert!(hanging.y > 0.095 && hanging.y < 0.11 && hanging.with_y(0.0).length() < 0.01);
}

#[test]
fn impossible_tubes_are_refused_by_field() {
    let field = |spec: TubeSpec| tube(&spec, &springs(6.0)).expect_err("impossible").field;
    assert_eq!(field(TubeSpec { grid: (17, 2, 4), ..TUBE }), "grid.2");
    assert_eq!(field(TubeSpec { grid: (17, 2, 9), ..TUBE }), "grid.2");
    assert_eq!(field(TubeSpec { radius: 0.0, ..TUBE }), "radius");
    assert_eq!(field(TubeSpec { radius: 0.001, ..BAG }), "grid.0");
    assert_eq!(field(TubeSpec { radius: 0.05, ..BAG }), "grid.0");
    let error = tube(&TUBE, &BodySprings { node_mass: 0.0, ..springs(6.0) }).expect_err("no mass");
    assert_eq!(error.field, "masses.0.mass");
    assert!(made("tube").springs.iter().any(|s| s.kind == SpringClass::CrossOver));
}
