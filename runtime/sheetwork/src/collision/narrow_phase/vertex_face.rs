//! Nodes on the faces of a body.
//!
//! In the frame of the body a node moves from a to b on a straight line. With d_k its distance from
//! plane k minus the contact offset, the node is inside a convex solid if all d_k < 0. It entered
//! through the face whose plane it crossed last, among those in front of which it began (clipping
//! of a line by slabs: Cyrus and Beck, Generalized two- and three-dimensional clipping, 1978). Near
//! a rim two faces may qualify; the one parallel to the sheet is chosen, because a sheet that
//! slides on a face must not catch on the next face, and one that hangs beside a body must not be
//! lifted to its top. Lengths in m.

use glam::DVec3;

use crate::collision::bvh::SurfaceTree;
use crate::collision::constraint::{ContactConstraint, SheetPoint};
use crate::collision::features::ColliderMesh;
use crate::collision::narrow_phase::DetectionDistances;
use crate::collision::narrow_phase::body_frame::{BodyFramePositions, SheetBodyPair};
use crate::collision::narrow_phase::feature_keys::FeatureKind;
use crate::collision::settings::{DetectionSettings, VertexFaceSettings};

const SETTINGS: VertexFaceSettings = DetectionSettings::DEFAULT.vertex_face;

/// Add the constraints of all nodes with a half space.
pub(crate) fn half_space(
    meeting: &SheetBodyPair,
    local: &BodyFramePositions,
    normal: DVec3,
    constraints: &mut Vec<ContactConstraint>,
) {
    for (i, p) in local.end.iter().enumerate().filter(|(i, _)| !meeting.skin.is_detached(*i)) {
        let height = normal.dot(*p);
        if height.min(normal.dot(local.accepted(i))) <= meeting.offset + meeting.margin {
            let i = i as u32;
            let foot = *p - normal * height;
            constraints.push(meeting.constraint(
                (SheetPoint::node(i), FeatureKind::Node, i),
                (foot, FeatureKind::Face, 0),
                normal,
            ));
        }
    }
}

/// Add the constraints of all nodes with a surface of faces. Return the number of nodes tested.
pub(crate) fn mesh(
    meeting: &SheetBodyPair,
    local: &BodyFramePositions,
    tree: &SurfaceTree,
    mesh: &ColliderMesh,
    constraints: &mut Vec<ContactConstraint>,
) -> u64 {
    let limits = meeting.limits(mesh.min_width());
    let (low, high) = mesh.bounds();
    let room = DVec3::splat(limits.offset + limits.margin);
    let (low, high) = (low - room, high + room);
    let few = mesh.uses_planes();
    let mut tests = 0;
    for i in 0..local.end.len() {
        let (a, b, put) = (local.start[i], local.end[i], local.accepted(i));
        if !(a.min(b).min(put).cmple(high).all() && a.max(b).max(put).cmpge(low).all()) || meeting.skin.is_detached(i) {
            continue;
        }
        tests += 1;
        let first = a;
        let a = if few { last_outside(mesh, a, local.base[i], &limits) } else { a };
        // Evaluated at rims only.
        let lies = || meeting.at_base(tree.node_normal(i));
        let face = |a, b| {
            if few { entered_face(mesh, a, b, &lies, &limits) } else { entered_by_query(mesh, a, b, &lies, &limits) }
        };
        // A node that stays clear in free motion may have been pushed in by another contact.
        let pushed = || Some(put).filter(|p| *p != b).and_then(|p| face(first, p));
        let Some(index) = face(a, b).or_else(pushed) else { continue };
        let face = &mesh.faces()[index as usize];
        let foot = b - face.normal * face.height(b);
        let i = i as u32;
        constraints.push(meeting.constraint(
            (SheetPoint::node(i), FeatureKind::Node, i),
            (foot, FeatureKind::Face, index),
            face.normal,
        ));
    }
    tests
}

/// Start of the path into a convex solid: the base if it is outside, since the node may have passed
/// around a rim; otherwise, and if the path to the base leads through the solid, the start.
fn last_outside(mesh: &ColliderMesh, start: DVec3, base: DVec3, limits: &DetectionDistances) -> DVec3 {
    let outside =
        start != base && mesh.faces().iter().any(|f| f.height(base) - limits.offset >= -limits.max_start_penetration);
    if outside && !passes_through_solid(mesh, start, base, limits) { base } else { start }
}

