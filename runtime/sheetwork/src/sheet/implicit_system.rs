//! Equations of a sheet for implicit integrators: incremental potential, gradient, tangent matrix
//! and Newton step.
//!
//! The unknowns are three coordinates of each dynamic node, in order. The tangent is a symmetric
//! matrix of 3x3 blocks with the sparsity pattern of the elements. Its constant part (bending,
//! inertia, air; N/m) is stored, and the rest is added at every iterate. The row of a fixed
//! direction is a row of the identity.

use glam::{DMat3, DVec3};

use crate::elements::mixed_spring::MixedSprings;
use crate::elements::spring::{SpringWorkspace, Springs};
use crate::elements::{Anchor, Element, Geometric, NO_BLOCK};
use crate::integrators::implicit::{ImplicitProblem, StageProblem};
use crate::integrators::{AdvanceReport, Forces};
use crate::linear::ldl::IndefiniteFactor;
use crate::linear::{Factor, HalfSolutions, NotPositiveDefinite, Pattern, SparseLoads, analyse};
use crate::math::Vectors;
use crate::sheet::air_drag::AirDrag;
use crate::sheet::{Field, Sheet};

/// Linear system of a sheet with its workspace.
pub(crate) struct ImplicitSystem {
    /// Node of each block row, and block row of each node.
    masses: Vec<u32>,
    row: Vec<u32>,
    /// 1 for the free directions and 0 for the fixed directions of each block row.
    free: Vec<DVec3>,
    pattern: Pattern,
    factor: Factor,
    node_places: Vec<[f64; 2]>,
    /// Factor for unstable equilibria, created at the first one.
    indefinite: Option<Box<IndefiniteFactor>>,
    /// Constant part of the tangent (N/m), and its 1/h (1/s).
    constant: Vec<f64>,
    constant_at: Option<f64>,
    values: Vec<f64>,
    /// Whether the factor is that of the tangent without contact.
    is_factor_without_contact: bool,
    /// Tangent with contact.
    augmented: Vec<f64>,
    right: Vec<f64>,
    gradient: Vectors,
    /// Entries of `values` in rows and columns of fixed directions: those set to zero, and those
    /// set to one.
    zeros: Vec<u32>,
    ones: Vec<u32>,
    pub springs: MixedSprings,
}

impl ImplicitSystem {
    /// Build the system of `sheet` and bind its elements.
    pub fn new(sheet: &mut Sheet) -> Self {
        let mut springs = MixedSprings::new(&sheet.springs);
        let mut row = vec![NO_BLOCK; sheet.node_count()];
        let mut masses = Vec::new();
        for (i, w) in sheet.inverse_mass.iter().enumerate() {
            if *w > 0.0 {
                row[i] = masses.len() as u32;
                masses.push(i as u32);
            }
        }
        let mut pairs = Vec::new();
        let mut couple = |a: u32, b: u32| {
            let (a, b) = (row[a as usize], row[b as usize]);
            if a != NO_BLOCK && b != NO_BLOCK {
                pairs.push((a, b));
            }
        };
        springs.visit_coupled_nodes(&mut couple);
        sheet.elements.iter().for_each(|e| e.visit_coupled_nodes(&mut couple));
        let pattern = Pattern::new(masses.len(), pairs);
        let block = |a: u32, b: u32| {
            let (a, b) = (row[a as usize], row[b as usize]);
            if a == NO_BLOCK || b == NO_BLOCK { NO_BLOCK } else { pattern.slot(a, b).unwrap_or(NO_BLOCK) }
        };
        springs.bind_blocks(&block);
        sheet.elements.iter_mut().for_each(|e| e.bind_blocks(&block));
        let (nu, nv) = (f64::from(sheet.model.grid.0), f64::from(sheet.model.grid.2));
        let place = |m: &u32| {
            let (u, v) = sheet.model.uv[*m as usize];
            [u * nu, v * nv]
        };
        let places: Vec<[f64; 2]> = masses.iter().map(place).collect();
        let factor = analyse(&pattern, &places);
        let (zeros, ones) = held_entries(sheet, &pattern, &row);
        let mut free = vec![DVec3::ONE; masses.len()];
        for entry in &ones {
            let block = pattern.starts.partition_point(|s| *s <= entry / 9) - 1;
            free[block][(entry % 9) as usize / 4] = 0.0;
        }
        let numbers = 9 * pattern.blocks();
        Self {
            right: vec![0.0; 3 * masses.len()],
            gradient: Vectors::zeros(sheet.node_count()),
            constant: vec![0.0; numbers],
            constant_at: None,
            values: vec![0.0; numbers],
            is_factor_without_contact: false,
            augmented: Vec::new(),
            masses,
            row,
            free,
            pattern,
            factor,
            node_places: places,
            indefinite: None,
            zeros,
            ones,
            springs,
        }
    }

