//! The client's end of a link: commands to a game, and access to its streams.
//!
//! Streams are read by `reader`.

use std::sync::Arc;
use std::time::{Duration, Instant};

use iceoryx2::port::client::Client as Port;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::client::ClientCreateError;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::command::{Command, GameStatus, MAXIMUM_COMMAND_BYTES};
use crate::link_place::LinkPlace;
use crate::reader::{Events, Frames, POLL_INTERVAL, Topology};
use crate::server::{Control, control};
use crate::{Ipc, LinkError, clean_up, node_at};

/// A connection to a game.
pub struct Client {
    place: LinkPlace,
    timeout: Duration,
    port: Port<Ipc, [u8], (), [u8], ()>,
    control: Control,
    node: Arc<Node<Ipc>>,
}

/// Part of an answer.
#[derive(Deserialize)]
struct AnswerPart<T> {
    #[serde(alias = "params", alias = "text")]
    content: T,
    /// Index for the next request.
    next: Option<usize>,
}

/// A parameter of a running game.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct RemoteParameter {
    /// Path.
    pub path: String,
    /// Value, as text that `set` accepts.
    pub value: String,
    /// Unit; empty for a name or a plain number.
    pub unit: String,
    /// "number" (or "none" for an optional number without a value), "vector", "boolean" or "name".
    pub kind: String,
    /// Minimum of a number.
    pub min: Option<f64>,
    /// Maximum of a number.
    pub max: Option<f64>,
}

impl RemoteParameter {
    /// Value of a number.
    pub fn number(&self) -> Option<f64> {
        if self.kind == "number" { self.value.parse().ok() } else { None }
    }

    /// Value of a boolean.
    pub fn boolean(&self) -> Option<bool> {
        if self.kind == "boolean" { self.value.parse().ok() } else { None }
    }

    /// Value of a vector.
    pub fn vector(&self) -> Option<[f64; 3]> {
        let inner = self.value.strip_prefix('(').and_then(|v| v.strip_suffix(')')).filter(|_| self.kind == "vector")?;
        let parts: Result<Vec<f64>, _> = inner.split(',').map(|c| c.trim().parse()).collect();
        parts.ok()?.try_into().ok()
    }
}

/// Force and position of a grab.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct GrabForce {
    /// Force on the hand, N.
    pub force: [f64; 3],
    /// Position of the grabbed point, m.
    pub position: [f64; 3],
    /// Simulated time, s.
    pub time: f64,
}

impl Client {
    /// Attaches to the game that serves `place`.
    ///
    /// # Errors
    /// No game, another version, or missing permission.
    pub fn attach(place: &LinkPlace) -> Result<Self, LinkError> {
        // A missing folder means that no game has served there; it is not created.
        if !place.root().exists() {
            return Err(LinkError::NoGame(place.name().into(), String::new()));
        }
        let node = Arc::new(node_at(place, "sheetwork client")?);
        let control = control(&node, place, false).map_err(|e| with_others(e, place))?;
        if control.dynamic_config().number_of_servers() == 0 {
            return Err(with_others(LinkError::NoGame(place.name().into(), String::new()), place));
        }
        let port = control.client_builder().initial_max_slice_len(MAXIMUM_COMMAND_BYTES);
        let port = port.allocation_strategy(AllocationStrategy::Static);
        let port = port.backpressure_strategy(BackpressureStrategy::DiscardData).create();
        let port = port.map_err(|e| match e {
            ClientCreateError::ExceedsMaxSupportedClients => LinkError::Full("command a game"),
            e => LinkError::Memory(format!("no port for commands: {e:?}")),
        })?;
        Ok(Self { place: place.clone(), timeout: Duration::from_secs(2), port, control, node })
    }

    /// Attaches, and waits up to `patience` for a game.
    ///
    /// # Errors
    /// As [`Client::attach`], after that time.
    pub fn attach_within(place: &LinkPlace, patience: Duration) -> Result<Self, LinkError> {
        let start = Instant::now();
        loop {
            match Self::attach(place) {
                Err(LinkError::NoGame(..) | LinkError::Memory(_) | LinkError::Full(_))
                    if start.elapsed() < patience =>
                {
                    std::thread::sleep(Duration::from_millis(20));
                }
                result => return result,
            }
        }
    }

    /// Sets the time limit for answers; 2 s by default.
    pub fn set_timeout(&mut self, patience: Duration) {
        self.timeout = patience;
    }

    /// Place of the link.
    pub fn place(&self) -> &LinkPlace {
        &self.place
    }

    /// Whether a game serves the link. A killed game counts until its remains are removed.
    pub fn is_served(&self) -> bool {
        self.control.dynamic_config().number_of_servers() > 0
    }

    /// Sends a command and returns the JSON object of its answer.
    ///
    /// # Errors
    /// A rejected command, or no answer in time.
    pub fn send(&self, command: &Command) -> Result<Map<String, Value>, LinkError> {
        self.send_bytes(&command.to_bytes())
    }

