//! Serialisation of a world: all state that the next step depends on, for bit-exact continuation.
//!
//! Little endian: the eight bytes `SHEETWRK`, the version (u32), the number of bytes after the
//! checksum (u64), their CRC-32 (u32); then a checksum of the structure (u32: sheets, bodies and
//! heaters as the scene describes them), settings, bodies, sheets, contact, heat, time. Parameters
//! and grabs are included; the scene is not: a snapshot is loaded by its own world or by a new one
//! of the same scene. Events before the snapshot are not sent again.

use crc32fast::Hasher;

use crate::contact::SheetContact;
use crate::contact::node::drawn_contact::DrawnContact;
use crate::error::{InputError, SnapshotError};
use crate::scene::{Air, ContactDefaults, ContactSurface, Scene, WindZone};
use crate::serialize::{CorruptState, ReadResult, State, StateReader, StateWriter};
use crate::sheet::refine::{Resolution, resolution_of};
use crate::sheet::{Sheet, serialization};
use crate::world::World;
use crate::world::remap::{deserialise_grids, grid_of, serialise_grids};

const MAGIC: &[u8; 8] = b"SHEETWRK";
const VERSION: u32 = 10;
/// Message about a snapshot of another world.
const OTHER_STRUCTURE: &str = "is of other sheets or bodies than there are now";
/// Bytes of position and velocity of a node.
const BYTES_PER_NODE: u64 = 48;
/// Bytes before the body: magic, version, length, checksum.
const HEADER_LENGTH: usize = 8 + 4 + 8 + 4;

/// Lower bound of the number of nodes of `sheet` on a grid. The number on a triangle mesh is known
/// only after meshing: it grows at least with the length in cells of a narrow strip. A refined mesh
/// has at least a quarter as many nodes as triangles.
fn min_nodes(sheet: &Sheet, Resolution { grid, levels }: &Resolution) -> u64 {
    let own = grid_of(sheet);
    if sheet.mesh().is_none() {
        return u64::from(grid.0) * u64::from(grid.1);
    }
    if let Some(levels) = levels {
        return levels.iter().map(|level| 4_u64.pow((*level).into())).sum::<u64>() / 4;
    }
    let longer = f64::min(f64::from(grid.0) / f64::from(own.0), f64::from(grid.1) / f64::from(own.1));
    (0.25 * longer.min(longer * longer) * sheet.node_count() as f64) as u64
}

impl World {
    /// Serialise the world for [`World::deserialise`].
    pub fn serialise(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.serialise_into(&mut bytes);
        bytes
    }

    /// Serialise the world into `bytes`, replacing their content and reusing their allocation.
    pub fn serialise_into(&self, bytes: &mut Vec<u8>) {
        let mut to = StateWriter { bytes: std::mem::take(bytes) };
        to.bytes.clear();
        to.bytes.extend_from_slice(&[0; HEADER_LENGTH]);
        self.write_state(&mut to);
        let length = (to.bytes.len() - HEADER_LENGTH) as u64;
        let sum = crc32fast::hash(&to.bytes[HEADER_LENGTH..]);
        let head = [&MAGIC[..], &VERSION.to_le_bytes(), &length.to_le_bytes(), &sum.to_le_bytes()].concat();
        to.bytes[..HEADER_LENGTH].copy_from_slice(&head);
        *bytes = to.bytes;
    }

    /// Load the state of `bytes`, parameters included. The next step equals the next step of the
    /// saved world bit for bit.
    ///
    /// # Errors
    /// When `bytes` are no snapshot, truncated, damaged, of another version, or of other sheets or
    /// bodies than this world's; nothing changes then.
    pub fn deserialise(&mut self, bytes: &[u8]) -> Result<(), SnapshotError> {
        let body = body_of(bytes)?;
        let grids = self.grids_of(body)?;
        let back = self.serialise();
        let before = self.exchange_grids(&grids).map_err(other_structure)?;
        if let Err(other) = self.check_make(body) {
            self.restore_sheets(before);
            return Err(other);
        }
        if self.read_state(body).is_err() {
            self.restore_sheets(before);
            // The world's own state is always accepted.
            let _ = self.read_state(&back[HEADER_LENGTH..]);
            let problem =
                "is of sheets that lay otherwise when they were first stepped, or was not written by this program";
            return Err(SnapshotError::OtherWorld(InputError::new("snapshot", problem)));
        }
        Ok(())
    }

    fn check_make(&self, body: &[u8]) -> Result<(), SnapshotError> {
        let make = body.first_chunk().map(|make| u32::from_le_bytes(*make));
        if make == Some(self.structure_checksum()) {
            return Ok(());
        }
        Err(other_structure(CorruptState))
    }

