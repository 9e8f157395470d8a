//! Flexion limit and contact solved together at the end of a step.
//!
//! The bend of a triple is the vector κ = u₂ - u₁ of its unit vectors, |κ| = 2 sin(θ/2). The
//! limit is a disc: |κ| ≤ R = 2 sin(θ_max/2). A free motion to (x*, v*) in a step of h (s) from
//! x₀ and impulses P on triples and contacts give, with the inverse masses W and the gradient G
//! of κ,
//!
//!   y = W (Gᵀ Λ + p),  x = x* + ϑ h y,  v = v* + y,
//!
//! ϑ being the weight of an acceleration in the displacement of the integrator. Two stages solve
//! for the same Λ and p:
//!
//! 1. positions: κ(x₀) + G (x - x₀) in its disc, contact gaps at least 0, points in contact
//!    carried along by the surface within the friction bound;
//! 2. velocities: κ(x) + G v h in its disc, no approach at closed contacts, friction.
//!
//! A layered sheet has its thickness limit in both stages too: the height of a node above its cell
//! ([`crate::elements::thickness_limit`]) as a further inequality.
//!
//! Both are projected Gauss-Seidel iterations: the impulse of a triple is the one that places the
//! end of its own κ on the disc, hence opposite to κ at the end. For a nearly straight triple the
//! direction of κ turns with a small motion across it, which makes a stiffness Λ/|κ| that an
//! explicit treatment of the direction would integrate beyond its stability limit. Impulses are
//! totals: a triple never pulls, whatever earlier iterations did, and the totals of the last step
//! are the start of the next one, so that a sheet at rest is a fixed point.
//!
//! The remainder of the linearisation (`FlexionSettings::angle_slack`) is taken out of positions
//! alone, so that it adds no velocity.

use glam::DVec3;

use crate::elements::flexion_limit::{FlexionLimit, bend};
use crate::elements::thickness_limit::{CellHeight, ThicknessLimit};
use crate::math::Vectors;
use crate::units::settings::settings;

settings! {
    /// Settings of the flexion limit.
    pub struct FlexionSettings {
        /// Change of an angle (rad) in an iteration below which the iteration ends.
        pub tolerance: f64 = 1e-4,
        /// Maximum number of iterations of each stage.
        pub maximum_iterations: usize = 200,
        /// Angle (rad) beyond the limit that stays in the positions.
        pub angle_slack: f64 = 3.5e-3,
        /// Maximum number of iterations over the positions.
        pub maximum_position_iterations: usize = 20,
        /// Angle (rad) below the limit from which a triple takes part in the solve.
        pub margin: f64 = 0.087,
        /// Bend |κ| below which its direction is rounding error.
        pub straight: f64 = 1e-9,
    }
}

const SETTINGS: FlexionSettings = FlexionSettings::DEFAULT;

/// Total impulses of a triple in one step, kg m²/s: both components in each stage.
pub type TripleImpulses = [[f64; 2]; 2];

/// Contact of a point of the sheet with a surface, or with another point of the sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LimitContact {
    /// Nodes; the first `count` of them count.
    pub nodes: [u32; 6],
    /// Weights of the nodes in the point; negative for the other point of a self-contact.
    pub weights: [f64; 6],
    /// Number of nodes.
    pub count: usize,
    /// Unit normal, towards the point.
    pub normal: DVec3,
    /// Velocity of the surface, m/s.
    pub velocity: DVec3,
    /// Position of the surface along the normal at the end of the step, contact offset included, m.
    pub level: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// Whether the contact began with a rebound in this step: its impulse is not taken back, and
    /// the tangential motion before the rebound is free.
    pub rebounds: bool,
    /// Total normal (N s) and tangential (N s) impulse.
    pub impulse: (f64, DVec3),
}

impl LimitContact {
    /// Contact of node `i`.
    pub fn of_node(i: u32, normal: DVec3, level: f64) -> Self {
        let (mut nodes, mut weights) = ([0; 6], [0.0; 6]);
        (nodes[0], weights[0]) = (i, 1.0);
        Self { nodes, weights, count: 1, normal, level, ..Self::default() }
    }

