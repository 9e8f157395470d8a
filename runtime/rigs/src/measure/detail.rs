//! Visible effect of a change of grid (LOD).
//!
//! Sheets that droop, swing, are creased, are curled, and lie on a box change to a finer and to a
//! coarser grid; triangle meshes also as a tag with a point, a hole and a slit. Lattices droop,
//! swing and lie on the box.
//!
//! - `pop`: largest distance between the drawn surfaces before and after, over the deflection
//!   (largest distance of the surface from its best-fit plane).
//! - `strain_ratio`: elastic energy after over before.
//! - `rise`: largest energy rise in the 0.1 s after the change, over elastic plus kinetic energy.
//! - `apart`: distance after 0.1 s from a sheet that stays on its grid, over the deflection. It
//!   includes the difference in stiffness of the grids.
//!
//! Rows of a triangular layer end half a cell apart and are drawn straight at a quarter of a cell
//! from the sheet's ends. `pop` covers the area where all rows have nodes, `pop_with_ends` the area
//! that both grids draw, and `outline_m` is the displacement of the drawn ends along the sheet.
//! Triangle meshes are compared at places that both meshes cover.

use glam::{DMat3, DVec3};
use serde_json::{Value, json};

use crate::measure::{RigResult, Runner, Setup, body};
use sheetwork::material::calibration::isotropic_rows;
use sheetwork::mesh::outline::locate::PointLocator;
use sheetwork::mesh::outline::{HoleSpec, OutlineSpec, TriangleMesh};
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{CreaseSpec, Region, Scene, Shape};
use sheetwork::sheet::Sheet;
use sheetwork::{InputError, World};

/// Nodes along each side of the grids.
const GRIDS: [u32; 3] = [11, 21, 41];
/// Pieces along each side for the comparison of surfaces, common to all grids.
const PIECES: u32 = 160;
/// Duration of observation after a change, s.
const AFTER: f64 = 0.1;
/// Time for a sheet on a box to come to rest, s.
const REST: f64 = 2.0;

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut rows = Vec::new();
    let mut last = None;
    let is_shell = setup.structure == StructureKind::Shell;
    for from in GRIDS {
        let offered = |(shape, _): &(&str, DetailShape)| {
            (is_shell || !SHELL_ALONE.contains(shape)) && (setup.outlined || !OUTLINED_ALONE.contains(shape))
        };
        for (shape, (scene, begin)) in SHAPES.into_iter().filter(offered) {
            let setup = Setup { grid: (from, from), ..setup.clone() };
            let mut runner = begin(&setup, &scene(&setup)?)?;
            let start = runner.world.serialise();
            for to in GRIDS.into_iter().filter(|to| *to != from) {
                runner.world.deserialise(&start)?;
                let mut row = change(&mut runner.world, to)?;
                row["shape"] = json!(shape);
                row["change"] = json!(format!("{from} to {to}"));
                rows.push(row);
            }
            last = Some(runner);
        }
    }
    let largest = |key: &str| rows.iter().filter_map(|r| r[key].as_f64()).fold(0.0, f64::max);
    let keys = json!({
        "largest_pop": largest("pop"),
        "largest_rise": largest("rise"),
        "largest_apart": largest("apart"),
        "changes": rows,
    });
    last.map(|runner| runner.outcome(keys)).ok_or_else(|| InputError::new("case", "has no grids"))
}

/// Scene of a shape, and the motion that leads to the shape.
type DetailShape = (fn(&Setup) -> Result<Scene, InputError>, fn(&Setup, &Scene) -> Result<Runner, InputError>);

const SHAPES: [(&str, DetailShape); 7] = [
    ("droop", (clamped, settled)),
    ("swing", (clamped, falling)),
    ("crease", (creased, settled)),
    ("curl", (curled, settled)),
    ("box", (on_box, dropped)),
    ("tag droops", (tag, settled)),
    ("tag swings", (tag, falling)),
];
const SHELL_ALONE: [&str; 2] = ["crease", "curl"];
const OUTLINED_ALONE: [&str; 2] = ["tag droops", "tag swings"];

/// A clamped sheet.
fn clamped(setup: &Setup) -> Result<Scene, InputError> {
    let mut scene = setup.scene();
    setup.clamp(&mut scene, Region::Left);
    Ok(scene)
}

/// Equilibrium under the weight.
fn settled(setup: &Setup, scene: &Scene) -> Result<Runner, InputError> {
    let mut runner = Runner::new(setup.world(scene)?);
    runner.bring_to_rest(&Setup { dynamic: false, ..setup.clone() });
    Ok(runner)
}

/// A fall from flat, under way.
fn falling(setup: &Setup, scene: &Scene) -> Result<Runner, InputError> {
    let mut runner = Runner::new(setup.world(scene)?);
    runner.run(0.1, |_| true);
    Ok(runner)
}

