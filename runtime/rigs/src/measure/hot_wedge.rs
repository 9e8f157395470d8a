//! A sheet on a hot wedge (thesis 5.2.4, figures 5.8 and 5.9): what happens to it, and when.
//!
//! The ridge of the wedge lies along z and the rows of the sheet along x. The thesis shows
//! photographs; each event is a number of the sheet's shape that passes a threshold of
//! [`WedgeCriteria`]:
//! - bend: angle between the normals of adjoining cells, degrees;
//! - gap: mean distance of the ends of the middle row from the wedge, m;
//! - cover: part of the front face of the wedge that the overhang hides, seen along z;
//! - open cells of the overhang and of the faces, and the temperature of the hottest node of the
//!   overhang, °C.

use glam::DVec3;

use sheetwork::scene::{Polyhedron, Scene, Shape};
use sheetwork::sheet::Sheet;
use sheetwork::{BuildError, InputError, World};

/// Thresholds of the events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WedgeCriteria {
    /// Creases: largest change of a bend of the front overhang since the sheet settled, degrees.
    pub crease: f64,
    /// The sheet is sharper across the ridge: bend over the ridge, as a multiple of that of the
    /// settled sheet.
    pub ridge: f64,
    /// The faces of the sheet warp: gap, as a fraction of that of the settled sheet.
    pub warp: f64,
    /// The warp is pronounced: the same.
    pub warp_more: f64,
    /// The overhang bends over the front, or drapes down it: cover, 0 to 1.
    pub bent: f64,
    /// The overhang crumples: largest bend in it, degrees; 180 folds a cell onto its neighbour.
    pub crumpled: f64,
    /// The overhang encloses the front: cover, 0 to 1.
    pub enclosed: f64,
    /// First signs of melting: temperature of the hottest node of the overhang below `melts_at`, K.
    pub softest: f64,
    /// The hole is wider: open cells of the first hole times this.
    pub wider: f64,
    /// A patch has melted: open cells as a part of those on the faces.
    pub patch: f64,
    /// The face has melted: the same.
    pub face: f64,
    /// Points along each side of the front face at which the cover is sampled.
    pub samples: u32,
    /// Steps between two observations.
    pub stride: u32,
}

impl Default for WedgeCriteria {
    fn default() -> Self {
        Self {
            crease: 0.5,
            ridge: 2.0,
            warp: 0.8,
            warp_more: 0.5,
            bent: 0.25,
            crumpled: 160.0,
            enclosed: 0.75,
            softest: 10.0,
            wider: 2.0,
            patch: 0.5,
            face: 0.9,
            samples: 20,
            stride: 2,
        }
    }
}

/// An event of one of the figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WedgeEvent {
    /// Name of the event.
    pub name: &'static str,
    /// When it happens in the thesis, from and to, s of thermal time.
    pub thesis_s: (f64, f64),
    /// When it happened here, s of thermal time since the heating began; `None` where it did not.
    pub time_s: Option<f64>,
}

impl WedgeEvent {
    /// Whether it happened within the span of the thesis, extended by `part` of its ends.
    pub fn agrees(&self, part: f64) -> bool {
        let (from, to) = self.thesis_s;
        self.time_s.is_some_and(|t| t >= from * (1.0 - part) && t <= to * (1.0 + part))
    }
}