    /// Add node `i` with `weight` to the point.
    pub fn add_term(&mut self, i: u32, weight: f64) {
        if let Some((node, own)) = self.nodes.get_mut(self.count).zip(self.weights.get_mut(self.count)) {
            (*node, *own) = (i, weight);
            self.count += 1;
        }
    }

    /// Nodes and weights.
    fn terms(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.nodes[..self.count].iter().map(|i| *i as usize).zip(self.weights)
    }

    /// The combination of `of` that the weights make.
    fn at(&self, of: impl Fn(usize) -> DVec3) -> DVec3 {
        self.terms().map(|(i, w)| of(i) * w).sum()
    }
}

/// A contact in a stage: wanted normal and tangential rates, and the compliances 1/kg.
#[derive(Clone, Copy, Debug)]
struct ContactRow {
    target: f64,
    drift: DVec3,
    compliance: (f64, f64),
}

/// A triple in a stage, in the plane of two directions across it.
#[derive(Clone, Copy, Debug)]
struct TripleRow {
    index: usize,
    nodes: [usize; 3],
    /// Gradient of both components of κ with respect to the nodes, 1/m.
    gradient: [[DVec3; 3]; 2],
    /// Largest compliance of a component, 1/(kg m²).
    compliance: f64,
    /// κ without the impulses of the stage, and the radius of its disc.
    bend: [f64; 2],
    radius: f64,
    /// Total impulse, kg m²/s.
    impulse: [f64; 2],
}

impl TripleRow {
    /// Row of `nodes` at `x`; `None` without directions.
    fn new(index: usize, nodes: [usize; 3], x: &Vectors, mobility: &[DVec3]) -> Option<Self> {
        let [a, b, c] = nodes.map(|i| x.get(i));
        let ((u1, l1), (u2, l2)) = ((b - a).normalize_and_length(), (c - b).normalize_and_length());
        if l1 <= 0.0 || l2 <= 0.0 {
            return None;
        }
        let kappa = u2 - u1;
        let first = if kappa.length() > SETTINGS.straight { kappa.normalize() } else { u1.any_orthonormal_vector() };
        let across = if kappa.length() > SETTINGS.straight { u1.cross(u2) } else { u1.cross(first) };
        let second = across.try_normalize().unwrap_or_else(|| u1.any_orthonormal_vector());
        let gradient = [first, second].map(|e| {
            let (p1, p2) = ((e - u1 * u1.dot(e)) / l1, (e - u2 * u2.dot(e)) / l2);
            [p1, -(p1 + p2), p2]
        });
        let compliance = gradient.map(|g| (0..3).map(|k| (g[k] * g[k]).dot(mobility[nodes[k]])).sum::<f64>());
        let (compliance, bend) = (compliance[0].max(compliance[1]), [kappa.dot(first), kappa.dot(second)]);
        Some(Self { index, nodes, gradient, compliance, bend, radius: 0.0, impulse: [0.0; 2] })
    }

    /// Rate of both components for the node rates `of`.
    #[inline]
    fn rate(&self, of: impl Fn(usize) -> DVec3) -> [f64; 2] {
        let y = [of(self.nodes[0]), of(self.nodes[1]), of(self.nodes[2])];
        self.gradient.map(|g| g[0].dot(y[0]) + g[1].dot(y[1]) + g[2].dot(y[2]))
    }

    /// Apply an `impulse` to the node rates `y`.
    #[inline]
    fn apply(&self, impulse: [f64; 2], y: &mut [DVec3], mobility: &[DVec3]) {
        for k in 0..3 {
            let push = self.gradient[0][k] * impulse[0] + self.gradient[1][k] * impulse[1];
            y[self.nodes[k]] -= push * mobility[self.nodes[k]];
        }
    }

    /// Relax the row in a stage of `h` (s). Returns the change of κ.
    #[inline]
    fn relax(&mut self, y: &mut [DVec3], mobility: &[DVec3], h: f64) -> f64 {
        let rate = self.rate(|i| y[i]);
        let per_bend = 1.0 / (h * self.compliance);
        let free = [0, 1].map(|e| self.impulse[e] + per_bend * (self.bend[e] + h * rate[e]));
        let size = free[0].hypot(free[1]);
        let kept = if size > 0.0 { (1.0 - self.radius * per_bend / size).max(0.0) } else { 0.0 };
        let total = free.map(|f| f * kept);
        let change = [total[0] - self.impulse[0], total[1] - self.impulse[1]];
        self.impulse = total;
        self.apply(change, y, mobility);
        change[0].hypot(change[1]) * self.compliance * h
    }
}

