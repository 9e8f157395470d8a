//! Hot bodies: heat exchange between a body with a temperature and a sheet near it.
//!
//! A patch at a gap g (m) from the surface of the body exchanges q = (T_body - T)/(1/h_c + g/k_air)
//! per area, through the contact and the air in the gap, where it faces the surface. Beyond `FAR`
//! the exchange is neglected: the convection of the room is larger. The temperature of the body is
//! constant.

use glam::DVec3;
use rapier3d::math::Real;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::prelude::Collider;

use crate::error::InputError;
use crate::scene::{Scene, body_name};
use crate::serialize::{Keeper, Taken, Taker};
use crate::thermal::source::{Dial, Kind, Moment, Source, Target};
use crate::units::temperature::{COLDEST, HOTTEST};

/// Conductivity of air, W/(m K).
const AIR: f64 = 0.026;
/// Maximum gap, m: the exchange across it is small against the convection of the room.
const FAR: f64 = 5e-3;

pub(crate) const KIND: Kind =
    Kind { name: "bodies", about: "hot bodies, through contact and the air in between", build };

fn build(scene: &Scene) -> Result<Vec<Box<dyn Source>>, InputError> {
    let hot = scene.bodies.iter().enumerate().filter_map(|(i, b)| Some((body_name(&b.name, i), b.temperature?)));
    Ok(hot.map(|(name, celsius)| of(&name, celsius, scene.contact_conductance)).collect())
}

/// Body `name` at `celsius` (°C) with contact conductance `conductance` (W/(m² K)).
pub(crate) fn of(name: &str, celsius: f64, conductance: f64) -> Box<dyn Source> {
    Box::new(HotBody { name: name.to_owned(), celsius, conductance })
}

/// Parameter path of the temperature of the body `name`.
pub(crate) fn path_of(name: &str) -> String {
    format!("bodies.{name}.temperature")
}

struct HotBody {
    name: String,
    celsius: f64,
    /// Contact conductance, W/(m² K).
    conductance: f64,
}

impl HotBody {
    fn give_from(&self, collider: &Collider, offset: f64, target: &mut Target) {
        let Some((low, high)) = target.sheet.x.bounds() else { return };
        let around = Aabb::new(low.as_vec3(), high.as_vec3()).loosened((FAR + offset) as Real);
        if !around.intersects(&collider.compute_aabb()) {
            return;
        }
        let (shape, pose) = (collider.shape(), collider.position());
        for i in 0..target.faces.patches.len() {
            let (patch, normal) = (target.faces.patches[i], target.faces.normals[i]);
            let place = target.sheet.x.get(patch.mass as usize);
            let found = shape.project_point(pose, place.as_vec3(), false);
            let way = found.point.as_dvec3() - place;
            let gap = if found.is_inside { 0.0 } else { (way.length() - offset).max(0.0) };
            let towards = if found.is_inside { -way } else { way };
            if gap > FAR || towards.dot(normal) < 0.0 || normal == DVec3::ZERO {
                continue;
            }
            target.couple(patch, self.celsius, patch.area / (1.0 / self.conductance + gap / AIR));
        }
    }
}

impl Source for HotBody {
    fn give(&mut self, _index: usize, moment: &Moment, target: &mut Target) {
        let (Some(view), Some(rigid)) = (moment.view, moment.rigid) else { return };
        let Some(index) = rigid.index_of(&self.name) else { return };
        let offset = target.sheet.contact_offset();
        for handle in rigid.colliders(index) {
            if let Some(collider) = view.colliders.get(*handle) {
                self.give_from(collider, offset, target);
            }
        }
    }

    fn path(&self) -> String {
        format!("bodies.{}", self.name)
    }

    fn dials(&self) -> Vec<Dial> {
        vec![Dial { path: path_of(&self.name), value: self.celsius, unit: "°C", range: (COLDEST, HOTTEST) }]
    }

    fn keep_settings(&self, to: &mut Keeper) {
        to.number(self.celsius);
    }

    fn take_settings(&mut self, from: &mut Taker) -> Taken {
        self.celsius = from.number()?;
        Ok(())
    }

    fn turn(&mut self, path: &str, value: f64) -> bool {
        let own = path == path_of(&self.name);
        if own {
            self.celsius = value;
        }
        own
    }
}
