//! Roles of another process in tests of the live link: `link_role ROLE`, with the link and other
//! settings in the environment. A failure is a panic.

use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use iceoryx2::prelude::*;
use sheetwork::World;
use sheetwork_link::Client;
use sheetwork_link::Link;
use sheetwork_link::LinkError;
use sheetwork_link::layout::FrameHeader;
use sheetwork_link::link_place::LinkPlace;
use sheetwork_tests::game::{TestGame, strip};

/// Maximum life of a process whose test has died.
const MAXIMUM_LIFETIME: Duration = Duration::from_secs(600);
/// Time limit of every wait, long enough for a busy machine.
const WAIT_TIMEOUT: Duration = Duration::from_secs(60);

fn main() -> ExitCode {
    match std::env::args().nth(1).as_deref() {
        Some("game") => game(),
        Some("reader") => reader(),
        Some("intruder") => intruder(),
        Some("liar") => invalid_game(),
        Some("crowded") => crowded(),
        _ => {
            eprintln!("usage: link_role game|reader|intruder|liar|crowded");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}

fn place() -> LinkPlace {
    LinkPlace::new("").expect("named in the environment")
}

/// A game at 240 Hz, or at full speed with SHEETWORK_FAST.
fn game() {
    let mut game = TestGame::new(&strip());
    game.playing = std::env::var_os("SHEETWORK_PAUSED").is_none();
    let fast = std::env::var_os("SHEETWORK_FAST").is_some();
    game.world.set_sleep(false);
    let mut link = Link::new(&place(), &game.world).expect("serves");
    let start = Instant::now();
    while start.elapsed() < MAXIMUM_LIFETIME {
        if game.playing {
            game.world.step();
        }
        link.exchange(&mut game, 1e-3);
        if !fast {
            std::thread::sleep(Duration::from_micros(4000));
        }
    }
}

/// A reader of SHEETWORK_FRAMES frames, unlimited by default.
fn reader() {
    let wanted = std::env::var("SHEETWORK_FRAMES").ok().and_then(|n| n.parse().ok()).unwrap_or(u64::MAX);
    let client = Client::attach_within(&place(), WAIT_TIMEOUT).expect("a game");
    let mut frames = client.frames(true).expect("a place");
    let mut last = None;
    for read in 0..wanted {
        let frame = frames.wait(WAIT_TIMEOUT).expect("frames");
        let (header, view) = (*frame.header(), frame.view().expect("sound"));
        assert!(last.is_none_or(|(epoch, n)| epoch != header.epoch || n < header.frame), "frames go on");
        assert!(view.sheets().all(|s| s.positions().iter().flatten().all(|c| c.is_finite())));
        last = Some((header.epoch, header.frame));
        if read == 0 {
            println!("reading");
        }
        if read % 7 == 0 {
            client.status().expect("an answer");
        }
    }
}

/// Tries to attach and requires rejection.
fn intruder() {
    let refused = Client::attach(&place()).err().expect("refused");
    assert!(matches!(refused, LinkError::Refused(_)), "{refused}");
}

/// A game that writes frames of another layout, of a wrong size, and nonsense.
fn invalid_game() {
    let place = place();
    let mut honest =
        Link::new(&LinkPlace::within(place.root(), "honest").expect("a name"), &TestGame::new(&strip()).world)
            .expect("makes the folder");
    honest.invalidate_plan();
    let mut config = Config::default();
    config.global.set_root_path(&Path_::new(place.root().as_os_str().as_encoded_bytes()).expect("a path"));
    config.global.prefix = FileName::new(place.prefix().as_bytes()).expect("a prefix");
    let node = NodeBuilder::new().config(&config).create::<ipc::Service>().expect("a node");
    let name = |what: &str| ServiceName::new(&format!("sheetwork/{}/{what}", place.name())).expect("a name");
    let control = node.service_builder(&name("control")).request_response::<[u8], [u8]>().create().expect("made");
    let frames = node.service_builder(&name("frames")).publish_subscribe::<[u64]>().create().expect("made");
    let port = frames.publisher_builder().initial_max_slice_len(4096).create().expect("made");
    let server = control.server_builder().initial_max_slice_len(64).create().expect("made");
    let mut later = [0_u8; size_of::<FrameHeader>()];
    later[..8].copy_from_slice(b"sheetlnk");
    later[8] = 9;
    let words = |bytes: &[u8]| -> Vec<u64> {
        bytes.chunks_exact(8).map(|c| u64::from_le_bytes(c.try_into().expect("eight"))).collect()
    };
    let samples = [words(&later), words(&later[..16]), vec![7], vec![u64::MAX; 512]];
    let start = Instant::now();
    for sample in samples.iter().cycle() {
        let loaned = port.loan_slice_uninit(sample.len()).expect("memory");
        loaned.write_from_slice(sample).send().expect("sent");
        if let Ok(Some(request)) = server.receive()
            && let Ok(answer) = request.loan_slice_uninit(3)
        {
            let _ = answer.write_from_slice(b"{,}").send();
        }
        std::thread::sleep(Duration::from_millis(5));
        if start.elapsed() > MAXIMUM_LIFETIME {
            return;
        }
    }
}

type Path_ = iceoryx2::prelude::Path;

/// A game and its reader with 8 MiB of shared memory, which is filled and emptied again.
fn crowded() {
    let mut game = TestGame::new(&strip());
    let mut link = Link::new(&place(), &game.world).expect("there is room at first");
    let mut steps = |link: &mut Link, n: u32| {
        for _ in 0..n {
            game.world.step();
            link.exchange(&mut game, 1e-3);
        }
    };
    let client = Client::attach(&place()).expect("attaches");
    let mut frames = client.frames(false).expect("reads");
    steps(&mut link, 10);
    assert!(frames.latest().expect("sound").is_some());
    let full = Path::new("/dev/shm/full");
    let mut file = std::fs::File::create(full).expect("made");
    while std::io::Write::write_all(&mut file, &[1; 4096]).is_ok() {}
    drop(file);
    // Existing readers continue in reserved memory; new ones are rejected; no process dies.
    steps(&mut link, 1000);
    assert!(frames.latest().expect("sound").is_some(), "memory that was taken is written to");
    assert!(matches!(Client::attach(&place()).err(), Some(LinkError::Memory(_))));
    let other =
        Link::new(&LinkPlace::within(place().root(), "other").expect("a name"), &World::new(&strip()).expect("valid"));
    assert!(matches!(other.err(), Some(LinkError::Memory(_))));
    std::fs::remove_file(full).expect("removed");
    let second = Client::attach(&place()).expect("there is room again");
    let mut more = second.frames(true).expect("reads");
    steps(&mut link, 10);
    assert!(more.latest().expect("sound").is_some());
    println!("survived");
}
