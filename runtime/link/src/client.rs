//! The other end of a link: what a process holds that watches a game and commands it.
//!
//! Reading is in `reader`.

use std::sync::Arc;
use std::time::{Duration, Instant};

use iceoryx2::port::client::Client as Port;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::client::ClientCreateError;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::command::{Command, MOST_BYTES, Standing};
use crate::place::LinkPlace;
use crate::reader::{Events, Frames, LOOK_EVERY, Topology};
use crate::server::{Control, control};
use crate::{Ipc, LinkError, clean_up, node_at};

/// A process's hold on a game.
pub struct Client {
    place: LinkPlace,
    patience: Duration,
    port: Port<Ipc, [u8], (), [u8], ()>,
    control: Control,
    node: Arc<Node<Ipc>>,
}

/// A parameter of a running game.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct RemoteParameter {
    /// Its path.
    pub path: String,
    /// Its value, as text that `set` takes back.
    pub value: String,
    /// Its unit; empty for a name or a plain number.
    pub unit: String,
    /// "number" (or "none" where there may be none), "vector", "boolean" or "name".
    pub kind: String,
    /// Smallest value, of a number.
    pub min: Option<f64>,
    /// Largest value, of a number.
    pub max: Option<f64>,
}

impl RemoteParameter {
    /// Its value, of a number.
    pub fn number(&self) -> Option<f64> {
        if self.kind == "number" { self.value.parse().ok() } else { None }
    }

    /// Its value, of a boolean.
    pub fn boolean(&self) -> Option<bool> {
        if self.kind == "boolean" { self.value.parse().ok() } else { None }
    }

    /// Its value, of a vector.
    pub fn vector(&self) -> Option<[f64; 3]> {
        let inner = self.value.strip_prefix('(').and_then(|v| v.strip_suffix(')')).filter(|_| self.kind == "vector")?;
        let parts: Result<Vec<f64>, _> = inner.split(',').map(|c| c.trim().parse()).collect();
        parts.ok()?.try_into().ok()
    }
}

/// What a hand feels.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct PulledTo {
    /// Force on the hand, N.
    pub force: [f64; 3],
    /// Where the point is that it holds, m.
    pub position: [f64; 3],
    /// Simulated time, s.
    pub time: f64,
}

impl Client {
    /// Attaches to the game that serves `place`.
    ///
    /// # Errors
    /// When there is none, it is of another version, or this user may not.
    pub fn attach(place: &LinkPlace) -> Result<Self, LinkError> {
        // A folder that is not there was made by no game: nothing is left behind by having looked.
        if !place.root().exists() {
            return Err(LinkError::NoGame(place.name().into(), String::new()));
        }
        let node = Arc::new(node_at(place, "sheetwork client")?);
        let control = control(&node, place, false).map_err(|e| with_others(e, place))?;
        if control.dynamic_config().number_of_servers() == 0 {
            return Err(with_others(LinkError::NoGame(place.name().into(), String::new()), place));
        }
        let port = control.client_builder().initial_max_slice_len(MOST_BYTES);
        let port = port.allocation_strategy(AllocationStrategy::Static);
        let port = port.backpressure_strategy(BackpressureStrategy::DiscardData).create();
        let port = port.map_err(|e| match e {
            ClientCreateError::ExceedsMaxSupportedClients => LinkError::Full("command a game"),
            e => LinkError::Memory(format!("no port for commands: {e:?}")),
        })?;
        Ok(Self { place: place.clone(), patience: Duration::from_secs(2), port, control, node })
    }

    /// Attaches, and waits up to `patience` for a game to be there.
    ///
    /// # Errors
    /// As [`Client::attach`], at the end of that time.
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

    /// How long to wait for an answer; two seconds unless told otherwise.
    pub fn set_patience(&mut self, patience: Duration) {
        self.patience = patience;
    }

    /// Where the game is.
    pub fn place(&self) -> &LinkPlace {
        &self.place
    }

    /// Whether a game serves it, as far as is known: one that was killed counts until someone has cleaned up.
    pub fn is_served(&self) -> bool {
        self.control.dynamic_config().number_of_servers() > 0
    }

    /// Sends a command and waits for its answer: the JSON object.
    ///
    /// # Errors
    /// When the game refuses, or does not answer in time.
    pub fn send(&self, command: &Command) -> Result<Map<String, Value>, LinkError> {
        self.send_bytes(&command.to_bytes())
    }

