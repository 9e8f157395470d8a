//! The two sides of a sheet in heat exchange: one patch per node of the lowest layer, facing down,
//! and one per node of the uppermost layer, facing up.
//!
//! A patch has the area of its node, m², and the normal of the triangles around it. The edges of
//! the sheet are thin and exchange no heat.

use glam::DVec3;

use crate::sheet::Sheet;
use crate::sheet::temperature::network::ThermalNetwork;

/// Part of a side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Index of the thermal node that receives the patch's heat.
    pub node: u32,
    /// Index of the sheet's node.
    pub mass: u32,
    /// Whether the patch faces up, along the normal of the upper side.
    pub up: bool,
    /// Area, m².
    pub area: f64,
}

/// Patches of a sheet, lower side first, and their normals.
#[derive(Clone, Debug, Default)]
pub struct SheetPatches {
    /// All patches.
    pub patches: Vec<Patch>,
    /// Unit outward normal of each patch; zero where the triangles around it cancel.
    pub normals: Vec<DVec3>,
    /// Triangles of the lowest and of the uppermost layer, counter-clockwise seen from above.
    triangles: [Vec<[u32; 3]>; 2],
    sums: Vec<DVec3>,
}

impl SheetPatches {
    /// Patches of `sheet`.
    pub fn new(sheet: &Sheet, network: &ThermalNetwork, points: usize) -> Self {
        let top = sheet.model.layers.len().saturating_sub(1);
        let mut faces = Self {
            triangles: [
                sheet.cells().layer_triangles(0),
                if top > 0 { sheet.cells().layer_triangles(top) } else { Vec::new() },
            ],
            sums: vec![DVec3::ZERO; sheet.node_count()],
            ..Self::default()
        };
        for (up, index) in [(false, 0), (true, top)] {
            let Some(layer) = sheet.model.layers.get(index) else { continue };
            for mass in layer.range() {
                let node = if up && points > 1 { mass + sheet.node_count() } else { mass };
                let area = network.area[node];
                faces.patches.push(Patch { node: node as u32, mass: mass as u32, up, area });
            }
        }
        faces.normals = vec![DVec3::ZERO; faces.patches.len()];
        faces.update_normals(sheet);
        faces
    }

    /// Update the normals to the present shape of the sheet.
    pub fn update_normals(&mut self, sheet: &Sheet) {
        self.sums.fill(DVec3::ZERO);
        for t in self.triangles.iter().flatten() {
            let [a, b, c] = t.map(|m| sheet.state.x.get(m as usize));
            let area = (b - a).cross(c - a);
            t.iter().for_each(|m| self.sums[*m as usize] += area);
        }
        for (normal, patch) in self.normals.iter_mut().zip(&self.patches) {
            let n = self.sums[patch.mass as usize].normalize_or_zero();
            *normal = if patch.up { n } else { -n };
        }
    }

    /// Triangles of the sides: of the lowest layer, and, where there is another, of the uppermost.
    pub fn triangles(&self) -> impl Iterator<Item = &[u32; 3]> {
        self.triangles.iter().flatten()
    }
}
