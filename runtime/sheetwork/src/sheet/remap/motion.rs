//! Remapping of positions and velocities to another grid, for shells; `lattice` does so for
//! lattices.

use glam::{DMat3, DVec3};

use crate::elements::remap::{GridRemap, MeshRemap, Remap};
use crate::math::Vectors;
use crate::mesh::structure::StructureKind;
use crate::scene::SheetSpec;
use crate::sheet::Sheet;
use crate::sheet::remap::spline::SplineSurface;
use crate::sheet::remap::strain::StrainGrid;

/// Tolerance on the distance of a node from its pin, relative to the length of the sheet, for
/// rounding.
pub(crate) const PIN_TOLERANCE: f64 = 1e-9;

impl Sheet {
    fn edges_of_grid(&self) -> StrainGrid {
        let [columns, rows] = self.nodes_along();
        let spacing = (self.model.extent.0 / (columns - 1) as f64, self.model.extent.1 / (rows - 1) as f64);
        StrainGrid { columns, rows, spacing, triangular: false }
    }

    /// Whether it is a shell on a grid.
    fn is_grid(&self) -> bool {
        self.model.structure == StructureKind::Shell
            && self.model.triangles.is_none()
            && self.elements.len() > self.grabs.len()
    }

    /// Positions of the nodes of another grid, m; the present positions where the grid is the same
    /// or cannot change.
    pub fn positions_at(&self, grid: (u32, u32)) -> std::borrow::Cow<'_, Vectors> {
        let [columns, rows] = self.nodes_along();
        let to = (grid.0 as usize, grid.1 as usize);
        if let Some((mesh, first)) = self.meshes_to(grid) {
            let x: Vec<DVec3> = self.state.x.iter().collect();
            return std::borrow::Cow::Owned(vectors(&self.patches(mesh, false).interpolate(
                first,
                &x,
                [DVec3::ZERO; 2],
            )));
        }
        if to == (columns, rows) || !(self.is_grid() || self.is_lattice()) {
            return std::borrow::Cow::Borrowed(&self.state.x);
        }
        if self.is_lattice() {
            return self
                .lattice_positions_at(grid)
                .map_or(std::borrow::Cow::Borrowed(&self.state.x), std::borrow::Cow::Owned);
        }
        let surface = SplineSurface {
            from: (columns, rows),
            to,
            clamped: &vec![false; self.node_count()],
            staggered: false,
            folds: &self.model.folds,
        };
        std::borrow::Cow::Owned(vectors(&surface.interpolate(&self.state.x, [DVec3::ZERO; 2])))
    }

    /// Nodal `values` interpolated at the nodes of another grid.
    pub fn values_at<'a>(&self, grid: (u32, u32), values: &'a [f64]) -> std::borrow::Cow<'a, [f64]> {
        let (from, to) = (self.nodes_along(), [grid.0 as usize, grid.1 as usize]);
        if let Some((mesh, first)) = self.meshes_to(grid) {
            return std::borrow::Cow::Owned(Remap::Mesh(MeshRemap::new(mesh, first)).at_nodes(values));
        }
        if from == to || !(self.is_grid() || self.is_lattice()) {
            return std::borrow::Cow::Borrowed(values);
        }
        if self.is_lattice() {
            return self
                .lattice_values_at(grid, values)
                .map_or(std::borrow::Cow::Borrowed(values), std::borrow::Cow::Owned);
        }
        std::borrow::Cow::Owned(Remap::Grid(GridRemap { from, to }).at_nodes(values))
    }

    /// Remap positions and velocities of `old`, with its strains and rates of strain.
    pub(crate) fn remap_motion(&mut self, old: &Self, spec: &SheetSpec, time: f64) {
        if self.model.structure != StructureKind::Shell {
            return self.remap_layers(old, spec, time);
        }
        let (before, now) = (old.edges_of_grid(), self.edges_of_grid());
        let surface = SplineSurface {
            from: (before.columns, before.rows),
            to: (now.columns, now.rows),
            clamped: &old.model.clamped,
            staggered: false,
            folds: &old.model.folds,
        };
        let rotation = spec.placement.quaternion();
        let clamp = [rotation * DVec3::X * before.spacing.0, rotation * DVec3::Z * before.spacing.1];
        self.state.x = vectors(&surface.interpolate(&old.state.x, clamp));
        self.pins.adopt_positions(time, &mut self.state.x, PIN_TOLERANCE * self.model.length);
        let held: Vec<bool> = self.inverse_mass.iter().map(|w| *w == 0.0).collect();
        let (was, were): (Vec<DVec3>, Vec<DVec3>) = (old.state.x.iter().collect(), old.state.v.iter().collect());
        let mut x: Vec<DVec3> = self.state.x.iter().collect();
        now.restore_strains(&mut x, &before.interpolate(&before.strains(&was), &now), &held);
        self.state.x = vectors(&x);
        self.pins.adopt_positions(time, &mut self.state.x, PIN_TOLERANCE * self.model.length);
        if old.state.v.max_squared() == 0.0 {
            self.state.v = Vectors::zeros(self.node_count());
            return;
        }
        let mut v = surface.interpolate(&old.state.v, [DVec3::ZERO; 2]);
        now.restore_strain_rates(&x, &mut v, &before.interpolate(&before.rates(&was, &were), &now), &held);
        self.state.v = vectors(&v);
        self.pins.zero_fixed_axes(&mut self.state.v);
        self.restore_momentum(old);
    }

    /// Set the momentum and angular momentum of `old`, for a sheet without pins.
    pub(crate) fn restore_momentum(&mut self, old: &Self) {
        if !self.pins.is_empty() {
            return;
        }
        let centre = self.centre_of_mass();
        let (mut inertia, mut size) = (DMat3::ZERO, 0.0);
        for (x, m) in self.state.x.iter().zip(&self.model.mass) {
            let r = x - centre;
            inertia += (DMat3::from_diagonal(DVec3::splat(r.length_squared()))
                - DMat3::from_cols(r * r.x, r * r.y, r * r.z))
                * *m;
            size += m * r.length_squared();
        }
        let lost = old.angular_momentum() - self.angular_momentum();
        let turns = inertia.determinant() > 1e-9 * size * size * size;
        let spin = if turns { inertia.inverse() * lost } else { DVec3::ZERO };
        for i in 0..self.node_count() {
            let turned = self.state.v.get(i) + spin.cross(self.state.x.get(i) - centre);
            self.state.v.set(i, turned);
        }
        let drift = (old.momentum() - self.momentum()) / self.total_mass();
        for i in 0..self.node_count() {
            let moved = self.state.v.get(i) + drift;
            self.state.v.set(i, moved);
        }
    }

    /// Limit the kinetic energy to that of `old` minus the gain of elastic energy.
    pub(crate) fn limit_kinetic_energy_to(&mut self, old: &Self) {
        let (before, now) = (old.kinetic_elastic_energy(), self.kinetic_elastic_energy());
        let gained = (now.elastic - before.elastic).max(0.0);
        self.limit_kinetic_energy((before.kinetic - gained).max(0.0));
    }
}

pub(crate) fn vectors(list: &[DVec3]) -> Vectors {
    let mut all = Vectors::default();
    list.iter().for_each(|v| all.push(*v));
    all
}
