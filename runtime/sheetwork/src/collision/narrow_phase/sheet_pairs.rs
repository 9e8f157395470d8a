//! Detection between two sheets: candidate pairs of a stage and their contact constraints, in
//! parallel.
//!
//! Each pair of sheets writes its own constraints, which are joined in the order of the pairs. The
//! result is independent of the number of threads.

use crate::parallel::*;
use glam::DVec3;

use crate::collision::bvh::{BoundingBox, FrameMotion, SurfaceTree};
use crate::collision::constraint::ContactConstraint;
use crate::collision::narrow_phase::triangle_pairs::{PairMember, SheetPair};
use crate::collision::narrow_phase::{ContactPair, DetectionDistances, DetectionInput, SheetStageMotion};
use crate::collision::settings::{DetectionSettings, SheetPairSettings};

const SETTINGS: SheetPairSettings = DetectionSettings::DEFAULT.sheet_pairs;
const DETECTION: DetectionSettings = DetectionSettings::DEFAULT;

/// Two sheets whose swept boxes overlap, by indices of the detection input.
#[derive(Clone, Copy)]
struct CandidatePair {
    pair: (u32, u32),
    /// Swept box of the second sheet, grown by both contact offsets and the margin.
    around: BoundingBox,
    /// Friction and restitution coefficient.
    coefficients: (f64, f64),
}

/// Constraints and counts of one parallel task.
#[derive(Default)]
struct ThreadResult {
    rows: Vec<ContactConstraint>,
    seen: PairResult,
}

/// Result of testing some pairs of sheets.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PairResult {
    /// Number of box pairs and of triangle pairs tested.
    pub boxes: u64,
    pub tests: u64,
    /// Whether two sheets interpenetrate at the end and did not at the start.
    pub interpenetrates: bool,
}

impl PairResult {
    fn merged(self, other: Self) -> Self {
        Self {
            boxes: self.boxes + other.boxes,
            tests: self.tests + other.tests,
            interpenetrates: self.interpenetrates || other.interpenetrates,
        }
    }
}

/// Detector of sheet-sheet contact with buffers reused between calls.
#[derive(Default)]
pub(crate) struct SheetPairDetector {
    /// Candidate pairs of sheets of this step.
    pub candidate_pairs: Vec<(u32, u32)>,
    /// Swept box of each sheet, relative to the mean motion of all.
    swept_boxes: Vec<BoundingBox>,
    candidates: Vec<CandidatePair>,
    /// Whether a sheet is part of a candidate pair.
    is_candidate: Vec<bool>,
    thread_results: Vec<ThreadResult>,
}

impl SheetPairDetector {
    /// Add the constraints of all pairs of sheets nearer than contact offset plus `margin` (m) to
    /// `constraints`, in parallel if the first flag is set. With the second flag, edges that stand
    /// out at the end are tested too, and interpenetration is detected.
    pub fn detect_contacts(
        &mut self,
        problem: &DetectionInput,
        margin: f64,
        trees: &mut [SurfaceTree],
        (parallel, crosses): (bool, bool),
        constraints: &mut Vec<ContactConstraint>,
    ) -> PairResult {
        let sheets = problem.sheets;
        let drift = FrameMotion::mean_of(sheets.iter().filter(|sheet| sheet.awake));
        self.find_candidates(problem, margin, &drift);
        let refresh = |((tree, sheet), meets): ((&mut SurfaceTree, &SheetStageMotion), &bool)| {
            if *meets {
                tree.refresh(sheet, &drift, box_margin(sheet, margin));
                tree.refresh_ridges(sheet, crosses);
            }
        };
        let parallel = parallel && self.candidates.len() > SETTINGS.pairs_per_task;
        match parallel {
            true => trees.par_iter_mut().zip(sheets).zip(&self.is_candidate).for_each(refresh),
            false => trees.iter_mut().zip(sheets).zip(&self.is_candidate).for_each(refresh),
        }
        let trees = &*trees;
        let work = |meeting: &CandidatePair, constraints: &mut Vec<ContactConstraint>| {
            let CandidatePair { pair, around, coefficients } = *meeting;
            let mut seen = PairResult::default();
            if let Some(couple) = sheet_pair(sheets, trees, pair, margin, coefficients) {
                for (p, q) in couple.a.tree.pairs_with(couple.b.tree, around) {
                    couple.detect_triangle_pair(p, q, constraints);
                    seen.tests += 1;
                }
                seen.interpenetrates = crosses && {
                    let pairs = || couple.a.tree.pairs_with(couple.b.tree, around);
                    pairs().any(|(p, q)| couple.triangles_intersect(p, q, |sheet| sheet.end))
                        && !pairs().any(|(p, q)| couple.triangles_intersect(p, q, |sheet| sheet.start))
                };
            }
            seen
        };
        let all = PairResult { boxes: self.candidate_pairs.len() as u64, ..PairResult::default() };
        if !parallel {
            return self.candidates.iter().fold(all, |seen, meeting| seen.merged(work(meeting, constraints)));
        }
        self.thread_results.resize_with(
            self.thread_results.len().max(self.candidates.len().div_ceil(SETTINGS.pairs_per_task)),
            ThreadResult::default,
        );
        let parts = self.candidates.par_chunks(SETTINGS.pairs_per_task).zip(&mut self.thread_results);
        parts.for_each(|(meetings, share)| {
            share.rows.clear();
            let ThreadResult { rows: constraints, seen } = share;
            *seen =
                meetings.iter().fold(PairResult::default(), |seen, meeting| seen.merged(work(meeting, constraints)));
        });
        let shares = &self.thread_results[..self.candidates.len().div_ceil(SETTINGS.pairs_per_task)];
        shares.iter().for_each(|share| constraints.extend_from_slice(&share.rows));
        shares.iter().fold(all, |seen, share| seen.merged(share.seen))
    }

