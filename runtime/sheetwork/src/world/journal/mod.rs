//! Journals: the inputs of a run, step by step, with checksums of the results, so that the run can
//! be repeated, entered at any step, and verified.
//!
//! File: the line `sheetwork journal 1`, a line of JSON ([`JournalHeader`]), then parts, each after
//! its length in bytes (u32) and its CRC-32 (u32), little endian. A part begins with a snapshot
//! ([`World::serialise`]) before its first step. For every step follow the inputs before it, and a
//! checksum of positions and velocities after it of every sheet and of all bodies together.

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::World;
use crate::error::{InputError, check_range, reject_if};
use crate::scene::{PathKey, PinSpec, Region, Scene, WindZone};
use crate::serialize::{CorruptState, ReadResult, State, StateReader, StateWriter};
use crate::sheet::Sheet;
use crate::world::part_file::{PartFile, read_parts};
use crate::world::{BodyId, ForceTarget, SheetId};

const MAGIC: &str = "sheetwork journal 1";
/// Maximum length of a header, bytes.
const MAX_HEADER_LENGTH: usize = 64 << 20;

/// Header of a journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JournalHeader {
    /// Name of the scene.
    pub scene: String,
    /// The scene itself (RON).
    pub source: String,
    /// Folder of the scene's files.
    pub base: PathBuf,
    /// Number of steps between snapshots.
    pub every: u32,
}

/// Input to a world between two steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum JournalInput {
    /// [`World::set`].
    Set {
        /// Path of the parameter.
        path: String,
        /// Value as text.
        value: String,
    },
    /// [`crate::sheet::Sheet::grab`].
    Grab {
        /// Name of the sheet.
        sheet: String,
        /// Material point, each coordinate 0 to 1.
        uv: (f64, f64),
        /// Stiffness, N/m.
        stiffness: f64,
    },
    /// [`crate::sheet::Sheet::pull`].
    Pull {
        /// Name of the sheet.
        sheet: String,
        /// Index of the grab.
        index: u32,
        /// Target position, m.
        target: DVec3,
    },
    /// [`crate::sheet::Sheet::release_grab`].
    LetGo {
        /// Name of the sheet.
        sheet: String,
        /// Index of the grab.
        index: u32,
    },
    /// [`World::move_body`].
    MoveBody {
        /// Name of the body.
        name: String,
        /// Target position, m.
        position: DVec3,
        /// Target rotation.
        rotation: DQuat,
    },
    /// [`World::place_body`].
    PlaceBody {
        /// Name of the body.
        name: String,
        /// New position, m.
        position: DVec3,
        /// New rotation.
        rotation: DQuat,
    },
    /// [`World::set_wind_zones`].
    SetWindZones {
        /// All zones.
        zones: Vec<WindZone>,
    },
    /// [`World::apply_force`].
    ApplyForce {
        /// Name of the sheet.
        sheet: String,
        /// Part of the sheet.
        target: ForceTarget,
        /// Sum of the force, N.
        force: DVec3,
    },
    /// [`World::apply_impulse`].
    ApplyImpulse {
        /// Name of the sheet.
        sheet: String,
        /// Part of the sheet.
        target: ForceTarget,
        /// Sum of the impulse, N s.
        impulse: DVec3,
    },
    /// [`World::pin`].
    Pin {
        /// Name of the sheet.
        sheet: String,
        /// Nodes.
        region: Region,
        /// Path from now on; empty for a fixed pin.
        path: Vec<PathKey>,
        /// Time until release, s.
        until: Option<f64>,
    },
    /// [`World::unpin`].
    Unpin {
        /// Name of the sheet.
        sheet: String,
        /// Nodes.
        region: Region,
    },
    /// [`World::attach`].
    Attach {
        /// Name of the sheet.
        sheet: String,
        /// Nodes.
        region: Region,
        /// Name of the body.
        body: String,
    },
    /// [`World::cut`].
    Cut {
        /// Name of the sheet.
        sheet: String,
        /// Material point at the start.
        from: (f64, f64),
        /// Material point at the end.
        to: (f64, f64),
    },
    /// [`World::move_sheet`].
    MoveSheet {
        /// Name of the sheet.
        sheet: String,
        /// Displacement, m.
        by: DVec3,
        /// Rotation about the origin.
        rotation: DQuat,
    },
}

