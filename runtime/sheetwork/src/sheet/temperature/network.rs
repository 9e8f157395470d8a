//! Thermal network of a sheet: heat capacities of thermal nodes, and conductances between them.
//!
//! A thermal node is a node of the sheet, or one of the two halves of the thickness at it. Its
//! capacity is C = ρ c A t/n (J/K), A the area of the node and n the number of layers or halves.
//! Within a layer heat flows along links, q = G (T_a - T_b):
//!
//! - on a rectangular grid G = k (t/n) w/h with h the distance of two nodes and w the width of the
//!   face between their cells (finite volumes; half the width along an edge of the sheet with nodes
//!   on it);
//! - on triangles G = ½ k (t/n) cot of the angle opposite to the link, summed over its triangles,
//!   with lumped capacities (linear finite elements). The area inside the outline of the sheet that
//!   a layer leaves uncovered belongs to the nodes and links of its border.
//!
//! Both are of second order in the spacing. Through the thickness a node exchanges heat with the
//! *mean* of the nodes around it in the next layer, q = k A n/t (T - Σ w T): separate links would
//! conduct along the sheet. A temperature that is linear along the sheet thus causes no flow across
//! it. All exchange is antisymmetric and conserves heat.
//!
//! In a fractured sheet only closed cells have capacity and conduct; cells that melt take their
//! heat with them. A node without closed cells keeps its temperature.

use std::collections::BTreeMap;

use crate::elements::fracture::OpenCells;
use crate::mesh::structure::LatticeLayer;
use crate::sheet::Sheet;

/// Conductance between two thermal nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThermalLink {
    /// The two thermal nodes.
    pub ends: [u32; 2],
    /// Conductance, W/K.
    pub conductance: f64,
}

/// Conductance between a thermal node and the mean of others.
#[derive(Clone, Debug, PartialEq)]
pub struct ThermalBridge {
    /// The thermal node.
    pub node: u32,
    /// The others.
    pub others: Vec<u32>,
    /// Conductance, W/K.
    pub conductance: f64,
}

/// Thermal nodes of a sheet and their conductances.
#[derive(Clone, Debug, Default)]
pub struct ThermalNetwork {
    /// Heat capacity of each thermal node, J/K.
    pub capacity: Vec<f64>,
    /// Area of the sheet of each thermal node, m².
    pub area: Vec<f64>,
    /// Links along layers, and between halves.
    pub links: Vec<ThermalLink>,
    /// Bridges between layers.
    pub bridges: Vec<ThermalBridge>,
}

/// Conductances per k t of a layer, by the nodes they join.
type Plane = BTreeMap<(u32, u32), f64>;

impl ThermalNetwork {
    /// Network of `sheet`, with `points` temperatures through the thickness at each node: 2 for the
    /// halves of a single layer.
    pub fn new(sheet: &Sheet, points: usize) -> Self {
        let n = sheet.node_count();
        let material = sheet.material();
        let parts = sheet.model.layers.len().max(1) * points;
        let slab = material.thickness / parts as f64;
        let mut area = vec![0.0; n];
        let mut plane = Plane::new();
        match &sheet.model.triangles {
            Some(_) => of_triangles(sheet, &sheet.cells().layer_triangles(0), &mut area, &mut plane),
            None => sheet.model.layers.iter().for_each(|layer| of_layer(sheet, layer, &mut area, &mut plane)),
        }
        let mut network = Self { area: area.repeat(points), ..Self::default() };
        let per_area = material.density * material.specific_heat * slab;
        network.capacity = network.area.iter().map(|a| a * per_area).collect();
        if sheet.open_cell_set().is_some() {
            // A node without closed cells has no heat flow; any capacity above 0 serves.
            network
                .capacity
                .iter_mut()
                .filter(|c| **c == 0.0)
                .for_each(|c| *c = per_area * sheet.model.extent.0 * sheet.model.extent.1);
        }
        let k = material.conductivity;
        for half in 0..points {
            let up = (half * n) as u32;
            let each = plane.iter().filter(|p| *p.1 != 0.0);
            network
                .links
                .extend(each.map(|((a, b), g)| ThermalLink { ends: [a + up, b + up], conductance: g * k * slab }));
        }
        for half in 1..points {
            let (low, high) = (((half - 1) * n) as u32, (half * n) as u32);
            network.links.extend((0..n).filter(|i| network.area[*i] > 0.0).map(|i| ThermalLink {
                ends: [low + i as u32, high + i as u32],
                conductance: k * network.area[i] / slab,
            }));
        }
        for (node, others) in sheet.stack.cells().filter(|c| !c.1.is_empty() && !sheet.is_detached(c.0 as usize)) {
            let conductance = k * network.area[node as usize] / slab;
            network.bridges.push(ThermalBridge { node, others: others.to_vec(), conductance });
        }
        network
    }

