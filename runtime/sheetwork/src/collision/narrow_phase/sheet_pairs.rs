//! Sheets against one another: which meet in a stage, and the rows of those that do, on as many threads as there are.
//!
//! Every pair of sheets writes rows of its own, which are joined in the order of the pairs: threads change nothing.

use glam::DVec3;
use rayon::prelude::*;

use crate::collision::bvh::{Cuboid, Drift, SkinTree};
use crate::collision::constraint::Contact;
use crate::collision::narrow_phase::triangle_pairs::{Couple, Party};
use crate::collision::narrow_phase::{DEEP, Limits, Pair, Problem, SheetMotion};

/// Pairs of sheets that one thread takes at a time.
const AT_A_TIME: usize = 4;

/// Sheets that go through one another do so when one is moved by this part of what keeps them apart, either way; what only touches does not. And no
/// mass lies in a triangle of the other then, nor an edge in an edge, as where two are put in one place.
const ASIDE: DVec3 = DVec3::new(4.8e-4, 6.1e-4, 6.3e-4);

/// Two sheets that meet, by their place in the problem.
#[derive(Clone, Copy)]
struct Meeting {
    pair: (u32, u32),
    /// What the second sweeps, with room for both.
    around: Cuboid,
    /// Friction and restitution coefficient.
    coefficients: (f64, f64),
}

/// Rows that some meetings gave.
#[derive(Default)]
struct Share {
    rows: Vec<Contact>,
    seen: Seen,
}

/// What looking at some pairs of sheets has come to.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    /// Pairs of boxes and of triangles looked at.
    pub boxes: u64,
    pub tests: u64,
    /// Whether two sheets go through one another at the end that did not at the start.
    pub cut: bool,
}

impl Seen {
    fn and(self, other: Self) -> Self {
        Self { boxes: self.boxes + other.boxes, tests: self.tests + other.tests, cut: self.cut || other.cut }
    }
}

/// What is kept from call to call.
#[derive(Default)]
pub(crate) struct Between {
    /// Pairs of sheets that may meet in this step.
    pub near: Vec<(u32, u32)>,
    /// What every sheet sweeps, as seen from their mean motion.
    swept: Vec<Cuboid>,
    meetings: Vec<Meeting>,
    /// Whether a sheet is in one of them.
    meets: Vec<bool>,
    shares: Vec<Share>,
}

impl Between {
    /// Adds the rows of all sheets that meet nearer than `margin` (m) to `rows`, on threads if `parallel`. Where what `crosses` is looked for,
    /// ridges at the end count too, and sheets that go through one another.
    pub fn find(
        &mut self,
        problem: &Problem,
        margin: f64,
        trees: &mut [SkinTree],
        (parallel, crosses): (bool, bool),
        rows: &mut Vec<Contact>,
    ) -> Seen {
        let sheets = problem.sheets;
        let drift = Drift::of(sheets.iter().filter(|sheet| sheet.awake));
        self.meet(problem, margin, &drift);
        let refresh = |((tree, sheet), meets): ((&mut SkinTree, &SheetMotion), &bool)| {
            if *meets {
                tree.refresh(sheet, &drift, half_room(sheet, margin));
                tree.refresh_ridges(sheet, crosses);
            }
        };
        let parallel = parallel && self.meetings.len() > AT_A_TIME;
        match parallel {
            true => trees.par_iter_mut().zip(sheets).zip(&self.meets).for_each(refresh),
            false => trees.iter_mut().zip(sheets).zip(&self.meets).for_each(refresh),
        }
        let trees = &*trees;
        let work = |meeting: &Meeting, rows: &mut Vec<Contact>| {
            let Meeting { pair, around, coefficients } = *meeting;
            let mut seen = Seen::default();
            if let Some(couple) = couple(sheets, trees, pair, margin, coefficients) {
                for (p, q) in couple.a.tree.pairs_with(couple.b.tree, around) {
                    couple.triangles(p, q, rows);
                    seen.tests += 1;
                }
                seen.cut = crosses && {
                    let pairs = || couple.a.tree.pairs_with(couple.b.tree, around);
                    pairs().any(|(p, q)| couple.cut(p, q, |sheet| sheet.end))
                        && !pairs().any(|(p, q)| couple.cut(p, q, |sheet| sheet.start))
                };
            }
            seen
        };
        let all = Seen { boxes: self.near.len() as u64, ..Seen::default() };
        if !parallel {
            return self.meetings.iter().fold(all, |seen, meeting| seen.and(work(meeting, rows)));
        }
        self.shares.resize_with(self.shares.len().max(self.meetings.len().div_ceil(AT_A_TIME)), Share::default);
        let parts = self.meetings.par_chunks(AT_A_TIME).zip(&mut self.shares);
        parts.for_each(|(meetings, share)| {
            share.rows.clear();
            let Share { rows, seen } = share;
            *seen = meetings.iter().fold(Seen::default(), |seen, meeting| seen.and(work(meeting, rows)));
        });
        let shares = &self.shares[..self.meetings.len().div_ceil(AT_A_TIME)];
        shares.iter().for_each(|share| rows.extend_from_slice(&share.rows));
        shares.iter().fold(all, |seen, share| seen.and(share.seen))
    }

