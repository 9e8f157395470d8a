//! Contacts of sheets and bodies, solved on their masses.
//!
//! Wanted is the displacement δ with H δ = Jᵀ p, u = J δ + b, and Coulomb's law between u and p at every contact. In place
//! of W = J H⁻¹ Jᵀ, dense in the contacts, this keeps to the sparse matrix of the sheets (`joint`). Each round says of every contact from its
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

mod joint;
mod row;

use glam::{DMat3, DVec2, DVec3};

use super::coulomb::Law;
pub(super) use joint::{Joint, Tangent, covers};
pub(super) use row::Row;

/// ρ over the sheet's own stiffness c at the contact.
const STIFFER: f64 = 300.0;
/// By how much friction may be above its limit where it sticks, as a fraction of that: what would start to slide and stop again.
const STICKS: f64 = 1e-4;
/// A contact with less than this fraction of all normal force does not rub.
const NEGLIGIBLE: f64 = 1e-6;
/// Rounds, at most, and those after which states change few at a time.
const ROUNDS: u32 = 70;
const PATIENCE: u32 = 15;
/// How a contact acts: what the matrix depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    pushes: bool,
    rubs: Rubbing,
}

impl State {
    fn acts(&self) -> bool {
        self.pushes || self.rubs != Rubbing::None
    }
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
    /// Where in the matrix the pairs of every row are.
    slots: Vec<u32>,
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

    /// Finds the rows in the matrix of `tangent`, and how stiff it is against each.
    pub fn bind(&mut self, tangent: &dyn Tangent) {
        self.slots.clear();
        for row in &mut self.rows {
            row.bind(tangent.pattern(), |i| tangent.diagonal(i), &mut self.slots);
        }
    }

    /// Solves from the forces in `force`; leaves the forces there. `tolerance` (m) is for gaps, and the limits of friction
    /// follow up to `updates` times. True if it settled.
    pub fn solve(&mut self, tangent: &mut dyn Tangent, tolerance: f64, updates: u32) -> bool {
        let n = 3 * tangent.pattern().size();
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
            if !self.factorize(tangent) {
                return false;
            }
            self.step(tangent);
            let settled = self.update(tolerance);
            if std::env::var_os("DBG3").is_some() {
                let (mut push, mut rub, mut big)=(0,0,0.0f64);
                for (i,(w,by)) in self.wanted.iter().enumerate() { push+=usize::from(w.pushes!=self.states[i].pushes); rub+=usize::from(std::mem::discriminant(&w.rubs)!=std::mem::discriminant(&self.states[i].rubs)); big=big.max(*by); }
                let change=self.u.iter().zip(&self.before).map(|(a,b)|(*a-*b).abs().max_element()).fold(0.0,f64::max);
                let np=self.states.iter().filter(|s|s.pushes).count();
                let nst=self.states.iter().filter(|s|s.rubs==Rubbing::Stuck).count();
                let nsl=self.states.iter().filter(|s|matches!(s.rubs,Rubbing::Sliding{..})).count();
                eprintln!("      round {round} pushing {np} stuck {nst} sliding {nsl} want push {push} rub {rub} most {big:.2e} change {change:.2e} settled {settled} factors {}", self.factors);
            }
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
        let all: f64 = self.force.iter().map(|p| p.x).sum();
        for (i, row) in self.rows.iter().enumerate() {
            let Law::Coulomb(friction) = row.law else { continue };
            let normal = self.force[i].x;
            self.limits[i] = if normal > NEGLIGIBLE * all { friction * normal } else { 0.0 };
            self.states[i].rubs = next_rubbing(row, &self.states[i], self.limits[i], self.force[i], self.u[i]);
        }
    }

    /// Whether contact `i` slides.
    pub fn slides(&self, i: usize) -> bool {
        matches!(self.states[i].rubs, Rubbing::Sliding { .. })
    }

    /// Displacement of each block row, m.
    pub fn displacement(&self) -> &[f64] {
        &self.delta
    }

    /// States to begin with: what had a force keeps it, what is open and would overlap pushes.
    fn begin(&mut self) {
        self.states.clear();
        self.limits.clear();
        for (row, p) in self.rows.iter().zip(&mut self.force) {
            if row.idle {
                *p = DVec3::ZERO;
            }
            let Law::Coulomb(friction) = row.law else {
                self.limits.push(f64::INFINITY);
                self.states.push(State { pushes: true, rubs: Rubbing::Stuck });
                continue;
            };
            let limit = friction * p.x;
            let slides = row.slid && p.y.hypot(p.z) >= limit * (1.0 - 1e-6);
            let rubs = match limit > 0.0 {
                false => Rubbing::None,
                true if slides => sliding(row, DVec2::new(p.y, p.z), row.b, limit),
                true => Rubbing::Stuck,
            };
            self.limits.push(limit);
            self.states.push(State { pushes: p.x > 0.0 || (row.new && !row.idle && row.b.x < 0.0), rubs });
        }
    }

    /// Makes the factor that the states ask for; false when there is none.
    fn factorize(&mut self, tangent: &mut dyn Tangent) -> bool {
        if self.same_matrix() {
            return true;
        }
        let (rows, states, slots) = (&self.rows, &self.states, &self.slots);
        let done = tangent.factorize_with(&mut |values| {
            for (row, state) in rows.iter().zip(states).filter(|(_, state)| state.acts()) {
                row.stiffen(&stiffness(row, state), slots, values);
            }
        });
        self.factored.clear();
        if done {
            self.factors += 1;
            self.factored.extend_from_slice(&self.states);
        }
        done
    }

    /// Solves for δ with the states there are.
    fn step(&mut self, tangent: &mut dyn Tangent) {
        self.delta.fill(0.0);
        // From here on `force` is that of δ = 0.
        for (i, row) in self.rows.iter().enumerate() {
            let d = stiffness(row, &self.factored[i]);
            self.force[i] = linear_part(self.force[i], self.u[i], &self.states[i], &d) - d * row.b;
            row.push(self.force[i], &mut self.delta);
        }
        tangent.solve(&mut self.delta);
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
                let pushes = !row.idle && next.x - row.stiffness.x * u.x > 0.0;
                let rubs = next_rubbing(row, &state, self.limits[i], next, u);
                let other = std::mem::discriminant(&rubs) != std::mem::discriminant(&state.rubs);
                let mut wants =
                    if pushes == state.pushes { 0.0 } else { (next.x.abs() / row.stiffness.x).max(u.x.abs()) };
                if other {
                    wants += u.y.hypot(u.z) + next.y.hypot(next.z) / row.stiffness.y;
                }
                // What makes no difference is left as it is, and so is the factor.
                let changes = other || pushes != state.pushes;
                let to = if changes && wants < tolerance { state } else { State { pushes, rubs } };
                same &= to.pushes == state.pushes && (to.rubs == Rubbing::Stuck) == (state.rubs == Rubbing::Stuck);
                same &= !state.pushes || u.x.abs() < tolerance;
                same &= state.rubs != Rubbing::Stuck || u.y.abs().max(u.z.abs()) < tolerance;
                self.wanted.push((to, wants));
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