    /// Take over changed spring stiffnesses and invalidate the constant part.
    pub fn refresh(&mut self, springs: &Springs) {
        self.constant_at = None;
        self.springs.update_from(springs);
    }

    /// Invalidate the constant part after a change of forces or of the step.
    pub fn forget_constant(&mut self) {
        self.constant_at = None;
    }

    /// Node of each block row.
    pub fn masses(&self) -> &[u32] {
        &self.masses
    }

    /// 1 for a free and 0 for a fixed direction of each unknown.
    pub fn free_entries(&self) -> impl Iterator<Item = f64> + '_ {
        self.free.iter().flat_map(|f| f.to_array())
    }

    /// Index of the block of nodes `a` and `b`, a ≥ b; `None` for a fixed node or an uncoupled
    /// pair.
    pub fn block(&self, a: u32, b: u32) -> Option<u32> {
        let (a, b) = (self.block_row(a), self.block_row(b));
        if a == NO_BLOCK || b == NO_BLOCK { None } else { self.pattern.slot(a, b) }
    }

    /// Whether nodes `a` and `b`, a ≥ b, are dynamic and have no block.
    pub fn lacks_block(&self, a: u32, b: u32) -> bool {
        self.block_row(a) != NO_BLOCK && self.block_row(b) != NO_BLOCK && self.block(a, b).is_none()
    }

    /// Block row of node `i`; [`NO_BLOCK`] for a fixed node.
    pub fn block_row(&self, i: u32) -> u32 {
        self.row[i as usize]
    }

    /// 1 for the free directions and 0 for the fixed directions of block row `row`.
    pub fn free_axes(&self, row: u32) -> DVec3 {
        self.free[row as usize]
    }

    /// Add the half solutions of `loads` with the last factor.
    pub fn half_solve(&mut self, loads: &SparseLoads, solutions: &mut HalfSolutions) {
        self.factor.half_solve(loads, solutions);
    }

    /// Sparsity pattern of the tangent.
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Call `visit` with each block row and its gradient, N.
    pub fn for_each_gradient_row(&self, mut visit: impl FnMut(u32, DVec3)) {
        self.masses.iter().enumerate().for_each(|(row, mass)| visit(row as u32, self.gradient.get(*mass as usize)));
    }

    /// Last assembled tangent.
    pub fn tangent(&self) -> ContactTangent<'_> {
        ContactTangent { pattern: &self.pattern, values: &self.values }
    }

    /// Factorise the last assembled tangent with the entries that `add` adds; false when the sum is
    /// not positive definite.
    pub fn factorize_with(&mut self, add: &mut dyn FnMut(&mut [f64])) -> bool {
        self.is_factor_without_contact = false;
        self.augmented.clone_from(&self.values);
        add(&mut self.augmented);
        self.factor.factorize(&self.augmented).is_ok()
    }

    /// Factorise the last assembled tangent, unless the factor is that of this tangent.
    pub fn restore_factor(&mut self) {
        if !self.is_factor_without_contact {
            self.is_factor_without_contact = self.factorize_with(&mut |_| {});
        }
    }

    /// Solve with the last factor, in place.
    pub fn solve(&mut self, right: &mut [f64]) {
        self.factor.solve(right);
    }

    /// Name of the linear solver, block rows of the matrix, blocks of the matrix, nonzeros of the
    /// factor.
    pub fn statistics(&self) -> (&'static str, usize, usize, usize) {
        (self.factor.name(), self.masses.len(), self.pattern.blocks(), self.factor.nonzeros())
    }
}

/// Tangent to which contact adds entries.
pub(crate) struct ContactTangent<'a> {
    pattern: &'a Pattern,
    values: &'a [f64],
}

impl ContactTangent<'_> {
    /// Diagonal block of `row`, N/m.
    pub fn diagonal(&self, row: u32) -> DMat3 {
        let at = 9 * self.pattern.starts[row as usize] as usize;
        DMat3::from_cols_slice(&self.values[at..at + 9])
    }

    /// Sparsity pattern of the blocks.
    pub fn pattern(&self) -> &Pattern {
        self.pattern
    }

    /// Blocks, 9 numbers each, N/m.
    pub fn values(&self) -> &[f64] {
        self.values
    }
}

