//! Contact of the nodes of an explicit integrator with kinematic and static bodies. All other
//! contacts of explicit integrators go through `contact::outer_iteration::solve_explicit`.
//!
//! Rapier's broad phase returns the colliders near the swept box of the sheet. Nodes that may have
//! reached one (see `clearance`) are tested in its frame (`target`), and `response` computes their
//! motion. Impacts are then shared between layers (`through_thickness`), and nodes in contact with
//! two bodies are moved out of both.

use std::f64::consts::TAU;

use glam::DVec3;
use rapier3d::math::Real;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::shape::{Shape, TypedShape};
use rapier3d::prelude::{ColliderHandle, RigidBody, Vector};

use crate::contact::node::bonding;
use crate::contact::node::clearance::{Clearance, FirstHit, RemainingPath};
use crate::contact::node::flexion;
use crate::contact::node::response::{NodeContactSurface, NodePath, respond_to_surface, time_of_impact};
use crate::contact::node::target::{NO_FACE, PathHit, StepTarget};
use crate::contact::node::through_thickness::propagate_impacts;
use crate::contact::settings::{ContactSettings, NodeContactSettings};
use crate::math::RigidFrame;
use crate::rigid::RigidView;
use crate::scene::ContactSurface;
use crate::sheet::layer_stack::LayerImpact;
use crate::sheet::{Sheet, node_contact};

const SETTINGS: NodeContactSettings = ContactSettings::DEFAULT.node;

/// Resolve the contact of `sheet` after its integrator moved it for `dt` (s) from `work.x_before`
/// and `work.v_before`.
///
/// `remaining` (s) is the time from the end of this substep to that of the bodies' poses. `touched`
/// is called for every node that touches a collider.
pub(crate) fn resolve_node_contact(
    sheet: &mut Sheet,
    clearance: &mut Clearance,
    view: &RigidView,
    (dt, remaining): (f64, f64),
    touched: &mut dyn FnMut(ColliderHandle),
) {
    bonding::begin(sheet);
    let reach = reach_of_moving(view, dt + remaining);
    let offset = node_contact::contact_offset(sheet);
    let margin = (SETTINGS.search_margin * sheet.model.initial_diagonal).max(2.0 * offset);
    // A sheet may have been displaced between steps, and a caller may move its own bodies without
    // setting their velocity.
    if std::mem::take(&mut sheet.state.displaced) || !view.is_world_owned {
        clearance.clear();
    }
    let inverse_mass = &sheet.inverse_mass;
    let tested = offset + bonding::tolerance(sheet);
    if !clearance.begin(&sheet.state.x, |i| inverse_mass[i] > 0.0, reach, margin, tested) {
        bonding::release_unmet(sheet);
        flexion::hold_limit(sheet, clearance, Some(view), (dt, remaining), touched);
        return;
    }
    let Some((low, high)) = swept_bounds(sheet) else { return bonding::release_unmet(sheet) };
    let around = Aabb::new(low.as_vec3(), high.as_vec3()).loosened((reach + margin) as Real);
    for (handle, collider) in view.query_fixed().intersect_aabb_conservative(around) {
        let target = StepTarget::new(handle, collider, view, sheet, dt, remaining);
        test_nodes(sheet, clearance, &target, dt, margin);
    }
    let mut struck = respond_all(sheet, clearance, dt, touched);
    if !clearance.remaining_paths.is_empty() {
        struck |= test_remaining_paths(sheet, clearance, view, (dt, remaining), touched);
    }
    if struck {
        if sheet.stack.is_layered() {
            propagate_impacts(sheet, dt);
        }
        sheet.work.layer_impacts.fill(LayerImpact::default());
    }
    bonding::release_unmet(sheet);
    if !clearance.between_bodies.is_empty() {
        separate_from_two_bodies(sheet, clearance, view, around, (dt, remaining));
    }
    flexion::hold_limit(sheet, clearance, Some(view), (dt, remaining), touched);
    bonding::finish(sheet, clearance, dt);
    clearance.end(&sheet.state.x);
}

