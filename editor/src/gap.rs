//! Distance between the smoothed, displayed surface and the flat triangles used in contact.
//!
//! Each displayed vertex belongs to a cell of the sheet; its distance is that to the nearest of the
//! cell's two triangles. The displayed surface is first moved out of bodies, as in the display.

use bevy_sheetwork::SheetLayer;
use bevy_sheetwork::render::{clear_of_bodies, display_clearance};
use glam::{DVec3, Vec3};
use sheetwork::World;
use sheetwork::sheet::Sheet;
use sheetwork::sheet::surface::{DrawingSurface, SurfaceMesh, SurfaceSmoothing};

/// Spline segments per cell of the displayed surface.
pub const PARTS: u32 = 5;

/// Largest distance of any sheet of `world`, m; `None` where no surface is smoothed.
pub fn largest(world: &World, layer: SheetLayer, spline: SurfaceSmoothing) -> Option<f64> {
    world.sheets().iter().filter_map(|sheet| of_sheet(world, sheet, layer, spline)).reduce(f64::max)
}

/// Smoothed surface of a sheet of `world` as displayed, moved out of bodies in contact; `None` for
/// a sheet without such a layer.
pub fn drawn(world: &World, sheet: &Sheet, layer: SheetLayer, spline: SurfaceSmoothing) -> Option<SurfaceMesh> {
    let mut mesh = DrawingSurface::of_sheet(sheet, layer.index(sheet)?, PARTS, spline)?.mesh(&sheet.state.x);
    if let Some(rigid) = world.rigid().filter(|_| sheet.touching().contains(&true)) {
        let (reach, skin) = display_clearance(sheet, PARTS);
        clear_of_bodies(&rigid.view(), &mesh.indices, reach, skin, &mut mesh.positions, &mut mesh.normals);
    }
    Some(mesh)
}

fn of_sheet(world: &World, sheet: &Sheet, layer: SheetLayer, spline: SurfaceSmoothing) -> Option<f64> {
    if sheet.open_count() > 0 {
        // The surface consists of the sheet's own triangles.
        return Some(0.0);
    }
    let grid = sheet.model.layers.get(layer.index(sheet)?)?;
    let mesh = drawn(world, sheet, layer, spline)?;
    let corner = |m: u32| sheet.model.uv.get(m as usize).copied().unwrap_or_default();
    let (low, high) = grid.range().map(|m| corner(m as u32)).fold(
        ((1.0, 1.0), (0.0, 0.0)),
        |(low, high): ((f64, f64), (f64, f64)), p| {
            ((low.0.min(p.0), low.1.min(p.1)), (high.0.max(p.0), high.1.max(p.1)))
        },
    );
    let (triangles, size) = match &sheet.model.triangles {
        Some(triangles) => (triangles.clone(), (sheet.model.grid.0, sheet.model.grid.2)),
        None => (grid.triangles(), (grid.nx, grid.nz)),
    };
    let cells = Cells::new(sheet, &triangles, size, (low, high));
    let gaps =
        mesh.positions.iter().zip(&mesh.uvs).map(|(p, uv)| cells.distance(sheet, Vec3::from(*p).as_dvec3(), *uv));
    gaps.reduce(f64::max)
}

/// Triangles of a layer, indexed by material coordinates.
struct Cells {
    columns: usize,
    rows: usize,
    low: (f64, f64),
    size: (f64, f64),
    triangles: Vec<Vec<[u32; 3]>>,
}

impl Cells {
    fn new(sheet: &Sheet, all: &[[u32; 3]], (nx, nz): (u32, u32), (low, high): ((f64, f64), (f64, f64))) -> Self {
        let (columns, rows) = ((nx as usize).saturating_sub(1).max(1), (nz as usize).saturating_sub(1).max(1));
        let size = ((high.0 - low.0).max(1e-12), (high.1 - low.1).max(1e-12));
        let mut cells = Self { columns, rows, low, size, triangles: vec![Vec::new(); columns * rows] };
        for triangle in all {
            let uv = triangle.map(|m| sheet.model.uv[m as usize]);
            let middle = ((uv[0].0 + uv[1].0 + uv[2].0) / 3.0, (uv[0].1 + uv[1].1 + uv[2].1) / 3.0);
            let (i, j) = cells.at(middle);
            cells.triangles[j * columns + i].push(*triangle);
        }
        cells
    }

