//! Strain and temperature of the cells of a sheet that can open: see `fracture`.

use glam::DVec3;

use crate::elements::fracture::{OpenCells, rectangle};
use crate::elements::triangle_cells::TriangleCells;
use crate::sheet::Sheet;
use crate::units::temperature::REFERENCE;

/// Strain and temperature (°C) of a cell.
pub(crate) struct CellState {
    pub strain: f64,
    pub celsius: Option<f64>,
}

/// Nodes of the upper layers in each triangle of the lowest layer: a node of a smaller layer lies
/// inside a triangle, one of a layer of the same size at a corner.
pub(crate) fn upper_nodes(sheet: &Sheet, open: &OpenCells) -> Vec<Vec<u32>> {
    let (Some(cells), [bottom, upper @ ..]) = (open.triangles(), sheet.model.layers.as_slice()) else {
        return Vec::new();
    };
    if upper.is_empty() {
        return Vec::new();
    }
    let mut nodes = vec![Vec::new(); open.cells().len()];
    for layer in upper {
        for i in layer.range() {
            if layer.nx == bottom.nx {
                let below = bottom.first + i as u32 - layer.first;
                cells.around(below).iter().for_each(|c| nodes[*c as usize].push(i as u32));
            } else if let Some(c) = open.cell_at(open.place(sheet.model.uv[i])) {
                nodes[c].push(i as u32);
            }
        }
    }
    nodes
}

/// State of cell `c` of a grid with `columns` cells in a row.
pub(crate) fn state_of_rectangle(sheet: &Sheet, columns: usize, c: usize) -> CellState {
    let Some(layer) = sheet.model.layers.first() else { return CellState { strain: 0.0, celsius: None } };
    let m = rectangle(columns, c).map(|m| m as usize);
    let celsius = sheet.temperatures().map(|t| rectangle_temperature(sheet, t, m, c));
    let [p, q, r, s] = m.map(|m| sheet.state.x.get(m));
    let half =
        (0.5 * f64::from(layer.nx - 1) / sheet.model.extent.0, 0.5 * f64::from(layer.nz - 1) / sheet.model.extent.1);
    let derivatives = ((q - p + s - r) * half.0, (r - p + s - q) * half.1);
    CellState { strain: strain_of(sheet, derivatives, celsius), celsius }
}

/// State of triangle `c` of `cells`, with the nodes of the upper layers in each.
pub(crate) fn state_of_triangle(sheet: &Sheet, cells: &TriangleCells, upper_nodes: &[Vec<u32>], c: usize) -> CellState {
    let m = cells.mesh().triangles[c].map(|m| m as usize);
    let celsius = sheet.temperatures().map(|t| {
        let upper = upper_nodes.get(c).map_or(&[][..], Vec::as_slice);
        let sum = m.iter().map(|m| t[*m]).sum::<f64>() + upper.iter().map(|m| t[*m as usize]).sum::<f64>();
        sum / (3 + upper.len()) as f64
    });
    let derivatives = cells.derivatives(c, m.map(|m| sheet.state.x.get(m)));
    CellState { strain: strain_of(sheet, derivatives, celsius), celsius }
}

/// Largest principal strain for the derivatives of the position along u and v.
#[inline]
fn strain_of(sheet: &Sheet, (a, b): (DVec3, DVec3), celsius: Option<f64>) -> f64 {
    let (aa, bb, ab) = (a.length_squared(), b.length_squared(), a.dot(b));
    let square = 0.5 * (aa + bb + ((aa - bb).powi(2) + 4.0 * ab * ab).sqrt());
    let grown = 1.0 + celsius.map_or(0.0, |t| sheet.parameters.material.expansion * (t - REFERENCE));
    square.sqrt() / grown - 1.0
}

/// Mean temperature of the nodes of cell `c` of a grid, °C; `m` are its corners in the lowest
/// layer.
fn rectangle_temperature(sheet: &Sheet, celsius: &[f64], m: [usize; 4], c: usize) -> f64 {
    let (mut sum, mut count) = (m.iter().map(|m| celsius[*m]).sum::<f64>(), 4.0);
    let Some(bottom) = sheet.model.layers.first().filter(|_| sheet.model.layers.len() > 1) else {
        return sum / count;
    };
    let across = bottom.nx - 1;
    let (i, j) = (c as u32 % across, c as u32 / across);
    for layer in &sheet.model.layers[1..] {
        if layer.nx == bottom.nx {
            let corners = rectangle(across as usize, c).map(|m| celsius[(layer.first + m) as usize]);
            sum += corners.iter().sum::<f64>();
            count += 4.0;
        } else {
            sum += celsius[layer.at(i, j) as usize];
            count += 1.0;
        }
    }
    sum / count
}
