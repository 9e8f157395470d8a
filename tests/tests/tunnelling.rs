//! CCD of fast nodes: none passes through a 5 mm plate at 20 m/s and 60 steps per second in any
//! direction, with displacements per step of 60 times the thickness. Plates are static, translating
//! and rotating; further bodies are a box, a plate bent to an L, and a needle thrown at paper.

use glam::{DQuat, DVec3};
use sheetwork::World;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::IntegratorKind;
use sheetwork::scene::{
    BodySpec, ContactDefaults, Material, MaterialChoice, PathKey, PinSpec, Placement, Polyhedron, Region, Scene, Shape,
    SheetSpec,
};
use sheetwork_tests::{Random, body, world};

const SPEED: f64 = 20.0;
const THICKNESS: f64 = 0.005;
const DT: f64 = 1.0 / 60.0;
/// Penetration that contact tolerates for a step, m.
const PENETRATION_TOLERANCE: f64 = 1e-4;

/// A limp sheet of four nodes, 0.1 m square; its weak springs are stable at 60 steps per second.
fn projectile(index: usize, position: DVec3, velocity: DVec3) -> SheetSpec {
    SheetSpec {
        name: format!("shot {index}"),
        structure: StructureKind::Samm,
        grid: (2, 1, 2),
        size: (0.1, 0.1),
        material: MaterialChoice::Inline(Material { young: 0.1, ..Material::default() }),
        node_mass: Some(1e-3),
        placement: Placement { position, rotation: DVec3::ZERO },
        velocity,
        ..SheetSpec::default()
    }
}

/// Many projectiles, without contact between sheets, against `bodies`.
fn shots(bodies: Vec<BodySpec>, restitution: f64, sheets: Vec<SheetSpec>) -> World {
    let contact = ContactDefaults { friction: 0.2, restitution, sheets: false, ..ContactDefaults::default() };
    let engine = IntegratorKind::EulerCromer;
    world(&Scene { gravity: DVec3::ZERO, engine, dt: DT, contact, bodies, sheets, ..Scene::default() })
}

/// A downward velocity of 20 m/s, short of grazing, and a start from which the sheet crosses the
/// plane y = 0 within half a metre of the origin after a random number of steps.
fn aimed(random: &mut Random) -> (DVec3, DVec3) {
    let direction = DVec3::new(random.signed(), -0.3 - random.signed().abs(), random.signed()).normalize();
    let target = DVec3::new(0.5 * random.signed(), 0.0, 0.5 * random.signed());
    let time = DT * (2.0 + 3.0 * random.signed().abs());
    (target - direction * (SPEED * time), direction * SPEED)
}

/// Number of steps after which every projectile has reached the plate.
const STEPS: u32 = 9;

#[test]
fn no_node_passes_through_a_static_plate() {
    for turned in [DVec3::ZERO, DVec3::new(35.0, 20.0, 170.0), DVec3::new(90.0, 10.0, 45.0)] {
        for restitution in [0.0, 0.5] {
            let place = Placement { position: DVec3::new(1.0, 2.0, -3.0), rotation: turned };
            let plate = body("plate", Shape::Box(DVec3::new(8.0, THICKNESS, 8.0)), place, vec![]);
            let mut random = Random::new(5);
            let sheets = (0..300).map(|i| {
                let (start, velocity) = aimed(&mut random);
                projectile(i, place.apply(start), place.quaternion() * velocity)
            });
            let mut world = shots(vec![plate], restitution, sheets.collect());
            (0..STEPS).for_each(|_| _ = world.step());
            let back = place.quaternion().inverse();
            for sheet in world.sheets() {
                assert!(sheet.counters.contacts > 0, "{} missed", sheet.name);
                for p in sheet.x.iter() {
                    let height = (back * (p - place.position)).y;
                    assert!(height > 0.5 * THICKNESS, "{} is at {height} m", sheet.name);
                }
            }
        }
    }
}

#[test]
fn no_node_passes_through_a_moving_plate() {
    // The plate moves at 5 m/s towards, away from and across the projectiles: approach speeds up to
    // 25 m/s.
    for drift in [DVec3::new(0.0, 5.0, 0.0), DVec3::new(0.0, -5.0, 0.0), DVec3::new(4.0, 1.0, 3.0)] {
        let path = vec![PathKey::default(), PathKey { time: 1.0, offset: drift, rotation: DVec3::ZERO }];
        let plate = body("plate", Shape::Box(DVec3::new(12.0, THICKNESS, 12.0)), Placement::default(), path);
        let mut random = Random::new(6);
        let sheets = (0..300).map(|i| {
            let (start, velocity) = aimed(&mut random);
            // Clear of the plate at the start for every direction of its motion.
            projectile(i, start + DVec3::Y * 0.2, velocity)
        });
        let mut world = shots(vec![plate], 0.0, sheets.collect());
        for _ in 0..STEPS + 8 {
            world.step();
            let height = world.rigid().and_then(|r| r.pose(0)).map_or(0.0, |p| p.0.y);
            for (sheet, p) in world.sheets().iter().flat_map(|s| s.x.iter().map(move |p| (s, p))) {
                assert!(p.y > height + 0.4 * THICKNESS, "{} is {} m through", sheet.name, height - p.y);
            }
        }
        // Projectiles slower than a receding plate never reach it.
        let met = world.sheets().iter().filter(|s| s.counters.contacts > 0).count();
        assert!(met == 300 || (drift.y < 0.0 && met > 200), "{met} of 300 met the plate with {drift}");
    }
}

