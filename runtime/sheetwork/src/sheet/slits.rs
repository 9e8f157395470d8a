//! Cells of a sheet that its slits open.

use crate::mesh::slits::{Slit, crossed};
use crate::sheet::Sheet;

/// For each cell, whether one of `slits` crosses it.
pub(crate) fn slit_cells(sheet: &Sheet, slits: &[Slit]) -> Vec<bool> {
    let bottom = sheet.model.layers.first().copied().unwrap_or_default();
    let size = (bottom.nx.saturating_sub(1) as usize, bottom.nz.saturating_sub(1) as usize);
    let mut cells = vec![false; size.0 * size.1];
    for slit in slits {
        crossed(size, *slit).into_iter().for_each(|c| cells[c] = true);
    }
    cells
}
