//! Knobs: what is allowed is done by the next step, what is not is refused with a reason and changes nothing.

use sheetwork::link::{Client, Command, Link, LinkError};

use super::place::{Place, until};
use sheetwork_tests::game::{Game, strip};

#[test]
fn parameters_are_listed_set_in_order_and_refused_with_reasons() {
    let place = Place::new("knobs");
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
    // The next step already has it: with gravity turned round the free edge goes up.
    let mut frames = client.frames(false).expect("a place");
    let height = |f: &sheetwork::link::Frame| f.view().expect("sound").sheets().next().expect("one").positions()[8][1];
    let before = until(&mut frames, |f| Some(height(f)));
    client.set("gravity", "(0, 50, 0)").expect("accepted");
    let answer = client.send(&Command::Step { steps: 1 }).expect("done");
    let after = until(&mut frames, |f| (Some(f.header().steps) == answer["steps"].as_u64()).then(|| height(f)));
    assert!(after > before, "{before} m, then {after} m");
}

#[test]
fn commands_play_step_reset_keep_and_restore() {
    let place = Place::new("commands");
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
    assert_eq!(status.scene, sheetwork_tests::shipped("wedge").name);
    assert_eq!(sheetwork::scene::Scene::parse(&client.scene().expect("answers")).expect("valid").name, status.scene);
    // Another scene has other frames: the reader goes on with them.
    client.send(&Command::Step { steps: 1 }).expect("done");
    let masses =
        |f: &sheetwork::link::Frame| f.view().expect("sound").sheets().map(|s| s.positions().len()).sum::<usize>();
    until(&mut frames, |f| (masses(f) > 45).then_some(()));
}

#[test]
fn nonsense_of_any_size_is_refused_and_the_game_goes_on() {
    let place = Place::new("nonsense");
    let mut game = Game::new(&strip());
    let mut link = Link::new(&place.link, &game.world).expect("serves");
    let answered = std::thread::scope(|scope| {
        let other = scope.spawn(|| {
            let mut client = Client::attach(&place.link).expect("attaches");
            client.set_patience(super::place::PATIENCE);
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
