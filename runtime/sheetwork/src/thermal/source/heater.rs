//! Heaters: polyhedra with hot faces that radiate to both sides of a sheet.
//!
//! A patch with emissivity (and absorptivity) ε absorbs, from a hot face at T_h with emissivity ε_h
//! and view factor F,
//!
//!   q = ε σ F V ε_h (T_h⁴ - T_wall⁴) per area,
//!
//! where V is the unobstructed fraction of the face. The walls' radiation that the face hides or
//! reflects is counted with the room. F is exact ([`crate::thermal::view_factor`]); a face radiates
//! from its outer side only. V is computed by rays to `RAYS_PER_CORNER` points of the face,
//! weighted by their view; bodies and the sheet itself block rays.
//!
//! F is updated for a patch that has moved by `VIEW_TOLERANCE` of its distance or turned by
//! `VIEW_TOLERANCE` (rad), with one patch in `VIEW_UPDATE_STEPS` tested per step. V is updated for
//! one patch in `SHADOW_UPDATE_STEPS` per step, self-shadowing as often. Pairs that face away are
//! skipped.

use std::path::Path;

use glam::DVec3;
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::query::Ray;

use crate::error::InputError;
use crate::rigid::RigidView;
use crate::scene::heater_file::Heater;
use crate::scene::{HeaterSpec, Placement, Scene};
use crate::serialize::{CorruptState, ReadResult, State, StateReader, StateWriter};
use crate::sheet::{Sheet, temperature};
use crate::thermal::shadow::SelfShadow;
use crate::thermal::source::{HeatSource, HeatedSheet, HotPlane, SourceInputs, SourceKind, fourth_power};
use crate::thermal::view_factor::contour;
use crate::units::parameters::ParameterId as Id;
use crate::units::temperature::COLDEST;

/// Motion of a patch that requires a new view factor: as a fraction of its distance from the middle
/// of the nearest hot face, and as a rotation, rad. The view factor is then wrong by some
/// thousandths.
const VIEW_TOLERANCE: f64 = 1e-3;
/// Number of steps in which all moving patches are tested, so that view factors lag by at most a
/// twentieth of a second.
const VIEW_UPDATE_STEPS: usize = 3;
/// Number of steps in which the shadows of all patches are updated.
const SHADOW_UPDATE_STEPS: usize = 24;
/// Number of ray targets per corner of a face.
const RAYS_PER_CORNER: usize = 4;
/// Distance of a ray's start from its patch, as a fraction of its length.
const START: f64 = 1e-4;

pub(crate) const KIND: SourceKind =
    SourceKind { name: "heaters", about: "polyhedra with hot faces, by exact view factors, with shadows", build };

fn build(scene: &Scene) -> Result<Vec<Box<dyn HeatSource>>, InputError> {
    let each = |(index, spec): (usize, &HeaterSpec)| {
        let made = of(&name_of(spec, index), spec, &scene.base);
        made.map_err(|e| if e.file.is_none() { e.within(&format!("heaters.{index}")) } else { e })
    };
    scene.heaters.iter().enumerate().map(each).collect()
}

/// Heater of `spec`, its file in the folder `base`.
///
/// # Errors
/// When its file is invalid.
pub(crate) fn of(name: &str, spec: &HeaterSpec, base: &Path) -> Result<Box<dyn HeatSource>, InputError> {
    Ok(Box::new(HeaterSource::new(name.to_owned(), spec, &spec.resolve(base)?)))
}

/// Name of the heater `index` of a scene: its number where it has none.
pub(crate) fn name_of(spec: &HeaterSpec, index: usize) -> String {
    if spec.name.is_empty() { index.to_string() } else { spec.name.clone() }
}

/// Parameter path of the heater `name`.
pub(crate) fn path_of(name: &str) -> String {
    format!("heaters.{name}")
}

/// Hot face in world coordinates.
#[derive(Clone, Debug)]
struct HotFace {
    corners: Vec<DVec3>,
    normal: DVec3,
    middle: DVec3,
    /// Ray targets, with the area of each.
    points: Vec<(DVec3, f64)>,
    celsius: f64,
    emissivity: f64,
}

impl HotFace {
    fn new(corners: Vec<DVec3>, celsius: f64, emissivity: f64) -> Self {
        let middle = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
        let mut area = DVec3::ZERO;
        let mut points = Vec::with_capacity(RAYS_PER_CORNER * corners.len());
        for (i, a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let part = (*a - middle).cross(b - middle) * 0.5;
            area += part;
            // The four quarters of the triangle.
            let thirds = [(4.0, 1.0, 1.0), (1.0, 4.0, 1.0), (1.0, 1.0, 4.0), (2.0, 2.0, 2.0)];
            points.extend(thirds.map(|(u, v, w)| ((middle * u + *a * v + b * w) / 6.0, part.length() / 4.0)));
        }
        Self { normal: area.normalize_or_zero(), corners, middle, points, celsius, emissivity }
    }

    /// View factor F from a patch; 0 behind the face.
    fn view_factor(&self, place: DVec3, normal: DVec3) -> f64 {
        if self.normal.dot(place - self.middle) <= 0.0 {
            return 0.0;
        }
        contour(&self.corners, place, normal).abs().min(1.0)
    }