    fn at(&self, (u, v): (f64, f64)) -> (usize, usize) {
        let place = |part: f64, count: usize| ((part * count as f64).max(0.0) as usize).min(count - 1);
        (place((u - self.low.0) / self.size.0, self.columns), place((v - self.low.1) / self.size.1, self.rows))
    }

    /// Distance of `p` to the triangles of the cell at `uv` and its neighbours: rows of some
    /// structures are shifted by half a cell.
    fn distance(&self, sheet: &Sheet, p: DVec3, uv: [f32; 2]) -> f64 {
        let (i, j) = self.at((f64::from(uv[0]), f64::from(uv[1])));
        let (rows, columns) =
            (j.saturating_sub(1)..=(j + 1).min(self.rows - 1), i.saturating_sub(1)..=(i + 1).min(self.columns - 1));
        let near = rows.flat_map(|j| columns.clone().map(move |i| (i, j)));
        let triangles = near.flat_map(|(i, j)| &self.triangles[j * self.columns + i]);
        triangles.map(|t| to_triangle(p, t.map(|m| sheet.state.x.get(m as usize)))).fold(f64::INFINITY, f64::min)
    }
}

/// Distance of `p` to a triangle (Ericson, *Real-Time Collision Detection*, 2005, 5.1.5).
fn to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (ab, ac, normal) = (b - a, c - a, (b - a).cross(c - a));
    let area = normal.length_squared();
    if area > 0.0 {
        let w = ab.cross(p - a).dot(normal) / area;
        let v = (p - a).cross(ac).dot(normal) / area;
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            return (p - a).dot(normal).abs() / area.sqrt();
        }
    }
    let to_line = |from: DVec3, along: DVec3| {
        let s = ((p - from).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
        p.distance(from + s * along)
    };
    to_line(a, ab).min(to_line(a, ac)).min(to_line(b, c - b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::scene::Scene;

    #[test]
    fn the_gap_of_a_flat_sheet_is_zero_and_of_a_bent_one_that_of_an_arc() {
        let scene = Scene::parse(
            r#"(gravity: (0, 0, 0), sheets: [(structure: "shell", grid: (9, 1, 3), size: (0.16, 0.04), material: "hips")])"#,
        );
        let mut world = World::new(&scene.expect("valid")).expect("valid");
        assert!(largest(&world, SheetLayer::Top, SurfaceSmoothing::Interpolating).expect("a sheet") < 1e-8);
        // On a cylinder with r = 0.1 m the arc rises r (1 - cos(chord / 2r)) above a chord of 0.02
        // m.
        let (radius, sheet) = (0.1, &mut world.sheets_mut()[0]);
        for i in 0..sheet.node_count() {
            let place = sheet.state.x.get(i);
            let (sin, cos) = (place.x / radius).sin_cos();
            sheet.state.x.set(i, DVec3::new(radius * sin, radius * cos, place.z));
        }
        let gap = largest(&world, SheetLayer::Top, SurfaceSmoothing::Interpolating).expect("a sheet");
        let rise = radius * (1.0 - (0.01_f64 / radius).cos());
        assert!((gap / rise - 1.0).abs() < 0.35, "a spline is near the arc: {gap} beside {rise}");
    }

    #[test]
    fn distances_to_a_triangle_are_those_to_its_face_edges_and_corners() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for (p, wanted) in [
            (DVec3::new(0.2, 0.2, 0.5), 0.5),
            (DVec3::new(0.5, -1.0, 0.0), 1.0),
            (DVec3::new(-3.0, -4.0, 0.0), 5.0),
            (DVec3::new(1.0, 1.0, 0.0), 0.5_f64.sqrt()),
        ] {
            assert!((to_triangle(p, t) - wanted).abs() < 1e-12, "{p}");
        }
    }
}
