//! Offsets of the upper layers of a lattice from its bottom layer, for the transfer to another
//! grid.
//!
//! A node of an upper layer is at x = o + α a + β b + δ n. o is the middle of the cell below it (or
//! the node below it, for layers as large as the bottom one), a = ∂x/∂u and b = ∂x/∂v there (per
//! metre at rest), and n their unit normal out of the upper side, all from node positions (chords,
//! not arcs), as the springs between layers see them. α and β (m) are l g times the shear of the
//! layer, for the l-th layer and the layer distance g (m).
//!
//! Over a triangle the three springs to its corners determine the node (`apex`), and their strains
//! λᵢ = ½ (ℓᵢ²/ℓ₀² - 1) are transferred. Over a square there are four springs, and the height δ (m)
//! of a bent sheet depends on the grid: the corners of a cell lie below its smooth surface, further
//! on a coarse grid. The transferred quantity is therefore the mean strain of the springs to the
//! corners cᵢ, λ = ½ (ℓ²/ℓ₀² - 1) with their mean square length ℓ²:
//!
//!   δ² = ℓ² - m, m = mean of |o + α a + β b - cᵢ|².
//!
//! Over a node, two layers up, these differences cancel, and λ = ½ (δ²/(l g)² - 1). Shear and λ
//! vary slowly for any bend and are interpolated linearly. Their rates follow from the same
//! equations with n' = (1 - n nᵀ)(b × a)'/|b × a|.

use glam::DVec3;

use crate::error::InputError;
use crate::mesh::structure::{LatticeLayer, LatticeSpec, lay_out};
use crate::sheet::Sheet;
use crate::sheet::remap::apex;
use crate::sheet::remap::row_interpolation::RowInterpolation;

/// Layout of a lattice: layers, material coordinates of the nodes, length and width (m) to which
/// they refer, and layer distance (m).
pub(crate) struct LatticeLayout {
    pub layers: Vec<LatticeLayer>,
    pub uv: Vec<(f64, f64)>,
    pub extent: (f64, f64),
    pub gap: f64,
}

/// o (m), a and b of a cell or node, or their rates.
type SurfaceFrame = [DVec3; 3];

/// Shear along u and along v and λ, or three λᵢ, followed by their rates (1/s).
type NodeOffset = [f64; 6];

/// Offsets of every upper node, for each layer from the second on.
pub(crate) struct LayerOffsets {
    layers: Vec<RowInterpolation<6>>,
    width: (f64, f64),
}

impl LatticeLayout {
    /// Layout of `sheet`.
    pub fn from_sheet(sheet: &Sheet) -> Self {
        Self {
            layers: sheet.model.layers.clone(),
            uv: sheet.model.uv.clone(),
            extent: sheet.model.extent,
            gap: sheet.model.gap,
        }
    }

    /// Layout of `sheet` on another grid.
    ///
    /// # Errors
    /// When the structure has no such grid.
    pub fn on_grid(sheet: &Sheet, (nu, nv): (u32, u32)) -> Result<Self, InputError> {
        let (structure, grid) = (sheet.model.structure, (nu, sheet.model.grid.1, nv));
        let spec = LatticeSpec { structure, grid, size: sheet.model.extent, gap: 1.0, cross_over: false };
        let lattice = lay_out(&spec)?;
        let uv = crate::sheet::build::material_coordinates(&lattice);
        Ok(Self { layers: lattice.layers, uv, ..Self::from_sheet(sheet) })
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.uv.len()
    }

    /// Spacing of nodes in a row and of rows, 0 to 1 over the sheet.
    pub fn step(&self) -> (f64, f64) {
        let [columns, rows] = self.layers.first().map_or([2; 2], |l| [l.nx, l.nz]);
        let half = if self.is_triangular() { 0.5 } else { 0.0 };
        (1.0 / (f64::from(columns - 1) + half), 1.0 / f64::from(rows - 1))
    }

    /// Whether odd rows are shifted by half a cell.
    pub fn is_triangular(&self) -> bool {
        self.layers.first().is_some_and(|l| l.triangular)
    }

    /// Larger of the two spacings, along u and along v.
    pub fn wider_step(&self, other: &Self) -> (f64, f64) {
        let (a, b) = (self.step(), other.step());
        (a.0.max(b.0), a.1.max(b.1))
    }

