//! Forces and impulses of a program on a sheet: at a material point, at the point nearest to a
//! place in the world, or on a region.
//!
//! A force acts during the next step, or during the whole of the next [`World::advance`] or
//! [`World::advance_with`], and ends with it; a snapshot contains it. On a point it is distributed
//! to the three nodes around it by barycentric weights, which preserves force and moment. On a
//! region it is distributed in proportion to the node masses, so that it accelerates all nodes
//! alike on every grid.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::collision::geometry::closest_points::point_triangle;
use crate::error::{InputError, check_range};
use crate::scene::{Region, validate};
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter};
use crate::sheet::{Sheet, Vectors, grab, region};
use crate::units::parameters::ParameterId as Id;
use crate::units::settings::settings;
use crate::world::World;
use crate::world::ids::SheetId;

settings! {
    /// Settings of forces of a program.
    pub struct LoadSettings {
        /// Maximum component of an impulse, N s: that of a force in a second.
        pub maximum_impulse: f64 = 1e6,
        /// Maximum coordinate of a place, m.
        pub maximum_coordinate: f64 = 1e6,
        /// Maximum component of the velocity of a body, m/s and rad/s.
        pub maximum_body_speed: f64 = 1e4,
    }
}

const SETTINGS: LoadSettings = LoadSettings::DEFAULT;

/// Part of a sheet on which a force or an impulse acts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum ForceTarget {
    /// Material point (u, v), each 0 to 1, of the bottom layer.
    Point(f64, f64),
    /// Point of the bottom layer nearest to this place, m; each coordinate within ±1e6.
    Nearest(DVec3),
    /// Nodes of a region, in proportion to their masses.
    Region(Region),
}

/// Force of the program on a sheet.
#[derive(Clone, Debug)]
struct Load {
    sheet: SheetId,
    target: ForceTarget,
    /// Total force, N.
    force: DVec3,
    /// Nodes and their fractions of the force, on a grid of `node_count` nodes.
    shares: Vec<(u32, f64)>,
    node_count: usize,
    /// Whether it has acted in a step.
    has_acted: bool,
}

impl Load {
    /// Add `sign` times the acceleration by the load to that which the integrator has stored, so
    /// that the impulse of the load is exact.
    fn shift_acceleration(&self, sheet: &mut Sheet, sign: f64) {
        for (node, share) in self.shares.iter().filter(|_| self.node_count == sheet.inverse_mass.len()) {
            let per_force = sign * share * sheet.inverse_mass[*node as usize];
            sheet.engine.add_acceleration(*node as usize, self.force * per_force);
        }
    }
}

/// Forces of the program during the next step or advance.
#[derive(Default)]
pub(crate) struct Loads {
    list: Vec<Load>,
    /// Constant forces of the sheets with loads, N, during a step.
    constant: Vec<(usize, Vectors)>,
    /// Number of entries of `constant` in use.
    used: usize,
}

impl World {
    /// Apply a force with the sum `force` (N, each component within ±1e6) to `target` of the sheet
    /// `id` during the next step or the whole of the next advance; the sheet wakes. Forces add up.
    ///
    /// # Errors
    /// When there is no such sheet, the target contains no node, or a number is out of range;
    /// nothing changes then.
    pub fn apply_force(&mut self, id: SheetId, target: &ForceTarget, force: DVec3) -> Result<(), InputError> {
        Id::RegionForce.check_each("force", force.to_array())?;
        let index = self.index_of_sheet(id)?;
        let sheet = &mut self.sheets[index];
        let target = material_target(target, sheet)?;
        let shares = shares(&target, sheet)?;
        let node_count = sheet.node_count();
        self.loads.list.push(Load { sheet: id, target, force, shares, node_count, has_acted: false });
        sheet.wake();
        Ok(())
    }

    /// Apply an impulse with the sum `impulse` (N s, each component within ±1e6) to `target` of
    /// the sheet `id` at once; the sheet wakes. Fixed nodes do not move.
    ///
    /// # Errors
    /// As [`World::apply_force`].
    pub fn apply_impulse(&mut self, id: SheetId, target: &ForceTarget, impulse: DVec3) -> Result<(), InputError> {
        for (axis, value) in impulse.to_array().into_iter().enumerate() {
            check_range(&format!("impulse.{axis}"), value, -SETTINGS.maximum_impulse, SETTINGS.maximum_impulse, "N s")?;
        }
        let index = self.index_of_sheet(id)?;
        let sheet = &mut self.sheets[index];
        for (node, share) in shares(&material_target(target, sheet)?, sheet)? {
            sheet.apply_impulse(node as usize, impulse * share)?;
        }
        Ok(())
    }

    /// Add the loads to the constant forces of the sheets for a step.
    pub(crate) fn begin_loads(&mut self) {
        let Self { loads: Loads { list, constant, used }, sheets, sheet_ids, .. } = self;
        *used = 0;
        for load in list {
            let Some(index) = sheet_ids.position(load.sheet.0) else { continue };
            let sheet = &mut sheets[index];
            if load.node_count != sheet.node_count() {
                load.shares = shares(&load.target, sheet).unwrap_or_default();
                load.node_count = sheet.node_count();
            }
            if !std::mem::replace(&mut load.has_acted, true) {
                load.shift_acceleration(sheet, 1.0);
            }
            if !constant[..*used].iter().any(|(at, _)| *at == index) {
                if *used == constant.len() {
                    constant.push((index, Vectors::default()));
                }
                constant[*used].0 = index;
                constant[*used].1.clone_from(&sheet.parameters.applied);
                *used += 1;
            }
            for (node, share) in &load.shares {
                sheet.parameters.applied.add(*node as usize, load.force * *share);
            }
        }
    }

