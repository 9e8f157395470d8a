//! Cells of a sheet: the rectangles or triangles of its lowest layer that can open, and the
//! triangles and sides of all layers that closed cells hold.

use std::sync::Arc;

use crate::elements::fracture::OpenCells;
use crate::elements::triangle_cells::TriangleCells;
use crate::mesh::outline::TriangleMesh;
use crate::mesh::structure::LatticeLayer;
use crate::sheet::Sheet;

/// Cells of a sheet.
#[derive(Clone, Copy)]
pub struct SheetCells<'a> {
    sheet: &'a Sheet,
    /// Open cells; `None` if all are closed.
    open: Option<&'a OpenCells>,
}

impl<'a> SheetCells<'a> {
    pub(crate) fn new(sheet: &'a Sheet, open: Option<&'a OpenCells>) -> Self {
        Self { sheet, open }
    }

    /// Cells along length and width, or triangles and 1; zero for a sheet that cannot open.
    pub fn counts(&self) -> (usize, usize) {
        self.sheet.state.fracture.as_ref().map_or((0, 0), |t| t.size())
    }

    /// Whether no closed cell is beside a spring or side between the nodes `a` and `b`.
    pub fn is_side_cut(&self, a: u32, b: u32) -> bool {
        self.open.is_some_and(|open| {
            let at = |i: u32| (i, open.place(self.sheet.model.uv[i as usize]));
            let is_detached = [a, b].iter().any(|i| self.sheet.is_detached(*i as usize));
            is_detached || open.is_side_cut(at(a), at(b))
        })
    }

    /// Whether a triangle of a layer lies in a closed cell.
    pub fn is_triangle_closed(&self, triangle: [u32; 3]) -> bool {
        self.open.is_none_or(|open| {
            let at = triangle.map(|m| open.place(self.sheet.model.uv[m as usize]));
            let (u, v) = ((at[0].0 + at[1].0 + at[2].0) / 3.0, (at[0].1 + at[1].1 + at[2].1) / 3.0);
            open.is_closed_at(u, v) && !triangle.iter().any(|m| self.sheet.is_detached(*m as usize))
        })
    }

    /// Those of `triangles` that lie in closed cells.
    pub fn closed(&self, mut triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
        if self.open.is_some() {
            triangles.retain(|t| self.is_triangle_closed(*t));
        }
        triangles
    }

    /// Triangles of all layers in closed cells, counter-clockwise seen from the upper side.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        self.closed(match &self.sheet.model.triangles {
            Some(triangles) => triangles.clone(),
            None => self.sheet.model.layers.iter().flat_map(LatticeLayer::triangles).collect(),
        })
    }

    /// Triangles of layer `index` in closed cells, counter-clockwise seen from the upper side; none
    /// without that layer.
    pub fn layer_triangles(&self, index: usize) -> Vec<[u32; 3]> {
        self.closed(match (&self.sheet.model.triangles, self.sheet.model.layers.get(index)) {
            (Some(triangles), Some(_)) => triangles.clone(),
            (None, Some(layer)) => layer.triangles(),
            (_, None) => Vec::new(),
        })
    }
}

/// The cells of `sheet`, all closed.
pub(crate) fn closed_cells(sheet: &Sheet) -> OpenCells {
    let bottom = sheet.model.layers.first().copied().unwrap_or_default();
    let mesh = match &sheet.model.meshes.present {
        Some(mesh) => Some(mesh.clone()),
        None if bottom.triangular => {
            let positions = bottom.range().map(|i| sheet.model.place(i as u32)).collect();
            // Counter-clockwise seen from above is clockwise in (u, v).
            let triangles = bottom.triangles().into_iter().map(|[a, b, c]| [a, c, b]).collect();
            TriangleMesh::new(positions, triangles).ok().map(Arc::new)
        }
        None => None,
    };
    match mesh {
        Some(mesh) => OpenCells::closed_triangles(TriangleCells::new(mesh, !bottom.triangular)),
        None => OpenCells::closed(bottom.nx as usize, bottom.nz as usize),
    }
}
