//! What can be asked of a running world, and who does it: the game.
//!
//! A command is a JSON object with its name as `op` and the version of the protocol as `layout`:
//! `{"layout":1,"op":"set","path":"gravity","value":"(0,-1.6,0)"}`. The answer has `ok`, `epoch`, `steps`, `time`, and what was asked for, or
//! `error`. Every command is done between two steps, in the order they came; what it changed is in effect from the next one.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::layout::LAYOUT;
use sheetwork::{InputError, World};

/// Largest command that is read, bytes.
pub const MOST_BYTES: usize = 16 << 10;

/// A command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "op", rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// How the game stands: [`Standing`].
    Status,
    /// Every parameter with value, unit and range, from this index on; `next` says where to go on.
    Params {
        /// Index of the first.
        #[serde(default)]
        from: usize,
    },
    /// One parameter: its value, kind, unit and range.
    Get {
        /// Its path.
        path: String,
    },
    /// Sets a parameter; the answer has the `old` value.
    Set {
        /// Its path.
        path: String,
        /// The value, as a scene file has it.
        value: String,
    },
    /// Lets time pass.
    Play,
    /// Stops time.
    Pause,
    /// Takes so many steps and pauses.
    Step {
        /// 1 to 10000.
        steps: u32,
    },
    /// Puts the world back to its scene.
    Reset,
    /// Opens a scene file of the game's machine.
    Load {
        /// The file.
        file: String,
    },
    /// Keeps the world as it is under a name, in the game's memory.
    Snapshot {
        /// Any name up to 64 bytes.
        #[serde(default)]
        name: String,
    },
    /// Goes back to what was kept; see [`World::restore`].
    Restore {
        /// Its name.
        #[serde(default)]
        name: String,
    },
    /// The scene, as text, from this byte on; `next` says where to go on.
    Scene {
        /// Byte to begin at.
        #[serde(default)]
        from: usize,
    },
    /// Takes hold of a material point; the answer has the number of the `grab` and the `position`.
    Grab {
        /// The sheet.
        sheet: String,
        /// Place along the length, 0 to 1.
        u: f64,
        /// Place along the width, 0 to 1.
        v: f64,
        /// Of the spring between hand and sheet, N/m.
        stiffness: f64,
    },
    /// Moves the hand; the answer has the `force` that it feels and the point's `position`. A grab that is not moved for two
    /// seconds lets go.
    Pull {
        /// Number of the grab.
        grab: u64,
        /// Where to, m.
        target: [f64; 3],
    },
    /// Lets go.
    Release {
        /// Number of the grab.
        grab: u64,
    },
}

impl Command {
    /// The command as it is sent.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut object = serde_json::to_value(self).unwrap_or_default();
        object["layout"] = LAYOUT.into();
        serde_json::to_vec(&object).unwrap_or_default()
    }

    /// The command in these bytes.
    ///
    /// # Errors
    /// When they are none, or of another version: a sentence.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        if bytes.len() > MOST_BYTES {
            return Err(format!("the command has {} bytes; at most {MOST_BYTES} are read", bytes.len()));
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

/// How a game stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Standing {
    /// Name of the scene.
    pub scene: String,
    /// Engine.
    pub engine: String,
    /// Its step, s.
    pub dt: f64,
    /// Whether time passes.
    pub playing: bool,
    /// Names of the sheets.
    pub sheets: Vec<String>,
    /// Process that runs the game.
    pub process: u32,
    /// Events so far.
    pub events: usize,
    /// Names of the sheets that went unstable: they stand still until a reset, or until a snapshot of when they were sound is restored.
    #[serde(default)]
    pub stopped: Vec<String>,
}

/// A game, as the link drives it.
pub trait Host {
    /// The world.
    fn world(&self) -> &World;

    /// The world, to be changed between steps.
    fn world_mut(&mut self) -> &mut World;

    /// Whether time passes.
    fn playing(&self) -> bool;

    /// Lets time pass, or stops it.
    ///
    /// # Errors
    /// When this game does not let others do that.
    fn play(&mut self, playing: bool) -> Result<(), InputError>;

    /// Takes so many steps and pauses.
    ///
    /// # Errors
    /// When this game does not let others do that.
    fn step(&mut self, steps: u32) -> Result<(), InputError> {
        self.play(false)?;
        (0..steps).for_each(|_| self.world_mut().step());
        Ok(())
    }

    /// Sets a parameter; returns the old value.
    ///
    /// # Errors
    /// When there is none of that path, or the value is not allowed; nothing is changed then.
    fn set(&mut self, path: &str, value: &str) -> Result<String, InputError> {
        self.world_mut().set(path, value)
    }

    /// Puts the world back to its scene.
    ///
    /// # Errors
    /// When a file of the scene cannot be read any more, or this game does not let others do that.
    fn reset(&mut self) -> Result<(), InputError> {
        self.world_mut().reset()
    }

    /// Opens a scene file.
    ///
    /// # Errors
    /// When it is not valid, or this game does not let others do that; the world is then as before.
    fn load(&mut self, file: &Path) -> Result<(), InputError>;
}
