//! Barrier method: a substep of an island that is free of intersections at every iterate.
//!
//! Minimises the incremental potential of a backward Euler step with a barrier on the distance of
//! every pair of features (Li et al., Incremental Potential Contact, 2020):
//!
//!   min Σ Φ_sheet(x) + Σ_bodies ½ m|c - ĉ|²/h² + ½ θᵀ I θ/h² + Σ b(d)
//!
//! by Newton's method with a positive definite tangent. Each step is cut to the part that keeps the
//! gaps open (`stencil`), and halved until the potential falls. The motion of kinematic bodies and
//! prescribed nodes is a part of each step, and advances by the same fraction: features that they
//! push are carried along. Friction (`friction`) is added once the solution without it is known.
//!
//! It starts from a state without intersections and may stop at any iterate. `islands/fallback`
//! uses it where the contact solver has no accepted solution. Energies in J, h in s.

mod friction;
mod stencil;
mod surfaces;
mod terms;
mod velocities;

use glam::DVec3;

use crate::collision::narrow_phase::ContactPair;
use crate::contact::IslandView;
use crate::contact::barrier::friction::Friction;
use crate::contact::barrier::stencil::Stencil;
use crate::contact::barrier::surfaces::{Owner, Surfaces};
use crate::contact::barrier::terms::Term;
use crate::contact::settings::{BarrierSettings, ContactSettings};
use crate::contact::solver::augmented_lagrangian::{IslandTangent, TangentMatrix};
use crate::math::Vectors;
use crate::rigid::BodyState;
use crate::sheet::{Field, Sheet, stage};

pub(crate) use crate::contact::barrier::surfaces::{BarrierAttachment, BarrierCollider};

const SETTINGS: BarrierSettings = ContactSettings::DEFAULT.barrier;

/// Friction coefficient of a pair; `None` where the pair has no contact.
pub(crate) type PairFriction<'a> = &'a dyn Fn(&IslandView, ContactPair) -> Option<f64>;

/// Result of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BarrierReport {
    /// Number of factorisations.
    pub iterations: u32,
    /// Work, in node-iterations.
    pub work: u64,
    /// Whether the last step was below the tolerance.
    pub converged: bool,
    /// Whether kinematic bodies and prescribed nodes have reached their end.
    pub arrived: bool,
}

/// The method with its arrays.
#[derive(Default)]
pub(crate) struct BarrierSolver {
    surfaces: Surfaces,
    tangent: IslandTangent,
    /// Stencils at the iterate, and those along the step.
    active: Vec<Stencil>,
    swept: Vec<Stencil>,
    /// Friction of the stencils of the solution without it.
    friction: Vec<Friction>,
    /// Terms of the linear system, and the slots of their blocks.
    terms: Vec<Term>,
    slots: Vec<u32>,
    /// Displacement of every vertex in the full step, m, and its part that is prescribed.
    step: Vec<DVec3>,
    prescribed: Vec<DVec3>,
    /// Compliance of each vertex, m/N; 0 where its motion is prescribed.
    compliance: Vec<f64>,
    /// Positions to which fixed and prescribed nodes move, m.
    targets: Vec<Vectors>,
    /// States of the bodies at the iterate.
    bodies: Vec<BodyState>,
    right: Vec<f64>,
    /// Displacement beyond which a step is not a part of the motion, m.
    reach: f64,
}

