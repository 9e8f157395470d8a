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
    // The sides of a mesh are its nodes on the sides of its bounding box: at the distance 0 by
    // `beyond`. Those of a layer are a column or a row of its nodes.
    let side = |beyond: fn((f64, f64)) -> f64, is_on: fn(&LatticeLayer, u32, u32) -> bool| -> Vec<u32> {
        if sheet.model.triangles.is_some() {
            return all.clone().filter(|i| beyond(uv[*i as usize]) <= BORDER_TOLERANCE).collect();
        }
        let on = layers.iter().flat_map(|l| l.range().map(move |k| (l, k as u32 - l.first)));
        on.filter(|(l, k)| is_on(l, k % l.nx, k / l.nx)).map(|(l, k)| l.first + k).collect()
    };
    let masses: Vec<u32> = match region {
        Region::All => all.collect(),
        Region::Border => all.filter(|i| sheet.model.border[*i as usize]).collect(),
        Region::Left => side(|(u, _)| u, |_, i, _| i == 0),
        Region::Right => side(|(u, _)| 1.0 - u, |l, i, _| i + 1 == l.nx),
        Region::Back => side(|(_, v)| v, |_, _, j| j == 0),
        Region::Front => side(|(_, v)| 1.0 - v, |l, _, j| j + 1 == l.nz),
        Region::Rect(u, v) => {
            let inside = |x: f64, (low, high): (f64, f64)| x >= low - BORDER_TOLERANCE && x <= high + BORDER_TOLERANCE;
            all.filter(|i| inside(uv[*i as usize].0, *u) && inside(uv[*i as usize].1, *v)).collect()
        }
        Region::Point(u, v) => {
            // On any refinement of a mesh a point is that of the base mesh.
            let base = sheet.model.meshes.refinement.as_ref().map_or(uv.len(), |r| r.base.positions.len());
            nearest(*u, *v, layers, &uv[..base]).into_iter().collect()
        }
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
    bottom.filter(|i| *i < uv.len()).min_by(|a, b| distance(*a).total_cmp(&distance(*b))).map(|i| i as u32)
}
