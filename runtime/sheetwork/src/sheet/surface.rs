//! Drawing surface of a sheet as triangles: one layer, flat between its nodes or smoothed.
//!
//! The interpolating surface of a grid is a tensor product of Catmull-Rom splines, which passes
//! through every node. Between nodes a smooth surface can still dip below a sharp edge. The rows of
//! a triangular layer are shifted by half a cell in turn; splines along the rows bring them to
//! common columns first, which makes the drawn outline straight. A layer that is closed to a tube
//! is always drawn through its nodes. Triangles of a mesh are subdivided (`smooth_surface`).
//!
//! The surfaces of the thesis have the nodes as control points (`b_spline`): they cut corners, so
//! that they sink into bodies and even out ragged edges.
//!
//! Every drawn vertex is a fixed combination of nodes. An update is a sparse product and does not
//! allocate.

use glam::Vec3;

use crate::math::Vectors;
use crate::mesh::outline::TriangleMesh;
use crate::mesh::structure::LatticeLayer;
use crate::sheet::Sheet;
use crate::sheet::b_spline::clamped_b_spline;
use crate::sheet::smooth_surface::{NodeWeights, halve};

/// Triangles to draw, in single precision.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMesh {
    /// Vertex positions, m.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, out of the upper side.
    pub normals: Vec<[f32; 3]>,
    /// Material coordinates, 0 to 1 along length and width.
    pub uvs: Vec<[f32; 2]>,
    /// Triangles, counter-clockwise seen from the upper side.
    pub indices: Vec<[u32; 3]>,
}

/// Topology and vertex weights of the drawing surface of a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawingSurface {
    /// First entry of each vertex in `masses` and `weights`, and the end.
    first: Vec<u32>,
    masses: Vec<u32>,
    weights: Vec<f32>,
    uvs: Vec<[f32; 2]>,
    indices: Vec<[u32; 3]>,
}

/// Smoothing of a drawing surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SurfaceSmoothing {
    /// Splines through the nodes.
    #[default]
    Interpolating,
    /// Uniform cubic B-splines, clamped at the edges, with the nodes as control points: NURBS with
    /// weights of 1.
    BSpline,
    /// One piece of the highest degree in each direction, a Bézier surface: the thesis's 2 n knots
    /// for n nodes. The degree is limited to 23, the highest of the OpenGL utility library that it
    /// used.
    Bezier,
}

impl SurfaceSmoothing {
    /// All kinds, with their names in listings and on command lines.
    pub const ALL: [(Self, &'static str); 3] =
        [(Self::Interpolating, "interpolating"), (Self::BSpline, "b-spline"), (Self::Bezier, "bezier")];

    /// Degree of a B-spline; `None` for the interpolating surface.
    fn degree(self) -> Option<u32> {
        match self {
            Self::Interpolating => None,
            Self::BSpline => Some(3),
            Self::Bezier => Some(23),
        }
    }
}

/// Columns and rows of nodes, ascending, along which a sheet is creased from edge to edge.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CreaseLines {
    /// Columns, counted along the length.
    pub columns: Vec<u32>,
    /// Rows, counted along the width.
    pub rows: Vec<u32>,
}

impl DrawingSurface {
    /// Surface of a triangle mesh: flat for `parts` of 1, subdivided once from 2 on and twice from
    /// 4 on (see `smooth_surface`); `uv` are the material coordinates of the sheet.
    pub fn from_mesh(mesh: &TriangleMesh, uv: &[(f64, f64)], parts: u32) -> Self {
        let mut vertices: Vec<NodeWeights> = (0..uv.len() as u32).map(|i| vec![(i, 1.0)]).collect();
        let mut drawn = std::borrow::Cow::Borrowed(mesh);
        for _ in 0..parts.max(1).ilog2().min(2) {
            let Some((finer, more)) = halve(&drawn, &vertices) else { break };
            (drawn, vertices) = (std::borrow::Cow::Owned(finer), more);
        }
        let mut surface = Self::from_combinations(vertices, uv);
        // Counter-clockwise in (u, v) is clockwise seen from above.
        surface.indices = drawn.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        surface
    }

    /// Surface of `layer` with `parts` spline segments between neighbouring nodes (clamped to 1 to
    /// 16); 1 draws flat triangles between the nodes. `uv` are the material coordinates of the
    /// sheet.
    pub fn new(layer: &LatticeLayer, uv: &[(f64, f64)], parts: u32) -> Self {
        Self::smoothed(layer, uv, parts, &CreaseLines::default(), SurfaceSmoothing::Interpolating)
    }

