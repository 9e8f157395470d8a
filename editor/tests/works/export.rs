//! A run is written as pictures and as glTF, and the files can be read.

use glam::Vec3;
use serde_json::Value;
use sheetwork::World;
use sheetwork_editor::export::{Film, Job, Kind, Track, gltf, moments, picture_file};
use sheetwork_editor::picture::Look;

use super::common::{folder, strip};

/// The two chunks of a GLB file, with checked lengths.
fn chunks(file: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("four bytes")) as usize;
    assert_eq!((&file[..4], word(4), word(8)), (b"glTF".as_slice(), 2, file.len()));
    let text = word(12);
    assert_eq!((&file[16..20], text % 4), (b"JSON".as_slice(), 0));
    let rest = 20 + text;
    let binary = word(rest);
    assert_eq!((&file[rest + 4..rest + 8], binary % 4), (b"BIN\0".as_slice(), 0));
    assert_eq!(rest + 8 + binary, file.len());
    let json = serde_json::from_slice(&file[20..rest]).expect("JSON");
    (json, file[rest + 8..].to_vec())
}

fn number(value: &Value) -> usize {
    value.as_u64().unwrap_or_else(|| panic!("{value} is no number")) as usize
}

/// Numbers of an accessor, with checked view and type.
fn read(json: &Value, binary: &[u8], index: &Value) -> (Vec<f32>, usize) {
    let accessor = &json["accessors"][number(index)];
    let view = &json["bufferViews"][number(&accessor["bufferView"])];
    let (from, length) = (number(&view["byteOffset"]), number(&view["byteLength"]));
    let size = match accessor["type"].as_str() {
        Some("SCALAR") => 1,
        Some("VEC2") => 2,
        Some("VEC3") => 3,
        Some("VEC4") => 4,
        other => panic!("{other:?}"),
    };
    assert_eq!(length, 4 * size * number(&accessor["count"]), "a view is as long as what is in it");
    let words = binary[from..from + length].chunks_exact(4).map(|b| b.try_into().expect("four bytes"));
    let numbers: Vec<f32> = match number(&accessor["componentType"]) {
        5126 => words.map(f32::from_le_bytes).collect(),
        5125 => words.map(|b| u32::from_le_bytes(b) as f32).collect(),
        other => panic!("{other}"),
    };
    assert!(numbers.iter().all(|n| n.is_finite()));
    if let Some(low) = accessor.get("min").and_then(Value::as_array) {
        for (k, low) in low.iter().enumerate() {
            let least = numbers.iter().skip(k).step_by(size).copied().fold(f32::INFINITY, f32::min);
            assert!((low.as_f64().expect("a number") as f32 - least).abs() <= 0.0, "bounds are exact");
        }
    }
    (numbers, size)
}

fn vectors(numbers: &[f32]) -> Vec<Vec3> {
    numbers.chunks_exact(3).map(Vec3::from_slice).collect()
}

