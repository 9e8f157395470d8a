//! Surface of a sheet for queries: triangles in blocks with bounding boxes.

use std::sync::OnceLock;

use glam::DVec3;

use crate::collision::bvh::BoundingBox;
use crate::mesh::structure::LatticeLayer;
use crate::sheet::{Sheet, Vectors};
use crate::world::ids::SheetId;
use crate::world::query::settings::QuerySettings;
use crate::world::query::{InterpolatedNodes, QueryLayer, SurfaceArea, SurfacePoint};

const SETTINGS: QuerySettings = QuerySettings::DEFAULT;

/// Surface of a layer of a sheet.
pub(super) struct QuerySurface<'w> {
    pub id: SheetId,
    sheet: &'w Sheet,
    layer: LatticeLayer,
    index: usize,
    nodes: InterpolatedNodes<'w>,
    bounds: BoundingBox,
    blocks: OnceLock<TriangleBlocks>,
}

/// Triangles of closed cells, and boxes of each 32 of them in turn.
struct TriangleBlocks {
    triangles: Vec<[u32; 3]>,
    bounds: Vec<BoundingBox>,
    /// Lowest and highest material coordinates.
    uv: Vec<[(f64, f64); 2]>,
}

impl<'w> QuerySurface<'w> {
    /// Surface of a layer at its state, or at `nodes` if there is one per node.
    pub fn new(
        (id, sheet): (SheetId, &'w Sheet),
        layer: QueryLayer,
        nodes: Option<InterpolatedNodes<'w>>,
    ) -> Option<Self> {
        let last = sheet.model.layers.len().checked_sub(1)?;
        let index = if layer == QueryLayer::Upper { last } else { 0 };
        let count = sheet.node_count();
        let fits = |n: &InterpolatedNodes| n.0.len() == count && n.1.len() == count && n.2.is_finite();
        let nodes = nodes.filter(fits).unwrap_or((&sheet.state.x, &sheet.state.x, 1.0));
        let bounds = |x: &Vectors| BoundingBox::from_positions(x);
        let bounds = if nodes.2 == 1.0 { bounds(nodes.1) } else { bounds(nodes.0).joined(&bounds(nodes.1)) };
        let layer = sheet.model.layers[index];
        Some(Self { id, sheet, layer, index, nodes, bounds: widened(bounds), blocks: OnceLock::new() })
    }

    /// Bounding box of the nodes.
    pub fn bounds(&self) -> &BoundingBox {
        &self.bounds
    }

    /// Position of node `i`, m.
    pub fn position(&self, i: u32) -> DVec3 {
        let (before, after, s) = self.nodes;
        let end = after.get(i as usize);
        if s == 1.0 { end } else { before.get(i as usize).lerp(end, f64::from(s)) }
    }

    /// Positions of the corners of a triangle, m.
    pub fn corners(&self, nodes: [u32; 3]) -> [DVec3; 3] {
        nodes.map(|i| self.position(i))
    }

    /// Nodes of the layer that are not detached, ascending.
    pub fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        let count = self.sheet.node_count() as u32;
        let range = if self.sheet.model.triangles.is_some() {
            0..count
        } else {
            self.layer.first..(self.layer.first + self.layer.len()).min(count)
        };
        range.filter(|i| !self.sheet.is_detached(*i as usize))
    }