    /// Surface of layer `index` of a sheet, as [`Sheet::surface`], with a choice of smoothing. A
    /// triangle mesh is subdivided through its nodes in any case.
    pub fn of_sheet(sheet: &Sheet, index: usize, parts: u32, smoothing: SurfaceSmoothing) -> Option<Self> {
        let uv = &sheet.model.uv;
        if sheet.open_cell_set().is_some() {
            let layer = sheet.model.layers.get(index)?;
            let mut surface = Self::new(layer, uv, 1);
            let closed = sheet.cells().layer_triangles(index);
            surface.indices = closed.into_iter().map(|t| t.map(|i| i - layer.first)).collect();
            return Some(surface);
        }
        match &sheet.model.meshes.present {
            Some(mesh) => (index == 0).then(|| Self::from_mesh(mesh, uv, parts)),
            None => {
                let layer = sheet.model.layers.get(index)?;
                Some(Self::smoothed(layer, uv, parts, &sheet.model.folds, smoothing))
            }
        }
    }

    /// Surface of `layer` as [`DrawingSurface::new`], smoothed as chosen, with splines that end on
    /// both sides of `folds`, so that a crease is equally sharp on every grid.
    fn smoothed(
        layer: &LatticeLayer,
        uv: &[(f64, f64)],
        parts: u32,
        folds: &CreaseLines,
        smoothing: SurfaceSmoothing,
    ) -> Self {
        let parts = parts.clamp(1, 16);
        if parts == 1 || layer.nx < 2 || layer.nz < 2 {
            return Self::flat(layer, uv);
        }
        let strips = if layer.tubular { layer.nz } else { layer.nz - 1 };
        let (columns, rows) = ((layer.nx - 1) * parts + 1, strips * parts + 1);
        let place = |k: u32| f64::from(k) / f64::from(parts);
        let mut vertices = Vec::new();
        for r in 0..rows {
            for c in 0..columns {
                vertices.push(match smoothing.degree() {
                    _ if layer.tubular => around_tube(layer, (place(c), place(r))),
                    Some(degree) => control_weights(layer, (place(c), place(r)), folds, degree),
                    None => through_nodes(layer, (place(c), place(r)), folds),
                });
            }
        }
        let mut surface = Self::from_combinations(vertices, uv);
        let grid = LatticeLayer { first: 0, nx: columns, nz: rows, triangular: false, tubular: false };
        surface.indices = grid.triangles();
        surface
    }

    fn flat(layer: &LatticeLayer, uv: &[(f64, f64)]) -> Self {
        let vertices = layer.range().map(|i| vec![(i as u32, 1.0)]).collect();
        let mut surface = Self::from_combinations(vertices, uv);
        surface.indices = layer.triangles().into_iter().map(|t| t.map(|i| i - layer.first)).collect();
        surface
    }

    fn from_combinations(vertices: Vec<NodeWeights>, uv: &[(f64, f64)]) -> Self {
        let mut surface = Self { first: vec![0], masses: vec![], weights: vec![], uvs: vec![], indices: vec![] };
        for combination in vertices {
            let (mut u, mut v) = (0.0, 0.0);
            for (i, w) in combination {
                surface.masses.push(i);
                surface.weights.push(w as f32);
                u += w * uv[i as usize].0;
                v += w * uv[i as usize].1;
            }
            surface.uvs.push([u as f32, v as f32]);
            surface.first.push(surface.masses.len() as u32);
        }
        surface
    }

    /// Triangle mesh at the positions `x` (m).
    pub fn mesh(&self, x: &Vectors) -> SurfaceMesh {
        let n = self.uvs.len();
        let mut mesh = SurfaceMesh {
            positions: vec![[0.0; 3]; n],
            normals: vec![[0.0; 3]; n],
            uvs: self.uvs.clone(),
            indices: self.indices.clone(),
        };
        self.update(x, x, 1.0, &mut mesh.positions, &mut mesh.normals);
        mesh
    }

    /// Nodes of a vertex with their weights.
    pub(crate) fn terms(&self, vertex: usize) -> impl Iterator<Item = (u32, f64)> {
        let range = self.first[vertex] as usize..self.first[vertex + 1] as usize;
        self.masses[range.clone()].iter().copied().zip(self.weights[range].iter().map(|w| f64::from(*w)))
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.uvs.len()
    }

    /// Whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.uvs.is_empty()
    }

