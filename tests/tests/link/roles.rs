//! What this program is when it is started by a test. Started by hand these end at once.

use std::path::Path;
use std::time::{Duration, Instant};

use iceoryx2::prelude::*;
use sheetwork::link::layout::FrameHeader;
use sheetwork::link::{Client, Host, Link, LinkError, LinkPlace};
use sheetwork::scene::Scene;
use sheetwork::{InputError, World};

use super::place::PATIENCE;

/// Longest that a process lives whose test has died.
const LONGEST: Duration = Duration::from_secs(600);

fn role(name: &str) -> bool {
    std::env::var("SHEETWORK_ROLE").as_deref() == Ok(name)
}

fn place() -> LinkPlace {
    LinkPlace::new("").expect("named in the environment")
}

/// A small sheet, clamped at one edge.
pub fn strip() -> Scene {
    Scene::parse(
        r#"(name: "strip", dt: 0.004166666666666667, engine: "tr-bdf2", sheets: [(name: "strip", structure: "shell", grid: (9, 1, 5),
            size: (0.2, 0.1), material: "pet", damping_ratio: 0.2, pins: [(region: Left, clamp: true)])])"#,
    )
    .expect("valid")
}

pub struct Game {
    pub world: World,
    pub playing: bool,
}

impl Game {
    pub fn new(scene: &Scene) -> Self {
        Self { world: World::new(scene).expect("valid"), playing: true }
    }
}

impl Host for Game {
    fn world(&self) -> &World {
        &self.world
    }

    fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    fn playing(&self) -> bool {
        self.playing
    }

    fn play(&mut self, playing: bool) -> Result<(), InputError> {
        self.playing = playing;
        Ok(())
    }

    fn load(&mut self, file: &Path) -> Result<(), InputError> {
        self.world = World::new(&Scene::load(file)?)?;
        Ok(())
    }
}

/// A game at 240 Hz, or as fast as it can with SHEETWORK_FAST.
#[test]
#[ignore = "a role"]
fn game() {
    if !role("game") {
        return;
    }
    let mut game = Game::new(&strip());
    game.playing = std::env::var_os("SHEETWORK_PAUSED").is_none();
    let fast = std::env::var_os("SHEETWORK_FAST").is_some();
    game.world.set_sleep(false);
    let mut link = Link::new(&place(), &game.world).expect("serves");
    let start = Instant::now();
    while start.elapsed() < LONGEST {
        if game.playing {
            game.world.step();
        }
        link.exchange(&mut game, 1e-3);
        if !fast {
            std::thread::sleep(Duration::from_micros(4000));
        }
    }
}

/// A reader of SHEETWORK_FRAMES frames, or for ever.
#[test]
#[ignore = "a role"]
fn reader() {
    if !role("reader") {
        return;
    }
    let wanted = std::env::var("SHEETWORK_FRAMES").ok().and_then(|n| n.parse().ok()).unwrap_or(u64::MAX);
    let client = Client::attach_within(&place(), PATIENCE).expect("a game");
    let mut frames = client.frames(true).expect("a place");
    let mut last = None;
    for read in 0..wanted {
        let frame = frames.wait(PATIENCE).expect("frames");
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

/// Tries to attach; well when it is refused.
#[test]
#[ignore = "a role"]
fn intruder() {
    if role("intruder") {
        let refused = Client::attach(&place()).err().expect("refused");
        assert!(matches!(refused, LinkError::Refused(_)), "{refused}");
    }
}

/// A game that writes frames of another layout, of a wrong size, and nonsense.
#[test]
#[ignore = "a role"]
fn liar() {
    if !role("liar") {
        return;
    }
    let place = place();
    let mut honest = Link::new(&LinkPlace::within(place.root(), "honest").expect("a name"), &Game::new(&strip()).world)
        .expect("makes the folder");
    honest.look_again();
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
        if start.elapsed() > LONGEST {
            return;
        }
    }
}

type Path_ = iceoryx2::prelude::Path;

/// A game and its reader with 8 MiB of shared memory, which someone fills and empties again.
#[test]
#[ignore = "a role"]
fn crowded() {
    if !role("crowded") {
        return;
    }
    let mut game = Game::new(&strip());
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
    // Those who are there go on, in memory that is theirs; those who come are not served; nobody dies.
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
