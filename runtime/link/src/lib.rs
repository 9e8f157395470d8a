//! The live link: other processes read a running world in shared memory and change its parameters.
//!
//! A game owns a [`Link`]. After its steps it calls [`Link::exchange`], which answers the commands
//! received since the last call, in order, and then publishes the world. Up to twelve other
//! processes own a [`Client`] each, in Rust, in Python (`runtime/link/python`) or on the command
//! line (`sheetwork watch`, `set`, ...).
//!
//! Output is frames ([`layout`]), written directly into shared memory
//! ([iceoryx2](https://iceoryx.io)), and events. Input is commands ([`Command`]), each with an
//! answer. Without readers nothing is written: the cost for the game is then the check for readers.
//!
//! | stream | content | purpose |
//! |---|---|---|
//! | `frames` | positions, contact flags, temperature | motion |
//! | `fields` | frames with normals, strain and energies, which cost time | analysis |
//! | `topology` | triangles of each sheet, after changes | drawing |
//! | `events` | one JSON object each | logs, triggers |
//! | `control` | commands and their answers, JSON | parameters |
//!
//! Either end may terminate at any moment. Readers of a stopped game wait, and see another epoch
//! after its restart. A game never waits for a reader: a slow or stopped reader misses frames.
//! Remains of a terminated process are removed by the next one. Permissions: [`link_place`].

pub(crate) mod attached_process;
pub(crate) mod client;
pub(crate) mod command;
pub(crate) mod command_handler;
pub(crate) mod grabs;
pub mod layout;
pub mod link_place;
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

pub use crate::attached_process::AttachedProcess;
pub use crate::client::{Client, GrabForce, RemoteParameter};
pub use crate::command::{Command, GameStatus, Host};
pub use crate::link_place::LinkPlace;
pub use crate::reader::{Events, Frame, Frames, Topology};
pub use crate::server::{Link, LinkStatistics};

/// Variant of iceoryx2: inter-process, with ports that may move between threads.
type Ipc = ipc_threadsafe::Service;

/// Maximum number of readers of a stream, and of processes that send commands.
pub const MAXIMUM_CLIENTS: usize = 12;

/// A frame and a topology of `world` as a game would write them, for tests of readers.
pub fn samples(world: &World) -> (Vec<u8>, Vec<u8>) {
    let plan = plan::FramePlan::new(world);
    let mut frame = vec![0; plan.bytes[1]];
    let moment = write::FrameStamp { epoch: 1, frame: 0, topology: 1, step_time: 0.0, written_at: 0, playing: true };
    write::frame(&plan, world, &moment, true, &mut frame);
    let mut meshes = vec![0; topology::bytes(&plan)];
    topology::write(&plan, world, (1, 1), &mut meshes);
    (frame, meshes)
}

/// Errors of a link.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinkError {
    /// No game serves a link of this name.
    #[error("no game serves the link \"{0}\"{1}")]
    NoGame(String, String),
    /// Another process serves the link.
    #[error("another process already serves the link \"{0}\"; choose another name, for example with the variable {variable}",
        variable = link_place::NAME_VARIABLE)]
    Taken(String),
    /// A rejection by the game or this library, with the reason.
    #[error("{0}")]
    Refused(String),
    /// No answer from the game in time.
    #[error("the game does not answer")]
    Silent,
    /// The other end has another version or is not Sheetwork.
    #[error("the other end does not fit: {0}")]
    Unlike(String),
    /// The maximum number of processes is attached; the text names the operation.
    #[error("no more than {most} processes may {0} at once, and as many do: end one of them, and try again half a second later",
        most = MAXIMUM_CLIENTS)]
    Full(&'static str),
    /// Shared memory is exhausted or not permitted.
    #[error("shared memory: {0}")]
    Memory(String),
}

impl From<LinkError> for sheetwork::InputError {
    fn from(error: LinkError) -> Self {
        Self::new("link", error.to_string())
    }
}

/// Number of checks, 50 ms apart, for unfinished objects in shared memory before a start.
const CLEAN_UP_ATTEMPTS: usize = 40;

/// Removes the remains of terminated processes at `place`.
fn clean_up(node: &Node<Ipc>, place: &LinkPlace) {
    if place.remove_unfinished() {
        node.try_cleanup_dead_nodes();
    }
}

/// Limits the log of iceoryx2 to fatal messages, unless `IOX2_LOG_LEVEL` is set.
fn quiet_log() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| set_log_level_from_env_or(LogLevel::Fatal));
}

/// Creates a node at a place and removes the remains of terminated processes there.
fn node_at(place: &LinkPlace, name: &str) -> Result<Node<Ipc>, LinkError> {
    quiet_log();
    place.prepare_folder()?;
    if link_place::free_shared_memory() < stream::FREE_MEMORY_MARGIN {
        return Err(LinkError::Memory("/dev/shm is full".into()));
    }
    // The creation of a node cleans up first.
    for _ in 0..CLEAN_UP_ATTEMPTS {
        if place.remove_unfinished() {
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

/// CLOCK_MONOTONIC of the machine, common to all its processes, ns.
pub fn monotonic_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}