/// A cell of the thickness limit in a stage.
#[derive(Clone, Copy, Debug)]
struct CellRow {
    index: usize,
    height: CellHeight,
    /// Smallest rate, m/s, and compliance, 1/kg.
    target: f64,
    compliance: f64,
    /// Total impulse, N s.
    impulse: f64,
}

impl CellRow {
    /// Rate of the height for the node rates `of`, m/s.
    fn rate(height: &CellHeight, of: impl Fn(usize) -> DVec3) -> f64 {
        height.nodes.iter().zip(&height.gradient).map(|(i, g)| g.dot(of(*i as usize))).sum()
    }

    /// Apply an `impulse` to the node rates `y`.
    fn apply(&self, impulse: f64, y: &mut [DVec3], mobility: &[DVec3]) {
        for (i, g) in self.height.nodes.iter().zip(&self.height.gradient) {
            y[*i as usize] += *g * impulse * mobility[*i as usize];
        }
    }

    /// Relax the row. Returns the change of its rate, m/s.
    fn relax(&mut self, y: &mut [DVec3], mobility: &[DVec3]) -> f64 {
        let rate = Self::rate(&self.height, |i| y[i]);
        let total = (self.impulse + (self.target - rate) / self.compliance).max(0.0);
        let change = total - self.impulse;
        self.impulse = total;
        self.apply(change, y, mobility);
        change.abs() * self.compliance
    }
}

/// Impulses of both stages of a step, for the start of the next one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LimitImpulses {
    /// Triples, kg m²/s.
    pub triples: Vec<TripleImpulses>,
    /// Cells of the thickness limit, N s.
    pub cells: Vec<[f64; 2]>,
}

impl LimitImpulses {
    /// No impulse on `triples` triples and `cells` cells.
    pub fn reset(&mut self, triples: usize, cells: usize) {
        self.triples.clear();
        self.triples.resize(triples, TripleImpulses::default());
        self.cells.clear();
        self.cells.resize(cells, [0.0; 2]);
    }

    /// Set all impulses to zero.
    pub fn clear(&mut self) {
        self.triples.fill(TripleImpulses::default());
        self.cells.fill([0.0; 2]);
    }

    /// Copy from `other`, reusing the allocations.
    pub fn copy_from(&mut self, other: &Self) {
        self.triples.clone_from(&other.triples);
        self.cells.clone_from(&other.cells);
    }

    /// All numbers, for a snapshot.
    pub fn numbers(&self) -> [&[f64]; 2] {
        [self.triples.as_flattened().as_flattened(), self.cells.as_flattened()]
    }

    /// All numbers, mutable.
    pub fn numbers_mut(&mut self) -> [&mut [f64]; 2] {
        [self.triples.as_flattened_mut().as_flattened_mut(), self.cells.as_flattened_mut()]
    }
}

/// A step of a sheet whose limit is to be held.
#[derive(Clone, Copy, Debug)]
pub struct LimitedStep<'a> {
    /// Positions at the start, m.
    pub start: &'a Vectors,
    /// Positions (m) and velocities (m/s) at the end of the motion without limit.
    pub free: (&'a Vectors, &'a Vectors),
    /// Length, s.
    pub dt: f64,
    /// Weight of an acceleration in the displacement of the integrator.
    pub drift: f64,
}

