//! Selection of the nodes of a region of a scene file.

use crate::error::{InputError, reject_if};
use crate::mesh::structure::LatticeLayer;
use crate::scene::Region;
use crate::sheet::Sheet;

/// Tolerance on the borders of a rectangle, so that 0.1 includes the row at 0.1 despite rounding.
const BORDER_TOLERANCE: f64 = 1e-9;

/// Indices of the nodes in `region`, in order.
///
/// # Errors
/// When a node index does not exist, or the region contains no node.
pub fn select(region: &Region, sheet: &Sheet) -> Result<Vec<u32>, InputError> {
    let (layers, uv) = (&sheet.model.layers, &sheet.model.uv);
    let all = 0..uv.len() as u32;
    let columns = |last: bool| {
        let rows = layers.iter().flat_map(move |l| (0..l.nz).map(move |j| l.at(if last { l.nx - 1 } else { 0 }, j)));
        rows.collect()
    };
    let rows = |last: bool| {
        let row = layers.iter().flat_map(move |l| (0..l.nx).map(move |i| l.at(i, if last { l.nz - 1 } else { 0 })));
        row.collect()
    };
    let beyond = |side: fn((f64, f64)) -> f64| {
        let on = all.clone().filter(|i| side(uv[*i as usize]) <= BORDER_TOLERANCE);
        on.collect::<Vec<u32>>()
    };
    let masses: Vec<u32> = match region {
        Region::All => all.collect(),
        Region::Border => all.filter(|i| sheet.model.border[*i as usize]).collect(),
        // The sides of a mesh are its nodes on the sides of its bounding box.
        Region::Left if sheet.model.triangles.is_some() => beyond(|(u, _)| u),
        Region::Right if sheet.model.triangles.is_some() => beyond(|(u, _)| 1.0 - u),
        Region::Back if sheet.model.triangles.is_some() => beyond(|(_, v)| v),
        Region::Front if sheet.model.triangles.is_some() => beyond(|(_, v)| 1.0 - v),
        Region::Left => columns(false),
        Region::Right => columns(true),
        Region::Back => rows(false),
        Region::Front => rows(true),
        Region::Rect(u, v) => {
            let inside = |x: f64, (low, high): (f64, f64)| x >= low - BORDER_TOLERANCE && x <= high + BORDER_TOLERANCE;
            all.filter(|i| inside(uv[*i as usize].0, *u) && inside(uv[*i as usize].1, *v)).collect()
        }
        Region::Point(u, v) => nearest(*u, *v, layers, uv).into_iter().collect(),
        Region::Masses(list) => {
            if let Some(i) = list.iter().find(|i| **i as usize >= uv.len()) {
                let problem = format!("mass {i} does not exist: the sheet has masses 0 to {}", uv.len() - 1);
                return Err(InputError::new("", problem));
            }
            list.clone()
        }
    };
    reject_if!(masses.is_empty(), "", "holds no mass of the sheet");
    Ok(masses)
}

fn nearest(u: f64, v: f64, layers: &[LatticeLayer], uv: &[(f64, f64)]) -> Option<u32> {
    let distance = |i: usize| (uv[i].0 - u).powi(2) + (uv[i].1 - v).powi(2);
    let bottom = layers.first()?.range();
    bottom.min_by(|a, b| distance(*a).total_cmp(&distance(*b))).map(|i| i as u32)
}
