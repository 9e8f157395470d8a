//! Cells of a sheet that its slits open.

use crate::elements::fracture::OpenCells;
use crate::mesh::slits::{Slit, crossed, crossed_triangles};

/// For each of the cells `open`, whether one of `slits` crosses it.
pub(crate) fn slit_cells(open: &OpenCells, slits: &[Slit]) -> Vec<bool> {
    let mut cells = vec![false; open.cells().len()];
    for slit in slits {
        let list = match open.triangles() {
            None => crossed(open.size(), *slit),
            Some(t) => crossed_triangles(t.mesh(), (t.place(slit.0), t.place(slit.1)), t.side()),
        };
        list.into_iter().for_each(|c| cells[c] = true);
    }
    cells
}