    /// Add to `flow` (W) the conduction into thermal nodes at `celsius` (°C).
    pub fn conduct(&self, celsius: &[f64], flow: &mut [f64]) {
        for link in &self.links {
            let [a, b] = link.ends.map(|i| i as usize);
            let q = link.conductance * (celsius[b] - celsius[a]);
            flow[a] += q;
            flow[b] -= q;
        }
        for bridge in &self.bridges {
            let share = 1.0 / bridge.others.len() as f64;
            let mean = bridge.others.iter().map(|i| celsius[*i as usize]).sum::<f64>() * share;
            let q = bridge.conductance * (mean - celsius[bridge.node as usize]);
            flow[bridge.node as usize] += q;
            bridge.others.iter().for_each(|i| flow[*i as usize] -= q * share);
        }
    }

    /// Visit the contributions to the conduction matrix, W/K: diagonal entries and, once, entries a
    /// > b.
    pub fn for_each_entry(&self, mut visit: impl FnMut(u32, u32, f64)) {
        for link in &self.links {
            let [a, b] = link.ends;
            visit(a, a, link.conductance);
            visit(b, b, link.conductance);
            visit(a.max(b), a.min(b), -link.conductance);
        }
        for bridge in &self.bridges {
            let share = 1.0 / bridge.others.len() as f64;
            let all = std::iter::once((bridge.node, 1.0)).chain(bridge.others.iter().map(|i| (*i, -share)));
            for (p, (a, wa)) in all.clone().enumerate() {
                for (b, wb) in all.clone().take(p + 1) {
                    visit(a.max(b), a.min(b), bridge.conductance * wa * wb);
                }
            }
        }
    }
}

/// Area and conductances of a layer: a rectangular one by finite volumes, a triangular one by its
/// triangles.
fn of_layer(sheet: &Sheet, layer: &LatticeLayer, area: &mut [f64], plane: &mut Plane) {
    if layer.triangular {
        of_triangles(sheet, &sheet.cells().closed(layer.triangles()), area, plane);
        fill_outline(sheet, layer, area, plane);
        return;
    }
    let (nx, _, nz) = sheet.model.grid;
    let h = [sheet.model.extent.0 / f64::from(nx - 1), sheet.model.extent.1 / f64::from(nz - 1)];
    if let Some(open) = sheet.open_cell_set() {
        return of_torn_layer((layer, h, (nx, nz)), open, area, plane);
    }
    // Nodes of a smaller layer lie in the middles of cells and have whole cells.
    let part = |k: u32, n: u32, whole: u32| if n == whole && (k == 0 || k + 1 == n) { 0.5 } else { 1.0 };
    for j in 0..layer.nz {
        for i in 0..layer.nx {
            let (a, across) = (layer.at(i, j), (part(i, layer.nx, nx), part(j, layer.nz, nz)));
            area[a as usize] = across.0 * across.1 * h[0] * h[1];
            if i + 1 < layer.nx {
                *plane.entry((a, layer.at(i + 1, j))).or_default() += across.1 * h[1] / h[0];
            }
            if j + 1 < layer.nz {
                *plane.entry((a, layer.at(i, j + 1))).or_default() += across.0 * h[0] / h[1];
            }
        }
    }
}