#[test]
fn nodes_near_the_rim_of_a_large_turning_plate_are_not_skipped() {
    // One turn per second about z: 6 degrees per step, 38 m/s at the rim of a plate of 12 m. Half
    // of the nodes are at rest in its path.
    let turn = |time: f64| PathKey { time, offset: DVec3::ZERO, rotation: DVec3::new(0.0, 0.0, 360.0 * time) };
    let box_ = Shape::Box(DVec3::new(12.0, THICKNESS, 12.0));
    let plate = body("plate", box_, Placement::default(), vec![turn(0.0), turn(1.0)]);
    let mut random = Random::new(7);
    let sheets = (0..300).map(|i| {
        if i % 2 == 0 {
            let (start, velocity) = aimed(&mut random);
            return projectile(i, start, velocity);
        }
        // On the side that the plate turns towards.
        let start = DVec3::new(3.5 + 1.5 * random.signed(), 1.5 + random.signed(), random.signed());
        projectile(i, start, DVec3::ZERO)
    });
    let mut world = shots(vec![plate], 0.0, sheets.collect());
    let mut through = 0;
    for _ in 0..12 {
        world.step();
        let q = world.rigid().and_then(|r| r.pose(0)).map_or(DQuat::IDENTITY, |p| p.1);
        let back = q.inverse();
        // Nodes that slide off the rim, 6 m from the axis, are excluded.
        let local = world.sheets().iter().flat_map(|s| s.x.iter()).map(|p| back * p);
        through += local.filter(|p| p.y < 0.0 && p.x < 5.9).count();
    }
    assert!(world.unstable().is_none());
    assert_eq!(through, 0, "masses were on the other side");
    let met = world.sheets().iter().filter(|s| s.counters.contacts > 0).count();
    assert!(met > 200, "{met}");
}

/// A plate of 5 mm bent at a right angle: an L with legs of 1 m in the plane normal to z, 2 m long.
/// Its inner edge runs along z through the origin, and it opens to +x, +y.
fn bent_plate() -> Polyhedron {
    let t = THICKNESS;
    let outline = [(-t, -t), (1.0, -t), (1.0, 0.0), (0.0, 0.0), (0.0, 1.0), (-t, 1.0)];
    let at = |z: f64| outline.iter().map(move |(x, y)| DVec3::new(*x, *y, z));
    let n = outline.len() as u32;
    let mut faces = vec![(0..n).rev().collect(), (n..2 * n).collect::<Vec<_>>()];
    faces.extend((0..n).map(|i| vec![i, (i + 1) % n, n + (i + 1) % n, n + i]));
    Polyhedron { vertices: at(-1.0).chain(at(1.0)).collect(), faces }
}

#[test]
fn no_node_passes_through_the_corner_of_a_bent_plate() {
    // Throws into the corner, at either leg and at both. A node must stay in the quadrant x > 0, y
    // > 0 within the length of the legs.
    for rotation in [DVec3::ZERO, DVec3::new(20.0, -70.0, 100.0)] {
        let place = Placement { position: DVec3::new(0.5, -0.5, 2.0), rotation };
        let q = place.quaternion();
        let plate = body("bent", Shape::Polyhedron(bent_plate()), place, vec![]);
        let mut random = Random::new(8);
        let sheets = (0..400).map(|i| {
            let start = DVec3::new(0.6 + 0.2 * random.signed(), 0.6 + 0.2 * random.signed(), 0.3 * random.signed());
            let target = match i % 3 {
                0 => DVec3::new(0.0, 0.4 + 0.3 * random.signed(), 0.3 * random.signed()),
                1 => DVec3::new(0.4 + 0.3 * random.signed(), 0.0, 0.3 * random.signed()),
                _ => DVec3::new(0.02 * random.signed().abs(), 0.0, 0.3 * random.signed()),
            };
            projectile(i, place.apply(start), q * ((target - start).normalize() * SPEED))
        });
        let mut world = shots(vec![plate], 0.0, sheets.collect());
        let back = q.inverse();
        for step in 0..6 {
            world.step();
            for sheet in world.sheets() {
                for p in sheet.x.iter().map(|p| back * (p - place.position)) {
                    // Beyond the end of a leg or of the plate any position is valid.
                    let covered = p.x < 1.0 && p.y < 1.0 && p.z.abs() < 1.0;
                    assert!(
                        !covered || (p.x > -PENETRATION_TOLERANCE && p.y > -PENETRATION_TOLERANCE),
                        "{} is at {p} after step {step}",
                        sheet.name
                    );
                }
            }
        }
        assert!(world.sheets().iter().all(|s| s.counters.contacts > 0));
    }
}