impl JournalInput {
    /// Apply the input to `world`.
    ///
    /// # Errors
    /// When the world refuses the input, or has no sheet or body of that name.
    pub fn apply(&self, world: &mut World) -> Result<(), InputError> {
        match self {
            Self::Set { path, value } => Ok(world.set(path, value).map(|_| ())?),
            Self::Grab { sheet, uv, stiffness } => sheet_of(world, sheet)?.grab(*uv, *stiffness).map(|_| ()),
            Self::Pull { sheet, index, target } => sheet_of(world, sheet)?.pull(*index as usize, *target),
            Self::LetGo { sheet, index } => {
                let gone = sheet_of(world, sheet)?.release_grab(*index as usize);
                if gone { Ok(()) } else { Err(InputError::new("pull", "nobody pulls there")) }
            }
            Self::MoveBody { name, position, rotation } => {
                send_body(world, name, (*position, *rotation), World::move_body)
            }
            Self::PlaceBody { name, position, rotation } => {
                send_body(world, name, (*position, *rotation), World::place_body)
            }
            Self::SetWindZones { zones } => world.set_wind_zones(zones),
            Self::ApplyForce { sheet, target, force } => {
                let id = id_of(world, sheet)?;
                world.apply_force(id, target, *force)
            }
            Self::ApplyImpulse { sheet, target, impulse } => {
                let id = id_of(world, sheet)?;
                world.apply_impulse(id, target, *impulse)
            }
            Self::Pin { .. } | Self::Unpin { .. } | Self::Attach { .. } | Self::Cut { .. } | Self::MoveSheet { .. } => {
                self.change_sheet(world)
            }
        }
    }

    /// Apply a change of a running sheet.
    fn change_sheet(&self, world: &mut World) -> Result<(), InputError> {
        match self {
            Self::Pin { sheet, region, path, until } => {
                let pin = PinSpec { path: path.clone(), until: *until, ..PinSpec::fixed(region.clone()) };
                world.pin(id_of(world, sheet)?, &pin).map(|_| ())
            }
            Self::Unpin { sheet, region } => world.unpin(id_of(world, sheet)?, region).map(|_| ()),
            Self::Attach { sheet, region, body } => {
                let none = || InputError::new("body", format!("no body is named \"{body}\""));
                let body = world.body_id(body).ok_or_else(none)?;
                world.attach(id_of(world, sheet)?, region, body).map(|_| ())
            }
            Self::Cut { sheet, from, to } => world.cut(id_of(world, sheet)?, *from, *to).map(|_| ()),
            Self::MoveSheet { sheet, by, rotation } => world.move_sheet(id_of(world, sheet)?, *by, *rotation),
            _ => Ok(()),
        }
    }
}

/// Id of the sheet of a name.
fn id_of(world: &World, name: &str) -> Result<SheetId, InputError> {
    world.sheet_id(name).ok_or_else(|| InputError::new("sheet", format!("no sheet is named \"{name}\"")))
}

/// Sheet of a name.
fn sheet_of<'a>(world: &'a mut World, name: &str) -> Result<&'a mut Sheet, InputError> {
    let index = world.sheet_index(name)?;
    Ok(&mut world.sheets[index])
}

/// Send a body to a pose by `send`, which returns whether it did.
fn send_body(
    world: &mut World,
    name: &str,
    (position, rotation): (DVec3, DQuat),
    send: impl FnOnce(&mut World, BodyId, DVec3, DQuat) -> bool,
) -> Result<(), InputError> {
    let valid = position.is_finite() && rotation.is_finite() && rotation.length_squared() > 0.0;
    let id = world.body_id(name).filter(|_| valid);
    if id.is_some_and(|id| send(world, id, position, rotation)) {
        return Ok(());
    }
    let problem = if valid { "is not there, or does not move so" } else { "cannot be sent to what is no place" };
    Err(InputError::new(format!("bodies.{name}"), problem))
}

/// Checksums of positions and velocities of the sheets of `world`, one per sheet, and last of all
/// its bodies.
pub fn state_checksums(world: &World) -> Vec<u32> {
    let mut all = Vec::with_capacity(world.sheets().len() + 1);
    for sheet in world.sheets() {
        let mut sum = crc32fast::Hasher::new();
        for axis in sheet.state.x.axes().into_iter().chain(sheet.state.v.axes()) {
            axis.iter().for_each(|v| sum.update(&v.to_le_bytes()));
        }
        all.push(sum.finalize());
    }
    let mut bodies = StateWriter::default();
    if let Some(rigid) = world.rigid() {
        (0..rigid.bodies().len()).filter_map(|i| rigid.state(i)).for_each(|state| state.serialise(&mut bodies));
    }
    all.push(crc32fast::hash(&bodies.bytes));
    all
}