    /// Leaves out the pairs of sheets that go through one another at the start, as far as `is_in_doubt` asks for one of the two, and writes
    /// them to `crossing`.
    pub fn leave_out_crossing(
        &mut self,
        problem: &Problem,
        trees: &mut [SkinTree],
        is_in_doubt: impl Fn(u32) -> bool,
        crossing: &mut Vec<u32>,
    ) {
        let (sheets, drift) = (problem.sheets, Drift::default());
        self.near.retain(|&(s, t)| {
            if !is_in_doubt(s) && !is_in_doubt(t) {
                return true;
            }
            for i in [s, t] {
                let Some((sheet, tree)) = sheets.get(i as usize).zip(trees.get_mut(i as usize)) else { return true };
                tree.refresh(sheet, &drift, half_room(sheet, 0.0));
            }
            let (Some(couple), Some(other)) = (couple(sheets, trees, (s, t), 0.0, (0.0, 0.0)), sheets.get(t as usize))
            else {
                return true;
            };
            let around = Cuboid::swept(other, &drift).grown(couple.limits.offset);
            let by = ASIDE * couple.limits.offset;
            let is_cut = |by: DVec3| {
                let mut pairs = couple.a.tree.pairs_with(couple.b.tree, around);
                pairs.any(|(p, q)| couple.cut_when_moved(p, q, by))
            };
            let crosses = is_cut(by) && is_cut(-by);
            if crosses {
                crossing.extend([s, t]);
            }
            !crosses
        });
    }

    /// Which sheets sweep what others do.
    fn meet(&mut self, problem: &Problem, margin: f64, drift: &Drift) {
        let sheets = problem.sheets;
        self.swept.clear();
        self.swept.extend(sheets.iter().map(|sheet| Cuboid::swept(sheet, drift)));
        self.meetings.clear();
        self.meets.clear();
        self.meets.resize(sheets.len(), false);
        for &(s, t) in &self.near {
            let (Some(a), Some(b)) = (sheets.get(s as usize), sheets.get(t as usize)) else { continue };
            let around = self.swept[t as usize].grown(a.skin.offset() + b.skin.offset() + margin);
            if self.swept[s as usize].meets(&around) {
                self.meets[s as usize] = true;
                self.meets[t as usize] = true;
                let coefficients = (problem.surfaces)(Pair::Sheets(s, t));
                self.meetings.push(Meeting { pair: (s, t), around, coefficients });
            }
        }
    }
}

/// What boxes of a sheet that may meet another within `margin` are grown by, m: each does half of that.
pub(crate) fn half_room(sheet: &SheetMotion, margin: f64) -> f64 {
    sheet.skin.offset() + 0.5 * margin
}

/// Two sheets of a problem, or one twice.
pub(crate) fn couple<'a>(
    sheets: &'a [SheetMotion<'a>],
    trees: &'a [SkinTree],
    (s, t): (u32, u32),
    margin: f64,
    coefficients: (f64, f64),
) -> Option<Couple<'a>> {
    let party = |index: u32| {
        let (sheet, tree) = (sheets.get(index as usize)?, trees.get(index as usize)?);
        Some(Party { index, sheet, tree })
    };
    let (a, b) = (party(s)?, party(t)?);
    let offset = a.sheet.skin.offset() + b.sheet.skin.offset();
    // Two sheets that lie within each other are on no certain side: as two that are made in one place.
    let limits = Limits { offset, margin, deep: DEEP.min(0.5 * offset) };
    Some(Couple { a, b, limits, coefficients })
}