    /// Nodal `values` of the layout `old` at the nodes of this one: weighted mean in each layer
    /// under a hat function as wide as the coarser cell.
    pub fn means(&self, old: &Self, values: &[f64]) -> Vec<f64> {
        let width = self.wider_step(old);
        let mut all = Vec::with_capacity(self.len());
        for (layer, before) in self.layers.iter().zip(&old.layers) {
            let rows = RowInterpolation::new(before.range().map(|i| (old.uv[i], [values[i]])));
            all.extend(layer.range().map(|i| rows.interpolate(self.uv[i], width).map_or(0.0, |[v]| v)));
        }
        all
    }

    /// Nodes around cell (i, j) of the bottom layer, or of the triangle that points to the next row
    /// of a triangular layer, and whether it is a triangle.
    fn corners(&self, i: u32, j: u32) -> ([usize; 4], bool) {
        let bottom = &self.layers[0];
        let at = |i, j| bottom.at(i, j) as usize;
        if bottom.triangular {
            let apex = at(i + j % 2, j + 1);
            return ([at(i, j), at(i + 1, j), apex, apex], true);
        }
        ([at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)], false)
    }

    /// Frame of each cell of the bottom layer at the positions `x` (m). It is linear in `x`, so
    /// that velocities give its rate.
    fn cells(&self, x: &[DVec3]) -> Vec<SurfaceFrame> {
        let step = self.step();
        let (du, dv) = (step.0 * self.extent.0, step.1 * self.extent.1);
        let bottom = &self.layers[0];
        let cell = |i, j| match self.corners(i, j) {
            ([a, b, c, _], true) => [(x[a] + x[b] + x[c]) / 3.0, (x[b] - x[a]) / du, (x[c] - (x[a] + x[b]) * 0.5) / dv],
            ([a, b, c, d], false) => [
                (x[a] + x[b] + x[c] + x[d]) * 0.25,
                (x[b] - x[a] + x[d] - x[c]) * (0.5 / du),
                (x[c] - x[a] + x[d] - x[b]) * (0.5 / dv),
            ],
        };
        let rows = 0..bottom.nz - 1;
        rows.flat_map(|j| (0..bottom.nx - 1).map(move |i| (i, j))).map(|(i, j)| cell(i, j)).collect()
    }

    /// Frame of each node of the bottom layer: mean over the cells around it.
    fn nodes(&self, x: &[DVec3], cells: &[SurfaceFrame]) -> Vec<SurfaceFrame> {
        let bottom = &self.layers[0];
        let mut all: Vec<(SurfaceFrame, f64)> = vec![([DVec3::ZERO; 3], 0.0); bottom.len() as usize];
        let mut add = |node: usize, cell: &SurfaceFrame| {
            let (sum, count) = &mut all[node];
            (sum[1], sum[2], *count) = (sum[1] + cell[1], sum[2] + cell[2], *count + 1.0);
        };
        let columns = bottom.nx - 1;
        for (k, cell) in cells.iter().enumerate() {
            let (i, j) = (k as u32 % columns, k as u32 / columns);
            // Cells of triangular layers also count for all four nodes, so that every corner has a
            // frame.
            let around = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)];
            around.iter().for_each(|(i, j)| add(bottom.at(*i, *j) as usize, cell));
        }
        let mean = |(node, (sum, count)): (usize, &(SurfaceFrame, f64))| [x[node], sum[1] / *count, sum[2] / *count];
        all.iter().enumerate().map(mean).collect()
    }

    /// Unit normal at each node of the bottom layer, out of the upper side.
    pub fn normals(&self, x: &[DVec3]) -> Vec<DVec3> {
        self.nodes(x, &self.cells(x)).iter().map(|[_, a, b]| normal(*a, *b)).collect()
    }

    /// Frame below each upper node, in order.
    fn frames(&self, x: &[DVec3]) -> Vec<SurfaceFrame> {
        let cells = self.cells(x);
        let nodes = if self.layers.len() > 2 { self.nodes(x, &cells) } else { Vec::new() };
        let each = |l: usize| if l % 2 == 1 { cells.clone() } else { nodes.clone() };
        (1..self.layers.len()).flat_map(each).collect()
    }

    /// Corners of the triangle below node `k` of layer `l`; `None` over a square or over a node.
    fn triangle(&self, l: usize, k: usize) -> Option<[usize; 3]> {
        let columns = self.layers[0].nx - 1;
        let three = self.is_triangular() && l % 2 == 1;
        three.then(|| self.corners(k as u32 % columns, k as u32 / columns).0).map(|[a, b, c, _]| [a, b, c])
    }

    /// Squared rest lengths of the springs to the corners of the triangle, m².
    fn squared_rest_lengths(&self, l: usize) -> [f64; 3] {
        let step = self.step();
        let (u, v) = (step.0 * self.extent.0, step.1 * self.extent.1);
        let height = (l as f64 * self.gap).powi(2);
        let beside = 0.25 * u * u + v * v / 9.0 + height;
        [beside, beside, 4.0 * v * v / 9.0 + height]
    }

    /// Upper nodes: layer, index of the frame in its layer, node.
    fn upper_nodes(&self) -> impl Iterator<Item = (usize, usize, usize)> + '_ {
        let layers = self.layers.iter().enumerate().skip(1);
        layers.flat_map(|(l, layer)| layer.range().enumerate().map(move |(k, i)| (l, k, i)))
    }

    /// m (m²) of the node over cell `k` of the bottom layer, and its rate; zero over a node.
    fn mean_square_distance(
        &self,
        (l, k): (usize, usize),
        of: (&SurfaceFrame, &SurfaceFrame),
        own: &NodeOffset,
        x: &[DVec3],
        v: &[DVec3],
    ) -> (f64, f64) {
        if l.is_multiple_of(2) {
            return (0.0, 0.0);
        }
        let columns = self.layers[0].nx - 1;
        let (corners, _) = self.corners(k as u32 % columns, k as u32 / columns);
        let ([o, a, b], [o_rate, a_rate, b_rate]) = of;
        let [alpha, beta, _, alpha_rate, beta_rate, _] = own.map(|s| s * l as f64 * self.gap);
        let at = o + a * alpha + b * beta;
        let rate = o_rate + a_rate * alpha + b_rate * beta + a * alpha_rate + b * beta_rate;
        let part = 0.25;
        corners.iter().fold((0.0, 0.0), |(m, change), c| {
            let (w, w_rate) = (at - x[*c], rate - v[*c]);
            (m + part * w.length_squared(), change + 2.0 * part * w.dot(w_rate))
        })
    }

    /// ℓ₀² of layer `l`, or its squared height at rest, m².
    fn rest(&self, l: usize) -> f64 {
        if l.is_multiple_of(2) {
            return (l as f64 * self.gap).powi(2);
        }
        let step = self.step();
        let (u, v) = (step.0 * self.extent.0, step.1 * self.extent.1);
        0.25 * (u * u + v * v) + (l as f64 * self.gap).powi(2)
    }

    /// Offsets of the upper nodes at the positions `x` (m) and velocities `v` (m/s) of all nodes.
    pub fn offsets(&self, x: &[DVec3], v: &[DVec3]) -> LayerOffsets {
        let (frames, rates) = (self.frames(x), self.frames(v));
        let first = self.layers.first().map_or(0, |l| l.len() as usize);
        let of = |(l, k, i): (usize, usize, usize)| {
            if let Some(corners) = self.triangle(l, k) {
                let (w, rest) = (corners.map(|c| (x[i] - x[c], v[i] - v[c])), self.squared_rest_lengths(l));
                let strain = |c: usize| 0.5 * (w[c].0.length_squared() / rest[c] - 1.0);
                let rate = |c: usize| w[c].0.dot(w[c].1) / rest[c];
                return (l, (self.uv[i], [strain(0), strain(1), strain(2), rate(0), rate(1), rate(2)]));
            }
            let frame = (&frames[i - first], &rates[i - first]);
            let mut own = offset(frame.0, frame.1, x[i], v[i]);
            let (height, rising) = (own[2], own[5]);
            let thick = l as f64 * self.gap;
            [0, 1, 3, 4].into_iter().for_each(|k| own[k] /= thick);
            let (m, change) = self.mean_square_distance((l, k), frame, &own, x, v);
            let rest = self.rest(l);
            own[2] = 0.5 * ((height * height.abs() + m) / rest - 1.0);
            own[5] = (height.abs() * rising + 0.5 * change) / rest;
            (l, (self.uv[i], own))
        };
        let all: Vec<_> = self.upper_nodes().map(of).collect();
        let rows =
            |l: usize| RowInterpolation::new(all.iter().filter(|(layer, _)| *layer == l).map(|(_, point)| *point));
        LayerOffsets { layers: (1..self.layers.len()).map(rows).collect(), width: self.step() }
    }

    /// Offsets of another sheet at the upper nodes of this layout, in order.
    pub fn interpolate(&self, offsets: &LayerOffsets) -> Vec<NodeOffset> {
        let at = |(l, _, i): (usize, usize, usize)| offsets.layers[l - 1].interpolate(self.uv[i], offsets.width);
        self.upper_nodes().map(|upper| at(upper).unwrap_or_default()).collect()
    }

    /// Set the positions of the upper nodes from those of the bottom layer in `x` (m).
    pub fn place_upper_layers(&self, offsets: &[NodeOffset], x: &mut [DVec3]) {
        let frames = self.frames(x);
        for ((l, k, i), (frame, own)) in self.upper_nodes().zip(frames.iter().zip(offsets)) {
            let [o, a, b] = frame;
            if let Some(corners) = self.triangle(l, k) {
                let rest = self.squared_rest_lengths(l);
                let squares = std::array::from_fn(|c| (1.0 + 2.0 * own[c]) * rest[c]);
                x[i] = apex::apex_position(corners.map(|c| x[c]), normal(*a, *b), squares);
                continue;
            }
            let (m, _) = self.mean_square_distance((l, k), (frame, &[DVec3::ZERO; 3]), own, x, x);
            let thick = l as f64 * self.gap;
            x[i] = o + (a * own[0] + b * own[1]) * thick + normal(*a, *b) * self.height(l, own, m);
        }
    }

    /// Height δ (m) for an offset.
    fn height(&self, l: usize, own: &NodeOffset, m: f64) -> f64 {
        let square = (1.0 + 2.0 * own[2]) * self.rest(l) - m;
        square.signum() * square.abs().sqrt()
    }

    /// Set the velocities of the upper nodes from those of the bottom layer in `v` (m/s), at the
    /// positions `x` (m).
    pub fn move_upper_layers(&self, offsets: &[NodeOffset], x: &[DVec3], v: &mut [DVec3]) {
        let (frames, rates) = (self.frames(x), self.frames(v));
        for ((l, k, i), ((frame, rate), own)) in self.upper_nodes().zip(frames.iter().zip(&rates).zip(offsets)) {
            if let Some(corners) = self.triangle(l, k) {
                let rest = self.squared_rest_lengths(l);
                let rates = std::array::from_fn(|c| own[3 + c] * rest[c]);
                v[i] = apex::apex_velocity(x[i], corners.map(|c| x[c]), corners.map(|c| v[c]), rates);
                continue;
            }
            let (m, change) = self.mean_square_distance((l, k), (frame, rate), own, x, v);
            let [_, a, b] = frame;
            let height = self.height(l, own, m);
            // δ δ' = ½ (ℓ²)' - ½ m'. The bound excludes a division by zero for a layer pressed
            // flat.
            let least = 1e-3 * self.gap;
            let rising = (own[5] * self.rest(l) - 0.5 * change) / height.abs().max(least);
            let thick = l as f64 * self.gap;
            let still = [own[0] * thick, own[1] * thick, height, 0.0, 0.0, 0.0];
            v[i] = frame_velocity(frame, rate, &still) + (a * own[3] + b * own[4]) * thick + normal(*a, *b) * rising;
        }
    }
}