    /// Interpolate `values`, one per node, at the vertices, with the weights of positions and
    /// clamped to the range of the nodes used.
    ///
    /// A shorter `out` than [`DrawingSurface::len`] is filled as far as it goes.
    pub fn interpolate(&self, values: &[f64], out: &mut [f32]) {
        for (vertex, out) in out.iter_mut().enumerate().take(self.len()) {
            let (mut sum, mut low, mut high) = (0.0, f32::INFINITY, f32::NEG_INFINITY);
            for k in self.first[vertex] as usize..self.first[vertex + 1] as usize {
                let value = values.get(self.masses[k] as usize).map_or(0.0, |v| *v as f32);
                sum += value * self.weights[k];
                (low, high) = (low.min(value), high.max(value));
            }
            *out = sum.max(low).min(high);
        }
    }

    /// Write positions (m) and unit normals at a time between two steps: `before` at s = 0, `after`
    /// at s = 1.
    ///
    /// Both slices must be [`DrawingSurface::len`] long; a shorter one is filled as far as it goes.
    pub fn update(
        &self,
        before: &Vectors,
        after: &Vectors,
        s: f32,
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
    ) {
        for (vertex, out) in positions.iter_mut().enumerate().take(self.len()) {
            let mut sum = Vec3::ZERO;
            for k in self.first[vertex] as usize..self.first[vertex + 1] as usize {
                let i = self.masses[k] as usize;
                let (a, b) = (before.get(i).as_vec3(), after.get(i).as_vec3());
                sum += a.lerp(b, s) * self.weights[k];
            }
            *out = sum.to_array();
        }
        normals.fill([0.0; 3]);
        for [a, b, c] in self.indices.iter().map(|t| t.map(|i| i as usize)) {
            let [p, q, r] = [a, b, c].map(|i| positions.get(i).map_or(Vec3::ZERO, |p| Vec3::from(*p)));
            // The cross product weights the normal by area.
            let normal = (q - p).cross(r - p);
            for i in [a, b, c] {
                if let Some(n) = normals.get_mut(i) {
                    *n = (Vec3::from(*n) + normal).to_array();
                }
            }
        }
        for n in normals {
            *n = Vec3::from(*n).normalize_or(Vec3::Y).to_array();
        }
    }
}

/// Weights at column `u` and row `v` of the surface through the nodes.
fn through_nodes(layer: &LatticeLayer, (u, v): (f64, f64), folds: &CreaseLines) -> NodeWeights {
    let middle = if layer.triangular { 0.25 } else { 0.0 };
    let mut sum = NodeWeights::new();
    for (j, wz) in catmull_rom(v, layer.nz, &folds.rows) {
        let stagger = if layer.triangular && j % 2 == 1 { 0.5 } else { 0.0 };
        for (i, wx) in catmull_rom(u + middle - stagger, layer.nx, &folds.columns) {
            sum.push((layer.at(i, j), wx * wz));
        }
    }
    sum
}

/// Weights at column `u` and row `v`, 0 to the number of rows, of the surface through the nodes of
/// a tube. The row of nodes is continued beyond its ends by those at the other end.
fn around_tube(layer: &LatticeLayer, (u, v): (f64, f64)) -> NodeWeights {
    let columns = catmull_rom(u, layer.nx, &[]);
    let around = catmull_rom(v + 1.0, layer.nz + 3, &[]).into_iter().map(|(j, w)| ((j + layer.nz - 1) % layer.nz, w));
    around.flat_map(|(j, wz)| columns.iter().map(move |(i, wx)| (layer.at(*i, j), wx * wz))).collect()
}

/// Weights at column `u` and row `v` of the surface with the nodes as control points.
fn control_weights(layer: &LatticeLayer, (u, v): (f64, f64), folds: &CreaseLines, degree: u32) -> NodeWeights {
    let along = |place: f64, n: u32, folds: &[u32]| {
        let inner = || folds.iter().copied().filter(|f| (1..n - 1).contains(f));
        let first = inner().filter(|f| f64::from(*f) <= place).max().unwrap_or(0);
        let last = inner().filter(|f| f64::from(*f) > place).min().unwrap_or(n - 1);
        clamped_b_spline((place - f64::from(first)) / f64::from(last - first), first, last, degree)
    };
    let columns = along(u, layer.nx, &folds.columns);
    let rows = along(v, layer.nz, &folds.rows);
    rows.iter().flat_map(|(j, wz)| columns.iter().map(move |(i, wx)| (layer.at(*i, *j), wx * wz))).collect()
}

