//! Buckling detection: one event per snap-through, with place and energy, and none otherwise.

use glam::DVec3;
use sheetwork::World;
use sheetwork::islands::event::{Event, EventKind};
use sheetwork::scene::Scene;

/// Buckling events of `scene` in `seconds`, with a call of `each` before every step.
fn buckles(scene: &str, seconds: f64, mut each: impl FnMut(&mut World)) -> Vec<Event> {
    let mut world = World::new(&Scene::parse(scene).expect("valid")).expect("valid");
    world.set_buckling_detection(true);
    while world.time() < seconds {
        each(&mut world);
        world.step();
    }
    assert!(world.unstable().is_none(), "{scene}");
    world.events().iter().filter(|e| e.kind == EventKind::Buckled).cloned().collect()
}

/// Elastic energy (J) of a strip of this length (m), width (m), thickness (m) and modulus (Pa),
/// buckled to a half wave by an approach of its pinned ends (`nearer`, m). Snap-through to the
/// other side can pass through a whole wave, which has four times the energy (Timoshenko and Gere,
/// *Theory of Elastic Stability*, 2.1: P L² = n² π² E I, and U = P Δ for a shallow bow).
fn energy_of_half_a_wave(length: f64, width: f64, thickness: f64, nearer: f64, young: f64) -> f64 {
    let inertia = width * thickness.powi(3) / 12.0;
    std::f64::consts::PI.powi(2) * young * inertia / (length * length) * nearer
}

/// A strip buckles downwards under its weight when its ends approach. A hand then pulls its middle
/// up by a soft spring until it snaps through.
#[test]
fn a_strip_buckles_under_compression_and_in_snap_through() {
    for dt in [0.002, 0.004] {
        let scene = format!(
            r#"(engine: "tr-bdf2", dt: {dt}, air: (factor: 0.99),
                sheets: [(name: "arch", structure: "shell", grid: (25, 1, 3), size: (0.2, 0.02), material: "hips",
                    pins: [(region: Left, path: [(time: 0, offset: (0, 0, 0)), (time: 0.5, offset: (0.002, 0, 0))]),
                        (region: Right, path: [(time: 0, offset: (0, 0, 0)), (time: 0.5, offset: (-0.002, 0, 0))])])])"#
        );
        let (mut start, mut over) = (None, f64::INFINITY);
        let seen = buckles(&scene, 4.0, |world| {
            let time = world.time();
            let Some(sheet) = world.sheet_mut("arch") else { return };
            if time > 1.0 && start.is_none() {
                sheet.grab((0.5, 0.5), 0.2).expect("free");
                start = Some(sheet.pulls()[0].target);
            }
            if let Some(start) = start {
                sheet.pull(0, start + DVec3::Y * 0.5 * (time - 1.0)).expect("there");
                let middle = sheet.pulls()[0].point(&sheet.state.x);
                if middle.y > 0.0 {
                    over = over.min(time);
                }
            }
        });
        assert_eq!(seen.len(), 2, "{seen:?}");
        assert!(seen[0].time_s < 0.05, "the load of a straight strip is reached at once");
        let (time, energy) = (seen[1].time_s, seen[1].energy_j.expect("known"));
        assert!((over - time).abs() < 0.03, "at {time} s, through at {over} s");
        let half = energy_of_half_a_wave(0.2, 0.02, 5e-4, 0.004, 2e9);
        assert!(energy > 0.1 * half && energy < 3.0 * half, "{energy} J of {half} J");
        let [x, _, z] = seen[1].place_m.expect("known");
        assert!(x.abs() < 0.09 && z.abs() < 0.011, "{x} {z}");
    }
}

#[test]
fn hanging_swinging_bouncing_and_bending_sheets_do_not_buckle() {
    let cantilever = r#"(engine: "tr-bdf2", dt: 0.004, sheets: [(name: "a", structure: "shell", grid: (17, 1, 5), size: (0.2, 0.05), material: "card",
        pins: [(region: Left, clamp: true)])])"#;
    let pendulum = r#"(engine: "tr-bdf2", dt: 0.004, sheets: [(name: "a", structure: "shell", grid: (9, 1, 9), size: (0.2, 0.2), material: "hips",
        pins: [(region: Left)])])"#;
    let bounce = r#"(engine: "tr-bdf2", dt: 0.004, sheets: [(name: "a", structure: "shell", grid: (11, 1, 11), size: (0.1, 0.1), material: "hips",
        restitution: 0.5, placement: (position: (0, 0.05, 0)))], room: (x: (-1, 1), y: (0, 1), z: (-1, 1)))"#;
    let lattice = r#"(dt: 0.002, engine: "tr-bdf2", sheets: [(name: "a", structure: "slamm", grid: (9, 2, 9), size: (0.1, 0.1),
        material: "rubber", springs: Uniform, pins: [(region: Left)])])"#;
    for scene in [cantilever, pendulum, bounce, lattice] {
        assert_eq!(buckles(scene, 2.0, |_| {}), [], "{scene}");
    }
}