    /// Remove the pairs that interpenetrate at the start and of which at least one sheet satisfies
    /// `is_in_doubt`. Their indices are appended to `crossing`.
    pub fn exclude_crossing_pairs(
        &mut self,
        problem: &DetectionInput,
        trees: &mut [SurfaceTree],
        is_in_doubt: impl Fn(u32) -> bool,
        crossing: &mut Vec<u32>,
    ) {
        let (sheets, drift) = (problem.sheets, FrameMotion::default());
        self.candidate_pairs.retain(|&(s, t)| {
            if !is_in_doubt(s) && !is_in_doubt(t) {
                return true;
            }
            for i in [s, t] {
                let Some((sheet, tree)) = sheets.get(i as usize).zip(trees.get_mut(i as usize)) else { return true };
                tree.refresh(sheet, &drift, box_margin(sheet, 0.0));
            }
            let (Some(couple), Some(other)) =
                (sheet_pair(sheets, trees, (s, t), 0.0, (0.0, 0.0)), sheets.get(t as usize))
            else {
                return true;
            };
            let around = BoundingBox::swept(other, &drift).grown(couple.limits.offset);
            let by = SETTINGS.interpenetration_shift * couple.limits.offset;
            let is_cut = |by: DVec3| {
                let mut pairs = couple.a.tree.pairs_with(couple.b.tree, around);
                pairs.any(|(p, q)| couple.triangles_intersect_when_moved(p, q, by))
            };
            let crosses = is_cut(by) && is_cut(-by);
            if crosses {
                crossing.extend([s, t]);
            }
            !crosses
        });
    }

    /// Find the pairs of sheets whose swept boxes overlap.
    fn find_candidates(&mut self, problem: &DetectionInput, margin: f64, drift: &FrameMotion) {
        let sheets = problem.sheets;
        self.swept_boxes.clear();
        self.swept_boxes.extend(sheets.iter().map(|sheet| BoundingBox::swept(sheet, drift)));
        self.candidates.clear();
        self.is_candidate.clear();
        self.is_candidate.resize(sheets.len(), false);
        for &(s, t) in &self.candidate_pairs {
            let (Some(a), Some(b)) = (sheets.get(s as usize), sheets.get(t as usize)) else { continue };
            let around = self.swept_boxes[t as usize].grown(a.skin.contact_offset() + b.skin.contact_offset() + margin);
            if self.swept_boxes[s as usize].overlaps(&around) {
                self.is_candidate[s as usize] = true;
                self.is_candidate[t as usize] = true;
                let coefficients = (problem.surfaces)(ContactPair::Sheets(s, t));
                self.candidates.push(CandidatePair { pair: (s, t), around, coefficients });
            }
        }
    }
}

/// Distance (m) by which the boxes of a sheet are grown: its contact offset plus half the margin,
/// since both sheets of a pair contribute.
pub(crate) fn box_margin(sheet: &SheetStageMotion, margin: f64) -> f64 {
    sheet.skin.contact_offset() + 0.5 * margin
}

/// Two sheets of the detection input, or one twice.
pub(crate) fn sheet_pair<'a>(
    sheets: &'a [SheetStageMotion<'a>],
    trees: &'a [SurfaceTree],
    (s, t): (u32, u32),
    margin: f64,
    coefficients: (f64, f64),
) -> Option<SheetPair<'a>> {
    let party = |index: u32| {
        let (sheet, tree) = (sheets.get(index as usize)?, trees.get(index as usize)?);
        Some(PairMember { index, sheet, tree })
    };
    let (a, b) = (party(s)?, party(t)?);
    let offset = a.sheet.skin.contact_offset() + b.sheet.skin.contact_offset();
    // The overlap limit is at most half the offset: sheets created in the same place have no
    // defined side.
    let half = a.sheet.skin.half_thickness().min(b.sheet.skin.half_thickness());
    let deep = (DETECTION.maximum_initial_overlap * half).min(0.5 * offset);
    let limits = DetectionDistances { offset, margin, max_start_penetration: deep, half, fall: 0.0 };
    Some(SheetPair { a, b, limits, coefficients })
}
