//! Numbers of features follow from Euler's formula and from the shapes.

use glam::{DVec3, Vec3};
use rapier3d::math::Pose;
use rapier3d::prelude::SharedShape;

use crate::collision::features::{ColliderFeatures, ColliderMesh, ColliderPart};

fn mesh(shape: &SharedShape) -> ColliderMesh {
    match ColliderFeatures::from_shape(shape.0.as_ref()).solids() {
        [(0, ColliderPart::Mesh(mesh))] => mesh.as_ref().clone(),
        _ => panic!("not one mesh"),
    }
}

#[test]
fn a_box_has_six_faces_twelve_edges_and_eight_corners() {
    let mesh = mesh(&SharedShape::cuboid(0.1, 0.05, 0.02));
    assert_eq!((mesh.vertices.len(), mesh.faces().len(), mesh.edges().len(), mesh.corners().len()), (8, 6, 12, 8));
    assert!(mesh.min_width().is_finite() && mesh.uses_planes());
    assert!((mesh.min_width() - 0.04).abs() < 1e-8);
    for face in mesh.faces() {
        assert!(face.height(DVec3::ZERO) < 0.0 && (face.normal.length() - 1.0).abs() < 1e-12);
    }
    for edge in mesh.edges() {
        let middle = edge.ends[0].lerp(edge.ends[1], 0.5);
        assert!(edge.normals.iter().all(|n| n.dot(middle) > 0.0) && edge.normals[0].dot(edge.normals[1]).abs() < 1e-9);
    }
    let corner = &mesh.corners()[0];
    let out = corner.position.signum() / 3.0_f64.sqrt();
    assert_eq!(corner.edges.len(), 3);
    assert!(corner.lies_behind(out, 0.0) && !corner.lies_behind(-out, 0.0));
}

#[test]
fn round_shapes_are_closed_convex_and_close_to_their_surface() {
    let shapes = [
        (SharedShape::cylinder(0.05, 0.02), 2e-5),
        (SharedShape::cone(0.05, 0.02), 2e-5),
        (SharedShape::capsule_y(0.03, 0.01), 6e-5),
    ];
    for (shape, away) in shapes {
        let mesh = mesh(&shape);
        assert!(mesh.min_width().is_finite(), "{:?}", shape.shape_type());
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
            let middle = (a + b + c) / 3.0;
            let distance = shape.distance_to_local_point(middle.as_vec3(), false).abs();
            assert!(distance < away, "{:?}: {distance}", shape.shape_type());
        }
    }
}

#[test]
fn a_round_box_lies_between_its_true_surface_and_just_below_it() {
    let (half, radius) = (0.03, 0.005);
    let side = half as f32;
    let mesh = mesh(&SharedShape::round_cuboid(side, side, side, 0.005));
    assert!(mesh.min_width().is_finite());
    for t in &mesh.triangles {
        let middle = t.iter().map(|i| mesh.vertices[*i as usize]).sum::<DVec3>() / 3.0;
        let out = (middle.abs() - DVec3::splat(half)).max(DVec3::ZERO).length() - radius;
        assert!(out < 1e-7 && out > -1e-4, "{out}");
    }
}

#[test]
fn a_hollow_has_no_convex_edge() {
    // A cube whose top is pushed in to a point below: the rim stays convex, the four valleys are
    // concave.
    let mut vertices: Vec<DVec3> = Vec::new();
    for y in [0.0, 1.0] {
        vertices.extend([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, z)| DVec3::new(x, y, z)));
    }
    vertices.push(DVec3::new(0.5, 0.5, 0.5));
    let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
    for i in 0..4 {
        let (a, b) = (i, (i + 1) % 4);
        triangles.extend([[a, 4 + a, 4 + b], [a, 4 + b, b], [4 + a, 8, 4 + b]]);
    }
    let mesh = ColliderMesh::new(&vertices, &triangles).expect("triangles");
    assert!(!mesh.min_width().is_finite());
    assert_eq!((mesh.faces().len(), mesh.edges().len()), (9, 12));
    // The lower corners are convex; those of the rim have a concave edge.
    assert_eq!(mesh.corners().len(), 4);
    let below = mesh.nearest(DVec3::new(0.5, 0.2, 0.5), 10.0).expect("near");
    assert!(below.inside && (below.point.y).abs() < 1e-12);
    let (time, _) = mesh.entered(DVec3::new(0.5, 1.5, 0.45), DVec3::new(0.5, 0.0, 0.45)).expect("enters");
    assert!((1.5 - 1.5 * time - 0.55).abs() < 1e-6);
}

#[test]
fn compounds_are_numbered_through_and_other_shapes_are_empty() {
    let parts = vec![
        (Pose::from_translation(Vec3::X), SharedShape::cuboid(0.1, 0.1, 0.1)),
        (Pose::from_translation(-Vec3::X), SharedShape::ball(0.2)),
    ];
    let features = ColliderFeatures::from_shape(SharedShape::compound(parts).0.as_ref());
    let [(0, ColliderPart::Mesh(mesh)), (12, ColliderPart::Ball { centre, radius })] = features.solids() else {
        panic!("order")
    };
    assert!((mesh.bounds().0.x - 0.9).abs() < 1e-6 && *centre == DVec3::NEG_X && (radius - 0.2).abs() < 1e-8);
    assert!(ColliderFeatures::from_shape(SharedShape::segment(Vec3::X, Vec3::Y).0.as_ref()).solids().is_empty());
    assert!(ColliderPart::from_triangles(&[DVec3::X], &[[0, 0, 0]]).is_none());
    assert!(ColliderPart::from_triangles(&[DVec3::NAN; 3], &[[0, 1, 2]]).is_none());
}