/// Writer of a journal while a world runs.
pub struct JournalWriter {
    out: PartFile,
    every: u32,
    /// Unwritten part: its snapshot, its steps, and their number.
    key: Vec<u8>,
    steps: StateWriter,
    count: u32,
    waiting: Vec<JournalInput>,
}

impl JournalWriter {
    /// Create the file for `world`, with a snapshot every `every` steps, 1 to 1e6.
    ///
    /// # Errors
    /// When `every` is out of range or the file cannot be written.
    pub fn create(file: &Path, world: &World, every: u32) -> Result<Self, InputError> {
        check_range("every", f64::from(every), 1.0, 1e6, "steps")?;
        let scene = world.scene();
        let header =
            JournalHeader { scene: scene.name.clone(), source: scene.to_text()?, base: scene.base.clone(), every };
        Ok(Self {
            out: PartFile::create(file, MAGIC, &header, crc32fast::hash)?,
            every,
            key: world.serialise(),
            steps: StateWriter::default(),
            count: 0,
            waiting: Vec::new(),
        })
    }

    /// Apply `input` to `world`, and record it.
    ///
    /// # Errors
    /// As [`JournalInput::apply`]; nothing is recorded then.
    pub fn input(&mut self, world: &mut World, input: JournalInput) -> Result<(), InputError> {
        input.apply(world)?;
        self.waiting.push(input);
        Ok(())
    }

    /// Take a step of `world`, and record its inputs and checksums.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn step(&mut self, world: &mut World) -> Result<(), InputError> {
        let inputs = postcard::to_extend(&std::mem::take(&mut self.waiting), Vec::new())
            .map_err(|e| InputError::new("input", e.to_string()))?;
        self.steps.blob(&inputs);
        world.step();
        let sums = state_checksums(world);
        self.steps.count(sums.len() as u64);
        sums.iter().for_each(|sum| self.steps.bytes.extend_from_slice(&sum.to_le_bytes()));
        self.count += 1;
        if self.count == self.every {
            self.flush()?;
            world.serialise_into(&mut self.key);
        }
        Ok(())
    }

    /// Write the unwritten part.
    fn flush(&mut self) -> Result<(), InputError> {
        let mut part = StateWriter::default();
        part.blob(&self.key);
        part.count(u64::from(std::mem::take(&mut self.count)));
        part.bytes.append(&mut self.steps.bytes);
        self.out.part(&part.bytes, || {
            InputError::new("every", "makes parts of more than 4 GiB: fewer steps from snapshot to snapshot will do")
        })
    }

    /// Finish the file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<(), InputError> {
        if self.count > 0 {
            self.flush()?;
        }
        self.out.finish()
    }
}

/// A step of a journal.
#[derive(Clone, Debug, PartialEq)]
struct JournalStep {
    inputs: Vec<JournalInput>,
    sums: Vec<u32>,
}

/// A snapshot and the steps after it.
#[derive(Clone, Debug, PartialEq)]
struct JournalPart {
    key: Vec<u8>,
    steps: Vec<JournalStep>,
}

/// A journal read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Journal {
    /// Header of the journal.
    pub header: JournalHeader,
    parts: Vec<JournalPart>,
}

/// First difference between a run and its journal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JournalDifference {
    /// Number of the first step after which a state differs, counted from 1.
    pub step: u64,
    /// Simulated time after that step, s.
    pub time_s: f64,
    /// Name of the sheet that differs, or "bodies".
    pub what: String,
}

impl Journal {
    /// Read a journal.
    ///
    /// # Errors
    /// When the file cannot be read, is no journal, ends within a part or is damaged.
    pub fn read(file: &Path) -> Result<Self, InputError> {
        let bytes = std::fs::read(file).map_err(|e| InputError::io(file, &e))?;
        Self::from_bytes(&bytes).map_err(|e| e.in_file(file))
    }