/// A fall to rest.
fn dropped(setup: &Setup, scene: &Scene) -> Result<Runner, InputError> {
    let mut runner = Runner::new(setup.world_with_sleep(scene)?);
    runner.run(REST, |world| !world.is_resting());
    Ok(runner)
}

/// A clamped sheet with a crease of 60 degrees across its middle.
fn creased(setup: &Setup) -> Result<Scene, InputError> {
    let mut scene = clamped(setup)?;
    scene.sheets[0].creases.push(CreaseSpec { from: (0.5, 0.0), to: (0.5, 1.0), angle: 60.0 });
    Ok(scene)
}

/// A clamped sheet curled upwards to a quarter of a circle.
fn curled(setup: &Setup) -> Result<Scene, InputError> {
    let mut scene = clamped(setup)?;
    scene.sheets[0].curl = (std::f64::consts::FRAC_PI_2 / setup.length, 0.0);
    Ok(scene)
}

/// A tag with a point, clamped along its straight end, with a round hole and a slit from its side.
fn tag(setup: &Setup) -> Result<Scene, InputError> {
    let mut scene = clamped(setup)?;
    let (sheet, l) = (&mut scene.sheets[0], setup.length);
    sheet.size = (l, l);
    let corners = [(-0.5, -0.5), (0.2, -0.5), (0.5, -0.1), (0.5, 0.1), (0.2, 0.5), (-0.5, 0.5)];
    sheet.outline = Some(OutlineSpec::Polygon(corners.map(|(x, z)| (x * l, z * l)).to_vec()));
    sheet.holes = vec![HoleSpec::Disc { centre: (0.15 * l, -0.1 * l), radius: 0.13 * l }];
    sheet.cuts = vec![vec![(0.103 * l, 0.6 * l), (0.103 * l, 0.2 * l)]];
    Ok(scene)
}

/// A sheet above a narrower box.
fn on_box(setup: &Setup) -> Result<Scene, InputError> {
    let mut scene = setup.scene();
    let side = setup.box_side;
    scene.bodies.push(body("box", Shape::Box(DVec3::splat(side)), DVec3::new(0.0, -0.5 * side, 0.0)));
    scene.sheets[0].placement.position.y = setup.contact_offset()? + 1e-3;
    Ok(scene)
}

/// The drawn surface with equal vertices on every grid: the area between the nodes of all rows, and
/// the whole drawn area. The two differ for triangular layers only.
fn surfaces(sheet: &Sheet) -> [Vec<DVec3>; 2] {
    if sheet.model.triangles.is_some() {
        let drawn = of_triangles(sheet);
        return [drawn.clone(), drawn];
    }
    let half = 0.5 / (f64::from(GRIDS[0]) - 0.5);
    [half, 0.5 * half].map(|margin| drawn(sheet, margin))
}

/// The drawn surface; in a triangular layer without `margin` (fraction of the length) at both ends.
fn drawn(sheet: &Sheet, margin: f64) -> Vec<DVec3> {
    let parts = PIECES / (sheet.model.grid.0 - 1);
    let Some(surface) = sheet.surface(0, parts) else { return Vec::new() };
    let mesh = surface.mesh(&sheet.state.x);
    let points: Vec<DVec3> = mesh.positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
    let columns = ((sheet.model.grid.0 - 1) * parts + 1) as usize;
    let alike = columns == PIECES as usize + 1 && points.len() == columns * columns;
    if alike && !sheet.model.structure.info().triangular {
        points
    } else {
        at_common_places(&points, columns, &mesh.uvs, margin)
    }
}

/// Interpolates a surface of `columns` columns with vertices at `uvs` at places common to all
/// grids.
fn at_common_places(points: &[DVec3], columns: usize, uvs: &[[f32; 2]], margin: f64) -> Vec<DVec3> {
    let rows = points.len() / columns;
    let (first, last) = (uvs[0], uvs[points.len() - 1]);
    let cell = |part: f64, axis: usize, count: usize| {
        let (low, high) = (f64::from(first[axis]), f64::from(last[axis]));
        let place = ((part - low) / (high - low)).clamp(0.0, 1.0) * (count - 1) as f64;
        let low = (place.floor() as usize).min(count - 2);
        (low, place - low as f64)
    };
    let part = |k: u32| f64::from(k) / f64::from(PIECES);
    let at = |i: u32, j: u32| {
        let (a, s) = cell(margin + (1.0 - 2.0 * margin) * part(i), 0, columns);
        let (b, t) = cell(part(j), 1, rows);
        let row = |b: usize| points[b * columns + a].lerp(points[b * columns + a + 1], s);
        row(b).lerp(row(b + 1), t)
    };
    (0..=PIECES).flat_map(|j| (0..=PIECES).map(move |i| (i, j))).map(|(i, j)| at(i, j)).collect()
}

