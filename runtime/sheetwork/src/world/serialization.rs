//! Serialisation of a world: all state that the next step depends on, for bit-exact continuation.
//!
//! Little endian: the eight bytes `SHEETWRK`, the version (u32), the number of bytes after the
//! checksum (u64), their CRC-32 (u32); then a checksum of the structure (u32: sheets, bodies and
//! heaters as the scene describes them), settings, bodies, sheets, contact, heat, time. Parameters
//! and grabs are included; the scene is not: a snapshot is loaded by its own world or by a new one
//! of the same scene. Events before the snapshot are not sent again.

use crate::contact::SheetContact;
use crate::error::InputError;
use crate::scene::{Air, ContactDefaults, Scene};
use crate::serialize::{Cut, Keeper, Taken, Taker};
use crate::sheet::Sheet;
use crate::world::World;
use crate::world::remap::{Grid, grid_of, keep_grids, take_grids};

const MAGIC: &[u8; 8] = b"SHEETWRK";
const VERSION: u32 = 5;
/// Message about a snapshot of another world.
const OTHERS: &str = "is of other sheets or bodies than there are now";
/// Bytes of position and velocity of a node.
const OF_A_MASS: u64 = 48;
/// Bytes before the body: magic, version, length, checksum.
const HEAD: usize = 8 + 4 + 8 + 4;

/// Lower bound of the number of nodes of `sheet` on `grid`. The number on a triangle mesh is known
/// only after meshing: it grows at least with the length in cells of a narrow strip.
fn fewest_masses(sheet: &Sheet, grid: Grid) -> u64 {
    let own = grid_of(sheet);
    if sheet.mesh().is_none() {
        return u64::from(grid.0) * u64::from(grid.1);
    }
    let longer = f64::min(f64::from(grid.0) / f64::from(own.0), f64::from(grid.1) / f64::from(own.1));
    (0.25 * longer.min(longer * longer) * sheet.masses() as f64) as u64
}

impl World {
    /// Serialise the world for [`World::load`].
    pub fn save(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.save_into(&mut bytes);
        bytes
    }

    /// Serialise the world into `bytes`, replacing their content and reusing their allocation.
    pub fn save_into(&self, bytes: &mut Vec<u8>) {
        let mut to = Keeper { bytes: std::mem::take(bytes) };
        to.bytes.clear();
        to.bytes.extend_from_slice(&[0; HEAD]);
        self.keep(&mut to);
        let length = (to.bytes.len() - HEAD) as u64;
        let sum = crc32fast::hash(&to.bytes[HEAD..]);
        let head = [&MAGIC[..], &VERSION.to_le_bytes(), &length.to_le_bytes(), &sum.to_le_bytes()].concat();
        to.bytes[..HEAD].copy_from_slice(&head);
        *bytes = to.bytes;
    }

    /// Load the state of `bytes`, parameters included. The next step equals the next step of the
    /// saved world bit for bit.
    ///
    /// # Errors
    /// When `bytes` are no snapshot, truncated, damaged, of another version, or of other sheets or
    /// bodies than this world's; nothing changes then.
    pub fn load(&mut self, bytes: &[u8]) -> Result<(), InputError> {
        let body = body_of(bytes)?;
        let grids = self.grids_of(body)?;
        let back = self.save();
        let before = self.go_to_grids(&grids).map_err(|Cut| InputError::new("snapshot", OTHERS))?;
        if let Err(other) = self.check_make(body) {
            self.put_back(before);
            return Err(other);
        }
        if self.take(body).is_err() {
            self.put_back(before);
            // The world's own state is always accepted.
            let _ = self.take(&back[HEAD..]);
            return Err(InputError::new(
                "snapshot",
                "is of sheets that lay otherwise when they were first stepped, or was not written by this program",
            ));
        }
        Ok(())
    }

    fn check_make(&self, body: &[u8]) -> Result<(), InputError> {
        let make = body.first_chunk().map(|make| u32::from_le_bytes(*make));
        if make == Some(self.make()) {
            return Ok(());
        }
        Err(InputError::new("snapshot", OTHERS))
    }

    /// Grids of the sheets in a snapshot of this world's scene.
    fn grids_of(&self, body: &[u8]) -> Result<Vec<Grid>, InputError> {
        let other = |Cut| InputError::new("snapshot", OTHERS);
        let mut from = Taker::new(body);
        let scene = from.sum().and_then(|_| from.sum()).map_err(other)?;
        let grids = take_grids(&mut from).map_err(other)?;
        let elsewhere = grids.iter().zip(&self.sheets).filter(|(grid, sheet)| grid_of(sheet) != **grid);
        let masses: u64 = elsewhere.map(|(grid, sheet)| fewest_masses(sheet, *grid)).sum();
        // Sheets are built only when the snapshot is long enough for their nodes.
        let there = masses.saturating_mul(OF_A_MASS) <= body.len() as u64;
        let ours = scene == self.make && grids.len() == self.sheets.len();
        if ours && there { Ok(grids) } else { Err(other(Cut)) }
    }

