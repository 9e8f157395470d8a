//! Check of the invariant of contact: no sheet lies within a body, another sheet or itself by more
//! than a tenth of its thickness.
//!
//! Every pair of triangles, and every triangle and convex solid, whose boxes meet is tested
//! exactly (`collision/overlap`), independently of the contact solver: the sheets of islands whose
//! contact solution was not accepted in this step, or that began it with an overlap, or all with
//! [`World::set_penetration_check`]. Triangles whose nodes are all held, and parts of bodies that
//! are not convex, do not count, nor does a sheet compressed between two bodies that do not reach
//! its mid-surface. Triangles of one sheet count where they are farther apart at rest than their
//! size and the thickness. Lengths in m.

use glam::DVec3;

use crate::collision::overlap::half_thickness;
use crate::collision::overlap::sheets::{NearestPlace, PlacedSheet};
use crate::collision::settings::{DetectionSettings, OverlapSettings};
use crate::islands::event::{Event, EventKind};
use crate::serialize::{ReadResult, State, StateReader, StateWriter};
use crate::sheet::Sheet;
use crate::world::World;
use crate::world::placed_solids::{PlacedSolid, placed_solids};

const SETTINGS: OverlapSettings = DetectionSettings::DEFAULT.overlap;

/// Object that a sheet penetrates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PenetratedObject {
    /// The body of this index in [`crate::rigid::RigidWorld::bodies`].
    Body(usize),
    /// The sheet of this index in [`World::sheets`].
    Sheet(usize),
    /// The sheet itself.
    Itself,
}

/// Penetration of a sheet beyond the accepted depth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Penetration {
    /// Index of the sheet in [`World::sheets`].
    pub sheet: usize,
    /// Penetrated object.
    pub with: PenetratedObject,
    /// Depth, m: overlap of the surfaces of the material. Between sheets at most the thickness.
    pub depth: f64,
    /// Place, m.
    pub place: DVec3,
}

/// State of the check.
#[derive(Default)]
pub(super) struct PenetrationCheck {
    /// Whether every step is checked.
    always: bool,
    /// Pairs that penetrate at present, each is reported once: sheet, kind and index of the other.
    pairs: Vec<[u32; 3]>,
    /// Description and depth, in thicknesses, of the deepest penetration so far.
    deepest: Option<(f64, String)>,
}

impl PenetrationCheck {
    /// An empty check, of every step if `always`.
    pub fn new(always: bool) -> Self {
        Self { always, ..Self::default() }
    }

    /// Whether every step is checked.
    pub fn is_always(&self) -> bool {
        self.always
    }

    /// Serialise the pairs that are already reported.
    pub fn serialise(&self, to: &mut StateWriter) {
        to.count(self.pairs.len() as u64);
        self.pairs.serialise(to);
    }

    /// Deserialise the output of [`PenetrationCheck::serialise`].
    pub fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        self.pairs.clear();
        for _ in 0..from.count()? {
            let mut pair = [0; 3];
            pair.deserialise(from)?;
            self.pairs.push(pair);
        }
        Ok(())
    }
}

/// Pair of a penetration, for the memory of those reported.
fn pair_of(found: &Penetration) -> [u32; 3] {
    let (kind, index) = match found.with {
        PenetratedObject::Body(index) => (0, index),
        PenetratedObject::Sheet(index) => (1, index),
        PenetratedObject::Itself => (2, 0),
    };
    [found.sheet as u32, kind, index as u32]
}

impl World {
    /// Check every step for penetration beyond a tenth of the thickness, by a test of every pair of
    /// triangles that is independent of the contact solver, not only the steps whose contact
    /// solution was not accepted. Each pair found sends one [`EventKind::Penetration`], and the
    /// report's status names the deepest. Default: off. The motion does not depend on it.
    pub fn set_penetration_check(&mut self, on: bool) {
        self.penetration_check.always = on;
    }

    /// Penetrations deeper than a tenth of the thickness in the present state: by sheet, with
    /// bodies first, then the sheets before it, then itself.
    pub fn penetrations(&self) -> Vec<Penetration> {
        self.penetrations_of(|_| true)
    }

