//! The live link: other processes see a running world in shared memory and turn its knobs.
//!
//! A game holds a [`Link`]. After its steps it calls [`Link::exchange`], which answers what other processes asked since the last
//! time, in the order they asked, and then shows them the world. Others hold a [`Client`]: any number of processes up to twelve, in
//! Rust, in Python (`runtime/link/python`) or on the command line (`sheetwork watch`, `set`, ...).
//!
//! Out go frames ([`layout`]), written straight into shared memory ([iceoryx2](https://iceoryx.io)), and events. In come
//! commands ([`Command`]), each with an answer. With nobody there nothing is written: the game then pays for looking whether there is.
//!
//! | stream | what | for |
//! |---|---|---|
//! | `frames` | positions, contact flags, temperature | whoever follows the motion |
//! | `fields` | the same with normals, strain and energies | whoever needs those: they cost time |
//! | `topology` | which masses make triangles, when that changes | whoever draws |
//! | `events` | what happened, one JSON object each | logs, triggers |
//! | `control` | commands and their answers, JSON | knobs |
//!
//! Either end may die at any moment. Readers of a stopped game wait, and see another epoch when it starts again. A game never
//! waits for a reader: one that is slow or stopped misses frames. What a dead process leaves behind, the next one removes.
//! Who may attach: [`place`].

pub(crate) mod answer;
pub(crate) mod attached;
pub(crate) mod client;
pub(crate) mod command;
pub(crate) mod grabs;
pub mod layout;
pub mod place;
pub(crate) mod plan;
pub(crate) mod reader;
pub(crate) mod server;
pub(crate) mod stream;
#[cfg(test)]
mod tests;
pub mod topology;
pub(crate) mod write;

use std::time::Duration;

use iceoryx2::prelude::*;

use sheetwork::World;

pub use crate::attached::Attached;
pub use crate::client::{Client, PulledTo, RemoteParameter};
pub use crate::command::{Command, Host, Standing};
pub use crate::place::LinkPlace;
pub use crate::reader::{Events, Frame, Frames, Topology};
pub use crate::server::{Link, LinkStatistics};

/// Variant of iceoryx2: between processes, ports that may move between threads.
type Ipc = ipc_threadsafe::Service;

/// Most readers of a stream, and most processes that send commands.
pub const MOST_CLIENTS: usize = 12;

/// A frame and a topology of `world` as a game would write them: to try readers on.
pub fn samples(world: &World) -> (Vec<u8>, Vec<u8>) {
    let plan = plan::Plan::new(world);
    let mut frame = vec![0; plan.bytes[1]];
    let moment = write::Moment { epoch: 1, frame: 0, topology: 1, step_time: 0.0, written_at: 0, playing: true };
    write::frame(&plan, world, &moment, true, &mut frame);
    let mut meshes = vec![0; topology::bytes(&plan)];
    topology::write(&plan, world, (1, 1), &mut meshes);
    (frame, meshes)
}

/// Why a link, or something asked of it, did not come about.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinkError {
    /// No game serves a link of this name.
    #[error("no game serves the link \"{0}\"{1}")]
    NoGame(String, String),
    /// Another process serves it already.
    #[error("another process already serves the link \"{0}\"; give this one another name")]
    Taken(String),
    /// The game, or this library, refused, and why.
    #[error("{0}")]
    Refused(String),
    /// The game did not answer in time.
    #[error("the game does not answer")]
    Silent,
    /// The other end is of another version, or no Sheetwork.
    #[error("the other end does not fit: {0}")]
    Unlike(String),
    /// As many are attached as may be; what no more of them can do.
    #[error("no more than {most} processes may {0} at once, and as many do: end one of them, and try again half a second later",
        most = MOST_CLIENTS)]
    Full(&'static str),
    /// Shared memory cannot be had: full, or not allowed.
    #[error("shared memory: {0}")]
    Memory(String),
}

impl From<LinkError> for sheetwork::InputError {
    fn from(error: LinkError) -> Self {
        Self::new("link", error.to_string())
    }
}

/// Times that it is looked again, 50 ms apart, whether what is unfinished in shared memory may be removed.
const TIDYINGS: usize = 40;

/// Removes what dead processes have left at `place`.
fn clean_up(node: &Node<Ipc>, place: &LinkPlace) {
    if place.tidy() {
        node.try_cleanup_dead_nodes();
    }
}

/// Lets iceoryx2 say only what cannot be told otherwise, unless `IOX2_LOG_LEVEL` asks for more.
fn quiet_log() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| set_log_level_from_env_or(LogLevel::Fatal));
}

/// A node at a place, which removes what dead processes have left there.
fn node_at(place: &LinkPlace, name: &str) -> Result<Node<Ipc>, LinkError> {
    quiet_log();
    place.ready()?;
    if place::free_shared_memory() < stream::MARGIN {
        return Err(LinkError::Memory("/dev/shm is full".into()));
    }
    // A node that is made cleans up first.
    for _ in 0..TIDYINGS {
        if place.tidy() {
            break;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let memory = |e: &dyn std::fmt::Debug| LinkError::Memory(format!("no node in {}: {e:?}", place.root().display()));
    let node = NodeBuilder::new()
        .name(&NodeName::new(name).map_err(|e| memory(&e))?)
        .signal_handling_mode(SignalHandlingMode::HandleTerminationRequests)
        .config(&place.config()?);
    node.create::<Ipc>().map_err(|e| memory(&e))
}

/// Nanoseconds of the machine's CLOCK_MONOTONIC, which all its processes share.
pub fn monotonic_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}