    /// Restore the constant forces after a step.
    pub(crate) fn finish_loads(&mut self) {
        for (index, constant) in &self.loads.constant[..std::mem::take(&mut self.loads.used)] {
            self.sheets[*index].parameters.applied.copy_from(constant);
        }
    }

    /// Remove the loads at the end of a step or an advance.
    pub(crate) fn clear_loads(&mut self) {
        if let Some(rigid) = self.rigid.as_mut().filter(|rigid| rigid.has_loads()) {
            rigid.clear_loads();
        }
        let Self { loads: Loads { list, .. }, sheets, sheet_ids, .. } = self;
        for load in list.drain(..).filter(|load| load.has_acted) {
            if let Some(sheet) = sheet_ids.position(load.sheet.0).and_then(|index| sheets.get_mut(index)) {
                load.shift_acceleration(sheet, -1.0);
            }
        }
    }

    /// Serialise the loads.
    pub(crate) fn serialise_loads(&self, to: &mut StateWriter) {
        let of = |load: &Load| Some((self.sheet_ids.position(load.sheet.0)?, load.target.clone(), load.force));
        let list: Vec<(usize, ForceTarget, DVec3)> = self.loads.list.iter().filter_map(of).collect();
        to.blob(&postcard::to_extend(&list, Vec::new()).unwrap_or_default());
    }

    /// Deserialise the output of [`World::serialise_loads`].
    pub(crate) fn deserialise_loads(&mut self, from: &mut StateReader) -> ReadResult {
        let list: Vec<(usize, ForceTarget, DVec3)> = postcard::from_bytes(from.blob()?).map_err(|_| CorruptState)?;
        let mut loads = Vec::with_capacity(list.len());
        for (index, target, force) in list {
            let (sheet, slot) = self.sheets.get(index).zip(self.sheet_ids.at(index)).ok_or(CorruptState)?;
            let shares = shares(&target, sheet).map_err(|_| CorruptState)?;
            if !force.is_finite() {
                return Err(CorruptState);
            }
            let node_count = sheet.node_count();
            loads.push(Load { sheet: SheetId(slot), target, force, shares, node_count, has_acted: false });
        }
        self.loads.list = loads;
        Ok(())
    }
}

/// The target in material coordinates, which stay with the sheet when it moves.
fn material_target(target: &ForceTarget, sheet: &Sheet) -> Result<ForceTarget, InputError> {
    match target {
        ForceTarget::Nearest(place) => {
            for (axis, value) in place.to_array().into_iter().enumerate() {
                check_range(
                    &format!("place.{axis}"),
                    value,
                    -SETTINGS.maximum_coordinate,
                    SETTINGS.maximum_coordinate,
                    "m",
                )?;
            }
            let (u, v) = nearest_point(sheet, *place);
            Ok(ForceTarget::Point(u, v))
        }
        other => Ok(other.clone()),
    }
}

/// Nodes of a target and their fractions, which sum to 1.
fn shares(target: &ForceTarget, sheet: &Sheet) -> Result<Vec<(u32, f64)>, InputError> {
    match target {
        ForceTarget::Nearest(place) => {
            let (u, v) = nearest_point(sheet, *place);
            shares(&ForceTarget::Point(u, v), sheet)
        }
        ForceTarget::Point(u, v) => {
            check_range("u", *u, 0.0, 1.0, "")?;
            check_range("v", *v, 0.0, 1.0, "")?;
            let (nodes, weights) = grab::material_point(sheet, (*u, *v)).terms();
            Ok(nodes.into_iter().zip(weights).collect())
        }
        ForceTarget::Region(part) => {
            validate::region(part).map_err(|e| e.within("region"))?;
            let mut nodes = region::select(part, sheet).map_err(|e| e.within("region"))?;
            nodes.sort_unstable();
            nodes.dedup();
            let mass = |node: u32| sheet.model.mass[node as usize];
            let total: f64 = nodes.iter().map(|node| mass(*node)).sum();
            Ok(nodes.into_iter().map(|node| (node, mass(node) / total)).collect())
        }
    }
}

/// Material coordinates of the point of the bottom layer nearest to `place` (m).
fn nearest_point(sheet: &Sheet, place: DVec3) -> (f64, f64) {
    let mut best = (f64::INFINITY, (0.5, 0.5));
    for triangle in grab::bottom_triangles(sheet).iter() {
        let corners = triangle.map(|node| sheet.state.x.get(node as usize));
        let weights = point_triangle(place, corners);
        let point: DVec3 = corners.iter().zip(weights).map(|(corner, weight)| *corner * weight).sum();
        let distance = point.distance_squared(place);
        if distance < best.0 {
            let uv = triangle.map(|node| sheet.model.uv[node as usize]);
            let each = |of: fn(&(f64, f64)) -> f64| uv.iter().zip(weights).map(|(at, weight)| of(at) * weight).sum();
            let (u, v): (f64, f64) = (each(|at| at.0), each(|at| at.1));
            best = (distance, (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0)));
        }
    }
    best.1
}