    /// Penetrations of the sheets that `counts` accepts.
    fn penetrations_of(&self, counts: impl Fn(&Sheet) -> bool) -> Vec<Penetration> {
        let solids = placed_solids(self.rigid.as_deref());
        let placed: Vec<PlacedSheet> = self.sheets.iter().map(PlacedSheet::free).collect();
        let mut all = Vec::new();
        for (index, sheet) in placed.iter().enumerate().filter(|(_, sheet)| counts(sheet.sheet)) {
            let half = half_thickness(sheet.sheet);
            // Depths are judged by the thinner of two sheets.
            let mut add = |with, depth: f64, thinner: f64, found: NearestPlace| {
                if depth > 2.0 * SETTINGS.depth * thinner && !is_compressed(&solids, &found, half) {
                    all.push(Penetration { sheet: index, with, depth, place: found.place });
                }
            };
            for solid in &solids {
                if let Some(found) = solid.depth_of(sheet, DVec3::ZERO) {
                    add(PenetratedObject::Body(solid.body), half + found.distance, half, found);
                }
            }
            let others = if self.scene.contact.sheets { &placed[..index] } else { &[] };
            for (other, with) in others.iter().enumerate() {
                let their_half = half_thickness(with.sheet);
                let touching = half + their_half;
                if let Some(found) = sheet.nearest(DVec3::ZERO, with, touching, |_, _| false) {
                    add(PenetratedObject::Sheet(other), touching - found.distance, half.min(their_half), found);
                }
            }
            if let Some(found) = self.nearest_to_itself(index, sheet) {
                add(PenetratedObject::Itself, 2.0 * half - found.distance, half, found);
            }
        }
        all
    }

    /// Least distance below the thickness of parts of a sheet that are not neighbours at rest.
    fn nearest_to_itself(&self, index: usize, sheet: &PlacedSheet) -> Option<NearestPlace> {
        let surface = self.sheet_contacts.get(index)?.surface.as_ref()?;
        let thickness = 2.0 * half_thickness(sheet.sheet);
        let neighbours = |p: &[u32; 3], q: &[u32; 3]| surface.are_neighbours(p, q, thickness);
        let sheet = PlacedSheet::with_flat_rim(sheet.sheet, surface);
        sheet.nearest(DVec3::ZERO, &sheet, thickness, neighbours)
    }

    /// Report the penetrations that begin in this step.
    pub(super) fn check_penetration(&mut self) {
        let always = self.penetration_check.always;
        if !always && !self.sheets.iter().any(|sheet| sheet.work.is_contact_uncertain) {
            return;
        }
        let found = self.penetrations_of(|sheet| always || sheet.work.is_contact_uncertain);
        self.sheets.iter_mut().for_each(|sheet| sheet.work.is_contact_uncertain = false);
        let mut check = std::mem::take(&mut self.penetration_check);
        for p in &found {
            let sheet = &self.sheets[p.sheet];
            let (body, other) = match p.with {
                PenetratedObject::Body(index) => (self.rigid.as_deref().map(|r| r.bodies()[index].name.clone()), None),
                PenetratedObject::Sheet(index) => (None, Some(self.sheets[index].name.clone())),
                PenetratedObject::Itself => (None, Some(sheet.name.clone())),
            };
            let thicknesses = p.depth / (2.0 * half_thickness(sheet));
            if check.deepest.as_ref().is_none_or(|(most, _)| thicknesses > *most) {
                let with = body.as_ref().or(other.as_ref()).map_or("", String::as_str);
                let status = format!(
                    "penetration: {} in {with} at {:.6} s, {:.3e} m ({thicknesses:.2} thicknesses) at ({:.5}, {:.5}, {:.5}) m",
                    sheet.name, self.time, p.depth, p.place.x, p.place.y, p.place.z
                );
                check.deepest = Some((thicknesses, status));
            }
            if !check.pairs.contains(&pair_of(p)) {
                let event = Event::new(self.time, EventKind::Penetration, &sheet.name, body);
                let (place_m, depth_m) = (Some(p.place.to_array()), Some(p.depth));
                self.events.push(Event { other, place_m, depth_m, ..event });
            }
        }
        check.pairs.clear();
        check.pairs.extend(found.iter().map(pair_of));
        self.penetration_check = check;
    }

    /// Description of the deepest penetration that the check has found.
    pub(super) fn deepest_penetration(&self) -> Option<&str> {
        self.penetration_check.deepest.as_ref().map(|(_, status)| status.as_str())
    }
}

/// Whether the material at `found` is compressed by no more than its half thickness: solids are
/// near from both sides, of the two sheets together where there are two.
fn is_compressed(solids: &[PlacedSolid], found: &NearestPlace, half: f64) -> bool {
    let [own, other] = found.triangles;
    let sides = |triangle| solids.iter().filter_map(move |solid| solid.side_of(triangle, half));
    let met = |side: f64| sides(&own).any(|s| s == side) || sides(&other).any(|s| s == side);
    found.distance != 0.0 && met(1.0) && met(-1.0)
}