/// Whether the path from `a` to `b`, both outside, leads through a convex solid.
fn passes_through_solid(mesh: &ColliderMesh, a: DVec3, b: DVec3, limits: &DetectionDistances) -> bool {
    let (mut enters, mut leaves) = ((0, 0.0_f64), (0, 1.0_f64));
    for (k, face) in mesh.faces().iter().enumerate() {
        let (from, to) = (face.height(a) - limits.offset, face.height(b) - limits.offset);
        if from >= 0.0 && to >= 0.0 {
            return false;
        }
        let time = from / (from - to);
        if from > 0.0 && time > enters.1 {
            enters = (k, time);
        } else if to > 0.0 && time < leaves.1 {
            leaves = (k, time);
        }
    }
    enters.1 > 0.0 && leaves.1 < 1.0 && passes_through(mesh, a, b, enters, leaves, limits)
}

/// Face of a convex solid through which a node moving from `a` to `b` has entered, or near which it
/// is. `lies` returns the surface normal of the sheet there.
fn entered_face(
    mesh: &ColliderMesh,
    a: DVec3,
    b: DVec3,
    lies: &dyn Fn() -> DVec3,
    limits: &DetectionDistances,
) -> Option<u32> {
    let faces = mesh.faces();
    let ends = |k: usize| (faces[k].height(a) - limits.offset, faces[k].height(b) - limits.offset);
    let (mut outmost, mut furthest) = (0, f64::NEG_INFINITY);
    let (mut last, mut time, mut out) = (None, f64::NEG_INFINITY, (0, f64::INFINITY));
    for k in 0..faces.len() {
        let (d0, d1) = ends(k);
        if d1 > furthest {
            (outmost, furthest) = (k, d1);
        }
        if d1 > limits.margin && d0 > 0.0 {
            return None;
        }
        // For motion nearly parallel to the plane the crossing time is rounding noise.
        let t = if d0 - d1 > 1e-12 { (d0 / (d0 - d1)).max(0.0) } else { 0.0 };
        if d0 >= -limits.max_start_penetration && (t > time || (t == time && last.is_some_and(|j| d1 > ends(j).1))) {
            (last, time) = (Some(k), t);
        }
        if d1 > 0.0 && d1 > d0 && -d0 / (d1 - d0) < out.1 {
            out = (k, -d0 / (d1 - d0));
        }
    }
    if furthest > 0.0 && furthest <= limits.margin {
        let chosen =
            best_aligned_face(mesh, outmost, lies, |k| ends(k).1 >= furthest - SETTINGS.rim_distance * limits.half);
        if ends(chosen).0 >= -limits.max_start_penetration {
            return Some(chosen as u32);
        }
    }
    if furthest > 0.0 {
        return last.filter(|k| passes_through(mesh, a, b, (*k, time), out, limits)).map(|k| k as u32);
    }
    // A node that began inside leaves along the shortest way.
    let Some(last) = last else { return shallowest_face(mesh, a).map(|k| k as u32) };
    let time = time.min(1.0);
    let chosen = best_aligned_face(mesh, last, lies, |k| {
        let (d0, d1) = ends(k);
        let passing = d0 + (d1 - d0) * time;
        let sharp = faces[k].normal.dot(faces[last].normal) < SETTINGS.ridge_cosine;
        let deep = if sharp {
            limits.max_start_penetration.min(SETTINGS.rim_distance * limits.half)
        } else {
            limits.max_start_penetration
        };
        if d0 < -deep || passing >= -deep {
            return d0 >= -deep;
        }
        let lies = lies();
        let lain_on = faces[k].normal.dot(lies).abs() > 0.9 && faces[last].normal.dot(lies).abs() < 0.5;
        let most = limits.rim_passing_depth();
        d0 < most && lain_on && passing >= -most.min(0.4 * mesh.min_width())
    });
    Some(shallowest_smooth_face(mesh, chosen, b) as u32)
}

