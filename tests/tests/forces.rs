//! Recorded forces: balance of momentum of sheets and bodies, and no effect on results.

use sheetwork::glam::DVec3;
use sheetwork::scene::Scene;
use sheetwork::{ForceKind, World};

fn scene(engine: &str, rest: &str) -> Scene {
    Scene::parse(&format!("(dt: 0.004, engine: \"{engine}\", {rest})")).expect("valid")
}

#[test]
fn probe() {
    for (name, engine, rest) in [
        ("floor", "tr-bdf2", r#"room: (x: (-1, 1), y: (0, 1), z: (-1, 1), back_wall: false), sheets: [(structure: "shell", grid: (9, 1, 9), size: (0.1, 0.1), material: "hips", placement: (position: (0, 0.01, 0), rotation: (0.2, 0, 0.1)))]"#),
        ("ball", "tr-bdf2", r#"gravity: (0, 0, 0), sheets: [(structure: "shell", grid: (9, 1, 9), size: (0.1, 0.1), material: "hips")], bodies: [(name: "ball", shape: Sphere(0.02), mass: 0.02, placement: (position: (0.01, 0.05, 0)), velocity: (0, -1, 0))]"#),
        ("ball", "verlet", r#"gravity: (0, 0, 0), sheets: [(structure: "slamm", grid: (9, 2, 9), size: (0.1, 0.1), springs: Calibrated, material: "hips")], bodies: [(name: "ball", shape: Sphere(0.02), mass: 0.02, placement: (position: (0.01, 0.05, 0)), velocity: (0, -1, 0))]"#),
    ] {
        let mut scene = scene(engine, rest);
        if engine == "verlet" { scene.dt = 1e-4; }
        let mut world = World::new(&scene).expect("valid");
        world.record_forces(true);
        let mut worst = [0.0_f64; 4];
        for step in 0..(0.4 / scene.dt) as usize {
            let before = world.sheets()[0].momentum();
            let body = world.body_state("ball").map(|b| b.velocity() * b.mass());
            world.step();
            let of = |kind: ForceKind| world.forces().iter().filter(|e| e.kind == kind).map(|e| e.impulse).sum::<DVec3>();
            let contact = of(ForceKind::Contact);
            let numerical = of(ForceKind::Numerical);
            let change = world.sheets()[0].momentum() - before;
            let body_change = body.map_or(DVec3::ZERO, |b| { let s = world.body_state("ball").unwrap(); s.velocity() * s.mass() - b });
            if contact != DVec3::ZERO && step < 400 {
                let r = numerical.length() / contact.length();
                worst[0] = worst[0].max(r);
                worst[1] = worst[1].max((contact + body_change).length() / contact.length());
                println!("{name} {engine} {step} contact {contact:?} num {r:.2e} body {:.2e} change {change:?} report {:?}", (contact + body_change).length() / contact.length(), world.step_report());
            }
        }
        println!("{name} {engine} worst {worst:?}");
        for e in world.forces() { println!("{e:?} {:?}", world.partner_name(e)); }
    }
}
