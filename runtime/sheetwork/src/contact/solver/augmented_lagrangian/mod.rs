//! Contacts of sheets and bodies, solved by Newton steps.
//!
//! Wanted is the displacement δ with H δ = Jᵀ p, u = J δ + b, and Coulomb's law between u and p at every contact. With the limits of
//! friction held, the problem is convex, and an augmented Lagrangian with weights ρ,
//!
//!   Φ(δ) = ½ δᵀ H δ + Σ |P(p - ρ u)|²/2ρ (in parts),  p⁺ = P(p - ρ u),
//!
//! P the projection on what forces there may be (normal ≥ 0, tangential within a disc), is minimised by Newton steps,
//!
//!   (H + Σ Jᵀ D J) s = Jᵀ P(p - ρ u) - H δ,  D = ρ ∂P,
//!
//! each followed along s as far as that lowers Φ; where contacts act (open, stuck, sliding) as the step supposed, it is exact and
//! the forces are brought up to date. Then the limits of friction follow the normal forces. A step needs a new factor only when a
//! contact acts otherwise than before: of the masses' matrix (`joint`), or of one in the contacts (`space`).
//! (Alart and Curnier, "A mixed formulation for frictional contact problems prone to Newton like solution methods", CMAME 92,
//! 1991; Li, Sun, Toh, "A highly efficient semismooth Newton augmented Lagrangian method", SIAM J. Optim. 28, 2018; Haslinger,
//! "Approximation of the Signorini problem with friction, obeying the Coulomb law", Math. Meth. Appl. Sci. 5, 1983.)

pub(crate) mod block_row;
pub(crate) mod contact_state;
pub(crate) mod interior_point;
pub(crate) mod tangent;
#[cfg(test)]
mod tests;
pub(crate) mod unknowns;

use glam::{DMat3, DVec2, DVec3};

use crate::contact::coulomb::Law;
pub(crate) use crate::contact::solver::augmented_lagrangian::block_row::Row;
use crate::contact::solver::augmented_lagrangian::contact_state::{Rubs, State, projected, state_of, stiffness};
pub(crate) use crate::contact::solver::augmented_lagrangian::interior_point::Inside;
pub(crate) use crate::contact::solver::augmented_lagrangian::tangent::{Joint, Tangent, covers};
pub(crate) use crate::contact::solver::augmented_lagrangian::unknowns::{OnForces, OnMasses, Space};

/// Share of the contacts that act otherwise than supposed which makes the next steps braced, or, after some, has those that push
/// found from within.
const MANY: f64 = 0.03;
const STEPS_OUTSIDE: u32 = 3;
/// After so many braced steps gaps that are not down to this fraction of the first, and after so many those that are more than a few times
/// what is asked, are found from within: such steps go on for long or not at all.
const STEPS_BRACED: [u32; 2] = [6, 10];
const LOST: f64 = 0.5;
const FEW_TIMES: f64 = 4.0;
/// Steps more for each time that limits of friction have followed: what settles each time comes there.
const MORE: u32 = 6;
/// Steps on the forces at most before that: what does not settle there may on the masses.
const ON_FORCES: u32 = 20;
/// The least part of the way that limits of friction go.
const LEAST_PART: f64 = 0.1;
/// Steps after which what is out of balance need only be less than [`Accuracy::balance_late`].
const LATE: u32 = 3;
/// How much more a gap of glue counts: two rows of a stiff sheet that are held a micrometre apart pull by newtons.
const HOLDS: f64 = 100.0;
/// By how much friction may miss its limit, as a fraction of that.
const STICKS: f64 = 1e-3;
/// A gap that a round of forces does not lessen by more than this fraction, and that is no more than so many times what is asked, is
/// one that contacts which contradict one another leave.
const STALLED: f64 = 0.1;
const CONTRADICTED: f64 = 10.0;
/// A gap that a round of forces does not lessen to this fraction asks for weights so many times larger: where many contacts hold a soft
/// sheet together, they are stiffer than each by itself.
const SLOW: f64 = 0.4;
const FASTER: f64 = 5.0;
/// Sum of forces, as a fraction of the largest there was on the way, below which they are what rounding has left.
const ROUNDING: f64 = 1e-6;
/// A contact with less than this fraction of all normal force does not rub.
const NEGLIGIBLE: f64 = 1e-6;
/// The same as a fraction of STICKS of all friction there may be, for contacts that carry little.
const SLIGHT: f64 = 0.1;
/// Halvings and secants of a search along a step, and how much of the slope of Φ may be left.
const TRIALS: u32 = 12;
const FLAT: f64 = 0.1;