/// Catmull-Rom weights at parameter `u` of a row of `n` points at 0, 1, 2, ...; beyond the ends the
/// row continues in a straight line. The row ends on both sides of each of `folds`.
fn catmull_rom(u: f64, n: u32, folds: &[u32]) -> NodeWeights {
    let last = n as i64 - 1;
    let piece = (u.floor() as i64).clamp(0, last - 1);
    let within = || folds.iter().map(|f| i64::from(*f));
    let first = within().filter(|f| *f <= piece).max().unwrap_or(0);
    let last = within().filter(|f| *f > piece && *f < last).min().unwrap_or(last);
    let t = u - piece as f64;
    let (t2, t3) = (t * t, t * t * t);
    let basis = if (0.0..=1.0).contains(&t) {
        [
            0.5 * (-t3 + 2.0 * t2 - t),
            0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
            0.5 * (-3.0 * t3 + 4.0 * t2 + t),
            0.5 * (t3 - t2),
        ]
    } else {
        [0.0, 1.0 - t, t, 0.0]
    };
    let mut weights = NodeWeights::new();
    let mut add = |i: i64, w: f64| {
        if w != 0.0 {
            match weights.iter_mut().find(|(j, _)| *j == i as u32) {
                Some((_, sum)) => *sum += w,
                None => weights.push((i as u32, w)),
            }
        }
    };
    for (k, w) in basis.into_iter().enumerate() {
        let i = piece - 1 + k as i64;
        // The phantom point beyond an end continues the parabola through the last three points, 3
        // p₀ - 3 p₁ + p₂, or the line through the last two. A sheet bent up to its edge is
        // therefore drawn equally on every grid.
        let (end, inward) = if i < first { (first, 1) } else { (last, -1) };
        if (first..=last).contains(&i) {
            add(i, w);
        } else if last - first >= 2 {
            add(end, 3.0 * w);
            add(end + inward, -3.0 * w);
            add(end + 2 * inward, w);
        } else {
            add(end, 2.0 * w);
            add(end + inward, -w);
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, SheetSpec};

    fn sheet(structure: &str) -> Sheet {
        let spec = SheetSpec {
            structure: structure.parse().expect("known"),
            grid: (6, 1, 5),
            size: (0.5, 0.4),
            ..SheetSpec::thesis()
        };
        Sheet::build(&Scene { sheets: vec![spec], ..Scene::thesis() }, 0).expect("valid")
    }

    #[test]
    fn a_flat_sheet_is_drawn_flat_inside_its_outline_with_normals_up() {
        for structure in ["samm", "trimm"] {
            let sheet = sheet(structure);
            for parts in [1, 4] {
                let mesh = DrawingSurface::new(&sheet.model.layers[0], &sheet.model.uv, parts).mesh(&sheet.state.x);
                for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
                    assert!(p[1].abs() < 1e-7 && p[0].abs() < 0.2501 && p[2].abs() < 0.2001, "{structure} {p:?}");
                    assert!((n[1] - 1.0).abs() < 1e-5, "{structure} {n:?}");
                }
            }
        }
    }

    #[test]
    fn values_are_interpolated_like_positions_without_overshoot() {
        for structure in ["samm", "trimm"] {
            let sheet = sheet(structure);
            let surface = DrawingSurface::new(&sheet.model.layers[0], &sheet.model.uv, 4);
            let mut seen = vec![0.0; surface.len()];
            let along: Vec<f64> = sheet.state.x.iter().map(|p| p.x).collect();
            surface.interpolate(&along, &mut seen);
            let drawn = surface.mesh(&sheet.state.x).positions;
            // Shifted rows are drawn beyond their ends, where positions are extrapolated linearly
            // and values are clamped.
            let inside = |p: &[f32; 3]| structure == "samm" || p[0].abs() < 0.15;
            let off = drawn.iter().zip(&seen).filter(|(p, _)| inside(p)).map(|(p, v)| (p[0] - v).abs());
            assert!(off.fold(0.0, f32::max) < 1e-6, "{structure}");
            let step: Vec<f64> = along.iter().map(|x| if *x < 0.0 { 20.0 } else { 100.0 }).collect();
            surface.interpolate(&step, &mut seen);
            assert!(seen.iter().all(|v| (20.0..=100.0).contains(v)), "{structure}");
        }
    }

    #[test]
    fn the_smooth_surface_passes_through_every_node_of_a_square_layer() {
        let mut sheet = sheet("samm");
        for i in 0..sheet.node_count() {
            let mut p = sheet.state.x.get(i);
            p.y = (7.0 * p.x).sin() * (5.0 * p.z).cos();
            sheet.state.x.set(i, p);
        }
        let mesh = DrawingSurface::new(&sheet.model.layers[0], &sheet.model.uv, 3).mesh(&sheet.state.x);
        for p in sheet.state.x.iter() {
            let near = |q: &[f32; 3]| Vec3::from(*q).distance(p.as_vec3()) < 1e-6;
            assert!(mesh.positions.iter().any(near), "no drawn vertex at {p}");
        }
    }

    /// Surface of a square layer of 12 by 12 nodes 10 cm apart whose heights are `f` (m).
    fn over(f: impl Fn(f64, f64) -> f64, smoothing: SurfaceSmoothing) -> Vec<[f64; 3]> {
        let spec = SheetSpec {
            structure: "samm".parse().expect("known"),
            grid: (12, 1, 12),
            size: (1.1, 1.1),
            ..SheetSpec::thesis()
        };
        let mut sheet = Sheet::build(&Scene { sheets: vec![spec], ..Scene::thesis() }, 0).expect("valid");
        for i in 0..sheet.node_count() {
            let mut p = sheet.state.x.get(i);
            p.y = f(p.x, p.z);
            sheet.state.x.set(i, p);
        }
        let surface = DrawingSurface::of_sheet(&sheet, 0, 4, smoothing).expect("a layer");
        surface.mesh(&sheet.state.x).positions.iter().map(|p| p.map(f64::from)).collect()
    }

    #[test]
    fn a_plane_is_exact_and_a_b_spline_lies_a_sixth_of_the_second_difference_inside_a_paraboloid() {
        use SurfaceSmoothing::{BSpline, Bezier, Interpolating};
        for smoothing in [Interpolating, BSpline, Bezier] {
            let off = over(|x, z| 0.3 * x - 0.2 * z, smoothing);
            let worst = off.iter().map(|[x, y, z]| (y - 0.3 * x + 0.2 * z).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-6, "{smoothing:?}: {worst}");
        }
        // y = ½ (κ₁ x² + κ₂ z²): second differences h² κ along rows and columns, so that
        // the surface lies h²/6 (κ₁ + κ₂) above; not so within three cells of the edges,
        // where the knots are not uniform.
        let (h, k1, k2) = (0.1, 0.8, 0.3);
        let paraboloid = |x: f64, z: f64| 0.5 * (k1 * x * x + k2 * z * z);
        let inner = |p: &&[f64; 3]| p[0].abs() < 0.2 && p[2].abs() < 0.2;
        let spline = over(paraboloid, BSpline);
        assert!(spline.iter().filter(inner).count() > 100);
        for [x, y, z] in spline.iter().filter(inner) {
            let rise = y - paraboloid(*x, *z);
            assert!((rise / (h * h / 6.0 * (k1 + k2)) - 1.0).abs() < 2e-4, "{rise}");
        }
        for [x, y, z] in over(paraboloid, Interpolating).iter().filter(inner) {
            assert!((y - paraboloid(*x, *z)).abs() < 1e-6);
        }
    }

    #[test]
    fn b_splines_end_at_the_corners_and_even_out_the_zigzag_of_a_triangular_layer() {
        let sheet = sheet("trimm");
        let layer = &sheet.model.layers[0];
        let drawn = |smoothing, parts| {
            let surface = DrawingSurface::of_sheet(&sheet, 0, parts, smoothing).expect("a layer");
            surface.mesh(&sheet.state.x).positions
        };
        let smooth = drawn(SurfaceSmoothing::BSpline, 4);
        let corner = sheet.state.x.get(layer.at(0, 0) as usize).as_vec3();
        assert!(smooth.iter().any(|p| Vec3::from(*p).distance(corner) < 1e-6));
        // Left edge of the sheet: the nodes of its rows are half a cell apart in turn.
        let left = |places: &[[f32; 3]], columns: usize| {
            let edge: Vec<f32> = places.iter().step_by(columns).map(|p| p[0]).collect();
            let inner = &edge[edge.len() / 4..3 * edge.len() / 4 + 1];
            inner.iter().copied().fold(f32::MIN, f32::max) - inner.iter().copied().fold(f32::MAX, f32::min)
        };
        let flat: Vec<[f32; 3]> = layer.range().map(|i| sheet.state.x.get(i).as_vec3().to_array()).collect();
        let (before, after) = (left(&flat, 6), left(&smooth, 21));
        assert!(before > 0.04 && after < 0.5 * before, "{before} {after}");
    }
}
