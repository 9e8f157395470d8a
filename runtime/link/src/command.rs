//! Commands to a running world, and the interface of the game that executes them.
//!
//! A command is a JSON object with its name as `op` and the protocol version as `layout`:
//! `{"layout":1,"op":"set","path":"gravity","value":"(0,-1.6,0)"}`. The answer has `ok`, `epoch`,
//! `steps`, `time`, and the result or `error`. Commands are executed between two steps, in the
//! order of arrival, and take effect from the next step.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::layout::LAYOUT;
use sheetwork::{InputError, World};

/// Maximum size of a command, bytes.
pub const MAXIMUM_COMMAND_BYTES: usize = 16 << 10;

/// A command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "op", rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// Returns the status of the game: [`GameStatus`].
    Status,
    /// Returns parameters with value, unit and range, from this index on; `next` is the index for
    /// the next request.
    Params {
        /// Index of the first parameter.
        #[serde(default)]
        from: usize,
    },
    /// Returns one parameter: value, kind, unit and range.
    Get {
        /// Path.
        path: String,
    },
    /// Sets a parameter; the answer has the `old` value.
    Set {
        /// Path.
        path: String,
        /// Value, as in a scene file.
        value: String,
    },
    /// Continues the simulation.
    Play,
    /// Pauses the simulation.
    Pause,
    /// Takes steps, then pauses.
    Step {
        /// Number of steps, 1 to 10000.
        steps: u32,
    },
    /// Resets the world to its scene.
    Reset,
    /// Opens a scene file on the game's machine.
    Load {
        /// Path of the file.
        file: String,
    },
    /// Stores a snapshot under a name, in the game's memory.
    Snapshot {
        /// Any name up to 64 bytes.
        #[serde(default)]
        name: String,
    },
    /// Restores a stored snapshot; see [`World::restore`].
    Restore {
        /// Name of the snapshot.
        #[serde(default)]
        name: String,
    },
    /// Returns the text of the scene from this byte on; `next` is the byte for the next request.
    Scene {
        /// First byte.
        #[serde(default)]
        from: usize,
    },
    /// Grabs a material point; the answer has the number of the `grab` and the `position`.
    Grab {
        /// Name of the sheet.
        sheet: String,
        /// Material coordinate along the length, 0 to 1.
        u: f64,
        /// Material coordinate along the width, 0 to 1.
        v: f64,
        /// Stiffness of the spring between hand and sheet, N/m.
        stiffness: f64,
    },
    /// Moves the hand; the answer has the `force` on it and the point's `position`. A grab without
    /// a move for two seconds is released.
    Pull {
        /// Number of the grab.
        grab: u64,
        /// Position of the hand, m.
        target: [f64; 3],
    },
    /// Releases a grab.
    Release {
        /// Number of the grab.
        grab: u64,
    },
}

impl Command {
    /// Serialises the command.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut object = serde_json::to_value(self).unwrap_or_default();
        object["layout"] = LAYOUT.into();
        serde_json::to_vec(&object).unwrap_or_default()
    }

    /// Deserialises a command.
    ///
    /// # Errors
    /// Invalid JSON, an unknown command or another version, as a sentence.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        if bytes.len() > MAXIMUM_COMMAND_BYTES {
            return Err(format!("the command has {} bytes; at most {MAXIMUM_COMMAND_BYTES} are read", bytes.len()));
        }
        let mut object: serde_json::Value =
            serde_json::from_slice(bytes).map_err(|e| format!("the command is no JSON: {e}"))?;
        let layout = object.as_object_mut().and_then(|o| o.shift_remove("layout"));
        match layout.as_ref().and_then(serde_json::Value::as_u64) {
            Some(version) if version == u64::from(LAYOUT) => {}
            Some(version) => return Err(format!("the command is of layout {version}, and this game knows {LAYOUT}")),
            None => return Err("the command does not say its layout".into()),
        }
        serde_json::from_value(object).map_err(|e| format!("the command cannot be read: {e}"))
    }
}

/// Status of a game.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GameStatus {
    /// Name of the scene.
    pub scene: String,
    /// Time integrator.
    pub engine: String,
    /// Time step, s.
    pub dt: f64,
    /// Whether the simulation runs.
    pub playing: bool,
    /// Names of the sheets.
    pub sheets: Vec<String>,
    /// Process number of the game.
    pub process: u32,
    /// Number of events so far.
    pub events: usize,
    /// Names of the unstable sheets. They are frozen until a reset, or until a snapshot from before
    /// the instability is restored.
    #[serde(default)]
    pub stopped: Vec<String>,
}

/// Interface of a game to the link.
pub trait Host {
    /// The world.
    fn world(&self) -> &World;

    /// The world, for changes between steps.
    fn world_mut(&mut self) -> &mut World;

    /// Whether the simulation runs.
    fn playing(&self) -> bool;

    /// Continues or pauses the simulation.
    ///
    /// # Errors
    /// A game without this permission.
    fn play(&mut self, playing: bool) -> Result<(), InputError>;

    /// Takes steps, then pauses.
    ///
    /// # Errors
    /// A game without this permission.
    fn step(&mut self, steps: u32) -> Result<(), InputError> {
        self.play(false)?;
        for _ in 0..steps {
            self.world_mut().step();
        }
        Ok(())
    }

    /// Sets a parameter and returns the old value.
    ///
    /// # Errors
    /// An unknown path or an invalid value; the world is then unchanged.
    fn set(&mut self, path: &str, value: &str) -> Result<String, InputError> {
        Ok(self.world_mut().set(path, value)?)
    }

    /// Resets the world to its scene.
    ///
    /// # Errors
    /// An unreadable file of the scene, or a game without this permission.
    fn reset(&mut self) -> Result<(), InputError> {
        Ok(self.world_mut().reset()?)
    }

    /// Opens a scene file.
    ///
    /// # Errors
    /// An invalid scene, or a game without this permission; the world is then unchanged.
    fn load(&mut self, file: &Path) -> Result<(), InputError>;
}
