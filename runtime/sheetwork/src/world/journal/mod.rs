//! Journals: a run as what was done to it, step by step, with what came of it, so that it can be run again, gone to at any step, and checked.
//!
//! File: the line `sheetwork journal 1`, a line of JSON ([`Header`]), then parts, each after its length in bytes (u32) and their CRC-32
//! (u32), little endian. A part begins with a snapshot ([`World::save`]) of before its first step; then for every step the inputs that
//! came before it and, of every sheet and of all bodies together, a sum of where they are and how they move after it.

#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::World;
use crate::error::{InputError, check_range};
use crate::scene::Scene;
use crate::serialize::{Cut, Keeper, Taken, Taker};

const MAGIC: &str = "sheetwork journal 1";
/// Longest header that is read, bytes.
const LONGEST: usize = 64 << 20;

/// What a journal is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Name of the scene.
    pub scene: String,
    /// The scene itself (RON).
    pub source: String,
    /// Folder that the scene's files are in.
    pub base: PathBuf,
    /// Steps from one snapshot to the next.
    pub every: u32,
}

/// Something that is done to a world between two steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Input {
    /// [`World::set`].
    Set {
        /// Path of the parameter.
        path: String,
        /// Its value, as text.
        value: String,
    },
    /// [`crate::sheet::Sheet::grab`].
    Grab {
        /// Name of the sheet.
        sheet: String,
        /// Where on it, each 0 to 1.
        uv: (f64, f64),
        /// Stiffness, N/m.
        stiffness: f64,
    },
    /// [`crate::sheet::Sheet::pull`].
    Pull {
        /// Name of the sheet.
        sheet: String,
        /// Which of its pulls.
        index: u32,
        /// Where to, m.
        target: DVec3,
    },
    /// [`crate::sheet::Sheet::let_go`].
    LetGo {
        /// Name of the sheet.
        sheet: String,
        /// Which of its pulls.
        index: u32,
    },
    /// [`World::move_body`].
    MoveBody {
        /// Its name.
        name: String,
        /// Where it shall be, m.
        position: DVec3,
        /// And how turned.
        rotation: DQuat,
    },
    /// [`World::place_body`].
    PlaceBody {
        /// Its name.
        name: String,
        /// Where it is from now on, m.
        position: DVec3,
        /// And how turned.
        rotation: DQuat,
    },
}

impl Input {
    /// Does it to `world`.
    ///
    /// # Errors
    /// When the world refuses it, or has no sheet or body of that name.
    pub fn apply(&self, world: &mut World) -> Result<(), InputError> {
        let of = |world: &mut World, name: &str| -> Result<usize, InputError> {
            let found = world.sheets().iter().position(|s| s.name == name);
            found.ok_or_else(|| InputError::new("sheet", format!("no sheet is named \"{name}\"")))
        };
        match self {
            Self::Set { path, value } => world.set(path, value).map(|_| ()),
            Self::Grab { sheet, uv, stiffness } => {
                let index = of(world, sheet)?;
                world.sheets_mut()[index].grab(*uv, *stiffness).map(|_| ())
            }
            Self::Pull { sheet, index, target } => {
                let at = of(world, sheet)?;
                world.sheets_mut()[at].pull(*index as usize, *target)
            }
            Self::LetGo { sheet, index } => {
                let at = of(world, sheet)?;
                let gone = world.sheets_mut()[at].let_go(*index as usize);
                if gone { Ok(()) } else { Err(InputError::new("pull", "nobody pulls there")) }
            }
            Self::MoveBody { name, position, rotation } => {
                let done = is_place(*position, *rotation) && world.move_body(name, *position, *rotation);
                done.then_some(()).ok_or_else(|| no_such(name, *position, *rotation))
            }
            Self::PlaceBody { name, position, rotation } => {
                let done = is_place(*position, *rotation) && world.place_body(name, *position, *rotation);
                done.then_some(()).ok_or_else(|| no_such(name, *position, *rotation))
            }
        }
    }
}

/// Whether a body can be there.
fn is_place(position: DVec3, rotation: DQuat) -> bool {
    position.is_finite() && rotation.is_finite() && rotation.length_squared() > 0.0
}

/// Why a body did not go there.
fn no_such(name: &str, position: DVec3, rotation: DQuat) -> InputError {
    let there = is_place(position, rotation);
    let problem = if there { "is not there, or does not move so" } else { "cannot be sent to what is no place" };
    InputError::new(format!("bodies.{name}"), problem)
}

