//! Many contacts of one sheet with bodies that do not give way, solved on the sheet itself.
//!
//! Wanted is the displacement δ with H δ = Jᵀ p, u = J δ + b, and Coulomb's law between u and p at every contact. In place
//! of W = J H⁻¹ Jᵀ, dense in the contacts, this keeps to the sheet's own sparse matrix. Each round says of every contact from its
//! last force p and gap how it acts (open, stuck, sliding; the sign of p_n - c u_n, the length of p_t - c u_t against μ p_n),
//! and solves for all at once, with u = 0 where it is held imposed by an augmented Lagrangian,
//!
//!   p⁺ = p - ρ u⁺,  (H + Σ Jᵀ D J) δ⁺ = ...,  D = ρ where held, of friction c (L/|p_t - c u_t|) across the slip,
//!
//! a Newton step on the pair (δ, p). ρ is large against the sheet's stiffness, so that held contacts close within two
//! rounds; c is that stiffness, or a contact just reached would be taken for open. A round needs a new factor only when
//! a contact acts otherwise than before, and its cost hardly grows with the number of contacts: a slap of all masses costs what an edge does.
//! (Alart and Curnier, "A mixed formulation for frictional contact problems prone to Newton like solution methods", CMAME 92,
//! 1991; Hintermüller, Ito, Kunisch, "The primal-dual active set strategy as a semismooth Newton method", SIAM J. Optim. 13, 2002.)

use glam::{DMat3, DVec2, DVec3};

use super::coulomb::Law;
use crate::engine::linear::Pattern;
use crate::sheet::{ContactTangent, Sheet};

/// ρ over the sheet's own stiffness c at the contact.
const STIFFER: f64 = 300.0;
/// By how much friction may be above its limit where it sticks, as a fraction of that: what would start to slide and stop again.
const STICKS: f64 = 1e-4;
/// Times that the limits of friction follow the normal forces, at most.
pub(super) const UPDATES: u32 = 10;
/// Rounds, at most, and those after which states change few at a time.
const ROUNDS: u32 = 70;
const PATIENCE: u32 = 15;
/// A contact as the sheet sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// Block rows of its masses, their weights, and which of their directions are free.
    pub rows: [u32; 3],
    pub weights: [f64; 3],
    pub free: [DVec3; 3],
    /// Columns: normal and two tangents.
    pub frame: DMat3,
    pub law: Law,
    /// u where δ is zero, in the frame, m.
    pub b: DVec3,
    /// c, N/m.
    stiffness: DVec3,
}

impl Row {
    /// A contact; c and b are set by the solver.
    pub fn new(frame: DMat3, law: Law) -> Self {
        Self {
            rows: [0; 3],
            weights: [0.0; 3],
            free: [DVec3::ONE; 3],
            frame,
            law,
            b: DVec3::ZERO,
            stiffness: DVec3::ZERO,
        }
    }

    fn terms(&self) -> impl Iterator<Item = (usize, f64, DVec3)> + '_ {
        (0..3).filter(|k| self.weights[*k] != 0.0).map(|k| (self.rows[k] as usize, self.weights[k], self.free[k]))
    }

    fn moved(&self, delta: &[f64]) -> DVec3 {
        let sum: DVec3 = self.terms().map(|(row, w, free)| DVec3::from_slice(&delta[3 * row..]) * free * w).sum();
        self.frame.transpose() * sum
    }

    fn push(&self, p: DVec3, force: &mut [f64]) {
        let world = self.frame * p;
        for (row, w, free) in self.terms() {
            let f = world * free * w;
            for (to, f) in force[3 * row..3 * row + 3].iter_mut().zip(f.to_array()) {
                *to += f;
            }
        }
    }
}

/// How a contact acts: what the matrix depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    pushes: bool,
    rubs: Rubbing,
}

/// Friction of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rubbing {
    None,
    Stuck,
    /// Slides: direction of the force, its size (N), and D across it (N/m).
    Sliding {
        along: (f64, f64),
        limit: f64,
        across: f64,
    },
}