#[test]
fn a_run_is_written_as_gltf_that_has_every_moment() {
    let (folder, mut session) = (folder("gltf"), strip());
    let file = folder.join("strip.glb");
    let mut job = Job::new(Kind::Gltf, &file, 0.2);
    job.rate = 20.0;
    let camera = sheetwork_editor::camera::Camera::from_session(&session);
    job.begin(&session, &camera).expect("in range");
    while !job.step().expect("written") {}
    assert_eq!(session.world().steps(), 0, "the session stays where it was");
    session.run(0.2);
    let (json, binary) = chunks(&std::fs::read(&file).expect("there"));
    assert_eq!(json["asset"]["version"], "2.0");
    assert_eq!(number(&json["buffers"][0]["byteLength"]), binary.len());
    let primitive = &json["meshes"][0]["primitives"][0];
    let (first, _) = read(&json, &binary, &primitive["attributes"]["POSITION"]);
    let (indices, _) = read(&json, &binary, &primitive["indices"]);
    assert_eq!((first.len(), indices.len()), (3 * 13 * 9, 3 * 2 * 12 * 8));
    assert!(indices.iter().all(|i| (*i as usize) < first.len() / 3));
    let targets = primitive["targets"].as_array().expect("targets");
    assert_eq!((targets.len(), json["meshes"][0]["weights"].as_array().map(Vec::len)), (4, Some(4)));
    // The last target added to the first moment gives the present positions.
    let (last, _) = read(&json, &binary, &targets[3]["POSITION"]);
    let sheet = &session.world().sheets()[0];
    for (mass, (a, d)) in vectors(&first).into_iter().zip(vectors(&last)).enumerate() {
        assert!((a + d).distance(sheet.state.x.get(mass).as_vec3()) < 1e-6, "mass {mass}");
    }
    let animation = &json["animations"][0];
    let channel = |path: &str| {
        let all = animation["channels"].as_array().expect("channels").iter();
        let found = all.clone().find(|c| c["target"]["path"] == path).unwrap_or_else(|| panic!("{path}"));
        let sampler = &animation["samplers"][number(&found["sampler"])];
        (
            read(&json, &binary, &sampler["input"]).0,
            read(&json, &binary, &sampler["output"]).0,
            number(&found["target"]["node"]),
        )
    };
    let (times, weights, node) = channel("weights");
    assert_eq!((times.len(), weights.len(), node), (5, 20, 0));
    assert!(times.windows(2).all(|t| t[0] < t[1]) && (times[4] - 0.2).abs() < 1e-6);
    for (moment, row) in weights.chunks_exact(4).enumerate() {
        let ones: Vec<usize> = (0..4).filter(|k| row[*k] == 1.0).collect();
        assert_eq!(ones, if moment == 0 { vec![] } else { vec![moment - 1] });
    }
    let (_, places, node) = channel("translation");
    assert_eq!(json["nodes"][node]["name"], "ball");
    let ball = session.world().rigid().and_then(|r| r.pose(0)).expect("a ball").0.as_vec3();
    assert!(vectors(&places).last().expect("moments").distance(ball) < 1e-6, "the ball fell");
    assert_eq!(channel("rotation").1.len(), 20);
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn triangles_that_open_during_the_run_collapse_to_points() {
    let mut scene = strip().scene().clone();
    scene.sheets[0].tearing = true;
    scene.sheets[0].material = sheetwork::scene::MaterialChoice::Inline(sheetwork::scene::Material {
        melts_at: Some(150.0),
        ..sheetwork::scene::material::by_name("hips").expect("known")
    });
    let mut world = World::new(&scene).expect("valid");
    let mut track = Track::from_world(&world);
    track.record(&world, 0.0);
    world.sheets_mut()[0].set_temperatures(|i| if i == 40 { 900.0 } else { 20.0 }).expect("in range");
    world.step();
    let open = world.sheets()[0].open_count();
    assert!(open > 0 && open < 8, "{open}");
    track.record(&world, 0.1);
    let shapes = track.sheets[0].shapes();
    assert_eq!(shapes.moments[0].0.len(), 13 * 9 + 6 * open, "its triangles have corners of their own");
    let area = |moment: usize, t: &[u32; 3]| {
        let [a, b, c] = t.map(|k| shapes.moments[moment].0[k as usize]);
        0.5 * (b - a).cross(c - a).length()
    };
    let gone = shapes.triangles.iter().filter(|t| area(0, t) > 1e-6 && area(1, t) == 0.0).count();
    assert_eq!(gone, 2 * open);
    assert!(chunks(&gltf::binary(&track, "x")).0["meshes"].is_array());
}

#[test]
fn pictures_of_a_run_differ_and_too_many_are_rejected() {
    let (folder, session) = (folder("sequence"), strip());
    let file = folder.join("run.png");
    let mut job = Job::new(Kind::Sequence(Look::default(), (96, 64)), &file, 0.2);
    job.rate = 10.0;
    let camera = sheetwork_editor::camera::Camera::from_session(&session);
    job.begin(&session, &camera).expect("in range");
    while !job.step().expect("written") {}
    let read = |i: usize| std::fs::read(picture_file(&file, i)).expect("a picture");
    assert!(read(0) != read(2) && !picture_file(&file, 3).exists());
    assert!(job.world().expect("begun").time() > 0.19);
    std::fs::remove_dir_all(&folder).expect("removed");
    assert_eq!(moments(30.0, 2.0, 100).expect("in range"), 61);
    assert!(moments(30.0, 20.0, 100).expect_err("too many").problem.contains("601"));
    assert!(moments(0.0, 1.0, 100).is_err() && moments(f64::NAN, 1.0, 100).is_err() && moments(1.0, -1.0, 9).is_err());
    let mut job = Job::new(Kind::Gltf, &folder.join("none/x.glb"), 0.0);
    job.begin(&session, &camera).expect("in range");
    let refused = job.step().expect_err("no such folder").to_string();
    assert!(refused.contains("x.glb"), "{refused}");
}

#[test]
fn a_moment_between_two_steps_is_interpolated_and_the_run_has_whole_steps() {
    let mut session = strip();
    session.run(0.1);
    let (start, dt) = (session.world().time(), session.world().dt());
    let mut film = Film::from_session(&session).expect("valid");
    let places = |world: &World| {
        (0..world.sheets()[0].node_count()).map(|i| world.sheets()[0].state.x.get(i)).collect::<Vec<_>>()
    };
    let shown = places(film.at(2.25 * dt).expect("valid"));
    let steps = film.world().steps();
    let ahead = places(film.at(3.0 * dt).expect("valid"));
    assert_eq!(film.world().steps(), steps, "it was taken already");
    session.run(2.0 * dt);
    let before = places(session.world());
    session.step();
    assert_eq!(places(session.world()), ahead, "the same steps to the bit");
    let between = |i: usize| before[i].lerp(ahead[i], 0.25);
    assert!((0..shown.len()).all(|i| shown[i].distance(between(i)) < 1e-7));
    assert!(before.iter().zip(&ahead).any(|(a, b)| a.distance(*b) > 1e-4), "it moves");
    let ball = |world: &World| world.rigid().and_then(|r| r.pose(0)).expect("a ball").0;
    let world = film.at(3.5 * dt).expect("valid");
    assert!((world.time() - start - 3.5 * dt).abs() < 1e-9 * dt + 1e-12);
    let half = ball(world);
    session.step();
    assert!(half.y > ball(session.world()).y, "half a step behind");
}