    /// Grids of the sheets in a snapshot of this world's scene.
    fn grids_of(&self, body: &[u8]) -> Result<Vec<Resolution>, SnapshotError> {
        let mut from = StateReader::new(body);
        let scene = from.checksum().and_then(|_| from.checksum()).map_err(other_structure)?;
        let grids = deserialise_grids(&mut from, &self.scene).map_err(other_structure)?;
        let elsewhere = grids.iter().zip(&self.sheets).filter(|(at, sheet)| resolution_of(sheet) != **at);
        let masses: u64 = elsewhere.map(|(at, sheet)| min_nodes(sheet, at)).sum();
        // Sheets are built only when the snapshot is long enough for their nodes.
        let there = masses.saturating_mul(BYTES_PER_NODE) <= body.len() as u64;
        let ours = scene == self.structure.value() && grids.len() == self.sheets.len();
        if ours && there { Ok(grids) } else { Err(other_structure(CorruptState)) }
    }

    /// Checksum of the structure of the world.
    fn structure_checksum(&self) -> u32 {
        let mut to = StateWriter::default();
        to.bytes.extend_from_slice(&self.structure.value().to_le_bytes());
        self.sheets.iter().for_each(|s| serialization::serialise_layout(s, &mut to));
        to.count(self.rigid.as_deref().map_or(0, |r| 1 + r.bodies().len() as u64));
        to.count(self.heat.as_ref().map_or(0, |h| 1 + h.sources() as u64));
        crc32fast::hash(&to.bytes)
    }

    fn write_state(&self, to: &mut StateWriter) {
        to.bytes.extend_from_slice(&self.structure_checksum().to_le_bytes());
        to.bytes.extend_from_slice(&self.structure.value().to_le_bytes());
        serialise_grids(&self.sheets, to);
        self.sheets.iter().for_each(|s| to.flag(serialization::is_changed(s)));
        let settings = self.serialise_settings();
        to.blob(&settings);
        self.rigid.iter().for_each(|rigid| rigid.serialise(to));
        for (sheet, contact) in self.sheets.iter().zip(&self.sheet_contacts) {
            contact.serialise_surface(to);
            serialization::serialise_state(sheet, to, |to| {
                contact.clearance.serialise(to, sheet.state.displaced);
                if sheet.model.contact_surface != ContactSurface::Masses {
                    DrawnContact::serialise(contact.drawn.as_deref(), to);
                }
            });
        }
        self.islands.serialise(self.sheets.len(), to);
        self.heat.iter().for_each(|heat| heat.serialise(to));
        self.contact_logs.iter().for_each(|t| t.serialise(to));
        self.lod.iter().for_each(|detail| detail.serialise(to));
        self.penetration_check.serialise(to);
        self.serialise_contacts(to);
        self.serialise_loads(to);
        to.number(self.time);
        to.count(self.steps);
        to.count(self.event_count());
    }

    /// Deserialise the output of [`World::write_state`] from a world of the same structure.
    fn read_state(&mut self, body: &[u8]) -> ReadResult {
        let mut from = StateReader::new(body.get(8..).ok_or(CorruptState)?);
        deserialise_grids(&mut from, &self.scene)?;
        for index in 0..self.sheets.len() {
            // Changes by heat, creep and fracture are undone only by building the sheet again.
            if !from.flag()? && serialization::is_changed(&self.sheets[index]) {
                self.sheets[index] = self.fresh_sheet(index, &resolution_of(&self.sheets[index]))?;
                self.sheet_contacts[index] = SheetContact::default();
            }
        }
        let settings = from.blob()?;
        if settings != self.serialise_settings() {
            self.deserialise_settings(settings)?;
        }
        self.rigid.iter_mut().try_for_each(|rigid| rigid.deserialise(&mut from, &self.scene))?;
        for (sheet, contact) in self.sheets.iter_mut().zip(&mut self.sheet_contacts) {
            contact.deserialise_surface(sheet, &mut from)?;
            DrawnContact::prepare(&mut contact.drawn, sheet);
            serialization::deserialise_state(sheet, &mut from, |from, masses| {
                contact.clearance.deserialise(from, masses)?;
                contact.drawn.iter_mut().try_for_each(|drawn| drawn.deserialise(from))
            })?;
            contact.prepare_opened(sheet);
        }
        self.islands.deserialise(&mut self.sheet_contacts, &mut from)?;
        self.heat.iter_mut().try_for_each(|heat| heat.deserialise(&mut from, &self.sheets))?;
        self.contact_logs.iter_mut().try_for_each(|t| t.deserialise(&mut from))?;
        self.lod.iter_mut().try_for_each(|detail| detail.deserialise(&mut from))?;
        self.penetration_check.deserialise(&mut from)?;
        self.deserialise_contacts(&mut from)?;
        self.deserialise_loads(&mut from)?;
        (self.time, self.steps) = (from.number()?, from.count()?);
        let told = from.count()?;
        self.events.truncate(usize::try_from(told.saturating_sub(self.drained_events)).unwrap_or(usize::MAX));
        self.drained_events = told - self.events.len() as u64;
        if from.is_empty() { Ok(()) } else { Err(CorruptState) }
    }