/// The solver with its arrays.
#[derive(Default)]
pub(crate) struct Primal {
    pub rows: Vec<Row>,
    /// Multipliers, then forces, in the frames, N.
    pub force: Vec<DVec3>,
    /// Limit of friction at each contact, N: fixed while states are looked for, which keeps the problem convex.
    limits: Vec<f64>,
    states: Vec<State>,
    /// States that the last round asks for, and how much each is wanted, m.
    wanted: Vec<(State, f64)>,
    factored: Vec<State>,
    u: Vec<DVec3>,
    /// u of the round before.
    before: Vec<DVec3>,
    delta: Vec<f64>,
    /// Newton steps and factors so far.
    pub steps: u64,
    pub factors: u64,
}

impl Primal {
    /// Begins another problem with another matrix.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.force.clear();
        self.factored.clear();
    }

    /// Sets c from the stiffness of the sheet at each contact.
    pub fn weigh(&mut self, tangent: &ContactTangent) {
        for row in &mut self.rows {
            let compliance = |direction: DVec3| -> f64 {
                let each = (0..3).filter(|k| row.weights[*k] != 0.0).map(|k| {
                    let stiffness = tangent.diagonal(row.rows[k]);
                    row.weights[k] * row.weights[k] / direction.dot(stiffness * direction)
                });
                each.sum()
            };
            let along = |d: DVec3| 1.0 / compliance(d).max(f64::MIN_POSITIVE);
            let c = [row.frame.x_axis, row.frame.y_axis, row.frame.z_axis].map(along);
            // One weight for both tangents, so that the disc stays a disc.
            let tangential = c[1].min(c[2]);
            row.stiffness = DVec3::new(c[0], tangential, tangential);
        }
    }

    /// Solves from the forces in `force`; leaves the forces there. `tolerance` (m) is for gaps, and the limits of friction
    /// follow up to `updates` times. True if it settled.
    pub fn solve(&mut self, sheet: &mut Sheet, tolerance: f64, updates: u32) -> bool {
        let n = sheet.unknowns();
        self.delta.clear();
        self.delta.resize(n, 0.0);
        self.u.clear();
        self.u.extend(self.rows.iter().map(|r| r.b));
        self.begin();
        let mut fresh = false;
        let mut updated = 0;
        for round in 0..ROUNDS {
            self.steps += 1;
            self.before.clone_from(&self.u);
            if !self.factorize(sheet) {
                return false;
            }
            self.step(sheet);
            let settled = self.update(tolerance);
            self.change_states(round);
            if settled {
                if fresh || updated >= updates {
                    return true;
                }
                self.limit_friction();
                updated += 1;
            }
            fresh = settled;
        }
        false
    }

    /// Takes up the states that are wanted: all at first, later those wanted most, since changing all may go round in circles.
    fn change_states(&mut self, round: u32) {
        let most = self.wanted.iter().map(|(_, by)| *by).fold(0.0, f64::max);
        let least = if round < PATIENCE { 0.0 } else { most * if round < 2 * PATIENCE { 0.3 } else { 0.9 } };
        for (state, (wanted, by)) in self.states.iter_mut().zip(&self.wanted) {
            if *by >= least || *by == 0.0 {
                *state = *wanted;
            }
        }
    }

    /// Lets the limits of friction follow the normal forces.
    fn limit_friction(&mut self) {
        for (i, row) in self.rows.iter().enumerate() {
            let Law::Coulomb(friction) = row.law else { continue };
            self.limits[i] = friction * self.force[i].x;
            self.states[i].rubs = next_rubbing(row, &self.states[i], self.limits[i], self.force[i], self.u[i]);
        }
    }

    /// Displacement of each block row, m.
    pub fn displacement(&self) -> &[f64] {
        &self.delta
    }

    /// States to begin with: what had a force keeps it, what is open and would overlap pushes.
    fn begin(&mut self) {
        self.states.clear();
        self.limits.clear();
        for (row, p) in self.rows.iter().zip(&self.force) {
            let Law::Coulomb(friction) = row.law else {
                self.limits.push(f64::INFINITY);
                self.states.push(State { pushes: true, rubs: Rubbing::Stuck });
                continue;
            };
            let limit = friction * p.x;
            let slides = p.y.hypot(p.z) >= limit * (1.0 - 1e-6);
            let rubs = match limit > 0.0 {
                false => Rubbing::None,
                true if slides => sliding(row, DVec2::new(p.y, p.z), row.b, limit),
                true => Rubbing::Stuck,
            };
            self.limits.push(limit);
            self.states.push(State { pushes: p.x > 0.0 || row.b.x < 0.0, rubs });
        }
    }

    /// Makes the factor that the states ask for; false when there is none.
    fn factorize(&mut self, sheet: &mut Sheet) -> bool {
        if self.same_matrix() {
            return true;
        }
        let (rows, states) = (&self.rows, &self.states);
        let done = sheet.factorize_with(|pattern, values| {
            rows.iter().zip(states).for_each(|(row, state)| add(row, state, pattern, values));
        });
        self.factored.clear();
        if done {
            self.factors += 1;
            self.factored.extend_from_slice(&self.states);
        }
        done
    }

    /// Solves for δ with the states there are.
    fn step(&mut self, sheet: &mut Sheet) {
        self.delta.fill(0.0);
        // From here on `force` is that of δ = 0.
        for (i, row) in self.rows.iter().enumerate() {
            let d = stiffness(row, &self.factored[i]);
            self.force[i] = linear_part(self.force[i], self.u[i], &self.states[i], &d) - d * row.b;
            row.push(self.force[i], &mut self.delta);
        }
        sheet.solve_contact(&mut self.delta);
        for (row, u) in self.rows.iter().zip(&mut self.u) {
            *u = row.b + row.moved(&self.delta);
        }
    }

    /// Whether the factor at hand is of the matrix that the states ask for.
    fn same_matrix(&self) -> bool {
        let alike = |(a, b): (&State, &State)| match (a.rubs, b.rubs) {
            (Rubbing::Sliding { along: p, across: s, .. }, Rubbing::Sliding { along: q, across: t, .. }) => {
                let turned = (p.0 - q.0).abs() + (p.1 - q.1).abs();
                // A direction a little off only costs another round.
                turned < 0.02 && (s - t).abs() <= 0.1 * s
            }
            _ => a == b,
        };
        self.factored.len() == self.states.len() && self.factored.iter().zip(&self.states).all(alike)
    }

    /// Takes up the forces that go with u, and the states for the next round; true when nothing changed that matters.
    fn update(&mut self, tolerance: f64) -> bool {
        let (mut change, mut same) = (0.0_f64, true);
        self.wanted.clear();
        for (i, row) in self.rows.iter().enumerate() {
            let (state, u) = (self.states[i], self.u[i]);
            let mut next = self.force[i] - stiffness(row, &self.factored[i]) * (u - row.b);
            if row.law == Law::Glue {
                self.wanted.push((state, 0.0));
                same &= u.abs().max_element() < tolerance;
            } else {
                let pushes = next.x - row.stiffness.x * u.x > 0.0;
                let rubs = next_rubbing(row, &state, self.limits[i], next, u);
                let slight = (next.x.abs() / row.stiffness.x).max(u.x.abs()) < tolerance;
                same &= pushes == state.pushes || slight;
                same &= !state.pushes || u.x.abs() < tolerance;
                same &=
                    state.rubs != Rubbing::Stuck || (rubs == Rubbing::Stuck && u.y.abs().max(u.z.abs()) < tolerance);
                let mut wants =
                    if pushes == state.pushes { 0.0 } else { (next.x.abs() / row.stiffness.x).max(u.x.abs()) };
                if std::mem::discriminant(&rubs) != std::mem::discriminant(&state.rubs) {
                    wants += u.y.hypot(u.z) + next.y.hypot(next.z) / row.stiffness.y;
                }
                self.wanted.push((State { pushes, rubs }, wants));
                next.x = next.x.max(0.0);
                let length = next.y.hypot(next.z);
                if length > self.limits[i] {
                    let s = self.limits[i] / length;
                    (next.y, next.z) = (next.y * s, next.z * s);
                }
            }
            // Forces may go round among contacts that hold the same; it is what they do that must not change.
            change = change.max((u - self.before[i]).abs().max_element());
            self.force[i] = next;
        }
        same && change <= tolerance
    }
}