    /// Sends bytes as a command and returns the answer.
    ///
    /// # Errors
    /// Too many bytes, a rejected command, or no answer in time.
    pub fn send_bytes(&self, bytes: &[u8]) -> Result<Map<String, Value>, LinkError> {
        if bytes.len() > MAXIMUM_COMMAND_BYTES {
            return Err(LinkError::Refused(format!(
                "the command has {} bytes; at most {MAXIMUM_COMMAND_BYTES} go",
                bytes.len()
            )));
        }
        let request = self.port.loan_slice_uninit(bytes.len()).map_err(|e| LinkError::Memory(format!("{e:?}")))?;
        let pending = request.write_from_slice(bytes).send().map_err(|e| LinkError::Memory(format!("{e:?}")))?;
        let start = Instant::now();
        loop {
            match pending.receive() {
                Ok(Some(answer)) => return read_answer(answer.payload()),
                Ok(None) => {}
                Err(e) => return Err(LinkError::Memory(format!("{e:?}"))),
            }
            if start.elapsed() > self.timeout {
                clean_up(&self.node, &self.place);
                return Err(LinkError::Silent);
            }
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    fn ask<T: DeserializeOwned>(&self, command: &Command) -> Result<T, LinkError> {
        let answer = self.send(command)?;
        serde_json::from_value(Value::Object(answer)).map_err(|e| LinkError::Unlike(format!("an answer: {e}")))
    }

    /// All parts of an answer that is longer than one message.
    fn ask_for_parts<T: DeserializeOwned>(&self, command: impl Fn(usize) -> Command) -> Result<Vec<T>, LinkError> {
        let (mut all, mut from) = (Vec::new(), 0);
        loop {
            let part: AnswerPart<T> = self.ask(&command(from))?;
            all.push(part.content);
            match part.next {
                // Only increasing indices, so that the loop terminates for any answer.
                Some(next) if next > from => from = next,
                _ => return Ok(all),
            }
        }
    }

    /// Status of the game.
    ///
    /// # Errors
    /// No answer.
    pub fn status(&self) -> Result<GameStatus, LinkError> {
        self.ask(&Command::Status)
    }

    /// All parameters of the running world.
    ///
    /// # Errors
    /// No answer.
    pub fn parameters(&self) -> Result<Vec<RemoteParameter>, LinkError> {
        let parts: Vec<Vec<RemoteParameter>> = self.ask_for_parts(|from| Command::Params { from })?;
        Ok(parts.into_iter().flatten().collect())
    }

    /// One parameter.
    ///
    /// # Errors
    /// An unknown path, or no answer.
    pub fn get(&self, path: &str) -> Result<RemoteParameter, LinkError> {
        self.ask(&Command::Get { path: path.into() })
    }

    /// Sets a parameter, in effect from the next step, and returns the old value. The value is a
    /// number, a boolean, or text as in a scene file.
    ///
    /// # Errors
    /// A rejected value, with the reason, or no answer.
    pub fn set(&self, path: &str, value: impl std::fmt::Display) -> Result<String, LinkError> {
        let answer = self.send(&Command::Set { path: path.into(), value: value.to_string() })?;
        Ok(answer.get("old").and_then(Value::as_str).unwrap_or_default().to_owned())
    }

    /// The scene of the game, as text in RON.
    ///
    /// # Errors
    /// No answer.
    pub fn scene(&self) -> Result<String, LinkError> {
        let parts: Vec<String> = self.ask_for_parts(|from| Command::Scene { from })?;
        Ok(parts.concat())
    }

    /// Grabs the material point (u, v) of a sheet with a spring of `stiffness` N/m and returns the
    /// number of the grab.
    ///
    /// # Errors
    /// A rejected grab, or no answer.
    pub fn grab(&self, sheet: &str, (u, v): (f64, f64), stiffness: f64) -> Result<u64, LinkError> {
        let answer = self.send(&Command::Grab { sheet: sheet.into(), u, v, stiffness })?;
        answer.get("grab").and_then(Value::as_u64).ok_or_else(|| LinkError::Unlike("no grab in the answer".into()))
    }

    /// Moves the hand of `grab` to `target` (m) and returns its force. Suited for up to a thousand
    /// calls per second.
    ///
    /// # Errors
    /// A grab that has ended, a rejected command, or no answer.
    pub fn pull(&self, grab: u64, target: [f64; 3]) -> Result<GrabForce, LinkError> {
        self.ask(&Command::Pull { grab, target })
    }

    /// Subscribes to frames: positions, contact and temperature; with `complete` also normals,
    /// strain and energies.
    ///
    /// # Errors
    /// Twelve readers already, or no memory.
    pub fn frames(&self, complete: bool) -> Result<Frames, LinkError> {
        Frames::new(&self.node, &self.place, complete)
    }

    /// Subscribes to the topology: the triangles of each sheet. To be checked with every drawn
    /// frame.
    ///
    /// # Errors
    /// Twelve readers already, or no memory.
    pub fn topology(&self) -> Result<Topology, LinkError> {
        Topology::new(&self.node, &self.place)
    }

    /// Subscribes to events.
    ///
    /// # Errors
    /// Twelve readers already, or no memory.
    pub fn events(&self) -> Result<Events, LinkError> {
        Events::new(&self.node, &self.place)
    }
}

/// Adds the names of other links to the error.
fn with_others(error: LinkError, place: &LinkPlace) -> LinkError {
    let LinkError::NoGame(name, _) = error else { return error };
    let mut others = Vec::new();
    if let Ok(config) = place.config() {
        let _ = Ipc::list(&config, |details| {
            let mut parts = details.static_details.name().as_str().split('/');
            if let (Some("sheetwork"), Some(other), Some("control")) = (parts.next(), parts.next(), parts.next())
                && other != name
            {
                others.push(other.to_owned());
            }
            CallbackProgression::Continue
        });
    }
    others.sort();
    let listed = if others.is_empty() { String::new() } else { format!("; there are: {}", others.join(", ")) };
    LinkError::NoGame(name, listed)
}

fn read_answer(bytes: &[u8]) -> Result<Map<String, Value>, LinkError> {
    let answer: Map<String, Value> =
        serde_json::from_slice(bytes).map_err(|e| LinkError::Unlike(format!("an answer: {e}")))?;
    if answer.get("ok").and_then(Value::as_bool) == Some(true) {
        return Ok(answer);
    }
    let reason = answer.get("error").and_then(Value::as_str).unwrap_or("refused without a reason");
    Err(LinkError::Refused(reason.to_owned()))
}
