//! Detection between two sheets: candidate pairs of a stage and their contact constraints, in
//! parallel.
//!
//! Each pair of sheets writes its own constraints, which are joined in the order of the pairs. The
//! result is independent of the number of threads.

use crate::parallel::*;
use glam::DVec3;

use crate::collision::bvh::{Cuboid, Drift, SkinTree};
use crate::collision::constraint::Contact;
use crate::collision::narrow_phase::triangle_pairs::{Couple, Party};
use crate::collision::narrow_phase::{Limits, Pair, Problem, SheetMotion};
use crate::collision::settings::{DetectionSettings, SheetPairSettings};

const SETTINGS: SheetPairSettings = DetectionSettings::DEFAULT.sheet_pairs;
const DETECTION: DetectionSettings = DetectionSettings::DEFAULT;

/// Two sheets whose swept boxes overlap, by indices of the detection input.
#[derive(Clone, Copy)]
struct Meeting {
    pair: (u32, u32),
    /// Swept box of the second sheet, grown by both contact offsets and the margin.
    around: Cuboid,
    /// Friction and restitution coefficient.
    coefficients: (f64, f64),
}

/// Constraints and counts of one parallel task.
#[derive(Default)]
struct Share {
    rows: Vec<Contact>,
    seen: Seen,
}

/// Result of testing some pairs of sheets.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    /// Number of box pairs and of triangle pairs tested.
    pub boxes: u64,
    pub tests: u64,
    /// Whether two sheets interpenetrate at the end and did not at the start.
    pub cut: bool,
}

impl Seen {
    fn and(self, other: Self) -> Self {
        Self { boxes: self.boxes + other.boxes, tests: self.tests + other.tests, cut: self.cut || other.cut }
    }
}

/// Detector of sheet-sheet contact with buffers reused between calls.
#[derive(Default)]
pub(crate) struct Between {
    /// Candidate pairs of sheets of this step.
    pub near: Vec<(u32, u32)>,
    /// Swept box of each sheet, relative to the mean motion of all.
    swept: Vec<Cuboid>,
    meetings: Vec<Meeting>,
    /// Whether a sheet is part of a candidate pair.
    meets: Vec<bool>,
    shares: Vec<Share>,
}

impl Between {
    /// Add the constraints of all pairs of sheets nearer than contact offset plus `margin` (m) to
    /// `rows`, in parallel if the first flag is set. With the second flag, edges that stand out at
    /// the end are tested too, and interpenetration is detected.
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
        let parallel = parallel && self.meetings.len() > SETTINGS.pairs_per_task;
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
        self.shares
            .resize_with(self.shares.len().max(self.meetings.len().div_ceil(SETTINGS.pairs_per_task)), Share::default);
        let parts = self.meetings.par_chunks(SETTINGS.pairs_per_task).zip(&mut self.shares);
        parts.for_each(|(meetings, share)| {
            share.rows.clear();
            let Share { rows, seen } = share;
            *seen = meetings.iter().fold(Seen::default(), |seen, meeting| seen.and(work(meeting, rows)));
        });
        let shares = &self.shares[..self.meetings.len().div_ceil(SETTINGS.pairs_per_task)];
        shares.iter().for_each(|share| rows.extend_from_slice(&share.rows));
        shares.iter().fold(all, |seen, share| seen.and(share.seen))
    }

    /// Remove the pairs that interpenetrate at the start and of which at least one sheet satisfies
    /// `is_in_doubt`. Their indices are appended to `crossing`.
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
            let by = SETTINGS.interpenetration_shift * couple.limits.offset;
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

    /// Find the pairs of sheets whose swept boxes overlap.
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

/// Distance (m) by which the boxes of a sheet are grown: its contact offset plus half the margin,
/// since both sheets of a pair contribute.
pub(crate) fn half_room(sheet: &SheetMotion, margin: f64) -> f64 {
    sheet.skin.offset() + 0.5 * margin
}

/// Two sheets of the detection input, or one twice.
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
    // The overlap limit is at most half the offset: sheets created in the same place have no
    // defined side.
    let limits = Limits { offset, margin, deep: DETECTION.maximum_initial_overlap.min(0.5 * offset) };
    Some(Couple { a, b, limits, coefficients })
}