    /// Serialise the settings that can change while the world runs.
    fn serialise_settings(&self) -> Vec<u8> {
        let mut to = StateWriter::default();
        let Air { factor, per, density, wind } = self.air;
        to.vector(self.gravity);
        to.numbers(&[factor, per, density]);
        to.vector(wind);
        to.blob(&postcard::to_extend(&self.wind_zones, Vec::new()).unwrap_or_default());
        to.text(self.engine.name());
        to.numbers(&[self.tolerance, self.dt]);
        to.flag(self.sleep);
        let contact = postcard::to_extend(&self.scene.contact, Vec::new()).unwrap_or_default();
        to.blob(&contact);
        self.heat.iter().for_each(|heat| heat.serialise_settings(&mut to));
        self.lod.iter().for_each(|detail| detail.serialise_settings(&mut to));
        self.sheets.iter().for_each(|s| serialization::serialise_settings(s, &mut to));
        to.bytes
    }

    fn deserialise_settings(&mut self, bytes: &[u8]) -> ReadResult {
        let mut from = StateReader::new(bytes);
        self.set_gravity_unbounded(from.vector()?);
        let (factor, per, density) = (from.number()?, from.number()?, from.number()?);
        self.set_air(Air { factor, per, density, wind: from.vector()? }).map_err(|_| CorruptState)?;
        let zones: Vec<WindZone> = postcard::from_bytes(from.blob()?).map_err(|_| CorruptState)?;
        if zones != self.wind_zones {
            self.set_wind_zones(&zones).map_err(|_| CorruptState)?;
        }
        self.engine = from.text()?.parse().map_err(|_| CorruptState)?;
        (self.tolerance, self.dt) = (from.number()?, from.number()?);
        if !(self.dt > 0.0 && self.dt <= 1.0 && self.tolerance > 0.0 && self.gravity.is_finite()) {
            return Err(CorruptState);
        }
        let sleep = from.flag()?;
        if sleep != self.sleep {
            self.set_sleep(sleep);
        }
        let contact: ContactDefaults = postcard::from_bytes(from.blob()?).map_err(|_| CorruptState)?;
        if contact != self.scene.contact {
            if let Some(rigid) = &mut self.rigid {
                rigid.set_contact(&contact);
            }
            self.scene.contact = contact;
        }
        self.heat.iter_mut().try_for_each(|heat| heat.deserialise_settings(&mut from))?;
        self.lod.iter_mut().try_for_each(|detail| detail.deserialise_settings(&mut from))?;
        let tolerance = self.tolerance;
        self.sheets.iter_mut().try_for_each(|s| serialization::deserialise_settings(s, &mut from, tolerance))?;
        if from.is_empty() { Ok(()) } else { Err(CorruptState) }
    }

    /// Return to the state in `bytes` of this world, keeping the present parameters. Returns
    /// `false` when that is impossible.
    pub(crate) fn roll_back(&mut self, bytes: &[u8]) -> bool {
        let Ok(body) = body_of(bytes) else { return false };
        let Ok(grids) = self.grids_of(body) else { return false };
        let elsewhere = grids.iter().zip(&self.sheets).any(|(at, sheet)| resolution_of(sheet) != *at);
        let start = elsewhere.then(|| self.serialise());
        // A change of grid keeps the settings of the sheet.
        if (0..grids.len()).any(|i| self.change_resolution(i, &grids[i]).is_err()) || self.check_make(body).is_err() {
            start.iter().for_each(|start| drop(self.deserialise(start)));
            return false;
        }
        let (back, settings) = (self.serialise(), self.serialise_settings());
        let mut taken = self.read_state(body);
        if taken.is_ok() && settings != self.serialise_settings() {
            taken = self.deserialise_settings(&settings);
        }
        if taken.is_err() {
            let _ = self.read_state(&back[HEADER_LENGTH..]);
            start.iter().for_each(|start| drop(self.deserialise(start)));
        }
        taken.is_ok()
    }
}