/// Arrays of the solve. They persist, so that a warm step does not allocate.
#[derive(Clone, Debug, Default)]
pub struct FlexionWorkspace {
    /// Whether the last step had limit and contact solved together.
    pub is_coupled: bool,
    /// Length of the last step, s.
    pub dt: f64,
    /// Contacts of the step.
    pub contacts: Vec<LimitContact>,
    /// Positions (m) and velocities (m/s) at the end of the motion without limit.
    pub free: (Vectors, Vectors),
    /// Impulses of the last step.
    pub start_impulses: LimitImpulses,
    /// Inverse mass of each node along each axis, 1/kg.
    pub mobility: Vec<DVec3>,
    /// Gradient of a bend, 1/m, by which rates of points count as rates of angles.
    per_length: f64,
    /// Rates of the nodes, m/s.
    y: Vec<DVec3>,
    rows: Vec<TripleRow>,
    cell_rows: Vec<CellRow>,
    contact_rows: Vec<ContactRow>,
}

impl FlexionWorkspace {
    /// Reserve memory for a sheet of `nodes` nodes, `triples` triples and `cells` cells.
    pub fn reserve(&mut self, nodes: usize, triples: usize, cells: usize) {
        if self.y.len() != nodes {
            self.y = vec![DVec3::ZERO; nodes];
            self.contacts.reserve(2 * nodes);
            self.contact_rows.reserve(2 * nodes);
        }
        self.rows.reserve(triples.saturating_sub(self.rows.len()));
        self.cell_rows.reserve(cells.saturating_sub(self.cell_rows.len()));
    }

    /// Hold the limits and the contacts of this workspace in `step`, and leave the end in `x` (m)
    /// and `v` (m/s). `impulses` are the totals: start values, and the result.
    pub fn solve(
        &mut self,
        limits: (&FlexionLimit, Option<&ThicknessLimit>),
        step: &LimitedStep,
        (x, v): (&mut Vectors, &mut Vectors),
        impulses: &mut LimitImpulses,
    ) {
        self.solve_positions(limits, step, x, impulses);
        self.solve_velocities(limits, step.dt, x, impulses);
        self.y.iter().enumerate().for_each(|(i, y)| v.set(i, *y));
        self.correct_positions(limits.0, x);
    }

    /// First stage: leave the positions in `x` (m) and the velocities in the rates.
    fn solve_positions(
        &mut self,
        (limit, thickness): (&FlexionLimit, Option<&ThicknessLimit>),
        step: &LimitedStep,
        x: &mut Vectors,
        impulses: &mut LimitImpulses,
    ) {
        let h = step.drift * step.dt;
        let (start, (free, free_v)) = (step.start, step.free);
        self.y.fill(DVec3::ZERO);
        for contact in &self.contacts {
            let push = contact.normal * contact.impulse.0 + contact.impulse.1;
            contact.terms().for_each(|(i, w)| self.y[i] += push * w * self.mobility[i]);
        }
        self.collect(limit, start, |i| free.get(i) - start.get(i), |_| DVec3::ZERO, &impulses.triples);
        for row in &mut self.rows {
            row.impulse = impulses.triples[row.index][0];
            row.apply(row.impulse, &mut self.y, &self.mobility);
        }
        self.collect_cells(thickness, start, |height| {
            let drop = CellRow::rate(height, |i| free.get(i) - start.get(i));
            -(height.excess.max(0.0) + drop) / h
        });
        for row in &mut self.cell_rows {
            row.impulse = impulses.cells[row.index][0];
            row.apply(row.impulse, &mut self.y, &self.mobility);
        }
        self.prepare_contacts(|contact| {
            let (end, begin) = (contact.at(|i| free.get(i)), contact.at(|i| start.get(i)));
            let slip = end - begin - contact.velocity * step.dt;
            let slip = if contact.rebounds { DVec3::ZERO } else { slip - contact.normal * slip.dot(contact.normal) };
            ((contact.level - end.dot(contact.normal)) / h, -slip / h)
        });
        self.relax(h);
        self.store(0, impulses);
        for (i, y) in self.y.iter_mut().enumerate() {
            x.set(i, free.get(i) + *y * h);
            *y += free_v.get(i);
        }
    }