/// The drawn triangles at places over their bounding box; NaN outside of all triangles.
fn of_triangles(sheet: &Sheet) -> Vec<DVec3> {
    let drawn = sheet.surface(0, 4).map(|surface| surface.mesh(&sheet.state.x)).unwrap_or_default();
    let places = drawn.uvs.iter().map(|p| p.map(f64::from)).collect();
    let Ok(mesh) = TriangleMesh::new(places, drawn.indices.iter().map(|[a, b, c]| [*a, *c, *b]).collect()) else {
        return Vec::new();
    };
    let locator = PointLocator::new(&mesh);
    let part = |k: u32| f64::from(k) / f64::from(PIECES);
    let at = |i: u32, j: u32| {
        let p = [part(i), part(j)];
        let k = locator.find(p, p);
        let weights = locator.weights(k, p);
        if weights.iter().any(|w| *w < -1e-9) {
            return DVec3::NAN;
        }
        mesh.triangles[k as usize]
            .iter()
            .zip(weights)
            .map(|(v, w)| DVec3::from_array(drawn.positions[*v as usize].map(f64::from)) * w)
            .sum()
    };
    (0..=PIECES).flat_map(|j| (0..=PIECES).map(move |i| (i, j))).map(|(i, j)| at(i, j)).collect()
}

/// Distance between the drawn ends of the sheet and its own ends, m.
fn inset(sheet: &Sheet) -> f64 {
    let triangular = sheet.model.structure.info().triangular;
    if triangular { 0.25 * sheet.rest_size().0 / (f64::from(sheet.model.grid.0) - 0.5) } else { 0.0 }
}

/// Largest distance of points from their best-fit plane, m.
fn deflection(points: &[DVec3]) -> f64 {
    let points: Vec<DVec3> = points.iter().copied().filter(|p| p.is_finite()).collect();
    let centre = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let mut spread = DMat3::ZERO;
    for p in &points {
        let r = *p - centre;
        spread += DMat3::from_cols(r * r.x, r * r.y, r * r.z);
    }
    // Direction of least variance, by power iteration on trace minus covariance.
    let size = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
    let rest = DMat3::from_diagonal(DVec3::splat(size)) - spread;
    let mut normal = DVec3::new(0.3, 1.0, 0.2);
    for _ in 0..200 {
        normal = (rest * normal).normalize_or(DVec3::Y);
    }
    points.iter().map(|p| (*p - centre).dot(normal).abs()).fold(0.0, f64::max)
}

/// Largest distance between two surfaces with equal vertices, m, over the vertices of both.
fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// Changes the first sheet of `world` to a grid of `to` by `to` nodes and measures the effect.
fn change(world: &mut World, to: u32) -> Result<Value, InputError> {
    let gravity = world.gravity();
    let energy = |world: &World| world.sheets()[0].energy(gravity);
    let (before, start) = (surfaces(&world.sheets()[0]), energy(world));
    let name = world.sheets()[0].name.clone();
    let there = world.serialise();
    world.advance(AFTER);
    let [stayed, _] = surfaces(&world.sheets()[0]);
    world.deserialise(&there)?;
    let (structure, size, drawn_from) =
        (world.sheets()[0].model.structure, world.sheets()[0].rest_size(), inset(&world.sheets()[0]));
    let grid = (to, isotropic_rows(structure, to, size).unwrap_or(to));
    let clock = std::time::Instant::now();
    world.remap(&name, grid)?;
    let took = clock.elapsed().as_secs_f64();
    let (after, begun) = (surfaces(&world.sheets()[0]), energy(world));
    let mut highest = begun.total;
    let steps = (AFTER / world.dt()).round() as u32;
    for _ in 0..steps {
        world.step();
        highest = highest.max(energy(world).total);
    }
    let bent = deflection(&before[0]);
    let [later, _] = surfaces(&world.sheets()[0]);
    let own = (start.elastic + start.kinetic).max(f64::MIN_POSITIVE);
    Ok(json!({
        "pop": apart(&before[0], &after[0]) / bent,
        "pop_with_ends": apart(&before[1], &after[1]) / bent,
        "deflection_m": bent,
        "strain_ratio": begun.elastic / start.elastic,
        "motion_ratio": if start.kinetic > 0.0 { begun.kinetic / start.kinetic } else { 1.0 },
        "rise": (highest - begun.total) / own,
        "apart": apart(&stayed, &later) / bent,
        "outline_m": (inset(&world.sheets()[0]) - drawn_from).abs(),
        "change_ms": 1e3 * took,
        "asleep": world.is_resting(),
    }))
}
