//! Process failures: either end is killed, stopped or sends invalid data; the other continues, and
//! the next attach succeeds.

use std::io::{BufRead, BufReader};
use std::process::Command;
use std::time::{Duration, Instant};

use sheetwork_link::Client;
use sheetwork_link::LinkError;
use sheetwork_tests::Random;

use super::place::{Process, ROLES, TestLink, WAIT_TIMEOUT, until};

/// Number of kills.
fn kills() -> u32 {
    std::env::var("SHEETWORK_LINK_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(8)
}

/// A random duration of up to `most`.
fn moment(random: &mut Random, most: Duration) -> Duration {
    most.mul_f64(0.5 + 0.5 * random.signed().clamp(-1.0, 1.0))
}

#[test]
fn a_game_survives_killed_readers() {
    let place = TestLink::new("killed-readers");
    let _game = place.start("game", &[]);
    let client = place.attach();
    let mut frames = client.frames(false).expect("a place");
    let mut random = Random::new(1);
    for _ in 0..kills() {
        let before = until(&mut frames, |f| Some(*f.header()));
        let mut reader = place.start("reader", &[]);
        std::thread::sleep(moment(&mut random, Duration::from_millis(200)));
        reader.kill();
        until(&mut frames, |f| (f.header().epoch == before.epoch && f.header().steps > before.steps + 5).then_some(()));
        client.status().expect("answers");
    }
    // All reader slots are free again.
    let mut last = place.start("reader", &[("SHEETWORK_FRAMES", "3")]);
    assert!(last.ended_well());
    let start = Instant::now();
    while place.attach().frames(true).is_err() {
        assert!(start.elapsed() < WAIT_TIMEOUT, "a dead reader keeps its place");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn a_reader_continues_after_killed_games() {
    let place = TestLink::new("killed-games");
    let mut random = Random::new(2);
    let mut game = place.start("game", &[]);
    let watcher = place.attach();
    let mut frames = watcher.frames(true).expect("a place");
    let mut epoch = until(&mut frames, |f| Some(f.header().epoch));
    for kill in 1..=kills() {
        std::thread::sleep(moment(&mut random, Duration::from_millis(100)));
        game.kill();
        game = place.start("game", &[]);
        epoch = until(&mut frames, |f| (f.header().epoch != epoch).then_some(f.header().epoch));
        assert_eq!((frames.restarts(), frames.faulty()), (u64::from(kill), 0));
        let fresh = place.attach();
        let answer = fresh.send(&sheetwork_link::Command::Status).expect("the next attach succeeds");
        assert_eq!(answer["epoch"].as_u64(), Some(epoch));
    }
    // A stopped game does not count as terminated, and continues.
    game.signal("STOP");
    let mut hasty = Client::attach(&place.link).expect("attaches");
    hasty.set_timeout(Duration::from_millis(100));
    assert!(matches!(hasty.status(), Err(LinkError::Silent)));
    game.signal("CONT");
    until(&mut frames, |f| (f.header().epoch == epoch).then_some(()));
}

#[test]
fn remains_of_a_killed_game_are_removed_by_the_next() {
    let place = TestLink::new("leftovers");
    let mut game = place.start("game", &[]);
    drop(place.attach());
    game.kill();
    assert!(place.objects() > 0, "it had no time to clean up");
    let world = sheetwork::World::new(&sheetwork_tests::game::strip()).expect("valid");
    drop(sheetwork_link::Link::new(&place.link, &world).expect("serves"));
    assert_eq!(place.objects(), 0);
    assert!(matches!(Client::attach(&place.link).err(), Some(LinkError::NoGame(..))));
}

/// A process killed between the creation of an object and the setting of its size leaves an object
/// for which iceoryx2 alone would wait without a time limit.
#[test]
fn an_unfinished_object_blocks_no_process() {
    let place = TestLink::new("unfinished");
    let mut game = place.start("game", &[]);
    let mut reader = place.start("reader", &[]);
    assert!(heard_first(&mut reader, "reading"));
    reader.kill();
    game.kill();
    let mut unfinished = 0;
    for entry in std::fs::read_dir("/dev/shm").expect("there").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with(&place.link.prefix()) && name.ends_with(".connection") {
            let object = std::fs::File::options().write(true).open(entry.path()).expect("this user's");
            object.set_len(0).expect("cut");
            unfinished += 1;
        }
    }
    assert!(unfinished > 0, "a reader was connected");
    let (done, ended) = std::sync::mpsc::channel();
    let link = place.link.clone();
    std::thread::spawn(move || {
        let world = sheetwork::World::new(&sheetwork_tests::game::strip()).expect("valid");
        drop(sheetwork_link::Link::new(&link, &world).expect("serves"));
        let _ = done.send(());
    });
    assert!(ended.recv_timeout(WAIT_TIMEOUT).is_ok(), "the next game waits for the dead");
    assert_eq!(place.objects(), 0);
}

/// Whether a process prints a line; reads up to that line.
fn heard_first(child: &mut Process, wanted: &str) -> bool {
    let Some(out) = child.0.stdout.take() else { return false };
    BufReader::new(out).lines().map_while(Result::ok).any(|line| line.contains(wanted))
}

#[test]
fn frames_of_another_layout_or_size_are_reported_and_harmless() {
    let place = TestLink::new("liar");
    let _liar = place.start("liar", &[]);
    let mut client = place.attach();
    client.set_timeout(Duration::from_secs(5));
    let mut frames = client.frames(false).expect("a place");
    let (start, mut told) = (Instant::now(), Vec::new());
    while told.len() < 8 && start.elapsed() < WAIT_TIMEOUT {
        match frames.next() {
            Err(LinkError::Unlike(what)) => told.push(what),
            Ok(None) => std::thread::sleep(Duration::from_millis(1)),
            Ok(Some(_)) => panic!("nonsense was taken for a frame"),
            Err(error) => panic!("{error}"),
        }
    }
    assert!(told.iter().any(|t| t.contains("layout 9")), "{told:?}");
    assert!(told.iter().any(|t| t.contains("no frame")), "{told:?}");
    assert!(matches!(client.status(), Err(LinkError::Unlike(_))));
}

#[test]
fn full_shared_memory_kills_no_process() {
    let place = TestLink::new("crowded");
    let mut inside = Command::new("unshare");
    inside.args(["-m", "sh", "-c", "mount -t tmpfs -o size=8m tmpfs /dev/shm && exec \"$@\"", "sh"]).arg(ROLES);
    let possible =
        Command::new("unshare").args(["-m", "sh", "-c", "mount -t tmpfs -o size=8m tmpfs /dev/shm"]).output();
    if !possible.is_ok_and(|o| o.status.success()) {
        eprintln!("skipped: a /dev/shm of its own needs unshare and the rights of root");
        return;
    }
    let mut child = place.start_by(inside, "crowded", &[]);
    let survived = heard(&mut child, "survived");
    assert!(child.ended_well() && survived);
}

/// Whether a process prints a line.
fn heard(child: &mut Process, wanted: &str) -> bool {
    let Some(out) = child.0.stdout.take() else { return false };
    // Reads to the end, because the process must not write to a closed pipe.
    BufReader::new(out).lines().map_while(Result::ok).filter(|line| line.contains(wanted)).count() > 0
}

#[test]
fn another_user_cannot_attach() {
    use std::os::unix::fs::PermissionsExt;
    use std::os::unix::process::CommandExt;
    let place = TestLink::new("intruder");
    let world = sheetwork::World::new(&sheetwork_tests::game::strip()).expect("valid");
    let _link = sheetwork_link::Link::new(&place.link, &world).expect("serves");
    let mode = |p: &std::path::Path| std::fs::metadata(p).expect("there").permissions().mode() & 0o777;
    assert_eq!(mode(place.link.root()), 0o700);
    for entry in std::fs::read_dir("/dev/shm").expect("there").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        // iceoryx2's counter of nodes, 16 bytes, is accessible to all users and holds no data of
        // the link.
        if name.starts_with(&place.link.prefix()) && !name.ends_with(".global_mgmt") {
            assert_eq!(mode(&entry.path()) & 0o077, 0, "{:?}", entry.path());
        }
    }
    // As user `nobody`, from a copy of the program that this user may read.
    let copy = std::env::temp_dir().join(format!("sheetwork-intruder-{}", std::process::id()));
    std::fs::copy(ROLES, &copy).expect("copied");
    std::fs::set_permissions(&copy, std::fs::Permissions::from_mode(0o755)).expect("set");
    let mut program = Command::new(&copy);
    program.uid(65534).current_dir("/");
    let may = Command::new("true").uid(65534).status().is_ok();
    if may {
        assert!(place.start_by(program, "intruder", &[]).ended_well());
    } else {
        eprintln!("skipped: to be another user needs the rights of root");
    }
    let _ = std::fs::remove_file(copy);
    // A folder open to others is rejected.
    std::fs::set_permissions(place.link.root(), std::fs::Permissions::from_mode(0o755)).expect("set");
    assert!(matches!(Client::attach(&place.link).err(), Some(LinkError::Refused(_))));
}
