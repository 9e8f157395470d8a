//! What a group of sheets may touch (for the time being: masses against half spaces that stand still).

use glam::{DMat3, DVec3};
use rapier3d::parry::shape::TypedShape;

use super::group::Find;
use crate::contact::Group;
use crate::contact::mover::Mover;
use crate::contact::rigid::RigidView;
use crate::contact::row::{Contact, Side};
use crate::contact::stage::mass_point;
use crate::contact::target::Frame;

pub(crate) struct Near<'a> {
    pub view: &'a RigidView<'a>,
    pub normals: Vec<(DVec3, f64, f64)>,
}

impl Find for Near<'_> {
    fn begin_stage(&mut self, group: &mut Group, _from: f64, _to: f64) {
        group.movers.clear();
        self.normals.clear();
        for (_, collider) in self.view.colliders.iter() {
            if let TypedShape::HalfSpace(plane) = collider.shape().as_typed_shape() {
                let frame = Frame::of(collider.position());
                self.normals.push((
                    frame.rotation * plane.normal.as_dvec3(),
                    f64::from(collider.friction()),
                    f64::from(collider.restitution()),
                ));
                group.movers.push(Mover {
                    start: frame,
                    free: frame,
                    centre: [frame.origin; 2],
                    linear: [DVec3::ZERO; 2],
                    angular: [DVec3::ZERO; 2],
                    inverse_mass: 0.0,
                    inverse_inertia: DMat3::ZERO,
                    shift: DVec3::ZERO,
                    turn: DVec3::ZERO,
                    kick: DVec3::ZERO,
                    twist: DVec3::ZERO,
                });
            }
        }
    }

    fn find(&mut self, group: &Group, _round: u32, contacts: &mut Vec<Contact>) {
        contacts.clear();
        for (b, (normal, friction, restitution)) in self.normals.iter().enumerate() {
            for (s, _) in group.members.iter().enumerate() {
                let sheet = group.sheet(s as u32);
                for (i, x) in sheet.work.stage.free.iter().enumerate() {
                    let frame = &group.movers[b].free;
                    let height = (x - frame.origin).dot(*normal);
                    if height < 0.01 {
                        contacts.push(Contact {
                            a: mass_point(s as u32, i as u32),
                            b: Side::Body { body: b as u32, local: frame.into_local(x - *normal * height) },
                            normal: *normal,
                            offset: crate::contact::SKIN,
                            key: [b as u64, i as u64],
                            friction: 0.5 * (sheet.friction + friction),
                            restitution: 0.5 * (sheet.restitution + restitution),
                        });
                    }
                }
            }
        }
    }

    fn end_stage(&mut self, _group: &mut Group) {}
}
