//! Hot bodies: heat exchange between a body with a temperature and a sheet near it.
//!
//! A patch at a gap g (m) from the surface of the body exchanges q = (T_body - T)/(1/h_c + g/k_air)
//! per area, through the contact and the air in the gap, where it faces the surface. Beyond
//! `MAX_GAP` the exchange is neglected: the convection of the room is larger. The temperature of
//! the body is constant or follows its schedule, and rises linearly from the origin of the body
//! along its `temperature_slope` (K/m). Its `hot_spots` replace it in places.

use glam::{DQuat, DVec3};
use rapier3d::math::Real;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::prelude::Collider;

use crate::error::InputError;
use crate::scene::{BodySpec, BodySpotSpec, OvenKey, Scene, body_name};
use crate::serialize::{ReadResult, StateReader, StateWriter};
use crate::sheet::node_contact;
use crate::thermal::source::{HeatSource, HeatedSheet, SourceInputs, SourceKind, oven};
use crate::units::parameters::ParameterId as Id;
use crate::units::temperature::{COLDEST, HOTTEST, REFERENCE};

/// Conductivity of air, W/(m K).
const AIR: f64 = 0.026;
/// Maximum gap, m: the exchange across it is small against the convection of the room.
const MAX_GAP: f64 = 5e-3;

pub(crate) const KIND: SourceKind =
    SourceKind { name: "bodies", about: "hot bodies, through contact and the air in between", build };

fn build(scene: &Scene) -> Result<Vec<Box<dyn HeatSource>>, InputError> {
    let hot = scene.bodies.iter().enumerate().filter(|(_, b)| b.is_hot());
    Ok(hot.map(|(i, b)| of(&body_name(&b.name, i), b, scene.contact_conductance)).collect())
}

/// Hot body `name` of `spec` with contact conductance `conductance` (W/(m² K)).
pub(crate) fn of(name: &str, spec: &BodySpec, conductance: f64) -> Box<dyn HeatSource> {
    let schedule = spec.temperature_schedule.clone();
    // Until the first exchange, a scheduled body shows the temperature at which it starts.
    let first = schedule.first().and_then(|key| key.temperature);
    let celsius = first.or(spec.temperature).unwrap_or(REFERENCE);
    let (slope, spots) = (spec.temperature_slope, spec.hot_spots.clone());
    Box::new(HotBody { name: name.to_owned(), celsius, schedule, slope, spots, conductance })
}

struct HotBody {
    name: String,
    /// Temperature at the last exchange, °C.
    celsius: f64,
    /// Temperatures over time; empty for a constant one.
    schedule: Vec<OvenKey>,
    /// Rise of the temperature along the axes of the body, K/m.
    slope: DVec3,
    /// Places with another temperature.
    spots: Vec<BodySpotSpec>,
    /// Contact conductance, W/(m² K).
    conductance: f64,
}

/// Position of a body, m, and its rotation.
type Pose = (DVec3, DQuat);

impl HotBody {
    /// Temperature at `place` (m) along the axes of the body from its origin, °C. A slope does not
    /// lead out of the range of temperatures.
    fn at(&self, place: DVec3) -> f64 {
        let celsius = self.celsius + self.slope.dot(place);
        let celsius = self.spots.iter().fold(celsius, |celsius, spot| spot.apply(celsius, place));
        celsius.clamp(COLDEST, HOTTEST)
    }

    fn give_from(&self, collider: &Collider, (origin, turn): Pose, offset: f64, target: &mut HeatedSheet) {
        let Some((low, high)) = target.sheet.state.x.bounds() else { return };
        let around = Aabb::new(low.as_vec3(), high.as_vec3()).loosened((MAX_GAP + offset) as Real);
        if !around.intersects(&collider.compute_aabb()) {
            return;
        }
        let (shape, pose) = (collider.shape(), collider.position());
        let back = turn.inverse();
        for i in 0..target.faces.patches.len() {
            let (patch, normal) = (target.faces.patches[i], target.faces.normals[i]);
            let place = target.sheet.state.x.get(patch.mass as usize);
            let found = shape.project_point(pose, place.as_vec3(), false);
            let way = found.point.as_dvec3() - place;
            let gap = if found.is_inside { 0.0 } else { (way.length() - offset).max(0.0) };
            let towards = if found.is_inside { -way } else { way };
            if gap > MAX_GAP || towards.dot(normal) < 0.0 || normal == DVec3::ZERO {
                continue;
            }
            let celsius = self.at(back * (found.point.as_dvec3() - origin));
            target.couple(patch, celsius, patch.area / (1.0 / self.conductance + gap / AIR));
        }
    }
}

impl HeatSource for HotBody {
    fn add_exchange(&mut self, _index: usize, moment: &SourceInputs, target: &mut HeatedSheet) {
        let (Some(view), Some(rigid)) = (moment.view, moment.rigid) else { return };
        let Some((index, pose)) = rigid.index_of(&self.name).and_then(|i| Some((i, rigid.pose(i)?))) else { return };
        if !self.schedule.is_empty() {
            let Some(celsius) = OvenKey::at(&self.schedule, moment.time) else { return };
            self.celsius = celsius;
        }
        let offset = node_contact::contact_offset(target.sheet);
        for handle in rigid.colliders(index) {
            if let Some(collider) = view.colliders.get(*handle) {
                self.give_from(collider, pose, offset, target);
            }
        }
    }

    fn path(&self) -> String {
        format!("bodies.{}", self.name)
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn parameters(&self) -> &'static [Id] {
        &[Id::BodyTemperature]
    }

    fn parameter(&self, _id: Id) -> f64 {
        self.celsius
    }

    fn set_parameter(&mut self, _id: Id, value: f64) {
        // A set temperature replaces the schedule.
        self.schedule.clear();
        self.celsius = value;
    }

    fn serialise_settings(&self, to: &mut StateWriter) {
        to.number(self.celsius);
        to.states(&self.schedule);
    }

    fn deserialise_settings(&mut self, from: &mut StateReader) -> ReadResult {
        self.celsius = from.number()?;
        self.schedule = oven::read_schedule(from)?;
        Ok(())
    }
}
