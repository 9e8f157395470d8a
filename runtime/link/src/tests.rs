//! Round trip of the layout, and rejection of damaged samples.

use crate::layout::{FrameView, LAYOUT};
use crate::plan::FramePlan;
use crate::topology::{self, Meshes, SheetMesh};
use crate::write::{FrameStamp, frame};
use sheetwork::World;
use sheetwork::scene::Scene;

fn world() -> World {
    let scene = Scene::parse(
        r#"(engine: "euler-richardson", dt: 0.001, room: (x: (-1, 1), y: (0, 1), z: (-1, 1)),
            sheets: [
                (name: "leaf", structure: "shell", grid: (6, 1, 5), size: (0.2, 0.1), material: "pet"),
                (name: "lattice", structure: "samm", grid: (4, 2, 4), size: (0.3, 0.3), material: "thesis", springs: Uniform,
                    placement: (position: (1, 0.5, 0)))])"#,
    );
    World::new(&scene.expect("valid")).expect("valid")
}

/// A frame in memory with the alignment of a sample.
#[repr(align(64))]
struct Aligned([u8; 1 << 16]);

fn written(world: &World, complete: bool, memory: &mut Aligned) -> usize {
    let plan = FramePlan::new(world);
    assert!(plan.fits(world));
    let bytes = plan.bytes[usize::from(complete)];
    let moment = FrameStamp { epoch: 7, frame: 3, topology: 2, step_time: 1e-3, written_at: 5, playing: true };
    frame(&plan, world, &moment, complete, &mut memory.0[..bytes]);
    bytes
}

#[test]
fn a_frame_equals_the_world() {
    let mut world = world();
    let stretch = 1.01;
    let leaf = world.sheet_mut("leaf").expect("there");
    for i in 0..leaf.node_count() {
        leaf.state.x.set(i, leaf.state.x.get(i) * stretch);
    }
    let mut memory = Box::new(Aligned([0xff; 1 << 16]));
    for complete in [false, true] {
        let bytes = written(&world, complete, &mut memory);
        let view = FrameView::new(&memory.0[..bytes]).expect("sound");
        assert_eq!((view.header().epoch, view.header().frame, view.sheets().count()), (7, 3, 2));
        assert_eq!(view.bodies().len(), 2, "floor and back wall");
        assert_eq!(view.bodies()[0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        for (seen, sheet) in view.sheets().zip(world.sheets()) {
            assert_eq!((seen.header().name(), seen.header().structure()), (&*sheet.name, sheet.model.structure.name()));
            assert_eq!(seen.positions().len(), sheet.node_count());
            for (p, q) in seen.positions().iter().zip(sheet.state.x.iter()) {
                assert_eq!(*p, q.as_vec3().to_array());
            }
            assert_eq!(seen.contact().len(), sheet.node_count());
            assert!(seen.temperature().is_empty());
            assert_eq!(seen.normals().len(), if complete { sheet.node_count() } else { 0 });
            assert!(seen.normals().iter().all(|n| (n[1] - 1.0).abs() < 1e-6));
            let expected = if sheet.name == "leaf" { stretch - 1.0 } else { 0.0 };
            assert!(seen.strain().iter().all(|e| (f64::from(*e) - expected).abs() < 1e-7));
            assert_eq!(seen.header().energy[3].is_nan(), !complete);
        }
    }
}

#[test]
fn truncated_or_damaged_samples_are_rejected_or_harmless() {
    let world = world();
    let mut memory = Box::new(Aligned([0; 1 << 16]));
    let bytes = written(&world, true, &mut memory);
    for cut in 0..bytes {
        assert!(FrameView::new(&memory.0[..cut]).is_err(), "{cut} bytes of {bytes}");
    }
    assert!(FrameView::new(&memory.0[..bytes + 1]).is_err());
    let sum = |view: FrameView| -> usize {
        let each = |s: crate::layout::SheetView| {
            s.header().name().len() + s.positions().len() + s.normals().len() + s.strain().len() + s.contact().len()
        };
        view.sheets().map(each).sum()
    };
    // Every single-bit error of the headers.
    for at in 0..(144 + 2 * 192) {
        for bit in 0..8 {
            memory.0[at] ^= 1 << bit;
            if let Ok(view) = FrameView::new(&memory.0[..bytes]) {
                assert!(sum(view) < 10_000);
            }
            memory.0[at] ^= 1 << bit;
        }
    }
    memory.0[8] = LAYOUT as u8 + 1;
    let refused = FrameView::new(&memory.0[..bytes]).err().expect("another layout");
    assert!(refused.contains("layout 2"), "{refused}");
}

#[test]
fn topology_survives_a_round_trip_and_damage_is_rejected_or_harmless() {
    let world = world();
    let plan = FramePlan::new(&world);
    let bytes = topology::bytes(&plan);
    assert!(bytes <= topology::sample_capacity(&plan));
    let mut memory = Box::new(Aligned([0xff; 1 << 16]));
    topology::write(&plan, &world, (7, 3), &mut memory.0[..bytes]);
    let meshes = Meshes::read(&memory.0[..bytes]).expect("sound");
    assert_eq!((meshes.epoch, meshes.version, meshes.sheets.len()), (7, 3, 2));
    for (mesh, (plan, sheet)) in meshes.sheets.iter().zip(plan.sheets.iter().zip(world.sheets())) {
        assert_eq!((&mesh.name, mesh.masses, &mesh.triangles), (&sheet.name, sheet.node_count(), &plan.triangles));
        assert!(!mesh.triangles.is_empty() && mesh.open.is_empty());
    }
    for cut in 0..bytes {
        assert!(Meshes::read(&memory.0[..cut]).is_err(), "{cut} bytes of {bytes}");
    }
    for at in 0..bytes.min(600) {
        for bit in 0..8 {
            memory.0[at] ^= 1 << bit;
            if let Ok(meshes) = Meshes::read(&memory.0[..bytes]) {
                let within = |m: &SheetMesh| m.triangles.iter().flatten().all(|i| (*i as usize) < m.masses);
                assert!(meshes.sheets.iter().all(within));
            }
            memory.0[at] ^= 1 << bit;
        }
    }
}

#[test]
fn commands_survive_a_round_trip_and_invalid_ones_are_rejected() {
    use crate::command::Command;
    let all = [
        Command::Status,
        Command::Set { path: "gravity".into(), value: "(0, -1.6, 0)".into() },
        Command::Pull { grab: 3, target: [0.0, 1e-3, 2.0] },
    ];
    for command in all {
        assert_eq!(Command::from_bytes(&command.to_bytes()), Ok(command));
    }
    for (bytes, says) in [
        (&b""[..], "no JSON"),
        (b"[1,2]", "does not say its layout"),
        (br#"{"op":"play"}"#, "does not say its layout"),
        (br#"{"layout":2,"op":"play"}"#, "layout 2"),
        (br#"{"layout":1,"op":"explode"}"#, "explode"),
        (br#"{"layout":1,"op":"set","path":"gravity"}"#, "value"),
        (br#"{"layout":1,"op":"pull","grab":1,"target":[0,null,0]}"#, "null"),
        (br#"{"layout":1,"op":"step","steps":1,"more":1}"#, "more"),
        (&[0xff; 20_000], "20000 bytes"),
    ] {
        let refused = Command::from_bytes(bytes).expect_err("refused");
        assert!(refused.contains(says), "{refused}");
    }
}