type Reached = fn(&WedgeCriteria, &WedgeShape, &WedgeShape) -> bool;
type Row = (&'static str, (f64, f64), Reached);

/// Events of figure 5.8: styrene of 0.25 mm.
const STYRENE: [Row; 7] = [
    ("the overhang creases", (60.0, 180.0), |c, was, is| is.largest_change(was) >= c.crease),
    ("the sheet is sharper across the ridge", (360.0, 360.0), |c, was, is| is.ridge >= c.ridge * was.ridge),
    ("the faces warp", (570.0, 570.0), |c, was, is| is.gap <= c.warp * was.gap),
    ("the warp is pronounced", (720.0, 900.0), |c, was, is| is.gap <= c.warp_more * was.gap),
    ("the overhang bends over the front", (1200.0, 1200.0), |c, _, is| is.cover >= c.bent),
    ("the overhang crumples", (1320.0, 1320.0), |c, _, is| is.largest_bend() >= c.crumpled),
    ("the overhang encloses the front", (1560.0, 1560.0), |c, _, is| is.cover >= c.enclosed),
];

/// Events of figure 5.9: packaging PVC.
const PVC: [Row; 6] = [
    ("the overhang drapes down the front", (14.0, 14.0), |c, _, is| is.cover >= c.bent),
    ("first signs of melting", (24.0, 44.0), |c, _, is| is.hottest >= is.melts_at - c.softest),
    ("a hole opens across the front", (54.0, 54.0), |_, _, is| is.front_open > 0),
    ("the hole is wider", (64.0, 64.0), |c, _, is| {
        is.first > 0 && f64::from(is.front_open) >= c.wider * f64::from(is.first)
    }),
    ("a patch of the face has melted", (240.0, 240.0), |c, _, is| is.face_open >= c.patch),
    ("the face has melted", (360.0, 360.0), |c, _, is| is.face_open >= c.face),
];

/// Events of figure 5.8 in `scene`: a sheet on a wedge, first of the sheets and of the bodies.
///
/// # Errors
/// When the scene is invalid, or its first body is not a polyhedron in line.
pub fn figure_5_8(scene: &Scene, criteria: &WedgeCriteria) -> Result<Vec<WedgeEvent>, BuildError> {
    events(scene, criteria, &STYRENE)
}

/// Events of figure 5.9 in `scene`, whose sheet has `tearing`.
///
/// # Errors
/// As [`figure_5_8`].
pub fn figure_5_9(scene: &Scene, criteria: &WedgeCriteria) -> Result<Vec<WedgeEvent>, BuildError> {
    events(scene, criteria, &PVC)
}

fn events(scene: &Scene, criteria: &WedgeCriteria, rows: &[Row]) -> Result<Vec<WedgeEvent>, BuildError> {
    let mut world = World::new(scene)?;
    let wedge = Wedge::of(scene, criteria.samples)?;
    let start = heating_start(scene);
    let mut found: Vec<WedgeEvent> =
        rows.iter().map(|(name, thesis_s, _)| WedgeEvent { name, thesis_s: *thesis_s, time_s: None }).collect();
    let mut settled = None;
    let mut first = 0;
    while world.time() < scene.duration {
        (0..criteria.stride.max(1)).for_each(|_| _ = world.step());
        if world.time() < start {
            continue;
        }
        let mut shape = wedge.observe(&world.sheets()[0]);
        if first == 0 {
            first = shape.front_open;
        }
        shape.first = first;
        let was = settled.get_or_insert_with(|| shape.clone());
        let time = (world.time() - start) * scene.time_lapse;
        for (event, (_, _, reached)) in found.iter_mut().zip(rows) {
            if event.time_s.is_none() && reached(criteria, was, &shape) {
                event.time_s = Some(time);
            }
        }
    }
    Ok(found)
}

/// Time at which the temperature of the first body begins to change, s.
fn heating_start(scene: &Scene) -> f64 {
    let Some(keys) = scene.bodies.first().map(|b| &b.temperature_schedule) else { return 0.0 };
    let level = keys.iter().take_while(|key| key.temperature == keys[0].temperature);
    level.last().map_or(0.0, |key| key.time)
}

/// Shape of the sheet at one moment.
#[derive(Clone, Debug, Default)]
pub struct WedgeShape {
    /// Bends of the front overhang, degrees.
    pub bends: Vec<f64>,
    /// Bend over the ridge in the middle of the sheet, degrees.
    pub ridge: f64,
    /// Gap, m.
    pub gap: f64,
    /// Cover, 0 to 1.
    pub cover: f64,
    /// Temperature of the hottest node of the front overhang, °C.
    pub hottest: f64,
    /// Melting temperature of the material, °C; infinite without one.
    pub melts_at: f64,
    /// Number of open cells.
    pub open: u32,
    /// Number of open cells of the front overhang and of the row across its edge.
    pub front_open: u32,
    /// That number when the first of them opened; 0 before.
    pub first: u32,
    /// Open cells on the faces of the wedge as a part of all there, 0 to 1.
    pub face_open: f64,
}

impl WedgeShape {
    /// Largest bend of the front overhang, degrees.
    pub fn largest_bend(&self) -> f64 {
        self.bends.iter().copied().fold(0.0, f64::max)
    }

    /// Largest change of a bend since `was`, degrees.
    pub fn largest_change(&self, was: &Self) -> f64 {
        self.bends.iter().zip(&was.bends).map(|(is, was)| (is - was).abs()).fold(0.0, f64::max)
    }
}

/// The wedge, and the sheet's rows on it.
pub struct Wedge {
    grid: (usize, usize),
    /// Rows whose nodes rest over the wedge at the start: first and last.
    rows: (usize, usize),
    /// A point and the normal of each face.
    planes: Vec<(DVec3, DVec3)>,
    /// Points of the front face.
    samples: Vec<DVec3>,
}

impl Wedge {
    /// Wedge of `scene`, with `samples` points along each side of its front face.
    ///
    /// # Errors
    /// When the first body is not a polyhedron in line, or there is no sheet.
    pub fn of(scene: &Scene, samples: u32) -> Result<Self, InputError> {
        let shape = scene.bodies.first().map(|b| (&b.shape, b.placement.position));
        let (Some((Shape::Polyhedron(body), origin)), Some(sheet)) = (shape, scene.sheets.first()) else {
            return Err(InputError::new("bodies.0.shape", "is not a polyhedron in line under a sheet"));
        };
        let at = |v: &DVec3| *v + origin;
        let (low, high) = body.bounds();
        let (nx, nz) = (sheet.grid.0 as usize, sheet.grid.2 as usize);
        let z = |k: usize| sheet.placement.position.z + sheet.size.1 * (k as f64 / (nz - 1) as f64 - 0.5);
        let over = |k: &usize| z(*k) >= low.z + origin.z - 1e-9 && z(*k) <= high.z + origin.z + 1e-9;
        let rows = ((0..nz).find(over).unwrap_or(0), (0..nz).rfind(over).unwrap_or(nz - 1));
        let planes = (0..body.faces.len()).map(|f| (at(&body.corners(f)[0]), body.face_normal(f))).collect();
        let mut wedge = Self { grid: (nx, nz), rows, planes, samples: Vec::new() };
        wedge.samples = wedge.front_points(body, origin, samples);
        Ok(wedge)
    }

    /// Points of the front face, on a grid over its bounds.
    fn front_points(&self, body: &Polyhedron, origin: DVec3, count: u32) -> Vec<DVec3> {
        let (low, high) = body.bounds();
        let part = |i: u32| (f64::from(i) + 0.5) / f64::from(count);
        let points = (0..count * count).map(|i| {
            let (a, b) = (part(i % count), part(i / count));
            origin + DVec3::new(low.x + a * (high.x - low.x), low.y + b * (high.y - low.y), high.z)
        });
        points.filter(|p| self.distance(*p) < 1e-9).collect()
    }

    /// Distance of `place` from the wedge, m: the largest over the planes of its faces, negative
    /// inside.
    fn distance(&self, place: DVec3) -> f64 {
        self.planes.iter().map(|(point, normal)| normal.dot(place - *point)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Shape of `sheet` now.
    pub fn observe(&self, sheet: &Sheet) -> WedgeShape {
        let (nx, nz) = self.grid;
        let node = |i: usize, k: usize| sheet.state.x.get(k * nx + i);
        let normal = |i: usize, k: usize| {
            (node(i + 1, k + 1) - node(i, k)).cross(node(i + 1, k) - node(i, k + 1)).normalize_or_zero()
        };
        let bend = |a: DVec3, b: DVec3| a.dot(b).clamp(-1.0, 1.0).acos().to_degrees();
        let mut bends = Vec::new();
        for k in self.rows.1..nz - 1 {
            bends.extend((0..nx - 2).map(|i| bend(normal(i, k), normal(i + 1, k))));
            if k + 2 < nz {
                bends.extend((0..nx - 1).map(|i| bend(normal(i, k), normal(i, k + 1))));
            }
        }
        let (column, row) = (nx / 2, nz / 2);
        let ridge = bend(normal(column.saturating_sub(2), row), normal((column + 1).min(nx - 2), row));
        let gap = 0.5 * (self.distance(node(0, row)) + self.distance(node(nx - 1, row)));
        let mut shape = WedgeShape { bends, ridge, gap, cover: self.cover(sheet), ..WedgeShape::default() };
        shape.melts_at = sheet.material().melts_at.unwrap_or(f64::INFINITY);
        let overhang = sheet.temperatures().unwrap_or_default().iter().skip((self.rows.1 + 1) * nx);
        shape.hottest = overhang.copied().fold(f64::NEG_INFINITY, f64::max);
        self.count_open(sheet, &mut shape);
        shape
    }

    /// Part of the front face that closed cells of the front overhang hide, seen along z.
    fn cover(&self, sheet: &Sheet) -> f64 {
        let (nx, nz) = self.grid;
        let node = |i: usize, k: usize| sheet.state.x.get(k * nx + i);
        let open = sheet.open_cells().unwrap_or_default();
        let is_closed = |(i, k): &(usize, usize)| !open.get(k * (nx - 1) + i).copied().unwrap_or(false);
        let mut hidden = vec![false; self.samples.len()];
        let cells = (self.rows.1..nz - 1).flat_map(|k| (0..nx - 1).map(move |i| (i, k)));
        for (i, k) in cells.filter(is_closed) {
            let (a, b, c, d) = (node(i, k), node(i + 1, k), node(i + 1, k + 1), node(i, k + 1));
            for (p, hidden) in self.samples.iter().zip(&mut hidden) {
                *hidden = *hidden || is_under(*p, [a, b, c]) || is_under(*p, [a, c, d]);
            }
        }
        hidden.iter().filter(|h| **h).count() as f64 / hidden.len().max(1) as f64
    }

    fn count_open(&self, sheet: &Sheet, shape: &mut WedgeShape) {
        let columns = self.grid.0 - 1;
        let cells = sheet.open_cells().unwrap_or_default();
        let mut face = (0, 0);
        for (row, cells) in cells.chunks(columns).enumerate() {
            let open = cells.iter().filter(|open| **open).count();
            shape.open += open as u32;
            if row + 1 >= self.rows.1 {
                shape.front_open += open as u32;
            }
            if (self.rows.0..self.rows.1).contains(&row) {
                face = (face.0 + open, face.1 + cells.len());
            }
        }
        shape.face_open = face.0 as f64 / face.1.max(1) as f64;
    }
}

/// Whether `p` lies in the triangle, seen along z.
fn is_under(p: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let side = |u: DVec3, v: DVec3| (v.x - u.x) * (p.y - u.y) - (v.y - u.y) * (p.x - u.x);
    let (s, t, u) = (side(a, b), side(b, c), side(c, a));
    (s >= 0.0 && t >= 0.0 && u >= 0.0) || (s <= 0.0 && t <= 0.0 && u <= 0.0)
}