/// Entries of the rows and columns of fixed directions.
fn held_entries(sheet: &Sheet, pattern: &Pattern, row: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut held = vec![[false; 3]; pattern.size()];
    for (mass, axes) in sheet.pins.fixed_axes() {
        if row[mass as usize] != NO_BLOCK {
            let all = &mut held[row[mass as usize] as usize];
            all.iter_mut().zip(axes).for_each(|(held, axis)| *held |= axis);
        }
    }
    let (mut zeros, mut ones) = (Vec::new(), Vec::new());
    if held.iter().flatten().any(|h| *h) {
        for (slot, r, c) in pattern.iter() {
            for i in 0..3 {
                for j in 0..3 {
                    let entry = (9 * slot + 3 * i + j) as u32;
                    if held[r as usize][i] || held[c as usize][j] {
                        zeros.push(entry);
                        if r == c && i == j {
                            ones.push(entry);
                        }
                    }
                }
            }
        }
    }
    (zeros, ones)
}

/// Sheet as an implicit integrator sees it.
pub(crate) struct ImplicitSheet<'a> {
    pub field: Field,
    pub mass: &'a [f64],
    pub inverse_mass: &'a [f64],
    pub applied: &'a Vectors,
    pub pins: &'a crate::sheet::Pins,
    pub springs: &'a Springs,
    pub scratch: &'a mut SpringWorkspace,
    pub elements: &'a mut [Box<dyn Element>],
    pub system: &'a mut ImplicitSystem,
    pub drag: &'a mut AirDrag,
}

impl ImplicitSheet<'_> {
    fn elements_and_springs(&mut self) -> impl Iterator<Item = &mut dyn Element> {
        let springs: &mut dyn Element = &mut self.system.springs;
        std::iter::once(springs).chain(self.elements.iter_mut().map(|e| &mut **e as &mut dyn Element))
    }

    /// Assemble the constant part of the tangent for 1/h (1/s), unless it is up to date.
    fn constant(&mut self, per_time: f64) {
        if self.system.constant_at == Some(per_time) {
            return;
        }
        self.system.constant.fill(0.0);
        for element in self.elements.iter() {
            element.add_constant_tangent(per_time, &mut self.system.constant);
        }
        for (row, mass) in self.system.masses.iter().enumerate() {
            let m = self.mass[*mass as usize];
            let inertia = m * per_time * per_time + self.field.air * m * per_time;
            let at = 9 * self.system.pattern.starts[row] as usize;
            for i in [0, 4, 8] {
                self.system.constant[at + i] += inertia;
            }
        }
        self.system.constant_at = Some(per_time);
    }

    /// Start the elements without rates, with the stress at `x`.
    pub fn start(&mut self, x: &Vectors, still: &Vectors) {
        self.begin_stage(0.0, &[], 0.0, x, still);
        self.update_stress(x);
    }

    /// Assemble the tangent at `x`.
    fn assemble(&mut self, stage: &StageProblem, x: &Vectors, geometric: Geometric) {
        self.constant(stage.per_time);
        let mut values = std::mem::take(&mut self.system.values);
        values.copy_from_slice(&self.system.constant);
        self.elements_and_springs().for_each(|e| e.add_tangent(x, geometric, &mut values));
        let system = &mut *self.system;
        self.drag.add_tangent(stage, &system.masses, &system.pattern, &mut values);
        system.zeros.iter().for_each(|i| values[*i as usize] = 0.0);
        system.ones.iter().for_each(|i| values[*i as usize] = 1.0);
        system.values = values;
    }

    /// Factorise the tangent at `x`.
    ///
    /// # Errors
    /// When the tangent is not positive definite.
    pub fn factorize(
        &mut self,
        stage: &StageProblem,
        x: &Vectors,
        geometric: Geometric,
    ) -> Result<(), NotPositiveDefinite> {
        self.assemble(stage, x, geometric);
        self.system.is_factor_without_contact = true;
        self.system.factor.factorize(&self.system.values)
    }

    /// Assemble the gradient and the positive definite tangent at `x`.
    pub fn linearise(&mut self, stage: &StageProblem, x: &Vectors) {
        self.gradient(stage, x);
        self.pins.zero_fixed_axes(&mut self.system.gradient);
        self.assemble(stage, x, Geometric::Clipped);
        self.system.is_factor_without_contact = false;
    }

    /// Compute g = ∇Φ (N) into the system's gradient; entries of fixed nodes are undefined.
    fn gradient(&mut self, stage: &StageProblem, x: &Vectors) {
        let mut g = std::mem::take(&mut self.system.gradient);
        let (inertia, air) = (stage.per_time * stage.per_time, self.field.air * stage.per_time);
        let gravity = self.field.gravity.to_array();
        let axes = g.axes_mut().into_iter().zip(x.axes()).zip(stage.y.axes()).zip(stage.w.axes());
        for ((((g, x), y), w), (applied, gravity)) in axes.zip(self.applied.axes().into_iter().zip(gravity)) {
            for i in 0..g.len() {
                let m = self.mass[i];
                g[i] = m * (inertia * (x[i] - y[i]) + air * (x[i] - w[i]) - gravity) - applied[i];
            }
        }
        self.drag.add_gradient(stage, x, &mut g);
        self.elements_and_springs().for_each(|e| e.add_gradient(x, &mut g));
        self.system.gradient = g;
    }
}