/// How a contact rubs next that acted as `state` and came to force `p` and gap and slip `u`.
fn next_rubbing(row: &Row, state: &State, limit: f64, p: DVec3, u: DVec3) -> Rubbing {
    if limit <= 0.0 {
        return Rubbing::None;
    }
    let force = DVec2::new(p.y, p.z);
    match state.rubs {
        Rubbing::None if u.y == 0.0 && u.z == 0.0 => Rubbing::Stuck,
        Rubbing::None => sliding(row, -DVec2::new(u.y, u.z), u, limit),
        Rubbing::Stuck if force.length() <= limit * (1.0 + STICKS) => Rubbing::Stuck,
        Rubbing::Stuck => sliding(row, force, u, limit),
        // Friction that drives the slip is none: it would have stopped in between.
        Rubbing::Sliding { along, .. } if along.0 * u.y + along.1 * u.z > 0.0 => Rubbing::Stuck,
        Rubbing::Sliding { along, .. } => sliding(row, DVec2::new(along.0, along.1), u, limit),
    }
}

/// Sliding with friction of size `limit` that was along `force` and turns against the slip in `u`.
fn sliding(row: &Row, force: DVec2, u: DVec3, limit: f64) -> Rubbing {
    let trial = force.normalize_or_zero() * limit - DVec2::new(u.y, u.z) * row.stiffness.y;
    let length = trial.length();
    let along = trial / length.max(f64::MIN_POSITIVE);
    Rubbing::Sliding { along: (along.x, along.y), limit, across: row.stiffness.y * (limit / length.max(limit)) }
}