    /// Unobstructed fraction V from a patch.
    fn visible(&self, place: DVec3, normal: DVec3, blocked: impl Fn(DVec3, DVec3) -> bool) -> f64 {
        let (mut seen, mut all) = (0.0, 0.0);
        for (point, area) in &self.points {
            let way = *point - place;
            let (here, there) = (way.dot(normal), -way.dot(self.normal));
            if here <= 0.0 || there <= 0.0 {
                continue;
            }
            let weight = area * here * there / way.length_squared().powi(2);
            all += weight;
            if !blocked(place, *point) {
                seen += weight;
            }
        }
        if all > 0.0 { seen / all } else { 1.0 }
    }
}

/// View data of a sheet's patches.
#[derive(Default)]
struct PatchViews {
    /// Position and normal of the view factors, NaN before the first, and the squared distance of
    /// the middle of the nearest face, m².
    at: Vec<(DVec3, DVec3, f64)>,
    /// F and V of every patch, face by face.
    factors: Vec<(f64, f64)>,
    /// First patch of the next shadow update, and whether all patches have been updated once.
    next: usize,
    /// Step counter modulo `VIEW_UPDATE_STEPS`.
    glance: usize,
    complete: bool,
    own: Option<SelfShadow>,
}

impl PatchViews {
    fn serialise(&self, to: &mut StateWriter) {
        to.states(&self.at);
        self.factors.serialise(to);
        to.count(self.next as u64);
        to.count(self.glance as u64);
        to.flag(self.complete);
        to.option(self.own.as_ref(), SelfShadow::serialise);
    }

    /// Deserialise the data of `sheet` for `faces` hot faces.
    fn deserialise(&mut self, from: &mut StateReader, sheet: &Sheet, faces: usize) -> ReadResult {
        self.at = from.states(56)?;
        let patches = self.at.len();
        self.factors.resize(patches * faces, (0.0, 1.0));
        self.factors.deserialise(from)?;
        (self.next, self.glance) = (from.index(patches.max(1))? as usize, from.index(VIEW_UPDATE_STEPS)? as usize);
        self.complete = from.flag()?;
        if !from.flag()? {
            self.own = None;
            return Ok(());
        }
        let body = temperature::faces(sheet).ok_or(CorruptState)?;
        if self.own.as_ref().is_none_or(|own| !own.is_of(body)) {
            self.own = Some(SelfShadow::new(sheet, body));
        }
        self.own.as_mut().map_or(Ok(()), |own| own.deserialise(from))
    }
}

struct HeaterSource {
    name: String,
    on: bool,
    faces: Vec<HotFace>,
    /// Corners of the faces in the heater's axes, m.
    own: Vec<Vec<DVec3>>,
    /// View data of each sheet.
    seen: Vec<PatchViews>,
}

impl HeaterSource {
    fn new(name: String, spec: &HeaterSpec, heaters: &[Heater]) -> Self {
        let (mut faces, mut own) = (Vec::new(), Vec::new());
        for heater in heaters {
            for (index, face) in heater.faces.iter().enumerate() {
                let Some(celsius) = face.temperature.filter(|_| face.emissivity > 0.0) else { continue };
                let corners = heater.polyhedron.corners(index);
                let there = corners.iter().map(|p| spec.placement.apply(*p)).collect();
                faces.push(HotFace::new(there, celsius, face.emissivity));
                own.push(corners);
            }
        }
        Self { name, on: spec.on, faces, own, seen: Vec::new() }
    }

    /// Update view factors and some shadows of a sheet.
    fn update_views(&mut self, index: usize, moment: &SourceInputs, target: &HeatedSheet) {
        if self.seen.len() <= index {
            self.seen.resize_with(index + 1, PatchViews::default);
        }
        let (faces, seen) = (&self.faces, &mut self.seen[index]);
        let patches = &target.faces.patches;
        if seen.at.len() != patches.len() {
            seen.at = vec![(DVec3::NAN, DVec3::NAN, f64::NAN); patches.len()];
            seen.factors = vec![(0.0, 1.0); patches.len() * faces.len()];
        }
        let turn = if seen.complete { patches.len().div_ceil(SHADOW_UPDATE_STEPS) } else { patches.len() };
        let shadows = seen.next..seen.next + turn;
        let own = seen.own.get_or_insert_with(|| SelfShadow::new(target.sheet, target.faces));
        if !seen.complete || shadows.start < turn {
            own.refresh(target.sheet, target.faces);
        }
        seen.glance = (seen.glance + 1) % VIEW_UPDATE_STEPS;
        for (i, patch) in patches.iter().enumerate() {
            let shaded = shadows.contains(&i) || shadows.contains(&(i + patches.len()));
            if seen.complete && !shaded && i % VIEW_UPDATE_STEPS != seen.glance {
                continue;
            }
            let (place, normal) = (target.sheet.state.x.get(patch.mass as usize), target.faces.normals[i]);
            let (was, faced, reach) = seen.at[i];
            let moved = was.distance_squared(place) + faced.distance_squared(normal) * reach;
            let factors = &mut seen.factors[i * faces.len()..(i + 1) * faces.len()];
            // NaN marks a patch without view factors.
            if moved.is_nan() || moved > VIEW_TOLERANCE * VIEW_TOLERANCE * reach {
                let reach = faces.iter().map(|f| f.middle.distance_squared(place)).fold(f64::INFINITY, f64::min);
                seen.at[i] = (place, normal, reach);
                factors.iter_mut().zip(faces).for_each(|(f, face)| f.0 = face.view_factor(place, normal));
            }
            if shaded {
                for (factors, face) in factors.iter_mut().zip(faces).filter(|(f, _)| f.0 > 0.0) {
                    factors.1 = face.visible(place, normal, |from, to| {
                        is_blocked(moment.view, from, to) || own.stops(target.sheet, patch.mass, from, to)
                    });
                }
            }
        }
        seen.next = shadows.end % patches.len().max(1);
        seen.complete = true;
    }
}