    /// Second stage: change the rates, the velocities at `x` (m).
    fn solve_velocities(
        &mut self,
        (limit, thickness): (&FlexionLimit, Option<&ThicknessLimit>),
        dt: f64,
        x: &Vectors,
        impulses: &mut LimitImpulses,
    ) {
        let rates = std::mem::take(&mut self.y);
        self.collect(limit, x, |_| DVec3::ZERO, |i| rates[i] * dt, &impulses.triples);
        self.y = rates;
        for row in &mut self.rows {
            let [applied, start] = impulses.triples[row.index];
            row.impulse = start;
            row.apply([start[0] - applied[0], start[1] - applied[1]], &mut self.y, &self.mobility);
        }
        self.collect_cells(thickness, x, |height| height.smallest_rate(dt));
        for row in &mut self.cell_rows {
            let [applied, start] = impulses.cells[row.index];
            row.impulse = start;
            row.apply(start - applied, &mut self.y, &self.mobility);
        }
        self.prepare_contacts(|contact| {
            let gap = contact.at(|i| x.get(i)).dot(contact.normal) - contact.level;
            let closed = contact.impulse.0 > 0.0 || gap <= 0.0;
            let surface = contact.velocity.dot(contact.normal);
            let target = if closed { surface } else { surface - gap / dt };
            (target, contact.velocity - contact.normal * surface)
        });
        self.relax(dt);
        self.store(1, impulses);
    }

    /// Collect the triples that may reach the limit, linearised at `x` (m): those near it, those
    /// that a displacement by `offset` and by `motion` (m) takes beyond it, and those with an
    /// impulse.
    fn collect(
        &mut self,
        limit: &FlexionLimit,
        x: &Vectors,
        offset: impl Fn(usize) -> DVec3,
        motion: impl Fn(usize) -> DVec3,
        impulses: &[TripleImpulses],
    ) {
        self.rows.clear();
        let angle = limit.limit.to_radians();
        let (radius, near) = (bend_of(angle), bend_of((angle - SETTINGS.margin).max(0.0)));
        for (index, (triple, totals)) in limit.triples.iter().zip(impulses).enumerate() {
            let Some(mut row) = TripleRow::new(index, triple.map(|i| i as usize), x, &self.mobility) else { continue };
            self.per_length = row.gradient[1][1].length();
            let size = row.bend[0].hypot(row.bend[1]);
            let (moved, next) = (row.rate(&offset), row.rate(&motion));
            row.bend = [0, 1].map(|e| row.bend[e] + moved[e]);
            let reached = (row.bend[0] + next[0]).hypot(row.bend[1] + next[1]);
            if row.compliance > 0.0 && (size > near || reached > radius || *totals != TripleImpulses::default()) {
                row.radius = radius.max(size);
                self.rows.push(row);
            }
        }
    }

    /// Collect the cells of the thickness limit, linearised at `x` (m); `smallest` returns their
    /// smallest rate, m/s.
    fn collect_cells(
        &mut self,
        thickness: Option<&ThicknessLimit>,
        x: &Vectors,
        smallest: impl Fn(&CellHeight) -> f64,
    ) {
        self.cell_rows.clear();
        let Some(limit) = thickness else { return };
        for index in 0..limit.len() {
            let Some(height) = limit.height(index, x) else { continue };
            let squares = height.nodes.iter().zip(&height.gradient);
            let compliance = squares.map(|(i, g)| (*g * *g).dot(self.mobility[*i as usize])).sum();
            if compliance > 0.0 {
                let target = smallest(&height);
                self.cell_rows.push(CellRow { index, height, target, compliance, impulse: 0.0 });
            }
        }
    }

    /// Store the impulses of a stage.
    fn store(&self, stage: usize, impulses: &mut LimitImpulses) {
        impulses.triples.iter_mut().for_each(|total| total[stage] = [0.0; 2]);
        impulses.cells.iter_mut().for_each(|total| total[stage] = 0.0);
        self.rows.iter().for_each(|row| impulses.triples[row.index][stage] = row.impulse);
        self.cell_rows.iter().for_each(|row| impulses.cells[row.index][stage] = row.impulse);
    }

    /// Set up the contacts of a stage: `wanted` returns their normal and tangential rate, m/s.
    fn prepare_contacts(&mut self, wanted: impl Fn(&LimitContact) -> (f64, DVec3)) {
        self.contact_rows.clear();
        for contact in &self.contacts {
            let square = contact.normal * contact.normal;
            let mut compliance = (0.0, 0.0);
            for (i, w) in contact.terms() {
                compliance.0 += w * w * square.dot(self.mobility[i]);
                compliance.1 += w * w * self.mobility[i].max_element();
            }
            let (target, drift) = wanted(contact);
            self.contact_rows.push(ContactRow { target, drift, compliance });
        }
    }