    /// Sends any bytes as a command, and waits for the answer.
    ///
    /// # Errors
    /// When they are too many, the game refuses, or does not answer in time.
    pub fn send_bytes(&self, bytes: &[u8]) -> Result<Map<String, Value>, LinkError> {
        if bytes.len() > MOST_BYTES {
            return Err(LinkError::Refused(format!("the command has {} bytes; at most {MOST_BYTES} go", bytes.len())));
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
            if start.elapsed() > self.patience {
                clean_up(&self.node, &self.place);
                return Err(LinkError::Silent);
            }
            std::thread::sleep(LOOK_EVERY);
        }
    }

    fn ask<T: DeserializeOwned>(&self, command: &Command) -> Result<T, LinkError> {
        let answer = self.send(command)?;
        serde_json::from_value(Value::Object(answer)).map_err(|e| LinkError::Unlike(format!("an answer: {e}")))
    }

    /// How the game stands.
    ///
    /// # Errors
    /// When it does not answer.
    pub fn status(&self) -> Result<Standing, LinkError> {
        self.ask(&Command::Status)
    }

    /// Every parameter of the running world.
    ///
    /// # Errors
    /// When the game does not answer.
    pub fn parameters(&self) -> Result<Vec<RemoteParameter>, LinkError> {
        #[derive(Deserialize)]
        struct Part {
            params: Vec<RemoteParameter>,
            next: Option<usize>,
        }
        let (mut all, mut from) = (Vec::new(), 0);
        loop {
            let part: Part = self.ask(&Command::Params { from })?;
            all.extend(part.params);
            match part.next {
                // Only forwards: an answer that leads back would never end.
                Some(next) if next > from => from = next,
                _ => return Ok(all),
            }
        }
    }

    /// One parameter.
    ///
    /// # Errors
    /// When there is none of that path, or the game does not answer.
    pub fn get(&self, path: &str) -> Result<RemoteParameter, LinkError> {
        self.ask(&Command::Get { path: path.into() })
    }

    /// Sets a parameter, in effect from the next step on: a number, a boolean, or text as a scene file has it; returns the old value.
    ///
    /// # Errors
    /// When the game refuses, with its reason, or does not answer.
    pub fn set(&self, path: &str, value: impl std::fmt::Display) -> Result<String, LinkError> {
        let answer = self.send(&Command::Set { path: path.into(), value: value.to_string() })?;
        Ok(answer.get("old").and_then(Value::as_str).unwrap_or_default().to_owned())
    }

    /// The scene that the game runs, as text in RON.
    ///
    /// # Errors
    /// When the game does not answer.
    pub fn scene(&self) -> Result<String, LinkError> {
        #[derive(Deserialize)]
        struct Part {
            text: String,
            next: Option<usize>,
        }
        let (mut all, mut from) = (String::new(), 0);
        loop {
            let part: Part = self.ask(&Command::Scene { from })?;
            all.push_str(&part.text);
            match part.next {
                Some(next) if next > from => from = next,
                _ => return Ok(all),
            }
        }
    }

    /// Takes hold of the material point (u, v) of a sheet by a spring of `stiffness` N/m; the number of the grab.
    ///
    /// # Errors
    /// When the game refuses or does not answer.
    pub fn grab(&self, sheet: &str, (u, v): (f64, f64), stiffness: f64) -> Result<u64, LinkError> {
        let answer = self.send(&Command::Grab { sheet: sheet.into(), u, v, stiffness })?;
        answer.get("grab").and_then(Value::as_u64).ok_or_else(|| LinkError::Unlike("no grab in the answer".into()))
    }

    /// Moves the hand of `grab` to `target` (m), and says what it feels. To be called up to a thousand times a second.
    ///
    /// # Errors
    /// When the grab holds nothing any more, the game refuses, or does not answer.
    pub fn pull(&self, grab: u64, target: [f64; 3]) -> Result<PulledTo, LinkError> {
        self.ask(&Command::Pull { grab, target })
    }

    /// Frames from now on: positions, contact and temperature, or, where `complete`, normals, strain and energies too.
    ///
    /// # Errors
    /// When there are twelve readers already, or no memory.
    pub fn frames(&self, complete: bool) -> Result<Frames, LinkError> {
        Frames::new(&self.node, &self.place, complete)
    }

    /// Which masses make triangles, from now on: to be asked with every frame that is drawn.
    ///
    /// # Errors
    /// When there are twelve readers already, or no memory.
    pub fn topology(&self) -> Result<Topology, LinkError> {
        Topology::new(&self.node, &self.place)
    }

    /// Events from now on.
    ///
    /// # Errors
    /// When there are twelve readers already, or no memory.
    pub fn events(&self) -> Result<Events, LinkError> {
        Events::new(&self.node, &self.place)
    }
}

/// The error, and which other links there are.
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
