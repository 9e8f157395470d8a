//! Where the masses of a lattice are on its new grid, and how they move.
//!
//! The bottom layer, which is the one that is drawn, is read by splines; the others stand on it as they did (`layers`). Then the bottom layer moves by the least
//! that brings the mean stretch of all layers to what it was (`membrane`), and the others move with it: how much layers differ is the bend, which is
//! that of the surface. What is held is where its pins have it, in every layer.

use glam::DVec3;

use super::super::{Sheet, Vectors};
use super::layers::Layout;
use super::membrane::Membrane;
use super::motion::vectors;
use super::spline::Surface;
use super::strain::Mesh;
use crate::lattice::{Layer, StructureKind};
use crate::scene::SheetSpec;

/// Rounds of bringing the stretch to what it was: it is nearly linear.
const ROUNDS: usize = 3;

/// The bottom layer as edges with strains.
fn mesh(layout: &Layout) -> Mesh {
    let (step, bottom) = (layout.step(), layout.layers[0]);
    let spacing = (step.0 * layout.extent.0, step.1 * layout.extent.1);
    Mesh { columns: bottom.nx as usize, rows: bottom.nz as usize, spacing, triangular: bottom.triangular }
}

/// The bottom layer of `old` at the masses of that of `new`, with room for the others.
fn surface(old: &Layout, new: &Layout, values: &Vectors) -> Vec<DVec3> {
    let size = |l: &Layer| (l.nx as usize, l.nz as usize);
    let (from, to) = (size(&old.layers[0]), size(&new.layers[0]));
    let clamped = vec![false; from.0 * from.1];
    let staggered = old.is_triangular();
    let surface = Surface { from, to, clamped: &clamped, staggered, folds: &Default::default() };
    let mut all = surface.read(values, [DVec3::ZERO; 2]);
    all.resize(new.len(), DVec3::ZERO);
    all
}

impl Sheet {
    /// Whether it is a lattice that can go to another grid.
    pub(super) fn is_lattice(&self) -> bool {
        self.structure != StructureKind::Shell && !self.springs.is_empty() && self.triangles.is_none()
    }

    /// Where its masses would be on another grid, m; none where there is no such grid.
    pub(super) fn layers_at(&self, grid: (u32, u32)) -> Option<Vectors> {
        let (old, new) = (Layout::of(self), Layout::at(self, grid).ok()?);
        let x: Vec<DVec3> = self.x.iter().collect();
        let mut all = surface(&old, &new, &self.x);
        new.stand(&new.read(&old.offsets(&x, &vec![DVec3::ZERO; x.len()])), &mut all);
        Some(vectors(&all))
    }

    /// What `values`, one a mass, are at those places.
    pub(super) fn layer_values_at(&self, grid: (u32, u32), values: &[f64]) -> Option<Vec<f64>> {
        let (old, new) = (Layout::of(self), Layout::at(self, grid).ok()?);
        let values: Vec<[f64; 1]> = values.iter().map(|v| [*v]).collect();
        Some(new.means(&old, &values).into_iter().map(|[v]| v).collect())
    }

    /// Puts masses on the layers of `old`, as stretched and moving as those.
    pub(super) fn take_layers_of(&mut self, old: &Self, spec: &SheetSpec, time: f64) {
        let (before, now) = (Layout::of(old), Layout::of(self));
        self.take_pins_of(old, spec, (&before, &now));
        let (was, were): (Vec<DVec3>, Vec<DVec3>) = (old.x.iter().collect(), old.v.iter().collect());
        let offsets = now.read(&before.offsets(&was, &were));
        let mesh = mesh(&now);
        let bottom = mesh.columns * mesh.rows;
        let held: Vec<bool> = self.inverse_mass[..bottom].iter().map(|w| *w == 0.0).collect();
        let middle = |masses: &[usize]| {
            let part = 1.0 / masses.len() as f64;
            masses.iter().fold((0.0, 0.0), |(u, v), m| (u + part * now.uv[*m].0, v + part * now.uv[*m].1))
        };
        // Along the surface alone: across it layers would make strain of every ripple.
        let along = |normals: &[DVec3]| {
            let normals = normals.to_vec();
            let held = &held;
            move |i: usize, d: DVec3| if held[i] { DVec3::ZERO } else { d - normals[i] * normals[i].dot(d) }
        };
        let minus = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|k| a[k] - b[k]);

        let mut x = surface(&before, &now, &old.x);
        let wanted = Membrane::strains(&before, &was);
        for _ in 0..ROUNDS {
            self.stand_on_pins(&now, &offsets, &mut x, time);
            let own = Membrane::strains(&now, &x);
            let change = mesh.of_field(|e| minus(wanted.read(middle(e)), own.read(middle(e))));
            let d = mesh.answer_within(&x[..bottom], &change, along(&now.normals(&x)));
            x.iter_mut().zip(&d).for_each(|(x, d)| *x += *d);
        }
        self.stand_on_pins(&now, &offsets, &mut x, time);
        if old.v.max_squared() == 0.0 {
            self.v = Vectors::zeros(self.masses());
            return;
        }
        let mut v = surface(&before, &now, &old.v);
        now.follow(&offsets, &x, &mut v);
        let (wanted, own) = (Membrane::rates(&before, &was, &were), Membrane::rates(&now, &x, &v));
        let change = mesh.of_field(|e| minus(wanted.read(middle(e)), own.read(middle(e))));
        let d = mesh.answer_within(&x[..bottom], &change, along(&now.normals(&x)));
        v.iter_mut().zip(&d).for_each(|(v, d)| *v += *d);
        now.follow(&offsets, &x, &mut v);
        self.v = vectors(&v);
        self.lead_pinned(old, (&before, &now));
        self.keep_momentum(old);
    }

    /// Stands the upper layers on the bottom one at `x` (m), what is pinned where its pins have it at `time` (s).
    fn stand_on_pins(&mut self, layout: &Layout, offsets: &[[f64; 6]], x: &mut [DVec3], time: f64) {
        let mut place = |x: &mut [DVec3]| {
            self.x = vectors(x);
            self.pins.place(time, &mut self.x);
            x.iter_mut().zip(self.x.iter()).for_each(|(to, from)| *to = from);
        };
        place(x);
        layout.stand(offsets, x);
        place(x);
    }
}