/// Sums of where the sheets of `world` are and how they move, sheet by sheet, and last of its bodies.
pub fn sums(world: &World) -> Vec<u32> {
    let mut all = Vec::with_capacity(world.sheets().len() + 1);
    for sheet in world.sheets() {
        let mut sum = crc32fast::Hasher::new();
        for axis in sheet.x.axes().into_iter().chain(sheet.v.axes()) {
            axis.iter().for_each(|v| sum.update(&v.to_le_bytes()));
        }
        all.push(sum.finalize());
    }
    let mut bodies = Keeper::default();
    if let Some(rigid) = world.rigid() {
        (0..rigid.bodies().len()).filter_map(|i| rigid.state(i)).for_each(|state| state.keep(&mut bodies));
    }
    all.push(crc32fast::hash(&bodies.bytes));
    all
}

/// Writes a journal while a world runs.
pub struct Writer {
    file: PathBuf,
    out: BufWriter<File>,
    every: u32,
    /// The part on its way: its snapshot, its steps, and how many there are.
    key: Vec<u8>,
    steps: Keeper,
    count: u32,
    waiting: Vec<Input>,
}

impl Writer {
    /// Creates the file for `world`, with a snapshot every `every` steps, 1 to 1e6.
    ///
    /// # Errors
    /// When `every` is out of range or the file cannot be written.
    pub fn create(file: &Path, world: &World, every: u32) -> Result<Self, InputError> {
        check_range("every", f64::from(every), 1.0, 1e6, "steps")?;
        let scene = world.scene();
        let header = Header { scene: scene.name.clone(), source: scene.to_text()?, base: scene.base.clone(), every };
        let json = serde_json::to_string(&header).map_err(|e| InputError::new("", e.to_string()).in_file(file))?;
        let out = BufWriter::new(File::create(file).map_err(|e| InputError::io(file, &e))?);
        let mut writer = Self {
            file: file.to_path_buf(),
            out,
            every,
            key: world.save(),
            steps: Keeper::default(),
            count: 0,
            waiting: Vec::new(),
        };
        writer.write(format!("{MAGIC}\n{json}\n").as_bytes())?;
        Ok(writer)
    }

    /// Does `input` to `world`, and notes it.
    ///
    /// # Errors
    /// As [`Input::apply`]; nothing is noted then.
    pub fn input(&mut self, world: &mut World, input: Input) -> Result<(), InputError> {
        input.apply(world)?;
        self.waiting.push(input);
        Ok(())
    }

    /// Takes a step of `world`, and notes what came of it.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn step(&mut self, world: &mut World) -> Result<(), InputError> {
        let inputs = postcard::to_extend(&std::mem::take(&mut self.waiting), Vec::new())
            .map_err(|e| InputError::new("input", e.to_string()))?;
        self.steps.blob(&inputs);
        world.step();
        let sums = sums(world);
        self.steps.count(sums.len() as u64);
        sums.iter().for_each(|sum| self.steps.bytes.extend_from_slice(&sum.to_le_bytes()));
        self.count += 1;
        if self.count == self.every {
            self.flush()?;
            world.save_into(&mut self.key);
        }
        Ok(())
    }

    /// Writes the part on its way.
    fn flush(&mut self) -> Result<(), InputError> {
        let mut part = Keeper::default();
        part.blob(&self.key);
        part.count(u64::from(std::mem::take(&mut self.count)));
        part.bytes.append(&mut self.steps.bytes);
        let length = u32::try_from(part.bytes.len()).map_err(|_| {
            InputError::new("every", "makes parts of more than 4 GiB: fewer steps from snapshot to snapshot will do")
        })?;
        self.write(&length.to_le_bytes())?;
        self.write(&crc32fast::hash(&part.bytes).to_le_bytes())?;
        self.write(&part.bytes)
    }

    /// Finishes the file.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn finish(mut self) -> Result<(), InputError> {
        if self.count > 0 {
            self.flush()?;
        }
        self.out.flush().map_err(|e| InputError::io(&self.file, &e))
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), InputError> {
        self.out.write_all(bytes).map_err(|e| InputError::io(&self.file, &e))
    }
}

/// A step of a journal.
#[derive(Clone, Debug, PartialEq)]
struct Step {
    inputs: Vec<Input>,
    sums: Vec<u32>,
}

/// Steps from a snapshot on.
#[derive(Clone, Debug, PartialEq)]
struct Part {
    key: Vec<u8>,
    steps: Vec<Step>,
}

/// A journal that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Journal {
    /// What it is of.
    pub header: Header,
    parts: Vec<Part>,
}

/// Where a run comes apart from its journal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The first step after which something is elsewhere, counted from 1.
    pub step: u64,
    /// Simulated time after it, s.
    pub time_s: f64,
    /// What: the name of a sheet, or "bodies".
    pub what: String,
}

impl Journal {
    /// Reads a journal.
    ///
    /// # Errors
    /// When the file cannot be read, is no journal, ends within a part or is damaged.
    pub fn read(file: &Path) -> Result<Self, InputError> {
        let bytes = std::fs::read(file).map_err(|e| InputError::io(file, &e))?;
        Self::from_bytes(&bytes).map_err(|e| e.in_file(file))
    }