    /// Read a journal from the bytes of a file.
    ///
    /// # Errors
    /// As [`Journal::read`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, InputError> {
        let bad = |problem: String| InputError::new("journal", problem);
        let none = || bad(format!("does not begin with \"{MAGIC}\": not a journal"));
        // A file truncated within its first line can still name its format.
        let (magic, rest) = line_of(bytes).unwrap_or((&bytes[..bytes.len().min(2 * MAGIC.len())], &[]));
        if magic != MAGIC.as_bytes() {
            let other = magic.strip_prefix(b"sheetwork journal ").unwrap_or_default();
            let digits: String = other.iter().map(|b| char::from(*b)).take_while(char::is_ascii_digit).collect();
            return Err(if digits.is_empty() || digits == "1" {
                none()
            } else {
                bad(format!("is a journal of version {digits}; this program reads version 1"))
            });
        }
        let (json, rest) = line_of(rest).ok_or_else(|| bad("ends within its header".into()))?;
        let header = serde_json::from_slice(json).map_err(|e| bad(format!("header: {e}")))?;
        let part = |at, body: &[u8]| part_of(body).map_err(|CorruptState| format!("part {at} cannot be read"));
        let parts = read_parts(rest, "part", crc32fast::hash, part).map_err(bad)?;
        Ok(Self { header, parts })
    }

    /// Number of steps.
    pub fn len(&self) -> u64 {
        self.parts.iter().map(|p| p.steps.len() as u64).sum()
    }

    /// Whether the journal has no steps.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Build the world of the journal's scene, at its beginning. `base` replaces the folder of the
    /// scene's files.
    ///
    /// # Errors
    /// When the scene cannot be built, or the first snapshot belongs to another scene.
    pub fn world(&self, base: Option<&Path>) -> Result<World, InputError> {
        let mut scene = Scene::parse(&self.header.source)?;
        scene.base = base.map_or_else(|| self.header.base.clone(), Path::to_path_buf);
        let mut world = World::new(&scene)?;
        if let Some(first) = self.parts.first() {
            world.deserialise(&first.key)?;
        }
        Ok(world)
    }

    /// Take `world`, built by [`Journal::world`], to the state after step `step`, from the last
    /// snapshot before it.
    ///
    /// # Errors
    /// When the journal has fewer steps, or one of its snapshots or inputs is refused.
    pub fn seek(&self, world: &mut World, step: u64) -> Result<(), InputError> {
        reject_if!(step > self.len(), "step", "{step} is outside 0 to {}", self.len());
        let mut before = 0;
        for part in &self.parts {
            let here = part.steps.len() as u64;
            if step <= before + here {
                world.deserialise(&part.key)?;
                let steps = part.steps.iter().take((step - before) as usize);
                return steps.into_iter().try_for_each(|s| s.take(world));
            }
            before += here;
        }
        Ok(())
    }

    /// Repeat the run in `world`, and return its first difference from the journal; `None` when
    /// there is none. The snapshot of every part is compared too.
    ///
    /// # Errors
    /// When a snapshot or an input is refused.
    pub fn check(&self, world: &mut World) -> Result<Option<JournalDifference>, InputError> {
        let mut number = 0;
        if let Some(first) = self.parts.first() {
            world.deserialise(&first.key)?;
        }
        for part in &self.parts {
            for step in &part.steps {
                step.take(world)?;
                number += 1;
                let now = state_checksums(world);
                if let Some(at) = (0..now.len().max(step.sums.len())).find(|i| now.get(*i) != step.sums.get(*i)) {
                    let what = world.sheets().get(at).map_or_else(|| "bodies".to_owned(), |s| s.name.clone());
                    return Ok(Some(JournalDifference { step: number, time_s: world.time(), what }));
                }
            }
        }
        Ok(None)
    }
}

impl JournalStep {
    fn take(&self, world: &mut World) -> Result<(), InputError> {
        self.inputs.iter().try_for_each(|input| input.apply(world))?;
        world.step();
        Ok(())
    }
}

/// The first line of `bytes`, and the bytes after it.
fn line_of(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().take(MAX_HEADER_LENGTH).position(|b| *b == b'\n')?;
    Some((&bytes[..end], &bytes[end + 1..]))
}

fn part_of(body: &[u8]) -> ReadResult<JournalPart> {
    let mut from = StateReader::new(body);
    let key = from.blob()?.to_vec();
    let mut steps = Vec::new();
    for _ in 0..from.length(2)? {
        let inputs = postcard::from_bytes(from.blob()?).map_err(|_| CorruptState)?;
        let mut sums = Vec::new();
        for _ in 0..from.length(4)? {
            sums.push(from.checksum()?);
        }
        steps.push(JournalStep { inputs, sums });
    }
    if from.is_empty() { Ok(JournalPart { key, steps }) } else { Err(CorruptState) }
}