/// How accurate a solve is to be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accuracy {
    /// Gaps, m.
    pub gap: f64,
    /// ρ over the sheet's own stiffness at the contact: with 100 a contact closes to a hundredth of its depth in a step. Friction
    /// needs less, since it changes over from holding to sliding.
    pub stiffer: DVec3,
    /// Up to what weights of gaps grow where they close slowly; piles take longer with more.
    pub stiffest: f64,
    /// How much more a slip counts, which would add up from step to step.
    pub slip: f64,
    /// By what fraction of their sum forces may be short of holding the displacement: stiff contacts hide in small gaps what is
    /// not held.
    pub balance: f64,
    /// The same after some steps: where sheets slide over one another, a few contacts flicker between holding and sliding for long.
    pub balance_late: f64,
    /// The same of forces found from within, which close in on friction slowly.
    pub balance_inside: f64,
    /// Where the path to them ends.
    pub inside: Inside,
    /// Times that the limits of friction follow the normal forces, at most.
    pub updates: u32,
    /// Steps after which forces are found from within in any case.
    pub patience: u32,
    /// Whether to take braced steps where much changes: surer to come near, slower to get there.
    pub braced: bool,
}

impl Accuracy {
    /// Of one sheet: what sticks must not creep, and momentum be kept.
    pub const FINE: Self = Self {
        gap: 2e-7,
        slip: 10.0,
        stiffer: DVec3::new(100.0, 10.0, 10.0),
        stiffest: 1e4,
        balance: 1e-7,
        balance_late: 1e-7,
        balance_inside: 1e-3,
        inside: Inside::FINE,
        updates: 5,
        // With 20 a sheet that lies loosely around a needle, half of its contacts about to slide, failed where 30 do; what is halved costs more.
        patience: 40,
        braced: false,
    };
    /// Of several sheets in the midst of a blow, where some contact always changes from holding to sliding: limits of friction follow the normal
    /// forces from solve to solve.
    pub const TOGETHER: Self = Self {
        gap: 5e-6,
        slip: 1.0,
        stiffer: DVec3::new(30.0, 3.0, 3.0),
        stiffest: 0.0,
        balance: 1e-3,
        balance_late: 5e-2,
        balance_inside: 1e-2,
        inside: Inside::TOGETHER,
        updates: 0,
        patience: 14,
        braced: true,
    };
    /// Of several sheets otherwise: what slides on one comes within 2 % of its acceleration. With the limits of the solve before it was 0.5 to
    /// 7 % off; the next finer one takes a house of cards that falls 1.2 to 1.6 times as long.
    pub const TOGETHER_CALM: Self = Self { balance_late: 1e-2, updates: 1, ..Self::TOGETHER };
    /// Of a few sheets otherwise, where that is no slower: what slides on a sheet comes within 1e-4 of its acceleration. With ten
    /// times the balance a step of a sheet that slides at 35° may not settle for seconds.
    pub const TOGETHER_FEW: Self = Self { balance_late: 1e-4, updates: 2, ..Self::TOGETHER };
    /// Where a sheet is still far from where it will be, and where several are.
    pub const ROUGH: Self = Self {
        gap: 1e-5,
        slip: 10.0,
        balance: 1e-3,
        balance_late: 1e-3,
        balance_inside: 1e-2,
        updates: 0,
        ..Self::FINE
    };
    pub const ROUGH_TOGETHER: Self = Self { gap: 1e-5, slip: 10.0, stiffer: Self::FINE.stiffer, ..Self::TOGETHER };
}