/// Upper bound of the displacement of any point of a kinematic body in `time` (s), m: speed, plus
/// angular speed times radius.
pub(crate) fn reach_of_moving(view: &RigidView, time: f64) -> f64 {
    let moving = view.bodies.iter().filter(|(_, b)| !b.is_fixed() && !view.is_dynamic(b));
    let reach = moving.map(|(_, body)| {
        let turn = f64::from(body.angvel().length());
        let radius = if turn > 0.0 { radius_of(body, view) } else { 0.0 };
        (f64::from(body.linvel().length()) + turn * radius) * time
    });
    reach.fold(0.0, f64::max)
}

/// Distance from the centre of mass of a body to the furthest point of its colliders' bounding
/// spheres, m.
fn radius_of(body: &RigidBody, view: &RigidView) -> f64 {
    let centre = body.center_of_mass();
    let colliders = body.colliders().iter().filter_map(|c| view.colliders.get(*c));
    let radii = colliders.map(|collider| {
        let sphere = collider.shape().compute_bounding_sphere(collider.position());
        f64::from(sphere.center.distance(centre) + sphere.radius)
    });
    radii.fold(0.0, f64::max).min(SETTINGS.maximum_body_radius)
}

/// Corners of the bounding box that the sheet swept in the step, m.
fn swept_bounds(sheet: &Sheet) -> Option<(DVec3, DVec3)> {
    let (a, b) = sheet.work.x_before.bounds()?;
    let (c, d) = sheet.state.x.bounds()?;
    Some((a.min(c), b.max(d)))
}

/// Test all nodes that need it against one collider, and keep the first hit of each.
fn test_nodes(sheet: &Sheet, clearance: &mut Clearance, target: &StepTarget, dt: f64, margin: f64) {
    let offset = node_contact::contact_offset(sheet);
    for i in 0..sheet.state.x.len() {
        if clearance.nearest[i] < 0.0 {
            continue;
        }
        let flight = path_of_node(sheet, i, dt);
        let reach = if clearance.is_new(i) { Real::MAX } else { margin as Real };
        let (near, mut face) = clearance.nearest_face[i];
        if near != target.handle {
            face = NO_FACE;
        }
        let (a, b) = (target.start.local_point(flight.x0).as_vec3(), target.end.local_point(flight.x1).as_vec3());
        match target.test_path(a, b, reach, &mut face) {
            PathHit::Clear(distance) => clearance.nearest[i] = clearance.nearest[i].min(distance.into()),
            PathHit::Surface(surface) => {
                let tau = time_of_impact(&flight, &surface, offset);
                let before = &mut clearance.first_hit[i];
                let earlier = before.is_none_or(|b| tau < b.tau);
                if before.is_none() {
                    clearance.hits.push(i as u32);
                }
                let another = before.is_some();
                if earlier {
                    *before = Some(FirstHit { collider: target.handle, face, surface, tau, another });
                } else if let Some(before) = before {
                    before.another = true;
                }
            }
        }
    }
}

/// Path of node `i` in a step of `dt` (s) as the integrator moved it.
fn path_of_node(sheet: &Sheet, i: usize, dt: f64) -> NodePath {
    let work = &sheet.work;
    let drift = sheet.engine_kind.info().drift;
    NodePath {
        x0: work.x_before.get(i),
        v0: work.v_before.get(i),
        x1: sheet.state.x.get(i),
        v1: sheet.state.v.get(i),
        dt,
        drift,
    }
}

/// Apply the response of every node at its first hit. Returns whether any was an impact.
fn respond_all(sheet: &mut Sheet, clearance: &mut Clearance, dt: f64, touched: &mut dyn FnMut(ColliderHandle)) -> bool {
    let mut struck = false;
    for k in 0..clearance.hits.len() {
        let i = clearance.hits[k] as usize;
        let Some(first) = clearance.first_hit[i].take() else { continue };
        let flight = path_of_node(sheet, i, dt);
        clearance.nearest_face[i] = (first.collider, first.face);
        struck |= respond((&mut *sheet, &mut *clearance), i, &flight, &first.surface, first.collider, first.another);
        touched(first.collider);
    }
    struck
}