/// Area and conductances of a rectangular layer with node spacings `h` (m) by its closed cells. A
/// closed cell gives a quarter of its area to each corner and half of its width to each of its
/// sides; at nodes in the middles of cells it gives the whole.
fn of_torn_layer(
    (layer, h, (nx, nz)): (&LatticeLayer, [f64; 2], (u32, u32)),
    open: &OpenCells,
    area: &mut [f64],
    plane: &mut Plane,
) {
    let closed = |i: u32, di: i64, j: u32, dj: i64| open.is_closed(i64::from(i) + di, i64::from(j) + dj);
    let share = |all: &[bool]| all.iter().filter(|c| **c).count() as f64 / all.len() as f64;
    let at_corners = (layer.nx, layer.nz) == (nx, nz);
    for j in 0..layer.nz {
        for i in 0..layer.nx {
            let a = layer.at(i, j);
            let [sw, se, nw, ne] = [(-1, -1), (0, -1), (-1, 0), (0, 0)].map(|(di, dj)| closed(i, di, j, dj));
            let (own, right, front) = if at_corners {
                (share(&[sw, se, nw, ne]), share(&[se, ne]), share(&[nw, ne]))
            } else {
                let joined = |to: bool| if ne && to { 1.0 } else { 0.0 };
                (share(&[ne]), joined(closed(i, 1, j, 0)), joined(closed(i, 0, j, 1)))
            };
            area[a as usize] = own * h[0] * h[1];
            if i + 1 < layer.nx && right > 0.0 {
                *plane.entry((a, layer.at(i + 1, j))).or_default() += right * h[1] / h[0];
            }
            if j + 1 < layer.nz && front > 0.0 {
                *plane.entry((a, layer.at(i, j + 1))).or_default() += front * h[0] / h[1];
            }
        }
    }
}

/// Area and conductances of triangles: linear finite elements with lumped capacities.
fn of_triangles(sheet: &Sheet, triangles: &[[u32; 3]], area: &mut [f64], plane: &mut Plane) {
    for t in triangles {
        let p = t.map(|m| sheet.model.place(m));
        let side = |a: usize, b: usize| [p[b][0] - p[a][0], p[b][1] - p[a][1]];
        let (ab, ac) = (side(0, 1), side(0, 2));
        let double = (ab[0] * ac[1] - ab[1] * ac[0]).abs();
        for c in 0..3 {
            area[t[c] as usize] += double / 6.0;
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            let (to_a, to_b) = (side(c, a), side(c, b));
            let cotangent = (to_a[0] * to_b[0] + to_a[1] * to_b[1]) / double;
            let key = (t[a].min(t[b]), t[a].max(t[b]));
            *plane.entry(key).or_default() += 0.5 * cotangent;
        }
    }
}

/// Assign the area that a triangular layer leaves uncovered while all cells are closed to its
/// border, as a strip of uniform width, where the border is beside a closed cell.
fn fill_outline(sheet: &Sheet, layer: &LatticeLayer, area: &mut [f64], plane: &mut Plane) {
    let (i, j) = (layer.nx - 1, layer.nz - 1);
    let along = (0..i).flat_map(|k| [(layer.at(k, 0), layer.at(k + 1, 0)), (layer.at(k, j), layer.at(k + 1, j))]);
    let across = (0..j).flat_map(|k| [(layer.at(0, k), layer.at(0, k + 1)), (layer.at(i, k), layer.at(i, k + 1))]);
    let border: Vec<(u32, u32)> = along.chain(across).collect();
    let length = |(a, b): (u32, u32)| {
        let (p, q) = (sheet.model.place(a), sheet.model.place(b));
        (p[0] - q[0]).hypot(p[1] - q[1])
    };
    let around: f64 = border.iter().map(|e| length(*e)).sum();
    let covered: f64 = if sheet.open_cell_set().is_none() {
        layer.range().map(|m| area[m]).sum()
    } else {
        layer.triangles().iter().map(|t| triangle_area(t.map(|m| sheet.model.place(m)))).sum()
    };
    let width = (sheet.model.extent.0 * sheet.model.extent.1 - covered) / around;
    for edge in border.into_iter().filter(|(a, b)| !sheet.cells().is_side_cut(*a, *b)) {
        let l = length(edge);
        area[edge.0 as usize] += 0.5 * width * l;
        area[edge.1 as usize] += 0.5 * width * l;
        *plane.entry((edge.0.min(edge.1), edge.0.max(edge.1))).or_default() += width / l;
    }
}

/// Area of a triangle, m².
fn triangle_area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
}