    /// Triangles of closed cells.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.blocks().triangles
    }

    fn blocks(&self) -> &TriangleBlocks {
        self.blocks.get_or_init(|| {
            let triangles = self.sheet.cells().layer_triangles(self.index);
            let corners = |block: &[[u32; 3]]| {
                let all = block.iter().flatten().map(|i| self.position(*i));
                let join = |b: BoundingBox, p: DVec3| BoundingBox { low: b.low.min(p), high: b.high.max(p) };
                widened(all.fold(BoundingBox::default(), join))
            };
            let bounds = triangles.chunks(SETTINGS.block).map(corners).collect();
            let uv = triangles.chunks(SETTINGS.block).map(|block| self.uv_range(block)).collect();
            TriangleBlocks { triangles, bounds, uv }
        })
    }

    fn uv_range(&self, block: &[[u32; 3]]) -> [(f64, f64); 2] {
        let all = block.iter().flat_map(|nodes| self.uv_of(*nodes));
        let none = [(f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY)];
        all.fold(none, |[low, high], p| [(low.0.min(p.0), low.1.min(p.1)), (high.0.max(p.0), high.1.max(p.1))])
    }

    /// Material coordinates of the corners of a triangle. On the seam of a tube those of the first
    /// row continue those of the last row, beyond 1.
    fn uv_of(&self, nodes: [u32; 3]) -> [(f64, f64); 3] {
        let mut uv = nodes.map(|i| self.sheet.model.uv[i as usize]);
        let is_seam = self.layer.tubular && self.layer.nz > 2 && {
            let (low, high) = uv.iter().fold((1.0_f64, 0.0_f64), |(low, high), p| (low.min(p.1), high.max(p.1)));
            high - low > 0.75
        };
        if is_seam {
            let rows = f64::from(self.layer.nz);
            uv.iter_mut().filter(|p| p.1 < 0.5).for_each(|p| p.1 += rows / (rows - 1.0));
        }
        uv
    }

    /// Call `visit` with each triangle in blocks whose box satisfies `near`, in their order.
    pub fn visit_triangles(&self, near: impl Fn(&BoundingBox) -> bool, mut visit: impl FnMut([u32; 3])) {
        if !near(&self.bounds) {
            return;
        }
        let blocks = self.blocks();
        for (block, bounds) in blocks.triangles.chunks(SETTINGS.block).zip(&blocks.bounds) {
            if near(bounds) {
                block.iter().for_each(|nodes| visit(*nodes));
            }
        }
    }

    /// Triangle at the material point (u, v) and the weights of its nodes.
    pub fn locate(&self, (u, v): (f64, f64)) -> Option<([u32; 3], [f64; 3])> {
        if !(0.0..=1.0).contains(&u) || !(0.0..=1.0).contains(&v) {
            return None;
        }
        let blocks = self.blocks();
        let within = |[low, high]: &[(f64, f64); 2]| {
            u >= low.0 - SETTINGS.weight_slack
                && u <= high.0 + SETTINGS.weight_slack
                && v >= low.1 - SETTINGS.weight_slack
                && v <= high.1 + SETTINGS.weight_slack
        };
        let chosen = blocks.triangles.chunks(SETTINGS.block).zip(&blocks.uv).filter(|(_, range)| within(range));
        chosen.flat_map(|(block, _)| block).find_map(|nodes| {
            let weights = weights_at(self.uv_of(*nodes), (u, v))?;
            weights.iter().all(|w| *w >= -SETTINGS.weight_slack).then(|| (*nodes, normalised(weights)))
        })
    }

    /// Point of a triangle with all its values.
    pub fn point(&self, nodes: [u32; 3], weights: [f64; 3], distance: f64) -> SurfacePoint {
        let corners = self.corners(nodes);
        let position = combine(corners, weights);
        let away = |k: &usize| corners[*k].distance_squared(position);
        let nearest = (0..3).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(0);
        let node = nodes[nearest];
        let uv = self.uv_of(nodes);
        let mut place = (0..3).fold((0.0, 0.0), |p, k| (p.0 + weights[k] * uv[k].0, p.1 + weights[k] * uv[k].1));
        if place.1 > 1.0 {
            place.1 = self.sheet.model.uv[node as usize].1;
        }
        SurfacePoint {
            sheet: self.id,
            nodes,
            weights,
            node,
            uv: (place.0.clamp(0.0, 1.0), place.1.clamp(0.0, 1.0)),
            position,
            normal: (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero(),
            velocity: combine(nodes.map(|i| self.sheet.state.v.get(i as usize)), weights),
            distance,
        }
    }

    /// Area at present and at rest.
    pub fn area(&self) -> SurfaceArea {
        let (length, width) = self.sheet.rest_size();
        let (mut present, mut rest) = (0.0, 0.0);
        for nodes in self.triangles() {
            let [a, b, c] = self.corners(*nodes);
            present += 0.5 * (b - a).cross(c - a).length();
            let [a, b, c] = self.uv_of(*nodes);
            rest += 0.5 * length * width * ((b.0 - a.0) * (c.1 - a.1) - (c.0 - a.0) * (b.1 - a.1)).abs();
        }
        SurfaceArea { present, rest }
    }
}

fn widened(bounds: BoundingBox) -> BoundingBox {
    let largest = bounds.low.abs().max(bounds.high.abs()).max_element();
    if largest.is_finite() { bounds.grown(SETTINGS.box_growth * largest) } else { bounds }
}

/// Weighted sum of three vectors.
pub(super) fn combine(vectors: [DVec3; 3], weights: [f64; 3]) -> DVec3 {
    vectors[0] * weights[0] + vectors[1] * weights[1] + vectors[2] * weights[2]
}

/// Squared distance of a point from a box, m².
pub(super) fn distance_squared(bounds: &BoundingBox, point: DVec3) -> f64 {
    point.distance_squared(point.max(bounds.low).min(bounds.high))
}

/// Barycentric weights of (u, v); `None` for a triangle without area.
fn weights_at([a, b, c]: [(f64, f64); 3], (u, v): (f64, f64)) -> Option<[f64; 3]> {
    let area = (b.0 - a.0) * (c.1 - a.1) - (c.0 - a.0) * (b.1 - a.1);
    if area == 0.0 {
        return None;
    }
    let second = ((u - a.0) * (c.1 - a.1) - (c.0 - a.0) * (v - a.1)) / area;
    let third = ((b.0 - a.0) * (v - a.1) - (u - a.0) * (b.1 - a.1)) / area;
    Some([1.0 - second - third, second, third])
}

/// Weights without the negative ones of rounding.
fn normalised(weights: [f64; 3]) -> [f64; 3] {
    let weights = weights.map(|w| w.max(0.0));
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}
