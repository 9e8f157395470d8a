//! Execution of commands, and their answers.

use std::path::Path;

use glam::DVec3;
use serde_json::{Map, Value, json};

use crate::command::{Command, GameStatus, Host};
use crate::grabs::Grabs;
use sheetwork::sheet::Status;
use sheetwork::world::Snapshot;
use sheetwork::{InputError, Parameter, World};

/// Maximum size of an answer, bytes; longer ones are split into parts.
pub const ANSWER_BYTES: usize = 16 << 10;
/// Maximum number of stored snapshots; the oldest is discarded.
const MAXIMUM_SNAPSHOTS: usize = 16;
/// Maximum number of steps in one command.
const MAXIMUM_STEPS_PER_COMMAND: u32 = 10_000;
/// Bytes of the scene's text in one answer; escapes at most double them.
const SCENE_PART: usize = 7000;

/// State of a link for its commanding clients.
#[derive(Default)]
pub struct CommandHandler {
    pub grabs: Grabs,
    snapshots: Vec<(String, Snapshot)>,
}

type Body = Map<String, Value>;

impl CommandHandler {
    /// Executes `command` and returns the body of its answer.
    pub fn execute(&mut self, host: &mut dyn Host, command: &Command) -> Result<Body, InputError> {
        match command {
            Command::Status => Ok(object(serde_json::to_value(game_status(host)).unwrap_or_default())),
            Command::Params { from } => Ok(parameters(&host.world().parameters(), *from)),
            Command::Get { path } => Ok(object(parameter(&host.world().get(path)?))),
            Command::Set { path, value } => host.set(path, value).map(|old| object(json!({ "old": old }))),
            Command::Play => host.play(true).map(|()| Body::new()),
            Command::Pause => host.play(false).map(|()| Body::new()),
            Command::Step { steps } => {
                sheetwork::check_range("steps", f64::from(*steps), 1.0, f64::from(MAXIMUM_STEPS_PER_COMMAND), "")?;
                host.step(*steps).map(|()| Body::new())
            }
            Command::Reset => {
                self.grabs.clear(host.world_mut());
                host.reset().map(|()| Body::new())
            }
            Command::Load { file } => {
                host.load(Path::new(file))?;
                self.grabs.forget();
                self.snapshots.clear();
                Ok(Body::new())
            }
            Command::Snapshot { name } => self.store_snapshot(host, name),
            Command::Restore { name } => {
                let kept = self.snapshots.iter().find(|s| s.0 == *name);
                let (_, snapshot) =
                    kept.ok_or_else(|| InputError::new("snapshot", format!("there is no \"{name}\"")))?;
                host.world_mut().restore(snapshot)?;
                Ok(Body::new())
            }
            Command::Scene { from } => scene(host, *from),
            Command::Grab { .. } | Command::Pull { .. } | Command::Release { .. } => self.handle(host, command),
        }
    }

    fn store_snapshot(&mut self, host: &dyn Host, name: &str) -> Result<Body, InputError> {
        if name.len() > 64 {
            return Err(InputError::new("name", format!("has {} bytes; at most 64 are allowed", name.len())));
        }
        let snapshot = host.world().snapshot();
        self.snapshots.retain(|s| s.0 != name);
        if self.snapshots.len() >= MAXIMUM_SNAPSHOTS {
            self.snapshots.remove(0);
        }
        self.snapshots.push((name.to_owned(), snapshot));
        Ok(Body::new())
    }

    fn handle(&mut self, host: &mut dyn Host, command: &Command) -> Result<Body, InputError> {
        let world = host.world_mut();
        match command {
            Command::Grab { sheet, u, v, stiffness } => {
                let (number, place) = self.grabs.grab(world, sheet, (*u, *v), *stiffness)?;
                Ok(object(json!({ "grab": number, "position": place.to_array() })))
            }
            Command::Pull { grab, target } => {
                let (force, place) = self.grabs.pull(world, *grab, DVec3::from_array(*target))?;
                Ok(object(json!({ "force": force.to_array(), "position": place.to_array() })))
            }
            Command::Release { grab } if !self.grabs.release(world, *grab) => {
                Err(InputError::new("grab", format!("{grab} holds nothing any more")))
            }
            _ => Ok(Body::new()),
        }
    }
}

fn object(value: Value) -> Body {
    match value {
        Value::Object(body) => body,
        _ => Body::new(),
    }
}

/// Names of the unstable sheets. They are frozen until a reset, or until a snapshot from before the
/// instability is restored.
pub fn unstable_sheets(world: &World) -> Vec<String> {
    let unstable = world.sheets().iter().filter(|s| matches!(s.state.status, Status::Unstable { .. }));
    unstable.map(|s| s.name.clone()).take(64).collect()
}

fn game_status(host: &dyn Host) -> GameStatus {
    let world = host.world();
    GameStatus {
        scene: world.scene().name.clone(),
        engine: world.engine().to_string(),
        dt: world.dt(),
        playing: host.playing(),
        sheets: world.sheets().iter().map(|s| s.name.clone()).take(64).collect(),
        process: std::process::id(),
        events: world.events().len(),
        stopped: unstable_sheets(world),
    }
}

fn parameter(p: &Parameter) -> Value {
    json!({
        "path": p.path, "value": p.value, "unit": p.unit, "kind": p.kind.name(),
        "min": p.range.map(|r| r.0), "max": p.range.map(|r| r.1),
    })
}

/// As many parameters from `from` on as fit into one answer.
fn parameters(all: &[Parameter], from: usize) -> Body {
    let mut list = Vec::new();
    let mut bytes = 256;
    let mut next = None;
    for (index, p) in all.iter().enumerate().skip(from) {
        // Escapes at most double the length of values and paths.
        bytes += 2 * (p.path.len() + p.value.len()) + 128;
        if bytes > ANSWER_BYTES && !list.is_empty() {
            next = Some(index);
            break;
        }
        list.push(parameter(p));
    }
    object(json!({ "params": list, "next": next }))
}

fn scene(host: &dyn Host, from: usize) -> Result<Body, InputError> {
    let text = host.world().scene().to_text()?;
    let mut end = (from.saturating_add(SCENE_PART)).min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let part = text.get(from..end).ok_or_else(|| InputError::new("from", "is not within the scene's text"))?;
    Ok(object(json!({ "text": part, "next": (end < text.len()).then_some(end) })))
}