impl BarrierSolver {
    /// Solve a substep of `h` (s), for which the sheets of `island` have begun a stage of backward
    /// Euler and the bodies have their free motion, in at most `most` Newton steps. The iterates
    /// of the sheets and `ends` of the bodies receive the solution.
    pub fn solve<'a>(
        &mut self,
        island: &mut IslandView,
        colliders: impl Iterator<Item = BarrierCollider<'a>> + Clone,
        attachments: &[BarrierAttachment],
        friction: PairFriction,
        (field, h): (Field, f64),
        most: u32,
    ) -> BarrierReport {
        self.begin(island, colliders, attachments);
        self.prescribe(island, h, 1.0);
        let moves = self.prescribed.iter().any(|d| *d != DVec3::ZERO);
        let led = self.prescribed.iter().map(|d| d.length()).fold(0.0, f64::max);
        let fast = island.sheets.iter().map(Sheet::max_speed).fold(0.0, f64::max);
        self.reach = SETTINGS.reach * (led + (fast + field.gravity.length() * h) * h + self.thinnest(island));
        let (mut remaining, mut slides) = (if moves { 1.0 } else { 0.0 }, false);
        let mut report = BarrierReport { iterations: 0, work: 0, converged: false, arrived: !moves };
        while report.iterations < most && !report.converged {
            report.iterations += 1;
            report.work += SETTINGS.work * (island.nodes() + self.active.len()) as u64;
            let Some(slope) = self.find_step(island, friction, (field, h, remaining)) else { break };
            let (taken, largest) = self.take_step(island, friction, (field, h), slope, &mut remaining);
            report.arrived = remaining <= 0.0;
            let near = report.arrived && taken * largest <= SETTINGS.displacement * self.thinnest(island);
            if near || taken == 0.0 || report.iterations == most / 2 {
                // The forces of the solution without friction bound it.
                let begins = !slides && self.begin_friction(island, friction, h);
                slides = true;
                if begins {
                    self.return_to_start(island);
                    remaining = if moves { 1.0 } else { 0.0 };
                    report.arrived = !moves;
                }
                report.converged = near && !begins;
                if taken == 0.0 && !begins {
                    break;
                }
            }
        }
        report
    }

    /// Fraction of a substep of `h` (s) after which a body with prescribed motion first meets a
    /// sheet in free flight.
    pub fn first_impact<'a>(
        &mut self,
        island: &IslandView,
        colliders: impl Iterator<Item = BarrierCollider<'a>> + Clone,
        friction: PairFriction,
        h: f64,
    ) -> f64 {
        self.surfaces.build(island, colliders);
        let Surfaces { owners, x, start, .. } = &mut self.surfaces;
        x.clear();
        self.step.clear();
        for owner in &*owners {
            let (from, by) = match *owner {
                Owner::Node { sheet, node } => {
                    let state = &island.sheet(sheet).state;
                    (state.x.get(node as usize), state.v.get(node as usize) * h)
                }
                Owner::Body { body, local } => {
                    let start = &island.solver_bodies[body as usize].start;
                    let from = start.world_point(local);
                    (from, start.free_flight(h, DVec3::ZERO).world_point(local) - from)
                }
            };
            x.push(from);
            self.step.push(by);
        }
        start.clone_from(x);
        self.surfaces.attached.clear();
        let mut swept = std::mem::take(&mut self.swept);
        self.surfaces.find(island, &self.step, &|pair| friction(island, pair), &mut swept);
        let mut first = 1.0_f64;
        for stencil in swept.iter().filter(|stencil| self.gives(island, stencil)) {
            let d = stencil.vertices.map(|i| self.step[i as usize]);
            first = first.min(stencil.free_fraction(self.corners(stencil), d));
        }
        self.swept = swept;
        first
    }

    /// Whether contact can move a vertex of a stencil.
    fn gives(&self, island: &IslandView, stencil: &Stencil) -> bool {
        stencil.vertices.iter().any(|vertex| match self.surfaces.owners[*vertex as usize] {
            Owner::Node { sheet, node } => !island.sheet(sheet).is_held(node as usize),
            Owner::Body { body, .. } => island.solver_bodies[body as usize].is_dynamic(),
        })
    }

    /// Least half thickness of the sheets, m.
    fn thinnest(&self, island: &IslandView) -> f64 {
        let offsets = island.contacts.iter().filter_map(|c| Some(c.surface.as_ref()?.contact_offset()));
        offsets.fold(f64::INFINITY, f64::min)
    }

    fn begin<'a>(
        &mut self,
        island: &mut IslandView,
        colliders: impl Iterator<Item = BarrierCollider<'a>> + Clone,
        attachments: &[BarrierAttachment],
    ) {
        self.surfaces.build(island, colliders);
        self.surfaces.attach(attachments);
        self.targets.clear();
        self.targets.extend(island.sheets.iter().map(|sheet| sheet.work.stage.free_positions.clone()));
        self.tangent = IslandTangent::default();
        let count = self.surfaces.owners.len();
        for list in [&mut self.step, &mut self.prescribed, &mut self.surfaces.x] {
            list.clear();
            list.resize(count, DVec3::ZERO);
        }
        self.return_to_start(island);
        self.surfaces.start.clone_from(&self.surfaces.x);
        self.friction.clear();
    }

    /// Set the iterate to the state at the start of the substep.
    fn return_to_start(&mut self, island: &mut IslandView) {
        island.sheets.iter_mut().for_each(|sheet| sheet.work.stage.iterate.copy_from(&sheet.state.x));
        self.bodies.clear();
        self.bodies.extend(island.solver_bodies.iter().map(|body| body.start));
        self.place(island);
    }

    /// Place the vertices at the iterate.
    fn place(&mut self, island: &IslandView) {
        for (x, owner) in self.surfaces.x.iter_mut().zip(&self.surfaces.owners) {
            *x = match *owner {
                Owner::Node { sheet, node } => island.sheet(sheet).work.stage.iterate.get(node as usize),
                Owner::Body { body, local } => self.bodies[body as usize].world_point(local),
            };
        }
    }

    /// Compute the Newton step with `remaining` of the prescribed motion. Returns the slope of the
    /// potential along it without the prescribed motion, J.
    fn find_step(
        &mut self,
        island: &mut IslandView,
        friction: PairFriction,
        (field, h, remaining): (Field, f64, f64),
    ) -> Option<f64> {
        island.for_each_sheet(|sheet| stage::linearise(sheet, field));
        self.tangent.lay_out(island);
        self.prescribe(island, h, remaining);
        self.find_active(island, friction);
        self.collect_terms(island);
        let pairs = self.terms.iter().flat_map(|term| term.constraint.pairs());
        self.tangent.fill(island, pairs, h);
        self.slots.clear();
        for term in &mut self.terms {
            term.constraint.look_up_slots(self.tangent.pattern(), &mut self.slots);
        }
        self.fill_right(island, h);
        if !self.factorize() {
            return None;
        }
        let force = self.right.clone();
        self.tangent.solve(&mut self.right);
        if !self.right.iter().all(|d| d.abs() < SETTINGS.maximum_displacement) {
            return None;
        }
        self.spread(island);
        Some(-force.iter().zip(&self.right).map(|(f, d)| f * d).sum::<f64>())
    }

    /// Factorise the linear system, whose diagonal grows until it is positive definite: the tangent
    /// of a strongly compressed sheet is not, and a larger diagonal only shortens the step.
    fn factorize(&mut self) -> bool {
        let Self { terms, slots, tangent, .. } = self;
        let columns = &tangent.pattern().starts[..tangent.size()];
        let diagonal: Vec<usize> = columns.iter().map(|start| 9 * *start as usize).collect();
        let mut added = 0.0;
        while added <= SETTINGS.maximum_shift {
            let is_factorized = tangent.factorize_with(&mut |values| {
                let largest = diagonal.iter().map(|first| values[*first].abs()).fold(0.0, f64::max);
                terms.iter().for_each(|term| term.constraint.add_stiffness(&term.stiffness, slots, values));
                diagonal
                    .iter()
                    .flat_map(|first| [0, 4, 8].map(|k| first + k))
                    .for_each(|k| values[k] += added * largest);
            });
            if is_factorized {
                return true;
            }
            added = (4.0_f64 * added).max(SETTINGS.least_shift);
        }
        false
    }

    /// Find the stencils at the iterate that contact can move.
    fn find_active(&mut self, island: &IslandView, friction: PairFriction) {
        self.step.fill(DVec3::ZERO);
        self.surfaces.find(island, &self.step, &|pair| friction(island, pair), &mut self.active);
        let mut active = std::mem::take(&mut self.active);
        active.retain(|stencil| self.applies(stencil));
        self.active = active;
    }

    /// Set the prescribed displacements and the compliances of the vertices.
    fn prescribe(&mut self, island: &IslandView, h: f64, remaining: f64) {
        self.compliance.clear();
        for (vertex, owner) in self.surfaces.owners.iter().enumerate() {
            let x = self.surfaces.x[vertex];
            let (by, compliance) = match *owner {
                Owner::Node { sheet, node } => {
                    let target = self.targets[sheet as usize].get(node as usize) - x;
                    match stage::free_row(island.sheet(sheet), node) {
                        None => (target, 0.0),
                        Some((row, free)) => {
                            let diagonal = stage::tangent(island.sheet(sheet)).map(|t| t.diagonal(row));
                            let inverse = diagonal.unwrap_or_default().inverse();
                            let along = [inverse.x_axis.x, inverse.y_axis.y, inverse.z_axis.z];
                            let sum = along.iter().zip(free.to_array()).map(|(c, free)| c * free).sum();
                            (target * (DVec3::ONE - free), sum)
                        }
                    }
                }
                Owner::Body { body, local } => {
                    let solver_body = &island.solver_bodies[body as usize];
                    if solver_body.is_dynamic() {
                        (DVec3::ZERO, h * h * solver_body.free.inverse_mass())
                    } else {
                        (solver_body.free.world_point(local) - x, 0.0)
                    }
                }
            };
            self.prescribed[vertex] = if remaining > 0.0 { by } else { DVec3::ZERO };
            self.compliance.push(compliance);
        }
    }

    /// Stiffness of the barrier, N/m; `None` where the motion of all vertices is prescribed.
    fn stiffness(&self, stencil: &Stencil) -> Option<f64> {
        if stencil.stiffness > 0.0 {
            return Some(stencil.stiffness);
        }
        let sum: f64 = stencil.vertices.iter().map(|i| self.compliance[*i as usize]).sum();
        (sum > 0.0).then(|| SETTINGS.stiffness / sum)
    }

    /// Whether a stencil has a barrier: contact can move it, and it is not attached.
    fn applies(&self, stencil: &Stencil) -> bool {
        self.stiffness(stencil).is_some() && !self.surfaces.is_attached(stencil)
    }

    /// Stiffness of an attachment, N/m.
    fn attachment_stiffness(&self, [node, point]: [u32; 2]) -> f64 {
        SETTINGS.attachment / (self.compliance[node as usize] + self.compliance[point as usize]).max(f64::MIN_POSITIVE)
    }

    fn corners(&self, stencil: &Stencil) -> [DVec3; 4] {
        stencil.vertices.map(|i| self.surfaces.x[i as usize])
    }

    /// Set the displacement of every vertex from the solution.
    fn spread(&mut self, island: &IslandView) {
        for (vertex, owner) in self.surfaces.owners.iter().enumerate() {
            let of = |row: u32| DVec3::from_slice(&self.right[3 * row as usize..3 * row as usize + 3]);
            let by = match *owner {
                Owner::Node { sheet, node } => stage::free_row(island.sheet(sheet), node)
                    .map_or(DVec3::ZERO, |(row, free)| of(self.tangent.sheet(sheet) + row) * free),
                Owner::Body { body, .. } => self.tangent.body(island.sheets.len(), body).map_or(DVec3::ZERO, |first| {
                    of(first) + of(first + 1).cross(self.surfaces.x[vertex] - self.bodies[body as usize].centre())
                }),
            };
            self.step[vertex] = by + self.prescribed[vertex];
        }
    }

    /// Potential of sheets and bodies, and barrier of the stencils along the step, J.
    fn potential(&self, island: &mut IslandView, field: Field, h: f64) -> f64 {
        let mut sum = 0.0;
        for sheet in island.sheets.iter_mut() {
            sum += stage::iterate_potential(sheet, field);
        }
        for (solver_body, now) in island.solver_bodies.iter().zip(&self.bodies) {
            if solver_body.is_dynamic() {
                let (shift, turn) = displacement(&solver_body.free, now);
                let spin = turn.dot(solver_body.free.inertia() * turn);
                sum += 0.5 * (shift.length_squared() / solver_body.free.inverse_mass() + spin) / (h * h);
            }
        }
        for stencil in &self.swept {
            if let Some(stiffness) = self.stiffness(stencil) {
                sum += stencil.barrier(stencil.closest(self.corners(stencil)).distance, stiffness)[0];
            }
        }
        for pair in &self.surfaces.attached {
            let apart = self.surfaces.x[pair[0] as usize].distance_squared(self.surfaces.x[pair[1] as usize]);
            sum += 0.5 * self.attachment_stiffness(*pair) * apart;
        }
        sum + self.friction.iter().map(|friction| friction.value(self.slip(friction))).sum::<f64>()
    }

    /// Take the part of the step that keeps all gaps open and does not raise the potential, apart
    /// from the work of the prescribed motion. Returns the part and the largest displacement of a
    /// vertex in the full step, m.
    fn take_step(
        &mut self,
        island: &mut IslandView,
        friction: PairFriction,
        (field, h): (Field, f64),
        slope: f64,
        remaining: &mut f64,
    ) -> (f64, f64) {
        let largest = self.step.iter().map(|d| d.length_squared()).fold(0.0, f64::max).sqrt();
        let mut swept = std::mem::take(&mut self.swept);
        self.surfaces.find(island, &self.step, &|pair| friction(island, pair), &mut swept);
        swept.retain(|stencil| self.applies(stencil));
        self.swept = swept;
        let mut part = 1.0_f64;
        for stencil in &self.swept {
            let d = stencil.vertices.map(|i| self.step[i as usize]);
            part = part.min(stencil.free_fraction(self.corners(stencil), d));
        }
        let before = self.potential(island, field, h);
        let mass = |sheet: &Sheet| sheet.model.mass.iter().sum::<f64>();
        let kinetic = 0.5 * island.sheets.iter().map(mass).sum::<f64>() * SETTINGS.speed * SETTINGS.speed;
        let first = part;
        let bodies = self.bodies.clone();
        let starts: Vec<Vectors> = island.sheets.iter().map(|sheet| sheet.work.stage.iterate.clone()).collect();
        let start = self.surfaces.x.clone();
        let moves = *remaining > 0.0;
        for _ in 0..SETTINGS.maximum_halvings {
            let left = if part >= 1.0 { 0.0 } else { *remaining * (1.0 - part) };
            self.move_by(island, (&starts, &bodies, &start), part, 1.0 - left);
            let after = self.potential(island, field, h);
            let work = if moves { self.work_of_prescribed(part) } else { 0.0 };
            let slack = SETTINGS.rounding * (before.abs() + kinetic) + SETTINGS.led_work * work;
            if after.is_finite() && after <= before + SETTINGS.sufficient_fall * part * slope.min(0.0) + slack {
                *remaining = left;
                return (part, largest);
            }
            part *= 0.5;
        }
        // A body that moves goes on where no part of the step lowers the potential, unless the step
        // is far larger than the motion.
        let part = if moves && first * largest <= self.reach { first } else { 0.0 };
        *remaining *= 1.0 - part;
        self.move_by(island, (&starts, &bodies, &start), part, 1.0 - *remaining);
        (part, largest)
    }

    /// Move sheets and bodies by `part` of the step from the given state; kinematic bodies to the
    /// fraction `done` of their motion.
    fn move_by(
        &mut self,
        island: &mut IslandView,
        (starts, bodies, start): (&[Vectors], &[BodyState], &[DVec3]),
        part: f64,
        done: f64,
    ) {
        for (local, sheet) in island.sheets.iter_mut().enumerate() {
            let first = self.surfaces.vertex(local as u32, 0);
            let iterate = &mut sheet.work.stage.iterate;
            iterate.copy_from(&starts[local]);
            for i in 0..iterate.len() {
                iterate.add(i, self.step[first + i] * part);
            }
        }
        let sheets = island.sheets.len();
        for (body, solver_body) in island.solver_bodies.iter().enumerate() {
            let row = self.tangent.body(sheets, body as u32);
            self.bodies[body] = match row {
                Some(first) => {
                    let of = |row: u32| DVec3::from_slice(&self.right[3 * row as usize..3 * row as usize + 3]) * part;
                    bodies[body].displaced(of(first), of(first + 1))
                }
                None => interpolated(&solver_body.start, &solver_body.free, done),
            };
        }
        self.surfaces.x.copy_from_slice(start);
        self.place(island);
    }

    /// Estimate of the work that the prescribed motion does against the barrier in `part` of the
    /// step, J.
    fn work_of_prescribed(&self, part: f64) -> f64 {
        let mut work = 0.0;
        for stencil in &self.swept {
            let Some(stiffness) = self.stiffness(stencil) else { continue };
            let closest = stencil.closest(self.corners(stencil));
            let [_, first, _] = stencil.barrier(closest.distance, stiffness);
            if first < 0.0 && first.is_finite() {
                let moved = stencil.vertices.iter().zip(closest.weights);
                let closing: f64 = moved.map(|(i, w)| w * closest.normal.dot(self.prescribed[*i as usize])).sum();
                work += (first * closing).max(0.0) * part;
            }
        }
        work
    }
}

/// Displacement (m) and rotation vector (rad) from the free state of a body to `now`.
fn displacement(free: &BodyState, now: &BodyState) -> (DVec3, DVec3) {
    let turn = now.rotation() * free.rotation().conjugate();
    let turn = if turn.w < 0.0 { -turn } else { turn };
    (now.centre() - free.centre(), turn.to_scaled_axis())
}

/// State of a kinematic body at the fraction `part` of its motion.
fn interpolated(start: &BodyState, end: &BodyState, part: f64) -> BodyState {
    if part >= 1.0 {
        return *end;
    }
    let (shift, turn) = displacement(start, end);
    start.displaced(shift * part, turn * part)
}