fn other_structure(_: CorruptState) -> SnapshotError {
    SnapshotError::OtherWorld(InputError::new("snapshot", OTHER_STRUCTURE))
}

/// Body of a snapshot, after a check of magic, version, length and checksum.
fn body_of(bytes: &[u8]) -> Result<&[u8], SnapshotError> {
    let bad = |problem: String| SnapshotError::Damaged(InputError::new("snapshot", problem));
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return Err(bad("does not begin with \"SHEETWRK\": not a snapshot".into()));
    };
    let ended = || bad(format!("is cut off: {} bytes of its first {HEADER_LENGTH}", bytes.len()));
    let (version, rest) = rest.split_first_chunk().ok_or_else(ended)?;
    let version = u32::from_le_bytes(*version);
    if version != VERSION {
        let problem = format!("is a snapshot of version {version}; this program reads version {VERSION}");
        return Err(SnapshotError::Version(InputError::new("snapshot", problem)));
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

/// Checksum of the structure of a scene: the parts that cannot change while a world runs. It is
/// composed of the checksums of the objects, so that a change of one does not visit the others.
#[derive(Clone, Default)]
pub(crate) struct StructureChecksum {
    sheets: Vec<Hasher>,
    bodies: Vec<Hasher>,
    value: u32,
}

impl StructureChecksum {
    /// Checksum of the structure of `scene`.
    pub fn new(scene: &Scene) -> Self {
        let sheets = scene.sheets.iter().map(checksum_of).collect();
        let bodies = scene.bodies.iter().map(checksum_of).collect();
        let mut all = Self { sheets, bodies, ..Self::default() };
        all.update(scene);
        all
    }

    /// Update after a sheet was added to `scene`.
    pub fn add_sheet(&mut self, scene: &Scene) {
        self.sheets.extend(scene.sheets.last().map(checksum_of));
        self.update(scene);
    }

    /// Update after the sheet `index` was removed from `scene`.
    pub fn remove_sheet(&mut self, index: usize, scene: &Scene) {
        self.sheets.remove(index);
        self.update(scene);
    }

    /// Update after a body was added to `scene`.
    pub fn add_body(&mut self, scene: &Scene) {
        self.bodies.extend(scene.bodies.last().map(checksum_of));
        self.update(scene);
    }

    /// Checksum.
    pub fn value(&self) -> u32 {
        self.value
    }

    fn update(&mut self, scene: &Scene) {
        let Scene { room, heaters, .. } = scene;
        let mut all = Hasher::new();
        for list in [&self.sheets, &self.bodies] {
            all.update(b"[");
            for (i, part) in list.iter().enumerate() {
                if i > 0 {
                    all.update(b", ");
                }
                all.combine(part);
            }
            all.update(b"] ");
        }
        all.update(format!("{room:?} {heaters:?}").as_bytes());
        self.value = all.finalize();
    }
}

/// Checksum of the description of one object.
fn checksum_of(part: &impl std::fmt::Debug) -> Hasher {
    let mut hasher = Hasher::new();
    hasher.update(format!("{part:?}").as_bytes());
    hasher
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_of_a_changed_structure_is_that_of_its_text() {
        let text =
            "(room: (x: (0, 1), y: (0, 1), z: (0, 1)), sheets: [(name: \"a\", placement: (position: (0, 0, 0.5)))],
            bodies: [(shape: Ball(0.1), placement: (position: (0, 0.5, 0.5)))])";
        let mut world = World::new(&Scene::parse(text).expect("valid")).expect("valid");
        let check = |world: &World| {
            let Scene { sheets, bodies, room, heaters, .. } = world.scene();
            let text = format!("{sheets:?} {bodies:?} {room:?} {heaters:?}");
            assert_eq!(world.structure.value(), crc32fast::hash(text.as_bytes()), "{text}");
        };
        check(&world);
        let (sheet, body) = (world.scene().sheets[0].clone(), world.scene().bodies[0].clone());
        let (second, third) = (world.add_sheet(&sheet).expect("valid"), world.add_sheet(&sheet).expect("valid"));
        check(&world);
        let ball = world.add_body(&body).expect("valid");
        check(&world);
        let first = world.sheet_id("a").expect("there");
        assert!(world.remove_sheet(second) && world.remove_sheet(first));
        check(&world);
        assert!(world.remove_body(ball) && world.remove_sheet(third));
        check(&world);
        assert!(world.sheets().is_empty());
    }
}