/// Unit normal n out of the upper side, with u to the right and v towards the viewer.
fn normal(a: DVec3, b: DVec3) -> DVec3 {
    b.cross(a).normalize_or(DVec3::Y)
}

/// Velocity of a point at rest in a moving frame.
fn frame_velocity(
    [_, a, b]: &SurfaceFrame,
    [o_rate, a_rate, b_rate]: &SurfaceFrame,
    [alpha, beta, delta, ..]: &[f64; 6],
) -> DVec3 {
    let (n, area) = (normal(*a, *b), b.cross(*a));
    let change = b_rate.cross(*a) + b.cross(*a_rate);
    let turn = (change - n * n.dot(change)) / area.length().max(f64::MIN_POSITIVE);
    o_rate + a_rate * *alpha + b_rate * *beta + turn * *delta
}

/// Components of a vector along a, b and n.
fn frame_components([_, a, b]: &SurfaceFrame, w: DVec3) -> [f64; 3] {
    let (aa, ab, bb) = (a.dot(*a), a.dot(*b), b.dot(*b));
    let (p, q, size) = (a.dot(w), b.dot(w), aa * bb - ab * ab);
    let height = normal(*a, *b).dot(w);
    if size > 0.0 { [(p * bb - q * ab) / size, (q * aa - p * ab) / size, height] } else { [0.0, 0.0, height] }
}

