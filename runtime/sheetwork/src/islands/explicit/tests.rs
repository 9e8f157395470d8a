//! Sheets of explicit integrators in contacts beyond nodes: edges and tips, dynamic bodies, other
//! sheets. References are closed forms and conserved quantities.

use glam::DVec3;

use crate::World;
use crate::collision::overlap::{BodyPose, OverlapSolid, faces, with_body};
use crate::mesh::structure::StructureKind;
use crate::rigid::BodyState;
use crate::scene::{
    BodySpec, ContactDefaults, IntegratorKind, PinSpec, Placement, Polyhedron, Region, Scene, Shape, SheetSpec,
};
use crate::sheet::Sheet;

const G: f64 = 9.81;

/// Soft lattice of 9 x 2 x 9 nodes, 24 mm long, 20 mm above the origin.
fn lattice(engine: IntegratorKind) -> Scene {
    let sheet = SheetSpec {
        structure: StructureKind::Trimm,
        grid: (9, 2, 9),
        size: (0.024, 0.024),
        gap: 1e-3,
        node_mass: Some(4e-5),
        damping: 0.2,
        placement: at(0.0, 0.02, 0.0),
        ..SheetSpec::thesis()
    };
    Scene { engine, dt: 1e-3, sheets: vec![sheet], contact: rough(), ..Scene::default() }
}

/// One layer of 9 x 9 nodes in a tenth of the Earth's gravity.
fn layer(engine: IntegratorKind) -> Scene {
    let mut scene = lattice(engine);
    scene.gravity = DVec3::new(0.0, -0.981, 0.0);
    scene.sheets[0].structure = StructureKind::Provot2d;
    scene.sheets[0].grid = (9, 1, 9);
    scene
}

fn rough() -> ContactDefaults {
    ContactDefaults { friction: 0.3, restitution: 0.1, ..ContactDefaults::default() }
}

fn at(x: f64, y: f64, z: f64) -> Placement {
    Placement { position: DVec3::new(x, y, z), rotation: DVec3::ZERO }
}

fn body(shape: Shape, placement: Placement) -> BodySpec {
    BodySpec { name: "body".into(), placement, ..BodySpec::new(shape) }
}

fn world(scene: &Scene) -> World {
    World::new(scene).expect("valid")
}

/// Largest penetration of the static body by nodes, and by any point of the surface, m.
fn depth(world: &World) -> (f64, f64) {
    let sheet = &world.sheets()[0];
    let of = &world.rigid().expect("its own").bodies().iter().find(|b| b.name == "body").expect("there");
    let state = world.body_state("body").expect("there");
    let frame = BodyPose { position: state.origin(), rotation: state.rotation() };
    with_body(sheet, &faces(sheet), &OverlapSolid::from_shape(&of.shape).expect("known"), &frame)
}

fn momenta(world: &World) -> (DVec3, DVec3) {
    let sheets = world.sheets().iter().map(|s: &Sheet| {
        let p = s.momentum();
        (p, s.angular_momentum() + s.centre_of_mass().cross(p))
    });
    let bodies = world.body_state("body").map(|b: &BodyState| (b.momentum(), b.angular_momentum(DVec3::ZERO)));
    sheets.chain(bodies).fold((DVec3::ZERO, DVec3::ZERO), |(p, l), (q, m)| (p + q, l + m))
}

#[test]
fn a_ridge_does_not_penetrate_between_nodes() {
    let mut scene = layer(IntegratorKind::EulerRichardson);
    // The ridge lies between two rows of nodes.
    scene.sheets[0].placement = at(0.0014, 0.017, 0.0);
    scene.bodies.push(body(Shape::Polyhedron(Polyhedron::wedge(0.03, 0.016, 0.06)), at(0.0, 0.0, 0.0)));
    let mut world = world(&scene);
    let mut deepest = 0.0_f64;
    for _ in 0..2000 {
        world.step();
        deepest = deepest.max(depth(&world).1);
    }
    assert!(deepest < 1e-4, "{deepest}");
}