/// Apply the response of node `i` at `surface`. The remaining path is stored for another test if it
/// is long or `another` collider was hit. Returns whether this was an impact.
fn respond(
    (sheet, clearance): (&mut Sheet, &mut Clearance),
    i: usize,
    flight: &NodePath,
    surface: &NodeContactSurface,
    from: ColliderHandle,
    another: bool,
) -> bool {
    let out = respond_to_surface(flight, surface, node_contact::contact_offset(sheet));
    flexion::record(sheet, i, surface, &out);
    bonding::record(sheet, i, flight, surface, &out);
    if sheet.model.contact_surface != ContactSurface::Masses {
        clearance.node_surfaces.push((i as u32, *surface));
    }
    sheet.state.x.set(i, out.x);
    sheet.state.v.set(i, out.v);
    sheet.state.counters.contacts += 1;
    clearance.nearest[i] = 0.0;
    if sheet.state.touching[i] {
        clearance.between_bodies.push(i as u32);
    }
    sheet.state.touching[i] = true;
    let least = SETTINGS.minimum_remaining_path;
    if out.remaining_time > 0.0 && (another || out.x.distance_squared(out.position_at_contact) > least * least) {
        let (x0, v0, x1, v1) = (out.position_at_contact, out.velocity_after_contact, out.x, out.v);
        let flight = NodePath { x0, v0, x1, v1, dt: out.remaining_time, drift: flight.drift };
        clearance.remaining_paths.push(RemainingPath { node: i as u32, from, normal: surface.normal, flight });
    }
    if out.impact > 0.0 {
        sheet.work.layer_impacts[i] = LayerImpact {
            share: 1.0,
            normal: surface.normal,
            body: surface.velocity,
            restitution: surface.restitution,
            friction: surface.friction,
            rest: out.remaining_time,
        };
    }
    out.impact > 0.0
}

/// Test the remaining paths of nodes after their contact: a node that slips along one wall of a
/// corner must not pass through the other. Returns whether any hit was an impact.
fn test_remaining_paths(
    sheet: &mut Sheet,
    clearance: &mut Clearance,
    view: &RigidView,
    (dt, remaining): (f64, f64),
    touched: &mut dyn FnMut(ColliderHandle),
) -> bool {
    let mut struck = false;
    for _ in 0..SETTINGS.maximum_corner_iterations {
        std::mem::swap(&mut clearance.remaining_paths, &mut clearance.previous_remaining_paths);
        clearance.remaining_paths.clear();
        let ends = clearance.previous_remaining_paths.iter().flat_map(|leg| [leg.flight.x0, leg.flight.x1]);
        let low = ends.clone().fold(DVec3::INFINITY, DVec3::min);
        let high = ends.fold(DVec3::NEG_INFINITY, DVec3::max);
        if low.x > high.x {
            break;
        }
        let around = Aabb::new(low.as_vec3(), high.as_vec3()).loosened(reach_of_moving(view, dt + remaining) as Real);
        for (handle, collider) in view.query_fixed().intersect_aabb_conservative(around) {
            let target = StepTarget::new(handle, collider, view, sheet, dt, remaining);
            for k in 0..clearance.previous_remaining_paths.len() {
                let leg = clearance.previous_remaining_paths[k];
                let i = leg.node as usize;
                // A path along one face of a convex body cannot enter it.
                if leg.from == handle && target.convex {
                    continue;
                }
                let flight = NodePath { x1: sheet.state.x.get(i), v1: sheet.state.v.get(i), ..leg.flight };
                let (a, b) = (target.before_end(flight.dt).local_point(flight.x0), target.end.local_point(flight.x1));
                let PathHit::Surface(surface) = target.test_path(a.as_vec3(), b.as_vec3(), 0.0, &mut { NO_FACE })
                else {
                    continue;
                };
                if leg.from == handle && surface.normal.dot(leg.normal) > SETTINGS.same_face_cosine {
                    continue;
                }
                struck |= respond((&mut *sheet, &mut *clearance), i, &flight, &surface, handle, false);
                touched(handle);
            }
        }
    }
    struck
}

