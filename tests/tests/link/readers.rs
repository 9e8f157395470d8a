//! Readers: received data equals the world's, for any number of readers, without allocation and
//! without growth.

use std::time::{Duration, Instant};

use allocation_counter::measure;
use sheetwork_link::Client;
use sheetwork_link::Link;
use sheetwork_link::LinkError;

use super::place::{TestLink, WAIT_TIMEOUT, until};
use sheetwork_tests::game::{TestGame, strip};

#[test]
fn a_reader_receives_the_world_and_a_game_without_readers_writes_nothing() {
    let place = TestLink::new("sees");
    let mut game = TestGame::new(&strip());
    let mut link = Link::new(&place.link, &game.world).expect("serves");
    for _ in 0..5 {
        game.world.step();
        link.exchange(&mut game, 2e-3);
    }
    assert_eq!((link.statistics().frames, link.statistics().unread_frames, link.statistics().bytes), (0, 5, 0));
    let client = Client::attach(&place.link).expect("attaches");
    let (mut lean, mut full) = (client.frames(false).expect("reads"), client.frames(true).expect("reads"));
    let mut events = client.events().expect("reads");
    game.world.step();
    link.exchange(&mut game, 2e-3);
    for (frames, complete) in [(&mut lean, false), (&mut full, true)] {
        let frame = frames.next().expect("sound").expect("there");
        let (header, view) = (*frame.header(), frame.view().expect("sound"));
        assert_eq!((header.steps, header.time, header.epoch), (6, game.world.time(), link.epoch()));
        assert_eq!((header.step_time, header.complete), (2e-3, u32::from(complete)));
        let (seen, sheet) = (view.sheet("strip").expect("there"), &game.world.sheets()[0]);
        assert_eq!((seen.header().grid, seen.header().structure()), ([9, 1, 5], "shell"));
        assert!(seen.positions().iter().zip(sheet.state.x.iter()).all(|(p, x)| *p == x.as_vec3().to_array()));
        let energy = sheet.energy(game.world.gravity());
        assert_eq!(seen.header().energy[3] == energy.total, complete);
        assert!(frames.next().expect("sound").is_none());
    }
    // No event at first; then the sheet becomes unstable.
    assert!(events.next().expect("readable").is_none());
    game.world.sheets_mut()[0].state.v.set(44, glam::DVec3::splat(f64::NAN));
    game.world.step();
    link.exchange(&mut game, 2e-3);
    let event = events.next().expect("readable").expect("it went unstable");
    assert_eq!((event["kind"].as_str(), event["sheet"].as_str()), (Some("unstable"), Some("strip")));
    assert_eq!(event["place_m"].as_array().map(Vec::len), Some(3));
    assert!(link.statistics().events == 1 && link.statistics().dropped == 0);
}

#[test]
fn polling_allocates_nothing_and_publishing_only_within_iceoryx2() {
    let place = TestLink::new("allocates");
    let mut game = TestGame::new(&strip());
    let mut link = Link::new(&place.link, &game.world).expect("serves");
    let steps = |game: &mut TestGame, link: &mut Link| {
        game.world.step();
        link.exchange(game, 1e-3);
    };
    (0..300).for_each(|_| steps(&mut game, &mut link));
    let alone = measure(|| (0..100).for_each(|_| steps(&mut game, &mut link)));
    assert_eq!(alone.count_total, 0, "with nobody there");
    let client = Client::attach(&place.link).expect("attaches");
    let (mut lean, mut full) = (client.frames(false).expect("reads"), client.frames(true).expect("reads"));
    for _ in 0..20 {
        steps(&mut game, &mut link);
    }
    let (mut read, before) = (0, link.statistics().frames);
    let mut counted = 0;
    for _ in 0..100 {
        counted += measure(|| steps(&mut game, &mut link)).count_total;
        read += u32::from(lean.latest().expect("sound").is_some()) + u32::from(full.latest().expect("sound").is_some());
    }
    // One allocation per sample is iceoryx2's own, for the bookkeeping of loaned samples.
    assert_eq!((counted, read, link.statistics().frames - before), (200, 200, 200));
}