/// Whether the path through a solid is deeper than a graze of a corner.
fn passes_through(
    mesh: &ColliderMesh,
    a: DVec3,
    b: DVec3,
    (k, enters): (usize, f64),
    (j, leaves): (usize, f64),
    limits: &DetectionDistances,
) -> bool {
    if enters >= leaves || enters > 1.0 {
        return false;
    }
    let faces = mesh.faces();
    let middle = a.lerp(b, 0.5 * (enters + leaves));
    let depth = faces.iter().map(|f| limits.offset - f.height(middle)).fold(f64::INFINITY, f64::min);
    depth > SETTINGS.corner_cut_depth * limits.half
        || (depth > 0.0 && faces[k].normal.dot(faces[j].normal) < SETTINGS.ridge_cosine)
}

/// Face most nearly parallel to the sheet, among `first` and the faces at a sharp angle to it that
/// satisfy `allowed`.
fn best_aligned_face(
    mesh: &ColliderMesh,
    first: usize,
    lies: &dyn Fn() -> DVec3,
    allowed: impl Fn(usize) -> bool,
) -> usize {
    let faces = mesh.faces();
    let (mut best, mut most) = (first, 0.0);
    for (k, face) in faces.iter().enumerate() {
        if k == first || face.normal.dot(faces[first].normal) >= SETTINGS.smooth_cosine || !allowed(k) {
            continue;
        }
        let lies = lies();
        let aligned = face.normal.dot(lies).abs();
        if aligned > faces[first].normal.dot(lies).abs() + 0.1 && aligned > most {
            (best, most) = (k, aligned);
        }
    }
    best
}

/// Face with the least penetration of `b`, among `first` and the faces smoothly joined to it.
fn shallowest_smooth_face(mesh: &ColliderMesh, first: usize, b: DVec3) -> usize {
    let faces = mesh.faces();
    let (mut best, mut height) = (first, faces[first].height(b));
    for (k, face) in faces.iter().enumerate() {
        if face.height(b) > height && face.normal.dot(faces[first].normal) > SETTINGS.smooth_cosine {
            (best, height) = (k, face.height(b));
        }
    }
    best
}

fn shallowest_face(mesh: &ColliderMesh, p: DVec3) -> Option<usize> {
    let heights = mesh.faces().iter().enumerate().map(|(k, f)| (k, f.height(p)));
    heights.max_by(|x, y| x.1.total_cmp(&y.1)).map(|x| x.0)
}

/// Face that a node has entered or is near, by distance and ray queries, for surfaces that are not
/// convex or have many faces.
fn entered_by_query(
    mesh: &ColliderMesh,
    a: DVec3,
    b: DVec3,
    lies: &dyn Fn() -> DVec3,
    limits: &DetectionDistances,
) -> Option<u32> {
    let faces = mesh.faces();
    let travel = a.distance(b);
    let reach = limits.offset + limits.margin;
    let ray = || mesh.entered(a, b).map(|(_, face)| face);
    let Some(near) = mesh.nearest(b, reach + travel) else { return ray() };
    let face = &faces[near.face as usize];
    let came_in_front =
        face.height(a) >= -limits.max_start_penetration.min(0.5 * limits.offset + SETTINGS.rim_distance * limits.half);
    if !near.inside {
        if b.distance(near.point) > reach {
            // The nearest face to the end need not be the one on the path.
            return (travel > b.distance(near.point)).then(ray).flatten().filter(|k| *k != near.face || !came_in_front);
        }
        // Beside a rim the edges and corners of the body determine the contact.
        let over = face.height(b) >= 0.9 * b.distance(near.point);
        return (came_in_front && over).then_some(near.face);
    }
    let Some(through) = (travel > SETTINGS.rim_distance * limits.half).then(ray).flatten() else {
        return Some(near.face);
    };
    let other = &faces[through as usize];
    let smooth = other.normal.dot(face.normal) > SETTINGS.smooth_cosine;
    let lies_along = |lies: DVec3| face.normal.dot(lies).abs() > other.normal.dot(lies).abs() + 0.1;
    let shallow = face.height(b) > -limits.rim_passing_depth() && lies_along(lies());
    Some(if came_in_front && (smooth || shallow) { near.face } else { through })
}