impl Forces for ImplicitSheet<'_> {
    fn accelerations(&mut self, _t: f64, x: &Vectors, v: &Vectors, a: &mut Vectors) {
        ImplicitProblem::accelerations(self, x, v, a);
    }

    fn implicit(&mut self) -> Option<&mut dyn ImplicitProblem> {
        Some(self)
    }
}

impl ImplicitProblem for ImplicitSheet<'_> {
    fn begin_stage(&mut self, per_time: f64, anchors: &[Anchor], follow: f64, x: &Vectors, v: &Vectors) {
        self.elements_and_springs().for_each(|e| e.begin_stage(per_time, anchors, follow));
        self.drag.begin(&self.field, x, v);
    }

    fn finish_stage(&mut self, x: &Vectors) {
        self.elements_and_springs().for_each(|e| e.finish_stage(x));
    }

    fn undo_arms(&mut self) {
        self.elements.iter_mut().filter_map(|e| e.arms_mut()).for_each(|arms| arms.undo_stage());
    }

    fn reset_rates(&mut self) {
        self.elements_and_springs().for_each(|e| e.reset_rates());
    }

    fn potential(&mut self, stage: &StageProblem, x: &Vectors) -> f64 {
        let mut sum = self.inertial_potential(stage, x);
        let gravity = self.field.gravity;
        for i in 0..x.len() {
            if self.inverse_mass[i] > 0.0 {
                let m = self.mass[i];
                sum -= (gravity * m + self.applied.get(i)).dot(x.get(i));
            }
        }
        if self.field.air > 0.0 && stage.per_time > 0.0 {
            let scale = 0.5 * self.field.air * stage.per_time;
            for i in 0..x.len() {
                if self.inverse_mass[i] > 0.0 {
                    sum += scale * self.mass[i] * x.get(i).distance_squared(stage.w.get(i));
                }
            }
        }
        sum += self.drag.potential(stage, x);
        sum + self.elements_and_springs().map(|e| e.potential(x)).sum::<f64>()
    }

    fn inertial_potential(&self, stage: &StageProblem, x: &Vectors) -> f64 {
        let mut sum = 0.0;
        for i in 0..x.len() {
            if self.inverse_mass[i] > 0.0 {
                sum += self.mass[i] * x.get(i).distance_squared(stage.y.get(i));
            }
        }
        0.5 * sum * stage.per_time * stage.per_time
    }

    fn kinetic_energy_at(&self, speed: f64) -> f64 {
        0.5 * self.mass.iter().sum::<f64>() * speed * speed
    }

    fn has_dynamic_attachments(&self) -> bool {
        self.pins.has_dynamic_attachments()
    }

    fn pressure_work(&self, from: &Vectors, to: &Vectors) -> f64 {
        self.drag.pushed(from, to)
    }

    fn newton_direction(
        &mut self,
        stage: &StageProblem,
        x: &Vectors,
        geometric: Geometric,
        d: &mut Vectors,
    ) -> Result<f64, NotPositiveDefinite> {
        self.gradient(stage, x);
        self.assemble(stage, x, geometric);
        self.pins.zero_fixed_axes(&mut self.system.gradient);
        let system = &mut *self.system;
        for (right, mass) in system.right.chunks_exact_mut(3).zip(&system.masses) {
            right.copy_from_slice(&system.gradient.get(*mass as usize).to_array());
        }
        system.is_factor_without_contact = true;
        if system.factor.factorize_and_solve(&system.values, &mut system.right).is_err() {
            // Newton's method also finds unstable equilibria; their tangent is indefinite.
            if stage.per_time > 0.0 || geometric == Geometric::Clipped {
                return Err(NotPositiveDefinite);
            }
            let factor = system
                .indefinite
                .get_or_insert_with(|| Box::new(IndefiniteFactor::new(&system.pattern, &system.node_places)));
            for (right, mass) in system.right.chunks_exact_mut(3).zip(&system.masses) {
                right.copy_from_slice(&system.gradient.get(*mass as usize).to_array());
            }
            factor.factorize_and_solve(&system.values, &mut system.right)?;
        }
        d.clear();
        let mut slope = 0.0;
        for (step, mass) in system.right.chunks_exact(3).zip(&system.masses) {
            let step = -DVec3::from_slice(step);
            d.set(*mass as usize, step);
            slope += step.dot(system.gradient.get(*mass as usize));
        }
        Ok(slope)
    }

    fn predict_stress(&mut self, x: &Vectors, d: &Vectors) -> f64 {
        self.elements_and_springs().map(|e| e.predict_stress(x, d)).sum()
    }

    fn update_stress(&mut self, x: &Vectors) {
        self.elements_and_springs().for_each(|e| e.update_stress(x));
    }

    fn zero_prescribed(&self, a: &mut Vectors) {
        for (i, w) in self.inverse_mass.iter().enumerate() {
            if *w == 0.0 {
                a.set(i, DVec3::ZERO);
            }
        }
        self.pins.zero_fixed_axes(a);
    }

    fn copy_prescribed(&self, x: &Vectors, to: &mut Vectors) {
        for (i, w) in self.inverse_mass.iter().enumerate() {
            if *w == 0.0 {
                to.set(i, x.get(i));
            }
        }
        self.pins.copy_fixed_axes(x, to);
    }

    fn accelerations(&mut self, x: &Vectors, v: &Vectors, a: &mut Vectors) -> f64 {
        a.clear();
        self.springs.add_forces(x, v, self.springs.is_damped(), self.scratch, a);
        self.elements.iter_mut().for_each(|e| e.add_forces(x, v, a));
        let mut own = 0.0_f64;
        for i in 0..a.len() {
            let f = a.get(i) * self.inverse_mass[i];
            own = own.max(f.length());
            let free = self.inverse_mass[i] > 0.0;
            let outer = self.field.gravity - v.get(i) * self.field.air + self.applied.get(i) * self.inverse_mass[i];
            a.set(i, if free { f + outer } else { DVec3::ZERO });
        }
        self.drag.add_buoyancy(self.inverse_mass, a);
        own
    }
}

