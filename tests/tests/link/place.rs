//! A folder for a link, and the processes of a test, which end with it.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use sheetwork_link::Client;
use sheetwork_link::Frames;
use sheetwork_link::link_place::LinkPlace;

/// Time limit of every wait, long enough for a busy machine.
pub const WAIT_TIMEOUT: Duration = Duration::from_secs(60);

/// Program of the roles of other processes.
pub const ROLES: &str = env!("CARGO_BIN_EXE_link_role");

/// The link of one test.
pub struct TestLink {
    folder: PathBuf,
    pub link: LinkPlace,
}

impl TestLink {
    pub fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("sheetwork-test-{test}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        let link = LinkPlace::within(&folder, test).expect("a name");
        Self { folder, link }
    }

    /// Starts the role program in this folder, with further settings in the environment.
    pub fn start(&self, role: &str, more: &[(&str, &str)]) -> Process {
        self.start_by(Command::new(ROLES), role, more)
    }

    pub fn start_by(&self, mut program: Command, role: &str, more: &[(&str, &str)]) -> Process {
        program.arg(role);
        program.env("SHEETWORK_LINK_ROOT", self.link.root()).env("SHEETWORK_LINK", self.link.name());
        program.envs(more.iter().copied());
        Process(program.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::inherit()).spawn().expect("starts"))
    }

    pub fn attach(&self) -> Client {
        let mut client = Client::attach_within(&self.link, WAIT_TIMEOUT).expect("a game");
        client.set_timeout(WAIT_TIMEOUT);
        client
    }

    /// Number of objects of this link in shared memory, without iceoryx2's permanent counter of
    /// nodes.
    pub fn objects(&self) -> usize {
        let prefix = self.link.prefix();
        let all = std::fs::read_dir("/dev/shm").into_iter().flatten().flatten();
        let names = all.map(|e| e.file_name().to_string_lossy().into_owned());
        names.filter(|n| n.starts_with(&prefix) && !n.ends_with(".global_mgmt")).count()
    }
}

impl Drop for TestLink {
    fn drop(&mut self) {
        // Remains of killed processes: objects with this folder's prefix, and the folder.
        let prefix = self.link.prefix();
        for entry in std::fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(&prefix) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Another process, killed at the end of its test.
pub struct Process(pub Child);

impl Process {
    /// Sends SIGKILL.
    pub fn kill(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }

    /// Sends any signal, by its name.
    pub fn signal(&self, name: &str) {
        let done = Command::new("kill").args([&format!("-{name}"), &self.0.id().to_string()]).status();
        assert!(done.expect("kill runs").success(), "kill -{name}");
    }

    /// Waits for the end of the process; whether it succeeded.
    pub fn ended_well(&mut self) -> bool {
        let start = Instant::now();
        while start.elapsed() < WAIT_TIMEOUT {
            if let Some(status) = self.0.try_wait().expect("a child") {
                return status.success();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        false
    }

    /// Present private memory, bytes.
    pub fn resident(&self) -> u64 {
        let text = std::fs::read_to_string(format!("/proc/{}/smaps_rollup", self.0.id())).unwrap_or_default();
        let line = text.lines().find(|l| l.starts_with("Pss_Anon:")).unwrap_or_default();
        line.split_whitespace().nth(1).and_then(|kb| kb.parse::<u64>().ok()).unwrap_or(0) * 1024
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.kill();
    }
}

/// Waits for a frame for which `wanted` returns a value.
pub fn until<T>(frames: &mut Frames, mut wanted: impl FnMut(&sheetwork_link::Frame) -> Option<T>) -> T {
    let start = Instant::now();
    while start.elapsed() < WAIT_TIMEOUT {
        if let Ok(frame) = frames.wait(Duration::from_millis(200))
            && let Some(found) = wanted(&frame)
        {
            return found;
        }
    }
    panic!("no such frame in {WAIT_TIMEOUT:?}");
}