    /// Relax all rows in a stage of `h` (s) until κ changes by less than the tolerance.
    fn relax(&mut self, h: f64) {
        for iteration in 0..SETTINGS.maximum_iterations {
            let mut change = 0.0_f64;
            for (contact, row) in self.contacts.iter_mut().zip(&self.contact_rows) {
                change = change.max(relax_contact(contact, row, &mut self.y, &self.mobility) * self.per_length * h);
            }
            for row in &mut self.cell_rows {
                change = change.max(row.relax(&mut self.y, &self.mobility) * self.per_length * h);
            }
            let count = self.rows.len();
            for k in 0..count {
                let row = &mut self.rows[if iteration % 2 == 1 { count - 1 - k } else { k }];
                change = change.max(row.relax(&mut self.y, &self.mobility, h));
            }
            if change < SETTINGS.tolerance {
                break;
            }
        }
    }

    /// Return the triples beyond the limit and its slack to the limit, and the points behind a
    /// surface to it.
    fn correct_positions(&self, limit: &FlexionLimit, x: &mut Vectors) {
        let angle = limit.limit.to_radians();
        for _ in 0..SETTINGS.maximum_position_iterations {
            for (contact, row) in self.contacts.iter().zip(&self.contact_rows) {
                let depth = contact.level - contact.at(|i| x.get(i)).dot(contact.normal);
                if depth > 0.0 && row.compliance.0 > 0.0 {
                    let push = contact.normal * (depth / row.compliance.0);
                    contact.terms().for_each(|(i, w)| x.add(i, push * w * self.mobility[i]));
                }
            }
            let mut done = true;
            for triple in &limit.triples {
                let nodes = triple.map(|i| i as usize);
                let Some((cosine, ga, gc)) = bend(nodes.map(|i| x.get(i))) else { continue };
                let present = cosine.clamp(-1.0, 1.0).acos();
                let excess = present - angle - 0.5 * SETTINGS.angle_slack;
                if excess <= 0.5 * SETTINGS.angle_slack {
                    continue;
                }
                done = false;
                // The gradient of cos θ is -sin θ times that of θ.
                let gradient = [ga, -(ga + gc), gc];
                let squares = (0..3).map(|k| (gradient[k] * gradient[k]).dot(self.mobility[nodes[k]]));
                let weight = squares.sum::<f64>();
                if weight > f64::MIN_POSITIVE {
                    let step = excess * present.sin() / weight;
                    (0..3).for_each(|k| x.add(nodes[k], gradient[k] * step * self.mobility[nodes[k]]));
                }
            }
            if done {
                break;
            }
        }
    }
}

/// |κ| at the angle `angle` (rad).
fn bend_of(angle: f64) -> f64 {
    2.0 * (0.5 * angle).sin()
}

/// Relax one contact. Returns the change of its rate, m/s.
#[inline]
fn relax_contact(contact: &mut LimitContact, row: &ContactRow, y: &mut [DVec3], mobility: &[DVec3]) -> f64 {
    let (along, across) = row.compliance;
    if along <= 0.0 {
        return 0.0;
    }
    let rate = contact.at(|i| y[i]);
    let approach = rate.dot(contact.normal);
    let pressing = (contact.impulse.0 + (row.target - approach) / along).max(0.0);
    let slip = rate - contact.normal * approach - row.drift;
    let mut friction = contact.impulse.1 - slip / across;
    let (size, bound) = (friction.length(), contact.friction * pressing);
    if size > bound {
        friction *= bound / size;
    }
    let change = contact.normal * (pressing - contact.impulse.0) + friction - contact.impulse.1;
    contact.impulse = (pressing, friction);
    for k in 0..contact.count {
        let i = contact.nodes[k] as usize;
        y[i] += change * contact.weights[k] * mobility[i];
    }
    change.length() * across
}

#[cfg(test)]
mod tests;