/// The solver with its arrays.
#[derive(Default)]
pub(crate) struct Primal {
    pub rows: Vec<Row>,
    /// Forces, in the frames, N.
    pub force: Vec<DVec3>,
    /// Limit of friction at each contact, N.
    limits: Vec<f64>,
    /// By how much those are off what the normal forces allow, N, and the part of it that they went last.
    short: Vec<f64>,
    part: f64,
    states: Vec<State>,
    factored: Vec<State>,
    /// D of every row in the factor.
    weights: Vec<DMat3>,
    /// J δ + b, and its change along the step.
    u: Vec<DVec3>,
    du: Vec<DVec3>,
    delta: Vec<f64>,
    /// H δ, the step, and H times the step.
    pull: Vec<f64>,
    step: Vec<f64>,
    step_pull: Vec<f64>,
    interior: interior_point::Interior,
    /// The largest sum of forces in this solve, N.
    most: f64,
    /// Newton steps and factors so far.
    pub steps: u64,
    /// ρ over the stiffness of the sheet itself.
    stiffer: DVec3,
    /// Whether steps are braced: what slides is held against the direction it slides in too, and steps are taken whole.
    braced: bool,
    pub factors: u64,
}

impl Primal {
    /// Begins another problem with another matrix.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.force.clear();
        self.states.clear();
        self.factored.clear();
    }

    /// Takes the rows solved for as known: what is added now is new to them.
    pub fn go_on(&mut self) {
        for (row, state) in self.rows.iter_mut().zip(&self.states) {
            row.new = false;
            row.slid = state.rubs == Rubs::Slides;
        }
        self.factored.clear();
    }

    /// Displacement of each block row, m.
    pub fn displacement(&self) -> &[f64] {
        &self.delta
    }

    /// Has another solver find the forces and u, from the forces `begun`; whether it did.
    pub fn adopt(
        &mut self,
        begun: &[DVec3],
        solve: impl FnOnce(&[Row], (&mut Vec<DVec3>, &mut Vec<DVec3>)) -> bool,
    ) -> bool {
        self.force.clear();
        self.force.extend_from_slice(begun);
        let settled = solve(&self.rows, (&mut self.force, &mut self.u));
        if settled {
            self.limits.clear();
            self.limits.extend(self.rows.iter().zip(&self.force).map(|(row, p)| match row.law {
                Law::Coulomb(friction) => friction * p.x.max(0.0),
                Law::Glue => f64::INFINITY,
            }));
            self.aim();
            self.factored.clear();
        }
        settled
    }

    /// Whether contact `i` slides.
    pub fn slides(&self, i: usize) -> bool {
        self.states[i].rubs == Rubs::Slides
    }

    /// Solves from the forces in `force`; leaves the forces there. True if it settled.
    pub fn solve(&mut self, space: &mut dyn Space, accuracy: &Accuracy) -> bool {
        if !self.guess(space, accuracy) {
            return false;
        }
        let tolerance = accuracy.gap;
        let (mut updated, mut exact, mut trusted, mut inside) = (0, true, true, false);
        let (mut before, mut first) = (f64::INFINITY, f64::INFINITY);
        let mut just_held = false;
        for round in 0.. {
            let most = if space.is_cheap() { accuracy.patience.min(ON_FORCES) } else { accuracy.patience };
            let patience = most + MORE * updated;
            let soon =
                round == STEPS_OUTSIDE && !accuracy.braced && !exact && !space.is_cheap() && self.changes() > MANY;
            // New forces throw contacts open for a step.
            let lost = accuracy.braced && !just_held && self.is_lost(round, &mut first, accuracy);
            if !inside && (soon || lost || round == patience) {
                if !space.is_cheap() && self.go_inside(space, accuracy) {
                    return true;
                }
                // What it came to may be a good place to go on from.
                inside = true;
            }
            if round == patience {
                return false;
            }
            let braced = accuracy.braced
                && !space.is_cheap()
                && if round == 0 { self.changes() > MANY } else { self.braced && !exact };
            if std::mem::replace(&mut self.braced, braced) != braced {
                self.factored.clear();
            }
            self.aim();
            let balanced = self.load(space) <= if round < LATE { accuracy.balance } else { accuracy.balance_late };
            just_held = balanced;
            if balanced {
                let missed = self.missed(accuracy.slip);
                self.project();
                let stalled = missed > (1.0 - STALLED) * before && missed <= CONTRADICTED * tolerance;
                if missed > SLOW * before && self.stiffer.x < accuracy.stiffest {
                    self.stiffer *= FASTER;
                    self.factored.clear();
                }
                before = missed;
                if missed <= tolerance || stalled {
                    if updated >= accuracy.updates || !self.limit_friction() {
                        return true;
                    }
                    updated += 1;
                }
                self.aim();
                self.load(space);
            }
            // Friction that has changed often makes no difference, and the factor at hand can tell.
            let will_do = trusted && self.pushes_alike();
            if !will_do && !self.factorize(space) {
                return false;
            }
            self.solve_step(space);
            let small = self.du.iter().all(|du| du.abs().max_element() <= tolerance);
            trusted = !will_do || (small && balanced);
            exact = self.advance(space) || small;
        }
        false
    }

    /// Whether braced steps have not come near in so many rounds; `first` is what was missed in the first, m.
    fn is_lost(&self, round: u32, first: &mut f64, accuracy: &Accuracy) -> bool {
        if round > 0 && !STEPS_BRACED.contains(&round) {
            return false;
        }
        let missed = self.missed(accuracy.slip);
        if round == 0 {
            *first = missed;
        }
        let [early, _] = STEPS_BRACED;
        round > 0 && missed > FEW_TIMES * accuracy.gap && (round > early || missed > LOST * *first)
    }

    /// Begins with the displacement for contacts that act as they did when they had their forces.
    fn guess(&mut self, space: &mut dyn Space, accuracy: &Accuracy) -> bool {
        self.most = 0.0;
        self.braced = false;
        self.stiffer = accuracy.stiffer;
        let n = space.size(&self.rows);
        for vector in [&mut self.delta, &mut self.pull, &mut self.step, &mut self.step_pull] {
            vector.clear();
            vector.resize(n, 0.0);
        }
        self.u.clear();
        self.u.extend(self.rows.iter().map(|r| r.b));
        self.du.clear();
        self.du.resize(self.rows.len(), DVec3::ZERO);
        self.begin();
        for (i, row) in self.rows.iter().enumerate() {
            let state = &self.states[i];
            if state.acts() {
                let d = stiffness(row.stiffness * self.stiffer, state, self.braced);
                let p = self.force[i];
                let normal = if state.pushes { p.x } else { 0.0 };
                let held = DVec3::new(normal, p.y, p.z) - d * row.b;
                space.push(i, row, held, &mut self.step);
                self.most += held.abs().element_sum();
            }
        }
        if !self.factorize(space) {
            return false;
        }
        self.solve_step(space);
        self.go(1.0);
        true
    }

    /// States to begin with: what had a force keeps it, what is new and would overlap pushes.
    fn begin(&mut self) {
        self.states.clear();
        self.limits.clear();
        self.short.clear();
        for (row, p) in self.rows.iter().zip(&mut self.force) {
            let Law::Coulomb(friction) = row.law else {
                self.limits.push(f64::INFINITY);
                self.states.push(State { pushes: true, rubs: Rubs::Sticks, ..State::OPEN });
                continue;
            };
            if row.idle {
                *p = DVec3::ZERO;
            }
            let limit = friction * p.x.max(0.0);
            let tangential = DVec2::new(p.y, p.z).clamp_length_max(limit);
            (p.y, p.z) = (tangential.x, tangential.y);
            let rubs = match limit > 0.0 {
                false => Rubs::No,
                true if row.slid && tangential.length() > limit * (1.0 - STICKS) => Rubs::Slides,
                true => Rubs::Sticks,
            };
            self.limits.push(limit);
            let pushes = p.x > 0.0 || (row.new && !row.idle && row.b.x < row.eager);
            self.states.push(State { pushes, rubs, along: tangential.normalize_or_zero(), across: 1.0 });
        }
    }

    /// Share of the contacts that push and were not supposed to, or do not and were.
    fn changes(&self) -> f64 {
        let rows = self.rows.iter().enumerate();
        let other = rows.filter(|(i, row)| {
            let trial = self.force[*i] - row.stiffness * self.stiffer * self.u[*i];
            state_of(row, trial, self.limits[*i]).pushes != self.states[*i].pushes
        });
        other.count() as f64 / self.rows.len().max(1) as f64
    }

    /// Works out how contacts act at the u there is.
    fn aim(&mut self) {
        for (i, row) in self.rows.iter().enumerate() {
            let next = state_of(row, self.force[i] - row.stiffness * self.stiffer * self.u[i], self.limits[i]);
            self.states[i] = next;
        }
    }

    /// By how much gaps and slips that should be none are missed, m; slips count `slips` times.
    fn missed(&self, slips: f64) -> f64 {
        let each = self.rows.iter().zip(&self.u).zip(&self.states).map(|((row, u), state)| {
            if row.law == Law::Glue {
                return HOLDS * u.abs().max_element();
            }
            let slip = if state.rubs == Rubs::Sticks { slips * u.y.abs().max(u.z.abs()) } else { 0.0 };
            let gap = if state.pushes { u.x.abs() } else { (-u.x).max(0.0) };
            if row.idle { 0.0 } else { gap.max(slip) }
        });
        each.fold(0.0, f64::max)
    }

    /// Brings the forces up to date.
    fn project(&mut self) {
        for (i, row) in self.rows.iter().enumerate() {
            self.force[i] = projected(row, self.force[i] - row.stiffness * self.stiffer * self.u[i], self.limits[i]);
        }
    }

    /// Lets the limits of friction follow the normal forces; false when they are what they were. Those that overshoot, as a sheet's that is wedged in
    /// between a floor and a needle, would for ever: they go part of the way (Irons and Tuck, "A version of the Aitken accelerator for computer
    /// iteration", IJNME 1, 1969).
    fn limit_friction(&mut self) -> bool {
        let all: f64 = self.force.iter().map(|p| p.x).sum();
        let first = self.short.is_empty();
        self.short.resize(self.rows.len(), 0.0);
        let (mut changed, mut along, mut square) = (false, 0.0, 0.0);
        for (i, row) in self.rows.iter().enumerate() {
            let Law::Coulomb(friction) = row.law else { continue };
            let normal = self.force[i].x;
            let limit = if normal > NEGLIGIBLE * all { friction * normal } else { 0.0 };
            let slight = STICKS * limit.max(self.limits[i]).max(SLIGHT * friction * all);
            let short = limit - self.limits[i];
            changed |= match self.states[i].rubs {
                Rubs::Sticks => DVec2::new(self.force[i].y, self.force[i].z).length() > limit + slight,
                _ => short.abs() > slight,
            };
            let by = short - self.short[i];
            along += self.short[i] * by;
            square += by * by;
            self.short[i] = short;
        }
        let is_known = !first && square > 0.0;
        self.part = if is_known { (-self.part * along / square).clamp(LEAST_PART, 1.0) } else { 1.0 };
        for (limit, short) in self.limits.iter_mut().zip(&self.short) {
            *limit = (*limit + self.part * short).max(0.0);
        }
        changed
    }

    /// Makes the right side of a Newton step for contacts that act as they do. Returns what [`Primal::fall_short`] does.
    fn load(&mut self, space: &dyn Space) -> f64 {
        self.fall_short(space, |all, i, row| {
            let p = || projected(row, all.force[i] - row.stiffness * all.stiffer * all.u[i], all.limits[i]);
            all.states[i].acts().then(p)
        })
    }

    /// Puts on the right side of a step what the forces that `force` gives, of the contacts which have one, are short of holding the
    /// displacement. Returns its sum as a fraction of that of all forces; where all contacts open in the end, of a fraction of
    /// the most there were in this solve: rounding is not to be measured by itself.
    fn fall_short(&mut self, space: &dyn Space, force: impl Fn(&Self, usize, &Row) -> Option<DVec3>) -> f64 {
        let mut step = std::mem::take(&mut self.step);
        for (to, from) in step.iter_mut().zip(&self.pull) {
            *to = -from;
        }
        let mut all = 0.0;
        for (i, row) in self.rows.iter().enumerate() {
            if let Some(p) = force(self, i, row) {
                space.push(i, row, p, &mut step);
                all += p.abs().element_sum();
            }
        }
        self.most = self.most.max(all);
        let short: f64 = step.iter().map(|r| r.abs()).sum();
        self.step = step;
        short / all.max(ROUNDING * self.most).max(f64::MIN_POSITIVE)
    }

    /// Whether the factor at hand is of contacts of which the same push.
    fn pushes_alike(&self) -> bool {
        let alike = self.factored.len() == self.states.len();
        alike && self.factored.iter().zip(&self.states).all(|(a, b)| a.pushes == b.pushes)
    }

    /// Makes the factor that the states ask for; false when there is none.
    fn factorize(&mut self, space: &mut dyn Space) -> bool {
        let alike = self.factored.len() == self.states.len();
        if alike && self.factored.iter().zip(&self.states).all(|(a, b)| a.is_near(b)) {
            return true;
        }
        self.weights.clear();
        let (braced, stiffer) = (self.braced, self.stiffer);
        let weight = |(row, state): (&Row, &State)| stiffness(row.stiffness * stiffer, state, braced);
        self.weights.extend(self.rows.iter().zip(&self.states).map(weight));
        let done = space.factorize(&self.rows, &self.weights);
        self.factored.clear();
        if done {
            self.factors += 1;
            self.factored.extend_from_slice(&self.states);
        }
        done
    }

    /// Solves for the step from its right side, and what it does to every contact.
    fn solve_step(&mut self, space: &mut dyn Space) {
        self.steps += 1;
        space.solve(&self.rows, &self.weights, (&mut self.step, &mut self.step_pull), &mut self.du);
    }

    /// Goes along the step as far as that lowers Φ; true where contacts then act as the step supposed.
    fn advance(&mut self, space: &dyn Space) -> bool {
        let supposed = |(i, row): (usize, &Row)| {
            let trial = self.force[i] - row.stiffness * self.stiffer * (self.u[i] + self.du[i]);
            state_of(row, trial, self.limits[i]).is_near(&self.factored[i])
        };
        // Φ is then one parabola along the step.
        let exact = self.rows.iter().enumerate().all(supposed);
        let part = if exact || self.braced { 1.0 } else { self.search(space) };
        self.go(part);
        exact
    }

    fn go(&mut self, part: f64) {
        for (to, by) in self.delta.iter_mut().zip(&self.step) {
            *to += part * by;
        }
        for (to, by) in self.pull.iter_mut().zip(&self.step_pull) {
            *to += part * by;
        }
        for (to, by) in self.u.iter_mut().zip(&self.du) {
            *to += *by * part;
        }
    }

    /// The part of the step at which Φ is least, nearly.
    fn search(&self, space: &dyn Space) -> f64 {
        let work = |forces: &[f64]| space.work(&self.step, &self.du, forces);
        let (constant, linear) = (work(&self.pull), work(&self.step_pull));
        let slope = |part: f64| {
            let each = self.rows.iter().enumerate().map(|(i, row)| {
                let trial = self.force[i] - row.stiffness * self.stiffer * (self.u[i] + self.du[i] * part);
                self.du[i].dot(projected(row, trial, self.limits[i]))
            });
            constant + part * linear - each.sum::<f64>()
        };
        let (first, last) = (slope(0.0), slope(1.0));
        let flat = FLAT * first.abs();
        if first >= 0.0 || last <= flat {
            return 1.0;
        }
        let (mut low, mut high) = ((0.0, first), (1.0, last));
        let mut part = 1.0;
        for k in 0..TRIALS {
            // The slope rises: halves in turn with secants, which alone would creep.
            let secant = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
            part = if k % 2 == 0 { secant } else { 0.5 * (low.0 + high.0) };
            let here = slope(part);
            if here.abs() <= flat {
                break;
            }
            if here < 0.0 {
                low = (part, here);
            } else {
                high = (part, here);
            }
        }
        part
    }
}