#[test]
fn a_node_deflected_by_one_body_does_not_pass_through_another() {
    // The corner made of two plates, in both orders of processing.
    for swapped in [false, true] {
        let t = THICKNESS;
        let at = |x: f64, y: f64| Placement { position: DVec3::new(x, y, 0.0), rotation: DVec3::ZERO };
        let floor = body("floor", Shape::Box(DVec3::new(4.0, t, 4.0)), at(0.0, -0.5 * t), vec![]);
        let wall = body("wall", Shape::Box(DVec3::new(t, 4.0, 4.0)), at(-0.5 * t, 1.0), vec![]);
        let bodies = if swapped { vec![wall, floor] } else { vec![floor, wall] };
        let mut random = Random::new(9);
        let sheets = (0..400).map(|i| {
            let start = DVec3::new(0.5 + 0.2 * random.signed(), 0.5 + 0.2 * random.signed(), 0.3 * random.signed());
            let target = DVec3::new(0.1 * random.signed().abs(), 0.1 * random.signed().abs(), 0.3 * random.signed());
            projectile(i, start, (target - start).normalize() * SPEED)
        });
        let mut world = shots(bodies, 0.3, sheets.collect());
        for step in 0..6 {
            world.step();
            for (sheet, p) in world.sheets().iter().flat_map(|s| s.x.iter().map(move |p| (s, p))) {
                assert!(
                    p.x > -PENETRATION_TOLERANCE && p.y > -PENETRATION_TOLERANCE,
                    "{} is at {p} after step {step}",
                    sheet.name
                );
            }
        }
        assert!(world.unstable().is_none());
    }
}

/// A needle: a pyramid of 8 mm by 8 mm, 50 mm long.
fn needle() -> Polyhedron {
    let h = 0.004;
    let base = [(-h, -h), (-h, h), (h, h), (h, -h)].map(|(x, z)| DVec3::new(x, 0.0, z));
    let faces = vec![vec![3, 2, 1, 0], vec![0, 1, 4], vec![1, 2, 4], vec![2, 3, 4], vec![3, 0, 4]];
    Polyhedron { vertices: base.into_iter().chain([DVec3::new(0.0, 0.05, 0.0)]).collect(), faces }
}

#[test]
fn no_dynamic_needle_passes_through_a_fixed_sheet() {
    // An impact turns a needle of 4 g at up to 270 rad/s, or 4 rad per step, so that it can swing
    // past the sheet.
    let mut throws =
        vec![(DVec3::new(0.017, 0.3, 0.003), DVec3::new(150.0, 40.0, 0.0), DVec3::new(10.0, 20.0, 5.0), 20.0)];
    let mut random = Random::new(11);
    throws.extend((0..15).map(|i| {
        let place = DVec3::new(0.08 * random.signed(), 0.3, 0.08 * random.signed());
        (place, 180.0 * random.vector(), 20.0 * random.vector(), [4.0, 8.0, 20.0][i % 3])
    }));
    for (engine, count) in [(IntegratorKind::TrBdf2, 16), (IntegratorKind::BackwardEuler, 4)] {
        for (position, rotation, spin, speed) in throws.iter().copied().take(count) {
            let sides = [Region::Left, Region::Right, Region::Back, Region::Front];
            let sheet = SheetSpec {
                structure: StructureKind::Shell,
                grid: (15, 1, 15),
                size: (0.25, 0.25),
                material: MaterialChoice::Named("paper".into()),
                pins: sides.map(PinSpec::fixed).to_vec(),
                ..SheetSpec::default()
            };
            let thrown = BodySpec {
                velocity: DVec3::new(0.0, -speed, 0.0),
                spin,
                mass: Some(0.004),
                ..body("needle", Shape::Polyhedron(needle()), Placement { position, rotation }, vec![])
            };
            let contact = ContactDefaults { friction: 0.3, restitution: 0.1, ..ContactDefaults::default() };
            let scene = Scene { gravity: DVec3::ZERO, engine, dt: DT, contact, ..Scene::default() };
            let mut world = world(&Scene { sheets: vec![sheet], bodies: vec![thrown], ..scene });
            (0..(0.8 / speed / DT) as u32 + 4).for_each(|_| _ = world.step());
            let state = world.body_state("needle").expect("the needle");
            // The needle rebounds, or rests in the hollow that it has made.
            let y = state.centre().y;
            assert!(y > -0.04, "{engine}, {speed} m/s, {position}: at {y} m");
            assert!(state.kinetic_energy() < 0.5 * 0.004 * speed * speed, "{engine}, {speed} m/s, {position}");
        }
    }
}