    /// The same of a file's bytes.
    ///
    /// # Errors
    /// As [`Journal::read`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, InputError> {
        let bad = |problem: String| InputError::new("journal", problem);
        let none = || bad(format!("does not begin with \"{MAGIC}\": not a journal"));
        // A file that was cut off within its first line may still say what it is.
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
        let (json, mut rest) = line_of(rest).ok_or_else(|| bad("ends within its header".into()))?;
        let header = serde_json::from_slice(json).map_err(|e| bad(format!("header: {e}")))?;
        let mut parts = Vec::new();
        while !rest.is_empty() {
            let at = parts.len();
            let Some((&[a, b, c, d, e, f, g, h], after)) = rest.split_first_chunk() else {
                return Err(bad(format!("ends within part {at}: {} bytes of its first 8", rest.len())));
            };
            let (length, sum) = (u32::from_le_bytes([a, b, c, d]) as usize, u32::from_le_bytes([e, f, g, h]));
            let Some((body, next)) = after.split_at_checked(length) else {
                return Err(bad(format!("ends within part {at}: {} bytes of {length}", after.len())));
            };
            if crc32fast::hash(body) != sum {
                return Err(bad(format!("part {at} is damaged: its checksum does not fit")));
            }
            parts.push(part_of(body).map_err(|Cut| bad(format!("part {at} cannot be read")))?);
            rest = next;
        }
        Ok(Self { header, parts })
    }

    /// How many steps it has.
    pub fn len(&self) -> u64 {
        self.parts.iter().map(|p| p.steps.len() as u64).sum()
    }

    /// Whether it has none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A world of its scene, at its beginning; `base` is the folder of the scene's files, where it is not the journal's.
    ///
    /// # Errors
    /// When the scene cannot be built, or the first snapshot is not of it.
    pub fn world(&self, base: Option<&Path>) -> Result<World, InputError> {
        let mut scene = Scene::parse(&self.header.source)?;
        scene.base = base.map_or_else(|| self.header.base.clone(), Path::to_path_buf);
        let mut world = World::new(&scene)?;
        if let Some(first) = self.parts.first() {
            world.load(&first.key)?;
        }
        Ok(world)
    }

    /// Takes `world`, which must be one of [`Journal::world`], to after step number `step`: from the last snapshot before it on.
    ///
    /// # Errors
    /// When the journal has not that many steps, or one of its snapshots or inputs is refused.
    pub fn seek(&self, world: &mut World, step: u64) -> Result<(), InputError> {
        if step > self.len() {
            return Err(InputError::new("step", format!("{step} is outside 0 to {}", self.len())));
        }
        let mut before = 0;
        for part in &self.parts {
            let here = part.steps.len() as u64;
            if step <= before + here {
                world.load(&part.key)?;
                let steps = part.steps.iter().take((step - before) as usize);
                return steps.into_iter().try_for_each(|s| s.take(world));
            }
            before += here;
        }
        Ok(())
    }

    /// Runs all of it again in `world` and says where that first comes apart from what was written; `None` where it does not. Every part
    /// begins with its own snapshot, which is compared too.
    ///
    /// # Errors
    /// When a snapshot or an input is refused.
    pub fn check(&self, world: &mut World) -> Result<Option<Difference>, InputError> {
        let mut number = 0;
        if let Some(first) = self.parts.first() {
            world.load(&first.key)?;
        }
        for part in &self.parts {
            for step in &part.steps {
                step.take(world)?;
                number += 1;
                let now = sums(world);
                if let Some(at) = (0..now.len().max(step.sums.len())).find(|i| now.get(*i) != step.sums.get(*i)) {
                    let what = world.sheets().get(at).map_or_else(|| "bodies".to_owned(), |s| s.name.clone());
                    return Ok(Some(Difference { step: number, time_s: world.time(), what }));
                }
            }
        }
        Ok(None)
    }
}

impl Step {
    fn take(&self, world: &mut World) -> Result<(), InputError> {
        self.inputs.iter().try_for_each(|input| input.apply(world))?;
        world.step();
        Ok(())
    }
}

/// The first line of `bytes`, and what follows it.
fn line_of(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().take(LONGEST).position(|b| *b == b'\n')?;
    Some((&bytes[..end], &bytes[end + 1..]))
}

fn part_of(body: &[u8]) -> Taken<Part> {
    let mut from = Taker::new(body);
    let key = from.blob()?.to_vec();
    let mut steps = Vec::new();
    for _ in 0..from.length(2)? {
        let inputs = postcard::from_bytes(from.blob()?).map_err(|_| Cut)?;
        let mut sums = Vec::new();
        for _ in 0..from.length(4)? {
            sums.push(from.sum()?);
        }
        steps.push(Step { inputs, sums });
    }
    if from.is_empty() { Ok(Part { key, steps }) } else { Err(Cut) }
}