/// α, β, δ (m) and their rates (m/s).
fn offset(frame: &SurfaceFrame, rate: &SurfaceFrame, x: DVec3, v: DVec3) -> [f64; 6] {
    let [alpha, beta, delta] = frame_components(frame, x - frame[0]);
    let still = [alpha, beta, delta, 0.0, 0.0, 0.0];
    let [p, q, r] = frame_components(frame, v - frame_velocity(frame, rate, &still));
    [alpha, beta, delta, p, q, r]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, SheetSpec};

    fn sheet(structure: &str, grid: (u32, u32, u32)) -> Sheet {
        let structure = structure.parse().expect("known");
        let spec = SheetSpec { structure, grid, size: (0.25, 0.2), gap: 0.004, ..SheetSpec::thesis() };
        Sheet::build(&Scene { sheets: vec![spec], ..Scene::thesis() }, 0).expect("valid")
    }

    #[test]
    fn offsets_restore_positions_and_velocities_on_the_same_grid() {
        for structure in ["trimm", "slamm", "samm"] {
            let sheet = sheet(structure, (7, 3, 6));
            let layout = LatticeLayout::from_sheet(&sheet);
            let other = LatticeLayout::on_grid(&sheet, (7, 6)).expect("a grid");
            assert!(
                layout.layers == other.layers
                    && layout
                        .uv
                        .iter()
                        .zip(&other.uv)
                        .all(|(a, b)| { (a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-12 })
            );
            let wave = |p: DVec3| p + DVec3::new(0.002 * p.z, 0.03 * (6.0 * p.x + 2.0 * p.z).sin(), 0.01 * p.x);
            let x: Vec<DVec3> = sheet.state.x.iter().map(wave).collect();
            let v: Vec<DVec3> = x.iter().map(|p| DVec3::new(p.y, 3.0 * p.x * p.x, p.z * p.x)).collect();
            let own = layout.interpolate(&layout.offsets(&x, &v));
            let bottom = layout.layers[0].len() as usize;
            let (mut y, mut w) = (x.clone(), v.clone());
            y[bottom..].fill(DVec3::ZERO);
            w[bottom..].fill(DVec3::ZERO);
            layout.place_upper_layers(&own, &mut y);
            layout.move_upper_layers(&own, &y, &mut w);
            for i in 0..x.len() {
                assert!(x[i].distance(y[i]) < 1e-12 && v[i].distance(w[i]) < 1e-11, "{structure} {i}");
            }
        }
    }

    #[test]
    fn velocities_of_upper_layers_equal_differences_of_positions() {
        // The velocities must equal central differences of the positions.
        let sheet = sheet("trimm", (6, 2, 6));
        let layout = LatticeLayout::from_sheet(&sheet);
        let x: Vec<DVec3> = sheet.state.x.iter().map(|p| p + DVec3::Y * (4.0 * p.x).sin() * 0.05).collect();
        let v: Vec<DVec3> = x.iter().map(|p| DVec3::new(0.2 * p.y, (9.0 * p.x).cos(), p.z)).collect();
        let own = layout.interpolate(&layout.offsets(&x, &vec![DVec3::ZERO; x.len()]));
        let at = |h: f64| {
            let mut moved: Vec<DVec3> = x.iter().zip(&v).map(|(x, v)| x + v * h).collect();
            layout.place_upper_layers(&own, &mut moved);
            moved
        };
        let mut w = v.clone();
        layout.move_upper_layers(&own, &x, &mut w);
        let h = 1e-6;
        for ((after, before), w) in at(h).iter().zip(&at(-h)).zip(&w) {
            assert!(((after - before) / (2.0 * h)).distance(*w) < 1e-7, "{w}");
        }
    }
}
