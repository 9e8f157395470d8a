//! Depth of the drawn surfaces of sheets in bodies, and raggedness of their edges.
//!
//! Contact acts at the nodes. A drawn surface that passes through the nodes cuts into bodies
//! between them; one that has the nodes as control points lies beside them (thesis 5.3.4). Both
//! layers of each sheet are measured, flat and with every kind of smoothing, without the
//! correction that the editor and the plugin make when they draw.

use glam::Vec3;
use serde::Serialize;
use sheetwork::World;
use sheetwork::sheet::surface::{DrawingSurface, SurfaceMesh, SurfaceSmoothing};

/// Spline segments per cell, as the editor draws.
const PARTS: u32 = 5;

/// Measures of one drawn surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DrawnSurface {
    /// Sheet.
    pub sheet: String,
    /// Layer, from the bottom.
    pub layer: usize,
    /// `flat`, or the name of a smoothing.
    pub smoothing: &'static str,
    /// Depth of the deepest point inside a body, floor and walls included, m; none where no point
    /// is inside. Points are five to a cell along either side.
    pub depth_m: Option<f64>,
    /// Largest distance of a node of the layer from the surface's vertices, m.
    pub off_nodes_m: f64,
    /// Sharpest angle between neighbouring sides of the outline, without its corners, degrees.
    pub edge_kink_deg: f64,
}

/// Measures of every layer of every sheet on a grid.
pub fn drawn_surfaces(world: &World) -> Vec<DrawnSurface> {
    let kinds = [(1, SurfaceSmoothing::Interpolating, "flat")];
    let smooth = SurfaceSmoothing::ALL.map(|(kind, name)| (PARTS, kind, name));
    let mut all = Vec::new();
    for sheet in world.sheets().iter().filter(|s| s.model.triangles.is_none()) {
        for (index, layer) in sheet.model.layers.iter().enumerate() {
            for (parts, smoothing, name) in kinds.into_iter().chain(smooth) {
                let Some(surface) = DrawingSurface::of_sheet(sheet, index, parts, smoothing) else { continue };
                let mesh = surface.mesh(&sheet.state.x);
                let columns = ((layer.nx - 1) * parts + 1) as usize;
                let off = layer.range().map(|i| {
                    let node = sheet.state.x.get(i).as_vec3();
                    mesh.positions.iter().map(|p| Vec3::from(*p).distance(node)).fold(f32::INFINITY, f32::min)
                });
                all.push(DrawnSurface {
                    sheet: sheet.name.clone(),
                    layer: index,
                    smoothing: name,
                    depth_m: depth(world, &mesh, PARTS / parts),
                    off_nodes_m: f64::from(off.fold(0.0, f32::max)),
                    edge_kink_deg: sharpest_kink(&mesh, columns),
                });
            }
        }
    }
    all
}

/// Depth of the deepest point inside a body, m; the sides of the triangles are divided by `parts`.
fn depth(world: &World, mesh: &SurfaceMesh, parts: u32) -> Option<f64> {
    let view = world.rigid()?.view();
    let query = view.query();
    let depth = |p: Vec3| {
        let (_, nearest, _) = query.project_point_and_get_feature(p, f32::MAX)?;
        nearest.is_inside.then(|| f64::from(nearest.point.distance(p)))
    };
    let points = mesh.indices.iter().flat_map(|triangle| {
        let [a, b, c] = triangle.map(|i| Vec3::from(mesh.positions[i as usize]));
        let part = move |n: u32| n as f32 / parts as f32;
        let inside = (0..=parts).flat_map(move |i| (0..=parts - i).map(move |j| (i, j)));
        inside.map(move |(i, j)| a + part(i) * (b - a) + part(j) * (c - a))
    });
    points.filter_map(depth).reduce(f64::max)
}

/// Sharpest angle along the four edges of a grid of `columns`, degrees.
fn sharpest_kink(mesh: &SurfaceMesh, columns: usize) -> f64 {
    let at = |i: usize| Vec3::from(mesh.positions[i]);
    let rows = mesh.positions.len() / columns.max(1);
    let edges: [Vec<Vec3>; 4] = [
        (0..columns).map(at).collect(),
        (0..columns).map(|c| at((rows - 1) * columns + c)).collect(),
        (0..rows).map(|r| at(r * columns)).collect(),
        (0..rows).map(|r| at(r * columns + columns - 1)).collect(),
    ];
    let kinks = edges
        .iter()
        .flat_map(|edge| edge.windows(3).map(|p| f64::from((p[1] - p[0]).angle_between(p[2] - p[1])).to_degrees()));
    kinks.filter(|angle| angle.is_finite()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::scene::Scene;

    #[test]
    fn a_b_spline_sinks_into_the_edge_of_a_box_and_has_the_smoother_edge() {
        // A strip whose nodes follow a right angle over the edge of a box at x = 0, in cells of 2
        // cm: the second difference at the bend is 2 cm · √2 along the diagonal, of which a
        // cubic B-spline leaves a sixth, 4.7 mm, on the inside; it is 3.3 mm below both faces.
        let scene = Scene::parse(
            r#"(gravity: (0, 0, 0), sheets: [(structure: "samm", grid: (13, 1, 5), size: (0.24, 0.08))],
                bodies: [(name: "box", shape: Box((0.2, 0.2, 0.2)), placement: (position: (-0.1, -0.1, 0)))])"#,
        );
        let mut world = World::new(&scene.expect("valid")).expect("valid");
        let sheet = &mut world.sheets_mut()[0];
        for i in 0..sheet.node_count() {
            let mut p = sheet.state.x.get(i);
            if p.x > 1e-9 {
                (p.x, p.y) = (0.0, -p.x);
            } else {
                p.y = 0.0;
            }
            sheet.state.x.set(i, p);
        }
        let all = drawn_surfaces(&world);
        let of = |name: &str| all.iter().find(|s| s.smoothing == name).expect("measured");
        let inside = |name: &str| of(name).depth_m.unwrap_or(0.0);
        assert!(inside("flat") < 1e-6 && inside("interpolating") < 1e-3, "{all:?}");
        assert!((inside("b-spline") / (0.02 / 6.0) - 1.0).abs() < 0.02, "{all:?}");
        assert!(inside("bezier") > 2.0 * inside("b-spline"), "{all:?}");
        assert!((of("flat").edge_kink_deg - 90.0).abs() < 1e-3 && of("interpolating").off_nodes_m < 1e-6);
        assert!(of("b-spline").edge_kink_deg < 0.5 * of("interpolating").edge_kink_deg, "{all:?}");
    }
}
