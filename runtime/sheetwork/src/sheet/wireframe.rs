//! Edges between neighbouring nodes, with and without springs, for drawing.

use crate::sheet::Sheet;

impl Sheet {
    /// Pairs of neighbouring nodes of a layer, each once: the edges of its triangles.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let sides = self.cells().triangles().into_iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
        let mut edges: Vec<[u32; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Shortest and longest distance of joined nodes, m: rest lengths of the springs, or present
    /// lengths of the edges for a sheet without springs. `None` for a sheet of one node.
    pub fn spacing(&self) -> Option<(f64, f64)> {
        let widen = |(low, high): (f64, f64), d: f64| (low.min(d), high.max(d));
        let none = (f64::INFINITY, 0.0);
        let rest = &self.springs.rest;
        let (low, high) = if rest.is_empty() {
            let at = |i: u32| self.state.x.get(i as usize);
            self.edges().iter().map(|[a, b]| at(*a).distance(at(*b))).fold(none, widen)
        } else {
            rest.iter().copied().fold(none, widen)
        };
        (low.is_finite() && high > 0.0).then_some((low, high))
    }
}

#[cfg(test)]
mod tests {
    use crate::World;
    use crate::mesh::structure::StructureKind;
    use crate::scene::{Scene, SheetSpec};

    #[test]
    fn a_shell_has_the_edges_of_its_grid_and_their_lengths() {
        let sheet =
            SheetSpec { structure: StructureKind::Shell, grid: (4, 1, 3), size: (0.3, 0.1), ..SheetSpec::thesis() };
        let world = World::new(&Scene { sheets: vec![sheet], ..Scene::thesis() }).expect("valid");
        let sheet = &world.sheets()[0];
        // 3 rows of 3 along, 4 columns of 2 across, and a diagonal for each of 6 cells.
        assert_eq!(sheet.edges().len(), 9 + 8 + 6);
        let (low, high) = sheet.spacing().expect("masses");
        assert!((low - 0.05).abs() < 1e-12 && (high - 0.1_f64.hypot(0.05)).abs() < 1e-12);
        assert!(sheet.follows_material());
    }
}
