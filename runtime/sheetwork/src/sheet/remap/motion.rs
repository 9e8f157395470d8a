//! Remapping of positions and velocities to another grid, for shells; `lattice` does so for
//! lattices.

use glam::{DMat3, DVec3};

use crate::elements::remap::{Carry, Grids, Meshes};
use crate::math::Vectors;
use crate::mesh::structure::StructureKind;
use crate::scene::SheetSpec;
use crate::sheet::Sheet;
use crate::sheet::remap::spline::Surface;
use crate::sheet::remap::strain::Mesh;

/// Tolerance on the distance of a node from its pin, relative to the length of the sheet, for
/// rounding.
pub(crate) const OFF: f64 = 1e-9;

impl Sheet {
    fn edges_of_grid(&self) -> Mesh {
        let [columns, rows] = self.masses_along();
        let spacing = (self.extent.0 / (columns - 1) as f64, self.extent.1 / (rows - 1) as f64);
        Mesh { columns, rows, spacing, triangular: false }
    }

    /// Whether it is a shell on a grid.
    fn is_grid(&self) -> bool {
        self.structure == StructureKind::Shell && self.triangles.is_none() && self.elements.len() > self.pulls.len()
    }

    /// Positions of the nodes of another grid, m; the present positions where the grid is the same
    /// or cannot change.
    pub fn places_at(&self, grid: (u32, u32)) -> std::borrow::Cow<'_, Vectors> {
        let [columns, rows] = self.masses_along();
        let to = (grid.0 as usize, grid.1 as usize);
        if let Some((mesh, first)) = self.meshes_to(grid) {
            let x: Vec<DVec3> = self.x.iter().collect();
            return std::borrow::Cow::Owned(vectors(&self.patches(mesh, false).read(first, &x, [DVec3::ZERO; 2])));
        }
        if to == (columns, rows) || !(self.is_grid() || self.is_lattice()) {
            return std::borrow::Cow::Borrowed(&self.x);
        }
        if self.is_lattice() {
            return self.layers_at(grid).map_or(std::borrow::Cow::Borrowed(&self.x), std::borrow::Cow::Owned);
        }
        let surface = Surface {
            from: (columns, rows),
            to,
            clamped: &vec![false; self.masses()],
            staggered: false,
            folds: &self.folds,
        };
        std::borrow::Cow::Owned(vectors(&surface.read(&self.x, [DVec3::ZERO; 2])))
    }

    /// Nodal `values` interpolated at the nodes of another grid.
    pub fn values_at<'a>(&self, grid: (u32, u32), values: &'a [f64]) -> std::borrow::Cow<'a, [f64]> {
        let (from, to) = (self.masses_along(), [grid.0 as usize, grid.1 as usize]);
        if let Some((mesh, first)) = self.meshes_to(grid) {
            return std::borrow::Cow::Owned(Carry::Mesh(Meshes::new(mesh, first)).at_masses(values));
        }
        if from == to || !(self.is_grid() || self.is_lattice()) {
            return std::borrow::Cow::Borrowed(values);
        }
        if self.is_lattice() {
            return self
                .layer_values_at(grid, values)
                .map_or(std::borrow::Cow::Borrowed(values), std::borrow::Cow::Owned);
        }
        std::borrow::Cow::Owned(Carry::Grid(Grids { from, to }).at_masses(values))
    }

    /// Remap positions and velocities of `old`, with its strains and rates of strain.
    pub(crate) fn take_motion_of(&mut self, old: &Self, spec: &SheetSpec, time: f64) {
        if self.structure != StructureKind::Shell {
            return self.take_layers_of(old, spec, time);
        }
        let (before, now) = (old.edges_of_grid(), self.edges_of_grid());
        let surface = Surface {
            from: (before.columns, before.rows),
            to: (now.columns, now.rows),
            clamped: &old.clamped,
            staggered: false,
            folds: &old.folds,
        };
        let rotation = spec.placement.quaternion();
        let clamp = [rotation * DVec3::X * before.spacing.0, rotation * DVec3::Z * before.spacing.1];
        self.x = vectors(&surface.read(&old.x, clamp));
        self.pins.anchor(time, &mut self.x, OFF * self.length);
        let held: Vec<bool> = self.inverse_mass.iter().map(|w| *w == 0.0).collect();
        let (was, were): (Vec<DVec3>, Vec<DVec3>) = (old.x.iter().collect(), old.v.iter().collect());
        let mut x: Vec<DVec3> = self.x.iter().collect();
        now.approach(&mut x, &before.read(&before.strains(&was), &now), &held);
        self.x = vectors(&x);
        self.pins.anchor(time, &mut self.x, OFF * self.length);
        if old.v.max_squared() == 0.0 {
            self.v = Vectors::zeros(self.masses());
            return;
        }
        let mut v = surface.read(&old.v, [DVec3::ZERO; 2]);
        now.approach_rates(&x, &mut v, &before.read(&before.rates(&was, &were), &now), &held);
        self.v = vectors(&v);
        self.pins.hold_rails(&mut self.v);
        self.keep_momentum(old);
    }

    /// Set the momentum and angular momentum of `old`, for a sheet without pins.
    pub(crate) fn keep_momentum(&mut self, old: &Self) {
        if !self.pins.is_empty() {
            return;
        }
        let centre = self.centre_of_mass();
        let (mut inertia, mut size) = (DMat3::ZERO, 0.0);
        for (x, m) in self.x.iter().zip(&self.mass) {
            let r = x - centre;
            inertia += (DMat3::from_diagonal(DVec3::splat(r.length_squared()))
                - DMat3::from_cols(r * r.x, r * r.y, r * r.z))
                * *m;
            size += m * r.length_squared();
        }
        let lost = old.angular_momentum() - self.angular_momentum();
        let turns = inertia.determinant() > 1e-9 * size * size * size;
        let spin = if turns { inertia.inverse() * lost } else { DVec3::ZERO };
        for i in 0..self.masses() {
            let turned = self.v.get(i) + spin.cross(self.x.get(i) - centre);
            self.v.set(i, turned);
        }
        let drift = (old.momentum() - self.momentum()) / self.total_mass();
        for i in 0..self.masses() {
            let moved = self.v.get(i) + drift;
            self.v.set(i, moved);
        }
    }

    /// Limit the kinetic energy to that of `old` minus the gain of elastic energy.
    pub(crate) fn bound_energy(&mut self, old: &Self) {
        let (before, now) = (old.level(), self.level());
        let gained = (now.elastic - before.elastic).max(0.0);
        self.slow_down((before.motion - gained).max(0.0));
    }
}

pub(crate) fn vectors(list: &[DVec3]) -> Vectors {
    let mut all = Vectors::default();
    list.iter().for_each(|v| all.push(*v));
    all
}