#[test]
fn a_ball_and_a_free_sheet_exchange_momentum() {
    for engine in [IntegratorKind::Verlet, IntegratorKind::Rk45] {
        let mut scene = layer(engine);
        scene.gravity = DVec3::ZERO;
        let ball = body(Shape::Ball(0.005), at(0.003, 0.03, 0.002));
        scene.bodies.push(BodySpec { mass: Some(2e-3), velocity: DVec3::new(0.1, -0.5, 0.05), ..ball });
        let mut world = world(&scene);
        let (p, l) = momenta(&world);
        let energy = world.energy().total;
        for _ in 0..200 {
            world.step();
            let (q, m) = momenta(&world);
            assert!((q - p).length() < 1e-9 * p.length(), "{engine} at {}: {}", world.time(), (q - p).length());
            // Position correction is separate from the velocity solve and changes the moment by the
            // square of the step.
            assert!((m - l).length() < 1e-2 * l.length(), "{engine} at {}: {}", world.time(), (m - l).length());
            assert!(world.energy().total < energy * (1.0 + 1e-9), "{engine} gained energy");
        }
        let pushed = world.sheets()[0].momentum();
        assert!(pushed.y < -1e-2 * p.length(), "{engine}: the sheet was not pushed: {pushed}");
        assert!(world.body_state("body").expect("there").velocity().y > -0.45, "the ball was not");
    }
}

#[test]
fn a_thrown_sheet_that_slides_on_another_obeys_friction() {
    // The lower sheet is fixed; the upper slides on it at speed v and stops after v²/(2 μ g).
    let (speed, friction) = (0.1, 0.4);
    let mut scene = lattice(IntegratorKind::Verlet);
    scene.contact = ContactDefaults { friction, restitution: 0.0, ..ContactDefaults::default() };
    scene.dt = 2e-4;
    scene.sheets[0].structure = StructureKind::Provot2d;
    scene.sheets[0].grid = (9, 1, 9);
    scene.sheets[0].size = (0.06, 0.06);
    scene.sheets[0].placement = at(0.0, 0.0, 0.0);
    scene.sheets[0].pins = vec![PinSpec::fixed(Region::All)];
    let above = SheetSpec {
        name: "above".into(),
        size: (0.024, 0.024),
        placement: at(-0.01, 2.1e-5, 0.0013),
        velocity: DVec3::new(speed, 0.0, 0.0),
        pins: Vec::new(),
        ..scene.sheets[0].clone()
    };
    scene.sheets.push(above);
    let mut world = world(&scene);
    let start = world.sheets()[1].centre_of_mass().x;
    for _ in 0..1000 {
        world.step();
    }
    let slid = world.sheets()[1].centre_of_mass().x - start;
    let wanted = speed * speed / (2.0 * friction * G);
    assert!((slid / wanted - 1.0).abs() < 0.02, "{slid} {wanted}");
}

/// State after one of two sheets has changed to the implicit integrator by its recovery policy.
#[test]
fn sheets_of_explicit_and_implicit_engines_meet() {
    for implicit in [0, 1] {
        let mut scene = layer(IntegratorKind::Verlet);
        scene.gravity = DVec3::ZERO;
        let above = SheetSpec {
            name: "above".into(),
            placement: at(0.0011, 0.024, 0.0007),
            velocity: DVec3::new(0.02, -0.3, 0.0),
            ..scene.sheets[0].clone()
        };
        scene.sheets.push(above);
        let mut world = world(&scene);
        world.sheets_mut()[implicit].set_engine(IntegratorKind::TrBdf2, 1e-6);
        let ((p, _), energy) = (momenta(&world), world.energy().total);
        let start = world.sheets()[0].momentum();
        for _ in 0..100 {
            world.step();
            let [below, above] = [0, 1].map(|i| world.sheets()[i].centre_of_mass().y);
            assert!(below < above, "{implicit} at {}: they are through", world.time());
            assert!((momenta(&world).0 - p).length() < 1e-9 * p.length(), "{implicit}: {}", momenta(&world).0 - p);
            assert!(world.energy().total < energy * (1.0 + 1e-6), "{implicit} gained energy");
        }
        assert!(world.sheets().iter().all(|s| s.state.status == crate::sheet::Status::Awake));
        let pushed = world.sheets()[0].momentum() - start;
        assert!(pushed.y < -0.3 * p.length(), "{implicit}: the lower one was not pushed: {pushed}");
    }
}