#[test]
fn ten_readers_and_a_stopped_one_receive_their_frames() {
    let place = TestLink::new("ten");
    let _game = place.start("game", &[]);
    let client = place.attach();
    let stopped = place.start("reader", &[]);
    let mut ten: Vec<_> = (0..10).map(|_| place.start("reader", &[("SHEETWORK_FRAMES", "40")])).collect();
    stopped.signal("STOP");
    for (index, reader) in ten.iter_mut().enumerate() {
        assert!(reader.ended_well(), "reader {index}");
    }
    let before = client.send(&sheetwork_link::Command::Status).expect("answers")["steps"].as_u64().expect("a number");
    let mut frames = client.frames(false).expect("a place is free again");
    until(&mut frames, |f| (f.header().steps > before + 20).then_some(()));
    stopped.signal("CONT");
}

#[test]
fn a_thirteenth_reader_and_a_second_game_are_rejected() {
    let place = TestLink::new("thirteen");
    let mut game = TestGame::new(&strip());
    let mut link = Link::new(&place.link, &game.world).expect("serves");
    let client = Client::attach(&place.link).expect("attaches");
    let mut all: Vec<_> = (0..12).map(|_| client.frames(false).expect("a place")).collect();
    let refused = client.frames(false).err().expect("refused");
    assert!(matches!(refused, LinkError::Full(_)) && refused.to_string().contains("12 processes"), "{refused}");
    let clients: Vec<_> = (0..11).map(|_| Client::attach(&place.link).expect("a place")).collect();
    let refused = Client::attach(&place.link).err().expect("refused");
    assert!(matches!(refused, LinkError::Full(_)) && refused.to_string().contains("12 processes"), "{refused}");
    let who = link.attached();
    assert_eq!((who.len(), who[0].process, who[0].reads, who[0].commands), (1, std::process::id(), 12, true));
    assert!(who[0].name.starts_with("link-"), "{}", who[0]);
    drop(clients);
    game.world.step();
    link.exchange(&mut game, 1e-3);
    assert!(all.iter_mut().all(|f| f.latest().expect("sound").is_some()));
    assert!(matches!(Link::new(&place.link, &game.world).err(), Some(LinkError::Taken(_))));
}

#[test]
fn a_soak_grows_neither_memory_nor_objects() {
    let seconds = std::env::var("SHEETWORK_LINK_SOAK").ok().and_then(|s| s.parse().ok()).unwrap_or(20.0);
    let place = TestLink::new("soak");
    let game = place.start("game", &[("SHEETWORK_FAST", "1")]);
    let client = place.attach();
    let mut frames = client.frames(false).expect("a place");
    let begin = Instant::now();
    let (mut warm, mut count) = (None, 0_u64);
    // A busy machine may take longer for the required frames.
    while begin.elapsed().as_secs_f64() < seconds || (count <= 100 && begin.elapsed() < WAIT_TIMEOUT) {
        count += u64::from(frames.latest().expect("sound").is_some());
        if count % 50 == 0 {
            // Other readers attach and detach meanwhile.
            drop(client.frames(true).expect("a place"));
            client.set("gravity", "(0, -9.81, 0)").expect("accepted");
        }
        if warm.is_none() && begin.elapsed().as_secs_f64() > 0.3 * seconds {
            warm = Some((game.resident(), place.objects()));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let (memory, objects) = warm.expect("warm by now");
    let (memory_now, objects_now) = (game.resident(), place.objects());
    assert!(count > 100, "{count} frames");
    assert!(objects_now <= objects + 2, "{objects} objects, then {objects_now}");
    assert!(memory > 0 && memory_now <= memory + (256 << 10), "{memory} bytes, then {memory_now}");
    eprintln!("soak: {count} frames read, {memory_now} bytes, {objects_now} objects");
}