    /// Checksum of the structure of the world.
    fn make(&self) -> u32 {
        let mut to = Keeper::default();
        to.bytes.extend_from_slice(&self.make.to_le_bytes());
        self.sheets.iter().for_each(|s| s.keep_make(&mut to));
        to.count(self.rigid.as_ref().map_or(0, |r| 1 + r.bodies().len() as u64));
        to.count(self.heat.as_ref().map_or(0, |h| 1 + h.sources() as u64));
        crc32fast::hash(&to.bytes)
    }

    fn keep(&self, to: &mut Keeper) {
        to.bytes.extend_from_slice(&self.make().to_le_bytes());
        to.bytes.extend_from_slice(&self.make.to_le_bytes());
        keep_grids(&self.sheets, to);
        self.sheets.iter().for_each(|s| to.flag(s.is_changed()));
        let settings = self.settings();
        to.blob(&settings);
        self.rigid.iter().for_each(|rigid| rigid.keep(to));
        for (sheet, contact) in self.sheets.iter().zip(&self.contacts) {
            contact.keep_surface(to);
            sheet.keep_state(to, |to| contact.clearance.keep(to, sheet.displaced));
        }
        self.groups.keep(self.sheets.len(), to);
        self.heat.iter().for_each(|heat| heat.keep(to));
        self.touches.iter().for_each(|t| t.keep(to));
        self.detail.iter().for_each(|detail| detail.keep(to));
        to.number(self.time);
        to.count(self.steps);
        to.count(self.told_before + self.events.len() as u64);
    }

    /// Deserialise the output of [`World::keep`] from a world of the same structure.
    fn take(&mut self, body: &[u8]) -> Taken {
        let mut from = Taker::new(body.get(8..).ok_or(Cut)?);
        take_grids(&mut from)?;
        for index in 0..self.sheets.len() {
            // Changes by heat, creep and fracture are undone only by building the sheet again.
            if !from.flag()? && self.sheets[index].is_changed() {
                self.renew(index)?;
            }
        }
        let settings = from.blob()?;
        if settings != self.settings() {
            self.take_settings(settings)?;
        }
        if let Some(rigid) = &mut self.rigid {
            rigid.take(&mut from, &self.scene)?;
        }
        for (sheet, contact) in self.sheets.iter_mut().zip(&mut self.contacts) {
            contact.take_surface(sheet, &mut from)?;
            sheet.take_state(&mut from, |from, masses| contact.clearance.take(from, masses))?;
            contact.prepare_opened(sheet);
        }
        self.groups.take(&mut self.contacts, &mut from)?;
        if let Some(heat) = &mut self.heat {
            heat.take(&mut from, &self.sheets)?;
        }
        self.touches.iter_mut().try_for_each(|t| t.take(&mut from))?;
        if let Some(detail) = &mut self.detail {
            detail.take(&mut from)?;
        }
        (self.time, self.steps) = (from.number()?, from.count()?);
        let told = from.count()?;
        self.events.truncate(usize::try_from(told.saturating_sub(self.told_before)).unwrap_or(usize::MAX));
        self.told_before = told - self.events.len() as u64;
        if from.is_empty() { Ok(()) } else { Err(Cut) }
    }

    /// Build the sheet `index` of the scene again.
    fn renew(&mut self, index: usize) -> Taken {
        let watched = self.sheets[index].is_watched();
        let grid = grid_of(&self.sheets[index]);
        let mut sheet = self.built_at(index, grid).map_err(|_| Cut)?;
        sheet.watch_buckling(watched);
        self.sheets[index] = sheet;
        self.contacts[index] = SheetContact::default();
        Ok(())
    }

    /// Serialise the settings that can change while the world runs.
    fn settings(&self) -> Vec<u8> {
        let mut to = Keeper::default();
        let Air { factor, per, density, wind } = self.air;
        to.vector(self.gravity);
        to.numbers(&[factor, per, density]);
        to.vector(wind);
        to.text(self.engine.name());
        to.numbers(&[self.tolerance, self.dt]);
        to.flag(self.sleep);
        let contact = postcard::to_extend(&self.scene.contact, Vec::new()).unwrap_or_default();
        to.blob(&contact);
        self.heat.iter().for_each(|heat| heat.keep_settings(&mut to));
        self.detail.iter().for_each(|detail| detail.keep_settings(&mut to));
        self.sheets.iter().for_each(|s| s.keep_settings(&mut to));
        to.bytes
    }