/// Whether a body blocks the line from `from` to `to`.
fn is_blocked(view: Option<&RigidView>, from: DVec3, to: DVec3) -> bool {
    let Some(view) = view.filter(|view| !view.colliders.is_empty()) else { return false };
    let start = from + (to - from) * START;
    let ray = Ray::new(start.as_vec3(), (to - start).as_vec3());
    let around = Aabb::new(start.min(to).as_vec3(), start.max(to).as_vec3());
    let query = view.query();
    let mut near = query.intersect_aabb_conservative(around);
    near.any(|(_, collider)| collider.shape().intersects_ray(collider.position(), &ray, 1.0))
}

impl HeatSource for HeaterSource {
    fn is_active(&self) -> bool {
        self.on && !self.faces.is_empty()
    }

    fn add_exchange(&mut self, index: usize, moment: &SourceInputs, target: &mut HeatedSheet) {
        if !self.is_active() {
            return;
        }
        self.update_views(index, moment, target);
        let walls = fourth_power(moment.room.celsius);
        let count = self.faces.len();
        for i in 0..target.faces.patches.len() {
            let patch = target.faces.patches[i];
            let factors = &self.seen[index].factors[i * count..(i + 1) * count];
            for ((factor, visible), face) in factors.iter().zip(&self.faces).filter(|(f, _)| f.0 > 0.0) {
                let above = face.emissivity * (fourth_power(face.celsius) - walls);
                target.irradiate(patch, factor * visible, above);
            }
        }
    }

    fn add_hot_faces(&self, faces: &mut Vec<HotPlane>) {
        faces.extend(self.faces.iter().filter(|_| self.on).map(|face| HotPlane {
            centre: face.middle,
            normal: face.normal,
            area: face.points.iter().map(|(_, area)| area).sum(),
            celsius: face.celsius,
            emissivity: face.emissivity,
        }));
    }

    fn path(&self) -> String {
        path_of(&self.name)
    }

    fn place(&mut self, placement: &Placement) -> bool {
        for (face, own) in self.faces.iter_mut().zip(&self.own) {
            let there = own.iter().map(|p| placement.apply(*p)).collect();
            *face = HotFace::new(there, face.celsius, face.emissivity);
        }
        self.discard_views();
        true
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn parameters(&self) -> &'static [Id] {
        &[Id::HeaterOn, Id::HeaterTemperature]
    }

    fn parameter(&self, id: Id) -> f64 {
        match id {
            Id::HeaterOn => f64::from(u8::from(self.on)),
            _ => self.faces.iter().map(|f| f.celsius).fold(COLDEST, f64::max),
        }
    }

    fn set_parameter(&mut self, id: Id, value: f64) {
        match id {
            Id::HeaterOn => self.on = value >= 0.5,
            _ => self.faces.iter_mut().for_each(|f| f.celsius = value),
        }
    }

    fn serialise_settings(&self, to: &mut StateWriter) {
        to.flag(self.on);
        for face in &self.faces {
            face.celsius.serialise(to);
            face.corners.serialise(to);
        }
    }

    fn deserialise_settings(&mut self, from: &mut StateReader) -> ReadResult {
        self.on = from.flag()?;
        for face in &mut self.faces {
            face.celsius.deserialise(from)?;
            let mut corners = face.corners.clone();
            corners.deserialise(from)?;
            if corners != face.corners {
                *face = HotFace::new(corners, face.celsius, face.emissivity);
            }
        }
        Ok(())
    }

    fn serialise(&self, to: &mut StateWriter) {
        to.count(self.seen.len() as u64);
        self.seen.iter().for_each(|seen| seen.serialise(to));
    }

    fn deserialise(&mut self, from: &mut StateReader, sheets: &[Sheet]) -> ReadResult {
        let count = from.length(1)?;
        if count > sheets.len() {
            return Err(CorruptState);
        }
        self.seen.resize_with(count, PatchViews::default);
        let faces = self.faces.len();
        self.seen.iter_mut().zip(sheets).try_for_each(|(seen, sheet)| seen.deserialise(from, sheet, faces))
    }

    fn discard_views(&mut self) {
        self.seen.clear();
    }
}
