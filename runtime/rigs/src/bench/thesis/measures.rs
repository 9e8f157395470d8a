//! Geometric measures of a sheet against its state at the start of a run.

use glam::{DVec2, DVec3};
use sheetwork::sheet::Sheet;
use sheetwork::sheet::layer_stack::LayerStack;

/// Mean distance of each node from the layer below, over that at the start; 1 for a single layer.
pub(crate) fn layer_distance(start: &Sheet, now: &Sheet) -> f64 {
    let stack = LayerStack::new(now.springs(), &now.model.layer_of);
    let (mut sum, mut rest) = (0.0, 0.0);
    for (upper, lower) in stack.cells().filter(|(_, lower)| lower.len() > 2) {
        sum += height_over(now, upper, lower);
        rest += height_over(start, upper, lower);
    }
    if rest == 0.0 { 1.0 } else { sum / rest }
}

/// Signed distance of a node from the plane of the nodes around it in the next layer, along the
/// plane's normal out of the upper side, m.
fn height_over(sheet: &Sheet, node: u32, plane: &[u32]) -> f64 {
    let at = |i: u32| sheet.state.x.get(i as usize);
    let middle: DVec3 = plane.iter().map(|i| at(*i)).sum::<DVec3>() / plane.len() as f64;
    let mut plane = plane.to_vec();
    plane.sort_unstable();
    let (a, b) = (at(plane[1]) - at(plane[0]), at(plane[2]) - at(plane[0]));
    // Nodes of a layer are numbered along x first, so that b × a points upwards in a flat sheet.
    let normal = b.cross(a).normalize_or_zero();
    let sense = if sheet.model.layer_of[node as usize] > sheet.model.layer_of[plane[0] as usize] { 1.0 } else { -1.0 };
    sense * (at(node) - middle).dot(normal)
}

/// Length of the middle row of the bottom layer along x, over that at the start.
pub(crate) fn stretch_x(start: &Sheet, now: &Sheet) -> f64 {
    row_length(now, false) / row_length(start, false)
}

/// Length of the middle column of the bottom layer along z, over that at the start.
pub(crate) fn stretch_z(start: &Sheet, now: &Sheet) -> f64 {
    row_length(now, true) / row_length(start, true)
}

fn row_length(sheet: &Sheet, across: bool) -> f64 {
    let layer = sheet.model.layers[0];
    let nodes: Vec<u32> = if across {
        (0..layer.nz).map(|j| layer.at(layer.nx / 2, j)).collect()
    } else {
        (0..layer.nx).map(|i| layer.at(i, layer.nz / 2)).collect()
    };
    let at = |i: u32| sheet.state.x.get(i as usize);
    nodes.windows(2).map(|pair| at(pair[0]).distance(at(pair[1]))).sum()
}

/// Stretch along x of the half of the middle row on one side of the centre: `right` for u > 0.5.
pub(crate) fn half_stretch(start: &Sheet, now: &Sheet, right: bool) -> f64 {
    let length = |sheet: &Sheet| {
        let layer = sheet.model.layers[0];
        let middle = layer.nx / 2;
        let (from, to) = if right { (middle, layer.nx - 1) } else { (0, middle) };
        let at = |i: u32| sheet.state.x.get(layer.at(i, layer.nz / 2) as usize);
        (from..to).map(|i| at(i).distance(at(i + 1))).sum::<f64>()
    };
    length(now) / length(start)
}

/// Rotation about the vertical that best maps the start to the present state (least squares over
/// the bottom layer, in plan), degrees, positive from z to x.
pub(crate) fn yaw(start: &Sheet, now: &Sheet) -> f64 {
    let range = now.model.layers[0].range();
    let plan = |sheet: &Sheet| -> Vec<DVec2> {
        let points = range.clone().map(|i| sheet.state.x.get(i)).map(|p| DVec2::new(p.z, p.x));
        points.collect()
    };
    let (before, after) = (plan(start), plan(now));
    let mean = |points: &[DVec2]| points.iter().sum::<DVec2>() / points.len() as f64;
    let (m0, m1) = (mean(&before), mean(&after));
    let (mut sine, mut cosine) = (0.0, 0.0);
    for (p, q) in before.iter().zip(&after) {
        let (p, q) = (*p - m0, *q - m1);
        sine += p.perp_dot(q);
        cosine += p.dot(q);
    }
    sine.atan2(cosine).to_degrees()
}

/// Part of the area of the bottom layer whose upper side faces downwards.
pub(crate) fn turned_over(sheet: &Sheet) -> f64 {
    let (mut down, mut whole) = (0.0, 0.0);
    for [a, b, c] in sheet.model.layers[0].triangles() {
        let at = |i: u32| sheet.state.x.get(i as usize);
        let area = (at(b) - at(a)).cross(at(c) - at(a));
        whole += area.length();
        down += if area.y < 0.0 { area.length() } else { 0.0 };
    }
    down / whole
}

/// Height of the lowest and the highest node, m.
pub(crate) fn heights(sheet: &Sheet) -> (f64, f64) {
    sheet.state.x.y.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(*y), high.max(*y)))
}

/// Position of a probe, m.
pub(crate) fn probe(sheet: &Sheet, name: &str) -> DVec3 {
    sheet.probes.iter().find(|p| p.name == name).map_or(DVec3::NAN, |p| p.at(&sheet.state.x))
}

/// Largest curvature of the middle row of the bottom layer in its own plane: angle between
/// neighbouring segments over their mean length, 1/m.
pub(crate) fn sharpest_bend(sheet: &Sheet) -> f64 {
    let layer = sheet.model.layers[0];
    let at = |i: u32| sheet.state.x.get(layer.at(i, layer.nz / 2) as usize);
    let bend = |i: u32| {
        let (a, b) = (at(i) - at(i - 1), at(i + 1) - at(i));
        a.angle_between(b) / (0.5 * (a.length() + b.length()))
    };
    (1..layer.nx - 1).map(bend).fold(0.0, f64::max)
}