    fn take_settings(&mut self, bytes: &[u8]) -> Taken {
        let mut from = Taker::new(bytes);
        self.set_gravity_unbounded(from.vector()?);
        let (factor, per, density) = (from.number()?, from.number()?, from.number()?);
        self.set_air(Air { factor, per, density, wind: from.vector()? }).map_err(|_| Cut)?;
        self.engine = from.text()?.parse().map_err(|_| Cut)?;
        (self.tolerance, self.dt) = (from.number()?, from.number()?);
        if !(self.dt > 0.0 && self.dt <= 1.0 && self.tolerance > 0.0 && self.gravity.is_finite()) {
            return Err(Cut);
        }
        let sleep = from.flag()?;
        if sleep != self.sleep {
            self.set_sleep(sleep);
        }
        let contact: ContactDefaults = postcard::from_bytes(from.blob()?).map_err(|_| Cut)?;
        if contact != self.scene.contact {
            if let Some(rigid) = &mut self.rigid {
                rigid.set_contact(&contact);
            }
            self.scene.contact = contact;
        }
        if let Some(heat) = &mut self.heat {
            heat.take_settings(&mut from)?;
        }
        if let Some(detail) = &mut self.detail {
            detail.take_settings(&mut from)?;
        }
        let tolerance = self.tolerance;
        self.sheets.iter_mut().try_for_each(|s| s.take_settings(&mut from, tolerance))?;
        if from.is_empty() { Ok(()) } else { Err(Cut) }
    }

    /// Return to the state in `bytes` of this world, keeping the present parameters. Returns
    /// `false` when that is impossible.
    pub(crate) fn go_back(&mut self, bytes: &[u8]) -> bool {
        let Ok(body) = body_of(bytes) else { return false };
        let Ok(grids) = self.grids_of(body) else { return false };
        let elsewhere = grids.iter().zip(&self.sheets).any(|(grid, sheet)| grid_of(sheet) != *grid);
        let start = elsewhere.then(|| self.save());
        // A change of grid keeps the settings of the sheet.
        if (0..grids.len()).any(|i| self.resample_index(i, grids[i]).is_err()) || self.check_make(body).is_err() {
            start.iter().for_each(|start| drop(self.load(start)));
            return false;
        }
        let (back, settings) = (self.save(), self.settings());
        let mut taken = self.take(body);
        if taken.is_ok() && settings != self.settings() {
            taken = self.take_settings(&settings);
        }
        if taken.is_err() {
            let _ = self.take(&back[HEAD..]);
            start.iter().for_each(|start| drop(self.load(start)));
        }
        taken.is_ok()
    }
}

/// Body of a snapshot, after a check of magic, version, length and checksum.
fn body_of(bytes: &[u8]) -> Result<&[u8], InputError> {
    let bad = |problem: String| InputError::new("snapshot", problem);
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return Err(bad("does not begin with \"SHEETWRK\": not a snapshot".into()));
    };
    let ended = || bad(format!("is cut off: {} bytes of its first {HEAD}", bytes.len()));
    let (version, rest) = rest.split_first_chunk().ok_or_else(ended)?;
    let version = u32::from_le_bytes(*version);
    if version != VERSION {
        return Err(bad(format!("is a snapshot of version {version}; this program reads version {VERSION}")));
    }
    let (length, rest) = rest.split_first_chunk().ok_or_else(ended)?;
    let (sum, body) = rest.split_first_chunk().ok_or_else(ended)?;
    let (length, sum) = (u64::from_le_bytes(*length), u32::from_le_bytes(*sum));
    if body.len() as u64 != length {
        let how = if (body.len() as u64) < length { "is cut off" } else { "goes on after its end" };
        return Err(bad(format!("{how}: {} bytes of {length}", body.len())));
    }
    if crc32fast::hash(body) != sum {
        return Err(bad("is damaged: its checksum does not fit".into()));
    }
    Ok(body)
}

/// Checksum of the structure of `scene`: the parts that cannot change while a world runs.
pub(crate) fn make_of(scene: &Scene) -> u32 {
    let Scene { sheets, bodies, room, heaters, .. } = scene;
    crc32fast::hash(format!("{sheets:?} {bodies:?} {room:?} {heaters:?}").as_bytes())
}