/// Move nodes in contact with two bodies out of both by alternating projections, and remove their
/// approach velocity.
fn separate_from_two_bodies(
    sheet: &mut Sheet,
    clearance: &Clearance,
    view: &RigidView,
    around: Aabb,
    (dt, remaining): (f64, f64),
) {
    for _ in 0..SETTINGS.maximum_corner_iterations {
        for (handle, collider) in view.query_fixed().intersect_aabb_conservative(around) {
            let target = StepTarget::new(handle, collider, view, sheet, dt, remaining);
            for i in clearance.between_bodies.iter().map(|i| *i as usize) {
                let Some(surface) = target.surface_at(sheet.state.x.get(i)) else { continue };
                let depth =
                    node_contact::contact_offset(sheet) - (sheet.state.x.get(i) - surface.point).dot(surface.normal);
                let approach = (sheet.state.v.get(i) - surface.velocity).dot(surface.normal);
                sheet.state.x.set(i, sheet.state.x.get(i) + surface.normal * depth.max(0.0));
                sheet.state.v.set(i, sheet.state.v.get(i) - surface.normal * approach.min(0.0));
            }
        }
    }
}

/// Deepest penetration of a node of `sheet` into a body, m; 0 if there is none.
pub fn deepest_penetration(sheet: &Sheet, view: &RigidView) -> f64 {
    let Some((low, high)) = sheet.state.x.bounds() else { return 0.0 };
    let mut deepest = 0.0_f64;
    for (_, collider) in view.query().intersect_aabb_conservative(Aabb::new(low.as_vec3(), high.as_vec3())) {
        let frame = RigidFrame::from_pose(collider.position());
        for p in sheet.state.x.iter() {
            let local = frame.local_point(p).as_vec3();
            // Only this projection of Parry distinguishes inside and outside of an oriented mesh.
            let (projection, _) = collider.shape().project_local_point_and_get_feature(local);
            let depth = frame.world(projection.point.as_dvec3()).distance(p);
            if projection.is_inside && depth > deepest && is_within(collider.shape(), local.as_dvec3()) {
                deepest = depth;
            }
        }
    }
    deepest
}

/// Whether `p` lies inside a polyhedral shape: the solid angles of its triangles seen from inside
/// sum to 4π, from outside to 0. Other shapes return true. It confirms Parry's projection, which is
/// wrong near sharp corners (Van Oosterom and Strackee, "The solid angle of a plane triangle", IEEE
/// Trans. Biomed. Eng. 30, 1983).
fn is_within(shape: &dyn Shape, p: DVec3) -> bool {
    let angle = |corners: [Vector; 3]| {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3() - p);
        let (x, y, z) = (a.length(), b.length(), c.length());
        let volume = a.dot(b.cross(c));
        2.0 * volume.atan2(x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y)
    };
    let around: f64 = match shape.as_typed_shape() {
        TypedShape::TriMesh(mesh) => mesh.triangles().map(|t| angle([t.a, t.b, t.c])).sum(),
        TypedShape::ConvexPolyhedron(solid) => {
            let (vertices, triangles) = solid.to_trimesh();
            triangles.iter().map(|t| angle(t.map(|i| vertices[i as usize]))).sum()
        }
        _ => return true,
    };
    around.abs() > TAU
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::polyhedron::pyramid::pyramid;
    use rapier3d::prelude::{SharedShape, TriMeshFlags};

    /// A slender pyramid, for which Parry's projection takes points beside the tip as inside.
    #[test]
    fn point_beside_a_needle_tip_is_outside() {
        let needle = pyramid(0.016, 0.05);
        let vertices: Vec<_> = needle.vertices.iter().map(|p| p.as_vec3()).collect();
        let triangles = needle.triangulate();
        let mesh = SharedShape::trimesh_with_flags(vertices.clone(), triangles.clone(), TriMeshFlags::ORIENTED);
        let shapes = [mesh.expect("closed"), SharedShape::convex_mesh(vertices, &triangles).expect("convex")];
        let steps = |n: i32, scale: f64| (0..=n).map(move |k| scale * (f64::from(k) + 0.37) / f64::from(n));
        let mut within = [0, 0];
        for (x, y, z) in steps(12, 0.024).flat_map(|x| {
            steps(12, 0.06).flat_map(move |y| steps(12, 0.024).map(move |z| (x - 0.012, y - 0.005, z - 0.012)))
        }) {
            let inside = y > 0.0 && x.abs().max(z.abs()) < 0.008 * (1.0 - y / 0.05);
            for (shape, count) in shapes.iter().zip(&mut within) {
                assert_eq!(is_within(&*shape.0, DVec3::new(x, y, z)), inside, "({x}, {y}, {z})");
                *count += u32::from(inside);
            }
        }
        assert!(within[0] > 100, "{within:?}");
    }
}