/// The force of a contact in a round less -D u: `p` and `u` are those before it.
fn linear_part(p: DVec3, u: DVec3, state: &State, d: &DMat3) -> DVec3 {
    let normal = if state.pushes { p.x } else { 0.0 };
    match state.rubs {
        Rubbing::None => DVec3::new(normal, 0.0, 0.0),
        Rubbing::Stuck => DVec3::new(normal, p.y, p.z),
        Rubbing::Sliding { along, limit, .. } => {
            let turning = *d * DVec3::new(0.0, u.y, u.z);
            DVec3::new(normal, along.0 * limit + turning.y, along.1 * limit + turning.z)
        }
    }
}

/// D of a contact.
fn stiffness(row: &Row, state: &State) -> DMat3 {
    let rho = row.stiffness * STIFFER;
    let tangential = match state.rubs {
        Rubbing::None => [0.0; 3],
        Rubbing::Stuck => [rho.y, 0.0, rho.z],
        Rubbing::Sliding { along: (y, z), across, .. } => [across * z * z, -across * y * z, across * y * y],
    };
    DMat3::from_cols(
        DVec3::new(if state.pushes { rho.x } else { 0.0 }, 0.0, 0.0),
        DVec3::new(0.0, tangential[0], tangential[1]),
        DVec3::new(0.0, tangential[1], tangential[2]),
    )
}

/// Adds Jᵀ D J of one contact.
fn add(row: &Row, state: &State, pattern: &Pattern, values: &mut [f64]) {
    if !state.pushes && state.rubs == Rubbing::None {
        return;
    }
    let local = stiffness(row, state);
    let world = row.frame * local * row.frame.transpose();
    for (i, wi, fi) in row.terms() {
        for (j, wj, fj) in row.terms().filter(|(j, ..)| *j <= i) {
            let Some(slot) = pattern.slot(i as u32, j as u32) else { continue };
            let at = 9 * slot as usize;
            for r in 0..3 {
                for c in 0..3 {
                    values[at + 3 * r + c] += wi * wj * fi[r] * fj[c] * world.col(c)[r];
                }
            }
        }
    }
}