/// Call `work` with the sheet as an implicit integrator sees it.
pub(crate) fn with_implicit_sheet<R>(
    sheet: &mut Sheet,
    field: Field,
    system: &mut ImplicitSystem,
    work: impl FnOnce(&mut ImplicitSheet) -> R,
) -> R {
    let mut problem = ImplicitSheet {
        field,
        mass: &sheet.model.mass,
        inverse_mass: &sheet.inverse_mass,
        applied: &sheet.parameters.applied,
        pins: &sheet.pins,
        springs: &sheet.springs,
        scratch: &mut sheet.work.springs,
        elements: &mut sheet.elements,
        system,
        drag: &mut sheet.parameters.drag,
    };
    work(&mut problem)
}

/// Advance by an implicit integrator; see [`advance`](crate::sheet::accelerations::advance).
pub(crate) fn advance_implicit(sheet: &mut Sheet, field: Field, t: f64, dt: f64) -> AdvanceReport {
    prepare_implicit(sheet, field);
    let Some(mut system) = sheet.system.take() else { return AdvanceReport::default() };
    // Moved out for the step, so that they are borrowed separately from the rest of the sheet.
    let (mut x, mut v) = (std::mem::take(&mut sheet.state.x), std::mem::take(&mut sheet.state.v));
    let mut engine = std::mem::replace(&mut sheet.engine, Box::new(crate::integrators::IdleIntegrator));
    let done = with_implicit_sheet(sheet, field, &mut system, |problem| engine.advance(problem, t, dt, &mut x, &mut v));
    (sheet.state.x, sheet.state.v, sheet.engine, sheet.system) = (x, v, engine, Some(system));
    done
}

/// Build the linear system where there is none, and restart the elements after an explicit
/// integrator or a change of the field.
pub(crate) fn prepare_implicit(sheet: &mut Sheet, field: Field) {
    let mut system = sheet.system.take().unwrap_or_else(|| Box::new(ImplicitSystem::new(sheet)));
    if sheet.last_field.is_none() {
        let (x, v) = (std::mem::take(&mut sheet.state.x), std::mem::take(&mut sheet.state.v));
        with_implicit_sheet(sheet, field, &mut system, |problem| {
            problem.reset_rates();
            problem.start(&x, &v);
        });
        (sheet.state.x, sheet.state.v) = (x, v);
    }
    if sheet.last_field != Some(field) {
        system.forget_constant();
        sheet.last_field = Some(field);
    }
    sheet.system = Some(system);
}
