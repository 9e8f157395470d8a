//! Parameters over the link: valid changes take effect in the next step; invalid ones are rejected
//! with a reason and have no effect.

use sheetwork_link::Client;
use sheetwork_link::Command;
use sheetwork_link::Link;
use sheetwork_link::LinkError;

use super::place::{TestLink, until};
use sheetwork_tests::game::{TestGame, strip};

#[test]
fn parameters_are_listed_set_in_order_and_rejected_with_reasons() {
    let place = TestLink::new("knobs");
    let _game = place.start("game", &[("SHEETWORK_PAUSED", "1")]);
    let client = place.attach();
    let all = client.parameters().expect("answers");
    let young = all.iter().find(|p| p.path == "sheets.strip.material.young").expect("listed");
    assert_eq!((young.unit.as_str(), young.kind.as_str(), young.max), ("Pa", "number", Some(2e12)));
    assert!(all.iter().any(|p| p.path == "engine" && p.kind == "name") && all.len() > 12);
    for p in &all {
        assert_eq!(client.get(&p.path).expect("answers"), *p, "{}", p.path);
        assert_eq!(client.set(&p.path, &p.value), Ok(p.value.clone()), "{} takes back its own value", p.path);
    }
    assert_eq!(client.set("sheets.strip.material.young", "1e9"), Ok(young.value.clone()));
    assert_eq!(client.set("sheets.0.material.young", "2e9"), Ok("1000000000".into()));
    for (path, value, says) in [
        ("sheets.strip.material.young", "NaN", "not a finite number"),
        ("sheets.strip.material.young", "-1", "outside"),
        ("sheets.strip.material.young", "soft", "not a finite number"),
        ("gravity", "(0, 1e9, 0)", "outside"),
        ("gravity", "(0, 1)", "3"),
        ("engine", "perpetual", "perpetual"),
        ("sheets.strip.colour", "1", "cannot be set"),
    ] {
        let refused = client.set(path, value).expect_err("refused");
        assert!(matches!(&refused, LinkError::Refused(why) if why.contains(says)), "{path} = {value}: {refused}");
    }
    assert_eq!(client.get("sheets.strip.material.young").expect("answers").value, "2000000000");
    // The change acts in the next step: with reversed gravity the free edge rises.
    let mut frames = client.frames(false).expect("a place");
    let height = |f: &sheetwork_link::Frame| f.view().expect("sound").sheets().next().expect("one").positions()[8][1];
    let before = until(&mut frames, |f| Some(height(f)));
    client.set("gravity", "(0, 50, 0)").expect("accepted");
    let answer = client.send(&Command::Step { steps: 1 }).expect("done");
    let after = until(&mut frames, |f| (Some(f.header().steps) == answer["steps"].as_u64()).then(|| height(f)));
    assert!(after > before, "{before} m, then {after} m");
}

#[test]
fn switches_are_booleans_and_an_unknown_path_names_the_nearest() {
    let place = TestLink::new("switches");
    let _game = place.start("game", &[("SHEETWORK_PAUSED", "1")]);
    let client = place.attach();
    let film = sheetwork_tests::scenes_folder().join("melting_hole.ron").display().to_string();
    client.send(&Command::Load { file: film }).expect("done");
    let path =
        client.parameters().expect("answers").into_iter().find(|p| p.path.ends_with(".on")).expect("a heater").path;
    let switch = client.get(&path).expect("answers");
    assert_eq!(
        (switch.kind.as_str(), switch.boolean(), switch.number(), switch.min),
        ("boolean", Some(true), None, None)
    );
    assert_eq!(client.set(&path, false), Ok("true".into()));
    assert_eq!(client.get(&path).expect("answers").boolean(), Some(false));
    assert_eq!(client.set(&path, "true"), Ok("false".into()));
    for (value, says) in [("0.5", "neither true nor false"), ("on", "neither true nor false")] {
        let refused = client.set(&path, value).expect_err("refused").to_string();
        assert!(refused.contains(says), "{refused}");
    }
    let gravity = client.get("gravity").expect("answers");
    assert_eq!((gravity.vector(), gravity.number(), gravity.boolean()), (Some([0.0, -9.81, 0.0]), None, None));
    assert_eq!(client.set("dt", 0.002).map(|_| client.get("dt").expect("answers").number()), Ok(Some(0.002)));
    for wrong in [client.get("gravty").map(|p| p.value), client.set("gravty", "1")] {
        let refused = wrong.expect_err("refused").to_string();
        assert!(refused.contains("did you mean gravity?") && refused.contains("sheetwork params"), "{refused}");
        assert!(!refused.contains("young"), "not all of them: {refused}");
    }
}

