//! Smoothed surface of a sheet on bodies: neither vertices nor sides penetrate a body, and the
//! displayed gap equals that over all triangles.

use bevy_sheetwork::SheetLayer;
use glam::{DVec3, Vec3};
use sheetwork::World;
use sheetwork::scene::{Scene, Shape};
use sheetwork::sheet::surface::{DrawingSurface, SurfaceSmoothing};
use sheetwork_editor::{gap, scenes};

/// Largest penetration of the displayed surface, m.
const MAX_PENETRATION: f64 = 5e-5;

/// Sample intervals per side of a displayed triangle.
const PARTS_OF_SIDE: u32 = 6;

/// Penetration of `p` into the bodies, by the planes of their convex faces; negative outside.
fn depth(world: &World, p: DVec3) -> f64 {
    let rigid = world.rigid().expect("bodies");
    let of_body = |(index, body): (usize, &sheetwork::rigid::RigidBodyInfo)| {
        let (place, turn) = rigid.pose(index).expect("a pose");
        let own = turn.inverse() * (p - place);
        if let Shape::Ball(radius) = body.shape {
            return radius - own.length();
        }
        let of_part = |part: &sheetwork::scene::Polyhedron| {
            let middle = part.vertices.iter().sum::<DVec3>() / part.vertices.len() as f64;
            let plane = |face: &Vec<u32>| {
                let at = |i: usize| part.vertices[face[i] as usize];
                let normal = (at(1) - at(0)).cross(at(2) - at(0)).normalize();
                let outward = if normal.dot(middle - at(0)) > 0.0 { -normal } else { normal };
                outward.dot(at(0) - own)
            };
            part.faces.iter().map(plane).fold(f64::INFINITY, f64::min)
        };
        body.polyhedra.iter().map(of_part).fold(f64::NEG_INFINITY, f64::max)
    };
    rigid.bodies().iter().enumerate().map(of_body).fold(f64::NEG_INFINITY, f64::max)
}

/// Distance of `p` to a triangle: interior, otherwise the nearest of three edges.
fn away(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let edge = |from: DVec3, to: DVec3| {
        let s = ((p - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
        p.distance(from.lerp(to, s))
    };
    let normal = (b - a).cross(c - a).normalize();
    let foot = p - normal * normal.dot(p - a);
    let side = |from: DVec3, to: DVec3| (to - from).cross(foot - from).dot(normal) >= 0.0;
    let on_edges = edge(a, b).min(edge(b, c)).min(edge(c, a));
    if side(a, b) && side(b, c) && side(c, a) { p.distance(foot) } else { on_edges }
}

/// Run a scene. Returns the penetration of the displayed surface, that of the smoothed surface, and
/// the gap, m: as displayed and by brute force.
fn after(scene: &Scene, seconds: f64, spline: SurfaceSmoothing) -> (f64, f64, f64, f64) {
    let mut world = World::new(scene).expect("valid");
    world.advance(seconds);
    let sheet = &world.sheets()[0];
    assert!(sheet.touching().contains(&true), "it lies on something");
    let mesh = gap::drawn(&world, sheet, SheetLayer::Top, spline).expect("a layer");
    let (layer, last) = (sheet.model.layers.last().expect("a layer"), sheet.model.layers.len() - 1);
    // Triangles sampled at corners, along sides and inside.
    let deepest = |places: &[[f32; 3]]| {
        let of_triangle = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|i| Vec3::from(places[i as usize]).as_dvec3());
            let points = (0..=PARTS_OF_SIDE).flat_map(|i| (0..=PARTS_OF_SIDE - i).map(move |j| (i, j)));
            let part = |n: u32| f64::from(n) / f64::from(PARTS_OF_SIDE);
            points
                .map(|(i, j)| depth(&world, a + part(i) * (b - a) + part(j) * (c - a)))
                .fold(f64::NEG_INFINITY, f64::max)
        };
        mesh.indices.iter().map(of_triangle).fold(f64::NEG_INFINITY, f64::max)
    };
    let unkept = DrawingSurface::of_sheet(sheet, last, gap::PARTS, spline).expect("a surface").mesh(&sheet.state.x);
    let triangles = layer.triangles();
    let nearest = |p: &[f32; 3]| {
        let p = Vec3::from(*p).as_dvec3();
        triangles.iter().map(|t| away(p, t.map(|m| sheet.state.x.get(m as usize)))).fold(f64::INFINITY, f64::min)
    };
    let brute = mesh.positions.iter().map(nearest).fold(0.0, f64::max);
    let shown = gap::largest(&world, SheetLayer::Top, spline).expect("smoothed");
    (deepest(&mesh.positions), deepest(&unkept.positions), shown, brute)
}

fn check(name: &str, scene: &Scene, seconds: f64) -> f64 {
    check_spline(name, scene, seconds, SurfaceSmoothing::Interpolating)
}

fn check_spline(name: &str, scene: &Scene, seconds: f64, spline: SurfaceSmoothing) -> f64 {
    let (deepest, unkept, shown, brute) = after(scene, seconds, spline);
    let um = |m: f64| 1e6 * m;
    println!(
        "{name}: deepest {:.2} um, without care {:.1} um, gap {:.2} um, by brute force {:.2} um",
        um(deepest),
        um(unkept),
        um(shown),
        um(brute)
    );
    assert!(deepest < MAX_PENETRATION, "{name}: {deepest} m inside");
    assert!((shown - brute).abs() < 1e-8 + 1e-3 * brute, "{name}: shown {shown}, brute force {brute}");
    unkept
}

fn shipped(name: &str) -> Scene {
    Scene::load(&scenes::find(std::path::Path::new(name))).expect("shipped")
}

#[test]
fn on_a_box_and_on_balls_nothing_drawn_is_inside_and_the_gap_is_true() {
    let card = sheetwork_editor::templates::TABLE.iter().find(|t| t.name == "Sheet on a box").expect("a template");
    let mut deep = check("card on a box", &card.scene(), 3.0);
    deep = deep.max(check("sheet on a box", &shipped("box_drop"), 3.0));
    let mut film = shipped("pvc_drape");
    film.sheets[0].tearing = false;
    film.time_lapse = 10.0;
    deep = deep.max(check("film on a ball", &film, 3.0));
    deep = deep.max(check("soft lattice on a dome", &shipped("hemisphere"), 4.0));
    deep = deep.max(check("lattice drawn out over a ridge", &shipped("wedge"), 0.3));
    assert!(deep > MAX_PENETRATION, "without care something would be inside: {deep}");
}

#[test]
fn a_b_spline_surface_is_brought_out_of_bodies_too() {
    // It sinks deeper than the interpolating surface, and the display knows it.
    let mut box_drop = shipped("box_drop");
    box_drop.sheets.truncate(1);
    let splines = [SurfaceSmoothing::Interpolating, SurfaceSmoothing::BSpline];
    let [through, beside] = splines.map(|spline| check_spline("sheet on a box", &box_drop, 3.0, spline));
    assert!(beside > 2.0 * through, "{beside} {through}");
}
