//! Cells of a sheet that its slits open.

use crate::elements::fracture::OpenCells;
use crate::error::{InputError, reject_if};
use crate::mesh::outline::metres;
use crate::mesh::slits::{Slit, crossed, crossed_triangles};

/// For each of the cells `open`, whether one of `slits` crosses it.
///
/// # Errors
/// When a slit crosses no cell: it lies outside the outline or in a hole.
pub(crate) fn slit_cells(open: &OpenCells, slits: &[Slit]) -> Result<Vec<bool>, InputError> {
    let mut cells = vec![false; open.cells().len()];
    let point = |(x, z): (f64, f64)| format!("({}, {})", metres(x), metres(z));
    for (i, slit) in slits.iter().enumerate() {
        let Some(t) = open.triangles() else {
            crossed(open.size(), *slit).into_iter().for_each(|c| cells[c] = true);
            continue;
        };
        let (from, to) = (t.place(slit.0), t.place(slit.1));
        let list = crossed_triangles(t.mesh(), (from, to), t.side());
        let (low, high) = (point(t.place((0.0, 0.0))), point(t.place((1.0, 1.0))));
        let problem = format!("from {} to {} m crosses no cell of the sheet, which extends", point(from), point(to));
        reject_if!(list.is_empty(), format!("slits.{i}"), "{problem} from {low} to {high} m");
        list.into_iter().for_each(|c| cells[c] = true);
    }
    Ok(cells)
}