/// An integrator that is unstable on these sheets. They are frozen and named until a reset or
/// restore.
#[test]
fn an_unstable_sheet_is_reported_until_reset_or_restore() {
    let place = TestLink::new("unstable");
    let _game = place.start("game", &[("SHEETWORK_PAUSED", "1")]);
    let client = place.attach();
    let tip = |client: &Client| {
        let mut frames = client.frames(false).expect("a place");
        until(&mut frames, |f| Some(f.view().expect("sound").sheets().next().expect("one").positions()[8]))
    };
    let stopped =
        |answer: serde_json::Map<String, serde_json::Value>| answer.get("stopped").cloned().unwrap_or_default();
    client.send(&Command::Step { steps: 5 }).expect("done");
    client.send(&Command::Snapshot { name: "sound".into() }).expect("done");
    for back in [Command::Restore { name: "sound".into() }, Command::Reset] {
        client.set("engine", "euler").expect("accepted");
        let answer = client.send(&Command::Step { steps: 300 }).expect("done");
        assert_eq!(stopped(answer), serde_json::json!(["strip"]));
        assert_eq!(client.status().expect("answers").stopped, ["strip"]);
        // The previous integrator alone does not restore the sheet, and the answer reports it.
        let set = Command::Set { path: "engine".into(), value: "tr-bdf2".into() };
        assert_eq!(stopped(client.send(&set).expect("accepted")), serde_json::json!(["strip"]));
        let stood = tip(&client);
        client.send(&Command::Step { steps: 5 }).expect("done");
        assert_eq!(tip(&client), stood);
        assert_eq!(stopped(client.send(&back).expect("done")), serde_json::Value::Null);
        let begun = tip(&client);
        assert_eq!(stopped(client.send(&Command::Step { steps: 20 }).expect("done")), serde_json::Value::Null);
        assert!(tip(&client) != begun && client.status().expect("answers").stopped.is_empty(), "it moves again");
    }
}

#[test]
fn commands_play_step_reset_snapshot_and_restore() {
    let place = TestLink::new("commands");
    let _game = place.start("game", &[("SHEETWORK_PAUSED", "1")]);
    let client = place.attach();
    let steps = |command: Command| client.send(&command).expect("done")["steps"].as_u64().expect("a number");
    assert_eq!(steps(Command::Step { steps: 10 }), 10);
    assert_eq!(steps(Command::Snapshot { name: "ten".into() }), 10);
    assert_eq!(steps(Command::Step { steps: 5 }), 15);
    assert_eq!(steps(Command::Restore { name: "ten".into() }), 10);
    assert!(client.send(&Command::Restore { name: "eleven".into() }).is_err());
    assert!(client.send(&Command::Step { steps: 0 }).is_err());
    assert_eq!(steps(Command::Reset), 0);
    client.send(&Command::Play).expect("done");
    assert!(client.status().expect("answers").playing);
    let mut frames = client.frames(false).expect("a place");
    until(&mut frames, |f| (f.header().steps > 3).then_some(()));
    client.send(&Command::Pause).expect("done");
    assert!(client.send(&Command::Load { file: "/no/such/file.ron".into() }).is_err());
    let wedge = sheetwork_tests::scenes_folder().join("wedge.ron").display().to_string();
    client.send(&Command::Load { file: wedge }).expect("done");
    let status = client.status().expect("answers");
    assert_eq!(status.scene, sheetwork_tests::shipped_scene("wedge").name);
    assert_eq!(sheetwork::scene::Scene::parse(&client.scene().expect("answers")).expect("valid").name, status.scene);
    // Another scene has other frames; the reader continues with them.
    client.send(&Command::Step { steps: 1 }).expect("done");
    let masses =
        |f: &sheetwork_link::Frame| f.view().expect("sound").sheets().map(|s| s.positions().len()).sum::<usize>();
    until(&mut frames, |f| (masses(f) > 45).then_some(()));
}

#[test]
fn nonsense_of_any_size_is_rejected_and_the_game_continues() {
    let place = TestLink::new("nonsense");
    let mut game = TestGame::new(&strip());
    let mut link = Link::new(&place.link, &game.world).expect("serves");
    let answered = std::thread::scope(|scope| {
        let other = scope.spawn(|| {
            let mut client = Client::attach(&place.link).expect("attaches");
            client.set_timeout(super::place::WAIT_TIMEOUT);
            let mut random = sheetwork_tests::Random::new(4);
            let mut refused = 0;
            for length in [0, 1, 2, 7, 100, 4000, 16 << 10] {
                let noise: Vec<u8> = (0..length).map(|_| (random.signed() * 128.0) as i8 as u8).collect();
                refused += u32::from(matches!(client.send_bytes(&noise), Err(LinkError::Refused(_))));
            }
            assert!(matches!(client.send_bytes(&vec![b' '; (16 << 10) + 1]), Err(LinkError::Refused(_))));
            let whole = Command::Set { path: "gravity".into(), value: "(0,0,0)".into() }.to_bytes();
            for cut in 0..whole.len() {
                refused += u32::from(matches!(client.send_bytes(&whole[..cut]), Err(LinkError::Refused(_))));
            }
            (refused, whole.len() as u32 + 7)
        });
        while !other.is_finished() {
            game.world.step();
            link.exchange(&mut game, 1e-3);
        }
        other.join().expect("no panic")
    });
    assert_eq!(answered.0, answered.1);
    assert_eq!(game.world.gravity().y, -9.81);
    assert_eq!(link.statistics().accepted, 0);
}
